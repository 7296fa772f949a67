#include "event_table.h"

#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/text.h"
#include "io/provenance.h"
#include "report.h"

static cns_code parse_condition(cns_event_condition *s, const cns_model *model, const char *text,
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

int cns_event_table_open(cns_event_table *t, const cns_context *cx)
{
    cns_error err = {0};
    const cns_texts *sections = &cx->o->sections;
    const cns_model *model = cx->c->model;
    const cns_model_motion *motion = model->motion;
    cns_code code = CNS_OK;
    *t = (cns_event_table){.cx = cx, .room = sections->n + 2};
    t->condition = cns_xalloc((size_t)t->room, sizeof *t->condition);
    for (int i = 0; i < t->room; i++)
        cns_event_condition_init(&t->condition[i]);
    if (motion != NULL) {
        char text[32];
        cns_event_condition *s = &t->condition[t->n++];
        snprintf(text, sizeof text, motion->turns == 2 ? "pi" : "2*pi/%d", motion->turns);
        s->kind = CNS_CONDITION_PERIODS;
        s->state = motion->angle;
        code = cns_number_parse(&s->period, text, &err);
        if (motion->rate >= 0)
            t->condition[t->n++].state = motion->rate;
    }
    for (int i = 0; i < sections->n && !code; i++)
        code = parse_condition(&t->condition[t->n++], model, sections->at[i], &err);
    if (!code && t->n == 0)
        code = cns_fail(&err, CNS_USAGE, "model %s has no events of its own: name one with --section",
                        model->name);
    if (!code)
        code = cns_file_create(&t->file, cx->o->events, &err);
    return code ? cns_complain(code, "%s", err.text) : 0;
}

static void forget_lines(cns_event_table *t)
{
    if (t->lines.file != NULL)
        free(cns_text_close(&t->lines, NULL));
    t->lines.file = NULL;
    t->told = 0;
}

void cns_event_table_close(cns_event_table *t)
{
    forget_lines(t);
    if (t->file.path != NULL)
        cns_file_close(&t->file, false, NULL);
    for (int i = 0; i < t->room; i++)
        cns_event_condition_clear(&t->condition[i]);
    free(t->condition);
}

void cns_event_table_begin(cns_event_table *t, const cns_run_info *run)
{
    t->enclosed = run->enclosed;
    forget_lines(t);
    cns_text_open(&t->lines);
}

void cns_event_table_add(cns_event_table *t, const cns_event *e)
{
    FILE *out = t->lines.file;
    t->told++;
    const cns_model *model = t->cx->c->model;
    const cns_event_condition *s = &t->condition[e->condition];
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

int cns_event_table_write(cns_event_table *t, bool whole_run, const char *reason)
{
    const cns_options *o = t->cx->o;
    const cns_case *c = t->cx->c;
    FILE *out = t->file.stream;
    cns_error err;
    char *lines = t->lines.file != NULL ? cns_text_close(&t->lines, &err) : cns_xcopy("");
    t->lines.file = NULL;
    if (lines == NULL)
        return cns_complain(err.code, "%s", err.text);
    cns_provenance_begin(out, c, "events of ", CNS_PROVENANCE_EQUATIONS);
    fputs(t->enclosed
              ? "# proof: an enclosure: the exact solution has each of these events, and none beside it, at "
                "the "
                "time and with the states\n#   shown, rounded; that there are no others is not proven. A "
                "theorem as far as the enclosures are right\n"
          : c->has_goal || o->prove ? "# proof: two runs of different precision and order; convergence under "
                                      "refinement and measured growth, not interval arithmetic\n"
                                    : "# UNPROVEN\n",
          out);
    fprintf(out, "event,direction,t");
    for (int i = 0; i < c->model->n_states; i++)
        fprintf(out, ",%s", c->model->states[i].name);
    fprintf(out, ",decimals\n");
    fputs(lines, out);
    free(lines);
    char *kept;
    if (cns_provenance_close(&t->file, t->told > 0 || whole_run, reason, &kept, &err))
        return cns_complain(err.code, "%s", err.text);
    if (kept != NULL && strcmp(kept, o->events) != 0)
        cns_complain(
            CNS_OK,
            "the events up to there are in %.300s: %.300s is something else than a stopped table, and stays",
            kept, o->events);
    free(kept);
    return 0;
}
