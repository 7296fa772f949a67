/* The classical Runge-Kutta method of order 4, in any arithmetic, with cubic Hermite interpolation. It steps
 * over kinks without noticing, as in Xu, Li, Li, Liao, section 2.2: that is what it is here for. */
#include <math.h>
#include <stdlib.h>

#include "arith/straight.h"
#include "method.h"
#include "numerics.h"

/* Registers: n each of the state and the weighted sum of slopes; then three constants. */
enum { STATE, SUM, BLOCKS };
enum { HALF_H, H, SIXTH_H, CONSTANTS };
enum { CUBIC = 3 };

struct cns_stepper {
    cns_flow_spec spec;
    int n;
    cns_jet *jet;
    mpfr_t h, a, b;          /* the step; scratch */
    mpfr_t *x, *y, *f0, *f1; /* both ends of the last step, and the slopes there */
    bool have_f1;
    mpfr_t *cubic;       /* the coefficients of one state's interpolation */
    cns_arith *straight; /* with the C library's double: the right-hand side for strides; else NULL */
    bool recorded;
    double *now, *sum; /* of a stride: the states, and the weighted sum of slopes */
};

static void destroy(cns_stepper *s)
{
    if (!s)
        return;
    cns_jet_free(s->jet);
    cns_vector_free(s->x);
    cns_vector_free(s->y);
    cns_vector_free(s->f0);
    cns_vector_free(s->f1);
    cns_vector_free(s->cubic);
    cns_straight_free(s->straight);
    free(s->now);
    free(s->sum);
    mpfr_clears(s->h, s->a, s->b, (mpfr_ptr)0);
    free(s);
}

static cns_stepper *create(const cns_flow_spec *spec, cns_error *err)
{
    cns_stepper *s = calloc(1, sizeof *s);
    if (!s) {
        cns_out_of_memory(err);
        return NULL;
    }
    s->spec = *spec;
    s->n = cns_program_states(spec->program);
    mpfr_inits2(spec->prec, s->h, s->a, s->b, (mpfr_ptr)0);
    cns_jet_spec jet = {.program = spec->program,
                        .ops = cns_flow_arith(spec),
                        .order = 1,
                        .prec = spec->prec,
                        .registers = BLOCKS * s->n + CONSTANTS};
    s->x = cns_vector_new(s->n, spec->prec);
    s->y = cns_vector_new(s->n, spec->prec);
    s->f0 = cns_vector_new(s->n, spec->prec);
    s->f1 = cns_vector_new(s->n, spec->prec);
    s->cubic = cns_vector_new(CUBIC + 1, spec->prec);
    s->jet = cns_jet_new(&jet, err);
    bool complete = s->jet && s->x && s->y && s->f0 && s->f1 && s->cubic;
    if (complete && jet.ops == &cns_arith_libm) {
        s->straight = cns_straight_new(cns_jet_series(s->jet));
        s->now = calloc((size_t)s->n + 1, sizeof *s->now);
        s->sum = calloc((size_t)s->n + 1, sizeof *s->sum);
        complete = s->straight && s->now && s->sum;
    }
    if (!complete) {
        if (s->jet)
            cns_out_of_memory(err);
        destroy(s);
        return NULL;
    }
    return s;
}

static size_t bytes(const cns_stepper *s)
{
    return cns_jet_bytes(s->jet) + cns_vector_bytes(4 * s->n, s->spec.prec);
}

static void start(cns_stepper *s)
{
    cns_jet_begin(s->jet, 1);
    s->have_f1 = false;
}

static int reg(const cns_stepper *s, int block, int i)
{
    return cns_jet_register(s->jet, block * s->n + i);
}

/* x_i(stage) = x_i + c f_i, into the states of the jet, and the slopes into their weighted sum. */
static void advance(cns_stepper *s, int c, int weight)
{
    const cns_arith_ops *ops = cns_jet_ops(s->jet);
    cns_arith *A = cns_jet_arith(s->jet);
    for (int i = 0; i < s->n; i++) {
        int state = cns_jet_state_series(s->jet, i);
        ops->zero(A);
        if (weight > 0) {
            ops->coef(A, 1, reg(s, SUM, i), 0);
            ops->coef(A, weight, state, 1);
        } else {
            ops->coef(A, 1, state, 1);
        }
        ops->store(A, reg(s, SUM, i), 0);
        ops->zero(A);
        ops->coef(A, 1, reg(s, STATE, i), 0);
        if (c == SIXTH_H)
            ops->scaled(A, 1, reg(s, BLOCKS, SIXTH_H), reg(s, SUM, i), 0);
        else
            ops->scaled(A, 1, reg(s, BLOCKS, c), state, 1);
        ops->store(A, state, 0);
    }
}

static cns_code step(cns_stepper *s, cns_step *step, mpfr_t *x, mpfr_t *y, cns_error *err)
{
    static const struct {
        int c;
        int weight; /* of this slope in the sum; 0 starts it */
    } stage[4] = {{HALF_H, 0}, {HALF_H, 2}, {H, 2}, {SIXTH_H, 1}};
    const cns_arith_ops *ops = cns_jet_ops(s->jet);
    cns_arith *A = cns_jet_arith(s->jet);

    mpfr_set(step->h, *step->limit, MPFR_RNDN);
    mpfr_set(s->h, step->h, MPFR_RNDN);
    ops->set(A, reg(s, BLOCKS, H), 0, s->h, true);
    mpfr_div_2ui(s->a, s->h, 1, MPFR_RNDN);
    ops->set(A, reg(s, BLOCKS, HALF_H), 0, s->a, true);
    mpfr_div_ui(s->a, s->h, 6, MPFR_RNDN);
    ops->set(A, reg(s, BLOCKS, SIXTH_H), 0, s->a, true);
    for (int i = 0; i < s->n; i++) {
        cns_jet_set_state(s->jet, i, x[i]);
        ops->set(A, reg(s, STATE, i), 0, x[i], false);
        mpfr_set(s->x[i], x[i], MPFR_RNDN);
    }
    for (int k = 0; k < 4; k++) {
        cns_code code = cns_jet_expand(s->jet, 1, err);
        if (code)
            return code;
        if (k == 0)
            for (int i = 0; i < s->n; i++)
                ops->get(A, s->f0[i], cns_jet_state_series(s->jet, i), 1);
        advance(s, stage[k].c, stage[k].weight);
    }
    for (int i = 0; i < s->n; i++) {
        ops->get(A, y[i], cns_jet_state_series(s->jet, i), 0);
        mpfr_set(s->y[i], y[i], MPFR_RNDN);
    }
    s->have_f1 = false;
    step->landed = false;
    step->noise_log2 = -(double)s->spec.prec;
    return CNS_OK;
}

/* Slopes for the states among the straight code's values, which is recorded anew where a sign has changed. */
static bool slopes(cns_stepper *s)
{
    if (s->recorded && cns_straight_run(s->straight))
        return true;
    for (int i = 0; i < s->n; i++) {
        mpfr_set_d(s->a, cns_straight_values(s->straight)[cns_jet_state_series(s->jet, i)], MPFR_RNDN);
        cns_jet_set_state(s->jet, i, s->a);
    }
    s->recorded = cns_jet_record(s->jet, s->straight);
    return s->recorded && cns_straight_run(s->straight);
}

/* As `step`, operation for operation. False: the step is not made. */
static bool straight_step(cns_stepper *s, double h, const double *bound)
{
    const double half_h = h / 2, sixth_h = h / 6;
    const int n = s->n, slope = cns_jet_series(s->jet);
    double *const v = cns_straight_values(s->straight), *const x = s->now, *const sum = s->sum;
    for (int i = 0; i < n; i++)
        v[i] = x[i];
    for (int k = 0; k < 4; k++) {
        if (!slopes(s))
            return false;
        const double *f = v + slope;
        if (k == 0)
            for (int i = 0; i < n; i++)
                sum[i] = f[i], v[i] = x[i] + half_h * f[i];
        else if (k < 3)
            for (int i = 0; i < n; i++)
                sum[i] += 2 * f[i], v[i] = x[i] + (k == 1 ? half_h : h) * f[i];
        else
            for (int i = 0; i < n; i++)
                v[i] = x[i] + sixth_h * (sum[i] + f[i]);
    }
    for (int i = 0; i < n; i++)
        if (!(fabs(v[i]) < bound[i]))
            return false;
    for (int i = 0; i < n; i++)
        x[i] = v[i];
    return true;
}

static long stride(cns_stepper *s, const mpfr_t h, const double *bound, long most, mpfr_t *x)
{
    const double length = mpfr_get_d(h, MPFR_RNDN);
    long made = 0;
    if (s->straight == NULL || !isnormal(length / 6))
        return 0;
    for (int i = 0; i < s->n; i++)
        s->now[i] = mpfr_get_d(x[i], MPFR_RNDN);
    while (made < most && straight_step(s, length, bound))
        made++;
    for (int i = 0; i < s->n; i++)
        mpfr_set_d(x[i], s->now[i], MPFR_RNDN);
    return made;
}

/* The slopes at the end of the step, once something inside it is asked for. */
static void need_f1(cns_stepper *s)
{
    cns_error ignored;
    if (s->have_f1)
        return;
    for (int i = 0; i < s->n; i++)
        cns_jet_set_state(s->jet, i, s->y[i]);
    if (cns_jet_expand(s->jet, 1, &ignored))
        for (int i = 0; i < s->n; i++) { /* singular there: the secant's slope serves */
            mpfr_sub(s->f1[i], s->y[i], s->x[i], MPFR_RNDN);
            mpfr_div(s->f1[i], s->f1[i], s->h, MPFR_RNDN);
        }
    else
        for (int i = 0; i < s->n; i++)
            cns_jet_coefficient(s->jet, s->f1[i], i, 1);
    s->have_f1 = true;
}

/* Cubic Hermite: with u = tau/h,
 * x + u h f0 + u^2 (3 (y - x) - h (2 f0 + f1)) + u^3 (2 (x - y) + h (f0 + f1)); its error, O(h^4), is that of
 * the method over a fixed time. */
static mpfr_t *polynomial(cns_stepper *s, int i, int *degree, mpfr_t unit)
{
    mpfr_t *c = s->cubic;
    need_f1(s);
    *degree = CUBIC;
    mpfr_set(unit, s->h, MPFR_RNDN);
    mpfr_set(c[0], s->x[i], MPFR_RNDN);
    mpfr_mul(c[1], s->f0[i], s->h, MPFR_RNDN);
    mpfr_sub(s->a, s->y[i], s->x[i], MPFR_RNDN);
    mpfr_mul_2ui(c[3], s->a, 1, MPFR_RNDN);
    mpfr_neg(c[3], c[3], MPFR_RNDN);
    mpfr_mul_ui(c[2], s->a, 3, MPFR_RNDN);
    mpfr_add(s->a, s->f0[i], s->f1[i], MPFR_RNDN);
    mpfr_mul(s->b, s->a, s->h, MPFR_RNDN);
    mpfr_add(c[3], c[3], s->b, MPFR_RNDN);
    mpfr_add(s->a, s->a, s->f0[i], MPFR_RNDN);
    mpfr_mul(s->b, s->a, s->h, MPFR_RNDN);
    mpfr_sub(c[2], c[2], s->b, MPFR_RNDN);
    return c;
}

static void eval(cns_stepper *s, const mpfr_t tau, mpfr_t *x)
{
    mpfr_t u, unit;
    int degree;
    mpfr_inits2(s->spec.prec, u, unit, (mpfr_ptr)0);
    mpfr_div(u, tau, s->h, MPFR_RNDN);
    for (int i = 0; i < s->n; i++) {
        mpfr_t *c = polynomial(s, i, &degree, unit);
        mpfr_set(s->a, c[degree], MPFR_RNDN);
        for (int k = degree - 1; k >= 0; k--) {
            mpfr_mul(s->a, s->a, u, MPFR_RNDN);
            mpfr_add(s->a, s->a, c[k], MPFR_RNDN);
        }
        mpfr_set(x[i], s->a, MPFR_RNDN);
        if (mpfr_cmp_ui(u, 1) == 0) /* the end itself, without the rounding of the interpolation */
            mpfr_set(x[i], s->y[i], MPFR_RNDN);
    }
    mpfr_clears(u, unit, (mpfr_ptr)0);
}

const cns_method_ops cns_method_rk4 = {
    .name = "rk4",
    .create = create,
    .destroy = destroy,
    .bytes = bytes,
    .start = start,
    .step = step,
    .stride = stride,
    .eval = eval,
    .polynomial = polynomial,
};
