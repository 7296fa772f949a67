/* The fast arithmetic: its primitives against exact sums in MPFR, its kernels against each other bit for bit,
 * its jets against the plain arithmetic's within the bound that it states, and whole flows. */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "num/fixed.h"
#include "problem.h"
#include "taylor/arith_fast.h"

static const cns_arith_ops *const ops = &cns_arith_fast;

/* Kernels that this machine has. */

enum { KERNELS = 2 };
static const char *const kernels[KERNELS] = {"portable", "avx512ifma"};

static bool has_kernel(const char *name)
{
    return fx_kernel_choose(name) != NULL;
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
    cns_arith_spec spec = {SERIES, order, prec};
    n_each = 0;
    for (int i = 0; i < KERNELS; i++) {
        cns_error err;
        if (!has_kernel(kernels[i]))
            continue;
        each[n_each] = cns_fast_create(&spec, kernels[i], &err);
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
                    (!s->live || s->exp == t->exp) && F->raised == G->raised &&
                    F->raised_series == G->raised_series && F->singular == G->singular;
        for (int k = 0; same && k < s->stored; k++) {
            for (int l = 0; l < F->rows[k]; l++) {
                size_t at = (size_t)l * F->stride;
                uint64_t limb = s->fwd[at + (size_t)k];
                same = same && limb >> FX_BITS == 0 && t->fwd[at + (size_t)k] == limb &&
                       s->rev[at + (size_t)(F->order - k)] == limb &&
                       t->rev[at + (size_t)(F->order - k)] == limb;
            }
            for (int l = 0; l <= F->rows[k]; l++) {
                size_t at = (size_t)k * (size_t)F->record + (size_t)l;
                same = same && s->record[at] == t->record[at] &&
                       s->record[at + (size_t)F->value] == t->record[at + (size_t)F->value];
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

typedef enum kind { ZERO, RANDOM, ONES, UNEVEN, MIXED, KINDS } kind;

static void random_value(mpfr_t y, long exp, kind kind)
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
static void fill(int w, int upto, kind kind, long exp, int decay, mpfr_t *x, mpfr_t t)
{
    for (int k = 0; k <= upto; k++) {
        enum kind this = kind == MIXED ? (enum kind)pick(ZERO, UNEVEN) : kind;
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
    x->u = vector_new(x->order + 1, x->exact);
    x->v = vector_new(x->order + 1, x->exact);
    mpfr_inits2(x->exact, x->c, x->s, x->p, (mpfr_ptr)0);
    mpfr_init2(x->t, prec + 300);
    long eu = pick(-20, 20), ev = one_in(2) ? eu + pick(-4, 4) : pick(-300, 300);
    fill(U, x->order, (kind)pick(0, KINDS - 1), eu, x->decay, x->u, x->t);
    fill(V, x->order, (kind)pick(0, KINDS - 1), ev, x->decay, x->v, x->t);
    random_value(x->t, pick(-30, 30), RANDOM);
    ALL(ops->set(A, C, 0, x->t, true));
    mpfr_set(x->c, x->t, MPFR_RNDN);
}

static void world_clear(world *x)
{
    vector_free(x->u, x->order + 1);
    vector_free(x->v, x->order + 1);
    mpfr_clears(x->c, x->s, x->p, x->t, (mpfr_ptr)0);
    close_each();
}

/* Sums of products with a random store. Bounds: a convolution of n + 1 terms drops less than (n + 1)(rows + 1)
 * units (fixed.h); a store rounds once, and a factor spreads a unit over its limbs. */

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
        long weight = one_in(4) ? pick(-2147483647L, 2147483647L) : pick(-3, 3);
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
        long a = one_in(2) ? 1 : pick(-1000, 1000), b = pick(1, 2000);
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
    CHECK(mpfr_zero_p(x->p) ? m == 0 : m == wanted && e == expected, "get_2exp after %s: %a 2^%ld, not %a 2^%ld",
          what, m, e, wanted, expected);
}

static void one_polynomial(world *x)
{
    const fx *F = inside(each[0]);
    double tau = one_in(3) ? 1 : one_in(2) ? 0.5 : ldexp((double)pick(0, 1L << 53), -53), finest = HUGE_VAL;
    int n = (int)pick(0, x->order);
    mpfr_t y;
    mpfr_init2(y, x->exact);
    mpfr_set_zero(x->s, 1);
    for (int k = n; k >= 0; k--) {
        mpfr_mul_d(x->s, x->s, tau, MPFR_RNDN);
        mpfr_add(x->s, x->s, x->u[k], MPFR_RNDN);
        finest = fmin(finest, (double)FX_BITS * (F->rows[k] + 1) + (double)x->decay * k);
    }
    for (int i = 0; i < n_each; i++) {
        cns_fast_sum(each[i], i == 0 ? y : x->p, U, n, tau);
        CHECK(i == 0 || mpfr_equal_p(y, x->p), "sum: kernels differ");
    }
    double distance = log2_distance(y, x->s), bound = exponent_of(U) + 2 - finest + log2(n + 2.0);
    CHECK(distance <= bound, "the sum at %g of %d is wrong by 2^%.1f, above 2^%.1f", tau, n, distance, bound);
    mpfr_clear(y);
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
    for (size_t i = 0; i < sizeof outside / sizeof *outside; i++) {
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
    CHECK(exponent_of(T) <= before + 1, "an exponent is learnt too high: %g after %g", exponent_of(T), before);
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
        check_value(T, k, x->u[k], unit_of(T, k) + (by > 0 ? 0 : -1e6), "raised from");
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
} full[] = {{66, 200},   {205, 430}, {210, 480},  {200, 490},  {190, 500},
            {700, 1000}, {1108, 3322}, {4200, 500}, {3000, 2600}, {160, 16700}};

static void set_ones(fx *F, int w)
{
    fx_series *x = &F->series[w];
    for (int k = 0; k <= F->order; k++) {
        int64_t *value = x->record + (size_t)k * (size_t)F->record + F->value;
        value[0] = 0;
        for (int l = 0; l < F->rows[k]; l++) {
            x->fwd[(size_t)l * F->stride + (size_t)k] = (uint64_t)FX_MASK;
            x->rev[(size_t)l * F->stride + (size_t)(F->order - k)] = (uint64_t)FX_MASK;
            value[l + 1] = l == 0 ? FX_MASK >> 1 : FX_MASK;
        }
    }
    fx_sums(F, w, 0);
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
    for (size_t i = 0; i < sizeof orders / sizeof *orders; i++) {
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
            for (size_t i = 0; i < sizeof zero / sizeof *zero; i++) {
                check_same(zero[i], "zero");
                ops->get(each[0], y, zero[i], k);
                ck_assert(mpfr_zero_p(y) && ops->get_2exp(each[0], &e, zero[i], k) == 0);
            }
        }
        cns_fast_sum(each[0], y, W, order, 1);
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

/* Expansions of x' = c x - s, s^2 = x^2 + ..., by hand: from one begin to the next the step, the precision and
 * the size of the states change, constants stay; every coefficient is right to the precision of its time. */
START_TEST(begin_again)
{
    stream = round_seed = test_seed();
    for (int i = 0; i < 20; i++) {
        const int order = (int)pick(1, 90);
        const mpfr_prec_t most = pick(100, 600);
        mpfr_t *x = vector_new(order + 1, 2 * most + 1000), c, t, s;
        mpfr_inits2(2 * most + 1000, c, t, s, (mpfr_ptr)0);
        open_each(order, most);
        random_value(c, 1, RANDOM);
        mpfr_prec_round(c, most, MPFR_RNDN);
        ALL(ops->begin(A, 1));
        ALL(ops->set(A, C, 0, c, true));
        double H = 1;
        long size = 0;
        mpfr_prec_t prec = most;
        for (int again = 0; again < 12; again++) {
            H = one_in(3) ? ldexp(H, (int)pick(-6, 6)) : H * (0.7 + 0.6 * test_random_unit(&stream));
            H = H > 1 ? 1 : H < 1e-3 ? 1e-3 : H;
            size = one_in(3) ? pick(-90, 90) : size;
            prec = one_in(3) ? pick(60, most) : prec;
            ALL(cns_fast_set_precision(A, prec));
            ALL(ops->begin(A, H));
            mpfr_set_prec(t, most);
            ops->get(each[0], t, C, 0);
            ck_assert(mpfr_equal_p(t, c));
            mpfr_set_prec(t, 2 * most + 1000);
            random_value(x[0], size, RANDOM);
            mpfr_prec_round(x[0], most, MPFR_RNDN);
            ALL(ops->set(A, U, 0, x[0], false));
            mpfr_prec_round(x[0], 2 * most + 1000, MPFR_RNDN);
            for (int k = 0; k < order; k++) { /* x' = c x / 8: x_{k+1} = c H x_k / (8 (k+1)) */
                ALL(ops->zero(A); ops->scaled(A, 1, C, U, k); ops->store_ratio(A, V, k, 1, 8));
                ALL(ops->zero(A); ops->coef(A, 1, V, k); ops->store_next(A, U, k, -1));
                mpfr_mul(x[k + 1], x[k], c, MPFR_RNDN);
                mpfr_mul_d(x[k + 1], x[k + 1], H, MPFR_RNDN);
                mpfr_div_ui(x[k + 1], x[k + 1], 8 * ((unsigned long)k + 1), MPFR_RNDN);
            }
            for (int k = 0; k <= order; k++)
                check_value(U, k, x[k], exponent_of(U) + 4 - (double)prec, "begun again");
            /* exponents that were learnt are those of this size, not of the one before */
            CHECK(exponent_of(U) - (double)size <= 16, "exponent 2^%g for a state of 2^%ld", exponent_of(U),
                  size);
            check_same(V, "begun again");
        }
        close_each();
        vector_free(x, order + 1);
        mpfr_clears(c, t, s, (mpfr_ptr)0);
    }
}
END_TEST

/* Exponents carried over to a new arithmetic make it continue with the same bits. */
static void carried_over(world *x)
{
    long e[SERIES], f[SERIES];
    cns_arith *other[KERNELS];
    const fx *F = inside(each[0]);
    cns_arith_spec spec = {SERIES, x->order, F->max_prec};
    int n = n_each;
    for (int i = 0; i < n; i++) {
        cns_fast_get_exponents(each[i], e);
        other[i] = cns_fast_create(&spec, cns_fast_kernel(each[i]), NULL);
        ck_assert_ptr_nonnull(other[i]);
        cns_fast_set_decay(other[i], x->decay);
        cns_fast_set_precision(other[i], F->prec);
        ops->set(other[i], C, 0, x->c, true);
        cns_fast_set_exponents(other[i], e);
        if (i > 0)
            ck_assert_mem_eq(e, f, sizeof e);
        memcpy(f, e, sizeof e);
    }
    memcpy(each + (n == 1 ? 1 : 0), other, 0);
    for (int i = 0; i < n; i++) {
        cns_arith *pair[KERNELS] = {each[i], other[i]}, *kept[KERNELS];
        memcpy(kept, each, sizeof kept);
        memcpy(each, pair, sizeof pair);
        n_each = 2;
        ALL(ops->begin(A, x->H));
        for (int k = 0; k <= x->order; k++) {
            ALL(ops->set(A, U, k, x->u[k], false));
            ALL(ops->zero(A); ops->square(A, 1, U, k, 0); ops->scaled(A, 1, C, U, k); ops->store(A, W, k));
        }
        check_same(U, "exponents carried over");
        check_same(W, "exponents carried over");
        memcpy(each, kept, sizeof kept);
        n_each = n;
        ops->destroy(other[i]);
    }
}

START_TEST(exponents_carry_over)
{
    rounds(300, 30, carried_over);
}
END_TEST

START_TEST(what_does_not_fit)
{
    static const cns_arith_spec bad[] = {{0, 5, 100}, {3, 0, 100}, {3, 5, 0}, {3, 5, 2000000}, {3, 2000000, 99}};
    const cns_arith_spec good = {3, 5, 100};
    cns_error err;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        ck_assert_ptr_null(cns_fast_create(&bad[i], NULL, &err));
        ck_assert_int_eq(err.code, CNS_NUMERIC);
    }
    ck_assert_ptr_null(cns_fast_create(&good, "sparc", &err));
    ck_assert_int_eq(err.code, CNS_USAGE);
}
END_TEST
