/* What the files of src/solve share. */
#ifndef CNS_SOLVE_SOLVE_INTERNAL_H
#define CNS_SOLVE_SOLVE_INTERNAL_H

#include "cns/solve.h"

/* What a problem asks for, where it says nothing too. */
int cns_columns(const cns_problem *p);
cns_column cns_column_at(const cns_problem *p, int i);
const cns_number *cns_every(const cns_problem *p);

/* Is a derived quantity among the columns? */
bool cns_wants_outputs(const cns_problem *p);

#endif
