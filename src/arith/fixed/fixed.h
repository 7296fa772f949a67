/* Block fixed point: power series as blocks of fixed-point coefficients, private to the fast arithmetic.
 *
 * A series a with block exponent e holds, for time scaled by R = H 2^d,
 *     A_k = a_k 2^(d k) = x_k 2^(e+1),   -1/2 <= x_k < 1/2,
 * that is |a_k| <= 2^e 2^(-d k). What is stored is u_k = x_k + 1/2 in [0, 1): non-negative, with the same
 * bias at every order, in limbs of 52 bits, limb 0 the most significant. Order k keeps
 *     rows(k) = max(1, ceil((W - d k + r k)/52)) limbs,   r = FX_REACH/8,
 * so that a_k tau^k is accurate to 2^(e+1-W) at every order and for every tau up to 2^r: the window shrinks
 * by d - r bits per order and is a function of k alone.
 *
 * Small numbers ("few-limb numbers") are arrays t[0..rows]: t[0] is the signed integer part and
 * t[i], i >= 1, counts 2^(-52 i). Normalised means 0 <= t[i] < 2^52 for i >= 1; between carry passes the
 * limbs are signed 64-bit sums, and `load` bounds |t[i]| / 2^52.
 *
 * Convolutions keep the limb pairs (i, j), counted from 0, with i + j < rows(n), both halves of each
 * product, and sum them exactly; a kernel decides only how. With M = rows(n), the pairs left out are at
 * most M per term of weight below 2^(-52 M) (i + j = M), and less than one such in all beyond those, so
 *     0 <= exact - kept < (hi - lo + 1) (M + 1) 2^(-52 M) 2^(e_a + e_b + 2)
 * in the scale of A_n. Correction for the bias, with D_k = u_0 + ... + u_k:
 *     sum x_j y_(n-j) = sum u_j v_(n-j) - (sum u_j + sum v_j)/2 + (number of terms)/4. */
#ifndef CNS_ARITH_FIXED_FIXED_H
#define CNS_ARITH_FIXED_FIXED_H

#include <gmp.h>
#include <mpfr.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "arith/arith.h"

#define FX_BITS      52
#define FX_REACH     2 /* sums serve tau up to 2^(FX_REACH/8) */
#define FX_MASK      ((INT64_C(1) << FX_BITS) - 1)
#define FX_HALF      (INT64_C(1) << (FX_BITS - 1)) /* 1/2 in t[1] */
#define FX_MAX_LOAD  256                           /* of few-limb sums: |t[i]| < 2^60 */
#define FX_MAX_SLOPE 640                           /* the integer part stays below 2^10: n/2 sum 2^(-3k/4) */
#define FX_LANE_LOAD 1000                          /* of one lane of a column: |lane| < 2^62 */
#define FX_SUM_LOAD  400                           /* of a column over its 8 lanes: twice it < 2^62 */

/* What is kept of a series beside its values. Each part is made when a convolution first asks for it, and
 * kept up from then on: a series that is never an operand has none. */
enum { FX_FWD = 1, FX_REV = 2, FX_SUMS = 4 };

typedef struct fx_series {
    bool live;       /* exponent chosen */
    bool constant;   /* kept across expansions */
    int parts;       /* FX_FWD, FX_REV, FX_SUMS */
    int stored;      /* orders 0..stored-1 hold values */
    long exp;        /* e */
    int64_t peak;    /* max over stored k of the first limb of |x_k| */
    uint64_t *fwd;   /* limb l of order k at fwd[l * stride + k], if kept */
    uint64_t *rev;   /* the same at rev[l * stride + order - k], if kept */
    int64_t *record; /* order k: D_k if kept, eight zeros, x_k at `value`; integer parts first */
} fx_series;

/* sign * 2^exp * sum_{i >= 1} limb[i] 2^(-52 i); limbs from -pad to beyond the last row are zero. */
typedef struct fx_const {
    bool valid;
    int sign;
    int series, index; /* cached: which coefficient, which multiple */
    long divisor_exp;  /* of a reciprocal: the exponent of the divisor */
    long exp;
    int used; /* limbs beyond this one are zero */
    int64_t *limb;
} fx_const;

typedef struct fx_number {
    int64_t *t; /* zero from t[-pad] to t[-1] */
    int rows;
    int load; /* 0: zero, nothing added yet */
    bool normal;
    long exp;
} fx_number;

typedef struct fx fx;

/* What one order of an expansion does, worked out for the block exponents as they are: sums of few limbs in
 * a register, no exponents to compare, no state to keep (compile.c makes it, fixed_core.h runs it). */
enum { FX_ONE_ROWS = 6 }; /* orders of at most so many rows: with what products add, eight words */

typedef struct fx_step {
    enum {
        FX_DO_COEF,   /* a coefficient to the accumulator */
        FX_DO_SCALED, /* the same times a constant */
        FX_DO_CONV,   /* a product into the lanes, or the last one: with it their sum to the accumulator */
        FX_DO_SQUARE,
        FX_DO_STORE
    } kind;
    int group; /* the call that began this sum */

    /* The sum: what comes is moved down by down_x bits, or up by up_x, and added, or subtracted where flip is
     * ~0, to an accumulator that was carried and moved likewise; where `fresh`, to nothing. */
    bool fresh, carry;
    int up, up_x;
    long down, down_x;
    uint64_t flip;

    const fx_series *a, *b;
    const fx_const *c;
    int weight, weight_grows, order; /* of a coefficient, 0: 1; and how it grows from that order on */
    int sign, lo, above;             /* of a product: its last term is k - above */
    bool open, close;                /* the first, the last one of its lanes */

    fx_series *w;
    int next;   /* 1: stores order k + 1 */
    bool empty; /* an empty sum */
    enum { FX_TIMES_NOTHING, FX_TIMES_CONST, FX_TIMES_INVERSE, FX_TIMES_NEXT } times;
    fx_const *made; /* FX_TIMES_NEXT: c / (k + 1) */
    long exp;       /* of the sum, and of c if it stays, less that of the coefficient */
} fx_step;

typedef struct fx_compiled {
    int n, capacity;
    fx_step *step;
} fx_compiled;

typedef struct fx_kernel {
    const char *name;
#define PRIMITIVE(KIND, name, n, ...) void (*name)(fx * F CNS_INTS_##n(__VA_ARGS__));
#include "arith/primitives.def"
#undef PRIMITIVE
    /* The accumulator is sum_{k <= n} A_k c^k, c a fraction in [0, 1) without an exponent; of a slope,
     * sum_{k <= n} k A_k c^(k-1) 2^-d, n <= FX_MAX_SLOPE. */
    void (*sum)(fx *F, int a, int n, const fx_const *c, bool slope);
    /* Orders *k..to-1 by the compiled order; rows[*k] <= FX_ONE_ROWS. Returns NULL, or the step at which
     * order *k met a coefficient that wants another block exponent: the sum it belongs to is not stored. */
    const fx_step *(*run)(fx *F, const fx_compiled *C, int *k, int to);
} fx_kernel;

struct fx {
    const fx_kernel *kernel;
    int n_series, order, decay, next_decay;
    mpfr_prec_t max_prec, prec, next_prec;
    long window;          /* W, in bits */
    int limbs, max_limbs; /* rows(0), and the most it can be */
    int width;            /* words of a few-limb number, a multiple of 8 */
    int record, value;    /* words of a record, and where in it x_k begins */
    int pad;              /* zero words before t[0] */
    size_t stride;        /* of rows, a multiple of 8 */
    double H;
    int *rows; /* rows[k], k = 0..order+1 */
    fx_series *series;

    int64_t *lanes; /* (max_limbs + 2) columns of 8 lanes; column p has weight 2^(-52 p) */
    bool lanes_used;
    int lanes_rows, lanes_load, corr_load;
    long lanes_exp, terms;
    int64_t *corr;
    int64_t *zeros; /* a number */
    fx_number acc;
    int64_t *tmp, *tmp2, *tmp3;

    fx_const *inverse_order; /* 1/(k+1), k = 0..order */
    fx_const *constant;      /* per series: the number a_0, for those used as constants */
    fx_const *step_const;    /* per series and one more: a_0 R; the last is R itself */
    fx_const *next_const;    /* the same times 1/(k+1), the last k used */
    fx_const *reciprocal;    /* per series d: 1/d_v, the last v used */
    fx_const tau;            /* of a sum, times 2^-d */

    fx_compiled compiled;
    int *will_store; /* while compiling, per series: orders stored when this place is reached */

    size_t bytes; /* allocated */

    mpz_t z, z2;
    mpfr_t f, f2, f3, g, g2; /* working precision and more; g, g2 for functions */
    mpfr_t *kept;            /* values of constants */
    bool *has_kept;

    /* status */
    int raised;        /* bits by which block exponents were raised since begin, the largest of all series */
    int raised_series; /* and the series */
    bool singular;     /* a division by zero, or a value that is not a number, since begin */
};

/* fixed.c: everything outside the order loop, and its rare paths */
fx *cns_fx_create(int n_series, int order, mpfr_prec_t prec, const fx_kernel *kernel);
void cns_fx_destroy(fx *F);
void cns_fx_begin(fx *F, double H);
void cns_fx_get(const fx *F, mpfr_t y, int a, int k);
void cns_fx_set(fx *F, int w, int k, const mpfr_t y, bool keep);
double cns_fx_get_2exp(const fx *F, long *e, int a, int k);
/* y = sum_{k <= n} a_k tau^k, 0 <= tau <= 2^(FX_REACH/8), with an error below 3 (n+1) 2^(e-W). Costs least
 * where tau has few bits. */
void cns_fx_sum(fx *F, mpfr_t y, int a, int n, const mpfr_t tau);
/* y = sum_{k <= n} k a_k tau^(k-1), n <= FX_MAX_SLOPE, made from the stored coefficients with an error below
 * 3 (n+1) 2^(e-W) / tau, tau > 0; *largest: log2 of its largest term times tau, to a bit, -HUGE_VAL if all
 * vanish. */
void cns_fx_slope(fx *F, mpfr_t y, double *largest, int a, int n, const mpfr_t tau);

long cns_fx_learnt(const fx *F, int a); /* the block exponent the next expansion will take */
void cns_fx_set_exponent(fx *F, int a, long e);
void cns_fx_fill(fx *F, int a, int k);      /* zeros in orders stored..k */
void cns_fx_choose(fx *F, int w, int k);    /* exponent of w, from the accumulator about to be stored at k */
void cns_fx_raise(fx *F, int w, int k);     /* higher exponent, so that the accumulator fits at k */
void cns_fx_sums(fx *F, int w, int k);      /* D_j anew for all stored j >= k, if kept */
void cns_fx_want(fx *F, int a, int parts);  /* more parts */
void cns_fx_prepare_constant(fx *F, int c); /* constant[c] */
void cns_fx_prepare_step(fx *F, int c);     /* step_const[c] */
const fx_const *cns_fx_reciprocal(fx *F, int d, int v);
bool cns_fx_orient(fx *F, int a, int b); /* parts for a product a b; true: b is read forwards */
/* Compiles order k, as traced, into F->compiled, which serves the orders after it, too. False: these calls,
 * or the series as they are, cannot be compiled. */
bool cns_fx_compile(fx *F, const cns_trace *trace, int k);
void cns_fx_ratio(fx *F, long p, long q); /* acc *= p / q, slowly */
void cns_fx_shift(int64_t *out, const int64_t *t, int rows, int t_rows, long shift); /* t 2^shift, floor */

const fx_kernel *cns_fx_kernel_find(const char *name); /* "auto": the best; NULL: this machine has it not */
extern const fx_kernel cns_fx_kernel_portable;
#if defined(__x86_64__) && defined(__GNUC__)
#define FX_HAVE_IFMA 1
extern const fx_kernel cns_fx_kernel_avx512ifma;
#endif

#endif
