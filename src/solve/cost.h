/* What a run will cost: steps, time, memory. Private to src/integrate. */
#ifndef CNS_SOLVE_COST_H
#define CNS_SOLVE_COST_H

#include "cns/solve.h"

enum { CNS_TALLY_LEVELS = 14 };

/* How many steps a run takes in each part of the time, from the steps of a preliminary one. */
typedef struct cns_tally {
    const cns_flow_spec *spec; /* of the preliminary run */
    double end;
    struct {
        double steps[CNS_TALLY_LEVELS]; /* regular ones, at 10, 20, 40 ... digits */
        double approaches;              /* towards a square root's zeros: as many at any digits */
        double landings;
    } part[CNS_PLAN_PARTS];
    bool begun;
    double before[CNS_TALLY_LEVELS]; /* log2 of the last step that the coefficients allowed */
    bool crossing;                   /* a kink that is smoothed */
    double wide, least;              /* log2 of the longest step since the last one; of the shortest in it */
} cns_tally;

void cns_tally_step(void *tally, const cns_flow *f);

/* Fills in steps, seconds and memory of *plan for the two runs of a proof. Some steps of either run are made,
 * at the digits that its schedule has first, last and in between, and what they take is summed over the
 * schedule; that itself takes about a hundredth of the time predicted. The seconds are those of a machine
 * with nothing else to do. */
void cns_cost_predict(const cns_problem *p, const cns_flow_spec *fine, const cns_flow_spec *coarse,
                      const cns_tally *tally, cns_run_info *plan);

#endif
