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
    int *series; /* per node, -1 if it has none (folded, constant nodes have one) */
    int *plan;   /* the nodes to compute at each order, in tape order */
    int n_plan;
    int *state_series;
    int registers_from;

    /* Per node, for this expansion. */
    signed char *sign;   /* ABS and HYPOT on an invariant line: the held sign; 0 while undecided */
    signed char *held;   /* the same from the pass before: SIGNED needs it from order 0 on */
    bool sign_late;      /* a SIGNED was computed before its sign was decided */
    bool *vanishes;      /* identically zero, by the structure of the program and exact zeros of states */
    bool *at_zero;       /* starts on a zero: coefficient 0 does not count */
    bool *constant_zero; /* constants that are zero */
    bool *state_vanishes;
    int *val;         /* lower bound of the number of leading zeros; exact where a divisor needs it */
    int *known;       /* how many coefficients are computed; used in the singular case only */
    int *state_known; /* the same for the states */
    bool sharp;       /* smoothed abs() is treated as exact */
    bool singular;    /* leading zeros are in play */

    /* The trace of every order from FIRST_REPEATED on; made anew when one of the arrays that decide it
     * differs. */
    cns_arith *recorder;
    cns_trace trace;
    bool traced;
    signed char *traced_for; /* sign, held, vanishes and state_vanishes at that time */

    mpfr_t x, y, z; /* scratch, working precision */
};

/* Adds sign * (coefficient n of node v) to the accumulator: a stored coefficient, or, for a folded node,
 * the sums and products it stands for. */
void cns_accumulate(cns_jet *J, int sign, int v, int n);

/* Room beyond the order asked for, where leading zeros let products run ahead of the states. */
enum { CNS_LOOKAHEAD = 4 };

void cns_jet_next_state(cns_jet *J, int i, int k); /* x_{k+1} = H f_k / (k+1) */
cns_code cns_jet_expand_singular(cns_jet *J, int order, cns_error *err);
bool cns_jet_lies_on_kinks(cns_jet *J); /* at order 0; marks them in at_zero */

/* What an operation has to watch: the node in whose zeros w is not analytic, and for CNS_WATCH_SMOOTH the
 * node eps. */
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
