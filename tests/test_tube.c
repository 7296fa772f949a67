/* The tube around a run holds the exact solution: against runs of many more digits, whatever is done to the
 * run. */
#include <math.h>
#include <stdlib.h>

#include "integrate/tube.h"
#include "num/flint.h"
#include "problem.h"

enum { MORE = 25 }; /* digits of the reference */

typedef struct tried {
    const char *model;
    int n;
    const char *end;
    double spread; /* of random initial values about these */
    double initial[6];
} tried;

static const tried systems[] = {
    {"lorenz", 3, "8", 5, {1, 1, 20}},
    {"apw", 6, "12", 0.3, {0, 0, 1, 0.1, 0.3, 1}},
    {"apw", 6, "6", 1e-6, {0, 0, 1, 1e-5, -1e-5, 0}},
};

static double log2_mag(const mag_t x)
{
    mpfr_t y;
    arf_t f;
    mpfr_init2(y, 53);
    arf_init(f);
    arf_set_mag(f, x);
    arf_get_mpfr(y, f, MPFR_RNDN);
    const double l = log2_of(y);
    mpfr_clear(y);
    arf_clear(f);
    return l;
}

/* A run with its tube, beside a reference, to the end; a planted error (NULL: none) is added to a random
 * state at the end of step `at`. Returns the worst log2(bound) - log2(error) over all rows, or HUGE_VAL
 * without a row; *rows counts them. */
static double distance_to_tube(const tried *t, long digits, cns_arithmetic arithmetic, uint64_t *s, long at,
                               const double *planted, long *rows)
{
    enum { ROWS = 16 };
    cns_error err;
    cns_program *p = model_program(t->model, NULL);
    char text[6][64];
    const char *initial[6];
    for (int i = 0; i < t->n; i++) {
        snprintf(text[i], sizeof text[i], "%.17g", t->initial[i] + t->spread * (2 * test_random_unit(s) - 1));
        initial[i] = text[i];
    }
    cns_number *x0 = numbers_new(t->n, initial), *end = numbers_new(1, &t->end);
    cns_flow_spec spec = cns_flow_spec_taylor(p, unit_scales, arithmetic, digits),
                  more = cns_flow_spec_taylor(p, unit_scales, CNS_ARITH_FAST, digits + MORE);
    cns_flow *f = flow_new(&spec), *reference = flow_new(&more);
    cns_flow_start(f, x0);
    cns_flow_start(reference, x0);
    cns_tube *tube = cns_tube_new(p, spec.prec, &err);
    ck_assert_ptr_nonnull(tube);
    cns_tube_start(tube, f, x0);
    mpfr_t *x = cns_vector_xnew(t->n, spec.prec), *y = cns_vector_xnew(t->n, more.prec);
    mag_ptr error = _mag_vec_init(t->n);
    mpq_t time;
    mpq_init(time);
    double worst = HUGE_VAL;
    cns_code code = CNS_OK;
    for (int row = 0; row <= ROWS && !code; row++) {
        mpq_set_si(time, row, ROWS);
        mpq_mul(time, time, end->ratio);
        while (!code && mpfr_cmp_q(cns_flow_end(f), time) < 0) {
            check_ok(cns_flow_step(f, &err), &err);
            const bool now = planted && cns_flow_steps(f) == at;
            if (!now || *planted < 0) /* the error is made after the tube has looked, or before */
                code = cns_tube_follow(tube, f, &err);
            if (now) {
                const int i = (int)test_random_below(s, (uint64_t)t->n);
                mpfr_set(x[0], cns_flow_state(f)[i], MPFR_RNDN);
                mpfr_add_d(x[0], x[0], *planted, MPFR_RNDN);
                cns_flow_replace(f, i, 1, x);
                if (*planted > 0)
                    code = cns_tube_follow(tube, f, &err);
            }
        }
        while (mpfr_cmp_q(cns_flow_end(reference), time) < 0)
            check_ok(cns_flow_step(reference, &err), &err);
        if (code)
            break;
        cns_flow_eval(f, time, x);
        cns_flow_eval(reference, time, y);
        cns_tube_at(tube, f, time, x, error);
        for (int i = 0; i < t->n; i++) {
            const double distance = log2_distance(x[i], y[i]);
            ++*rows;
            /* The reference has an error of its own, which growth may have made 2^40 of its last digits. */
            if (distance > 40 - (double)more.prec)
                worst = fmin(worst, log2_mag(error + i) - distance);
        }
    }
    mpq_clear(time);
    _mag_vec_clear(error, t->n);
    cns_vector_free(x);
    cns_vector_free(y);
    cns_tube_free(tube);
    cns_flow_free(f);
    cns_flow_free(reference);
    cns_program_free(p);
    numbers_free(x0, t->n);
    numbers_free(end, 1);
    return worst;
}

START_TEST(holds_the_solution)
{
    enum { RUNS = 12 };
    uint64_t s = test_seed() + (uint64_t)_i;
    long rows = 0;
    for (int i = 0; i < RUNS; i++) {
        const long digits = 24 + (long)test_random_below(&s, 60);
        ck_assert_double_ge(distance_to_tube(&systems[_i], digits,
                                             i % 4 == 3 ? CNS_ARITH_MPFR : CNS_ARITH_FAST, &s, 0, NULL,
                                             &rows),
                            0);
    }
    ck_assert_int_gt(rows, RUNS * 16);
}
END_TEST

/* An error made in the run, of any size, at any step, in any state, is inside the bound from there on. */
START_TEST(planted_errors_are_noticed)
{
    enum { RUNS = 40 };
    uint64_t s = test_seed() + 10 + (uint64_t)_i;
    long rows = 0;
    for (int i = 0; i < RUNS; i++) {
        const long digits = 24 + (long)test_random_below(&s, 30);
        const double size = pow(10, -4 - 20 * test_random_unit(&s)) * (test_random_below(&s, 2) ? 1 : -1);
        ck_assert_double_ge(distance_to_tube(&systems[_i], digits, CNS_ARITH_FAST, &s,
                                             1 + (long)test_random_below(&s, 40), &size, &rows),
                            0);
    }
    ck_assert_int_gt(rows, RUNS * 16);
}
END_TEST

/* A run of a program of n states for so many steps, `by` being added to a state after the first; error[i] is
 * the bound at the end, x the states there. */
static void follow_program(const cns_program *p, int n, const char *const *initial, int steps, int state,
                           double by, mpfr_t *x, mpq_t time, mag_ptr error)
{
    cns_error err;
    cns_number *x0 = numbers_new(n, initial);
    const cns_flow_spec spec = cns_flow_spec_taylor(p, unit_scales, CNS_ARITH_FAST, 40);
    cns_flow *f = flow_new(&spec);
    cns_flow_start(f, x0);
    cns_tube *tube = cns_tube_new(p, spec.prec, &err);
    ck_assert_ptr_nonnull(tube);
    cns_tube_start(tube, f, x0);
    for (int k = 1; k <= steps; k++) {
        check_ok(cns_flow_step(f, &err), &err);
        if (k == 1 && by != 0) {
            mpfr_add_d(x[0], cns_flow_state(f)[state], by, MPFR_RNDN);
            cns_flow_replace(f, state, 1, x);
        }
        check_ok(cns_tube_follow(tube, f, &err), &err);
    }
    mpfr_get_q(time, cns_flow_end(f));
    cns_flow_eval(f, time, x);
    cns_tube_at(tube, f, time, x, error);
    cns_tube_free(tube);
    cns_flow_free(f);
    numbers_free(x0, n);
}

/* u' = -u, p' = u, q' = p, r' = q: p, q and r feed back on nothing, but p's error is q's, and q's is r's. */
START_TEST(errors_go_from_passive_states_to_others)
{
    enum { N = 4 };
    static const char *const initial[N] = {"1", "-1", "1", "0"};
    const double planted = 1e-10;
    cns_program *p = program_new(N, NULL);
    cns_derivative(p, 0, cns_neg(p, cns_state(p, 0)));
    for (int i = 1; i < N; i++)
        cns_derivative(p, i, cns_state(p, i - 1));
    finished(p);
    mpfr_t *x = cns_vector_xnew(N, 200);
    mag_ptr error = _mag_vec_init(N);
    mpq_t time;
    mpq_init(time);
    follow_program(p, N, initial, 12, 1, planted, x, time, error);
    /* p = -e^-t, q = e^-t, r = 1 - e^-t, but for what was added at the end of the first step. */
    const double q = mpfr_get_d(x[2], MPFR_RNDN) - exp(-mpq_get_d(time)),
                 r = mpfr_get_d(x[3], MPFR_RNDN) - 1 + exp(-mpq_get_d(time));
    ck_assert_double_gt(q, 5 * planted);
    ck_assert_double_gt(r, 2 * q);
    ck_assert_double_ge(mag_get_d(error + 1), planted);
    ck_assert_double_ge(mag_get_d(error + 2) * (1 + 1e-6), q);
    ck_assert_double_ge(mag_get_d(error + 3) * (1 + 1e-6), r);
    mpq_clear(time);
    _mag_vec_clear(error, N);
    cns_vector_free(x);
    cns_program_free(p);
}
END_TEST

/* |s| s of s = |v| v: the tangents have a held sign within a product that another held sign multiplies. */
START_TEST(kinks_of_kinks_are_bounded)
{
    enum { N = 2 };
    static const char *const initial[N] = {"1", "1/2"};
    cns_program *p = program_new(N, NULL);
    const cns_node u = cns_state(p, 0), v = cns_state(p, 1), s = cns_mul(p, cns_abs(p, v), v),
                   q = cns_mul(p, cns_abs(p, s), s);
    cns_derivative(p, 0, q);
    cns_derivative(p, 1, cns_neg(p, cns_add(p, q, u)));
    finished(p);
    mpfr_t *x = cns_vector_xnew(N, 200);
    mag_ptr error = _mag_vec_init(N);
    mpq_t time;
    mpq_init(time);
    follow_program(p, N, initial, 2, 0, 0, x, time, error);
    for (int i = 0; i < N; i++)
        ck_assert_double_lt(log2_mag(error + i), -90);
    mpq_clear(time);
    _mag_vec_clear(error, N);
    cns_vector_free(x);
    cns_program_free(p);
}
END_TEST

Suite *suite_tube(void)
{
    Suite *s = suite_create("tube");
    TCase *t = tcase_create("bounds");
    tcase_set_timeout(t, 600);
    add_table_test(t, holds_the_solution, systems);
    add_table_test(t, planted_errors_are_noticed, systems);
    tcase_add_test(t, errors_go_from_passive_states_to_others);
    tcase_add_test(t, kinks_of_kinks_are_bounded);
    suite_add_tcase(s, t);
    return s;
}
