/* What a tube proves of a meeting of the run with a condition: that the exact solution meets it, too, once,
 * in the same direction, at about the same time. Not that there are no other meetings. */
#ifndef CNS_INTEGRATE_MEETING_BOUND_H
#define CNS_INTEGRATE_MEETING_BOUND_H

#include "cns/events.h"
#include "num/flint.h"

typedef struct cns_meeting_bound {
    bool proven;   /* false: the rest says nothing */
    mag_t time;    /* of the distance of the two meetings in time */
    mag_ptr state; /* and of the states there, one per state */
} cns_meeting_bound;

void cns_meeting_bound_init(cns_meeting_bound *b, int n_states);
void cns_meeting_bound_clear(cns_meeting_bound *b, int n_states);

/* tangent: cns_whole_tangent_program() of p, of one direction. error: of the states of m, against the exact
 * solution at the time of m. prec: of the states. */
void cns_meeting_prove(cns_meeting_bound *b, const cns_program *p, const cns_program *tangent,
                       const cns_event_condition *c, const cns_meeting *m, mag_srcptr error, slong prec);

#endif
