/* Periodic orbits, attracting or not, with period, state and Floquet multipliers to as many decimals as asked
 * for.
 *
 * An orbit is found by Newton's method with the variational equations, from a guess of state and period, or
 * from the late motion of the system's trajectory: the cycle that it tends to, or, of a chaotic motion, a
 * cycle that it comes near to. Periodic is meant up to whole revolutions of an angle and up to place (what
 * nothing feeds back on drifts). Where a part of the period makes the motion an image of itself under the
 * symmetries of the model, that part, a repetition, is what is computed.
 *
 * Every value comes from two solutions, each Newton's method to its end, that differ in digits, order and
 * every step (as in cns/solve.h); e, the bound of its error, is 16 times the largest of their difference and
 * the noise of the coarser one, which is its rounding times the growth of the tangents and the norm of the
 * inverse derivative. Of a text all numbers within e have to have it. Multipliers are enclosed in ball
 * arithmetic, the entries of the monodromy matrix being balls of radius e. What tells an error of the program
 * from noise: the condition of Kantorovich's theorem holds, 2 h = 2 |1/F'| L |step| < 1, with 16 times the
 * Lipschitz constant L that Newton's method has seen; the determinant of the monodromy matrix is the
 * exponential of the integral of the trace (Liouville); and the vector along the orbit comes back to itself,
 * which is the multiplier 1. */
#ifndef CNS_STUDY_ORBIT_H
#define CNS_STUDY_ORBIT_H

#include "cns/monitor.h"
#include "cns/study/equilibria.h"
#include "cns/study/sweep.h"
#include "cns/system.h"

CNS_BEGIN_DECLS

typedef struct cns_orbit_spec {
    long decimals;     /* of every value, >= 1 */
    cns_number period; /* of the guess, whose state is the initial one; 0: from the late motion */
    int section;       /* the state that is held, at its value in the guess; -1: one that the motion crosses
                          its section by */
    long returns;      /* of the late motion (see cns/study/classify.h) until it repeats; 0: as it is */
} cns_orbit_spec;

#define CNS_ORBIT_TEXT 160

typedef struct cns_orbit {
    int n_states, d; /* states; dynamic ones, */
    int *index;      /* which they are, */
    int held;        /* and which of the states was held */
    char **state;    /* d texts: where the orbit begins */
    char *period;
    char *parameter; /* where it is one of a branch at which something happens: the value; else NULL */
    int repetitions; /* in a period: 1, unless a part of it makes the motion an image of itself */
    char symmetry[CNS_ORBIT_TEXT]; /* which image, in the names of the model; "" */
    long winding;                  /* whole revolutions of the angle in a period */
    char **drift;                  /* n_states texts: change in a period; NULL for dynamic states */
    cns_eigenvalue *multiplier;    /* d - 1: but for the 1 along the orbit; the largest first */
    cns_eigenvalue *repetition;    /* d - 1: the same of one repetition; its powers are the former */
    int unstable;                  /* multipliers that are certainly outside the unit circle; */
    int stable;                    /* inside */
    const char *stability;         /* stable, unstable, or not hyperbolic */
    long decimals;                 /* of all texts; fewer than asked for with CNS_UNREACHED */
    long digits, coarse_digits;    /* of the two solutions */
    int newton;                    /* steps to the coarser one */
    double difference;             /* log10 of theirs, in scales; */
    double kantorovich;            /* log10 of h */
} cns_orbit;

/* *result is a new orbit with CNS_OK and CNS_UNREACHED. CNS_USAGE: the spec makes no sense for this system;
 * CNS_NUMERIC: none was found, or none proven; err says why. */
cns_code cns_orbit_find(const cns_system *s, const cns_orbit_spec *spec, const cns_monitor *monitor,
                        cns_orbit **result, cns_error *err);
void cns_orbit_free(cns_orbit *o);

/* What happens to a branch of orbits where a multiplier crosses the unit circle. The multiplier meant is that
 * of one repetition. */
typedef enum cns_crossing {
    CNS_CROSSING_NONE,
    CNS_CROSSING_FOLD,          /* 1: the branch turns back */
    CNS_CROSSING_BRANCH_POINT,  /* 1: another branch crosses it */
    CNS_CROSSING_DOUBLING,      /* -1: an orbit of twice the period branches off */
    CNS_CROSSING_SYMMETRY,      /* -1, of half a period or another even part: the multiplier of the period
                                   is 1, and orbits of the same period without the symmetry branch off, which
                                   repeat after two repetitions */
    CNS_CROSSING_NEIMARK_SACKER /* a complex pair: a torus branches off */
} cns_crossing;

const char *cns_crossing_name(cns_crossing crossing);

typedef struct cns_branch_point {
    char *parameter; /* exact; of a crossing, to the decimals of the orbit */
    cns_crossing crossing;
    cns_orbit *orbit;
    char *note; /* what is to be said at this value, instead of an orbit or with one; or NULL */
} cns_branch_point;

typedef struct cns_branch {
    int n;
    cns_branch_point *point; /* along the branch */
} cns_branch;

/* The orbit for each value of a sweep, beginning with that of `spec` at the first, each from those before;
 * and, between them, every crossing, located as the zero of det(P + 1), det(P - 1) or the product of all
 * 1 - mu_i mu_j, where P is the derivative of the return map, by secants in two precisions. A branch that
 * turns back is followed around its fold, and ends there. Where it comes to an orbit that repeats sooner,
 * that one is followed. *result, a new branch, holds what there is whatever is returned. CNS_UNREACHED: the
 * branch ends before the last value, or some decimals are missing; CNS_USAGE: no parameter is swept. */
cns_code cns_orbit_follow(const cns_system *s, const cns_orbit_spec *spec, const cns_sweep *sweep,
                          const cns_monitor *monitor, cns_branch **result, cns_error *err);
void cns_branch_free(cns_branch *b);

CNS_END_DECLS

#endif
