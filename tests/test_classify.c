/* Modes of systems whose late motion is known in closed form, symmetries against the right-hand side, sweeps
 * and bisection by trajectory. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cns/study/bisect.h"
#include "cns/study/classify.h"
#include "cns/study/sweep.h"
#include "problem.h"

#define PI 3.14159265358979323846

/* A limit cycle at radius 1 with angular frequency w = 2. */
static void build_hopf(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node x = cns_state(p, 0), y = cns_state(p, 1), w = cns_constant(p, "2");
    cns_node pull = cns_sub(p, cns_constant(p, "1"), cns_add(p, cns_sqr(p, x), cns_sqr(p, y)));
    cns_derivative(p, 0, cns_sub(p, cns_mul(p, pull, x), cns_mul(p, w, y)));
    cns_derivative(p, 1, cns_add(p, cns_mul(p, pull, y), cns_mul(p, w, x)));
}

/* x'' = -x - g x' */
static void build_oscillator(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node x = cns_state(p, 0), v = cns_state(p, 1);
    cns_derivative(p, 0, v);
    cns_derivative(p, 1, cns_neg(p, cns_add(p, x, cns_mul(p, cns_parameter(p, 0), v))));
}

/* The pendulum pulled to the energy E0: theta' = w, w' = -sin theta + (E0 - w^2/2 + cos theta) w. On its
 * limit cycle it is the pendulum of that energy: k = sqrt((1 + E0)/2) gives it the period 4 K(k) if it
 * swings, and 2 K(1/k)/k if it goes round. A passive state falls with w^2 - 1 - E0. */
static void build_pendulum(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node theta = cns_state(p, 0), w = cns_state(p, 1), sine, cosine, e0 = cns_parameter(p, 0);
    cns_sincos(p, theta, &sine, &cosine);
    cns_node half = cns_mul(p, cns_constant(p, "1/2"), cns_sqr(p, w));
    cns_node excess = cns_add(p, cns_sub(p, e0, half), cosine);
    cns_derivative(p, 0, w);
    cns_derivative(p, 1, cns_sub(p, cns_mul(p, excess, w), sine));
    cns_derivative(p, 2, cns_neg(p, cns_constant(p, "3")));
}

/* theta' = w drawn to 2 + cos theta, whose revolution takes 2 pi / sqrt(3); (p, q) is drawn to a circle and
 * its phase to theta/2 or theta/2 + pi, so that two revolutions repeat it, one does not. */
static void build_doubled(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node theta = cns_state(p, 0), w = cns_state(p, 1), a = cns_state(p, 2), b = cns_state(p, 3), sine,
             cosine;
    cns_sincos(p, theta, &sine, &cosine);
    cns_node g = cns_add(p, cns_constant(p, "2"), cosine);
    cns_derivative(p, 0, w);
    cns_derivative(p, 1, cns_sub(p, cns_sub(p, g, w), cns_mul(p, sine, w)));
    /* sin(theta - 2 psi) with cos 2 psi = a^2 - b^2, sin 2 psi = 2 a b */
    cns_node c2 = cns_sub(p, cns_sqr(p, a), cns_sqr(p, b)),
             s2 = cns_mul(p, cns_constant(p, "2"), cns_mul(p, a, b));
    cns_node lag = cns_sub(p, cns_mul(p, sine, c2), cns_mul(p, cosine, s2));
    cns_node rate = cns_add(p, cns_mul(p, cns_constant(p, "1/2"), w), lag);
    cns_node pull = cns_sub(p, cns_constant(p, "1"), cns_add(p, cns_sqr(p, a), cns_sqr(p, b)));
    cns_derivative(p, 2, cns_sub(p, cns_mul(p, pull, a), cns_mul(p, rate, b)));
    cns_derivative(p, 3, cns_add(p, cns_mul(p, pull, b), cns_mul(p, rate, a)));
}

static const cns_model_state states[] = {{"a", "", 1}, {"b", "", 1}, {"c", "", 1}, {"d", "", 1}};
static const cns_model_parameter parameters[] = {{"P", "", "0", NULL}};
static const signed char no_change[] = {1, 1, 1, 1}, mirror[] = {-1, -1, 1};
static const cns_model_motion swings = {
    .angle = 0, .rate = 1, .turns = 1, .height = 2, .turn_sign = no_change, .mirror_sign = mirror};
static const cns_model_motion turns_only = {
    .angle = 0, .rate = 1, .turns = 1, .height = -1, .turn_sign = no_change};
static const cns_model hopf = {.name = "hopf",
                               .n_states = 2,
                               .n_parameters = 1,
                               .states = states,
                               .parameters = parameters,
                               .build = build_hopf};
static const cns_model oscillator = {.name = "oscillator",
                                     .n_states = 2,
                                     .n_parameters = 1,
                                     .states = states,
                                     .parameters = parameters,
                                     .build = build_oscillator};
static const cns_model pendulum = {.name = "pendulum",
                                   .n_states = 3,
                                   .n_parameters = 1,
                                   .states = states,
                                   .parameters = parameters,
                                   .motion = &swings,
                                   .build = build_pendulum};
static const cns_model doubled = {.name = "doubled",
                                  .n_states = 4,
                                  .n_parameters = 1,
                                  .states = states,
                                  .parameters = parameters,
                                  .motion = &turns_only,
                                  .build = build_doubled};

static cns_system *system_of(const cns_model *m, const char *parameter, const char *const *initial)
{
    cns_setting settings[6] = {{"P", parameter}};
    for (int i = 0; i < m->n_states; i++)
        settings[i + 1] = (cns_setting){m->states[i].name, initial[i]};
    return system_new(m, settings);
}

static const cns_classify_spec usual = {.observable = -1, .max_digits = 200};

static cns_motion classify(const cns_model *m, const char *parameter, const char *const *initial)
{
    cns_system *s = system_of(m, parameter, initial);
    cns_motion motion;
    cns_error err;
    check_ok(cns_classify(s, &usual, NULL, &motion, &err), &err);
    cns_system_free(s);
    return motion;
}

/* At least eight decimals, all right. */
static void check_text(const char *text, double value, const char *what)
{
    ck_assert_msg(text != NULL, "%s: none", what);
    const char *point = strchr(text, '.');
    ck_assert_msg(point != NULL && strlen(point) > 8, "%s: only %s", what, text);
    ck_assert_msg(fabs(atof(text) - value) < 0.6 * pow(10, -(double)(strlen(point) - 1)), "%s: %s, not %.12g",
                  what, text, value);
}

/* K(k), by the arithmetic-geometric mean. */
static double elliptic(double k)
{
    double a = 1, b = sqrt(1 - k * k);
    for (int i = 0; i < 40; i++) {
        const double c = 0.5 * (a + b);
        b = sqrt(a * b);
        a = c;
    }
    return PI / (2 * a);
}

START_TEST(limit_cycle)
{
    cns_motion m = classify(&hopf, "0", (const char *[]){"1/10", "0"});
    ck_assert_str_eq(cns_mode_name(m.mode), "periodic");
    ck_assert_int_eq(m.returns, 1);
    check_text(m.period, PI, "period");
    check_text(m.amplitude, 1, "amplitude");
    ck_assert(fabs(m.multiplier / exp(-2 * PI) - 1) < 1e-6);
    ck_assert_int_eq(m.extrema, 1);
    check_text(m.maximum[0], 1, "maximum");
    /* r^-2 - 1 falls like exp(-2 t) from 99: at the first return after this time r is within 2^-10 of 1. */
    const double since = 0.5 * log(99 * ldexp(1, 9));
    ck_assert_msg(m.transient >= since && m.transient < since + PI, "%g", m.transient);
    cns_motion_clear(&m);
}
END_TEST

START_TEST(swinging)
{
    cns_motion m = classify(&pendulum, "0", (const char *[]){"1", "0.2", "0"});
    ck_assert_str_eq(cns_mode_name(m.mode), "flutter");
    ck_assert_str_eq(m.symmetry, "mirror");
    ck_assert_int_eq(m.winding, 0);
    ck_assert_int_eq(m.returns, 1);
    check_text(m.period, 4 * elliptic(sqrt(0.5)), "period");
    check_text(m.amplitude, PI / 2, "amplitude");
    check_text(m.descent, 3, "descent");
    check_text(m.drift[2], -12 * elliptic(sqrt(0.5)), "drift");
    cns_motion_clear(&m);
}
END_TEST

START_TEST(going_round)
{
    for (int side = -1; side <= 1; side += 2) {
        cns_motion m = classify(&pendulum, "2", (const char *[]){"1", side > 0 ? "2" : "-2", "0"});
        const double k = sqrt(1.5);
        ck_assert_str_eq(cns_mode_name(m.mode), "tumble");
        ck_assert_str_eq(m.symmetry, "none");
        ck_assert_int_eq(m.winding, side);
        ck_assert_ptr_null(m.amplitude);
        check_text(m.period, 2 * elliptic(1 / k) / k, "period");
        cns_motion_clear(&m);
    }
}
END_TEST

START_TEST(period_two)
{
    cns_motion m = classify(&doubled, "0", (const char *[]){"0", "2", "1", "0.1"});
    ck_assert_str_eq(cns_mode_name(m.mode), "tumble");
    ck_assert_int_eq(m.returns, 2);
    ck_assert_int_eq(m.winding, 2);
    ck_assert_str_eq(m.symmetry, "none");
    check_text(m.period, 4 * PI / sqrt(3), "period");
    cns_motion_clear(&m);
}
END_TEST

START_TEST(steady_and_neutral)
{
    cns_motion m = classify(&oscillator, "1", (const char *[]){"1", "0"});
    ck_assert_str_eq(cns_mode_name(m.mode), "steady");
    cns_motion_clear(&m);
    /* Without friction every motion repeats, and none attracts: not a mode. */
    m = classify(&oscillator, "0", (const char *[]){"1", "0"});
    ck_assert_str_eq(cns_mode_name(m.mode), "undecided");
    ck_assert(m.note[0] != '\0');
    cns_motion_clear(&m);
}
END_TEST

START_TEST(lorenz_is_chaotic)
{
    const cns_setting start[] = {{"x", "-15.8"}, {"y", "-17.48"}, {"z", "35.64"}, {NULL, NULL}};
    cns_system *s = system_new(cns_model_find("lorenz"), start);
    cns_motion m;
    cns_error err;
    check_ok(cns_classify(s, &usual, NULL, &m, &err), &err);
    ck_assert_str_eq(cns_mode_name(m.mode), "chaotic");
    ck_assert_msg(fabs(m.lambda - 0.9056) < 4 * m.lambda_se + 1e-3, "%g +- %g", m.lambda, m.lambda_se);
    cns_motion_clear(&m);
    cns_system_free(s);
}
END_TEST

/* f(g x) = g f(x) at random states, for turn and mirror image. */
START_TEST(symmetries_of_the_disk)
{
    const cns_model *m = cns_model_find("apw");
    cns_program *p = model_program("apw", NULL);
    cns_jet *J = jet_new(p, &cns_arith_mpfr, 1, 200);
    uint64_t seed = test_seed();
    mpfr_t x, pi, f[6], g[6];
    mpfr_inits2(200, x, pi, (mpfr_ptr)0);
    mpfr_const_pi(pi, MPFR_RNDN);
    for (int i = 0; i < 6; i++)
        mpfr_inits2(200, f[i], g[i], (mpfr_ptr)0);
    for (int trial = 0; trial < 100; trial++) {
        const bool turn = trial % 2 == 0;
        const signed char *sign = turn ? m->motion->turn_sign : m->motion->mirror_sign;
        double state[6];
        cns_error err;
        for (int i = 0; i < 6; i++)
            state[i] = 4 * test_random_unit(&seed) - 2;
        for (int image = 0; image < 2; image++) {
            cns_jet_begin(J, 1);
            for (int i = 0; i < 6; i++) {
                mpfr_set_d(x, image ? sign[i] * state[i] : state[i], MPFR_RNDN);
                if (image && turn && i == m->motion->angle) {
                    mpfr_mul_ui(g[0], pi, 2, MPFR_RNDN);
                    mpfr_div_si(g[0], g[0], m->motion->turns, MPFR_RNDN);
                    mpfr_add(x, x, g[0], MPFR_RNDN);
                }
                cns_jet_set_state(J, i, x);
            }
            check_ok(cns_jet_expand(J, 1, &err), &err);
            for (int i = 0; i < 6; i++)
                cns_jet_coefficient(J, image ? g[i] : f[i], i, 1);
        }
        for (int i = 0; i < 6; i++) {
            mpfr_mul_si(f[i], f[i], sign[i], MPFR_RNDN);
            check_close(f[i], g[i], -180, "rate %d, trial %d", i, trial);
        }
    }
    for (int i = 0; i < 6; i++)
        mpfr_clears(f[i], g[i], (mpfr_ptr)0);
    mpfr_clears(x, pi, (mpfr_ptr)0);
    cns_jet_free(J);
    cns_program_free(p);
}
END_TEST

static cns_code name_mode(void *context, const cns_system *s, const char *value, const cns_monitor *monitor,
                          FILE *const *table, cns_error *err)
{
    cns_motion m;
    (void)context;
    cns_code code = cns_classify(s, &usual, monitor, &m, err);
    fprintf(table[0], "%s %s\n", value, cns_mode_name(m.mode));
    fputs("second\n", table[1]);
    cns_motion_clear(&m);
    return code;
}

static cns_code tell_start(void *context, const cns_system *s, const char *value, const cns_monitor *monitor,
                           FILE *const *table, cns_error *err)
{
    (void)context;
    (void)monitor;
    const char *start = cns_system_initial(s)[0].text;
    if (strcmp(start, "1") == 0)
        return cns_fail(err, CNS_UNREACHED, "nothing to tell,\nin vain");
    fprintf(table[0], "%s %s\n", value, start);
    return CNS_OK;
}

START_TEST(a_sweep)
{
    cns_system *s = system_of(&pendulum, "0", (const char *[]){"1", "1.5", "0"});
    cns_sweep sweep;
    cns_error err;
    cns_sweep_rows rows[8];
    const cns_sweep_study study = {.name = "modes", .rows = name_mode};
    check_ok(cns_sweep_parse(&sweep, &pendulum, "P=1/2:2:0.5", &err), &err);
    ck_assert_int_eq(cns_sweep_count(&sweep), 4);
    cns_sweep_clear(&sweep);
    check_ok(cns_sweep_parse(&sweep, &pendulum, "P=0.5:1.5:1", &err), &err);
    ck_assert_int_eq(cns_sweep_count(&sweep), 2);
    check_ok(cns_sweep_run(s, &sweep, &study, NULL, NULL, rows, &err), &err);
    ck_assert_str_eq(rows[0].table[0], "0.5 flutter\n");
    ck_assert_str_eq(rows[1].table[0], "1.5 tumble\n");
    ck_assert_str_eq(rows[1].table[1], "second\n");
    cns_sweep_rows_clear(rows, 2);
    cns_sweep_clear(&sweep);
    /* downwards, and of a state: the pendulum that is pulled to rest at its top tells where it began */
    check_ok(cns_sweep_parse(&sweep, &pendulum, "initial.a=3:1:1/2", &err), &err);
    ck_assert_int_eq(cns_sweep_count(&sweep), 5);
    ck_assert_str_eq(cns_sweep_name(&sweep, &pendulum).text, "initial.a");
    cns_sweep_study starts = {.name = "starts", .rows = tell_start};
    check_ok(cns_sweep_run(s, &sweep, &starts, NULL, NULL, rows, &err), &err);
    for (int i = 0; i < 5; i++) {
        char wanted[32];
        snprintf(wanted, sizeof wanted, i % 2 ? "%.1f %.1f\n" : "%.0f %.0f\n", 3 - 0.5 * i, 3 - 0.5 * i);
        if (i < 4)
            ck_assert_str_eq(rows[i].table[0], wanted);
    }
    ck_assert_str_eq(rows[4].table[0], "# initial.a=1: nothing to tell,?in vain\n");
    cns_sweep_rows_clear(rows, 5);
    cns_sweep_clear(&sweep);
    static const char *const wrong[] = {"P",        "P=1",      "P=1:2",      "Q=1:2:1", "P=1:2:0",
                                        "P=1:2:-1", "P=1:pi:1", "P=0:1:1e-9", "P=1:2:x"};
    for (int i = 0; i < COUNT(wrong); i++)
        ck_assert_int_eq(cns_sweep_parse(&sweep, &pendulum, wrong[i], &err), CNS_USAGE);
    cns_system_free(s);
}
END_TEST

/* The pendulum goes round when its energy is above that of the saddle, 1. */
START_TEST(by_trajectory)
{
    cns_system *s = system_of(&pendulum, "0", (const char *[]){"1", "1.5", "0"});
    const char *ends[] = {"0.6", "1.7"};
    cns_number *x = numbers_new(2, ends);
    cns_bisect_spec spec = {.parameter = 0, .decimals = 6};
    cns_bisect_result r;
    cns_error err;
    spec.lower = x[0];
    spec.upper = x[1];
    check_ok(cns_bisect(s, &spec, NULL, NULL, &r, &err), &err);
    ck_assert_str_eq(r.critical, "1.000000");
    ck_assert_str_eq(r.lower_mode, "flutter");
    ck_assert_str_eq(r.upper_mode, "tumble");
    ck_assert(atof(r.lower) < 1 && atof(r.upper) > 1);
    cns_bisect_clear(&r);
    spec.lower = x[1];
    check_ok(cns_number_parse(&x[0], "2.5", &err), &err);
    spec.upper = x[0];
    ck_assert_int_eq(cns_bisect(s, &spec, NULL, NULL, &r, &err), CNS_UNREACHED);
    ck_assert_ptr_null(r.critical);
    ck_assert_str_eq(r.lower_mode, "tumble");
    cns_bisect_clear(&r);
    numbers_free(x, 2);
    cns_system_free(s);
}
END_TEST

Suite *suite_classify(void)
{
    Suite *s = suite_create("classify");
    TCase *t = tcase_create("modes");
    tcase_add_test(t, limit_cycle);
    tcase_add_test(t, swinging);
    tcase_add_test(t, going_round);
    tcase_add_test(t, period_two);
    tcase_add_test(t, steady_and_neutral);
    tcase_add_test(t, lorenz_is_chaotic);
    tcase_add_test(t, symmetries_of_the_disk);
    tcase_add_test(t, a_sweep);
    tcase_add_test(t, by_trajectory);
    suite_add_tcase(s, t);
    return s;
}
