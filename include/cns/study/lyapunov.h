/* The Lyapunov exponents of a trajectory, the largest or more of them, with their standard errors.
 *
 * States and n tangent vectors are integrated together, in the arithmetic asked for; after every step the
 * vectors are made perpendicular and brought back to length 1 by powers of two, exactly (G. Benettin, L.
 * Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9 and 21). With L_i(t) the logarithm of the
 * length that vector i, perpendicular to those before it, would have without that,
 *
 *     lambda_i = (L_i(t0 + T) - L_i(t0)) / T
 *
 * in units of 1/time, the largest first. The transient [0, t0], t0 = T/10, is left out: there the trajectory
 * approaches its attractor and the tangents turn into the directions that grow most. Lengths are Euclidean,
 * of the dynamic states in their scales (passive states, on which nothing feeds back, do not take part).
 *
 * The standard error comes from batch means: T is cut into 32 batches, and the scatter of their means tells
 * that of the whole, itself to 13 %. Errors from other numbers of batches are given beside it: where growth
 * remembers longer than a batch lasts they rise with the length of the batches. The other way round, where
 * L - lambda t is bounded, as on a periodic orbit or for an exponent that is zero because time can be
 * shifted, they fall with it, and all overestimate the error.
 *
 * A mean is a figure where growth is stationary, which is tested twice (study/batches.h says how, and how
 * often a test errs: less than once in 1000). Where the rate of an exponent changes, and what was before
 * moves the mean by more than two standard errors, as when a long chaotic transient ends in a fixed point,
 * that is left out, and T is what follows: a whole number of eighths. If the rate changes again, or too late
 * for an eighth to follow, there is no figure. Nor is there one where neighbouring batches vary together:
 * their error would be too small.
 *
 * In double, and at any fixed precision over a long time, the trajectory is not that of the initial state:
 * it is shadowed at best, and the exponents are right as means over the attractor. Landing on kinks keeps
 * them the exponents of the system itself; a field that is C1 needs no jump of the tangents there. */
#ifndef CNS_STUDY_LYAPUNOV_H
#define CNS_STUDY_LYAPUNOV_H

#include "cns/flow.h"
#include "cns/monitor.h"
#include "cns/system.h"

CNS_BEGIN_DECLS

#define CNS_LYAPUNOV_ROWS    32 /* of the convergence table: at t0 + k T / 32 */
#define CNS_LYAPUNOV_COUNTS  4  /* numbers of batches tried: 16, 32, 64, 128 */
#define CNS_LYAPUNOV_CHANGES 2  /* of rate, at most: after two there is no figure */

typedef struct cns_lyapunov_spec {
    cns_number time;           /* T > 0; the trajectory is followed for 1.1 T */
    cns_arithmetic arithmetic; /* of states and tangents */
    long digits;               /* >= 1; 0 with arithmetic double */
    bool portable;             /* double: the same bits on every machine, and slower */
    int exponents;             /* how many, the largest ones; 0: all */
    const double *tangent;     /* the first vector at t = 0, per dynamic state; NULL: one that no symmetry
                                  singles out */
} cns_lyapunov_spec;

typedef struct cns_lyapunov_figure {
    double lambda, se;
} cns_lyapunov_figure;

typedef struct cns_exponent {
    double lambda, se;                          /* those of the last row; not finite: there is no figure */
    cns_lyapunov_figure row[CNS_LYAPUNOV_ROWS]; /* means so far; without a figure: the rate within each row's
                                                   own time, which has no error */
    double batch_se[CNS_LYAPUNOV_COUNTS];       /* over all of T, by the number of batches */
} cns_exponent;

typedef struct cns_lyapunov_change {
    int exponent; /* from 0 */
    double t;     /* since the beginning of the trajectory, to about a hundredth of what was looked at */
    double before, after;
} cns_lyapunov_change;

typedef struct cns_lyapunov_result {
    int n;
    cns_exponent *exponent; /* n of them */
    double discarded, time; /* t0 and T */
    int changes;            /* of rate that were found; what came before the only one is left out */
    cns_lyapunov_change change[CNS_LYAPUNOV_CHANGES];
    /* Where growth is positive: the fixed points that attract, by name, so that chaos may be a transient that
     * ends later; NULL: none is known to. */
    char *attractors;
    char note[256]; /* why there is no figure; else empty */
    int batches[CNS_LYAPUNOV_COUNTS];
    double t[CNS_LYAPUNOV_ROWS]; /* of the rows, since the beginning of the trajectory */
    /* The Kaplan-Yorke dimension: j + (lambda_1 + ... + lambda_j) / |lambda_(j+1)|, j the last for which the
     * sum is not below zero by three standard errors. Its error is that of the batches, whose exponents vary
     * together. Not finite: the n exponents do not reach so far. Error 0: it follows from signs alone. */
    double dimension, dimension_se;
    /* Where all exponents were asked for: their sum, and the mean trace of the Jacobian along the same
     * trajectory, which is the same number by another route; else not finite. */
    double sum, trace;
    char *exact_trace; /* "-41/3": it is the same everywhere; NULL: it is not */
    int order;
    long steps, landings;
} cns_lyapunov_result;

/* CNS_UNREACHED: no figure; the result holds what there is, and the message says why. CNS_USAGE: more
 * exponents than there are. CNS_NUMERIC: a singularity, no dynamic states, or a tangent that vanishes;
 * CNS_STOPPED. To be cleared in any case. */
cns_code cns_lyapunov(const cns_system *s, const cns_lyapunov_spec *spec, const cns_monitor *monitor,
                      cns_lyapunov_result *result, cns_error *err);
void cns_lyapunov_result_clear(cns_lyapunov_result *result);

CNS_END_DECLS

#endif
