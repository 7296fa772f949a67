/* The growth of errors along a trajectory, from tangents carried in double precision.
 *
 * Along the steps of a flow this integrates the variational equations (d tangent vectors for d dynamic
 * states) and keeps two matrices, in units of the model's scales: Phi(t, 0), the tangent propagator, and
 * C(t) = sum_i q_i^2 Phi(t, t_i) Phi(t, t_i)^T, the covariance that noise of size q_i made in step i has
 * grown to. The base trajectory is taken anew from the flow, whatever its precision, so the tangents belong
 * to the true trajectory. Both matrices carry an exponent of their own and do not overflow. */
#ifndef CNS_INTEGRATE_GROWTH_H
#define CNS_INTEGRATE_GROWTH_H

#include "cns/flow.h"

typedef struct cns_growth cns_growth;

cns_growth *cns_growth_new(const cns_program *p, const double *scales, cns_error *err);
void cns_growth_free(cns_growth *g);

void cns_growth_start(cns_growth *g);

/* After each step of the flow, before the next. noise_log2: log2 of q for this step. */
cns_code cns_growth_follow(cns_growth *g, cns_flow *f, double noise_log2, cns_error *err);

/* Steps may be left out of cns_growth_follow() as long as they end before cns_growth_free_until() - the next
 * one after them must not - and their number and noise are told. */
double cns_growth_free_until(const cns_growth *g);
void cns_growth_skipped(cns_growth *g, long steps, double noise_log2);

/* At a time within the last step; times must not decrease. *growth is log10 of the largest singular value
 * of Phi(t, 0); *error_log2 is log2 of the root of the trace of C(t), -HUGE_VAL before any noise. */
cns_code cns_growth_at(cns_growth *g, const mpq_t t, double *growth, double *error_log2, cns_error *err);

/* Origins: times from which growth is followed, too. cns_growth_mark() makes the beginning of the last step
 * followed one; cns_growth_since() gives log10 of the Frobenius norm of Phi(t, origin) for the t of the last
 * cns_growth_at(). Origins are numbered from 0; at most CNS_GROWTH_ORIGINS. */
#define CNS_GROWTH_ORIGINS 64
cns_code cns_growth_mark(cns_growth *g, cns_error *err);
int cns_growth_marks(const cns_growth *g);
double cns_growth_origin(const cns_growth *g, int origin); /* its time */
double cns_growth_since(cns_growth *g, int origin);

/* The largest singular value of a, d x d, by power iteration on a^T a; scratch: 2 d numbers. */
double cns_spectral_norm(const double *a, int d, double *scratch);

#endif
