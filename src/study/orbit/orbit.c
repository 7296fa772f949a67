#include "orbit.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/monitor.h"
#include "integrate/trajectory.h"
#include "num/ball_text.h"
#include "num/decimal_text.h"
#include "num/logs.h"
#include "num/vector.h"
#include "solve/proof.h"
#include "study/spectrum.h"

enum {
    PARTS = 12, /* of a period that may make the motion an image of itself */
    TRIES = 5,  /* with more digits each */
    SPARE = 12  /* digits beyond those that the growth of noise asks for */
};

static const double same = 1e-9; /* distances, in scales, below which states are the same */

/* From a guess to the first solution. */

static cns_code run_to(const cns_loop *l, const mpfr_t *u, int parts, cns_shooting *s, cns_error *err)
{
    mpfr_t time;
    mpfr_init2(time, s->prec);
    mpfr_div_ui(time, u[l->d], (unsigned long)parts, MPFR_RNDN);
    cns_code code = cns_shooting_run(s, u, time, err);
    mpfr_clear(time);
    return code;
}

static cns_code correct_in_place(const cns_loop *l, mpfr_t *u, cns_error *err)
{
    cns_corrected c;
    cns_code code = cns_correct(l, CNS_ORBIT_FIRST_DIGITS, false, NULL, u, &c, err);
    for (int k = 0; k <= l->d && !code; k++)
        mpfr_set(u[k], c.u[k], MPFR_RNDN);
    cns_corrected_close(&c);
    return code;
}

cns_code cns_orbit_shorten(cns_loop *l, mpfr_t *u, int most, bool *found, cns_error *err)
{
    const cns_shooting_spec spec = {.system = l->system, .digits = CNS_ORBIT_FIRST_DIGITS, .stop = l->stop};
    cns_shooting s;
    *found = false;
    cns_code code = cns_shooting_open(&s, &spec, err);
    for (int parts = most; parts > 1 && !code && !*found; parts--) {
        int image;
        long turns;
        code = run_to(l, u, parts, &s, err);
        *found = !code && cns_loop_match(l, u, s.x, &image, &turns) < same;
        if (*found) {
            mpfr_div_ui(u[l->d], u[l->d], (unsigned long)parts, MPFR_RNDN);
            l->image = image;
            l->turns = turns;
            code = correct_in_place(l, u, err);
        }
    }
    cns_shooting_close(&s);
    return code;
}

cns_code cns_orbit_settle(cns_loop *l, mpfr_t *u, cns_error *err)
{
    const cns_shooting_spec spec = {.system = l->system, .digits = CNS_ORBIT_FIRST_DIGITS, .stop = l->stop};
    cns_shooting s;
    bool found;
    cns_code code = cns_shooting_open(&s, &spec, err);
    if (!code)
        code = run_to(l, u, 1, &s, err);
    if (!code)
        cns_loop_match(l, u, s.x, &l->image, &l->turns);
    if (!code)
        code = correct_in_place(l, u, err);
    cns_shooting_close(&s);
    return code ? code : cns_orbit_shorten(l, u, PARTS, &found, err);
}

cns_code cns_orbit_raise(const cns_loop *l, long digits, const mpfr_t *u, cns_corrected *c, cns_error *err)
{
    long at = CNS_ORBIT_FIRST_DIGITS;
    cns_code code = CNS_OK;
    mpfr_t *better = NULL;
    double change = -HUGE_VAL;
    while (2 * at < digits && !code) {
        at *= 2;
        code = cns_correct(l, at, false, NULL, better != NULL ? (const mpfr_t *)better : u, c, err);
        mpfr_t *next = c->u;
        change = fmax(change, c->change_log2);
        c->u = NULL;
        cns_corrected_close(c);
        cns_vector_free(better);
        better = next;
    }
    if (!code)
        code = cns_correct(l, digits, false, NULL, better != NULL ? (const mpfr_t *)better : u, c, err);
    c->change_log2 = fmax(c->change_log2, change);
    cns_vector_free(better);
    return code;
}

/* Proof and description. */

typedef struct drifts {
    mpfr_t *x; /* all states at the end of a period, the passive ones from 0 */
} drifts;

static cns_code measure_drifts(const cns_loop *l, const cns_corrected *c, long digits, bool fine, int order,
                               drifts *t, cns_error *err)
{
    const cns_system *s = c->system != NULL ? c->system : l->system;
    cns_flow_spec spec =
        cns_flow_spec_taylor(cns_system_program(s), cns_system_scales(s), CNS_ARITH_FAST, digits);
    mpfr_t end;
    mpq_t time;
    spec.verify = true;
    spec.stop = l->stop;
    if (fine)
        spec.safety = CNS_FINE_SAFETY;
    t->x = cns_vector_xnew(l->n, spec.prec);
    cns_flow *f = cns_flow_new(&spec, err);
    if (f == NULL)
        return err->code;
    for (int k = 0; k < l->d; k++)
        mpfr_set(t->x[l->index[k]], c->u[k], MPFR_RNDN);
    cns_flow_start_at(f, (const mpfr_t *)t->x);
    mpfr_init2(end, spec.prec + 16);
    mpq_init(time);
    mpfr_mul_si(end, c->u[l->d], order, MPFR_RNDN);
    cns_code code = CNS_OK;
    while (!code && mpfr_less_p(cns_flow_end(f), end))
        code = cns_flow_step(f, err);
    mpfr_get_q(time, end);
    if (!code)
        cns_flow_eval(f, time, t->x);
    mpfr_clear(end);
    mpq_clear(time);
    cns_flow_free(f);
    return code;
}

/* The two solutions, and everything about the orbit in balls. */
typedef struct proven {
    cns_corrected coarse, fine;
    drifts coarse_drifts, fine_drifts;
    long digits;
    int order;
    long winding;
    arb_ptr state, drift;    /* d; n */
    arb_t period, parameter; /* the latter of a point that was located */
    arb_mat_t matrix;        /* of the return map */
    cns_spectrum spectrum;   /* of a repetition */
    acb_ptr full;            /* of a period */
    double kantorovich_log2, difference_log2;
} proven;

static void open_proven(proven *p, const cns_loop *l)
{
    *p = (proven){0};
    p->order = cns_image_order(&l->images, &l->images.item[l->image], l->turns, &p->winding);
    p->state = _arb_vec_init(l->d);
    p->drift = _arb_vec_init(l->n);
    p->full = _acb_vec_init(l->d - 1);
    arb_init(p->period);
    arb_init(p->parameter);
    arb_mat_init(p->matrix, l->d - 1, l->d - 1);
    cns_spectrum_init(&p->spectrum, l->d - 1);
}

static void drop_solutions(proven *p)
{
    cns_corrected_close(&p->coarse);
    cns_corrected_close(&p->fine);
    cns_vector_free(p->coarse_drifts.x);
    cns_vector_free(p->fine_drifts.x);
    p->coarse_drifts.x = p->fine_drifts.x = NULL;
}

static void close_proven(proven *p, const cns_loop *l)
{
    drop_solutions(p);
    _arb_vec_clear(p->state, l->d);
    _arb_vec_clear(p->drift, l->n);
    _acb_vec_clear(p->full, l->d - 1);
    arb_clear(p->period);
    arb_clear(p->parameter);
    arb_mat_clear(p->matrix);
    cns_spectrum_clear(&p->spectrum);
}

/* Kantorovich: F has a zero within twice the step, and Newton's method goes there, if h = |1/F'| L |step| is
 * at most 1/2. The constant L is that seen on the way, with room for what was not seen. */
static cns_code kantorovich(proven *p, cns_error *err)
{
    const double change = p->coarse.change_log2 > -HUGE_VAL ? p->coarse.change_log2 : 0;
    const double step = fmax(p->fine.step_log2, p->difference_log2);
    p->kantorovich_log2 = p->fine.inverse_log2 + change + CNS_PROOF_SAFETY_LOG2 + step;
    return p->kantorovich_log2 < -1
               ? CNS_OK
               : cns_fail(err, CNS_NUMERIC,
                          "Newton's method has come to 10^%.1f only: the orbit is not proven to be one",
                          step * CNS_LOG10_2);
}

static cns_code into_balls(const cns_loop *l, proven *p, cns_error *err)
{
    const double noise = p->coarse.noise_log2;
    mpfr_t x, y;
    mpfr_inits2(p->fine.shooting.prec, x, y, (mpfr_ptr)0);
    p->difference_log2 = -HUGE_VAL;
    for (int k = 0; k < l->d; k++) {
        const double scale = cns_system_scales(l->system)[l->index[k]];
        if (k == l->held) {
            arf_set_mpfr(arb_midref(p->state + k), p->fine.u[k]);
            arb_set_round(p->state + k, p->state + k, p->fine.shooting.prec);
            if (l->held_value.pi_power != 0 || mpz_cmp_ui(mpq_denref(l->held_value.ratio), 1) != 0)
                cns_ball_of(p->state + k, p->fine.u[k], p->coarse.u[k], -HUGE_VAL);
            else
                mag_zero(arb_radref(p->state + k));
            continue;
        }
        mpfr_sub(x, p->fine.u[k], p->coarse.u[k], MPFR_RNDN);
        p->difference_log2 = fmax(p->difference_log2, cns_log2_mpfr(x) - cns_log2_2exp(scale, 0));
        cns_ball_of(p->state + k, p->fine.u[k], p->coarse.u[k], noise + cns_log2_2exp(scale, 0));
    }
    mpfr_mul_si(x, p->fine.u[l->d], p->order, MPFR_RNDN);
    mpfr_mul_si(y, p->coarse.u[l->d], p->order, MPFR_RNDN);
    cns_ball_of(p->period, x, y, noise + cns_log2_mpfr(x));
    for (int i = 0; i < l->n; i++)
        cns_ball_of(p->drift + i, p->fine_drifts.x[i], p->coarse_drifts.x[i],
                    noise + cns_log2_2exp(cns_system_scales(l->system)[i], 0) + cns_log2_mpfr(x));
    if (l->parameter >= 0)
        cns_ball_of(p->parameter, p->fine.u[l->d + 1], p->coarse.u[l->d + 1],
                    noise + cns_log2_2exp(l->parameter_scale, 0));
    mpfr_clears(x, y, (mpfr_ptr)0);
    cns_code code = kantorovich(p, err);
    if (!code)
        code = cns_return_matrix(l, &p->fine, &p->coarse, p->matrix, err);
    const slong prec = (slong)p->fine.shooting.prec + 64;
    if (!code)
        code = cns_spectrum_enclose(&p->spectrum, p->matrix, prec, err);
    for (int i = 0; i < l->d - 1 && !code; i++)
        acb_pow_ui(p->full + i, p->spectrum.lambda + i, (ulong)p->order, prec);
    return code;
}

static cns_code two_solutions(const cns_loop *l, const cns_orbit_solver *solver, proven *p, cns_error *err)
{
    const long coarse = p->digits - CNS_ANOTHER_LIMB;
    drop_solutions(p);
    cns_code code = solver->solve(solver->context, l, coarse, false, NULL, &p->coarse, err);
    if (!code)
        code = solver->solve(solver->context, l, p->digits, true, (const mpfr_t *)p->coarse.u, &p->fine, err);
    if (!code)
        code = measure_drifts(l, &p->coarse, coarse, false, p->order, &p->coarse_drifts, err);
    if (!code)
        code = measure_drifts(l, &p->fine, p->digits, true, p->order, &p->fine_drifts, err);
    return code ? code : into_balls(l, p, err);
}

static bool give(char **to, const arb_t x, long decimals)
{
    *to = cns_text_ball(x, decimals);
    return *to != NULL;
}

static bool give_multiplier(cns_eigenvalue *to, const acb_t x, bool real, long decimals)
{
    const bool re = give(&to->re, acb_realref(x), decimals);
    if (real)
        to->im = cns_xcopy("0");
    return (real || give(&to->im, acb_imagref(x), decimals)) && re;
}

static void clear_texts(cns_orbit *o)
{
    for (int k = 0; k < o->d; k++)
        free(o->state[k]);
    for (int i = 0; i < o->n_states; i++)
        free(o->drift[i]);
    for (int i = 0; i < o->d - 1; i++) {
        free(o->multiplier[i].re);
        free(o->multiplier[i].im);
        free(o->repetition[i].re);
        free(o->repetition[i].im);
    }
    free(o->period);
    free(o->parameter);
    free(o->state);
    free(o->drift);
    free(o->multiplier);
    free(o->repetition);
}

void cns_orbit_free(cns_orbit *o)
{
    if (o == NULL)
        return;
    clear_texts(o);
    free(o->index);
    free(o);
}

/* The multipliers by size, the largest first; of a pair, the positive imaginary part first. */
static void by_size(const proven *p, int n, int *order)
{
    arb_t a, b;
    arb_init(a);
    arb_init(b);
    for (int i = 0; i < n; i++) {
        order[i] = i;
        for (int j = i; j > 0; j--) {
            acb_abs(a, p->spectrum.lambda + order[j], 128);
            acb_abs(b, p->spectrum.lambda + order[j - 1], 128);
            if (arb_overlaps(a, b) || arb_lt(a, b))
                break;
            const int other = order[j];
            order[j] = order[j - 1];
            order[j - 1] = other;
        }
    }
    arb_clear(a);
    arb_clear(b);
}

/* All texts to so many decimals. False: not all are certain. */
static bool describe(const cns_loop *l, const proven *p, long decimals, cns_orbit *o)
{
    const int d = l->d;
    clear_texts(o);
    o->state = cns_xalloc((size_t)d, sizeof *o->state);
    o->drift = cns_xalloc((size_t)l->n, sizeof *o->drift);
    o->multiplier = cns_xalloc((size_t)d, sizeof *o->multiplier);
    o->repetition = cns_xalloc((size_t)d, sizeof *o->repetition);
    o->decimals = decimals;
    bool certain = give(&o->period, p->period, decimals);
    certain = (l->parameter < 0 || give(&o->parameter, p->parameter, decimals)) && certain;
    for (int k = 0; k < d; k++)
        certain = give(&o->state[k], p->state + k, decimals) && certain;
    for (int i = 0, k = 0; i < l->n; i++) {
        const bool dynamic = k < d && l->index[k] == i;
        k += dynamic;
        certain = (dynamic || give(&o->drift[i], p->drift + i, decimals)) && certain;
    }
    o->stable = o->unstable = 0;
    int *order = cns_xalloc((size_t)d, sizeof *order);
    by_size(p, d - 1, order);
    for (int at = 0; at < d - 1; at++) {
        const int i = order[at];
        const bool real = cns_spectrum_is_real(&p->spectrum, i);
        arb_t modulus;
        arb_init(modulus);
        acb_abs(modulus, p->full + i, (slong)p->fine.shooting.prec);
        arb_sub_ui(modulus, modulus, 1, (slong)p->fine.shooting.prec);
        o->stable += arb_is_negative(modulus) != 0;
        o->unstable += arb_is_positive(modulus) != 0;
        arb_clear(modulus);
        certain = give_multiplier(&o->multiplier[at], p->full + i, real, decimals) && certain;
        certain = give_multiplier(&o->repetition[at], p->spectrum.lambda + i, real, decimals) && certain;
    }
    free(order);
    o->stability = o->unstable > 0 ? "unstable" : o->stable == d - 1 ? "stable" : "not hyperbolic";
    return certain;
}

static cns_orbit *new_orbit(const cns_loop *l, const proven *p)
{
    cns_orbit *o = cns_xalloc(1, sizeof *o);
    o->state = cns_xalloc((size_t)l->d, sizeof *o->state);
    o->drift = cns_xalloc((size_t)l->n, sizeof *o->drift);
    o->multiplier = cns_xalloc((size_t)l->d, sizeof *o->multiplier);
    o->repetition = cns_xalloc((size_t)l->d, sizeof *o->repetition);
    o->n_states = l->n;
    o->d = l->d;
    o->index = cns_xalloc((size_t)l->d, sizeof *o->index);
    memcpy(o->index, l->index, (size_t)l->d * sizeof *o->index);
    o->held = l->index[l->held];
    o->repetitions = p->order;
    snprintf(o->symmetry, sizeof o->symmetry, "%s", p->order > 1 ? l->images.item[l->image].name : "");
    o->winding = p->winding;
    return o;
}

/* The decimals, at most so many, to which all of it is certain, and the texts with them. */
static long reach(const cns_loop *l, const proven *p, long decimals, cns_orbit *o)
{
    while (decimals >= 0 && !describe(l, p, decimals, o))
        decimals--;
    return decimals;
}

cns_code cns_orbit_at(void *context, const cns_loop *l, long digits, bool fine, const mpfr_t *near,
                      cns_corrected *c, cns_error *err)
{
    return near != NULL ? cns_correct(l, digits, fine, NULL, near, c, err)
                        : cns_orbit_raise(l, digits, context, c, err);
}

cns_code cns_orbit_prove(const cns_loop *l, const cns_orbit_solver *solver, long decimals, cns_orbit **result,
                         cns_error *err)
{
    proven p;
    cns_orbit *o = NULL;
    long loss = SPARE, reached = -1;
    *result = NULL;
    open_proven(&p, l);
    cns_code code = CNS_OK;
    for (int attempt = 0; attempt < TRIES && !code && reached < decimals; attempt++) {
        p.digits = decimals + loss + CNS_ANOTHER_LIMB;
        code = two_solutions(l, solver, &p, err);
        if (code)
            break;
        if (o == NULL)
            o = new_orbit(l, &p);
        reached = reach(l, &p, decimals, o);
        o->digits = p.digits;
        o->coarse_digits = p.digits - CNS_ANOTHER_LIMB;
        o->newton = p.coarse.turns;
        o->difference = p.difference_log2 * CNS_LOG10_2;
        o->kantorovich = p.kantorovich_log2 * CNS_LOG10_2;
        loss += 2 * (decimals - reached) + SPARE; /* where branches meet half of the digits are lost */
    }
    if (!code && reached < 0)
        code = cns_fail(err, CNS_NUMERIC, "not one decimal of the orbit is certain");
    else if (!code && reached < decimals)
        code =
            cns_fail(err, CNS_UNREACHED,
                     "only %ld decimals are certain: a number lies at a tie, or multipliers meet", reached);
    close_proven(&p, l);
    if (code && code != CNS_UNREACHED) {
        cns_orbit_free(o);
        o = NULL;
    }
    *result = o;
    return code;
}

cns_code cns_orbit_find(const cns_system *s, const cns_orbit_spec *spec, const cns_monitor *monitor,
                        cns_orbit **result, cns_error *err)
{
    cns_loop l;
    *result = NULL;
    cns_code code = cns_loop_open(&l, s, cns_monitor_stop(monitor), err);
    mpfr_t *u = cns_vector_xnew(l.d + 2, cns_digits_to_bits(CNS_ORBIT_FIRST_DIGITS));
    if (!code)
        code = cns_orbit_guess(&l, spec, u, monitor, err);
    cns_monitor_tell(monitor, 0.5, "Newton's method");
    if (!code)
        code = cns_orbit_settle(&l, u, err);
    if (!code)
        code = cns_orbit_prove(&l, &(cns_orbit_solver){cns_orbit_at, u}, spec->decimals, result, err);
    cns_vector_free(u);
    cns_loop_close(&l);
    return code == CNS_UNREACHED && *result == NULL ? (err->code = CNS_NUMERIC) : code;
}
