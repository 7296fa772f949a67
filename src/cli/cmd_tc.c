/* cns tc: the critical predictable time of a run by numerics. */
#include <string.h>

#include "cns/study/tc.h"
#include "commands.h"
#include "context.h"
#include "core/clock.h"
#include "delta.h"
#include "integrate/trajectory.h"
#include "io/summary.h"
#include "report.h"

typedef struct tc_context {
    cns_context cx;
    const cns_number *delta;
    bool outputs;
    cns_tc_result result;
} tc_context;

static void on_progress(void *context, double fraction)
{
    const tc_context *tc = context;
    cns_study_progress(&tc->cx.study, fraction, "the run under test and its reference");
}

static const char *observable_name(const tc_context *tc, int i)
{
    const cns_model *m = tc->cx.c->model;
    if (i == CNS_TC_NORM)
        return "norm";
    return i <= m->n_states ? m->states[i - 1].name : m->outputs[i - 1 - m->n_states].name;
}

/* Derived quantities are followed if the case asks for any, and named if it asks for them. */
static bool is_shown(const tc_context *tc, int i)
{
    const cns_case *c = tc->cx.c;
    bool shown = i <= c->model->n_states;
    for (int k = 0; k < c->n_columns && !shown; k++)
        shown = c->columns[k].kind == CNS_COLUMN_OUTPUT && c->columns[k].index == i - 1 - c->model->n_states;
    return shown;
}

static void time_text(char *text, size_t size, double t)
{
    snprintf(text, size, "%.6f", t);
}

/* The bound of an observable without a T_c: the end as the case gives it, or the last row compared. */
static void bound_text(const tc_context *tc, char *text, size_t size, double t)
{
    const cns_number *end = &tc->cx.c->end;
    if (t >= cns_number_get_d(end))
        snprintf(text, size, "%.64s", end->text);
    else
        snprintf(text, size, "%.12g", t);
}

static void print_times(const tc_context *tc, cns_summary *s)
{
    char text[80];
    cns_summary_open_mapping(s, "times");
    for (int i = 0; i < tc->result.n; i++) {
        const cns_tc_time *t = &tc->result.time[i];
        if (!is_shown(tc, i))
            continue;
        if (t->kind == CNS_TC_FOUND) {
            time_text(text, sizeof text, t->t);
            cns_summary_text(s, observable_name(tc, i), text);
            continue;
        }
        cns_summary_open_mapping(s, observable_name(tc, i));
        bound_text(tc, text, sizeof text, t->t);
        cns_summary_text(s, "beyond", text);
        if (t->kind == CNS_TC_STILL)
            cns_summary_text(s, "none", "the difference does not grow");
        if (t->kind == CNS_TC_IDENTICAL)
            cns_summary_text(s, "none", "the two runs are identical");
        cns_summary_shut(s);
    }
    cns_summary_shut(s);
}

static void print_table(const tc_context *tc, FILE *out)
{
    const cns_case *c = tc->cx.c;
    char digits[32] = "double precision";
    if (c->numerics.arithmetic != CNS_ARITH_DOUBLE)
        snprintf(digits, sizeof digits, "%ld digits", c->numerics.digits);
    fprintf(out, "T_c of %s, %s, delta = %s, against %ld digits\n", c->name, digits, tc->delta->text,
            tc->result.reference_digits);
    for (int i = 0; i < tc->result.n; i++) {
        const cns_tc_time *t = &tc->result.time[i];
        char text[80];
        if (!is_shown(tc, i))
            continue;
        if (t->kind == CNS_TC_FOUND) {
            time_text(text, sizeof text, t->t);
            fprintf(out, "  %-10s %s  (first row: %.12g)\n", observable_name(tc, i), text, t->row);
            continue;
        }
        bound_text(tc, text, sizeof text, t->t);
        fprintf(out, "  %-10s > %s%s\n", observable_name(tc, i), text,
                t->kind == CNS_TC_STILL       ? "  (none: the difference does not grow)"
                : t->kind == CNS_TC_IDENTICAL ? "  (none: the two runs are identical)"
                                              : "");
    }
}

static int print(const tc_context *tc)
{
    cns_page page;
    bool written = true;
    cns_code code = cns_page_open(&page);
    if (code)
        return (int)code;
    if (tc->cx.o->yaml) {
        const cns_numerics *n = &tc->cx.c->numerics;
        cns_summary *s = cns_summary_open(page.file);
        cns_summary_text(s, "delta", tc->delta->text);
        if (n->arithmetic == CNS_ARITH_DOUBLE)
            cns_summary_text(s, "digits", "double");
        else
            cns_summary_long(s, "digits", n->digits);
        cns_summary_long(s, "reference_digits", tc->result.reference_digits);
        print_times(tc, s);
        written = cns_summary_close(s) != 0;
    } else {
        print_table(tc, page.file);
    }
    int status = cns_page_print(&page);
    return status ? status : written ? 0 : cns_complain(CNS_IO, "cannot write the summary");
}

static int refuse(const cns_case *c)
{
    fprintf(stderr, "%s:1:1: %s: `cns tc` needs 'numerics', such as {digits: 16}\n", c->name,
            c->has_goal ? "a 'goal' finds its own digits and is proven" : "no 'numerics'");
    return CNS_USAGE;
}

static int run(const cns_options *o)
{
    tc_context tc = {0};
    cns_error err = {0};
    cns_number delta;
    int status = cns_delta_read(o, &delta);
    if (status)
        return status;
    status = cns_context_open(o, &tc.cx);
    if (status) {
        cns_number_clear(&delta);
        return status;
    }
    const cns_case *c = tc.cx.c;
    if (!c->has_numerics) {
        status = refuse(c);
        cns_context_close(&tc.cx);
        cns_number_clear(&delta);
        return status;
    }
    tc.delta = &delta;
    for (int i = 0; i < c->n_columns; i++)
        tc.outputs = tc.outputs || c->columns[i].kind == CNS_COLUMN_OUTPUT;
    const cns_tc_request request = {.numerics = &c->numerics,
                                    .program = tc.cx.program,
                                    .truth = tc.cx.program,
                                    .delta = &delta,
                                    .until = CNS_TC_EVERY_ONE,
                                    .outputs = tc.outputs,
                                    .reference_digits = o->reference_digits,
                                    .progress = on_progress,
                                    .context = &tc};
    cns_code code = cns_tc_measure(&tc.cx.study, &request, &tc.result, &err);
    status = cns_context_status(&tc.cx, code, &err);
    if (!code || code == CNS_UNREACHED) {
        int printed = print(&tc);
        status = printed ? printed : status;
    }
    if (o->verbose && !status)
        fprintf(stderr, "cns: %ld steps, reference %ld steps, up to t = %.12g, %.2f s\n", tc.result.steps,
                tc.result.reference_steps, tc.result.compared, cns_seconds() - tc.cx.since);
    cns_tc_result_clear(&tc.result);
    cns_context_close(&tc.cx);
    cns_number_clear(&delta);
    return status;
}

const cns_command cns_command_tc = {
    .name = "tc",
    .run = run,
    .operands = "CASE",
    .least = 1,
    .most = 1,
    .summary = "critical predictable time of a run by numerics",
    .details =
        "How long the run that `numerics` describes can be trusted: the first row at which it differs\n"
        "from a finer run by more than delta, refined inside the interval before that row. For an\n"
        "observable u that is |1 - u1/u2| > delta; for `norm`, the distance of the states that feed\n"
        "back, each divided by its typical size, > delta. With `digits: K` every state is rounded to K\n"
        "significant decimals after every step. The finer run is a Taylor run with more digits, chosen\n"
        "so that its own error stays far below delta.\n",
    .options = CNS_TAKES(CNS_OPTION_YAML, CNS_OPTION_SET, CNS_OPTION_DELTA, CNS_OPTION_REFERENCE_DIGITS,
                         CNS_OPTION_THREADS, CNS_OPTION_QUIET, CNS_OPTION_VERBOSE),
};
