/* Shooting: the flow over a time, and its derivatives. Private to src/study.
 *
 * States and tangents are integrated together, from a state of the dynamic states to a time, and evaluated
 * there. Two shootings of which one is `fine` differ in order, tolerance and every step, besides in digits.
 */
#ifndef CNS_STUDY_ORBIT_SHOOTING_H
#define CNS_STUDY_ORBIT_SHOOTING_H

#include "cns/flow.h"
#include "cns/system.h"
#include "taylor/jet.h"

typedef struct cns_shooting_spec {
    const cns_system *system; /* outlives the shooting */
    long digits;
    bool fine;
    bool tangents; /* are they wanted? */
    const volatile sig_atomic_t *stop;
} cns_shooting_spec;

typedef struct cns_shooting {
    int n, d;             /* states of the system; dynamic ones, */
    int *index;           /* which they are */
    const double *scales; /* of the system, per state */
    mpfr_prec_t prec;
    mpfr_t *x;    /* after a run: the d dynamic states at its end, */
    mpfr_t *m;    /* d x d, m[i d + j] = d x_i / d z_j, */
    mpfr_t *f;    /* the rates of change at its end, */
    mpfr_t trace; /* and the integral of the trace of the Jacobian; both only with tangents */
    long steps;
    /* private: */
    bool tangents;
    double *all_scales;
    cns_program *program;
    cns_flow *flow;
    cns_jet *field;
    mpfr_t *state;
} cns_shooting;

cns_code cns_shooting_open(cns_shooting *s, const cns_shooting_spec *spec, cns_error *err);
void cns_shooting_close(cns_shooting *s);

/* From z, d numbers, over `time`, > 0. CNS_NUMERIC: the trajectory does not get there. */
cns_code cns_shooting_run(cns_shooting *s, const mpfr_t *z, mpfr_srcptr time, cns_error *err);

#endif
