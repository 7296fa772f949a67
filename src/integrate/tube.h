/* A proven tube around a Taylor run: bounds of the distance between what the run has computed and the exact
 * solution from the exact initial values, at every time. An a posteriori method: nothing is assumed about how
 * the run was made; what is looked at is its polynomials, and the states that it goes on with.
 *
 * On each step the run's polynomials p solve the equations but for a defect g (taylor/defect.h), so that the
 * error e = x - p obeys e' = J e - g, with the Jacobian J averaged between x and p. It is carried along by
 * the tangents in coordinates that turn with the flow: e in Q r, where Q is orthogonal and r is a box. Over a
 * step the tangents V of the columns of Q are computed in double, and the same defect routine, applied to the
 * variational equations, bounds how far they are from those of every trajectory within the tube. At its end
 * V = Q' R by Gram-Schmidt, in the order of the columns, so that r' = |R| r + small: triangular matrices
 * multiply as their diagonals do, and the bound grows as the error does (Lohner; Nedialkov, Jackson, Corliss,
 * Appl. Math. Comput. 105 (1999) 21). That the exact solution stays in the tube, and exists, follows by
 * continuation: it would have to leave it within the step, and the logarithmic norm of J over boxes that
 * cover the tube says that it does not.
 *
 * What is proven rests on this file, on taylor/defect.c and the remainder rules of operations, on the bound
 * of roundings that the arithmetic states (arith.h), and on MPFR, GMP and FLINT. */
#ifndef CNS_INTEGRATE_TUBE_H
#define CNS_INTEGRATE_TUBE_H

#include "cns/flow.h"
#include "num/flint.h"

typedef struct cns_tube cns_tube;

/* For flows of a program whose states have so many bits. NULL: out of memory, or no tangents; err says which.
 */
cns_tube *cns_tube_new(const cns_program *p, mpfr_prec_t prec, cns_error *err);
void cns_tube_free(cns_tube *t);

/* At t = 0, f having been started with these exact values. */
void cns_tube_start(cns_tube *t, const cns_flow *f, const cns_number *initial);

/* After each step of f. There is no bound from here on, and err says why: CNS_NUMERIC: an expansion begins on
 * a singularity, or an equation divides by what may be zero within the tube; CNS_UNREACHED: the tube has
 * grown to the size of the motion, and with more digits would not. */
cns_code cns_tube_follow(cns_tube *t, const cns_flow *f, cns_error *err);

/* error[i] >= |x_i - exact solution| at a time within the last step (or at 0, before the first), x being what
 * was computed for that time, one number per state. */
void cns_tube_at(cns_tube *t, const cns_flow *f, const mpq_t time, const mpfr_t *x, mag_ptr error);

/* log10 of the largest growth of a disturbance of the initial values up to that time. */
double cns_tube_growth(cns_tube *t, const cns_flow *f, const mpq_t time);

#endif
