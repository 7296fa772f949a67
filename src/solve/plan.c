/* How many digits a goal needs: from the growth of noise along a preliminary run in double precision with
 * tangents, and a margin for what that run cannot know. */
#include <math.h>
#include <stdlib.h>

#include "core/clock.h"
#include "core/memory.h"
#include "core/monitor.h"
#include "cost.h"
#include "events.h"
#include "integrate/numerics.h"
#include "integrate/rows.h"
#include "num/logs.h"
#include "problem.h"
#include "proof.h"

enum {
    /* Of the preliminary run. */
    DOUBLE_ORDER = 22,
    DOUBLE_TOLERANCE_LOG2 = -54,
    /* A step makes more noise than one rounding; and with e some digits below the last place told, few values
     * lie so near to a rounding boundary that the place is lost and the run must be repeated. */
    SPARE_DIGITS = 5,
    LEAST_DIGITS = 10, /* of the coarser run */
    WINDOWS = 64       /* parts of the time in which growth is compared, for its fluctuation */
};

/* The decimals that the goal asks for in x: significant digits of a small number are more. */
static double places_of(const cns_goal *goal, mpfr_srcptr x)
{
    const double count = (double)cns_goal_count(goal);
    if (cns_goal_places(goal) == CNS_PLACES_DECIMALS || !mpfr_regular_p(x))
        return count;
    return count + fmax(0, -cns_log2_mpfr(x) * CNS_LOG10_2);
}

/* The digits that the sizes of states take beside the places behind the point: 10^-decimals is absolute, a
 * number of so many digits is rounded relative to its own size. The guard bits cover what is usual. */
static double size_of(const cns_problem *p, const cns_goal *goal, const mpfr_t *state)
{
    const cns_program *program = cns_system_program(p->system);
    double most = 0;
    for (int i = 0; i < cns_program_states(program); i++)
        if (mpfr_regular_p(state[i]) &&
            (cns_program_is_dynamic(program, i) || cns_goal_places(goal) == CNS_PLACES_DECIMALS)) {
            const double log2_size =
                (double)mpfr_get_exp(state[i]) - cns_log2_2exp(cns_system_scales(p->system)[i], 0);
            most = fmax(most, (log2_size - CNS_USUAL_SIZE_BITS) * CNS_LOG10_2);
        }
    return most;
}

/* The digits that noise made from each origin on may cost any later row: what it grows to, at most, and a
 * margin for the part of the way that the preliminary run cannot know. */
typedef struct needs {
    const cns_problem *p;
    const cns_goal *goal;
    cns_growth *growth;
    bool *constant, *zero_output; /* what needs no digits, as it never changes (cns/system.h) */
    double most;                  /* of noise made anywhere */
    int n;
    double time[CNS_GROWTH_ORIGINS];
    double from[CNS_GROWTH_ORIGINS]; /* the goal's places and the growth to where it needs most */
} needs;

static double places_of_row(const needs *need, const cns_sample *s)
{
    const cns_problem *p = need->p;
    const cns_goal *goal = need->goal;
    double most = (double)cns_goal_count(goal);
    for (int i = 0; i < cns_columns(p); i++) {
        const cns_column c = cns_column_at(p, i);
        if (c.kind == CNS_COLUMN_STATE ? !need->constant[c.index]
                                       : c.kind == CNS_COLUMN_OUTPUT && !need->zero_output[c.index])
            most = fmax(most,
                        places_of(goal, c.kind == CNS_COLUMN_STATE ? s->state[c.index] : s->output[c.index]));
    }
    return most;
}

/* Of a row or an event: places, and what noise has grown to there, by the last cns_growth_at(). */
static void add_needs(needs *need, double places, double noise_log2)
{
    cns_growth *g = need->growth;
    need->most = fmax(need->most, places + fmax(0, noise_log2 * CNS_LOG10_2));
    for (; need->n < cns_growth_marks(g); need->n++) {
        need->time[need->n] = cns_growth_origin(g, need->n);
        need->from[need->n] = places;
    }
    for (int i = 0; i < need->n; i++)
        need->from[i] = fmax(need->from[i], places + fmax(0, cns_growth_since(g, i)));
}

static cns_code add_event_needs(void *context, const cns_meeting *m, const cns_meeting_bound *bound,
                                double noise_log2, cns_error *err)
{
    (void)bound;
    needs *need = context;
    const int n = cns_program_states(cns_system_program(need->p->system)),
              own = need->p->conditions[m->condition].state;
    double places = places_of(need->goal, m->time);
    (void)err;
    for (int i = 0; i < n; i++)
        if (i != own && !need->constant[i]) /* own, which is exact, or found again by raising the digits */
            places = fmax(places, places_of(need->goal, m->state[i]));
    if (m->direction == 0) /* a touch moves by the root of the noise */
        places *= 2;
    const double loss = cns_event_loss_log2(need->p, m) * CNS_LOG10_2;
    if (isfinite(loss))
        add_needs(need, places + size_of(need->p, need->goal, m->state) + loss, noise_log2);
    return CNS_OK;
}

/* Digits for steps that begin in each part of [0, end]. Noise of many steps adds up, as a random walk. */
static void fill_schedule(cns_schedule *schedule, const needs *need, double end, double spread,
                          double trusted, double steps)
{
    double later = 0;
    int origin = need->n - 1;
    schedule->end = end;
    schedule->n = CNS_PLAN_PARTS;
    for (int i = schedule->n - 1; i >= 0; i--) {
        double begin = end * i / schedule->n;
        double unknown = fmax(0, end - fmax(trusted, begin));
        /* The origins within the part, and the last one before it: steps can be longer than parts. */
        bool before = false;
        for (; origin >= 0 && !before; origin -= !before) {
            later = fmax(later, need->from[origin] + 3.5 * spread * sqrt(unknown));
            before = need->time[origin] <= begin;
        }
        schedule->digits[i] = (long)ceil(later + 0.5 * cns_log10_2exp(fmax(1, steps), 0)) + SPARE_DIGITS + 2;
        if (schedule->digits[i] < LEAST_DIGITS)
            schedule->digits[i] = LEAST_DIGITS;
    }
}

cns_code cns_plan(const cns_problem *p, const cns_goal *goal, cns_run_info *plan, cns_schedule *schedule,
                  cns_error *err)
{
    const cns_code refused = cns_problem_check(p, err);
    if (refused)
        return refused;
    if ((goal->decimals > 0) == (goal->significant > 0))
        return cns_fail(err, CNS_USAGE, "a goal is at least one decimal, or significant digit, not both");
    cns_trajectory_spec spec = {.flow = cns_flow_spec_taylor(cns_system_program(p->system),
                                                             cns_system_scales(p->system), CNS_ARITH_DOUBLE,
                                                             CNS_DOUBLE_DIGITS),
                                .initial = cns_system_initial(p->system),
                                .outputs = cns_wants_outputs(p) && goal->significant > 0,
                                .deadline = goal->max_time > 0 ? cns_seconds() + goal->max_time : 0,
                                .origins = true,
                                .end = cns_number_get_d(p->end),
                                .most_steps = cns_most_steps(p, goal->max_time),
                                .conditions = p->conditions,
                                .n_conditions = p->n_conditions,
                                .met = add_event_needs,
                                .stepped = cns_tally_step,
                                .unit_noise = true};
    const double since = cns_thread_seconds();
    cns_tally tally = {.spec = &spec.flow, .end = spec.end};
    needs need = {.p = p, .goal = goal, .most = (double)cns_goal_count(goal)};
    spec.context = &tally;
    spec.met_context = &need;
    spec.flow.portable = true;
    spec.flow.stop = cns_monitor_stop(p->monitor);
    spec.flow.order = DOUBLE_ORDER;
    spec.flow.tolerance_log2 = DOUBLE_TOLERANCE_LOG2;
    *plan = (cns_run_info){.attempt = 1, .planned = true};
    cns_code code = cns_go_on(cns_monitor_stop(p->monitor), err);
    need.constant = cns_xalloc((size_t)cns_system_model(p->system)->n_states + 1, sizeof *need.constant);
    need.zero_output =
        cns_xalloc((size_t)cns_system_model(p->system)->n_outputs + 1, sizeof *need.zero_output);
    if (!code)
        code = cns_system_constants(p->system, need.constant, need.zero_output, err);
    if (code) {
        free(need.constant);
        free(need.zero_output);
        return code;
    }

    cns_trajectory *t = cns_trajectory_new(&spec, err);
    cns_sample s = {0};
    mpq_t time;
    mpq_init(time);
    if (!t || !cns_sample_init(&s, cns_system_program(p->system), CNS_DOUBLE_BITS)) {
        cns_trajectory_free(t);
        cns_sample_clear(&s);
        mpq_clear(time);
        free(need.constant);
        free(need.zero_output);
        return t ? cns_out_of_memory(err) : err->code;
    }

    /* Past the time at which double precision is used up, the run follows another trajectory of the same
     * kind: growth there is known in the mean, and fluctuates about it like a random walk whose variance
     * per unit of time is that of the increments seen. */
    cns_error failure = {0};
    double end = cns_number_get_d(p->end), growth = 0, trusted = end;
    double window = end / WINDOWS, window_start = 0, at_start = 0, sum = 0, sum2 = 0;
    int windows = 0;
    need.growth = cns_trajectory_growth(t);
    for (unsigned long row = 0; !code && cns_problem_row(p, row, time); row++) {
        code = cns_trajectory_at(t, time, &s, &failure);
        if (code)
            break;
        plan->followed = mpq_equal(time, p->end->ratio) ? end : mpq_get_d(time); /* rounded as the end is */
        double now = plan->followed, g = s.error_log2 > 0 ? s.error_log2 * CNS_LOG10_2 : 0;
        if (now - window_start >= window) {
            double rate = (g - at_start) / (now - window_start);
            sum += rate * (now - window_start);
            sum2 += (g - at_start) * (g - at_start) / (now - window_start);
            windows++;
            window_start = now;
            at_start = g;
        }
        if (trusted >= end && g > CNS_DOUBLE_DIGITS - 3)
            trusted = now;
        growth = fmax(growth, g);
        add_needs(&need, places_of_row(&need, &s) + size_of(p, goal, s.state), s.error_log2);
    }
    if (code == CNS_STOPPED && cns_trajectory_late(t)) {
        code = cns_fail(err, CNS_UNREACHED, "max_time of %g s is used up while planning", goal->max_time);
    } else if (code == CNS_STOPPED || code == CNS_MEMORY || code == CNS_USAGE) {
        *err = failure;
    } else {
        /* A preliminary run that failed tells what it could; the run itself will tell why. */
        if (code)
            *err = failure;
        code = CNS_OK;
        double mean = end > 0 ? sum / end : 0;
        double variance = windows > 1 ? fmax(0, (sum2 - mean * sum) / windows) : 0;
        double untrusted = fmax(0, end - trusted);
        plan->growth = growth;
        plan->margin = 3.5 * sqrt(variance * untrusted);
        fill_schedule(schedule, &need, end, sqrt(variance), trusted,
                      (double)cns_flow_steps(cns_trajectory_flow(t)));
        long digits = (long)ceil(need.most + plan->margin) + SPARE_DIGITS + 2;
        if (digits < LEAST_DIGITS)
            digits = LEAST_DIGITS;
        /* Neither estimate is exact: the first part takes the larger, and no part has more. */
        if (schedule->digits[0] < digits)
            schedule->digits[0] = digits;
        digits = schedule->digits[0];
        plan->enclosed = goal->proof == CNS_PROOF_ENCLOSURE;
        cns_proof_runs runs;
        if (plan->enclosed) {
            plan->digits = digits;
            cns_proof_enclosed(&runs, p, plan->digits, schedule);
        } else {
            plan->proof_digits = digits;
            plan->digits = digits + CNS_ANOTHER_LIMB;
            cns_proof_of_goal(&runs, p, plan->digits, schedule);
        }
        plan->prec = runs.fine.prec;
        plan->order = runs.fine.order;
        plan->proof_prec = runs.coarse.prec;
        plan->proof_order = runs.coarse.order;
        code = cns_cost_predict(p, &runs, &tally, plan, err);
        cns_proof_runs_clear(&runs);
        plan->seconds += cns_thread_seconds() - since;
        if (!code) /* what was measured until the stop tells nothing */
            code = cns_go_on(cns_monitor_stop(p->monitor), err);
    }
    cns_trajectory_free(t);
    cns_sample_clear(&s);
    mpq_clear(time);
    free(need.constant);
    free(need.zero_output);
    return code;
}
