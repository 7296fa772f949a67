/* What a problem asks for, and the simplest problem of all. */
#include <stdio.h>
#include <stdlib.h>

#include "core/memory.h"
#include "core/monitor.h"
#include "integrate/rows.h"
#include "problem.h"

static bool is_time(const cns_number *x)
{
    return x != NULL && x->pi_power == 0 && cns_number_sign(x) > 0;
}

cns_code cns_problem_check(const cns_problem *p, cns_error *err)
{
    bool rises = true;
    for (int i = 0; p->at != NULL && i < p->n_at; i++)
        rises = rises && p->at[i].pi_power == 0 &&
                (i > 0 ? cns_number_cmp(&p->at[i - 1], &p->at[i]) < 0 : cns_number_sign(&p->at[i]) >= 0) &&
                (i < p->n_at - 1 || cns_number_cmp(&p->at[i], p->end) == 0);
    if (!rises)
        return cns_fail(err, CNS_USAGE, "a list of times must increase, from 0 or later up to the end");
    if (is_time(p->end) && is_time(cns_every(p)))
        return CNS_OK;
    return cns_fail(err, CNS_USAGE, "the times of rows must be rational and positive");
}

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

bool cns_problem_row(const cns_problem *p, unsigned long row, mpq_t passed)
{
    if (p->at == NULL)
        return cns_row_time(cns_every(p), p->end, row, passed);
    if (row >= (unsigned long)p->n_at)
        return false;
    mpq_set(passed, p->at[row].ratio);
    return true;
}

double cns_problem_rows(const cns_problem *p)
{
    return p->at != NULL ? p->n_at : cns_number_get_d(p->end) / cns_number_get_d(cns_every(p));
}

double cns_problem_time(const cns_problem *p, mpq_srcptr passed)
{
    mpq_t time;
    mpq_init(time);
    cns_system_time(p->system, time, passed);
    const double t = mpq_get_d(time);
    mpq_clear(time);
    return t;
}

cns_places cns_goal_places(const cns_goal *goal)
{
    return goal->significant > 0 ? CNS_PLACES_SIGNIFICANT : CNS_PLACES_DECIMALS;
}

long cns_goal_count(const cns_goal *goal)
{
    return goal->significant > 0 ? goal->significant : goal->decimals;
}

double cns_most_steps(const cns_problem *p, double max_time)
{
    return max_time > 0 || cns_monitor_limited(p->monitor) ? 0 : CNS_MOST_STEPS;
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

cns_code cns_solve_print(const cns_system *s, const char *end, const char *every, long decimals, FILE *out,
                         cns_error *err)
{
    const cns_model *m = cns_system_model(s);
    printer p = {.out = out, .columns = 1 + m->n_states + m->n_outputs};
    cns_column *columns = cns_xalloc((size_t)p.columns, sizeof *columns); /* the first is the time */
    const cns_sink sink = {.context = &p, .row = print_row};
    const cns_goal goal = {.decimals = decimals};
    cns_number last, step;
    cns_result result;
    cns_number_init(&last);
    cns_number_init(&step);
    const cns_problem problem = {
        .system = s, .end = &last, .every = &step, .columns = columns, .n_columns = p.columns, .sink = &sink};
    for (int i = 0; i < m->n_states; i++)
        columns[1 + i] = (cns_column){CNS_COLUMN_STATE, i};
    for (int i = 0; i < m->n_outputs; i++)
        columns[1 + m->n_states + i] = (cns_column){CNS_COLUMN_OUTPUT, i};
    cns_code code = cns_number_parse(&last, end, err);
    if (!code)
        code = cns_number_parse(&step, every != NULL ? every : end, err);
    if (!code)
        code = cns_problem_check(&problem, err);
    if (!code) {
        fputc('t', out);
        for (int i = 0; i < m->n_states; i++)
            fprintf(out, ",%s", m->states[i].name);
        for (int i = 0; i < m->n_outputs; i++)
            fprintf(out, ",%s", m->outputs[i].name);
        fputc('\n', out);
        code = cns_solve_goal(&problem, &goal, &result, err);
    }
    if (!code && fflush(out) != 0)
        code = cns_fail(err, CNS_IO, "a row cannot be written");
    cns_number_clear(&last);
    cns_number_clear(&step);
    free(columns);
    return code;
}
