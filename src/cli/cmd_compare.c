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

typedef struct decimals_text {
    char text[32];
} decimals_text;

/* Of a value against a missing one -inf, which no least hides; of nothing `nothing`. */
static decimals_text text_of(long decimals, const char *nothing, const char *infinity)
{
    decimals_text d;
    if (decimals == CNS_COMPARE_NOTHING || decimals == CNS_COMPARE_MISSING)
        snprintf(d.text, sizeof d.text, "%s", decimals == CNS_COMPARE_NOTHING ? nothing : infinity);
    else
        snprintf(d.text, sizeof d.text, "%ld", decimals);
    return d;
}

/* A name as a value of a line whose values commas separate. */
static void print_name(FILE *out, const char *name)
{
    if (strpbrk(name, ",\"") == NULL) {
        fputs(name, out);
        return;
    }
    fputc('"', out);
    for (; *name; name++)
        fprintf(out, *name == '"' ? "\"%c" : "%c", *name);
    fputc('"', out);
}

static void on_begin(void *context, int n, const char *const *names)
{
    compare_context *x = context;
    x->n = n;
    x->names = names;
    if (x->summary)
        return;
    fputs("t,decimals", x->page.file);
    for (int k = 0; k < n && x->verbose; k++) {
        fputc(',', x->page.file);
        print_name(x->page.file, names[k]);
    }
    fputc('\n', x->page.file);
}

static void print_row(const compare_context *x, const char *t, long least, const long *each)
{
    fprintf(x->page.file, "%s,%s", t, text_of(least, "", "-inf").text);
    for (int k = 0; k < x->n && x->verbose; k++)
        fprintf(x->page.file, ",%s", text_of(each[k], "", "-inf").text);
    fputc('\n', x->page.file);
}

static void on_row(void *context, const char *t, long least, const long *each)
{
    const compare_context *x = context;
    if (!x->summary) {
        print_row(x, t, least, each);
        return;
    }
    cns_summary_open_mapping(x->summary, NULL);
    cns_summary_text(x->summary, "t", t);
    cns_summary_text(x->summary, "decimals", text_of(least, "null", "-.inf").text);
    if (x->verbose) {
        cns_summary_open_mapping(x->summary, "columns");
        for (int k = 0; k < x->n; k++)
            cns_summary_text(x->summary, x->names[k], text_of(each[k], "null", "-.inf").text);
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

/* One entry of the list of what was not compared. */
static void yaml_gap(cns_summary *s, const char *column, const char *what, const cns_compare_gap *gap,
                     const char *where, const char *side)
{
    if (gap->count == 0)
        return;
    cns_summary_open_mapping(s, NULL);
    if (column)
        cns_summary_text(s, "column", column);
    cns_summary_long(s, what, gap->count);
    cns_summary_text(s, where, side);
    cns_summary_text(s, "first", gap->first);
    cns_summary_shut(s);
}

static void yaml_not_compared(cns_summary *s, const cns_compare_result *r)
{
    static const char *const side[] = {"a", "b", "both"};
    cns_summary_open_list(s, "not_compared");
    for (int i = CNS_COMPARE_A; i <= CNS_COMPARE_B; i++) {
        for (int k = 0; k < r->n_only[i]; k++) {
            cns_summary_open_mapping(s, NULL);
            cns_summary_text(s, "column", r->only[i][k]);
            cns_summary_text(s, "only_in", side[i]);
            cns_summary_shut(s);
        }
        yaml_gap(s, NULL, "rows", &r->rows[i], "only_in", side[i]);
    }
    for (int k = 0; k < r->n; k++)
        for (int i = CNS_COMPARE_A; i <= CNS_COMPARE_BOTH; i++)
            yaml_gap(s, r->name[k], "values", &r->values[k][i], "missing_in", side[i]);
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
    if (r->first.t) {
        cns_summary_open_mapping(s, "first_difference");
        cns_summary_text(s, "t", r->first.t);
        cns_summary_text(s, "column", r->name[r->first.column]);
        cns_summary_text(s, "a", r->first.a ? r->first.a : "null");
        cns_summary_text(s, "b", r->first.b ? r->first.b : "null");
        cns_summary_shut(s);
    } else {
        cns_summary_text(s, "first_difference", "null");
    }
    yaml_not_compared(s, r);
    cns_summary_text(s, "delta", delta);
    cns_summary_text(s, "criterion", cns_tc_criterion_name(CNS_TC_ROWS));
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

static void print_not_compared(FILE *out, const cns_compare_result *r)
{
    static const char *const table[] = {"A", "B", "both"};
    for (int i = CNS_COMPARE_A; i <= CNS_COMPARE_B; i++) {
        for (int k = 0; k < r->n_only[i]; k++)
            fprintf(out, "# not compared: column %s, only in %s\n", r->only[i][k], table[i]);
        if (r->rows[i].count > 0)
            fprintf(out, "# not compared: %ld row%s only in %s, first at t = %s\n", r->rows[i].count,
                    r->rows[i].count == 1 ? "" : "s", table[i], r->rows[i].first);
    }
    for (int k = 0; k < r->n; k++)
        for (int i = CNS_COMPARE_A; i <= CNS_COMPARE_BOTH; i++) {
            const cns_compare_gap *gap = &r->values[k][i];
            if (gap->count > 0)
                fprintf(out, "# not compared: %ld value%s of %s, missing in %s, first at t = %s\n",
                        gap->count, gap->count == 1 ? "" : "s", r->name[k], table[i], gap->first);
        }
}

static void print_lines(FILE *out, const cns_compare_result *r, const char *delta)
{
    fprintf(out, "# common rows: %ld of %ld and %ld\n", r->common, r->rows_a, r->rows_b);
    print_not_compared(out, r);
    if (r->first.t)
        fprintf(out, "# first difference: t = %s, %s: %s and %s\n", r->first.t, r->name[r->first.column],
                r->first.a ? r->first.a : "no number", r->first.b ? r->first.b : "no number");
    else
        fputs("# first difference: none\n", out);
    fprintf(out, "# T_c, criterion rows: first common row beyond delta = %s; norm of ", delta);
    norm_text(r, out);
    fputc('\n', out);
    print_time(out, "norm", r->norm_tc, r->norm_last);
    for (int k = 0; k < r->n; k++)
        print_time(out, r->name[k], r->tc[k], r->last[k]);
}

/* The exit status of --decimals. */
static int judge(const cns_compare_result *r, long decimals)
{
    int status = 0;
    if (r->n_few > 0)
        status = cns_complain(CNS_UNREACHED,
                              "%ld value%s to fewer than %ld decimals, first at t = %s, %s: %s and %s",
                              r->n_few, r->n_few == 1 ? " agrees" : "s agree", decimals, r->few.t,
                              r->name[r->few.column], r->few.a, r->few.b);
    if (!cns_compare_whole(r))
        status = cns_complain(CNS_UNREACHED,
                              "not all was compared: the lines or the list 'not compared' say what was not");
    return status;
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
                                   .decimals = o->decimals,
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
    int status = 0;
    if (code || !written) {
        free(cns_text_close(&x.page, NULL));
        status = code ? cns_complain(code, "%s", err.text)
                      : cns_complain(CNS_MEMORY, "out of memory: cannot write the summary");
    } else {
        status = cns_page_write(&x.page, NULL);
    }
    if (!status && o->decimals > 0)
        status = judge(&r, o->decimals);
    cns_compare_result_clear(&r);
    return status;
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
    .reads = true,
    .operands = "A B",
    .least = 2,
    .most = 2,
    .summary = "compare two tables: agreed decimals, first difference, T_c",
    .details =
        "A and B are tables of `cns run`, or any columns of numbers with a header, separated by commas, "
        "semicolons, tabs or blanks. Columns are matched by name and rows by time, exactly; nothing is "
        "interpolated. Printed are the decimals to which both agree in every common row, what was not "
        "compared, the first difference, and T_c with B as the reference, at the rows that both have (the "
        "criterion `rows` of `cns tc`; between "
        "rows nothing is known, so T_c depends on them); -v adds a column for each "
        "quantity. With --decimals N the exit status is 1 if two values agree to fewer decimals, or if "
        "anything was not compared.\n",
    .options = CNS_TAKES(CNS_OPTION_YAML, CNS_OPTION_DECIMALS_AGREED, CNS_OPTION_DELTA, CNS_OPTION_QUIET,
                         CNS_OPTION_VERBOSE),
};
