/* A trajectory, row by row: a flow and what follows it, the growth of errors, its events and its derived
 * quantities. */
#ifndef CNS_INTEGRATE_TRAJECTORY_H
#define CNS_INTEGRATE_TRAJECTORY_H

#include "cns/events.h"
#include "cns/flow.h"
#include "growth.h"
#include "meeting_bound.h"
#include "tube.h"

typedef struct cns_sample {
    int n_states, n_outputs;
    mpfr_t *state, *output; /* an output that is not defined there (0/0) is NaN */
    double growth;          /* log10 of the tangent growth since t = 0 */
    double error_log2;      /* log2 of the error that noise has grown to, in scales; -HUGE_VAL: none */
    mag_ptr state_error, output_error; /* with a tube: proven bounds of the errors; NULL: not wanted */
} cns_sample;

typedef struct cns_trajectory cns_trajectory;

typedef struct cns_trajectory_spec {
    cns_flow_spec flow;
    const cns_number *initial; /* one per state; NULL: cns_trajectory_start() will tell */
    double end;                /* the last time that will be asked for */
    bool origins;              /* follow growth from times spread evenly up to `end`, for planning */
    double most_steps; /* CNS_USAGE once steps show that there will be more up to `end`; 0: no limit */
    bool outputs;      /* compute the program's outputs, too */
    bool tube;       /* prove bounds of the errors as it goes (tube.h); growth is then that of its tangents */
    bool no_growth;  /* do not follow growth: samples have neither growth nor error */
    bool unit_noise; /* the noise of every step is 1, in scales, instead of the flow's own */
    void (*stepped)(void *context, const cns_flow *f); /* called after each step; may be NULL */
    void *context;
    double deadline; /* of cns_seconds(); 0: none. After it, CNS_STOPPED, and cns_trajectory_late() */
    const cns_event_condition *conditions; /* whose meetings are found in every step; copied. NULL: none */
    int n_conditions;
    /* Called for each meeting, in order of time and before any sample later than it, with log2 of the error
     * that noise has grown to there (-HUGE_VAL: growth is not followed), and, with a tube, what that proves
     * of it; may be NULL. */
    cns_code (*met)(void *context, const cns_meeting *m, const cns_meeting_bound *bound, double noise_log2,
                    cns_error *err);
    void *met_context;
} cns_trajectory_spec;

cns_trajectory *cns_trajectory_new(const cns_trajectory_spec *spec, cns_error *err);
void cns_trajectory_free(cns_trajectory *t);

/* Back to t = 0, with these states. */
void cns_trajectory_start(cns_trajectory *t, const cns_number *initial);

/* Integrates as far as needed and evaluates at `time`; times must not decrease. */
cns_code cns_trajectory_at(cns_trajectory *t, const mpq_t time, cns_sample *s, cns_error *err);

/* spec.met for those meetings of the last step that are later than the last sample. */
cns_code cns_trajectory_tell_rest(cns_trajectory *t, cns_error *err);

/* The same in its parts, to look between the ends of steps: one step, its growth and its meetings; the states
 * and outputs (not growth and error) at a time within the last step, any number of times in any order. */
cns_code cns_trajectory_step(cns_trajectory *t, cns_error *err);
void cns_trajectory_peek(cns_trajectory *t, const mpq_t time, cns_sample *s);

/* From now on growth is not followed; what it costs is saved. */
void cns_trajectory_leave_growth(cns_trajectory *t);

cns_flow *cns_trajectory_flow(cns_trajectory *t);
cns_growth *cns_trajectory_growth(cns_trajectory *t);           /* NULL: not followed from the beginning */
const cns_meetings *cns_trajectory_meetings(cns_trajectory *t); /* of the last step; NULL: no conditions */
bool cns_trajectory_late(const cns_trajectory *t);              /* was the deadline the reason? */

bool cns_trajectory_unbounded(const cns_trajectory *t); /* was the end of the tube the reason? */

bool cns_sample_init(cns_sample *s, const cns_program *p, mpfr_prec_t prec); /* false: out of memory */
void cns_sample_want_errors(cns_sample *s);                                  /* of a trajectory with a tube */
void cns_sample_clear(cns_sample *s);

#endif
