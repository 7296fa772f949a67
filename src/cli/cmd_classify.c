/* cns classify: the mode of a motion, or of many. */
#include <stdlib.h>
#include <string.h>

#include "cns/study/classify.h"
#include "cns/study/sweep.h"
#include "cns/version.h"
#include "commands.h"
#include "context.h"
#include "core/memory.h"
#include "core/text.h"
#include "io/provenance.h"
#include "io/summary.h"
#include "report.h"

enum { MAX_DIGITS = 400 };

static void text_unless_null(cns_summary *s, const char *key, const char *text)
{
    if (text != NULL)
        cns_summary_text(s, key, text);
}

static bool print_yaml(FILE *out, const cns_case *c, const cns_motion *m, const char *observable)
{
    cns_summary *s = cns_summary_open(out);
    cns_summary_text(s, "mode", cns_mode_name(m->mode));
    if (m->period != NULL) {
        cns_summary_text(s, "period", m->period);
        cns_summary_text(s, "symmetry", cns_symmetry_name(m->symmetry));
        cns_summary_long(s, "winding", m->winding);
        cns_summary_long(s, "returns", m->returns);
        cns_summary_number(s, "multiplier", m->multiplier, 4);
        text_unless_null(s, "amplitude", m->amplitude);
        text_unless_null(s, "descent", m->descent);
        cns_summary_open_mapping(s, "drift");
        for (int i = 0; i < m->n_states; i++)
            text_unless_null(s, c->model->states[i].name, m->drift[i]);
        cns_summary_shut(s);
    }
    if (m->lambda_se >= 0) {
        cns_summary_number(s, "lambda", m->lambda, 4);
        cns_summary_number(s, "lambda_se", m->lambda_se, 2);
    }
    if (m->extrema > 0) {
        cns_summary_text(s, "observable", observable);
        cns_summary_open_list(s, "maxima");
        for (int i = 0; i < m->extrema; i++)
            cns_summary_text(s, NULL, m->maximum[i]);
        cns_summary_shut(s);
    }
    if (m->mode != CNS_MODE_UNDECIDED)
        cns_summary_number(s, "transient", m->transient, 6);
    cns_summary_number(s, "time", m->time, 6);
    cns_summary_long(s, "digits", m->digits);
    if (m->note[0] != '\0')
        cns_summary_text(s, "note", m->note);
    return cns_summary_close(s) != 0;
}

static void print_line(FILE *out, const char *key, const char *value, const char *meaning)
{
    if (value != NULL)
        fprintf(out, "%-11s %s%s%s\n", key, value, meaning[0] != '\0' ? "   " : "", meaning);
}

static void print_text(FILE *out, const cns_case *c, const cns_motion *m, const char *observable)
{
    char value[64];
    print_line(out, "mode", cns_mode_name(m->mode), m->note);
    if (m->period != NULL) {
        print_line(out, "period", m->period, "");
        print_line(out, "symmetry", cns_symmetry_name(m->symmetry), "");
        snprintf(value, sizeof value, "%ld", m->winding);
        print_line(out, "winding", value, "whole revolutions in a period");
        snprintf(value, sizeof value, "%d", m->returns);
        print_line(out, "returns", value, "to the section, until it repeats up to symmetry");
        snprintf(value, sizeof value, "%.4g", m->multiplier);
        print_line(out, "multiplier", value, "of a small deviation, in one repetition");
        print_line(out, "amplitude", m->amplitude, "");
        print_line(out, "descent", m->descent, "mean speed");
        for (int i = 0; i < m->n_states; i++) {
            snprintf(value, sizeof value, "drift %s", c->model->states[i].name);
            print_line(out, value, m->drift[i], "in a period");
        }
    }
    if (m->lambda_se >= 0) {
        snprintf(value, sizeof value, "%.4g +- %.2g", m->lambda, m->lambda_se);
        print_line(out, "lambda", value, "largest exponent");
    }
    if (m->mode != CNS_MODE_UNDECIDED) {
        snprintf(value, sizeof value, "%.6g", m->transient);
        print_line(out, "transient", value, "until then");
    }
    if (m->extrema > 0)
        fprintf(out, "maxima of %s:", observable);
    for (int i = 0; i < m->extrema; i++)
        fprintf(out, " %s", m->maximum[i]);
    if (m->extrema > 0)
        fputc('\n', out);
}

static int classify(cns_context *s, const cns_classify_spec *spec, const char *observable)
{
    cns_motion motion;
    cns_error err = {0};
    cns_page page;
    bool written = true;
    cns_code code = cns_classify(&s->study, spec, &motion, &err);
    int status = cns_context_status(s, code, &err);
    if (!status)
        status = (int)cns_page_open(&page);
    if (!status) {
        if (s->o->yaml)
            written = print_yaml(page.file, s->c, &motion, observable);
        else
            print_text(page.file, s->c, &motion, observable);
        status = cns_page_print(&page);
    }
    if (!status && !written)
        status = cns_complain(CNS_IO, "cannot write the summary");
    if (!status && motion.mode == CNS_MODE_UNDECIDED)
        status = CNS_UNREACHED;
    cns_motion_clear(&motion);
    return status;
}

/* All that a row depends on besides the value of the parameter. */
static char *identity_of(const cns_case *c, const cns_classify_spec *spec)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (out == NULL)
        return cns_xcopy("");
    fprintf(out, "classify %s, observable %d, until %.17g, digits %ld, cns %s\n", c->model->name,
            spec->observable, spec->until, spec->max_digits, CNS_VERSION);
    for (int i = 0; i < c->model->n_parameters; i++)
        fprintf(out, "%s: %s\n", c->model->parameters[i].name, c->parameters[i].text);
    for (int i = 0; i < c->model->n_states; i++)
        fprintf(out, "%s: %s\n", c->model->states[i].name, c->initial[i].text);
    fprintf(out, "abs: %s\n", c->smooth ? c->eps.text : "exact");
    fclose(out);
    return text;
}

static int sweep(cns_context *s, const cns_classify_spec *spec, const char *observable)
{
    cns_sweep sw;
    cns_error err = {0};
    cns_page page;
    if (cns_sweep_parse(&sw, s->c->model, s->o->sweep, &err))
        return cns_complain(err.code, "--sweep: %s", err.text);
    const int n = cns_sweep_count(&sw);
    char **rows = cns_xalloc((size_t)n, sizeof *rows), *identity = identity_of(s->c, spec);
    cns_code code = cns_sweep_run(&s->study, &sw, spec, s->o->output, identity, rows, &err);
    int status = cns_context_status(s, code, &err), printed = (int)cns_page_open(&page), done = 0;
    if (!printed) {
        cns_provenance_begin(page.file, s->c, "modes of ", CNS_PROVENANCE_CASE);
        fprintf(page.file, "# sweep: %s\n# maxima: of %s\n", s->o->sweep, observable);
        fprintf(page.file, "%s,%s\n", s->c->model->parameters[sw.parameter].name, CNS_SWEEP_HEADER);
        for (int i = 0; i < n; i++)
            if (rows[i] != NULL) {
                fprintf(page.file, "%s\n", rows[i]);
                done++;
            }
        char reason[48];
        snprintf(reason, sizeof reason, "%d of %d rows", done, n);
        cns_provenance_end(page.file, done == n ? NULL : reason);
        printed = cns_page_print(&page);
    }
    for (int i = 0; i < n; i++)
        free(rows[i]);
    free(rows);
    free(identity);
    cns_sweep_clear(&sw);
    return status ? status : printed;
}

static int run(const cns_options *o)
{
    cns_context s;
    cns_classify_spec spec = {.observable = -1, .max_digits = MAX_DIGITS};
    cns_error err = {0};
    if (o->output != NULL && o->sweep == NULL)
        return cns_complain(CNS_USAGE, "-o is the directory of a sweep's runs: it needs --sweep");
    if (o->sweep != NULL && o->yaml)
        return cns_complain(CNS_USAGE, "--sweep prints a table: it does not go with --yaml");
    int status = cns_context_open(o, &s);
    if (status)
        return status;
    const cns_model *m = s.c->model;
    for (int i = 0; i < m->n_states && o->observable != NULL; i++)
        if (strcmp(m->states[i].name, o->observable) == 0)
            spec.observable = i;
    if (o->observable != NULL && spec.observable < 0)
        status = cns_complain(CNS_USAGE, "--observable: model %s has no state '%s'", m->name,
                              cns_quote(o->observable).text);
    if (o->until != NULL) {
        cns_number until;
        cns_number_init(&until);
        if (cns_number_parse(&until, o->until, &err) || cns_number_sign(&until) <= 0)
            status = cns_complain(CNS_USAGE, "--until takes a time greater than 0, not '%s'",
                                  cns_quote(o->until).text);
        spec.until = cns_number_get_d(&until);
        cns_number_clear(&until);
    }
    const char *observable = o->observable;
    for (int i = 0; i < m->n_states && o->observable == NULL; i++)
        if (cns_program_is_dynamic(s.program, i))
            observable = m->states[i].name;
    if (!status)
        status = o->sweep != NULL ? sweep(&s, &spec, observable) : classify(&s, &spec, observable);
    cns_context_close(&s);
    return status;
}

const cns_command cns_command_classify = {
    .name = "classify",
    .run = run,
    .operands = "CASE",
    .least = 1,
    .most = 1,
    .summary = "find the mode of a motion: steady, flutter, tumble, chaotic",
    .details =
        "Follows the case's own trajectory until its late motion shows, twice, in different precisions,\n"
        "and finds the cycle that it tends to. Keys:\n"
        "  mode      steady, flutter (periodic, from side to side), tumble (periodic, going round),\n"
        "            periodic (in a model without an angle), chaotic (the largest exponent is positive,\n"
        "            by six standard errors), undecided (exit status 1; a note says why)\n"
        "  period    after which the motion repeats, up to place and whole revolutions of its angle\n"
        "  winding   whole revolutions in a period\n"
        "  symmetry  mirror: half a period makes the motion its own mirror image; turn: a part of a\n"
        "            period turns it by half a revolution and otherwise repeats it; none\n"
        "  returns   passages through broadside (angle = k pi) until it repeats, up to symmetry: 1 is\n"
        "            the simplest motion of its kind, 2 what is called period two\n"
        "With --sweep it does so for many values of a parameter, on all cores, and prints a table; with\n"
        "-o DIR every finished value is kept in DIR, and none is computed again.\n",
    .options = CNS_TAKES(CNS_OPTION_OUTPUT_DIR, CNS_OPTION_YAML, CNS_OPTION_SET, CNS_OPTION_UNTIL_LIMIT,
                         CNS_OPTION_SWEEP, CNS_OPTION_OBSERVABLE, CNS_OPTION_THREADS, CNS_OPTION_QUIET),
};
