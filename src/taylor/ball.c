#include "ball.h"

#if __has_include(<flint/fmpq.h>)
#include <flint/fmpq.h>
#else
#include <fmpq.h>
#endif

#include "op/rules.h"

void cns_ball_number(arb_t y, const cns_number *x, slong prec)
{
    fmpq_t ratio;
    fmpq_init(ratio);
    fmpq_set_mpq(ratio, x->ratio);
    arb_set_fmpq(y, ratio, prec);
    fmpq_clear(ratio);
    if (x->pi_power == 0)
        return;
    arb_t pi;
    arb_init(pi);
    arb_const_pi(pi, prec + 8);
    if (x->pi_power > 0)
        arb_mul(y, y, pi, prec);
    else
        arb_div(y, y, pi, prec);
    arb_clear(pi);
}

/* All nodes over the box; to be freed. */
static arb_ptr nodes_over(const cns_program *p, arb_srcptr x, slong prec)
{
    arb_ptr value = _arb_vec_init(p->n_nodes);
    for (int v = 0; v < p->n_nodes; v++) {
        const cns_program_node *n = &p->node[v];
        cns_enclosure e = {.p = p, .node = n, .y = value + v, .value = value, .state = x, .prec = prec};
        for (int k = 0; k < 4; k++)
            e.x[k] = n->arg[k] < 0 ? NULL : value + n->arg[k];
        cns_operations[n->op]->enclose(&e);
    }
    return value;
}

void cns_ball_outputs(const cns_program *p, arb_srcptr x, arb_ptr y, slong prec)
{
    arb_ptr value = nodes_over(p, x, prec);
    for (int i = 0; i < p->n_outputs; i++)
        arb_set(y + i, value + p->output[i]);
    _arb_vec_clear(value, p->n_nodes);
}

cns_code cns_ball_derivatives(const cns_program *p, arb_srcptr x, arb_ptr f, slong prec, cns_error *err)
{
    arb_ptr value = nodes_over(p, x, prec);
    cns_code code = CNS_OK;
    for (int i = 0; i < p->n_states && !code; i++) {
        arb_set(f + i, value + p->derivative[i]);
        if (p->factor[i] >= 0)
            arb_mul(f + i, f + i, value + p->factor[i], prec);
        if (!arb_is_finite(f + i))
            code = cns_fail(err, CNS_NUMERIC, "the derivative of state %d is not defined there", i);
    }
    _arb_vec_clear(value, p->n_nodes);
    return code;
}
