/* Plans against the runs they are made for. */
#include <math.h>
#include <stdlib.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "cns/solve.h"
#include "core/clock.h"
#include "problem.h"

typedef struct planned {
    const char *model, *smooth;
    const char *initial[6];
    const char *end, *every;
    cns_places places;
    long count;
    double error; /* of the steps, relative */
} planned;

static const planned goals[] = {
    {"apw", NULL, {"0", "0", "1", "0", "0.01", "1"}, "25", "1/2", CNS_PLACES_DECIMALS, 10, 0.2},
    {"apw", "1e-6", {"0", "0", "1", "0", "0.01", "1"}, "20", "1", CNS_PLACES_DECIMALS, 10, 0.3},
    {"apw", NULL, {"0", "0", "1", "0", "0.01", "1"}, "20", "20", CNS_PLACES_SIGNIFICANT, 60, 0.2},
    {"lorenz", NULL, {"-15.8", "-17.48", "35.64"}, "20", "1", CNS_PLACES_DECIMALS, 15, 0.2},
};

/* The problem of a goal; cleared with problem_clear(). */
typedef struct setting {
    cns_system *system;
    cns_number *times;
    cns_column columns[1];
    cns_problem problem;
} setting;

static void setting_make(setting *s, cns_system *system, const char *end, const char *every)
{
    const char *times[] = {end, every};
    *s = (setting){.system = system, .times = numbers_new(2, times), .columns = {{CNS_COLUMN_STATE, 0}}};
    s->problem = (cns_problem){.system = s->system,
                               .end = &s->times[0],
                               .every = &s->times[1],
                               .columns = s->columns,
                               .n_columns = 1};
}

static void setting_open(setting *s, const planned *g)
{
    const cns_model *m = cns_model_find(g->model);
    cns_setting settings[8] = {{NULL, NULL}};
    for (int i = 0; i < m->n_states; i++)
        settings[i] = (cns_setting){m->states[i].name, g->initial[i]};
    if (g->smooth)
        settings[m->n_states] = (cns_setting){"smooth", g->smooth};
    setting_make(s, system_new(m, settings), g->end, g->every);
}

static void setting_close(setting *s)
{
    numbers_free(s->times, 2);
    cns_system_free(s->system);
}

static cns_run_info plan_for(const setting *s, cns_places places, long count)
{
    long digits[CNS_PLAN_PARTS];
    cns_schedule schedule = {.digits = digits};
    cns_goal goal = goal_of(places, count, 5000);
    cns_run_info plan;
    cns_error err;
    check_ok(cns_plan(&s->problem, &goal, &plan, &schedule, &err), &err);
    ck_assert(plan.followed == cns_number_get_d(s->problem.end));
    return plan;
}

/* Processor time comes out otherwise each time where other programs share the processor and its caches: what
 * is said of it must become true in one of so many tries. */
enum { TRIES = 30 };

/* Digits and order exactly, at the first try; steps within 20 %, or 30 % where smoothed kinks take most;
 * processor time within a factor of two. */
START_TEST(run_is_what_was_planned)
{
    setting s;
    double expected = 0, took = 0;
    bool close = false;
    setting_open(&s, &goals[_i]);
    cns_goal goal = goal_of(goals[_i].places, goals[_i].count, 5000);
    for (int i = 0; i < TRIES && !close; i++) {
        cns_error err;
        cns_result result;
        cns_run_info plan = plan_for(&s, goals[_i].places, goals[_i].count);
        double since = cns_process_seconds();
        check_ok(cns_solve_goal(&s.problem, &goal, &result, &err), &err);
        took = cns_process_seconds() - since;
        expected = plan.seconds;
        close = expected < 2 * took && took < 2 * expected;
        ck_assert(result.reached);
        ck_assert_int_eq(result.run.attempt, 1);
        ck_assert_int_eq(plan.digits, result.run.digits);
        ck_assert_int_eq(plan.proof_digits, result.run.proof_digits);
        ck_assert_int_eq(plan.order, result.run.order);
        ck_assert_double_le(fabs(plan.steps - (double)result.steps), goals[_i].error * (double)result.steps);
    }
    ck_assert_msg(close, "%.3f s planned, %.3f s taken", expected, took);
    setting_close(&s);
}
END_TEST

/* A clock by which a step takes 2 s and a row 1 s: the measurement reads it before a step, after it, and
 * after a row. With `falling` below 1 both take less at each reading than at the one before:
 * runs are measured with the most digits first. */
static int readings, stop_at;
static double falling = 1;
static volatile sig_atomic_t stop;
static double metered(cns_clock clock)
{
    static const double spent[] = {2, 1, 0}; /* before a reading: a step, a row, nothing */
    static double now, price;
    (void)clock;
    if (++readings == stop_at)
        stop = 2;
    price = readings > 1 ? price * falling : 1; /* the first is the beginning of all */
    now += readings > 1 ? price * spent[readings % 3] : 0;
    return now;
}

static cns_code metered_plan(setting *s, int threads, cns_run_info *plan)
{
    long digits[CNS_PLAN_PARTS];
    cns_schedule schedule = {.digits = digits};
    cns_goal goal = {.decimals = 10, .max_digits = 5000, .proof = CNS_PROOF_TWO_RUNS};
    cns_error err;
    readings = 0;
    const cns_monitor monitor = {.threads = threads, .stop = &stop};
    s->problem.monitor = &monitor;
    cns_clock_replace(metered);
    cns_code code = cns_plan(&s->problem, &goal, plan, &schedule, &err);
    cns_clock_replace(NULL);
    s->problem.monitor = NULL;
    return code;
}

/* Two threads take as long as the longer run, one as both; planning is counted. */
START_TEST(seconds_are_steps_and_rows)
{
    setting s;
    cns_run_info two, one;
    setting_open(&s, &goals[0]);
    stop_at = stop = 0;
    ck_assert_int_eq(metered_plan(&s, 2, &two), CNS_OK);
    const double planning = readings - 2, rows = 50;
    ck_assert_double_eq_tol(two.seconds, planning + 2 * two.steps + rows, 1e-6);
    ck_assert_int_eq(metered_plan(&s, 1, &one), CNS_OK);
    ck_assert_double_gt(one.seconds, planning + 1.5 * (2 * one.steps + rows));
    ck_assert_double_lt(one.seconds, planning + 2 * (2 * one.steps + rows));
    setting_close(&s);
}
END_TEST

/* Whenever a stop comes, there is no plan: one from half a measurement would promise too little. */
START_TEST(a_stopped_plan_says_nothing)
{
    setting s;
    cns_run_info plan;
    setting_open(&s, &goals[0]);
    stop_at = stop = 0;
    ck_assert_int_eq(metered_plan(&s, 1, &plan), CNS_OK);
    const int last = readings;
    ck_assert_int_gt(last, 20);
    for (int i = 0; i < 5; i++) {
        stop_at = (const int[]){1, 2, 10, last / 2, last}[i];
        stop = 0;
        ck_assert_int_eq(metered_plan(&s, 1, &plan), CNS_STOPPED);
    }
    setting_close(&s);
}
END_TEST

typedef struct watch {
    double last, halfway;
} watch;

static void watch_progress(void *context, double fraction, const char *what)
{
    watch *seen = context;
    double t, end;
    ck_assert_int_eq(sscanf(what, "t = %lf of %lf", &t, &end), 2);
    ck_assert(fraction >= seen->last && fraction <= 1);
    seen->last = fraction;
    if (t == end / 2)
        seen->halfway = fraction;
}

/* Progress is told in parts of the work: where steps cost the same throughout, half of it is done at half of
 * the time; where precision falls with time and steps become cheaper, more. */
START_TEST(progress_is_that_of_the_work)
{
    static const planned g = {"lorenz", NULL, {"-15.8", "-17.48", "35.64"}, "100", "1/2", CNS_PLACES_DECIMALS,
                              10,       0};
    setting s;
    cns_error err;
    cns_result result;
    watch seen = {0, 0};
    double halfway[2];
    setting_open(&s, &g);
    const cns_monitor monitor = {.progress = watch_progress, .context = &seen};
    s.problem.monitor = &monitor;
    cns_goal goal = goal_of(g.places, g.count, 5000);
    check_ok(cns_solve_goal(&s.problem, &goal, &result, &err), &err);
    ck_assert_double_eq_tol(seen.last, 1, 1e-9);
    ck_assert_double_eq(seen.halfway, result.run.done[CNS_PLAN_PARTS / 2 - 1]);
    for (int i = 0; i < 2; i++) {
        cns_run_info plan;
        stop_at = stop = 0;
        falling = i == 0 ? 1 : 0.9;
        ck_assert_int_eq(metered_plan(&s, 1, &plan), CNS_OK);
        halfway[i] = plan.done[CNS_PLAN_PARTS / 2 - 1];
    }
    ck_assert_double_eq_tol(halfway[0], 0.5, 0.05);
    ck_assert_msg(halfway[1] > halfway[0] + 0.05 && halfway[1] < 0.95, "%g, %g", halfway[0], halfway[1]);
    setting_close(&s);
}
END_TEST

START_TEST(more_decimals_cost_more)
{
    setting s;
    setting_open(&s, &goals[0]);
    bool more = false;
    for (int i = 0; i < TRIES && !more; i++) {
        cns_run_info few = plan_for(&s, CNS_PLACES_DECIMALS, 10),
                     many = plan_for(&s, CNS_PLACES_DECIMALS, 400);
        ck_assert_int_eq(many.digits - few.digits, 390);
        ck_assert_double_gt(many.memory, few.memory + 1e6);
        more = many.seconds > 5 * few.seconds;
    }
    ck_assert(more);
    setting_close(&s);
}
END_TEST

static void build_pole(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_derivative(p, 0, cns_sqr(p, cns_state(p, 0)));
}

/* As far as double precision follows the trajectory there is no margin. Beyond, growth is known in the mean,
 * and fluctuates like a random walk: the margin grows like the root of the time. */
START_TEST(margins_grow_like_a_walk)
{
    static const struct {
        const char *end;
        double time; /* beyond what double follows, about */
    } ends[] = {{"20", 0}, {"200", 165}, {"800", 765}};
    double unit = 0;
    for (int i = 0; i < COUNT(ends); i++) {
        const planned g = {
            "lorenz", NULL, {"-15.8", "-17.48", "35.64"}, ends[i].end, "1", CNS_PLACES_DECIMALS, 10, 0};
        setting s;
        setting_open(&s, &g);
        cns_run_info plan = plan_for(&s, g.places, g.count);
        if (i == 0)
            ck_assert_double_eq(plan.margin, 0);
        if (i == 1)
            unit = plan.margin / sqrt(ends[1].time);
        if (i == 2)
            ck_assert_msg(fabs(plan.margin / sqrt(ends[2].time) / unit - 1) < 0.5, "%g, not %g", plan.margin,
                          unit * sqrt(ends[2].time));
        ck_assert(i == 0 || plan.margin > 1);
        ck_assert_double_ge((double)(plan.enclosed ? plan.digits : plan.proof_digits),
                            10 + plan.growth + plan.margin);
        setting_close(&s);
    }
}
END_TEST

/* x' = x^2 from 1 has a pole at t = 1. */
START_TEST(says_how_far_it_came)
{
    const cns_model pole = unit_model(1, build_pole, NULL);
    setting s;
    setting_make(&s, unit_system(&pole, (const char *[]){"1"}), "2", "1/8");
    long digits[CNS_PLAN_PARTS];
    cns_schedule schedule = {.digits = digits};
    cns_goal goal = {.decimals = 10, .max_digits = 5000};
    cns_run_info plan;
    cns_error err = {0};
    check_ok(cns_plan(&s.problem, &goal, &plan, &schedule, &err), &err);
    ck_assert(plan.followed == 0.875);
    ck_assert_int_eq(err.code, CNS_NUMERIC);
    setting_close(&s);
}
END_TEST

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
static double heap(void)
{
    struct mallinfo2 m = mallinfo2();
    return (double)m.uordblks + (double)m.hblkhd;
}

/* What a flow says it holds, against the heap. */
START_TEST(memory_is_what_is_allocated)
{
    cns_program *p = model_program("apw", NULL);
    for (int arithmetic = CNS_ARITH_FAST; arithmetic <= CNS_ARITH_MPFR; arithmetic++)
        for (long digits = 100; digits <= 600; digits += 250) {
            cns_flow_spec spec = taylor_spec(p, digits);
            spec.arithmetic = (cns_arithmetic)arithmetic;
            double before = heap();
            cns_flow *f = flow_new(&spec);
            double held = heap() - before, told = (double)cns_flow_bytes(f);
            cns_flow_free(f);
            ck_assert_msg(fabs(told / held - 1) < 0.1, "%ld digits: %.0f bytes told, %.0f held", digits, told,
                          held);
        }
    cns_program_free(p);
}
END_TEST
#endif

Suite *suite_plan(void)
{
    Suite *s = suite_create("plan");
    TCase *t = tcase_create("plan");
    add_table_test(t, run_is_what_was_planned, goals);
    tcase_add_test(t, seconds_are_steps_and_rows);
    tcase_add_test(t, a_stopped_plan_says_nothing);
    tcase_add_test(t, progress_is_that_of_the_work);
    tcase_add_test(t, more_decimals_cost_more);
    tcase_add_test(t, margins_grow_like_a_walk);
    tcase_add_test(t, says_how_far_it_came);
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
    tcase_add_test(t, memory_is_what_is_allocated);
#endif
    suite_add_tcase(s, t);
    return s;
}
