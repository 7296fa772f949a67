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

/* W - w = (A - w B - (a - w b) + (a - w b)) / B with the exact operands A and B, |B| >= m:
 * |W - w| <= (|a - w b| + |A - a| + |w| |B - b|) / m. */
bool cns_quotient_remainder(cns_defect *d, int v, int a, int b)
{
    mag_t x, m;
    bool is = d->row[v] >= 0 && (d->row[b] >= 0 || d->p->node[b].constant);
    if (!is)
        return false;
    mag_init(x);
    mag_init(m);
    is = cns_defect_lowest(m, d, b);
    if (is && !d->p->node[b].constant) { /* of a constant the error has been taken off */
        mag_add(x, d->e0 + b, d->e1 + b);
        mag_sub_lower(m, m, x);
        is = !mag_is_zero(m);
    }
    if (is) {
        mag_mul(x, d->size + v, d->size + b);
        mag_add(x, x, d->size + a);
        cns_remainder_begin(d, v, x, x);
        mag_addmul(d->e0 + v, d->unit, x); /* the reciprocal's */
        mag_add(d->e0 + v, d->e0 + v, d->e0 + a);
        mag_addmul(d->e0 + v, d->norm + v, d->e0 + b);
        mag_div(d->e0 + v, d->e0 + v, m);
        cns_defect_leading(x, d, a);
        cns_defect_products(d->e1 + v, d, v, b);
        mag_add(d->e1 + v, d->e1 + v, x);
        mag_add(d->e1 + v, d->e1 + v, d->e1 + a);
        mag_addmul(d->e1 + v, d->norm + v, d->e1 + b);
        mag_div(d->e1 + v, d->e1 + v, m);
    }
    mag_clear(x);
    mag_clear(m);
    return is;
}

static bool div_remainder(cns_defect *d, int v)
{
    return cns_quotient_remainder(d, v, d->p->node[v].arg[0], d->p->node[v].arg[1]);
}

CNS_DERIVE(div, cns_over(d, cns_plus(d, d->dx[0], cns_minus(d, cns_times(d, d->w, d->dx[1]))), d->x[1]))
CNS_ENCLOSE(div, arb_div(e->y, e->x[0], e->x[1], e->prec))
CNS_EXACT(div, mpq_sgn(x[1]) != 0 && (mpq_div(y, x[0], x[1]), true))
CNS_OPERATION(div, 2, div_known, div_vanishes, NULL, .adds = 1, .exact = div_exact);
