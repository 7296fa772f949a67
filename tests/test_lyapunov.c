/* Exponents: systems whose exponents are known, neighbouring trajectories, volumes, and the batches. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cns/study/lyapunov.h"
#include "problem.h"
#include "study/batches.h"

static const char *const disk[] = {"0", "0", "1", "0", "0.01", "1"};
static const cns_setting disk_start[] = {{"theta", "1"}, {"Vy", "0.01"}, {"omega", "1"}, {NULL, NULL}};
static const double disk_tangent[] = {0.5, -0.25, 0.125, 0.75};

/* A result to be cleared with cns_lyapunov_result_clear(), whatever the code. */
static cns_code try_exponents(const cns_system *s, int exponents, const double *tangent, long time,
                              cns_arithmetic arithmetic, cns_lyapunov_result *result, cns_error *err)
{
    cns_lyapunov_spec spec = {
        .arithmetic = arithmetic, .digits = 30, .exponents = exponents, .tangent = tangent};
    cns_number_init(&spec.time);
    mpq_set_si(spec.time.ratio, time, 1);
    cns_code code = cns_lyapunov(s, &spec, NULL, result, err);
    cns_number_clear(&spec.time);
    return code;
}

/* The largest exponent over all of the time. */
static cns_exponent exponent(const cns_system *s, long time, cns_arithmetic arithmetic)
{
    cns_lyapunov_result r;
    cns_error err;
    const double length = (double)time;
    check_ok(try_exponents(s, 1, NULL, time, arithmetic, &r, &err), &err);
    const cns_exponent e = r.exponent[0];
    ck_assert_int_eq(r.n, 1);
    ck_assert_int_eq(r.changes, 0);
    ck_assert(e.lambda == e.row[CNS_LYAPUNOV_ROWS - 1].lambda);
    ck_assert(e.se == e.row[CNS_LYAPUNOV_ROWS - 1].se);
    ck_assert(e.se == e.batch_se[1] && r.batches[1] == 32);
    ck_assert(r.time == length);
    ck_assert_double_eq_tol(r.t[CNS_LYAPUNOV_ROWS - 1], 1.1 * length, 1e-9 * length);
    ck_assert_double_eq_tol(r.discarded, 0.1 * length, 1e-9 * length);
    cns_lyapunov_result_clear(&r);
    return e;
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
        cns_exponent e = exponent(s, linear_systems[_i].time, (cns_arithmetic)arithmetic);
        ck_assert_double_eq_tol(e.lambda, linear_systems[_i].lambda, linear_systems[_i].error);
        ck_assert_double_le(fabs(e.lambda - linear_systems[_i].lambda), 3 * e.se + 1e-9);
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
        cns_exponent e = exponent(s, arithmetic == CNS_ARITH_DOUBLE ? 400 : 100, (cns_arithmetic)arithmetic);
        ck_assert_double_le(fabs(e.lambda), 0.02);
        ck_assert_double_le(fabs(e.lambda), 2 * e.se);
        ck_assert_double_le(e.se, 0.06);
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
        check_ok(try_exponents(s, 1, disk_tangent, time, (cns_arithmetic)arithmetic, &r, &err), &err);
        ck_assert_double_eq_tol(r.exponent[0].lambda, expected, 2e-9);
        ck_assert_int_gt(r.landings, 3);
        cns_lyapunov_result_clear(&r);
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
    cns_exponent e = exponent(s, 1000, CNS_ARITH_DOUBLE);
    ck_assert_double_eq_tol(e.lambda, 0.9056, 3.5 * e.se);
    ck_assert_double_le(e.se, 0.05);
    cns_system_free(s);
}
END_TEST

/* The rows are means from the end of the transient on. */
START_TEST(table_is_the_mean_so_far)
{
    cns_system *s = system_new(cns_model_find("apw"), disk_start);
    cns_lyapunov_result r;
    cns_error err;
    check_ok(try_exponents(s, 1, NULL, 64, CNS_ARITH_DOUBLE, &r, &err), &err);
    const cns_exponent *e = &r.exponent[0];
    double sum = 0, smallest = HUGE_VAL, largest = -HUGE_VAL;
    for (int k = 0; k < CNS_LYAPUNOV_ROWS; k++) { /* the mean of one row's time, from the means so far */
        double here = (k + 1) * e->row[k].lambda - (k > 0 ? k * e->row[k - 1].lambda : 0);
        smallest = fmin(smallest, here);
        largest = fmax(largest, here);
        sum += here;
        ck_assert_double_eq_tol(r.t[k], 6.4 + 2 * (k + 1), 1e-9);
        ck_assert_double_gt(e->row[k].se, 0);
    }
    ck_assert_double_eq_tol(sum / CNS_LYAPUNOV_ROWS, e->lambda, 1e-12);
    ck_assert_double_gt(largest - smallest, 0.1);
    cns_lyapunov_result_clear(&r);
    cns_system_free(s);
}
END_TEST

/* x_n = memory x_{n-1} + noise of variance 1. */
static void fill_series(double *x, int n, double memory, uint64_t *seed)
{
    double before = 0;
    for (int i = -100; i < n; i++) {
        before = memory * before + sqrt(12) * (test_random_unit(seed) - 0.5);
        if (i >= 0)
            x[i] = before;
    }
}

/* The error of the mean over n is sqrt((1 + memory)/(1 - memory) / n) times the
 * deviation of x. */
START_TEST(batches_see_memory)
{
    enum { N = 2048, TURNS = 150 };
    static const double memories[] = {0, 0.8, -0.6};
    const double memory = memories[_i];
    uint64_t s = test_seed();
    double x[N], mean_square = 0;
    for (int turn = 0; turn < TURNS; turn++) {
        fill_series(x, N, memory, &s);
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
    ck_assert_double_eq_tol(cns_batch_error(x, 6, 6), sqrt(20.0 / 5 / 6), 1e-14);
    ck_assert_double_eq_tol(cns_batch_error(x, 4, 2), 2, 1e-14); /* means 2, 6 */
}
END_TEST

/* At most one of 1000 series that remember little is taken for another: more than 12 of 3000 would be, if
 * that were so, once in 50000 runs, and much less often where they are fewer (measured: 0.2 of 1000). */
START_TEST(stationary_series_are_stationary)
{
    enum { N = 256, SERIES = 3000 };
    static const double memories[] = {0, 0.3, -0.6};
    uint64_t s = test_seed();
    double x[N];
    int changes = 0, remember = 0;
    for (int turn = 0; turn < SERIES; turn++) {
        fill_series(x, N, memories[_i], &s);
        changes += cns_find_change(x, N, 32, 0) > 0;
        remember += cns_batches_remember(x, N, 32);
    }
    ck_assert_int_le(changes, 12);
    ck_assert_int_le(remember, 12);
}
END_TEST

/* A change by three times the scatter of terms is found near its place, whatever the scatter after it; and
 * not if changes have to be larger to matter. */
START_TEST(changes_are_found)
{
    enum { N = 1024, LEAST = 3 * N / 32 };
    uint64_t s = test_seed();
    double x[N];
    for (int turn = 0; turn < 100; turn++) {
        const int at = LEAST + (int)test_random_below(&s, N - 2 * LEAST);
        const double calm = turn % 2 == 0 ? 1 : 1e-6;
        fill_series(x, N, 0, &s);
        for (int i = at; i < N; i++)
            x[i] = 3 + calm * x[i];
        ck_assert_int_le(abs(cns_find_change(x, N, 32, 0) - at), 24);
        ck_assert_int_eq(cns_find_change(x, N, 32, 4), 0);
    }
}
END_TEST

/* Batches that are shorter than what terms remember. */
START_TEST(long_memory_is_noticed)
{
    enum { N = 1024, SERIES = 100 };
    uint64_t s = test_seed();
    double x[N];
    int noticed = 0;
    for (int turn = 0; turn < SERIES; turn++) {
        fill_series(x, N, 0.99, &s);
        noticed += cns_batches_remember(x, N, 32);
    }
    ck_assert_int_ge(noticed, SERIES / 4); /* 63 of 100 (measured) */
}
END_TEST

/* sin(omega k) has mean zero, within its error, however its period goes into batches. */
START_TEST(periods_are_no_memory)
{
    enum { N = 8192 };
    uint64_t s = test_seed();
    double x[N];
    for (int turn = 0; turn < 200; turn++) {
        /* in step with regular batches of 256, in step with 8 terms but for a little, or with neither */
        const double period = turn % 3 == 0   ? 256.0 / (double)(1 + test_random_below(&s, 60))
                              : turn % 3 == 1 ? 8 * (1 + 1e-4 * test_random_unit(&s))
                                              : 3 + 100 * test_random_unit(&s);
        for (int i = 0; i < N; i++)
            x[i] = sin(2 * 3.14159265358979324 / period * i);
        ck_assert_int_eq(cns_find_change(x, N, 32, 0), 0);
        ck_assert(!cns_batches_remember(x, N, 32));
        ck_assert_double_ge(cns_batch_error(x, N, 32), period / 3.14 / N); /* the mean of the last, unfinished
                                                                              one is as large as that */
    }
}
END_TEST

/* All exponents of linear systems are the real parts of their eigenvalues; the trace is their sum. */
static const struct {
    const char *a[9];
    int n;
    long time;
    double lambda[3];
    const char *trace;
    double dimension;
} spectra[] = {
    {{"3/10"}, 1, 30, {0.3}, "3/10", 1},
    {{"-1", "0", "0", "1/2"}, 2, 200, {0.5, -1}, "-1/2", 1.5},
    {{"0", "1", "0", "0", "0", "1", "-6", "-11", "-6"}, 3, 200, {-1, -2, -3}, "-6", 0},
    {{"1/5", "1", "-1", "1/5"}, 2, 100, {0.2, 0.2}, "2/5", 2},
    {{"0", "1", "-1", "0"}, 2, 100, {0, 0}, "0", 2},
    {{"1", "1", "1/3", "0", "-1/2", "1", "0", "0", "-3"}, 3, 200, {1, -0.5, -3}, "-5/2", 2 + 0.5 / 3},
};

START_TEST(linear_systems_have_their_eigenvalues)
{
    static const char *const origin[] = {"0", "0", "0"};
    const cns_model model = unit_model(spectra[_i].n, linear, spectra[_i].a);
    cns_system *s = unit_system(&model, origin);
    for (int arithmetic = CNS_ARITH_FAST; arithmetic <= CNS_ARITH_DOUBLE; arithmetic++) {
        cns_lyapunov_result r;
        cns_error err;
        check_ok(try_exponents(s, 0, NULL, spectra[_i].time, (cns_arithmetic)arithmetic, &r, &err), &err);
        ck_assert_int_eq(r.n, spectra[_i].n);
        for (int i = 0; i < r.n; i++)
            ck_assert_double_eq_tol(r.exponent[i].lambda, spectra[_i].lambda[i], 1e-9);
        ck_assert_double_eq_tol(r.dimension, spectra[_i].dimension, 1e-8);
        ck_assert_double_eq_tol(r.sum, r.trace, 1e-11);
        ck_assert_str_eq(r.exact_trace, spectra[_i].trace);
        cns_lyapunov_result_clear(&r);
    }
    cns_system_free(s);
}
END_TEST

/* The first few exponents are those of the whole spectrum, and none is asked for that there is not. */
START_TEST(some_exponents_are_the_first_of_all)
{
    cns_system *s = system_new(cns_model_find("apw"), disk_start);
    cns_lyapunov_result all, some;
    cns_error err;
    check_ok(try_exponents(s, 4, NULL, 100, CNS_ARITH_DOUBLE, &all, &err), &err);
    for (int n = 1; n < 4; n++) {
        check_ok(try_exponents(s, n, NULL, 100, CNS_ARITH_DOUBLE, &some, &err), &err);
        ck_assert_int_eq(some.n, n);
        ck_assert(!isfinite(some.sum) && some.exact_trace == NULL);
        for (int i = 0; i < n; i++) /* steps are others: the trajectory is the same for a while only */
            ck_assert_double_eq_tol(some.exponent[i].lambda, all.exponent[i].lambda, 4 * all.exponent[i].se);
        cns_lyapunov_result_clear(&some);
    }
    ck_assert(all.exact_trace == NULL);
    cns_lyapunov_result_clear(&all);
    ck_assert_int_eq(try_exponents(s, 5, NULL, 10, CNS_ARITH_DOUBLE, &some, &err), CNS_USAGE);
    cns_lyapunov_result_clear(&some);
    cns_system_free(s);
}
END_TEST

/* Lorenz: 0.9056, 0, -14.5723 (J. C. Sprott, 2003); the trace is -(sigma + 1 + b). Volumes of the disk shrink
 * by the mean trace, which is another at each place. */
START_TEST(volumes_grow_by_the_trace)
{
    static const double published[] = {0.9056, 0, -14.5723};
    const cns_setting start[] = {{"x", "-15.8"}, {"y", "-17.48"}, {"z", "35.64"}, {NULL, NULL}};
    for (int arithmetic = CNS_ARITH_FAST; arithmetic <= CNS_ARITH_DOUBLE; arithmetic++) {
        cns_lyapunov_result r;
        cns_error err;
        const bool in_double = arithmetic == CNS_ARITH_DOUBLE;
        cns_system *s = system_new(cns_model_find("lorenz"), start);
        check_ok(try_exponents(s, 0, NULL, in_double ? 500 : 8, (cns_arithmetic)arithmetic, &r, &err), &err);
        ck_assert_str_eq(r.exact_trace, "-41/3");
        ck_assert_double_eq_tol(r.sum, -41.0 / 3, 1e-10);
        for (int i = 0; i < 3 && in_double; i++) {
            ck_assert_double_eq_tol(r.exponent[i].lambda, published[i], 4 * r.exponent[i].se);
            ck_assert_double_le(r.exponent[i].se, 0.05);
        }
        if (in_double) {
            ck_assert_double_eq_tol(r.dimension, 2.0622, 4 * r.dimension_se);
            ck_assert_double_le(r.dimension_se, 0.002);
        }
        cns_lyapunov_result_clear(&r);
        cns_system_free(s);
        s = system_new(cns_model_find("apw"), disk_start);
        check_ok(try_exponents(s, 0, NULL, in_double ? 100 : 30, (cns_arithmetic)arithmetic, &r, &err), &err);
        ck_assert_double_eq_tol(r.sum, r.trace, 1e-10);
        ck_assert_double_lt(r.sum, -0.1);
        cns_lyapunov_result_clear(&r);
        cns_system_free(s);
    }
}
END_TEST

/* The errors of all exponents and of their dimension are those of the same batches: a sum that does not vary
 * has no error, though its terms have. */
START_TEST(errors_vary_together)
{
    const cns_setting start[] = {{"x", "-15.8"}, {"y", "-17.48"}, {"z", "35.64"}, {NULL, NULL}};
    cns_system *s = system_new(cns_model_find("lorenz"), start);
    cns_lyapunov_result r;
    cns_error err;
    check_ok(try_exponents(s, 0, NULL, 500, CNS_ARITH_DOUBLE, &r, &err), &err);
    const cns_exponent *e = r.exponent;
    /* D = 2 + (lambda1 + lambda2) / |lambda3|, and lambda1 + lambda2 is the trace less lambda3. */
    ck_assert_double_eq_tol(r.dimension, 3 + 41.0 / 3 / e[2].lambda, 1e-9);
    ck_assert_double_eq_tol(r.dimension_se, 41.0 / 3 / (e[2].lambda * e[2].lambda) * e[2].se, 1e-9);
    cns_lyapunov_result_clear(&r);
    cns_system_free(s);
}
END_TEST

/* x' = x (1 - x), z' = c x z (1 - z): from beside 0 the state comes to x = 1 after -ln x(0), where z begins
 * to grow, and to z = 1 after -ln z(0) / c more. The largest exponent is 1, c and -c by turns. */
static void steps(cns_program *p, const cns_model *model)
{
    cns_node x = cns_state(p, 0), z = cns_state(p, 1), one = cns_constant(p, "1");
    cns_derivative(p, 0, cns_mul(p, x, cns_sub(p, one, x)));
    cns_derivative(
        p, 1, cns_mul(p, cns_mul(p, cns_constant(p, model->data), x), cns_mul(p, z, cns_sub(p, one, z))));
}

/* Of two changes, at neither of which the rate is steady on both sides, it is only seen that it varies. */
static const struct {
    const char *c, *start[2];
    cns_code code;
    int changes;
    double t, lambda;  /* of the last change, and from then on */
    const char *words; /* why there is no figure */
} changing[] = {
    {"3/10", {"1/2", "1"}, CNS_OK, 0, 0, -0.3, NULL},
    {"3/10", {"1/2", "1e-40"}, CNS_OK, 1, 307, -0.3, NULL},
    {"3/10", {"1/2", "1e-135"}, CNS_UNREACHED, 1, 1036, 0, "too little time follows"},
    {"1/10", {"1e-217", "1e-13"}, CNS_UNREACHED, 2, 799, 0, "and again"},
    {"3/10", {"1e-120", "1e-40"}, CNS_UNREACHED, 0, 0, 0, "varies over longer"},
};

START_TEST(late_motion_has_its_own_exponent)
{
    const cns_model model = unit_model(2, steps, changing[_i].c);
    cns_system *s = unit_system(&model, changing[_i].start);
    cns_lyapunov_result r;
    cns_error err = {0};
    ck_assert_int_eq(try_exponents(s, 1, NULL, 1000, CNS_ARITH_DOUBLE, &r, &err), changing[_i].code);
    ck_assert_int_eq(r.changes, changing[_i].changes);
    if (r.changes > 0)
        ck_assert_double_eq_tol(r.change[r.changes - 1].t, changing[_i].t, 30);
    if (changing[_i].code == CNS_OK) {
        ck_assert_double_eq_tol(r.exponent[0].lambda, changing[_i].lambda, 1e-6);
        ck_assert_str_eq(r.note, "");
        ck_assert_double_eq_tol(r.discarded + r.time, 1100, 1e-9);
        ck_assert_double_eq_tol(r.t[CNS_LYAPUNOV_ROWS - 1], 1100, 1e-9);
        ck_assert(r.changes == 0 || r.discarded > r.change[0].t);
    } else {
        ck_assert(!isfinite(r.exponent[0].lambda) && !isfinite(r.exponent[0].se));
        ck_assert_msg(strstr(err.text, changing[_i].words), "%s", err.text);
        ck_assert(strstr(err.text, r.note));
    }
    cns_lyapunov_result_clear(&r);
    cns_system_free(s);
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
        ck_assert_int_eq(try_exponents(s, 1, NULL, 10, CNS_ARITH_DOUBLE, &r, &err), CNS_NUMERIC);
        ck_assert_msg(strstr(err.text, words[i]), "%s", err.text);
        cns_system_free(s);
    }

    volatile sig_atomic_t stop = 1;
    const cns_monitor stopped = {.stop = &stop};
    cns_system *s = system_new(cns_model_find("apw"), disk_start);
    cns_number *time = numbers_new(1, one);
    const cns_lyapunov_spec spec = {.time = *time, .arithmetic = CNS_ARITH_DOUBLE, .exponents = 1};
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
    tcase_add_loop_test(t, stationary_series_are_stationary, 0, 3);
    tcase_add_test(t, changes_are_found);
    tcase_add_test(t, long_memory_is_noticed);
    tcase_add_test(t, periods_are_no_memory);
    add_table_test(t, linear_systems_have_their_eigenvalues, spectra);
    tcase_add_test(t, some_exponents_are_the_first_of_all);
    tcase_add_test(t, volumes_grow_by_the_trace);
    tcase_add_test(t, errors_vary_together);
    add_table_test(t, late_motion_has_its_own_exponent, changing);
    tcase_add_test(t, failures_are_told);
    suite_add_tcase(s, t);
    return s;
}
