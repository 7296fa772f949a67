/* cns compare: two tables. */
#include <stdlib.h>
#include <string.h>

#include "cns/study/compare.h"
#include "cns/study/laws.h"
#include "commands.h"
#include "io/read_table.h"
#include "report.h"

typedef struct compare_context {
    bool verbose;
    cns_text_stream page;
    cns_summary *summary; /* --yaml */
    int n;
    const char *const *names;
} compare_context;

static void decimals_text(char *text, size_t size, long decimals)
{
    if (decimals == CNS_COMPARE_NOTHING)
        text[0] = '\0';
    else
        snprintf(text, size, "%ld", decimals);
}

static void on_begin(void *context, int n, const char *const *names)
{
    compare_context *x = context;
    x->n = n;
    x->names = names;
    if (x->summary)
        return;
    fputs("t,decimals", x->page.file);
    for (int k = 0; k < n && x->verbose; k++)
        fprintf(x->page.file, ",%s", names[k]);
    fputc('\n', x->page.file);
}

static void on_row(void *context, const char *t, long least, const long *each)
{
    compare_context *x = context;
    char text[32];
    decimals_text(text, sizeof text, least);
    if (!x->summary) {
        fprintf(x->page.file, "%s,%s", t, text);
        for (int k = 0; k < x->n && x->verbose; k++) {
            decimals_text(text, sizeof text, each[k]);
            fprintf(x->page.file, ",%s", text);
        }
        fputc('\n', x->page.file);
        return;
    }
    cns_summary_open_mapping(x->summary, NULL);
    cns_summary_text(x->summary, "t", t);
    cns_summary_text(x->summary, "decimals", least == CNS_COMPARE_NOTHING ? "null" : text);
    if (x->verbose) {
        cns_summary_open_mapping(x->summary, "columns");
        for (int k = 0; k < x->n; k++) {
            decimals_text(text, sizeof text, each[k]);
            cns_summary_text(x->summary, x->names[k], each[k] == CNS_COMPARE_NOTHING ? "null" : text);
        }
        cns_summary_shut(x->summary);
    }
    cns_summary_shut(x->summary);
}

/* What the norm is made of, in words: "theta, Vx (dynamic states of apw)". */
static void norm_text(const cns_compare_result *r, FILE *out)
{
    bool first = true;
    for (int k = 0; k < r->n; k++) {
        if (!r->in_norm[k])
            continue;
        fprintf(out, "%s%s", first ? "" : ", ", r->name[k]);
        first = false;
    }
    if (r->model)
        fprintf(out, " (dynamic states of %s)", r->model);
    else
        fputs(" (all common columns)", out);
}

static void yaml_time(cns_summary *s, const char *key, const char *tc, const char *last)
{
    if (tc) {
        cns_summary_text(s, key, tc);
        return;
    }
    cns_summary_open_mapping(s, key);
    cns_summary_text(s, "beyond", last ? last : "null");
    cns_summary_shut(s);
}

/* False: out of memory. */
static bool print_yaml(cns_summary *s, const cns_compare_result *r, const char *delta)
{
    cns_text_stream norm;
    cns_text_open(&norm);
    norm_text(r, norm.file);
    char *text = cns_text_close(&norm, NULL);
    if (text == NULL)
        return false;
    if (r->differs) {
        cns_summary_open_mapping(s, "first_difference");
        cns_summary_text(s, "t", r->first.t);
        cns_summary_text(s, "column", r->name[r->first.column]);
        cns_summary_text(s, "a", r->first.a);
        cns_summary_text(s, "b", r->first.b);
        cns_summary_shut(s);
    } else {
        cns_summary_text(s, "first_difference", "null");
    }
    cns_summary_text(s, "delta", delta);
    cns_summary_open_mapping(s, "times");
    yaml_time(s, "norm", r->norm_tc, r->norm_last);
    for (int k = 0; k < r->n; k++)
        yaml_time(s, r->name[k], r->tc[k], r->last[k]);
    cns_summary_shut(s);
    cns_summary_text(s, "norm_of", text);
    free(text);
    cns_summary_open_mapping(s, "rows");
    cns_summary_long(s, "a", r->rows_a);
    cns_summary_long(s, "b", r->rows_b);
    cns_summary_long(s, "common", r->common);
    cns_summary_shut(s);
    return true;
}

static void print_time(FILE *out, const char *name, const char *tc, const char *last)
{
    fprintf(out, "# T_c of %s: %s%s\n", name, tc || !last ? "" : "> ",
            tc     ? tc
            : last ? last
                   : "no value in common");
}

static void print_lines(FILE *out, const cns_compare_result *r, const char *delta)
{
    fprintf(out, "# common rows: %ld of %ld and %ld\n", r->common, r->rows_a, r->rows_b);
    if (r->differs)
        fprintf(out, "# first difference: t = %s, %s: %s and %s\n", r->first.t, r->name[r->first.column],
                r->first.a, r->first.b);
    else
        fputs("# first difference: none\n", out);
    fprintf(out, "# T_c: first common row beyond delta = %s; norm of ", delta);
    norm_text(r, out);
    fputc('\n', out);
    print_time(out, "norm", r->norm_tc, r->norm_last);
    for (int k = 0; k < r->n; k++)
        print_time(out, r->name[k], r->tc[k], r->last[k]);
}

static int compare(const cns_options *o, const cns_number *delta, cns_table_reader *a, cns_table_reader *b)
{
    compare_context x = {.verbose = o->verbose > 0};
    cns_compare_result r;
    cns_error err;
    bool written = true;
    cns_text_open(&x.page);
    if (o->yaml) {
        x.summary = cns_summary_open(x.page.file);
        cns_summary_open_list(x.summary, "agreed");
    }
    const cns_compare_spec spec = {.a = cns_table_reader_rows(a),
                                   .b = cns_table_reader_rows(b),
                                   .delta = delta,
                                   .context = &x,
                                   .begin = on_begin,
                                   .row = on_row};
    cns_code code = cns_compare(&spec, &r, &err);
    if (x.summary) {
        cns_summary_shut(x.summary);
        written = code || print_yaml(x.summary, &r, delta->text);
        written = cns_summary_close(x.summary) && written;
    } else if (!code) {
        print_lines(x.page.file, &r, delta->text);
    }
    cns_compare_result_clear(&r);
    if (code || !written) {
        free(cns_text_close(&x.page, NULL));
        return code ? cns_complain(code, "%s", err.text)
                    : cns_complain(CNS_MEMORY, "out of memory: cannot write the summary");
    }
    return cns_page_write(&x.page, NULL);
}

static int run(cns_context *cx)
{
    const cns_options *o = cx->o;
    const char *const *names = o->operands.at;
    cns_number delta;
    cns_error err;
    if (!strcmp(names[0], "-") && !strcmp(names[1], "-"))
        return cns_complain(CNS_USAGE, "only one of the two tables can be standard input");
    cns_number_init(&delta);
    cns_number_parse(&delta, o->delta != NULL ? o->delta : CNS_STANDARD_DELTA, &err);
    cns_table_reader *a = cns_table_reader_open(names[0], &err);
    cns_table_reader *b = a ? cns_table_reader_open(names[1], &err) : NULL;
    int status = b ? compare(o, &delta, a, b) : cns_complain(err.code, "%s", err.text);
    cns_table_reader_close(a);
    cns_table_reader_close(b);
    cns_number_clear(&delta);
    return status;
}

const cns_command cns_command_compare = {
    .name = "compare",
    .run = run,
    .operands = "A B",
    .least = 2,
    .most = 2,
    .summary = "compare two tables: agreed decimals, first difference, T_c",
    .details =
        "A and B are tables of `cns run`, or any columns of numbers with a header, separated by commas,\n"
        "semicolons, tabs or blanks. Columns are matched by name and rows by time, exactly; nothing is\n"
        "interpolated. Printed are the decimals to which both agree in every common row, the first\n"
        "difference, and T_c with B as the reference; -v adds a column for each quantity.\n",
    .options = CNS_TAKES(CNS_OPTION_YAML, CNS_OPTION_DELTA, CNS_OPTION_QUIET, CNS_OPTION_VERBOSE),
};
