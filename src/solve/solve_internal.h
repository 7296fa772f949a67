/* What planning and solving share. Private to src/integrate. */
#ifndef CNS_SOLVE_SOLVE_INTERNAL_H
#define CNS_SOLVE_SOLVE_INTERNAL_H

#include "cns/solve.h"
#include "integrate/trajectory.h"

enum {
    /* The second run of a proof has so many digits more or fewer: more than the 19.3 of a limb, so that the
     * limb counts differ and no constant is rounded in the same place. */
    CNS_PROOF_DIGITS = 22,
    /* e = |s1 - s2| is enlarged by this factor, 2^CNS_PROOF_SAFETY_LOG2. */
    CNS_PROOF_SAFETY_LOG2 = 4
};

/* The finer run takes steps shorter by 2^-CNS_FINE_SAFETY. */
#define CNS_FINE_SAFETY 0.1

/* The time of row number `row`: a multiple of every, at most the end. False: there is no such row. */
bool cns_row_time(const cns_problem *p, unsigned long row, mpq_t time);

/* The spec of a Taylor run with so many digits, all else automatic. */
cns_flow_spec cns_taylor_spec(const cns_problem *p, long digits);

/* The specs of the two runs of a proof, the printed one with so many digits and finer in everything. shift:
 * the digits by which the coarser run exceeds the schedule. */
void cns_proof_specs(const cns_problem *p, long digits, const cns_schedule *schedule, long shift,
                     cns_flow_spec *fine, cns_flow_spec *coarse);

/* The spec of a run by given numerics. */
cns_flow_spec cns_given_spec(const cns_problem *p, const cns_numerics *n);

bool cns_wants_outputs(const cns_problem *p);

/* Is the difference of the dynamic states of two runs at time t no larger than noise times growth explain?
 * CNS_NUMERIC, with the figures, if it is larger. */
cns_code cns_proof_explained(const cns_problem *p, const cns_sample *fine, const cns_sample *coarse, double t,
                             cns_error *err);

#endif
