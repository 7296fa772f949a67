#include "growth.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "method.h"
#include "num/logs.h"
#include "taylor/jet.h"
#include "taylor/tangent.h"

enum { ORDER = 20, TIME_PREC = 64 };

/* A segment is one Taylor expansion of states and tangents, the tangents starting as the identity. */
struct cns_growth {
    int n, d;
    int *index;    /* the dynamic states */
    double *scale; /* of the dynamic states */
    cns_program *program;
    cns_jet *jet;
    mpfr_t base, x, y; /* where the segment begins; scratch */
    double *state;     /* there */
    double unit;       /* its unit of time: tau = (t - base) / unit */
    double reach;      /* how far it is good for, in that unit */
    bool expanded;
    double *m, *product;             /* d x d, row-major, scratch */
    double *phi, *c;                 /* at the base */
    double *row_phi, *row_c, *row_m; /* the same, and the tangents from the base, at the last row */
    double *origin;                  /* d x d each: the propagators from the origins to the base */
    long origin_e[CNS_GROWTH_ORIGINS];
    double origin_time[CNS_GROWTH_ORIGINS];
    int origins;
    long phi_e, c_e; /* their exponents: the matrix is phi 2^phi_e */
    bool landed;     /* the flow's last step ended on a kink */
    double pending;  /* noise of steps since the base: log2 of the sum of squares, -HUGE_VAL: none */
};

cns_growth *cns_growth_new(const cns_program *p, const double *scales, cns_error *err)
{
    cns_growth *g = calloc(1, sizeof *g);
    if (!g) {
        cns_out_of_memory(err);
        return NULL;
    }
    g->n = cns_program_states(p);
    g->index = malloc(((size_t)g->n + 1) * sizeof *g->index);
    g->scale = malloc(((size_t)g->n + 1) * sizeof *g->scale);
    mpfr_inits2(TIME_PREC, g->x, g->y, (mpfr_ptr)0);
    mpfr_init2(g->base, TIME_PREC);
    if (!g->index || !g->scale) {
        cns_out_of_memory(err);
        cns_growth_free(g);
        return NULL;
    }
    g->d = cns_dynamic_states(p, g->index);
    for (int i = 0; i < g->d; i++)
        g->scale[i] = scales[g->index[i]];
    if (g->d == 0)
        return g;
    size_t square = (size_t)g->d * (size_t)g->d;
    g->state = calloc((size_t)g->d, sizeof *g->state);
    g->m = calloc(7 * square, sizeof *g->m);
    if (!g->state || !g->m) {
        cns_out_of_memory(err);
        cns_growth_free(g);
        return NULL;
    }
    g->product = g->m + square;
    g->phi = g->m + 2 * square;
    g->c = g->m + 3 * square;
    g->row_phi = g->m + 4 * square;
    g->row_c = g->m + 5 * square;
    g->row_m = g->m + 6 * square;
    if (cns_tangent_program(p, g->d, &g->program, err)) {
        cns_growth_free(g);
        return NULL;
    }
    cns_jet_spec spec = {.program = g->program, .ops = &cns_arith_double, .order = ORDER, .prec = 53};
    g->jet = cns_jet_new(&spec, err);
    if (!g->jet) {
        cns_growth_free(g);
        return NULL;
    }
    return g;
}

void cns_growth_free(cns_growth *g)
{
    if (!g)
        return;
    cns_jet_free(g->jet);
    cns_program_free(g->program);
    mpfr_clears(g->base, g->x, g->y, (mpfr_ptr)0);
    free(g->index);
    free(g->scale);
    free(g->state);
    free(g->m);
    free(g->origin);
    free(g);
}

void cns_growth_start(cns_growth *g)
{
    size_t square = (size_t)g->d * (size_t)g->d;
    g->expanded = g->landed = false;
    g->phi_e = g->c_e = 0;
    g->origins = 0;
    g->pending = -HUGE_VAL;
    if (g->d == 0)
        return;
    memset(g->phi, 0, square * sizeof *g->phi);
    memset(g->c, 0, square * sizeof *g->c);
    for (int i = 0; i < g->d; i++)
        g->phi[i * g->d + i] = 1;
}

/* Brings the largest entry to [0.5, 1) and moves the rest into the exponent. */
static void normalise(double *a, int count, long *e)
{
    double largest = 0;
    int shift;
    for (int i = 0; i < count; i++)
        largest = fmax(largest, fabs(a[i]));
    if (largest == 0 || !isfinite(largest))
        return;
    frexp(largest, &shift);
    for (int i = 0; i < count; i++)
        a[i] = ldexp(a[i], -shift);
    *e += shift;
}

/* out = a b, d x d. */
static void multiply(double *out, const double *a, const double *b, int d)
{
    for (int i = 0; i < d; i++)
        for (int j = 0; j < d; j++) {
            double s = 0;
            for (int k = 0; k < d; k++)
                s += a[i * d + k] * b[k * d + j];
            out[i * d + j] = s;
        }
}

/* Adds q^2 on the diagonal of C, log2 of q^2 given. */
static void inject(double *c, long *c_e, int d, double q2_log2)
{
    double largest = 0;
    if (q2_log2 == -HUGE_VAL)
        return;
    for (int i = 0; i < d * d; i++)
        largest = fmax(largest, fabs(c[i]));
    if (largest == 0)
        *c_e = (long)floor(q2_log2);
    long e;
    double m = cns_exp2_2exp(q2_log2, &e);
    long relative = e - *c_e;
    if (relative > 900) { /* the new noise dwarfs the old */
        for (int i = 0; i < d * d; i++)
            c[i] = 0;
        *c_e = e;
        relative = 0;
    }
    if (relative > -900)
        for (int i = 0; i < d; i++)
            c[i * d + i] += ldexp(m, (int)relative);
    normalise(c, d * d, c_e);
}

/* M = the tangents at tau units after the base, in scaled variables; states there into `state` if wanted. */
static void propagate(cns_growth *g, double tau, double *m, double *state)
{
    const cns_arith_ops *ops = cns_jet_ops(g->jet);
    const cns_arith *A = cns_jet_arith(g->jet);
    int d = g->d, order = cns_jet_order(g->jet);
    for (int column = state ? -1 : 0; column < d; column++)
        for (int i = 0; i < d; i++) {
            int s = cns_jet_state_series(g->jet, (column + 1) * d + i);
            double y = 0;
            for (int k = order; k >= 0; k--) {
                long e;
                double c = ops->get_2exp(A, &e, s, k);
                y = y * tau + ldexp(c, (int)e);
            }
            if (column < 0)
                state[i] = y;
            else
                m[i * d + column] = y * g->scale[column] / g->scale[i];
        }
}

/* Phi and C at tau after the base, into phi and c (which may be the growth's own, g->phi and g->c). */
static void transport(cns_growth *g, double tau, double *phi, long *phi_e, double *c, long *c_e,
                      double *state)
{
    int d = g->d;
    double *m = g->m, *t = g->product;
    propagate(g, tau, m, state);
    multiply(t, m, g->phi, d);
    memcpy(phi, t, (size_t)(d * d) * sizeof *t);
    *phi_e = g->phi_e;
    normalise(phi, d * d, phi_e);
    *c_e = g->c_e;
    multiply(t, m, g->c, d);
    for (int i = 0; i < d; i++)
        for (int j = 0; j <= i; j++) {
            double s = 0;
            for (int k = 0; k < d; k++)
                s += t[i * d + k] * m[j * d + k];
            /* c may be g->c, whose entries are no longer needed: t holds M C. */
            c[i * d + j] = c[j * d + i] = s;
        }
    normalise(c, d * d, c_e);
    inject(c, c_e, d, g->pending);
}

/* Moves the base itself by tau units: everything kept there is transported. */
static void move_base(cns_growth *g, double tau, double *state)
{
    transport(g, tau, g->phi, &g->phi_e, g->c, &g->c_e, state);
    const size_t square = (size_t)g->d * (size_t)g->d;
    for (int i = 0; i < g->origins; i++) { /* g->m is still the tangents at tau */
        double *phi = g->origin + (size_t)i * square;
        multiply(g->product, g->m, phi, g->d);
        memcpy(phi, g->product, square * sizeof *phi);
        normalise(phi, g->d * g->d, &g->origin_e[i]);
    }
    g->pending = -HUGE_VAL;
}

cns_code cns_growth_mark(cns_growth *g, cns_error *err)
{
    const size_t square = (size_t)g->d * (size_t)g->d;
    if (!g->origin)
        g->origin = calloc(square * CNS_GROWTH_ORIGINS + 1, sizeof *g->origin);
    if (!g->origin)
        return cns_out_of_memory(err);
    if (g->origins == CNS_GROWTH_ORIGINS || !g->expanded)
        return CNS_OK;
    double *phi = g->origin + (size_t)g->origins * square;
    memset(phi, 0, square * sizeof *phi);
    for (int i = 0; i < g->d; i++)
        phi[i * g->d + i] = 1;
    g->origin_time[g->origins] = mpfr_get_d(g->base, MPFR_RNDN);
    g->origin_e[g->origins++] = 0;
    return CNS_OK;
}

double cns_growth_origin(const cns_growth *g, int origin)
{
    return g->origin_time[origin];
}

int cns_growth_marks(const cns_growth *g)
{
    return g->origins;
}

double cns_growth_since(cns_growth *g, int origin)
{
    const double *phi = g->origin + (size_t)origin * (size_t)g->d * (size_t)g->d;
    double sum = 0;
    multiply(g->product, g->row_m, phi, g->d);
    for (int i = 0; i < g->d * g->d; i++)
        sum += g->product[i] * g->product[i];
    return sum > 0 ? 0.5 * cns_log10_2exp(sum, 2 * g->origin_e[origin]) : -HUGE_VAL;
}

static bool expand(cns_growth *g, double length, cns_error *err)
{
    int d = g->d;
    g->unit = length > 0 ? length : 1;
    cns_jet_begin(g->jet, g->unit);
    for (int i = 0; i < d; i++) {
        mpfr_set_d(g->x, g->state[i], MPFR_RNDN);
        cns_jet_set_state(g->jet, i, g->x);
        for (int j = 0; j < d; j++) {
            mpfr_set_d(g->x, i == j, MPFR_RNDN);
            cns_jet_set_state(g->jet, (j + 1) * d + i, g->x);
        }
    }
    if (cns_jet_expand(g->jet, ORDER, err))
        return false;
    /* The reach: where the last four coefficients stay below 1e-8 of the scales, or of the growth. */
    int order = cns_jet_order(g->jet);
    double worst = g->unit < 1e-12 ? 3 : 50; /* below, coefficients may underflow, and tell nothing */
    for (int k = order - 3; k <= order; k++)
        for (int i = 0; i < d * (d + 1); i++) {
            long e;
            double m = fabs(cns_jet_coefficient_2exp(g->jet, &e, i, k));
            if (!isfinite(m)) {
                cns_fail(err, CNS_NUMERIC, "tangents are out of range");
                return false;
            }
            if (m > 0 && k > 0)
                worst = fmin(worst, (-27 - cns_log2_2exp(m, e)) / k);
        }
    long e;
    double m = cns_exp2_2exp(worst, &e);
    g->reach = ldexp(m, (int)e);
    g->expanded = true;
    return true;
}

static double since_base(cns_growth *g, mpfr_srcptr t)
{
    mpfr_t difference;
    mpfr_init2(difference, TIME_PREC);
    mpfr_sub(difference, t, g->base, MPFR_RNDN);
    double elapsed = mpfr_get_d(difference, MPFR_RNDN);
    mpfr_clear(difference);
    return elapsed;
}

/* Moves the base forward until t is within reach of the segment; *tau is then its time from the base. */
static cns_code bring_within_reach(cns_growth *g, mpfr_srcptr t, double *tau, cns_error *err)
{
    double rest = since_base(g, t);
    while (rest / g->unit > g->reach * 1.0000001) {
        double step = g->reach * g->unit;
        move_base(g, g->reach, g->state);
        mpfr_set_d(g->x, step, MPFR_RNDN);
        mpfr_add(g->base, g->base, g->x, MPFR_RNDN);
        rest -= step;
        if (!expand(g, rest, err))
            return err->code;
        if (g->reach < 1e-9)
            return cns_fail(err, CNS_NUMERIC, "tangents: the step underflows");
    }
    *tau = rest / g->unit;
    return CNS_OK;
}

static double add_log2(double a, double b)
{
    double big = fmax(a, b), small = fmin(a, b);
    long e;
    if (small - big < -60 || small == -HUGE_VAL)
        return big;
    double m = cns_exp2_2exp(small - big, &e);
    return big + cns_log2_2exp(1 + ldexp(m, (int)e), 0);
}

cns_code cns_growth_follow(cns_growth *g, cns_flow *f, double noise_log2, cns_error *err)
{
    if (g->d == 0)
        return CNS_OK;
    mpfr_srcptr t0 = cns_flow_begin(f), t1 = cns_flow_end(f);
    double tau = 0;
    /* Small steps share a segment; a landing ends it, because a sign has changed there. */
    if (!g->expanded || since_base(g, t1) > g->reach * g->unit || g->landed) {
        if (g->expanded) {
            cns_code code = bring_within_reach(g, t0, &tau, err);
            if (code)
                return code;
            move_base(g, tau, NULL);
        }
        mpfr_set_prec(g->base, mpfr_get_prec(t0));
        mpfr_set(g->base, t0, MPFR_RNDN);
        for (int i = 0; i < g->d; i++)
            g->state[i] = mpfr_get_d(cns_flow_begin_state(f)[g->index[i]], MPFR_RNDN);
        if (!expand(g, since_base(g, t1), err))
            return err->code;
    }
    g->landed = cns_flow_landed(f);
    g->pending = add_log2(g->pending, 2 * noise_log2);
    return CNS_OK;
}

double cns_growth_free_until(const cns_growth *g)
{
    if (g->d == 0)
        return HUGE_VAL;
    return g->expanded && !g->landed ? mpfr_get_d(g->base, MPFR_RNDN) + g->reach * g->unit * (1 - 1e-12) : 0;
}

void cns_growth_skipped(cns_growth *g, long steps, double noise_log2)
{
    g->pending = add_log2(g->pending, 2 * noise_log2 + cns_log2_2exp((double)steps, 0));
}

double cns_spectral_norm(const double *a, int d, double *scratch)
{
    double *v = scratch, *w = scratch + d, norm = 0;
    for (int i = 0; i < d; i++)
        v[i] = 1 + 0.1 * i;
    for (int turn = 0; turn < 60; turn++) {
        double length = 0;
        for (int i = 0; i < d; i++) {
            w[i] = 0;
            for (int j = 0; j < d; j++)
                w[i] += a[i * d + j] * v[j];
        }
        for (int j = 0; j < d; j++) {
            v[j] = 0;
            for (int i = 0; i < d; i++)
                v[j] += a[i * d + j] * w[i];
            length += v[j] * v[j];
        }
        length = sqrt(length);
        if (length == 0)
            return 0;
        for (int j = 0; j < d; j++)
            v[j] /= length;
        norm = sqrt(length);
    }
    return norm;
}

cns_code cns_growth_at(cns_growth *g, const mpq_t t, double *growth, double *error_log2, cns_error *err)
{
    long phi_e, c_e;
    double tau;
    *growth = 0;
    *error_log2 = -HUGE_VAL;
    if (g->d == 0 || !g->expanded)
        return CNS_OK;
    mpfr_set_prec(g->y, mpfr_get_prec(g->base));
    mpfr_set_q(g->y, t, MPFR_RNDN);
    cns_code code = bring_within_reach(g, g->y, &tau, err);
    if (code)
        return code;
    double *phi = g->row_phi, *c = g->row_c, trace = 0;
    transport(g, tau, phi, &phi_e, c, &c_e, NULL);
    memcpy(g->row_m, g->m, (size_t)(g->d * g->d) * sizeof *g->m);
    double norm = cns_spectral_norm(phi, g->d, g->m);
    for (int i = 0; i < g->d; i++)
        trace += c[i * g->d + i];
    *growth = norm > 0 ? cns_log10_2exp(norm, phi_e) : -HUGE_VAL;
    if (trace > 0)
        *error_log2 = 0.5 * cns_log2_2exp(trace, c_e);
    return CNS_OK;
}
