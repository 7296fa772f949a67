#include "event_table.h"

#include <stdlib.h>
#include <string.h>

#include "core/files.h"
#include "core/memory.h"
#include "core/text.h"
#include "io/provenance.h"
#include "report.h"

static cns_code parse_section(cns_event_condition *s, const cns_model *model, const char *text,
                              cns_error *err)
{
    const char *equals = strchr(text, '='), *mod = strstr(text, " mod ");
    if (equals == NULL)
        return cns_fail(err, CNS_USAGE, "a section is STATE=VALUE, not '%s'", cns_quote(text).text);
    s->state = -1;
    for (int i = 0; i < model->n_states; i++)
        if (strlen(model->states[i].name) == (size_t)(equals - text) &&
            strncmp(model->states[i].name, text, (size_t)(equals - text)) == 0)
            s->state = i;
    if (s->state < 0)
        return cns_fail(err, CNS_USAGE, "'%s': model %s has no such state", cns_quote(text).text,
                        model->name);
    if (strcmp(equals + 1, "extremum") == 0) {
        s->kind = CNS_CONDITION_EXTREMUM;
        return CNS_OK;
    }
    s->kind = mod != NULL ? CNS_CONDITION_PERIODS : CNS_CONDITION_VALUE;
    char *value = cns_xcopy_n(equals + 1, mod != NULL ? (size_t)(mod - equals - 1) : strlen(equals + 1));
    cns_code code = cns_number_parse(&s->value, value, err);
    free(value);
    if (!code && mod != NULL)
        code = cns_number_parse(&s->period, mod + 5, err);
    if (!code && mod != NULL && cns_number_sign(&s->period) <= 0)
        code = cns_fail(err, CNS_USAGE, "'%s': the period must be positive", cns_quote(text).text);
    return code;
}

int cns_wanted_open(cns_wanted *w, const cns_options *o, const cns_model *model)
{
    cns_error err = {0};
    const cns_model_motion *motion = model->motion;
    cns_code code = CNS_OK;
    *w = (cns_wanted){.o = o};
    w->sections = cns_xalloc((size_t)o->sections.n + 2, sizeof *w->sections);
    for (int i = 0; i < o->sections.n + 2; i++)
        cns_event_condition_init(&w->sections[i]);
    if (motion != NULL) {
        char text[32];
        cns_event_condition *s = &w->sections[w->n++];
        snprintf(text, sizeof text, motion->turns == 2 ? "pi" : "2*pi/%d", motion->turns);
        s->kind = CNS_CONDITION_PERIODS;
        s->state = motion->angle;
        code = cns_number_parse(&s->period, text, &err);
        if (motion->rate >= 0)
            w->sections[w->n++].state = motion->rate;
    }
    for (int i = 0; i < o->sections.n && !code; i++)
        code = parse_section(&w->sections[w->n++], model, o->sections.at[i], &err);
    if (!code && w->n == 0)
        code = cns_fail(&err, CNS_USAGE, "model %s has no events of its own: name one with --section",
                        model->name);
    if (!code)
        return 0;
    cns_wanted_close(w);
    return cns_complain(code, "%s", err.text);
}

static void forget_lines(cns_wanted *w)
{
    if (w->lines != NULL)
        fclose(w->lines);
    free(w->text);
    w->lines = NULL;
    w->text = NULL;
}

void cns_wanted_close(cns_wanted *w)
{
    forget_lines(w);
    for (int i = 0; w->sections != NULL && i < w->o->sections.n + 2; i++)
        cns_event_condition_clear(&w->sections[i]);
    free(w->sections);
    w->sections = NULL;
}

cns_code cns_wanted_begin(cns_wanted *w, cns_error *err)
{
    forget_lines(w);
    w->lines = open_memstream(&w->text, &w->size);
    return w->lines != NULL ? CNS_OK : cns_fail(err, CNS_NUMERIC, "out of memory");
}

void cns_wanted_event(cns_wanted *w, const cns_model *model, const cns_event *e)
{
    FILE *out = w->lines;
    const cns_event_condition *s = &w->sections[e->condition];
    const char *name = model->states[s->state].name;
    if (s->kind == CNS_CONDITION_EXTREMUM)
        fprintf(out, "%s extremum", name);
    else if (s->kind == CNS_CONDITION_VALUE)
        fprintf(out, "%s=%s", name, s->value.text);
    else if (cns_number_sign(&s->value) == 0)
        fprintf(out, "%s=%ld*%s", name, e->k, s->period.text);
    else
        fprintf(out, "%s=%s%+ld*%s", name, s->value.text, e->k, s->period.text);
    fprintf(out, ",%d,%s", e->direction, e->time);
    for (int i = 0; i < model->n_states; i++)
        fprintf(out, ",%s", e->state[i]);
    if (e->decimals >= 0)
        fprintf(out, ",%ld\n", e->decimals);
    else
        fprintf(out, ",\n");
}

int cns_wanted_write(cns_wanted *w, const cns_case *c, const char *reason)
{
    cns_error err = {0};
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (out == NULL)
        return cns_complain(CNS_NUMERIC, "out of memory");
    cns_provenance_begin(out, c, "events of ", CNS_PROVENANCE_EQUATIONS);
    fprintf(out, c->has_goal || w->o->prove
                     ? "# proof: two runs of different precision and order; convergence under refinement and "
                       "measured growth, not interval arithmetic\n"
                     : "# UNPROVEN\n");
    fprintf(out, "event,direction,t");
    for (int i = 0; i < c->model->n_states; i++)
        fprintf(out, ",%s", c->model->states[i].name);
    fprintf(out, ",decimals\n");
    if (w->lines != NULL) {
        fflush(w->lines);
        fputs(w->text, out);
    }
    cns_provenance_end(out, reason);
    fclose(out);
    cns_code code = cns_file_replace(w->o->events, text, &err);
    free(text);
    return code ? cns_complain(code, "%s", err.text) : 0;
}
