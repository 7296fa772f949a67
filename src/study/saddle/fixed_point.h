/* Fixed points of the reduced dynamics (the dynamic states alone) with everything enclosed: place, Jacobian,
 * eigenvalues, eigenvectors. Private to src/study. */
#ifndef CNS_STUDY_SADDLE_FIXED_POINT_H
#define CNS_STUDY_SADDLE_FIXED_POINT_H

#include "cns/program.h"
#include "num/flint.h"
#include "study/spectrum.h"

/* What Newton's method and its proof work on. */
typedef struct cns_reduced {
    int d;                /* dynamic states */
    int *index;           /* which of the model's states they are */
    cns_program *field;   /* their equations alone */
    cns_program *tangent; /* the same with d tangent vectors */
} cns_reduced;

cns_code cns_reduced_open(cns_reduced *r, const cns_program *p, cns_error *err);
void cns_reduced_close(cns_reduced *r);

typedef struct cns_fixed_point {
    int d;
    arb_ptr x;             /* d enclosures; there is exactly one fixed point in this box */
    arb_mat_t jacobian;    /* d x d, at that point */
    cns_spectrum spectrum; /* of the Jacobian */
} cns_fixed_point;

void cns_fixed_point_init(cns_fixed_point *f, int d);
void cns_fixed_point_clear(cns_fixed_point *f);

/* The fixed point near guess (one number per dynamic state), by Newton's method, proven to exist and to be
 * alone in its box by Krawczyk's operator (R. Krawczyk, Computing 4 (1969) 187; A. Neumaier, Interval methods
 * for systems of equations, 1990, section 5.1). CNS_NUMERIC: none found or none proven: err says which. */
cns_code cns_fixed_point_find(const cns_reduced *r, const double *guess, slong prec, cns_fixed_point *f,
                              cns_error *err);

/* Do all small deviations in these states alone (d flags) die out, the others being held? The eigenvalues of
 * that block of the Jacobian are certain to have negative real parts. */
bool cns_fixed_point_attracts(const cns_fixed_point *f, const bool *in_states);

#endif
