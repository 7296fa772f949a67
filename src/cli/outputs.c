#include "outputs.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "commands.h"
#include "core/memory.h"
#include "core/text.h"
#include "report.h"

/* What tells a file from all others: device and inode; of one that does not exist yet, those of its
 * directory, and its name there. */
typedef struct place {
    bool known, there;
    dev_t device;
    ino_t inode;
    const char *name;
} place;

static place place_of_open(int file)
{
    struct stat s;
    if (fstat(file, &s) != 0 || !S_ISREG(s.st_mode))
        return (place){0};
    return (place){.known = true, .there = true, .device = s.st_dev, .inode = s.st_ino};
}

static place place_of(const char *path)
{
    struct stat s;
    if (stat(path, &s) == 0)
        return (place){.known = S_ISREG(s.st_mode), .there = true, .device = s.st_dev, .inode = s.st_ino};
    const char *slash = strrchr(path, '/');
    char *directory = slash == NULL ? cns_xcopy(".") : cns_xcopy_n(path, (size_t)(slash - path) + 1);
    place p = {.known = stat(directory, &s) == 0, .name = slash == NULL ? path : slash + 1};
    free(directory);
    p.device = s.st_dev;
    p.inode = s.st_ino;
    return p;
}

static bool same(const place *a, const place *b)
{
    return a->known && b->known && a->there == b->there && a->device == b->device && a->inode == b->inode &&
           (a->there || strcmp(a->name, b->name) == 0);
}

/* A file that the command reads or writes. */
typedef struct end {
    const char *option; /* NULL: standard output, or an operand */
    const char *path;   /* NULL: a standard stream */
    place place;
} end;

static end input_of(const char *operand)
{
    return strcmp(operand, "-") == 0 ? (end){.place = place_of_open(STDIN_FILENO)}
                                     : (end){.path = operand, .place = place_of(operand)};
}

/* "--output t.csv" or "standard output" */
static cns_quotation title(const end *e)
{
    cns_quotation q;
    if (e->option == NULL)
        snprintf(q.text, sizeof q.text, "standard output");
    else
        snprintf(q.text, sizeof q.text, "--%s %.40s", e->option, cns_quote(e->path).text);
    return q;
}

static int refuse_input(const end *output, const end *input)
{
    return cns_complain(CNS_USAGE, "%s would overwrite %s, which is read", title(output).text,
                        input->path != NULL ? cns_quote(input->path).text : "standard input");
}

enum { MOST = 8 };

int cns_outputs_check(const cns_options *o)
{
    const cns_command *c = o->command;
    if (c == NULL || o->help || o->version || !(c->reads || c->opens >= CNS_OPENS_CASE))
        return 0;
    cns_written written[MOST];
    end output[MOST + 1];
    int n = cns_options_written(o, written, MOST);
    bool table_in_file = false;
    for (int i = 0; i < n; i++) {
        output[i] = (end){written[i].option, written[i].path, place_of(written[i].path)};
        table_in_file = table_in_file || written[i].path == o->output;
    }
    if (!table_in_file || o->yaml)
        output[n++] = (end){.place = place_of_open(STDOUT_FILENO)};
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < o->operands.n; k++) {
            const end input = input_of(o->operands.at[k]);
            if (same(&output[i].place, &input.place))
                return refuse_input(&output[i], &input);
        }
        for (int k = 0; k < i; k++)
            if (same(&output[i].place, &output[k].place))
                return cns_complain(CNS_USAGE, "%s and %s are the same file", title(&output[k]).text,
                                    title(&output[i]).text);
    }
    return 0;
}
