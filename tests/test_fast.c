/* The fast arithmetic: its primitives against exact sums in MPFR, its kernels against each other bit for bit,
 * its jets against the plain arithmetic's within the bound that it states, and whole flows. */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arith/fast.h"
#include "arith/fixed/fixed.h"
#include "integrate/method.h"
#include "integrate/numerics.h"
#include "problem.h"

static const cns_arith_ops *const ops = &cns_arith_fast;

/* Kernels that this machine has. */

enum { KERNELS = 2 };
static const char *const kernels[KERNELS] = {"portable", "avx512ifma"};

static bool has_kernel(const char *name)
{
    return cns_fast_has_kernel(name);
}

/* The same arithmetic once per kernel; calls go to all. */

enum { U, V, W, C, D, T, SERIES };

static cns_arith *each[KERNELS];
static int n_each;
static uint64_t stream, round_seed; /* of the round, to repeat it */

#define ALL(call)                                                                                            \
    do {                                                                                                     \
        for (int kernel_ = 0; kernel_ < n_each; kernel_++) {                                                 \
            cns_arith *const A = each[kernel_];                                                              \
            call;                                                                                            \
        }                                                                                                    \
    } while (0)

static fx *inside(const cns_arith *A) /* the fixed point is an arithmetic's first member */
{
    return *(fx *const *)(const void *)A;
}

static void open_each(int order, mpfr_prec_t prec)
{
    cns_arith_spec spec = {.series = SERIES, .order = order, .prec = prec};
    n_each = 0;
    for (int i = 0; i < KERNELS; i++) {
        cns_error err;
        if (!has_kernel(kernels[i]))
            continue;
        spec.kernel = kernels[i];
        each[n_each] = cns_arith_fast.create(&spec, &err);
        ck_assert_msg(each[n_each] != NULL, "%s: %s", kernels[i], err.text);
        ck_assert_str_eq(cns_fast_kernel(each[n_each]), kernels[i]);
        n_each++;
    }
}

static void close_each(void)
{
    ALL(ops->destroy(A));
}

static long pick(long lo, long hi)
{
    return lo + (long)test_random_below(&stream, (uint64_t)(hi - lo + 1));
}

static bool one_in(long n)
{
    return pick(1, n) == 1;
}

#define CHECK(ok, ...)                                                                                       \
    do {                                                                                                     \
        if (!(ok)) {                                                                                         \
            char what_[256];                                                                                 \
            snprintf(what_, sizeof what_, __VA_ARGS__);                                                      \
            ck_abort_msg("%s (round of seed %llu)", what_, (unsigned long long)round_seed);                  \
        }                                                                                                    \
    } while (0)

/* All limbs, exponents and sums of series w agree between the kernels, and every limb is a limb. */
static void check_same(int w, const char *what)
{
    for (int i = 0; i < n_each; i++) {
        const fx *F = inside(each[0]), *G = inside(each[i]);
        const fx_series *s = &F->series[w], *t = &G->series[w];
        bool same = s->live == t->live && s->stored == t->stored && s->peak == t->peak &&
                    (!s->live || s->exp == t->exp) && s->parts == t->parts && F->raised == G->raised &&
                    F->raised_series == G->raised_series && F->singular == G->singular;
        for (int k = 0; same && k < s->stored; k++) {
            for (int l = 0; l < F->rows[k]; l++) {
                size_t at = (size_t)l * F->stride;
                size_t back = at + (size_t)(F->order - k),
                       value = (size_t)k * (size_t)F->record + (size_t)F->value;
                uint64_t limb = (uint64_t)s->record[value + (size_t)l + 1];
                if (l == 0)
                    limb = (limb + (uint64_t)FX_HALF) & (uint64_t)FX_MASK;
                same = same && limb >> FX_BITS == 0;
                if (s->parts & FX_FWD)
                    same = same && s->fwd[at + (size_t)k] == limb && t->fwd[at + (size_t)k] == limb;
                if (s->parts & FX_REV)
                    same = same && s->rev[back] == limb && t->rev[back] == limb;
            }
            for (int l = 0; l <= F->rows[k]; l++) {
                size_t at = (size_t)k * (size_t)F->record + (size_t)l;
                if (s->parts & FX_SUMS)
                    same = same && s->record[at] == t->record[at];
                same = same && s->record[at + (size_t)F->value] == t->record[at + (size_t)F->value];
            }
        }
        CHECK(same, "%s: kernels differ", what);
    }
}

static double exponent_of(int w)
{
    return inside(each[0])->series[w].live ? (double)inside(each[0])->series[w].exp : -1e6;
}

/* One unit of the last limb of w_k: what a rounding may cost. */
static double unit_of(int w, int k)
{
    const fx *F = inside(each[0]);
    return exponent_of(w) + 1 - (double)FX_BITS * F->rows[k] - (double)F->decay * k;
}

/* Coefficient k of w is x, within 2^bound, in every kernel. */
static void check_value(int w, int k, const mpfr_t x, double bound, const char *what)
{
    mpfr_t y;
    mpfr_init2(y, mpfr_get_prec(x) + 200);
    ops->get(each[0], y, w, k);
    double distance = log2_distance(y, x);
    CHECK(distance <= bound, "%s: order %d is wrong by 2^%.1f, above 2^%.1f", what, k, distance, bound);
    mpfr_clear(y);
    check_same(w, what);
}

/* Random series. */

enum { ZERO, RANDOM, ONES, UNEVEN, MIXED, KINDS };

static void random_value(mpfr_t y, long exp, int kind)
{
    mpfr_t t;
    mpfr_set_zero(y, 1);
    if (kind == ZERO)
        return;
    mpfr_init2(t, 64);
    for (long have = 0; have < mpfr_get_prec(y); have += 60) {
        uint64_t bits = kind == ONES ? UINT64_MAX : test_random(&stream);
        mpfr_set_ui_2exp(t, (unsigned long)(bits >> 4), -have - 60, MPFR_RNDN);
        mpfr_add(y, y, t, MPFR_RNDZ);
    }
    mpfr_mul_2si(y, y, exp - (kind == UNEVEN ? pick(0, 70) : 0), MPFR_RNDN);
    if (one_in(2))
        mpfr_neg(y, y, MPFR_RNDN);
    mpfr_clear(t);
}

/* Series w gets coefficients below 2^(exp - decay k); x what they are once stored. */
static void fill(int w, int upto, int kind, long exp, int decay, mpfr_t *x, mpfr_t t)
{
    for (int k = 0; k <= upto; k++) {
        int this = kind == MIXED ? (int)pick(ZERO, UNEVEN) : kind;
        random_value(t, exp - (long)decay * k, this);
        ALL(ops->set(A, w, k, t, false));
    }
    for (int k = 0; k <= upto; k++)
        ops->get(each[0], x[k], w, k);
    check_same(w, "set");
}

/* What a round works with: exact values of what the series hold. */
typedef struct world {
    int order, decay;
    double H;
    mpfr_prec_t exact;
    mpfr_t *u, *v, c, s, p, t;
} world;

static void world_init(world *x)
{
    static const int sizes[] = {1, 2, 3, 7, 8, 9, 15, 16, 17, 30, 64, 100, 130, 200, 400, 700, 1200};
    int which = (int)pick(0, one_in(16) ? 16 : one_in(4) ? 14 : 12);
    x->order = sizes[which] + (int)pick(0, 3);
    mpfr_prec_t prec = one_in(4)   ? pick(20, 60 + x->order * 5)
                       : one_in(2) ? (long)(3.1 * x->order) + 2
                                   : pick(20, 1200);
    open_each(x->order, prec);
    x->decay = one_in(4) ? (int)pick(1, 6) : 3;
    ALL(cns_fast_set_decay(A, x->decay));
    if (one_in(4)) {
        mpfr_prec_t lower = pick(prec / 2 + 2, prec);
        ALL(cns_fast_set_precision(A, lower));
    }
    x->H = ldexp((double)pick(1, 1L << 52), -52 - (int)pick(0, 4));
    ALL(ops->begin(A, x->H));
    x->exact = 3 * prec + 3 * x->order * x->decay + 2000;
    x->u = cns_vector_xnew(x->order + 1, x->exact);
    x->v = cns_vector_xnew(x->order + 1, x->exact);
    mpfr_inits2(x->exact, x->c, x->s, x->p, (mpfr_ptr)0);
    mpfr_init2(x->t, prec + 300);
    long eu = pick(-20, 20), ev = one_in(2) ? eu + pick(-4, 4) : pick(-300, 300);
    fill(U, x->order, (int)pick(0, KINDS - 1), eu, x->decay, x->u, x->t);
    fill(V, x->order, (int)pick(0, KINDS - 1), ev, x->decay, x->v, x->t);
    random_value(x->t, pick(-30, 30), RANDOM);
    ALL(ops->set(A, C, 0, x->t, true));
    mpfr_set(x->c, x->t, MPFR_RNDN);
}

static void world_clear(world *x)
{
    cns_vector_free(x->u);
    cns_vector_free(x->v);
    mpfr_clears(x->c, x->s, x->p, x->t, (mpfr_ptr)0);
    close_each();
}

/* Sums of products with a random store. Bounds: a convolution of n + 1 terms drops less than (n + 1)(rows +
 * 1) units (fixed.h); a store rounds once, and a factor spreads a unit over its limbs. */

static void add_product(world *x, const mpfr_t a, const mpfr_t b, int sign)
{
    mpfr_mul(x->p, a, b, MPFR_RNDN);
    (sign < 0 ? mpfr_sub : mpfr_add)(x->s, x->s, x->p, MPFR_RNDN);
}

/* One summand into the accumulator and into x->s. *top: log2 of the largest value; *bound: of the error. */
static void accumulate(world *x, int n, double *top, double *bound)
{
    const fx *F = inside(each[0]);
    double unit = -(double)FX_BITS * F->rows[n] - (double)x->decay * n;
    double terms = log2((n + 2.0) * (F->rows[n] + 2.0)) + 3;
    int sign = one_in(2) ? 1 : -1;
    double e = exponent_of(V), c = (double)mpfr_get_exp(x->c);
    int lo = n > 0 ? (int)pick(0, 1) : 0, hi = n - (n > lo ? (int)pick(0, 1) : 0), half = n >= 2 ? lo : 0;
    switch (pick(0, 3)) {
    case 0:;
        int weight = (int)(one_in(4) ? pick(-2147483647L, 2147483647L) : pick(-3, 3));
        ALL(ops->coef(A, weight, U, n));
        mpfr_mul_si(x->p, x->u[n], weight, MPFR_RNDN);
        mpfr_add(x->s, x->s, x->p, MPFR_RNDN);
        *top = fmax(*top, exponent_of(U) + 1 + (weight ? log2(fabs((double)weight)) : 0));
        break;
    case 1:
        ALL(ops->scaled(A, sign, C, V, n));
        add_product(x, x->v[n], x->c, sign);
        *top = fmax(*top, e + 1 + c);
        *bound = fmax(*bound, e + 3 + c + unit + terms);
        break;
    case 2:
        ALL(ops->conv(A, sign, U, V, n, lo, hi));
        for (int j = lo; j <= hi; j++)
            add_product(x, x->u[j], x->v[n - j], sign);
        *top = fmax(*top, exponent_of(U) + e + 1);
        *bound = fmax(*bound, exponent_of(U) + e + 2 + unit + terms);
        break;
    default:
        ALL(ops->square(A, sign, V, n, half));
        for (int j = half; j <= n - half; j++)
            add_product(x, x->v[j], x->v[n - j], sign);
        *top = fmax(*top, 2 * e + 1);
        *bound = fmax(*bound, 2 * e + 2 + unit + terms);
    }
}

/* The accumulator, which holds x->s, into W: the order it went to. */
static int store_somehow(world *x, int n, double top, double *bound, const char **what)
{
    const fx *F = inside(each[0]);
    double unit = -(double)FX_BITS * F->rows[n] - (double)x->decay * n;
    double spread = top + unit + log2((n + 2.0) * (F->rows[n] + 2.0)) + 3;
    double c = (double)mpfr_get_exp(x->c);
    *bound = fmax(*bound, top + unit + 2) + 2;
    switch (pick(0, 6)) {
    case 0:
        *what = "store_scaled";
        ALL(ops->store_scaled(A, W, n, C));
        mpfr_mul(x->s, x->s, x->c, MPFR_RNDN);
        *bound = fmax(*bound, spread) + 1 + c;
        return n;
    case 1:;
        const int a = one_in(2) ? 1 : (int)pick(-1000, 1000), b = (int)pick(1, 2000);
        *what = "store_ratio";
        ALL(ops->store_ratio(A, W, n, a, b));
        mpfr_mul_si(x->s, x->s, a, MPFR_RNDN);
        mpfr_div_si(x->s, x->s, b, MPFR_RNDN);
        *bound = fmax(*bound + (a ? log2(fabs((double)a) / (double)b) : 0), top + unit + 4) + 1;
        return n;
    case 2:
        if (mpfr_zero_p(x->u[0]))
            break;
        int v = !mpfr_zero_p(x->u[1]) ? (int)pick(0, 1) : 0, twice = (int)pick(0, 1);
        *what = "store_over";
        ALL(ops->store_over(A, W, n, U, v, twice));
        mpfr_div(x->s, x->s, x->u[v], MPFR_RNDN);
        mpfr_div_2ui(x->s, x->s, (unsigned long)twice, MPFR_RNDN);
        *bound = fmax(*bound, spread) + 2 - (double)mpfr_get_exp(x->u[v]) - twice;
        return n;
    case 3:
        if (n == x->order)
            break;
        bool with = one_in(2);
        *what = "store_next";
        ALL(ops->store_next(A, W, n, with ? C : -1));
        mpfr_mul_d(x->s, x->s, x->H, MPFR_RNDN);
        if (with)
            mpfr_mul(x->s, x->s, x->c, MPFR_RNDN);
        mpfr_div_ui(x->s, x->s, (unsigned long)n + 1, MPFR_RNDN);
        *bound = fmax(*bound, spread) + 2 + log2(x->H / (n + 1)) + (with ? c : 0);
        return n + 1;
    }
    *what = "store";
    ALL(ops->store(A, W, n));
    return n;
}

static void one_sum(world *x)
{
    int n = (int)pick(0, x->order);
    double top = -1e6, bound = -1e6;
    const char *what;
    mpfr_set_zero(x->s, 1);
    ALL(ops->zero(A));
    for (long parts = pick(1, 4); parts > 0; parts--)
        accumulate(x, n, &top, &bound);
    int k = store_somehow(x, n, top, &bound, &what);
    check_value(W, k, x->s, fmax(bound, unit_of(W, k) + 1) + 1, what);
    long e, expected;
    ops->get(each[0], x->p, W, k);
    double m = ops->get_2exp(each[0], &e, W, k), wanted = mpfr_get_d_2exp(&expected, x->p, MPFR_RNDN);
    CHECK(mpfr_zero_p(x->p) ? m == 0 : m == wanted && e == expected,
          "get_2exp after %s: %a 2^%ld, not %a 2^%ld", what, m, e, wanted, expected);
}

static void one_polynomial(world *x)
{
    const fx *F = inside(each[0]);
    double tau_double = one_in(3) ? 1 : one_in(2) ? 0.5 : ldexp((double)pick(0, 1L << 53), -53);
    double finest = HUGE_VAL;
    int n = (int)pick(0, x->order);
    mpfr_t y, tau;
    mpfr_init2(y, x->exact);
    mpfr_init2(tau, one_in(2) ? 24 : FX_BITS * (F->limbs + 2));
    mpfr_set_d(tau, tau_double, MPFR_RNDN);
    if (one_in(2)) { /* all bits in use, up to the reach */
        mpfr_set_d(tau, (double)pick(0, FX_REACH) / 8 + tau_double - 1, MPFR_RNDD);
        mpfr_exp2(tau, tau, MPFR_RNDD);
    }
    mpfr_set_zero(x->s, 1);
    for (int k = n; k >= 0; k--) {
        mpfr_mul(x->s, x->s, tau, MPFR_RNDN);
        mpfr_add(x->s, x->s, x->u[k], MPFR_RNDN);
        double weight = fmin(0, k * (tau_double - x->decay)); /* log2 tau^k 2^(-decay k), or more */
        finest = fmin(finest, (double)FX_BITS * F->rows[k] - weight);
    }
    for (int i = 0; i < n_each; i++) {
        cns_fast_sum(each[i], i == 0 ? y : x->p, U, n, tau);
        CHECK(i == 0 || mpfr_equal_p(y, x->p), "sum: kernels differ");
    }
    double distance = log2_distance(y, x->s), bound = exponent_of(U) + 2 - finest + log2(n + 2.0);
    CHECK(distance <= bound, "the sum at %g of %d is wrong by 2^%.1f, above 2^%.1f",
          mpfr_get_d(tau, MPFR_RNDN), n, distance, bound);
    if (mpfr_zero_p(tau) || n > FX_MAX_SLOPE) {
        mpfr_clears(y, tau, (mpfr_ptr)0);
        return;
    }
    /* the slope, times tau, and its largest term */
    double largest, term = -HUGE_VAL;
    mpfr_set_zero(x->s, 1);
    for (int k = n; k >= 1; k--) {
        mpfr_mul_ui(x->p, x->u[k], (unsigned long)k, MPFR_RNDN);
        mpfr_mul(x->s, x->s, tau, MPFR_RNDN);
        mpfr_add(x->s, x->s, x->p, MPFR_RNDN);
        term = fmax(term, log2_of(x->p) + k * log2_of(tau));
    }
    mpfr_mul(x->s, x->s, tau, MPFR_RNDN);
    for (int i = 0; i < n_each; i++) {
        ck_assert(ops->slope(each[i], i == 0 ? y : x->p, &largest, U, n, tau));
        CHECK(i == 0 || mpfr_equal_p(y, x->p), "slope: kernels differ");
    }
    mpfr_mul(y, y, tau, MPFR_RNDN);
    distance = log2_distance(y, x->s);
    CHECK(distance <= bound, "the slope at %g of %d is wrong by 2^%.1f, above 2^%.1f",
          mpfr_get_d(tau, MPFR_RNDN), n, distance, bound);
    CHECK(largest == term || fabs(largest - term) <= 1.01, "the largest term is 2^%.1f, not 2^%.1f", term,
          largest);
    mpfr_clears(y, tau, (mpfr_ptr)0);
}

enum { SUM_ROUNDS = 60, SUM_RUNS = 6 };

/* Calls f in rounds of random worlds; each starts at a seed of its own, which a failure names. */
static void rounds(int run, int count, void (*f)(world *x))
{
    stream = test_seed() + 1000003u * (uint64_t)run;
    for (int i = 0; i < count; i++) {
        world x;
        round_seed = stream = test_random(&stream);
        world_init(&x);
        f(&x);
        world_clear(&x);
    }
}

static void sums(world *x)
{
    for (int i = 0; i < 12; i++)
        one_sum(x);
    for (int i = 0; i < 3; i++)
        one_polynomial(x);
}

START_TEST(sums_and_stores)
{
    rounds(_i, SUM_ROUNDS, sums);
}
END_TEST

/* Order-0 functions: the value for the stored argument, to a unit. */

static void one_function(world *x, cns_function f, long exp, bool positive)
{
    mpfr_t a, b, w, w2, y;
    mpfr_inits2(x->exact, a, b, w, w2, y, (mpfr_ptr)0);
    random_value(x->t, exp, RANDOM);
    if (positive)
        mpfr_abs(x->t, x->t, MPFR_RNDN);
    ALL(ops->begin(A, x->H / 8)); /* a very different step: exponents are chosen anew */
    ALL(ops->begin(A, x->H));
    ALL(ops->set(A, U, 0, x->t, false));
    random_value(x->t, pick(-4, 4), RANDOM);
    ALL(ops->set(A, f == CNS_FN_POW ? D : V, 0, x->t, f == CNS_FN_POW));
    ops->get(each[0], a, U, 0);
    ops->get(each[0], b, f == CNS_FN_POW ? D : V, 0);
    switch (f) {
    case CNS_FN_SQRT:
        mpfr_sqrt(w, a, MPFR_RNDN);
        break;
    case CNS_FN_HYPOT:
        mpfr_hypot(w, a, b, MPFR_RNDN);
        break;
    case CNS_FN_SINCOS:
        mpfr_sin_cos(w, w2, a, MPFR_RNDN);
        break;
    case CNS_FN_EXP:
        mpfr_exp(w, a, MPFR_RNDN);
        break;
    case CNS_FN_LOG:
        mpfr_log(w, a, MPFR_RNDN);
        break;
    case CNS_FN_POW:
        mpfr_pow(w, a, b, MPFR_RNDN);
        break;
    }
    ALL(ops->function(A, f, W, f == CNS_FN_SINCOS ? T : -1, U, f == CNS_FN_POW ? D : V));
    static const char *const names[] = {"sqrt", "hypot", "sincos", "exp", "log", "pow"};
    check_value(W, 0, w, unit_of(W, 0) + 1, names[f]);
    if (f == CNS_FN_SINCOS)
        check_value(T, 0, w2, unit_of(T, 0) + 1, "cos");
    mpfr_clears(a, b, w, w2, y, (mpfr_ptr)0);
}

static void functions(world *x)
{
    for (int i = 0; i < 3; i++) {
        one_function(x, CNS_FN_SQRT, pick(-200, 200), true);
        one_function(x, CNS_FN_HYPOT, pick(-6, 6), false);
        one_function(x, CNS_FN_SINCOS, pick(-40, 12), false);
        one_function(x, CNS_FN_EXP, pick(-20, 9), false);
        one_function(x, CNS_FN_LOG, pick(-60, 60), true);
        one_function(x, CNS_FN_POW, pick(-20, 20), true);
    }
    /* out of their domain: said, not computed */
    static const struct {
        cns_function f;
        long a;
    } outside[] = {{CNS_FN_SQRT, -1}, {CNS_FN_LOG, -1}, {CNS_FN_LOG, 0}};
    for (int i = 0; i < COUNT(outside); i++) {
        cns_fast_status status;
        ALL(ops->begin(A, x->H));
        mpfr_set_si(x->t, outside[i].a, MPFR_RNDN);
        ALL(ops->set(A, U, 0, x->t, false));
        ALL(ops->function(A, outside[i].f, W, -1, U, -1));
        cns_fast_status_get(each[0], &status);
        CHECK(status.singular, "function %d of %ld: not called singular", (int)outside[i].f, outside[i].a);
        CHECK(ops->noise_log2(each[0]) == HUGE_VAL, "the noise of what is singular has a bound");
        check_same(W, "a singular function");
    }
}

START_TEST(functions_of_order_0)
{
    rounds(100, 25, functions);
}
END_TEST

/* Coefficients above what the block exponent has room for: it is raised, everything stored so far stays
 * within a unit of the new exponent, and the bits lost are reported. */
static void raised(world *x)
{
    int jump = (int)pick(2, 400), upto = (int)pick(0, x->order - 1), how = (int)pick(0, 2);
    double factor = 0;
    cns_fast_status status;
    fill(T, upto, pick(0, 1) ? RANDOM : ONES, 0, x->decay, x->u, x->t);
    double before = exponent_of(T);
    mpfr_set_zero(x->s, 1);
    random_value(x->t, jump - (long)x->decay * (upto + 1), RANDOM);
    ALL(ops->begin(A, x->H)); /* the same exponents again, learnt */
    for (int k = 0; k <= upto; k++)
        ALL(ops->set(A, T, k, x->u[k], false));
    CHECK(exponent_of(T) <= before + 4, "an exponent is learnt too high: %g after %g", exponent_of(T),
          before);
    before = exponent_of(T);
    if (how == 0) {
        ALL(ops->set(A, T, upto + 1, x->t, false));
        mpfr_set(x->s, x->t, MPFR_RNDN);
    } else {
        ALL(ops->set(A, D, upto + 1, x->t, false));
        ops->get(each[0], x->p, D, upto + 1);
        ALL(ops->zero(A));
        ALL(ops->coef(A, how == 1 ? 1 : -3, D, upto + 1));
        ALL(ops->store(A, T, upto + 1));
        mpfr_mul_si(x->s, x->p, how == 1 ? 1 : -3, MPFR_RNDN);
        factor = 2;
    }
    cns_fast_status_get(each[0], &status);
    double by = exponent_of(T) - before;
    CHECK(mpfr_get_exp(x->s) <= (long)exponent_of(T) - (long)x->decay * (upto + 1), "raised too little");
    CHECK(status.raised >= (int)by && (by == 0 || status.raised_series == T),
          "raised by %g bits, reported %d of series %d", by, status.raised, status.raised_series);
    check_value(T, upto + 1, x->s, unit_of(T, upto + 1) + 1 + factor, "raised to");
    for (int k = 0; k <= upto; k++)
        check_value(T, k, x->u[k], unit_of(T, k) + 1, "raised from");
}

START_TEST(a_raise_is_seen_and_keeps_values)
{
    rounds(200, 150, raised);
}
END_TEST

/* Every limb all ones, at the largest window: the fullest columns there can be, several convolutions in one
 * sum. The limbs are written behind the arithmetic's back; the sum has a closed form. */
static const struct {
    int order;
    mpfr_prec_t prec;
} full[] = {{66, 200},   {205, 430},   {210, 480},  {200, 490},   {190, 500},
            {700, 1000}, {1108, 3322}, {4200, 500}, {3000, 2600}, {160, 16700}};

static void set_ones(fx *F, int w)
{
    fx_series *x = &F->series[w];
    for (int k = 0; k <= F->order; k++) {
        int64_t *value = x->record + (size_t)k * (size_t)F->record + F->value;
        value[0] = 0;
        for (int l = 0; l < F->rows[k]; l++)
            value[l + 1] = l == 0 ? FX_MASK >> 1 : FX_MASK;
    }
    cns_fx_want(F, w, FX_FWD | FX_REV | FX_SUMS);
}

START_TEST(all_ones)
{
    const int order = full[_i].order;
    const mpfr_prec_t prec = full[_i].prec;
    const int orders[] = {order, order / 2, order / 3, order / 4, 191, 192, 383, 1, 0};
    mpfr_t t, s, p;
    open_each(order, prec);
    ALL(cns_fast_set_decay(A, 1));
    ALL(ops->begin(A, 1));
    mpfr_init2(t, prec);
    mpfr_inits2(4 * prec + 4 * order + 400, s, p, (mpfr_ptr)0);
    for (int k = 0; k <= order; k++) {
        mpfr_set_ui_2exp(t, 1, -k, MPFR_RNDN);
        ALL(ops->set(A, U, k, t, false));
    }
    ALL(set_ones(inside(A), U));
    const fx *F = inside(each[0]);
    for (int i = 0; i < COUNT(orders); i++) {
        const int n = orders[i];
        if (n > order)
            continue;
        ALL(ops->zero(A); for (int q = 0; q < 5; q++) ops->conv(A, 1, U, U, n, 0, n));
        ALL(for (int q = 0; q < 3; q++) ops->square(A, 1, U, n, 0));
        ALL(ops->conv(A, -1, U, U, n, 0, n); ops->store(A, W, n));
        /* 7 (n + 1) x^2 with x = (1/2 - 2^(-52 rows)) 2^(e + 1), to the bound on dropped pairs */
        mpfr_set_ui_2exp(p, 1, -1, MPFR_RNDN);
        mpfr_set_ui_2exp(s, 1, -(long)FX_BITS * F->rows[n], MPFR_RNDN);
        mpfr_sub(s, p, s, MPFR_RNDN);
        mpfr_sqr(s, s, MPFR_RNDN);
        mpfr_mul_ui(s, s, 7 * ((unsigned long)n + 1), MPFR_RNDN);
        mpfr_mul_2si(s, s, 2 * F->series[U].exp + 2 - n, MPFR_RNDN);
        double unit = -(double)FX_BITS * F->rows[n] - n;
        double bound = 2 * exponent_of(U) + 2 + unit + log2(11 * (n + 1.0) * (F->rows[n] + 2));
        check_value(W, n, s, fmax(bound, unit_of(W, n) + 1), "all ones");
    }
    mpfr_clears(t, s, p, (mpfr_ptr)0);
    close_each();
}
END_TEST

/* Series that were never set, and those set to zero, are zero everywhere. */
START_TEST(zero_series)
{
    for (int order = 1; order <= 20; order += order < 3 ? 1 : 17) {
        mpfr_t t, y;
        long e;
        cns_fast_status status;
        mpfr_inits2(200, t, y, (mpfr_ptr)0);
        open_each(order, 150);
        ALL(ops->begin(A, 0.25));
        mpfr_set_ui(t, 3, MPFR_RNDN);
        mpfr_div_ui(t, t, 7, MPFR_RNDN);
        ALL(ops->set(A, U, 0, t, false));
        mpfr_set_zero(t, -1);
        ALL(ops->set(A, V, 0, t, false));
        mpfr_set_zero(t, 1);
        ALL(ops->set(A, C, 0, t, true));
        for (int k = 0; k < order; k++) {
            ALL(ops->zero(A); ops->conv(A, 1, U, V, k, 0, k); ops->conv(A, -1, D, U, k, 0, k);
                ops->square(A, 1, V, k, 0); ops->square(A, 1, D, k, 0); ops->coef(A, -5, D, k);
                ops->scaled(A, 1, C, U, k); ops->coef(A, 7, V, k); ops->store_next(A, W, k, -1));
            ALL(ops->zero(A); ops->coef(A, 1, U, k); ops->store_scaled(A, T, k, C));
            ALL(ops->zero(A); ops->store_over(A, D, k, U, 0, k & 1));
            static const int zero[] = {W, T, D, V};
            for (int i = 0; i < COUNT(zero); i++) {
                check_same(zero[i], "zero");
                ops->get(each[0], y, zero[i], k);
                ck_assert(mpfr_zero_p(y) && ops->get_2exp(each[0], &e, zero[i], k) == 0);
            }
        }
        mpfr_set_ui(t, 1, MPFR_RNDN);
        cns_fast_sum(each[0], y, W, order, t);
        ck_assert(mpfr_zero_p(y));
        cns_fast_status_get(each[0], &status);
        ck_assert(!status.singular && status.raised == 0);
        ALL(ops->zero(A); ops->coef(A, 1, U, 0); ops->store_over(A, W, 0, V, 0, 0));
        cns_fast_status_get(each[0], &status);
        ck_assert(status.singular);
        close_each();
        mpfr_clears(t, y, (mpfr_ptr)0);
    }
}
END_TEST

/* Expansions of x' = c x - s, s^2 = x^2 + ..., by hand: from one begin to the next the step, the precision
 * and the size of the states change, constants stay; every coefficient is right to the precision of its time.
 */
START_TEST(begin_again)
{
    stream = round_seed = test_seed();
    for (int i = 0; i < 20; i++) {
        const int order = (int)pick(1, 90);
        const mpfr_prec_t most = pick(100, 600);
        mpfr_t *x = cns_vector_xnew(order + 1, 2 * most + 1000), c, t, s;
        mpfr_inits2(2 * most + 1000, c, t, s, (mpfr_ptr)0);
        open_each(order, most);
        random_value(c, 1, RANDOM);
        mpfr_prec_round(c, most, MPFR_RNDN);
        ALL(ops->begin(A, 1));
        ALL(ops->set(A, C, 0, c, true));
        double H = 1;
        long size = 0;
        int kept = 0;
        mpfr_prec_t prec = most;
        for (int again = 0; again < 12; again++) {
            H = one_in(3) ? ldexp(H, (int)pick(-6, 6)) : H * (0.7 + 0.6 * test_random_unit(&stream));
            H = H > 1 ? 1 : H < 1e-3 ? 1e-3 : H;
            bool other = one_in(4);
            kept = other ? 0 : kept + 1; /* expansions of this size */
            size = other ? pick(-90, 90) : size;
            prec = one_in(3) ? pick(60, most) : prec;
            ALL(cns_fast_set_precision(A, prec));
            ALL(ops->begin(A, H));
            mpfr_set_prec(t, most);
            ops->get(each[0], t, C, 0);
            ck_assert(mpfr_equal_p(t, c));
            random_value(t, size, RANDOM);
            ALL(ops->set(A, U, 0, t, false));
            mpfr_set(x[0], t, MPFR_RNDN);
            mpfr_set_prec(t, 2 * most + 1000);
            for (int k = 0; k < order; k++) { /* x' = c x / 8: x_{k+1} = c H x_k / (8 (k+1)) */
                ALL(ops->zero(A); ops->scaled(A, 1, C, U, k); ops->store_ratio(A, V, k, 1, 8));
                ALL(ops->zero(A); ops->coef(A, 1, V, k); ops->store_next(A, U, k, -1));
                mpfr_mul(x[k + 1], x[k], c, MPFR_RNDN);
                mpfr_mul_d(x[k + 1], x[k + 1], H, MPFR_RNDN);
                mpfr_div_ui(x[k + 1], x[k + 1], 8 * ((unsigned long)k + 1), MPFR_RNDN);
            }
            for (int k = 0; k <= order; k++)
                check_value(U, k, x[k], exponent_of(U) + 4 - (double)prec, "begun again");
            /* exponents fall by at least a limb per expansion */
            CHECK(kept < 4 || exponent_of(U) - (double)size <= 16, "exponent 2^%g for a state of 2^%ld",
                  exponent_of(U), size);
            check_same(V, "begun again");
        }
        close_each();
        cns_vector_free(x);
        mpfr_clears(c, t, s, (mpfr_ptr)0);
    }
}
END_TEST

START_TEST(what_does_not_fit)
{
    static const cns_arith_spec bad[] = {
        {0, 5, 100, NULL}, {3, 0, 100, NULL}, {3, 5, 0, NULL}, {3, 5, 2000000, NULL}, {3, 2000000, 99, NULL}};
    const cns_arith_spec unknown = {3, 5, 100, "sparc"};
    cns_error err;
    for (int i = 0; i < COUNT(bad); i++) {
        ck_assert_ptr_null(cns_arith_fast.create(&bad[i], &err));
        ck_assert_int_eq(err.code, CNS_NUMERIC);
    }
    ck_assert_ptr_null(cns_arith_fast.create(&unknown, &err));
    ck_assert_int_eq(err.code, CNS_USAGE);
    ck_assert_int_eq(cns_fast_choose_kernel("sparc", &err), CNS_USAGE);
}
END_TEST

/* Jets. */

/* A program of the model with some parameters drawn anew. */
static cns_program *random_program(const char *model, const char *smooth)
{
    const cns_model *m = cns_model_find(model);
    char text[16][32];
    const char *texts[16];
    for (int i = 0; i < m->n_parameters; i++) {
        texts[i] = m->parameters[i].standard;
        if (one_in(3))
            continue;
        double standard = strtod(texts[i], NULL);
        standard = standard == 0 ? 3 : standard; /* pi */
        snprintf(text[i], sizeof text[i], "%.9f", standard * (0.4 + 1.2 * test_random_unit(&stream)));
        texts[i] = text[i];
    }
    cns_program_options options = {NULL};
    cns_number *parameters = numbers_new(m->n_parameters, texts);
    cns_number *eps = smooth ? numbers_new(1, &smooth) : NULL;
    options.smooth = eps;
    cns_program *p;
    cns_error err;
    check_ok(cns_model_program(m, parameters, &options, &p, &err), &err);
    numbers_free(parameters, m->n_parameters);
    if (eps)
        numbers_free(eps, 1);
    return p;
}

enum { TEXT = 48 };

static void random_states(const cns_program *p, char text[][TEXT], const char **texts, bool zeros)
{
    const int n = cns_program_states(p);
    for (int i = 0; i < n; i++) {
        double size = n == 3 ? 20 : one_in(5) ? 1e-3 : 2;
        snprintf(text[i], TEXT, "%.15f", zeros && one_in(8) ? 0 : size * (2 * test_random_unit(&stream) - 1));
        texts[i] = text[i];
    }
}

/* One expansion of all states, coefficient k of state i in c[i (order+1) + k]; false where it is singular. */
static bool expand(cns_jet *J, int order, double H, mpfr_t *state, int n, mpfr_t *c)
{
    cns_error ignored;
    cns_jet_begin(J, H);
    for (int i = 0; i < n; i++)
        cns_jet_set_state(J, i, state[i]);
    if (cns_jet_expand(J, order, &ignored) || cns_jet_order(J) != order)
        return false;
    for (int i = 0; i < n; i++)
        for (int k = 0; k <= order; k++)
            cns_jet_coefficient(J, c[i * (order + 1) + k], i, k);
    return true;
}

/* The step that the last coefficients of an expansion with H = 1 allow. */
static double step_for(mpfr_t *c, int n, int order, double tolerance_log2)
{
    double best = 4;
    for (int i = 0; i < n; i++)
        for (int k = (order + 1) / 2 + order / 4; k <= order; k++)
            best = fmin(best, (tolerance_log2 - log2_of(c[i * (order + 1) + k])) / k);
    return exp2(best);
}

static double worst_to_bound, worst_lost; /* log2 of error / bound; of bound / 2^-prec */

/* The error of the fast jet against the plain one at 200 bits more, from the same state with the step H. The
 * state moves on to the end of the step. */
static bool one_expansion(cns_jet *fast, cns_jet *plain, int order, double *H, double tolerance_log2,
                          mpfr_prec_t prec, mpfr_t *state, int n)
{
    mpfr_prec_t more = prec + 200;
    mpfr_t *c = cns_vector_xnew(n * (order + 1), more), *d = cns_vector_xnew(n * (order + 1), more), power;
    bool done = expand(plain, order, 1, state, n, c);
    if (done) {
        double factor = exp2(1.3 * test_random_unit(&stream) - (one_in(4) ? 4 : 1));
        *H = step_for(c, n, order, tolerance_log2) * factor;
        done = expand(fast, order, *H, state, n, d);
    }
    if (done) {
        double worst = -HUGE_VAL, bound = ops->noise_log2(cns_jet_arith(fast));
        mpfr_init2(power, more);
        mpfr_set_ui(power, 1, MPFR_RNDN);
        for (int i = 0; i < n; i++)
            mpfr_set_zero(state[i], 1);
        for (int k = 0; k <= order; k++) {
            for (int i = 0; i < n; i++) {
                mpfr_ptr x = c[i * (order + 1) + k];
                mpfr_mul(x, x, power, MPFR_RNDN);
                worst = fmax(worst, log2_distance(x, d[i * (order + 1) + k]));
                mpfr_add(state[i], state[i], x, MPFR_RNDN);
            }
            mpfr_mul_d(power, power, *H, MPFR_RNDN);
        }
        CHECK(worst == -HUGE_VAL || worst < bound,
              "order %d, %ld bits, H = %g: an error of 2^%.1f, above its bound 2^%.1f", order, (long)prec, *H,
              worst, bound);
        worst_to_bound = fmax(worst_to_bound, worst - bound);
        worst_lost = fmax(worst_lost, bound + (double)prec);
        mpfr_clear(power);
    }
    cns_vector_free(c);
    cns_vector_free(d);
    return done;
}

enum { ARCS = 200, GUARD = 28 }; /* GUARD: what the integrator adds to the precision */

START_TEST(jets_keep_their_bound)
{
    int arcs = 0, expansions = 0, refused = 0;
    stream = test_seed();
    worst_to_bound = worst_lost = -HUGE_VAL;
    while (arcs < ARCS) {
        char text[8][TEXT];
        const char *texts[8];
        round_seed = stream = test_random(&stream);
        bool disk = !one_in(5);
        cns_program *p = random_program(disk ? "apw" : "lorenz", one_in(4) ? "1e-3" : NULL);
        const int n = cns_program_states(p);
        long digits = pick(20, one_in(4) ? 200 : 90);
        mpfr_prec_t prec = cns_digits_to_bits(digits);
        double tolerance_log2 = DECIMALS((double)digits);
        int order = cns_order_for(tolerance_log2, CNS_ARITH_FAST);
        if (one_in(2))
            order = (int)pick(2, 3 * order / 2);
        random_states(p, text, texts, true);
        cns_number *given = numbers_new(n, texts);
        mpfr_t *state = cns_vector_xnew(n, prec);
        for (int i = 0; i < n; i++)
            cns_number_get_mpfr(state[i], &given[i]);
        cns_jet *fast = jet_new(p, &cns_arith_fast, order, prec + GUARD);
        cns_jet *plain = jet_new(p, &cns_arith_mpfr, order, prec + 200);
        ops->set_decay(cns_jet_arith(fast), (int)pick(1, 3));
        double H;
        bool done = true;
        int count = 0;
        for (int more = one_in(3) ? 3 : 1; done && more > 0; more--, count += done)
            done = one_expansion(fast, plain, order, &H, tolerance_log2, prec, state, n);
        arcs += count > 0;
        expansions += count;
        refused += !done;
        cns_jet_free(fast);
        cns_jet_free(plain);
        cns_vector_free(state);
        numbers_free(given, n);
        cns_program_free(p);
        ck_assert_int_lt(refused, ARCS);
    }
    printf("fast: %d expansions of %d random arcs: the largest error is 2^%.1f of its bound (seed %llu)\n",
           expansions, arcs, worst_to_bound, (unsigned long long)test_seed());
    fflush(stdout);
    ck_assert_double_lt(worst_to_bound, 0);
}
END_TEST

/* Every operation there is, some of whose series vanish or begin late. */
static cns_program *all_operations(void)
{
    cns_program *p = program_new(4, NULL);
    cns_node x = cns_state(p, 0), y = cns_state(p, 1), z = cns_state(p, 2), w = cns_state(p, 3);
    cns_node half = cns_constant(p, "1/2"), three = cns_constant(p, "3"), sine, cosine;
    cns_sincos(p, cns_mul(p, x, z), &sine, &cosine);
    cns_node square = cns_add(p, three, cns_sqr(p, y));
    cns_derivative(p, 0, cns_sub(p, cns_div(p, sine, square), cns_mul(p, half, cns_abs(p, y))));
    cns_derivative(p, 1, cns_add(p, cns_mul(p, cns_log(p, square), cosine), cns_neg(p, cns_sqrt(p, square))));
    cns_derivative(
        p, 2, cns_sub(p, cns_mul(p, cns_pow(p, square, cns_constant(p, "-1/3")), x), cns_hypot(p, y, three)));
    cns_derivative(p, 3, cns_mul(p, w, cns_exp(p, cns_mul(p, cns_constant(p, "-1/5"), cns_sqr(p, z)))));
    return finished(p);
}

/* Whole orders at once, by their trace, compiled or not, against every call as it comes: the same bits, with
 * steps so long that block exponents must be raised on the way. */
START_TEST(orders_at_once_change_nothing)
{
    cns_arith_ops one_by_one = *ops;
    one_by_one.orders = NULL;
    stream = test_seed() + 31u * (uint64_t)_i;
    round_seed = stream;
    cns_error no_kernel;
    if (cns_fast_choose_kernel(kernels[_i % KERNELS], &no_kernel))
        return;
    long raised = 0, compared = 0;
    for (int arcs = 0; arcs < 30; arcs++) {
        char text[8][TEXT];
        const char *texts[8];
        cns_program *p = one_in(3)   ? all_operations()
                         : one_in(3) ? random_program("lorenz", NULL)
                                     : random_program("apw", one_in(2) ? "1e-3" : NULL);
        const int n = cns_program_states(p), order = (int)pick(1, one_in(4) ? 260 : 90);
        const mpfr_prec_t prec = pick(30, one_in(3) ? 900 : 300);
        random_states(p, text, texts, true);
        cns_number *given = numbers_new(n, texts);
        mpfr_t *state = cns_vector_xnew(n, prec), *c = cns_vector_xnew(n * (order + 1), prec + 200),
               *d = cns_vector_xnew(n * (order + 1), prec + 200);
        cns_jet *at_once = jet_new(p, ops, order, prec), *single = jet_new(p, &one_by_one, order, prec);
        const int decay = (int)pick(1, 3);
        ops->set_decay(cns_jet_arith(at_once), decay);
        ops->set_decay(cns_jet_arith(single), decay);
        double H = exp2(-2 - 4 * test_random_unit(&stream));
        for (int i = 0; i < n; i++)
            cns_number_get_mpfr(state[i], &given[i]);
        for (int times = 0; times < 4; times++) {
            cns_fast_status status;
            const bool good = expand(at_once, order, H, state, n, c);
            CHECK(expand(single, order, H, state, n, d) == good, "order %d: only one fails", order);
            CHECK(ops->noise_log2(cns_jet_arith(at_once)) == ops->noise_log2(cns_jet_arith(single)),
                  "order %d, H = %g: noise differs", order, H);
            if (!good)
                continue;
            for (int i = 0; i < n * (order + 1); i++)
                CHECK(mpfr_equal_p(c[i], d[i]),
                      "order %d, %ld bits, H = %g: state %d, coefficient %d differs", order, (long)prec, H,
                      i / (order + 1), i % (order + 1));
            cns_fast_status_get(cns_jet_arith(at_once), &status);
            raised += status.raised > 0;
            compared++;
            H *= one_in(3) ? 0.2 + 2.5 * test_random_unit(&stream) : 1;
            if (one_in(3))
                mpfr_add_d(state[pick(0, n - 1)], state[0], 0.01, MPFR_RNDN);
        }
        cns_jet_free(at_once);
        cns_jet_free(single);
        cns_vector_free(state);
        cns_vector_free(c);
        cns_vector_free(d);
        numbers_free(given, n);
        cns_program_free(p);
    }
    ck_assert_int_gt(compared, 20);
    ck_assert_int_gt(raised, 0);
}
END_TEST

/* Flows. */

/* The derivative that a step is checked by: within its tolerance of the right-hand side, and not of one with
 * a constant that is wrong in one of the last digits. */
START_TEST(derivatives_are_sharp)
{
    static const char *const initial[] = {"0", "0", "1.7", "-0.45", "-0.3", "0.6"};
    static const char *const standard[] = {"2.2", "1.2", "pi", "1.4", "1", "0.2", "0.2"};
    const long digits = 20 + 25 * _i;
    cns_program *p = model_program("apw", NULL);
    const int n = cns_program_states(p);
    cns_flow_spec spec = taylor_spec(p, digits);
    spec.arithmetic = CNS_ARITH_FAST;
    const mpfr_prec_t more = spec.prec + 96;
    mpfr_t *x = cns_vector_xnew(n, spec.prec), *y = cns_vector_xnew(n, spec.prec),
           *dx = cns_vector_xnew(n, more), tolerance, f;
    mpfr_inits2(more, tolerance, f, (mpfr_ptr)0);
    cns_number *given = numbers_new(n, initial);
    for (int i = 0; i < n; i++)
        cns_number_get_mpfr(x[i], &given[i]);
    cns_error err;
    cns_stepper *s = cns_method_taylor.create(&spec, &err);
    cns_step step = {.t0 = 0};
    mpfr_init2(step.h, 2 * spec.prec + 128);
    cns_method_taylor.start(s);
    check_ok(cns_method_taylor.step(s, &step, x, y, &err), &err);
    cns_method_taylor.derivative(s, step.h, dx, tolerance);
    for (int wrong = -1; wrong < 7; wrong++) {
        char text[200] = "";
        const char *texts[7];
        for (int i = 0; i < 7; i++)
            texts[i] = standard[i];
        if (wrong == 2)
            continue; /* no decimal */
        if (wrong >= 0) {
            snprintf(text, sizeof text, "%s%s", standard[wrong], strchr(standard[wrong], '.') ? "" : ".");
            for (long i = 0; i < digits - 13; i++)
                strcat(text, "0");
            strcat(text, "1");
            texts[wrong] = text;
        }
        cns_number *parameters = numbers_new(7, texts);
        cns_program_options options = {NULL};
        cns_program *q;
        check_ok(cns_model_program(cns_model_find("apw"), parameters, &options, &q, &err), &err);
        cns_jet *check = jet_new(q, &cns_arith_mpfr, 1, more);
        cns_jet_begin(check, 1);
        for (int i = 0; i < n; i++)
            cns_jet_set_state(check, i, y[i]);
        check_ok(cns_jet_expand(check, 1, &err), &err);
        bool same = true;
        for (int i = 0; i < n; i++) {
            cns_jet_coefficient(check, f, i, 1);
            mpfr_sub(f, f, dx[i], MPFR_RNDN);
            same = same && mpfr_cmpabs(f, tolerance) <= 0;
        }
        ck_assert_msg(same == (wrong < 0), "%ld digits: parameter %d", digits, wrong);
        cns_jet_free(check);
        cns_program_free(q);
        numbers_free(parameters, 7);
    }
    cns_method_taylor.destroy(s);
    mpfr_clears(tolerance, f, step.h, (mpfr_ptr)0);
    cns_vector_free(x);
    cns_vector_free(y);
    cns_vector_free(dx);
    numbers_free(given, n);
    cns_program_free(p);
}
END_TEST

/* A program of the model with its defaults, or with random parameters. */
static cns_flow *start_flow(const cns_flow_spec *spec, cns_arithmetic arithmetic, const char *const *initial)
{
    cns_flow_spec own = *spec;
    own.arithmetic = arithmetic;
    return flow_started(&own, initial);
}

#define FAST                                                                                                 \
    {                                                                                                        \
        "0", "0", "1.7", "-0.45", "-0.3", "0.6"                                                              \
    } /* far from the zeros of the speed */
#define CASE4                                                                                                \
    {                                                                                                        \
        "0", "0", "1", "0", "0.01", "1"                                                                      \
    }
static const struct {
    const char *what, *model, *smooth;
    const char *initial[6];
    const char *end, *step;
    long digits;
    int order; /* 0: that of the tolerance */
    double decimals;
} trajectories[] = {
    {"case 4, crossings", "apw", NULL, CASE4, "20", NULL, 60, 0, 55},
    {"order 400", "apw", NULL, FAST, "2", NULL, 100, 400, 96},
    {"low order", "apw", NULL, FAST, "1", NULL, 14, 7, 11},
    {"order 500", "apw", NULL, FAST, "1", NULL, 160, 500, 156},
    {"fixed step", "apw", NULL, FAST, "6", "1/16", 40, 60, 36},
    {"a long fixed step, of low order", "apw", NULL, FAST, "2", "1/16", 60, 10, 55},
    {"smoothed, 1e-3", "apw", "1e-3", CASE4, "12", NULL, 60, 0, 56},
    {"smoothed, 1e-10", "apw", "1e-10", CASE4, "8", NULL, 50, 0, 46},
    {"smoothed, 1e-30", "apw", "1e-30", CASE4, "8", NULL, 40, 0, 36},
    {"rest", "apw", NULL, {"0", "0", "1", "0", "0", "0"}, "6", NULL, 50, 0, 46},
    {"rest, smoothed", "apw", "1e-8", {"0", "0", "1", "0", "0", "0"}, "3", NULL, 40, 0, 36},
    {"straight down", "apw", NULL, {"0", "0", "0", "0", "0.01", "0"}, "10", NULL, 50, 0, 47},
    {"straight down from rest", "apw", NULL, {"0", "0", "0", "0", "0", "0"}, "5", NULL, 50, 0, 47},
    {"turning at rest", "apw", NULL, {"0", "0", "1/2", "0", "0", "-1"}, "5", NULL, 50, 0, 46},
    {"lorenz", "lorenz", NULL, {"-15.8", "-17.48", "35.64"}, "12", NULL, 80, 0, 68},
    {"lorenz, on its axis", "lorenz", NULL, {"0", "0", "30"}, "5", NULL, 50, 0, 47},
    {"lorenz, at rest", "lorenz", NULL, {"0", "0", "0"}, "5", NULL, 50, 0, 47},
};

START_TEST(flows_agree)
{
    cns_program *p = model_program(trajectories[_i].model, trajectories[_i].smooth);
    const int n = cns_program_states(p);
    cns_flow_spec spec = taylor_spec(p, trajectories[_i].digits);
    cns_number *step = trajectories[_i].step ? numbers_new(1, &trajectories[_i].step) : NULL;
    spec.step = step;
    if (trajectories[_i].order > 0)
        spec.order = trajectories[_i].order;
    mpfr_t *x = cns_vector_xnew(n, spec.prec), *y = cns_vector_xnew(n, spec.prec);
    cns_flow *fast = start_flow(&spec, CNS_ARITH_FAST, trajectories[_i].initial);
    cns_flow *plain = start_flow(&spec, CNS_ARITH_MPFR, trajectories[_i].initial);
    flow_to(fast, trajectories[_i].end, x);
    flow_to(plain, trajectories[_i].end, y);
    for (int i = 0; i < n; i++) {
        double size = fmax(0, log2_of(y[i]));
        check_close(x[i], y[i], size + DECIMALS(trajectories[_i].decimals), "%s, state %d",
                    trajectories[_i].what, i);
    }
    ck_assert_int_eq(cns_flow_landings(fast), cns_flow_landings(plain));
    cns_flow_free(fast);
    cns_flow_free(plain);
    cns_vector_free(x);
    cns_vector_free(y);
    if (step)
        numbers_free(step, 1);
    cns_program_free(p);
}
END_TEST

START_TEST(the_reference)
{
    static const char *const times[] = {"0.5", "3", "5.5", "10", "15.5", "20"};
    static const char *const initial[] = CASE4;
    cns_program *p = model_program("apw", NULL);
    cns_flow_spec spec = taylor_spec(p, 60);
    mpfr_t *x = cns_vector_xnew(6, spec.prec), *y = cns_vector_xnew(6, spec.prec);
    cns_flow *f = start_flow(&spec, CNS_ARITH_FAST, initial);
    for (int i = 0; i < COUNT(times); i++) {
        flow_to(f, times[i], x);
        reference_row("case4.csv", times[i], y, 6);
        for (int j = 0; j < 6; j++) /* rounded to 40 decimals */
            check_close(x[j], y[j], DECIMALS(40) - 0.9, "t = %s, state %d", times[i], j);
    }
    ck_assert_int_ge(cns_flow_landings(f), 2);
    cns_flow_free(f);
    cns_vector_free(x);
    cns_vector_free(y);
    cns_program_free(p);
}
END_TEST

/* Digits pay one for one: at t = 300, where noise has grown by some 12 digits, against 320 decimals of
 * another program; at an order far from the best, too. */
START_TEST(digits_pay_one_for_one)
{
    static const struct {
        long digits;
        int order; /* 0: the best */
    } runs[] = {{60, 0}, {120, 0}, {60, 300}};
    static const char *const initial[] = CASE4;
    cns_program *p = model_program("apw", NULL);
    for (int i = 0; i < COUNT(runs); i++) {
        cns_flow_spec spec = taylor_spec(p, runs[i].digits);
        if (runs[i].order)
            spec.order = runs[i].order;
        mpfr_t *x = cns_vector_xnew(6, spec.prec), *y = cns_vector_xnew(6, 1100);
        cns_flow *f = start_flow(&spec, CNS_ARITH_FAST, initial);
        flow_to(f, "300", x);
        reference_row("case4-t300-320.csv", "300", y, 6);
        double worst = -HUGE_VAL;
        for (int j = 2; j < 6; j++)
            worst = fmax(worst, log2_distance(x[j], y[j]));
        double lost = (double)runs[i].digits + worst / 3.3219280948873623479;
        ck_assert_msg(lost > 8 && lost < 16, "%ld digits, order %d: %.1f digits lost", runs[i].digits,
                      spec.order, lost);
        cns_flow_free(f);
        cns_vector_free(x);
        cns_vector_free(y);
    }
    cns_program_free(p);
}
END_TEST

/* With the same order and fixed step the truncation is the same, and only rounding tells them apart. */
START_TEST(orders_1_to_400)
{
    static const int orders[] = {1,  2,  3,  4,  5,  6,  7,  8,  9,   10,  11,  12,  15,  16, 17,
                                 23, 24, 25, 31, 33, 63, 64, 65, 100, 191, 192, 193, 256, 400};
    static const char *const initial[2][6] = {FAST, {"-15.8", "-17.48", "35.64"}};
    static const char *const h[2] = {"1/64", "1/256"}, *const end[2] = {"1/4", "1/32"};
    for (int m = 0; m < 2; m++) {
        cns_program *p = model_program(m == 0 ? "apw" : "lorenz", NULL);
        const int n = cns_program_states(p);
        cns_number *step = numbers_new(1, &h[m]);
        for (int i = 0; i < COUNT(orders); i++) {
            cns_flow_spec spec = taylor_spec(p, 30);
            spec.order = orders[i];
            spec.step = step;
            mpfr_t *x = cns_vector_xnew(n, spec.prec), *y = cns_vector_xnew(n, spec.prec);
            cns_flow *fast = start_flow(&spec, CNS_ARITH_FAST, initial[m]);
            cns_flow *plain = start_flow(&spec, CNS_ARITH_MPFR, initial[m]);
            flow_to(fast, end[m], x);
            flow_to(plain, end[m], y);
            for (int j = 0; j < n; j++)
                check_close(x[j], y[j], DECIMALS(m == 0 ? 31 : 29), "model %d, order %d, state %d", m,
                            orders[i], j);
            ck_assert_int_eq(cns_flow_steps(fast), cns_flow_steps(plain));
            cns_flow_free(fast);
            cns_flow_free(plain);
            cns_vector_free(x);
            cns_vector_free(y);
        }
        numbers_free(step, 1);
        cns_program_free(p);
    }
}
END_TEST

/* An error, not a reason to take another arithmetic. */
START_TEST(no_flow_without_its_kernel)
{
    cns_error err;
    cns_program *p = random_program("lorenz", NULL);
    cns_flow_spec spec = taylor_spec(p, 30);
    spec.arithmetic = CNS_ARITH_FAST;
    spec.kernel = "sparc";
    ck_assert_ptr_null(cns_flow_new(&spec, &err));
    ck_assert_int_eq(err.code, CNS_USAGE);
    cns_program_free(p);
}
END_TEST

/* The same steps, the same bits, whatever the kernel. */
START_TEST(kernels_give_the_same_flows)
{
    if (!has_kernel(kernels[1]))
        return;
    stream = test_seed() + 77u * (uint64_t)_i;
    round_seed = stream;
    char text[8][TEXT];
    const char *texts[8];
    static const char *const fixed_step = "1/50";
    cns_program *p = random_program(one_in(4) ? "lorenz" : "apw", one_in(3) ? "1e-5" : NULL);
    const int n = cns_program_states(p);
    cns_flow_spec spec = taylor_spec(p, pick(15, one_in(3) ? 200 : 70));
    cns_number *step = one_in(5) ? numbers_new(1, &fixed_step) : NULL;
    spec.step = step;
    spec.order = step ? (int)pick(1, 90) : one_in(2) ? (int)pick(12, spec.order + 40) : spec.order;
    spec.verify = false;
    random_states(p, text, texts, one_in(2));
    cns_flow *f[KERNELS];
    for (int i = 0; i < KERNELS; i++) {
        spec.kernel = kernels[i];
        f[i] = start_flow(&spec, CNS_ARITH_FAST, texts);
    }
    for (int s = 0; s < 60 && mpfr_cmp_ui(cns_flow_end(f[0]), 4) < 0; s++) {
        cns_error err[KERNELS];
        cns_code code = cns_flow_step(f[0], &err[0]);
        CHECK(cns_flow_step(f[1], &err[1]) == code, "step %d: %s", s, err[code ? 0 : 1].text);
        if (code) {
            ck_assert_str_eq(err[0].text, err[1].text);
            break;
        }
        bool same = mpfr_equal_p(cns_flow_end(f[0]), cns_flow_end(f[1])) &&
                    cns_flow_landed(f[0]) == cns_flow_landed(f[1]) &&
                    cns_flow_noise_log2(f[0]) == cns_flow_noise_log2(f[1]);
        for (int i = 0; i < n; i++)
            same = same && mpfr_equal_p(cns_flow_state(f[0])[i], cns_flow_state(f[1])[i]);
        CHECK(same, "step %d: kernels differ", s);
    }
    for (int i = 0; i < KERNELS; i++)
        cns_flow_free(f[i]);
    if (step)
        numbers_free(step, 1);
    cns_program_free(p);
}
END_TEST

Suite *suite_fast(void)
{
    Suite *s = suite_create("fast");
    TCase *t = tcase_create("primitives");
    tcase_add_loop_test(t, sums_and_stores, 0, SUM_RUNS);
    tcase_add_test(t, functions_of_order_0);
    tcase_add_test(t, a_raise_is_seen_and_keeps_values);
    add_table_test(t, all_ones, full);
    tcase_add_test(t, zero_series);
    tcase_add_test(t, begin_again);
    tcase_add_test(t, what_does_not_fit);
    suite_add_tcase(s, t);
    t = tcase_create("jets");
    tcase_add_test(t, jets_keep_their_bound);
    tcase_add_loop_test(t, orders_at_once_change_nothing, 0, 4 * KERNELS);
    suite_add_tcase(s, t);
    t = tcase_create("flows");
    add_table_test(t, flows_agree, trajectories);
    tcase_add_loop_test(t, derivatives_are_sharp, 0, 5);
    tcase_add_test(t, the_reference);
    tcase_add_test(t, digits_pay_one_for_one);
    tcase_add_test(t, orders_1_to_400);
    tcase_add_test(t, no_flow_without_its_kernel);
    tcase_add_loop_test(t, kernels_give_the_same_flows, 0, 20);
    suite_add_tcase(s, t);
    return s;
}
