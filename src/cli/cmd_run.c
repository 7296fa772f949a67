/* cns run: a trajectory as a table. */
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

#include "cns/solve.h"
#include "commands.h"
#include "core/clock.h"
#include "event_table.h"
#include "io/write_table.h"
#include "report.h"
#include "signals.h"
#include "sweep.h"

typedef struct run_context {
    cns_context *cx;
    cns_table *table;       /* NULL: --yaml without -o */
    cns_event_table events; /* without --events empty */
} run_context;

static void announce(cns_context *cx, const cns_run_info *run)
{
    if (run->planned && run->enclosed)
        cns_note(
            cx,
            "noise will grow to 10^%.1f (margin %.1f): %ld digits, order %d, with an enclosure; about %.0f "
            "steps, %.1f s",
            run->growth, run->margin, run->digits, run->order, run->steps, run->seconds);
    else if (run->attempt > 1 && run->why_not[0] != '\0' && !run->enclosed)
        cns_note(cx, "%s; from here on by two runs, of %ld digits and %ld", run->why_not, run->digits,
                 run->proof_digits);
    else if (run->planned)
        cns_note(
            cx,
            "noise will grow to 10^%.1f (margin %.1f): %ld digits, order %d, proof with %ld digits; about "
            "%.0f steps, %.1f s",
            run->growth, run->margin, run->digits, run->order, run->proof_digits, run->steps, run->seconds);
    else if (run->attempt > 1)
        cns_note(cx, "not enough: again with %ld digits, order %d", run->digits, run->order);
    else if (cx->o->verbose)
        cns_note(cx, "%ld digits (%ld bits), order %d", run->digits, (long)run->prec, run->order);
    if (run->planned && run->followed < cns_number_get_d(cx->problem.end))
        cns_note(cx, "the preliminary run in double precision ends at t = %.12g: nothing is predicted beyond",
                 cns_program_time(cns_system_program(cx->system), run->followed));
    if (!run->planned && run->attempt == 1 && run->steps > 0)
        cns_note(cx, "about %.*g steps, %.*f s", run->steps < 1e7 ? 7 : 2, round(run->steps),
                 run->seconds < 10 ? 1 : 0, run->seconds);
}

static cns_code on_begin(void *context, const cns_run_info *run, cns_error *err)
{
    run_context *r = context;
    r->cx->since = cns_seconds(); /* progress is that of this attempt */
    announce(r->cx, run);
    if (r->events.n > 0)
        cns_event_table_begin(&r->events, run);
    return r->table ? cns_table_begin(r->table, run, err) : CNS_OK;
}

static cns_code on_row(void *context, const cns_row *row, cns_error *err)
{
    run_context *r = context;
    cns_meter_make_way(&r->cx->meter);
    return r->table ? cns_table_row(r->table, row, err) : CNS_OK;
}

static cns_code on_event(void *context, const cns_event *event, cns_error *err)
{
    run_context *r = context;
    (void)err;
    cns_event_table_add(&r->events, event);
    return CNS_OK;
}

static void print_yaml(cns_summary *s, const cns_context *cx, const void *found)
{
    const cns_result *result = found;
    char end[64];
    snprintf(end, sizeof end, "%.15g", result->end); /* 0.1, not 0.10000000000000001 */
    cns_summary_text(s, "end", result->complete ? cx->c->end.text : end);
    if (result->decimals >= 0)
        cns_summary_long(s, "decimals", result->decimals);
    cns_summary_long(s, "digits", result->run.digits);
    cns_summary_long(s, "order", result->run.order);
    cns_summary_long(s, "steps", result->steps);
    cns_summary_long(s, "landings", result->landings);
    cns_summary_long(s, "events", result->landings); /* its older name, until version 0.2 */
    if (result->run.kernel != NULL)                  /* a run was begun, not only planned */
        cns_summary_text(s, "kernel", result->run.kernel);
    cns_summary_seconds(s, "wall_s", result->wall_s);
}

/* Of the YAML alone: the table is written row by row. */
static const cns_view summary = {.yaml = print_yaml};

static int open_outputs(run_context *r)
{
    const cns_options *o = r->cx->o;
    cns_error err = {0};
    if (o->events == NULL && o->sections.n > 0)
        return cns_complain(CNS_USAGE, "--section names an event for --events FILE, which is missing");
    int status = o->events != NULL ? cns_event_table_open(&r->events, r->cx) : 0;
    if (!status && (!o->yaml || o->output)) {
        r->table = cns_table_open(o->output, stdout, r->cx->c, &err);
        if (!r->table)
            status = cns_complain(err.code, "%s", err.text);
    }
    return status;
}

/* Where a run ended by itself or was stopped, for the last line of its tables. */
static const char *reason_of(char *text, size_t size, const cns_result *result, cns_code code,
                             const cns_error *err)
{
    if (!code || result->complete)
        return NULL;
    if (code != CNS_STOPPED)
        return err->text;
    if (result->rows > 0)
        snprintf(text, size, "%s at t = %.12g", cns_signal_text(), result->end);
    else
        snprintf(text, size, "%s before the first row", cns_signal_text());
    return text;
}

/* Says of a run that ended too early what there is of its table. by: the signal that stopped it, and where;
 * NULL: it ended by itself, and the message is out. kept: the file with the rows; NULL: there is none. */
static void tell_kept(cns_context *cx, const char *by, const char *kept, bool any_rows)
{
    const char *asked = cx->o->output;
    const bool elsewhere = kept != NULL && strcmp(asked, kept) != 0;
    char what[1024];
    if (kept != NULL)
        snprintf(what, sizeof what, "the rows up to there are in %.300s%s%.300s%s", kept,
                 elsewhere ? ": " : "", elsewhere ? asked : "",
                 elsewhere ? " is something else than a stopped table, and stays" : "");
    else if (asked != NULL)
        snprintf(what, sizeof what, "nothing is written to %.300s", asked);
    else
        snprintf(what, sizeof what,
                 any_rows && !cx->o->yaml ? "the rows up to there are printed" : "nothing is kept");
    if (by != NULL && cns_signal_status() == CNS_UNREACHED)
        cns_complain(CNS_OK, "stopped by %s; %s; the same command begins anew", by, what);
    else if (by != NULL)
        cns_note(cx, "stopped by %s; %s; the same command begins anew", by, what);
    /* Rows that are not where they will be looked for: that is part of the message. */
    if (elsewhere && (by == NULL || cx->o->quiet))
        cns_complain(CNS_OK, "%s", what);
}

/* Ends the tables of a run that answered `code`, and tells what it was. An exit status. */
static int close_outputs(run_context *r, const cns_result *result, cns_code code, const cns_error *err)
{
    cns_context *cx = r->cx;
    cns_error io = {0};
    char text[128], *kept = NULL;
    const char *reason = reason_of(text, sizeof text, result, code, err);
    const bool gone = r->table && cns_table_reader_gone(r->table), abandoned = gone || code == CNS_IO,
               stopped = code == CNS_STOPPED && !gone;
    cns_meter_clear(&cx->meter);
    int status = gone      ? CNS_STOPPED + SIGPIPE
                 : stopped ? cns_signal_status()
                 : code    ? cns_complain(code, "%s", err->text)
                           : 0;
    code = CNS_OK;
    if (r->table && abandoned)
        cns_table_abandon(r->table);
    else if (r->table)
        code = cns_table_close(r->table, reason, &kept, &io);
    if (code)
        status = code == CNS_STOPPED ? CNS_STOPPED + SIGPIPE : cns_complain(code, "%s", io.text);
    else if (reason != NULL && !abandoned)
        tell_kept(cx, stopped ? text : NULL, kept, result->rows > 0);
    free(kept);
    if (r->events.n > 0 && !abandoned) {
        int written = cns_event_table_write(&r->events, result->complete,
                                            result->events_end.code ? result->events_end.text : reason);
        status = written ? written : status;
    }
    return status;
}

static int compute(run_context *r)
{
    cns_context *cx = r->cx;
    const cns_options *o = cx->o;
    const cns_case *c = cx->c;
    const cns_sink sink = {.context = r, .begin = on_begin, .row = on_row, .event = on_event};
    cns_error err = {0};
    cns_result result = {.decimals = -1};
    cx->problem.sink = &sink;
    cx->problem.conditions = r->events.condition;
    cx->problem.n_conditions = r->events.n;
    cns_code code = c->has_goal ? cns_solve_goal(&cx->problem, &c->goal, &result, &err)
                                : cns_solve_numerics(&cx->problem, &c->numerics, o->prove, &result, &err);
    int status = close_outputs(r, &result, code, &err);
    if (o->yaml && (status == CNS_OK || status == CNS_UNREACHED)) {
        int shown = cns_show(cx, &summary, &result);
        status = shown ? shown : status;
    }
    if (o->verbose && !status)
        cns_note(cx, "%ld steps, %ld landings, %.2f s", result.steps, result.landings, result.wall_s);
    return status;
}

/* A sweep. */

typedef struct swept_run {
    const cns_context *cx;
    const char *value;
    FILE *out;
} swept_run;

static cns_code print_row(void *context, const cns_row *row, cns_error *err)
{
    const swept_run *r = context;
    (void)err;
    fprintf(r->out, "%s,", r->value);
    cns_table_print_row(r->out, r->cx->c, row);
    return CNS_OK;
}

static cns_code sweep_rows(void *context, const cns_system *s, const char *value, const cns_monitor *monitor,
                           FILE *const *table, cns_error *err)
{
    const cns_context *cx = context;
    swept_run r = {cx, value, table[0]};
    const cns_sink sink = {.context = &r, .row = print_row};
    cns_problem p = cx->problem;
    cns_result result = {.decimals = -1};
    p.system = s;
    p.monitor = monitor;
    p.sink = &sink;
    return cx->c->has_goal ? cns_solve_goal(&p, &cx->c->goal, &result, err)
                           : cns_solve_numerics(&p, &cx->c->numerics, cx->o->prove, &result, err);
}

static int sweep(cns_context *cx)
{
    const cns_case *c = cx->c;
    if (cx->o->events != NULL || cx->o->sections.n > 0)
        return cns_complain(CNS_USAGE, "--events does not go with --sweep");
    char *name = cns_sweep_study_name(c, cx->o->prove ? "run, proven" : "run");
    cns_text_stream columns;
    cns_error err;
    cns_text_open(&columns);
    cns_table_print_names(columns.file, c);
    char *names = cns_text_close(&columns, &err);
    const cns_swept swept = {.study = {.name = name, .context = cx, .rows = sweep_rows},
                             .table = {{.what = "trajectories of ",
                                        .note = c->has_goal || cx->o->prove ? NULL : "UNPROVEN",
                                        .columns = names,
                                        .path = cx->o->output}},
                             .directory = cx->o->keep};
    int status = names != NULL ? cns_sweep_tables(cx, &swept) : cns_complain(err.code, "%s", err.text);
    free(names);
    free(name);
    return status;
}

static int run(cns_context *cx)
{
    const cns_case *c = cx->c;
    run_context r = {.cx = cx};
    if (!c->has_goal && !c->has_numerics)
        return cns_complain_of_case(
            c, "neither 'goal' nor 'numerics': `cns run` needs one of them, such as --set "
               "goal.decimals=10");
    if (cx->o->keep != NULL && cx->o->sweep == NULL)
        return cns_complain(CNS_USAGE, "--keep is for a sweep's values: it needs --sweep");
    if (cx->o->sweep != NULL)
        return sweep(cx);
    int status = open_outputs(&r);
    if (!status)
        status = compute(&r);
    cns_event_table_close(&r.events);
    return status;
}

const cns_command cns_command_run = {
    .name = "run",
    .run = run,
    .opens = CNS_OPENS_SYSTEM,
    .times = CNS_TIMES_TAKEN,
    .limits = true,
    .operands = "CASE",
    .least = 1,
    .most = 1,
    .summary = "compute a trajectory and print it as a table",
    .details =
        "CASE is a case file, or - for standard input; `cns help case` lists its keys.\n"
        "With `goal` the program finds digits, order and steps by itself and proves every decimal it prints. "
        "With `numerics` it computes as told; --prove bounds the error of a Taylor run, or adds a second, "
        "finer run "
        "to another, and prints the decimals that are right.\n"
        "--events writes a second table, when the first has ended: the moments at which the angle is a "
        "multiple of half a turn and its rate is zero (APW: theta = k pi, omega = 0), and those of "
        "--section, with the states there; proven like the rows. A section is "
        "STATE=VALUE, STATE=VALUE mod PERIOD, or STATE=extremum. `direction` is the sign of the change (at "
        "a maximum -1), 0 where the state only touches. Nothing at the start counts. For the events alone: "
        "-o /dev/null.\n"
        "With --sweep the table has the rows of many trajectories, one behind the other, and the value of "
        "each "
        "in the first column.\n",
    .options = CNS_TAKES(CNS_OPTION_OUTPUT_FILE, CNS_OPTION_YAML, CNS_OPTION_SET, CNS_OPTION_PROVE,
                         CNS_OPTION_EVENTS, CNS_OPTION_SECTION, CNS_OPTION_SWEEP, CNS_OPTION_KEEP,
                         CNS_OPTION_MAX_TIME, CNS_OPTION_THREADS, CNS_OPTION_QUIET, CNS_OPTION_VERBOSE),
};
