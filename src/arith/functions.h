/* The functions of order-0 coefficients, correctly rounded. Private to src/taylor. */
#ifndef CNS_ARITH_FUNCTIONS_H
#define CNS_ARITH_FUNCTIONS_H

#include "arith.h"

/* w = f(a) or f(a, b), and for CNS_FN_SINCOS w2 = cos a; w2 and b are not looked at elsewhere. w and w2 may
 * be a or b. */
void cns_function_mpfr(cns_function f, mpfr_ptr w, mpfr_ptr w2, mpfr_srcptr a, mpfr_srcptr b);

#endif
