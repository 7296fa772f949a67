/* The time loop's one step, for every method: time, grid of a fixed step, and the check of the derivative. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cns/flow.h"
#include "core/memory.h"
#include "method.h"
#include "num/logs.h"
#include "num/round.h"
#include "numerics.h"

struct cns_flow {
    cns_flow_spec spec;
    const cns_method_ops *ops;
    cns_stepper *stepper;
    int n;
    mpfr_t t0, t1; /* more bits than the states: a step may be as short as the last digit of a state */
    mpfr_t tau;
    mpfr_t *x0, *x1, *initial;
    mpq_t grid; /* fixed step: steps so far, times the step, exactly */
    mpq_t step;
    cns_step last;
    long steps, landings;
    cns_jet *check; /* pointwise right-hand side, its constants converted anew at more bits */
    mpfr_t *derivative;
    mpfr_t tolerance, difference;
    double *bound; /* per state: where it is large, steps are made one by one; NULL: they always are */
};

enum { TIME_BITS = 128, CHECK_BITS = 96 };

/* What is wrong with what is asked for; NULL: nothing. */
static const char *refused(const cns_flow_spec *spec)
{
    const bool multiple = spec->arithmetic != CNS_ARITH_DOUBLE;
    if (spec->method == CNS_METHOD_RK4 && !spec->step)
        return "the Runge-Kutta method needs a fixed step";
    if (spec->step && (spec->step->pi_power != 0 || cns_number_sign(spec->step) <= 0))
        return "a fixed step must be rational and positive";
    if (spec->method == CNS_METHOD_TAYLOR && spec->order < 1)
        return "the order of a Taylor series must be at least 1";
    if (multiple && (spec->prec < MPFR_PREC_MIN || spec->prec > MPFR_PREC_MAX / 4))
        return "the precision is out of range";
    if (spec->round_digits > 0 && !multiple)
        return "double cannot keep a number of decimals: take multiple precision";
    return NULL;
}

/* A state beyond these makes noise of its own (count_size), or runs away. */
static bool set_bounds(cns_flow *f)
{
    f->bound = calloc((size_t)f->n + 1, sizeof *f->bound);
    for (int i = 0; f->bound && i < f->n; i++) {
        int scale;
        frexp(f->spec.scales[i], &scale);
        f->bound[i] =
            cns_program_is_dynamic(f->spec.program, i) ? ldexp(1, scale + CNS_USUAL_SIZE_BITS) : HUGE_VAL;
    }
    return f->bound != NULL;
}

cns_flow *cns_flow_new(const cns_flow_spec *spec, cns_error *err)
{
    const char *why = refused(spec);
    if (why != NULL) {
        cns_fail(err, CNS_USAGE, "%s", why);
        return NULL;
    }
    cns_flow *f = calloc(1, sizeof *f);
    if (!f) {
        cns_out_of_memory(err);
        return NULL;
    }
    f->spec = *spec;
    f->spec.arithmetic = cns_arithmetic_for(spec->arithmetic, spec->order);
    if (spec->arithmetic == CNS_ARITH_DOUBLE)
        f->spec.prec = CNS_DOUBLE_BITS;
    f->n = cns_program_states(spec->program);
    f->ops = spec->method == CNS_METHOD_RK4 ? &cns_method_rk4 : &cns_method_taylor;
    const mpfr_prec_t prec = f->spec.prec, time_prec = 2 * prec + TIME_BITS;
    mpfr_inits2(time_prec, f->t0, f->t1, f->tau, f->last.h, (mpfr_ptr)0);
    mpfr_inits2(prec + CHECK_BITS, f->tolerance, f->difference, (mpfr_ptr)0);
    mpq_inits(f->grid, f->step, (mpq_ptr)0);
    f->x0 = cns_vector_new(f->n, prec);
    f->x1 = cns_vector_new(f->n, prec);
    f->initial = cns_vector_new(f->n, prec);
    f->derivative = cns_vector_new(f->n, prec + CHECK_BITS);
    if (!f->x0 || !f->x1 || !f->initial || !f->derivative) {
        cns_out_of_memory(err);
        cns_flow_free(f);
        return NULL;
    }
    if (spec->step)
        mpq_set(f->step, spec->step->ratio);
    if (spec->step && f->ops->stride && !set_bounds(f)) {
        cns_out_of_memory(err);
        cns_flow_free(f);
        return NULL;
    }
    f->stepper = f->ops->create(&f->spec, err);
    if (f->stepper && spec->verify && f->ops->derivative) {
        cns_jet_spec check = {.program = spec->program,
                              .ops = &cns_arith_mpfr,
                              .order = 1,
                              .prec = prec + CHECK_BITS,
                              .sharp_prec = prec};
        f->check = cns_jet_new(&check, err);
    }
    if (!f->stepper || (spec->verify && f->ops->derivative && !f->check)) {
        cns_flow_free(f);
        return NULL;
    }
    return f;
}

void cns_flow_free(cns_flow *f)
{
    if (!f)
        return;
    if (f->stepper)
        f->ops->destroy(f->stepper);
    cns_jet_free(f->check);
    cns_vector_free(f->x0);
    cns_vector_free(f->x1);
    cns_vector_free(f->initial);
    cns_vector_free(f->derivative);
    free(f->bound);
    mpfr_clears(f->t0, f->t1, f->tau, f->last.h, f->tolerance, f->difference, (mpfr_ptr)0);
    mpq_clears(f->grid, f->step, (mpq_ptr)0);
    free(f);
}

size_t cns_flow_bytes(const cns_flow *f)
{
    return f->ops->bytes(f->stepper) + cns_jet_bytes(f->check) + cns_vector_bytes(4 * f->n, f->spec.prec);
}

/* To t = 0 with the states that are in x1. */
static void restart(cns_flow *f)
{
    for (int i = 0; i < f->n; i++) {
        mpfr_set(f->x0[i], f->x1[i], MPFR_RNDN);
        mpfr_set(f->initial[i], f->x1[i], MPFR_RNDN);
    }
    mpfr_set_zero(f->t0, 1);
    mpfr_set_zero(f->t1, 1);
    mpq_set_ui(f->grid, 0, 1);
    f->steps = f->landings = 0;
    f->last.landed = false;
    f->ops->start(f->stepper);
}

void cns_flow_replace(cns_flow *f, int first, int count, const mpfr_t *x)
{
    for (int i = 0; i < count; i++)
        mpfr_set(f->x1[first + i], x[i], MPFR_RNDN);
}

void cns_flow_start(cns_flow *f, const cns_number *initial)
{
    for (int i = 0; i < f->n; i++)
        cns_number_get_mpfr(f->x1[i], &initial[i]);
    restart(f);
}

void cns_flow_start_at(cns_flow *f, const mpfr_t *initial)
{
    for (int i = 0; i < f->n; i++)
        mpfr_set(f->x1[i], initial[i], MPFR_RNDN);
    restart(f);
}

static cns_code mismatch(const cns_flow *f, int i, cns_error *err)
{
    char difference[64], tolerance[64]; /* in MPFR: doubles do not reach down there */
    mpfr_snprintf(difference, sizeof difference, "%.2Re", f->difference);
    mpfr_snprintf(tolerance, sizeof tolerance, "%.2Re", f->tolerance);
    return cns_fail(
        err, CNS_NUMERIC,
        "t = %.12g: the derivative of %s differs from the right-hand side by %s, more than the %s "
        "that rounding and truncation allow: a wrong branch of abs() or sqrt(), or a wrong constant",
        cns_program_time(f->spec.program, mpfr_get_d(f->t1, MPFR_RNDN)), cns_state_name(f->spec.program, i),
        difference, tolerance);
}

/* The derivative of the dense output at the end of the step against f evaluated there with true abs() and
 * sqrt(), in more bits and with constants of its own: a mismatch is an error of branch or of constants. */
static cns_code verify(cns_flow *f, cns_error *err)
{
    cns_error singular;
    mpfr_set(f->tau, f->last.h, MPFR_RNDN);
    f->ops->derivative(f->stepper, f->tau, f->derivative, f->tolerance);
    cns_jet_begin(f->check, 1);
    for (int i = 0; i < f->n; i++)
        cns_jet_set_state(f->check, i, f->x1[i]);
    if (cns_jet_expand(f->check, 1, &singular))
        return CNS_OK; /* f is not defined there; the next step will say so, if that is still true */
    for (int i = 0; i < f->n; i++) {
        cns_jet_coefficient(f->check, f->difference, i, 1);
        mpfr_sub(f->difference, f->difference, f->derivative[i], MPFR_RNDN);
        if (mpfr_cmpabs(f->difference, f->tolerance) > 0)
            return mismatch(f, i, err);
    }
    return CNS_OK;
}

/* The bits by which a state exceeds its scale, or what it began with: none if it is zero. */
static long excess_bits(const cns_flow *f, int i, bool beyond_initial)
{
    int scale;
    frexp(f->spec.scales[i], &scale);
    long least = scale;
    if (beyond_initial && mpfr_regular_p(f->initial[i]) && mpfr_get_exp(f->initial[i]) > least)
        least = mpfr_get_exp(f->initial[i]);
    return cns_program_is_dynamic(f->spec.program, i) && mpfr_regular_p(f->x1[i])
               ? mpfr_get_exp(f->x1[i]) - least
               : 0;
}

/* A state that has grown by as many digits as half of those carried is lost; near a pole the steps would
 * shrink for ever instead. */
static bool runs_away(const cns_flow *f, int i)
{
    return excess_bits(f, i, true) > f->spec.prec / 2;
}

/* A state is rounded relative to its own size, noise is counted in its scale. The guard bits cover what is
 * usual. */
static void count_size(cns_flow *f)
{
    for (int i = 0; i < f->n; i++)
        f->last.noise_log2 =
            fmax(f->last.noise_log2, (double)(excess_bits(f, i, false) - CNS_USUAL_SIZE_BITS - f->spec.prec));
}

/* A step of fixed length has failed. Does the solution itself go on beyond it? A Taylor series in double
 * precision, whose steps are as short as they have to be, tells, from the initial state: the state that the
 * step began with may be none of the solution's any more. */
static bool step_is_too_large(const cns_flow *f)
{
    cns_error ignored;
    if (f->spec.step == NULL)
        return false;
    cns_flow_spec spec =
        cns_flow_spec_taylor(f->spec.program, f->spec.scales, CNS_ARITH_DOUBLE, CNS_DOUBLE_DIGITS);
    spec.stop = f->spec.stop;
    cns_flow *other = cns_flow_new(&spec, &ignored);
    if (other == NULL)
        return false;
    cns_flow_start_at(other, (const mpfr_t *)f->initial);
    mpfr_set_q(other->tolerance, f->step, MPFR_RNDN);
    mpfr_add(other->tolerance, other->tolerance, f->t0, MPFR_RNDN);
    cns_code code = CNS_OK;
    while (!code && mpfr_less_p(other->t1, other->tolerance))
        code = cns_flow_step(other, &ignored);
    cns_flow_free(other);
    return !code;
}

/* The failure of the step that begins at t, and whose fault it is. */
static cns_code failed(const cns_flow *f, cns_code code, const char *what, const char *otherwise,
                       cns_error *err)
{
    const double t = cns_program_time(f->spec.program, mpfr_get_d(f->t0, MPFR_RNDN));
    if (code != CNS_NUMERIC || !step_is_too_large(f))
        return cns_fail(err, code, "t = %.12g: %s%s", t, what, otherwise);
    return cns_fail(err, code,
                    "t = %.12g: %s: the step of %s is too large; the solution itself goes on there", t, what,
                    f->spec.step->text);
}

/* What a run of K digits keeps of the state at the end of a step. The step's noise is then at least what was
 * cut off. A component that a landing has set to 0 stays 0. */
static void round_state(cns_flow *f)
{
    double largest = f->last.noise_log2;
    for (int i = 0; i < f->n; i++) {
        mpfr_set(f->difference, f->x1[i], MPFR_RNDN);
        cns_round_significant(f->x1[i], f->spec.round_digits);
        if (!cns_program_is_dynamic(f->spec.program, i))
            continue;
        mpfr_sub(f->difference, f->difference, f->x1[i], MPFR_RNDN);
        mpfr_div_d(f->difference, f->difference, f->spec.scales[i], MPFR_RNDN);
        largest = fmax(largest, cns_log2_mpfr(f->difference));
    }
    f->last.noise_log2 = largest;
}

cns_code cns_flow_step(cns_flow *f, cns_error *err)
{
    cns_error inner;
    mpq_t next;
    cns_code code = cns_go_on(f->spec.stop, err);
    if (code)
        return code;
    mpfr_t *swap = f->x0;
    f->x0 = f->x1;
    f->x1 = swap;
    mpfr_set(f->t0, f->t1, MPFR_RNDN);
    f->last.limit = NULL;
    if (f->spec.step) { /* to the next point of the grid, from wherever a kink left us */
        mpq_init(next);
        mpq_add(next, f->grid, f->step);
        mpfr_set_q(f->tau, next, MPFR_RNDN);
        mpfr_sub(f->tau, f->tau, f->t0, MPFR_RNDN);
        f->last.limit = &f->tau;
    }
    f->last.landed = false;
    f->last.t0 = mpfr_get_d(f->t0, MPFR_RNDN);
    code = f->ops->step(f->stepper, &f->last, f->x0, f->x1, &inner);
    if (!code) {
        if (f->spec.step && !f->last.landed) {
            mpq_set(f->grid, next);
            mpfr_set_q(f->t1, f->grid, MPFR_RNDN);
        } else {
            mpfr_add(f->t1, f->t0, f->last.h, MPFR_RNDN);
        }
    }
    if (f->spec.step)
        mpq_clear(next);
    if (code)
        return failed(f, code, inner.text, "", err);
    if (mpfr_lessequal_p(f->t1, f->t0))
        return failed(f, CNS_NUMERIC, "the step underflows", ": a singularity", err);
    for (int i = 0; i < f->n; i++) {
        const bool finite = mpfr_number_p(f->x1[i]) != 0;
        if (finite && !runs_away(f, i))
            continue;
        snprintf(inner.text, sizeof inner.text, "%s %s", cns_state_name(f->spec.program, i),
                 finite ? "grows without bound" : "is not a finite number after the step");
        return failed(f, CNS_NUMERIC, inner.text, finite ? ": a pole" : "", err);
    }
    count_size(f);
    f->steps++;
    f->landings += f->last.landed;
    code = f->check ? verify(f, err) : CNS_OK;
    if (!code && f->spec.round_digits > 0)
        round_state(f);
    return code;
}

/* Where steps of fixed length differ by the rounding of times only: do all of them have the same length at
 * the precision of the states? It is left in f->tau. */
static bool is_steady(cns_flow *f)
{
    enum { ROUNDING_LOG2 = 150 }; /* of times, relative to a step, and far more */
    mpfr_t h[3];
    for (int i = 0; i < 3; i++)
        mpfr_init2(h[i], i == 2 ? f->spec.prec : mpfr_get_prec(f->tau));
    mpfr_set_q(h[0], f->step, MPFR_RNDN);
    mpfr_div_2ui(h[1], h[0], ROUNDING_LOG2, MPFR_RNDN);
    mpfr_set(h[2], h[0], MPFR_RNDN);
    bool steady = true;
    for (int turn = 0; turn < 2; turn++) {
        mpfr_t near;
        mpfr_init2(near, f->spec.prec);
        (turn == 0 ? mpfr_add : mpfr_sub)(near, h[0], h[1], MPFR_RNDN);
        steady = steady && mpfr_equal_p(near, h[2]);
        mpfr_clear(near);
    }
    mpfr_set(f->tau, h[2], MPFR_RNDN);
    for (int i = 0; i < 3; i++)
        mpfr_clear(h[i]);
    return steady;
}

long cns_flow_skip(cns_flow *f, double time)
{
    enum { AT_ONCE = 1 << 14 };
    if (!f->bound || !f->spec.step)
        return 0;
    const double from = mpfr_get_d(f->t1, MPFR_RNDN), h = cns_number_get_d(f->spec.step),
                 steps = (time - from) / h * (1 - 1e-12) - 2;
    if (!(steps >= 1) || !is_steady(f))
        return 0;
    const long made =
        f->ops->stride(f->stepper, f->tau, f->bound, steps < AT_ONCE ? (long)steps : AT_ONCE, f->x1);
    if (made > 0) {
        mpq_t moved;
        mpq_init(moved);
        mpq_set_si(moved, made, 1);
        mpq_mul(moved, moved, f->step);
        mpq_add(f->grid, f->grid, moved);
        mpfr_set_q(f->t1, f->grid, MPFR_RNDN);
        mpq_clear(moved);
        f->steps += made;
    }
    return made;
}

int cns_flow_states(const cns_flow *f)
{
    return f->n;
}

mpfr_prec_t cns_flow_prec(const cns_flow *f)
{
    return f->spec.prec;
}

mpfr_srcptr cns_flow_begin(const cns_flow *f)
{
    return f->t0;
}

mpfr_srcptr cns_flow_end(const cns_flow *f)
{
    return f->t1;
}

const mpfr_t *cns_flow_state(const cns_flow *f)
{
    return (const mpfr_t *)f->x1;
}

const mpfr_t *cns_flow_begin_state(const cns_flow *f)
{
    return (const mpfr_t *)f->x0;
}

bool cns_flow_landed(const cns_flow *f)
{
    return f->last.landed;
}

double cns_flow_noise_log2(const cns_flow *f)
{
    return f->last.noise_log2;
}

bool cns_flow_reach(const cns_flow *f, double tolerance_log2, int order, double *h_log2)
{
    return f->ops->reach && f->ops->reach(f->stepper, tolerance_log2, order, h_log2);
}

long cns_flow_steps(const cns_flow *f)
{
    return f->steps;
}

long cns_flow_landings(const cns_flow *f)
{
    return f->landings;
}

void cns_flow_eval(cns_flow *f, const mpq_t t, mpfr_t *x)
{
    if (f->steps == 0) {
        for (int i = 0; i < f->n; i++)
            mpfr_set(x[i], f->x1[i], MPFR_RNDN);
        return;
    }
    mpfr_set_q(f->tau, t, MPFR_RNDN);
    mpfr_sub(f->tau, f->tau, f->t0, MPFR_RNDN);
    if (mpfr_sgn(f->tau) < 0)
        mpfr_set_zero(f->tau, 1);
    f->ops->eval(f->stepper, f->tau, x);
}

mpfr_t *cns_flow_polynomial(cns_flow *f, int state, int *degree, mpfr_t unit)
{
    return f->ops->polynomial(f->stepper, state, degree, unit);
}

const cns_jet *cns_flow_expansion(const cns_flow *f, double *H)
{
    return f->ops->expansion && f->steps > 0 ? f->ops->expansion(f->stepper, H) : NULL;
}
