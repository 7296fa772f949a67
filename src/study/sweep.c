#include "cns/study/sweep.h"

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
    const cns_sweep_study *study;
    const cns_monitor *monitor;
} jobs;

static const char next_table[] = "\f\n"; /* in a kept result, between tables */

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

/* The parameter or state, numbered as in cns_sweep, that the first n characters name; -1: none. */
static int varied_named(const cns_model *model, const char *text, size_t n)
{
    static const char parameters[] = "parameters.", initial[] = "initial.";
    const bool state = strncmp(text, initial, sizeof initial - 1) == 0;
    const size_t skipped = state                                                   ? sizeof initial - 1
                           : strncmp(text, parameters, sizeof parameters - 1) == 0 ? sizeof parameters - 1
                                                                                   : 0;
    for (int i = 0; i < (state ? model->n_states : model->n_parameters); i++) {
        const char *name = state ? model->states[i].name : model->parameters[i].name;
        if (strlen(name) + skipped == n && strncmp(name, text + skipped, n - skipped) == 0)
            return state ? model->n_parameters + i : i;
    }
    return -1;
}

static cns_code check_values(cns_sweep *s, const cns_model *model, cns_error *err)
{
    unsigned long count;
    cns_number least;
    const int way = cns_number_cmp(&s->to, &s->from), sign = cns_number_sign(&s->step);
    if (sign == 0)
        return cns_fail(err, CNS_USAGE, "the step of a sweep is not 0");
    if (sign < 0 && way > 0)
        return cns_fail(err, CNS_USAGE, "the step %s leads away from %s", cns_quote(s->step.text).text,
                        cns_quote(s->to.text).text);
    if (way < 0 && sign > 0)
        mpq_neg(s->step.ratio, s->step.ratio);
    if (!count_values(s, &count))
        return cns_fail(err, CNS_USAGE, "a sweep has at most %d values", CNS_SWEEP_MOST);
    const char *minimum = s->varied < model->n_parameters ? model->parameters[s->varied].minimum : NULL;
    cns_number_init(&least);
    cns_code code = CNS_OK;
    if (minimum != NULL && !cns_number_parse(&least, minimum, err) &&
        cns_number_cmp(way < 0 ? &s->to : &s->from, &least) <= 0)
        code = cns_fail(err, CNS_USAGE, "%s must be greater than %s", model->parameters[s->varied].name,
                        minimum);
    cns_number_clear(&least);
    return code;
}

cns_code cns_sweep_parse(cns_sweep *s, const cns_model *model, const char *text, cns_error *err)
{
    const char *equals = strchr(text, '='), *colon = equals != NULL ? strchr(equals, ':') : NULL,
               *second = colon != NULL ? strchr(colon + 1, ':') : NULL;
    if (second == NULL)
        return cns_fail(err, CNS_USAGE, "a sweep is NAME=FROM:TO:STEP, not '%s'", cns_quote(text).text);
    s->varied = varied_named(model, text, (size_t)(equals - text));
    if (s->varied < 0)
        return cns_fail(err, CNS_USAGE,
                        "'%s': model %s has no such parameter; a state at the start is initial.%s",
                        cns_quote(text).text, model->name, model->states[0].name);
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
    if (!code)
        code = check_values(s, model, err);
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

cns_sweep_title cns_sweep_name(const cns_sweep *s, const cns_model *model)
{
    const int state = s->varied - model->n_parameters;
    cns_sweep_title title;
    snprintf(title.text, sizeof title.text, "%s%s", state < 0 ? "" : "initial.",
             state < 0 ? model->parameters[s->varied].name : model->states[state].name);
    return title;
}

static void name(void *context, int i, char *text, size_t size)
{
    const jobs *j = context;
    cns_number x;
    cns_number_init(&x);
    cns_sweep_value(j->sweep, i, &x);
    snprintf(text, size, "%s=%s", cns_sweep_name(j->sweep, cns_system_model(j->system)).text,
             cns_ensemble_word_for(x.text).text);
    cns_number_clear(&x);
}

static double cost(void *context, int i)
{
    (void)context;
    (void)i;
    return 1;
}

/* All tables of a value, one behind the other. */
static cns_code fill(const jobs *j, const cns_number *x, FILE *out, cns_error *err)
{
    const cns_monitor quiet = {.stop = cns_monitor_stop(j->monitor),
                               .limited = j->monitor != NULL && j->monitor->limited};
    cns_text_stream tables[CNS_SWEEP_TABLES];
    FILE *table[CNS_SWEEP_TABLES];
    for (int k = 0; k < CNS_SWEEP_TABLES; k++) {
        cns_text_open(&tables[k]);
        table[k] = tables[k].file;
    }
    cns_system *s = cns_system_with(j->system, j->sweep->varied, x, err);
    cns_code code = s != NULL ? j->study->rows(j->study->context, s, x->text, &quiet, table, err) : err->code;
    cns_system_free(s);
    if (code == CNS_NUMERIC || code == CNS_UNREACHED || code == CNS_USAGE) {
        char *line = cns_text_printable(err->text);
        fprintf(table[0], "# %s=%s: %s\n", cns_sweep_name(j->sweep, cns_system_model(j->system)).text,
                x->text, line);
        free(line);
        code = CNS_OK;
    }
    for (int k = 0; k < CNS_SWEEP_TABLES; k++) {
        char *text = cns_text_close(&tables[k], code ? NULL : err);
        if (text == NULL && !code)
            code = err->code;
        else if (text != NULL)
            fprintf(out, "%s%s", k > 0 ? next_table : "", text);
        free(text);
    }
    return code;
}

static cns_code run(void *context, int i, cns_ensemble_job *job, char **result, cns_error *err)
{
    const jobs *j = context;
    cns_text_stream all;
    cns_number x;
    cns_number_init(&x);
    cns_sweep_value(j->sweep, i, &x);
    cns_text_open(&all);
    cns_code code = fill(j, &x, all.file, err);
    cns_ensemble_tell(job, 1);
    char *text = cns_text_close(&all, code ? NULL : err);
    if (!code && text == NULL)
        code = err->code;
    if (!code)
        *result = text;
    else
        free(text);
    cns_number_clear(&x);
    return code;
}

static void split(char *all, cns_sweep_rows *rows)
{
    char *from = all;
    for (int k = 0; k < CNS_SWEEP_TABLES; k++) {
        char *to = strstr(from, next_table);
        to = to != NULL ? to : from + strlen(from);
        rows->table[k] = cns_xcopy_n(from, (size_t)(to - from));
        from = *to != '\0' ? to + sizeof next_table - 1 : to;
    }
}

cns_code cns_sweep_run(const cns_system *s, const cns_sweep *sweep, const cns_sweep_study *study,
                       const char *directory, const cns_monitor *monitor, cns_sweep_rows *rows,
                       cns_error *err)
{
    jobs j = {s, sweep, study, monitor};
    const int n = cns_sweep_count(sweep);
    char *identity = cns_system_identity(s, sweep->varied, "%s", study->name);
    char **results = cns_xalloc((size_t)n, sizeof *results);
    const cns_ensemble e = {.n = n,
                            .monitor = monitor,
                            .directory = directory,
                            .identity = identity,
                            .context = &j,
                            .name = name,
                            .cost = cost,
                            .run = run};
    const cns_code code = cns_ensemble_run(&e, results, err);
    for (int i = 0; i < n; i++) {
        rows[i] = (cns_sweep_rows){0};
        if (results[i] != NULL)
            split(results[i], &rows[i]);
        free(results[i]);
    }
    free(results);
    free(identity);
    return code;
}

void cns_sweep_rows_clear(cns_sweep_rows *rows, int count)
{
    for (int i = 0; i < count; i++)
        for (int k = 0; k < CNS_SWEEP_TABLES; k++)
            free(rows[i].table[k]);
}
