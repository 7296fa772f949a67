/* The largest exponent: systems whose exponent is known, neighbouring trajectories, and the batches. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cns/study/lyapunov.h"
#include "problem.h"
#include "study/batches.h"

static const char *const disk[] = {"0", "0", "1", "0", "0.01", "1"};
static const cns_setting disk_start[] = {{"theta", "1"}, {"Vy", "0.01"}, {"omega", "1"}, {NULL, NULL}};
static const double disk_tangent[] = {0.5, -0.25, 0.125, 0.75};

static cns_code try_exponent(const cns_system *s, const double *tangent, long time, cns_arithmetic arithmetic,
                             cns_lyapunov_result *result, cns_error *err)
{
    cns_lyapunov_spec spec = {.arithmetic = arithmetic, .digits = 30, .tangent = tangent};
    cns_number_init(&spec.time);
    mpq_set_si(spec.time.ratio, time, 1);
    cns_code code = cns_lyapunov(s, &spec, NULL, result, err);
    cns_number_clear(&spec.time);
    return code;
}

static cns_lyapunov_result exponent(const cns_system *s, long time, cns_arithmetic arithmetic)
{
    cns_lyapunov_result r;
    cns_error err;
    const double length = (double)time;
    check_ok(try_exponent(s, NULL, time, arithmetic, &r, &err), &err);
    ck_assert(r.lambda == r.row[CNS_LYAPUNOV_ROWS - 1].lambda);
    ck_assert(r.se == r.row[CNS_LYAPUNOV_ROWS - 1].se);
    ck_assert(r.se == r.batch[1].se && r.batch[1].count == 32);
    ck_assert_double_eq_tol(r.row[CNS_LYAPUNOV_ROWS - 1].t, 1.1 * length, 1e-9 * length);
    ck_assert_double_eq_tol(r.discarded, 0.1 * length, 1e-9 * length);
    return r;
}

/* x_i' = sum_j a_ij x_j, the model's data being the texts a. */
static void linear(cns_program *p, const cns_model *model)
{
    const char *const *a = model->data;
    const int n = model->n_states;
    for (int i = 0; i < n; i++) {
        cns_node f = cns_constant(p, "0");
        for (int j = 0; j < n; j++)
            f = cns_add(p, f, cns_mul(p, cns_constant(p, a[i * n + j]), cns_state(p, j)));
        cns_derivative(p, i, f);
    }
}

static void oscillator(cns_program *p, const cns_model *model)
{
    cns_node x = cns_state(p, 0), y = cns_state(p, 1);
    (void)model;
    cns_derivative(p, 0, y);
    cns_derivative(p, 1, cns_sub(p, cns_mul(p, cns_sub(p, cns_constant(p, "1"), cns_sqr(p, x)), y), x));
}

static void pole(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_derivative(p, 0, cns_sqr(p, cns_state(p, 0)));
}

static void passive(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_derivative(p, 0, cns_constant(p, "1"));
}

static const struct {
    const char *a[9];
    int n;
    long time;
    double lambda, error;
} linear_systems[] = {
    {{"3/10"}, 1, 30, 0.3, 1e-9},
    {{"-2"}, 1, 400, -2, 1e-9},                                         /* through 10^-300 and further */
    {{"-1", "0", "0", "1/2"}, 2, 200, 0.5, 1e-9},                       /* the tangent has to turn */
    {{"0", "1", "0", "0", "0", "1", "6", "-11", "6"}, 3, 200, 3, 1e-9}, /* eigenvalues 1, 2, 3 */
    {{"1/5", "1", "-1", "1/5"}, 2, 200, 0.2, 1e-9},                     /* a spiral */
    {{"1/5", "4", "-1/4", "1/5"}, 2, 500, 0.2, 1e-2},                   /* |v| oscillates about e^(t/5) */
    {{"0", "1", "-1", "0"}, 2, 100, 0, 1e-9},
};

START_TEST(linear_systems_have_their_eigenvalue)
{
    static const char *const origin[] = {"0", "0", "0"};
    const cns_model model = unit_model(linear_systems[_i].n, linear, linear_systems[_i].a);
    cns_system *s = unit_system(&model, origin);
    for (int arithmetic = CNS_ARITH_FAST; arithmetic <= CNS_ARITH_DOUBLE; arithmetic++) {
        cns_lyapunov_result r = exponent(s, linear_systems[_i].time, (cns_arithmetic)arithmetic);
        ck_assert_double_eq_tol(r.lambda, linear_systems[_i].lambda, linear_systems[_i].error);
        ck_assert_double_le(fabs(r.lambda - linear_systems[_i].lambda), 3 * r.se + 1e-9);
    }
    cns_system_free(s);
}
END_TEST

/* From a start outside its limit cycle: the tangent shrinks at first, and then no more. */
START_TEST(limit_cycle_has_exponent_zero)
{
    static const char *const start[] = {"3", "0"};
    const cns_model model = unit_model(2, oscillator, NULL);
    cns_system *s = unit_system(&model, start);
    for (int arithmetic = CNS_ARITH_FAST; arithmetic <= CNS_ARITH_DOUBLE; arithmetic++) {
        cns_lyapunov_result r =
            exponent(s, arithmetic == CNS_ARITH_DOUBLE ? 400 : 100, (cns_arithmetic)arithmetic);
        ck_assert_double_le(fabs(r.lambda), 0.02);
        ck_assert_double_le(fabs(r.lambda), 2 * r.se);
        ck_assert_double_le(r.se, 0.05);
    }
    cns_system_free(s);
}
END_TEST

static double log_distance(mpfr_t *a, mpfr_t *b, int from, int to)
{
    double sum = 0;
    mpfr_t x;
    mpfr_init2(x, 64);
    for (int i = from; i < to; i++) {
        mpfr_sub(x, a[i], b[i], MPFR_RNDN);
        mpfr_mul_2ui(x, x, 100, MPFR_RNDN); /* doubles then hold its square */
        double y = mpfr_get_d(x, MPFR_RNDN);
        sum += y * y;
    }
    mpfr_clear(x);
    return 0.5 * log(sum);
}

/* The same growth from two neighbouring trajectories in many digits, without any tangents: 2^-100 apart at
 * first, over some zeros of omega. */
START_TEST(growth_is_that_of_a_small_distance)
{
    enum { DIGITS = 90, SMALL = 200 };
    const long time = 40;
    cns_system *s = system_new(cns_model_find("apw"), disk_start);
    cns_flow_spec spec = taylor_spec(cns_system_program(s), DIGITS);
    cns_number *x = numbers_new(6, disk);
    cns_flow *one = flow_new(&spec), *other = flow_new(&spec);
    mpfr_t *a = cns_vector_xnew(6, spec.prec), *b = cns_vector_xnew(6, spec.prec);
    mpq_t change;
    mpq_init(change);
    cns_flow_start(one, x);
    for (int i = 0; i < 4; i++) {
        mpq_set_d(change, disk_tangent[i]);
        mpq_div_2exp(change, change, SMALL);
        mpq_add(x[2 + i].ratio, x[2 + i].ratio, change);
    }
    cns_flow_start(other, x);
    flow_to(one, "4", a);
    flow_to(other, "4", b);
    double before = log_distance(a, b, 2, 6);
    flow_to(one, "44", a);
    flow_to(other, "44", b);
    double expected = (log_distance(a, b, 2, 6) - before) / (double)time;
    ck_assert_int_gt(cns_flow_landings(one), 3);
    for (int arithmetic = CNS_ARITH_FAST; arithmetic <= CNS_ARITH_DOUBLE; arithmetic++) {
        cns_lyapunov_result r;
        cns_error err;
        check_ok(try_exponent(s, disk_tangent, time, (cns_arithmetic)arithmetic, &r, &err), &err);
        ck_assert_double_eq_tol(r.lambda, expected, 2e-9);
        ck_assert_int_gt(r.landings, 3);
    }
    mpq_clear(change);
    cns_vector_free(a);
    cns_vector_free(b);
    cns_flow_free(one);
    cns_flow_free(other);
    numbers_free(x, 6);
    cns_system_free(s);
}
END_TEST

/* Lorenz's equations: 0.9056 (J. C. Sprott, Chaos and Time-Series Analysis, 2003). */
START_TEST(lorenz)
{
    const cns_setting start[] = {{"x", "-15.8"}, {"y", "-17.48"}, {"z", "35.64"}, {NULL, NULL}};
    cns_system *s = system_new(cns_model_find("lorenz"), start);
    cns_lyapunov_result r = exponent(s, 1000, CNS_ARITH_DOUBLE);
    ck_assert_double_eq_tol(r.lambda, 0.9056, 3.5 * r.se);
    ck_assert_double_le(r.se, 0.05);
    ck_assert_int_eq(r.landings, 0);
    cns_system_free(s);
}
END_TEST

/* The rows are means from the end of the transient on. */
START_TEST(table_is_the_mean_so_far)
{
    cns_system *s = system_new(cns_model_find("apw"), disk_start);
    cns_lyapunov_result whole = exponent(s, 64, CNS_ARITH_DOUBLE);
    double sum = 0, smallest = HUGE_VAL, largest = -HUGE_VAL;
    for (int k = 0; k < CNS_LYAPUNOV_ROWS; k++) { /* the mean of one row's time, from the means so far */
        double here = (k + 1) * whole.row[k].lambda - (k > 0 ? k * whole.row[k - 1].lambda : 0);
        smallest = fmin(smallest, here);
        largest = fmax(largest, here);
        sum += here;
        ck_assert_double_eq_tol(whole.row[k].t, 6.4 + 2 * (k + 1), 1e-9);
        ck_assert_double_gt(whole.row[k].se, 0);
    }
    ck_assert_double_eq_tol(sum / CNS_LYAPUNOV_ROWS, whole.lambda, 1e-12);
    ck_assert_double_gt(largest - smallest, 0.1);
    cns_system_free(s);
}
END_TEST

/* x_n = memory x_{n-1} + noise: the error of the mean over n is sqrt((1 + memory)/(1 - memory) / n) times the
 * deviation of x. */
START_TEST(batches_see_memory)
{
    enum { N = 2048, TURNS = 150 };
    static const double memories[] = {0, 0.8, -0.6};
    const double memory = memories[_i];
    uint64_t s = test_seed();
    double x[N], mean_square = 0;
    for (int turn = 0; turn < TURNS; turn++) {
        double before = 0;
        for (int i = -100; i < N; i++) {
            before = memory * before + sqrt(12) * (test_random_unit(&s) - 0.5);
            if (i >= 0)
                x[i] = 5 + before;
        }
        double se = cns_batch_error(x, N, 32);
        mean_square += se * se / TURNS;
    }
    double expected = 1 / ((1 - memory) * (1 - memory)) / N; /* the noise has variance 1 */
    /* Each square scatters by sqrt(2/31): the mean of TURNS by 2 %; batches of 64 miss some of the memory. */
    ck_assert_double_eq_tol(mean_square / expected, 1, 0.16);
}
END_TEST

START_TEST(batches_by_hand)
{
    static const double x[] = {1, 3, 5, 7, 4, 4};
    ck_assert_double_eq_tol(cns_batch_error(x, 6, 3), sqrt(8.0 / 6), 1e-14); /* means 2, 6, 4 */
    ck_assert_double_eq_tol(cns_batch_error(x, 6, 2), 1, 1e-14);             /* means 3, 5 */
}
END_TEST

START_TEST(failures_are_told)
{
    static const char *const one[] = {"1"};
    cns_lyapunov_result r;
    cns_error err;
    const cns_model models[] = {unit_model(1, pole, NULL), unit_model(1, passive, NULL)};
    static const char *const words[] = {"t = ", "exponent"};
    for (int i = 0; i < 2; i++) {
        cns_system *s = unit_system(&models[i], one);
        ck_assert_int_eq(try_exponent(s, NULL, 10, CNS_ARITH_DOUBLE, &r, &err), CNS_NUMERIC);
        ck_assert_msg(strstr(err.text, words[i]), "%s", err.text);
        cns_system_free(s);
    }

    volatile sig_atomic_t stop = 1;
    const cns_monitor stopped = {.stop = &stop};
    cns_system *s = system_new(cns_model_find("apw"), disk_start);
    cns_number *time = numbers_new(1, one);
    const cns_lyapunov_spec spec = {.time = *time, .arithmetic = CNS_ARITH_DOUBLE};
    ck_assert_int_eq(cns_lyapunov(s, &spec, &stopped, &r, &err), CNS_STOPPED);
    numbers_free(time, 1);
    cns_system_free(s);
}
END_TEST

Suite *suite_lyapunov(void)
{
    Suite *s = suite_create("lyapunov");
    TCase *t = tcase_create("lyapunov");
    add_table_test(t, linear_systems_have_their_eigenvalue, linear_systems);
    tcase_add_test(t, limit_cycle_has_exponent_zero);
    tcase_add_test(t, growth_is_that_of_a_small_distance);
    tcase_add_test(t, lorenz);
    tcase_add_test(t, table_is_the_mean_so_far);
    tcase_add_loop_test(t, batches_see_memory, 0, 3);
    tcase_add_test(t, batches_by_hand);
    tcase_add_test(t, failures_are_told);
    suite_add_tcase(s, t);
    return s;
}
