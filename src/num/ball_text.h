/* Decimal texts of balls. */
#ifndef CNS_NUM_BALL_TEXT_H
#define CNS_NUM_BALL_TEXT_H

#include "flint.h"

/* The text that all numbers of a ball have to so many decimals, a new string; NULL: they have not all the
 * same. */
char *cns_text_ball(const arb_t x, long decimals);

#endif
