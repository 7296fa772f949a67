/* The defect of an expansion: how far its polynomials are from solving the equations, as a proven bound.
 *
 * An expansion gives polynomials p_i(tau), one per state, 0 <= tau <= 1, t = t0 + H tau. Nothing is assumed
 * about how they were made. Its defect is g_i = p_i' - H f_i(p), with H here the length of the
 * step, and what is bounded is its integral,
 *
 *     int_0^1 |g_i(tau)| dtau <= cns_defect_of(i).
 *
 * Truncation, rounding, a wrong constant, a wrong sign of an abs(): all errors of a step are in it, or in the
 * jump from p(1) to the state that the next step begins with.
 *
 * Every node v of the program has a polynomial w_v, too: the series that its recurrence has made, of degree
 * below N, the order of the expansion; of a folded node, which has none, the sums and products of others that
 * it stands for, cut off below degree N. With W_v(tau) for the exact operation on the exact polynomials p of
 * the states, two numbers per node have |W_v - w_v| <= e0_v + e1_v tau^N. They follow from those of the
 * operands by the rule of each operation (op/, `remainder`), which asks by how much the recurrence can have
 * missed the identity that defines it (a rounding of the arithmetic, cns_defect_unit), and how large the
 * terms of order N and higher are that the identity has. The tail is integrated: it counts 1/(N+1).
 *
 * All bounds are mag_t of FLINT, rounded up. Sums over orders are made in double: sums of products of
 * non-negative numbers, whose relative error is below the number of operations times 2^-53, times a factor
 * that makes up for it; numbers too small for a double are rounded up to 1e-300 of the largest. */
#ifndef CNS_TAYLOR_DEFECT_H
#define CNS_TAYLOR_DEFECT_H

#include "num/flint.h"
#include "taylor/jet.h"

typedef struct cns_defect cns_defect;

/* For expansions by this jet, which must outlive it. NULL: out of memory. */
cns_defect *cns_defect_new(const cns_jet *J, cns_error *err);
void cns_defect_free(cns_defect *d);

/* Reads the jet's last expansion, made with this H, for times up to `length` after it. From here on tau is
 * the time in units of that: tau = (t - t0) / length. Errors of states are zero, of constants those of their
 * conversion. CNS_NUMERIC: it began on a singularity, and is not of the kind that can be bounded. */
cns_code cns_defect_read(cns_defect *d, double H, double length, cns_error *err);

/* The exact state is within e0 + e1 tau^N of the polynomial: a solution near it, or one that it approximates.
 */
void cns_defect_widen(cns_defect *d, int state, const mag_t e0, const mag_t e1);

/* How far beyond a zero an abs() holds its sign: the quantity u under it has sign(u) u >= -overshoot up to
 * the end of the step, which is `end` in units of the jet's H. The largest over all such quantities; zero
 * where all signs are right. */
void cns_defect_find_overshoot(cns_defect *d, const arb_t end);
void cns_defect_set_overshoot(cns_defect *d, const mag_t overshoot);
const mag_struct *cns_defect_overshoot(const cns_defect *d);

/* The remainders of all nodes. CNS_NUMERIC: a divisor or radicand is not bounded away from zero. */
cns_code cns_defect_bound(cns_defect *d, cns_error *err);

/* After that: the integral above. */
void cns_defect_of(mag_t g, const cns_defect *d, int state);

/* Of the polynomials of states, after cns_defect_read(). */
int cns_defect_order(const cns_defect *d);
/* Coefficient k as a double, relative error (3 k + 4) 2^-53, times 2^*e. */
double cns_defect_coefficient(const cns_defect *d, int state, int k, long *e);
/* The polynomial about `begin`, in units of a part of the step: p_i(begin + part s) = sum_k c_k s^k, for
 * 0 <= s <= 1, c_k up to order n as doubles, times 2^*e. error bounds what they miss by rounding, summed, and
 * tail the sum of |c_k| of the orders beyond. */
void cns_defect_shifted(const cns_defect *d, int state, double begin, double part, double *c, int n, long *e,
                        mag_t error, mag_t tail);
/* p_i at tau (0 <= tau <= 1 + a little), by leading terms in 53 bits; and sum k |p_k|. */
void cns_defect_value(arb_t y, const cns_defect *d, int state, const arb_t tau);
void cns_defect_slope(mag_t y, const cns_defect *d, int state);
/* The rounding of one coefficient of the state, summed over its series. */
void cns_defect_rounding(mag_t y, const cns_defect *d, int state);

#endif
