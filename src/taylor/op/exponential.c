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

/* W0 = exp(a) of the polynomial a changes by a factor of at most R = exp(sum of |a_k|, k >= 1) to either side
 * of W0(0). w' = a' w + r and w = W0 q give q' = r / W0: |w - W0| <= R |w_0 - exp(a_0)| + R^2 int |r|. And
 * exp(a + A) - exp(a) = exp(a) (exp(A) - 1), exp(X + Y tau^N) - 1 <= exp(X) - 1 + exp(X) (exp(Y) - 1) tau^N.
 */
static bool exp_remainder(cns_defect *d, int v)
{
    const int *arg = d->p->node[v].arg, a = arg[0], du = arg[1];
    if (d->row[v] < 0 || (d->row[a] < 0 && !d->p->node[a].constant))
        return false;
    mag_t R, x, W, e;
    mag_init(R);
    mag_init(x);
    mag_init(W);
    mag_init(e);
    mag_mul(x, d->size + v, d->size + du);
    mag_add(x, x, d->size + v);
    cns_remainder_begin(d, v, x, x);
    cns_defect_from(x, d, a, 1);
    mag_mul_2exp_si(x, x, 1);
    mag_exp(R, x);
    if (d->row[a] >= 0 && !d->J->vanishes[a])
        cns_defect_euler_products(d->e1 + v, d, a, v);
    mag_div_ui(d->e1 + v, d->e1 + v, (ulong)d->N);
    mag_mul(d->e0 + v, d->e0 + v, R);
    mag_mul(d->e1 + v, d->e1 + v, R);
    mag_add(W, d->norm + v, d->e0 + v);
    mag_add(W, W, d->e1 + v);
    mag_expm1(e, d->e0 + a);
    mag_addmul(d->e0 + v, W, e);
    mag_expm1(x, d->e1 + a);
    mag_one(R);
    mag_add(e, e, R);
    mag_mul(x, x, e);
    mag_addmul(d->e1 + v, W, x);
    mag_clear(R);
    mag_clear(x);
    mag_clear(W);
    mag_clear(e);
    return true;
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

/* m <= |a|, *far <= |A| for the exact operand A of node a; a is positive. */
static bool bounded_below(cns_defect *d, int a, mag_t m, mag_t far)
{
    if (!cns_defect_lowest(m, d, a) || (d->row[a] >= 0 && !positive(d->J, a)))
        return false;
    mag_add(far, d->e0 + a, d->e1 + a);
    mag_sub_lower(far, m, far);
    return !mag_is_zero(far);
}

/* a w' = a' + r: |w - log a| <= |w_0 - log a_0| + int |r| / m; and |log A - log a| <= |A - a| / least. */
static bool log_remainder(cns_defect *d, int v)
{
    const int *arg = d->p->node[v].arg, a = arg[0], du = arg[1], dw = v + 1;
    mag_t m, far, x;
    mag_init(m);
    mag_init(far);
    mag_init(x);
    const bool is = d->row[v] >= 0 && d->row[a] >= 0 && bounded_below(d, a, m, far);
    if (is) {
        mag_mul(x, d->size + dw, d->size + a);
        mag_add(x, x, d->size + du);
        mag_addmul(x, d->size + v, d->size + a);
        cns_remainder_begin(d, v, x, x);
        mag_addmul(d->e0 + v, d->unit, x);
        mag_div(d->e0 + v, d->e0 + v, m);
        mag_add(d->e0 + v, d->e0 + v, d->least);
        mag_addmul(d->e0 + v, d->unit, d->size + v);
        cns_defect_euler_products(d->e1 + v, d, v, a);
        mag_div_ui(d->e1 + v, d->e1 + v, (ulong)d->N);
        cns_defect_leading(x, d, a);
        mag_add(d->e1 + v, d->e1 + v, x);
        mag_div(d->e1 + v, d->e1 + v, m);
        mag_div(x, d->e0 + a, far);
        mag_add(d->e0 + v, d->e0 + v, x);
        mag_div(x, d->e1 + a, far);
        mag_add(d->e1 + v, d->e1 + v, x);
    }
    mag_clear(m);
    mag_clear(far);
    mag_clear(x);
    return is;
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

/* W0 = a^p changes by factors of at most R = (max a / min a)^|p|. a w' = p a' w + r and w = W0 q give
 * q' = r / (a W0): |w - W0| <= R (|w_0 - W0(0)| + int |r| / m); and
 * |A^p - a^p| <= W0 (exp(|p| |A - a| / least) - 1), split as for exp. */
static bool pow_remainder(cns_defect *d, int v)
{
    const int *arg = d->p->node[v].arg, a = arg[0], p = arg[1], du = arg[2], dw = v + 1;
    mag_t m, far, x, y, R;
    mag_init(m);
    mag_init(far);
    mag_init(x);
    mag_init(y);
    mag_init(R);
    const bool is = d->row[v] >= 0 && d->row[a] >= 0 && bounded_below(d, a, m, far);
    if (is) {
        mag_mul(x, d->size + dw, d->size + a);
        mag_addmul(x, d->size + du, d->size + v);
        mag_addmul(x, d->size + v, d->size + a);
        cns_remainder_begin(d, v, x, x);
        mag_addmul(d->e0 + v, d->unit, x);
        mag_div(d->e0 + v, d->e0 + v, m);
        mag_addmul(d->e0 + v, d->unit, d->size + v);
        cns_defect_euler_products(d->e1 + v, d, v, a);
        cns_defect_euler_products(x, d, a, v);
        mag_addmul(d->e1 + v, x, d->norm + p);
        mag_div_ui(d->e1 + v, d->e1 + v, (ulong)d->N);
        mag_div(d->e1 + v, d->e1 + v, m);
        mag_div(x, d->norm + a, m); /* R <= exp(|p| log(max / min)) */
        mag_log(x, x);
        mag_mul(x, x, d->norm + p);
        mag_exp(R, x);
        mag_mul(d->e0 + v, d->e0 + v, R);
        mag_mul(d->e1 + v, d->e1 + v, R);
        mag_add(R, d->norm + v, d->e0 + v);
        mag_add(R, R, d->e1 + v);
        mag_add(x, d->norm + p, d->e0 + p);
        mag_div(x, x, far);
        mag_mul(y, x, d->e0 + a);
        mag_expm1(y, y);
        mag_addmul(d->e0 + v, R, y);
        mag_mul(x, x, d->e1 + a);
        mag_expm1(x, x);
        mag_one(m);
        mag_add(y, y, m);
        mag_mul(x, x, y);
        mag_addmul(d->e1 + v, R, x);
        /* The exponent's own error moves w by |log a| of it. */
        mag_add(x, d->norm + a, d->e0 + a);
        mag_add(x, x, d->e1 + a);
        mag_inv(y, far);
        mag_max(x, x, y);
        mag_log(x, x);
        mag_mul(x, x, d->e0 + p);
        mag_expm1(x, x);
        mag_addmul(d->e0 + v, R, x);
    }
    mag_clear(m);
    mag_clear(far);
    mag_clear(x);
    mag_clear(y);
    mag_clear(R);
    return is;
}

CNS_DERIVE(pow, cns_over(d, cns_times(d, d->x[1], cns_times(d, d->w, d->dx[0])), d->x[0]))
CNS_ENCLOSE(pow, arb_pow(e->y, e->x[0], e->x[1], e->prec))
CNS_OPERATION(pow, 3, cns_known_beside_companion, cns_never_vanishes, NULL, .has_companion = true);
