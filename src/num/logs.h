/* Logarithms that steer steps: from additions, products and quotients of doubles only, so that they have
 * the same bits on every machine, whatever its C library. Accurate to about 1e-10, which is ample. */
#ifndef CNS_NUM_LOGS_H
#define CNS_NUM_LOGS_H

#include <mpfr.h>

/* log2(m 2^e), m > 0. */
double cns_log2_2exp(double m, long e);

/* 2^x as m 2^e with 0.5 <= m < 1. |x| < 2^30. */
double cns_exp2_2exp(double x, long *e);

/* log2 |x|; -HUGE_VAL for 0. */
double cns_log2_mpfr(mpfr_srcptr x);

/* log10 of m 2^e. */
double cns_log10_2exp(double m, long e);

#define CNS_LOG2_10 3.3219280948873623479
#define CNS_LOG10_2 0.30102999566398119521

#endif
