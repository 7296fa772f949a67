/* How a saddle's one-dimensional unstable manifold passes the next saddle.
 *
 * The branch that the model's connection names is expanded to high order about the saddle (see
 * src/study/branch.h), then integrated until it comes near the next saddle, the saddle itself or one of its
 * images under the model's symmetries, and leaves it along its unstable direction. The side on which it
 * leaves is the mode; the time at which it does gives the distance by which it has missed: near a connection
 * at I_c
 *
 *     coordinate along the unstable eigenvector = C (I - I_c) e^(lambda t) (1 + ...),
 *
 * so that `miss`, the coordinate's value divided by e^(lambda t), is a smooth function of the parameter with
 * a simple zero at I_c, up to corrections that vanish with it. */
#ifndef CNS_STUDY_SADDLE_MANIFOLD_H
#define CNS_STUDY_SADDLE_MANIFOLD_H

#include <mpfr.h>

#include "cns/monitor.h"
#include "cns/system.h"

/* Two variants differ in the precision, in the order and start of the expansion, in the order, tolerance and
 * safety of the steps: what they agree in does not depend on them. */
typedef struct cns_passage_spec {
    long digits; /* of the arithmetic; the manifold's start is right to so many */
    int variant; /* 0 or 1 */
    int passes;  /* how many saddles to pass, one after another: 0 and 1 mean the first */
} cns_passage_spec;

/* Of the last saddle that was passed. Near a connection motions settle down to a periodic one, in some few
 * passes where it attracts: its period is the interval times the passes in it. */
typedef struct cns_passage {
    int side;      /* 1: beyond; -1: back (see cns_model_connection) */
    mpfr_t miss;   /* of the first saddle: signed, in units of the eigenvectors, 1 being as far away as scales
                      of the model say */
    double time;   /* from the branch's parameter s = 1 until it leaves the next saddle */
    double lambda; /* the unstable eigenvalue */
    double interval; /* between the last two departures; 0 after one */
    double loss;     /* digits of the miss lost to a start at a small s, as smoothing forces it */
    long steps;
} cns_passage;

void cns_passage_init(cns_passage *p, mpfr_prec_t prec);
void cns_passage_clear(cns_passage *p);

/* CNS_USAGE: the model names no connection. CNS_NUMERIC: no such saddle, the manifold does not come near the
 * next one, or it comes so near that so many digits do not tell on which side it leaves. The monitor hears of
 * the time reached, in units of that which so many digits last. */
cns_code cns_manifold_passage(const cns_system *s, const cns_passage_spec *spec, const cns_monitor *monitor,
                              cns_passage *p, cns_error *err);

#endif
