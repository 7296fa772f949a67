#include "defect.h"

#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "defect_internal.h"
#include "num/logs.h"
#include "op/rules.h"

/* Beside sums, 1e-300 of the largest coefficient stands for what is too small for a double. */
#define TINY 1e-300

enum {
    CONSTANT_BITS = 64, /* more than the jet's, for the exact values of constants */
    TERMS = 48,         /* of a series, when its values are wanted to double precision */
    PIECES = 200,       /* of a step, when a sign is looked at */
    LEADING = 4,        /* coefficients that tell the mean fall */
    FACTORS = 6         /* of factors of factors, in a product that is looked through */
};

static double *c_of(const cns_defect *d, int row)
{
    return d->c + (size_t)row * ((size_t)d->most + 2);
}

static double *S_of(const cns_defect *d, int row)
{
    return d->S + (size_t)row * ((size_t)d->most + 2);
}

/* 2^e, or 0 below the range of a double. */
static inline double two_to(long e)
{
    const union {
        uint64_t bits;
        double value;
    } x = {.bits = e < -1022 ? 0 : (uint64_t)((e > 1023 ? 1024 : e) + 1023) << 52};
    return x.value;
}

/* y = a bound of m 2^e, m >= 0. */
static void set_2exp(mag_t y, double m, long e)
{
    mag_set_d(y, m);
    mag_mul_2exp_si(y, y, e);
}

/* The exact values of constants, and what the jet has for them. */
static void set_constants(cns_defect *d)
{
    const cns_program *p = d->p;
    const slong prec = d->J->spec.prec + CONSTANT_BITS;
    for (int v = 0; v < p->n_nodes; v++) {
        const cns_program_node *n = &p->node[v];
        if (!n->constant)
            continue;
        cns_enclosure e = {.p = p, .node = n, .y = d->constant + v, .value = d->constant, .prec = prec};
        for (int k = 0; k < 4; k++)
            e.x[k] = n->arg[k] < 0 ? NULL : d->constant + n->arg[k];
        cns_operations[n->op]->enclose(&e);
    }
}

cns_defect *cns_defect_new(const cns_jet *J, cns_error *err)
{
    cns_defect *d = calloc(1, sizeof *d);
    const cns_program *p = J->p;
    if (d == NULL) {
        cns_out_of_memory(err);
        return NULL;
    }
    d->J = J;
    d->p = p;
    d->most = J->spec.order;
    mag_init(d->unit);
    mag_init(d->least);
    mag_init(d->overshoot);
    const size_t n = (size_t)p->n_nodes + 1, line = (size_t)d->most + 2;
    d->row = malloc(n * sizeof *d->row);
    d->rows = p->n_states;
    for (int v = 0; v < p->n_nodes && d->row != NULL; v++) {
        const cns_program_node *node = &p->node[v];
        d->row[v] = node->op == CNS_OP_STATE                                           ? node->index
                    : !node->constant && J->series[v] >= 0 && node->op != CNS_OP_EULER ? d->rows++
                                                                                       : -1;
    }
    const size_t rows = (size_t)d->rows + 1;
    d->fall = calloc(line, sizeof *d->fall);
    d->split = calloc(line, sizeof *d->split);
    d->plain = calloc(line, sizeof *d->plain);
    d->down = calloc(line, sizeof *d->down);
    d->flat = calloc(line, sizeof *d->flat);
    d->m = calloc(line, sizeof *d->m);
    d->e = calloc(line, sizeof *d->e);
    d->power = calloc(line, sizeof *d->power);
    d->power_e = calloc(line, sizeof *d->power_e);
    d->x = calloc(rows, sizeof *d->x);
    d->c = calloc(rows * line, sizeof *d->c);
    d->S = calloc(rows * line, sizeof *d->S);
    d->norm = _mag_vec_init((slong)(4 * n));
    d->constant = _arb_vec_init((slong)n);
    if (!d->row || !d->fall || !d->split || !d->plain || !d->down || !d->flat || !d->m || !d->e ||
        !d->power || !d->power_e || !d->x || !d->c || !d->S) {
        cns_out_of_memory(err);
        cns_defect_free(d);
        return NULL;
    }
    d->size = d->norm + n;
    d->e0 = d->norm + 2 * n;
    d->e1 = d->norm + 3 * n;
    set_constants(d);
    return d;
}

void cns_defect_free(cns_defect *d)
{
    if (d == NULL)
        return;
    const slong n = d->p->n_nodes + 1;
    if (d->norm != NULL)
        _mag_vec_clear(d->norm, 4 * n);
    if (d->constant != NULL)
        _arb_vec_clear(d->constant, n);
    mag_clear(d->unit);
    mag_clear(d->least);
    mag_clear(d->overshoot);
    free(d->row);
    free(d->fall);
    free(d->split);
    free(d->plain);
    free(d->down);
    free(d->flat);
    free(d->m);
    free(d->e);
    free(d->power);
    free(d->power_e);
    free(d->x);
    free(d->c);
    free(d->S);
    free(d);
}

/* Bits by which coefficients fall from order to order, in the mean: by the largest state's. */
static void choose_fall(cns_defect *d)
{
    const cns_jet *J = d->J;
    double first = -HUGE_VAL, last = -HUGE_VAL;
    const int N = d->N, some = N < 2 * LEADING ? 1 : LEADING;
    for (int i = 0; i < d->p->n_states; i++)
        for (int k = 0; k < some && !J->state_vanishes[i]; k++) {
            long e;
            double m = J->ops->get_2exp(J->A, &e, J->state_series[i], k);
            if (m != 0)
                first = fmax(first, (double)e);
            m = J->ops->get_2exp(J->A, &e, J->state_series[i], N - k);
            if (m != 0)
                last = fmax(last, (double)e);
        }
    int e;
    const double m = frexp(d->stretch, &e);
    double fall = isfinite(first) && isfinite(last) ? (first - last) / N : 0;
    fall = fmax(-1000, fmin(fall - e - 2 * (m - 1), 1000));
    for (int k = 0; k <= N + 1; k++)
        d->fall[k] = (long)floor(k * fall);
    for (int i = 0; i <= N; i++) {
        d->split[i] = two_to(d->fall[N] - d->fall[i] - d->fall[N - i]);
        d->down[i] = two_to(d->fall[i] - d->fall[i + 1]);
        d->flat[i] = two_to(-d->fall[i]);
    }
}

/* The powers of the factor by which time is stretched, rounded: coefficient k times them has a relative error
 * below (3 k + 4) 2^-53. */
static void set_powers(cns_defect *d)
{
    double m = 1;
    long e = 0;
    for (int k = 0; k <= d->N; k++) {
        int more;
        d->power[k] = m;
        d->power_e[k] = e;
        m = frexp(m * d->stretch, &more);
        e += more;
    }
}

/* Reads a series of n coefficients into a row; the others are zero. */
static void read_row(cns_defect *d, int row, int series, int n)
{
    const cns_jet *J = d->J;
    double *c = c_of(d, row), *S = S_of(d, row), *m = d->m;
    long *e = d->e, x = LONG_MIN;
    const int N = d->N;
    if (series < 0)
        n = 0;
    else
        J->ops->leading(J->A, m, e, series, n);
    for (int k = 0; k < n; k++) {
        e[k] += d->power_e[k] + d->fall[k];
        if (m[k] != 0 && e[k] > x)
            x = e[k];
    }
    d->x[row] = x == LONG_MIN ? 0 : x;
    for (int k = 0; k < n; k++) {
        c[k] = m[k] == 0 ? 0 : m[k] * d->power[k] * two_to(e[k] - x);
        if (m[k] != 0 && fabs(c[k]) < TINY)
            c[k] = copysign(TINY, m[k]);
    }
    for (int k = n; k <= N + 1; k++)
        c[k] = 0;
    S[N + 1] = 0;
    for (int k = N; k >= 0; k--)
        S[k] = fabs(c[k]) + S[k + 1] * d->down[k] + TINY;
}

/* How far what the jet has for each constant is from its exact value. */
static void read_constants(cns_defect *d)
{
    const cns_jet *J = d->J;
    const cns_arith_ops *ops = J->ops;
    mpfr_t x;
    arb_t stored;
    mpfr_init2(x, J->spec.prec + 2 * CONSTANT_BITS);
    arb_init(stored);
    for (int v = 0; v < d->p->n_nodes; v++) {
        if (!d->p->node[v].constant)
            continue;
        ops->get(J->A, x, J->series[v], 0);
        arb_set_interval_mpfr(stored, x, x, mpfr_get_prec(x));
        arb_get_mag(d->norm + v, stored);
        mag_set(d->size + v, d->norm + v);
        if (ops->size_log2)
            mag_set_ui_2exp_si(d->size + v, 1, ops->size_log2(J->A, J->series[v]));
        arb_sub(stored, stored, d->constant + v, mpfr_get_prec(x));
        arb_get_mag(d->e0 + v, stored);
        mag_addmul(d->e0 + v, d->unit, d->size + v);
    }
    mpfr_clear(x);
    arb_clear(stored);
}

cns_code cns_defect_read(cns_defect *d, double H, double length, cns_error *err)
{
    const cns_jet *J = d->J;
    const cns_program *p = d->p;
    const cns_arith_ops *ops = J->ops;
    if (J->singular)
        return cns_fail(err, CNS_NUMERIC, "the expansion begins on a singularity");
    d->N = J->order;
    d->length = length;
    d->stretch = length / H;
    d->slack = 1 + ldexp(8 * d->N + 64, -52);
    mag_zero(d->overshoot);
    const long rounding = (long)ceil(ops->rounding_log2(J->A));
    if (rounding != d->constants_for) { /* constants are converted anew for each precision */
        mag_set_ui_2exp_si(d->unit, 1, rounding);
        read_constants(d);
        d->constants_for = rounding;
    }
    if (ops == &cns_arith_double || ops == &cns_arith_libm)
        mag_set_ui_2exp_si(d->least, 1, -960);
    set_powers(d);
    choose_fall(d);
    for (int i = 0; i < p->n_states; i++)
        read_row(d, i, J->state_vanishes[i] ? -1 : J->state_series[i], d->N + 1);
    for (int v = 0; v < p->n_nodes; v++) {
        const cns_program_node *n = &p->node[v];
        if (n->constant)
            continue;
        mag_zero(d->e0 + v);
        mag_zero(d->e1 + v);
        mag_zero(d->size + v);
        if (n->op == CNS_OP_EULER && J->series[v] >= 0) {
            const int a = n->arg[0];
            if (d->row[a] >= 0) {
                mag_zero(d->norm + v);
                cns_defect_euler_products(d->norm + v, d, a, -1);
            }
            mag_set(d->size + v, d->norm + v);
            if (ops->size_log2 && !J->vanishes[v])
                mag_set_ui_2exp_si(d->size + v, 1, ops->size_log2(J->A, J->series[v]));
        } else if (d->row[v] >= 0) {
            if (n->op != CNS_OP_STATE)
                read_row(d, d->row[v], J->vanishes[v] ? -1 : J->series[v], d->N);
            cns_defect_from(d->norm + v, d, v, 0);
            mag_set(d->size + v, d->norm + v);
            if (ops->size_log2 && !J->vanishes[v])
                mag_set_ui_2exp_si(d->size + v, 1, ops->size_log2(J->A, J->series[v]));
        }
    }
    return CNS_OK;
}

void cns_defect_widen(cns_defect *d, int state, const mag_t e0, const mag_t e1)
{
    const int v = d->p->state_node[state];
    if (v < 0)
        return; /* no operation sees it */
    mag_set(d->e0 + v, e0);
    mag_set(d->e1 + v, e1);
}

/* ---- what the rules are made of ---- */

void cns_remainder_begin(cns_defect *d, int v, const mag_t terms, const mag_t norm)
{
    mag_zero(d->e1 + v);
    mag_zero(d->e0 + v);
    if (d->row[v] < 0) {
        mag_set(d->size + v, terms);
        mag_set(d->norm + v, norm);
        return;
    }
    mag_add(d->e0 + v, terms, d->size + v);
    mag_mul(d->e0 + v, d->e0 + v, d->unit);
    mag_add(d->e0 + v, d->e0 + v, d->least);
}

void cns_defect_leading(mag_t y, const cns_defect *d, int a)
{
    const int r = d->row[a];
    if (r >= 0 && r < d->p->n_states)
        set_2exp(y, fabs(c_of(d, r)[d->N]) * d->slack, d->x[r] - d->fall[d->N]);
    else
        mag_zero(y);
}

void cns_defect_from(mag_t y, const cns_defect *d, int a, int k)
{
    const int r = d->row[a];
    if (r >= 0)
        set_2exp(y, S_of(d, r)[k] * d->slack, d->x[r] - d->fall[k]);
    else if (k == 0)
        mag_set(y, d->norm + a);
    else
        mag_zero(y); /* a constant */
}

/* The sum over i + j >= N of weight_i |a_i| |b_j|, weight being 1 or i. */
static void products(mag_t y, const cns_defect *d, int ra, int rb, bool weighted)
{
    const double *a = c_of(d, ra), *S = S_of(d, rb);
    double sum = 0;
    for (int i = 0; i <= d->N; i++)
        sum += fabs(a[i]) * (weighted ? i : 1) * (S[d->N - i] * d->split[i]);
    set_2exp(y, sum * d->slack, d->x[ra] + d->x[rb] - d->fall[d->N]);
}

void cns_defect_products(mag_t y, const cns_defect *d, int a, int b)
{
    if (d->row[a] >= 0 && d->row[b] >= 0) {
        products(y, d, d->row[a], d->row[b], false);
        return;
    }
    mag_t leading; /* one is a constant */
    mag_init(leading);
    cns_defect_leading(leading, d, d->row[a] >= 0 ? a : b);
    mag_mul(y, leading, d->norm + (d->row[a] >= 0 ? b : a));
    mag_clear(leading);
}

void cns_defect_euler_products(mag_t y, const cns_defect *d, int a, int b)
{
    if (b >= 0) {
        products(y, d, d->row[a], d->row[b], true);
        return;
    }
    const double *c = c_of(d, d->row[a]); /* b = 1: all terms of the derivative */
    double sum = 0;
    for (int k = d->N; k >= 1; k--)
        sum = k * (fabs(c[k])) + sum * d->down[k];
    set_2exp(y, sum * d->slack, d->x[d->row[a]] - d->fall[1]);
}

/* The coefficients of a row without `fall`, in d->plain, as many as matter; the sum of the others' sizes is
 * below *rest. */
static int unscale(const cns_defect *d, int row, double *rest)
{
    const double *c = c_of(d, row);
    const int n = d->N < TERMS ? d->N : TERMS;
    for (int k = 0; k <= n; k++)
        d->plain[k] = c[k] * d->flat[k];
    *rest = (n < d->N ? S_of(d, row)[n + 1] * d->slack * d->flat[n + 1] : 0) + TINY;
    return n;
}

static double horner(const double *c, int n, double x)
{
    double y = c[n];
    for (int k = n - 1; k >= 0; k--)
        y = y * x + c[k];
    return y;
}

/* At least |p'| on [0, x]. */
static double steepest(const double *c, int n, double x)
{
    double y = 0;
    for (int k = n; k >= 1; k--)
        y = y * x + k * fabs(c[k]);
    return y * (1 + ldexp(8 * n + 16, -52));
}

/* What rounding makes of horner() for 0 <= x <= 1, with that of the coefficients. */
static double horner_error(const double *c, int n)
{
    double sum = 0;
    for (int k = 0; k <= n; k++)
        sum += fabs(c[k]);
    return ldexp(sum, -52) * (4 * n + 16) + TINY;
}

bool cns_defect_lowest(mag_t y, const cns_defect *d, int v)
{
    if (d->p->node[v].constant) {
        arb_get_mag_lower(y, d->constant + v);
        mag_sub_lower(y, y, d->e0 + v);
        return !mag_is_zero(y);
    }
    const int r = d->row[v];
    double rest;
    const int n = unscale(d, r, &rest);
    const double *c = d->plain;
    const double error = horner_error(c, n) + rest;
    double low = 2 * fabs(c[0]) - ldexp(S_of(d, r)[0] * d->slack, -(int)d->fall[0]) - error;
    for (int pieces = 8; low <= 0.3 * fabs(c[0]) && pieces <= 4096; pieces *= 4) {
        low = HUGE_VAL;
        for (int j = 0; j < pieces && low > error; j++)
            low = fmin(low, fabs(horner(c, n, (j + 0.5) / pieces)) -
                                steepest(c, n, (j + 1.0) / pieces) * (0.5 / pieces));
        low = (low - error) * (1 - 0x1p-40);
        if (low > error && low > 0)
            break;
    }
    mag_zero(y);
    if (!(low > error))
        return false;
    mag_set_d_lower(y, low);
    mag_mul_2exp_si(y, y, d->x[r]);
    return true;
}

/* A product of small ones is small, of whatever kind they are; of all else the bound is that of its size. */
static void where_small(mag_t y, const cns_defect *d, int x, int u, const mag_t z, int depth)
{
    const cns_program_node *n = &d->p->node[x];
    mag_add(y, d->norm + x, d->e0 + x);
    mag_add(y, y, d->e1 + x);
    if (x == u) {
        mag_min(y, y, z);
    } else if (depth > 0 && (n->op == CNS_OP_MUL || n->op == CNS_OP_SQR || n->op == CNS_OP_SCALE)) {
        mag_t a, b;
        mag_init(a);
        mag_init(b);
        where_small(a, d, n->arg[0], u, z, depth - 1);
        if (n->op == CNS_OP_SQR)
            mag_set(b, a);
        else
            where_small(b, d, n->arg[1], u, z, depth - 1);
        mag_mul(a, a, b);
        mag_min(y, y, a);
        mag_clear(a);
        mag_clear(b);
    }
}

void cns_defect_where_small(mag_t y, const cns_defect *d, int x, int u, const mag_t z)
{
    where_small(y, d, x, u, z, FACTORS);
}

/* ---- the whole ---- */

cns_code cns_defect_bound(cns_defect *d, cns_error *err)
{
    const cns_jet *J = d->J;
    for (int v = 0; v < d->p->n_nodes; v++) {
        const cns_program_node *n = &d->p->node[v];
        if (n->constant || n->op == CNS_OP_STATE || (J->series[v] < 0 && !n->folded) ||
            (!n->needed && !J->spec.outputs))
            continue;
        bool exact = J->vanishes[v]; /* zero, made of zeros */
        for (int k = 0; k < 4 && exact; k++)
            exact = n->arg[k] < 0 || n->arg[k] >= v ||
                    (mag_is_zero(d->e0 + n->arg[k]) && mag_is_zero(d->e1 + n->arg[k]));
        if (!exact && !cns_operations[n->op]->remainder(d, v))
            return cns_fail(
                err, CNS_NUMERIC, "no bound: what %s of %s divides by, or takes the root of, may be zero",
                "the equation", cns_equation_of(d->p, v) ? cns_equation_of(d->p, v) : "an output");
    }
    return CNS_OK;
}

void cns_defect_rounding(mag_t y, const cns_defect *d, int state)
{
    const cns_jet *J = d->J;
    mag_zero(y);
    if (J->state_vanishes[state])
        return;
    set_2exp(y, S_of(d, state)[0] * d->slack, d->x[state] - d->fall[0]);
    if (J->ops->size_log2)
        mag_set_ui_2exp_si(y, 1, J->ops->size_log2(J->A, J->state_series[state]));
    mag_mul(y, y, d->unit);
    mag_add(y, y, d->least);
}

void cns_defect_of(mag_t g, const cns_defect *d, int state)
{
    const int f = d->p->derivative[state], q = d->p->factor[state];
    mag_t H, c, ec, x, y;
    mag_init(H);
    mag_init(c);
    mag_init(ec);
    mag_init(x);
    mag_init(y);
    mag_set_d(H, d->length);
    mag_one(c);
    if (q >= 0) {
        mag_set(c, d->norm + q);
        mag_set(ec, d->e0 + q);
    }
    /* The rounding of store_next, */
    cns_defect_rounding(g, d, state);
    mag_mul(x, c, d->size + f);
    mag_mul(x, x, H);
    mag_addmul(g, x, d->unit);
    /* what the derivative's polynomial misses, integrated, */
    cns_defect_leading(y, d, f);
    mag_add(y, y, d->e1 + f);
    mag_div_ui(y, y, (ulong)d->N + 1);
    mag_add(y, y, d->e0 + f);
    mag_add(x, c, ec);
    mag_mul(y, y, x);
    /* and the factor's own error. */
    mag_add(x, d->norm + f, d->e0 + f);
    mag_add(x, x, d->e1 + f);
    mag_addmul(y, x, ec);
    mag_addmul(g, y, H);
    mag_clear(H);
    mag_clear(c);
    mag_clear(ec);
    mag_clear(x);
    mag_clear(y);
}

int cns_defect_order(const cns_defect *d)
{
    return d->N;
}

double cns_defect_coefficient(const cns_defect *d, int state, int k, long *e)
{
    *e = d->x[state] - d->fall[k];
    return c_of(d, state)[k];
}

/* By Horner's scheme with polynomials, q <- q (begin + part s) + c_k. All terms of the result are sums of
 * terms whose sizes add up to no more than the sum of |c_k|, as begin + part <= 1. */
void cns_defect_shifted(const cns_defect *d, int state, double begin, double part, double *c, int n, long *e,
                        mag_t error, mag_t tail)
{
    double rest, size = 0, beyond = 0;
    const int N = unscale(d, state, &rest);
    double q[TERMS + 1] = {0};
    if (begin == 0) {
        double power = 1;
        for (int k = 0; k <= N; k++, power *= part)
            q[k] = d->plain[k] * power;
    }
    for (int k = N; k >= 0 && begin != 0; k--) {
        for (int i = N; i >= 1; i--)
            q[i] = q[i] * begin + q[i - 1] * part;
        q[0] = q[0] * begin + d->plain[k];
    }
    for (int k = 0; k <= N; k++) {
        size += fabs(d->plain[k]);
        if (k > n)
            beyond += fabs(q[k]);
    }
    for (int k = 0; k <= n; k++)
        c[k] = k <= N ? q[k] : 0;
    *e = d->x[state];
    set_2exp(tail, beyond * d->slack, *e);
    /* 2 N + 2 operations, and the coefficients' own errors; what lies beyond N is a polynomial, too. */
    set_2exp(error, ldexp(size, -52) * (6 * N + 24) + rest, *e);
}

void cns_defect_value(arb_t y, const cns_defect *d, int state, const arb_t tau)
{
    double rest;
    const int n = unscale(d, state, &rest);
    const double x = arf_get_d(arb_midref(tau), ARF_RND_NEAR);
    arb_t spread; /* tau - x */
    mag_t radius, t;
    arb_init(spread);
    mag_init(radius);
    mag_init(t);
    arf_set_d(arb_midref(spread), x);
    arb_sub(spread, tau, spread, MAG_BITS);
    arb_get_mag(radius, spread);
    const double furthest = fmin(1.0 + 1e-9, x + mag_get_d(radius)); /* tau <= 1 + a little */
    mag_set_d(t, steepest(d->plain, n, furthest) + rest * d->N);
    mag_mul(radius, radius, t);
    mag_set_d(t, horner_error(d->plain, n) + rest);
    mag_add(radius, radius, t);
    arb_set_d(y, horner(d->plain, n, x));
    arb_add_error_mag(y, radius);
    arb_mul_2exp_si(y, y, d->x[state]);
    arb_clear(spread);
    mag_clear(radius);
    mag_clear(t);
}

void cns_defect_slope(mag_t y, const cns_defect *d, int state)
{
    const double *c = c_of(d, state);
    double sum = 0;
    for (int k = d->N; k >= 1; k--)
        sum = k * (fabs(c[k])) + sum * d->down[k];
    set_2exp(y, sum * d->slack, d->x[state] - d->fall[1]);
}

/* ---- signs ---- */

/* Looks for how far below zero sigma u can be on [a, b], u being the polynomial of coefficients c_0..c_n,
 * with an error below `error` where it is not known better: at 0, and, if `last`, at b = tau_end, where it is
 * at least `end`. */
typedef struct fall_below {
    const double *c;
    int n, sigma;
    double error, end;
    int order;  /* of u, of which c are the leading coefficients */
    int pieces; /* that may still be looked at */
} fall_below;

static double below(fall_below *f, double a, double b, bool last)
{
    const double middle = (a + b) / 2, half = (b - a) / 2 * (1 + 1e-15);
    const double low = f->sigma * horner(f->c, f->n, middle) - half * steepest(f->c, f->n, b) - f->error;
    if (low > 0)
        return 0;
    double slope = 0, bend = 0;
    for (int k = f->n; k >= 1; k--)
        slope = slope * middle + k * f->c[k];
    for (int k = f->n; k >= 2; k--)
        bend = bend * b + (double)k * (k - 1) * fabs(f->c[k]);
    const double spread = half * bend * (1 + 1e-12) + f->error * f->order; /* with those that c has not */
    if (f->sigma * slope - spread > 0) {                                   /* it rises: least at a */
        if (a == 0)
            return f->sigma * f->c[0] < 0 ? fabs(f->c[0]) * (1 + 1e-15) : 0;
        if (f->sigma * horner(f->c, f->n, a) > f->error)
            return 0;
    } else if (f->sigma * slope + spread < 0) { /* it falls: least at b */
        if (last)
            return f->end < 0 ? -f->end : 0;
        if (f->sigma * horner(f->c, f->n, b) > f->error)
            return 0;
    }
    if (f->pieces-- <= 0)
        return -low;
    return fmax(below(f, a, middle, false), below(f, middle, b, last));
}

/* A lower bound of sigma u at `end`, from all its bits. */
static double value_at(const cns_defect *d, int u, int sigma, const arb_t end)
{
    const cns_jet *J = d->J;
    const int n = d->p->node[u].op == CNS_OP_STATE ? d->N : d->N - 1;
    const slong prec = 2 * J->spec.prec + CONSTANT_BITS;
    mpfr_t c;
    arb_t y, x;
    arf_t low;
    mpfr_init2(c, prec);
    arb_init(y);
    arb_init(x);
    arf_init(low);
    for (int k = n; k >= 0; k--) {
        J->ops->get(J->A, c, J->series[u], k);
        arb_set_interval_mpfr(x, c, c, prec);
        arb_mul(y, y, end, prec);
        arb_add(y, y, x, prec);
    }
    if (sigma < 0)
        arb_neg(y, y);
    arb_mul_2exp_si(y, y, -d->x[d->row[u]]);
    arb_get_lbound_arf(low, y, 53);
    const double bound = arf_get_d(low, ARF_RND_FLOOR);
    mpfr_clear(c);
    arb_clear(y);
    arb_clear(x);
    arf_clear(low);
    return bound;
}

void cns_defect_find_overshoot(cns_defect *d, const arb_t end)
{
    const cns_jet *J = d->J;
    mag_t one;
    mag_init(one);
    mag_zero(d->overshoot);
    for (int w = 0; w < d->p->n_watch; w++) {
        const int v = d->p->watch[w];
        const cns_watched watched = cns_operation_of(J, v)->watch(J, v);
        const int u = watched.node;
        if (watched.kind != CNS_WATCH_KINK || J->vanishes[u] || d->p->node[u].constant)
            continue;
        if (J->sign[v] == 0) {
            mag_max(d->overshoot, d->overshoot, d->norm + u);
            continue;
        }
        double rest;
        int zeros = 0;
        const int n = unscale(d, d->row[u], &rest);
        while (zeros < n && d->plain[zeros] == 0)
            zeros++;
        const double error = horner_error(d->plain, n) + rest;
        fall_below f = {.c = d->plain + zeros,
                        .n = n - zeros,
                        .sigma = J->sign[v],
                        .error = error,
                        .order = d->N,
                        .pieces = PIECES};
        if (f.sigma * f.c[0] - (ldexp(S_of(d, d->row[u])[0] * d->slack, 0) - fabs(f.c[0])) > error)
            continue; /* the first coefficient outweighs the others */
        f.end = value_at(d, u, J->sign[v], end);
        /* Divided by sigma^zeros, sigma being almost 1 at the end. */
        set_2exp(one, 1.001 * below(&f, 0, 1, true), d->x[d->row[u]]);
        mag_max(d->overshoot, d->overshoot, one);
    }
    mag_clear(one);
}

void cns_defect_set_overshoot(cns_defect *d, const mag_t overshoot)
{
    mag_set(d->overshoot, overshoot);
}

const mag_struct *cns_defect_overshoot(const cns_defect *d)
{
    return d->overshoot;
}
