/* The motion as a sequence of returns to a section, with the symmetries taken out: its late part found by
 * following the case's own trajectory. Private to src/study. */
#ifndef CNS_STUDY_MODES_RETURNS_H
#define CNS_STUDY_MODES_RETURNS_H

#include "cns/events.h"
#include "cns/system.h"
#include "study/orbit/image.h"

/* What is followed, and what counts as a return. With an angle: angle = k (2 pi / turns), any k; a return's
 * reduced state is its state turned back k times and, where the angle falls and there is a mirror image,
 * mirrored, so that all motions that are the same up to these symmetries have the same reduced states.
 * Without an angle: a state rises through a level that it crosses in its late motion. */
typedef struct cns_return_map {
    const cns_system *system;
    const cns_program *program; /* the system's, */
    const double *scales;       /* and its scales */
    const volatile sig_atomic_t *stop;
    const cns_model_motion
        *motion;       /* NULL: no angle, or one that does not turn or swing through its section */
    cns_images images; /* of the model */
    int n, d;          /* states; dynamic ones */
    int *index;        /* of the dynamic states */
    cns_event_condition section;
    int observable;
    long limit;   /* steps a trajectory is followed for, at most */
    double until; /* time to follow it for instead; 0: the limit */
} cns_return_map;

cns_code cns_return_map_open(cns_return_map *S, const cns_system *system, int observable, double until,
                             const volatile sig_atomic_t *stop, cns_error *err);
void cns_return_map_close(cns_return_map *S);

/* The factor that takes dynamic state i of a return to its reduced state. */
int cns_return_map_sign(const cns_return_map *S, int i, long turns, int direction);

/* Does a meeting with the section count as a return, after one of this direction (0: the first)? */
bool cns_return_map_counts(const cns_return_map *S, const cns_meeting *m, int before);

enum {
    CNS_MOST_RETURNS = 32, /* in one repetition */
    CNS_LATE_RETURNS = 2 * CNS_MOST_RETURNS
};

typedef enum cns_late_kind {
    CNS_LATE_OPEN, /* nothing of the others within the limit */
    CNS_LATE_STEADY,
    CNS_LATE_CYCLE,
    CNS_LATE_CHAOS
} cns_late_kind;

/* The late part of a motion. What stands under a kind applies to that kind only. */
typedef struct cns_late {
    cns_late_kind kind;
    int d;                    /* numbers in a reduced state: the dynamic states */
    int side;                 /* the direction, 1 or -1, in which the angle moved at the last return, */
    long turns;               /* and how many turns it had made by then */
    double time;              /* the motion was followed up to here, */
    double transient;         /* and its late part began here */
    double lambda, lambda_se; /* exponent of the second half of the time followed; se < 0: too short */
    bool looks_chaotic;       /* lambda is above zero by six standard errors, whatever the kind */

    /* log2, in scales, of the largest error at a return that the rounding noise of the run has grown to; a
     * run is trusted while that is below 2^-16: a larger one might turn the motion into another. */
    double noise_log2;
    bool trusted;        /* to the end */
    double trusted_time; /* the last return at which it was */

    /* CNS_LATE_CYCLE; CNS_LATE_OPEN with `known` returns: what it repeats best */
    int returns;      /* in one repetition, symmetries left out */
    int direction;    /* of the angle at z; 1 where reduced states are mirrored */
    int known;        /* at least `returns` returns, at most CNS_LATE_RETURNS; 0: none */
    mpfr_t *z;        /* the reduced states of the last `known` returns, d numbers each, the last one first */
    long cycle_turns; /* turns of the angle in one repetition */
    bool cycle_mirrored; /* one repetition ends in the mirror image */

    /* CNS_LATE_STEADY: the d dynamic states, and which of them are not exactly what they were at t = 0 */
    double *rest;
    bool *moves;

    int extrema; /* maxima of the observable that were met */
    struct {
        double t, value;
    } * extremum;
} cns_late;

/* digits 0: double. What looks chaotic is followed to the limit: it may be a transient. With digits > 0 a run
 * whose noise could decide something ends as CNS_LATE_OPEN at the horizon, a time, or, if that is 0, when it
 * looks chaotic. */
cns_code cns_late_find(const cns_return_map *S, long digits, double horizon, cns_late *late, cns_error *err);
void cns_late_clear(cns_late *late);

/* CNS_LATE_STEADY: is that more than a stay near a saddle? It is if the fixed point attracts all states that
 * move; those that have not moved at all, by a symmetry, never will. */
bool cns_late_attracts(const cns_return_map *S, const cns_late *late);

/* Working precision for so many digits; 0: that of double. */
mpfr_prec_t cns_modes_bits(long digits);

/* Flows of this accuracy: Taylor, adaptive; digits 0: double. */
cns_flow_spec cns_return_map_flow(const cns_return_map *S, const cns_program *p, const double *scales,
                                  long digits);

/* A number whose value is exactly x. */
void cns_number_from_mpfr(cns_number *n, mpfr_srcptr x);

#endif
