/* Lines through random walks: exact lines, closed forms, coverage of the 95 % limits, outliers, Student's t.
 */
#include <math.h>
#include <stdlib.h>

#include "study/predict/fit.h"
#include "support.h"

enum { MOST = 64, TRIALS = 4000 };

static double gauss(uint64_t *state)
{
    const double u = 1 - test_random_unit(state), v = test_random_unit(state);
    return sqrt(-2 * log(u)) * cos(6.283185307179586477 * v);
}

static void near(double a, double b, double relative)
{
    ck_assert_msg(fabs(a - b) <= relative * fmax(fabs(a), fabs(b)), "%.17g is not %.17g", a, b);
}

START_TEST(an_exact_line_is_found_exactly)
{
    uint64_t s = test_seed();
    double x[MOST], y[MOST];
    cns_fit f;
    cns_error err;
    const double a = 20 * test_random_unit(&s) - 10, b = 100 * test_random_unit(&s);
    for (int n = 3; n < MOST; n++) {
        for (int i = 0; i < n; i++) {
            x[i] = (i > 0 ? x[i - 1] : 0) + 0.1 + test_random_unit(&s);
            y[i] = a * x[i] + b;
        }
        for (int kind = CNS_SPREAD_WALK; kind <= CNS_SPREAD_GIVEN; kind++) {
            const cns_spread spread = {.kind = (cns_spread_kind)kind, .walk = 1, .dof = 5};
            ck_assert_int_eq(cns_fit_line(x, y, n, &spread, &f, &err), CNS_OK);
            ck_assert_double_eq_tol(f.slope, a, 1e-10);
            ck_assert_double_eq_tol(f.slope_gls, a, 1e-10);
            ck_assert_double_eq_tol(f.slope_robust, a, 1e-10);
            ck_assert_double_eq_tol(f.intercept, b, 1e-9);
            ck_assert(f.r2 > 1 - 1e-12);
            ck_assert(kind == CNS_SPREAD_GIVEN || f.slope_95 < 1e-9);
        }
    }
}
END_TEST

START_TEST(bad_points_are_refused)
{
    const double x[] = {1, 2, 2, 3}, y[] = {1, 2, NAN, 4};
    const cns_spread spread = {.kind = CNS_SPREAD_WALK};
    cns_fit f;
    cns_error err;
    ck_assert_int_eq(cns_fit_line(x, x, 2, &spread, &f, &err), CNS_USAGE);
    ck_assert_int_eq(cns_fit_line(x, x, 4, &spread, &f, &err), CNS_USAGE);
    ck_assert_int_eq(cns_fit_line(x + 1, y, 2, &spread, &f, &err), CNS_USAGE);
    const double z[] = {1, 2, 3, 4};
    ck_assert_int_eq(cns_fit_line(z, y, 4, &spread, &f, &err), CNS_USAGE);
}
END_TEST

/* Under a walk the efficient slope runs from end to end, with variance walk / length; the ordinary one is a
 * weighted sum of increments. */
START_TEST(errors_under_a_walk_are_those_of_its_increments)
{
    uint64_t s = test_seed();
    double x[MOST], y[MOST];
    for (int n = 3; n < MOST; n += 7) {
        double mean = 0, sxx = 0, variance = 0;
        for (int i = 0; i < n; i++) {
            x[i] = (i > 0 ? x[i - 1] : -3) + 0.1 + test_random_unit(&s);
            y[i] = gauss(&s);
            mean += x[i] / n;
        }
        for (int i = 0; i < n; i++)
            sxx += (x[i] - mean) * (x[i] - mean);
        for (int k = 1; k < n; k++) { /* increment k moves all points from k on */
            double weight = 0;
            for (int i = k; i < n; i++)
                weight += (x[i] - mean) / sxx;
            variance += weight * weight * (x[k] - x[k - 1]);
        }
        const cns_spread spread = {.kind = CNS_SPREAD_GIVEN, .walk = 2.5, .dof = 10, .start = -10};
        cns_fit f;
        cns_error err;
        ck_assert_int_eq(cns_fit_line(x, y, n, &spread, &f, &err), CNS_OK);
        near(f.slope_se, sqrt(2.5 * variance), 1e-9);
        near(f.slope_gls, (y[n - 1] - y[0]) / (x[n - 1] - x[0]), 1e-8);
        near(f.slope_gls_se, sqrt(2.5 / (x[n - 1] - x[0])), 1e-8);
    }
}
END_TEST

/* Without a walk everything is the textbook's. */
START_TEST(independent_residuals_give_the_textbook_errors)
{
    const double x[] = {1, 2, 3, 4, 5}, y[] = {1, 2, 1.3, 3.75, 2.25};
    const cns_spread spread = {.kind = CNS_SPREAD_INDEPENDENT};
    cns_fit f;
    cns_error err;
    ck_assert_int_eq(cns_fit_line(x, y, 5, &spread, &f, &err), CNS_OK);
    near(f.slope, 0.425, 1e-12);
    near(f.intercept, 0.785, 1e-12);
    const double s2 = (4.597 - 0.425 * 4.25) / 3; /* syy - slope sxy */
    near(f.residual_sd, sqrt(s2), 1e-12);
    near(f.slope_se, sqrt(s2 / 10), 1e-12);
    near(f.intercept_se, sqrt(s2 * (0.2 + 0.9)), 1e-12);
    near(f.slope_gls, f.slope, 1e-10);
    near(f.slope_gls_se, f.slope_se, 1e-10);
}
END_TEST

static void covers(int inside, const char *what)
{
    const double share = (double)inside / TRIALS;
    ck_assert_msg(share >= 0.93 && share <= 0.97, "the 95 %% limits of %s cover %.4f (CNS_TEST_SEED=%llu)",
                  what, share, (unsigned long long)test_seed());
}

/* Walks with a known slope, from a start before the first point, with and without jitter of the points. */
START_TEST(the_limits_cover)
{
    static const int sizes[] = {6, 10, 28};
    uint64_t s = test_seed();
    double x[MOST], y[MOST];
    for (int k = 0; k < 3; k++) {
        const int n = sizes[k];
        int own = 0, given = 0, intercepts = 0, efficient = 0, textbook = 0;
        for (int trial = 0; trial < TRIALS; trial++) {
            const double walk = 30, jitter = 40, start = -8;
            double w = gauss(&s) * sqrt(walk * (16 - start)), pure[MOST];
            for (int i = 0; i < n; i++) {
                x[i] = 16 + 3 * i;
                if (i > 0)
                    w += gauss(&s) * sqrt(walk * 3);
                pure[i] = 17.7 * x[i] + 96 + w;
                y[i] = pure[i] + gauss(&s) * sqrt(jitter);
            }
            /* Variances known with dof degrees of freedom, as measured ones are. */
            const long dof = 9;
            double chi2 = 0;
            for (long i = 0; i < dof; i++)
                chi2 += pow(gauss(&s), 2) / (double)dof;
            const cns_spread mine = {.kind = CNS_SPREAD_WALK, .start = start},
                             classic = {.kind = CNS_SPREAD_INDEPENDENT},
                             known = {CNS_SPREAD_GIVEN, walk * chi2, jitter * chi2, dof, start};
            cns_fit f;
            cns_error err;
            ck_assert_int_eq(cns_fit_line(x, pure, n, &mine, &f, &err), CNS_OK);
            own += fabs(f.slope - 17.7) <= f.slope_95;
            ck_assert_int_eq(cns_fit_line(x, pure, n, &classic, &f, &err), CNS_OK);
            textbook += fabs(f.slope - 17.7) <= f.slope_95;
            ck_assert_int_eq(cns_fit_line(x, y, n, &known, &f, &err), CNS_OK);
            given += fabs(f.slope - 17.7) <= f.slope_95;
            intercepts += fabs(f.intercept - 96) <= f.intercept_95;
            efficient += fabs(f.slope_gls - 17.7) <= cns_student_limit(0.95, dof) * f.slope_gls_se;
        }
        covers(own, "a slope by the points' own walk");
        covers(given, "a slope by given variances");
        covers(intercepts, "an intercept by given variances");
        covers(efficient, "an efficient slope");
        ck_assert_msg(textbook < TRIALS * 0.85, "the textbook's limits cover %d of %d walks", textbook,
                      TRIALS);
    }
}
END_TEST

START_TEST(outliers_do_not_move_the_robust_slope)
{
    uint64_t s = test_seed();
    double x[20], y[20];
    for (int i = 0; i < 20; i++) {
        x[i] = i;
        y[i] = 3 * i + 1 + 0.01 * gauss(&s);
    }
    for (int i = 0; i < 4; i++)
        y[3 + 5 * (int)test_random_below(&s, 4)] += 1000 * gauss(&s);
    const cns_spread spread = {.kind = CNS_SPREAD_INDEPENDENT};
    cns_fit f;
    cns_error err;
    ck_assert_int_eq(cns_fit_line(x, y, 20, &spread, &f, &err), CNS_OK);
    ck_assert_double_eq_tol(f.slope_robust, 3, 0.02);
}
END_TEST

/* Of an even number of slopes: -1, 0, 1, 7/3, 3, 7. */
START_TEST(the_robust_slope_is_the_median)
{
    const double x[] = {0, 1, 2, 3}, y[] = {0, 1, 0, 7};
    const cns_spread spread = {.kind = CNS_SPREAD_INDEPENDENT};
    cns_fit f;
    cns_error err;
    ck_assert_int_eq(cns_fit_line(x, y, 4, &spread, &f, &err), CNS_OK);
    ck_assert_double_eq_tol(f.slope_robust, (1 + 7.0 / 3) / 2, 1e-14);
}
END_TEST

/* Against the density, by Simpson's rule, and against printed tables. */
START_TEST(student)
{
    static const struct {
        long dof;
        double limit;
    } table[] = {{1, 12.70620474}, {2, 4.30265273},   {3, 3.18244631},      {8, 2.30600414},
                 {30, 2.04227246}, {120, 1.97993041}, {1000000, 1.95996398}};
    for (int i = 0; i < COUNT(table); i++)
        near(cns_student_limit(0.95, table[i].dof), table[i].limit, i < 6 ? 1e-8 : 2e-6);
    uint64_t s = test_seed();
    for (int trial = 0; trial < 50; trial++) {
        const long dof = 1 + (long)test_random_below(&s, 60);
        const double t = 5 * test_random_unit(&s), nu = (double)dof, h = t / 2000;
        double sum = 0;
        for (int i = 0; i <= 2000; i++)
            sum += pow(1 + i * h * i * h / nu, -(nu + 1) / 2) * (i == 0 || i == 2000 ? 1 : i % 2 ? 4 : 2);
        sum *= 2 * h / 3 * exp(lgamma((nu + 1) / 2) - lgamma(nu / 2)) / sqrt(nu * 3.14159265358979323846);
        ck_assert_double_eq_tol(cns_student_within(t, dof), sum, 1e-9);
    }
}
END_TEST

Suite *suite_fit(void)
{
    Suite *s = suite_create("fit");
    TCase *t = tcase_create("fit");
    tcase_add_test(t, an_exact_line_is_found_exactly);
    tcase_add_test(t, bad_points_are_refused);
    tcase_add_test(t, errors_under_a_walk_are_those_of_its_increments);
    tcase_add_test(t, independent_residuals_give_the_textbook_errors);
    tcase_add_test(t, the_limits_cover);
    tcase_add_test(t, outliers_do_not_move_the_robust_slope);
    tcase_add_test(t, the_robust_slope_is_the_median);
    tcase_add_test(t, student);
    suite_add_tcase(s, t);
    return s;
}
