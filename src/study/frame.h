/* Tangent vectors carried along a trajectory, and the growth of the volumes that they span.
 *
 * States and n tangent vectors are integrated together (taylor/tangent.h), and after every step each vector
 * is made perpendicular to those before it (Gram and Schmidt) and brought back to length 1/2 to 1 by a power
 * of two, exactly (G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9 and 21).
 * Neither changes how the volumes of the first 1, 2, ..., n vectors grow, whatever the rounding of the
 * projections. Lengths and angles are those of the dynamic states in their scales. */
#ifndef CNS_STUDY_FRAME_H
#define CNS_STUDY_FRAME_H

#include "cns/flow.h"
#include "cns/system.h"

typedef struct cns_frame cns_frame;

typedef struct cns_frame_spec {
    const cns_system *system;
    cns_arithmetic arithmetic; /* of states and tangents */
    long digits;               /* ignored in double */
    int vectors;               /* 1 to the number of dynamic states; 0: as many as those */
    const double *first;       /* the first vector at t = 0, per dynamic state; NULL: no special one */
    bool portable;             /* double: the same bits on every machine, and slower */
    bool traced;               /* the trace of the Jacobian is integrated, too */
    const volatile sig_atomic_t *stop;
} cns_frame_spec;

/* At t = 0. NULL: CNS_NUMERIC, there are no dynamic states; CNS_USAGE, there are fewer than vectors asked
 * for; or what the flow says. */
cns_frame *cns_frame_new(const cns_frame_spec *spec, cns_error *err);
void cns_frame_free(cns_frame *f);

int cns_frame_vectors(const cns_frame *f);
int cns_frame_dimensions(const cns_frame *f); /* dynamic states */
int cns_frame_order(const cns_frame *f);      /* of the Taylor series */
const cns_flow *cns_frame_flow(const cns_frame *f);

/* At time t, not before that of the last call: growth[i] is the logarithm of the length that vector i would
 * have by now, perpendicular to those before it, had it not been shortened; differences of it are what grows.
 * *trace, if traced, is the integral of the trace from 0 to t. */
cns_code cns_frame_at(cns_frame *f, double t, double *growth, double *trace, cns_error *err);

/* Sets y to the trace if it is the same rational number everywhere. */
bool cns_frame_constant_trace(const cns_frame *f, mpq_t y);

#endif
