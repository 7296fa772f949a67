/* The events of a run, with what is certain of them. */
#ifndef CNS_SOLVE_EVENTS_H
#define CNS_SOLVE_EVENTS_H

#include "cns/solve.h"
#include "integrate/meeting_bound.h"

/* A queue of meetings of one trajectory, in order of time: copies of what it found. */
typedef struct cns_found {
    cns_meeting m;
    double noise_log2;   /* what noise has grown to there, in scales */
    bool enclosed;       /* within a tube, which proves it; then the errors of */
    mpfr_t time_error;   /* its time, */
    mpfr_t *state_error; /* and its states */
} cns_found;

typedef struct cns_found_list {
    int first, n, room; /* at[first] .. at[n - 1] */
    int n_states;
    cns_found *at;
} cns_found_list;

/* As cns_trajectory_spec.met; `list` is a cns_found_list with its n_states set. */
cns_code cns_found_add(void *list, const cns_meeting *m, const cns_meeting_bound *bound, double noise_log2,
                       cns_error *err);
void cns_found_move(cns_found_list *to, cns_found_list *from); /* all of them, to the end of `to` */
void cns_found_drop(cns_found_list *list, int i);
void cns_found_clear(cns_found_list *list);

/* Where noise shows at a meeting. A deviation of the states, in scales, moves a crossing in time, and with
 * it all states, by as much as it is large, in their units, against the rate there: by 2^loss times itself. A
 * touch moves by the root of that, as does the zero of a parabola that is lifted. */
double cns_event_loss_log2(const cns_problem *p, const cns_meeting *m);

/* The meeting of the coarser run that belongs to the first of the finer one: the i-th meetings of both with
 * the same condition belong together. -1: it is not there. */
int cns_event_partner(const cns_found_list *fine, const cns_found_list *coarse);

/* The number of places, at most `most`, to which time and states of an event are certain; -1: none are, or
 * the runs disagree on what happens. coarse NULL: by the tube of the fine one. *error_log10: log10 of the
 * bound of its error; HUGE_VAL: there is none. Where there is one, time_error is the bound of the time alone.
 */
long cns_event_places(const cns_problem *p, const cns_found *fine, const cns_found *coarse,
                      const bool *constant, cns_places places, long most, double *error_log10,
                      mpfr_t time_error);

/* Tells the sink of an event, to `count` places or, without a proof (count < 0), with so many digits. */
cns_code cns_event_tell(const cns_problem *p, const cns_meeting *m, const bool *constant, cns_places places,
                        long count, long digits, cns_error *err);

#endif
