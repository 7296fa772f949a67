/* The critical predictable time T_c: how long a run can be trusted, told by a finer one.
 *
 * Source: Xu, Li, Li, Liao, "Accurate predictions of chaotic motion of a free fall disk", section 2.2, after
 * S. Liao, Tellus A 61 (2009) 550: T_c is where |1 - u1/u2| > delta, u1 from the run under test and u2 from
 * the reference. In continuous time that cannot be meant, because it holds near every zero of u2; there it is
 * decided by where a table happens to have its rows. Two criteria make a definition of it:
 *
 * CNS_TC_ENVELOPE, in continuous time. T_c of an observable u is the first t at which |u1(t) - u2(t)| >
 * delta E(t), E(t) being the running envelope of the reference, the largest |u2(s)| for 0 <= s <= t. For the
 * observable `norm` it is the first t at which the Euclidean distance of the dynamic states, each divided by
 * its scale, exceeds delta. u1 and u2 between the ends of steps are the dense outputs of both runs. T_c hangs
 * on neither the rows nor the end of the problem. It is located to 2^-40 of a step of the reference. A
 * difference that comes and goes within a 16th of such a step is found by its maximum.
 *
 * CNS_TC_ROWS, the source's form, on the problem's rows. T_c is found at the first row at which |1 - u1/u2| >
 * delta, or for `norm` the distance exceeds delta. It is then refined inside the interval before that row, to
 * about 1e-7 of the interval (at most 1e-7): T_c is the beginning of the stretch that reaches the row and on
 * which the condition holds. It hangs on the rows, by as much as the time between two zeros of u2.
 *
 * In both 0/0 counts as 0 and x/0 as infinite: a reference that has been 0 all the time is left by anything.
 */
#ifndef CNS_STUDY_TC_H
#define CNS_STUDY_TC_H

#include "cns/solve.h"

CNS_BEGIN_DECLS

typedef enum cns_tc_criterion { CNS_TC_ENVELOPE, CNS_TC_ROWS } cns_tc_criterion;
const char *cns_tc_criterion_name(cns_tc_criterion criterion); /* "envelope", "rows" */

typedef enum cns_tc_kind {
    CNS_TC_FOUND,
    CNS_TC_BEYOND,    /* not up to the time given */
    CNS_TC_STILL,     /* nor does the difference grow, as on an invariant line or near a stable state */
    CNS_TC_IDENTICAL, /* the two runs have the same value wherever they were compared */
} cns_tc_kind;

typedef struct cns_tc_time {
    cns_tc_kind kind;
    double t;   /* T_c; the time up to which there is none */
    double row; /* of CNS_TC_ROWS: the first row at which the condition holds; else t */
} cns_tc_time;

/* Observables are numbered: the norm, the states, the program's outputs. */
#define CNS_TC_NORM      0
#define CNS_TC_STATE(i)  (1 + (i))
#define CNS_TC_EVERY_ONE (-1)

typedef struct cns_tc_result {
    int n;             /* observables */
    cns_tc_time *time; /* of each */
    bool trusted;      /* false: the reference's own error came too near to delta at `compared`, and was not
                          trusted from there on */
    double compared;   /* time up to which both were compared */
    long reference_digits;
    long steps, reference_steps;
} cns_tc_result;

void cns_tc_result_clear(cns_tc_result *r);

typedef struct cns_tc_spec {
    const cns_numerics *numerics; /* of the run under test */
    const cns_system *truth; /* of the reference; NULL: the problem's, too; else another smoothing of it */
    const cns_number *delta; /* > 0 */
    cns_tc_criterion criterion;
    int until;             /* end when this observable, or CNS_TC_EVERY_ONE, has its T_c */
    long reference_digits; /* 0: what it takes */
} cns_tc_spec;

/* T_c of a run by numerics against a Taylor run with more digits; derived quantities, too, if a column of the
 * problem is one; its sink is of no use here. The reference is trusted as long as the error that its own
 * noise has grown to, by its measured tangents, stays below delta by a factor of 2^44. Automatic digits are
 * raised until it can be trusted all the way; CNS_UNREACHED when those given, or CNS_TC_MAX_DIGITS, do not
 * suffice. result is valid, and to be cleared, whatever is returned. */
#define CNS_TC_MAX_DIGITS 5000
cns_code cns_tc_measure(const cns_problem *problem, const cns_tc_spec *spec, cns_tc_result *result,
                        cns_error *err);

CNS_END_DECLS

#endif
