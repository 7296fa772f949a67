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
    WIDEST_LOG2 = -6, /* of a tube: states are of order one in their units */
    MOST_BOXES = 128,
    MOST_SEGMENTS = 32, /* a power of two */
    TIME_BITS = 64,     /* more than the states', for times within a step */
    BOX_BITS = 53
};

/* ln K, K being the most by which an error can grow within a segment: up to this, boxes are fine enough, and
 * up to that, segments short enough. What K multiplies is lost once, and what of the tangents it multiplies
 * is small. */
#define FINE_GROWTH  3.0
#define SHORT_GROWTH 4.0

/* A part of a step, with tangents of its own. Most steps are one segment; near a fixed point steps are so
 * long that K, exp of the length times a norm, would leave nothing of any bound. Times within it are in units
 * of the step. */
typedef struct segment {
    cns_defect *tangents; /* their polynomials, from Q */
    double begin, part;
    mag_ptr r, passive;             /* at its beginning: d; n, the errors of passive states */
    mag_ptr column, passive_column; /* d: of D; n x d: of the passive rows */
    mag_t rest;                     /* K (G + |p(0) - s|) */
    mag_ptr lost;                   /* n: what a passive state may lose within it beside V r */
    double *before;                 /* d x d: the product of all R before it, times 2^before_e */
    long before_e;
} segment;

struct cns_tube {
    const cns_program *p;
    int n, d;
    int *index; /* the dynamic states, here all that a derivative depends on */
    cns_program *tangents;
    cns_jet *jet;       /* of the tangents, in double */
    cns_defect *defect; /* of the run's jet, which may be another one from step to step */
    const cns_jet *defect_of;
    double *Q;       /* d x d, row-major */
    mag_ptr r;       /* d: |r_j| */
    mag_ptr passive; /* n: the errors of passive states */
    mpfr_t *state;   /* n: the run's state at the end of the last step, which these are about */
    double *product; /* d x d: of all R, times 2^product_e */
    long product_e;

    /* Of the last step. */
    double H, length;
    bool stepped;
    segment segment[MOST_SEGMENTS];
    int segments;

    double first_log_K; /* of the whole step within its first tube, with the passive rows in rows + n; < 0:
                           none */
    mag_t K;
    mpfr_t tau, x, y;   /* scratch, as all that follows */
    double *B, *R, *Q1; /* n x d; d x d */
    double *row, *rows; /* 2 d; 2 n */
    arb_ptr box, slope; /* states of the tangent program, and their derivatives */
};

static mag_ptr mags(int n)
{
    return _mag_vec_init(n + 1);
}

static void mags_free(mag_ptr m, int n)
{
    if (m != NULL)
        _mag_vec_clear(m, n + 1);
}

static void mags_set(mag_ptr to, mag_srcptr from, int n)
{
    for (int i = 0; i < n; i++)
        mag_set(to + i, from + i);
}

static bool segment_init(cns_tube *t, segment *s, cns_error *err)
{
    if (s->tangents != NULL)
        return true;
    s->before = calloc((size_t)t->d * (size_t)t->d + 1, sizeof *s->before);
    if (s->before == NULL) {
        cns_out_of_memory(err);
        return false;
    }
    mag_init(s->rest);
    s->r = mags(t->d);
    s->column = mags(t->d);
    s->passive = mags(t->n);
    s->lost = mags(t->n);
    s->passive_column = mags(t->n * t->d);
    s->tangents = cns_defect_new(t->jet, err);
    return s->tangents != NULL;
}

static void segment_clear(const cns_tube *t, segment *s)
{
    if (s->before == NULL)
        return;
    cns_defect_free(s->tangents);
    mag_clear(s->rest);
    mags_free(s->r, t->d);
    mags_free(s->column, t->d);
    mags_free(s->passive, t->n);
    mags_free(s->lost, t->n);
    mags_free(s->passive_column, t->n * t->d);
    free(s->before);
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
    mpfr_inits2(MPFR_PREC_MIN, t->tau, t->x, t->y, (mpfr_ptr)0);
    t->index = calloc((size_t)t->n + 1, sizeof *t->index);
    t->state = cns_vector_new(t->n, prec);
    if (t->index != NULL)
        t->d = cns_states_in_derivatives(p, t->index);
    const size_t d = (size_t)t->d, n = (size_t)t->n;
    t->Q = calloc(4 * d * d + n * d + 2 * d + 2 * n + 1, sizeof *t->Q);
    t->r = mags(t->d);
    t->passive = mags(t->n);
    if (t->index == NULL || t->state == NULL || t->Q == NULL) {
        cns_out_of_memory(err);
        cns_tube_free(t);
        return NULL;
    }
    t->product = t->Q + d * d;
    t->R = t->Q + 2 * d * d;
    t->Q1 = t->Q + 3 * d * d;
    t->B = t->Q + 4 * d * d;
    t->row = t->B + n * d;
    t->rows = t->row + 2 * d;
    t->box = _arb_vec_init(t->n * (t->d + 1) + 1);
    t->slope = _arb_vec_init(t->n * (t->d + 1) + 1);
    if (!cns_whole_tangent_program(p, t->d, &t->tangents, err)) {
        const cns_jet_spec spec = {.program = t->tangents,
                                   .ops = &cns_arith_double,
                                   .order = TANGENT_ORDER,
                                   .prec = 53,
                                   .sharp_prec = prec};
        t->jet = cns_jet_new(&spec, err);
    }
    if (t->jet == NULL || !segment_init(t, &t->segment[0], err)) {
        cns_tube_free(t);
        return NULL;
    }
    return t;
}

void cns_tube_free(cns_tube *t)
{
    if (t == NULL)
        return;
    for (int k = 0; k < MOST_SEGMENTS; k++)
        segment_clear(t, &t->segment[k]);
    cns_defect_free(t->defect);
    cns_jet_free(t->jet);
    cns_program_free(t->tangents);
    mags_free(t->r, t->d);
    mags_free(t->passive, t->n);
    cns_vector_free(t->state);
    if (t->box != NULL)
        _arb_vec_clear(t->box, t->n * (t->d + 1) + 1);
    if (t->slope != NULL)
        _arb_vec_clear(t->slope, t->n * (t->d + 1) + 1);
    mag_clear(t->K);
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

/* The polynomials of the run and of the tangents' copy of it differ: e0 + e1 s^N of state i, and the tube. */
static void widen(const cns_tube *t, const segment *s, int i, const mag_t tube)
{
    double c[TANGENT_ORDER + 1];
    long c_e, b_e;
    mag_t e0, e1, x;
    mag_init(e0);
    mag_init(e1);
    mag_init(x);
    cns_defect_shifted(t->defect, i, s->begin, s->part, c, TANGENT_ORDER, &c_e, e0, e1);
    mag_add(e0, e0, tube);
    double sum = 0;
    for (int k = 0; k <= TANGENT_ORDER; k++) {
        const double b = cns_defect_coefficient(s->tangents, i, k, &b_e);
        const long shift = b_e - c_e;
        if (shift > 900) { /* c is nothing beside it */
            mag_set_d(x, fabs(b));
            mag_mul_2exp_si(x, x, b_e);
            mag_add(e0, e0, x);
            sum += fabs(c[k]);
        } else {
            const double moved = shift < -900 ? copysign(1e-270, b) : ldexp(b, (int)shift);
            sum += fabs(moved - c[k]) + ldexp(fabs(moved), -51) * (3 * k + 4);
        }
    }
    mag_set_d(x, sum * (1 + 0x1p-40) + 1e-300);
    mag_mul_2exp_si(x, x, c_e);
    mag_add(e0, e0, x);
    cns_defect_widen(s->tangents, i, e0, e1);
    mag_clear(e0);
    mag_clear(e1);
    mag_clear(x);
}

/* The tangents of a segment from Q. */
static cns_code expand_tangents(cns_tube *t, segment *s, const cns_jet *J, cns_error *err)
{
    const int n = t->n, d = t->d;
    const double length = t->length * s->part;
    arb_t begin, x;
    arb_init(begin);
    arb_init(x);
    arb_set_d(begin, s->begin);
    mpfr_set_prec(t->x, 53);
    cns_code code = CNS_OK;
    bool agree = false;
    for (int attempt = 0; attempt < 2 && !code && !agree; attempt++) {
        cns_jet_begin(t->jet, length);
        for (int i = 0; i < n; i++) {
            if (s->begin == 0) {
                cns_jet_coefficient(J, t->x, i, 0);
            } else {
                cns_defect_value(x, t->defect, i, begin);
                arf_get_mpfr(t->x, arb_midref(x), MPFR_RNDN);
            }
            cns_jet_set_state(t->jet, i, t->x);
            mpfr_set_zero(t->x, 1);
            for (int j = 0; j < d; j++)
                cns_jet_set_state(t->jet, n * (1 + j) + i, t->x);
        }
        for (int j = 0; j < d; j++)
            for (int k = 0; k < d; k++) {
                mpfr_set_d(t->x, t->Q[k * d + j], MPFR_RNDN);
                cns_jet_set_state(t->jet, n * (1 + j) + t->index[k], t->x);
            }
        for (int w = 0; w < cns_jet_watched(t->jet) && attempt > 0; w++)
            cns_jet_set_zero(t->jet, w); /* in double it is not zero, but of no sign either */
        code = cns_jet_expand(t->jet, TANGENT_ORDER, err);
        agree = !code && cns_jet_signs_agree(t->jet, J);
    }
    if (!code && !agree)
        code = cns_fail(err, CNS_NUMERIC, "the tangents see another sign under an abs()");
    if (!code)
        code = cns_defect_read(s->tangents, length, length, err);
    arb_clear(begin);
    arb_clear(x);
    return code;
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

/* ln K: an error within the tube grows by no more than K over a part of the step, by the integral of the
 * positive part of the logarithmic norm, box by box. passive: the largest row sums of passive states.
 * HUGE_VAL: no bound. */
static double growth_within(cns_tube *t, double begin, double part, const mag_t tube, double *passive)
{
    double best = HUGE_VAL, *rows = t->rows;
    arb_t tau;
    cns_error ignored;
    arb_init(tau);
    for (int k = 0; k < t->n * t->d; k++)
        arb_zero(t->box + t->n + k);
    for (int j = 0; j < t->d; j++)
        arb_one(t->box + t->n * (1 + j) + t->index[j]);
    for (int boxes = 1; boxes <= MOST_BOXES && best > FINE_GROWTH; boxes *= 2) {
        double sum = 0;
        bool is = true;
        for (int i = 0; i < t->n; i++)
            rows[i] = 0;
        for (int b = 0; b < boxes && is; b++) {
            arb_set_d(tau, begin + part * ((b + 0.5) / boxes));
            mag_set_d(arb_radref(tau), part * (0.5 / boxes) * (1 + 0x1p-40) + 0x1p-50);
            for (int i = 0; i < t->n; i++) {
                cns_defect_value(t->box + i, t->defect, i, tau);
                arb_add_error_mag(t->box + i, tube);
            }
            is = !cns_ball_derivatives(t->tangents, t->box, t->slope, BOX_BITS, &ignored);
            if (is)
                sum += fmax(0, box_norm(t, t->slope, rows)) * t->length * part / boxes;
        }
        sum *= 1 + 0x1p-40;
        if (!is || !(sum < best))
            continue;
        const double before = best;
        best = sum;
        for (int i = 0; i < t->n; i++)
            passive[i] = rows[i];
        if (boxes > 4 && best > 0.8 * before)
            break; /* it is what it is */
    }
    arb_clear(tau);
    return best;
}

/* V_ij at a time of the segment, in its units, and how far it may be from that: rounding, and the time's own.
 */
static double tangent_at(const cns_tube *t, const segment *s, int i, int j, const arb_t time, mag_t error)
{
    arb_t y;
    mag_t x;
    arb_init(y);
    mag_init(x);
    cns_defect_value(y, s->tangents, t->n * (1 + j) + i, time);
    const double v = arf_get_d(arb_midref(y), ARF_RND_NEAR);
    mag_set_d(x, ldexp(fabs(v), -52));
    mag_add(error, arb_radref(y), x);
    mag_clear(x);
    arb_clear(y);
    return v;
}

static bool is_dynamic(const cns_tube *t, int i)
{
    return cns_is_in_derivatives(t->p, i);
}

/* The error of state i at a time of the segment, of what the polynomials say: sum_j (|V_ij| + D_ij) r_j and
 * what the tangents do not carry. */
static void error_at(const cns_tube *t, const segment *s, int i, const arb_t time, mag_t error)
{
    const bool dynamic = is_dynamic(t, i);
    mag_t x, y;
    mag_init(x);
    mag_init(y);
    mag_zero(error);
    for (int j = 0; j < t->d; j++) {
        mag_set_d(x, fabs(tangent_at(t, s, i, j, time, y)));
        mag_add(x, x, y);
        mag_add(x, x, dynamic ? s->column + j : s->passive_column + i * t->d + j);
        mag_addmul(error, x, s->r + j);
    }
    if (dynamic) {
        mag_add(error, error, s->rest);
    } else {
        mag_add(error, error, s->passive + i);
        mag_add(error, error, s->lost + i);
    }
    mag_clear(x);
    mag_clear(y);
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
static bool turn(cns_tube *t, mag_srcptr r0, mag_srcptr dB, mag_srcptr w)
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
            mag_addmul(t->r + a, x, r0 + j);
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

/* e: the largest error of a dynamic state, |Q r|, with what is added. */
static void error_at_begin(const cns_tube *t, mag_srcptr added, mag_t e)
{
    mag_t x, sum;
    mag_init(x);
    mag_init(sum);
    mag_zero(e);
    for (int k = 0; k < t->d; k++) {
        mag_zero(sum);
        for (int j = 0; j < t->d; j++) {
            mag_set_d(x, fabs(t->Q[k * t->d + j]));
            mag_addmul(sum, x, t->r + j);
        }
        mag_max(e, e, sum);
    }
    mag_zero(x);
    for (int k = 0; k < t->d; k++)
        mag_max(x, x, added + t->index[k]);
    mag_add(e, e, x);
    mag_clear(x);
    mag_clear(sum);
}

/* A tube about a segment: guessed, and then proven. added: n, what is added to the errors within it, the
 * defect among it; e: the error at its beginning, with that. Sets K, D, and what is lost. */
static cns_code close_tube(cns_tube *t, segment *s, mag_srcptr added, const mag_t e, cns_error *err)
{
    const int n = t->n, d = t->d;
    double *passive = t->rows + n;
    mag_t tube, x, g, most;
    mag_init(tube);
    mag_init(x);
    mag_init(g);
    mag_init(most);
    mag_mul_2exp_si(tube, e, GUESS_LOG2);
    cns_code code = CNS_OK;
    bool closed = false;
    for (int guess = 0; guess < GUESSES && !code && !closed; guess++) {
        if (mag_cmp_2exp_si(tube, WIDEST_LOG2) > 0) {
            code = cns_fail(err, CNS_UNREACHED, "the error's bound has grown to the size of the motion");
            break;
        }
        const double log_K = guess == 0 && t->first_log_K >= 0
                                 ? t->first_log_K
                                 : growth_within(t, s->begin, s->part, tube, passive);
        if (!(log_K < 200)) {
            code = cns_fail(err, CNS_NUMERIC, "the Jacobian is not bounded within the tube");
            break;
        }
        mag_set_d(x, log_K);
        mag_exp(t->K, x);
        mag_mul(most, t->K, e);
        closed = mag_cmp(most, tube) < 0 || (mag_is_zero(most) && mag_is_zero(tube));
        if (!closed)
            mag_mul_2exp_si(tube, most, 2);
    }
    if (!code && !closed)
        code = cns_fail(err, CNS_NUMERIC, "no tube about the trajectory was found");
    for (int i = 0; i < n && !code; i++)
        widen(t, s, i, tube);
    if (!code) {
        cns_defect_set_overshoot(s->tangents, cns_defect_overshoot(t->defect));
        code = cns_defect_bound(s->tangents, err);
    }
    mag_zero(x);
    for (int k = 0; k < d; k++)
        mag_max(x, x, added + t->index[k]);
    mag_mul(s->rest, t->K, x);
    for (int j = 0; j < d && !code; j++) {
        mag_zero(x);
        for (int k = 0; k < d; k++) {
            cns_defect_of(g, s->tangents, n * (1 + j) + t->index[k]);
            mag_max(x, x, g);
        }
        mag_mul(s->column + j, x, t->K);
        for (int i = 0; i < n; i++) {
            if (is_dynamic(t, i))
                continue;
            cns_defect_of(g, s->tangents, n * (1 + j) + i);
            mag_set_d(x, passive[i] * t->length * s->part);
            mag_addmul(g, x, s->column + j);
            mag_set(s->passive_column + i * d + j, g);
        }
    }
    for (int i = 0; i < n && !code; i++) { /* of the part that the tangents do not carry */
        mag_set_d(x, passive[i] * t->length * s->part);
        mag_mul(s->lost + i, x, s->rest);
        mag_add(s->lost + i, s->lost + i, added + i);
    }
    mag_clear(tube);
    mag_clear(x);
    mag_clear(g);
    mag_clear(most);
    return code;
}

/* A segment: its tangents and its tube, and Q, r and the errors of passive states at its end, `end` being
 * that in its units. jump: n, what is added there; NULL: nothing. */
static cns_code pass_segment(cns_tube *t, segment *s, const cns_jet *J, mag_srcptr added, const arb_t end,
                             mag_srcptr jump, cns_error *err)
{
    const int n = t->n, d = t->d;
    mag_ptr w = mags(d), dB = mags(d);
    mag_t e, x;
    mag_init(e);
    mag_init(x);
    error_at_begin(t, added, e);
    mags_set(s->r, t->r, d);
    mags_set(s->passive, t->passive, n);
    memcpy(s->before, t->product, (size_t)d * (size_t)d * sizeof *s->before);
    s->before_e = t->product_e;
    cns_code code = expand_tangents(t, s, J, err);
    if (!code)
        code = close_tube(t, s, added, e, err);
    for (int i = 0, k = 0; i < n && !code; i++) {
        const bool dynamic = is_dynamic(t, i);
        for (int j = 0; j < d; j++) {
            t->B[i * d + j] = tangent_at(t, s, i, j, end, x);
            if (dynamic)
                mag_max(dB + j, dB + j, x);
        }
        if (!dynamic) {
            error_at(t, s, i, end, t->passive + i);
            if (jump != NULL)
                mag_add(t->passive + i, t->passive + i, jump + i);
            continue;
        }
        mag_set(w + k, s->rest);
        if (jump != NULL)
            mag_add(w + k, w + k, jump + i);
        k++;
    }
    for (int j = 0; j < d && !code; j++)
        mag_add(dB + j, dB + j, s->column + j);
    if (!code && !turn(t, s->r, dB, w))
        code = cns_fail(err, CNS_NUMERIC, "the tangents are not independent any more");
    if (!code)
        multiply(t);
    mag_clear(e);
    mag_clear(x);
    mags_free(w, d);
    mags_free(dB, d);
    return code;
}

/* Into how many segments a step is cut: such that within none an error may grow by much. A power of two, so
 * that their ends and lengths are exact. e: as for close_tube(). */
static int how_many_segments(cns_tube *t, const mag_t e)
{
    mag_t tube;
    mag_init(tube);
    mag_mul_2exp_si(tube, e, GUESS_LOG2);
    const double log_K = growth_within(t, 0, 1, tube, t->rows + t->n);
    mag_clear(tube);
    t->first_log_K = log_K <= SHORT_GROWTH ? log_K : -1;
    if (log_K <= SHORT_GROWTH)
        return 1;
    int segments = 2;
    while (segments < MOST_SEGMENTS && segments * SHORT_GROWTH < 2 * log_K)
        segments *= 2;
    return segments;
}

static cns_code follow(cns_tube *t, const cns_flow *f, const cns_jet *J, cns_error *err)
{
    const int n = t->n;
    const mpfr_prec_t prec = cns_flow_prec(f);
    mag_ptr added = mags(n), jump = mags(n);
    mag_t x;
    arb_t end;
    mag_init(x);
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
    /* The end in units of the length: 1, or a little less, as that was rounded up. */
    mpfr_div_d(t->x, t->x, t->length, MPFR_RNDN);
    arb_set_interval_mpfr(end, t->x, t->x, BOX_BITS);

    mpfr_set_prec(t->y, 2 * prec + 4 * TIME_BITS);
    for (int i = 0; i < n && !code; i++)
        evaluation_error(t, J, i, cns_flow_state(f)[i], jump + i);
    mpfr_set_prec(t->x, 2 * prec + 4 * TIME_BITS);
    for (int i = 0; i < n && !code; i++) {
        cns_jet_coefficient(J, t->x, i, 0);
        distance(added + i, t->x, t->state[i]);
        cns_defect_of(x, t->defect, i);
        mag_add(added + i, added + i, x);
    }
    error_at_begin(t, added, x);
    t->segments = code ? 0 : how_many_segments(t, x);
    for (int k = 0; k < t->segments && !code; k++) {
        segment *s = &t->segment[k];
        const bool last = k == t->segments - 1;
        if (!segment_init(t, s, err)) {
            code = err->code;
            break;
        }
        s->part = 1.0 / t->segments;
        s->begin = k * s->part;
        if (last) { /* (end - begin) / part */
            arb_t begin;
            arb_init(begin);
            arb_set_d(begin, s->begin);
            arb_sub(end, end, begin, BOX_BITS);
            arb_set_d(begin, s->part);
            arb_div(end, end, begin, BOX_BITS);
            arb_clear(begin);
        }
        arb_t whole;
        arb_init(whole);
        arb_one(whole);
        code = pass_segment(t, s, J, added, last ? end : whole, last ? jump : NULL, err);
        arb_clear(whole);
    }
    keep_state(t, f);
    t->stepped = !code;
    mag_clear(x);
    arb_clear(end);
    mags_free(added, n);
    mags_free(jump, n);
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
                 cns_program_time(t->p, mpfr_get_d(cns_flow_begin(f), MPFR_RNDN)), why.text);
    return code;
}

/* The segment of a time within the last step, `time` in its units; t->tau in units of H. */
static const segment *elapsed(cns_tube *t, const cns_flow *f, const mpq_t at, arb_t time)
{
    const mpfr_prec_t prec = cns_flow_prec(f);
    mpfr_set_prec(t->x, 4 * prec + 8 * TIME_BITS);
    mpfr_set_q(t->x, at, MPFR_RNDN);
    mpfr_sub(t->x, t->x, cns_flow_begin(f), MPFR_RNDN);
    if (mpfr_sgn(t->x) < 0)
        mpfr_set_zero(t->x, 1);
    set_tau(t, t->x, prec);
    mpfr_div_d(t->x, t->x, t->length, MPFR_RNDN);
    int k = (int)floor(mpfr_get_d(t->x, MPFR_RNDN) * t->segments);
    k = k < 0 ? 0 : k < t->segments ? k : t->segments - 1;
    const segment *s = &t->segment[k];
    mpfr_sub_d(t->x, t->x, s->begin, MPFR_RNDN);
    mpfr_div_d(t->x, t->x, s->part, MPFR_RNDN);
    arb_set_interval_mpfr(time, t->x, t->x, BOX_BITS);
    return s;
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
    arb_t within;
    mag_t jump;
    arb_init(within);
    mag_init(jump);
    const segment *s = elapsed(t, f, time, within);
    mpfr_set_prec(t->y, 2 * prec + 4 * TIME_BITS);
    for (int i = 0; i < t->n; i++) {
        evaluation_error(t, t->defect_of, i, x[i], jump);
        error_at(t, s, i, within, error + i);
        mag_add(error + i, error + i, jump);
    }
    arb_clear(within);
    mag_clear(jump);
}

double cns_tube_growth(cns_tube *t, const cns_flow *f, const mpq_t time)
{
    const int d = t->d;
    if (!t->stepped || d == 0)
        return 0;
    arb_t within;
    mag_t ignored;
    arb_init(within);
    mag_init(ignored);
    const segment *s = elapsed(t, f, time, within);
    for (int k = 0; k < d; k++)
        for (int j = 0; j < d; j++)
            t->Q1[k * d + j] = tangent_at(t, s, t->index[k], j, within, ignored);
    for (int k = 0; k < d; k++)
        for (int j = 0; j < d; j++) {
            t->R[k * d + j] = 0;
            for (int l = 0; l < d; l++)
                t->R[k * d + j] += t->Q1[k * d + l] * s->before[l * d + j];
            if (!cns_program_is_dynamic(t->p, t->index[k]) || !cns_program_is_dynamic(t->p, t->index[j]))
                t->R[k * d + j] = 0; /* what does not feed back has no growth of its own */
        }
    const double norm = cns_spectral_norm(t->R, d, t->Q1);
    arb_clear(within);
    mag_clear(ignored);
    return norm > 0 ? cns_log10_2exp(norm, s->before_e) : -HUGE_VAL;
}
