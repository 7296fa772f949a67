#include "corrector.h"

#include <math.h>
#include <stdlib.h>

#include "core/memory.h"
#include "num/logs.h"
#include "num/vector.h"
#include "solve/proof.h"
#include "study/modes/returns.h"
#include "taylor/tangent.h"

enum {
    TURNS = 24,
    HALVINGS = 5,    /* of a step that leads away */
    SLACK_BITS = 12, /* by which rounding in many steps may exceed that in one */
    NEAR_LOG2 = -6   /* after half of the turns corrections are this small, or there is no orbit nearby */
};

cns_code cns_loop_open(cns_loop *l, const cns_system *s, const volatile sig_atomic_t *stop, cns_error *err)
{
    const cns_model *m = cns_system_model(s);
    *l = (cns_loop){.system = s, .parameter = -1, .n = m->n_states, .stop = stop};
    cns_number_init(&l->held_value);
    cns_images_open(&l->images, m);
    l->index = cns_xalloc((size_t)l->n + 1, sizeof *l->index);
    l->d = cns_dynamic_states(cns_system_program(s), l->index);
    return l->d >= 2 ? CNS_OK
                     : cns_fail(err, CNS_USAGE, "a motion with less than two dynamic states has no orbits");
}

void cns_loop_close(cns_loop *l)
{
    cns_number_clear(&l->held_value);
    cns_images_close(&l->images);
    free(l->index);
}

static double scale(const cns_loop *l, int k)
{
    return cns_system_scales(l->system)[l->index[k]];
}

static int sign(const cns_loop *l, int k)
{
    return l->images.item[l->image].sign[l->index[k]];
}

static bool is_angle(const cns_loop *l, int k)
{
    const cns_model_motion *m = l->images.model->motion;
    return m != NULL && m->angle == l->index[k];
}

double cns_loop_match(const cns_loop *l, const mpfr_t *z, const mpfr_t *x, int *image, long *turns)
{
    const double pi2 = 6.283185307179586477;
    const int n = cns_images_turns(&l->images);
    double best = HUGE_VAL;
    for (int i = 0; i < l->images.n; i++) {
        const cns_image *a = &l->images.item[i];
        double gap = 0;
        long made = a->turns;
        for (int k = 0; k < l->d; k++) {
            double off = mpfr_get_d(x[k], MPFR_RNDN) - a->sign[l->index[k]] * mpfr_get_d(z[k], MPFR_RNDN);
            if (is_angle(l, k)) {
                off -= (double)a->turns * pi2 / n;
                const double whole = floor(off / pi2 + 0.5);
                made += (long)fmax(-1e9, fmin(1e9, whole)) * n;
                off -= whole * pi2;
            }
            gap = fmax(gap, fabs(off) / scale(l, k));
        }
        if (gap < best) {
            best = gap;
            *image = i;
            *turns = made;
        }
    }
    return best;
}

/* One evaluation of the equations and the step that Newton's method makes from it. */
typedef struct evaluation {
    int size;                                      /* equations and unknowns: d, or d + 1 with a chord */
    arb_mat_t a, r, inverse, step, before, change; /* of the derivative: now, and at the turn before */
    bool had;                                      /* is there one from before? */
    mpfr_t *from;                                  /* where the last step began; */
    double step_log2;                              /* its length, */
    int halved;                                    /* and how often it was halved */
    slong prec;
} evaluation;

static void open_evaluation(evaluation *e, int size, slong prec)
{
    *e = (evaluation){.size = size, .prec = prec};
    arb_mat_init(e->a, size, size);
    arb_mat_init(e->inverse, size, size);
    arb_mat_init(e->before, size, size);
    arb_mat_init(e->change, size, size);
    arb_mat_init(e->r, size, 1);
    arb_mat_init(e->step, size, 1);
}

static void close_evaluation(evaluation *e)
{
    arb_mat_clear(e->a);
    arb_mat_clear(e->inverse);
    arb_mat_clear(e->before);
    arb_mat_clear(e->change);
    arb_mat_clear(e->r);
    arb_mat_clear(e->step);
}

/* log2 of the largest entry. */
static double size_log2(const arb_mat_t a)
{
    double largest = -HUGE_VAL;
    mpfr_t x;
    mpfr_init2(x, 53);
    for (slong i = 0; i < arb_mat_nrows(a); i++)
        for (slong j = 0; j < arb_mat_ncols(a); j++) {
            arf_get_mpfr(x, arb_midref(arb_mat_entry(a, i, j)), MPFR_RNDN);
            largest = fmax(largest, cns_log2_mpfr(x));
        }
    mpfr_clear(x);
    return largest;
}

static void put(arb_t to, mpfr_srcptr x, double factor, slong prec)
{
    arb_t f;
    arb_init(f);
    arb_set_d(f, factor);
    arf_set_mpfr(arb_midref(to), x);
    mag_zero(arb_radref(to));
    arb_mul(to, to, f, prec);
    mag_zero(arb_radref(to));
    arb_clear(f);
}

/* The system at parameter u[d + 1] + offset; NULL and err: there is none. */
static cns_system *system_at(const cns_loop *l, mpfr_srcptr value, cns_error *err)
{
    cns_number x;
    cns_number_init(&x);
    cns_number_from_mpfr(&x, value);
    cns_system *s = cns_system_with(l->system, l->parameter, &x, err);
    cns_number_clear(&x);
    return s;
}

/* The unknowns in the order of the columns: states without the held one, time, parameter. */
static int unknown(const cns_loop *l, int column)
{
    return column < l->held ? column : column + 1;
}

static double unit(const cns_loop *l, const mpfr_t *u, int unknown)
{
    return unknown < l->d    ? scale(l, unknown)
           : unknown == l->d ? mpfr_get_d(u[l->d], MPFR_RNDN)
                             : l->parameter_scale;
}

/* The column of the parameter: (Phi(p + h) - Phi(p)) / h. */
static cns_code parameter_column(const cns_loop *l, long digits, bool fine, const cns_corrected *c,
                                 evaluation *e, cns_error *err)
{
    const int d = l->d;
    const mpfr_prec_t prec = c->shooting.prec;
    cns_shooting other = {0};
    mpfr_t h, p;
    mpfr_inits2(prec, h, p, (mpfr_ptr)0);
    mpfr_set_d(h, l->parameter_scale, MPFR_RNDN);
    mpfr_mul_2si(h, h, -(long)prec / 2, MPFR_RNDN);
    mpfr_add(p, c->u[d + 1], h, MPFR_RNDN);
    mpfr_sub(h, p, c->u[d + 1], MPFR_RNDN);
    cns_system *s = system_at(l, p, err);
    const cns_shooting_spec spec = {.system = s, .digits = digits, .fine = fine, .stop = l->stop};
    cns_code code = s != NULL ? cns_shooting_open(&other, &spec, err) : err->code;
    if (!code)
        code = cns_shooting_run(&other, (const mpfr_t *)c->u, c->u[d], err);
    for (int i = 0; i < d && !code; i++) {
        mpfr_sub(p, other.x[i], c->shooting.x[i], MPFR_RNDN);
        mpfr_div(p, p, h, MPFR_RNDN);
        put(arb_mat_entry(e->a, i, d), p, l->parameter_scale / scale(l, i), e->prec);
    }
    cns_shooting_close(&other);
    cns_system_free(s);
    mpfr_clears(h, p, (mpfr_ptr)0);
    return code;
}

/* The chord's equation, as the last row. */
static void chord_row(const cns_loop *l, const cns_chord *chord, const cns_corrected *c, evaluation *e)
{
    arb_t t, x, y;
    arb_init(t);
    arb_init(x);
    arb_init(y);
    arb_zero(arb_mat_entry(e->r, l->d, 0));
    for (int j = 0; j <= l->d; j++) {
        const int k = unknown(l, j);
        const double size = unit(l, chord->from, k);
        put(t, chord->to[k], 1 / size, e->prec);
        put(x, chord->from[k], 1 / size, e->prec);
        arb_sub(t, t, x, e->prec);
        put(y, c->u[k], 1 / size, e->prec);
        arb_sub(x, y, x, e->prec); /* so far from the chord's beginning */
        put(y, chord->s, 1, e->prec);
        arb_mul(y, y, t, e->prec);
        arb_sub(x, y, x, e->prec);
        arb_addmul(arb_mat_entry(e->r, l->d, 0), x, t, e->prec);
        /* The step in time is relative to the time at hand. */
        arb_set_d(y, k == l->d ? mpfr_get_d(c->u[k], MPFR_RNDN) / size : 1);
        arb_mul(arb_mat_entry(e->a, l->d, j), t, y, e->prec);
    }
    arb_clear(t);
    arb_clear(x);
    arb_clear(y);
}

static cns_code evaluate(const cns_loop *l, long digits, bool fine, const cns_chord *chord, cns_corrected *c,
                         evaluation *e, cns_error *err)
{
    const int d = l->d;
    cns_shooting *s = &c->shooting;
    cns_code code = CNS_OK;
    mpfr_t x;
    if (s->index == NULL || chord != NULL) { /* the parameter is another one than before */
        cns_shooting_close(s);
        cns_system_free(c->system);
        c->system = l->parameter >= 0 ? system_at(l, c->u[d + 1], err) : NULL;
        if (l->parameter >= 0 && c->system == NULL)
            return err->code;
        const cns_shooting_spec spec = {.system = c->system != NULL ? c->system : l->system,
                                        .digits = digits,
                                        .fine = fine,
                                        .tangents = true,
                                        .stop = l->stop};
        code = cns_shooting_open(s, &spec, err);
    }
    if (!code)
        code = cns_shooting_run(s, (const mpfr_t *)c->u, c->u[d], err);
    if (code)
        return code;
    mpfr_init2(x, s->prec);
    c->growth_log2 = 0;
    for (int i = 0; i < d; i++) {
        mpfr_mul_si(x, c->u[i], sign(l, i), MPFR_RNDN);
        if (is_angle(l, i) && l->turns != 0) {
            mpfr_t turn;
            mpfr_init2(turn, s->prec + 64);
            mpfr_const_pi(turn, MPFR_RNDN);
            mpfr_mul_si(turn, turn, 2 * l->turns, MPFR_RNDN);
            mpfr_div_si(turn, turn, cns_images_turns(&l->images), MPFR_RNDN);
            mpfr_add(x, x, turn, MPFR_RNDN);
            mpfr_clear(turn);
        }
        mpfr_sub(x, x, s->x[i], MPFR_RNDN);
        put(arb_mat_entry(e->r, i, 0), x, 1 / scale(l, i), e->prec);
        for (int j = 0; j < d; j++) {
            const int k = unknown(l, j);
            if (k == d) {
                put(arb_mat_entry(e->a, i, j), s->f[i], unit(l, c->u, d) / scale(l, i), e->prec);
                continue;
            }
            if (i == k)
                mpfr_sub_si(x, s->m[i * d + k], sign(l, i), MPFR_RNDN);
            else
                mpfr_set(x, s->m[i * d + k], MPFR_RNDN);
            put(arb_mat_entry(e->a, i, j), x, scale(l, k) / scale(l, i), e->prec);
        }
        for (int j = 0; j < d; j++)
            c->growth_log2 = fmax(c->growth_log2, cns_log2_mpfr(s->m[i * d + j]) +
                                                      cns_log2_2exp(scale(l, j) / scale(l, i), 0));
    }
    mpfr_clear(x);
    if (chord == NULL)
        return CNS_OK;
    chord_row(l, chord, c, e);
    return parameter_column(l, digits, fine, c, e, err);
}

static cns_code not_isolated(cns_error *err)
{
    return cns_fail(err, CNS_UNREACHED,
                    "the orbit is not isolated: another multiplier than that along it is 1, or the section "
                    "does not cross it");
}

/* From e->a and e->r: the step, and what is to be said of the derivative. */
static cns_code solve(int d, cns_corrected *c, evaluation *e, cns_error *err)
{
    if (!arb_mat_approx_inv(e->inverse, e->a, e->prec))
        return not_isolated(err);
    arb_mat_get_mid(e->inverse, e->inverse);
    arb_mat_mul(e->step, e->inverse, e->r, e->prec);
    arb_mat_get_mid(e->step, e->step);
    const double dimension_log2 = cns_log2_2exp(e->size, 0);
    c->inverse_log2 = size_log2(e->inverse) + dimension_log2;
    if (e->had && e->step_log2 > -0.6 * (double)e->prec) {
        arb_mat_sub(e->change, e->a, e->before, e->prec);
        c->change_log2 = fmax(c->change_log2, size_log2(e->change) + dimension_log2 - e->step_log2);
    }
    arb_mat_set(e->before, e->a);
    e->had = true;
    c->step_log2 = size_log2(e->step);
    c->noise_log2 = c->inverse_log2 + c->growth_log2 + SLACK_BITS - (double)c->shooting.prec;
    /* On a chord the way to a point where branches meet is open. */
    if (e->size == d && c->inverse_log2 > (double)c->shooting.prec / 2)
        return not_isolated(err);
    return CNS_OK;
}

/* u = where the step began + 2^-halved of it. */
static void take_step(const cns_loop *l, cns_corrected *c, const evaluation *e)
{
    mpfr_t x;
    mpfr_init2(x, c->shooting.prec);
    for (int j = 0; j < e->size; j++) {
        const int k = unknown(l, j);
        arf_get_mpfr(x, arb_midref(arb_mat_entry(e->step, j, 0)), MPFR_RNDN);
        mpfr_mul_d(x, x, ldexp(unit(l, (const mpfr_t *)e->from, k), -e->halved), MPFR_RNDN);
        mpfr_add(c->u[k], e->from[k], x, MPFR_RNDN);
    }
    mpfr_clear(x);
}

/* Is the next step, by the derivative of the last one, shorter than that? (The monotonicity test of P.
 * Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 3.3, which no change of scales or
 * coordinates affects.) */
static bool comes_nearer(evaluation *e)
{
    arb_mat_t trial;
    arb_mat_init(trial, e->size, 1);
    arb_mat_mul(trial, e->inverse, e->r, e->prec);
    const bool nearer = size_log2(trial) <= e->step_log2;
    arb_mat_clear(trial);
    return nearer;
}

cns_code cns_correct(const cns_loop *l, long digits, bool fine, const cns_chord *chord, const mpfr_t *u,
                     cns_corrected *c, cns_error *err)
{
    const mpfr_prec_t prec = cns_digits_to_bits(digits);
    const int d = l->d;
    evaluation e;
    double before = HUGE_VAL;
    *c = (cns_corrected){.u = cns_vector_xnew(d + 2, prec), .change_log2 = -HUGE_VAL};
    for (int i = 0; i < d + 2; i++)
        mpfr_set(c->u[i], u[i], MPFR_RNDN);
    cns_number_get_mpfr(c->u[l->held], &l->held_value);
    open_evaluation(&e, chord != NULL ? d + 1 : d, (slong)prec + 64);
    e.from = cns_vector_xnew(d + 2, prec);
    cns_code code = CNS_OK;
    for (;;) {
        code = evaluate(l, digits, fine, chord, c, &e, err);
        const bool too_far = code == CNS_NUMERIC || (!code && c->turns > 0 && !comes_nearer(&e));
        if (c->turns > 0 && too_far && e.step_log2 > NEAR_LOG2 && e.halved < HALVINGS) {
            e.halved++;
            take_step(l, c, &e);
            continue;
        }
        if (!code)
            code = solve(d, c, &e, err);
        if (code == CNS_NUMERIC && c->turns > 0)
            code = cns_fail(err, CNS_UNREACHED, "Newton's method finds no orbit nearby");
        if (code || c->step_log2 <= c->noise_log2 ||
            (c->step_log2 > before - 1 && before < -(double)prec / 2))
            break;
        if (c->turns == TURNS || !(c->step_log2 < 20) || (c->turns > TURNS / 2 && c->step_log2 > NEAR_LOG2)) {
            code = cns_fail(err, CNS_UNREACHED, "Newton's method finds no orbit nearby");
            break;
        }
        for (int i = 0; i < d + 2; i++)
            mpfr_set(e.from[i], c->u[i], MPFR_RNDN);
        e.step_log2 = before = c->step_log2;
        e.halved = 0;
        take_step(l, c, &e);
        c->turns++;
    }
    cns_vector_free(e.from);
    close_evaluation(&e);
    return code;
}

void cns_corrected_close(cns_corrected *c)
{
    cns_shooting_close(&c->shooting);
    cns_system_free(c->system);
    cns_vector_free(c->u);
    *c = (cns_corrected){0};
}

void cns_ball_of(arb_t x, mpfr_srcptr fine, mpfr_srcptr coarse, double noise_log2)
{
    mpfr_t e;
    arf_t radius;
    mpfr_init2(e, 64);
    arf_init(radius);
    mpfr_set_zero(e, 1);
    cns_proof_error(e, fine, coarse, noise_log2);
    arf_set_mpfr(radius, e);
    arf_set_mpfr(arb_midref(x), fine);
    mag_zero(arb_radref(x));
    arb_add_error_arf(x, radius);
    arf_clear(radius);
    mpfr_clear(e);
}

/* What one has of a value, or two. */
static void value_of(arb_t x, mpfr_srcptr fine, mpfr_srcptr coarse, double noise_log2)
{
    if (coarse != NULL) {
        cns_ball_of(x, fine, coarse, noise_log2);
        return;
    }
    arf_set_mpfr(arb_midref(x), fine);
    mag_zero(arb_radref(x));
}

/* By Liouville's theorem det m = exp(integral of the trace), and f comes back: n f = f. */
static cns_code check(const arb_mat_t n, arb_srcptr f, const arb_t trace, int signs, slong prec,
                      cns_error *err)
{
    const slong d = arb_mat_nrows(n);
    arb_t x, y;
    arb_init(x);
    arb_init(y);
    bool good = true;
    for (slong i = 0; i < d; i++) {
        arb_zero(x);
        for (slong j = 0; j < d; j++)
            arb_addmul(x, arb_mat_entry(n, i, j), f + j, prec);
        good = good && arb_overlaps(x, f + i);
    }
    arb_mat_det(x, n, prec);
    arb_exp(y, trace, prec);
    arb_mul_si(y, y, signs, prec);
    const bool liouville = arb_overlaps(x, y) != 0;
    arb_clear(x);
    arb_clear(y);
    if (!good)
        return cns_fail(err, CNS_NUMERIC, "the tangent along the orbit does not come back: this is an error");
    return liouville ? CNS_OK
                     : cns_fail(err, CNS_NUMERIC,
                                "the determinant of the tangents is not the exponential of the integral of "
                                "the trace: this is an error");
}

cns_code cns_return_matrix(const cns_loop *l, const cns_corrected *fine, const cns_corrected *coarse,
                           arb_mat_t p, cns_error *err)
{
    const int d = l->d, h = l->held;
    const cns_shooting *a = &fine->shooting, *b = coarse != NULL ? &coarse->shooting : NULL;
    const slong prec = (slong)a->prec + 64;
    /* Tangents and rates move with the point, too. */
    const double noise = coarse == NULL ? 0
                                        : coarse->growth_log2 +
                                              fmax(0, coarse->noise_log2 + (double)b->prec) - (double)b->prec;
    arb_mat_t n;
    arb_t x, trace;
    arb_ptr f = _arb_vec_init(d);
    int signs = 1;
    arb_mat_init(n, d, d);
    arb_init(x);
    arb_init(trace);
    for (int i = 0; i < d; i++) { /* n = image^-1 m; f at the beginning is image^-1 f at the end */
        signs *= sign(l, i);
        value_of(f + i, a->f[i], b != NULL ? b->f[i] : NULL, noise + cns_log2_2exp(scale(l, i), 0));
        arb_mul_si(f + i, f + i, sign(l, i), prec);
        for (int j = 0; j < d; j++) {
            value_of(arb_mat_entry(n, i, j), a->m[i * d + j], b != NULL ? b->m[i * d + j] : NULL,
                     noise + cns_log2_2exp(scale(l, i) / scale(l, j), 0));
            arb_mul_si(arb_mat_entry(n, i, j), arb_mat_entry(n, i, j), sign(l, i), prec);
        }
    }
    value_of(trace, a->trace, b != NULL ? b->trace : NULL, noise);
    cns_code code = arb_contains_zero(f + h)
                        ? cns_fail(err, CNS_NUMERIC, "the orbit does not cross the section where it begins")
                        : CNS_OK;
    if (!code && coarse != NULL)
        code = check(n, f, trace, signs, prec, err);
    for (int i = 0, row = 0; i < d && !code; i++) {
        if (i == h)
            continue;
        arb_div(x, f + i, f + h, prec);
        for (int j = 0, column = 0; j < d; j++)
            if (j != h) {
                arb_ptr y = arb_mat_entry(p, row, column++);
                arb_mul(y, x, arb_mat_entry(n, h, j), prec);
                arb_sub(y, arb_mat_entry(n, i, j), y, prec);
            }
        row++;
    }
    arb_mat_clear(n);
    arb_clear(x);
    arb_clear(trace);
    _arb_vec_clear(f, d);
    return code;
}
