/* The critical predictable time T_c: how long a run can be trusted, told by a finer one.
 *
 * Source: Xu, Li, Li, Liao, "Accurate predictions of chaotic motion of a free fall disk", section 2.2, after
 * S. Liao, Tellus A 61 (2009) 550. For an observable u, T_c is found at the first row at which
 * |1 - u1/u2| > delta, u1 from the run under test and u2 from the reference; 0/0 counts as 0, x/0 as
 * infinite. For the observable `norm` it is the first row at which the Euclidean distance of the dynamic
 * states, each divided by its scale, exceeds delta. Rows decide, because between them every zero of u2 would
 * fire. The time is then refined on the dense outputs of both runs, inside the interval before that row: T_c
 * is the beginning of the stretch that reaches the row and on which the condition holds, to about 1e-7 of the
 * interval (at most 1e-7). The distance of two close trajectories grows through delta once; an observable may
 * do so several times, and then the last time before the row counts. */
#ifndef CNS_STUDY_TC_H
#define CNS_STUDY_TC_H

#include "cns/solve.h"

CNS_BEGIN_DECLS

typedef enum cns_tc_kind {
    CNS_TC_FOUND,
    CNS_TC_BEYOND,    /* not up to the time given */
    CNS_TC_STILL,     /* nor does the difference grow, as on an invariant line or near a stable state */
    CNS_TC_IDENTICAL, /* the two runs have the same value in every row */
} cns_tc_kind;

typedef struct cns_tc_time {
    cns_tc_kind kind;
    double t;   /* T_c; the time up to which there is none */
    double row; /* the first row at which the condition holds; else t */
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
    double compared;   /* time of the last row compared */
    long reference_digits;
    long steps, reference_steps;
} cns_tc_result;

void cns_tc_result_clear(cns_tc_result *r);

typedef struct cns_tc_spec {
    const cns_numerics *numerics; /* of the run under test */
    const cns_system *truth; /* of the reference; NULL: the problem's, too; else another smoothing of it */
    const cns_number *delta; /* > 0 */
    int until;               /* end when this observable, or CNS_TC_EVERY_ONE, has its T_c */
    long reference_digits;   /* 0: what it takes */
} cns_tc_spec;

/* T_c of a run by numerics against a Taylor run with more digits, at the problem's rows; derived quantities,
 * too, if a column of the problem is one; its sink is of no use here. The reference is trusted as long as the
 * error that its own noise has grown to, by its measured tangents, stays below delta by a factor of 2^44.
 * Automatic digits are raised until it can be trusted all the way; CNS_UNREACHED when those given, or
 * CNS_TC_MAX_DIGITS, do not suffice. result is valid, and to be cleared, whatever is returned. */
#define CNS_TC_MAX_DIGITS 5000
cns_code cns_tc_measure(const cns_problem *problem, const cns_tc_spec *spec, cns_tc_result *result,
                        cns_error *err);

CNS_END_DECLS

#endif
