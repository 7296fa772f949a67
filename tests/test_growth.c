/* Growth of errors along x' = y, y' = x, whose propagator is known: cosh t on the diagonal, sinh t beside it.
 */
#include <math.h>

#include "integrate/growth.h"
#include "problem.h"

static const double scales[] = {1, 8};

/* The propagator's largest singular value and Frobenius norm, in scales: its determinant is 1. */
static double frobenius(double t)
{
    const double ratio = scales[1] / scales[0];
    return sqrt(2 * cosh(t) * cosh(t) + sinh(t) * sinh(t) * (ratio * ratio + 1 / (ratio * ratio)));
}

static double log10_largest(double t)
{
    if (t > 150) /* where squares of squares of cosh leave the range of double, all grows like exp(t) */
        return log10_largest(150) + (t - 150) / log(10);
    const double f = frobenius(t) * frobenius(t);
    return log10(sqrt(0.5 * (f + sqrt(fmax(0, f * f - 4)))));
}

typedef struct followed {
    cns_program *p;
    cns_flow *f;
    cns_growth *g;
} followed;

static followed begin(void)
{
    static const char *const start[] = {"1", "-1"};
    cns_error err;
    followed w = {.p = program_new(2, NULL)};
    cns_derivative(w.p, 0, cns_state(w.p, 1));
    cns_derivative(w.p, 1, cns_state(w.p, 0));
    finished(w.p);
    cns_flow_spec spec = taylor_spec(w.p, 20);
    w.f = flow_started(&spec, start);
    w.g = cns_growth_new(w.p, scales, &err);
    ck_assert_ptr_nonnull(w.g);
    cns_growth_start(w.g);
    return w;
}

static void end(followed *w)
{
    cns_growth_free(w->g);
    cns_flow_free(w->f);
    cns_program_free(w->p);
}

/* One step, with so much noise; the time of its beginning. */
static double step(followed *w, double noise_log2)
{
    cns_error err;
    check_ok(cns_flow_step(w->f, &err), &err);
    check_ok(cns_growth_follow(w->g, w->f, noise_log2, &err), &err);
    return mpfr_get_d(cns_flow_begin(w->f), MPFR_RNDN);
}

static void at(followed *w, double t, double *growth, double *error_log2)
{
    cns_error err;
    mpq_t time;
    mpq_init(time);
    mpq_set_d(time, t);
    while (mpfr_cmp_d(cns_flow_end(w->f), t) < 0)
        step(w, -HUGE_VAL);
    check_ok(cns_growth_at(w->g, time, growth, error_log2, &err), &err);
    mpq_clear(time);
}

START_TEST(is_that_of_the_propagator)
{
    static const double times[] = {0, 0.001, 0.5, 1, 7, 100, 600};
    followed w = begin();
    step(&w, -HUGE_VAL);
    for (int i = 0; i < COUNT(times); i++) {
        double growth, error;
        at(&w, times[i], &growth, &error);
        ck_assert_double_eq_tol(growth, log10_largest(times[i]), 1e-5 * (1 + growth));
        ck_assert_double_eq(error, -HUGE_VAL);
    }
    end(&w);
}
END_TEST

/* From any time on, and at any time. */
START_TEST(since_an_origin)
{
    followed w = begin();
    double origin[3];
    cns_error err;
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 4; k++)
            origin[i] = step(&w, -HUGE_VAL);
        check_ok(cns_growth_mark(w.g, &err), &err);
    }
    ck_assert_int_eq(cns_growth_marks(w.g), 3);
    for (int more = 0; more < 3; more++) {
        double growth, error, t = ceil(mpfr_get_d(cns_flow_end(w.f), MPFR_RNDN)) + 0.25;
        at(&w, t, &growth, &error);
        for (int i = 0; i < 3; i++) { /* the base of the tangents there, at or before the step's beginning */
            const double from = cns_growth_origin(w.g, i);
            ck_assert(from <= origin[i] && from > (i > 0 ? origin[i - 1] : 0) - 1e-12);
            ck_assert_double_eq_tol(cns_growth_since(w.g, i), log10(frobenius(t - from)), 1e-6);
        }
    }
    end(&w);
}
END_TEST

/* Noise of one step, 2^q in each direction. It is added where the tangents are next expanded anew, which is
 * within a few units of time, and grows from there on. */
static void check_error(followed *w, double t, double q, double made)
{
    double growth, error;
    at(w, t, &growth, &error);
    const double least = q + log2(frobenius(t - made - 4)), most = q + log2(frobenius(t - made));
    ck_assert_msg(error > least && error < most, "2^%.2f, not 2^%.2f to 2^%.2f", error, least, most);
}

START_TEST(noise_grows_from_where_it_is_made)
{
    followed w = begin();
    double made = 0;
    for (int k = 0; k < 20; k++)
        made = step(&w, k == 0 ? -100 : k == 19 ? -200 : -HUGE_VAL);
    check_error(&w, ceil(made) + 20, -100, 0);
    end(&w);
}
END_TEST

/* Where precision falls, noise of late steps can be larger by any factor than what early noise has grown to.
 */
START_TEST(new_noise_can_dwarf_the_old)
{
    followed w = begin();
    double made = 0;
    for (int k = 0; k < 20; k++)
        made = step(&w, k == 0 ? -5000 : k == 19 ? -3 : -HUGE_VAL);
    check_error(&w, ceil(made) + 20, -3, made);
    end(&w);
    w = begin();
    for (int k = 0; k < 20; k++)
        made = step(&w, k == 0 ? -3 : k == 19 ? -5000 : -HUGE_VAL);
    check_error(&w, ceil(made) + 20, -3, 0);
    end(&w);
}
END_TEST

Suite *suite_growth(void)
{
    Suite *s = suite_create("growth");
    TCase *t = tcase_create("growth");
    tcase_add_test(t, is_that_of_the_propagator);
    tcase_add_test(t, since_an_origin);
    tcase_add_test(t, noise_grows_from_where_it_is_made);
    tcase_add_test(t, new_noise_can_dwarf_the_old);
    suite_add_tcase(s, t);
    return s;
}
