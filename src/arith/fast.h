/* The fast arithmetic: block fixed point with precision by order. The same primitives as every arithmetic,
 * and what it can do beyond them.
 *
 * Coefficients are absolute, not relative: a_k carries an error of a few units of 2^(e - prec) with e the
 * block exponent of its series, at every order k, provided |a_k| <= 2^e 2^(-decay k). Where a
 * coefficient exceeds that, the block exponent is raised in place and what is stored moves down with it;
 * nothing overflows, but the bits so lost are reported (cns_fast_status). Block exponents are learnt from the
 * last expansion. */
#ifndef CNS_ARITH_FAST_H
#define CNS_ARITH_FAST_H

#include "arith.h"

/* The kernel does the work on limbs: "portable" C, or "avx512ifma" where the processor has it, with the same
 * bits. "auto" is the best that there is. An arithmetic whose spec names none takes the kernel of the
 * process, which is "auto" unless chosen otherwise, once and for all that is created from then on; NULL and
 * "" choose "auto". CNS_USAGE: this machine has no such kernel. */
cns_code cns_fast_choose_kernel(const char *name, cns_error *err);
const char *cns_fast_kernel_name(void); /* of the process */
bool cns_fast_has_kernel(const char *name);

typedef struct cns_fast_status {
    int raised;        /* bits by which a block exponent had to be raised since begin, the largest */
    int raised_series; /* of which series; -1: none */
    bool singular;     /* division by zero, or a value that is not finite, since begin */
} cns_fast_status;

const char *cns_fast_kernel(const cns_arith *A);

/* For the next begin: working precision, at most that of the spec; bits by which coefficients are
 * expected to fall per order (3; 1..16). */
void cns_fast_set_precision(cns_arith *A, mpfr_prec_t prec);
void cns_fast_set_decay(cns_arith *A, int decay);

void cns_fast_status_get(const cns_arith *A, cns_fast_status *status);

/* y = sum_{k <= n} a_k tau^k, 0 <= tau <= 2^reach_log2, rounded to y. */
void cns_fast_sum(cns_arith *A, mpfr_t y, int a, int n, const mpfr_t tau);

#endif
