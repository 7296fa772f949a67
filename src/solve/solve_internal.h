/* What the files of src/solve share. */
#ifndef CNS_SOLVE_SOLVE_INTERNAL_H
#define CNS_SOLVE_SOLVE_INTERNAL_H

#include "cns/solve.h"

/* Is a derived quantity among the columns? */
bool cns_wants_outputs(const cns_problem *p);

#endif
