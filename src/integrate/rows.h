/* The times of a table's rows: the multiples of `every` from 0 on, and the end, once. Row 0 is at t = 0. Both
 * numbers are rational and positive; times are exact. */
#ifndef CNS_INTEGRATE_ROWS_H
#define CNS_INTEGRATE_ROWS_H

#include "cns/number.h"

/* The time of row number `row`; false, with `time` undefined, if there is no such row. */
bool cns_row_time(const cns_number *every, const cns_number *end, unsigned long row, mpq_t time);

/* The number of the last row that is a multiple of `every`; LONG_MAX if it is not below that. */
long cns_last_multiple(const cns_number *every, const cns_number *end);

/* How times are printed, so that each can be had back exactly whatever else the table has to say: finite
 * decimals as they are, and others rounded to so many decimals that their text is nearest to them among all
 * fractions with a denominator up to that of the times (num/fraction.h). */
typedef struct cns_time_form {
    bool fractions;    /* not all are finite decimals */
    mpz_t denominator; /* no time has a larger one */
    long decimals;
} cns_time_form;

/* The form of no time yet, and of one more. */
void cns_time_form_init(cns_time_form *f);
void cns_time_form_add(cns_time_form *f, mpq_srcptr time);
/* Of all from `start` on, `every` away from each other: a denominator that none of them exceeds. */
void cns_time_form_add_grid(cns_time_form *f, mpq_srcptr start, mpq_srcptr every);
void cns_time_form_clear(cns_time_form *f);
char *cns_time_text(const cns_time_form *f, mpq_srcptr time); /* a new text */

#endif
