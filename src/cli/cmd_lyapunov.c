/* cns lyapunov: the largest exponent, with its error. */
#include "cns/study/lyapunov.h"
#include "commands.h"
#include "core/clock.h"
#include "io/provenance.h"
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

static void print_table(FILE *out, const cns_context *cx, const void *result)
{
    const cns_lyapunov_result *r = result;
    const cns_lyapunov_spec *spec = &cx->c->lyapunov;
    const int decimals = decimals_for(r->se);
    cns_provenance_begin(out, cx->c, "largest Lyapunov exponent: ", CNS_PROVENANCE_CASE);
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

static void print_yaml(cns_summary *s, const cns_context *cx, const void *result)
{
    const cns_lyapunov_result *r = result;
    char text[32];
    const int decimals = decimals_for(r->se);
    snprintf(text, sizeof text, "%.*f", decimals, r->lambda);
    cns_summary_text(s, "lambda", text);
    snprintf(text, sizeof text, "%.*f", decimals, r->se);
    cns_summary_text(s, "lambda_se", text);
    cns_summary_text(s, "time", cx->c->lyapunov.time.text);
    cns_summary_number(s, "discarded", r->discarded, 9);
    cns_summary_long(s, "order", r->order);
    cns_summary_long(s, "steps", r->steps);
    cns_summary_long(s, "landings", r->landings);
    cns_summary_long(s, "events", r->landings); /* its older name, until version 0.2 */
    cns_summary_open_list(s, "batches");
    for (int b = 0; b < CNS_LYAPUNOV_COUNTS; b++) {
        cns_summary_open_mapping(s, NULL);
        cns_summary_long(s, "count", r->batch[b].count);
        cns_summary_number(s, "length", r->batch[b].length, 9);
        cns_summary_number(s, "se", r->batch[b].se, 3);
        cns_summary_shut(s);
    }
    cns_summary_shut(s);
}

static const cns_view view = {.text = print_table, .yaml = print_yaml, .to_file = true};

static int run(cns_context *cx)
{
    cns_error err = {0};
    cns_lyapunov_result r;
    cns_code code = cns_lyapunov(cx->system, &cx->c->lyapunov, &cx->monitor, &r, &err);
    int status = cns_report(cx, code, &err, &view, code ? NULL : &r);
    if (!status && cx->o->verbose)
        fprintf(stderr, "cns: %ld steps, %ld events, %.2f s\n", r.steps, r.landings,
                cns_seconds() - cx->since);
    return status;
}

const cns_command cns_command_lyapunov = {
    .name = "lyapunov",
    .run = run,
    .opens = CNS_OPENS_SYSTEM,
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
