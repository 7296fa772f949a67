/* The times of a table's rows: the multiples of `every` from 0 on, and the end, once. Row 0 is at t = 0. Both
 * numbers are rational and positive; times are exact. */
#ifndef CNS_INTEGRATE_ROWS_H
#define CNS_INTEGRATE_ROWS_H

#include "cns/number.h"

/* The time of row number `row`; false, with `time` undefined, if there is no such row. */
bool cns_row_time(const cns_number *every, const cns_number *end, unsigned long row, mpq_t time);

/* The number of the last row that is a multiple of `every`; LONG_MAX if it is not below that. */
long cns_last_multiple(const cns_number *every, const cns_number *end);

/* The time of an existing row as a new text: exact where it is a finite decimal, else with so many decimals
 * (at least six). */
char *cns_row_time_text(const cns_number *every, const cns_number *end, unsigned long row, long decimals);

#endif
