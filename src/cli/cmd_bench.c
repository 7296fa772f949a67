/* cns bench: how fast the arithmetics are on this machine. */
#include <math.h>

#include "bench/bench.h"
#include "commands.h"
#include "core/monitor.h"
#include "report.h"

enum { DEFAULT_SECONDS = 20 };

/* For each number of digits, and each system, a stretch of time that a run in MPFR covers in about a second.
 * With 1000 digits it is one step, which takes several. */
static const struct {
    long digits;
    double until[CNS_BENCH_SYSTEMS];
} stretches[] = {{60, {2, 2, 1}}, {120, {1, 1, 0.5}}, {300, {0.3, 0.3, 0.15}}, {1000, {0.2, 0.2, 0.04}}};

static double seconds_of(const cns_options *o)
{
    return o->seconds > 0 ? o->seconds : DEFAULT_SECONDS;
}

enum { ROWS = CNS_BENCH_SYSTEMS * sizeof stretches / sizeof *stretches };

static void on_progress(void *context, double fraction, const char *what)
{
    cns_context *cx = context;
    if (cx->meter.terminal)
        cns_monitor_tell(&cx->monitor, fraction, what);
}

static bool left_out(const cns_bench_row *row)
{
    for (int e = 0; e < CNS_BENCH_ENGINES; e++)
        if (row->cells[e].runs == 0 && cns_bench_has((cns_bench_engine)e))
            return true;
    return false;
}

static double right_digits(const cns_bench_row *row)
{
    double least = HUGE_VAL;
    for (int e = 0; e < CNS_BENCH_ENGINES; e++)
        if (row->cells[e].runs > 0)
            least = fmin(least, row->cells[e].right);
    return least;
}

/* result: the rows. */
static void print_table(FILE *out, const cns_context *cx, const void *result)
{
    const cns_bench_row *rows = result;
    int skipped = 0;
    fputs("seconds of processor time per unit of integrated time, one thread; medians\n", out);
    fprintf(out, "%-14s %6s", "model", "digits");
    for (int e = 0; e < CNS_BENCH_ENGINES; e++)
        fprintf(out, e == CNS_BENCH_MPFR ? "  %10s" : "  %10s %6s",
                cns_bench_engine_name((cns_bench_engine)e), "x");
    fprintf(out, "  %5s\n", "right");
    for (const cns_bench_row *row = rows; row < rows + ROWS; row++) {
        const cns_bench_cell *mpfr = &row->cells[CNS_BENCH_MPFR];
        fprintf(out, "%-14s %6ld", cns_bench_system_name(row->system), row->digits);
        for (int e = 0; e < CNS_BENCH_ENGINES; e++) {
            const cns_bench_cell *c = &row->cells[e];
            if (c->runs > 0)
                fprintf(out, "  %10.4g", cns_bench_median(c));
            else
                fprintf(out, "  %10s", "-");
            if (e != CNS_BENCH_MPFR && c->runs > 0 && mpfr->runs > 0)
                fprintf(out, " %6.1f", cns_bench_median(mpfr) / cns_bench_median(c));
            else if (e != CNS_BENCH_MPFR)
                fprintf(out, " %6s", "-");
        }
        if (isfinite(right_digits(row)))
            fprintf(out, "  %5.0f\n", floor(right_digits(row)));
        else
            fprintf(out, "  %5s\n", "-");
        skipped += left_out(row);
    }
    if (skipped > 0)
        fprintf(out, "-: left out, %g s are too short for it (--seconds S: more)\n", seconds_of(cx->o));
}

static void print_yaml(cns_summary *s, const cns_context *cx, const void *result)
{
    const cns_bench_row *rows = result;
    (void)cx;
    cns_summary_open_list(s, "rows");
    for (const cns_bench_row *row = rows; row < rows + ROWS; row++) {
        cns_summary_open_mapping(s, NULL);
        cns_summary_text(s, "model", cns_bench_system_name(row->system));
        cns_summary_long(s, "digits", row->digits);
        cns_summary_number(s, "until", row->until, 6);
        cns_summary_open_mapping(s, "engines");
        for (int e = 0; e < CNS_BENCH_ENGINES; e++) {
            const cns_bench_cell *c = &row->cells[e];
            if (c->runs == 0)
                continue;
            cns_summary_open_mapping(s, cns_bench_engine_name((cns_bench_engine)e));
            cns_summary_number(s, "seconds_per_unit", cns_bench_median(c), 4);
            cns_summary_number(s, "steps_per_unit", c->steps, 4);
            cns_summary_long(s, "order", c->order);
            cns_summary_long(s, "runs", c->runs);
            cns_summary_number(s, "digits_right", c->right, 4);
            cns_summary_shut(s);
        }
        cns_summary_shut(s);
        cns_summary_shut(s);
    }
    cns_summary_shut(s);
}

static const cns_view view = {.text = print_table, .yaml = print_yaml, .to_file = true};

static int run(cns_context *cx)
{
    cns_bench_row rows[ROWS] = {{0}};
    cns_error err = {0};
    cns_context_watch(cx);
    for (int i = 0; i < (int)ROWS; i++) { /* few digits first: what there is no time for comes last */
        rows[i].system = (cns_bench_system)(i % CNS_BENCH_SYSTEMS);
        rows[i].digits = stretches[i / CNS_BENCH_SYSTEMS].digits;
        rows[i].until = stretches[i / CNS_BENCH_SYSTEMS].until[rows[i].system];
    }
    const cns_monitor monitor = {.stop = cx->monitor.stop, .progress = on_progress, .context = cx};
    const cns_bench_spec spec = {.seconds = seconds_of(cx->o), .runs = CNS_BENCH_RUNS, .monitor = &monitor};
    cns_code code = cns_bench_fill(&spec, rows, ROWS, &err);
    return cns_report(cx, code, &err, &view, code ? NULL : rows);
}

const cns_command cns_command_bench = {
    .name = "bench",
    .run = run,
    .operands = "",
    .least = 0,
    .most = 0,
    .summary = "measure the speed of the arithmetics on this machine",
    .details =
        "Processor time per unit of integrated time, on built-in problems at 60, 120, 300 and 1000 digits: "
        "the plain engine (MPFR) and the fast arithmetic with each kernel that the machine has. x: times as "
        "fast as the plain engine; right: digits right at the end, the least of all. What would not fit "
        "into the time is left out.\n",
    .options = CNS_TAKES(CNS_OPTION_OUTPUT_FILE, CNS_OPTION_YAML, CNS_OPTION_SECONDS, CNS_OPTION_QUIET),
};
