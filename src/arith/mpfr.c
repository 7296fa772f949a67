/* MPFR: every single operation correctly rounded to the working precision. The reference arithmetic. */
#include <limits.h>
#include <math.h>
#include <stdlib.h>

#include "arith.h"
#include "num/vector.h"

struct cns_arith {
    cns_arith_spec spec;
    double H;
    mpfr_t acc, term, half;
    mpfr_t *c; /* coefficient k of series a is c[a (order+1) + k] */
};

static mpfr_ptr at(const cns_arith *A, int a, int k)
{
    return A->c[(size_t)a * ((size_t)A->spec.order + 1) + (size_t)k];
}

static void destroy(cns_arith *A)
{
    if (!A)
        return;
    mpfr_clears(A->acc, A->term, A->half, (mpfr_ptr)0);
    cns_vector_free(A->c);
    free(A);
}

static cns_arith *create(const cns_arith_spec *spec, cns_error *err)
{
    cns_arith *A = calloc(1, sizeof *A);
    const size_t n = (size_t)spec->series * ((size_t)spec->order + 1);
    mpfr_t *c = n <= INT_MAX ? cns_vector_new((int)n, spec->prec) : NULL;
    if (!A || !c) {
        cns_fail(err, CNS_MEMORY, "out of memory: %d series of order %d at %ld bits", spec->series,
                 spec->order, (long)spec->prec);
        cns_vector_free(c);
        free(A);
        return NULL;
    }
    *A = (cns_arith){.spec = *spec, .H = 1, .c = c};
    mpfr_inits2(spec->prec, A->acc, A->term, A->half, (mpfr_ptr)0);
    return A;
}

static size_t bytes(const cns_arith *A)
{
    return cns_vector_bytes(A->spec.series * (A->spec.order + 1), A->spec.prec);
}

static void begin(cns_arith *A, double H)
{
    A->H = H;
}

static void get(const cns_arith *A, mpfr_t y, int a, int k)
{
    mpfr_set(y, at(A, a, k), MPFR_RNDN);
}

static void set(cns_arith *A, int w, int k, const mpfr_t y, bool keep)
{
    (void)keep;
    mpfr_set(at(A, w, k), y, MPFR_RNDN);
}

static double get_2exp(const cns_arith *A, long *e, int a, int k)
{
    mpfr_srcptr x = at(A, a, k);
    if (!mpfr_regular_p(x)) {
        *e = 0;
        return mpfr_get_d(x, MPFR_RNDN);
    }
    return mpfr_get_d_2exp(e, x, MPFR_RNDN);
}

static void leading(const cns_arith *A, double *m, long *e, int a, int n)
{
    for (int k = 0; k < n; k++)
        m[k] = get_2exp(A, &e[k], a, k);
}

static void zero(cns_arith *A)
{
    mpfr_set_zero(A->acc, 1);
}

static void add_term(cns_arith *A, int sign)
{
    if (sign > 0)
        mpfr_add(A->acc, A->acc, A->term, MPFR_RNDN);
    else
        mpfr_sub(A->acc, A->acc, A->term, MPFR_RNDN);
}

static void coef(cns_arith *A, int weight, int a, int k)
{
    if (weight == 1) {
        mpfr_add(A->acc, A->acc, at(A, a, k), MPFR_RNDN);
    } else if (weight == -1) {
        mpfr_sub(A->acc, A->acc, at(A, a, k), MPFR_RNDN);
    } else {
        mpfr_mul_si(A->term, at(A, a, k), weight, MPFR_RNDN);
        add_term(A, 1);
    }
}

static void scaled(cns_arith *A, int sign, int c, int a, int k)
{
    mpfr_mul(A->term, at(A, c, 0), at(A, a, k), MPFR_RNDN);
    add_term(A, sign);
}

static void conv(cns_arith *A, int sign, int a, int b, int n, int lo, int hi)
{
    mpfr_t *x = &A->c[(size_t)a * ((size_t)A->spec.order + 1)];
    mpfr_t *y = &A->c[(size_t)b * ((size_t)A->spec.order + 1)];
    if (sign > 0)
        for (int j = lo; j <= hi; j++) {
            mpfr_mul(A->term, x[j], y[n - j], MPFR_RNDN);
            mpfr_add(A->acc, A->acc, A->term, MPFR_RNDN);
        }
    else
        for (int j = lo; j <= hi; j++) {
            mpfr_mul(A->term, x[j], y[n - j], MPFR_RNDN);
            mpfr_sub(A->acc, A->acc, A->term, MPFR_RNDN);
        }
}

/* Half the products: 2 sum_{j < n/2} a_j a_{n-j}, and the square in the middle. */
static void square(cns_arith *A, int sign, int a, int n, int lo)
{
    mpfr_t *x = &A->c[(size_t)a * ((size_t)A->spec.order + 1)];
    int j = lo;
    mpfr_set_zero(A->half, 1);
    for (; 2 * j < n; j++) {
        mpfr_mul(A->term, x[j], x[n - j], MPFR_RNDN);
        mpfr_add(A->half, A->half, A->term, MPFR_RNDN);
    }
    mpfr_mul_2ui(A->term, A->half, 1, MPFR_RNDN);
    add_term(A, sign);
    if (2 * j == n) {
        mpfr_sqr(A->term, x[j], MPFR_RNDN);
        add_term(A, sign);
    }
}

static void store(cns_arith *A, int w, int k)
{
    mpfr_set(at(A, w, k), A->acc, MPFR_RNDN);
}

static void store_scaled(cns_arith *A, int w, int k, int c)
{
    mpfr_mul(at(A, w, k), A->acc, at(A, c, 0), MPFR_RNDN);
}

static void store_ratio(cns_arith *A, int w, int k, int p, int q)
{
    mpfr_ptr x = at(A, w, k);
    if (p == 1) {
        mpfr_div_si(x, A->acc, q, MPFR_RNDN);
    } else {
        mpfr_mul_si(A->acc, A->acc, p, MPFR_RNDN);
        mpfr_div_si(x, A->acc, q, MPFR_RNDN);
    }
}

static void store_over(cns_arith *A, int w, int k, int d, int v, int twice)
{
    mpfr_div(at(A, w, k), A->acc, at(A, d, v), MPFR_RNDN);
    if (twice)
        mpfr_div_2ui(at(A, w, k), at(A, w, k), 1, MPFR_RNDN);
}

static void store_next(cns_arith *A, int x, int k, int c)
{
    if (c >= 0)
        mpfr_mul(A->acc, A->acc, at(A, c, 0), MPFR_RNDN);
    if (A->H != 1)
        mpfr_mul_d(A->acc, A->acc, A->H, MPFR_RNDN);
    mpfr_div_ui(at(A, x, k + 1), A->acc, (unsigned long)k + 1, MPFR_RNDN);
}

void cns_function_mpfr(cns_function f, mpfr_ptr w, mpfr_ptr w2, mpfr_srcptr a, mpfr_srcptr b)
{
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
}

static void function(cns_arith *A, cns_function f, int w, int w2, int a, int b)
{
    cns_function_mpfr(f, at(A, w, 0), w2 < 0 ? NULL : at(A, w2, 0), at(A, a, 0), b < 0 ? NULL : at(A, b, 0));
}

/* A term of order n is a sum of up to n + 1 products, each rounded and added: 2 (n + 2) roundings of 2^-prec
 * relative to the sum of their sizes; then those of the terms' sum and of the store. */
static double rounding_log2(const cns_arith *A)
{
    enum { PRIMITIVES = 64 };
    return log2(2.0 * (A->spec.order + 2) + 2 * PRIMITIVES) + 1 - (double)A->spec.prec;
}

const cns_arith_ops cns_arith_mpfr = {
    .name = "mpfr",
    .create = create,
    .destroy = destroy,
    .bytes = bytes,
    .begin = begin,
    .get = get,
    .set = set,
    .get_2exp = get_2exp,
    .leading = leading,
    .rounding_log2 = rounding_log2,
    .function = function,
#define PRIMITIVE(KIND, name, n, ...) .name = name,
#include "primitives.def"
#undef PRIMITIVE
};
