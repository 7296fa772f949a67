/* The largest Lyapunov exponent of a trajectory, with its standard error.
 *
 * States and one tangent vector are integrated together, in the arithmetic asked for,
 * and the tangent is brought back to length 1 after every step by a power of two, exactly (G. Benettin,
 * L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9). With L(t) = ln |v(t)|,
 *
 *     lambda = (L(t0 + T) - L(t0)) / T
 *
 * in units of 1/time. The transient [0, t0], t0 = T/10, is left out: there the trajectory approaches its
 * attractor and the tangent turns into the direction that grows most. |v| is the Euclidean norm of the
 * dynamic states in their scales (passive states, on which nothing feeds back, do not take part).
 *
 * The standard error comes from batch means: T is cut into 32 batches, and the scatter of their means tells
 * that of the whole, itself to 13 %. Errors from other numbers of batches are given beside it: where growth
 * remembers longer than a batch lasts they rise with the length of the batches. The other way round, where
 * L - lambda t is bounded, as on a periodic orbit, they fall with it, and all overestimate the error.
 *
 * In double, and at any fixed precision over a long time, the trajectory is not that of the initial state:
 * it is shadowed at best, and the exponent is right as a mean over the attractor. Landing on kinks keeps it
 * the exponent of the system itself; a field that is C1 needs no jump of the tangent there. */
#ifndef CNS_STUDY_LYAPUNOV_H
#define CNS_STUDY_LYAPUNOV_H

#include "cns/flow.h"
#include "cns/monitor.h"
#include "cns/system.h"

CNS_BEGIN_DECLS

#define CNS_LYAPUNOV_ROWS   32 /* of the convergence table: at t0 + k T / 32 */
#define CNS_LYAPUNOV_COUNTS 4  /* numbers of batches tried: 16, 32, 64, 128 */

typedef struct cns_lyapunov_spec {
    cns_number time;           /* T > 0; the trajectory is followed for 1.1 T */
    cns_arithmetic arithmetic; /* of states and tangents */
    long digits;               /* >= 1; 0 with arithmetic double */
    const double *tangent;     /* at t = 0, per dynamic state; NULL: one that no symmetry singles out */
} cns_lyapunov_spec;

typedef struct cns_lyapunov_row {
    double t; /* since the beginning of the trajectory */
    double lambda, se;
} cns_lyapunov_row;

typedef struct cns_lyapunov_result {
    double lambda, se; /* those of the last row */
    double discarded;  /* t0 */
    cns_lyapunov_row row[CNS_LYAPUNOV_ROWS];
    struct {
        int count;
        double length; /* in time */
        double se;
    } batch[CNS_LYAPUNOV_COUNTS]; /* over all of T */
    int order;
    long steps, landings;
} cns_lyapunov_result;

/* CNS_NUMERIC: a singularity, no dynamic states, or a tangent that vanishes; CNS_STOPPED. */
cns_code cns_lyapunov(const cns_system *s, const cns_lyapunov_spec *spec, const cns_monitor *monitor,
                      cns_lyapunov_result *result, cns_error *err);

CNS_END_DECLS

#endif
