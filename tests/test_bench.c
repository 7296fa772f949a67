/* Measuring speed: what is measured must be what is said; how fast it is, no test can tell. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arith/fast.h"
#include "bench/bench.h"
#include "cns/flow.h"
#include "core/clock.h"
#include "integrate/numerics.h"
#include "problem.h"

static cns_system *problem(cns_bench_system system)
{
    cns_error err;
    cns_system *p = cns_bench_system_new(system, &err);
    ck_assert_msg(p != NULL, "%s", err.text);
    return p;
}

START_TEST(medians)
{
    cns_bench_cell c = {.runs = 3, .seconds = {5, 1, 2}};
    ck_assert_double_eq(cns_bench_median(&c), 2);
    c = (cns_bench_cell){.runs = 4, .seconds = {5, 1, 2, 100}};
    ck_assert_double_eq(cns_bench_median(&c), 3.5);
    c = (cns_bench_cell){.runs = 1, .seconds = {7}};
    ck_assert_double_eq(cns_bench_median(&c), 7);
}
END_TEST

/* A planted difference is told to a tenth of a digit, in dynamic states only. */
START_TEST(agreement)
{
    cns_system *p = problem(CNS_BENCH_APW);
    const int n = cns_program_states(cns_system_program(p));
    mpfr_t *x = cns_vector_xnew(n, 200), *y = cns_vector_xnew(n, 200);
    for (int i = 0; i < n; i++) {
        mpfr_set_d(x[i], 0.3 * i - 1, MPFR_RNDN);
        mpfr_set(y[i], x[i], MPFR_RNDN);
    }
    ck_assert_double_eq(cns_bench_agreed(p, (const mpfr_t *)x, (const mpfr_t *)y), HUGE_VAL);
    mpfr_add_d(y[0], y[0], 1, MPFR_RNDN); /* x: nothing feeds back on it */
    ck_assert_double_eq(cns_bench_agreed(p, (const mpfr_t *)x, (const mpfr_t *)y), HUGE_VAL);
    mpfr_add_d(y[n - 1], y[n - 1], 1e-31, MPFR_RNDN);
    ck_assert_double_eq_tol(cns_bench_agreed(p, (const mpfr_t *)x, (const mpfr_t *)y), 31, 0.1);
    mpfr_sub_d(y[n - 2], y[n - 2], 1e-12, MPFR_RNDN);
    ck_assert_double_eq_tol(cns_bench_agreed(p, (const mpfr_t *)x, (const mpfr_t *)y), 12, 0.1);
    cns_vector_free(x);
    cns_vector_free(y);
    cns_system_free(p);
}
END_TEST

/* Every engine reaches the accuracy of its digits, kernels the same bits, and the process keeps its kernel.
 */
START_TEST(engines)
{
    enum { DIGITS = 30 };
    cns_error err;
    ck_assert_int_eq(cns_fast_choose_kernel("portable", &err), CNS_OK);
    for (int s = 0; s < CNS_BENCH_SYSTEMS; s++) {
        cns_system *p = problem((cns_bench_system)s);
        cns_bench_run runs[CNS_BENCH_ENGINES] = {{0}}, truth = {0};
        ck_assert_int_eq(cns_bench_reference(p, DIGITS, 0.7, NULL, &truth, &err), CNS_OK);
        for (int e = 0; e < CNS_BENCH_ENGINES; e++) {
            const cns_bench_job job = {.engine = (cns_bench_engine)e, .digits = DIGITS, .until = 0.7};
            if (!cns_bench_has(job.engine)) {
                ck_assert_int_eq(cns_bench_measure(p, &job, &runs[e], &err), CNS_USAGE);
                continue;
            }
            ck_assert_int_eq(cns_bench_measure(p, &job, &runs[e], &err), CNS_OK);
            ck_assert_double_ge(cns_bench_agreed(p, (const mpfr_t *)runs[e].end, (const mpfr_t *)truth.end),
                                DIGITS - 1);
            ck_assert_int_eq(
                runs[e].order,
                cns_order_for(-DIGITS * log2(10), e == CNS_BENCH_MPFR ? CNS_ARITH_MPFR : CNS_ARITH_FAST));
            double sum = 0;
            for (int i = 0; i < runs[e].taken; i++)
                sum += runs[e].each[i];
            ck_assert_double_eq_tol(sum / runs[e].covered, runs[e].seconds, 1e-9 * runs[e].seconds);
            ck_assert_double_eq_tol(runs[e].steps * runs[e].covered, runs[e].taken, 1e-9);
            ck_assert_double_ge(runs[e].covered, 0.3);
            ck_assert_str_eq(cns_fast_kernel_name(), "portable");
        }
        const cns_bench_run *a = &runs[CNS_BENCH_PORTABLE], *b = &runs[CNS_BENCH_IFMA];
        for (int i = 0; i < a->n && b->n; i++)
            ck_assert(mpfr_equal_p(a->end[i], b->end[i]));
        for (int e = 0; e < CNS_BENCH_ENGINES; e++)
            cns_bench_run_clear(&runs[e]);
        cns_bench_run_clear(&truth);
        cns_system_free(p);
    }
}
END_TEST

static double by_the_look(cns_clock clock)
{
    (void)clock;
    static double now;
    return now += 0.001;
}

/* By a clock that gains a millisecond whenever it is read, a step takes one. The first row is measured in any
 * case, the second only where there is time for it; with a stop, nothing. */
START_TEST(budget)
{
    cns_error err;
    cns_bench_row rows[] = {{.system = CNS_BENCH_LORENZ, .digits = 20, .until = 0.1},
                            {.system = CNS_BENCH_LORENZ, .digits = 200, .until = 0.1}};
    static const double seconds[] = {1e-9, 0.5, 1e9};
    cns_bench_spec spec = {.runs = 2};
    cns_clock_replace(by_the_look);
    for (int i = 0; i < 3; i++) {
        spec.seconds = seconds[i];
        ck_assert_int_eq(cns_bench_fill(&spec, rows, 2, &err), CNS_OK);
        for (int e = 0; e < CNS_BENCH_ENGINES; e++) {
            const bool has = cns_bench_has((cns_bench_engine)e);
            ck_assert_int_eq(rows[0].cells[e].runs, !has ? 0 : i == 0 ? 1 : 2);
            ck_assert_int_eq(rows[1].cells[e].runs, has && i == 2 ? 2 : 0);
            for (int k = 0; k < rows[0].cells[e].runs; k++) /* steps per unit of time, a millisecond each */
                ck_assert_double_eq_tol(rows[0].cells[e].seconds[k], 0.001 * rows[0].cells[e].steps, 1e-9);
        }
    }
    cns_clock_replace(NULL);
    static volatile sig_atomic_t stop = 1;
    const cns_monitor stopped = {.stop = &stop};
    spec.monitor = &stopped;
    ck_assert_int_eq(cns_bench_fill(&spec, rows, 1, &err), CNS_STOPPED);
}
END_TEST

Suite *suite_bench(void)
{
    Suite *s = suite_create("bench");
    TCase *tc = tcase_create("bench");
    tcase_add_test(tc, medians);
    tcase_add_test(tc, agreement);
    tcase_add_test(tc, engines);
    tcase_add_test(tc, budget);
    suite_add_tcase(s, tc);
    return s;
}
