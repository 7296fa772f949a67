/* Enclosures of the eigenvalues of a real matrix, each entry of it a ball. Private to src/study. */
#ifndef CNS_STUDY_SPECTRUM_H
#define CNS_STUDY_SPECTRUM_H

#include <stdbool.h>

#include "cns/status.h"
#include "num/flint.h"

typedef struct cns_spectrum {
    int d;
    acb_ptr lambda;  /* d enclosures: real parts fall; of a pair, the positive imaginary part first */
    bool simple;     /* the enclosures of the eigenvalues are disjoint: */
    acb_mat_t right; /* then columns are right eigenvectors, */
    acb_mat_t left;  /* and rows left eigenvectors, left right = 1 */
} cns_spectrum;

void cns_spectrum_init(cns_spectrum *s, int d);
void cns_spectrum_clear(cns_spectrum *s);

/* Of a matrix of d rows. CNS_NUMERIC: its eigenvalues could not be enclosed. */
cns_code cns_spectrum_enclose(cns_spectrum *s, const arb_mat_t matrix, slong prec, cns_error *err);

/* Is eigenvalue k certainly real? A real matrix has its eigenvalues in conjugate pairs, so one that is alone
 * in a ball whose mirror image meets no other ball is its own conjugate. */
bool cns_spectrum_is_real(const cns_spectrum *s, int k);

#endif
