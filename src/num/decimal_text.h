/* Decimal texts of multiprecision numbers, correctly rounded (to nearest; a tie, which only a number known
 * exactly can be, to even), and the question whether a number with an error bound has a certain text. */
#ifndef CNS_NUM_DECIMAL_TEXT_H
#define CNS_NUM_DECIMAL_TEXT_H

#include <gmp.h>
#include <mpfr.h>
#include <stdbool.h>

#include "cns/number.h"

/* New strings, the caller's to free. count >= 0 decimals, or >= 1 significant digits. */
char *cns_text_mpfr(mpfr_srcptr x, cns_places places, long count);
char *cns_text_mpq(mpq_srcptr x, cns_places places, long count);
char *cns_text_exact(mpq_srcptr x); /* a finite decimal with as few digits as it takes; NULL: x is none */
char *cns_text_number(const cns_number *x, cns_places places, long count);

/* So many significant digits as printf's %g has them: 0.001234, 1.234e-30, 0; without zeros at the end. Of a
 * result whose error is not known. */
char *cns_text_digits(mpfr_srcptr x, long digits);

/* Do x - e and x + e have the same text? Then so has every number between. NaN has none. */
bool cns_text_certain(mpfr_srcptr x, mpfr_srcptr e, cns_places places, long count);

#endif
