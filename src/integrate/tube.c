#include "tube.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "growth.h"
#include "method.h"
#include "num/logs.h"
#include "taylor/ball.h"
#include "taylor/defect.h"
#include "taylor/tangent.h"

enum {
    TANGENT_ORDER = 12,
    GUESS_LOG2 = 14, /* by which the tube is wider than the error at its beginning, at first */
    GUESSES = 4,
    WIDEST_LOG2 = -6, /* of a tube, relative to nothing: states are of order one in their units */
    FIRST_BOXES = 2,
    MOST_BOXES = 128,
    TIME_BITS = 64, /* more than the states', for times within a step */
    BOX_BITS = 53
};
/* With ln K up to this, boxes are fine enough. */
#define ENOUGH 3.0

struct cns_tube {
    const cns_program *p;
    int n, d;
    int *index; /* the dynamic states */
    cns_program *tangents;
    cns_jet *jet;                        /* of the tangents, in double */
    cns_defect *defect, *tangent_defect; /* of the run's jet, which may be another one from step to step */
    const cns_jet *defect_of;
    double *Q;       /* d x d, row-major */
    mag_ptr r;       /* d: |r_j| */
    mag_ptr passive; /* n: the errors of passive states, at the end of the last step */
    mpfr_t *state;   /* n: the run's state at the end of the last step, which `r` and `passive` are about */

    /* Of the last step. */
    double H, length;
    bool stepped;
    mag_ptr r0, passive0;           /* at its beginning */
    mag_ptr column, passive_column; /* d: of D; n x d: of the passive rows */
    mag_t K, rest;                  /* K; K (G + |p(0) - s|) */
    mag_ptr lost;                   /* n: what a passive state may lose within the step beside V r */
    double *product, *before;       /* d x d: of all R, times 2^product_e; the same without the last */
    long product_e, before_e;
    mpfr_t tau, x, y;
    double *B, *R, *Q1; /* scratch, d x d; B: n x d */
    double *row, *rows; /* scratch, 2 d; 2 n */
    arb_ptr box, slope; /* scratch: states of the tangent program, and their derivatives */
};

static mag_ptr mags(size_t n)
{
    return _mag_vec_init((slong)n + 1);
}

cns_tube *cns_tube_new(const cns_program *p, mpfr_prec_t prec, cns_error *err)
{
    cns_tube *t = calloc(1, sizeof *t);
    if (t == NULL) {
        cns_out_of_memory(err);
        return NULL;
    }
    t->p = p;
    t->n = cns_program_states(p);
    mag_init(t->K);
    mag_init(t->rest);
    mpfr_inits2(MPFR_PREC_MIN, t->tau, t->x, t->y, (mpfr_ptr)0);
    t->index = calloc((size_t)t->n + 1, sizeof *t->index);
    if (t->index == NULL) {
        cns_out_of_memory(err);
        cns_tube_free(t);
        return NULL;
    }
    t->d = cns_dynamic_states(p, t->index);
    const size_t d = (size_t)t->d, n = (size_t)t->n;
    t->Q = calloc(5 * d * d + n * d + 2 * d + 2 * n + 1, sizeof *t->Q);
    if (t->Q == NULL || cns_whole_tangent_program(p, t->d, &t->tangents, err)) {
        if (t->Q == NULL)
            cns_out_of_memory(err);
        cns_tube_free(t);
        return NULL;
    }
    t->product = t->Q + d * d;
    t->R = t->Q + 2 * d * d;
    t->Q1 = t->Q + 3 * d * d;
    t->before = t->Q + 4 * d * d;
    t->B = t->Q + 5 * d * d;
    t->row = t->B + n * d;
    t->rows = t->row + 2 * d;
    t->state = cns_vector_new(t->n, prec);
    if (t->state == NULL) {
        cns_out_of_memory(err);
        cns_tube_free(t);
        return NULL;
    }
    t->r = mags(d);
    t->r0 = mags(d);
    t->column = mags(d);
    t->passive = mags(n);
    t->passive0 = mags(n);
    t->lost = mags(n);
    t->passive_column = mags(n * d);
    t->box = _arb_vec_init(t->n * (t->d + 1) + 1);
    t->slope = _arb_vec_init(t->n * (t->d + 1) + 1);
    const cns_jet_spec spec = {
        .program = t->tangents, .ops = &cns_arith_double, .order = TANGENT_ORDER, .prec = 53};
    t->jet = cns_jet_new(&spec, err);
    if (t->jet != NULL)
        t->tangent_defect = cns_defect_new(t->jet, err);
    if (t->tangent_defect == NULL) {
        cns_tube_free(t);
        return NULL;
    }
    return t;
}

static void mags_free(mag_ptr m, int n)
{
    if (m != NULL)
        _mag_vec_clear(m, n + 1);
}

void cns_tube_free(cns_tube *t)
{
    if (t == NULL)
        return;
    cns_defect_free(t->defect);
    cns_defect_free(t->tangent_defect);
    cns_jet_free(t->jet);
    cns_program_free(t->tangents);
    mags_free(t->r, t->d);
    mags_free(t->r0, t->d);
    mags_free(t->column, t->d);
    mags_free(t->passive, t->n);
    mags_free(t->passive0, t->n);
    mags_free(t->lost, t->n);
    mags_free(t->passive_column, t->n * t->d);
    if (t->box != NULL)
        _arb_vec_clear(t->box, t->n * (t->d + 1) + 1);
    if (t->slope != NULL)
        _arb_vec_clear(t->slope, t->n * (t->d + 1) + 1);
    cns_vector_free(t->state);
    mag_clear(t->K);
    mag_clear(t->rest);
    mpfr_clears(t->tau, t->x, t->y, (mpfr_ptr)0);
    free(t->index);
    free(t->Q);
    free(t);
}

/* y = |a - b|, rounded up. */
static void distance(mag_t y, mpfr_srcptr a, mpfr_srcptr b)
{
    mpfr_t x;
    arf_t f;
    mpfr_init2(x, MAG_BITS);
    arf_init(f);
    mpfr_sub(x, a, b, MPFR_RNDA);
    arf_set_mpfr(f, x);
    arf_get_mag(y, f);
    mpfr_clear(x);
    arf_clear(f);
}

static void keep_state(cns_tube *t, const cns_flow *f)
{
    for (int i = 0; i < t->n; i++)
        mpfr_set(t->state[i], cns_flow_state(f)[i], MPFR_RNDN);
}

void cns_tube_start(cns_tube *t, const cns_flow *f, const cns_number *initial)
{
    const mpfr_prec_t prec = cns_flow_prec(f);
    arb_t exact, stored;
    mag_t error;
    arb_init(exact);
    arb_init(stored);
    mag_init(error);
    for (int i = 0, k = 0; i < t->n; i++) {
        mpfr_srcptr x = cns_flow_state(f)[i];
        cns_ball_number(exact, &initial[i], prec + TIME_BITS);
        arb_set_interval_mpfr(stored, x, x, prec);
        arb_sub(exact, exact, stored, prec + TIME_BITS);
        arb_get_mag(error, exact);
        if (k < t->d && t->index[k] == i)
            mag_set(t->r + k++, error);
        else
            mag_set(t->passive + i, error);
    }
    memset(t->Q, 0, (size_t)t->d * (size_t)t->d * sizeof *t->Q);
    memset(t->product, 0, (size_t)t->d * (size_t)t->d * sizeof *t->product);
    for (int k = 0; k < t->d; k++)
        t->Q[k * t->d + k] = t->product[k * t->d + k] = 1;
    t->product_e = 0;
    t->stepped = false;
    keep_state(t, f);
    arb_clear(exact);
    arb_clear(stored);
    mag_clear(error);
}

static void set_tau(cns_tube *t, mpfr_srcptr elapsed, mpfr_prec_t prec)
{
    mpfr_set_prec(t->tau, prec + TIME_BITS);
    mpfr_div_d(t->tau, elapsed, t->H, MPFR_RNDN);
}

/* error = |x - p(tau)|, p being the run's polynomial, with what the evaluation itself may miss. */
static void evaluation_error(cns_tube *t, const cns_jet *J, int i, mpfr_srcptr x, mag_t error)
{
    mag_t more;
    mag_init(more);
    cns_jet_sum(J, t->y, i, t->tau);
    distance(error, x, t->y);
    cns_defect_rounding(more, t->defect, i);
    mag_add(error, error, more);
    cns_defect_slope(more, t->defect, i); /* tau is rounded */
    mag_mul_2exp_si(more, more, 1 - (slong)mpfr_get_prec(t->tau));
    mag_add(error, error, more);
    arf_t y;
    arf_init(y);
    arf_set_mpfr(y, t->y); /* and so is the sum */
    arf_get_mag(more, y);
    mag_mul_2exp_si(more, more, -(slong)mpfr_get_prec(t->y));
    mag_add(error, error, more);
    arf_clear(y);
    mag_clear(more);
}

/* The polynomials of the run and of the tangents' copy of it differ: e0 + e1 tau^N of state i, and the tube.
 */
static void widen(cns_tube *t, int i, const mag_t tube)
{
    const cns_defect *p = t->defect, *q = t->tangent_defect;
    mag_t e0, e1, x;
    mag_init_set(e0, tube);
    mag_init(e1);
    mag_init(x);
    const int m = cns_defect_order(q);
    for (int k = 0; k <= m; k++) {
        long a_e, b_e;
        const double a = k <= cns_defect_order(p) ? cns_defect_coefficient(p, i, k, &a_e) : (a_e = 0, 0),
                     b = cns_defect_coefficient(q, i, k, &b_e);
        if (a_e - b_e > 900 || b_e - a_e > 900) {
            mag_set_d(x, fabs(a));
            mag_mul_2exp_si(x, x, a_e);
            mag_add(e0, e0, x);
            mag_set_d(x, fabs(b));
            mag_mul_2exp_si(x, x, b_e);
            mag_add(e0, e0, x);
            continue;
        }
        const double moved = ldexp(a, (int)(a_e - b_e)), difference = fabs(moved - b);
        mag_set_d(x, difference * (1 + 0x1p-50) + ldexp(fabs(moved) + fabs(b), -52) * (3 * k + 8) + 1e-300);
        mag_mul_2exp_si(x, x, b_e);
        mag_add(e0, e0, x);
    }
    cns_defect_tail(e1, p, i, m + 1);
    cns_defect_widen(t->tangent_defect, i, e0, e1);
    mag_clear(e0);
    mag_clear(e1);
    mag_clear(x);
}

static cns_code expand_tangents(cns_tube *t, const cns_jet *J, cns_error *err)
{
    const int n = t->n, d = t->d;
    mpfr_set_prec(t->x, 53);
    for (int attempt = 0; attempt < 2; attempt++) {
        cns_jet_begin(t->jet, t->length);
        for (int i = 0; i < n; i++) {
            cns_jet_coefficient(J, t->x, i, 0);
            cns_jet_set_state(t->jet, i, t->x);
            for (int j = 0; j < d; j++) {
                mpfr_set_zero(t->x, 1);
                cns_jet_set_state(t->jet, n * (1 + j) + i, t->x);
            }
        }
        for (int j = 0; j < d; j++)
            for (int k = 0; k < d; k++) {
                mpfr_set_d(t->x, t->Q[k * d + j], MPFR_RNDN);
                cns_jet_set_state(t->jet, n * (1 + j) + t->index[k], t->x);
            }
        for (int w = 0; w < cns_jet_watched(t->jet) && attempt > 0; w++)
            cns_jet_set_zero(t->jet, w); /* in double it is not zero, but of no sign either */
        const cns_code code = cns_jet_expand(t->jet, TANGENT_ORDER, err);
        if (code)
            return code;
        if (cns_jet_signs_agree(t->jet, J))
            return cns_defect_read(t->tangent_defect, t->length, t->length, err);
    }
    return cns_fail(err, CNS_NUMERIC, "the tangents see another sign under an abs()");
}

/* The largest row sum of the Jacobian's dynamic part over a box, with the diagonal's sign: its logarithmic
 * norm; and of passive rows, of sizes. */
static double box_norm(const cns_tube *t, arb_srcptr f, double *passive)
{
    const int n = t->n, d = t->d;
    double worst = -HUGE_VAL;
    mag_t size;
    arf_t upper;
    mag_init(size);
    arf_init(upper);
    for (int i = 0, k = 0; i < n; i++) {
        const bool dynamic = k < d && t->index[k] == i;
        double row = 0;
        for (int j = 0; j < d; j++) {
            arb_srcptr y = f + n * (1 + j) + i;
            if (dynamic && j == k) {
                arb_get_ubound_arf(upper, y, BOX_BITS);
                row += arf_get_d(upper, ARF_RND_CEIL);
            } else {
                arb_get_mag(size, y);
                row += mag_get_d(size);
            }
        }
        row += fabs(row) * 0x1p-40; /* d additions */
        if (dynamic) {
            worst = fmax(worst, row);
            k++;
        } else {
            passive[i] = fmax(passive[i], row);
        }
    }
    mag_clear(size);
    arf_clear(upper);
    return worst;
}

/* K: an error within the tube grows by no more than this factor over the step, exp of the integral of the
 * positive part of the logarithmic norm. passive: the largest row sums of passive states. False: none. */
static bool grow(cns_tube *t, const mag_t tube, double *passive)
{
    double best = HUGE_VAL;
    arb_t tau;
    cns_error ignored;
    arb_init(tau);
    for (int k = 0; k < t->n * t->d; k++)
        arb_zero(t->box + t->n + k);
    for (int j = 0; j < t->d; j++)
        arb_one(t->box + t->n * (1 + j) + t->index[j]);
    for (int boxes = FIRST_BOXES; boxes <= MOST_BOXES && best > ENOUGH; boxes *= 2) {
        double sum = 0;
        double *rows = t->rows;
        bool is = true;
        for (int i = 0; i < t->n; i++)
            rows[i] = 0;
        for (int b = 0; b < boxes && is; b++) {
            arb_set_d(tau, (b + 0.5) / boxes);
            mag_set_d(arb_radref(tau), 0.5 / boxes);
            for (int i = 0; i < t->n; i++) {
                cns_defect_value(t->box + i, t->defect, i, tau);
                arb_add_error_mag(t->box + i, tube);
            }
            is = !cns_ball_derivatives(t->tangents, t->box, t->slope, BOX_BITS, &ignored);
            if (is)
                sum += fmax(0, box_norm(t, t->slope, rows)) * t->length / boxes;
        }
        sum *= 1 + 0x1p-40;
        if (!is || !(sum < best))
            continue;
        best = sum;
        for (int i = 0; i < t->n; i++)
            passive[i] = rows[i];
        if (boxes >= 32 && best < 4 * ENOUGH)
            break;
    }
    arb_clear(tau);
    if (!(best < 60))
        return false;
    mag_t x;
    mag_init(x);
    mag_set_d(x, best);
    mag_exp(t->K, x);
    mag_clear(x);
    return true;
}

/* |V_ij| at tau, in units of the step, and how far it may be from that: rounding, and tau's own. */
static double tangent_at(const cns_tube *t, int i, int j, const arb_t tau, mag_t error)
{
    arb_t y;
    arb_init(y);
    cns_defect_value(y, t->tangent_defect, t->n * (1 + j) + i, tau);
    const double v = arf_get_d(arb_midref(y), ARF_RND_NEAR);
    mag_t x;
    mag_init(x);
    mag_set_d(x, ldexp(fabs(v), -52));
    mag_add(error, arb_radref(y), x);
    mag_clear(x);
    arb_clear(y);
    return v;
}

/* error = sum_j (|V_ij| + D_ij) r_j at tau. */
static void carried(cns_tube *t, int i, bool dynamic, const arb_t tau, mag_t error)
{
    mag_t x, y;
    mag_init(x);
    mag_init(y);
    mag_zero(error);
    for (int j = 0; j < t->d; j++) {
        mag_set_d(x, fabs(tangent_at(t, i, j, tau, y)));
        mag_add(x, x, y);
        mag_add(x, x, dynamic ? t->column + j : t->passive_column + i * t->d + j);
        mag_addmul(error, x, t->r0 + j);
    }
    mag_clear(x);
    mag_clear(y);
}

static bool is_dynamic(const cns_tube *t, int i)
{
    return cns_program_is_dynamic(t->p, i);
}

/* The error within the last step, at tau, of what the polynomials say. */
static void error_at(cns_tube *t, int i, const arb_t tau, mag_t error)
{
    const bool dynamic = is_dynamic(t, i);
    carried(t, i, dynamic, tau, error);
    if (dynamic) {
        mag_add(error, error, t->rest);
    } else {
        mag_add(error, error, t->passive0 + i);
        mag_add(error, error, t->lost + i);
    }
}

/* Columns of Q1 from those of B by Gram-Schmidt, twice. False: they are dependent, or not finite. */
static bool orthogonalise(cns_tube *t)
{
    const int d = t->d;
    double *q = t->Q1;
    for (int j = 0; j < d; j++) {
        for (int k = 0; k < d; k++)
            q[k * d + j] = t->B[t->index[k] * d + j];
        for (int pass = 0; pass < 2; pass++) {
            double norm = 0;
            for (int l = 0; l < j; l++) {
                double s = 0;
                for (int k = 0; k < d; k++)
                    s += q[k * d + l] * q[k * d + j];
                for (int k = 0; k < d; k++)
                    q[k * d + j] -= s * q[k * d + l];
            }
            for (int k = 0; k < d; k++)
                norm += q[k * d + j] * q[k * d + j];
            norm = sqrt(norm);
            if (!(norm > 0) || !isfinite(norm))
                return false;
            for (int k = 0; k < d; k++)
                q[k * d + j] /= norm;
        }
    }
    return true;
}

/* eta: Q1^-1 = Q1^T + E with |E| <= eta in the largest row sum. From Q1^T Q1 = I + F, |F| <= f < 1:
 * Q1^-1 - Q1^T = ((I + F)^-1 - I) Q1^T, at most f / (1 - f) times the norm of Q1^T, at most d (1 + f). */
static bool inverse_error(const cns_tube *t, mag_t eta)
{
    const int d = t->d;
    double worst = 0;
    for (int a = 0; a < d; a++) {
        double row = 0;
        for (int b = 0; b < d; b++) {
            double s = a == b ? -1 : 0;
            for (int k = 0; k < d; k++)
                s += t->Q1[k * d + a] * t->Q1[k * d + b];
            row += fabs(s) + (d + 2) * 0x1p-51;
        }
        worst = fmax(worst, row);
    }
    if (!(worst < 0.01))
        return false;
    mag_set_d(eta, worst * 1.02 * d * 1.02);
    return true;
}

/* r' = (|Q1^T B| + eta |B| + (|Q1^T| + eta) D) r + (|Q1^T| + eta) w; dB: of B's columns, with D. */
static bool turn(cns_tube *t, mag_srcptr dB, mag_srcptr w)
{
    const int d = t->d;
    mag_t eta, x, y, q;
    mag_init(eta);
    mag_init(x);
    mag_init(y);
    mag_init(q);
    const bool is = orthogonalise(t) && inverse_error(t, eta);
    for (int a = 0; a < d && is; a++) {
        double sum = 0;
        for (int k = 0; k < d; k++)
            sum += fabs(t->Q1[k * d + a]);
        mag_set_d(q, sum * (1 + 0x1p-40));
        mag_add(q, q, eta); /* |Q1^T| + eta, a row sum */
        mag_zero(t->r + a);
        for (int j = 0; j < d; j++) {
            double m = 0, size = 0, largest = 0;
            for (int k = 0; k < d; k++) {
                const double b = t->B[t->index[k] * d + j];
                m += t->Q1[k * d + a] * b;
                size += fabs(t->Q1[k * d + a] * b);
                largest = fmax(largest, fabs(b));
            }
            t->R[a * d + j] = m;
            mag_set_d(x, fabs(m) + size * (d + 2) * 0x1p-51 + 1e-300);
            mag_set_d(y, largest);
            mag_addmul(x, y, eta);
            mag_addmul(x, q, dB + j);
            mag_addmul(t->r + a, x, t->r0 + j);
        }
        for (int k = 0; k < d; k++) {
            mag_set_d(x, fabs(t->Q1[k * d + a]));
            mag_add(x, x, eta);
            mag_addmul(t->r + a, x, w + k);
        }
    }
    if (is)
        memcpy(t->Q, t->Q1, (size_t)d * (size_t)d * sizeof *t->Q);
    mag_clear(eta);
    mag_clear(x);
    mag_clear(y);
    mag_clear(q);
    return is;
}

/* The product of all R. */
static void multiply(cns_tube *t)
{
    const int d = t->d;
    double largest = 0, *column = t->row;
    memcpy(t->before, t->product, (size_t)d * (size_t)d * sizeof *t->before);
    t->before_e = t->product_e;
    for (int j = 0; j < d; j++) {
        for (int a = 0; a < d; a++) {
            column[a] = 0;
            for (int k = 0; k < d; k++)
                column[a] += t->R[a * d + k] * t->product[k * d + j];
        }
        for (int a = 0; a < d; a++) {
            t->product[a * d + j] = column[a];
            largest = fmax(largest, fabs(column[a]));
        }
    }
    int e;
    frexp(largest, &e);
    for (int k = 0; k < d * d; k++)
        t->product[k] = ldexp(t->product[k], -e);
    t->product_e += e;
}

/* D, K and what depends on the tube, which is guessed and then proven; e: of the error at the beginning, with
 * G. False: no tube was found. */
static cns_code find_tube(cns_tube *t, const cns_jet *J, const mag_t e, cns_error *err)
{
    const int n = t->n, d = t->d;
    mag_t tube, x, g;
    double *passive = t->rows + n;
    mag_init(tube);
    mag_init(x);
    mag_init(g);
    mag_mul_2exp_si(tube, e, GUESS_LOG2);
    cns_code code = expand_tangents(t, J, err);
    bool closed = false;
    for (int guess = 0; guess < GUESSES && !code && !closed; guess++) {
        if (mag_cmp_2exp_si(tube, WIDEST_LOG2) > 0) {
            code = cns_fail(err, CNS_UNREACHED, "the error's bound has grown to the size of the motion");
            break;
        }
        if (!grow(t, tube, passive)) {
            code = cns_fail(err, CNS_NUMERIC, "the Jacobian is not bounded within the tube");
            break;
        }
        mag_mul(t->rest, t->K, e);
        closed = mag_cmp(t->rest, tube) < 0 || (mag_is_zero(t->rest) && mag_is_zero(tube));
        if (!closed)
            mag_mul_2exp_si(tube, t->rest, 2);
    }
    if (!code && !closed)
        code = cns_fail(err, CNS_NUMERIC, "no tube about the trajectory was found");
    for (int i = 0; i < n && !code; i++)
        widen(t, i, tube);
    if (!code) {
        cns_defect_set_overshoot(t->tangent_defect, cns_defect_overshoot(t->defect));
        code = cns_defect_bound(t->tangent_defect, err);
    }
    for (int j = 0; j < d && !code; j++) {
        mag_zero(x);
        for (int k = 0; k < d; k++) {
            cns_defect_of(g, t->tangent_defect, n * (1 + j) + t->index[k]);
            mag_max(x, x, g);
        }
        mag_mul(t->column + j, x, t->K);
        for (int i = 0; i < n; i++) {
            if (is_dynamic(t, i))
                continue;
            cns_defect_of(g, t->tangent_defect, n * (1 + j) + i);
            mag_set_d(x, passive[i] * t->length);
            mag_addmul(g, x, t->column + j);
            mag_set(t->passive_column + i * d + j, g);
        }
    }
    for (int i = 0; i < n && !code; i++) { /* of e's part that is not carried by V */
        mag_set_d(x, passive[i] * t->length);
        mag_mul(t->lost + i, x, t->rest);
    }
    mag_clear(tube);
    mag_clear(x);
    mag_clear(g);
    return code;
}

static cns_code follow(cns_tube *t, const cns_flow *f, const cns_jet *J, cns_error *err)
{
    const int n = t->n, d = t->d;
    const mpfr_prec_t prec = cns_flow_prec(f);
    mag_t e, x, g;
    arb_t end;
    mag_ptr w = mags((size_t)d), dB = mags((size_t)d), start = mags((size_t)n);
    mag_init(e);
    mag_init(x);
    mag_init(g);
    arb_init(end);

    /* The step's length, exact, and its end in units of H. */
    mpfr_set_prec(t->x, 4 * prec + 8 * TIME_BITS);
    mpfr_sub(t->x, cns_flow_end(f), cns_flow_begin(f), MPFR_RNDN);
    t->length = mpfr_get_d(t->x, MPFR_RNDU);
    set_tau(t, t->x, prec);
    arb_set_interval_mpfr(end, t->tau, t->tau, mpfr_get_prec(t->tau));
    mag_set_ui_2exp_si(x, 1, 4 - (slong)mpfr_get_prec(t->tau));
    arb_add_error_mag(end, x);
    cns_code code = cns_defect_read(t->defect, t->H, t->length, err);
    if (!code) {
        cns_defect_find_overshoot(t->defect, end);
        code = cns_defect_bound(t->defect, err);
    }

    /* e: |error| at the beginning, dynamic part: Q r, the conversion of the states, and the defect. */
    mpfr_set_prec(t->x, 2 * prec + 4 * TIME_BITS);
    for (int i = 0; i < n && !code; i++) {
        cns_jet_coefficient(J, t->x, i, 0);
        distance(start + i, t->x, t->state[i]);
        cns_defect_of(g, t->defect, i);
        mag_add(start + i, start + i, g);
    }
    mag_t rest;
    mag_init(rest); /* the part that V r does not carry */
    for (int k = 0; k < d && !code; k++)
        mag_max(rest, rest, start + t->index[k]);
    mag_zero(e);
    for (int k = 0; k < d && !code; k++) {
        mag_zero(g);
        for (int j = 0; j < d; j++) {
            mag_set_d(x, fabs(t->Q[k * d + j]));
            mag_addmul(g, x, t->r + j);
        }
        mag_max(e, e, g);
    }
    mag_add(e, e, rest);
    if (!code)
        code = find_tube(t, J, e, err);
    if (!code) {
        /* rest: K times the part that V does not carry. */
        for (int i = 0; i < n; i++) {
            mag_div(x, rest, e); /* `lost` was made of all of e */
            if (mag_is_zero(e))
                mag_zero(x);
            mag_mul(t->lost + i, t->lost + i, x);
            mag_add(t->lost + i, t->lost + i, start + i);
        }
        mag_mul(t->rest, t->K, rest);
        for (int j = 0; j < d; j++)
            mag_set(t->r0 + j, t->r + j);
        for (int i = 0; i < n; i++)
            mag_set(t->passive0 + i, t->passive + i);
        arb_t tau;
        arb_init(tau);
        /* The end in units of the length: 1, or a little less, as that was rounded up. */
        mpfr_set_prec(t->x, 4 * prec + 8 * TIME_BITS);
        mpfr_sub(t->x, cns_flow_end(f), cns_flow_begin(f), MPFR_RNDN);
        mpfr_div_d(t->x, t->x, t->length, MPFR_RNDN);
        arb_set_interval_mpfr(tau, t->x, t->x, BOX_BITS);
        mpfr_set_prec(t->y, 2 * prec + 4 * TIME_BITS);
        for (int i = 0, k = 0; i < n; i++) {
            mag_t jump;
            mag_init(jump);
            evaluation_error(t, J, i, cns_flow_state(f)[i], jump);
            const bool dynamic = is_dynamic(t, i);
            if (dynamic) {
                mag_add(w + k, t->rest, jump);
                k++;
            } else {
                error_at(t, i, tau, t->passive + i);
                mag_add(t->passive + i, t->passive + i, jump);
            }
            for (int j = 0; j < d; j++) {
                t->B[i * d + j] = tangent_at(t, i, j, tau, x);
                if (dynamic)
                    mag_max(dB + j, dB + j, x);
            }
            mag_clear(jump);
        }
        for (int j = 0; j < d; j++)
            mag_add(dB + j, dB + j, t->column + j);
        if (turn(t, dB, w))
            multiply(t);
        else
            code = cns_fail(err, CNS_NUMERIC, "the tangents are not independent any more");
        arb_clear(tau);
    }
    keep_state(t, f);
    t->stepped = !code;
    mag_clear(rest);
    mag_clear(e);
    mag_clear(x);
    mag_clear(g);
    arb_clear(end);
    mags_free(w, d);
    mags_free(dB, d);
    mags_free(start, n);
    return code;
}

cns_code cns_tube_follow(cns_tube *t, const cns_flow *f, cns_error *err)
{
    const cns_jet *J = cns_flow_expansion(f, &t->H);
    if (J == NULL)
        return cns_fail(err, CNS_NUMERIC, "there is no series to bound");
    if (J != t->defect_of) {
        cns_defect_free(t->defect);
        t->defect_of = J;
        t->defect = cns_defect_new(J, err);
        if (t->defect == NULL)
            return err->code;
    }
    cns_error why;
    const cns_code code = follow(t, f, J, &why);
    if (code)
        cns_fail(err, code, "no bound of the error beyond t = %.12g: %s",
                 mpfr_get_d(cns_flow_begin(f), MPFR_RNDN), why.text);
    return code;
}

/* Sets tau to a time within the last step, in units of its length, and t->tau in units of H. */
static void elapsed(cns_tube *t, const cns_flow *f, const mpq_t time, arb_t tau)
{
    const mpfr_prec_t prec = cns_flow_prec(f);
    mpfr_set_prec(t->x, 4 * prec + 8 * TIME_BITS);
    mpfr_set_q(t->x, time, MPFR_RNDN);
    mpfr_sub(t->x, t->x, cns_flow_begin(f), MPFR_RNDN);
    if (mpfr_sgn(t->x) < 0)
        mpfr_set_zero(t->x, 1);
    set_tau(t, t->x, prec);
    mpfr_div_d(t->x, t->x, t->length, MPFR_RNDN);
    arb_set_interval_mpfr(tau, t->x, t->x, BOX_BITS);
}

void cns_tube_at(cns_tube *t, const cns_flow *f, const mpq_t time, const mpfr_t *x, mag_ptr error)
{
    const mpfr_prec_t prec = cns_flow_prec(f);
    if (!t->stepped) { /* Q is the identity */
        for (int i = 0, k = 0; i < t->n; i++) {
            mag_srcptr at_start = is_dynamic(t, i) ? t->r + k++ : t->passive + i;
            mag_t more;
            mag_init(more);
            distance(more, x[i], cns_flow_state(f)[i]);
            mag_add(error + i, at_start, more);
            mag_clear(more);
        }
        return;
    }
    arb_t tau;
    mag_t jump;
    arb_init(tau);
    mag_init(jump);
    elapsed(t, f, time, tau);
    mpfr_set_prec(t->y, 2 * prec + 4 * TIME_BITS);
    for (int i = 0; i < t->n; i++) {
        evaluation_error(t, t->defect_of, i, x[i], jump);
        error_at(t, i, tau, error + i);
        mag_add(error + i, error + i, jump);
    }
    arb_clear(tau);
    mag_clear(jump);
}

double cns_tube_growth(cns_tube *t, const cns_flow *f, const mpq_t time)
{
    const int d = t->d;
    if (!t->stepped || d == 0)
        return 0;
    arb_t tau;
    mag_t ignored;
    arb_init(tau);
    mag_init(ignored);
    elapsed(t, f, time, tau);
    for (int k = 0; k < d; k++)
        for (int j = 0; j < d; j++)
            t->Q1[k * d + j] = tangent_at(t, t->index[k], j, tau, ignored);
    for (int k = 0; k < d; k++)
        for (int j = 0; j < d; j++) {
            t->R[k * d + j] = 0;
            for (int l = 0; l < d; l++)
                t->R[k * d + j] += t->Q1[k * d + l] * t->before[l * d + j];
        }
    const double norm = cns_spectral_norm(t->R, d, t->Q1);
    arb_clear(tau);
    mag_clear(ignored);
    return norm > 0 ? cns_log10_2exp(norm, t->before_e) : -HUGE_VAL;
}
