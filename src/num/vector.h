/* Vectors of MPFR numbers. */
#ifndef CNS_NUM_VECTOR_H
#define CNS_NUM_VECTOR_H

#include <mpfr.h>
#include <stddef.h>

mpfr_t *cns_vector_new(int n, mpfr_prec_t prec); /* zeros; NULL: out of memory */
void cns_vector_free(mpfr_t *v, int n);
size_t cns_vector_bytes(int n, mpfr_prec_t prec); /* of memory in such a vector */

#endif
