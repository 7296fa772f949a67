/* cns models: what can be computed. */
#include "cns/model.h"
#include "commands.h"
#include "core/text.h"
#include "report.h"

static void print_model(const cns_model *m, FILE *out)
{
    fprintf(out, "%s: %s\n  from %s\n", m->name, m->title, m->source);
    fputs("  states\n", out);
    for (int i = 0; i < m->n_states; i++)
        fprintf(out, "    %-8s %s (scale %g)\n", m->states[i].name, m->states[i].meaning, m->states[i].scale);
    if (m->n_parameters > 0)
        fputs("  parameters\n", out);
    for (int i = 0; i < m->n_parameters; i++) {
        const cns_model_parameter *p = &m->parameters[i];
        fprintf(out, "    %-8s %s (", p->name, p->meaning);
        if (p->standard != NULL)
            fprintf(out, "default %s", p->standard);
        else
            fputs("no default", out);
        if (p->minimum != NULL)
            fprintf(out, "; > %s", p->minimum);
        fputs(")\n", out);
    }
    if (m->n_outputs > 0)
        fputs("  derived quantities\n", out);
    for (int i = 0; i < m->n_outputs; i++)
        fprintf(out, "    %-8s %s\n", m->outputs[i].name, m->outputs[i].meaning);
}

static const char *model_name(int i, const void *context)
{
    (void)context;
    return cns_model_at(i)->name;
}

/* result: the model asked for; NULL: all of them. */
static void print_text(FILE *out, const cns_context *cx, const void *result)
{
    const cns_model *only = result;
    (void)cx;
    for (int i = 0; i < cns_model_count() && only == NULL; i++) {
        if (i > 0)
            fputc('\n', out);
        print_model(cns_model_at(i), out);
    }
    if (only != NULL)
        print_model(only, out);
}

static int run(cns_context *cx)
{
    const cns_options *o = cx->o;
    const cns_model *only = NULL;
    if (o->operands.n > 0) {
        const char *name = o->operands.at[0];
        only = cns_model_find(name);
        if (only == NULL) {
            const char *nearest = cns_text_nearest(name, cns_model_count(), model_name, NULL);
            if (nearest != NULL)
                return cns_complain(CNS_USAGE, "unknown model '%s'; did you mean '%s'?", cns_quote(name).text,
                                    nearest);
            return cns_complain(CNS_USAGE, "unknown model '%s'; `cns models` lists the models",
                                cns_quote(name).text);
        }
    }
    return cns_show(cx, &(cns_view){.text = print_text, .folded = true}, only);
}

const cns_command cns_command_models = {
    .name = "models",
    .run = run,
    .operands = "[MODEL]",
    .least = 0,
    .most = 1,
    .summary = "list the models: states, parameters, derived quantities",
};
