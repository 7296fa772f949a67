/* Newton's method for periodic orbits, by shooting. Private to src/study.
 *
 * After `time` the motion is the image of its beginning: Phi_time(z) = image(z), which is d equations for the
 * d dynamic states but one, which is held on a section, and the time. Along a branch of orbits a parameter of
 * the model is one more unknown, and a chord through two points of the branch one more equation. The
 * derivatives are those of the variational equations; that by the parameter is a difference quotient, whose
 * step is half of the digits, so that Newton's method loses nothing of its order but its last bits.
 *
 * Unknowns u: the d states, the time, the parameter. */
#ifndef CNS_STUDY_ORBIT_CORRECTOR_H
#define CNS_STUDY_ORBIT_CORRECTOR_H

#include "image.h"
#include "num/flint.h"
#include "shooting.h"

typedef struct cns_loop {
    const cns_system *system; /* with the parameter's value, where that does not vary */
    int parameter;            /* of the model; -1: none varies */
    double parameter_scale;   /* a typical change of it */
    int n, d;
    int *index;            /* the dynamic states, */
    int held;              /* and which of them is held, */
    cns_number held_value; /* at this value */
    cns_images images;
    int image;  /* which of them, */
    long turns; /* with so many turns of the angle: any whole revolutions more than the image */
    const volatile sig_atomic_t *stop;
} cns_loop;

/* The state to hold and the image are left to be set. */
cns_code cns_loop_open(cns_loop *l, const cns_system *s, const volatile sig_atomic_t *stop, cns_error *err);
void cns_loop_close(cns_loop *l);

/* The image of z that x is nearest to, with the turns; how near, in scales. */
double cns_loop_match(const cns_loop *l, const mpfr_t *z, const mpfr_t *x, int *image, long *turns);

/* The points at which, of all in a direction, that with u = from + s (to - from) is wanted: those of the
 * plane through it at right angles, in scales. */
typedef struct cns_chord {
    const mpfr_t *from, *to;
    mpfr_srcptr s;
} cns_chord;

/* A point of the branch, as far as Newton's method goes with these digits. */
typedef struct cns_corrected {
    cns_system *system;    /* of the parameter's value; NULL: the loop's */
    cns_shooting shooting; /* of u, the last run */
    mpfr_t *u;             /* d + 2 */
    double step_log2;      /* the correction that is left, in scales: the noise of the arithmetic, */
    double noise_log2;     /* which is at most about this much */
    double inverse_log2; /* the norm of the inverse derivative; of the changes of the derivative per step, */
    double change_log2;  /* the largest: an estimate of its Lipschitz constant */
    double growth_log2;  /* the largest tangent */
    int turns;           /* of Newton's method */
} cns_corrected;

/* From a guess u, with so many digits; chord NULL: at the guess's parameter. *c is to be closed whatever is
 * returned. CNS_UNREACHED: Newton's method does not converge. */
cns_code cns_correct(const cns_loop *l, long digits, bool fine, const cns_chord *chord, const mpfr_t *u,
                     cns_corrected *c, cns_error *err);
void cns_corrected_close(cns_corrected *c);

/* A value that two of them have, fine and coarse, as a ball of the error that a proof counts with. */
void cns_ball_of(arb_t x, mpfr_srcptr fine, mpfr_srcptr coarse, double noise_log2);

/* The derivative of the return map of the section, images taken back: d - 1 by d - 1. Its eigenvalues are the
 * multipliers of one repetition, but for the 1 along the orbit. coarse NULL: without errors.
 * CNS_NUMERIC: the orbit does not cross the section there; or, with a coarse one, the determinant is not that
 * of Liouville's theorem, exp(integral of the trace), or the tangent along the orbit does not come back. */
cns_code cns_return_matrix(const cns_loop *l, const cns_corrected *fine, const cns_corrected *coarse,
                           arb_mat_t p, cns_error *err);

#endif
