#include "provenance.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/text.h"

static const char stopped[] = "# stopped: ";

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
    if (cns_number_sign(&c->start) != 0)
        fprintf(out, "\n# start: t = %s", c->start.text);
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
    fprintf(out, "%s%s\n", stopped, line);
    free(line);
}

/* May a table that ended too early take this place: is there nothing, or another such table? */
static bool may_replace(const char *path)
{
    FILE *in = fopen(path, "rb");
    if (in == NULL)
        return errno == ENOENT;
    char tail[2048];
    const bool near_end = fseek(in, -(long)(sizeof tail - 1), SEEK_END) == 0 || fseek(in, 0, SEEK_SET) == 0;
    const size_t n = near_end ? fread(tail, 1, sizeof tail - 1, in) : 0;
    fclose(in);
    tail[n] = '\0';
    const char *line = tail;
    for (const char *end = tail; *end != '\0'; end += *end != '\0') {
        line = end;
        end += strcspn(end, "\n");
    }
    return n == 0 || strncmp(line, stopped, sizeof stopped - 1) == 0;
}

cns_code cns_provenance_close(cns_file *f, bool any_rows, const char *reason, char **kept, cns_error *err)
{
    const bool aside = f->aside != NULL, keep = reason == NULL || any_rows || !aside;
    cns_provenance_end(f->stream, reason);
    if (keep && reason != NULL && aside && !may_replace(f->path)) {
        const size_t size = strlen(f->path) + sizeof ".partial";
        char *partial = cns_xalloc(size, 1);
        snprintf(partial, size, "%s.partial", f->path);
        cns_file_redirect(f, partial);
        free(partial);
    }
    *kept = keep ? cns_xcopy(f->path) : NULL;
    cns_code code = cns_file_close(f, keep, err);
    if (code) {
        free(*kept);
        *kept = NULL;
    }
    return code;
}
