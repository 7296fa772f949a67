#include "vector.h"

#include <stdint.h>
#include <stdlib.h>

#include "core/memory.h"

/* A vector is one block: the numbers, then their significands (MPFR's custom interface). */

size_t cns_vector_bytes(int n, mpfr_prec_t prec)
{
    const size_t each = sizeof(mpfr_t) + mpfr_custom_get_size(prec);
    return (size_t)n <= SIZE_MAX / each ? (size_t)n * each : SIZE_MAX;
}

static mpfr_t *zeros(mpfr_t *v, int n, mpfr_prec_t prec)
{
    if (v == NULL)
        return NULL;
    char *significands = (char *)(v + n);
    for (int i = 0; i < n; i++) {
        void *significand = significands + (size_t)i * mpfr_custom_get_size(prec);
        mpfr_custom_init(significand, prec);
        mpfr_custom_init_set(v[i], MPFR_ZERO_KIND, 0, prec, significand);
    }
    return v;
}

mpfr_t *cns_vector_new(int n, mpfr_prec_t prec)
{
    const size_t bytes = cns_vector_bytes(n, prec);
    return zeros(malloc(bytes > 0 ? bytes : 1), n, prec); /* malloc() of nothing may be NULL */
}

mpfr_t *cns_vector_xnew(int n, mpfr_prec_t prec)
{
    return zeros(cns_xgrow(NULL, cns_vector_bytes(n, prec), 1), n, prec);
}

void cns_vector_set_prec(mpfr_t *v, int n, mpfr_prec_t prec)
{
    for (int i = 0; i < n; i++)
        mpfr_custom_init_set(v[i], MPFR_ZERO_KIND, 0, prec, mpfr_custom_get_significand(v[i]));
}

void cns_vector_free(mpfr_t *v)
{
    free(v);
}
