/* Jets: the Taylor coefficients of a solution, from a program, in any arithmetic.
 *
 * A jet expands the solution through a given state in tau = (t - t0)/H. It evaluates the program order by
 * order: all operations at order k, then coefficient k+1 of every state from its derivative
 * (A. Jorba, M. Zou, Exp. Math. 14 (2005) 99, section 2). Where a divisor or a radicand vanishes at t0, a
 * coefficient of a result needs higher ones of the operands: then every operation is computed as far as its
 * operands allow, and states run ahead of each other (jet_singular.c). */
#ifndef CNS_TAYLOR_JET_H
#define CNS_TAYLOR_JET_H

#include <mpfr.h>
#include <stdbool.h>

#include "arith/arith.h"
#include "cns/program.h"
#include "cns/status.h"

typedef struct cns_jet cns_jet;

/* Smoothing of abs() changes a solution by some eps^2, and by eps^1.5 at a zero of u that only touches. Where
 * that is far below 2^-prec the smoothing is sharp: sqrt(u^2 + eps^2) is then expanded as |u|, with its kink,
 * on which steps end. It could not be told from |u|, and a zero of u that is known to 2^-prec could not be
 * approached to a distance of eps. False also where p is not smoothed. */
bool cns_jet_is_sharp(const cns_program *p, mpfr_prec_t prec);

typedef struct cns_jet_spec {
    const cns_program *program; /* finished; must outlive the jet */
    const cns_arith_ops *ops;
    int order; /* highest order of the states, >= 1 */
    mpfr_prec_t prec;
    const char *kernel;     /* as in cns_arith_spec */
    mpfr_prec_t sharp_prec; /* the precision that decides whether smoothing is sharp; 0: prec */
    bool outputs;           /* also compute the nodes that only outputs need */
    int registers;          /* extra series for the caller's use (Runge-Kutta stages) */
} cns_jet_spec;

/* NULL: out of memory, or a constant of the program is not a finite number; err says which. */
cns_jet *cns_jet_new(const cns_jet_spec *spec, cns_error *err);
void cns_jet_free(cns_jet *J);
size_t cns_jet_bytes(const cns_jet *J); /* of memory in its series; NULL: none */

/* Starts an expansion in tau = (t - t0)/H. H is exact; 1 is allowed. */
void cns_jet_begin(cns_jet *J, double H);

/* The states at t0, each once after cns_jet_begin. */
void cns_jet_set_state(cns_jet *J, int i, const mpfr_t x);

/* Says that the last step ended on a zero of watched quantity w, so that it is zero at t0: its coefficient 0
 * may be rounding noise, and does not decide its sign after t0. Holds for this expansion. */
void cns_jet_set_zero(cns_jet *J, int w);

/* Coefficients 0..order of all states, 1 <= order <= spec.order; from a start with leading zeros up to
 * four fewer (cns_jet_order tells).
 * CNS_NUMERIC: a quotient, root, logarithm or power is singular at t0 (err says which). */
cns_code cns_jet_expand(cns_jet *J, int order, cns_error *err);
/* Of the solution through the states that are set: constant[i], which on entry says what is known already of
 * state i, is whether it keeps its value for ever, zero_output[i] whether a derived quantity is zero for
 * ever. Both are proofs: the derivative, or the quantity, is made of what vanishes identically. */
void cns_jet_constants(cns_jet *J, bool *constant, bool *zero_output);

int cns_jet_order(const cns_jet *J);

/* The coefficients. y gets the arithmetic's value rounded to y's precision. */
void cns_jet_coefficient(const cns_jet *J, mpfr_t y, int state, int k);
double cns_jet_coefficient_2exp(const cns_jet *J, long *e, int state, int k); /* see arith.h get_2exp */

/* y = sum_k x_k tau^k of a state, all bits of the coefficients used; within the range of tau of the
 * arithmetic the error is that of one more rounding (arith.h, rounding_log2). */
void cns_jet_sum(const cns_jet *J, mpfr_t y, int state, const mpfr_t tau);

/* An output's value at t0 (spec.outputs). False when it is singular there. */
bool cns_jet_output(const cns_jet *J, mpfr_t y, int output);

/* Composition: the series of f(x) for given series x of the states, whether or not they solve x' = f(x).
 * Orders are composed one after another from 0 on; the states' coefficients of an order are set before, and
 * the latest order may be composed again after they have been changed. An abs() whose operand is zero at
 * order 0, to half of the precision, takes the sign of its next coefficient. spec.registers >= 1.
 * CNS_NUMERIC: singular at order 0. */
void cns_jet_set_coefficient(cns_jet *J, int state, int k, const mpfr_t x);
cns_code cns_jet_compose(cns_jet *J, int k, cns_error *err);
void cns_jet_composed(cns_jet *J, mpfr_t y, int state, int k); /* coefficient k of f */

/* Watched quantities: those in whose zeros the solution is not analytic. */
typedef enum cns_watch_kind {
    CNS_WATCH_KINK,  /* the operand of an abs(): its sign may simply change */
    CNS_WATCH_ROOT,  /* a square root: singular where it vanishes */
    CNS_WATCH_SMOOTH /* the operand u of sqrt(u^2 + eps^2), analytic, but with singularities at a distance
                        of about eps/|u'| from its zeros, which a step must not leap over */
} cns_watch_kind;

typedef struct cns_watch {
    int series; /* its series, a polynomial in tau whose roots a step must not pass */
    int order;  /* of that polynomial */
    int zeros;  /* so many leading coefficients are zero within rounding: the step begins on a zero */
    int state;  /* if it is a state, which; else -1 */
    cns_watch_kind kind;
    int eps; /* CNS_WATCH_SMOOTH: the series that holds eps */
} cns_watch;

int cns_jet_watched(const cns_jet *J);
/* Do two expansions, of a program and of its tangent program, hold the same signs of what stands under abs()?
 * J is that of the tangent program: it may have fewer of them. */
bool cns_jet_signs_agree(const cns_jet *J, const cns_jet *of);
/* After an expansion. False: the quantity vanishes identically on this step, and is not to be watched. */
bool cns_jet_watch(const cns_jet *J, int w, cns_watch *watch);

/* For methods that need values of the right-hand side f only, and calculate with them themselves: the
 * arithmetic, the states' series (after an expansion of order 1 with H = 1 their coefficient 1 is f) and the
 * registers. */
const cns_arith_ops *cns_jet_ops(const cns_jet *J);
cns_arith *cns_jet_arith(const cns_jet *J);
int cns_jet_state_series(const cns_jet *J, int i);
int cns_jet_register(const cns_jet *J, int r);
/* Records such an expansion, through the states that are set, as straight code for others (arith/straight.h):
 * `straight` has room for all series, cns_jet_series() of them. False: there is no such code here. */
bool cns_jet_record(cns_jet *J, cns_arith *straight);
int cns_jet_series(const cns_jet *J); /* how many there are but for the registers */

#endif
