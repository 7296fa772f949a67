/* cns lyapunov: the largest exponent, with its error. */
#include <stdlib.h>
#include <string.h>

#include "cns/study/lyapunov.h"
#include "commands.h"
#include "context.h"
#include "core/clock.h"
#include "core/files.h"
#include "integrate/trajectory.h"
#include "io/provenance.h"
#include "io/summary.h"
#include "report.h"

/* A figure and its error to the same decimals, two significant ones of the error. */
static int decimals_for(double se)
{
    int decimals = 1;
    for (double unit = 0.1; decimals < 9 && se < 9.95 * unit; unit /= 10)
        decimals++;
    return decimals;
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

static void print_table(FILE *out, const cns_case *c, const cns_lyapunov_result *r)
{
    const cns_lyapunov_spec *spec = &c->lyapunov;
    const int decimals = decimals_for(r->se);
    cns_provenance_begin(out, c, "largest Lyapunov exponent: ", CNS_PROVENANCE_CASE);
    fprintf(out, "# arithmetic: ");
    print_arithmetic(out, spec, r->order);
    fprintf(
        out,
        "\n# transient left out: t < %g\n# a mean over the attractor: at a fixed precision the trajectory is "
        "shadowed at best, not followed\n",
        r->discarded);
    fprintf(out, "t,lambda,se\n");
    for (int k = 0; k < CNS_LYAPUNOV_ROWS; k++)
        fprintf(out, "%.9g,%.*f,%.*f\n", r->row[k].t, decimals, r->row[k].lambda, decimals, r->row[k].se);
    fprintf(out, "# standard error by the number of batches, and their length:");
    for (int b = 0; b < CNS_LYAPUNOV_COUNTS; b++)
        fprintf(out, "%s %d (%g): %.*f", b > 0 ? "," : "", r->batch[b].count, r->batch[b].length, decimals,
                r->batch[b].se);
    fprintf(out, "\n# lambda = %.*f +- %.*f over T = %s\n", decimals, r->lambda, decimals, r->se,
            spec->time.text);
    cns_provenance_end(out, NULL);
}

static void print_summary(FILE *out, const cns_case *c, const cns_lyapunov_result *r, bool *written)
{
    char text[32];
    const int decimals = decimals_for(r->se);
    cns_summary *s = cns_summary_open(out);
    snprintf(text, sizeof text, "%.*f", decimals, r->lambda);
    cns_summary_text(s, "lambda", text);
    snprintf(text, sizeof text, "%.*f", decimals, r->se);
    cns_summary_text(s, "lambda_se", text);
    cns_summary_text(s, "time", c->lyapunov.time.text);
    cns_summary_number(s, "discarded", r->discarded, 9);
    cns_summary_long(s, "order", r->order);
    cns_summary_long(s, "steps", r->steps);
    cns_summary_long(s, "events", r->events);
    cns_summary_open_list(s, "batches");
    for (int b = 0; b < CNS_LYAPUNOV_COUNTS; b++) {
        cns_summary_open_mapping(s, NULL);
        cns_summary_long(s, "count", r->batch[b].count);
        cns_summary_number(s, "length", r->batch[b].length, 9);
        cns_summary_number(s, "se", r->batch[b].se, 3);
        cns_summary_shut(s);
    }
    cns_summary_shut(s);
    *written = cns_summary_close(s) != 0;
}

static int print(const cns_context *s, const cns_lyapunov_result *r)
{
    const cns_options *o = s->o;
    cns_page page;
    cns_error err;
    bool written = true;
    if (o->output) {
        char *text = NULL;
        size_t size;
        FILE *out = open_memstream(&text, &size);
        if (!out)
            return cns_complain(CNS_IO, "out of memory");
        print_table(out, s->c, r);
        bool lost = ferror(out) != 0;
        lost = fclose(out) != 0 || lost;
        cns_code code =
            lost ? cns_fail(&err, CNS_IO, "out of memory") : cns_file_replace(o->output, text, &err);
        free(text);
        if (code)
            return cns_complain(code, "%s", err.text);
        if (!o->yaml)
            return 0;
    }
    int status = (int)cns_page_open(&page);
    if (status)
        return status;
    if (o->yaml)
        print_summary(page.file, s->c, r, &written);
    else
        print_table(page.file, s->c, r);
    status = cns_page_print(&page);
    return status || written ? status : cns_complain(CNS_IO, "cannot write the summary");
}

static int run(const cns_options *o)
{
    cns_context s;
    cns_error err = {0};
    cns_lyapunov_result result;
    int status = cns_context_open(o, &s);
    if (status)
        return status;
    const cns_lyapunov_spec *spec = &s.c->lyapunov;
    const cns_lyapunov_problem problem = {.program = s.program,
                                          .scales = s.scales,
                                          .initial = s.c->initial,
                                          .time = cns_number_get_d(&spec->time),
                                          .arithmetic = spec->arithmetic,
                                          .digits = spec->digits,
                                          .stop = s.study.stop,
                                          .progress = s.study.progress,
                                          .context = s.study.context};
    status = cns_context_status(&s, cns_lyapunov(&problem, &result, &err), &err);
    if (!status)
        status = print(&s, &result);
    if (!status && o->verbose)
        fprintf(stderr, "cns: %ld steps, %ld events, %.2f s\n", result.steps, result.events,
                cns_seconds() - s.since);
    cns_context_close(&s);
    return status;
}

const cns_command cns_command_lyapunov = {
    .name = "lyapunov",
    .run = run,
    .operands = "CASE",
    .least = 1,
    .most = 1,
    .summary = "the largest Lyapunov exponent, with its standard error",
    .details =
        "A tangent is carried along a long trajectory and its mean growth is printed as a table of\n"
        "t, lambda and standard error; --yaml: as a summary. The section `lyapunov` of the case says\n"
        "how long (time: 20000) and in which arithmetic: double, or mpfr or fast with digits. A tenth\n"
        "of that time comes before it and is left out. The error falls like 1/sqrt(time).\n",
    .options = CNS_TAKES(CNS_OPTION_OUTPUT_FILE, CNS_OPTION_YAML, CNS_OPTION_SET, CNS_OPTION_QUIET,
                         CNS_OPTION_VERBOSE),
};
