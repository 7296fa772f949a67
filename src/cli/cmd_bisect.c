/* cns bisect: a critical parameter. */
#include "cns/study/bisect.h"

#include <string.h>

#include "commands.h"
#include "report.h"

static const char *parameter_name(const cns_case *c)
{
    return c->model->parameters[c->bisect.parameter].name;
}

static void print_text(FILE *out, const cns_context *cx, const void *result)
{
    const cns_bisect_result *r = result;
    if (r->critical != NULL)
        fprintf(out, "%s = %s, %ld decimals\n", parameter_name(cx->c), r->critical, r->decimals);
    fprintf(out, "%-8s at %s\n%-8s at %s\n", r->lower_mode, r->lower, r->upper_mode, r->upper);
}

static void print_yaml(cns_summary *s, const cns_context *cx, const void *result)
{
    const cns_bisect_result *r = result;
    cns_summary_text(s, "parameter", parameter_name(cx->c));
    if (r->critical != NULL)
        cns_summary_text(s, "critical", r->critical);
    cns_summary_text(s, "lower", r->lower);
    cns_summary_text(s, "upper", r->upper);
    cns_summary_text(s, "lower_mode", r->lower_mode);
    cns_summary_text(s, "upper_mode", r->upper_mode);
    if (r->critical != NULL)
        cns_summary_long(s, "decimals", r->decimals);
    cns_summary_long(s, "probes", r->probes);
}

static const cns_view view = {.text = print_text, .yaml = print_yaml};

/* With -v, what is done next goes to a line of its own. */
static void on_progress(void *context, double fraction, const char *what)
{
    cns_context *cx = context;
    const bool new = strncmp(cx->what, what, sizeof cx->what - 1) != 0;
    cns_context_tell(cx, fraction, what);
    if (cx->o->verbose > 0 && new)
        cns_note(cx, "%s", what);
}

static int run(cns_context *cx)
{
    const cns_case *c = cx->c;
    cns_bisect_result r = {.decimals = -1};
    cns_error err = {0};
    if (!c->has_bisect)
        return cns_complain_of_case(c, "no 'bisect': `cns bisect` needs that section");
    cx->monitor.progress = on_progress;
    cx->keeper = "-o DIR";
    cx->kept = cx->o->output;
    cns_code code = cns_bisect(cx->system, &c->bisect, cx->o->output, &cx->monitor, &r, &err);
    int status = cns_report(cx, code, &err, &view, r.lower != NULL ? &r : NULL);
    cns_bisect_clear(&r);
    return status;
}

const cns_command cns_command_bisect = {
    .name = "bisect",
    .run = run,
    .opens = CNS_OPENS_SYSTEM,
    .operands = "CASE",
    .least = 1,
    .most = 1,
    .summary = "the critical value of a parameter between two modes",
    .details =
        "The section `bisect` of the case names a parameter, a bracket and how many decimals to find. by: "
        "trajectory follows the case's own trajectory until its late motion shows, in halves of the "
        "bracket, with as many digits as the passage by the saddle takes. by: manifold follows the unstable "
        "manifold of a saddle to the next one and asks on which side it passes; the zero of the distance is "
        "found by secants of rising precision. Both ends of the last bracket are probed twice, with "
        "different digits, orders and steps. With -o DIR every probe is kept there, and the same command "
        "goes on where it was stopped.\n",
    .options = CNS_TAKES(CNS_OPTION_OUTPUT_DIR, CNS_OPTION_YAML, CNS_OPTION_SET, CNS_OPTION_MAX_TIME,
                         CNS_OPTION_THREADS, CNS_OPTION_QUIET, CNS_OPTION_VERBOSE),
};
