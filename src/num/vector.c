#include "vector.h"

#include <stdlib.h>

#include "core/memory.h"

enum { MALLOC_BYTES = 16 }; /* that malloc() adds to each number, in glibc */

static mpfr_t *zeros(mpfr_t *v, int n, mpfr_prec_t prec)
{
    for (int i = 0; v && i < n; i++) {
        mpfr_init2(v[i], prec);
        mpfr_set_zero(v[i], 1);
    }
    return v;
}

mpfr_t *cns_vector_new(int n, mpfr_prec_t prec)
{
    return zeros(malloc(((size_t)n + 1) * sizeof(mpfr_t)), n, prec);
}

mpfr_t *cns_vector_xnew(int n, mpfr_prec_t prec)
{
    return zeros(cns_xalloc((size_t)n + 1, sizeof(mpfr_t)), n, prec);
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
