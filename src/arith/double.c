/* IEEE double. The sums are the plain loops; functions of order-0 coefficients go through MPFR, so that
 * they are correctly rounded and the same everywhere, or (cns_arith_libm) through the C library. */
#include <math.h>
#include <stdlib.h>

#include "trace.h"

struct cns_arith {
    cns_arith_spec spec;
    double H, acc;
    double *c; /* coefficient k of series a is c[a (order+1) + k] */
};

static double *at(const cns_arith *A, int a, int k)
{
    return &A->c[(size_t)a * ((size_t)A->spec.order + 1) + (size_t)k];
}

static void destroy(cns_arith *A)
{
    if (A)
        free(A->c);
    free(A);
}

static cns_arith *create(const cns_arith_spec *spec, cns_error *err)
{
    cns_arith *A = calloc(1, sizeof *A);
    if (A) {
        A->spec = *spec;
        A->H = 1;
        A->c = calloc((size_t)spec->series * ((size_t)spec->order + 1) + 1, sizeof *A->c);
    }
    if (!A || !A->c) {
        destroy(A);
        cns_fail(err, CNS_MEMORY, "out of memory: %d series of order %d", spec->series, spec->order);
        return NULL;
    }
    return A;
}

static size_t bytes(const cns_arith *A)
{
    return (size_t)A->spec.series * ((size_t)A->spec.order + 1) * sizeof *A->c;
}

static void begin(cns_arith *A, double H)
{
    A->H = H;
}

static void get(const cns_arith *A, mpfr_t y, int a, int k)
{
    mpfr_set_d(y, *at(A, a, k), MPFR_RNDN);
}

static void set(cns_arith *A, int w, int k, const mpfr_t y, bool keep)
{
    (void)keep;
    *at(A, w, k) = mpfr_get_d(y, MPFR_RNDN);
}

static double get_2exp(const cns_arith *A, long *e, int a, int k)
{
    int exponent;
    double m = frexp(*at(A, a, k), &exponent);
    *e = exponent;
    return m;
}

static void leading(const cns_arith *A, double *m, long *e, int a, int n)
{
    for (int k = 0; k < n; k++) {
        m[k] = *at(A, a, k);
        e[k] = 0;
        if (m[k] != 0 && !(fabs(m[k]) > 0x1p-100 && fabs(m[k]) < 0x1p100))
            m[k] = get_2exp(A, &e[k], a, k);
    }
}

static void zero(cns_arith *A)
{
    A->acc = 0;
}

static void coef(cns_arith *A, int weight, int a, int k)
{
    A->acc += (double)weight * *at(A, a, k);
}

static void scaled(cns_arith *A, int sign, int c, int a, int k)
{
    A->acc += sign * (*at(A, c, 0) * *at(A, a, k));
}

static void conv(cns_arith *A, int sign, int a, int b, int n, int lo, int hi)
{
    const double *x = at(A, a, 0), *y = at(A, b, 0);
    double s = 0;
    for (int j = lo; j <= hi; j++)
        s += x[j] * y[n - j];
    A->acc += sign * s;
}

static void square(cns_arith *A, int sign, int a, int n, int lo)
{
    const double *x = at(A, a, 0);
    double s = 0;
    int j = lo;
    for (; 2 * j < n; j++)
        s += x[j] * x[n - j];
    s *= 2;
    if (2 * j == n)
        s += x[j] * x[j];
    A->acc += sign * s;
}

static void store(cns_arith *A, int w, int k)
{
    *at(A, w, k) = A->acc;
}

static void store_scaled(cns_arith *A, int w, int k, int c)
{
    *at(A, w, k) = *at(A, c, 0) * A->acc;
}

static void store_ratio(cns_arith *A, int w, int k, int p, int q)
{
    *at(A, w, k) = A->acc * (double)p / (double)q;
}

static void store_over(cns_arith *A, int w, int k, int d, int v, int twice)
{
    *at(A, w, k) = A->acc / ((twice ? 2 : 1) * *at(A, d, v));
}

static void store_next(cns_arith *A, int x, int k, int c)
{
    double f = c >= 0 ? *at(A, c, 0) * A->acc : A->acc;
    *at(A, x, k + 1) = f * A->H / (k + 1);
}

static bool orders(cns_arith *A, const cns_trace *trace, int from, int to)
{
    for (int k = from; k < to; k++)
        cns_trace_replay(&cns_arith_double, A, trace, 0, k);
    return true;
}

static void function(cns_arith *A, cns_function f, int w, int w2, int a, int b)
{
    mpfr_t x, y, z;
    double *out = at(A, w, 0), u = *at(A, a, 0);
    if (f == CNS_FN_SQRT) {
        *out = sqrt(u);
        return;
    }
    mpfr_inits2(53, x, y, z, (mpfr_ptr)0);
    mpfr_set_d(x, u, MPFR_RNDN);
    if (b >= 0)
        mpfr_set_d(y, *at(A, b, 0), MPFR_RNDN);
    cns_function_mpfr(f, z, y, x, y);
    if (f == CNS_FN_SINCOS)
        *at(A, w2, 0) = mpfr_get_d(y, MPFR_RNDN);
    *out = mpfr_get_d(z, MPFR_RNDN);
    mpfr_clears(x, y, z, (mpfr_ptr)0);
}

static void function_libm(cns_arith *A, cns_function f, int w, int w2, int a, int b)
{
    double *out = at(A, w, 0), u = *at(A, a, 0);
    switch (f) {
    case CNS_FN_SQRT:
        *out = sqrt(u);
        break;
    case CNS_FN_HYPOT:
        *out = hypot(u, *at(A, b, 0));
        break;
    case CNS_FN_SINCOS:
        *out = sin(u);
        *at(A, w2, 0) = cos(u);
        break;
    case CNS_FN_EXP:
        *out = exp(u);
        break;
    case CNS_FN_LOG:
        *out = log(u);
        break;
    case CNS_FN_POW:
        *out = pow(u, *at(A, b, 0));
        break;
    }
}

/* As in MPFR, and functions of the C library are good to a few units of the last place. */
static double rounding_log2(const cns_arith *A)
{
    enum { PRIMITIVES = 64 };
    return log2(2.0 * (A->spec.order + 2) + 2 * PRIMITIVES) + 1 - 53;
}

#define EVERYTHING_ELSE                                                                                      \
    .create = create, .destroy = destroy, .bytes = bytes, .begin = begin, .get = get, .set = set,            \
    .get_2exp = get_2exp, .leading = leading, .rounding_log2 = rounding_log2, .orders = orders
#define PRIMITIVE(KIND, name, n, ...) .name = name,

const cns_arith_ops cns_arith_double = {
    .name = "double",
    EVERYTHING_ELSE,
    .function = function,
#include "primitives.def"
};
const cns_arith_ops cns_arith_libm = {
    .name = "double (C library)",
    EVERYTHING_ELSE,
    .function = function_libm,
#include "primitives.def"
};
