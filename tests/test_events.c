/* Events of whole runs: right to the last decimal told, whatever happens on the way to them. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cns/solve.h"
#include "num/decimal_text.h"
#include "num/vector.h"
#include "problem.h"
#include "solve/events.h"

enum { MOST_EVENTS = 400, MOST_STATES = 6, MOST_CONDITIONS = 4 };

typedef struct told {
    int condition, direction;
    long k, decimals;
    char *text[1 + MOST_STATES]; /* time and states */
} told;

/* All that a run reports. */
typedef struct events {
    int n_states, n, attempts, rows;
    told at[MOST_EVENTS];
    cns_result result;
    cns_error err;
    cns_code code;
} events;

static void forget(events *e)
{
    for (int i = 0; i < e->n; i++)
        for (int k = 0; k <= e->n_states; k++)
            free(e->at[i].text[k]);
    e->n = 0;
}

static cns_code on_begin(void *context, const cns_run_info *run, cns_error *err)
{
    events *e = context;
    (void)run;
    (void)err;
    forget(e);
    e->attempts++;
    return CNS_OK;
}

static cns_code on_row(void *context, const cns_row *row, cns_error *err)
{
    (void)row;
    (void)err;
    ((events *)context)->rows++;
    return CNS_OK;
}

static cns_code on_event(void *context, const cns_event *event, cns_error *err)
{
    events *e = context;
    if (e->n == MOST_EVENTS)
        return cns_fail(err, CNS_IO, "too many events for this test");
    told *t = &e->at[e->n++];
    *t = (told){event->condition, event->direction, event->k, event->decimals, {strdup(event->time)}};
    for (int i = 0; i < e->n_states; i++)
        t->text[i + 1] = strdup(event->state[i]);
    return CNS_OK;
}

/* A condition: "value", "value mod period" or "extremum" of a state. */
typedef struct wanted {
    int state;
    const char *value, *period; /* value NULL: extremum */
} wanted;

typedef struct trial {
    const char *model; /* "clock", "oscillator" or one of the registry */
    const char *initial[MOST_STATES], *end, *every;
    wanted wanted[MOST_CONDITIONS];
    int n_wanted;
} trial;

/* x' = y' = 1 */
static void build_clock(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_derivative(p, 0, cns_constant(p, "1"));
    cns_derivative(p, 1, cns_constant(p, "1"));
}

/* x' = y, y' = -x, z' = 1 */
static void build_oscillator(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_derivative(p, 0, cns_state(p, 1));
    cns_derivative(p, 1, cns_neg(p, cns_state(p, 0)));
    cns_derivative(p, 2, cns_constant(p, "1"));
}

/* By a goal, or by numerics (goal NULL), proven or not. */
static void run(events *e, const trial *t, int threads, const cns_goal *goal, const cns_numerics *numerics,
                bool prove)
{
    const cns_model clock = unit_model(2, build_clock, NULL),
                    oscillator = unit_model(3, build_oscillator, NULL);
    const cns_model *m = !strcmp(t->model, "clock")        ? &clock
                         : !strcmp(t->model, "oscillator") ? &oscillator
                                                           : cns_model_find(t->model);
    const char *times[] = {t->end, t->every};
    cns_system *system = unit_system(m, t->initial);
    cns_number *time = numbers_new(2, times);
    const cns_monitor monitor = {.threads = threads};
    cns_event_condition condition[MOST_CONDITIONS];
    const cns_column column = {.kind = CNS_COLUMN_STATE};
    const cns_sink sink = {.context = e, .begin = on_begin, .row = on_row, .event = on_event};
    const cns_problem problem = {.system = system,
                                 .end = &time[0],
                                 .every = &time[1],
                                 .columns = &column,
                                 .n_columns = 1,
                                 .conditions = condition,
                                 .n_conditions = t->n_wanted,
                                 .monitor = &monitor,
                                 .sink = &sink};
    *e = (events){.n_states = m->n_states};
    for (int i = 0; i < t->n_wanted; i++) {
        const wanted *w = &t->wanted[i];
        cns_event_condition_init(&condition[i]);
        condition[i].state = w->state;
        condition[i].kind = w->period  ? CNS_CONDITION_PERIODS
                            : w->value ? CNS_CONDITION_VALUE
                                       : CNS_CONDITION_EXTREMUM;
        if (w->value)
            check_ok(cns_number_parse(&condition[i].value, w->value, &e->err), &e->err);
        if (w->period)
            check_ok(cns_number_parse(&condition[i].period, w->period, &e->err), &e->err);
    }
    e->code = goal ? cns_solve_goal(&problem, goal, &e->result, &e->err)
                   : cns_solve_numerics(&problem, numerics, prove, &e->result, &e->err);
    for (int i = 0; i < t->n_wanted; i++)
        cns_event_condition_clear(&condition[i]);
    numbers_free(time, 2);
    cns_system_free(system);
}

static void reach(events *e, const trial *t, int threads, cns_places places, long count)
{
    const cns_goal goal = goal_of(places, count, 2000);
    run(e, t, threads, &goal, NULL, false);
    check_ok(e->code, &e->err);
    ck_assert(e->result.reached && e->result.complete);
    ck_assert_int_eq(e->result.events_end.code, CNS_OK);
    for (int i = 0; i < e->n; i++)
        ck_assert_int_eq(e->at[i].decimals, count);
}

/* The event's texts are those of the other, which has more places, rounded. */
static void check_rounded(const told *few, const told *many, int n_states, cns_places places)
{
    ck_assert_int_eq(few->condition, many->condition);
    ck_assert_int_eq(few->direction, many->direction);
    ck_assert_int_eq(few->k, many->k);
    for (int i = 0; i <= n_states; i++) {
        cns_number x;
        cns_number_init(&x);
        ck_assert_int_eq(cns_number_parse(&x, many->text[i], NULL), CNS_OK);
        char *rounded = cns_text_mpq(x.ratio, places, few->decimals);
        ck_assert_msg(!strcmp(rounded, few->text[i]), "%s, value %d: %s, not %s", few->text[0], i,
                      few->text[i], rounded);
        free(rounded);
        cns_number_clear(&x);
    }
}

static const trial trials[] = {
    {"apw",
     {"0", "0", "1", "0", "0.01", "1"},
     "40",
     "8",
     {{2, "0", "pi"}, {5, "0", NULL}, {3, NULL, NULL}, {3, "1/10", NULL}},
     4},
    {"lorenz",
     {"-15.8", "-17.48", "35.64"},
     "25",
     "1/2",
     {{2, NULL, NULL}, {0, "0", NULL}, {2, "27", NULL}, {1, "1", "20"}},
     4},
    {"apw", {"0", "0", "0", "0", "1/100", "0"}, "50", "50", {{4, "-1/2", NULL}, {1, NULL, NULL}}, 2},
    {"oscillator", {"1", "0", "0"}, "60", "60", {{0, "1/2", NULL}, {1, "1/4", NULL}, {2, "1/3", "2"}}, 3},
};

/* A goal of few places against one of many, whose runs have other digits, orders, steps and schedules. */
START_TEST(events_are_those_of_a_finer_run_rounded)
{
    const trial *t = &trials[_i];
    for (int significant = 0; significant < 2; significant++) {
        const cns_places places = significant ? CNS_PLACES_SIGNIFICANT : CNS_PLACES_DECIMALS;
        events few, many, threaded;
        reach(&few, t, 1, places, 8);
        reach(&threaded, t, 2, places, 8);
        reach(&many, t, 1, places, 40);
        ck_assert_int_gt(few.n, 1);
        ck_assert_int_eq(few.n, many.n);
        ck_assert_int_eq(few.n, threaded.n);
        for (int i = 0; i < few.n; i++) {
            check_rounded(&few.at[i], &many.at[i], few.n_states, places);
            for (int k = 0; k <= few.n_states; k++)
                ck_assert_str_eq(few.at[i].text[k], threaded.at[i].text[k]);
        }
        forget(&few);
        forget(&many);
        forget(&threaded);
    }
}
END_TEST

static const cns_numerics by_hand[] = {
    {.arithmetic = CNS_ARITH_MPFR, .digits = 25},
    {.arithmetic = CNS_ARITH_FAST, .digits = 30, .order = 25},
    {.arithmetic = CNS_ARITH_DOUBLE},
};

START_TEST(events_by_numerics)
{
    const trial *t = &trials[0];
    events finer, proven, plain;
    reach(&finer, t, 1, CNS_PLACES_DECIMALS, 40);
    run(&proven, t, 2, NULL, &by_hand[_i], true);
    check_ok(proven.code, &proven.err);
    run(&plain, t, 1, NULL, &by_hand[_i], false);
    check_ok(plain.code, &plain.err);
    ck_assert_int_eq(proven.n, finer.n);
    ck_assert_int_eq(plain.n, finer.n);
    for (int i = 0; i < finer.n; i++) {
        ck_assert_int_ge(proven.at[i].decimals, 7);
        check_rounded(&proven.at[i], &finer.at[i], finer.n_states, CNS_PLACES_DECIMALS);
        ck_assert_int_eq(plain.at[i].decimals, -1);
        for (int k = 0; k <= finer.n_states; k++)
            ck_assert_double_eq_tol(atof(plain.at[i].text[k]), atof(finer.at[i].text[k]), 1e-7);
    }
    forget(&finer);
    forget(&proven);
    forget(&plain);
}
END_TEST

/* x = cos t comes to within 10^-30 of the value and goes back: two events, 10^-15 apart, whose decimals take
 * digits that the rows do not need. */
START_TEST(an_event_asks_for_digits)
{
    const trial near = {"oscillator",
                        {"1", "0", "0"},
                        "8",
                        "4",
                        {{0, "0.999999999999999999999999999999", NULL}},
                        1},
                rows = {"oscillator", {"1", "0", "0"}, "8", "4", {{0, NULL, NULL}}, 0};
    events with, without;
    reach(&with, &near, 1, CNS_PLACES_DECIMALS, 20);
    reach(&without, &rows, 1, CNS_PLACES_DECIMALS, 20);
    ck_assert_int_eq(with.n, 3); /* leaving 1 at first, and around t = 2 pi */
    ck_assert_int_eq(with.at[1].direction, 1);
    ck_assert_int_eq(with.at[2].direction, -1);
    ck_assert_str_ne(with.at[1].text[0], with.at[2].text[0]);
    ck_assert_int_gt(with.result.run.digits, without.result.run.digits + 10);
    ck_assert_int_eq(with.rows, without.rows);
    forget(&with);
}
END_TEST

/* t = x = y = 1/40 lies on a tie to two decimals, which no digits decide: told with fewer, and not in
 * silence. */
START_TEST(a_tie_gets_fewer_decimals)
{
    const trial t = {"clock", {"0", "0"}, "1", "1/3", {{0, "1/40", NULL}, {0, "1/3", NULL}}, 2};
    const cns_goal goal = {.decimals = 2, .max_digits = 2000};
    events e;
    run(&e, &t, 1, &goal, NULL, false);
    ck_assert_int_eq(e.code, CNS_UNREACHED);
    ck_assert_msg(strstr(e.err.text, "some events") != NULL, "%s", e.err.text);
    ck_assert(e.result.complete && !e.result.reached);
    ck_assert_int_gt(e.attempts, 2); /* more digits were tried */
    ck_assert_int_eq(e.rows, 4);
    ck_assert_int_eq(e.n, 2);
    ck_assert_int_eq(e.at[0].decimals, 1);
    ck_assert_str_eq(e.at[0].text[0], "0.0");
    ck_assert_int_eq(e.at[1].decimals, 2);
    ck_assert_str_eq(e.at[1].text[0], "0.33");
    forget(&e);
}
END_TEST

/* x = sin t exceeds the value by 10^-25 at t = pi/2: the finer run of 40 digits finds two crossings, the
 * other a touch, and more digits are not allowed. What was told before stands, and the rows are complete. */
START_TEST(where_the_runs_disagree_events_end)
{
    const trial t = {"oscillator",
                     {"0", "1", "0"},
                     "12",
                     "4",
                     {{0, "0.9999999999999999999999999", NULL}, {0, "1/2", NULL}},
                     2};
    const cns_goal goal = {.decimals = 4, .max_digits = 40, .proof = CNS_PROOF_TWO_RUNS};
    events e;
    run(&e, &t, 1, &goal, NULL, false);
    ck_assert_int_eq(e.code, CNS_UNREACHED);
    ck_assert_int_eq(e.result.events_end.code, CNS_UNREACHED);
    ck_assert_msg(strstr(e.err.text, "do not agree on the event at t = 1.57") != NULL, "%s", e.err.text);
    ck_assert(e.result.complete && !e.result.reached);
    ck_assert_int_eq(e.rows, 4);
    ck_assert_int_eq(e.n, 1);
    ck_assert_str_eq(e.at[0].text[0], "0.5236"); /* pi/6 */
    forget(&e);
}
END_TEST

/* e is 16 times the noise, times how far a deviation of 1 moves the crossing, times the largest state. */
START_TEST(places_of_an_event)
{
    enum { N = 3 };
    cns_system *system = system_new(cns_model_find("lorenz"), NULL);
    cns_event_condition condition;
    cns_event_condition_init(&condition);
    condition.kind = CNS_CONDITION_VALUE;
    const cns_problem p = {.system = system, .conditions = &condition, .n_conditions = 1};
    cns_found fine = {.m = {.direction = 1, .rate = 0.25, .state = cns_vector_xnew(N, 200)},
                      .noise_log2 = -300};
    mpfr_init2(fine.m.time, 200);
    mpfr_set_d(fine.m.time, 0.7, MPFR_RNDN);
    for (int i = 0; i < N; i++)
        mpfr_set_d(fine.m.state[i], 100 * i + 0.3, MPFR_RNDN);
    cns_found coarse = fine; /* the same: what is left is noise */
    coarse.noise_log2 = -100;
    const bool constant[N] = {false};
    const double largest = log2(200.3), slow = log2(1 + 1 / 0.25);
    double error;
    mpfr_t time_error;
    mpfr_init2(time_error, 64);
    long places = cns_event_places(&p, &fine, &coarse, constant, CNS_PLACES_DECIMALS, 60, &error, time_error);
    ck_assert_double_eq_tol(error, (4 - 100 + largest + slow) * log10(2), 1e-9);
    ck_assert(places == (long)floor(-error) || places == (long)floor(-error) - 1); /* one may straddle */
    ck_assert_int_eq(
        cns_event_places(&p, &fine, &coarse, constant, CNS_PLACES_DECIMALS, 9, &error, time_error), 9);

    fine.m.direction = coarse.m.direction = 0; /* a touch moves by the root of that */
    cns_event_places(&p, &fine, &coarse, constant, CNS_PLACES_DECIMALS, 60, &error, time_error);
    ck_assert_double_eq_tol(error, (4 + (largest - 100) / 2) * log10(2), 1e-9);

    coarse.m.direction = -1;
    ck_assert_int_eq(
        cns_event_places(&p, &fine, &coarse, constant, CNS_PLACES_DECIMALS, 60, &error, time_error), -1);
    coarse.m.direction = 0;
    coarse.m.k = 1;
    ck_assert_int_eq(
        cns_event_places(&p, &fine, &coarse, constant, CNS_PLACES_DECIMALS, 60, &error, time_error), -1);
    mpfr_clears(fine.m.time, time_error, (mpfr_ptr)0);
    cns_vector_free(fine.m.state);
    cns_event_condition_clear(&condition);
    cns_system_free(system);
}
END_TEST

Suite *suite_events(void)
{
    Suite *s = suite_create("events");
    TCase *t = tcase_create("events");
    add_table_test(t, events_are_those_of_a_finer_run_rounded, trials);
    add_table_test(t, events_by_numerics, by_hand);
    tcase_add_test(t, an_event_asks_for_digits);
    tcase_add_test(t, a_tie_gets_fewer_decimals);
    tcase_add_test(t, places_of_an_event);
    tcase_add_test(t, where_the_runs_disagree_events_end);
    suite_add_tcase(s, t);
    return s;
}
