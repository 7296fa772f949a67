/* What a problem asks for, where it says nothing too. */
#ifndef CNS_SOLVE_PROBLEM_H
#define CNS_SOLVE_PROBLEM_H

#include "cns/solve.h"

/* CNS_USAGE: the end or the distance of rows is not rational and positive. */
cns_code cns_problem_check(const cns_problem *p, cns_error *err);

int cns_columns(const cns_problem *p);
cns_column cns_column_at(const cns_problem *p, int i);
const cns_number *cns_every(const cns_problem *p);
/* As cns_row_time(), of the problem's rows. */
bool cns_problem_row(const cns_problem *p, unsigned long row, mpq_t passed);
double cns_problem_rows(const cns_problem *p); /* how many, about */
/* The time at which so much has passed, for messages. */
double cns_problem_time(const cns_problem *p, mpq_srcptr passed);
/* As in cns_trajectory_spec, for a run that gives up after max_time seconds; 0: not by itself. */
double cns_most_steps(const cns_problem *p, double max_time);
cns_places cns_goal_places(const cns_goal *goal);
long cns_goal_count(const cns_goal *goal);
bool cns_wants_outputs(const cns_problem *p); /* is a derived quantity among the columns? */

#endif
