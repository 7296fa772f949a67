/* Goals, proofs and numerics: whole tables against reference trajectories and closed forms, honest shortage,
 * and planted faults that the proof must find. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cns/case.h"
#include "cns/model.h"
#include "cns/solve.h"
#include "core/clock.h"
#include "num/decimal_text.h"
#include "problem.h"
#include "taylor/program_internal.h"

enum { MAX_ROWS = 200, MAX_COLUMNS = 8, MAX_STATES = 6 };

/* All that a run reports. */
typedef struct table {
    cns_case *c;
    cns_result result;
    cns_error err;
    cns_code code;
    int attempts, rows;
    char *text[MAX_ROWS][MAX_COLUMNS];
    long decimals[MAX_ROWS];
    double growth[MAX_ROWS];
} table;

static cns_code on_begin(void *context, const cns_run_info *run, cns_error *err)
{
    table *t = context;
    (void)err;
    t->attempts++;
    ck_assert_int_eq(run->attempt, t->attempts);
    return CNS_OK;
}

static double now; /* the clock of the tests that replace it: a row takes a second */

static cns_code on_row(void *context, const cns_row *row, cns_error *err)
{
    table *t = context;
    if (t->rows == MAX_ROWS)
        return cns_fail(err, CNS_IO, "too many rows for this test");
    for (int i = 0; i < t->c->n_columns; i++) {
        t->text[t->rows][i] = strdup(row->text[i]);
        ck_assert_ptr_nonnull(t->text[t->rows][i]);
    }
    t->decimals[t->rows] = row->decimals;
    t->growth[t->rows] = row->growth;
    t->rows++;
    now += 1;
    return CNS_OK;
}

static void solve(table *t, const char *yaml, bool prove, void (*spoil)(cns_program *p))
{
    char *report;
    memset(t, 0, sizeof *t);
    if (cns_case_parse("test", yaml, strlen(yaml), NULL, 0, &t->c, &report))
        ck_abort_msg("%s", report);
    const cns_case *c = t->c;
    ck_assert_int_le(c->n_columns, MAX_COLUMNS);
    cns_system *system =
        cns_system_new(c->model, c->parameters, c->initial, c->smooth ? &c->eps : NULL, &t->err);
    if (!system)
        ck_abort_msg("%s", t->err.text);
    if (spoil) /* what nobody else may do */
        spoil((cns_program *)(size_t)cns_system_program(system));
    cns_sink sink = {.context = t, .begin = on_begin, .row = on_row};
    cns_problem problem = {.system = system,
                           .end = &c->end,
                           .every = &c->every,
                           .columns = c->columns,
                           .n_columns = c->n_columns,
                           .sink = &sink};
    t->code = c->has_goal ? cns_solve_goal(&problem, &c->goal, &t->result, &t->err)
                          : cns_solve_numerics(&problem, &c->numerics, prove, &t->result, &t->err);
    cns_system_free(system);
}

static void table_clear(table *t)
{
    for (int i = 0; i < t->rows; i++)
        for (int j = 0; j < t->c->n_columns; j++)
            free(t->text[i][j]);
    cns_case_free(t->c);
}

static void check_done(const table *t)
{
    check_ok(t->code, &t->err);
    ck_assert(t->result.complete);
    ck_assert_int_eq(t->result.rows, t->rows);
}

/* Columns t, then all states: each text of row r is the reference rounded to so many places. */
static void check_row(const table *t, int r, const char *file, cns_places places, long count)
{
    char *text = reference_text(file, t->text[r][0]), *want = text;
    int n = t->c->model->n_states;
    for (int i = 0; i < n; i++) {
        cns_number x;
        cns_number_init(&x);
        char *next = want + strcspn(want, ",\n");
        *next = '\0';
        ck_assert_int_eq(cns_number_parse(&x, want, NULL), CNS_OK);
        want = next + 1;
        char *rounded = cns_text_mpq(x.ratio, places, count);
        ck_assert_msg(!strcmp(rounded, t->text[r][i + 1]), "%s, t = %s, column %d: %s, not %s", file,
                      t->text[r][0], i + 1, t->text[r][i + 1], rounded);
        free(rounded);
        cns_number_clear(&x);
    }
    free(text);
}

#define CASE4 "model: apw\ninitial: {theta: 1, Vy: 0.01, omega: 1}\n"

/* Every decimal printed is right: against trajectories computed by other code. */

static const struct {
    const char *file, *yaml;
    int rows;
    long count;
} references[] = {
    {"case4.csv", CASE4 "time: {end: 22, every: 2}\ngoal: {decimals: 40}\n", 12, 40},
    {"case4.csv", CASE4 "time: {end: 10, every: 0.5}\ngoal: {decimals: 10}\n", 21, 10},
    {"case4.csv", CASE4 "time: {end: 3, every: 0.5}\ngoal: {decimals: 1}\n", 7, 1},
    {"case2.csv",
     "model: apw\ninitial: {theta: 1, Vy: 0.01}\ntime: {end: 15, every: 5}\ngoal: {decimals: 30}\n", 4, 30},
    {"case3.csv",
     "model: apw\ninitial: {omega: 1, Vy: 0.01}\ntime: {end: 15, every: 5}\ngoal: {decimals: 30}\n", 4, 30},
    {"case1-swapped.csv",
     "model: apw\ninitial: {Vx: 0.01}\ntime: {end: 15, every: 5}\ngoal: {decimals: 30}\n", 4, 30},
    {"flutter.csv",
     "model: apw\nparameters: {I: 1.1}\ninitial: {theta: 1, Vy: 0.01, omega: 1}\n"
     "time: {end: 15, every: 5}\ngoal: {decimals: 25}\n",
     4, 25},
    {"tumble.csv",
     "model: apw\nparameters: {I: 1.4}\ninitial: {theta: 1, Vy: 0.01, omega: 1}\n"
     "time: {end: 15, every: 5}\ngoal: {decimals: 25}\n",
     4, 25},
    {"rest.csv", "model: apw\ninitial: {theta: 1}\ntime: {end: 5, every: 1}\ngoal: {decimals: 40}\n", 6, 40},
    {"case4-smooth-1e-10.csv",
     CASE4 "abs: {smooth: 1e-10}\ntime: {end: 10, every: 5}\ngoal: {decimals: 20}\n", 3, 20},
    {"lorenz.csv",
     "model: lorenz\ninitial: {x: -15.8, y: -17.48, z: 35.64}\ntime: {end: 20, every: 5}\ngoal: {decimals: "
     "58}\n",
     5, 58},
};

START_TEST(rows_are_the_reference_rounded)
{
    table t;
    solve(&t, references[_i].yaml, false, NULL);
    check_done(&t);
    ck_assert_int_eq(t.rows, references[_i].rows);
    ck_assert_int_eq(t.result.decimals, references[_i].count);
    for (int r = 0; r < t.rows; r++) {
        ck_assert_int_eq(t.decimals[r], references[_i].count);
        check_row(&t, r, references[_i].file, CNS_PLACES_DECIMALS, references[_i].count);
    }
    table_clear(&t);
}
END_TEST

/* Hristov et al., arXiv 2101.06682: the state at t = 100, 60 significant digits. */
START_TEST(lorenz_at_100)
{
    table t;
    solve(&t,
          "model: lorenz\ninitial: {x: -15.8, y: -17.48, z: 35.64}\ntime: {end: 100, every: 100}\n"
          "goal: {decimals: 12}\n",
          false, NULL);
    check_done(&t);
    ck_assert_int_eq(t.rows, 2);
    ck_assert_str_eq(t.text[1][1], "-10.510118721506");
    ck_assert_str_eq(t.text[1][2], "-12.172542813682");
    ck_assert_str_eq(t.text[1][3], "27.476265630375");
    ck_assert(t.growth[1] > 35 && t.growth[1] < 45);
    table_clear(&t);
}
END_TEST

/* Case 1 as printed: for t > t0 = W (I+1) atan(Vy0/W), with W^2 = pi/(A+B),
 * Vy = -W tanh((t - t0)/k), y = -W^2 (I+1) (ln cos(atan(Vy0/W)) + ln cosh((t - t0)/k)), k = W (I+1). */
START_TEST(case_1_is_its_closed_form)
{
    table t;
    mpfr_t w, k, a, u, v, y;
    solve(&t, "model: apw\ninitial: {Vy: 0.01}\ntime: {end: 50, every: 12.5}\ngoal: {decimals: 50}\n", false,
          NULL);
    check_done(&t);
    ck_assert_int_eq(t.rows, 5);
    ck_assert_int_eq(t.result.decimals, 50);
    ck_assert_int_eq(t.result.landings, 1);
    mpfr_inits2(400, w, k, a, u, v, y, (mpfr_ptr)0);
    mpfr_const_pi(w, MPFR_RNDN);
    mpfr_mul_ui(w, w, 10, MPFR_RNDN);
    mpfr_div_ui(w, w, 24, MPFR_RNDN); /* A + B = 2.4 */
    mpfr_sqrt(w, w, MPFR_RNDN);
    mpfr_mul_ui(k, w, 32, MPFR_RNDN);
    mpfr_div_ui(k, k, 10, MPFR_RNDN); /* I + 1 = 3.2 */
    mpfr_set_ui(a, 1, MPFR_RNDN);
    mpfr_div_ui(a, a, 100, MPFR_RNDN);
    mpfr_div(a, a, w, MPFR_RNDN);
    mpfr_atan(a, a, MPFR_RNDN);
    for (int r = 1; r < t.rows; r++) {
        mpfr_set_d(u, 12.5 * r, MPFR_RNDN);
        mpfr_div(u, u, k, MPFR_RNDN);
        mpfr_sub(u, u, a, MPFR_RNDN); /* (t - t0)/k */
        mpfr_tanh(v, u, MPFR_RNDN);
        mpfr_mul(v, v, w, MPFR_RNDN);
        mpfr_neg(v, v, MPFR_RNDN);
        mpfr_cosh(y, u, MPFR_RNDN);
        mpfr_cos(u, a, MPFR_RNDN);
        mpfr_mul(y, y, u, MPFR_RNDN);
        mpfr_log(y, y, MPFR_RNDN);
        mpfr_mul(y, y, w, MPFR_RNDN);
        mpfr_mul(y, y, k, MPFR_RNDN);
        mpfr_neg(y, y, MPFR_RNDN);
        char *vy = cns_text_mpfr(v, CNS_PLACES_DECIMALS, 50), *yy = cns_text_mpfr(y, CNS_PLACES_DECIMALS, 50);
        ck_assert_str_eq(t.text[r][5], vy);
        ck_assert_str_eq(t.text[r][2], yy);
        free(vy);
        free(yy);
        static const int zeros[] = {1, 3, 4, 6};
        for (int i = 0; i < 4; i++)
            ck_assert_uint_eq(strspn(t.text[r][zeros[i]], "0."), strlen(t.text[r][zeros[i]]));
    }
    mpfr_clears(w, k, a, u, v, y, (mpfr_ptr)0);
    table_clear(&t);
}
END_TEST

/* The speed comes close to zero, and the series of its root has singularities that near the real axis; the
 * states feel them less than the tolerance of a run with few digits. */
static const char *const near_misses[] = {
    "model: apw\nparameters: {I: 1.4}\ninitial: {theta: pi, Vx: -1e-4, Vy: -0.5}\ntime: {end: 2, every: 1}\n",
    "model: apw\nparameters: {I: 3}\ninitial: {theta: -1e-4, Vy: -1e-4, omega: 1.4}\ntime: {end: 2, every: "
    "1}\n",
    "model: apw\ninitial: {Vx: 1e-9, Vy: -1e-4, theta: 0.344, omega: pi/2}\ntime: {end: 2, every: 1}\n",
    "model: apw\nparameters: {I: 1.4}\ninitial: {Vy: 1e-9, omega: -0.5}\ntime: {end: 2, every: 1}\n",
};

START_TEST(near_misses_of_the_singularity)
{
    table few, many;
    char yaml[512];
    snprintf(yaml, sizeof yaml, "%sgoal: {decimals: 3}\n", near_misses[_i]);
    solve(&few, yaml, false, NULL);
    check_done(&few);
    snprintf(yaml, sizeof yaml, "%sgoal: {decimals: 25}\n", near_misses[_i]);
    solve(&many, yaml, false, NULL);
    check_done(&many);
    for (int r = 1; r < few.rows; r++)
        for (int i = 1; i <= MAX_STATES; i++) {
            cns_number x;
            cns_number_init(&x);
            ck_assert_int_eq(cns_number_parse(&x, many.text[r][i], NULL), CNS_OK);
            char *rounded = cns_text_mpq(x.ratio, CNS_PLACES_DECIMALS, 3);
            ck_assert_str_eq(few.text[r][i], rounded);
            free(rounded);
            cns_number_clear(&x);
        }
    table_clear(&few);
    table_clear(&many);
}
END_TEST

START_TEST(derived_quantities_at_rest)
{
    table t;
    solve(&t,
          "model: apw\ninitial: {theta: 1}\ntime: {end: 1, every: 1}\ngoal: {decimals: 8}\n"
          "output: {columns: [t, Gamma, Fx, Fy, tau, speed, vx_lab]}\n",
          false, NULL);
    check_done(&t);
    ck_assert_int_eq(t.rows, 2);
    for (int i = 1; i < t.c->n_columns; i++)
        ck_assert_str_eq(t.text[0][i], "0.00000000"); /* 0/0 in their formulas */
    table_clear(&t);
}
END_TEST

/* Rows. */

START_TEST(rows_do_not_depend_on_every)
{
    table a, b;
    solve(&a, CASE4 "time: {end: 6, every: 0.5}\ngoal: {decimals: 15}\n", false, NULL);
    solve(&b, CASE4 "time: {end: 6, every: 2}\ngoal: {decimals: 15}\n", false, NULL);
    check_done(&a);
    check_done(&b);
    ck_assert_int_eq(a.rows, 13);
    ck_assert_int_eq(b.rows, 4);
    for (int r = 0; r < b.rows; r++)
        for (int i = 0; i <= MAX_STATES; i++)
            ck_assert_str_eq(a.text[4 * r][i], b.text[r][i]);
    table_clear(&a);
    table_clear(&b);
}
END_TEST

START_TEST(steps_do_not_depend_on_every)
{
    table a, b;
    solve(&a, CASE4 "time: {end: 6, every: 1/7}\nnumerics: {arithmetic: mpfr, digits: 30}\n", false, NULL);
    solve(&b, CASE4 "time: {end: 6, every: 2}\nnumerics: {arithmetic: mpfr, digits: 30}\n", false, NULL);
    check_done(&a);
    check_done(&b);
    ck_assert_int_eq(a.rows, 43);
    ck_assert_int_eq(a.result.steps, b.result.steps);
    ck_assert_int_eq(a.result.landings, b.result.landings);
    for (int r = 0; r < b.rows; r++)
        for (int i = 1; i <= MAX_STATES; i++)
            ck_assert_str_eq(a.text[14 * r][i], b.text[r][i]); /* all digits of the arithmetic */
    table_clear(&a);
    table_clear(&b);
}
END_TEST

START_TEST(the_end_is_a_row_once)
{
    static const struct {
        const char *time;
        int rows;
        const char *last;
    } rows[] = {{"{end: 1, every: 0.25}", 5, "1"},
                {"{end: 1, every: 0.3}", 5, "1"},
                {"{end: 1, every: 5}", 2, "1"},
                {"{end: 1, every: 1/3}", 4, "1"},
                {"{end: 2/3, every: 1/3}", 3, "0.66666666666666667"}};
    for (int i = 0; i < COUNT(rows); i++) {
        table t;
        char yaml[256];
        snprintf(yaml, sizeof yaml, CASE4 "time: %s\ngoal: {decimals: 3}\n", rows[i].time);
        solve(&t, yaml, false, NULL);
        check_done(&t);
        ck_assert_int_eq(t.rows, rows[i].rows);
        ck_assert_str_eq(t.text[t.rows - 1][0], rows[i].last);
        table_clear(&t);
    }
}
END_TEST

/* What is known exactly at t = 0 prints although it is a tie. */
START_TEST(ties_at_the_start)
{
    table t;
    solve(&t,
          "model: apw\ninitial: {x: 0.015, y: 0.025, theta: -0.001, Vy: 0.5}\n"
          "time: {end: 0.5, every: 0.5}\ngoal: {decimals: 2}\n",
          false, NULL);
    check_done(&t);
    ck_assert_int_eq(t.attempts, 1);
    ck_assert_int_eq(t.decimals[0], 2);
    ck_assert_str_eq(t.text[0][1], "0.02");
    ck_assert_str_eq(t.text[0][2], "0.02");
    ck_assert_str_eq(t.text[0][3], "0.00");
    table_clear(&t);
}
END_TEST

START_TEST(a_goal_is_reached_at_the_first_attempt)
{
    table t;
    solve(&t, CASE4 "time: {end: 8, every: 1}\ngoal: {decimals: 20}\n", false, NULL);
    check_done(&t);
    ck_assert_int_eq(t.attempts, 1);
    ck_assert_int_eq(t.result.run.attempt, 1);
    ck_assert(t.result.run.planned);
    ck_assert_int_gt(t.result.run.prec, t.result.run.proof_prec + 64); /* another number of limbs */
    ck_assert_int_ne(t.result.run.order, t.result.run.proof_order);
    table_clear(&t);
}
END_TEST

START_TEST(significant_digits)
{
    table t;
    solve(&t, CASE4 "time: {end: 4, every: 1}\ngoal: {significant: 12}\n", false, NULL);
    check_done(&t);
    ck_assert_int_eq(t.rows, 5);
    for (int r = 0; r < t.rows; r++)
        check_row(&t, r, "case4.csv", CNS_PLACES_SIGNIFICANT, 12);
    table_clear(&t);
}
END_TEST

/* Shortage. */

START_TEST(too_few_digits_are_honest)
{
    table t;
    solve(&t, CASE4 "time: {end: 10, every: 1}\ngoal: {decimals: 30, max_digits: 40, proof: two-runs}\n",
          false, NULL);
    ck_assert_int_eq(t.code, CNS_UNREACHED);
    ck_assert_int_le(t.result.run.digits, 40);
    ck_assert_int_eq(t.rows, 11);
    ck_assert_int_lt(t.result.decimals, 30);
    for (int r = 0; r < t.rows; r++) {
        ck_assert_int_ge(t.decimals[r], 1);
        ck_assert_int_le(t.decimals[r], 30);
        check_row(&t, r, "case4.csv", CNS_PLACES_DECIMALS, t.decimals[r]);
    }
    table_clear(&t);
}
END_TEST

START_TEST(too_few_digits_for_significant_ones)
{
    table t;
    solve(&t, CASE4 "time: {end: 4, every: 1}\ngoal: {significant: 30, max_digits: 40, proof: two-runs}\n",
          false, NULL);
    ck_assert_int_eq(t.code, CNS_UNREACHED);
    ck_assert_int_eq(t.rows, 5);
    for (int r = 1; r < t.rows; r++) {
        long count = (long)(strcspn(t.text[r][3], "e") - (t.text[r][3][0] == '-')) - 1;
        ck_assert(count >= 1 && count < 30);
        check_row(&t, r, "case4.csv", CNS_PLACES_SIGNIFICANT, count);
    }
    table_clear(&t);
}
END_TEST

static double by_the_row(cns_clock clock)
{
    (void)clock;
    return now;
}

static double by_the_look(cns_clock clock)
{
    (void)clock;
    return now += 1;
}

/* Twenty rows fit into the time, and those that the last step holds besides. */
START_TEST(max_time_ends_a_run)
{
    table t;
    cns_clock_replace(by_the_row);
    solve(&t, CASE4 "time: {end: 60, every: 0.5}\ngoal: {decimals: 40, max_time: 19.5}\n", false, NULL);
    cns_clock_replace(NULL);
    ck_assert_int_eq(t.code, CNS_UNREACHED);
    ck_assert(!t.result.complete);
    ck_assert_ptr_nonnull(strstr(t.err.text, " s is used up at t = "));
    ck_assert_int_ge(t.rows, 20);
    ck_assert_int_lt(t.rows, 30);
    ck_assert_double_eq(t.result.wall_s, t.rows);
    for (int r = 0; r < t.rows; r++)
        check_row(&t, r, "case4.csv", CNS_PLACES_DECIMALS, 40);
    table_clear(&t);
}
END_TEST

START_TEST(max_time_ends_a_plan)
{
    table t;
    cns_clock_replace(by_the_look);
    solve(&t, CASE4 "time: {end: 60, every: 0.5}\ngoal: {decimals: 40, max_time: 20}\n", false, NULL);
    cns_clock_replace(NULL);
    ck_assert_int_eq(t.code, CNS_UNREACHED);
    ck_assert_ptr_nonnull(strstr(t.err.text, " s is used up while planning"));
    ck_assert_int_eq(t.rows, 0);
    table_clear(&t);
}
END_TEST

/* Numerics by hand. */

static void check_near(const table *t, int r, const char *file, double tolerance)
{
    mpfr_t *x = cns_vector_xnew(MAX_STATES, 200);
    reference_row(file, t->text[r][0], x, t->c->model->n_states);
    for (int i = 0; i < t->c->model->n_states; i++) {
        double d;
        mpfr_t got;
        mpfr_init2(got, 200);
        mpfr_set_str(got, t->text[r][i + 1], 10, MPFR_RNDN);
        mpfr_sub(got, got, x[i], MPFR_RNDN);
        d = fabs(mpfr_get_d(got, MPFR_RNDN));
        mpfr_clear(got);
        ck_assert_msg(d < tolerance, "t = %s, column %d: %s is off by %g", t->text[r][0], i + 1,
                      t->text[r][i + 1], d);
    }
    cns_vector_free(x);
}

static const struct {
    const char *numerics;
    double tolerance; /* of the run itself */
    long decimals;    /* at least so many are proven */
} numerics[] = {
    {"{arithmetic: mpfr, digits: 30}", 1e-28, 25},
    {"{arithmetic: mpfr, digits: 40, order: 30}", 1e-37, 33},
    {"{arithmetic: mpfr, digits: 25, step: 1/64, order: 12}", 1e-9, 5},
    {"{arithmetic: mpfr, digits: 40, tolerance: 1e-15}", 1e-12, 9},
    {"{arithmetic: double, order: 20}", 1e-12, 9},
    {"{method: rk4, arithmetic: double, step: 1/256}", 1e-7, 5},
    {"{method: rk4, arithmetic: mpfr, digits: 20, step: 1/128}", 1e-6, 5},
};

START_TEST(numerics_without_a_proof)
{
    table t;
    char yaml[512];
    snprintf(yaml, sizeof yaml, CASE4 "time: {end: 4, every: 2}\nnumerics: %s\n", numerics[_i].numerics);
    solve(&t, yaml, false, NULL);
    check_done(&t);
    ck_assert_int_eq(t.rows, 3);
    ck_assert_int_eq(t.result.decimals, -1);
    ck_assert_int_eq(t.result.run.proof_prec, 0);
    for (int r = 0; r < t.rows; r++) {
        ck_assert_int_eq(t.decimals[r], -1);
        check_near(&t, r, "case4.csv", numerics[_i].tolerance);
    }
    table_clear(&t);
}
END_TEST

START_TEST(numerics_with_a_proof)
{
    table t;
    char yaml[512];
    snprintf(yaml, sizeof yaml, CASE4 "time: {end: 4, every: 2}\nnumerics: %s\n", numerics[_i].numerics);
    solve(&t, yaml, true, NULL);
    check_done(&t);
    ck_assert_int_eq(t.rows, 3);
    ck_assert(t.result.run.proof_prec != 0 || t.result.run.enclosed);
    ck_assert_int_ge(t.result.decimals, numerics[_i].decimals);
    for (int r = 0; r < t.rows; r++)
        check_row(&t, r, "case4.csv", CNS_PLACES_DECIMALS, t.decimals[r]);
    table_clear(&t);
}
END_TEST

/* Planted faults. */

/* No watched quantities: kinks are leapt over, the held sign is wrong from there on. */
static void unwatch(cns_program *p)
{
    p->n_watch = 0;
}

static const struct {
    const char *yaml, *name;
} kinks[] = {
    {"model: apw\ninitial: {Vy: 0.01}\ntime: {end: 3, every: 1}\n", "the root of a square"},
    {"model: apw\ninitial: {theta: 1, omega: 0.02}\ntime: {end: 3, every: 1}\n", "the sign of omega"},
    {CASE4 "time: {end: 15, every: 5}\n", "the sign of omega, later"},
};

START_TEST(a_wrong_sign_is_found)
{
    for (int proven = 0; proven < 2; proven++) {
        table t;
        char yaml[512];
        snprintf(yaml, sizeof yaml, "%s%s", kinks[_i].yaml,
                 proven ? "goal: {decimals: 20}\n" : "numerics: {arithmetic: mpfr, digits: 60}\n");
        solve(&t, yaml, false, NULL);
        check_done(&t);
        ck_assert_msg(t.result.landings > 0, "%s: no kink, nothing to get wrong", kinks[_i].name);
        table wrong;
        solve(&wrong, yaml, false, unwatch);
        if (proven) {
            ck_assert_int_eq(wrong.code, CNS_NUMERIC);
            ck_assert_ptr_nonnull(strstr(wrong.err.text, "branch"));
            for (int r = 0; r < wrong.rows; r++) /* rows before it are right */
                for (int i = 0; i <= MAX_STATES; i++)
                    ck_assert_str_eq(wrong.text[r][i], t.text[r][i]);
            ck_assert_int_lt(wrong.rows, t.rows);
        } else { /* without a proof the fault is silent, and large */
            check_ok(wrong.code, &wrong.err);
            double most = 0;
            for (int i = 1; i <= MAX_STATES; i++)
                most = fmax(most, fabs(atof(wrong.text[t.rows - 1][i]) - atof(t.text[t.rows - 1][i])));
            ck_assert_msg(most > 1e-9, "%s: the fault changes nothing", kinks[_i].name);
        }
        table_clear(&t);
        table_clear(&wrong);
    }
}
END_TEST

Suite *suite_solve(void)
{
    Suite *suite = suite_create("solve");
    TCase *tc = tcase_create("right");
    add_table_test(tc, rows_are_the_reference_rounded, references);
    tcase_add_test(tc, lorenz_at_100);
    tcase_add_test(tc, case_1_is_its_closed_form);
    add_table_test(tc, near_misses_of_the_singularity, near_misses);
    tcase_add_test(tc, derived_quantities_at_rest);
    suite_add_tcase(suite, tc);
    tc = tcase_create("rows");
    tcase_add_test(tc, rows_do_not_depend_on_every);
    tcase_add_test(tc, steps_do_not_depend_on_every);
    tcase_add_test(tc, the_end_is_a_row_once);
    tcase_add_test(tc, ties_at_the_start);
    tcase_add_test(tc, a_goal_is_reached_at_the_first_attempt);
    tcase_add_test(tc, significant_digits);
    suite_add_tcase(suite, tc);
    tc = tcase_create("shortage");
    tcase_add_test(tc, too_few_digits_are_honest);
    tcase_add_test(tc, too_few_digits_for_significant_ones);
    tcase_add_test(tc, max_time_ends_a_run);
    tcase_add_test(tc, max_time_ends_a_plan);
    suite_add_tcase(suite, tc);
    tc = tcase_create("numerics");
    add_table_test(tc, numerics_without_a_proof, numerics);
    add_table_test(tc, numerics_with_a_proof, numerics);
    suite_add_tcase(suite, tc);
    tc = tcase_create("faults");
    add_table_test(tc, a_wrong_sign_is_found, kinks);
    suite_add_tcase(suite, tc);
    return suite;
}
