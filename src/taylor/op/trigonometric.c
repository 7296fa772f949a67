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

/* (c + i s)' = i a' (c + i s) + r is a rotation: the error is that of the start, and the integral of |r|.
 * Both are bounded here; the cosine has the same bounds. */
static bool sin_remainder(cns_defect *d, int v)
{
    const int *arg = d->p->node[v].arg, a = arg[0], du = arg[1], c = v + 1;
    mag_t x, y;
    if (d->row[a] < 0 && !d->p->node[a].constant)
        return false;
    mag_init(x);
    mag_init(y);
    mag_add(x, d->size + v, d->size + c);
    mag_mul(x, x, d->size + du);
    mag_add(x, x, d->size + c);
    mag_add(x, x, d->size + c); /* the starts, too */
    mag_add(x, x, d->size + v);
    cns_remainder_begin(d, v, x, x);
    mag_add(d->e0 + v, d->e0 + v, d->e0 + a);
    if (d->row[a] >= 0 && !d->J->vanishes[a]) {
        cns_defect_euler_products(x, d, a, c);
        if (d->row[v] >= 0 && !d->J->vanishes[v]) {
            cns_defect_euler_products(y, d, a, v);
            mag_add(x, x, y);
        }
        mag_div_ui(d->e1 + v, x, (ulong)d->N);
    }
    mag_add(d->e1 + v, d->e1 + v, d->e1 + a);
    mag_set(d->e0 + c, d->e0 + v);
    mag_set(d->e1 + c, d->e1 + v);
    mag_clear(x);
    mag_clear(y);
    return true;
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

/* The sine's; where that vanishes, u does, exactly or with a remainder of its own. */
static bool cos_remainder(cns_defect *d, int v)
{
    const int *arg = d->p->node[v].arg, s = arg[2];
    return !d->J->vanishes[s] || !mag_is_zero(d->e0 + arg[0]) || sin_remainder(d, s);
}

CNS_DERIVE(cos, cns_minus(d, cns_times(d, d->x[2], d->dx[0])))
CNS_ENCLOSE(cos, arb_cos(e->y, e->x[0], e->prec))
CNS_OPERATION(cos, 3, cos_known, cns_never_vanishes, NULL);
