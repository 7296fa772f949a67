/* The inside of a jet, for the recurrences. Private to src/taylor. */
#ifndef CNS_TAYLOR_JET_INTERNAL_H
#define CNS_TAYLOR_JET_INTERNAL_H

#include "jet.h"
#include "program_internal.h"

struct cns_jet {
    cns_jet_spec spec;
    const cns_program *p;
    const cns_arith_ops *ops;
    cns_arith *A;
    int order;   /* of this expansion */
    int *series; /* per node: its series, -1 if it has none; folded nodes have none, constants have one */
    int *plan;   /* the nodes to compute at each order, one after another */
    int n_plan;
    int *state_series;   /* per state */
    int registers_from;  /* the first of the registers' series */
    bool *constant_zero; /* per node: it is a constant, and zero */
    bool sharp;          /* smoothed abs() is expanded as |u| (cns_jet_is_sharp) */

    /* Of this expansion; per node unless it says otherwise. */
    bool *vanishes;       /* it is identically zero, as states that are exactly zero make it */
    bool *state_vanishes; /* per state */
    bool *at_zero;        /* it is zero at t0, whatever its coefficient 0 says (cns_jet_set_zero) */
    signed char *sign; /* of an absolute value |u| (or hypot() on an invariant line): the sign of u after t0,
                          which it holds until u has a zero; 0: not decided yet */
    signed char *held; /* the same, as the pass before found it: a SIGNED needs it from order 0 on */
    bool sign_late;    /* in this pass a SIGNED needed a sign that was not decided yet */

    /* Where a divisor or radicand vanishes at t0 (jet_singular.c). */
    bool singular;
    int *val;   /* a lower bound of the number of leading zeros, exact where a divisor needs it; else 0 */
    int *known; /* how many coefficients are computed */
    int *state_known; /* per state */

    /* The trace of an order (arith.h), for orders from FIRST_REPEATED on. The recurrences are asked for it
     * again when one of the arrays has changed by which they decide what to call. */
    cns_arith *recorder;
    cns_trace trace;
    bool traced;             /* there is one */
    signed char *traced_for; /* sign, held, vanishes and state_vanishes when it was recorded */

    mpfr_t x, y, z; /* scratch, working precision */
};

/* Adds sign * (coefficient n of node v) to the accumulator: a stored coefficient, or, for a folded node,
 * the sums and products it stands for. */
void cns_accumulate(cns_jet *J, int sign, int v, int n);

/* So many orders beyond spec.order have room in a series: where there are leading zeros, products need them.
 */
enum { CNS_LOOKAHEAD = 4 };

void cns_jet_next_state(cns_jet *J, int i, int k); /* x_{k+1} = H f_k / (k+1) */
cns_code cns_jet_expand_singular(cns_jet *J, int order, cns_error *err);
bool cns_jet_lies_on_kinks(cns_jet *J); /* at order 0; marks them in at_zero */

/* What an operation has to watch: the node in whose zeros its result is not analytic, and for
 * CNS_WATCH_SMOOTH the node eps. */
typedef struct cns_watched {
    int node;
    cns_watch_kind kind;
    int eps;
} cns_watched;

static inline const cns_operation *cns_operation_of(const cns_jet *J, int v)
{
    return cns_operations[J->p->node[v].op];
}

static inline bool cns_is_zero(const cns_jet *J, int series, int k)
{
    long e;
    return J->ops->get_2exp(J->A, &e, series, k) == 0;
}

static inline int cns_least(int a, int b)
{
    return a < b ? a : b;
}

#endif
