/* Laws of T_c on Lorenz's equations, whose growth is fast and whose right-hand side is smooth: slopes against
 * known orders, single points against another route, threads, kept runs, points left out. */
#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cns/case.h"
#include "cns/study/laws.h"
#include "cns/study/tc.h"
#include "study/predict/laws_internal.h"
#include "support.h"

#define START "model: lorenz\ninitial: {x: -15.8, y: -17.48, z: 35.64}\n"

typedef struct outcome {
    cns_case *c;
    cns_system *system;
    cns_problem problem;
    cns_laws_result r;
    cns_code code;
    cns_error err;
} outcome;

static void load(outcome *o, const char *yaml)
{
    char *report;
    if (cns_case_parse("test", yaml, strlen(yaml), NULL, 0, &o->c, &report))
        ck_abort_msg("%s", report);
    const cns_case *c = o->c;
    o->system = cns_system_new(c->model, c->parameters, c->initial, c->smooth ? &c->eps : NULL, &o->err);
    if (!o->system)
        ck_abort_msg("%s", o->err.text);
    o->problem = (cns_problem){.system = o->system, .end = &c->end, .every = &c->every};
}

static void go(outcome *o, const char *yaml, int threads, const char *directory)
{
    const cns_monitor monitor = {.threads = threads};
    load(o, yaml);
    o->problem.monitor = &monitor;
    o->code = cns_laws(&o->problem, &o->c->laws, directory, &o->r, &o->err);
}

static void drop(outcome *o)
{
    cns_laws_result_clear(&o->r);
    cns_system_free(o->system);
    cns_case_free(o->c);
}

static const char both[] = START
    "time: {end: 500, every: 1/8}\n"
    "laws: {digits: {from: 8, to: 32, by: 3}, steps: {method: taylor, order: 8, digits: 40, from: 1e-2, to: "
    "3e-3, per_decade: 12}}\n";

static void slope_is(const cns_fit *f, double slope, double tolerance)
{
    ck_assert_msg(fabs(f->slope - slope) <= tolerance && f->slope_se < tolerance, "%g +- %g is not %g",
                  f->slope, f->slope_se, slope);
}

/* A digit is worth a digit of growth, a factor of ten in the step as many as the order says, and the times
 * are as long as the exponent makes them. */
START_TEST(slopes)
{
    outcome o;
    go(&o, both, 2, NULL);
    ck_assert_msg(o.code == CNS_OK, "%s", o.err.text);
    const cns_law *digits = &o.r.law[CNS_LAW_DIGITS], *steps = &o.r.law[CNS_LAW_STEPS];
    ck_assert_int_eq(digits->n, 9);
    ck_assert_int_eq(steps->n, 7);
    ck_assert(digits->fitted && steps->fitted && !o.r.law[CNS_LAW_SMOOTHING].fitted);
    slope_is(&digits->level, 1, 0.06);
    slope_is(&steps->level, 8, 0.5);
    ck_assert_double_eq_tol(o.r.lambda, 0.9056, 0.1); /* Viswanath's exponent */
    ck_assert(fabs(digits->time.slope - log(10) / 0.9056) < 2.5 * digits->time.slope_95);
    ck_assert(o.r.reference_error < -8 && o.r.reference_check < -8);
    for (int i = 1; i < digits->n; i++)
        ck_assert(digits->point[i].tc > digits->point[i - 1].tc);
    drop(&o);
}
END_TEST

/* The same times by two trajectories that walk side by side, the other one chosen by cns_tc_measure(). */
START_TEST(points_by_another_route)
{
    static const char *const texts[] = {
        START "time: {end: 500, every: 1/8}\nlaws: {digits: {from: 12, to: 16, by: 4}}\n",
        START "time: {end: 500, every: 1/8}\nlaws: {observable: y, digits: {from: 12, to: 16, by: 4}}\n",
        START "time: {end: 500, every: 1/8}\n"
              "laws: {observable: y, criterion: rows, digits: {from: 12, to: 16, by: 4}}\n"};
    for (int k = 0; k < 3; k++) {
        outcome o;
        load(&o, texts[k]);
        ck_assert_int_eq(cns_laws(&o.problem, &o.c->laws, NULL, &o.r, &o.err), CNS_OK);
        for (int i = 0; i < 2; i++) {
            const cns_numerics n = {
                .method = CNS_METHOD_TAYLOR, .arithmetic = CNS_ARITH_FAST, .digits = 12 + 4 * i};
            const int until = k == 0 ? CNS_TC_NORM : CNS_TC_STATE(1);
            const cns_tc_spec spec = {
                .numerics = &n, .delta = &o.c->laws.delta, .criterion = o.c->laws.criterion, .until = until};
            cns_tc_result t;
            ck_assert_int_eq(cns_tc_measure(&o.problem, &spec, &t, &o.err), CNS_OK);
            ck_assert_int_eq(t.time[until].kind, CNS_TC_FOUND);
            ck_assert_double_eq_tol(o.r.law[CNS_LAW_DIGITS].point[i].tc, t.time[until].t, 2e-5);
            cns_tc_result_clear(&t);
        }
        drop(&o);
    }
}
END_TEST

static void same(const cns_laws_result *a, const cns_laws_result *b)
{
    for (int k = 0; k < CNS_LAW_KINDS; k++) {
        ck_assert_int_eq(a->law[k].n, b->law[k].n);
        for (int i = 0; i < a->law[k].n; i++) {
            ck_assert_str_eq(a->law[k].point[i].text, b->law[k].point[i].text);
            ck_assert(memcmp(&a->law[k].point[i].tc, &b->law[k].point[i].tc, sizeof(double)) == 0);
        }
        ck_assert(memcmp(&a->law[k].time, &b->law[k].time, sizeof a->law[k].time) == 0 || !a->law[k].fitted);
    }
    ck_assert(a->lambda == b->lambda && a->reference_digits == b->reference_digits);
}

static int count_files(const char *directory, bool removed)
{
    char path[512];
    int n = 0;
    DIR *d = opendir(directory);
    for (struct dirent *e = d ? readdir(d) : NULL; e; e = readdir(d)) {
        if (e->d_name[0] == '.')
            continue;
        n++;
        snprintf(path, sizeof path, "%s/%.200s", directory, e->d_name);
        if (removed)
            unlink(path);
    }
    if (d)
        closedir(d);
    return n;
}

/* The same whatever the threads; what is kept is used, also when a run is lost, and not for another case. */
START_TEST(kept_runs)
{
    static const char few[] =
        START "time: {end: 500, every: 1/4}\nlaws: {digits: {from: 6, to: 12, by: 2}}\n";
    static const char other[] =
        START "time: {end: 500, every: 1/4}\nlaws: {delta: 0.012, digits: {from: 6, to: 12, by: 2}}\n";
    char directory[] = "/tmp/cns-laws-XXXXXX", path[512], lost[512] = "";
    ck_assert_ptr_nonnull(mkdtemp(directory));
    outcome a, b, c, d;
    go(&a, few, 1, NULL);
    go(&b, few, 2, directory);
    ck_assert_msg(a.code == CNS_OK && b.code == CNS_OK, "%s %s", a.err.text, b.err.text);
    same(&a.r, &b.r);
    ck_assert_int_eq(count_files(directory, false), 6);
    DIR *files = opendir(directory); /* one is lost, and one is altered and must not be believed */
    for (struct dirent *e = readdir(files); e; e = readdir(files)) {
        snprintf(path, sizeof path, "%s/%.200s", directory, e->d_name);
        if (strncmp(e->d_name, "digits-8-", 9) == 0)
            unlink(path);
        if (strncmp(e->d_name, "digits-10-", 10) == 0)
            strcpy(lost, path);
    }
    closedir(files);
    FILE *f = fopen(lost, "r+");
    char line[256];
    ck_assert_ptr_nonnull(f);
    ck_assert_ptr_nonnull(fgets(line, sizeof line, f));
    fseek(f, (long)strlen(line), SEEK_SET);
    fputs("tc 7", f);
    fclose(f);
    go(&c, few, 2, directory);
    ck_assert(c.code == CNS_OK);
    same(&a.r, &c.r);
    go(&d, other, 1, directory);
    ck_assert(d.code == CNS_OK);
    for (int i = 0; i < 4; i++)
        ck_assert(d.r.law[0].point[i].tc > a.r.law[0].point[i].tc);
    drop(&a);
    drop(&b);
    drop(&c);
    drop(&d);
    count_files(directory, true);
    ck_assert_int_eq(rmdir(directory), 0);
}
END_TEST

/* Times beyond the end, steps lost in rounding, and what cannot be asked. */
START_TEST(left_out)
{
    outcome o;
    go(&o,
       START "time: {end: 40, every: 1/4}\nlaws: {digits: {from: 8, to: 24, by: 4}, steps: {method: taylor, "
             "order: 10, digits: 20, from: 1e-2, to: 1e-3, per_decade: 2}}\n",
       1, NULL);
    ck_assert_msg(o.code == CNS_OK, "%s", o.err.text);
    const cns_law *digits = &o.r.law[CNS_LAW_DIGITS], *steps = &o.r.law[CNS_LAW_STEPS];
    ck_assert_ptr_null(digits->point[0].left_out);
    ck_assert_ptr_nonnull(strstr(digits->point[4].left_out, "t = 40"));
    ck_assert(isnan(digits->point[4].tc));
    ck_assert_ptr_nonnull(strstr(steps->point[2].left_out, "rounding"));
    ck_assert(!steps->fitted);
    drop(&o);
    go(&o, START "time: {end: 40}\nlaws: {delta: 0.01}\n", 1, NULL);
    ck_assert_int_eq(o.code, CNS_USAGE);
    drop(&o);
    go(&o, START "time: {end: 40}\nlaws: {delta: 1e-20, digits: {from: 8, to: 9}}\n", 1, NULL);
    ck_assert_int_eq(o.code, CNS_USAGE);
    drop(&o);
    go(&o,
       "model: apw\nabs: {smooth: 1e-3}\ninitial: {Vx: 1}\ntime: {end: 40}\nlaws: {smoothing: {from: 1e-2, "
       "to: "
       "1e-3}}\n",
       1, NULL);
    ck_assert_int_eq(o.code, CNS_USAGE);
    drop(&o);
}
END_TEST

/* Smoothing by eps changes a trajectory by the order of eps^2. */
START_TEST(smoothing)
{
    outcome o;
    go(&o,
       "model: apw\ninitial: {theta: 1, Vx: 0.5, Vy: -1, omega: 1}\ntime: {end: 1000, every: 1/4}\n"
       "laws: {smoothing: {from: 1e-2, to: 1e-4, per_decade: 2}}\n",
       2, NULL);
    ck_assert_msg(o.code == CNS_OK, "%s", o.err.text);
    slope_is(&o.r.law[CNS_LAW_SMOOTHING].level, 2, 0.1);
    drop(&o);
}
END_TEST

/* Statistics of growth, and why points are left out, from made-up runs against a made-up reference. */
START_TEST(concluded_by_hand)
{
    enum { ROWS = 161, WINDOWS = 10, SIZE = (ROWS - 1) / WINDOWS, JOBS = 7 };
    static const char *const found[JOBS] = {"tc 10",         "tc 20",          "tc 1",        "tc 30",
                                            "beyond -3.5\n", "failed badly\n", "beyond -20\n"};
    static const char *const why[JOBS] = {
        NULL, NULL, "by its own error", NULL, "no T_c up to t = 80", "failed badly"};
    const double every = 0.5;
    double growth[ROWS] = {0}, error[ROWS] = {0}, sum = 0;
    uint64_t s = test_seed();
    for (int i = 1; i < ROWS; i++)
        growth[i] = growth[i - 1] + 0.2 + 0.1 * (test_random_unit(&s) - 0.5);
    cns_law_job job[JOBS];
    char *results[JOBS];
    for (int i = 0; i < JOBS; i++) {
        job[i] = (cns_law_job){.kind = i < JOBS - 1 ? CNS_LAW_DIGITS : CNS_LAW_CHECK, .text = "5", .x = i};
        results[i] = strdup(found[i]);
    }
    const cns_laws_work work = {.every = every,
                                .delta_log10 = -2,
                                .jobs = JOBS,
                                .job = job,
                                .ref = {.digits = 40, .rows = ROWS, .growth = growth, .error = error}};
    cns_laws_result r = {0};
    cns_error err;
    ck_assert_int_eq(cns_laws_conclude(&work, results, &r, &err), CNS_OK);
    const double time = (ROWS - 1) * every, rate = growth[ROWS - 1] / time;
    for (int w = 0; w < WINDOWS; w++) {
        const double d = growth[(w + 1) * SIZE] - growth[w * SIZE] - rate * SIZE * every;
        sum += d * d / (SIZE * every);
    }
    ck_assert_int_eq(r.windows, WINDOWS);
    ck_assert_double_eq_tol(r.lambda, rate * log(10), 1e-12);
    ck_assert_double_eq_tol(r.variance, sum / (WINDOWS - 1), 1e-12);
    ck_assert_double_eq_tol(r.lambda_se, sqrt(r.variance / time) * log(10), 1e-12);
    ck_assert_double_eq(r.reference_check, -20);
    const cns_law *law = &r.law[CNS_LAW_DIGITS];
    ck_assert_int_eq(law->n, JOBS - 1);
    ck_assert(law->fitted);
    ck_assert_int_eq(law->time.n, 3);
    for (int i = 0; i < law->n; i++)
        if (why[i])
            ck_assert_msg(law->point[i].left_out && strstr(law->point[i].left_out, why[i]), "%d: %s", i,
                          law->point[i].left_out ? law->point[i].left_out : "not left out");
        else
            ck_assert_msg(!law->point[i].left_out && law->point[i].tc == strtod(found[i] + 3, NULL), "%d", i);
    cns_laws_result_clear(&r);

    free(results[JOBS - 1]);
    results[JOBS - 1] = strdup("beyond -4.9\n"); /* half of the digits of trust are not left */
    ck_assert_int_eq(cns_laws_conclude(&work, results, &r, &err), CNS_NUMERIC);
    cns_laws_result_clear(&r);
    for (int i = 0; i < JOBS; i++)
        free(results[i]);
}
END_TEST

Suite *suite_laws(void)
{
    Suite *s = suite_create("laws");
    TCase *t = tcase_create("laws");
    tcase_add_test(t, slopes);
    tcase_add_test(t, points_by_another_route);
    tcase_add_test(t, kept_runs);
    tcase_add_test(t, left_out);
    tcase_add_test(t, smoothing);
    tcase_add_test(t, concluded_by_hand);
    suite_add_tcase(s, t);
    return s;
}
