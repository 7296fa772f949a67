/* Square roots and absolute values, which are roots of squares. Where their radicand vanishes the solution is
 * not analytic: they are what a step has to watch. */
#include "rules.h"

/* w_n = (q_{n+m} - sum_{j=m+1..n-1} w_j w_{n+m-j}) / (2 w_m), the sum q being in the accumulator. */
static void root_store(cns_jet *J, int v, int n, int m)
{
    if (n + m >= 2 * (m + 1))
        J->ops->square(J->A, -1, J->series[v], n + m, m + 1);
    J->ops->store_over(J->A, J->series[v], n, J->series[v], m, 1);
}

static void store_zero(cns_jet *J, int v, int n)
{
    J->ops->zero(J->A);
    J->ops->store(J->A, J->series[v], n);
}

/* Is coefficient n of u more than the rounding noise of a quantity made from the states? */
static bool significant(const cns_jet *J, int u, int n)
{
    long e, e_state;
    if (J->ops->get_2exp(J->A, &e, J->series[u], n) == 0 || (n == 0 && J->at_zero[u]))
        return false;
    if (n == 0)
        return true;
    const long slack = 10; /* bits lost in the few operations between the states and u */
    for (int i = 0; i < J->p->n_states; i++)
        if (J->ops->get_2exp(J->A, &e_state, J->state_series[i], n) != 0 &&
            e < e_state - (long)J->spec.prec + slack)
            return false;
    return true;
}

/* w = |u| on an arc: sign * u, the sign being that of u's first significant coefficient. */
static void store_held_sign(cns_jet *J, int v, int u, int n)
{
    long e;
    if (!J->sign[v] && significant(J, u, n))
        J->sign[v] = J->ops->get_2exp(J->A, &e, J->series[u], n) < 0 ? -1 : 1;
    J->ops->zero(J->A);
    if (J->sign[v])
        J->ops->coef(J->A, J->sign[v], J->series[u], n);
    J->ops->store(J->A, J->series[v], n);
}

static cns_watched watch_root(const cns_jet *J, int v)
{
    (void)J;
    return (cns_watched){.node = v, .kind = CNS_WATCH_ROOT};
}

static cns_watched watch_kink(int u)
{
    return (cns_watched){.node = u, .kind = CNS_WATCH_KINK};
}

/* W^2 - w^2 = Q - q + (q - w^2), and W + w >= w >= m > 0: |W - w| <= (|q - w^2| + |Q - q|) / m. q is the sum
 * of the operands qa and qb (-1: there is no second). */
static bool root_remainder(cns_defect *d, int v, int qa, int qb)
{
    mag_t x, m;
    mag_init(x);
    mag_init(m);
    bool is = d->row[v] >= 0 && cns_defect_lowest(m, d, v);
    if (is) {
        mag_mul(x, d->size + v, d->size + v);
        mag_add(x, x, d->size + qa);
        if (qb >= 0)
            mag_add(x, x, d->size + qb);
        cns_remainder_begin(d, v, x, x);
        mag_addmul(d->e0 + v, d->unit, x); /* the reciprocal's */
        cns_defect_products(d->e1 + v, d, v, v);
        for (int k = 0; k < (qb >= 0 ? 2 : 1); k++) {
            const int q = k == 0 ? qa : qb;
            cns_defect_leading(x, d, q);
            mag_add(d->e0 + v, d->e0 + v, d->e0 + q);
            mag_add(d->e1 + v, d->e1 + v, d->e1 + q);
            mag_add(d->e1 + v, d->e1 + v, x);
        }
        mag_div(d->e0 + v, d->e0 + v, m);
        mag_div(d->e1 + v, d->e1 + v, m);
        /* Then Q >= (m - e)^2 > 0, and w is the root that is positive. */
        mag_add(x, d->e0 + v, d->e1 + v);
        is = mag_cmp(x, m) < 0 && d->c[(size_t)d->row[v] * ((size_t)d->most + 2)] > 0;
    }
    mag_clear(x);
    mag_clear(m);
    return is;
}

/* |U| - sigma u, sigma u >= -overshoot, |U - u| <= e: at most 3 e + 2 overshoot. Coefficients of w are zero
 * as long as no coefficient of u had decided sigma. */
static bool held_sign_remainder(cns_defect *d, int v, int u)
{
    const cns_jet *J = d->J;
    mag_t x;
    mag_init_set(x, d->size + u);
    cns_remainder_begin(d, v, x, d->norm + u);
    if (J->sign[v] != 0) {
        mag_mul_2exp_si(x, d->overshoot, 1);
        mag_add(d->e0 + v, d->e0 + v, x);
        for (int k = 0; k < d->N && cns_is_zero(J, J->series[v], k); k++) {
            cns_defect_from(x, d, u, k);
            if (!cns_is_zero(J, J->series[u], k))
                mag_add(d->e0 + v, d->e0 + v, x);
            if (k > CNS_LOOKAHEAD)
                break;
        }
    } else { /* w = 0 */
        mag_add(d->e0 + v, d->e0 + v, d->norm + u);
    }
    mag_mul_ui(x, d->e0 + u, 3);
    mag_add(d->e0 + v, d->e0 + v, x);
    mag_mul_ui(x, d->e1 + u, 3);
    mag_add(d->e1 + v, d->e1 + v, x);
    cns_defect_leading(x, d, u);
    mag_add(d->e1 + v, d->e1 + v, x);
    mag_clear(x);
    return true;
}

/* sqrt: w = sqrt(q), q = q_{2m} t^{2m} + ... */

static cns_code sqrt_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    const int q = J->p->node[v].arg[0], m = J->val[q] / 2;
    long e;
    if (J->val[q] % 2)
        return cns_singular(J, v, "root of a quantity that changes sign", err);
    if (n < m) {
        store_zero(J, v, n);
        return CNS_OK;
    }
    if (n > m) {
        J->ops->zero(J->A);
        cns_accumulate(J, 1, q, n + m);
        root_store(J, v, n, m);
        return CNS_OK;
    }
    const double lead = J->ops->get_2exp(J->A, &e, J->series[q], 2 * m);
    if (lead < 0)
        return cns_singular(J, v, "root of a negative number", err);
    if (lead == 0 && !J->p->node[v].constant)
        return cns_singular(J, v, "root of zero", err);
    if (m == 0) {
        J->ops->function(J->A, CNS_FN_SQRT, J->series[v], -1, J->series[q], -1);
    } else {
        J->ops->get(J->A, J->x, J->series[q], 2 * m);
        mpfr_sqrt(J->y, J->x, MPFR_RNDN);
        J->ops->set(J->A, J->series[v], m, J->y, false);
    }
    return CNS_OK;
}

static int sqrt_known(const cns_jet *J, int v)
{
    const int q = J->p->node[v].arg[0];
    return J->known[q] > J->val[q] ? J->known[q] - J->val[q] / 2 : 0;
}

static bool sqrt_remainder(cns_defect *d, int v)
{
    return root_remainder(d, v, d->p->node[v].arg[0], -1);
}

CNS_DERIVE(sqrt, d->dx[0] < 0 ? -1 : cns_div(d->q, cns_mul(d->q, cns_constant(d->q, "1/2"), d->dx[0]), d->w))
CNS_ENCLOSE(sqrt, arb_sqrt(e->y, e->x[0], e->prec))
CNS_OPERATION(sqrt, 1, sqrt_known, cns_vanishes_with_first, watch_root);

/* hypot: w = sqrt(a^2 + b^2); operands a, b, a^2, b^2, the squares being nodes that others may share. On an
 * invariant line, where a or b vanishes identically, it is |the other|. */

/* The other, or -1 where neither vanishes. */
static int on_line(const cns_jet *J, int v)
{
    const int *arg = J->p->node[v].arg;
    return J->vanishes[arg[0]] ? arg[1] : J->vanishes[arg[1]] ? arg[0] : -1;
}

static cns_code hypot_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    const int *arg = J->p->node[v].arg, a = arg[0], b = arg[1], line = on_line(J, v);
    if (line >= 0) {
        store_held_sign(J, v, line, n);
        return CNS_OK;
    }
    const int m = cns_least(J->val[a], J->val[b]);
    if (n < m) {
        store_zero(J, v, n);
    } else if (n == 0) {
        J->ops->function(J->A, CNS_FN_HYPOT, J->series[v], -1, J->series[a], J->series[b]);
        if (cns_is_zero(J, J->series[v], 0) && !J->p->node[v].constant)
            return cns_singular(J, v, "root of zero", err);
    } else if (n == m) {
        J->ops->get(J->A, J->x, J->series[a], m);
        J->ops->get(J->A, J->y, J->series[b], m);
        mpfr_hypot(J->z, J->x, J->y, MPFR_RNDN);
        if (mpfr_zero_p(J->z))
            return cns_singular(J, v, "root of zero", err);
        J->ops->set(J->A, J->series[v], m, J->z, false);
    } else {
        J->ops->zero(J->A);
        cns_accumulate(J, 1, arg[2], n + m);
        cns_accumulate(J, 1, arg[3], n + m);
        root_store(J, v, n, m);
    }
    return CNS_OK;
}

static int hypot_known(const cns_jet *J, int v)
{
    const int *arg = J->p->node[v].arg, a = arg[0], b = arg[1], line = on_line(J, v);
    if (line >= 0)
        return J->known[line];
    const int m = cns_least(J->val[a], J->val[b]);
    return J->known[a] > m && J->known[b] > m ? cns_least(J->known[arg[2]], J->known[arg[3]]) - m : 0;
}

static cns_watched hypot_watch(const cns_jet *J, int v)
{
    const int line = on_line(J, v);
    return line >= 0 ? watch_kink(line) : watch_root(J, v);
}

static bool hypot_remainder(cns_defect *d, int v)
{
    const int *arg = d->p->node[v].arg, line = on_line(d->J, v);
    if (line < 0)
        return root_remainder(d, v, arg[2], arg[3]);
    const int other = line == arg[0] ? arg[1] : arg[0]; /* |sqrt(A^2 + B^2) - |B|| <= |A| */
    if (!held_sign_remainder(d, v, line))
        return false;
    mag_add(d->e0 + v, d->e0 + v, d->e0 + other);
    mag_add(d->e1 + v, d->e1 + v, d->e1 + other);
    return true;
}

CNS_DERIVE(hypot,
           cns_over(d, cns_plus(d, cns_times(d, d->x[0], d->dx[0]), cns_times(d, d->x[1], d->dx[1])), d->w))
CNS_ENCLOSE(hypot, arb_hypot(e->y, e->x[0], e->x[1], e->prec))
CNS_OPERATION(hypot, 4, hypot_known, cns_vanishes_with_both, hypot_watch, .adds = 1 << 2 | 1 << 3);

/* abs: w = |u|. */

static cns_code abs_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    (void)err;
    store_held_sign(J, v, J->p->node[v].arg[0], n);
    return CNS_OK;
}

static cns_watched abs_watch(const cns_jet *J, int v)
{
    return watch_kink(J->p->node[v].arg[0]);
}

static bool abs_remainder(cns_defect *d, int v)
{
    return held_sign_remainder(d, v, d->p->node[v].arg[0]);
}

CNS_DERIVE(abs, d->dx[0] < 0 ? -1 : cns_signed(d->q, d->w, d->dx[0]))
CNS_ENCLOSE(abs, arb_abs(e->y, e->x[0]))
CNS_OPERATION(abs, 1, cns_known_as_first, cns_vanishes_with_first, abs_watch);

/* smooth_abs: w = sqrt(u^2 + eps^2), or |u| where the two cannot be told apart (jet.h): eps where u vanishes
 * identically. Operands u^2 + eps^2, u, eps. */

static cns_code smooth_abs_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    const int *arg = J->p->node[v].arg;
    if (!J->sharp)
        return sqrt_recurrence(J, v, n, err);
    if (!J->vanishes[arg[1]]) {
        store_held_sign(J, v, arg[1], n);
        return CNS_OK;
    }
    J->ops->zero(J->A);
    cns_accumulate(J, 1, arg[2], n);
    J->ops->store(J->A, J->series[v], n);
    return CNS_OK;
}

static int smooth_abs_known(const cns_jet *J, int v)
{
    return J->sharp ? cns_known_as_second(J, v) : sqrt_known(J, v);
}

static cns_watched smooth_abs_watch(const cns_jet *J, int v)
{
    const int *arg = J->p->node[v].arg;
    return J->sharp ? watch_kink(arg[1])
                    : (cns_watched){.node = arg[1], .kind = CNS_WATCH_SMOOTH, .eps = arg[2]};
}

/* Where it is expanded as |u| it is not bounded: the two differ by eps, which counts twice as many digits as
 * what it does to a solution. */
static bool smooth_abs_remainder(cns_defect *d, int v)
{
    return !d->J->sharp && root_remainder(d, v, d->p->node[v].arg[0], -1);
}

CNS_DERIVE(smooth_abs, d->dx[1] < 0 ? -1 : cns_mul(d->q, cns_smooth_sign(d->q, d->w), d->dx[1]))
CNS_ENCLOSE(smooth_abs, sqrt_enclose(e))
CNS_OPERATION(smooth_abs, 3, smooth_abs_known, cns_never_vanishes, smooth_abs_watch);

/* smooth_sign: s = u/w of w = sqrt(u^2 + eps^2), or the sign that w holds where it is |u|: there the quotient
 * would be one of rounding noise beside a zero of u. Operands w, u. */

static cns_code smooth_sign_recurrence(cns_jet *J, int v, int n, cns_error *err)
{
    const int w = J->p->node[v].arg[0], u = J->p->node[v].arg[1];
    if (!J->sharp) {
        J->ops->zero(J->A);
        cns_accumulate(J, 1, u, n);
        cns_add_product(J, -1, w, v, n, 1, n);
        J->ops->store_over(J->A, J->series[v], n, J->series[w], 0, 0);
        return CNS_OK;
    }
    (void)err;
    const int held = J->sign[w] ? J->sign[w] : J->held[w];
    J->sign_late = J->sign_late || !held;
    if (n > 0) {
        store_zero(J, v, n);
    } else {
        mpfr_set_si(J->x, held, MPFR_RNDN);
        J->ops->set(J->A, J->series[v], 0, J->x, false);
    }
    return CNS_OK;
}

/* As a quotient u/w. */
static bool smooth_sign_remainder(cns_defect *d, int v)
{
    return !d->J->sharp && cns_quotient_remainder(d, v, d->p->node[v].arg[1], d->p->node[v].arg[0]);
}

CNS_DERIVE(smooth_sign,
           cns_over(d, cns_plus(d, d->dx[1], cns_minus(d, cns_times(d, d->w, d->dx[0]))), d->x[0]))
CNS_ENCLOSE(smooth_sign, arb_div(e->y, e->x[1], e->x[0], e->prec))
CNS_OPERATION(smooth_sign, 2, cns_known_as_both, cns_vanishes_with_second, NULL);

/* signed: the sign that an abs() holds, times a. Operands: the abs() node, a. */

static void signed_accumulate(cns_jet *J, int sign, int v, int n)
{
    const int w = J->p->node[v].arg[0], a = J->p->node[v].arg[1];
    const int held = J->sign[w] ? J->sign[w] : J->held[w];
    if (!J->vanishes[a] && held)
        J->ops->coef(J->A, sign * held, J->series[a], n);
    else if (!J->vanishes[a] && !cns_is_zero(J, J->series[a], n))
        J->sign_late = true;
}

static int signed_zeros(const cns_jet *J, int v)
{
    return J->val[J->p->node[v].arg[1]];
}

/* sign(U) A - sigma a = sigma (A - a) + (sign(U) - sigma) A: the two signs differ only where |U| <= z, which
 * is overshoot and U's remainder; and there A, which has U as a factor, is small. So |u| u and its tangents
 * need no zero of u to be located. */
static bool signed_remainder(cns_defect *d, int v)
{
    const int w = d->p->node[v].arg[0], a = d->p->node[v].arg[1], u = d->p->node[w].arg[0];
    const int held = d->J->sign[w] ? d->J->sign[w] : d->J->held[w];
    mag_t x, z;
    mag_init_set(x, d->size + a);
    mag_init(z);
    cns_remainder_begin(d, v, x, d->norm + a);
    if (held != 0) {
        mag_add(z, d->overshoot, d->e0 + u);
        mag_add(z, z, d->e1 + u);
        cns_defect_where_small(x, d, a, u, z);
        mag_mul_2exp_si(x, x, 1);
        mag_add(d->e0 + v, d->e0 + v, x);
    } else { /* w = 0 */
        mag_add(d->e0 + v, d->e0 + v, d->norm + a);
    }
    mag_add(d->e0 + v, d->e0 + v, d->e0 + a);
    cns_defect_leading(x, d, a);
    mag_add(d->e1 + v, d->e1 + a, x);
    mag_clear(x);
    mag_clear(z);
    return true;
}

CNS_DERIVE(signed, d->dx[1] < 0 ? -1 : cns_signed(d->q, d->x[0], d->dx[1]))

/* Where u may have either sign, |u| has a tangent anywhere between. */
static void signed_enclose(const cns_enclosure *e)
{
    arb_srcptr u = e->value + e->p->node[e->node->arg[0]].arg[0], a = e->x[1];
    if (arb_is_positive(u)) {
        arb_set(e->y, a);
    } else if (arb_is_negative(u)) {
        arb_neg(e->y, a);
    } else {
        arb_zero(e->y);
        mag_one(arb_radref(e->y));
        arb_mul(e->y, e->y, a, e->prec);
    }
}

CNS_FOLDED_OPERATION(signed, 2, cns_sum_recurrence, cns_known_as_second, cns_vanishes_with_either,
                     signed_zeros, 0);
