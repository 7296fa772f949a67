#include "ball.h"

#if __has_include(<flint/fmpq.h>)
#include <flint/fmpq.h>
#else
#include <fmpq.h>
#endif

#include "program_internal.h"

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

/* y = a times the sign of u, which is anything from -1 to 1 where u may vanish. */
static void signed_ball(arb_t y, const arb_t u, const arb_t a, slong prec)
{
    if (arb_is_positive(u)) {
        arb_set(y, a);
    } else if (arb_is_negative(u)) {
        arb_neg(y, a);
    } else {
        arb_zero(y);
        mag_one(arb_radref(y));
        arb_mul(y, y, a, prec);
    }
}

static void evaluate(const cns_program *p, int v, arb_ptr value, arb_srcptr x, slong prec)
{
    const cns_tape_node *n = &p->node[v];
    const int *arg = n->arg;
    arb_ptr y = value + v;
    arb_srcptr a = arg[0] >= 0 ? value + arg[0] : NULL, b = arg[1] >= 0 ? value + arg[1] : NULL;
    switch (n->op) {
    case CNS_OP_CONSTANT:
        cns_ball_number(y, n->index < 0 ? &p->smooth : &p->constants[n->index], prec);
        break;
    case CNS_OP_PARAMETER:
        cns_ball_number(y, &p->parameters[n->index], prec);
        break;
    case CNS_OP_STATE:
        arb_set(y, x + n->index);
        break;
    case CNS_OP_ADD:
        arb_add(y, a, b, prec);
        break;
    case CNS_OP_SUB:
        arb_sub(y, a, b, prec);
        break;
    case CNS_OP_NEG:
        arb_neg(y, a);
        break;
    case CNS_OP_MUL:
    case CNS_OP_SCALE:
        arb_mul(y, a, b, prec);
        break;
    case CNS_OP_SQR:
        arb_sqr(y, a, prec);
        break;
    case CNS_OP_DIV:
        arb_div(y, a, b, prec);
        break;
    case CNS_OP_SQRT:
    case CNS_OP_SMOOTH_ABS:
        arb_sqrt(y, a, prec);
        break;
    case CNS_OP_HYPOT:
        arb_hypot(y, a, b, prec);
        break;
    case CNS_OP_SIN:
        arb_sin(y, a, prec);
        break;
    case CNS_OP_COS:
        arb_cos(y, a, prec);
        break;
    case CNS_OP_EXP:
        arb_exp(y, a, prec);
        break;
    case CNS_OP_LOG:
        arb_log(y, a, prec);
        break;
    case CNS_OP_POW:
        arb_pow(y, a, b, prec);
        break;
    case CNS_OP_ABS:
        arb_abs(y, a);
        break;
    case CNS_OP_SIGNED:
        signed_ball(y, value + p->node[arg[0]].arg[0], b, prec);
        break;
    case CNS_OP_EULER: /* a help for series, no value */
    case CNS_OP_COUNT:
        break;
    }
}

cns_code cns_ball_derivatives(const cns_program *p, arb_srcptr x, arb_ptr f, slong prec, cns_error *err)
{
    arb_ptr value = _arb_vec_init(p->n_nodes);
    cns_code code = CNS_OK;
    for (int v = 0; v < p->n_nodes; v++)
        evaluate(p, v, value, x, prec);
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
