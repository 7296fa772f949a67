/* Unstable manifolds and the critical parameters they tell, against systems whose connections are known in
 * closed form, and against a start on the linear eigenvector in a separate integration. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cns/study/bisect.h"
#include "num/decimal_text.h"
#include "problem.h"
#include "study/saddle/branch.h"
#include "study/saddle/manifold.h"
#include "taylor/tangent.h"

/* A. A saddle with its unstable manifold in closed form: x' = x, y' = x^2 - y, that is y = x^2 / 3. */

static void build_parabola(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node x = cns_state(p, 0), y = cns_state(p, 1);
    cns_derivative(p, 0, x);
    cns_derivative(p, 1, cns_sub(p, cns_sqr(p, x), y));
}

/* B. A homoclinic orbit (B. Sandstede, J. Dynam. Diff. Equations 9 (1997) 269, without z): with m = mu^2 - 2
 * and x' = a x + b y - a x^2 + m x (2 - 3 x),   y' = b x + a y - 3/2 b x^2 - 3/2 a x y - 2 m y the curve x^2
 * (1 - x) = y^2 consists of solutions for m = 0, mu = sqrt 2. Eigenvalues a +- b. */
static void build_loop(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node x = cns_state(p, 0), y = cns_state(p, 1), xx = cns_sqr(p, x), xy = cns_mul(p, x, y);
    cns_node a = cns_constant(p, "-0.3"), two = cns_constant(p, "2"), three = cns_constant(p, "3");
    cns_node m = cns_sub(p, cns_sqr(p, cns_parameter(p, 0)), two), half3 = cns_constant(p, "3/2");
    cns_node fx = cns_add(p, cns_mul(p, a, x), y);
    fx = cns_sub(p, fx, cns_mul(p, a, xx));
    cns_derivative(p, 0,
                   cns_add(p, fx, cns_mul(p, m, cns_sub(p, cns_mul(p, two, x), cns_mul(p, three, xx)))));
    cns_node fy = cns_add(p, x, cns_mul(p, a, y));
    fy = cns_sub(p, fy, cns_mul(p, half3, cns_add(p, xx, cns_mul(p, a, xy))));
    cns_derivative(p, 1, cns_sub(p, fy, cns_mul(p, m, cns_mul(p, two, y))));
}

static int origin(const double *parameter, cns_model_guess *guess)
{
    (void)parameter;
    guess[0] = (cns_model_guess){.name = "origin"};
    return 1;
}

/* C. A pendulum with quadratic drag, driven by a constant torque: x' = y, y' = mu - sin x - d |y| y. While y
 * > 0, y^2 obeys a linear equation in x, and the unstable manifold of the saddle returns to the next one if
 *     mu = 2 d / sqrt(1 + 4 d^2).
 * The saddle, x = pi - asin mu, lies on the kink. */
static void build_pendulum(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node x = cns_state(p, 0), y = cns_state(p, 1), sine, cosine;
    cns_sincos(p, x, &sine, &cosine);
    cns_node drag = cns_mul(p, cns_parameter(p, 1), cns_mul(p, cns_abs(p, y), y));
    cns_derivative(p, 0, y);
    cns_derivative(p, 1, cns_sub(p, cns_sub(p, cns_parameter(p, 0), sine), drag));
}

static int upright(const double *parameter, cns_model_guess *guess)
{
    guess[0] = (cns_model_guess){.name = "upright", .state = {3.14159265358979 - asin(parameter[0]), 0}};
    return 1;
}

static const cns_model_symmetry revolution = {"revolution", (const signed char[2]){1, 1},
                                              (const char *const[2]){"2*pi", NULL}};

static const cns_model_state unit[] = {{"x", "", 1}, {"y", "", 1}},
                             small[] = {{"x", "", 0.2}, {"y", "", 0.2}};
static const cns_model_parameter mu_d[] = {{"mu", "", "0", NULL}, {"d", "", "1/2", NULL}};

static const cns_model parabola = {
    .name = "parabola", .n_states = 2, .states = unit, .build = build_parabola, .equilibria = origin};
static const cns_model_connection loop_connection = {"origin", 0, "out", "round"};
static const cns_model loop = {.name = "loop",
                               .n_states = 2,
                               .n_parameters = 1,
                               .states = small,
                               .parameters = mu_d,
                               .build = build_loop,
                               .equilibria = origin,
                               .connection = &loop_connection};
static const cns_model_connection pendulum_connection = {"upright", 0, "stops", "turns"};
static const cns_model pendulum = {.name = "pendulum",
                                   .n_states = 2,
                                   .n_parameters = 2,
                                   .states = unit,
                                   .parameters = mu_d,
                                   .build = build_pendulum,
                                   .equilibria = upright,
                                   .n_symmetries = 1,
                                   .symmetries = &revolution,
                                   .connection = &pendulum_connection};

/* A bisection of a model with its standard parameters, but for d where that is given. */
typedef struct bench {
    cns_number *bracket;
    cns_system *system;
    cns_monitor monitor;
    cns_bisect_spec spec;
    cns_bisect_result r;
    cns_error err;
} bench;

static void bench_open(bench *b, const cns_model *m, const char *lower, const char *upper, long decimals)
{
    const char *ends[2] = {lower, upper};
    *b = (bench){.bracket = numbers_new(2, ends), .system = system_new(m, NULL)};
    b->spec = (cns_bisect_spec){.parameter = 0, .by_manifold = true, .decimals = decimals};
    b->spec.lower = b->bracket[0];
    b->spec.upper = b->bracket[1];
}

/* The system with another number: parameter i, or the smoothing (-1). */
static void bench_set(bench *b, int i, const char *text)
{
    cns_number *x = numbers_new(1, &text);
    cns_system *other =
        i < 0 ? cns_system_smoothed(b->system, x, &b->err) : cns_system_with(b->system, i, x, &b->err);
    if (!other)
        ck_abort_msg("%s", b->err.text);
    cns_system_free(b->system);
    b->system = other;
    numbers_free(x, 1);
}

static void bench_close(bench *b)
{
    cns_bisect_clear(&b->r);
    cns_system_free(b->system);
    numbers_free(b->bracket, 2);
}

static cns_code bisect(bench *b, const char *directory)
{
    return cns_bisect(b->system, &b->spec, directory, &b->monitor, &b->r, &b->err);
}

static void check_critical(const bench *b, const mpfr_t x)
{
    char *right = cns_text_mpfr(x, CNS_PLACES_DECIMALS, b->spec.decimals);
    mpfr_t lower, upper;
    mpfr_inits2(1000, lower, upper, (mpfr_ptr)0);
    ck_assert_str_eq(b->r.critical, right);
    ck_assert_int_eq(b->r.decimals, b->spec.decimals);
    mpfr_set_str(lower, b->r.lower, 10, MPFR_RNDD);
    mpfr_set_str(upper, b->r.upper, 10, MPFR_RNDU);
    ck_assert_msg(mpfr_cmp(lower, x) < 0 && mpfr_cmp(x, upper) < 0, "%s and %s do not hold %s", b->r.lower,
                  b->r.upper, right);
    ck_assert_str_ne(b->r.lower_mode, b->r.upper_mode);
    free(right);
    mpfr_clears(lower, upper, (mpfr_ptr)0);
}

static void open_branch(cns_branch *b, cns_reduced *r, cns_fixed_point *f, const cns_system *s, int order,
                        mpfr_prec_t prec)
{
    cns_model_guess guess[CNS_MODEL_MAX_GUESSES];
    cns_error err;
    ck_assert_int_gt(cns_system_guesses(s, guess), 0);
    check_ok(cns_reduced_open(r, cns_system_program(s), &err), &err);
    cns_fixed_point_init(f, r->d);
    check_ok(cns_fixed_point_find(r, guess[0].state, (slong)prec + 64, f, &err), &err);
    check_ok(cns_branch_open(b, r, f, 0, cns_system_scales(s), order, prec, &err), &err);
}

START_TEST(a_branch)
{
    bench u;
    cns_reduced r;
    cns_fixed_point f;
    cns_branch b;
    mpfr_t third;
    bench_open(&u, &parabola, "0", "1", 1);
    open_branch(&b, &r, &f, u.system, 20, 300);
    mpfr_init2(third, 300);
    mpfr_set_ui(third, 1, MPFR_RNDN);
    ck_assert(mpfr_equal_p(b.lambda, third) != 0);
    for (int n = 0; n <= 20; n++) {
        ck_assert(mpfr_cmp_ui(b.p[2 * n], n == 1) == 0);
        mpfr_set_ui(third, n == 2, MPFR_RNDN);
        mpfr_div_ui(third, third, 3, MPFR_RNDN);
        check_close(b.p[2 * n + 1], third, -295.0, "coefficient %d of y", n);
    }
    mpfr_clear(third);
    cns_branch_close(&b);
    cns_fixed_point_clear(&f);
    cns_reduced_close(&r);
    bench_close(&u);
}
END_TEST

/* x' = x, y' = x + |x - 1/4| - 1/4 - 2 y: the branch is y = 0 up to the kink at x = 1/4, which its series
 * does not know of. */
static void build_kink(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node x = cns_state(p, 0), y = cns_state(p, 1), quarter = cns_constant(p, "1/4");
    cns_node kink = cns_abs(p, cns_sub(p, x, quarter));
    cns_derivative(p, 0, x);
    cns_derivative(p, 1,
                   cns_sub(p, cns_sub(p, cns_add(p, x, kink), quarter), cns_mul(p, cns_constant(p, "2"), y)));
}

START_TEST(a_branch_that_is_none)
{
    const cns_model kink = {
        .name = "kink", .n_states = 2, .states = unit, .build = build_kink, .equilibria = origin};
    cns_system *s = system_new(&kink, NULL);
    cns_model_guess guess[CNS_MODEL_MAX_GUESSES];
    cns_reduced r;
    cns_fixed_point f;
    cns_branch b;
    cns_error err;
    ck_assert_int_eq(cns_system_guesses(s, guess), 1);
    check_ok(cns_reduced_open(&r, cns_system_program(s), &err), &err);
    cns_fixed_point_init(&f, r.d);
    check_ok(cns_fixed_point_find(&r, guess[0].state, 364, &f, &err), &err);
    ck_assert_int_eq(cns_branch_open(&b, &r, &f, 0, cns_system_scales(s), 20, 300, &err), CNS_NUMERIC);
    ck_assert_msg(strstr(err.text, "does not solve the equations (state 1") != NULL, "%s", err.text);
    cns_branch_close(&b);
    cns_fixed_point_clear(&f);
    cns_reduced_close(&r);
    cns_system_free(s);
}
END_TEST

/* The pendulum's branch from its kink: E = y^2 solves dE/dx = 2 (mu - sin x) - 2 d E, E = 0 at the saddle; d
 * = 1/2: E = 2 mu + cos x - sin x + c e^-x. */
START_TEST(branch_on_kink)
{
    enum { PREC = 400 };
    bench u;
    cns_reduced r;
    cns_fixed_point f;
    cns_branch b;
    mpfr_t energy, sine, cosine, c;
    mpfr_t *x = cns_vector_xnew(2, PREC);
    const char *mu = "3/5";
    bench_open(&u, &pendulum, "0", "1", 1);
    bench_set(&u, 0, mu);
    open_branch(&b, &r, &f, u.system, 80, PREC);
    mpfr_inits2(PREC, energy, sine, cosine, c, (mpfr_ptr)0);
    for (int turn = 0; turn < 2; turn++) {
        if (turn == 0) {
            mpfr_set(x[0], b.p[0], MPFR_RNDN);
            mpfr_set_zero(x[1], 1);
        } else {
            cns_branch_eval(&b, b.s, x);
            ck_assert(mpfr_cmp_d(b.s, 1e-4) > 0 && mpfr_sgn(x[1]) > 0);
        }
        mpfr_sin_cos(sine, cosine, x[0], MPFR_RNDN);
        mpfr_sqr(energy, x[1], MPFR_RNDN);
        mpfr_sub_d(energy, energy, 0, MPFR_RNDN);
        mpfr_sub(energy, energy, cosine, MPFR_RNDN);
        mpfr_add(energy, energy, sine, MPFR_RNDN);
        mpfr_set_ui(sine, 6, MPFR_RNDN);
        mpfr_div_ui(sine, sine, 5, MPFR_RNDN);
        mpfr_sub(energy, energy, sine, MPFR_RNDN);
        mpfr_exp(cosine, x[0], MPFR_RNDN);
        mpfr_mul(energy, energy, cosine, MPFR_RNDN); /* c */
        if (turn > 0)
            check_close(energy, c, 20.0 - PREC, "energy");
        mpfr_set(c, energy, MPFR_RNDN);
    }
    mpfr_clears(energy, sine, cosine, c, (mpfr_ptr)0);
    cns_vector_free(x);
    cns_branch_close(&b);
    cns_fixed_point_clear(&f);
    cns_reduced_close(&r);
    bench_close(&u);
}
END_TEST

START_TEST(homoclinic)
{
    bench b;
    mpfr_t x;
    bench_open(&b, &loop, "1.41", "1.42", 40);
    check_ok(bisect(&b, NULL), &b.err);
    mpfr_init2(x, 1000);
    mpfr_sqrt_ui(x, 2, MPFR_RNDN);
    check_critical(&b, x);
    mpfr_clear(x);
    bench_close(&b);
}
END_TEST

/* With the kink, for a random d: sqrt by MPFR alone. */
START_TEST(heteroclinic)
{
    uint64_t s = test_seed();
    bench b;
    mpfr_t x, d;
    char text[32];
    bench_open(&b, &pendulum, "0", "0.99", 35);
    snprintf(text, sizeof text, "%.3f", 0.2 + 0.8 * test_random_unit(&s));
    bench_set(&b, 1, text);
    mpfr_inits2(1000, x, d, (mpfr_ptr)0);
    cns_number_get_mpfr(d, &cns_system_parameters(b.system)[1]);
    mpfr_mul_ui(d, d, 2, MPFR_RNDN);
    mpfr_sqr(x, d, MPFR_RNDN);
    mpfr_add_ui(x, x, 1, MPFR_RNDN);
    mpfr_sqrt(x, x, MPFR_RNDN);
    mpfr_div(x, d, x, MPFR_RNDN);
    char lower[32], upper[32];
    snprintf(lower, sizeof lower, "%.3f", mpfr_get_d(x, MPFR_RNDN) - 0.013);
    snprintf(upper, sizeof upper, "%.3f", mpfr_get_d(x, MPFR_RNDN) + 0.021);
    check_ok(cns_number_parse(&b.bracket[0], lower, &b.err), &b.err);
    check_ok(cns_number_parse(&b.bracket[1], upper, &b.err), &b.err);
    b.spec.lower = b.bracket[0];
    b.spec.upper = b.bracket[1];
    check_ok(bisect(&b, NULL), &b.err);
    check_critical(&b, x);
    ck_assert_str_eq(b.r.lower_mode, "stops");
    ck_assert_str_eq(b.r.upper_mode, "turns");
    mpfr_clears(x, d, (mpfr_ptr)0);
    bench_close(&b);
}
END_TEST

/* d = 3/8 makes it 3/5: an estimate may hit the connection itself, and no number of digits tells its side. */
START_TEST(exact_hit)
{
    bench b;
    mpfr_t x;
    mpfr_init2(x, 1000);
    mpfr_set_ui(x, 3, MPFR_RNDN);
    mpfr_div_ui(x, x, 5, MPFR_RNDN);
    bench_open(&b, &pendulum, "0.59", "0.61", 20);
    bench_set(&b, 1, "3/8");
    check_ok(bisect(&b, NULL), &b.err);
    check_critical(&b, x);
    bench_close(&b);
    cns_passage p;
    const cns_passage_spec spec = {.digits = 40};
    bench_open(&b, &pendulum, "0.6", "0.61", 20);
    bench_set(&b, 0, "0.6");
    bench_set(&b, 1, "3/8");
    cns_passage_init(&p, 200);
    ck_assert_int_eq(cns_manifold_passage(b.system, &spec, NULL, &p, &b.err), CNS_UNREACHED);
    ck_assert_int_eq(bisect(&b, NULL), CNS_UNREACHED);
    ck_assert_ptr_null(b.r.critical);
    cns_passage_clear(&p);
    bench_close(&b);
    mpfr_clear(x);
}
END_TEST

START_TEST(refused)
{
    bench b;
    bench_open(&b, cns_model_find("apw"), "1.2192", "1.2193", 10);
    ck_assert_int_eq(bisect(&b, NULL), CNS_UNREACHED);
    ck_assert_ptr_null(b.r.critical);
    ck_assert_str_eq(b.r.lower_mode, "tumble");
    ck_assert_str_eq(b.r.upper_mode, "tumble");
    bench_close(&b);
    bench_open(&b, &parabola, "0", "1", 10);
    ck_assert_int_eq(bisect(&b, NULL), CNS_USAGE);
    bench_close(&b);
    volatile sig_atomic_t stop = 1;
    bench_open(&b, cns_model_find("apw"), "1.2191", "1.2193", 10);
    b.monitor.stop = &stop;
    ck_assert_int_eq(bisect(&b, NULL), CNS_STOPPED);
    bench_close(&b);
}
END_TEST

/* Which way a disk goes that is put on the linear eigenvector, 1e-24 from the saddle, by another integration:
 * MPFR, other orders, no coordinates of the next saddle. 1: it turns over before it swings back. */
static int goes_over(const char *inertia)
{
    enum { THETA, VX, VY, OMEGA };
    const cns_model *m = cns_model_find("apw");
    const char *texts[7];
    cns_program *p, *field;
    cns_error err;
    for (int i = 0; i < 7; i++)
        texts[i] = i == 0 ? inertia : m->parameters[i].standard;
    cns_number *parameters = numbers_new(7, texts);
    const cns_program_options options = {NULL};
    check_ok(cns_model_program(m, parameters, &options, &p, &err), &err);
    check_ok(cns_tangent_program(p, 0, &field, &err), &err);
    const cns_flow_spec spec = taylor_spec(field, 50);
    cns_flow *f = flow_new(&spec);
    mpfr_t *x = cns_vector_xnew(4, 300);
    mpfr_t pi, lambda, residue, k, c;
    mpfr_inits2(300, pi, lambda, residue, k, c, (mpfr_ptr)0);
    mpfr_const_pi(pi, MPFR_RNDN);
    /* The eigenvector (1, 0, w, lambda): lambda^2 = k (v w - mu1 lambda), and the Vy equation, solved by
     * bisection in lambda on the characteristic polynomial's positive root. */
    mpfr_t v, I, low, high, w, t;
    mpfr_inits2(300, v, I, low, high, w, t, (mpfr_ptr)0);
    cns_number_get_mpfr(I, &parameters[0]);
    mpfr_div_d(v, pi, 1, MPFR_RNDN);
    mpfr_mul_ui(v, v, 5, MPFR_RNDN);
    mpfr_div_ui(v, v, 2, MPFR_RNDN);
    mpfr_sqrt(v, v, MPFR_RNDN);
    mpfr_add_d(k, I, 0.5, MPFR_RNDN);
    mpfr_ui_div(k, 4, k, MPFR_RNDN);
    mpfr_set_zero(low, 1);
    mpfr_set_ui(high, 2, MPFR_RNDN);
    for (int turn = 0; turn < 280; turn++) {
        mpfr_add(lambda, low, high, MPFR_RNDN);
        mpfr_div_2ui(lambda, lambda, 1, MPFR_RNDN);
        mpfr_sqr(w, lambda, MPFR_RNDN); /* w = (lambda^2 / k + 0.2 lambda) / v */
        mpfr_div(w, w, k, MPFR_RNDN);
        mpfr_div_ui(t, lambda, 5, MPFR_RNDN);
        mpfr_add(w, w, t, MPFR_RNDN);
        mpfr_div(w, w, v, MPFR_RNDN);
        /* (I + 1) lambda w = 1 - (2.4 + 0.4) v w / pi + (I - 2) v lambda */
        mpfr_add_ui(residue, I, 1, MPFR_RNDN);
        mpfr_mul(residue, residue, lambda, MPFR_RNDN);
        mpfr_mul(residue, residue, w, MPFR_RNDN);
        mpfr_sub_ui(residue, residue, 1, MPFR_RNDN);
        mpfr_mul(t, v, w, MPFR_RNDN);
        mpfr_mul_ui(t, t, 14, MPFR_RNDN);
        mpfr_div_ui(t, t, 5, MPFR_RNDN);
        mpfr_div(t, t, pi, MPFR_RNDN);
        mpfr_add(residue, residue, t, MPFR_RNDN);
        mpfr_sub_ui(t, I, 2, MPFR_RNDN);
        mpfr_mul(t, t, v, MPFR_RNDN);
        mpfr_mul(t, t, lambda, MPFR_RNDN);
        mpfr_sub(residue, residue, t, MPFR_RNDN);
        mpfr_set(mpfr_sgn(residue) < 0 ? low : high, lambda, MPFR_RNDN);
    }
    mpfr_set_str(c, "1e-24", 10, MPFR_RNDN);
    mpfr_div_2ui(x[THETA], pi, 1, MPFR_RNDN);
    mpfr_add(x[THETA], x[THETA], c, MPFR_RNDN);
    mpfr_neg(x[VX], v, MPFR_RNDN);
    mpfr_mul(x[VY], w, c, MPFR_RNDN);
    mpfr_mul(x[OMEGA], lambda, c, MPFR_RNDN);
    cns_flow_start_at(f, (const mpfr_t *)x);
    double theta = 0;
    while (theta < 4 || (theta > 3.5 && theta < 6)) { /* it comes near 3 pi / 2 = 4.71 */
        check_ok(cns_flow_step(f, &err), &err);
        theta = mpfr_get_d(cns_flow_state(f)[0], MPFR_RNDN);
        if (theta > 4 && theta < 4.2 && mpfr_sgn(cns_flow_state(f)[OMEGA]) < 0)
            break;
        ck_assert(mpfr_cmp_ui(cns_flow_end(f), 1000) < 0);
    }
    mpfr_clears(pi, lambda, residue, k, c, v, I, low, high, w, t, (mpfr_ptr)0);
    cns_vector_free(x);
    cns_flow_free(f);
    cns_program_free(field);
    cns_program_free(p);
    numbers_free(parameters, 7);
    return theta > 5;
}

START_TEST(the_disk)
{
    bench b;
    mpfr_t x, paper;
    bench_open(&b, cns_model_find("apw"), "1.21", "1.23", 20);
    check_ok(bisect(&b, NULL), &b.err);
    ck_assert_str_eq(b.r.lower_mode, "flutter");
    ck_assert_str_eq(b.r.upper_mode, "tumble");
    ck_assert_msg(b.r.probes < 16, "%ld probes", b.r.probes); /* bisection takes seventy */
    ck_assert_int_eq(goes_over(b.r.lower), 0);
    ck_assert_int_eq(goes_over(b.r.upper), 1);
    /* The value of Xu, Li, Li and Liao flutters; measured before with another program: 3.3e-14 below. */
    mpfr_inits2(200, x, paper, (mpfr_ptr)0);
    mpfr_set_str(x, b.r.critical, 10, MPFR_RNDN);
    mpfr_set_str(paper, "1.2191466312021015", 10, MPFR_RNDN);
    mpfr_sub(x, x, paper, MPFR_RNDN);
    ck_assert(mpfr_cmp_d(x, 3.25e-14) > 0 && mpfr_cmp_d(x, 3.35e-14) < 0);
    mpfr_clears(x, paper, (mpfr_ptr)0);
    bench_close(&b);
}
END_TEST

/* Both variants see the same passage, and its miss grows like the distance from the connection. */
START_TEST(a_passage)
{
    bench b;
    cns_passage p[2];
    double miss[2];
    static const char *const at[] = {"1.2190", "1.2193"};
    bench_open(&b, cns_model_find("apw"), "1.21", "1.23", 20);
    for (int i = 0; i < 2; i++) {
        bench_set(&b, 0, at[i]);
        for (int variant = 0; variant < 2; variant++) {
            const cns_passage_spec spec = {.digits = 30, .variant = variant};
            cns_passage_init(&p[variant], 200);
            check_ok(cns_manifold_passage(b.system, &spec, NULL, &p[variant], &b.err), &b.err);
            ck_assert_int_eq(p[variant].side, i ? 1 : -1);
        }
        check_close(p[0].miss, p[1].miss, DECIMALS(30.0), "the miss");
        ck_assert(fabs(p[0].lambda - 0.3813) < 1e-3);
        miss[i] = mpfr_get_d(p[0].miss, MPFR_RNDN);
        cns_passage_clear(&p[0]);
        cns_passage_clear(&p[1]);
    }
    double ratio = miss[0] / (1.2190 - 1.219146631) / (miss[1] / (1.2193 - 1.219146631));
    ck_assert_msg(fabs(ratio - 1) < 0.02, "%g", ratio);
    bench_close(&b);
}
END_TEST

/* Smoothing so small that it cannot show changes nothing; a larger one moves the connection, but little. */
START_TEST(smoothed)
{
    static const char *const eps[] = {"1e-40", "1e-3"};
    for (int i = 0; i < 2; i++) {
        bench b;
        bench_open(&b, cns_model_find("apw"), "1.2191", "1.2192", 12);
        bench_set(&b, -1, eps[i]);
        check_ok(bisect(&b, NULL), &b.err);
        if (i == 0)
            ck_assert_str_eq(b.r.critical, "1.219146631202");
        else
            ck_assert_msg(!strncmp(b.r.critical, "1.219146", 8) && strcmp(b.r.critical, "1.219146631202"),
                          "%s", b.r.critical);
        bench_close(&b);
    }
}
END_TEST

/* The period of the motion that a disk settles to near the connection: two saddles are passed in it. */
static double period_at(bench *b, const char *inertia, double *lambda)
{
    const cns_passage_spec spec = {.digits = 30, .passes = 4};
    cns_passage p;
    cns_passage_init(&p, 200);
    bench_set(b, 0, inertia);
    check_ok(cns_manifold_passage(b->system, &spec, NULL, &p, &b->err), &b->err);
    *lambda = p.lambda;
    const double period = 2 * p.interval;
    cns_passage_clear(&p);
    return period;
}

/* T = T0 + (2 / lambda) ln(1 / |I - I_c|) on both sides, over nine decades; and periods measured before, from
 * whole trajectories of another program, to two decimals. */
START_TEST(period_law)
{
    static const char *const near[2][2] = {{"1.219046631202134125", "1.219246631202134125"},  /* 1e-4 */
                                           {"1.219146631202034125", "1.219146631202234125"}}; /* 1e-13 */
    static const char *const measured[] = {"1.2190", "1.2191", "1.2192"};
    static const double periods[] = {50.66, 56.67, 55.98};
    bench b;
    double lambda;
    bench_open(&b, cns_model_find("apw"), "1.21", "1.23", 20);
    for (int side = 0; side < 2; side++) {
        const double far = period_at(&b, near[0][side], &lambda),
                     close = period_at(&b, near[1][side], &lambda);
        const double slope = (close - far) / (9 * log(10)), error = slope * lambda / 2 - 1;
        ck_assert_msg(fabs(error) < 3e-4, "side %d: the slope is off by %g", side, error);
        ck_assert(fabs(close - 2 / lambda * 13 * log(10) - 4.3708) < 1e-3);
    }
    for (int i = 0; i < 3; i++)
        ck_assert_msg(fabs(period_at(&b, measured[i], &lambda) - periods[i]) < 0.0051, "%s: %.4f",
                      measured[i], period_at(&b, measured[i], &lambda));
    bench_close(&b);
}
END_TEST

/* A second bisection with the same directory computes nothing, and more decimals use what is there. */
START_TEST(kept_probes)
{
    char directory[] = "/tmp/cns-manifold.XXXXXX", command[128];
    ck_assert_ptr_nonnull(mkdtemp(directory));
    bench b, again;
    bench_open(&b, &pendulum, "0.7", "0.71", 20);
    bench_open(&again, &pendulum, "0.7", "0.71", 20);
    check_ok(bisect(&b, directory), &b.err);
    volatile sig_atomic_t stop = 1; /* no probe can be made any more */
    again.monitor.stop = &stop;
    check_ok(bisect(&again, directory), &again.err);
    ck_assert_str_eq(again.r.critical, b.r.critical);
    ck_assert_str_eq(again.r.lower, b.r.lower);
    ck_assert_int_eq(again.r.probes, b.r.probes);
    bench_close(&again);
    bench_close(&b);
    snprintf(command, sizeof command, "rm -r %s", directory);
    ck_assert_int_eq(system(command), 0);
}
END_TEST

Suite *suite_manifold(void)
{
    Suite *s = suite_create("manifold");
    TCase *t = tcase_create("manifold");
    tcase_add_test(t, a_branch);
    tcase_add_test(t, a_branch_that_is_none);
    tcase_add_test(t, branch_on_kink);
    tcase_add_test(t, homoclinic);
    tcase_add_test(t, heteroclinic);
    tcase_add_test(t, exact_hit);
    tcase_add_test(t, refused);
    tcase_add_test(t, the_disk);
    tcase_add_test(t, a_passage);
    tcase_add_test(t, smoothed);
    tcase_add_test(t, period_law);
    tcase_add_test(t, kept_probes);
    suite_add_tcase(s, t);
    return s;
}
