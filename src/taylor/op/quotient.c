/* Quotients. */
#include "rules.h"

/* div: w = a/b, b = b_m t^m + ...:  w_n = (a_{n+m} - sum_{j=1..n} b_{m+j} w_{n-j}) / b_m. */

static cns_code div_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    const int a = J->p->node[v].arg[0], b = J->p->node[v].arg[1], m = J->val[b];
    if ((n == 0 || J->singular) && cns_is_zero(J, J->series[b], m))
        return cns_singular(J, v, "division by zero", err);
    J->ops->zero(J->A);
    cns_accumulate(J, 1, a, n + m);
    if (!J->p->node[b].constant)
        cns_add_product(J, -1, b, v, n + m, m + 1, n + m - J->val[v]);
    J->ops->store_over(J->A, J->series[v], n, J->series[b], m, 0);
    return CNS_OK;
}

/* A divisor of which only zeros are known so far is waited for. */
static int div_known(const cns_jet *J, int v)
{
    const int a = J->p->node[v].arg[0], b = J->p->node[v].arg[1], m = J->val[b];
    if (J->vanishes[b])
        return CNS_POLE;
    if (J->known[b] <= m)
        return 0;
    if (J->val[a] < m && J->known[a] > J->val[a])
        return CNS_POLE;
    const int lead = J->val[a] > m ? J->val[a] - m : 0;
    return cns_least(J->known[a] - m, J->known[b] - m + lead);
}

static bool div_vanishes(const cns_jet *J, int v)
{
    const int *arg = J->p->node[v].arg;
    return J->vanishes[arg[0]] && !J->vanishes[arg[1]];
}

CNS_DERIVE(div, cns_over(d, cns_plus(d, d->dx[0], cns_minus(d, cns_times(d, d->w, d->dx[1]))), d->x[1]))
CNS_ENCLOSE(div, arb_div(e->y, e->x[0], e->x[1], e->prec))
CNS_EXACT(div, mpq_sgn(x[1]) != 0 && (mpq_div(y, x[0], x[1]), true))
CNS_OPERATION(div, 2, div_known, div_vanishes, NULL, .adds = 1, .exact = div_exact);
