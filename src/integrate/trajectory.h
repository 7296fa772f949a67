/* A trajectory, row by row: a flow with its growth and its derived quantities. */
#ifndef CNS_INTEGRATE_TRAJECTORY_H
#define CNS_INTEGRATE_TRAJECTORY_H

#include "cns/flow.h"
#include "growth.h"

typedef struct cns_sample {
    int n_states, n_outputs;
    mpfr_t *state, *output; /* an output that is not defined there (0/0) is NaN */
    double growth;          /* log10 of the tangent growth since t = 0 */
    double error_log2;      /* log2 of the error that noise has grown to, in scales; -HUGE_VAL: none */
} cns_sample;

typedef struct cns_trajectory cns_trajectory;

typedef struct cns_trajectory_spec {
    cns_flow_spec flow;
    const cns_number *initial; /* one per state; outlives the trajectory */
    bool origins;              /* follow growth from times spread evenly up to `end`, for planning */
    double end;
    bool outputs;      /* compute the program's outputs, too */
    bool no_growth;    /* do not follow growth: samples have neither growth nor error */
    double unit_noise; /* if not 0, log2 of the noise of every step, instead of the flow's own */
    void (*stepped)(void *context, const cns_flow *f); /* called after each step; may be NULL */
    void *context;
    double deadline; /* of cns_seconds(); 0: none. After it, CNS_STOPPED with stopped_late */
} cns_trajectory_spec;

cns_trajectory *cns_trajectory_new(const cns_trajectory_spec *spec, cns_error *err);
void cns_trajectory_free(cns_trajectory *t);

/* Integrates as far as needed and evaluates at `time`; times must not decrease. */
cns_code cns_trajectory_at(cns_trajectory *t, const mpq_t time, cns_sample *s, cns_error *err);

/* The same in its parts, to look between the ends of steps: one step and its growth; the states and outputs
 * (not growth and error) at a time within the last step, any number of times in any order. */
cns_code cns_trajectory_step(cns_trajectory *t, cns_error *err);
void cns_trajectory_peek(cns_trajectory *t, const mpq_t time, cns_sample *s);

cns_flow *cns_trajectory_flow(cns_trajectory *t);
cns_growth *cns_trajectory_growth(cns_trajectory *t);
bool cns_trajectory_late(const cns_trajectory *t); /* was the deadline the reason? */

bool cns_sample_init(cns_sample *s, const cns_program *p, mpfr_prec_t prec); /* false: out of memory */
void cns_sample_clear(cns_sample *s);

#endif
