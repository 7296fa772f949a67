/* Block fixed point: power series as blocks of fixed-point coefficients, private to the fast arithmetic.
 *
 * All coefficients of a series share one exponent, its block exponent e. Coefficients are expected to fall by
 * d bits from order to order (the decay), so what is held is the series in time scaled by R = H 2^d instead
 * of H, whose coefficients are of one size: A_k = a_k 2^(d k) = x_k 2^(e+1),   -1/2 <= x_k < 1/2, that is
 * |a_k| <= 2^e 2^(-d k). What is stored is u_k = x_k + 1/2 in [0, 1): non-negative, so that products of limbs
 * need no signs, with the same bias 1/2 at every order. It is an array of limbs of 52 bits, limb 0 the most
 * significant. W, the window, is the number of bits of x_0. Order k keeps rows(k) = max(1, ceil((W - d k + r
 * k)/52)) limbs,   r = FX_REACH/8, so that a_k tau^k is accurate to 2^(e+1-W) at every order and for every
 * tau up to 2^r: the number of bits that are kept shrinks by d - r per order, and depends on k alone.
 *
 * A number outside of a series, as the accumulator, is an array t[0..rows] with the value
 * sum_i t[i] 2^(-52 i) times a power of two: t[0] is its integer part, which has the sign. It is normalised
 * when 0 <= t[i] < 2^52 for all i >= 1. Sums are not normalised after each addition: their limbs are signed
 * 64-bit numbers, and `load` bounds |t[i]| / 2^52 for i >= 1, so that carries are made before one could
 * overflow.
 *
 * A convolution multiplies limb by limb: the product of limb i of u_j with limb j' of v_(n-j), counted from
 * 0, has the weight 2^(-52 (i + j' + 2)). It takes the pairs with i + j' < M = rows(n), both halves of each
 * product of 104 bits, and sums them exactly, in whatever order a kernel likes. The pairs left out are, for
 * each term of the convolution, at most M of weight below 2^(-52 M) (those with i + j' = M), and beyond those
 * less than one such in all, so 0 <= exact - kept < (hi - lo + 1) (M + 1) 2^(-52 M) 2^(e_a + e_b + 2) in the
 * scale of A_n. The bias of the u is taken off the sum with their partial sums D_k = u_0 + ... + u_k: sum x_j
 * y_(n-j) = sum u_j v_(n-j) - (sum u_j + sum v_j)/2 + (number of terms)/4. */
#ifndef CNS_ARITH_FIXED_FIXED_H
#define CNS_ARITH_FIXED_FIXED_H

#include <gmp.h>
#include <mpfr.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "arith/arith.h"

#define FX_BITS     52
#define FX_REACH    2 /* sums serve tau up to 2^(FX_REACH/8) */
#define FX_MASK     ((INT64_C(1) << FX_BITS) - 1)
#define FX_HALF     (INT64_C(1) << (FX_BITS - 1)) /* 1/2 as limb t[1] */
#define FX_MAX_LOAD 256                           /* of numbers: |t[i]| < 2^60 */
/* Orders of a slope: its sum is n/2 sum_k 2^(-3k/4) at most, so that its integer part stays below 2^10. */
#define FX_MAX_SLOPE 640
#define FX_LANE_LOAD 1000 /* of one lane of a column (fx.lanes): |lane| < 2^62 */
#define FX_SUM_LOAD  400  /* of a column summed over its eight lanes: twice the sum is below 2^62 */
#define FX_CORR_LOAD 800  /* of what is taken off twice that sum (fx.corr): the difference is below 2^63 */

/* A series is kept in up to four forms, in the order that whoever reads it wants. Values x_k always are;
 * these are made when a convolution first asks for them, and kept up from then on. */
enum {
    FX_FWD = 1, /* limbs u_k with k rising: the operand of a convolution that is read forwards */
    FX_REV = 2, /* limbs u_k with k falling: the other operand */
    FX_SUMS = 4 /* D_k */
};

typedef struct fx_series {
    bool live;       /* it has a block exponent; without one it is zero so far */
    bool constant;   /* kept across expansions */
    int parts;       /* FX_FWD, FX_REV, FX_SUMS: those that are kept */
    int stored;      /* orders 0..stored-1 hold values */
    long exp;        /* the block exponent e */
    int64_t peak;    /* the largest first limb of |x_k| of all orders stored */
    uint64_t *fwd;   /* limb l of order k at fwd[l * stride + k] */
    uint64_t *rev;   /* limb l of order k at rev[l * stride + order - k] */
    int64_t *record; /* of order k, at record + k * fx.record: the number D_k, eight zeros, and the number
                        x_k, which begins at fx.value */
} fx_series;

/* A factor, sign * 2^exp * sum_{i >= 1} limb[i] 2^(-52 i). limb[-pad] to limb[0], and limbs after `used`, are
 * zero: a multiplication may read them. */
typedef struct fx_const {
    bool valid;
    int sign;
    int used; /* limbs after this one are zero */
    int64_t *limb;
    long exp;
    int index;        /* of one made for an order k, or from coefficient k of a series: k */
    int for_rows;     /* of next_const: for accumulators of so many limbs */
    long divisor_exp; /* of a reciprocal 1/d_v: the exponent of d_v */
} fx_const;

typedef struct fx_number {
    int64_t *t; /* zero from t[-pad] to t[-1] */
    int rows;
    int load; /* 0: zero, nothing has been added yet */
    bool normal;
    long exp; /* of the power of two */
} fx_number;

typedef struct fx fx;

/* A compiled order. Called one by one (order_by_calls.h), each primitive compares exponents to find the
 * shifts that its terms need, and loads to know when to carry. All numbers of order k have exponents that
 * depend on k by the same term, -d k, so as long as block exponents stay, the shifts are the same at every
 * order. A compiled order is the trace of an order (arith.h) with these shifts and carries worked out: a list
 * of steps, which need no comparisons, and whose sums stay in one vector register. compile.c makes it,
 * order_compiled.h runs it. */

/* For orders of at most so many limbs: a sum has an integer part, these limbs, and one more where it is a
 * product with a factor, together the eight words of a vector. */
enum { FX_ONE_ROWS = 6 };

typedef struct fx_step {
    enum {
        FX_DO_COEF,   /* adds x_k of series a */
        FX_DO_SCALED, /* adds c x_k */
        FX_DO_CONV, /* a product of series a and b goes into the lanes; the last one of its lanes closes them:
                       their sum is added */
        FX_DO_SQUARE, /* the same of a and a */
        FX_DO_STORE   /* the accumulator, times a factor, becomes a coefficient of w */
    } kind;
    int group; /* of the trace, the call that began this sum: from it on the calls can be made one by one */

    /* Adding a term: accumulator = accumulator 2^(up - down) +- term 2^(up_x - down_x). */
    bool fresh;   /* the first term: the accumulator is the term */
    bool carry;   /* the accumulator is normalised before, also before it is stored */
    int up, up_x; /* at most one of these four is not zero */
    long down, down_x;
    uint64_t flip; /* ~0: the term is subtracted; 0: added */

    const fx_series *a, *b;
    const fx_const *c;
    int weight;       /* FX_DO_COEF: of x_k; 0 stands for 1 */
    int weight_grows; /* by one per order */
    int order;        /* at this order the weight is `weight` */
    int sign, lo;     /* of a product: sum_{j=lo..k-above} a_j b_{k-j} */
    int above;
    bool open, close; /* the first, the last product of its lanes */

    fx_series *w;
    int next;   /* stored is coefficient k + next: 1 for a state, else 0 */
    bool empty; /* the accumulator is an empty sum */
    enum {
        FX_TIMES_NOTHING,
        FX_TIMES_CONST,   /* times c */
        FX_TIMES_INVERSE, /* times 1/k */
        FX_TIMES_NEXT     /* times c/(k + 1), which is kept in *made */
    } times;
    fx_const *made;
    long exp; /* by so many bits the accumulator's exponent, with that of c if c is the factor itself, exceeds
                 the coefficient's: the shift when it is stored */
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
    /* acc = sum_{k <= n} A_k c^k, c in [0, 1), its exponent being 0; for a slope
     * acc = sum_{k <= n} k A_k c^(k-1) 2^-d, n <= FX_MAX_SLOPE. */
    void (*sum)(fx *F, int a, int n, const fx_const *c, bool slope);
    /* Runs the compiled order for orders *k..to-1; rows[*k] <= FX_ONE_ROWS. Returns NULL, or the step at
     * which it had to stop, at order *k: a coefficient is too large for its block exponent, and the sum that
     * it is has not been stored. */
    const fx_step *(*run)(fx *F, const fx_compiled *C, int *k, int to);
} fx_kernel;

struct fx {
    const fx_kernel *kernel;
    int n_series, order;
    int decay, next_decay;                 /* d; next_: from the next begin on */
    mpfr_prec_t max_prec, prec, next_prec; /* bits; max_prec is what memory was allocated for */
    long window;          /* W, in bits: prec and what roundings cost (window_bits, fixed.c) */
    int limbs, max_limbs; /* rows(0), and the most it can be */
    int width;            /* words of a number's array from t[0] on, a multiple of 8 */
    int pad;              /* zero words before t[0] */
    int record, value;    /* words of a record of fx_series, and where in it x_k begins */
    size_t stride;        /* words between limb l and limb l + 1 of fwd and rev, a multiple of 8 */
    double H;
    int *rows; /* rows(k), k = 0..order+1 */
    fx_series *series;

    /* Products being summed. A product has its columns, one per weight 2^(-52 p); column p is eight lanes at
     * lanes + 8 p, so that eight terms of a convolution are summed side by side. All products in the lanes
     * have the same exponent and the same number of rows. */
    int64_t *lanes;
    bool lanes_used; /* there are products in them */
    int lanes_rows;
    int lanes_load; /* bounds |lane| / 2^52 */
    long lanes_exp;
    long terms;    /* of the convolutions in the lanes, less those subtracted */
    int64_t *corr; /* their sums of u, to take the bias off: a number of as many rows */
    int corr_load;
    fx_number acc;              /* the accumulator, but for what is still in the lanes */
    int64_t *tmp, *tmp2, *tmp3; /* arrays of numbers, for whoever needs one */
    int64_t *zeros;             /* the number zero */

    fx_const *inverse_order; /* 1/(k+1), k = 0..order */
    fx_const *constant;      /* per series: a_0, where it is a factor */
    fx_const *step_const;    /* per series: a_0 H; and one more, H */
    fx_const *next_const;    /* the same times 1/(k+1), of the last k used */
    fx_const *reciprocal;    /* per series: 1/a_v, of the last v used */
    fx_const tau;            /* tau 2^-d of a sum */

    fx_compiled compiled;
    int *will_store; /* while an order is compiled, per series: `stored` when the step is reached */

    size_t bytes; /* of all memory */

    mpz_t z, z2;             /* scratch */
    mpfr_t f, f2, f3, g, g2; /* scratch of as many bits as a factor has; g, g2: those of a coefficient */
    mpfr_t *kept;            /* per series: the value of a constant, to convert again for another window */
    bool *has_kept;

    /* Since begin: */
    int raised;        /* the most bits by which a block exponent was raised, */
    int raised_series; /* and of which series */
    bool singular;     /* a division by zero, or a value that is not a number or out of range: the series are
                          worthless */
};

/* fixed.c: everything outside the order loop, and its rare paths. The first ones are members of
 * cns_arith_ops. */
fx *cns_fx_create(int n_series, int order, mpfr_prec_t prec, const fx_kernel *kernel);
void cns_fx_destroy(fx *F);
void cns_fx_begin(fx *F, double H);
void cns_fx_get(const fx *F, mpfr_t y, int a, int k);
void cns_fx_set(fx *F, int w, int k, const mpfr_t y, bool keep);
double cns_fx_get_2exp(const fx *F, long *e, int a, int k);
void cns_fx_leading(const fx *F, double *m, long *e, int a, int n); /* see arith.h */
/* y = sum_{k <= n} a_k tau^k, 0 <= tau <= 2^(FX_REACH/8), with an error below 3 (n+1) 2^(e-W). Costs least
 * where tau has few bits. */
void cns_fx_sum(fx *F, mpfr_t y, int a, int n, const mpfr_t tau);
/* y = sum_{k <= n} k a_k tau^(k-1), n <= FX_MAX_SLOPE, made from the stored coefficients with an error below
 * 3 (n+1) 2^(e-W) / tau, tau > 0; *largest: log2 of its largest term times tau, to a bit, -HUGE_VAL if all
 * vanish. */
void cns_fx_slope(fx *F, mpfr_t y, double *largest, int a, int n, const mpfr_t tau);

/* The block exponent that the next expansion will give to a, from the coefficients of this one; LONG_MIN:
 * they are all zero, and tell nothing. */
long cns_fx_learnt(const fx *F, int a);
void cns_fx_set_exponent(fx *F, int a, long e); /* LONG_MIN: none */
void cns_fx_fill(fx *F, int a, int k);          /* zeros at orders stored..k */
/* Where the accumulator is about to be stored as coefficient k of w: its first block exponent, or a higher
 * one so that it fits. */
void cns_fx_choose(fx *F, int w, int k);
void cns_fx_raise(fx *F, int w, int k);
void cns_fx_sums(fx *F, int w, int k);      /* where D_j are kept: makes them anew for all stored j >= k */
void cns_fx_want(fx *F, int a, int parts);  /* a keeps these parts, too */
bool cns_fx_orient(fx *F, int a, int b);    /* parts for a product a b; true: b is the one read forwards */
void cns_fx_prepare_constant(fx *F, int c); /* makes constant[c] */
void cns_fx_prepare_step(fx *F, int c);     /* makes step_const[c], or that of H for c = -1 */
const fx_const *cns_fx_reciprocal(fx *F, int d, int v); /* makes reciprocal[d] for d_v */
void cns_fx_ratio(fx *F, long p, long q);               /* acc *= p / q, rounded down, for any p and q */
void cns_fx_shift(int64_t *out, const int64_t *t, int rows, int t_rows, long shift); /* floor(t 2^shift) */

/* Compiles order k, as traced, into F->compiled, which serves the orders after it, too. False: these calls,
 * or the series as they are, cannot be compiled. */
bool cns_fx_compile(fx *F, const cns_trace *trace, int k);

const fx_kernel *cns_fx_kernel_find(const char *name); /* "auto": the best; NULL: this machine has it not */
extern const fx_kernel cns_fx_kernel_portable;
#if defined(__x86_64__) && defined(__GNUC__)
#define FX_HAVE_IFMA 1
extern const fx_kernel cns_fx_kernel_avx512ifma;
#endif

#endif
