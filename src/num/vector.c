#include "vector.h"

#include <stdlib.h>

enum { MALLOC_BYTES = 16 }; /* that malloc() adds to each number, in glibc */

mpfr_t *cns_vector_new(int n, mpfr_prec_t prec)
{
    mpfr_t *v = malloc(((size_t)n + 1) * sizeof *v);
    for (int i = 0; v && i < n; i++) {
        mpfr_init2(v[i], prec);
        mpfr_set_zero(v[i], 1);
    }
    return v;
}

void cns_vector_free(mpfr_t *v, int n)
{
    for (int i = 0; v && i < n; i++)
        mpfr_clear(v[i]);
    free(v);
}

size_t cns_vector_bytes(int n, mpfr_prec_t prec)
{
    return (size_t)n * (sizeof(mpfr_t) + mpfr_custom_get_size(prec) + MALLOC_BYTES);
}
