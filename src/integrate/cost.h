/* What a run will cost: steps, time, memory. Private to src/integrate. */
#ifndef CNS_INTEGRATE_COST_H
#define CNS_INTEGRATE_COST_H

#include "cns/solve.h"

/* Fills in steps, seconds and memory of *plan for the two runs of a proof. `scouted` is a flow that has gone
 * the whole way with the spec `scout`, adaptive, without a schedule: the lengths of its steps tell those of
 * the others. Some steps of either run are made, at the digits that its schedule has first, last and in
 * between, and what they take is summed over the schedule; that itself takes about a hundredth of the time
 * predicted. The seconds are those of a machine with nothing else to do. */
void cns_cost_predict(const cns_problem *p, const cns_flow_spec *fine, const cns_flow_spec *coarse,
                      const cns_flow_spec *scout, const cns_flow *scouted, cns_run_info *plan);

double cns_thread_seconds(void); /* of processor time of this thread */

#endif
