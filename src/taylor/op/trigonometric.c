/* Sine and cosine, which are made together: the cosine is the node after its sine. */
#include "rules.h"

/* sin: operands u, euler(u).   n s_n = sum_{j=1..n} j u_j c_{n-j}. */

static cns_code sin_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    (void)err;
    const int *arg = J->p->node[v].arg, c = v + 1;
    if (n == 0) {
        J->ops->function(J->A, CNS_FN_SINCOS, J->series[v], J->series[c], J->series[arg[0]], -1);
        return CNS_OK;
    }
    J->ops->zero(J->A);
    cns_add_euler_product(J, 1, arg[1], c, n, n - J->val[c]);
    J->ops->store_ratio(J->A, J->series[v], n, 1, n);
    return CNS_OK;
}

CNS_DERIVE(sin, cns_times(d, d->w + 1, d->dx[0]))
CNS_ENCLOSE(sin, arb_sin(e->y, e->x[0], e->prec))
CNS_OPERATION(sin, 2, cns_known_beside_companion, cns_vanishes_with_first, NULL, .has_companion = true);

/* cos: operands u, euler(u), the sine.   n c_n = -sum_{j=1..n} j u_j s_{n-j}; c_0 came with s_0, unless u
 * vanishes identically. */

static cns_code cos_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    (void)err;
    const int *arg = J->p->node[v].arg, s = arg[2];
    if (n == 0) {
        if (J->vanishes[arg[0]]) {
            mpfr_set_ui(J->x, 1, MPFR_RNDN);
            J->ops->set(J->A, J->series[v], 0, J->x, false);
        }
        return CNS_OK;
    }
    J->ops->zero(J->A);
    cns_add_euler_product(J, -1, arg[1], s, n, n - J->val[s]);
    J->ops->store_ratio(J->A, J->series[v], n, 1, n);
    return CNS_OK;
}

static int cos_known(const cns_jet *J, int v)
{
    return cns_least(cns_known_as_first(J, v), J->known[J->p->node[v].arg[2]]);
}

CNS_DERIVE(cos, cns_minus(d, cns_times(d, d->x[2], d->dx[0])))
CNS_ENCLOSE(cos, arb_cos(e->y, e->x[0], e->prec))
CNS_OPERATION(cos, 3, cos_known, cns_never_vanishes, NULL);
