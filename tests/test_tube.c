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

Suite *suite_tube(void)
{
    Suite *s = suite_create("tube");
    TCase *t = tcase_create("bounds");
    tcase_set_timeout(t, 600);
    add_table_test(t, holds_the_solution, systems);
    add_table_test(t, planted_errors_are_noticed, systems);
    suite_add_tcase(s, t);
    return s;
}
