/* Jets: every operation on power series against naive oracles and identities.
 *
 * A random series u enters a program as the first of a chain of states, s_j' = s_{j+1}, with s_j(0) = j! u_j.
 * An operation's series is read from a quadrature: z' = w gives z_{k+1} = H w_k / (k+1). The oracle is the
 * composition f(u_0 + d) = sum f^(j)(u_0)/j! d^j, in many more bits and with plain products: it shares no
 * recurrence with the library. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "problem.h"
#include "taylor/program_internal.h"

enum { ORDER = 16, ORACLE_BITS = 900 };

/* Truncated series, coefficients 0..n, for the oracle. */

static void series_product(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n) /* w may be a or b */
{
    mpfr_t *c = cns_vector_xnew(n + 1, ORACLE_BITS);
    mpfr_t term;
    mpfr_init2(term, ORACLE_BITS);
    for (int i = 0; i <= n; i++)
        for (int j = 0; i + j <= n; j++) {
            mpfr_mul(term, a[i], b[j], MPFR_RNDN);
            mpfr_add(c[i + j], c[i + j], term, MPFR_RNDN);
        }
    for (int k = 0; k <= n; k++)
        mpfr_set(w[k], c[k], MPFR_RNDN);
    mpfr_clear(term);
    cns_vector_free(c);
}

/* w = sum_j f[j] (u - u_0)^j. */
static void series_compose(mpfr_t *w, mpfr_t *f, mpfr_t *u, int n)
{
    mpfr_t *d = cns_vector_xnew(n + 1, ORACLE_BITS), *sum = cns_vector_xnew(n + 1, ORACLE_BITS);
    for (int k = 1; k <= n; k++)
        mpfr_set(d[k], u[k], MPFR_RNDN);
    mpfr_set(sum[0], f[n], MPFR_RNDN);
    for (int j = n - 1; j >= 0; j--) {
        series_product(sum, sum, d, n);
        mpfr_add(sum[0], sum[0], f[j], MPFR_RNDN);
    }
    for (int k = 0; k <= n; k++)
        mpfr_set(w[k], sum[k], MPFR_RNDN);
    cns_vector_free(d);
    cns_vector_free(sum);
}

/* u^(p/q): f[j+1] = f[j] (p/q - j) / ((j+1) u_0). */
static void series_power(mpfr_t *w, mpfr_t *u, int n, long p, long q)
{
    mpfr_t *f = cns_vector_xnew(n + 1, ORACLE_BITS);
    mpfr_t x;
    mpfr_init2(x, ORACLE_BITS);
    mpfr_set_si(x, p, MPFR_RNDN);
    mpfr_div_si(x, x, q, MPFR_RNDN);
    if (q == 1)
        mpfr_pow_si(f[0], u[0], p, MPFR_RNDN);
    else
        mpfr_pow(f[0], u[0], x, MPFR_RNDN);
    for (int j = 0; j < n; j++) {
        mpfr_mul(f[j + 1], f[j], x, MPFR_RNDN);
        mpfr_div(f[j + 1], f[j + 1], u[0], MPFR_RNDN);
        mpfr_div_ui(f[j + 1], f[j + 1], (unsigned long)j + 1, MPFR_RNDN);
        mpfr_sub_ui(x, x, 1, MPFR_RNDN);
    }
    series_compose(w, f, u, n);
    mpfr_clear(x);
    cns_vector_free(f);
}

/* exp, or with quarter turns: sine (0), cosine (1). */
static void series_sine(mpfr_t *w, mpfr_t *u, int n, int turns)
{
    mpfr_t *f = cns_vector_xnew(n + 1, ORACLE_BITS);
    mpfr_t s, c;
    mpfr_inits2(ORACLE_BITS, s, c, (mpfr_ptr)0);
    mpfr_sin_cos(s, c, u[0], MPFR_RNDN);
    for (int j = 0; j <= n; j++) {
        int turn = (turns + j) % 4;
        mpfr_set(f[j], turn % 2 ? c : s, MPFR_RNDN);
        if (turn >= 2)
            mpfr_neg(f[j], f[j], MPFR_RNDN);
        for (int i = 2; i <= j; i++)
            mpfr_div_ui(f[j], f[j], (unsigned long)i, MPFR_RNDN);
    }
    series_compose(w, f, u, n);
    mpfr_clears(s, c, (mpfr_ptr)0);
    cns_vector_free(f);
}

static void series_exp(mpfr_t *w, mpfr_t *u, int n)
{
    mpfr_t *f = cns_vector_xnew(n + 1, ORACLE_BITS);
    mpfr_exp(f[0], u[0], MPFR_RNDN);
    for (int j = 1; j <= n; j++)
        mpfr_div_ui(f[j], f[j - 1], (unsigned long)j, MPFR_RNDN);
    series_compose(w, f, u, n);
    cns_vector_free(f);
}

static void series_log(mpfr_t *w, mpfr_t *u, int n)
{
    mpfr_t *f = cns_vector_xnew(n + 1, ORACLE_BITS);
    mpfr_t x;
    mpfr_init2(x, ORACLE_BITS);
    mpfr_log(f[0], u[0], MPFR_RNDN);
    mpfr_set_si(x, -1, MPFR_RNDN);
    for (int j = 1; j <= n; j++) {
        mpfr_div(x, x, u[0], MPFR_RNDN);
        mpfr_neg(x, x, MPFR_RNDN);
        mpfr_div_ui(f[j], x, (unsigned long)j, MPFR_RNDN);
    }
    series_compose(w, f, u, n);
    mpfr_clear(x);
    cns_vector_free(f);
}

/* The operations: how a program is built from nodes a and b, and the oracle. */

typedef struct operation {
    const char *name;
    cns_node (*build)(cns_program *p, cns_node a, cns_node b);
    void (*oracle)(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n);
    bool positive; /* a_0 must be */
    const char *smooth;
} operation;

#define BINARY(name)                                                                                         \
    static cns_node build_##name(cns_program *p, cns_node a, cns_node b)                                     \
    {                                                                                                        \
        return cns_##name(p, a, b);                                                                          \
    }
#define UNARY(name)                                                                                          \
    static cns_node build_##name(cns_program *p, cns_node a, cns_node b)                                     \
    {                                                                                                        \
        (void)b;                                                                                             \
        return cns_##name(p, a);                                                                             \
    }
BINARY(add)
BINARY(sub)
BINARY(mul)
BINARY(div)
BINARY(hypot)
UNARY(neg)
UNARY(sqr)
UNARY(sqrt)
UNARY(exp)
UNARY(log)
UNARY(abs)

static void oracle_add(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    for (int k = 0; k <= n; k++)
        mpfr_add(w[k], a[k], b[k], MPFR_RNDN);
}
static void oracle_sub(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    for (int k = 0; k <= n; k++)
        mpfr_sub(w[k], a[k], b[k], MPFR_RNDN);
}
static void oracle_neg(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    (void)b;
    for (int k = 0; k <= n; k++)
        mpfr_neg(w[k], a[k], MPFR_RNDN);
}
static void oracle_sqr(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    (void)b;
    series_product(w, a, a, n);
}
static void oracle_div(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    series_power(w, b, n, -1, 1);
    series_product(w, w, a, n);
}
static void oracle_sqrt(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    (void)b;
    series_power(w, a, n, 1, 2);
}
static void oracle_hypot(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    mpfr_t *q = cns_vector_xnew(n + 1, ORACLE_BITS);
    series_product(q, a, a, n);
    series_product(w, b, b, n);
    oracle_add(q, q, w, n);
    series_power(w, q, n, 1, 2);
    cns_vector_free(q);
}
static void oracle_sin(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    (void)b;
    series_sine(w, a, n, 0);
}
static void oracle_cos(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    (void)b;
    series_sine(w, a, n, 1);
}
static void oracle_exp(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    (void)b;
    series_exp(w, a, n);
}
static void oracle_log(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    (void)b;
    series_log(w, a, n);
}
static void oracle_abs(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    (void)b;
    for (int k = 0; k <= n; k++)
        mpfr_mul_si(w[k], a[k], mpfr_sgn(a[0]), MPFR_RNDN);
}
static void oracle_smooth_abs(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    (void)b;
    mpfr_t *q = cns_vector_xnew(n + 1, ORACLE_BITS), eps;
    mpfr_init2(eps, ORACLE_BITS);
    mpfr_set_ui(eps, 3, MPFR_RNDN);
    mpfr_div_ui(eps, eps, 7, MPFR_RNDN);
    mpfr_sqr(eps, eps, MPFR_RNDN);
    series_product(q, a, a, n);
    mpfr_add(q[0], q[0], eps, MPFR_RNDN);
    series_power(w, q, n, 1, 2);
    mpfr_clear(eps);
    cns_vector_free(q);
}
static cns_node build_sin(cns_program *p, cns_node a, cns_node b)
{
    cns_node s, c;
    (void)b;
    cns_sincos(p, a, &s, &c);
    return s;
}
static cns_node build_cos(cns_program *p, cns_node a, cns_node b)
{
    cns_node s, c;
    (void)b;
    cns_sincos(p, a, &s, &c);
    return c;
}
static cns_node build_pow(cns_program *p, cns_node a, cns_node b)
{
    (void)b;
    return cns_pow(p, a, cns_constant(p, "-7/3"));
}
static void oracle_pow(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    (void)b;
    series_power(w, a, n, -7, 3);
}
static cns_node build_pow_3(cns_program *p, cns_node a, cns_node b)
{
    (void)b;
    return cns_pow(p, a, cns_constant(p, "3"));
}
static void oracle_pow_3(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    (void)b;
    series_product(w, a, a, n);
    series_product(w, w, a, n);
}
static cns_node build_scale(cns_program *p, cns_node a, cns_node b)
{
    return cns_mul(p, cns_constant(p, "-5/3"), cns_sub(p, a, cns_div(p, b, cns_constant(p, "7"))));
}
static void oracle_scale(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    for (int k = 0; k <= n; k++) {
        mpfr_div_ui(w[k], b[k], 7, MPFR_RNDN);
        mpfr_sub(w[k], a[k], w[k], MPFR_RNDN);
        mpfr_mul_si(w[k], w[k], -5, MPFR_RNDN);
        mpfr_div_ui(w[k], w[k], 3, MPFR_RNDN);
    }
}
static cns_node build_signed(cns_program *p, cns_node a, cns_node b)
{
    return cns_signed(p, cns_abs(p, b), a);
}
static void oracle_signed(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    for (int k = 0; k <= n; k++)
        mpfr_mul_si(w[k], a[k], mpfr_sgn(b[0]), MPFR_RNDN);
}
static cns_node build_drag(cns_program *p, cns_node a, cns_node b)
{
    (void)b;
    return cns_mul(p, a, cns_abs(p, a));
}
static void oracle_drag(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    oracle_sqr(w, a, b, n);
    if (mpfr_sgn(a[0]) < 0)
        oracle_neg(w, w, b, n);
}
/* Folded sums and products under every kind of user. */
static cns_node build_nested(cns_program *p, cns_node a, cns_node b)
{
    cns_node inner = cns_sub(p, cns_mul(p, a, b), cns_neg(p, cns_add(p, cns_sqr(p, a), cns_sqr(p, b))));
    return cns_div(p, cns_sub(p, cns_mul(p, cns_constant(p, "3"), a), inner), b);
}
static void oracle_nested(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    mpfr_t *x = cns_vector_xnew(n + 1, ORACLE_BITS);
    series_product(w, a, b, n);
    series_product(x, a, a, n);
    oracle_add(w, w, x, n);
    series_product(x, b, b, n);
    oracle_add(w, w, x, n);
    for (int k = 0; k <= n; k++) {
        mpfr_mul_ui(x[k], a[k], 3, MPFR_RNDN);
        mpfr_sub(x[k], x[k], w[k], MPFR_RNDN);
    }
    oracle_div(w, x, b, n);
    cns_vector_free(x);
}
/* Aliased operands. */
static cns_node build_a_plus_a(cns_program *p, cns_node a, cns_node b)
{
    (void)b;
    return cns_add(p, a, a);
}
static void oracle_a_plus_a(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    (void)b;
    oracle_add(w, a, a, n);
}
static cns_node build_a_minus_a(cns_program *p, cns_node a, cns_node b)
{
    (void)b;
    return cns_sub(p, a, a);
}
static void oracle_a_minus_a(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    (void)b;
    oracle_sub(w, a, a, n);
}
static cns_node build_a_times_a(cns_program *p, cns_node a, cns_node b)
{
    (void)b;
    return cns_mul(p, a, a);
}
static cns_node build_a_over_a(cns_program *p, cns_node a, cns_node b)
{
    (void)b;
    return cns_div(p, a, a);
}
static void oracle_a_over_a(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    oracle_a_minus_a(w, a, b, n);
    mpfr_set_ui(w[0], 1, MPFR_RNDN);
}
static cns_node build_hypot_aa(cns_program *p, cns_node a, cns_node b)
{
    (void)b;
    return cns_hypot(p, a, a);
}
static void oracle_hypot_aa(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n)
{
    (void)b;
    oracle_hypot(w, a, a, n);
}

static const operation operations[] = {
    {"add", build_add, oracle_add, false, NULL},
    {"sub", build_sub, oracle_sub, false, NULL},
    {"neg", build_neg, oracle_neg, false, NULL},
    {"mul", build_mul, NULL, false, NULL},
    {"sqr", build_sqr, oracle_sqr, false, NULL},
    {"scale", build_scale, oracle_scale, false, NULL},
    {"div", build_div, oracle_div, false, NULL},
    {"sqrt", build_sqrt, oracle_sqrt, true, NULL},
    {"hypot", build_hypot, oracle_hypot, false, NULL},
    {"sin", build_sin, oracle_sin, false, NULL},
    {"cos", build_cos, oracle_cos, false, NULL},
    {"exp", build_exp, oracle_exp, false, NULL},
    {"log", build_log, oracle_log, true, NULL},
    {"pow", build_pow, oracle_pow, true, NULL},
    {"cube", build_pow_3, oracle_pow_3, true, NULL},
    {"abs", build_abs, oracle_abs, false, NULL},
    {"smooth abs", build_abs, oracle_smooth_abs, false, "3/7"},
    {"signed", build_signed, oracle_signed, false, NULL},
    {"|a| a", build_drag, oracle_drag, false, NULL},
    {"nested", build_nested, oracle_nested, false, NULL},
    {"a+a", build_a_plus_a, oracle_a_plus_a, false, NULL},
    {"a-a", build_a_minus_a, oracle_a_minus_a, false, NULL},
    {"a*a", build_a_times_a, oracle_sqr, false, NULL},
    {"a/a", build_a_over_a, oracle_a_over_a, false, NULL},
    {"hypot(a,a)", build_hypot_aa, oracle_hypot_aa, false, NULL},
};
enum { OPERATIONS = COUNT(operations) };

static const struct {
    const cns_arith_ops *ops;
    mpfr_prec_t prec;
} arithmetics[] = {
    {&cns_arith_mpfr, 53}, {&cns_arith_mpfr, 300}, {&cns_arith_double, 53}, {&cns_arith_libm, 53}};
enum { ARITHMETICS = COUNT(arithmetics) };

/* The states of a program under test: chain a, chain b, the time, two quadratures. */
enum { CHAIN = ORDER + 2, A = 0, B = CHAIN, TIME = 2 * CHAIN, Z, Z2, STATES };

/* z' = t^ahead op(a, b); z2' the same, so that the operation is stored, or once more on its own. */
static cns_program *program_of(const operation *op, int ahead, bool stored)
{
    cns_program *p = program_new(STATES, op->smooth);
    cns_node w = op->build(p, cns_state(p, A), cns_state(p, B)), zero = cns_constant(p, "0");
    for (int i = 0; i < CHAIN; i++)
        for (int c = 0; c <= B; c += B)
            cns_derivative(p, c + i, i + 1 < CHAIN ? cns_state(p, c + i + 1) : zero);
    for (int i = 0; i < ahead; i++)
        w = cns_mul(p, i ? cns_state(p, TIME) : w, i ? w : cns_state(p, TIME));
    cns_derivative(p, TIME, cns_constant(p, "1"));
    cns_derivative(p, Z, w);
    cns_derivative(p, Z2, stored ? w : zero);
    return finished(p);
}

/* Random coefficients k < terms of size 2^-k behind `zeros` zeros, the first of them in +-[1, 2), into the
 * chain of the jet and, exactly, into u. */
static void set_random_series(cns_jet *J, int chain, mpfr_t *u, int zeros, int terms, int sign,
                              const cns_arith_ops *ops, mpfr_prec_t prec, uint64_t *s)
{
    mpfr_t x;
    mpfr_init2(x, ops == &cns_arith_mpfr ? prec : 53);
    for (int k = 0; k < CHAIN; k++) {
        double r = k < zeros || k >= terms ? 0 : 2 * test_random_unit(s) - 1;
        if (k == zeros)
            r = (1 + test_random_unit(s)) * (sign ? sign : r < 0 ? -1 : 1);
        mpfr_set_d(x, ldexp(r, -k), MPFR_RNDN);
        for (int j = 2; j <= k; j++)
            mpfr_mul_ui(x, x, (unsigned long)j, MPFR_RNDN);
        cns_jet_set_state(J, chain + k, x);
        mpfr_set(u[k], x, MPFR_RNDN);
        for (int j = 2; j <= k; j++)
            mpfr_div_ui(u[k], u[k], (unsigned long)j, MPFR_RNDN);
    }
    mpfr_clear(x);
}

static void shift_down(mpfr_t *u, int by, int n)
{
    for (int k = 0; k <= n; k++) {
        if (k + by <= n)
            mpfr_set(u[k], u[k + by], MPFR_RNDN);
        else
            mpfr_set_zero(u[k], 1);
    }
}

/* Coefficients 0..n of the operation, from those of state z, undoing the quadrature and the time scale. */
static void read_series(mpfr_t *w, const cns_jet *J, int z, int n, int ahead, double H)
{
    for (int k = 0; k <= n; k++) {
        cns_jet_coefficient(J, w[k], z, k + 1 + ahead);
        mpfr_mul_ui(w[k], w[k], (unsigned long)(k + 1 + ahead), MPFR_RNDN);
        for (int j = 0; j < k + 1 + ahead; j++)
            mpfr_div_d(w[k], w[k], H, MPFR_RNDN);
    }
}

/* Coefficients agree to a few units of the last place of the largest 2^k |w_k|, of which k takes 2^-k. */
static void check_series(mpfr_t *w, mpfr_t *oracle, int n, double bits, const char *what)
{
    double largest = 0;
    for (int k = 0; k <= n; k++)
        largest = fmax(largest, log2_of(oracle[k]) + k);
    for (int k = 0; k <= n; k++)
        check_close(w[k], oracle[k], largest + bits - k, "%s, coefficient %d", what, k);
}

/* One operation in one arithmetic: orders from the least, scales of time, folded and stored. */
START_TEST(agrees_with_the_oracle)
{
    static const int orders[] = {1, 2, 3, 10, ORDER + 1};
    static const double scales[] = {1, 0.375, 3};
    const operation *op = &operations[_i % OPERATIONS];
    const cns_arith_ops *ops = arithmetics[_i / OPERATIONS].ops;
    mpfr_prec_t prec = arithmetics[_i / OPERATIONS].prec;
    uint64_t s = test_seed() + (uint64_t)_i;
    mpfr_t *a = cns_vector_xnew(CHAIN, ORACLE_BITS), *b = cns_vector_xnew(CHAIN, ORACLE_BITS);
    mpfr_t *w = cns_vector_xnew(CHAIN, ORACLE_BITS), *oracle = cns_vector_xnew(CHAIN, ORACLE_BITS);
    mpfr_t x;
    mpfr_init2(x, prec);
    mpfr_set_zero(x, 1);
    for (int stored = 0; stored < 2; stored++) {
        cns_program *p = program_of(op, 0, stored);
        cns_jet *J = jet_new(p, ops, ORDER + 1, prec);
        for (int turn = 0; turn < 15; turn++) { /* the same jet again and again: nothing is left over */
            int order = orders[turn % 5];
            double H = scales[turn / 5];
            char what[128];
            cns_error err;
            cns_jet_begin(J, H);
            set_random_series(J, A, a, 0, CHAIN, op->positive, ops, prec, &s);
            set_random_series(J, B, b, 0, CHAIN, 0, ops, prec, &s);
            for (int i = TIME; i < STATES; i++)
                cns_jet_set_state(J, i, x);
            check_ok(cns_jet_expand(J, order, &err), &err);
            ck_assert_int_eq(cns_jet_order(J), order);
            if (op->oracle)
                op->oracle(oracle, a, b, ORDER);
            else
                series_product(oracle, a, b, ORDER);
            snprintf(what, sizeof what, "%s, %s, H = %g, order %d%s", op->name, ops->name, H, order,
                     stored ? ", stored" : "");
            for (int z = Z; z <= Z2; z++)
                if (z == Z || stored) {
                    read_series(w, J, z, order - 1, 0, H);
                    check_series(w, oracle, order - 1, 16.0 - (double)prec, what);
                }
        }
        cns_jet_free(J);
        cns_program_free(p);
    }
    mpfr_clear(x);
    cns_vector_free(a);
    cns_vector_free(b);
    cns_vector_free(w);
    cns_vector_free(oracle);
}
END_TEST

/* Operands that start at order 1 or more: with a and b divided by t^zeros the operation is regular, and
 * op(a, b) = t^shift op(regular). Once z' = op, and once z' = t^ahead op, which can begin without it. */
static const struct {
    const char *name;
    cns_node (*build)(cns_program *p, cns_node a, cns_node b);
    void (*oracle)(mpfr_t *w, mpfr_t *a, mpfr_t *b, int n);
    int zeros_a, zeros_b; /* of the operands */
    int down_a, down_b;   /* by so much the oracle's are shifted */
    int shift;            /* of the result */
    int ahead;
    int sign_a;
} leading[] = {
    {"a/b, 1 and 1", build_div, oracle_div, 1, 1, 1, 1, 0, 1, 0},
    {"a/b, 2 and 2", build_div, oracle_div, 2, 2, 2, 2, 0, 2, 0},
    {"a/b, 3 and 3", build_div, oracle_div, 3, 3, 3, 3, 0, 3, 0},
    {"a/b, 3 and 1", build_div, oracle_div, 3, 1, 3, 1, 2, 1, 0},
    {"a/b, 2 and 0", build_div, oracle_div, 2, 0, 0, 0, 0, 0, 0},
    {"a/a, 1", build_a_over_a, oracle_a_over_a, 1, 0, 0, 0, 0, 1, 0},
    {"sqrt, 2", build_sqrt, oracle_sqrt, 2, 0, 2, 0, 1, 2, 1},
    {"sqrt, 4", build_sqrt, oracle_sqrt, 4, 0, 4, 0, 2, 4, 1},
    {"hypot, 1 and 2", build_hypot, oracle_hypot, 1, 2, 1, 1, 1, 1, 0},
    {"hypot, 2 and 1", build_hypot, oracle_hypot, 2, 1, 1, 1, 1, 1, 0},
    {"hypot, 1 and 1", build_hypot, oracle_hypot, 1, 1, 1, 1, 1, 1, 0},
    {"hypot, 2 and 2", build_hypot, oracle_hypot, 2, 2, 2, 2, 2, 2, 0},
    {"hypot, 0 and 3", build_hypot, oracle_hypot, 0, 3, 0, 0, 0, 0, 0},
    {"product, 2 and 1", build_mul, NULL, 2, 1, 0, 0, 0, 0, 0},
    {"square, 2", build_sqr, oracle_sqr, 2, 0, 0, 0, 0, 0, 0},
    {"sin, 1", build_sin, oracle_sin, 1, 0, 0, 0, 0, 0, 0},
    {"cos, 2", build_cos, oracle_cos, 2, 0, 0, 0, 0, 0, 0},
    {"exp, 3", build_exp, oracle_exp, 3, 0, 0, 0, 0, 0, 0},
    {"smooth abs, 1", build_abs, oracle_smooth_abs, 1, 0, 0, 0, 0, 0, 0},
};
enum { LEADING = COUNT(leading) };

START_TEST(runs_ahead_of_leading_zeros)
{
    const int n = 8;
    const cns_arith_ops *ops = arithmetics[_i / LEADING % ARITHMETICS].ops;
    mpfr_prec_t prec = arithmetics[_i / LEADING % ARITHMETICS].prec;
    int row = _i % LEADING, with_time = _i / LEADING / ARITHMETICS,
        ahead = with_time ? leading[row].ahead : 0;
    uint64_t s = test_seed() + 7777 + (uint64_t)_i;
    operation op = {.name = leading[row].name, .build = leading[row].build};
    if (leading[row].oracle == oracle_smooth_abs)
        op.smooth = "3/7";
    mpfr_t *a = cns_vector_xnew(CHAIN, ORACLE_BITS), *b = cns_vector_xnew(CHAIN, ORACLE_BITS);
    mpfr_t *w = cns_vector_xnew(CHAIN, ORACLE_BITS), *oracle = cns_vector_xnew(CHAIN, ORACLE_BITS);
    mpfr_t x;
    mpfr_init2(x, prec);
    mpfr_set_zero(x, 1);
    cns_program *p = program_of(&op, ahead, true);
    cns_jet *J = jet_new(p, ops, ORDER, prec);
    for (int turn = 0; turn < 4; turn++) {
        cns_error err;
        double H = turn % 2 ? 0.75 : 1;
        cns_jet_begin(J, H);
        set_random_series(J, A, a, leading[row].zeros_a, CHAIN, leading[row].sign_a, ops, prec, &s);
        set_random_series(J, B, b, leading[row].zeros_b, CHAIN, 0, ops, prec, &s);
        for (int i = TIME; i < STATES; i++)
            cns_jet_set_state(J, i, x);
        check_ok(cns_jet_expand(J, ORDER, &err), &err);
        ck_assert_int_ge(cns_jet_order(J), ORDER - 4);
        ck_assert_int_le(cns_jet_order(J), ORDER);
        shift_down(a, leading[row].down_a, CHAIN - 1);
        shift_down(b, leading[row].down_b, CHAIN - 1);
        if (leading[row].oracle)
            leading[row].oracle(oracle, a, b, n);
        else
            series_product(oracle, a, b, n);
        read_series(w, J, Z, n, ahead, H);
        for (int k = 0; k < leading[row].shift; k++)
            ck_assert_msg(mpfr_zero_p(w[k]), "%s: coefficient %d is not zero", op.name, k);
        shift_down(w, leading[row].shift, n);
        check_series(w, oracle, n - leading[row].shift, 18.0 - (double)prec, op.name);
    }
    cns_jet_free(J);
    cns_program_free(p);
    mpfr_clear(x);
    cns_vector_free(a);
    cns_vector_free(b);
    cns_vector_free(w);
    cns_vector_free(oracle);
}
END_TEST

/* |u| from a start on a zero: the sign is that of the first coefficient that is not zero. */
START_TEST(the_sign_of_abs_is_the_first_coefficients)
{
    const cns_arith_ops *ops = arithmetics[_i].ops;
    mpfr_prec_t prec = arithmetics[_i].prec;
    uint64_t s = test_seed() + 99 + (uint64_t)_i;
    operation op = {.build = build_abs};
    mpfr_t *a = cns_vector_xnew(CHAIN, ORACLE_BITS), *b = cns_vector_xnew(CHAIN, ORACLE_BITS);
    mpfr_t *w = cns_vector_xnew(CHAIN, ORACLE_BITS);
    mpfr_t x;
    mpfr_init2(x, prec);
    mpfr_set_zero(x, 1);
    cns_program *p = program_of(&op, 0, true);
    cns_jet *J = jet_new(p, ops, ORDER, prec);
    for (int zeros = 0; zeros < 5; zeros++)
        for (int sign = -1; sign <= 1; sign += 2) {
            cns_error err;
            cns_watch watch;
            cns_jet_begin(J, 1);
            set_random_series(J, A, a, zeros, 8, sign, ops, prec, &s);
            set_random_series(J, B, b, 0, 8, 0, ops, prec, &s);
            for (int i = TIME; i < STATES; i++)
                cns_jet_set_state(J, i, x);
            check_ok(cns_jet_expand(J, ORDER, &err), &err);
            read_series(w, J, Z, ORDER - 1, 0, 1);
            for (int k = 0; k < ORDER; k++)
                mpfr_mul_si(a[k], a[k], sign, MPFR_RNDN);
            check_series(w, a, ORDER - 1, 8.0 - (double)prec, "abs");
            ck_assert_int_eq(cns_jet_watched(J), 1);
            ck_assert(cns_jet_watch(J, 0, &watch));
            ck_assert_int_eq(watch.zeros, zeros);
            ck_assert_int_eq(watch.state, A);
            ck_assert_int_eq(watch.kind, CNS_WATCH_KINK);
        }
    cns_jet_free(J);
    cns_program_free(p);
    mpfr_clear(x);
    cns_vector_free(a);
    cns_vector_free(b);
    cns_vector_free(w);
}
END_TEST

/* u = a - b, where a' = (z z) y + t and b' = z (z y), begins with u_0 = 0 and u_1 the difference of
 * roundings: the sign of |u| is that of u_2, which is t'. */
START_TEST(noise_has_no_sign)
{
    enum { U, V, Q, Y, T, W, ALL };
    const mpfr_prec_t prec = arithmetics[_i].prec;
    uint64_t s = test_seed() + 97 + (uint64_t)_i;
    int opposite = 0;
    mpfr_t x, w;
    mpfr_inits2(prec, x, w, (mpfr_ptr)0);
    for (int sign = -1; sign <= 1; sign += 2) {
        cns_program *p = program_new(ALL, NULL);
        cns_node z = cns_state(p, Q), y = cns_state(p, Y);
        cns_derivative(p, U, cns_add(p, cns_mul(p, cns_sqr(p, z), y), cns_state(p, T)));
        cns_derivative(p, V, cns_mul(p, z, cns_mul(p, z, y)));
        cns_derivative(p, Q, cns_constant(p, "0"));
        cns_derivative(p, Y, cns_constant(p, "0"));
        cns_derivative(p, T, cns_constant(p, sign < 0 ? "-1" : "1"));
        cns_derivative(p, W, cns_abs(p, cns_sub(p, cns_state(p, U), cns_state(p, V))));
        cns_jet *J = jet_new(finished(p), arithmetics[_i].ops, 4, prec);
        for (int trial = 0; trial < 100; trial++) {
            cns_error err;
            cns_jet_begin(J, 1);
            for (int i = 0; i < ALL; i++) {
                mpfr_set_d(x, i == Q || i == Y ? 1 + test_random_unit(&s) : 0, MPFR_RNDN);
                mpfr_sqrt(x, x, MPFR_RNDN); /* all bits in use */
                cns_jet_set_state(J, i, x);
            }
            check_ok(cns_jet_expand(J, 4, &err), &err);
            cns_jet_coefficient(J, x, U, 1);
            cns_jet_coefficient(J, w, V, 1);
            mpfr_sub(x, x, w, MPFR_RNDN);
            opposite += mpfr_sgn(x) == -sign;
            cns_jet_coefficient(J, w, W, 3); /* |u|_2 / 3, and u_2 = t' / 2 */
            ck_assert_double_eq_tol(mpfr_get_d(w, MPFR_RNDN), 1.0 / 6, 1e-9);
        }
        cns_jet_free(J);
        cns_program_free(p);
    }
    ck_assert_int_gt(opposite, 10);
    mpfr_clears(x, w, (mpfr_ptr)0);
}
END_TEST

/* sign(b) a where b starts on a zero and a does not: the sign belongs to the whole arc, order 0 included. */
START_TEST(signed_holds_from_order_zero)
{
    const cns_arith_ops *ops = arithmetics[_i].ops;
    mpfr_prec_t prec = arithmetics[_i].prec;
    uint64_t s = test_seed() + 98 + (uint64_t)_i;
    operation op = {.build = build_signed};
    mpfr_t *a = cns_vector_xnew(CHAIN, ORACLE_BITS), *b = cns_vector_xnew(CHAIN, ORACLE_BITS);
    mpfr_t *w = cns_vector_xnew(CHAIN, ORACLE_BITS);
    mpfr_t x;
    mpfr_init2(x, prec);
    mpfr_set_zero(x, 1);
    cns_program *p = program_of(&op, 0, true);
    cns_jet *J = jet_new(p, ops, ORDER, prec);
    for (int zeros = 0; zeros < 3; zeros++) {
        cns_error err;
        cns_jet_begin(J, 1);
        set_random_series(J, A, a, 0, 8, 0, ops, prec, &s);
        set_random_series(J, B, b, zeros, 8, -1, ops, prec, &s);
        for (int i = TIME; i < STATES; i++)
            cns_jet_set_state(J, i, x);
        check_ok(cns_jet_expand(J, ORDER, &err), &err);
        read_series(w, J, Z, ORDER - 1, 0, 1);
        for (int k = 0; k < ORDER; k++)
            mpfr_neg(a[k], a[k], MPFR_RNDN);
        check_series(w, a, ORDER - 1, 8.0 - (double)prec, "signed");
    }
    cns_jet_free(J);
    cns_program_free(p);
    mpfr_clear(x);
    cns_vector_free(a);
    cns_vector_free(b);
    cns_vector_free(w);
}
END_TEST

/* Starts at which an operation has no value. a and b are random behind their leading zeros. */
static cns_node build_recip_sin(cns_program *p, cns_node a, cns_node b)
{
    return cns_div(p, b, build_sin(p, a, b));
}
static cns_node build_1_over_0(cns_program *p, cns_node a, cns_node b)
{
    (void)b;
    return cns_div(p, cns_constant(p, "1"), cns_sub(p, a, a));
}
static cns_node build_log_cos(cns_program *p, cns_node a, cns_node b)
{
    return cns_log(p, cns_neg(p, build_cos(p, a, b)));
}

static const struct {
    const char *name, *message;
    cns_node (*build)(cns_program *p, cns_node a, cns_node b);
    int zeros_a, sign_a, zeros_b;
} singular[] = {
    {"b/a at a = 0", "division by zero", build_recip_sin, 1, 0, 0},
    {"b/a, two zeros", "division by zero", build_recip_sin, 2, 0, 1},
    {"1/(a-a)", "", build_1_over_0, 0, 0, 0},
    {"sqrt of a simple zero", "root", build_sqrt, 1, 1, 0},
    {"sqrt of a triple zero", "root", build_sqrt, 3, 1, 0},
    {"sqrt of a negative number", "root of a negative", build_sqrt, 0, -1, 0},
    {"sqrt of minus a square", "root of a negative", build_sqrt, 2, -1, 0},
    {"log of a negative number", "logarithm", build_log, 0, -1, 0},
    {"log of zero", "logarithm", build_log, 1, 1, 0},
    {"log of minus one", "logarithm", build_log_cos, 2, 0, 0},
    {"power of a negative number", "power", build_pow, 0, -1, 0},
    {"power of zero", "power", build_pow, 1, 1, 0},
};
enum { SINGULAR = COUNT(singular) };

START_TEST(says_where_it_is_singular)
{
    const cns_arith_ops *ops = arithmetics[_i / SINGULAR].ops;
    mpfr_prec_t prec = arithmetics[_i / SINGULAR].prec;
    int row = _i % SINGULAR;
    uint64_t s = test_seed() + 31 + (uint64_t)_i;
    operation op = {.build = singular[row].build};
    mpfr_t *a = cns_vector_xnew(CHAIN, ORACLE_BITS);
    mpfr_t x;
    mpfr_init2(x, prec);
    mpfr_set_zero(x, 1);
    for (int ahead = 0; ahead < 2; ahead++) {
        cns_program *p = program_of(&op, ahead, true);
        cns_jet *J = jet_new(p, ops, ORDER, prec);
        cns_error err;
        for (int turn = 0; turn < 2; turn++) {
            cns_jet_begin(J, 1);
            set_random_series(J, A, a, singular[row].zeros_a, CHAIN, singular[row].sign_a, ops, prec, &s);
            set_random_series(J, B, a, singular[row].zeros_b, CHAIN, 0, ops, prec, &s);
            for (int i = TIME; i < STATES; i++)
                cns_jet_set_state(J, i, x);
            err.text[0] = 0;
            ck_assert_msg(cns_jet_expand(J, ORDER, &err) == CNS_NUMERIC, "%s is accepted",
                          singular[row].name);
            ck_assert_int_eq(err.code, CNS_NUMERIC);
            if (!ahead)
                ck_assert_msg(strstr(err.text, singular[row].message) || strstr(err.text, "are singular"),
                              "%s: %s", singular[row].name, err.text);
            /* The jet is as good as new afterwards. */
            cns_jet_begin(J, 1);
            for (int i = 0; i < STATES; i++) {
                mpfr_set_d(x, i == A || i == B ? 0.5 : 0, MPFR_RNDN);
                cns_jet_set_state(J, i, x);
            }
            mpfr_set_zero(x, 1);
            if (row != 2 && singular[row].build != build_log_cos)
                check_ok(cns_jet_expand(J, ORDER, &err), &err);
        }
        cns_jet_free(J);
        cns_program_free(p);
    }
    mpfr_clear(x);
    cns_vector_free(a);
}
END_TEST

/* x = y = 0 for ever: x/y has no value. */
START_TEST(zero_over_zero_is_singular)
{
    cns_program *p = program_new(3, NULL);
    cns_derivative(p, 0, cns_neg(p, cns_state(p, 0)));
    cns_derivative(p, 1, cns_neg(p, cns_state(p, 1)));
    cns_derivative(p, 2, cns_div(p, cns_state(p, 0), cns_state(p, 1)));
    finished(p);
    cns_jet *J = jet_new(p, &cns_arith_mpfr, 8, 100);
    mpfr_t x;
    cns_error err;
    mpfr_init2(x, 100);
    mpfr_set_zero(x, 1);
    cns_jet_begin(J, 1);
    for (int i = 0; i < 3; i++)
        cns_jet_set_state(J, i, x);
    ck_assert_int_eq(cns_jet_expand(J, 8, &err), CNS_NUMERIC);
    mpfr_clear(x);
    cns_jet_free(J);
    cns_program_free(p);
}
END_TEST

static const char *const bad_constants[] = {"div", "log", "sqrt", "pow"};

/* An output without a value leaves the solution alone. */
START_TEST(singular_outputs_are_just_missing)
{
    cns_program *p = program_new(1, NULL);
    cns_node x = cns_state(p, 0);
    cns_derivative(p, 0, cns_constant(p, "1"));
    cns_output(p, cns_div(p, cns_constant(p, "1"), x));
    cns_output(p, cns_log(p, x));
    cns_output(p, cns_sqrt(p, x));
    cns_output(p, cns_exp(p, x));
    cns_output(p, cns_mul(p, x, cns_div(p, cns_constant(p, "1"), x)));
    finished(p);
    cns_jet_spec spec = {.program = p, .ops = &cns_arith_mpfr, .order = 6, .prec = 100, .outputs = true};
    cns_error err;
    mpfr_t y;
    cns_jet *J = cns_jet_new(&spec, &err);
    ck_assert_ptr_nonnull(J);
    mpfr_init2(y, 100);
    for (int x0 = 0; x0 < 3; x0++) {
        mpfr_set_ui(y, x0 == 1, MPFR_RNDN);
        cns_jet_begin(J, 1);
        cns_jet_set_state(J, 0, y);
        check_ok(cns_jet_expand(J, 6, &err), &err);
        cns_jet_coefficient(J, y, 0, 1);
        ck_assert_int_eq(mpfr_cmp_ui(y, 1), 0);
        for (int i = 0; i < 5; i++)
            ck_assert_msg(cns_jet_output(J, y, i) == (x0 == 1 || i == 3), "output %d at %d", i, x0 == 1);
    }
    mpfr_clear(y);
    cns_jet_free(J);
    cns_program_free(p);
}
END_TEST

START_TEST(constants_without_a_value_give_no_jet)
{
    cns_program *p = program_new(1, NULL);
    cns_node zero = cns_sub(p, cns_constant(p, "1"), cns_constant(p, "1")), minus = cns_constant(p, "-1");
    cns_node bad = _i == 0   ? cns_div(p, minus, zero)
                   : _i == 1 ? cns_log(p, minus)
                   : _i == 2 ? cns_sqrt(p, minus)
                             : cns_pow(p, minus, cns_constant(p, "1/2"));
    cns_error err;
    cns_derivative(p, 0, cns_mul(p, bad, cns_state(p, 0)));
    finished(p);
    cns_jet_spec spec = {.program = p, .ops = &cns_arith_mpfr, .order = 4, .prec = 64};
    cns_jet *J = cns_jet_new(&spec, &err);
    ck_assert_msg(!J, "%s", bad_constants[_i]);
    ck_assert_int_eq(err.code, CNS_NUMERIC);
    cns_program_free(p);
}
END_TEST

/* Identities at high order on u = 2 + sin t, v = 2 + cos t (3/2 + half of either where an arc must stay
 * short): each quadrature's derivative vanishes but for coefficient 0. */
enum { U, V, IDENTITIES };

static cns_node identity(cns_program *p, int which, cns_node u, cns_node v)
{
    cns_node s, c, two = cns_constant(p, "2");
    switch (which) {
    case 0:
        cns_sincos(p, u, &s, &c);
        return cns_add(p, cns_sqr(p, s), cns_sqr(p, c));
    case 1:
        return cns_sub(p, cns_exp(p, cns_log(p, u)), u);
    case 2:
        return cns_sub(p, cns_sqr(p, cns_sqrt(p, u)), u);
    case 3:
        return cns_sub(p, cns_mul(p, cns_div(p, u, v), v), u);
    case 4:
        return cns_sub(p, cns_pow(p, u, cns_constant(p, "1/2")), cns_sqrt(p, u));
    case 5:
        return cns_sub(p, cns_mul(p, cns_hypot(p, u, v), cns_hypot(p, u, v)),
                       cns_add(p, cns_sqr(p, u), cns_sqr(p, v)));
    case 6:
        return cns_sub(p, cns_log(p, cns_mul(p, u, v)), cns_add(p, cns_log(p, u), cns_log(p, v)));
    case 7:
        return cns_sub(p, cns_mul(p, cns_exp(p, u), cns_exp(p, v)), cns_exp(p, cns_add(p, u, v)));
    case 8: /* (u+v)^2 - (u-v)^2 - 4 u v */
        return cns_sub(p, cns_sub(p, cns_sqr(p, cns_add(p, u, v)), cns_sqr(p, cns_sub(p, u, v))),
                       cns_mul(p, cns_constant(p, "4"), cns_mul(p, u, v)));
    case 9:
        return cns_sub(p, cns_pow(p, u, cns_constant(p, "-2/3")),
                       cns_div(p, cns_pow(p, u, cns_constant(p, "1/3")), u));
    case 10:
        return cns_sub(p, cns_div(p, two, u), cns_pow(p, cns_div(p, u, two), cns_constant(p, "-1")));
    case 11: { /* sin 2u = 2 sin u cos u */
        cns_node s2, c2;
        cns_sincos(p, u, &s, &c);
        cns_sincos(p, cns_mul(p, two, u), &s2, &c2);
        return cns_sub(p, s2, cns_mul(p, two, cns_mul(p, s, c)));
    }
    case 12: /* |-u| = |u| = u */
        return cns_sub(p, cns_abs(p, cns_neg(p, u)), u);
    case 13: /* |a| b with a < 0 */
        return cns_add(p, cns_mul(p, cns_abs(p, cns_neg(p, u)), v), cns_mul(p, cns_neg(p, u), v));
    case 14:
        return cns_sub(p, cns_abs(p, cns_sub(p, cns_constant(p, "-3"), u)),
                       cns_add(p, cns_constant(p, "3"), u));
    case 15: { /* smoothed: |u|^2 = u^2 + eps^2, of which a constant is left */
        cns_node w = cns_abs(p, u);
        return cns_sub(p, cns_sqr(p, w), cns_sqr(p, u));
    }
    }
    return -1;
}

enum { N_IDENTITIES = 16 };

static void check_identities(const cns_arith_ops *ops, mpfr_prec_t prec, int order, double H, bool outputs)
{
    enum { T = 0, S = 1, C = 2, Q = 3 };
    cns_program *p[2];
    for (int smooth = 0; smooth < 2; smooth++) {
        p[smooth] = program_new(Q + N_IDENTITIES, smooth ? "1/8" : NULL);
        cns_node s = cns_state(p[smooth], S), c = cns_state(p[smooth], C), two = cns_constant(p[smooth], "2");
        cns_node u = cns_add(p[smooth], two, s), v = cns_sub(p[smooth], c, cns_neg(p[smooth], two));
        cns_derivative(p[smooth], T, cns_constant(p[smooth], "1"));
        cns_derivative(p[smooth], S, c);
        cns_derivative(p[smooth], C, cns_neg(p[smooth], s));
        for (int i = 0; i < N_IDENTITIES; i++)
            cns_derivative(p[smooth], Q + i,
                           smooth && i != 15    ? two
                           : !smooth && i == 15 ? two
                                                : identity(p[smooth], i, u, v));
        finished(p[smooth]);
        cns_jet_spec spec = {
            .program = p[smooth], .ops = ops, .order = order, .prec = prec, .outputs = outputs};
        cns_error err;
        cns_jet *J = cns_jet_new(&spec, &err);
        ck_assert_ptr_nonnull(J);
        mpfr_t x, zero;
        mpfr_inits2(prec, x, zero, (mpfr_ptr)0);
        mpfr_set_zero(zero, 1);
        cns_jet_begin(J, H);
        for (int i = 0; i < Q + N_IDENTITIES; i++) {
            mpfr_set_d(x, i == S ? 0.25 : i == C ? -0.75 : 0, MPFR_RNDN);
            cns_jet_set_state(J, i, x);
        }
        check_ok(cns_jet_expand(J, order, &err), &err);
        for (int i = 0; i < N_IDENTITIES; i++)
            for (int k = 2; k <= order; k++) {
                cns_jet_coefficient(J, x, Q + i, k);
                /* no singularity of these functions is nearer than 1 */
                check_close(x, zero, 14.0 - (double)prec + k * log2(H),
                            "identity %d, coefficient %d of %d, H = %g", i, k, order, H);
            }
        mpfr_clears(x, zero, (mpfr_ptr)0);
        cns_jet_free(J);
        cns_program_free(p[smooth]);
    }
}

START_TEST(identities_hold)
{
    check_identities(&cns_arith_mpfr, 64, 2, 1, false);
    check_identities(&cns_arith_mpfr, 200, 60, 1, false);
    check_identities(&cns_arith_mpfr, 200, 61, 0.3, true);
    check_identities(&cns_arith_mpfr, 1000, 40, 1.5, false);
    check_identities(&cns_arith_double, 53, 40, 1, false);
    check_identities(&cns_arith_libm, 53, 40, 0.3, true);
}
END_TEST

START_TEST(identities_hold_at_order_1000)
{
    check_identities(&cns_arith_mpfr, 256, 1000, 1, false);
    check_identities(&cns_arith_double, 53, 1000, 0.5, false);
}
END_TEST

/* All operations at once: more bits give the same coefficients to the fewer bits. */
START_TEST(agrees_with_higher_precision)
{
    enum { N = 40, Q = 3 };
    cns_program *p = program_new(Q + 1, NULL);
    cns_node s = cns_state(p, 1), c = cns_state(p, 2), third = cns_constant(p, "1/3");
    cns_node u = cns_add(p, cns_constant(p, "2"), s), v = cns_add(p, cns_constant(p, "pi"), c), sn, cs;
    cns_sincos(p, cns_mul(p, u, v), &sn, &cs);
    cns_node sum = cns_add(p, cns_exp(p, sn), cns_log(p, v));
    sum = cns_sub(p, sum, cns_div(p, cs, cns_sqrt(p, u)));
    sum = cns_add(p, sum, cns_mul(p, cns_hypot(p, u, v), cns_abs(p, cns_neg(p, u))));
    sum = cns_mul(p, cns_pow(p, v, third), cns_sqr(p, sum));
    cns_derivative(p, 0, cns_constant(p, "1"));
    cns_derivative(p, 1, c);
    cns_derivative(p, 2, cns_neg(p, s));
    cns_derivative(p, Q, sum);
    finished(p);
    cns_jet *reference = jet_new(p, &cns_arith_mpfr, N, 700);
    mpfr_t x, y;
    mpfr_init2(y, 700);
    for (int turn = -1; turn < ARITHMETICS; turn++) {
        mpfr_prec_t prec = turn < 0 ? 700 : arithmetics[turn].prec;
        cns_jet *J = turn < 0 ? reference : jet_new(p, arithmetics[turn].ops, N, prec);
        cns_error err;
        mpfr_init2(x, prec);
        cns_jet_begin(J, 0.125);
        for (int i = 0; i < Q + 1; i++) {
            mpfr_set_d(x, i == 1 ? 0.25 : i == 2 ? -0.75 : 0, MPFR_RNDN);
            cns_jet_set_state(J, i, x);
        }
        check_ok(cns_jet_expand(J, N, &err), &err);
        for (int k = 0; k <= N && turn >= 0; k++) {
            cns_jet_coefficient(J, x, Q, k);
            cns_jet_coefficient(reference, y, Q, k);
            check_close(x, y, 16.0 - (double)prec, "%s, coefficient %d", arithmetics[turn].ops->name, k);
        }
        mpfr_clear(x);
        if (J != reference)
            cns_jet_free(J);
    }
    mpfr_clear(y);
    cns_jet_free(reference);
    cns_program_free(p);
}
END_TEST

/* The double arithmetic is the 53-bit one of MPFR wherever single operations are: x' = -x. */
START_TEST(double_and_mpfr_agree_to_the_bit_on_single_operations)
{
    cns_program *p = program_new(1, NULL);
    cns_derivative(p, 0, cns_neg(p, cns_state(p, 0)));
    finished(p);
    cns_jet *J[2] = {jet_new(p, &cns_arith_mpfr, 25, 53), jet_new(p, &cns_arith_double, 25, 53)};
    mpfr_t x, y;
    mpfr_inits2(53, x, y, (mpfr_ptr)0);
    for (int k = 0; k < 2; k++) {
        cns_error err;
        mpfr_set_d(x, 0.1, MPFR_RNDN);
        cns_jet_begin(J[k], 1);
        cns_jet_set_state(J[k], 0, x);
        check_ok(cns_jet_expand(J[k], 25, &err), &err);
    }
    for (int k = 0; k <= 25; k++) {
        long e;
        cns_jet_coefficient(J[0], x, 0, k);
        cns_jet_coefficient(J[1], y, 0, k);
        ck_assert(mpfr_equal_p(x, y));
        double m = cns_jet_coefficient_2exp(J[0], &e, 0, k);
        ck_assert_double_eq(ldexp(m, (int)e), mpfr_get_d(x, MPFR_RNDN));
        ck_assert(fabs(m) >= 0.5 && fabs(m) < 1);
        m = cns_jet_coefficient_2exp(J[1], &e, 0, k);
        ck_assert_double_eq(ldexp(m, (int)e), mpfr_get_d(y, MPFR_RNDN));
    }
    mpfr_clears(x, y, (mpfr_ptr)0);
    cns_jet_free(J[0]);
    cns_jet_free(J[1]);
    cns_program_free(p);
}
END_TEST

Suite *suite_jet(void)
{
    Suite *s = suite_create("jet");
    TCase *t = tcase_create("operations");
    tcase_add_loop_test(t, agrees_with_the_oracle, 0, OPERATIONS * ARITHMETICS);
    tcase_add_loop_test(t, runs_ahead_of_leading_zeros, 0, 2 * LEADING * ARITHMETICS);
    tcase_add_loop_test(t, the_sign_of_abs_is_the_first_coefficients, 0, ARITHMETICS);
    tcase_add_loop_test(t, noise_has_no_sign, 0, ARITHMETICS);
    tcase_add_loop_test(t, signed_holds_from_order_zero, 0, ARITHMETICS);
    tcase_add_loop_test(t, says_where_it_is_singular, 0, SINGULAR * ARITHMETICS);
    tcase_add_test(t, zero_over_zero_is_singular);
    tcase_add_test(t, singular_outputs_are_just_missing);
    tcase_add_loop_test(t, constants_without_a_value_give_no_jet, 0, 4);
    suite_add_tcase(s, t);
    t = tcase_create("identities");
    tcase_add_test(t, identities_hold);
    tcase_add_test(t, identities_hold_at_order_1000);
    tcase_add_test(t, agrees_with_higher_precision);
    tcase_add_test(t, double_and_mpfr_agree_to_the_bit_on_single_operations);
    suite_add_tcase(s, t);
    return s;
}
