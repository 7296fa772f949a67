/* The promise that every decimal printed is right: what it rests on, in one place.
 *
 * A value is computed twice, by runs that differ in precision, order and every step. The finer run is
 * printed. Its error is bounded by e = 16 max(|fine - coarse|, noise): noise is what the measured growth
 * makes of the rounding and truncation of the coarser run, for a difference can be small by accident. A text
 * is certain when value - e and value + e both have it. Should the difference be larger than noise times
 * growth can explain, that is no chaos but an error of the program, and is reported as one. */
#ifndef CNS_SOLVE_PROOF_H
#define CNS_SOLVE_PROOF_H

#include "cns/solve.h"
#include "integrate/trajectory.h"

enum {
    /* Digits by which two runs must differ if one is to confirm the other. A limb of GMP and MPFR has 64
     * bits, or 19.3 digits, so that the numbers of both runs differ in their count of limbs, and no constant
     * or intermediate result can happen to be rounded in the same place and to the same side. */
    CNS_ANOTHER_LIMB = 22,
    /* Of the finer run, so that the coarser one has some, too. */
    CNS_LEAST_PROOF_DIGITS = CNS_ANOTHER_LIMB + 4,
    /* e is 2^4 = 16 times the larger of difference and noise. If errors shrink by a factor r from the coarser
     * run to the finer, the finer one's error is |fine - coarse| / (r - 1). 22 digits more make r huge; half
     * the step of a Runge-Kutta method of order 4 makes it 16, and less where the method steps blindly over a
     * kink. With the factor, e is a bound as long as r is above 1 + 1/16. */
    CNS_PROOF_SAFETY_LOG2 = 4
};

/* The finer run takes steps shorter by 2^-CNS_FINE_SAFETY, so that steps differ even at equal orders. */
#define CNS_FINE_SAFETY 0.1

/* The two runs of a proof, or, without one, the one run that is printed. */
typedef struct cns_proof_runs {
    bool proof;                      /* by the coarser run */
    bool enclosed;                   /* by an enclosure: fine is all there is */
    cns_flow_spec fine, coarse;      /* without a proof, fine is all there is, as given */
    long fine_digits, coarse_digits; /* 0: double; none */
    cns_number half_step;            /* of the finer run, where the step is given */
} cns_proof_runs;

/* Of a goal: the finer run has so many digits. schedule: by time, of the coarser run; it is shifted such that
 * its first part has the coarser run's digits. */
void cns_proof_of_goal(cns_proof_runs *r, const cns_problem *p, long digits, const cns_schedule *schedule);
/* The run of so many digits that proves its goal by an enclosure. The schedule is that of its digits, shifted
 * such that its first part has these. */
void cns_proof_enclosed(cns_proof_runs *r, const cns_problem *p, long digits, const cns_schedule *schedule);
/* Of given numerics. An enclosure is one of the run that they describe; Runge-Kutta runs, and runs in double,
 * have none: then it is as with two runs. With two they describe the coarser run. The finer one has more
 * digits; a Taylor run also another order and shorter steps, a Runge-Kutta run half the step. */
void cns_proof_of_numerics(cns_proof_runs *r, const cns_problem *p, const cns_numerics *n,
                           cns_proof_kind kind);
void cns_proof_runs_clear(cns_proof_runs *r);

/* Raises e, the bound of several values, to what these two and log2 of the coarser one's noise (-HUGE_VAL:
 * none is known) ask for. Values that are not numbers leave it. */
void cns_proof_error(mpfr_t e, mpfr_srcptr fine, mpfr_srcptr coarse, double noise_log2);

/* A value and the bound of its error. */
typedef struct cns_bounded {
    mpfr_srcptr x, e;
} cns_bounded;

/* The largest number of places, at most `most`, to which all n values are certain; -1: there is none. A value
 * next to a rounding boundary may be certain to many places and not to fewer. */
long cns_proof_places(const cns_bounded *value, int n, cns_places places, long most);

/* Is the difference of the dynamic states at time t no larger than noise times growth explain? CNS_NUMERIC,
 * with the figures, if it is larger. */
cns_code cns_proof_explained(const cns_problem *p, const cns_sample *fine, const cns_sample *coarse, double t,
                             cns_error *err);

#endif
