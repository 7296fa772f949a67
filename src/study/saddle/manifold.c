/* One probe: along the unstable manifold of a saddle, past the next one. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "branch.h"
#include "cns/flow.h"
#include "core/memory.h"
#include "core/monitor.h"
#include "manifold.h"
#include "num/logs.h"
#include "num/vector.h"
#include "solve/proof.h"

enum {
    MAX_IMAGES = 128,
    MORE_WORDS = 2,      /* images under so many symmetries in a row, besides one for each pass */
    EXTRA_BITS = 64,     /* of the fixed point above the branch */
    VARIANT_DIGITS = 16, /* by which the second variant is finer: a limb of the fast arithmetic */
    CROSSING_TURNS = 200,
    NOISE_DIGITS = 5, /* what the way to the next saddle may make of the last digits */
    SLOW_TIMES = 40   /* unstable time constants that a passage may take besides those the digits last */
};

/* In units of eigenvectors whose largest component is one scale of the model. */
static const double near = 1;       /* what counts as having come near a saddle */
static const double leaving = 0.05; /* the coordinate along the unstable direction that counts as leaving */
static const double apart = 1.5;    /* so far away it has to have been from the saddle it began at */

/* The saddle's image under a symmetry: its place, and the coordinates there. */
typedef struct image {
    mpfr_t *x;
    signed char *sign; /* of the symmetry: the Jacobian there is that of the saddle with these signs */
    int turn;          /* 1 or -1: the sign with which the unstable eigenvector is taken */
    bool behind;       /* the motion comes from there, and has not been far away yet */
    bool approached;
} image;

typedef struct probe {
    const cns_system *s;
    cns_system *exact; /* the system without a smoothing that these digits cannot tell from none; else NULL */
    const cns_monitor *monitor;
    cns_reduced reduced;
    cns_fixed_point saddle;
    cns_branch branch;
    cns_flow *flow;
    double *scales; /* of the dynamic states */
    int d, along;
    mpfr_prec_t prec;
    image images[MAX_IMAGES];
    int n_images;
    mpfr_t *row;     /* the left unstable eigenvector, with row p_1 = 1 */
    double *re, *im; /* the other left eigenvectors, d x d, for distances */
    mpfr_t *x, *difference;
} probe;

/* Images. */

static bool same_place(const probe *p, mpfr_t *a, mpfr_t *b)
{
    for (int i = 0; i < p->d; i++)
        if (fabs(mpfr_get_d(a[i], MPFR_RNDN) - mpfr_get_d(b[i], MPFR_RNDN)) > 1e-6 * p->scales[i])
            return false;
    return true;
}

/* Adds the image of `from` under a symmetry, or under its inverse, if the place is new. */
static void add_image(probe *p, const image *from, const cns_model_symmetry *g, bool inverse)
{
    image *to = &p->images[p->n_images];
    mpfr_t shift;
    if (p->n_images == MAX_IMAGES)
        return;
    mpfr_init2(shift, p->prec);
    to->x = cns_vector_xnew(p->d, p->prec);
    to->sign = cns_xalloc((size_t)p->d, 1);
    for (int i = 0; i < p->d; i++) {
        const int state = p->reduced.index[i];
        cns_number number;
        cns_error ignored;
        cns_number_init(&number);
        if (g->shift[state] != NULL)
            cns_number_parse(&number, g->shift[state], &ignored);
        cns_number_get_mpfr(shift, &number);
        cns_number_clear(&number);
        to->sign[i] = (signed char)(from->sign[i] * g->sign[state]);
        mpfr_set(to->x[i], from->x[i], MPFR_RNDN);
        if (inverse)
            mpfr_sub(to->x[i], to->x[i], shift, MPFR_RNDN);
        mpfr_mul_si(to->x[i], to->x[i], g->sign[state], MPFR_RNDN);
        if (!inverse)
            mpfr_add(to->x[i], to->x[i], shift, MPFR_RNDN);
    }
    mpfr_clear(shift);
    to->turn = to->sign[p->along];
    for (int k = 0; k < p->n_images; k++)
        if (same_place(p, p->images[k].x, to->x)) {
            cns_vector_free(to->x);
            free(to->sign);
            *to = (image){0};
            return;
        }
    p->n_images++;
}

static void find_images(probe *p, int words)
{
    image *first = &p->images[0];
    first->x = cns_vector_xnew(p->d, p->prec);
    first->sign = cns_xalloc((size_t)p->d, 1);
    for (int i = 0; i < p->d; i++) {
        mpfr_set(first->x[i], p->branch.p[i], MPFR_RNDN);
        first->sign[i] = 1;
    }
    first->turn = 1;
    first->behind = true;
    p->n_images = 1;
    for (int word = 0, from = 0; word < words; word++)
        for (const int to = p->n_images; from < to; from++)
            for (int k = 0; k < 2 * cns_system_model(p->s)->n_symmetries; k++)
                add_image(p, &p->images[from], &cns_system_model(p->s)->symmetries[k / 2], k % 2 != 0);
}

/* Coordinates. */

/* Rows of the left eigenvectors, such that right eigenvectors with a largest component of one scale have
 * coordinate 1. */
static void find_rows(probe *p)
{
    const int d = p->d;
    acb_t scaled;
    acb_init(scaled);
    p->row = cns_vector_xnew(d, p->prec);
    p->re = cns_xalloc((size_t)(d * d), sizeof *p->re);
    p->im = cns_xalloc((size_t)(d * d), sizeof *p->im);
    for (int k = 0; k < d; k++) {
        double size = 0;
        for (int i = 0; i < d; i++) {
            acb_srcptr v = acb_mat_entry(p->saddle.spectrum.right, i, k);
            size = fmax(size, hypot(arf_get_d(arb_midref(acb_realref(v)), ARF_RND_NEAR),
                                    arf_get_d(arb_midref(acb_imagref(v)), ARF_RND_NEAR)) /
                                  p->scales[i]);
        }
        for (int j = 0; j < d; j++) {
            acb_srcptr l = acb_mat_entry(p->saddle.spectrum.left, k, j);
            p->re[k * d + j] = arf_get_d(arb_midref(acb_realref(l)), ARF_RND_NEAR) * size;
            p->im[k * d + j] = arf_get_d(arb_midref(acb_imagref(l)), ARF_RND_NEAR) * size;
        }
    }
    /* The right eigenvector p_1 is column 0 times p_1[j] / right[j]; the row is divided by that. */
    int largest = 0;
    for (int i = 1; i < d; i++)
        if (mpfr_cmpabs(p->branch.p[d + i], p->branch.p[d + largest]) > 0)
            largest = i;
    acb_t factor;
    acb_init(factor);
    arf_set_mpfr(arb_midref(acb_realref(factor)), p->branch.p[d + largest]);
    acb_div(factor, acb_mat_entry(p->saddle.spectrum.right, largest, 0), factor, (slong)p->prec + EXTRA_BITS);
    for (int j = 0; j < d; j++) {
        acb_mul(scaled, acb_mat_entry(p->saddle.spectrum.left, 0, j), factor, (slong)p->prec + EXTRA_BITS);
        arf_get_mpfr(p->row[j], arb_midref(acb_realref(scaled)), MPFR_RNDN);
    }
    acb_clear(factor);
    acb_clear(scaled);
}

/* u: the coordinate of x along the unstable eigenvector of image m. */
static void unstable_coordinate(probe *p, const image *m, const mpfr_t *x, mpfr_t u)
{
    mpfr_set_zero(u, 1);
    for (int i = 0; i < p->d; i++) {
        mpfr_sub(p->difference[i], x[i], m->x[i], MPFR_RNDN);
        mpfr_mul_si(p->difference[i], p->difference[i], m->sign[i] * m->turn, MPFR_RNDN);
        mpfr_mul(p->difference[i], p->difference[i], p->row[i], MPFR_RNDN);
        mpfr_add(u, u, p->difference[i], MPFR_RNDN);
    }
}

/* *u as above, *others the largest of the other coordinates. */
static void coordinates(const probe *p, const image *m, const mpfr_t *x, double *u, double *others)
{
    *u = *others = 0;
    for (int k = 0; k < p->d; k++) {
        double re = 0, im = 0;
        for (int i = 0; i < p->d; i++) {
            mpfr_sub(p->difference[i], x[i], m->x[i], MPFR_RNDN);
            const double c = mpfr_get_d(p->difference[i], MPFR_RNDN) * m->sign[i];
            re += p->re[k * p->d + i] * c;
            im += p->im[k * p->d + i] * c;
        }
        if (k == 0)
            *u = hypot(re, im);
        else
            *others = fmax(*others, hypot(re, im));
    }
}

/* The moment within the last step at which |u| becomes `leaving`, by the secant method on its logarithm,
 * which is almost linear in time; bisection where that leads out. */
static void find_leaving(probe *p, const image *m, mpfr_t t, mpfr_t u)
{
    const mpfr_prec_t prec = p->prec + EXTRA_BITS;
    mpfr_t low, high, value, before, at_before, step;
    mpq_t exact;
    int turns = CROSSING_TURNS;
    mpq_init(exact);
    mpfr_inits2(prec, low, high, value, before, at_before, step, (mpfr_ptr)0);
    mpfr_set(low, cns_flow_begin(p->flow), MPFR_RNDN);
    mpfr_set(high, cns_flow_end(p->flow), MPFR_RNDN);
    mpfr_set(t, high, MPFR_RNDN);
    unstable_coordinate(p, m, cns_flow_begin_state(p->flow), u);
    if (fabs(mpfr_get_d(u, MPFR_RNDN)) >=
        leaving) { /* it never was nearer: a wide miss, of which the side is what counts */
        unstable_coordinate(p, m, cns_flow_state(p->flow), u);
        turns = 0;
    }
    for (int turn = 0; turn < turns; turn++) {
        mpfr_get_q(exact, t);
        cns_flow_eval(p->flow, exact, p->x);
        unstable_coordinate(p, m, (const mpfr_t *)p->x, u);
        mpfr_abs(value, u, MPFR_RNDN);
        mpfr_div_d(value, value, leaving, MPFR_RNDN);
        mpfr_log(value, value, MPFR_RNDN);
        mpfr_set(mpfr_sgn(value) < 0 ? low : high, t, MPFR_RNDN);
        if (mpfr_zero_p(value) || mpfr_get_exp(value) < 8 - (mpfr_exp_t)p->prec)
            break;
        if (turn == 0) { /* d log|u| / dt = lambda, nearly */
            mpfr_div(step, value, p->branch.lambda, MPFR_RNDN);
        } else {
            mpfr_sub(step, t, before, MPFR_RNDN);
            mpfr_sub(at_before, value, at_before, MPFR_RNDN);
            mpfr_div(step, step, at_before, MPFR_RNDN);
            mpfr_mul(step, step, value, MPFR_RNDN);
        }
        mpfr_set(before, t, MPFR_RNDN);
        mpfr_set(at_before, value, MPFR_RNDN);
        mpfr_sub(t, t, step, MPFR_RNDN);
        if (!mpfr_number_p(t) || mpfr_cmp(t, low) <= 0 || mpfr_cmp(t, high) >= 0) {
            mpfr_add(t, low, high, MPFR_RNDN);
            mpfr_div_2ui(t, t, 1, MPFR_RNDN);
        }
        if (mpfr_equal_p(t, before))
            break;
    }
    mpfr_clears(low, high, value, before, at_before, step, (mpfr_ptr)0);
    mpq_clear(exact);
}

static cns_code too_near(long digits, cns_error *err)
{
    return cns_fail(err, CNS_UNREACHED,
                    "the next saddle is passed so near that %ld digits do not tell on which side", digits);
}

/* miss = u e^(-lambda t) / s: what the coordinate was at s = 1, had it always grown like this. */
static void finish(probe *p, const image *m, bool first, cns_passage *result)
{
    mpfr_t t, u, factor;
    mpfr_inits2(p->prec + EXTRA_BITS, t, u, factor, (mpfr_ptr)0);
    find_leaving(p, m, t, u);
    result->side = mpfr_sgn(u) < 0 ? -1 : 1;
    if (first) {
        mpfr_mul(factor, t, p->branch.lambda, MPFR_RNDN);
        mpfr_neg(factor, factor, MPFR_RNDN);
        mpfr_exp(factor, factor, MPFR_RNDN);
        mpfr_mul(u, u, factor, MPFR_RNDN);
        mpfr_div(result->miss, u, p->branch.s, MPFR_RNDN);
    }
    mpfr_log(factor, p->branch.s, MPFR_RNDN);
    mpfr_div(factor, factor, p->branch.lambda, MPFR_RNDN);
    mpfr_add(t, t, factor, MPFR_RNDN);
    result->interval = first ? 0 : mpfr_get_d(t, MPFR_RNDN) - result->time;
    result->time = mpfr_get_d(t, MPFR_RNDN);
    result->lambda = mpfr_get_d(p->branch.lambda, MPFR_RNDN);
    result->steps = cns_flow_steps(p->flow);
    mpfr_clears(t, u, factor, (mpfr_ptr)0);
}

/* The image that the last step has left, or NULL. */
static image *left_image(probe *p)
{
    for (int k = 0; k < p->n_images; k++) {
        image *m = &p->images[k];
        double u0, u1, others;
        coordinates(p, m, cns_flow_state(p->flow), &u1, &others);
        if (m->behind) {
            m->behind = fmax(u1, others) <= apart;
            continue;
        }
        m->approached = m->approached ? fmax(u1, others) < 2 * near : fmax(u1, others) < near;
        if (!m->approached || u1 < leaving || others > u1)
            continue;
        coordinates(p, m, cns_flow_begin_state(p->flow), &u0, &others);
        if (u0 < u1)
            return m;
    }
    return NULL;
}

static cns_code follow(probe *p, const cns_passage_spec *spec, double horizon, cns_passage *result,
                       cns_error *err)
{
    int passed = 0;
    for (;;) {
        cns_code code = cns_flow_step(p->flow, err);
        if (code)
            return code;
        const double t = mpfr_get_d(cns_flow_end(p->flow), MPFR_RNDN);
        image *m = left_image(p);
        if (m != NULL) {
            finish(p, m, passed == 0, result);
            /* Rounding the start moves it along the manifold by that much of s. */
            if (cns_log2_mpfr(result->miss) + cns_log2_mpfr(p->branch.s) <
                -(double)(spec->digits - NOISE_DIGITS) * CNS_LOG2_10)
                return too_near(spec->digits, err);
            if (++passed >= spec->passes)
                return CNS_OK;
            m->behind = true;
            m->approached = false;
            horizon += t;
        }
        cns_monitor_tell(p->monitor, fmin(t / horizon, 1), "along the unstable manifold");
        for (int k = 0; k < p->n_images && t > horizon; k++)
            if (p->images[k].approached)
                return too_near(spec->digits, err);
        if (t > horizon)
            return cns_fail(
                err, CNS_NUMERIC,
                "t = %.4g: the unstable manifold has not come near the next saddle and left it again", t);
    }
}

static cns_code find_saddle(probe *p, slong prec, cns_error *err)
{
    const cns_model *m = cns_system_model(p->s);
    cns_model_guess guess[CNS_MODEL_MAX_GUESSES];
    double start[CNS_MODEL_MAX_STATES];
    cns_error inner;
    const int n = cns_system_guesses(p->s, guess);
    for (int k = 0; k < n; k++) {
        if (strcmp(guess[k].name, m->connection->saddle) != 0)
            continue;
        for (int i = 0; i < p->d; i++)
            start[i] = guess[k].state[p->reduced.index[i]];
        cns_code code = cns_fixed_point_find(&p->reduced, start, prec, &p->saddle, &inner);
        return code ? cns_fail(err, code, "%s: %s", m->connection->saddle, inner.text) : CNS_OK;
    }
    return cns_fail(err, CNS_NUMERIC, "the model has no fixed point %s with these parameters",
                    m->connection->saddle);
}

/* The two ways to the same numbers. */
static cns_flow_spec numerics(const probe *p, long digits, int variant)
{
    cns_flow_spec spec = cns_flow_spec_taylor(p->reduced.field, p->scales, CNS_ARITH_FAST, digits);
    spec.safety = variant > 0 ? CNS_FINE_SAFETY : 0;
    spec.verify = true;
    spec.stop = cns_monitor_stop(p->monitor);
    return spec;
}

/* Smoothing moves a connection by some eps^2: nothing, if eps < 2^-(2/3 prec + 16), and a series about a
 * saddle on the smoothed kink would reach no farther than eps. */
static cns_code leave_out_sharp_smoothing(probe *p, cns_error *err)
{
    mpfr_t eps;
    if (cns_system_smooth(p->s) == NULL)
        return CNS_OK;
    mpfr_init2(eps, 53);
    cns_number_get_mpfr(eps, cns_system_smooth(p->s));
    const bool sharp = mpfr_get_exp(eps) < -(2 * p->prec / 3 + 16);
    mpfr_clear(eps);
    if (!sharp)
        return CNS_OK;
    p->s = p->exact = cns_system_smoothed(p->s, NULL, err);
    return p->exact != NULL ? CNS_OK : err->code;
}

static cns_code prepare(probe *p, const cns_passage_spec *spec, cns_error *err)
{
    const cns_model *m = cns_system_model(p->s);
    const long digits = spec->digits + (spec->variant > 0 ? VARIANT_DIGITS : 0);
    cns_error inner;
    if (m->connection == NULL || m->equilibria == NULL)
        return cns_fail(err, CNS_USAGE, "the model %s names no saddle whose unstable manifold to follow",
                        m->name);
    p->prec = cns_digits_to_bits(digits);
    cns_code code = leave_out_sharp_smoothing(p, err);
    if (!code)
        code = cns_reduced_open(&p->reduced, cns_system_program(p->s), err);
    if (code)
        return code;
    p->d = p->reduced.d;
    p->along = -1;
    p->scales = cns_xalloc((size_t)p->d, sizeof *p->scales);
    for (int i = 0; i < p->d; i++) {
        p->scales[i] = cns_system_scales(p->s)[p->reduced.index[i]];
        if (p->reduced.index[i] == m->connection->along)
            p->along = i;
    }
    cns_fixed_point_init(&p->saddle, p->d);
    p->x = cns_vector_xnew(p->d, p->prec);
    p->difference = cns_vector_xnew(p->d, p->prec);
    code = find_saddle(p, (slong)p->prec + 2 * EXTRA_BITS, err);
    if (code)
        return code;
    /* Two terms in three of a series that would go half way to its next singularity; three in four. */
    const int order = (int)((double)p->prec * (spec->variant > 0 ? 0.3 : 0.25)) + 10;
    code = cns_branch_open(&p->branch, &p->reduced, &p->saddle, p->along, p->scales, order,
                           p->prec + EXTRA_BITS, &inner);
    if (code)
        return cns_fail(err, code, "%s: %s", m->connection->saddle, inner.text);
    find_rows(p);
    find_images(p, MORE_WORDS + spec->passes);
    const cns_flow_spec flow = numerics(p, digits, spec->variant);
    p->flow = cns_flow_new(&flow, err);
    if (p->flow == NULL)
        return err->code;
    cns_branch_eval(&p->branch, p->branch.s, p->x);
    cns_flow_start_at(p->flow, (const mpfr_t *)p->x);
    return CNS_OK;
}

static void dispose(probe *p)
{
    cns_flow_free(p->flow);
    if (p->branch.p != NULL)
        cns_branch_close(&p->branch);
    if (p->saddle.x != NULL)
        cns_fixed_point_clear(&p->saddle);
    for (int k = 0; k < p->n_images; k++) {
        cns_vector_free(p->images[k].x);
        free(p->images[k].sign);
    }
    cns_vector_free(p->row);
    cns_vector_free(p->x);
    cns_vector_free(p->difference);
    free(p->re);
    free(p->im);
    free(p->scales);
    cns_reduced_close(&p->reduced);
    cns_system_free(p->exact);
}

void cns_passage_init(cns_passage *p, mpfr_prec_t prec)
{
    *p = (cns_passage){0};
    mpfr_init2(p->miss, prec);
}

void cns_passage_clear(cns_passage *p)
{
    mpfr_clear(p->miss);
}

cns_code cns_manifold_passage(const cns_system *s, const cns_passage_spec *spec, const cns_monitor *monitor,
                              cns_passage *result, cns_error *err)
{
    probe p = {.s = s, .monitor = monitor};
    cns_code code = prepare(&p, spec, err);
    if (!code) {
        const double horizon =
            (SLOW_TIMES + 2.302585092994046 * (double)spec->digits) / mpfr_get_d(p.branch.lambda, MPFR_RNDN);
        result->loss = -cns_log2_mpfr(p.branch.s) * CNS_LOG10_2;
        code = follow(&p, spec, horizon, result, err);
    }
    dispose(&p);
    return code;
}
