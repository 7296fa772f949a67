/* One branch of a saddle's one-dimensional unstable manifold, by the parametrisation method (X. Cabre, E.
 * Fontich, R. de la Llave, J. Differential Equations 218 (2005) 444; A. Haro et al., The parameterization
 * method for invariant manifolds, 2016, chapter 2): x(s) = sum p_n s^n with lambda s dx/ds = f(x(s)), where s
 * grows like e^(lambda t) along solutions. Private to src/study.
 *
 * Where the saddle lies on a kink, an abs() is held to the sign that it has on the branch: there the field is
 * analytic, and so is the branch. A start on the linear eigenvector would be wrong by the square of its
 * distance, and so would every decimal beyond. */
#ifndef CNS_STUDY_SADDLE_BRANCH_H
#define CNS_STUDY_SADDLE_BRANCH_H

#include <mpfr.h>

#include "fixed_point.h"

typedef struct cns_branch {
    int d, order;
    mpfr_prec_t prec;
    mpfr_t *p;     /* d coefficients of order 0, d of order 1, ...; p_1 is the eigenvector, in scales <= 1 */
    mpfr_t lambda; /* the unstable eigenvalue */
    mpfr_t s; /* where to start: the terms left out are below 2^-prec, in scales, and no kink lies before */
} cns_branch;

/* The branch of f, a saddle with one unstable direction, on which state `along` grows. scales: d typical
 * sizes. CNS_NUMERIC: not such a saddle, or the series does not do what it should (err says what). */
cns_code cns_branch_open(cns_branch *b, const cns_reduced *r, const cns_fixed_point *f, int along,
                         const double *scales, int order, mpfr_prec_t prec, cns_error *err);
void cns_branch_close(cns_branch *b);

/* x(s): d numbers. */
void cns_branch_eval(const cns_branch *b, const mpfr_t s, mpfr_t *x);

#endif
