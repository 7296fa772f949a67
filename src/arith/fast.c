#include "fast.h"

#include <limits.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "arith/fixed/fixed.h"
#include "trace.h"

/* Fewer than 1024 limbs: a kernel sums the two halves, of 52 bits, of as many limb products in a word, and
 * the sum has to stay below 2^63. */
enum { MAX_PREC = 52000, MAX_ORDER = 1000000 };

struct cns_arith {
    fx *F;
    const fx_kernel *ops;
    int step_bits; /* H < 2^step_bits */

    /* For the bound on errors (noise_log2). The level of a series: the largest exponent of any number that a
     * coefficient of it was made from since begin, moved by the factor of its store. Errors are proportional
     * to 2^level. LONG_MIN: nothing was stored. */
    long *level;      /* per series */
    long now;         /* of the accumulator: the largest exponent so far */
    bool *integrated; /* per series: it is a state, made by store_next */
};

static long most(long a, long b)
{
    return a > b ? a : b;
}

/* What a store does to the level of series w, `factor` being log2 of the factor that it multiplies by. */
static void settle(cns_arith *A, int w, long factor)
{
    long level = A->now == LONG_MIN ? LONG_MIN : A->now + factor;
    A->level[w] = most(A->level[w], most(level, A->F->series[w].live ? A->F->series[w].exp : LONG_MIN));
}

static void destroy(cns_arith *A)
{
    if (A == NULL)
        return;
    if (A->F != NULL)
        cns_fx_destroy(A->F);
    free(A->integrated);
    free(A->level);
    free(A);
}

/* What cns_fast_choose_kernel() chose; NULL: the best. */
static const fx_kernel *_Atomic process_kernel;

cns_code cns_fast_choose_kernel(const char *name, cns_error *err)
{
    const fx_kernel *kernel = cns_fx_kernel_find(name == NULL || *name == '\0' ? "auto" : name);
    if (kernel == NULL)
        return cns_fail(err, CNS_USAGE,
                        "this machine has no such kernel; auto, portable and avx512ifma are known");
    atomic_store(&process_kernel, kernel);
    return CNS_OK;
}

static const fx_kernel *kernel_of_process(void)
{
    const fx_kernel *kernel = atomic_load(&process_kernel);
    return kernel != NULL ? kernel : cns_fx_kernel_find("auto");
}

const char *cns_fast_kernel_name(void)
{
    return kernel_of_process()->name;
}

bool cns_fast_has_kernel(const char *name)
{
    return cns_fx_kernel_find(name) != NULL;
}

static cns_arith *create(const cns_arith_spec *spec, cns_error *err)
{
    const fx_kernel *ops = spec->kernel == NULL ? kernel_of_process() : cns_fx_kernel_find(spec->kernel);
    if (ops == NULL) {
        cns_fail(err, CNS_USAGE, "this machine has no kernel %s", spec->kernel);
        return NULL;
    }
    if (spec->series < 1 || spec->order < 1 || spec->prec < MPFR_PREC_MIN || spec->prec > MAX_PREC ||
        spec->order > MAX_ORDER) {
        cns_fail(err, CNS_NUMERIC, "the fast arithmetic does not hold %d series of order %d and %ld bits",
                 spec->series, spec->order, (long)spec->prec);
        return NULL;
    }
    cns_arith *A = malloc(sizeof *A);
    if (A != NULL) {
        A->F = cns_fx_create(spec->series, spec->order, spec->prec, ops);
        A->ops = ops;
        A->step_bits = 1; /* H = 1 */
        A->integrated = calloc((size_t)spec->series, sizeof *A->integrated);
        A->level = malloc((size_t)spec->series * sizeof *A->level);
    }
    if (A == NULL || A->F == NULL || A->integrated == NULL || A->level == NULL) {
        destroy(A);
        cns_fail(err, CNS_MEMORY, "out of memory: %d series of order %d and %ld bits", spec->series,
                 spec->order, (long)spec->prec);
        return NULL;
    }
    return A;
}

static size_t bytes(const cns_arith *A)
{
    return A->F->bytes;
}

const char *cns_fast_kernel(const cns_arith *A)
{
    return A->ops->name;
}

void cns_fast_set_precision(cns_arith *A, mpfr_prec_t prec)
{
    A->F->next_prec = prec < A->F->max_prec ? prec : A->F->max_prec;
}

void cns_fast_set_decay(cns_arith *A, int decay)
{
    A->F->next_decay = decay < 1 ? 1 : decay > 16 ? 16 : decay;
}

void cns_fast_status_get(const cns_arith *A, cns_fast_status *status)
{
    status->raised = A->F->raised;
    status->raised_series = A->F->raised_series;
    status->singular = A->F->singular;
}

void cns_fast_sum(cns_arith *A, mpfr_t y, int a, int n, const mpfr_t tau)
{
    cns_fx_sum(A->F, y, a, n, tau);
}

static bool slope(cns_arith *A, mpfr_t y, double *largest_log2, int a, int n, const mpfr_t tau)
{
    if (n > FX_MAX_SLOPE)
        return false;
    cns_fx_slope(A->F, y, largest_log2, a, n, tau);
    return true;
}

/* Series take the block exponents that would have suited the last expansion. One that failed, or whose H was
 * rather different, tells nothing: they are then chosen anew, by the first coefficients. */
static void begin(cns_arith *A, double H)
{
    if (H > 1.5 * A->F->H || A->F->H > 1.5 * H || A->F->singular || A->F->raised > 64)
        for (int i = 0; i < A->F->n_series; i++)
            if (!A->F->series[i].constant) {
                A->F->series[i].stored = 0;
                A->F->series[i].live = false;
            }
    for (int i = 0; i < A->F->n_series; i++)
        A->level[i] = LONG_MIN;
    cns_fx_begin(A->F, H);
    frexp(H, &A->step_bits);
}

static void get(const cns_arith *A, mpfr_t y, int a, int k)
{
    cns_fx_get(A->F, y, a, k);
}

static void set(cns_arith *A, int w, int k, const mpfr_t y, bool keep)
{
    cns_fx_set(A->F, w, k, y, keep);
}

static double get_2exp(const cns_arith *A, long *e, int a, int k)
{
    return cns_fx_get_2exp(A->F, e, a, k);
}

static void leading(const cns_arith *A, double *m, long *e, int a, int n)
{
    cns_fx_leading(A->F, m, e, a, n);
}

/* A term with this exponent is added to the accumulator. */
static void at_least(cns_arith *A, long level)
{
    A->now = most(A->now, level);
}

static long exponent(const cns_arith *A, int a)
{
    return A->F->series[a].exp;
}

/* What a primitive does to the levels, after it was called with arguments x. */
static inline void level_of(cns_arith *A, cns_primitive primitive, const int *x)
{
    switch (primitive) {
    case CNS_PRIMITIVE_ZERO:
        A->now = LONG_MIN;
        break;
    case CNS_PRIMITIVE_COEF: {
        int bits = 0; /* of |weight|, less one */
        for (int size = x[0] < 0 ? -x[0] : x[0]; size > 1; size >>= 1)
            bits++;
        at_least(A, exponent(A, x[1]) + bits);
        break;
    }
    case CNS_PRIMITIVE_SCALED:
        at_least(A, exponent(A, x[1]) + exponent(A, x[2]));
        break;
    case CNS_PRIMITIVE_CONV:
        at_least(A, exponent(A, x[1]) + exponent(A, x[2]) + 2);
        break;
    case CNS_PRIMITIVE_SQUARE:
        at_least(A, 2 * exponent(A, x[1]) + 2);
        break;
    case CNS_PRIMITIVE_STORE:
    case CNS_PRIMITIVE_STORE_RATIO:
        settle(A, x[0], 0);
        break;
    case CNS_PRIMITIVE_STORE_SCALED:
        settle(A, x[0], exponent(A, x[2]));
        break;
    case CNS_PRIMITIVE_STORE_OVER:
        settle(A, x[0], 1 - A->F->reciprocal[x[2]].divisor_exp - x[4]);
        break;
    case CNS_PRIMITIVE_STORE_NEXT:
        A->integrated[x[0]] = true;
        settle(A, x[0], A->step_bits + (x[2] < 0 ? 0 : exponent(A, x[2])));
        break;
    }
}

#define PRIMITIVE(KIND, name, n, ...)                                                                        \
    static void name(cns_arith *A CNS_INTS_##n(__VA_ARGS__))                                                 \
    {                                                                                                        \
        A->ops->name(A->F CNS_NAMES_##n(__VA_ARGS__));                                                       \
        level_of(A, CNS_PRIMITIVE_##KIND, CNS_ARRAY(CNS_NAMES_##n(__VA_ARGS__)));                            \
    }
#include "primitives.def"
#undef PRIMITIVE

/* The same for the calls before the one numbered `end`, made at orders up to k with the same block exponents:
 * levels depend on the order by the weight of an Euler derivative only, which is largest at order k. */
static void levels_of(cns_arith *A, const cns_trace *trace, int end, int k)
{
    for (const cns_trace_call *c = trace->call; c < trace->call + end; c++) {
        int x[CNS_MOST_ARGUMENTS];
        cns_trace_arguments(trace, c, k, x);
        level_of(A, c->primitive, x);
    }
}

/* Where coefficients have few limbs the trace is compiled, and run for as long as block exponents stay. Where
 * one has to be raised, the sum that needs it, and what remains of that order, are made by calls; then the
 * trace is compiled for the new exponents. */
static bool orders(cns_arith *A, const cns_trace *trace, int from, int to)
{
    fx *F = A->F;
    for (int k = from; k < to; k++) {
        int first = 0;
        if (!F->singular && F->rows[k] <= FX_ONE_ROWS && cns_fx_compile(F, trace, k)) {
            const int begun = k;
            const fx_step *stuck = A->ops->run(F, &F->compiled, &k, to);
            if (k > begun)
                levels_of(A, trace, trace->n, k - 1);
            if (!stuck)
                break;
            first = stuck->group;
            levels_of(A, trace, first, k);
        }
        cns_trace_replay(&cns_arith_fast, A, trace, first, k);
        if (k % 8 == 7 && F->singular)
            return false;
    }
    return true;
}

static void function(cns_arith *A, cns_function f, int w, int w2, int a, int b)
{
    fx *F = A->F;
    const mpfr_prec_t prec = (mpfr_prec_t)FX_BITS * (F->limbs + 1);
    mpfr_set_prec(F->g, prec);
    mpfr_set_prec(F->g2, prec);
    cns_fx_get(F, F->g, a, 0);
    if (b >= 0)
        cns_fx_get(F, F->g2, b, 0);
    cns_function_mpfr(f, F->g, F->g2, F->g, F->g2);
    cns_fx_set(F, w, 0, F->g, false);
    if (f == CNS_FN_SINCOS)
        cns_fx_set(F, w2, 0, F->g2, false);
}

/* A bound on the errors of the states' coefficients, W being the window (fixed.h). A convolution of a and b
 * drops less than 2^(e_a + e_b - W) in all, as W has the bits for its many small errors; another operation
 * rounds once, at 2^(e - W). So a coefficient of w is made with an error below 2^(level_w - W), by the
 * definition of its level. The errors of states count as they are. Those of other series reach states by
 * x_{k+1} = H f_k / (k+1): they count H times, or more for tau > 1. From there on an error is a small
 * disturbance of the solution like any other, whose series falls with the order as that of the solution does.
 * The sums of such errors over the orders, and over the few operations between the states and their
 * derivatives, are covered by the bits of the order and by SLACK. Tests measure the errors on random arcs,
 * and hold the arithmetic to this bound. */
enum { SLACK = 5 };

static double noise_log2(const cns_arith *A)
{
    const fx *F = A->F;
    long worst = LONG_MIN;
    int weight, order_bits;
    if (F->singular)
        return HUGE_VAL;
    frexp(F->H * exp2(FX_REACH / 8.0), &weight);
    frexp((double)F->order, &order_bits);
    for (int i = 0; i < F->n_series; i++) {
        if (F->series[i].constant || A->level[i] == LONG_MIN)
            continue;
        long level = A->level[i] + (A->integrated[i] ? 0 : weight);
        worst = level > worst ? level : worst;
    }
    return worst == LONG_MIN ? -HUGE_VAL : (double)(worst - F->window + SLACK + order_bits);
}

/* For proofs. An order n is kept to 2^-52 of its last limb, M = rows(n) limbs, in A_n = a_n 2^(decay n): to
 * less than 2^(e + 1 - W + (decay - r) n) with r = FX_REACH/8, or 2^(e + 1 - W - r n) in a_n, which is 2^(e +
 * 1 - W) for all tau up to 2^r (fixed.h). A convolution misses (N + 1)(L + 1) units of that at 2^(e_a + e_b +
 * 2), and any other primitive one unit of its larger operand or result; a factor, 1/n or a reciprocal, has
 * two limbs more than the sum that it multiplies. Raising a block exponent takes another unit of the new one
 * from every coefficient before. With sizes as below, 2^(e + 2) of a series, all are below 2^-W (N + 1)(L +
 * 2) times the sizes of their terms for each order: 64 primitives, N + 1 orders. */
static double rounding_log2(const cns_arith *A)
{
    enum { PRIMITIVES_LOG2 = 10 };
    const fx *F = A->F;
    const double orders = F->order + 1;
    return PRIMITIVES_LOG2 + log2(orders) * 2 + log2(F->max_limbs + 2) - (double)F->window;
}

/* |a_k| <= 2^(e - decay k), and tau^k <= 2^(k r): the sum over k is below 2^e / (1 - 2^(r - 1)) < 2.5 2^e. */
static long size_log2(const cns_arith *A, int a)
{
    enum { NOTHING = -(1 << 24) };
    return A->F->series[a].live ? A->F->series[a].exp + 2 : NOTHING;
}

const cns_arith_ops cns_arith_fast = {
    .name = "fast",
    .in_steps = true,
    .reach_log2 = FX_REACH / 8.0,
    .noise_log2 = noise_log2,
    .rounding_log2 = rounding_log2,
    .size_log2 = size_log2,
    .set_precision = cns_fast_set_precision,
    .set_decay = cns_fast_set_decay,
    .sum = cns_fast_sum,
    .slope = slope,
    .create = create,
    .destroy = destroy,
    .bytes = bytes,
    .begin = begin,
    .get = get,
    .set = set,
    .get_2exp = get_2exp,
    .leading = leading,
    .orders = orders,
    .function = function,
#define PRIMITIVE(KIND, name, n, ...) .name = name,
#include "primitives.def"
#undef PRIMITIVE
};
