/* Sections: meetings known in closed form, on joints, at ends, two in a step, touches; against crossings
 * counted on a fine grid. */
#include <math.h>
#include <stdlib.h>

#include "cns/events.h"
#include "problem.h"

enum { MOST = 4096, DIGITS = 40 };

typedef struct record {
    int section, direction;
    long k;
    double rate;
    mpfr_t time;
    mpfr_t *state;
} record;

static record all[MOST];
static int n_all, n_of;

static cns_event_condition section(cns_condition_kind kind, int state, const char *value, const char *period)
{
    cns_event_condition s;
    cns_error err;
    cns_event_condition_init(&s);
    s.kind = kind;
    s.state = state;
    check_ok(cns_number_parse(&s.value, value, &err), &err);
    if (period != NULL)
        check_ok(cns_number_parse(&s.period, period, &err), &err);
    return s;
}

static void forget(void)
{
    for (int i = 0; i < n_all; i++) {
        mpfr_clear(all[i].time);
        cns_vector_free(all[i].state);
    }
    n_all = 0;
}

/* All meetings up to the step that reaches `end`. */
static void collect(const cns_flow_spec *spec, const char *const *initial, cns_event_condition *sections,
                    int n, double end)
{
    cns_error err;
    cns_flow *f = flow_started(spec, initial);
    forget();
    n_of = cns_flow_states(f);
    cns_meetings *s = cns_meetings_new(sections, n, n_of, spec->scales, cns_flow_prec(f), &err);
    ck_assert_ptr_nonnull(s);
    cns_meetings_start(s);
    while (mpfr_cmp_d(cns_flow_end(f), end) < 0) {
        check_ok(cns_flow_step(f, &err), &err);
        check_ok(cns_meetings_follow(s, f, &err), &err);
        for (int i = 0; i < cns_meetings_count(s); i++) {
            const cns_meeting *m = cns_meetings_meeting(s, i);
            if (mpfr_cmp_d(m->time, end) > 0)
                continue;
            ck_assert_int_lt(n_all, MOST);
            record *r = &all[n_all++];
            *r = (record){.section = m->condition, .direction = m->direction, .k = m->k, .rate = m->rate};
            mpfr_init2(r->time, mpfr_get_prec(m->time));
            mpfr_set(r->time, m->time, MPFR_RNDN);
            r->state = cns_vector_xnew(n_of, cns_flow_prec(f));
            for (int j = 0; j < n_of; j++)
                mpfr_set(r->state[j], m->state[j], MPFR_RNDN);
        }
    }
    cns_meetings_free(s);
    cns_flow_free(f);
    for (int i = 0; i < n; i++)
        cns_event_condition_clear(&sections[i]);
}

/* x'' = -x, and z' = 1: clock. */
static cns_program *oscillator(void)
{
    cns_program *p = program_new(3, NULL);
    cns_derivative(p, 0, cns_state(p, 1));
    cns_derivative(p, 1, cns_neg(p, cns_state(p, 0)));
    cns_derivative(p, 2, cns_constant(p, "1"));
    return finished(p);
}

START_TEST(zeros_of_the_sine)
{
    cns_program *p = oscillator();
    cns_event_condition s[] = {section(CNS_CONDITION_VALUE, 0, "0", NULL),
                               section(CNS_CONDITION_EXTREMUM, 0, "0", NULL),
                               section(CNS_CONDITION_VALUE, 0, "1/2", NULL)};
    const cns_flow_spec spec = taylor_spec(p, DIGITS);
    mpfr_t pi, t;
    mpfr_inits2(200, pi, t, (mpfr_ptr)0);
    mpfr_const_pi(pi, MPFR_RNDN);
    collect(&spec, (const char *[]){"0", "1", "0"}, s, 3, 100);
    int zeros = 0, extrema = 0, halves = 0;
    for (int i = 0; i < n_all; i++) {
        const record *r = &all[i];
        if (r->section == 0) { /* t = k pi, k >= 1 */
            zeros++;
            mpfr_mul_si(t, pi, zeros, MPFR_RNDN);
            ck_assert_int_eq(r->direction, zeros % 2 ? -1 : 1);
            ck_assert(mpfr_zero_p(r->state[0]));
        } else if (r->section == 1) { /* (k - 1/2) pi; the first is a maximum */
            mpfr_mul_si(t, pi, 2 * extrema++ + 1, MPFR_RNDN);
            mpfr_div_2ui(t, t, 1, MPFR_RNDN);
            ck_assert_int_eq(r->direction, extrema % 2 ? -1 : 1);
            ck_assert(fabs(mpfr_get_d(r->state[0], MPFR_RNDN) - (extrema % 2 ? 1 : -1)) < 1e-15);
        } else { /* pi/6 and 5 pi/6, and 2 pi more */
            mpfr_mul_si(t, pi, (halves % 2 ? 5 : 1) + 12 * (halves / 2), MPFR_RNDN);
            mpfr_div_ui(t, t, 6, MPFR_RNDN);
            halves++;
        }
        check_close(r->time, t, DECIMALS(DIGITS - 4), "meeting %d of section %d", i, r->section);
        check_close(r->time, r->state[2], DECIMALS(DIGITS - 4), "the clock at meeting %d", i);
    }
    ck_assert_int_eq(zeros, 31);
    ck_assert_int_eq(extrema, 32);
    ck_assert_int_eq(halves, 32);
    mpfr_clears(pi, t, (mpfr_ptr)0);
    cns_program_free(p);
}
END_TEST

/* theta' = 1 + z, z' = 1: many multiples of a period in one step, exactly known. */
START_TEST(periods)
{
    cns_program *p = program_new(2, NULL);
    cns_derivative(p, 0, cns_add(p, cns_constant(p, "1"), cns_state(p, 1)));
    cns_derivative(p, 1, cns_constant(p, "1"));
    finished(p);
    cns_event_condition s[] = {section(CNS_CONDITION_PERIODS, 0, "1/2", "pi")};
    const char *sixteen = "16";
    cns_number *step = numbers_new(1, &sixteen);
    cns_flow_spec spec = taylor_spec(p, DIGITS);
    spec.step = step;
    collect(&spec, (const char *[]){"0", "0"}, s, 1, 20);
    mpfr_t t;
    mpfr_init2(t, 200);
    ck_assert_int_eq(n_all, 1 + (int)((20 + 200 - 0.5) / 3.14159265358979));
    for (int i = 0; i < n_all; i++) { /* t + t^2/2 = 1/2 + k pi */
        mpfr_const_pi(t, MPFR_RNDN);
        mpfr_mul_si(t, t, 2 * i, MPFR_RNDN);
        mpfr_add_ui(t, t, 2, MPFR_RNDN);
        mpfr_sqrt(t, t, MPFR_RNDN);
        mpfr_sub_ui(t, t, 1, MPFR_RNDN);
        ck_assert_int_eq(all[i].k, i);
        ck_assert_int_eq(all[i].direction, 1);
        check_close(all[i].time, t, DECIMALS(DIGITS - 4), "multiple %d", i);
    }
    mpfr_clear(t);
    numbers_free(step, 1);
    cns_program_free(p);
}
END_TEST

/* x = (t-1)^2 (t-3)/..: polynomial motion takes one step for all: two roots in a step, and a touch. z clock.
 */
START_TEST(two_in_a_step_and_a_touch)
{
    cns_program *p = program_new(2, NULL);
    cns_node z = cns_state(p, 1);
    /* x = (z-1)^2 (z-3) (z-4): x' = 2 (z-1)(z-3)(z-4) + (z-1)^2 (2 z - 7) */
    cns_node a = cns_sub(p, z, cns_constant(p, "1")), b = cns_sub(p, z, cns_constant(p, "3")),
             c = cns_sub(p, z, cns_constant(p, "4"));
    cns_node first = cns_mul(p, cns_constant(p, "2"), cns_mul(p, a, cns_mul(p, b, c)));
    cns_node second =
        cns_mul(p, cns_sqr(p, a), cns_sub(p, cns_mul(p, cns_constant(p, "2"), z), cns_constant(p, "7")));
    cns_derivative(p, 0, cns_add(p, first, second));
    cns_derivative(p, 1, cns_constant(p, "1"));
    finished(p);
    cns_event_condition s[] = {section(CNS_CONDITION_VALUE, 0, "0", NULL)};
    const cns_flow_spec spec = taylor_spec(p, DIGITS);
    collect(&spec, (const char *[]){"12", "0"}, s, 1, 10);
    ck_assert_int_eq(n_all, 3);
    const int direction[] = {0, -1, 1};
    for (int i = 0; i < 3; i++)
        ck_assert_int_eq(all[i].direction, direction[i]);
    ck_assert(fabs(mpfr_get_d(all[0].time, MPFR_RNDN) - 1) < 1e-15);
    ck_assert(fabs(mpfr_get_d(all[1].time, MPFR_RNDN) - 3) < 1e-15);
    ck_assert(fabs(mpfr_get_d(all[2].time, MPFR_RNDN) - 4) < 1e-15);
    cns_program_free(p);
}
END_TEST

/* Steps much shorter than the noise of the state, as beside a singularity: what crosses is no touch. */
START_TEST(tiny_steps)
{
    cns_program *p = oscillator();
    cns_event_condition s[] = {section(CNS_CONDITION_VALUE, 0, "0", NULL)};
    const char *tiny = "3e-31";
    cns_number *step = numbers_new(1, &tiny);
    cns_flow_spec spec = taylor_spec(p, 20);
    spec.step = step;
    collect(&spec, (const char *[]){"1e-30", "-1", "0"}, s, 1, 1e-29);
    ck_assert_int_eq(n_all, 1);
    ck_assert_int_eq(all[0].direction, -1);
    ck_assert(fabs(all[0].rate + 1) < 1e-15);
    ck_assert(fabs(mpfr_get_d(all[0].time, MPFR_RNDN) - 1e-30) < 1e-45);
    numbers_free(step, 1);
    cns_program_free(p);
}
END_TEST

/* A fixed step that ends exactly on the section, again and again: each meeting once. z = 1/2, 1, 3/2, ... */
START_TEST(joints)
{
    cns_program *p = program_new(2, NULL);
    cns_derivative(p, 0, cns_neg(p, cns_state(p, 0)));
    cns_derivative(p, 1, cns_constant(p, "1"));
    finished(p);
    const char *quarter = "1/4";
    cns_number *step = numbers_new(1, &quarter);
    cns_flow_spec spec = taylor_spec(p, DIGITS);
    spec.step = step;
    for (int rk4 = 0; rk4 < 2; rk4++) {
        cns_event_condition s[] = {section(CNS_CONDITION_PERIODS, 1, "0", "1/2")};
        spec.method = rk4 ? CNS_METHOD_RK4 : CNS_METHOD_TAYLOR;
        spec.verify = !rk4;
        collect(&spec, (const char *[]){"1", "0"}, s, 1, 20);
        ck_assert_int_eq(n_all, 40);
        for (int i = 0; i < n_all; i++)
            ck_assert(mpfr_cmp_d(all[i].time, 0.5 * (i + 1)) == 0 && all[i].direction == 1);
    }
    numbers_free(step, 1);
    cns_program_free(p);
}
END_TEST

/* The falling disk lands on omega = 0: meetings with it are its landings, each once; theta's extrema are the
 * same moments; theta = k pi against the signs of sin(theta) on a fine grid. */
START_TEST(falling_disk)
{
    enum { OMEGA = 5, THETA = 2 };
    cns_program *p = model_program("apw", NULL);
    const char *start[] = {"0", "0", "1", "0", "0.01", "1"};
    cns_flow_spec spec = taylor_spec(p, 30);
    cns_event_condition s[] = {section(CNS_CONDITION_VALUE, OMEGA, "0", NULL),
                               section(CNS_CONDITION_PERIODS, THETA, "0", "pi"),
                               section(CNS_CONDITION_EXTREMUM, THETA, "0", NULL)};
    collect(&spec, start, s, 3, 60);
    cns_flow *f = flow_started(&spec, start);
    cns_error err;
    long landings = 0, changes = 0, zeros = 0, passes = 0, turns = 0;
    mpfr_t *x = cns_vector_xnew(6, 200);
    mpq_t t;
    mpq_init(t);
    double last = sin(1.0);
    long row = 1;
    while (mpfr_cmp_d(cns_flow_end(f), 60) < 0) {
        check_ok(cns_flow_step(f, &err), &err);
        landings += cns_flow_landed(f) && mpfr_cmp_d(cns_flow_end(f), 60) <= 0;
        for (; mpfr_cmp_d(cns_flow_end(f), 0.01 * (double)row) >= 0 && row <= 6000; row++) {
            mpq_set_si(t, row, 100);
            mpq_canonicalize(t);
            cns_flow_eval(f, t, x);
            double sine = sin(mpfr_get_d(x[THETA], MPFR_RNDN));
            changes += (sine > 0) != (last > 0);
            last = sine;
        }
    }
    for (int i = 0; i < n_all; i++) {
        ck_assert(i == 0 || mpfr_cmp(all[i - 1].time, all[i].time) <= 0);
        zeros += all[i].section == 0;
        passes += all[i].section == 1;
        turns += all[i].section == 2;
        if (all[i].section == 2)
            ck_assert(fabs(mpfr_get_d(all[i].state[OMEGA], MPFR_RNDN)) < 1e-25);
    }
    ck_assert_int_gt(landings, 5);
    ck_assert_int_eq(zeros, landings);
    ck_assert_int_eq(turns, landings);
    ck_assert_int_gt(changes, 5);
    ck_assert_int_eq(passes, changes);
    mpq_clear(t);
    cns_vector_free(x);
    cns_flow_free(f);
    cns_program_free(p);
}
END_TEST

/* The same meetings in double, to its precision. */
START_TEST(double_agrees)
{
    cns_program *p = model_program("apw", NULL);
    const char *start[] = {"0", "0", "1", "0", "0.01", "1"};
    cns_flow_spec spec = taylor_spec(p, 30);
    double times[64];
    for (int round = 0; round < 2; round++) {
        cns_event_condition s[] = {section(CNS_CONDITION_PERIODS, 2, "0", "pi"),
                                   section(CNS_CONDITION_EXTREMUM, 3, "0", NULL)};
        collect(&spec, start, s, 2, 30);
        for (int i = 0; i < n_all && i < 64; i++) {
            double time = mpfr_get_d(all[i].time, MPFR_RNDN);
            if (round == 0)
                times[i] = time;
            else
                ck_assert_msg(fabs(times[i] - time) < 1e-9, "%.17g and %.17g", times[i], time);
        }
        if (round == 0) {
            ck_assert_int_gt(n_all, 6);
            times[63] = n_all;
        } else {
            ck_assert_int_eq((int)times[63], n_all);
        }
        spec.arithmetic = CNS_ARITH_DOUBLE;
        spec.tolerance_log2 = -52;
        spec.order = 20;
        spec.verify = false;
    }
    cns_program_free(p);
}
END_TEST

Suite *suite_meetings(void)
{
    Suite *s = suite_create("meetings");
    TCase *t = tcase_create("meetings");
    tcase_add_test(t, zeros_of_the_sine);
    tcase_add_test(t, periods);
    tcase_add_test(t, two_in_a_step_and_a_touch);
    tcase_add_test(t, tiny_steps);
    tcase_add_test(t, joints);
    tcase_add_test(t, falling_disk);
    tcase_add_test(t, double_agrees);
    suite_add_tcase(s, t);
    return s;
}
