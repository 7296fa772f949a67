/* Fractions that are printed as decimals, and had back. */
#ifndef CNS_NUM_FRACTION_H
#define CNS_NUM_FRACTION_H

#include <gmp.h>

/* y = of all fractions with a denominator from 1 to `most` that which is nearest to x; of two that are
 * equally near, the one with the smaller denominator. x is not y. */
void cns_fraction_nearest(mpq_t y, mpq_srcptr x, mpz_srcptr most);

/* To so many decimals a fraction with a denominator of at most `most` is rounded, for cns_fraction_nearest()
 * to give it back: two such fractions are 1/most^2 apart, or more, and the rounding moves one by less than
 * half of that. And so many that above 1/2 the double nearest to the text is the double nearest to the
 * fraction: a fraction that is not half way between two doubles is at least 2^-54/most away from there, which
 * is more than the rounding. */
long cns_fraction_decimals(mpz_srcptr most);

#endif
