/* Events: the moments at which a trajectory meets given conditions, found from the polynomials of its steps.
 *
 * A condition is on one state: state = value, state = value + k period for any integer k, or an extremum of
 * the state. Follow a flow like this:
 *
 *     cns_flow_start(f, initial), cns_meetings_start(m), then again and again
 *     cns_flow_step(f, err), cns_meetings_follow(m, f, err), and for i = 0 .. cns_meetings_count(m) - 1
 *     cns_meetings_meeting(m, i).
 *
 * After each step the meetings inside it, t0 < t <= t1, are isolated by the Bernstein coefficients of its
 * polynomial, not by sampling, and refined to the precision of the flow: two in a step, and one exactly at
 * its end, are both found, each once. Nothing at t = 0 counts.
 *
 * A condition may be touched without being crossed. What can be said of that in finite precision is that the
 * distance has an extremum and is there below the noise of the step: then direction is 0. Two crossings whose
 * excursion is below that noise are such a touch, too.
 *
 * These meetings are those of one run. Whether their digits are right a proof tells: give the conditions to
 * a problem of cns/solve.h. */
#ifndef CNS_EVENTS_H
#define CNS_EVENTS_H

#include "cns/flow.h"

CNS_BEGIN_DECLS

typedef enum cns_condition_kind {
    CNS_CONDITION_VALUE,   /* state = value */
    CNS_CONDITION_PERIODS, /* state = value + k period */
    CNS_CONDITION_EXTREMUM /* the state's derivative vanishes; value is not used */
} cns_condition_kind;

typedef struct cns_event_condition {
    cns_condition_kind kind;
    int state;                /* 0 .. the program's states - 1 */
    cns_number value, period; /* in the units of the state; period > 0 */
} cns_event_condition;

void cns_event_condition_init(cns_event_condition *s); /* state 0 = 0, no period */
void cns_event_condition_clear(cns_event_condition *s);
void cns_event_condition_set(cns_event_condition *s, const cns_event_condition *from);

typedef struct cns_meeting {
    int condition; /* which of the conditions, 0 .. n - 1 */
    long k;        /* CNS_CONDITION_PERIODS: the state is value + k period */
    int direction; /* sign of the change of state (of its derivative, at an extremum: -1 is a maximum); 0:
                      touched only */
    double rate;   /* that change per unit of time */
    mpfr_t time;
    mpfr_t *state; /* all states; the condition's own is exactly the value, rounded */
} cns_meeting;

typedef struct cns_meetings cns_meetings;

/* n conditions, which are copied, on flows of programs with n_states states at prec bits; scales, one per
 * state, > 0, tell what is small. cns_meetings_free() frees it; NULL, and err->code says why: CNS_USAGE, no
 * such state or no positive period; CNS_MEMORY. */
cns_meetings *cns_meetings_new(const cns_event_condition *condition, int n, int n_states,
                               const double *scales, mpfr_prec_t prec, cns_error *err);
void cns_meetings_free(cns_meetings *s);

/* After cns_flow_start(). */
void cns_meetings_start(cns_meetings *s);

/* After each step: finds the meetings in it. CNS_NUMERIC: too many of them in one step;
 * CNS_MEMORY. */
cns_code cns_meetings_follow(cns_meetings *s, cns_flow *f, cns_error *err);

/* Those of the last step in order of time, i = 0 .. count - 1; valid until the next call. */
int cns_meetings_count(const cns_meetings *s);
const cns_meeting *cns_meetings_meeting(const cns_meetings *s, int i);

CNS_END_DECLS

#endif
