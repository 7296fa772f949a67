/* Two trajectories compared, and the runs that are: what the laws of T_c take from its measurement. Private
 * to src/study/predict. */
#ifndef CNS_STUDY_PREDICT_TC_INTERNAL_H
#define CNS_STUDY_PREDICT_TC_INTERNAL_H

#include "cns/study/tc.h"
#include "integrate/trajectory.h"

/* Two trajectories, of programs with the same states. */
typedef struct cns_tc_pair {
    const cns_trajectory_spec *test, *reference;
    const cns_number *end;   /* rational */
    const cns_number *every; /* rows at multiples of every, and at the end; of use to CNS_TC_ROWS only */
    const cns_number *delta; /* > 0 */
    cns_tc_criterion criterion;
    int until;                  /* the comparison ends when this observable, or every one, has its T_c */
    mpfr_srcptr before;         /* the envelope of `until` before t = 0; NULL: 0 */
    const cns_monitor *monitor; /* its progress; the flows look at their own stop */
} cns_tc_pair;

/* result is valid, and to be cleared, whatever is returned. CNS_UNREACHED: the reference was not trusted all
 * the way (see cns_tc_measure()). */
cns_code cns_tc_compare(const cns_tc_pair *pair, cns_tc_result *result, cns_error *err);

/* The run that numerics describe, as T_c means it. With K digits it is the K-digit run: the state is rounded
 * to K decimals after every step, and all else, the tolerance too where it is automatic, is finer by some
 * digits, so that nothing else matters. A double run is itself. numerics outlive the spec. */
cns_flow_spec cns_tc_flow(const cns_system *s, const cns_numerics *numerics,
                          const volatile sig_atomic_t *stop);

#endif
