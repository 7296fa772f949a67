/* K-digit runs, and critical predictable times that are known in closed form. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "problem.h"
#include "study/predict/tc_internal.h"

enum { MAX_STATES = 6 };

typedef struct setting {
    cns_model model;
    cns_system *system;
    cns_number *planted; /* states at t = 0 of the run under test */
    cns_number *times;   /* end, every, delta */
} setting;

typedef void builder(cns_program *p, const cns_model *model);

static void setting_init(setting *s, int n, builder *build, const char *const *initial,
                         const char *const *planted, const char *end, const char *every, const char *delta)
{
    const char *const times[] = {end, every, delta};
    s->model = unit_model(n, build, NULL);
    s->system = unit_system(&s->model, initial);
    s->planted = numbers_new(n, planted);
    s->times = numbers_new(3, times);
}

static void setting_clear(setting *s)
{
    numbers_free(s->planted, s->model.n_states);
    numbers_free(s->times, 3);
    cns_system_free(s->system);
}

/* x' = x, y' = -y */
static void saddle(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_derivative(p, 0, cns_state(p, 0));
    cns_derivative(p, 1, cns_neg(p, cns_state(p, 1)));
}

/* x' = 1 */
static void uniform(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_derivative(p, 0, cns_constant(p, "1"));
}

/* Two fine runs that differ in their initial states. */
static void compare_planted(const setting *s, cns_tc_criterion criterion, cns_tc_result *r)
{
    cns_error err;
    cns_trajectory_spec test = {.flow = taylor_spec(cns_system_program(s->system), 40),
                                .initial = s->planted},
                        reference = {.flow = taylor_spec(cns_system_program(s->system), 60),
                                     .initial = cns_system_initial(s->system)};
    cns_tc_pair pair = {.test = &test,
                        .reference = &reference,
                        .end = &s->times[0],
                        .every = &s->times[1],
                        .delta = &s->times[2],
                        .criterion = criterion,
                        .until = CNS_TC_EVERY_ONE};
    check_ok(cns_tc_compare(&pair, r, &err), &err);
    ck_assert(r->trusted);
    ck_assert_int_eq(r->n, 1 + s->model.n_states);
}

static void check_found(const cns_tc_time *t, double time, double row)
{
    ck_assert_int_eq((int)t->kind, CNS_TC_FOUND);
    ck_assert_double_eq_tol(t->t, time, 3e-7);
    ck_assert_double_eq_tol(t->row, row, 3e-7);
}

/* 1e-8 e^t = 0.01 at t = ln 1e6, whatever the rows; x itself is off by 1e-8 of its size for ever. */
START_TEST(planted_difference)
{
    static const char *const every[] = {"0.5", "1/3", "13.9", "20", "0.01"};
    static const double row[] = {14, 14, 13.9, 20, 13.82};
    const char *const initial[] = {"1", "0"}, *const planted[] = {"1.00000001", "0"};
    setting s;
    cns_tc_result r;
    setting_init(&s, 2, saddle, initial, planted, "20", every[_i], "0.01");
    for (int rows = 0; rows < 2; rows++) {
        compare_planted(&s, rows ? CNS_TC_ROWS : CNS_TC_ENVELOPE, &r);
        check_found(&r.time[CNS_TC_NORM], log(1e6), rows ? row[_i] : log(1e6));
        ck_assert_int_eq((int)r.time[CNS_TC_STATE(0)].kind, CNS_TC_BEYOND);
        ck_assert_double_eq(r.time[CNS_TC_STATE(0)].t, 20);
        ck_assert_int_eq((int)r.time[CNS_TC_STATE(1)].kind, CNS_TC_IDENTICAL);
        cns_tc_result_clear(&r);
    }
    setting_clear(&s);
}
END_TEST

/* A difference far below delta at one row and beyond it at the next is still found inside. */
START_TEST(one_long_interval)
{
    const char *const initial[] = {"1", "0"}, *const planted[] = {"1.00000000000001", "0"};
    setting s;
    cns_tc_result r;
    setting_init(&s, 2, saddle, initial, planted, "30", "30", "0.01");
    for (int rows = 0; rows < 2; rows++) {
        compare_planted(&s, rows ? CNS_TC_ROWS : CNS_TC_ENVELOPE, &r);
        check_found(&r.time[CNS_TC_NORM], log(1e12), rows ? 30 : log(1e12));
        cns_tc_result_clear(&r);
    }
    setting_clear(&s);
}
END_TEST

START_TEST(zero_over_zero_and_x_over_zero)
{
    const char *const initial[] = {"0", "0"}, *const planted[] = {"1e-20", "0"};
    setting s;
    cns_tc_result r;
    setting_init(&s, 2, saddle, initial, planted, "60", "0.5", "0.01");
    for (int rows = 0; rows < 2; rows++) {
        compare_planted(&s, rows ? CNS_TC_ROWS : CNS_TC_ENVELOPE, &r);
        check_found(&r.time[CNS_TC_NORM], 18 * log(10), rows ? 41.5 : 18 * log(10));
        check_found(&r.time[CNS_TC_STATE(0)], 0, 0);
        ck_assert_int_eq((int)r.time[CNS_TC_STATE(1)].kind, CNS_TC_IDENTICAL);
        cns_tc_result_clear(&r);
    }
    setting_clear(&s);
}
END_TEST

START_TEST(observable_near_its_zero)
{
    /* u2 = t - 0.505, u1 = u2 + 1e-4: off by more than 1 % while |t - 0.505| < 0.01. The row 0.5 is in
     * there; without a row in there nothing fires. Of its envelope, 0.505 and more, 1e-4 is no percent. */
    const char *const initial[] = {"-0.505"}, *const planted[] = {"-0.5049"};
    for (int hit = 0; hit < 2; hit++) {
        setting s;
        cns_tc_result r;
        setting_init(&s, 1, uniform, initial, planted, "1.2", hit ? "0.5" : "0.4", "0.01");
        compare_planted(&s, CNS_TC_ROWS, &r);
        ck_assert_int_eq((int)r.time[CNS_TC_NORM].kind, CNS_TC_IDENTICAL); /* no state feeds back */
        if (hit)
            check_found(&r.time[CNS_TC_STATE(0)], 0.495, 0.5);
        else
            ck_assert_int_eq((int)r.time[CNS_TC_STATE(0)].kind, CNS_TC_BEYOND);
        cns_tc_result_clear(&r);
        compare_planted(&s, CNS_TC_ENVELOPE, &r);
        ck_assert_int_eq((int)r.time[CNS_TC_STATE(0)].kind, CNS_TC_BEYOND);
        cns_tc_result_clear(&r);
        setting_clear(&s);
    }
}
END_TEST

/* p + i q = exp((0.1 - i) t) i in the states 0 and 1: p = e^(t/10) sin t. g = g(0) e^t. w' = p' + g, so that
 * w - p = g - g(0) where w(0) = 0. */
static void swinging(cns_program *p, const cns_model *model)
{
    (void)model;
    const int tenth = cns_constant(p, "1/10");
    const int a = cns_state(p, 0), b = cns_state(p, 1), g = cns_state(p, 2);
    const int rise = cns_add(p, cns_mul(p, tenth, a), b);
    cns_derivative(p, 0, rise);
    cns_derivative(p, 1, cns_sub(p, cns_mul(p, tenth, b), a));
    cns_derivative(p, 2, g);
    cns_derivative(p, 3, cns_add(p, rise, g));
}

/* The criterion of the envelope in closed form, for an observable u2 = e^(t/10) sin t that passes through
 * zero all the time and a difference 1e-8 (e^t - 1). Its maxima are where tan t = -10. delta such that T_c is
 * in the middle of the fall from the maximum of |u2| number _i, where the envelope is that maximum; and
 * whatever the rows are. By rows T_c hangs on them. */
START_TEST(observable_through_its_zeros)
{
    static const char *const every[] = {"1", "0.5", "0.1", "0.01", "20"};
    const double pi = acos(-1), crest = pi - atan(10) + _i * pi, high = exp(crest / 10) * fabs(sin(crest));
    const double time = crest + 1, delta = 1e-8 * expm1(time) / high;
    const char *const initial[] = {"0", "1", "0", "0"}, *const planted[] = {"0", "1", "1e-8", "0"};
    char text[64];
    double least = 1e9, most = 0;
    snprintf(text, sizeof text, "%.17e", delta);
    for (int k = 0; k < 5; k++) {
        setting s;
        cns_tc_result r;
        setting_init(&s, 4, swinging, initial, planted, "20", every[k], text);
        compare_planted(&s, CNS_TC_ENVELOPE, &r);
        ck_assert_int_eq((int)r.time[CNS_TC_STATE(3)].kind, CNS_TC_FOUND);
        ck_assert_double_eq_tol(r.time[CNS_TC_STATE(3)].t, time, 1e-10);
        cns_tc_result_clear(&r);
        compare_planted(&s, CNS_TC_ROWS, &r);
        ck_assert_int_eq((int)r.time[CNS_TC_STATE(3)].kind, CNS_TC_FOUND);
        least = fmin(least, r.time[CNS_TC_STATE(3)].t);
        most = fmax(most, r.time[CNS_TC_STATE(3)].t);
        cns_tc_result_clear(&r);
        setting_clear(&s);
    }
    if (_i > 0) /* before that there is no zero */
        ck_assert_double_gt(most - least, 0.1);
}
END_TEST

/* c + i s = exp(i t), w' = c */
static void circling(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_derivative(p, 0, cns_neg(p, cns_state(p, 1)));
    cns_derivative(p, 1, cns_state(p, 0));
    cns_derivative(p, 2, cns_state(p, 0));
}

/* A difference A sin t from 1 that exceeds delta = A / (1 + 1e-6) for a moment around its maximum only: T_c
 * is that moment's beginning, not one a turn later nor none. */
START_TEST(difference_that_only_just_exceeds)
{
    const char *const initial[] = {"0", "0", "1"}, *const planted[] = {"0.01000001", "0", "1"};
    setting s;
    cns_tc_result r;
    setting_init(&s, 3, circling, initial, planted, "20", "20", "0.01");
    compare_planted(&s, CNS_TC_ENVELOPE, &r);
    check_found(&r.time[CNS_TC_STATE(2)], asin(1 / 1.000001), asin(1 / 1.000001));
    cns_tc_result_clear(&r);
    setting_clear(&s);
}
END_TEST

static cns_code measure(const setting *s, const cns_numerics *n, int until, long reference_digits,
                        cns_tc_result *r, cns_error *err)
{
    const cns_problem problem = {.system = s->system, .end = &s->times[0], .every = &s->times[1]};
    const cns_tc_spec spec = {
        .numerics = n, .delta = &s->times[2], .until = until, .reference_digits = reference_digits};
    return cns_tc_measure(&problem, &spec, r, err);
}

static void numerics_init(cns_numerics *n, long digits, const char *step)
{
    cns_error err;
    *n = (cns_numerics){.method = CNS_METHOD_TAYLOR, .arithmetic = CNS_ARITH_FAST, .digits = digits};
    cns_number_init(&n->step);
    cns_number_init(&n->tolerance);
    if (step)
        check_ok(cns_number_parse(&n->step, step, &err), &err);
}

static void numerics_clear(cns_numerics *n)
{
    cns_number_clear(&n->step);
    cns_number_clear(&n->tolerance);
}

/* When x' = x, x(0) = 1, with K digits kept after every step of length 1, is off by 0.01: x_{n+1} is e x_n as
 * a decimal text of K digits, and within a step the difference grows by e^t. */
static double expected_tc(int digits)
{
    mpfr_t x, e, truth, d;
    char text[128];
    double tc = 0;
    mpfr_inits2(400, x, e, truth, d, (mpfr_ptr)0);
    mpfr_set_ui(x, 1, MPFR_RNDN);
    mpfr_exp(e, x, MPFR_RNDN);
    mpfr_set(truth, x, MPFR_RNDN);
    for (int n = 0; tc == 0; n++) {
        mpfr_sub(d, x, truth, MPFR_RNDN);
        double log_d = n > 0 ? log(fabs(mpfr_get_d(d, MPFR_RNDN))) : -1e9;
        if (log(0.01) - log_d < 1)
            tc = n + log(0.01) - log_d;
        mpfr_mul(x, x, e, MPFR_RNDN);
        mpfr_mul(truth, truth, e, MPFR_RNDN);
        mpfr_snprintf(text, sizeof text, "%.*RNe", digits - 1, x);
        mpfr_set_str(x, text, 10, MPFR_RNDN);
    }
    mpfr_clears(x, e, truth, d, (mpfr_ptr)0);
    return tc;
}

START_TEST(rounding_alone)
{
    const char *const initial[] = {"1", "1"};
    const int digits = 6 + 2 * _i;
    setting s;
    cns_tc_result r;
    cns_error err;
    cns_numerics n;
    numerics_init(&n, digits, "1");
    setting_init(&s, 2, saddle, initial, initial, "60", "1/4", "0.01");
    check_ok(measure(&s, &n, CNS_TC_NORM, 0, &r, &err), &err);
    ck_assert_int_ge(r.reference_digits, digits + 20);
    ck_assert_int_eq((int)r.time[CNS_TC_NORM].kind, CNS_TC_FOUND);
    /* y is off, too, by 1e-K at most: nothing beside 0.01. */
    ck_assert_double_eq_tol(r.time[CNS_TC_NORM].t, expected_tc(digits), 1e-6);
    cns_tc_result_clear(&r);
    numerics_clear(&n);
    setting_clear(&s);
}
END_TEST

START_TEST(difference_that_does_not_grow)
{
    const char *const initial[] = {"0", "1"};
    setting s;
    cns_tc_result r;
    cns_error err;
    cns_numerics n;
    numerics_init(&n, 10, NULL);
    setting_init(&s, 2, saddle, initial, initial, "10", "0.5", "0.01");
    check_ok(measure(&s, &n, CNS_TC_NORM, 0, &r, &err), &err);
    ck_assert_int_eq((int)r.time[CNS_TC_NORM].kind, CNS_TC_STILL);
    ck_assert_int_eq((int)r.time[CNS_TC_STATE(0)].kind, CNS_TC_IDENTICAL);
    ck_assert_int_eq((int)r.time[CNS_TC_STATE(1)].kind, CNS_TC_STILL);
    cns_tc_result_clear(&r);
    numerics_clear(&n);
    setting_clear(&s);
}
END_TEST

/* A reference that is no better than the run is not believed; what is said is only what is certain. */
START_TEST(poor_reference)
{
    const char *const initial[] = {"1", "1"};
    setting s;
    cns_tc_result r;
    cns_error err;
    cns_numerics n;
    numerics_init(&n, 12, NULL);
    setting_init(&s, 2, saddle, initial, initial, "60", "1/4", "0.01");
    ck_assert_int_eq((int)measure(&s, &n, CNS_TC_NORM, 14, &r, &err), CNS_UNREACHED);
    ck_assert(!r.trusted);
    ck_assert(strstr(err.text, "more digits") != NULL);
    for (int i = 0; i < r.n; i++)
        ck_assert_int_ne((int)r.time[i].kind, CNS_TC_FOUND);
    double bound = r.time[CNS_TC_NORM].t;
    cns_tc_result_clear(&r);
    check_ok(measure(&s, &n, CNS_TC_NORM, 0, &r, &err), &err);
    ck_assert_double_lt(bound, r.time[CNS_TC_NORM].t);
    cns_tc_result_clear(&r);
    numerics_clear(&n);
    setting_clear(&s);
}
END_TEST

/* With few digits in a long run the first choice of reference digits does not last: more are taken. */
START_TEST(reference_digits_are_raised)
{
    const char *const initial[] = {"0", "0.5"};
    setting s;
    cns_tc_result r;
    cns_error err;
    cns_numerics n;
    numerics_init(&n, 5, NULL);
    /* x = 0 is an invariant line, on which nothing is ever off; an error of the reference may have grown to
     * e^120 times its size all the same. */
    setting_init(&s, 2, saddle, initial, initial, "120", "4", "0.01");
    check_ok(measure(&s, &n, CNS_TC_EVERY_ONE, 0, &r, &err), &err);
    ck_assert_int_gt(r.reference_digits, 5 + 22);
    ck_assert_double_eq(r.compared, 120);
    cns_tc_result_clear(&r);
    numerics_clear(&n);
    setting_clear(&s);
}
END_TEST

/* Every component has K decimals after every step, also after a landing, where omega stays 0; between the
 * ends of a step nothing is rounded. */
START_TEST(digits_kept)
{
    static const char *const initial[] = {"0", "0", "1", "0", "0.01", "1"};
    static const cns_method methods[] = {CNS_METHOD_TAYLOR, CNS_METHOD_TAYLOR, CNS_METHOD_RK4};
    static const cns_arithmetic arithmetics[] = {CNS_ARITH_MPFR, CNS_ARITH_FAST, CNS_ARITH_MPFR};
    enum { DIGITS = 12 };
    cns_system *system = system_new(cns_model_find("apw"), NULL);
    cns_error err;
    cns_numerics n;
    numerics_init(&n, DIGITS, methods[_i] == CNS_METHOD_RK4 ? "0.05" : NULL);
    n.method = methods[_i];
    n.arithmetic = arithmetics[_i];
    cns_flow_spec spec = cns_tc_flow(system, &n, NULL);
    ck_assert_int_eq(spec.round_digits, DIGITS);
    ck_assert_int_gt(spec.prec, cns_digits_to_bits(DIGITS + 10));
    cns_flow *f = flow_started(&spec, initial);
    mpfr_t want, *inner = cns_vector_xnew(MAX_STATES, spec.prec);
    mpq_t middle;
    mpq_init(middle);
    mpfr_init2(want, spec.prec);
    int landings = 0, longer = 0;
    while (mpfr_cmp_ui(cns_flow_end(f), 40) < 0) {
        check_ok(cns_flow_step(f, &err), &err);
        for (int i = 0; i < MAX_STATES; i++) {
            char text[64];
            mpfr_snprintf(text, sizeof text, "%.*RNe", DIGITS - 1, cns_flow_state(f)[i]);
            mpfr_set_str(want, text, 10, MPFR_RNDN);
            ck_assert_msg(mpfr_equal_p(want, cns_flow_state(f)[i]), "state %d has more digits than %s", i,
                          text);
        }
        if (cns_flow_landed(f)) {
            landings++;
            ck_assert(mpfr_zero_p(cns_flow_state(f)[5]));
        }
        ck_assert_double_gt(cns_flow_noise_log2(f), DECIMALS(DIGITS + 2));
        ck_assert_double_lt(cns_flow_noise_log2(f), DECIMALS(DIGITS - 2));
        mpq_set_d(middle, mpfr_get_d(cns_flow_begin(f), MPFR_RNDU) * 0.5 +
                              mpfr_get_d(cns_flow_end(f), MPFR_RNDD) * 0.5);
        cns_flow_eval(f, middle, inner);
        char text[64];
        mpfr_snprintf(text, sizeof text, "%.*RNe", DIGITS - 1, inner[2]);
        mpfr_set_str(want, text, 10, MPFR_RNDN);
        longer += !mpfr_equal_p(want, inner[2]);
    }
    if (methods[_i] == CNS_METHOD_TAYLOR)
        ck_assert_int_gt(landings, 3);
    ck_assert_int_gt(longer, 20);
    mpq_clear(middle);
    mpfr_clear(want);
    cns_vector_free(inner);
    cns_flow_free(f);
    numerics_clear(&n);
    cns_system_free(system);
}
END_TEST

START_TEST(double_keeps_no_decimals)
{
    cns_error err;
    cns_system *system = system_new(cns_model_find("lorenz"), NULL);
    cns_flow_spec spec = taylor_spec(cns_system_program(system), 16);
    spec.arithmetic = CNS_ARITH_DOUBLE;
    spec.round_digits = 10;
    ck_assert_ptr_null(cns_flow_new(&spec, &err));
    ck_assert_int_eq((int)err.code, CNS_USAGE);
    cns_numerics n;
    numerics_init(&n, 0, NULL);
    n.arithmetic = CNS_ARITH_DOUBLE;
    ck_assert_int_eq(cns_tc_flow(system, &n, NULL).round_digits, 0);
    numerics_clear(&n);
    cns_system_free(system);
}
END_TEST

Suite *suite_tc(void)
{
    Suite *s = suite_create("tc");
    TCase *t = tcase_create("predictable");
    tcase_add_loop_test(t, planted_difference, 0, 5);
    tcase_add_test(t, one_long_interval);
    tcase_add_test(t, zero_over_zero_and_x_over_zero);
    tcase_add_test(t, observable_near_its_zero);
    tcase_add_loop_test(t, observable_through_its_zeros, 0, 4);
    tcase_add_test(t, difference_that_only_just_exceeds);
    tcase_add_loop_test(t, rounding_alone, 0, 4);
    tcase_add_test(t, difference_that_does_not_grow);
    tcase_add_test(t, poor_reference);
    tcase_add_test(t, reference_digits_are_raised);
    tcase_add_loop_test(t, digits_kept, 0, 3);
    tcase_add_test(t, double_keeps_no_decimals);
    suite_add_tcase(s, t);
    return s;
}
