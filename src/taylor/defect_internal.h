/* The inside of a defect, for the rules of operations. Private to src/taylor.
 *
 * Coefficient k of the polynomial in row r is c_r[k] 2^(x_r - fall_k), fall_k = floor(k times the mean fall
 * of the coefficients): so the numbers c stay within the range of a double at any order. S_r[k] 2^(x_r -
 * fall_k) is an upper bound of the sum of the sizes of coefficients k and higher. Rows 0.. are those of
 * states; then come those of the nodes that are series and no states. */
#ifndef CNS_TAYLOR_DEFECT_INTERNAL_H
#define CNS_TAYLOR_DEFECT_INTERNAL_H

#include "defect.h"
#include "jet_internal.h"

struct cns_defect {
    const cns_jet *J;
    const cns_program *p;
    int N;                  /* of this expansion: states have coefficients 0..N, other nodes 0..N-1 */
    int most;               /* the largest N */
    double length, stretch; /* of the step; in units of the jet's H */
    int *row; /* per node; -1: it has none: a constant, a folded node, or one that is not needed */
    int rows;
    long *fall;          /* per order 0..N+1 */
    double *split;       /* per order i: 2^(fall_N - fall_i - fall_(N-i)), 1 or 2 */
    double slack;        /* a sum of products over the orders, made in double, times this is an upper bound */
    double *c, *S;       /* most + 2 numbers for each row */
    long *x;             /* per row */
    double *down, *flat; /* per order: 2^(fall_k - fall_(k+1)), 2^-fall_k */
    double *m;           /* scratch: coefficients times 2^e */
    long *e;
    double *power; /* of `stretch`, k-th, times 2^power_e */
    long *power_e;
    double *plain; /* scratch: coefficients without `fall`, most + 2 */
    /* Per node: sum of |w_k|; what roundings are relative to, at least that; the remainders. */
    mag_ptr norm, size, e0, e1;
    arb_ptr constant;   /* per node, the constants: the exact value */
    long constants_for; /* log2 of the unit that their errors were read for */
    mag_t unit;         /* roundings, in sizes (arith.h) */
    mag_t least;        /* and what underflow adds to each */
    mag_t overshoot;
};

/* For the rules. Each begins with cns_remainder_begin(): e0 becomes what rounding makes of a sum of terms of
 * the sizes `terms`, or, of a folded node, zero, its size `terms` and its norm `norm`; e1 becomes zero. */
void cns_remainder_begin(cns_defect *d, int v, const mag_t terms, const mag_t norm);
/* Sums over i + j >= N of |a_i| |b_j|, and of i |a_i| |b_j|. */
void cns_defect_products(mag_t y, const cns_defect *d, int a, int b);
void cns_defect_euler_products(mag_t y, const cns_defect *d, int a, int b);
void cns_defect_leading(mag_t y, const cns_defect *d, int a);     /* |a_N|, which states alone have */
void cns_defect_from(mag_t y, const cns_defect *d, int a, int k); /* sum of |a_j|, j >= k */
/* y <= |w_v(tau)| for 0 <= tau <= 1, w_v being the polynomial; false: no bound above zero is found. */
bool cns_defect_lowest(mag_t y, const cns_defect *d, int v);
/* A bound of |exact node x| at all times when |exact node u| <= z, u being an operand of x, of one of its
 * operands, and so on. */
void cns_defect_where_small(mag_t y, const cns_defect *d, int x, int u, const mag_t z);

#endif
