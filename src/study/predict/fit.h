/* A straight line through points that fluctuate like a random walk.
 *
 * Critical predictable times are first passages: T_c(x) is when the log10 of the growth of errors reaches a
 * level that is linear in x (x the digits, or -log10 of a step or of a smoothing). Over a time D that
 * logarithm has the mean mu D, mu = lambda / ln 10, and the variance s^2 D. By Wald's identities the passage
 * through one more unit of level takes 1/mu on average with the variance s^2 / mu^3, independently of the
 * units before. So with the slope c = dT_c/dx (mu c is the level per x)
 *
 *     T_c(x_i) = c x_i + d + W(x_i) + e_i,   Cov(W_i, W_j) = walk (min(x_i, x_j) - start),
 *     walk = s^2 c / mu^2   (for digits, c = a = 1/mu: s^2 a^3),
 *
 * W shared by all runs, which follow one trajectory, and e_i, of variance `jitter`, what the noise of one
 * run adds alone. The textbook errors of least squares take W for independent too, and are several times
 * too small. The slope does not depend on `start`, the x of T_c = 0; the intercept's error does. */
#ifndef CNS_STUDY_PREDICT_FIT_H
#define CNS_STUDY_PREDICT_FIT_H

#include "cns/study/laws.h"

typedef enum cns_spread_kind {
    CNS_SPREAD_WALK,        /* a walk, as strong as the increments of the points say; no jitter */
    CNS_SPREAD_INDEPENDENT, /* jitter, as strong as the residuals say; no walk */
    CNS_SPREAD_GIVEN        /* as given */
} cns_spread_kind;

typedef struct cns_spread {
    cns_spread_kind kind;
    double walk, jitter; /* variances, >= 0, not both 0: per unit of x, and of each point (GIVEN only) */
    long dof;            /* >= 1: degrees of freedom that they were found with (GIVEN only) */
    double start;        /* where the walk begins, at most the first x (of no use to INDEPENDENT) */
} cns_spread;

/* n >= 3 points, x increasing. CNS_USAGE: fewer, or not increasing, or not finite. */
cns_code cns_fit_line(const double *x, const double *y, int n, const cns_spread *spread, cns_fit *fit,
                      cns_error *err);

/* Student's t with dof >= 1 degrees of freedom: the probability of -t..t (Abramowitz and Stegun 26.7.3 and
 * 26.7.4), and the t of a probability 0 < p < 1. */
double cns_student_within(double t, long dof);
double cns_student_limit(double p, long dof);

#endif
