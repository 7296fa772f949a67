/* cns tc: the critical predictable time of a run by numerics. */
#include "cns/study/tc.h"

#include <stdlib.h>

#include "commands.h"
#include "core/clock.h"
#include "report.h"
#include "sweep.h"

static const char *observable_name(const cns_model *m, int i)
{
    if (i == CNS_TC_NORM)
        return "norm";
    return i <= m->n_states ? m->states[i - 1].name : m->outputs[i - 1 - m->n_states].name;
}

/* Where `laws: observable` is a state, it alone is followed; where it is the norm, so is everything else. */
static bool one_state(const cns_case *c)
{
    return c->laws.observable != CNS_OBSERVABLE_NORM;
}

/* Derived quantities are followed if the case asks for any, and named if it asks for them. */
static bool is_shown(const cns_case *c, int i)
{
    if (one_state(c))
        return i == CNS_TC_STATE(c->laws.observable);
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
static void bound_text(const cns_number *end, char *text, size_t size, double t)
{
    if (t >= cns_number_get_d(end))
        snprintf(text, size, "%.64s", end->text);
    else
        snprintf(text, size, "%.12g", t);
}

static void print_times(cns_summary *s, const cns_case *c, const cns_tc_result *r)
{
    char text[80];
    cns_summary_open_mapping(s, "times");
    for (int i = 0; i < r->n; i++) {
        const cns_tc_time *t = &r->time[i];
        if (!is_shown(c, i))
            continue;
        if (t->kind == CNS_TC_FOUND) {
            time_text(text, sizeof text, t->t);
            cns_summary_text(s, observable_name(c->model, i), text);
            continue;
        }
        cns_summary_open_mapping(s, observable_name(c->model, i));
        bound_text(&c->end, text, sizeof text, t->t);
        cns_summary_text(s, "beyond", text);
        if (t->kind == CNS_TC_STILL)
            cns_summary_text(s, "none", "the difference does not grow");
        if (t->kind == CNS_TC_IDENTICAL)
            cns_summary_text(s, "none", "the two runs are identical");
        cns_summary_shut(s);
    }
    cns_summary_shut(s);
}

static void print_text(FILE *out, const cns_context *cx, const void *result)
{
    const cns_case *c = cx->c;
    const cns_tc_result *r = result;
    char digits[32] = "double precision";
    if (c->numerics.arithmetic != CNS_ARITH_DOUBLE)
        snprintf(digits, sizeof digits, "%ld digits", c->numerics.digits);
    fprintf(out, "T_c of %s, %s, delta = %s, against %ld digits\n", c->name, digits, c->laws.delta.text,
            r->reference_digits);
    cns_print_criterion(out, c);
    for (int i = 0; i < r->n; i++) {
        const cns_tc_time *t = &r->time[i];
        char text[80];
        if (!is_shown(c, i))
            continue;
        if (t->kind == CNS_TC_FOUND) {
            time_text(text, sizeof text, t->t);
            fprintf(out, "  %-10s %s", observable_name(c->model, i), text);
            if (c->laws.criterion == CNS_TC_ROWS)
                fprintf(out, "  (first row: %.12g)", t->row);
            fputc('\n', out);
            continue;
        }
        bound_text(&c->end, text, sizeof text, t->t);
        fprintf(out, "  %-10s > %s%s\n", observable_name(c->model, i), text,
                t->kind == CNS_TC_STILL       ? "  (none: the difference does not grow)"
                : t->kind == CNS_TC_IDENTICAL ? "  (none: the two runs are identical)"
                                              : "");
    }
}

static void print_yaml(cns_summary *s, const cns_context *cx, const void *result)
{
    const cns_case *c = cx->c;
    const cns_tc_result *r = result;
    cns_summary_text(s, "delta", c->laws.delta.text);
    cns_summarise_criterion(s, c);
    if (c->numerics.arithmetic == CNS_ARITH_DOUBLE)
        cns_summary_text(s, "digits", "double");
    else
        cns_summary_long(s, "digits", c->numerics.digits);
    cns_summary_long(s, "reference_digits", r->reference_digits);
    print_times(s, c, r);
}

static const cns_view view = {.text = print_text, .yaml = print_yaml};

static cns_tc_spec spec_of(const cns_context *cx)
{
    const cns_case *c = cx->c;
    return (cns_tc_spec){.numerics = &c->numerics,
                         .delta = &c->laws.delta,
                         .criterion = c->laws.criterion,
                         .until = one_state(c) ? CNS_TC_STATE(c->laws.observable) : CNS_TC_EVERY_ONE,
                         .reference_digits = cx->o->reference_digits};
}

/* A sweep. */

static void print_swept(FILE *out, const cns_case *c, const char *value, const cns_tc_result *r)
{
    for (int i = 0; i < r->n; i++) {
        const cns_tc_time *t = &r->time[i];
        const bool is_found = t->kind == CNS_TC_FOUND;
        char text[80];
        if (!is_shown(c, i))
            continue;
        if (is_found)
            time_text(text, sizeof text, t->t);
        else
            bound_text(&c->end, text, sizeof text, t->t);
        fprintf(out, "%s,%s,%s,%s,%s\n", value, observable_name(c->model, i), is_found ? text : "",
                is_found ? "" : text,
                t->kind == CNS_TC_STILL       ? "the difference does not grow"
                : t->kind == CNS_TC_IDENTICAL ? "the two runs are identical"
                                              : "");
    }
}

static cns_code sweep_rows(void *context, const cns_system *s, const char *value, const cns_monitor *monitor,
                           FILE *const *table, cns_error *err)
{
    const cns_context *cx = context;
    const cns_tc_spec spec = spec_of(cx);
    cns_problem p = cx->problem;
    cns_tc_result r;
    p.system = s;
    p.monitor = monitor;
    cns_code code = cns_tc_measure(&p, &spec, &r, err);
    if (!code || code == CNS_UNREACHED)
        print_swept(table[0], cx->c, value, &r);
    cns_tc_result_clear(&r);
    return code;
}

static int sweep(cns_context *cx)
{
    const cns_case *c = cx->c;
    char what[256];
    snprintf(what, sizeof what, "tc, delta %s, criterion %d, observable %d, reference %ld",
             c->laws.delta.text, (int)c->laws.criterion, c->laws.observable, cx->o->reference_digits);
    char *name = cns_sweep_study_name(c, what);
    const cns_swept swept = {.study = {.name = name, .context = cx, .rows = sweep_rows},
                             .table = {{.what = "T_c of ", .columns = "observable,tc,beyond,note"}},
                             .directory = cx->o->keep};
    int status = cns_sweep_tables(cx, &swept);
    free(name);
    return status;
}

static int run(cns_context *cx)
{
    cns_case *c = cx->c;
    cns_tc_result r;
    cns_error err = {0};
    if (!c->has_numerics)
        return cns_complain_of_case(c, "%s: `cns tc` needs 'numerics', such as --set numerics.digits=16",
                                    c->has_goal ? "a 'goal' finds its own digits and is proven"
                                                : "no 'numerics'");
    if (cx->o->delta != NULL)
        cns_number_parse(&c->laws.delta, cx->o->delta, &err);
    const cns_tc_spec spec = spec_of(cx);
    if (one_state(c))
        cx->problem.n_columns = 0; /* no derived quantities */
    if (cx->o->keep != NULL && cx->o->sweep == NULL)
        return cns_complain(CNS_USAGE, "--keep is for a sweep's values: it needs --sweep");
    if (cx->o->sweep != NULL)
        return sweep(cx);
    cns_code code = cns_tc_measure(&cx->problem, &spec, &r, &err);
    int status = cns_report(cx, code, &err, &view, !code || code == CNS_UNREACHED ? &r : NULL);
    if (cx->o->verbose && !status)
        cns_note(cx, "%ld steps, reference %ld steps, up to t = %.12g, %.2f s", r.steps, r.reference_steps,
                 r.compared, cns_seconds() - cx->since);
    cns_tc_result_clear(&r);
    return status;
}

const cns_command cns_command_tc = {
    .name = "tc",
    .run = run,
    .opens = CNS_OPENS_SYSTEM,
    .times = CNS_TIMES_REFUSED,
    .operands = "CASE",
    .least = 1,
    .most = 1,
    .summary = "critical predictable time of a run by numerics",
    .details =
        "How long the run that `numerics` describes can be trusted: T_c is the first time at which it "
        "differs from a finer run by more than delta. For an observable u that is |u1 - u2| > delta times "
        "the largest |u2| up to then; for `norm`, the distance of the states that feed back, each divided "
        "by its typical size, > delta. Both hold in continuous time, and `time: every` has no part in them. "
        "With `laws: {criterion: rows}` it is the form of Xu, Li, Li and Liao: |1 - u1/u2| > delta at a row "
        "of `time: every`, refined inside the interval before that row. With `digits: K` every state is "
        "rounded to K significant decimals "
        "after every step. The finer run is a Taylor run with more digits, chosen so that its own error "
        "stays far below delta. delta is `laws: delta` of the case, unless --delta gives another. Where "
        "`laws: observable` names a state, the run ends at its T_c, and no other is printed. "
        "With --sweep the table has a row for every observable and value.\n",
    .options = CNS_TAKES(CNS_OPTION_YAML, CNS_OPTION_SET, CNS_OPTION_DELTA, CNS_OPTION_REFERENCE_DIGITS,
                         CNS_OPTION_SWEEP, CNS_OPTION_KEEP, CNS_OPTION_MAX_TIME, CNS_OPTION_THREADS,
                         CNS_OPTION_QUIET, CNS_OPTION_VERBOSE),
};
