/* cns lyapunov: the largest exponents, with their errors. */
#include "cns/study/lyapunov.h"

#include <math.h>
#include <stdlib.h>

#include "commands.h"
#include "core/clock.h"
#include "io/provenance.h"
#include "report.h"
#include "sweep.h"

enum { MOST_DECIMALS = 9 };

/* A figure and its error to the same decimals, two significant ones of the error. */
static int decimals_for(double se)
{
    int decimals = 1;
    for (double unit = 0.1; decimals < MOST_DECIMALS && se < 9.95 * unit; unit /= 10)
        decimals++;
    return decimals;
}

/* A figure as text, and its error, which is never printed as nothing. */
typedef struct figure {
    char value[32], error[32];
} figure;

static figure figure_of(double value, double se, int decimals)
{
    figure f;
    const double unit = pow(10, -decimals);
    snprintf(f.value, sizeof f.value, "%.*f", decimals, fabs(value) < 0.5 * unit ? 0 : value);
    snprintf(f.error, sizeof f.error, "%.*f", decimals, fmax(se, unit));
    return f;
}

static void print_arithmetic(FILE *out, const cns_lyapunov_spec *spec, int order)
{
    if (spec->arithmetic == CNS_ARITH_DOUBLE)
        fprintf(out, "double (53 bits)");
    else
        fprintf(out, "%s, %ld digits (%ld bits)", spec->arithmetic == CNS_ARITH_FAST ? "fast" : "mpfr",
                spec->digits, (long)cns_digits_to_bits(spec->digits));
    fprintf(out, ", Taylor series of order %d, states and tangent alike", order);
}

static bool has_figure(const cns_lyapunov_result *r)
{
    return r->note[0] == '\0';
}

/* "lambda" of the only one, "lambda2" of more. */
static const char *with_number(char *text, size_t size, const char *name, const cns_lyapunov_result *r, int i)
{
    snprintf(text, size, r->n > 1 ? "%s%d" : "%s", name, i + 1);
    return text;
}

static void print_rows(FILE *out, const cns_lyapunov_result *r)
{
    char name[32];
    fprintf(out, "t");
    for (int i = 0; i < r->n; i++) {
        fprintf(out, ",%s", with_number(name, sizeof name, has_figure(r) ? "lambda" : "rate", r, i));
        if (has_figure(r))
            fprintf(out, ",%s", with_number(name, sizeof name, "se", r, i));
    }
    for (int k = 0; k < CNS_LYAPUNOV_ROWS; k++) {
        fprintf(out, "\n%.9g", r->t[k]);
        for (int i = 0; i < r->n; i++) {
            const cns_exponent *e = &r->exponent[i];
            const figure f = figure_of(e->row[k].lambda, e->row[k].se, decimals_for(e->se));
            if (has_figure(r))
                fprintf(out, ",%s,%s", f.value, f.error);
            else
                fprintf(out, ",%.4g", e->row[k].lambda);
        }
    }
    fputc('\n', out);
}

static void print_figures(FILE *out, const char *time, const cns_lyapunov_result *r)
{
    char name[32];
    figure f;
    for (int i = 0; i < r->n; i++) {
        const cns_exponent *e = &r->exponent[i];
        fprintf(out, "# standard error%s by the number of batches, and their length:",
                r->n > 1 ? with_number(name, sizeof name, " of lambda", r, i) : "");
        for (int b = 0; b < CNS_LYAPUNOV_COUNTS; b++) {
            f = figure_of(0, e->batch_se[b], decimals_for(e->se));
            fprintf(out, "%s %d (%g): %s", b > 0 ? "," : "", r->batches[b], r->time / r->batches[b], f.error);
        }
        fputc('\n', out);
    }
    for (int i = 0; i < r->n; i++) {
        const cns_exponent *e = &r->exponent[i];
        f = figure_of(e->lambda, e->se, decimals_for(e->se));
        fprintf(out, "# %s = %s +- %s over T = %s\n", with_number(name, sizeof name, "lambda", r, i), f.value,
                f.error, time);
    }
    if (r->n > 1 && isfinite(r->dimension)) {
        f = figure_of(r->dimension, r->dimension_se, decimals_for(r->dimension_se));
        if (r->dimension_se > 0)
            fprintf(out, "# Kaplan-Yorke dimension = %s +- %s\n", f.value, f.error);
        else
            fprintf(out, "# Kaplan-Yorke dimension = %g, by the signs of the exponents\n", r->dimension);
    }
    if (isfinite(r->sum)) {
        fprintf(out, "# sum of the exponents = %s", figure_of(r->sum, 0, MOST_DECIMALS).value);
        fprintf(out, ", mean trace of the Jacobian = %s", figure_of(r->trace, 0, MOST_DECIMALS).value);
        if (r->exact_trace != NULL)
            fprintf(out, ", %s everywhere", r->exact_trace);
        fputc('\n', out);
    }
}

/* T: as it was given, or in `text` what is left of it. */
static const char *time_text(char *text, size_t size, const cns_context *cx, const cns_lyapunov_result *r)
{
    snprintf(text, size, "%.9g", r->time);
    return r->changes > 0 && has_figure(r) ? text : cx->c->lyapunov.time.text;
}

static void print_table(FILE *out, const cns_context *cx, const void *result)
{
    const cns_lyapunov_result *r = result;
    const cns_lyapunov_spec *spec = &cx->c->lyapunov;
    char name[32], time[32];
    cns_provenance_begin(
        out, cx->c, r->n > 1 ? "Lyapunov exponents: " : "largest Lyapunov exponent: ", CNS_PROVENANCE_CASE);
    fprintf(out, "# arithmetic: ");
    print_arithmetic(out, spec, r->order);
    fprintf(out, "\n# transient left out: t < %g\n", r->discarded);
    for (int i = 0; i < r->changes; i++) {
        const cns_lyapunov_change *c = &r->change[i];
        fprintf(out, "# the rate of %s changes at t about %.3g, from %.4g to %.4g\n",
                with_number(name, sizeof name, "lambda", r, c->exponent), c->t, c->before, c->after);
    }
    if (has_figure(r))
        fprintf(out,
                "# a mean over the attractor: at a fixed precision the trajectory is shadowed at best, not "
                "followed\n");
    else
        fprintf(out, "# no figure: %s\n# rates from row to row\n", r->note);
    if (r->attractors != NULL)
        fprintf(out, "# chaos up to t = %.6g may end later: fixed points attract as well: %s\n",
                r->discarded + r->time, r->attractors);
    print_rows(out, r);
    if (has_figure(r))
        print_figures(out, time_text(time, sizeof time, cx, r), r);
    cns_provenance_end(out, NULL);
}

/* Both values of a figure, in a mapping; null where there is none. */
static void add_figure(cns_summary *s, const char *name, const char *error_name, double value, double se)
{
    const figure f = figure_of(value, se, decimals_for(se));
    if (isfinite(value))
        cns_summary_text(s, name, f.value);
    else
        cns_summary_number(s, name, NAN, 1);
    if (isfinite(value))
        cns_summary_text(s, error_name, f.error);
    else
        cns_summary_number(s, error_name, NAN, 1);
}

static void add_changes(cns_summary *s, const cns_lyapunov_result *r)
{
    cns_summary_open_list(s, "changes");
    for (int i = 0; i < r->changes; i++) {
        cns_summary_open_mapping(s, NULL);
        cns_summary_long(s, "exponent", r->change[i].exponent + 1);
        cns_summary_number(s, "t", r->change[i].t, 3);
        cns_summary_number(s, "before", r->change[i].before, 4);
        cns_summary_number(s, "after", r->change[i].after, 4);
        cns_summary_shut(s);
    }
    cns_summary_shut(s);
}

static void add_spectrum(cns_summary *s, const cns_lyapunov_result *r)
{
    cns_summary_open_list(s, "exponents");
    for (int i = 0; i < r->n; i++) {
        cns_summary_open_mapping(s, NULL);
        add_figure(s, "lambda", "se", r->exponent[i].lambda, r->exponent[i].se);
        cns_summary_shut(s);
    }
    cns_summary_shut(s);
    if (r->n > 1 && isfinite(r->dimension) && r->dimension_se == 0)
        cns_summary_number(s, "dimension", r->dimension, 9);
    else if (r->n > 1 && isfinite(r->dimension))
        add_figure(s, "dimension", "dimension_se", r->dimension, r->dimension_se);
    if (isfinite(r->sum)) {
        cns_summary_text(s, "sum", figure_of(r->sum, 0, MOST_DECIMALS).value);
        cns_summary_text(s, "trace", figure_of(r->trace, 0, MOST_DECIMALS).value);
    }
    if (r->exact_trace != NULL)
        cns_summary_text(s, "exact_trace", r->exact_trace);
}

static void print_yaml(cns_summary *s, const cns_context *cx, const void *result)
{
    const cns_lyapunov_result *r = result;
    char time[32];
    add_figure(s, "lambda", "lambda_se", r->exponent[0].lambda, r->exponent[0].se);
    cns_summary_text(s, "time", time_text(time, sizeof time, cx, r));
    cns_summary_number(s, "discarded", r->discarded, 9);
    if (r->changes > 0)
        add_changes(s, r);
    cns_summary_long(s, "order", r->order);
    cns_summary_long(s, "steps", r->steps);
    cns_summary_long(s, "landings", r->landings);
    cns_summary_long(s, "events", r->landings); /* its older name, until version 0.2 */
    cns_summary_open_list(s, "batches");
    for (int b = 0; b < CNS_LYAPUNOV_COUNTS; b++) {
        cns_summary_open_mapping(s, NULL);
        cns_summary_long(s, "count", r->batches[b]);
        cns_summary_number(s, "length", r->time / r->batches[b], 9);
        cns_summary_number(s, "se", r->exponent[0].batch_se[b], 3);
        cns_summary_shut(s);
    }
    cns_summary_shut(s);
    add_spectrum(s, r);
    if (r->attractors != NULL)
        cns_summary_text(s, "attracting_points", r->attractors);
    if (!has_figure(r))
        cns_summary_text(s, "note", r->note);
}

/* A sweep. */

static void print_swept(FILE *out, const char *value, const cns_lyapunov_result *r)
{
    fputs(value, out);
    for (int i = 0; i < r->n; i++) {
        const cns_exponent *e = &r->exponent[i];
        const figure f = figure_of(e->lambda, e->se, decimals_for(e->se));
        fprintf(out, ",%s,%s", has_figure(r) ? f.value : "", has_figure(r) ? f.error : "");
    }
    if (r->n > 1) {
        const figure f = figure_of(r->dimension, r->dimension_se, decimals_for(r->dimension_se));
        const bool there = has_figure(r) && isfinite(r->dimension);
        fprintf(out, ",%s,%s", there ? f.value : "", there ? f.error : "");
    }
    fprintf(out, ",%.9g,%.9g,", r->discarded, r->time);
    char note[sizeof r->note + 32];
    snprintf(note, sizeof note, "%s", r->note);
    if (has_figure(r) && r->changes > 0)
        snprintf(note, sizeof note, "the rate changes at t about %.3g", r->change[0].t);
    else if (has_figure(r) && r->attractors != NULL)
        snprintf(note, sizeof note, "chaos may end later: fixed points attract as well: %.200s",
                 r->attractors);
    cns_sweep_print_last(out, note);
}

static cns_code sweep_rows(void *context, const cns_system *s, const char *value, const cns_monitor *monitor,
                           FILE *const *table, cns_error *err)
{
    const cns_context *cx = context;
    cns_lyapunov_result r;
    cns_code code = cns_lyapunov(s, &cx->c->lyapunov, monitor, &r, err);
    if (!code || code == CNS_UNREACHED) {
        print_swept(table[0], value, &r); /* the note says why there is no figure */
        code = CNS_OK;
    }
    cns_lyapunov_result_clear(&r);
    return code;
}

/* How many exponents the case asks for. */
static int exponents(const cns_context *cx)
{
    int n = 0;
    for (int i = 0; i < cx->c->model->n_states; i++)
        n += cns_program_is_dynamic(cns_system_program(cx->system), i);
    return cx->c->lyapunov.exponents > 0 ? cx->c->lyapunov.exponents : n;
}

static int sweep(cns_context *cx)
{
    const cns_lyapunov_spec *spec = &cx->c->lyapunov;
    const int n = exponents(cx);
    char name[256];
    cns_text_stream columns;
    cns_error err;
    snprintf(name, sizeof name, "lyapunov, time %s, arithmetic %d, %ld digits, %d exponents", spec->time.text,
             (int)spec->arithmetic, spec->digits, n);
    cns_text_open(&columns);
    for (int i = 1; i <= n && n > 1; i++)
        fprintf(columns.file, "lambda%d,se%d,", i, i);
    fprintf(columns.file, "%s", n > 1 ? "dimension,dimension_se," : "lambda,se,");
    fprintf(columns.file, "discarded,time,note");
    char *names = cns_text_close(&columns, &err);
    const cns_swept swept = {
        .study = {.name = name, .context = cx, .rows = sweep_rows},
        .table = {{.what = "Lyapunov exponents of ", .columns = names, .path = cx->o->output}},
        .directory = cx->o->keep};
    int status = names != NULL ? cns_sweep_tables(cx, &swept) : cns_complain(err.code, "%s", err.text);
    free(names);
    return status;
}

static const cns_view view = {.text = print_table, .yaml = print_yaml, .to_file = true};

static int run(cns_context *cx)
{
    cns_error err = {0};
    cns_lyapunov_result r;
    if (cx->o->keep != NULL && cx->o->sweep == NULL)
        return cns_complain(CNS_USAGE, "--keep is for a sweep's values: it needs --sweep");
    if (cx->o->sweep != NULL)
        return sweep(cx);
    cns_code code = cns_lyapunov(cx->system, &cx->c->lyapunov, &cx->monitor, &r, &err);
    int status = cns_report(cx, code, &err, &view, !code || code == CNS_UNREACHED ? &r : NULL);
    if (!status && cx->o->verbose)
        cns_note(cx, "%ld steps, %ld landings, %.2f s", r.steps, r.landings, cns_seconds() - cx->since);
    cns_lyapunov_result_clear(&r);
    return status;
}

const cns_command cns_command_lyapunov = {
    .name = "lyapunov",
    .run = run,
    .opens = CNS_OPENS_SYSTEM,
    .operands = "CASE",
    .least = 1,
    .most = 1,
    .summary = "Lyapunov exponents, with their standard errors",
    .details =
        "A tangent is carried along a long trajectory and its mean growth is printed as a table of t, "
        "lambda and standard error; --yaml: as a summary. The section `lyapunov` of the case says how long "
        "(time: 20000) and in which arithmetic: double, or mpfr or fast with digits. A tenth of that time "
        "comes before it and is left out. The error falls like 1/sqrt(time).\n"
        "With `exponents: all`, or a number, as many tangents are carried; then come the Kaplan-Yorke "
        "dimension and, as a check, the sum of all exponents and the mean trace of the Jacobian.\n"
        "Where the rate of growth changes once, what was before is left out. Where it changes again, or "
        "varies over longer than the batches that give the error, there is no figure: exit status 1.\n"
        "With --sweep the table has a row for every value.\n",
    .options =
        CNS_TAKES(CNS_OPTION_OUTPUT_FILE, CNS_OPTION_YAML, CNS_OPTION_SET, CNS_OPTION_SWEEP, CNS_OPTION_KEEP,
                  CNS_OPTION_MAX_TIME, CNS_OPTION_THREADS, CNS_OPTION_QUIET, CNS_OPTION_VERBOSE),
};
