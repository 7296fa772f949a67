/* The arithmetic under the Taylor engine.
 *
 * An arithmetic holds `series` power series of orders 0..`order` in scaled time tau = (t - t0)/H, and one
 * accumulator. The recurrences (src/taylor/op) are written once over these primitives; each
 * backend (MPFR, double, fixed point) implements them all. A coefficient is built in the accumulator
 * from convolutions and whole coefficients, and rounded into its series by one of the store functions.
 *
 * Shapes: series are numbered 0..series-1; coefficient k of series a is written a_k, 0 <= k <= order.
 * A series may be an operand of a convolution only at orders already stored. */
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
    int series;       /* how many */
    int order;        /* highest coefficient that can be held */
    mpfr_prec_t prec; /* working precision in bits; the double backend ignores it */
} cns_arith_spec;

/* A call of one of the primitives below, as noted by an expansion: its arguments in their order, and which of
 * them grow by one with every order. */
enum { CNS_CALL_ARGUMENTS = 6 };

typedef struct cns_call {
    enum {
        CNS_CALL_ZERO,
        CNS_CALL_COEF,
        CNS_CALL_SCALED,
        CNS_CALL_CONV,
        CNS_CALL_SQUARE,
        CNS_CALL_STORE,
        CNS_CALL_STORE_SCALED,
        CNS_CALL_STORE_RATIO,
        CNS_CALL_STORE_OVER,
        CNS_CALL_STORE_NEXT
    } kind;
    int arg[CNS_CALL_ARGUMENTS];
    bool grows[CNS_CALL_ARGUMENTS];
} cns_call;

typedef struct cns_calls {
    const cns_call *call;
    int n, order; /* the arguments are those of this order */
} cns_calls;

typedef struct cns_arith_ops {
    const char *name;

    /* True: coefficients carry an absolute error, the expansion wants H near the step to come, so that they
     * fall by some bits per order, and it serves tau <= 2^reach_log2 only. noise_log2 then tells, after an
     * expansion, log2 of a bound on the error of a state's coefficients; it is HUGE_VAL where the expansion
     * failed. NULL otherwise: the error is that of the precision. */
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
    /* y = sum_{k <= n} k a_k tau^(k-1), tau > 0, from the coefficients as they are, with an error below their
     * own; *largest_log2: of its largest term times tau, to a bit, -HUGE_VAL if all vanish. False, or NULL:
     * the caller sums coefficients itself. */
    bool (*slope)(cns_arith *A, mpfr_t y, double *largest_log2, int a, int n, const mpfr_t tau);

    cns_arith *(*create)(const cns_arith_spec *spec, cns_error *err); /* NULL: out of memory or range */
    void (*destroy)(cns_arith *A);

    size_t (*bytes)(const cns_arith *A); /* of memory that it holds */

    /* Starts a new expansion: time scaled by H > 0 (a machine number, exact), all series forgotten
     * except those given by set() with `keep` true (the constants). */
    void (*begin)(cns_arith *A, double H);

    /* Single coefficients across the border, through MPFR. get is exact when y has the precision;
     * set rounds to nearest. */
    void (*get)(const cns_arith *A, mpfr_t y, int a, int k);
    void (*set)(cns_arith *A, int w, int k, const mpfr_t y, bool keep);

    /* a_k = m * 2^e with 0.5 <= |m| < 1, m rounded to double; m = 0 for zero. */
    double (*get_2exp)(const cns_arith *A, long *e, int a, int k);

    /* The accumulator. */
    void (*zero)(cns_arith *A);
    void (*coef)(cns_arith *A, long weight, int a, int k);       /* += weight * a_k, |weight| < 2^31 */
    void (*scaled)(cns_arith *A, int sign, int c, int a, int k); /* += sign * c_0 * a_k, c a constant */
    void (*conv)(cns_arith *A, int sign, int a, int b, int n, int lo, int hi);
    /* += sign * sum_{j=lo..hi} a_j b_{n-j} */
    void (*square)(cns_arith *A, int sign, int a, int n, int lo);
    /* += sign * sum_{j=lo..n-lo} a_j a_{n-j} */

    /* Rounding the accumulator into a series; the accumulator is undefined afterwards. */
    void (*store)(cns_arith *A, int w, int k);                       /* w_k = acc */
    void (*store_scaled)(cns_arith *A, int w, int k, int c);         /* w_k = c_0 * acc */
    void (*store_ratio)(cns_arith *A, int w, int k, long p, long q); /* w_k = acc * p / q */
    void (*store_over)(cns_arith *A, int w, int k, int d, int v, int twice);
    /* w_k = acc / d_v, or acc / (2 d_v) */
    void (*store_next)(cns_arith *A, int x, int k, int c);
    /* x_{k+1} = c_0 * acc * H/(k+1); c = -1: no factor */

    /* Orders from..to-1 in one go: the same results as those calls, order by order. False: the expansion was
     * found to have failed. NULL: nothing is gained by it. */
    bool (*orders)(cns_arith *A, const cns_calls *calls, int from, int to);

    /* Order-0 functions; w2 and b as cns_function says, -1 where unused. */
    void (*function)(cns_arith *A, cns_function f, int w, int w2, int a, int b);
} cns_arith_ops;

extern const cns_arith_ops cns_arith_fast;   /* block fixed point; kernel by CNS_KERNEL */
extern const cns_arith_ops cns_arith_mpfr;   /* every operation correctly rounded; the reference */
extern const cns_arith_ops cns_arith_double; /* IEEE double; functions correctly rounded through MPFR */
extern const cns_arith_ops cns_arith_libm;   /* the same with the C library's functions: not the same
                                                bits on every machine */

/* The kernel that the fast arithmetic uses: "avx512ifma" or "portable", as CNS_KERNEL says. CNS_USAGE when it
 * names none, or one that this machine does not have. */
cns_code cns_fast_kernel_name(const char **name, cns_error *err);

#endif
