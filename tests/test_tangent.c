/* Tangent programs against central differences in many bits: of the right-hand side, and along the flow. */
#include <stdlib.h>

#include "problem.h"
#include "taylor/tangent.h"

enum { PREC = 700, SMALL = 170, MAX_STATES = 16 }; /* differences of 2^-170: errors of 2^-340 */

/* f(x), by an expansion of order 1. */
static void right_hand_side(cns_jet *J, int n, mpfr_t *x, mpfr_t *f)
{
    cns_error err;
    cns_jet_begin(J, 1);
    for (int i = 0; i < n; i++)
        cns_jet_set_state(J, i, x[i]);
    check_ok(cns_jet_expand(J, 1, &err), &err);
    for (int i = 0; i < n; i++)
        cns_jet_coefficient(J, f[i], i, 1);
}

/* At a random point (lower + (upper - lower) r for each state) along random directions. */
static void check_right_hand_side(const cns_program *p, const double *lower, const double *upper, uint64_t *s)
{
    enum { DIRECTIONS = 2 };
    int n = cns_program_states(p), index[MAX_STATES], d = cns_dynamic_states(p, index);
    int m = d * (1 + DIRECTIONS);
    cns_program *tangent;
    cns_error err;
    check_ok(cns_tangent_program(p, DIRECTIONS, &tangent, &err), &err);
    ck_assert_int_eq(cns_program_states(tangent), m);
    ck_assert_int_eq(cns_program_is_smooth(tangent), cns_program_is_smooth(p));
    cns_jet *J = jet_new(p, &cns_arith_mpfr, 1, PREC), *T = jet_new(tangent, &cns_arith_mpfr, 1, PREC);
    mpfr_t *x = cns_vector_xnew(n, PREC), *y = cns_vector_xnew(n, PREC), *f = cns_vector_xnew(n, PREC),
           *g = cns_vector_xnew(n, PREC);
    mpfr_t *z = cns_vector_xnew(m, PREC), *dz = cns_vector_xnew(m, PREC);
    for (int i = 0; i < n; i++)
        mpfr_set_d(x[i], lower[i] + (upper[i] - lower[i]) * test_random_unit(s), MPFR_RNDN);
    for (int i = 0; i < d; i++)
        mpfr_set(z[i], x[index[i]], MPFR_RNDN);
    for (int i = d; i < m; i++)
        mpfr_set_d(z[i], 2 * test_random_unit(s) - 1, MPFR_RNDN);
    right_hand_side(J, n, x, f);
    right_hand_side(T, m, z, dz);
    for (int i = 0; i < d; i++)
        check_close(dz[i], f[index[i]], 20.0 - PREC, "state %d", index[i]);
    for (int j = 0; j < DIRECTIONS; j++) {
        for (int sign = 1; sign >= -1; sign -= 2) {
            for (int i = 0; i < n; i++)
                mpfr_set(y[i], x[i], MPFR_RNDN);
            for (int i = 0; i < d; i++) {
                mpfr_mul_2si(y[index[i]], z[d * (1 + j) + i], -SMALL, MPFR_RNDN);
                mpfr_mul_si(y[index[i]], y[index[i]], sign, MPFR_RNDN);
                mpfr_add(y[index[i]], y[index[i]], x[index[i]], MPFR_RNDN);
            }
            right_hand_side(J, n, y, sign > 0 ? f : g);
        }
        for (int i = 0; i < d; i++) {
            mpfr_sub(f[index[i]], f[index[i]], g[index[i]], MPFR_RNDN);
            mpfr_mul_2si(f[index[i]], f[index[i]], SMALL - 1, MPFR_RNDN);
            check_close(dz[d * (1 + j) + i], f[index[i]], 60.0 - 2 * SMALL, "direction %d, state %d", j,
                        index[i]);
        }
    }
    cns_jet_free(J);
    cns_jet_free(T);
    cns_program_free(tangent);
    cns_vector_free(x);
    cns_vector_free(y);
    cns_vector_free(f);
    cns_vector_free(g);
    cns_vector_free(z);
    cns_vector_free(dz);
}

static const double ones[MAX_STATES] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
static const double minus_ones[MAX_STATES] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};

/* Every operation, shared and folded, constants in every place. State 3 is passive. */
static cns_program *everything(const char *smooth)
{
    cns_program *p = program_new(4, smooth);
    cns_node x = cns_state(p, 0), y = cns_state(p, 1), z = cns_state(p, 2), sn, cs;
    cns_node two = cns_constant(p, "2"), third = cns_constant(p, "1/3"), three = cns_constant(p, "3");
    cns_node u = cns_add(p, three, cns_mul(p, x, y)), v = cns_sub(p, cns_exp(p, z), cns_neg(p, two));
    cns_sincos(p, cns_sub(p, x, z), &sn, &cs);
    cns_node w = cns_hypot(p, cns_add(p, sn, two), cns_mul(p, y, cs));
    cns_derivative(p, 0,
                   cns_div(p, cns_add(p, cns_log(p, u), cns_mul(p, sn, cns_abs(p, cns_sub(p, y, two)))), v));
    cns_derivative(p, 1,
                   cns_mul(p, third,
                           cns_sub(p, cns_mul(p, w, cns_pow(p, u, cns_constant(p, "-7/3"))),
                                   cns_sqrt(p, cns_add(p, v, cns_sqr(p, x))))));
    cns_node drag = cns_mul(p, cns_abs(p, cns_sub(p, z, three)), cns_sub(p, z, three));
    cns_node more = cns_add(p, cns_div(p, cns_mul(p, two, drag), w), cns_hypot(p, x, three));
    cns_node powers = cns_mul(p, cns_pow(p, two, third), cns_div(p, cns_pow(p, v, third), cns_log(p, three)));
    cns_derivative(p, 2,
                   cns_sub(p, cns_sub(p, more, powers), cns_mul(p, cns_abs(p, cns_add(p, x, three)), cs)));
    cns_derivative(p, 3, cns_mul(p, x, cns_div(p, cns_state(p, 2), two)));
    cns_output(p, w);
    return finished(p);
}

START_TEST(agrees_with_differences)
{
    static const double apw_lower[] = {-1, -1, -3, -1, -1, 0.01}, apw_upper[] = {1, 1, 3, 1, 1, 1};
    static const double apw_below[] = {-1, -1, -3, -1, -1, -1}, apw_above[] = {1, 1, 3, 1, 1, -0.01};
    static const double lorenz_lower[] = {-20, -20, 0}, lorenz_upper[] = {20, 20, 40};
    uint64_t s = test_seed() + (uint64_t)_i;
    cns_program *p = _i < 2    ? model_program("apw", NULL)
                     : _i == 2 ? model_program("apw", "1/100")
                     : _i == 3 ? model_program("lorenz", NULL)
                               : everything(_i == 5 ? "1/50" : NULL);
    for (int turn = 0; turn < 10; turn++)
        switch (_i) {
        case 0:
        case 2:
            check_right_hand_side(p, apw_lower, apw_upper, &s);
            break;
        case 1:
            check_right_hand_side(p, apw_below, apw_above, &s);
            break;
        case 3:
            check_right_hand_side(p, lorenz_lower, lorenz_upper, &s);
            break;
        default:
            check_right_hand_side(p, minus_ones, ones, &s);
        }
    cns_program_free(p);
}
END_TEST

/* The tangent program of a tangent program: second derivatives. */
START_TEST(can_be_repeated)
{
    uint64_t s = test_seed() + 5;
    for (int smooth = 0; smooth < 2; smooth++) {
        cns_program *p = everything(smooth ? "1/50" : NULL), *first;
        cns_error err;
        check_ok(cns_tangent_program(p, 1, &first, &err), &err);
        cns_program_free(p); /* a tangent program stands on its own */
        check_right_hand_side(first, minus_ones, ones, &s);
        cns_program_free(first);
    }
}
END_TEST

START_TEST(has_the_dynamic_states)
{
    int index[MAX_STATES];
    cns_program *p = model_program("apw", NULL), *tangent;
    cns_error err;
    ck_assert_int_eq(cns_dynamic_states(p, index), 4);
    for (int i = 0; i < 4; i++)
        ck_assert_int_eq(index[i], i + 2);
    check_ok(cns_tangent_program(p, 0, &tangent, &err), &err);
    ck_assert_int_eq(cns_program_states(tangent), 4);
    cns_program_free(tangent);
    check_ok(cns_tangent_program(p, 4, &tangent, &err), &err);
    ck_assert_int_eq(cns_program_states(tangent), 20);
    cns_program_free(tangent);
    cns_program_free(p);
}
END_TEST

/* d(v')/dx is zero where f does not depend on x: x' = y, y' = 1 + x0 with a linear field, by hand. */
START_TEST(by_hand)
{
    cns_program *p = program_new(2, NULL), *tangent;
    cns_error err;
    cns_node x = cns_state(p, 0), y = cns_state(p, 1);
    cns_derivative(p, 0, cns_mul(p, x, y));
    cns_derivative(p, 1, cns_add(p, cns_constant(p, "5"), cns_mul(p, cns_constant(p, "3"), x)));
    check_ok(cns_tangent_program(finished(p), 1, &tangent, &err), &err);
    cns_jet *J = jet_new(tangent, &cns_arith_mpfr, 1, 100);
    mpfr_t *z = cns_vector_xnew(4, 100), *f = cns_vector_xnew(4, 100);
    for (int i = 0; i < 4; i++)
        mpfr_set_si(z[i], i + 2, MPFR_RNDN); /* x = 2, y = 3, dx = 4, dy = 5 */
    right_hand_side(J, 4, z, f);
    static const long expected[] = {6, 11, 4 * 3 + 2 * 5, 12};
    for (int i = 0; i < 4; i++)
        ck_assert_int_eq(mpfr_cmp_si(f[i], expected[i]), 0);
    cns_vector_free(z);
    cns_vector_free(f);
    cns_jet_free(J);
    cns_program_free(tangent);
    cns_program_free(p);
}
END_TEST

/* y oscillates through the kinks of |y| and |z|, at which the field is only continuous. */
static cns_program *kinked(void)
{
    cns_program *p = program_new(2, NULL);
    cns_node y = cns_state(p, 0), z = cns_state(p, 1), third = cns_constant(p, "1/3");
    cns_derivative(p, 0, cns_add(p, z, cns_mul(p, third, cns_abs(p, y))));
    cns_derivative(p, 1, cns_sub(p, cns_mul(p, cns_constant(p, "1/4"), cns_abs(p, z)), y));
    return finished(p);
}

/* The tangent along the flow is the difference of two neighbouring trajectories: to the size of the
 * difference where a kink is passed, to its square elsewhere. */
static const struct {
    const char *initial[6];
    const char *t;
    double decimals;
} flows[] = {
    {{"0", "0", "1", "-0.5", "0.4", "-0.05"}, "1.5", 16}, /* apw, exact: omega changes sign */
    {{"0", "0", "1", "-0.5", "0.4", "-0.05"}, "1.5", 34}, /* apw, smoothed */
    {{"-15.8", "-17.48", "35.64"}, "1.5", 34},            /* lorenz */
    {{"1", "0.3"}, "12", 16},                             /* kinked */
    {{"0", "1"}, "12", 16},                               /* kinked, from a zero */
    {{"0.3", "-0.2", "0.5", "0"}, "1/20", 34},            /* everything */
};

START_TEST(follows_the_flow)
{
    enum { DIGITS = 60, STEP_DECIMALS = 20 };
    cns_program *p = _i == 0   ? model_program("apw", NULL)
                     : _i == 1 ? model_program("apw", "1/100")
                     : _i == 2 ? model_program("lorenz", NULL)
                     : _i <= 4 ? kinked()
                               : everything(NULL);
    static const char *const direction[] = {"1", "-1/2", "1/3", "2/3"};
    int n = cns_program_states(p), index[MAX_STATES], d = cns_dynamic_states(p, index);
    cns_program *tangent;
    cns_error err;
    check_ok(cns_tangent_program(p, 1, &tangent, &err), &err);
    cns_flow_spec spec = taylor_spec(p, DIGITS), tangent_spec = taylor_spec(tangent, DIGITS);
    mpfr_t *x[2], *z = cns_vector_xnew(2 * d, spec.prec), eps;
    cns_number *start = numbers_new(n, flows[_i].initial), *v = numbers_new(d, direction);
    cns_number *both = malloc((size_t)(2 * d) * sizeof *both);
    mpq_t small, change;
    mpq_inits(small, change, (mpq_ptr)0);
    mpz_ui_pow_ui(mpq_denref(small), 10, STEP_DECIMALS);
    mpz_set_ui(mpq_numref(small), 1);
    for (int i = 0; i < d; i++) {
        both[i] = start[index[i]];
        both[d + i] = v[i];
    }
    tangent_spec.verify = _i != 3 && _i != 4; /* the tangent's derivative jumps where the field has a kink */
    cns_flow *f = flow_new(&tangent_spec);
    cns_flow_start(f, both);
    flow_to(f, flows[_i].t, z);
    long landings = cns_flow_landings(f);
    cns_flow_free(f);
    for (int side = 0; side < 2; side++) {
        for (int i = 0; i < d; i++) {
            mpq_mul(change, small, v[i].ratio);
            if (side)
                mpq_neg(change, change);
            mpq_add(start[index[i]].ratio, start[index[i]].ratio, change);
        }
        x[side] = cns_vector_xnew(n, spec.prec);
        f = flow_new(&spec);
        cns_flow_start(f, start);
        flow_to(f, flows[_i].t, x[side]);
        cns_flow_free(f);
        for (int i = 0; i < d; i++) {
            mpq_mul(change, small, v[i].ratio);
            if (side)
                mpq_neg(change, change);
            mpq_sub(start[index[i]].ratio, start[index[i]].ratio, change);
        }
    }
    ck_assert_msg((landings > 0) == (_i == 0 || _i == 3 || _i == 4), "%ld landings", landings);
    mpfr_init2(eps, spec.prec);
    mpfr_set_q(eps, small, MPFR_RNDN);
    for (int i = 0; i < d; i++) {
        mpfr_sub(x[0][index[i]], x[0][index[i]], x[1][index[i]], MPFR_RNDN);
        mpfr_div(x[0][index[i]], x[0][index[i]], eps, MPFR_RNDN);
        mpfr_div_2ui(x[0][index[i]], x[0][index[i]], 1, MPFR_RNDN);
        check_close(z[d + i], x[0][index[i]], DECIMALS(flows[_i].decimals), "flow %d, state %d", _i,
                    index[i]);
    }
    mpfr_clear(eps);
    mpq_clears(small, change, (mpq_ptr)0);
    cns_vector_free(x[0]);
    cns_vector_free(x[1]);
    cns_vector_free(z);
    free(both);
    numbers_free(start, n);
    numbers_free(v, d);
    cns_program_free(tangent);
    cns_program_free(p);
}
END_TEST

/* The trace of the Jacobian: the parts of the tangents along unit vectors that point along those, summed; and
 * exactly where it is the same rational number everywhere. */
START_TEST(trace_is_that_of_the_jacobian)
{
    static const struct {
        const char *model, *smooth, *exact;
    } traces[] = {{"lorenz", NULL, "-41/3"}, {"apw", NULL, NULL}, {"apw", "1/8", NULL}};
    uint64_t s = test_seed();
    for (int row = 0; row < COUNT(traces); row++) {
        cns_program *p = model_program(traces[row].model, traces[row].smooth), *tangent;
        int index[MAX_STATES], d = cns_dynamic_states(p, index), m = d * (1 + d) + 1;
        cns_error err;
        mpq_t exact, expected;
        mpq_inits(exact, expected, (mpq_ptr)0);
        check_ok(cns_traced_tangent_program(p, d, &tangent, &err), &err);
        ck_assert_int_eq(cns_program_states(tangent), m);
        ck_assert(!cns_program_is_dynamic(tangent, m - 1));
        cns_jet *T = jet_new(tangent, &cns_arith_mpfr, 1, PREC);
        mpfr_t *z = cns_vector_xnew(m, PREC), *dz = cns_vector_xnew(m, PREC);
        for (int i = 0; i < d; i++) {
            mpfr_set_d(z[i], 2 * test_random_unit(&s) - 1, MPFR_RNDN);
            mpfr_set_ui(z[d * (1 + i) + i], 1, MPFR_RNDN);
        }
        right_hand_side(T, m, z, dz);
        for (int i = 1; i < d; i++)
            mpfr_add(dz[d], dz[d], dz[d * (1 + i) + i], MPFR_RNDN);
        check_close(dz[m - 1], dz[d], 20.0 - PREC, "%s", traces[row].model);
        ck_assert_int_eq(cns_exact_derivative(tangent, m - 1, exact), traces[row].exact != NULL);
        if (traces[row].exact != NULL) {
            mpq_set_str(expected, traces[row].exact, 10);
            ck_assert(mpq_equal(exact, expected));
        }
        mpq_clears(exact, expected, (mpq_ptr)0);
        cns_vector_free(z);
        cns_vector_free(dz);
        cns_jet_free(T);
        cns_program_free(tangent);
        cns_program_free(p);
    }
}
END_TEST

/* Derivatives that are numbers: rational ones exactly, others not at all. */
START_TEST(constant_derivatives_are_exact)
{
    static const char *const exact[] = {"-7/12", NULL, NULL, NULL, "0"};
    cns_program *p = program_new(5, NULL);
    cns_node a = cns_constant(p, "2/3"), b = cns_constant(p, "0.5"), x = cns_state(p, 0);
    cns_node sum = cns_sub(p, cns_neg(p, cns_mul(p, a, b)), cns_sqr(p, b)); /* -1/3 - 1/4 */
    mpq_t y, expected;
    mpq_inits(y, expected, (mpq_ptr)0);
    cns_derivative(p, 0, cns_div(p, cns_add(p, sum, sum), cns_constant(p, "2")));
    cns_derivative(p, 1, cns_mul(p, a, cns_constant(p, "pi")));
    cns_derivative(p, 2, cns_mul(p, a, cns_sub(p, x, x)));
    cns_derivative(p, 3, cns_div(p, a, cns_sub(p, b, b)));
    cns_derivative(p, 4, cns_sub(p, b, b));
    finished(p);
    for (int i = 0; i < COUNT(exact); i++) {
        ck_assert_int_eq(cns_exact_derivative(p, i, y), exact[i] != NULL);
        if (exact[i] != NULL) {
            mpq_set_str(expected, exact[i], 10);
            ck_assert(mpq_equal(y, expected));
        }
    }
    mpq_clears(y, expected, (mpq_ptr)0);
    cns_program_free(p);
}
END_TEST

Suite *suite_tangent(void)
{
    Suite *s = suite_create("tangent");
    TCase *t = tcase_create("tangent");
    tcase_add_loop_test(t, agrees_with_differences, 0, 6);
    tcase_add_test(t, can_be_repeated);
    tcase_add_test(t, has_the_dynamic_states);
    tcase_add_test(t, by_hand);
    tcase_add_test(t, trace_is_that_of_the_jacobian);
    tcase_add_test(t, constant_derivatives_are_exact);
    add_table_test(t, follows_the_flow, flows);
    suite_add_tcase(s, t);
    return s;
}
