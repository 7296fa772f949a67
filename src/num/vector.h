/* Vectors of MPFR numbers. */
#ifndef CNS_NUM_VECTOR_H
#define CNS_NUM_VECTOR_H

#include <mpfr.h>
#include <stddef.h>

mpfr_t *cns_vector_new(int n, mpfr_prec_t prec);  /* zeros; NULL: out of memory */
mpfr_t *cns_vector_xnew(int n, mpfr_prec_t prec); /* the same for few numbers; never NULL (core/memory.h) */
void cns_vector_free(mpfr_t *v, int n);
size_t cns_vector_bytes(int n, mpfr_prec_t prec); /* of memory in such a vector */

#endif
