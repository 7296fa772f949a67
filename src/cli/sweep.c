#include "sweep.h"

#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/text.h"
#include "io/provenance.h"
#include "report.h"
#include "signals.h"

typedef struct found {
    cns_context *cx;
    const cns_swept *swept;
    cns_sweep sweep;
    int n, done;
    cns_sweep_rows *rows; /* n */
    char reason[160];     /* why not all are done; empty: they are */
} found;

static void print_begin(FILE *out, const found *f, const cns_swept_table *t)
{
    const cns_case *c = f->cx->c;
    cns_provenance_begin(out, c, t->what, CNS_PROVENANCE_CASE);
    fprintf(out, "# sweep: %s\n", f->cx->o->sweep);
    if (t->note != NULL)
        fprintf(out, "# %s\n", t->note);
    fprintf(out, "%s,%s\n", cns_sweep_name(&f->sweep, c->model).text, t->columns);
}

static void print_rows(FILE *out, const found *f, int table)
{
    for (int i = 0; i < f->n; i++)
        if (f->rows[i].table[table] != NULL)
            fputs(f->rows[i].table[table], out);
}

static int print(const found *f)
{
    cns_text_stream page;
    cns_text_open(&page);
    print_begin(page.file, f, &f->swept->table[0]);
    print_rows(page.file, f, 0);
    cns_provenance_end(page.file, f->reason[0] != '\0' ? f->reason : NULL);
    return cns_page_write(&page, NULL);
}

static int write(const found *f, int table)
{
    const cns_swept_table *t = &f->swept->table[table];
    cns_file file;
    cns_error err;
    char *kept;
    if (cns_file_create(&file, t->path, &err))
        return cns_complain(err.code, "%s", err.text);
    print_begin(file.stream, f, t);
    print_rows(file.stream, f, table);
    if (cns_provenance_close(&file, f->done > 0, f->reason[0] != '\0' ? f->reason : NULL, &kept, &err))
        return cns_complain(err.code, "%s", err.text);
    if (kept != NULL && strcmp(kept, t->path) != 0)
        cns_complain(CNS_OK,
                     "the rows are in %.300s: %.300s is something else than a stopped table, and stays", kept,
                     t->path);
    free(kept);
    return 0;
}

static int show(found *f)
{
    int status = 0;
    for (int i = 0; i < f->n; i++)
        f->done += f->rows[i].table[0] != NULL;
    if (f->done < f->n)
        snprintf(f->reason, sizeof f->reason, "%s%s%d of %d values", cns_signal_stop ? cns_signal_text() : "",
                 cns_signal_stop ? ", " : "", f->done, f->n);
    for (int k = CNS_SWEEP_TABLES - 1; k >= 0; k--) {
        int shown = f->swept->table[k].path != NULL ? write(f, k) : k == 0 ? print(f) : 0;
        status = shown ? shown : status;
    }
    f->cx->shown = f->swept->table[0].path == NULL;
    return status;
}

/* Values whose rows end with the reason why there are no more. */
static int count_failures(const found *f)
{
    int failures = 0;
    for (int i = 0; i < f->n; i++) {
        const char *rows = f->rows[i].table[0];
        failures += rows != NULL && (rows[0] == '#' || strstr(rows, "\n#") != NULL);
    }
    return failures;
}

int cns_sweep_tables(cns_context *cx, const cns_swept *swept)
{
    found f = {.cx = cx, .swept = swept};
    cns_error err = {0};
    if (cx->o->yaml)
        return cns_complain(CNS_USAGE, "--sweep prints a table: it does not go with --yaml");
    if (cns_sweep_parse(&f.sweep, cx->c->model, cx->o->sweep, &err))
        return cns_complain(err.code, "--sweep: %s", err.text);
    f.n = cns_sweep_count(&f.sweep);
    f.rows = cns_xalloc((size_t)f.n, sizeof *f.rows);
    cx->keeper = "--keep DIR";
    cx->kept = swept->directory;
    cns_code code =
        cns_sweep_run(cx->system, &f.sweep, &swept->study, swept->directory, &cx->monitor, f.rows, &err);
    cns_meter_clear(&cx->meter);
    int status = show(&f);
    const int told = cns_context_status(cx, code, &err), failures = count_failures(&f);
    status = status ? status : told;
    if (!status && failures > 0)
        status = cns_complain(CNS_UNREACHED, "%d of %d values could not be done as asked: the table says why",
                              failures, f.n);
    cns_sweep_rows_clear(f.rows, f.n);
    free(f.rows);
    cns_sweep_clear(&f.sweep);
    return status;
}

char *cns_sweep_study_name(const cns_case *c, const char *what)
{
    cns_text_stream name;
    const cns_numerics *n = &c->numerics;
    cns_error ignored;
    cns_text_open(&name);
    fprintf(name.file, "%s; end %s, every %s;", what, c->end.text, c->every.text);
    if (cns_number_sign(&c->start) != 0)
        fprintf(name.file, " start %s;", c->start.text);
    for (int i = 0; i < c->n_at; i++)
        fprintf(name.file, " at %s;", c->at[i].text);
    for (int i = 0; i < c->n_columns; i++)
        fprintf(name.file, " %s", cns_case_column_name(c, i));
    if (c->has_goal)
        fprintf(name.file, "; %ld decimals, %ld significant, at most %ld digits", c->goal.decimals,
                c->goal.significant, c->goal.max_digits);
    if (c->has_numerics)
        fprintf(name.file, "; method %d, arithmetic %d, %ld digits, order %ld, step %s, tolerance %s",
                n->method, n->arithmetic, n->digits, n->order, n->step.text, n->tolerance.text);
    char *text = cns_text_close(&name, &ignored);
    return text != NULL ? text : cns_xcopy(what);
}

void cns_sweep_print_last(FILE *out, const char *text)
{
    for (; *text != '\0'; text++)
        fputc(*text == ',' ? ';' : *text, out);
    fputc('\n', out);
}
