/* cns classify: the mode of a motion, or of many. */
#include <stdlib.h>
#include <string.h>

#include "cns/study/classify.h"
#include "commands.h"
#include "core/text.h"
#include "report.h"
#include "sweep.h"

enum { MAX_DIGITS = 400 };

static const char neutral_phase[] = "exact: a shift along the cycle neither grows nor shrinks";

static void text_unless_null(cns_summary *s, const char *key, const char *text)
{
    if (text != NULL)
        cns_summary_text(s, key, text);
}

/* What is shown of one motion. */
typedef struct found_motion {
    cns_motion motion;
    const char *observable; /* whose maxima are listed */
} found_motion;

/* The first of the maxima that are shown: of chaos there may be thousands. */
static int first_shown(const cns_motion *m)
{
    enum { SHOWN = 64 };
    return m->mode == CNS_MODE_CHAOTIC && m->extrema > SHOWN ? m->extrema - SHOWN : 0;
}

static void print_yaml(cns_summary *s, const cns_context *cx, const void *result)
{
    const found_motion *found = result;
    const cns_motion *m = &found->motion;
    cns_summary_text(s, "mode", cns_mode_name(m->mode));
    if (m->period != NULL) {
        cns_summary_text(s, "period", m->period);
        cns_summary_text(s, "symmetry", m->symmetry);
        cns_summary_long(s, "winding", m->winding);
        cns_summary_long(s, "returns", m->returns);
        cns_summary_number(s, "multiplier", m->multiplier, 4);
        text_unless_null(s, "amplitude", m->amplitude);
        text_unless_null(s, "descent", m->descent);
        cns_summary_open_mapping(s, "drift");
        for (int i = 0; i < m->n_states; i++)
            text_unless_null(s, cx->c->model->states[i].name, m->drift[i]);
        cns_summary_shut(s);
    }
    if (m->period != NULL) {
        cns_summary_long(s, "lambda", 0);
        cns_summary_text(s, "lambda_note", neutral_phase);
    } else if (m->lambda_se >= 0) {
        cns_summary_number(s, "lambda", m->lambda, 4);
        cns_summary_number(s, "lambda_se", m->lambda_se, 2);
    }
    if (m->extrema > 0) {
        cns_summary_text(s, "observable", found->observable);
        cns_summary_open_list(s, "maxima");
        for (int i = first_shown(m); i < m->extrema; i++)
            cns_summary_text(s, NULL, m->maximum[i]);
        cns_summary_shut(s);
    }
    if (m->mode != CNS_MODE_UNDECIDED)
        cns_summary_number(s, "transient", m->transient, 6);
    cns_summary_number(s, "time", m->time, 6);
    cns_summary_long(s, "digits", m->digits);
    if (m->note[0] != '\0')
        cns_summary_text(s, "note", m->note);
}

static void print_line(FILE *out, const char *key, const char *value, const char *meaning)
{
    if (value != NULL)
        fprintf(out, "%-11s %s%s%s\n", key, value, meaning[0] != '\0' ? "   " : "", meaning);
}

static void print_text(FILE *out, const cns_context *cx, const void *result)
{
    const found_motion *found = result;
    const cns_motion *m = &found->motion;
    char value[64];
    print_line(out, "mode", cns_mode_name(m->mode), m->note);
    if (m->period != NULL) {
        print_line(out, "period", m->period, "");
        print_line(out, "symmetry", m->symmetry, "");
        snprintf(value, sizeof value, "%ld", m->winding);
        print_line(out, "winding", value, "whole revolutions in a period");
        snprintf(value, sizeof value, "%d", m->returns);
        print_line(out, "returns", value, "to the section, until it repeats up to symmetry");
        snprintf(value, sizeof value, "%.4g", m->multiplier);
        print_line(out, "multiplier", value, "of a small deviation, in one repetition");
        print_line(out, "amplitude", m->amplitude, "");
        print_line(out, "descent", m->descent, "mean speed");
        for (int i = 0; i < m->n_states; i++) {
            snprintf(value, sizeof value, "drift %s", cx->c->model->states[i].name);
            print_line(out, value, m->drift[i], "in a period");
        }
    }
    if (m->period != NULL) {
        print_line(out, "lambda", "0", neutral_phase);
    } else if (m->lambda_se >= 0) {
        snprintf(value, sizeof value, "%.4g +- %.2g", m->lambda, m->lambda_se);
        print_line(out, "lambda", value, "largest exponent");
    }
    if (m->mode != CNS_MODE_UNDECIDED) {
        snprintf(value, sizeof value, "%.6g", m->transient);
        print_line(out, "transient", value, "until then");
    }
    if (m->extrema > 0)
        fprintf(out, "maxima of %s:", found->observable);
    for (int i = first_shown(m); i < m->extrema; i++)
        fprintf(out, " %s", m->maximum[i]);
    if (m->extrema > 0)
        fputc('\n', out);
}

static int classify(cns_context *cx, const cns_classify_spec *spec, const char *observable)
{
    static const cns_view view = {.text = print_text, .yaml = print_yaml};
    found_motion found = {.observable = observable};
    cns_error err = {0};
    cns_code code = cns_classify(cx->system, spec, &cx->monitor, &found.motion, &err);
    int status = cns_report(cx, code, &err, &view, !code || code == CNS_STOPPED ? &found : NULL);
    if (!status && found.motion.mode == CNS_MODE_UNDECIDED)
        status = CNS_UNREACHED;
    cns_motion_clear(&found.motion);
    return status;
}

/* A sweep. */

static void print_optional(FILE *out, const char *text)
{
    fprintf(out, "%s,", text != NULL ? text : "");
}

static void print_row(FILE *out, const char *value, const cns_motion *m)
{
    const bool periodic = m->period != NULL;
    fprintf(out, "%s,%s,", value, cns_mode_name(m->mode));
    if (periodic)
        fprintf(out, "%s,%d,%ld,", m->symmetry, m->returns, m->winding);
    else
        fprintf(out, ",,,");
    print_optional(out, m->period);
    print_optional(out, m->descent);
    if (periodic)
        fprintf(out, "%.4g,0,,", m->multiplier);
    else if (m->lambda_se >= 0)
        fprintf(out, ",%.5g,%.2g,", m->lambda, m->lambda_se);
    else
        fprintf(out, ",,,");
    if (m->mode != CNS_MODE_UNDECIDED)
        fprintf(out, "%.6g", m->transient);
    fprintf(out, ",%.6g,", m->time);
    cns_sweep_print_last(out, m->note);
}

static cns_code sweep_rows(void *context, const cns_system *s, const char *value, const cns_monitor *monitor,
                           FILE *const *table, cns_error *err)
{
    cns_motion motion;
    cns_code code = cns_classify(s, context, monitor, &motion, err);
    if (code == CNS_NUMERIC || code == CNS_UNREACHED) {
        fprintf(table[0], "%s,failed,,,,,,,,,,,", value);
        cns_sweep_print_last(table[0], err->text);
        code = CNS_OK;
    } else if (!code) {
        print_row(table[0], value, &motion);
        for (int i = 0; i < motion.extrema; i++)
            fprintf(table[1], "%s,%d,%s\n", value, i + 1, motion.maximum[i]);
    }
    cns_motion_clear(&motion);
    return code;
}

static int sweep(cns_context *cx, cns_classify_spec *spec, const char *observable)
{
    const cns_options *o = cx->o;
    char name[128], columns[160];
    snprintf(name, sizeof name, "classify, observable %d, until %.17g, digits %ld", spec->observable,
             spec->until, spec->max_digits);
    snprintf(columns, sizeof columns, "n,%.120s", observable);
    const cns_swept swept = {
        .study = {.name = name, .context = spec, .rows = sweep_rows},
        .table = {{.what = "modes of ",
                   .columns = "mode,symmetry,returns,winding,period,descent,multiplier,lambda,lambda_se,"
                              "transient,time,note"},
                  {.what = "maxima in modes of ", .columns = columns, .path = o->maxima}},
        .directory = o->keep != NULL ? o->keep : o->output};
    return cns_sweep_tables(cx, &swept);
}

/* The state that --observable names; -1: left to the study, or unknown (then the message is out). */
static int read_observable(const cns_options *o, const cns_model *m, int *state)
{
    *state = -1;
    for (int i = 0; i < m->n_states && o->observable != NULL; i++)
        if (strcmp(m->states[i].name, o->observable) == 0)
            *state = i;
    if (o->observable == NULL || *state >= 0)
        return 0;
    return cns_complain(CNS_USAGE, "--observable: model %s has no state '%s'", m->name,
                        cns_quote(o->observable).text);
}

/* --until, 0 without it. */
static int read_until(const cns_options *o, double *until)
{
    cns_number x;
    cns_error err;
    cns_number_init(&x);
    bool good = o->until == NULL || (!cns_number_parse(&x, o->until, &err) && cns_number_sign(&x) > 0);
    *until = cns_number_get_d(&x);
    cns_number_clear(&x);
    return good ? 0
                : cns_complain(CNS_USAGE, "--until takes a time greater than 0, not '%s'",
                               cns_quote(o->until).text);
}

static int run(cns_context *cx)
{
    const cns_options *o = cx->o;
    const cns_model *m = cx->c->model;
    cns_classify_spec spec = {.max_digits = MAX_DIGITS};
    if ((o->output != NULL || o->keep != NULL || o->maxima != NULL) && o->sweep == NULL)
        return cns_complain(CNS_USAGE, "%s is for a sweep's values: it needs --sweep",
                            o->maxima != NULL ? "--maxima"
                            : o->keep != NULL ? "--keep"
                                              : "-o");
    int status = read_observable(o, m, &spec.observable);
    if (!status)
        status = read_until(o, &spec.until);
    if (status)
        return status;
    const char *observable = o->observable;
    for (int i = 0; i < m->n_states && o->observable == NULL; i++)
        if (cns_program_is_dynamic(cns_system_program(cx->system), i))
            observable = m->states[i].name;
    return o->sweep != NULL ? sweep(cx, &spec, observable) : classify(cx, &spec, observable);
}

const cns_command cns_command_classify = {
    .name = "classify",
    .run = run,
    .opens = CNS_OPENS_SYSTEM,
    .operands = "CASE",
    .least = 1,
    .most = 1,
    .summary = "find the mode of a motion: steady, flutter, tumble, chaotic",
    .details =
        "Follows the case's own trajectory until its late motion shows, twice, in different precisions, and "
        "finds the cycle that it tends to. Keys:\n"
        "  mode      steady, flutter (periodic, from side to side), tumble (periodic, going round), "
        "periodic (in a model without an angle), chaotic (the largest exponent is positive, by six standard "
        "errors, up to the time that is told), undecided (exit status 1; a note says why)\n"
        "  period    after which the motion repeats, up to place and whole revolutions of its angle\n"
        "  winding   whole revolutions in a period\n"
        "  symmetry  mirror: half a period makes the motion its own mirror image; turn: a part of a period "
        "turns it by half a revolution and otherwise repeats it; in a model without an angle one of its own, "
        "as Lorenz's half-turn; none\n"
        "  returns   passages through broadside (angle = k pi) until it repeats, up to symmetry: 1 is the "
        "simplest motion of its kind, 2 what is called period two\n"
        "With --sweep it does so for many values, on all cores, and prints a table; --maxima FILE adds one "
        "with a row for every maximum of the observable, all of a period, or of chaos those of the second "
        "half of the time. With --keep DIR (or -o DIR) every finished value is kept in DIR, and none is "
        "computed again.\n",
    .options = CNS_TAKES(CNS_OPTION_OUTPUT_DIR, CNS_OPTION_YAML, CNS_OPTION_SET, CNS_OPTION_UNTIL_LIMIT,
                         CNS_OPTION_SWEEP, CNS_OPTION_KEEP, CNS_OPTION_MAXIMA, CNS_OPTION_OBSERVABLE,
                         CNS_OPTION_MAX_TIME, CNS_OPTION_THREADS, CNS_OPTION_QUIET),
};
