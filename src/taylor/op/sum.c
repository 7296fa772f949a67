/* Sums and products. Where such a node has one user that only adds it to its own accumulator, it is folded
 * into it: nothing is stored. */
#include "rules.h"

void cns_add_product(cns_jet *J, int sign, int a, int b, int n, int lo, int hi)
{
    if (hi >= lo && !J->vanishes[a] && !J->vanishes[b])
        J->ops->conv(J->A, sign, J->series[a], J->series[b], n, lo, hi);
}

void cns_accumulate(cns_jet *J, int sign, int v, int n)
{
    if (J->vanishes[v] || (J->p->node[v].constant && n > 0))
        return;
    if (J->series[v] >= 0)
        J->ops->coef(J->A, sign, J->series[v], n);
    else
        cns_operation_of(J, v)->accumulate(J, sign, v, n);
}

cns_code cns_sum_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    (void)err;
    J->ops->zero(J->A);
    cns_operation_of(J, v)->accumulate(J, 1, v, n);
    J->ops->store(J->A, J->series[v], n);
    return CNS_OK;
}

static void add_remainder_of(cns_defect *d, int v, int operand)
{
    mag_add(d->e0 + v, d->e0 + v, d->e0 + operand);
    mag_add(d->e1 + v, d->e1 + v, d->e1 + operand);
    if (d->p->node[operand].op == CNS_OP_STATE) {
        mag_t leading;
        mag_init(leading);
        cns_defect_leading(leading, d, operand);
        mag_add(d->e1 + v, d->e1 + v, leading);
        mag_clear(leading);
    }
}

bool cns_sum_remainder(cns_defect *d, int v, int a, int b)
{
    if (b < 0) {
        cns_remainder_begin(d, v, d->size + a, d->norm + a);
    } else {
        mag_t terms, norm;
        mag_init(terms);
        mag_init(norm);
        mag_add(terms, d->size + a, d->size + b);
        mag_add(norm, d->norm + a, d->norm + b);
        cns_remainder_begin(d, v, terms, norm);
        mag_clear(terms);
        mag_clear(norm);
        add_remainder_of(d, v, b);
    }
    add_remainder_of(d, v, a);
    return true;
}

/* (a + A)(b + B) - a b = a B + A b + A B, where A, the remainder of a, is below e0 + e1 tau^N, and tau^N
 * <= 1.
 */
bool cns_product_remainder(cns_defect *d, int v, int a, int b)
{
    mag_t x, y;
    mag_init(x);
    mag_init(y);
    mag_mul(x, d->size + a, d->size + b);
    mag_mul(y, d->norm + a, d->norm + b);
    cns_remainder_begin(d, v, x, y);
    mag_addmul(d->e0 + v, d->e0 + a, d->norm + b);
    mag_addmul(d->e0 + v, d->e0 + b, d->norm + a);
    mag_addmul(d->e0 + v, d->e0 + a, d->e0 + b);
    cns_defect_products(d->e1 + v, d, a, b);
    mag_add(x, d->norm + b, d->e0 + b);
    mag_add(x, x, d->e1 + b);
    mag_addmul(d->e1 + v, d->e1 + a, x);
    mag_add(y, d->norm + a, d->e0 + a);
    mag_addmul(d->e1 + v, d->e1 + b, y);
    mag_clear(x);
    mag_clear(y);
    return true;
}

bool cns_no_remainder(cns_defect *d, int v)
{
    (void)d, (void)v;
    return true;
}

static int least_zeros(const cns_jet *J, int v)
{
    const int *arg = J->p->node[v].arg;
    return cns_least(J->val[arg[0]], J->val[arg[1]]);
}

/* add: w = a + b. */

static void add_accumulate(cns_jet *J, int sign, int v, int n)
{
    cns_accumulate(J, sign, J->p->node[v].arg[0], n);
    cns_accumulate(J, sign, J->p->node[v].arg[1], n);
}

static bool add_remainder(cns_defect *d, int v)
{
    return cns_sum_remainder(d, v, d->p->node[v].arg[0], d->p->node[v].arg[1]);
}

CNS_DERIVE(add, cns_plus(d, d->dx[0], d->dx[1]))
CNS_ENCLOSE(add, arb_add(e->y, e->x[0], e->x[1], e->prec))
CNS_EXACT(add, (mpq_add(y, x[0], x[1]), true))
CNS_FOLDED_OPERATION(add, 2, cns_sum_recurrence, cns_known_as_both, cns_vanishes_with_both, least_zeros, 3,
                     .exact = add_exact);

/* sub: w = a - b. */

static void sub_accumulate(cns_jet *J, int sign, int v, int n)
{
    cns_accumulate(J, sign, J->p->node[v].arg[0], n);
    cns_accumulate(J, -sign, J->p->node[v].arg[1], n);
}

static bool sub_remainder(cns_defect *d, int v)
{
    return cns_sum_remainder(d, v, d->p->node[v].arg[0], d->p->node[v].arg[1]);
}

CNS_DERIVE(sub, cns_plus(d, d->dx[0], cns_minus(d, d->dx[1])))
CNS_ENCLOSE(sub, arb_sub(e->y, e->x[0], e->x[1], e->prec))
CNS_EXACT(sub, (mpq_sub(y, x[0], x[1]), true))
CNS_FOLDED_OPERATION(sub, 2, cns_sum_recurrence, cns_known_as_both, cns_vanishes_with_both, least_zeros, 3,
                     .exact = sub_exact);

/* neg: w = -a. */

static void neg_accumulate(cns_jet *J, int sign, int v, int n)
{
    cns_accumulate(J, -sign, J->p->node[v].arg[0], n);
}

static int neg_zeros(const cns_jet *J, int v)
{
    return J->val[J->p->node[v].arg[0]];
}

static bool neg_remainder(cns_defect *d, int v)
{
    return cns_sum_remainder(d, v, d->p->node[v].arg[0], -1);
}

CNS_DERIVE(neg, cns_minus(d, d->dx[0]))
CNS_ENCLOSE(neg, arb_neg(e->y, e->x[0]))
CNS_EXACT(neg, (mpq_neg(y, x[0]), true))
CNS_FOLDED_OPERATION(neg, 1, cns_sum_recurrence, cns_known_as_first, cns_vanishes_with_first, neg_zeros, 1,
                     .exact = neg_exact);

/* mul: w = a b. */

static void mul_accumulate(cns_jet *J, int sign, int v, int n)
{
    const int a = J->p->node[v].arg[0], b = J->p->node[v].arg[1];
    cns_add_product(J, sign, a, b, n, J->val[a], n - J->val[b]);
}

static int mul_known(const cns_jet *J, int v)
{
    const int a = J->p->node[v].arg[0], b = J->p->node[v].arg[1];
    return cns_least(J->known[a] + J->val[b], J->known[b] + J->val[a]);
}

static int mul_zeros(const cns_jet *J, int v)
{
    return J->val[J->p->node[v].arg[0]] + J->val[J->p->node[v].arg[1]];
}

static bool mul_remainder(cns_defect *d, int v)
{
    return cns_product_remainder(d, v, d->p->node[v].arg[0], d->p->node[v].arg[1]);
}

CNS_DERIVE(mul, cns_plus(d, cns_times(d, d->x[0], d->dx[1]), cns_times(d, d->x[1], d->dx[0])))
CNS_ENCLOSE(mul, arb_mul(e->y, e->x[0], e->x[1], e->prec))
CNS_EXACT(mul, (mpq_mul(y, x[0], x[1]), true))
CNS_FOLDED_OPERATION(mul, 2, cns_sum_recurrence, mul_known, cns_vanishes_with_either, mul_zeros, 0,
                     .exact = mul_exact);

/* sqr: w = a^2. */

static void sqr_accumulate(cns_jet *J, int sign, int v, int n)
{
    const int a = J->p->node[v].arg[0];
    if (!J->vanishes[a] && n >= 2 * J->val[a])
        J->ops->square(J->A, sign, J->series[a], n, J->val[a]);
}

static int sqr_known(const cns_jet *J, int v)
{
    const int a = J->p->node[v].arg[0];
    return J->known[a] + J->val[a];
}

static int sqr_zeros(const cns_jet *J, int v)
{
    return 2 * J->val[J->p->node[v].arg[0]];
}

static bool sqr_remainder(cns_defect *d, int v)
{
    return cns_product_remainder(d, v, d->p->node[v].arg[0], d->p->node[v].arg[0]);
}

CNS_DERIVE(sqr, d->dx[0] < 0 ? -1 : cns_mul(d->q, cns_constant(d->q, "2"), cns_mul(d->q, d->x[0], d->dx[0])))
CNS_ENCLOSE(sqr, arb_sqr(e->y, e->x[0], e->prec))
CNS_EXACT(sqr, (mpq_mul(y, x[0], x[0]), true))
CNS_FOLDED_OPERATION(sqr, 1, cns_sum_recurrence, sqr_known, cns_vanishes_with_first, sqr_zeros, 0,
                     .exact = sqr_exact);

/* scale: w = c a, c constant. Stored, it is c times the sum that a is, which may be folded into it; folded
 * itself, the sum it belongs to has other terms, and c multiplies the stored a. */

static cns_code scale_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    (void)err;
    const int *arg = J->p->node[v].arg;
    J->ops->zero(J->A);
    cns_accumulate(J, 1, arg[1], n);
    J->ops->store_scaled(J->A, J->series[v], n, J->series[arg[0]]);
    return CNS_OK;
}

static void scale_accumulate(cns_jet *J, int sign, int v, int n)
{
    const int *arg = J->p->node[v].arg;
    if (!J->vanishes[arg[1]])
        J->ops->scaled(J->A, sign, J->series[arg[0]], J->series[arg[1]], n);
}

static int scale_zeros(const cns_jet *J, int v)
{
    return J->val[J->p->node[v].arg[1]];
}

static bool scale_remainder(cns_defect *d, int v)
{
    return cns_product_remainder(d, v, d->p->node[v].arg[0], d->p->node[v].arg[1]);
}

CNS_DERIVE(scale, cns_times(d, d->x[0], d->dx[1]))
CNS_ENCLOSE(scale, arb_mul(e->y, e->x[0], e->x[1], e->prec))
CNS_EXACT(scale, (mpq_mul(y, x[0], x[1]), true))
CNS_FOLDED_OPERATION(scale, 2, scale_recurrence, cns_known_as_second, cns_vanishes_with_either, scale_zeros,
                     2, .exact = scale_exact);
