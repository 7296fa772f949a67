/* cns plan: what a time and a number of decimals will need. */
#include <math.h>

#include "cns/solve.h"
#include "commands.h"
#include "core/text.h"
#include "report.h"

enum { STANDARD_DECIMALS = 10 };

/* --until: a time as in case files, on the way from the start on; *until gets what passes up to there. */
static int parse_until(const cns_case *c, const char *text, cns_number *until)
{
    cns_error err = {0};
    const char *side = c->backwards ? "below" : "above",
               *start = cns_number_sign(&c->start) ? c->start.text : "0";
    if (cns_number_parse(until, text, &err))
        return cns_complain(CNS_USAGE, "--until takes a rational number %s %s; %s", side, start, err.text);
    if (until->pi_power != 0 || cns_number_cmp(until, &c->start) != (c->backwards ? -1 : 1))
        return cns_complain(CNS_USAGE, "--until takes a rational number %s %s, not '%s'", side, start,
                            cns_quote(text).text);
    mpq_sub(until->ratio, until->ratio, c->start.ratio);
    mpq_abs(until->ratio, until->ratio);
    return 0;
}

static cns_goal goal_of(const cns_case *c, const cns_options *o)
{
    cns_goal goal = c->goal;
    if (o->decimals > 0 || !c->has_goal) {
        goal.significant = 0;
        goal.decimals = o->decimals > 0 ? o->decimals : STANDARD_DECIMALS;
    }
    return goal;
}

typedef struct made_plan {
    cns_goal goal;
    cns_run_info plan;
} made_plan;

static void print_text(FILE *out, const cns_context *cx, const void *result)
{
    const made_plan *made = result;
    const cns_goal *goal = &made->goal;
    const cns_run_info *plan = &made->plan;
    const cns_problem *p = &cx->problem;
    fprintf(out, "to t = %s with %ld %s:\n", p->end->text,
            goal->significant > 0 ? goal->significant : goal->decimals,
            goal->significant > 0 ? "significant digits" : "decimals");
    if (plan->enclosed) {
        fprintf(out, "digits   %ld, with an enclosure\n", plan->digits);
        fprintf(out, "order    %d\n", plan->order);
    } else {
        fprintf(out, "digits   %ld, proof with %ld\n", plan->digits, plan->proof_digits);
        fprintf(out, "order    %d, proof with %d\n", plan->order, plan->proof_order);
    }
    fprintf(out, "growth   10^%.1f, margin 10^%.1f\n", plan->growth, plan->margin);
    fprintf(out, "steps    about %.0f\n", plan->steps);
    fprintf(out, "memory   about %.1f MB\n", plan->memory / 1e6);
    fprintf(out, "time     about %.*f s, %s\n", plan->seconds < 10 ? 2 : 0, plan->seconds,
            !plan->enclosed && p->monitor->threads > 1 ? "two threads" : "one thread");
}

static void print_yaml(cns_summary *s, const cns_context *cx, const void *result)
{
    const cns_run_info *plan = &((const made_plan *)result)->plan;
    const cns_problem *p = &cx->problem;
    cns_summary_text(s, "until", p->end->text);
    cns_summary_long(s, "digits", plan->digits);
    cns_summary_long(s, "order", plan->order);
    cns_summary_long(s, "steps", lround(plan->steps));
    cns_summary_long(s, "memory_bytes", lround(plan->memory));
    cns_summary_seconds(s, "seconds", plan->seconds);
    cns_summary_long(s, "proof_digits", plan->proof_digits);
    cns_summary_number(s, "growth", plan->growth, 4);
    cns_summary_number(s, "margin", plan->margin, 3);
    cns_summary_long(s, "threads", !plan->enclosed && p->monitor->threads > 1 ? 2 : 1);
}

static const cns_view view = {.text = print_text, .yaml = print_yaml};

static int plan_to(cns_context *cx)
{
    made_plan made = {.goal = goal_of(cx->c, cx->o)};
    const double end = cns_number_get_d(cx->problem.end);
    long digits[CNS_PLAN_PARTS];
    cns_schedule schedule = {.digits = digits};
    cns_error err = {0};
    if (end / cns_number_get_d(cx->problem.every) > CNS_CASE_MAX_ROWS)
        return cns_complain(CNS_USAGE, "more than %d rows up to t = %g", CNS_CASE_MAX_ROWS, end);
    cns_code code = cns_plan(&cx->problem, &made.goal, &made.plan, &schedule, &err);
    cns_meter_clear(&cx->meter);
    if (!code && made.plan.followed < end)
        return cns_complain(CNS_NUMERIC, "no plan beyond t = %.12g: the preliminary run ends there: %s",
                            cns_program_time(cns_system_program(cx->system), made.plan.followed), err.text);
    if (!code && made.plan.digits > made.goal.max_digits)
        cns_note(cx, "more digits than max_digits (%ld) allows", made.goal.max_digits);
    return cns_report(cx, code, &err, &view, code ? NULL : &made);
}

static int run(cns_context *cx)
{
    cns_number until;
    int status = 0;
    cns_number_init(&until);
    if (cx->o->until) {
        status = parse_until(cx->c, cx->o->until, &until);
        /* Without `every` the only row is the end. */
        if (cns_number_cmp(cx->problem.every, cx->problem.end) == 0)
            cx->problem.every = &until;
        cx->problem.end = &until;
        cx->problem.at = NULL; /* rows of a list need no more than the last */
    }
    if (!status)
        status = plan_to(cx);
    cns_number_clear(&until);
    return status;
}

const cns_command cns_command_plan = {
    .name = "plan",
    .run = run,
    .opens = CNS_OPENS_SYSTEM,
    .times = CNS_TIMES_TAKEN,
    .limits = true,
    .operands = "CASE",
    .least = 1,
    .most = 1,
    .summary = "digits, order, steps, memory and time that a goal will need",
    .details =
        "The growth of noise is measured along a preliminary run in double precision with tangents, the "
        "speed of this machine on some steps. A run with `goal` makes the same plan first. The time is that "
        "of a machine with nothing else to do. CASE may have `goal`, `numerics` or neither; what is left "
        "out: the case's end and goal, or 10 decimals.\n",
    .options = CNS_TAKES(CNS_OPTION_YAML, CNS_OPTION_SET, CNS_OPTION_UNTIL_TIME, CNS_OPTION_DECIMALS,
                         CNS_OPTION_MAX_TIME, CNS_OPTION_THREADS, CNS_OPTION_QUIET),
};
