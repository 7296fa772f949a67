/* The running envelope of a trajectory in closed form, and the maxima that it is made of. */
#include <math.h>

#include "problem.h"
#include "study/predict/envelope.h"
#include "study/predict/peak.h"

typedef struct curve {
    int kind, calls;
} curve;

enum { PARABOLA, SINE, STRAIGHT, FALLING, CURVES };
static const double vertex[CURVES] = {0.3, 1.5707963267948966, 2,
                                      1}; /* where it is largest on its interval */
static const double interval[CURVES][3] = {{0, 0.5, 1}, {1, 1.5, 2}, {0, 1, 2}, {1, 1.5, 2}};

static double value_of(void *context, double t)
{
    curve *c = context;
    c->calls++;
    switch (c->kind) {
    case PARABOLA:
        return 2 - (t - 0.3) * (t - 0.3);
    case SINE:
        return sin(t);
    case STRAIGHT:
        return t;
    default: /* the maximum is near, but before the interval */
        return 1 - (t - 0.8) * (t - 0.8);
    }
}

START_TEST(peak_is_found)
{
    curve c = {_i, 0};
    const double *t = interval[_i], value[] = {value_of(&c, t[0]), value_of(&c, t[1]), value_of(&c, t[2])};
    c.calls = 0;
    const cns_peak p = cns_peak_find(value_of, &c, t, value, -1);
    ck_assert_double_eq_tol(p.t, vertex[_i], 1e-7);
    ck_assert_double_eq_tol(p.value, value_of(&c, vertex[_i]), 1e-15);
    c.calls = 0;
    const cns_peak low =
        cns_peak_find(value_of, &c, t, value, 1e9); /* so high it is not: nothing is looked at */
    ck_assert_int_eq(c.calls, 0);
    ck_assert_double_le(low.value, p.value);
    for (int k = 0; k < 3; k++)
        ck_assert_double_ge(low.value, value[k]);
}
END_TEST

/* p + i q = exp((a - i) t) i: p = e^(a t) sin t */
static void spiral(cns_program *p, const cns_model *model)
{
    const int a = cns_constant(p, model->data), x = cns_state(p, 0), y = cns_state(p, 1);
    cns_derivative(p, 0, cns_add(p, cns_mul(p, a, x), y));
    cns_derivative(p, 1, cns_sub(p, cns_mul(p, a, y), x));
}

/* The largest |e^(a s) sin s|, 0 <= s <= t: |u| has its maxima at pi - atan(1/a) + k pi for a > 0, where for
 * a < 0 only the first one counts. */
static double spiral_envelope(double a, double t)
{
    const double pi = acos(-1), first = pi / 2 + atan(a);
    double E = fabs(exp(a * t) * sin(t));
    for (double s = first; s <= t; s += pi)
        E = fmax(E, fabs(exp(a * s) * sin(s)));
    return E;
}

/* Steps of a swinging that is nowhere singular are long: with 1500 digits many turns of |u|. */
START_TEST(envelope_of_a_spiral)
{
    static const char *const rate[] = {"1/10", "-1/10", "1/10", "-1/10", "0"};
    static const double a[] = {0.1, -0.1, 0.1, -0.1, 0};
    static const long digits[] = {20, 20, 1500, 1500, 100};
    const char *const initial[] = {"0", "1"};
    cns_error err;
    cns_model model = unit_model(2, spiral, rate[_i]);
    cns_system *system = unit_system(&model, initial);
    const cns_trajectory_spec spec = {.flow = taylor_spec(cns_system_program(system), digits[_i]),
                                      .initial = cns_system_initial(system),
                                      .no_growth = true};
    cns_trajectory *t = cns_trajectory_new(&spec, &err);
    ck_assert_ptr_nonnull(t);
    cns_envelope e;
    cns_sample s = {0};
    mpfr_t E;
    mpq_t time;
    mpq_init(time);
    mpfr_init2(E, CNS_ENVELOPE_BITS);
    check_ok(cns_envelope_init(&e, 3, &spec.flow, &err), &err);
    ck_assert(cns_sample_init(&s, cns_system_program(system), 64));
    uint64_t random = test_seed();
    double longest = 0;
    while (mpfr_cmp_ui(cns_flow_end(cns_trajectory_flow(t)), 40) < 0) {
        check_ok(cns_trajectory_step(t, &err), &err);
        cns_envelope_follow(&e, t);
        const double begin = mpfr_get_d(cns_flow_begin(cns_trajectory_flow(t)), MPFR_RNDU),
                     end = mpfr_get_d(cns_flow_end(cns_trajectory_flow(t)), MPFR_RNDD);
        longest = fmax(longest, end - begin);
        for (int k = 0; k < 200; k++) {
            const double at = begin + (end - begin) * test_random_unit(&random);
            mpq_set_d(time, at);
            cns_trajectory_peek(t, time, &s);
            cns_envelope_at(&e, CNS_TC_STATE(0), at, s.state[0], E);
            ck_assert_double_eq_tol(mpfr_get_d(E, MPFR_RNDN) / spiral_envelope(a[_i], at), 1, 1e-12);
        }
    }
    if (digits[_i] == 1500)
        ck_assert_double_gt(longest, 30);
    cns_envelope_clear(&e);
    cns_sample_clear(&s);
    cns_trajectory_free(t);
    cns_system_free(system);
    mpfr_clear(E);
    mpq_clear(time);
}
END_TEST

/* What was known before the trajectory began counts, and what is not defined does not. */
START_TEST(envelope_from_before)
{
    const char *const initial[] = {"0", "1"};
    cns_error err;
    cns_model model = unit_model(2, spiral, "0");
    cns_system *system = unit_system(&model, initial);
    const cns_flow_spec flow = taylor_spec(cns_system_program(system), 20);
    cns_envelope e;
    mpfr_t E, u;
    mpfr_inits2(CNS_ENVELOPE_BITS, E, u, (mpfr_ptr)0);
    check_ok(cns_envelope_init(&e, 3, &flow, &err), &err);
    mpfr_set_nan(u);
    cns_envelope_at(&e, CNS_TC_STATE(0), 0, u, E);
    ck_assert(mpfr_zero_p(E));
    mpfr_set_si(u, -7, MPFR_RNDN);
    cns_envelope_raise(&e, CNS_TC_STATE(0), u);
    mpfr_set_si(u, 3, MPFR_RNDN);
    cns_envelope_raise(&e, CNS_TC_STATE(0), u);
    cns_envelope_at(&e, CNS_TC_STATE(0), 0, u, E);
    ck_assert_int_eq(mpfr_cmp_si(E, 7), 0);
    cns_envelope_at(&e, CNS_TC_STATE(1), 0, u, E);
    ck_assert_int_eq(mpfr_cmp_si(E, 3), 0);
    cns_envelope_clear(&e);
    cns_system_free(system);
    mpfr_clears(E, u, (mpfr_ptr)0);
}
END_TEST

Suite *suite_envelope(void)
{
    Suite *s = suite_create("envelope");
    TCase *t = tcase_create("envelope");
    tcase_add_loop_test(t, peak_is_found, 0, CURVES);
    tcase_add_loop_test(t, envelope_of_a_spiral, 0, 5);
    tcase_add_test(t, envelope_from_before);
    suite_add_tcase(s, t);
    return s;
}
