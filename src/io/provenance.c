#include "provenance.h"

#include <stdlib.h>
#include <string.h>

#include "cns/version.h"
#include "core/text.h"

/* Every line of a text, behind `lead`. Lines end in LF, CR LF or CR. */
static void print_lines(FILE *out, const char *lead, const char *text)
{
    while (*text != '\0') {
        const size_t length = strcspn(text, "\r\n");
        fprintf(out, "%s%.*s\n", lead, (int)length, text);
        text += length;
        text += strspn(text, "\r");
        text += *text == '\n';
    }
}

static void print_values(FILE *out, const cns_case *c)
{
    const cns_model *m = c->model;
    fprintf(out, "# parameters:");
    for (int i = 0; i < m->n_parameters; i++)
        fprintf(out, "%s %s = %s", i > 0 ? "," : "", m->parameters[i].name, c->parameters[i].text);
    fprintf(out, "\n# initial:");
    for (int i = 0; i < m->n_states; i++)
        fprintf(out, "%s %s = %s", i > 0 ? "," : "", m->states[i].name, c->initial[i].text);
    if (c->smooth)
        fprintf(out, "\n# abs: sqrt(a^2 + eps^2), eps = %s\n", c->eps.text);
    else
        fprintf(out, "\n# abs: exact\n");
}

void cns_provenance_begin(FILE *out, const cns_case *c, const char *what, cns_provenance level)
{
    fprintf(out, "# cns %s: %s%s\n# format: %d\n", CNS_VERSION, what, c->model->title, CNS_TABLE_FORMAT);
    if (level >= CNS_PROVENANCE_EQUATIONS)
        fprintf(out, "# equations: %s\n", c->model->source);
    fprintf(out, "# case: %s, SHA-256 %s\n", c->name, c->sha256);
    if (level >= CNS_PROVENANCE_WHOLE)
        print_lines(out, "# | ", c->text);
    if (c->overrides != NULL)
        print_lines(out, "# override: ", c->overrides);
    if (level >= CNS_PROVENANCE_WHOLE)
        print_values(out, c);
}

void cns_provenance_end(FILE *out, const char *reason)
{
    if (reason == NULL) {
        fprintf(out, "# complete\n");
        return;
    }
    char *line = cns_text_printable(reason);
    fprintf(out, "# stopped: %s\n", line);
    free(line);
}
