/* Rounding of binary numbers to decimals: the state of a run that keeps K digits. */
#ifndef CNS_NUM_ROUND_H
#define CNS_NUM_ROUND_H

#include <mpfr.h>

/* Rounds x to `digits` >= 1 significant decimals, to nearest, a tie to the even digit, decided exactly in
 * integers; the decimal found is then the nearest number of x's precision. Zeros, infinities and NaN stay. */
void cns_round_significant(mpfr_t x, long digits);

#endif
