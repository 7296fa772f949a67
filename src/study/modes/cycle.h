/* Periodic motions as fixed points of the return map with the symmetries taken out, by Newton's method with
 * the variational equations. Private to src/study. */
#ifndef CNS_STUDY_MODES_CYCLE_H
#define CNS_STUDY_MODES_CYCLE_H

#include "returns.h"

typedef struct cns_cycle {
    int d, returns, direction; /* as in cns_late */
    long turns;                /* of the angle in one repetition, counted along `direction` at its start */
    bool mirrored;             /* one repetition ends in the mirror image */
    mpfr_t *z;                 /* the reduced state that repeats */
    mpfr_t time;               /* of one repetition */
    double residual_log2;      /* |R(z) - z|, in scales */
    double multiplier;         /* the largest modulus of the return map's eigenvalues there */
    double growth_log2;        /* the largest entry of the tangent propagator over one repetition */
} cns_cycle;

/* Newton's method from z (d numbers), with so many digits. CNS_UNREACHED: it does not converge. */
cns_code cns_cycle_find(const cns_return_map *S, const mpfr_t *z, int returns, int direction, long digits,
                        cns_cycle *c, cns_error *err);
void cns_cycle_clear(cns_cycle *c);

#endif
