/* Vectors of MPFR numbers, each in one block of memory.
 *
 * The numbers are used like any others, but neither cleared nor given another precision one by one; they may
 * be swapped with others of the same vector. */
#ifndef CNS_NUM_VECTOR_H
#define CNS_NUM_VECTOR_H

#include <mpfr.h>
#include <stddef.h>

mpfr_t *cns_vector_new(int n, mpfr_prec_t prec);  /* zeros; NULL: out of memory */
mpfr_t *cns_vector_xnew(int n, mpfr_prec_t prec); /* the same for few numbers; never NULL (core/memory.h) */
void cns_vector_free(mpfr_t *v);                  /* NULL: nothing */
size_t cns_vector_bytes(int n, mpfr_prec_t prec); /* of memory in such a vector */

/* Zeros of another precision, which is at most that of the beginning. */
void cns_vector_set_prec(mpfr_t *v, int n, mpfr_prec_t prec);

#endif
