/* The running envelope of observables along a trajectory: E(t) is the largest |u(s)|, 0 <= s <= t, by the
 * dense output. Within a step it is looked for in pieces of equal length, of which each may have one maximum
 * inside. A step of order p is shorter than the distance to the nearest singularity; where there is none, as
 * for exp(i w t), it is some p/20 radians long, so pieces of at most one radian are 8 + p/16. Private to
 * src/study/predict. */
#ifndef CNS_STUDY_PREDICT_ENVELOPE_H
#define CNS_STUDY_PREDICT_ENVELOPE_H

#include "cns/study/tc.h"
#include "integrate/trajectory.h"

enum { CNS_ENVELOPE_BITS = 64 };

typedef struct cns_envelope {
    int n;             /* observables, numbered as in cns/study/tc.h; the norm has no envelope: it stays 0 */
    int pieces;        /* of a step */
    mpfr_t *base;      /* of each observable, up to the beginning of the last step */
    mpfr_t *crest;     /* the largest |u| in each piece of the last step: n times `pieces` */
    double *crest_at;  /* and where */
    bool stepped;      /* is there a last step? */
    cns_sample sample; /* scratch */
    mpfr_t *node;      /* scratch: |u| of each at the ends and middles of the pieces */
    double *node_at;
    mpq_t time;
} cns_envelope;

/* For a trajectory of this flow. The envelope is 0. To be cleared whatever is returned. */
cns_code cns_envelope_init(cns_envelope *e, int n, const cns_flow_spec *flow, cns_error *err);
void cns_envelope_clear(cns_envelope *e); /* zeros are well */

/* Observable i, not the norm, in a sample. */
mpfr_srcptr cns_observable_of(const cns_sample *s, int i);

/* The envelope of observable i is at least |u| from the beginning of the last step on. */
void cns_envelope_raise(cns_envelope *e, int i, mpfr_srcptr u);
/* After each step of the trajectory. */
void cns_envelope_follow(cns_envelope *e, cns_trajectory *t);
/* E = that of observable i at a time t within the last step, at which it has the value u. */
void cns_envelope_at(const cns_envelope *e, int i, double t, mpfr_srcptr u, mpfr_t E);

#endif
