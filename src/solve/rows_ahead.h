/* A trajectory sampled at the rows of a problem, in a thread of its own that runs some rows ahead, or in the
 * caller's. The samples are the same. Private to src/solve. */
#ifndef CNS_SOLVE_ROWS_AHEAD_H
#define CNS_SOLVE_ROWS_AHEAD_H

#include "cns/solve.h"
#include "events.h"
#include "integrate/trajectory.h"

typedef struct cns_ahead cns_ahead;

/* spec.flow.stop and spec.met are taken over: the problem's stop and cns_ahead_free() both end the thread. */
cns_ahead *cns_ahead_new(const cns_problem *p, const cns_trajectory_spec *spec, unsigned long first_row,
                         bool threaded, cns_error *err);
void cns_ahead_free(cns_ahead *a);

/* The sample of the next row, which stays valid until the next call. The meetings up to that row, and with
 * the last row those of the whole step that reaches it, are added to `found`. */
cns_code cns_ahead_next(cns_ahead *a, const cns_sample **s, cns_found_list *found, cns_error *err);

bool cns_ahead_late(const cns_ahead *a); /* after CNS_STOPPED: was it the deadline? */

#endif
