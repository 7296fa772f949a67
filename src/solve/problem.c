/* What a problem asks for, and the simplest problem of all. */
#include <stdio.h>

#include "problem.h"

int cns_columns(const cns_problem *p)
{
    return p->columns != NULL ? p->n_columns : 1 + cns_system_model(p->system)->n_states;
}

cns_column cns_column_at(const cns_problem *p, int i)
{
    if (p->columns != NULL)
        return p->columns[i];
    return i == 0 ? (cns_column){CNS_COLUMN_TIME, 0} : (cns_column){CNS_COLUMN_STATE, i - 1};
}

const cns_number *cns_every(const cns_problem *p)
{
    return p->every != NULL ? p->every : p->end;
}

bool cns_wants_outputs(const cns_problem *p)
{
    for (int i = 0; i < cns_columns(p); i++)
        if (cns_column_at(p, i).kind == CNS_COLUMN_OUTPUT)
            return true;
    return false;
}

typedef struct printer {
    FILE *out;
    int columns;
} printer;

static cns_code print_row(void *context, const cns_row *row, cns_error *err)
{
    const printer *p = context;
    for (int i = 0; i < p->columns; i++)
        fprintf(p->out, "%s%c", row->text[i], i < p->columns - 1 ? ',' : '\n');
    return ferror(p->out) ? cns_fail(err, CNS_IO, "a row cannot be written") : CNS_OK;
}

static cns_code parse_time(cns_number *t, const char *text, const char *what, cns_error *err)
{
    const cns_code code = cns_number_parse(t, text, err);
    if (!code && (t->pi_power != 0 || cns_number_sign(t) <= 0))
        return cns_fail(err, CNS_USAGE, "the %s of a table is a rational number > 0, not '%.64s'", what,
                        t->text);
    return code;
}

cns_code cns_solve_print(const cns_system *s, const char *end, const char *every, long decimals, FILE *out,
                         cns_error *err)
{
    const cns_model *m = cns_system_model(s);
    printer p = {.out = out, .columns = 1 + m->n_states};
    const cns_sink sink = {.context = &p, .row = print_row};
    const cns_goal goal = {.places = CNS_PLACES_DECIMALS, .count = decimals};
    cns_number last, step;
    cns_result result;
    cns_number_init(&last);
    cns_number_init(&step);
    cns_code code = parse_time(&last, end, "end", err);
    if (!code)
        code = parse_time(&step, every != NULL ? every : end, "step", err);
    if (!code) {
        const cns_problem problem = {.system = s, .end = &last, .every = &step, .sink = &sink};
        fputc('t', out);
        for (int i = 0; i < m->n_states; i++)
            fprintf(out, ",%s", m->states[i].name);
        fputc('\n', out);
        code = cns_solve_goal(&problem, &goal, &result, err);
    }
    if (!code && fflush(out) != 0)
        code = cns_fail(err, CNS_IO, "a row cannot be written");
    cns_number_clear(&last);
    cns_number_clear(&step);
    return code;
}
