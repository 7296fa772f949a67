/* What has no operands: constants, parameters, states. */
#include "rules.h"
#include "taylor/ball.h"

static int known_already(const cns_jet *J, int v)
{
    return J->known[v];
}

/* Constants are expanded at order 0 only, where J->x has the bits that they need. */
static cns_code set_number(cns_jet *J, int v, const cns_number *x)
{
    cns_number_get_mpfr(J->x, x);
    J->ops->set(J->A, J->series[v], 0, J->x, false);
    return CNS_OK;
}

/* Sets y to x, unless pi is in it. */
static bool is_rational(mpq_t y, const cns_number *x)
{
    mpq_set(y, x->ratio);
    return x->pi_power == 0;
}

/* constant: number `index` of the program's constants; -1: eps of its smoothed absolute values. */

static const cns_number *constant_of(const cns_program *p, const cns_program_node *n)
{
    return n->index < 0 ? &p->smooth : &p->constants[n->index];
}

static cns_code constant_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    (void)n, (void)err;
    return set_number(J, v, constant_of(J->p, &J->p->node[v]));
}

#define constant_remainder cns_no_remainder
CNS_DERIVE(constant, -1)
CNS_ENCLOSE(constant, cns_ball_number(e->y, constant_of(e->p, e->node), e->prec))
CNS_EXACT(constant, is_rational(y, constant_of(p, n)))
CNS_OPERATION(constant, 0, known_already, cns_never_vanishes, NULL, .exact = constant_exact);

/* parameter: number `index` of the program's parameters. */

static cns_code parameter_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    (void)n, (void)err;
    return set_number(J, v, &J->p->parameters[J->p->node[v].index]);
}

#define parameter_remainder cns_no_remainder
CNS_DERIVE(parameter, -1)
CNS_ENCLOSE(parameter, cns_ball_number(e->y, &e->p->parameters[e->node->index], e->prec))
CNS_EXACT(parameter, is_rational(y, &p->parameters[n->index]))
CNS_OPERATION(parameter, 0, known_already, cns_never_vanishes, NULL, .exact = parameter_exact);

/* state: state `index`. */

/* Its coefficients are given, or come from its derivative, an order behind all others (jet.c). */
static cns_code state_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    (void)J, (void)v, (void)n, (void)err;
    return CNS_OK;
}

static bool state_vanishes(const cns_jet *J, int v)
{
    return J->state_vanishes[J->p->node[v].index];
}

#define state_remainder cns_no_remainder
CNS_DERIVE(state, cns_component(d))
CNS_ENCLOSE(state, arb_set(e->y, e->state + e->node->index))
CNS_OPERATION(state, 0, known_already, state_vanishes, NULL);
