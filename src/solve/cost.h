/* What a run will cost: steps, time, memory. Private to src/solve. */
#ifndef CNS_SOLVE_COST_H
#define CNS_SOLVE_COST_H

#include "cns/solve.h"
#include "proof.h"

enum { CNS_TALLY_LEVELS = 14 };

/* How many steps runs of more digits take in each part of the time, from the steps of a preliminary run. */
typedef struct cns_tally {
    const cns_flow_spec *spec; /* of the preliminary run */
    double end;
    struct {
        double steps[CNS_TALLY_LEVELS]; /* that the coefficients allow, at 10, 20, 40 ... digits */
        double
            approaches; /* shorter ones, that halve the distance to a zero of a root: as many at any digits */
        double landings; /* on kinks */
    } part[CNS_PLAN_PARTS];
    bool begun; /* `before` is there */
    double
        before[CNS_TALLY_LEVELS]; /* log2 of the length that the last step's coefficients allow, by level */
    /* On the way across a smoothed kink, sqrt(u^2 + eps^2) near u = 0, steps shrink to about eps and grow
     * again. They are not counted one by one. When they are over, what they are at each level follows from
     * how far they have shrunk. */
    bool crossing; /* are they going on? */
    double wide;   /* log2 of the longest step since the last crossing */
    double least;  /* log2 of the shortest step of this one */
} cns_tally;

void cns_tally_step(void *tally, const cns_flow *f); /* after each step; as cns_trajectory_spec.stepped */

/* Fills in steps, seconds and memory of *plan for the two runs of a proof. Some steps of either run are made,
 * at the digits that its schedule has first, last and in between, and what they take is summed over the
 * schedule; that itself takes about a hundredth of the time predicted. The seconds are those of a machine
 * with nothing else to do. CNS_STOPPED, CNS_MEMORY: there is no prediction. */
cns_code cns_cost_predict(const cns_problem *p, const cns_proof_runs *runs, const cns_tally *tally,
                          cns_run_info *plan, cns_error *err);

/* The same for the run, or the two of a proof, that given numerics ask for: steps and seconds of *info. Steps
 * that are not fixed are predicted from the beginning of a preliminary run; where that fails there is no
 * prediction. CNS_USAGE: the printed run takes more than CNS_MOST_STEPS, and no time limits it. */
cns_code cns_cost_of_numerics(const cns_problem *p, const cns_proof_runs *runs, cns_run_info *info,
                              cns_error *err);

#endif
