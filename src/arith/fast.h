/* The fast arithmetic: block fixed point with fewer bits the higher the order. It has the primitives of every
 * arithmetic; here is what it can do beyond them.
 *
 * The errors of coefficients are absolute, not relative: all coefficients of a series share one exponent e,
 * its block exponent, and a_k has an error of a few units of 2^(e - prec) at every order k, provided that
 * |a_k| <= 2^e 2^(-decay k). Where a coefficient is larger than that, the block exponent is raised, and the
 * coefficients before it lose as many of their last bits: nothing overflows, and the bits lost are counted
 * (cns_fast_status). An expansion begins with block exponents that would have suited the one before. */
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

/* From the next begin on: the working precision in bits, at most that of the spec, and the decay, the bits by
 * which coefficients are expected to fall per order, 1..16; 3 if it is not set. */
void cns_fast_set_precision(cns_arith *A, mpfr_prec_t prec);
void cns_fast_set_decay(cns_arith *A, int decay);

void cns_fast_status_get(const cns_arith *A, cns_fast_status *status);

/* y = sum_{k <= n} a_k tau^k, 0 <= tau <= 2^reach_log2, rounded to y. */
void cns_fast_sum(cns_arith *A, mpfr_t y, int a, int n, const mpfr_t tau);

#endif
