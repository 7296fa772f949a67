/* One recurrence per operation, written once for every arithmetic.
 *
 * Notation: w_n is coefficient n of the result in scaled time; val[a] is the number of leading zeros of a
 * (0 in the regular case), so sums start and end where their terms can differ from zero.
 * Sources: Jorba and Zou, Exp. Math. 14 (2005) 99, proposition 2.1; Neidinger, SIAM Review 52 (2010) 545. */
#include "taylor/jet_internal.h"

static bool is_zero(const cns_jet *J, int v, int n)
{
    long e;
    return J->ops->get_2exp(J->A, &e, J->series[v], n) == 0;
}

static cns_code singular(const cns_jet *J, int v, const char *what, cns_error *err)
{
    return cns_fail(err, CNS_NUMERIC, "%s (operation %%%d, %s)", what, v, cns_op_name[J->p->node[v].op]);
}

static void product(cns_jet *J, int sign, int a, int b, int n, int lo, int hi)
{
    if (hi >= lo && !J->vanishes[a] && !J->vanishes[b])
        J->ops->conv(J->A, sign, J->series[a], J->series[b], n, lo, hi);
}

/* Adds the sum or product that node v stands for. */
static void accumulate_operation(cns_jet *J, int sign, int v, int n)
{
    const cns_tape_node *N = &J->p->node[v];
    int a = N->arg[0], b = N->arg[1];
    switch (N->op) {
    case CNS_OP_ADD:
        cns_accumulate(J, sign, a, n);
        cns_accumulate(J, sign, b, n);
        break;
    case CNS_OP_SUB:
        cns_accumulate(J, sign, a, n);
        cns_accumulate(J, -sign, b, n);
        break;
    case CNS_OP_NEG:
        cns_accumulate(J, -sign, a, n);
        break;
    case CNS_OP_MUL:
        product(J, sign, a, b, n, J->val[a], n - J->val[b]);
        break;
    case CNS_OP_SQR:
        if (!J->vanishes[a] && n >= 2 * J->val[a])
            J->ops->square(J->A, sign, J->series[a], n, J->val[a]);
        break;
    case CNS_OP_SCALE:
        if (!J->vanishes[b])
            J->ops->scaled(J->A, sign, J->series[a], J->series[b], n);
        break;
    case CNS_OP_SIGNED: {
        int held = J->sign[a] ? J->sign[a] : J->held[a];
        if (!J->vanishes[b] && held)
            J->ops->coef(J->A, sign * held, J->series[b], n);
        else if (!J->vanishes[b] && !is_zero(J, b, n))
            J->sign_late = true;
        break;
    }
    default:
        break; /* nothing else is folded */
    }
}

void cns_accumulate(cns_jet *J, int sign, int v, int n)
{
    if (J->vanishes[v] || (J->p->node[v].constant && n > 0))
        return;
    if (J->series[v] >= 0)
        J->ops->coef(J->A, sign, J->series[v], n);
    else
        accumulate_operation(J, sign, v, n);
}

/* w = +-a +-b, a b, a^2, sign * b: w_n is the sum itself. */
static cns_code sum(cns_jet *J, int v, int n, cns_error *err)
{
    (void)err;
    J->ops->zero(J->A);
    accumulate_operation(J, 1, v, n);
    J->ops->store(J->A, J->series[v], n);
    return CNS_OK;
}

/* w = c a with c constant, a possibly a folded sum. */
static cns_code scale(cns_jet *J, int v, int n, cns_error *err)
{
    (void)err;
    const cns_tape_node *N = &J->p->node[v];
    J->ops->zero(J->A);
    cns_accumulate(J, 1, N->arg[1], n);
    J->ops->store_scaled(J->A, J->series[v], n, J->series[N->arg[0]]);
    return CNS_OK;
}

/* w = a/b, b = b_m t^m + ...:  w_n = (a_{n+m} - sum_{j=1..n} b_{m+j} w_{n-j}) / b_m. */
static cns_code quotient(cns_jet *J, int v, int n, cns_error *err)
{
    int a = J->p->node[v].arg[0], b = J->p->node[v].arg[1], m = J->val[b];
    if ((n == 0 || J->singular) && is_zero(J, b, m))
        return singular(J, v, "division by zero", err);
    J->ops->zero(J->A);
    cns_accumulate(J, 1, a, n + m);
    if (!J->p->node[b].constant)
        product(J, -1, b, v, n + m, m + 1, n + m - J->val[v]);
    J->ops->store_over(J->A, J->series[v], n, J->series[b], m, 0);
    return CNS_OK;
}

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

/* w = sqrt(q), q = q_{2m} t^{2m} + ... */
static cns_code square_root(cns_jet *J, int v, int n, cns_error *err)
{
    int q = J->p->node[v].arg[0], m = J->val[q] / 2;
    long e;
    if (J->val[q] % 2)
        return singular(J, v, "root of a quantity that changes sign", err);
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
    double lead = J->ops->get_2exp(J->A, &e, J->series[q], 2 * m);
    if (lead < 0)
        return singular(J, v, "root of a negative number", err);
    if (lead == 0 && !J->p->node[v].constant)
        return singular(J, v, "root of zero", err);
    if (m == 0) {
        J->ops->function(J->A, CNS_FN_SQRT, J->series[v], -1, J->series[q], -1);
    } else {
        J->ops->get(J->A, J->x, J->series[q], 2 * m);
        mpfr_sqrt(J->y, J->x, MPFR_RNDN);
        J->ops->set(J->A, J->series[v], m, J->y, false);
    }
    return CNS_OK;
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
static void held_sign(cns_jet *J, int v, int u, int n)
{
    long e;
    if (!J->sign[v] && significant(J, u, n))
        J->sign[v] = J->ops->get_2exp(J->A, &e, J->series[u], n) < 0 ? -1 : 1;
    J->ops->zero(J->A);
    if (J->sign[v])
        J->ops->coef(J->A, J->sign[v], J->series[u], n);
    J->ops->store(J->A, J->series[v], n);
}

/* w = sqrt(u^2 + eps^2), or |u| where the two cannot be told apart (see jet.h): eps where u vanishes
 * identically. */
static cns_code smooth_absolute(cns_jet *J, int v, int n, cns_error *err)
{
    const int *arg = J->p->node[v].arg;
    if (!J->sharp)
        return square_root(J, v, n, err);
    if (!J->vanishes[arg[1]]) {
        held_sign(J, v, arg[1], n);
        return CNS_OK;
    }
    J->ops->zero(J->A);
    cns_accumulate(J, 1, arg[2], n);
    J->ops->store(J->A, J->series[v], n);
    return CNS_OK;
}

static cns_code absolute(cns_jet *J, int v, int n, cns_error *err)
{
    (void)err;
    held_sign(J, v, J->p->node[v].arg[0], n);
    return CNS_OK;
}

/* w = sqrt(a^2 + b^2); on an invariant line, where a or b vanishes identically, |the other|. */
static cns_code hypotenuse(cns_jet *J, int v, int n, cns_error *err)
{
    const int *arg = J->p->node[v].arg;
    int a = arg[0], b = arg[1];
    if (J->vanishes[a] || J->vanishes[b]) {
        held_sign(J, v, J->vanishes[a] ? b : a, n);
        return CNS_OK;
    }
    int m = J->val[a] < J->val[b] ? J->val[a] : J->val[b];
    if (n < m) {
        store_zero(J, v, n);
    } else if (n == 0) {
        J->ops->function(J->A, CNS_FN_HYPOT, J->series[v], -1, J->series[a], J->series[b]);
        if (is_zero(J, v, 0) && !J->p->node[v].constant)
            return singular(J, v, "root of zero", err);
    } else if (n == m) {
        J->ops->get(J->A, J->x, J->series[a], m);
        J->ops->get(J->A, J->y, J->series[b], m);
        mpfr_hypot(J->z, J->x, J->y, MPFR_RNDN);
        if (mpfr_zero_p(J->z))
            return singular(J, v, "root of zero", err);
        J->ops->set(J->A, J->series[v], m, J->z, false);
    } else {
        J->ops->zero(J->A);
        cns_accumulate(J, 1, arg[2], n + m);
        cns_accumulate(J, 1, arg[3], n + m);
        root_store(J, v, n, m);
    }
    return CNS_OK;
}

/* w = t da/dt:  w_n = n a_n. */
static cns_code euler(cns_jet *J, int v, int n, cns_error *err)
{
    (void)err;
    J->ops->zero(J->A);
    if (n > 0)
        J->ops->coef(J->A, n, J->series[J->p->node[v].arg[0]], n);
    J->ops->store(J->A, J->series[v], n);
    return CNS_OK;
}

/* sum_{j=1..n} du_j b_{n-j} into the accumulator, du the Euler derivative. */
static void euler_product(cns_jet *J, int sign, int du, int b, int n, int hi)
{
    product(J, sign, du, b, n, J->val[du] > 1 ? J->val[du] : 1, hi);
}

/* s = sin u:  n s_n = sum_{j=1..n} j u_j c_{n-j}. */
static cns_code sine(cns_jet *J, int v, int n, cns_error *err)
{
    (void)err;
    const int *arg = J->p->node[v].arg;
    if (n == 0) {
        J->ops->function(J->A, CNS_FN_SINCOS, J->series[v], J->series[v + 1], J->series[arg[0]], -1);
        return CNS_OK;
    }
    J->ops->zero(J->A);
    euler_product(J, 1, arg[1], v + 1, n, n - J->val[v + 1]);
    J->ops->store_ratio(J->A, J->series[v], n, 1, n);
    return CNS_OK;
}

/* c = cos u:  n c_n = -sum_{j=1..n} j u_j s_{n-j}; c_0 came with s_0, unless u vanishes identically. */
static cns_code cosine(cns_jet *J, int v, int n, cns_error *err)
{
    (void)err;
    const int *arg = J->p->node[v].arg;
    if (n == 0) {
        if (J->vanishes[arg[0]]) {
            mpfr_set_ui(J->x, 1, MPFR_RNDN);
            J->ops->set(J->A, J->series[v], 0, J->x, false);
        }
        return CNS_OK;
    }
    J->ops->zero(J->A);
    euler_product(J, -1, arg[1], arg[2], n, n - J->val[arg[2]]);
    J->ops->store_ratio(J->A, J->series[v], n, 1, n);
    return CNS_OK;
}

/* w = exp u:  n w_n = sum_{j=1..n} j u_j w_{n-j}. */
static cns_code exponential(cns_jet *J, int v, int n, cns_error *err)
{
    (void)err;
    const int *arg = J->p->node[v].arg;
    if (n == 0) {
        J->ops->function(J->A, CNS_FN_EXP, J->series[v], -1, J->series[arg[0]], -1);
        return CNS_OK;
    }
    J->ops->zero(J->A);
    euler_product(J, 1, arg[1], v, n, n - J->val[v]);
    J->ops->store_ratio(J->A, J->series[v], n, 1, n);
    return CNS_OK;
}

/* w_n = acc / (n u_0). */
static void store_over_order(cns_jet *J, int v, int n, int u)
{
    J->ops->store_over(J->A, J->series[v], n, J->series[u], 0, 0);
    J->ops->zero(J->A);
    J->ops->coef(J->A, 1, J->series[v], n);
    J->ops->store_ratio(J->A, J->series[v], n, 1, n);
}

/* w = log u:  n u_0 w_n = n u_n - sum_{j=1..n-1} j w_j u_{n-j}. */
static cns_code logarithm(cns_jet *J, int v, int n, cns_error *err)
{
    const int *arg = J->p->node[v].arg;
    long e;
    if (n == 0) {
        if (J->ops->get_2exp(J->A, &e, J->series[arg[0]], 0) <= 0)
            return singular(J, v, "logarithm of a number that is not positive", err);
        J->ops->function(J->A, CNS_FN_LOG, J->series[v], -1, J->series[arg[0]], -1);
        return CNS_OK;
    }
    J->ops->zero(J->A);
    cns_accumulate(J, 1, arg[1], n);
    euler_product(J, -1, v + 1, arg[0], n, n - 1);
    store_over_order(J, v, n, arg[0]);
    return CNS_OK;
}

/* w = u^p:  n u_0 w_n = p sum_{j=1..n} j u_j w_{n-j} - sum_{j=1..n-1} j w_j u_{n-j}. */
static cns_code power(cns_jet *J, int v, int n, cns_error *err)
{
    const int *arg = J->p->node[v].arg;
    long e;
    if (n == 0) {
        if (J->ops->get_2exp(J->A, &e, J->series[arg[0]], 0) <= 0)
            return singular(J, v, "real power of a number that is not positive", err);
        J->ops->function(J->A, CNS_FN_POW, J->series[v], -1, J->series[arg[0]], J->series[arg[1]]);
        return CNS_OK;
    }
    J->ops->zero(J->A);
    euler_product(J, 1, arg[2], v, n, n);
    euler_product(J, -1, v + 1, arg[0], n, n - 1);
    store_over_order(J, v, n, arg[0]);
    return CNS_OK;
}

const cns_recurrence cns_op_recurrence[CNS_OP_COUNT] = {
#define OP(name, text, operands, recurrence) recurrence,
#include "operations.def"
#undef OP
};
