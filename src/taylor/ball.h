/* Right-hand sides in ball arithmetic (Arb): enclosures over whole boxes, every rounding included. */
#ifndef CNS_TAYLOR_BALL_H
#define CNS_TAYLOR_BALL_H

#include "cns/program.h"
#include "num/flint.h"

/* y encloses the number that the text of x says, exactly. */
void cns_ball_number(arb_t y, const cns_number *x, slong prec);

/* f[i] encloses d state_i/dt at every point of the box x[0..states-1]. Where an abs() may have either sign,
 * its tangent encloses both. p is finished. CNS_NUMERIC: not defined everywhere in the box. */
cns_code cns_ball_derivatives(const cns_program *p, arb_srcptr x, arb_ptr f, slong prec, cns_error *err);

/* y[i] encloses derived quantity i at every point of the box; not finite where it is not defined everywhere.
 */
void cns_ball_outputs(const cns_program *p, arb_srcptr x, arb_ptr y, slong prec);

#endif
