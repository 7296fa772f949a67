/* The Euler derivative t d/dt, which multiplies coefficient n by n: a help of other recurrences. */
#include "rules.h"

void cns_add_euler_product(cns_jet *J, int sign, int du, int b, int n, int hi)
{
    cns_add_product(J, sign, du, b, n, J->val[du] > 1 ? J->val[du] : 1, hi);
}

/* euler: w = t da/dt:  w_n = n a_n. */

static cns_code euler_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    (void)err;
    J->ops->zero(J->A);
    if (n > 0)
        J->ops->coef(J->A, n, J->series[J->p->node[v].arg[0]], n);
    J->ops->store(J->A, J->series[v], n);
    return CNS_OK;
}

/* No value depends on it: the derivatives of its users and their enclosures are written without it. */

#define euler_remainder cns_no_remainder
CNS_DERIVE(euler, -1)
CNS_ENCLOSE(euler, arb_indeterminate(e->y))
CNS_OPERATION(euler, 1, cns_known_as_first, cns_vanishes_with_first, NULL);
