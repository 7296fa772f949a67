#include "cns/study/sweep.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/files.h"
#include "core/memory.h"
#include "core/monitor.h"
#include "core/text.h"
#include "num/decimal_text.h"
#include "study/ensemble.h"

typedef struct jobs {
    const cns_system *system;
    const cns_sweep *sweep;
    const cns_classify_spec *spec;
    const cns_monitor *monitor;
} jobs;

void cns_sweep_clear(cns_sweep *s)
{
    cns_number_clear(&s->from);
    cns_number_clear(&s->to);
    cns_number_clear(&s->step);
}

/* How many values, as an exact quotient. */
static bool count_values(const cns_sweep *s, unsigned long *count)
{
    mpq_t q;
    mpz_t whole;
    mpq_init(q);
    mpz_init(whole);
    mpq_sub(q, s->to.ratio, s->from.ratio);
    mpq_div(q, q, s->step.ratio);
    mpz_fdiv_q(whole, mpq_numref(q), mpq_denref(q));
    const bool fits = mpz_sgn(whole) >= 0 && mpz_cmp_ui(whole, CNS_SWEEP_MOST - 1) <= 0;
    *count = fits ? mpz_get_ui(whole) + 1 : 0;
    mpz_clear(whole);
    mpq_clear(q);
    return fits;
}

cns_code cns_sweep_parse(cns_sweep *s, const cns_model *model, const char *text, cns_error *err)
{
    const char *equals = strchr(text, '='), *colon = equals != NULL ? strchr(equals, ':') : NULL,
               *second = colon != NULL ? strchr(colon + 1, ':') : NULL;
    if (second == NULL)
        return cns_fail(err, CNS_USAGE, "a sweep is NAME=FROM:TO:STEP, not '%s'", cns_quote(text).text);
    s->parameter = -1;
    for (int i = 0; i < model->n_parameters; i++)
        if (strlen(model->parameters[i].name) == (size_t)(equals - text) &&
            strncmp(model->parameters[i].name, text, (size_t)(equals - text)) == 0)
            s->parameter = i;
    if (s->parameter < 0)
        return cns_fail(err, CNS_USAGE, "'%s': model %s has no such parameter", cns_quote(text).text,
                        model->name);
    cns_number_init(&s->from);
    cns_number_init(&s->to);
    cns_number_init(&s->step);
    const char *const begin[] = {equals + 1, colon + 1, second + 1};
    const char *const end[] = {colon, second, second + strlen(second)};
    cns_number *const number[] = {&s->from, &s->to, &s->step};
    cns_code code = CNS_OK;
    for (int i = 0; i < 3 && !code; i++) {
        char *part = cns_xcopy_n(begin[i], (size_t)(end[i] - begin[i]));
        code = cns_number_parse(number[i], part, err);
        free(part);
        if (!code && number[i]->pi_power != 0)
            code = cns_fail(err, CNS_USAGE, "a sweep takes decimals and fractions, not '%s'",
                            cns_quote(number[i]->text).text);
    }
    unsigned long count;
    cns_number least;
    cns_number_init(&least);
    if (!code && cns_number_sign(&s->step) <= 0)
        code =
            cns_fail(err, CNS_USAGE, "the step of a sweep is positive, not %s", cns_quote(s->step.text).text);
    if (!code && !count_values(s, &count))
        code = cns_fail(err, CNS_USAGE, "a sweep goes upwards, by at most %d values", CNS_SWEEP_MOST);
    const char *minimum = model->parameters[s->parameter].minimum;
    if (!code && minimum != NULL && !cns_number_parse(&least, minimum, err) &&
        cns_number_cmp(&s->from, &least) <= 0)
        code = cns_fail(err, CNS_USAGE, "%s must be greater than %s", model->parameters[s->parameter].name,
                        minimum);
    cns_number_clear(&least);
    if (code)
        cns_sweep_clear(s);
    return code;
}

int cns_sweep_count(const cns_sweep *s)
{
    unsigned long count;
    count_values(s, &count);
    return (int)count;
}

void cns_sweep_value(const cns_sweep *s, int i, cns_number *x)
{
    cns_error err;
    mpq_t q;
    mpq_init(q);
    mpq_set_ui(q, (unsigned long)i, 1);
    mpq_mul(q, q, s->step.ratio);
    mpq_add(q, q, s->from.ratio);
    char *text = cns_text_exact(q);
    if (text == NULL)
        text = mpq_get_str(NULL, 10, q);
    cns_number_parse(x, text, &err);
    free(text);
    mpq_clear(q);
}

static void name(void *context, int i, char *text, size_t size)
{
    const jobs *j = context;
    cns_number x;
    cns_number_init(&x);
    cns_sweep_value(j->sweep, i, &x);
    snprintf(text, size, "%s=%s", cns_system_model(j->system)->parameters[j->sweep->parameter].name,
             cns_ensemble_word_for(x.text).text);
    cns_number_clear(&x);
}

static double cost(void *context, int i)
{
    (void)context;
    (void)i;
    return 1;
}

static void print_optional(FILE *out, const char *text)
{
    fprintf(out, "%s,", text != NULL ? text : "");
}

/* The last column of a row: no comma may part it. */
static void print_note(FILE *out, const char *text)
{
    fputc(',', out);
    for (; *text != '\0'; text++)
        fputc(*text == ',' ? ';' : *text, out);
}

static void print_row(FILE *out, const cns_motion *m)
{
    const bool periodic = m->period != NULL;
    fprintf(out, "%s,", cns_mode_name(m->mode));
    if (periodic)
        fprintf(out, "%s,%d,%ld,", m->symmetry, m->returns, m->winding);
    else
        fprintf(out, ",,,");
    print_optional(out, m->period);
    print_optional(out, m->descent);
    if (periodic)
        fprintf(out, "%.4g", m->multiplier);
    if (periodic)
        fprintf(out, ",0,,");
    else if (m->lambda_se >= 0)
        fprintf(out, ",%.5g,%.2g,", m->lambda, m->lambda_se);
    else
        fprintf(out, ",,,");
    fprintf(out, "%.6g,", m->transient);
    for (int i = 0; i < m->extrema; i++)
        fprintf(out, "%s%s", i > 0 ? " " : "", m->maximum[i]);
    print_note(out, m->note);
}

static cns_code classify(const jobs *j, const cns_number *value, cns_motion *motion, cns_error *err)
{
    const cns_monitor quiet = {.stop = cns_monitor_stop(j->monitor)};
    cns_system *s = cns_system_with(j->system, j->sweep->parameter, value, err);
    *motion = (cns_motion){0};
    cns_code code = s != NULL ? cns_classify(s, j->spec, &quiet, motion, err) : err->code;
    cns_system_free(s);
    return code;
}

static cns_code run(void *context, int i, cns_ensemble_job *job, char **result, cns_error *err)
{
    const jobs *j = context;
    cns_motion motion;
    cns_number x;
    cns_number_init(&x);
    cns_sweep_value(j->sweep, i, &x);
    cns_code code = classify(j, &x, &motion, err);
    cns_ensemble_tell(job, 1);
    if (!code || code == CNS_NUMERIC || code == CNS_UNREACHED) {
        cns_text_stream row;
        cns_text_open(&row);
        fprintf(row.file, "%s,", x.text);
        if (code) {
            fputs("failed,,,,,,,,,,", row.file);
            print_note(row.file, err->text);
        } else {
            print_row(row.file, &motion);
        }
        *result = cns_text_close(&row, err);
        code = *result != NULL ? CNS_OK : err->code;
    }
    cns_motion_clear(&motion);
    cns_number_clear(&x);
    return code;
}

cns_code cns_sweep_run(const cns_system *s, const cns_sweep *sweep, const cns_classify_spec *spec,
                       const char *directory, const cns_monitor *monitor, char **rows, cns_error *err)
{
    jobs j = {s, sweep, spec, monitor};
    char *identity =
        cns_system_identity(s, sweep->parameter, "classify, observable %d, until %.17g, digits %ld",
                            spec->observable, spec->until, spec->max_digits);
    const cns_ensemble e = {.n = cns_sweep_count(sweep),
                            .monitor = monitor,
                            .directory = directory,
                            .identity = identity,
                            .context = &j,
                            .name = name,
                            .cost = cost,
                            .run = run};
    const cns_code code = cns_ensemble_run(&e, rows, err);
    free(identity);
    return code;
}
