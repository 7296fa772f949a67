/* Exponential, logarithm, powers. The Euler derivative of a logarithm or a power is the node after it. */
#include "rules.h"

/* exp: operands u, euler(u).   n w_n = sum_{j=1..n} j u_j w_{n-j}. */

static cns_code exp_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    (void)err;
    const int *arg = J->p->node[v].arg;
    if (n == 0) {
        J->ops->function(J->A, CNS_FN_EXP, J->series[v], -1, J->series[arg[0]], -1);
        return CNS_OK;
    }
    J->ops->zero(J->A);
    cns_add_euler_product(J, 1, arg[1], v, n, n - J->val[v]);
    J->ops->store_ratio(J->A, J->series[v], n, 1, n);
    return CNS_OK;
}

CNS_DERIVE(exp, cns_times(d, d->w, d->dx[0]))
CNS_ENCLOSE(exp, arb_exp(e->y, e->x[0], e->prec))
CNS_OPERATION(exp, 2, cns_known_as_first, cns_never_vanishes, NULL);

/* w_n = acc / (n u_0). */
static void store_over_order(cns_jet *J, int v, int n, int u)
{
    J->ops->store_over(J->A, J->series[v], n, J->series[u], 0, 0);
    J->ops->zero(J->A);
    J->ops->coef(J->A, 1, J->series[v], n);
    J->ops->store_ratio(J->A, J->series[v], n, 1, n);
}

static bool positive(const cns_jet *J, int u)
{
    long e;
    return J->ops->get_2exp(J->A, &e, J->series[u], 0) > 0;
}

/* log: operands u, euler(u).   n u_0 w_n = n u_n - sum_{j=1..n-1} j w_j u_{n-j}. */

static cns_code log_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    const int *arg = J->p->node[v].arg;
    if (n == 0) {
        if (!positive(J, arg[0]))
            return cns_singular(J, v, "logarithm of a number that is not positive", err);
        J->ops->function(J->A, CNS_FN_LOG, J->series[v], -1, J->series[arg[0]], -1);
        return CNS_OK;
    }
    J->ops->zero(J->A);
    cns_accumulate(J, 1, arg[1], n);
    cns_add_euler_product(J, -1, v + 1, arg[0], n, n - 1);
    store_over_order(J, v, n, arg[0]);
    return CNS_OK;
}

CNS_DERIVE(log, cns_over(d, d->dx[0], d->x[0]))
CNS_ENCLOSE(log, arb_log(e->y, e->x[0], e->prec))
CNS_OPERATION(log, 2, cns_known_beside_companion, cns_never_vanishes, NULL, .has_companion = true);

/* pow: w = u^p, p constant; operands u, p, p euler(u).
 * n u_0 w_n = p sum_{j=1..n} j u_j w_{n-j} - sum_{j=1..n-1} j w_j u_{n-j}. */

static cns_code pow_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    const int *arg = J->p->node[v].arg;
    if (n == 0) {
        if (!positive(J, arg[0]))
            return cns_singular(J, v, "real power of a number that is not positive", err);
        J->ops->function(J->A, CNS_FN_POW, J->series[v], -1, J->series[arg[0]], J->series[arg[1]]);
        return CNS_OK;
    }
    J->ops->zero(J->A);
    cns_add_euler_product(J, 1, arg[2], v, n, n);
    cns_add_euler_product(J, -1, v + 1, arg[0], n, n - 1);
    store_over_order(J, v, n, arg[0]);
    return CNS_OK;
}

CNS_DERIVE(pow, cns_over(d, cns_times(d, d->x[1], cns_times(d, d->w, d->dx[0])), d->x[0]))
CNS_ENCLOSE(pow, arb_pow(e->y, e->x[0], e->x[1], e->prec))
CNS_OPERATION(pow, 3, cns_known_beside_companion, cns_never_vanishes, NULL, .has_companion = true);
