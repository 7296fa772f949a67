/* Straight code: what the recurrences compute at order 0 in double precision, recorded once and done again
 * for other values of the states, with the same results, at a fraction of the cost. It holds as long as every
 * value that a recurrence has looked at keeps its sign. */
#ifndef CNS_ARITH_STRAIGHT_H
#define CNS_ARITH_STRAIGHT_H

#include "arith.h"

/* An arithmetic that has its primitives computed by another one, and records them. */
extern const cns_arith_ops cns_arith_straight;
cns_arith *cns_straight_new(int series); /* NULL: out of memory */
void cns_straight_free(cns_arith *S);

/* Recording begins, for A, whose operations `ops` are: cns_arith_libm. */
void cns_straight_begin(cns_arith *S, const cns_arith_ops *ops, cns_arith *A);
/* Makes code of what was recorded: expansions with H = 1, at order 0 and x_1 of the states x. False: there is
 * no code of it, because a value was zero, or order 0 was not all that was asked for. */
bool cns_straight_compile(cns_arith *S);

/* The values: a_0 of series a is number a, x_1 of the state x is number `series` + x. */
double *cns_straight_values(cns_arith *S);
/* Computes them from those of the states. False: something has another sign than when it was recorded; those
 * of the states are as they were. */
bool cns_straight_run(cns_arith *S);

#endif
