/* cns run: a trajectory as a table. */
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cns/arith.h"
#include "cns/solve.h"
#include "cns/summary.h"
#include "cns/table.h"
#include "commands.h"
#include "console.h"
#include "progress.h"

static volatile sig_atomic_t stop_signal; /* the one thing a signal handler can reach */

static void on_signal(int number)
{
    stop_signal = number;
}

/* The first signal ends the run at its next step, the second at once. */
static void catch_signals(void)
{
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)(SA_RESETHAND | SA_RESTART)};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    sigaction(SIGHUP, &action, NULL);
}

typedef struct run_context {
    const cns_options *o;
    const cns_case *c;
    cns_table *table; /* NULL: --yaml without -o */
    cns_meter meter;
} run_context;

static void announce(run_context *r, const cns_run_info *run)
{
    cns_meter_clear(&r->meter);
    if (r->o->quiet)
        return;
    if (run->planned)
        fprintf(stderr,
                "cns: noise will grow to 10^%.1f (margin %.1f): %ld digits, order %d, proof with %ld digits; "
                "about "
                "%.0f steps, %.1f s\n",
                run->growth, run->margin, run->digits, run->order, run->proof_digits, run->steps,
                run->seconds);
    else if (run->attempt > 1)
        fprintf(stderr, "cns: not enough: again with %ld digits, order %d\n", run->digits, run->order);
    else if (r->o->verbose)
        fprintf(stderr, "cns: %ld digits (%ld bits), order %d\n", run->digits, (long)run->prec, run->order);
}

static cns_code on_begin(void *context, const cns_run_info *run, cns_error *err)
{
    run_context *r = context;
    announce(r, run);
    return r->table ? cns_table_begin(r->table, run, err) : CNS_OK;
}

static cns_code on_row(void *context, const cns_row *row, cns_error *err)
{
    run_context *r = context;
    return r->table ? cns_table_row(r->table, row, err) : CNS_OK;
}

static void on_progress(void *context, const cns_progress *p)
{
    run_context *r = context;
    char what[128];
    snprintf(what, sizeof what, "t = %g of %g, %ld digits", p->t, p->end, p->run->digits);
    cns_meter_show(&r->meter, p->t / p->end, p->seconds, what);
}

static int print_summary(const cns_result *result, const cns_case *c)
{
    cns_page page;
    char end[64];
    cns_code code = cns_page_open(&page);
    if (code)
        return (int)code;
    cns_summary *s = cns_summary_open(page.file);
    snprintf(end, sizeof end, "%.17g", result->end);
    cns_summary_text(s, "end", result->complete ? c->end.text : end);
    if (result->decimals >= 0)
        cns_summary_long(s, "decimals", result->decimals);
    cns_summary_long(s, "digits", result->run.digits);
    cns_summary_long(s, "order", result->run.order);
    cns_summary_long(s, "steps", result->steps);
    cns_summary_long(s, "events", result->events);
    cns_summary_text(s, "kernel", result->run.kernel);
    cns_summary_seconds(s, "wall_s", result->wall_s);
    bool written = cns_summary_close(s) != 0;
    int status = cns_page_print(&page);
    return status ? status : written ? 0 : cns_complain(CNS_IO, "cannot write the summary");
}

static cns_code solve(const cns_case *c, const cns_options *o, const cns_sink *sink, cns_result *result,
                      cns_error *err)
{
    cns_program_options options = {.smooth = c->smooth ? &c->eps : NULL};
    cns_program *program;
    *result = (cns_result){.decimals = -1};
    cns_code code = cns_model_program(c->model, c->parameters, &options, &program, err);
    if (code)
        return code;
    double *scales = malloc((size_t)c->model->n_states * sizeof *scales);
    if (!scales) {
        cns_program_free(program);
        return cns_fail(err, CNS_NUMERIC, "out of memory");
    }
    for (int i = 0; i < c->model->n_states; i++)
        scales[i] = c->model->states[i].scale;
    cns_problem problem = {.program = program,
                           .scales = scales,
                           .initial = c->initial,
                           .end = &c->end,
                           .every = &c->every,
                           .columns = c->columns,
                           .n_columns = c->n_columns,
                           .threads = o->threads > 0 ? o->threads : (int)sysconf(_SC_NPROCESSORS_ONLN),
                           .stop = &stop_signal,
                           .sink = sink};
    code = c->has_goal ? cns_solve_goal(&problem, &c->goal, result, err)
                       : cns_solve_numerics(&problem, &c->numerics, o->prove, result, err);
    free(scales);
    cns_program_free(program);
    return code;
}

int cns_cmd_run(const cns_options *o)
{
    cns_case *c;
    cns_error err = {0}, io = {0};
    cns_result result;
    int status = (int)cns_open_case(o, &c);
    if (status)
        return status;
    if (!c->has_goal && !c->has_numerics) {
        fprintf(stderr, "%s:1:1: neither 'goal' nor 'numerics': `cns run` needs one of them\n", c->name);
        cns_case_free(c);
        return CNS_USAGE;
    }
    const char *kernel; /* a wrong CNS_KERNEL is a usage error before anything is opened */
    if (cns_fast_kernel_name(&kernel, &err)) {
        cns_case_free(c);
        return cns_complain(err.code, "%s", err.text);
    }
    run_context r = {.o = o, .c = c};
    if (!o->yaml || o->output) {
        r.table = cns_table_open(o->output, c, &err);
        if (!r.table) {
            cns_case_free(c);
            return cns_complain(err.code, "%s", err.text);
        }
    }
    catch_signals();
    cns_meter_init(&r.meter, o->quiet);
    cns_sink sink = {.context = &r, .begin = on_begin, .row = on_row, .progress = on_progress};
    cns_code code = solve(c, o, &sink, &result, &err);
    cns_meter_clear(&r.meter);

    bool gone = r.table && cns_table_reader_gone(r.table);
    status = gone ? CNS_STOPPED + SIGPIPE : code == CNS_STOPPED ? CNS_STOPPED + (int)stop_signal : (int)code;
    if (code && !gone && code != CNS_STOPPED)
        cns_complain(code, "%s", err.text);
    if (r.table && (gone || code == CNS_IO)) {
        cns_table_abandon(r.table);
    } else if (r.table) {
        code = cns_table_close(r.table, !code || result.complete ? NULL : err.text, &io);
        if (code == CNS_STOPPED)
            status = CNS_STOPPED + SIGPIPE;
        else if (code)
            status = cns_complain(code, "%s", io.text);
    }
    if (o->yaml && (status == CNS_OK || status == CNS_UNREACHED)) {
        int printed = print_summary(&result, c);
        status = printed ? printed : status;
    }
    if (o->verbose && !status)
        fprintf(stderr, "cns: %ld steps, %ld events, %.2f s\n", result.steps, result.events, result.wall_s);
    cns_case_free(c);
    return status;
}
