/* The first real root of a polynomial in an interval, by isolation, not sampling.
 * Private to src/integrate. */
#ifndef CNS_INTEGRATE_ROOTS_H
#define CNS_INTEGRATE_ROOTS_H

#include <mpfr.h>
#include <stdbool.h>

#include "cns/status.h"

/* Finds the first sign change inside (0, h) of p(t) = sum_{k=0..degree} p[k] t^k, p[0] != 0.
 *
 * Bernstein coefficients on ever smaller intervals (G. E. Collins, A. G. Akritas 1976; variation
 * diminishing) prove each interval free of roots or the polynomial monotone on it, first in few bits, with
 * rounding and the truncated tail bounded, then, where that does not decide, in all bits. Roots closer
 * together than the noise of the coefficients (a touch of zero, or an excursion that is no more than
 * rounding) count as one crossing if the sign differs before and after, as none if it does not.
 *
 * root: at its own precision (the caller's working precision), polished by Newton's method on p.
 * CNS_NUMERIC: out of memory. */
cns_code cns_first_root(mpfr_t root, bool *found, mpfr_t *p, int degree, const mpfr_t h, cns_error *err);

#endif
