/* The arithmetic of power series, under the Taylor engine.
 *
 * An arithmetic holds `series` power series of orders 0..`order` in scaled time tau = (t - t0)/H, and one
 * accumulator. A coefficient is summed in the accumulator, from convolutions and from single coefficients,
 * and rounded into its series by one of the store functions. These primitives (primitives.def) are all that
 * the recurrences of operations (src/taylor/op) call, so that each recurrence is written once; the backends
 * (MPFR, double, fixed point) implement them.
 *
 * Series are numbered 0..series-1; coefficient k of series a is written a_k, 0 <= k <= order. */
#ifndef CNS_ARITH_ARITH_H
#define CNS_ARITH_ARITH_H

#include <mpfr.h>
#include <stdbool.h>
#include <stddef.h>

#include "cns/status.h"

typedef struct cns_arith cns_arith;

typedef enum cns_function { /* of order-0 coefficients; correctly rounded unless a backend says otherwise */
                            CNS_FN_SQRT,   /* w_0 = sqrt(a_0) */
                            CNS_FN_HYPOT,  /* w_0 = sqrt(a_0^2 + b_0^2) */
                            CNS_FN_SINCOS, /* w_0 = sin(a_0), w2_0 = cos(a_0) */
                            CNS_FN_EXP,    /* w_0 = exp(a_0) */
                            CNS_FN_LOG,    /* w_0 = log(a_0) */
                            CNS_FN_POW     /* w_0 = a_0^(b_0) */
} cns_function;

typedef struct cns_arith_spec {
    int series;         /* how many */
    int order;          /* highest coefficient that can be held */
    mpfr_prec_t prec;   /* working precision in bits; the double backend ignores it */
    const char *kernel; /* of the fast arithmetic (fast.h); NULL: as chosen for the process */
} cns_arith_spec;

/* A row of primitives.def has n names of arguments: CNS_INTS_n(a, b, ...) makes them the parameters of a
 * function, after its first, and CNS_NAMES_n(a, b, ...) the arguments of a call. */
#define CNS_INTS_0()
#define CNS_INTS_2(a, b)             , int a, int b
#define CNS_INTS_3(a, b, c)          , int a, int b, int c
#define CNS_INTS_4(a, b, c, d)       , int a, int b, int c, int d
#define CNS_INTS_5(a, b, c, d, e)    , int a, int b, int c, int d, int e
#define CNS_INTS_6(a, b, c, d, e, f) , int a, int b, int c, int d, int e, int f
#define CNS_NAMES_0()
#define CNS_NAMES_2(a, b)             , a, b
#define CNS_NAMES_3(a, b, c)          , a, b, c
#define CNS_NAMES_4(a, b, c, d)       , a, b, c, d
#define CNS_NAMES_5(a, b, c, d, e)    , a, b, c, d, e
#define CNS_NAMES_6(a, b, c, d, e, f) , a, b, c, d, e, f
enum { CNS_MOST_ARGUMENTS = 6 };
/* And CNS_ARRAY(CNS_NAMES_n(a, b, ...)) an array, filled up with zeros. */
#define CNS_ARRAY(names) ((const int[CNS_MOST_ARGUMENTS + 1]){0 names} + 1)

typedef enum cns_primitive {
#define PRIMITIVE(KIND, name, n, ...) CNS_PRIMITIVE_##KIND,
#include "primitives.def"
#undef PRIMITIVE
} cns_primitive;

/* The trace of an order: the calls of primitives that the recurrences make at it. From some low order on they
 * make the same calls at every order, but for arguments that grow by one, as the order itself. */
typedef struct cns_trace_call {
    cns_primitive primitive;
    int arg[CNS_MOST_ARGUMENTS];
    bool grows[CNS_MOST_ARGUMENTS];
} cns_trace_call;

typedef struct cns_trace {
    const cns_trace_call *call;
    int n, order; /* the arguments are those of this order */
} cns_trace;

typedef struct cns_arith_ops {
    const char *name;

    /* True: the errors of coefficients are absolute. Then an expansion wants an H near the step that is to be
     * taken, so that coefficients fall by some bits per order, and serves tau <= 2^reach_log2 only. After an
     * expansion noise_log2 is log2 of a bound on the errors of the states' coefficients, HUGE_VAL where the
     * expansion failed. False: errors are relative, those of the precision, and noise_log2 is NULL. */
    bool in_steps;
    double reach_log2;
    double (*noise_log2)(const cns_arith *A);
    /* The working precision from the next begin on, at most that of the spec. NULL: it is fixed. */
    void (*set_precision)(cns_arith *A, mpfr_prec_t prec);
    /* Bits by which coefficients are expected to fall per order, from the next begin on; 3 if not told. NULL:
     * it does not matter. */
    void (*set_decay)(cns_arith *A, int decay);
    /* y = sum_{k <= n} a_k tau^k, 0 <= tau <= 2^reach_log2, cheapest where tau has some 32 bits only. NULL:
     * the caller sums coefficients itself. */
    void (*sum)(cns_arith *A, mpfr_t y, int a, int n, const mpfr_t tau);
    /* y = sum_{k <= n} k a_k tau^(k-1), tau > 0, of the coefficients as they are: the error of the sum itself
     * is below that which the coefficients' own errors make. *largest_log2 is log2 of the largest term, times
     * tau, to a bit; -HUGE_VAL if all terms vanish. False, or NULL: the caller sums coefficients itself. */
    bool (*slope)(cns_arith *A, mpfr_t y, double *largest_log2, int a, int n, const mpfr_t tau);

    cns_arith *(*create)(const cns_arith_spec *spec, cns_error *err); /* NULL: out of memory or range */
    void (*destroy)(cns_arith *A);

    size_t (*bytes)(const cns_arith *A); /* of memory that it holds */

    /* What roundings do, for proofs (taylor/defect.h). Let a coefficient w_n be made as recurrences make it:
     * up to 64 terms are added, and the sum is stored. The terms are made of coefficients as they are stored
     * at the end of the expansion; the size of a term is the product of the sizes of the series in it, times
     * its weight; of a series, 2^size_log2 or, where that is NULL, the sum of its coefficients' sizes. Then
     * what is stored, times the divisor of store_over, differs from the exact result by less than
     * 2^rounding_log2 times (the sizes of all terms and that of w, times the divisor), also when these
     * differences are added up over all orders of the expansion, times tau^n, tau <= 2^reach_log2 if
     * in_steps, else 1. Constants count as what they are, and the functions of order 0 as one rounding more.
     * The coefficient that set() is given is one of them. */
    double (*rounding_log2)(const cns_arith *A);
    long (*size_log2)(const cns_arith *A, int a);

    /* Starts a new expansion: time scaled by H > 0 (a machine number, exact), all series forgotten
     * except those given by set() with `keep` true (the constants). */
    void (*begin)(cns_arith *A, double H);

    /* Single coefficients, out and in. get is exact when y has the bits; set rounds to nearest. */
    void (*get)(const cns_arith *A, mpfr_t y, int a, int k);
    void (*set)(cns_arith *A, int w, int k, const mpfr_t y, bool keep);

    /* a_k = m * 2^e with 0.5 <= |m| < 1, m rounded to double; m = 0 for zero. */
    double (*get_2exp)(const cns_arith *A, long *e, int a, int k);

    /* The same of a_0 .. a_{n-1} at once, but m only within 2^-100 .. 2^100, or 0, and good to 2^-52 of
     * itself. */
    void (*leading)(const cns_arith *A, double *m, long *e, int a, int n);

    /* The accumulator, into which a coefficient is summed, and from which it is stored. */
#define PRIMITIVE(KIND, name, n, ...) void (*name)(cns_arith * A CNS_INTS_##n(__VA_ARGS__));
#include "primitives.def"
#undef PRIMITIVE

    /* Orders from..to-1 by their trace: the same results as its calls, order by order. False: the expansion
     * was found to have failed. NULL: nothing is gained by it. */
    bool (*orders)(cns_arith *A, const cns_trace *trace, int from, int to);

    /* Functions of order-0 coefficients; w2 and b as cns_function says, -1 where it has none. */
    void (*function)(cns_arith *A, cns_function f, int w, int w2, int a, int b);
} cns_arith_ops;

extern const cns_arith_ops cns_arith_fast;   /* block fixed point (fast.h) */
extern const cns_arith_ops cns_arith_mpfr;   /* every operation correctly rounded; the reference */
extern const cns_arith_ops cns_arith_double; /* IEEE double; functions correctly rounded through MPFR */
extern const cns_arith_ops cns_arith_libm;   /* the same with the C library's functions: not the same
                                                bits on every machine */

/* A cns_function, correctly rounded: w = f(a) or f(a, b), and w2 = cos a; w2 and b are looked at only where
 * the function has them. w and w2 may be a or b. */
void cns_function_mpfr(cns_function f, mpfr_ptr w, mpfr_ptr w2, mpfr_srcptr a, mpfr_srcptr b);

#endif
