#include "read_table.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "core/memory.h"
#include "core/text.h"

struct cns_table_reader {
    char *shown; /* the name, fit for messages */
    FILE *file;
    cns_rows rows;
    char *line; /* the line at hand, cut into values */
    size_t room;
    long number;    /* of the line, from 1 */
    char separator; /* ' ': blanks and tabs, any number of them */
    int n, room_cells;
    char **cell; /* n values of the line */
    int *place;  /* n: at which character of the line each begins, from 1 */
    char **name; /* rows.n: of the columns */
    char *model; /* rows.model */
};

/* "FILE:LINE:PLACE: " and what is wrong there. */
#if defined(__GNUC__)
__attribute__((format(printf, 4, 5)))
#endif
static cns_code
wrong(const cns_table_reader *r, int place, cns_error *err, const char *format, ...)
{
    char what[512];
    va_list args;
    va_start(args, format);
    if (vsnprintf(what, sizeof what, format, args) < 0)
        what[0] = '\0';
    va_end(args);
    return cns_fail(err, CNS_USAGE, "%s:%ld:%d: %s", r->shown, r->number > 0 ? r->number : 1, place, what);
}

/* The next line without its end; false at the end of the file, or with *code. */
static bool read_line(cns_table_reader *r, cns_code *code, cns_error *err)
{
    errno = 0;
    ssize_t length = getline(&r->line, &r->room, r->file);
    *code = CNS_OK;
    if (length < 0) {
        if (errno == ENOMEM)
            *code = cns_out_of_memory(err);
        else if (ferror(r->file))
            *code = cns_fail(err, CNS_IO, "cannot read %s: %s", r->shown, strerror(errno));
        return false;
    }
    r->number++;
    size_t n = (size_t)length;
    const char *zero = memchr(r->line, '\0', n);
    if (zero) {
        *code = wrong(r, (int)(zero - r->line) + 1, err, "a zero byte: this is not a text");
        return false;
    }
    while (n > 0 && (r->line[n - 1] == '\n' || r->line[n - 1] == '\r'))
        r->line[--n] = '\0';
    if (r->number == 1 && !strncmp(r->line, "\xEF\xBB\xBF", 3)) /* a byte order mark */
        memmove(r->line, r->line + 3, n - 3 + 1);
    return true;
}

/* "# cns VERSION: ..." and "# | model: NAME" of our tables, "# model: NAME" of others. */
static void read_comment(cns_table_reader *r)
{
    const char *at = strchr(r->line, '#') + 1;
    at += strspn(at, " \t");
    if (r->number == 1 && !strncmp(at, "cns ", 4))
        r->rows.ours = true;
    if (*at == '|')
        at += 1 + strspn(at + 1, " \t");
    if (r->model || strncmp(at, "model:", 6) != 0)
        return;
    at += 6;
    at += strspn(at, " \t\"'");
    size_t n = strcspn(at, " \t\"';,#");
    if (n > 0)
        r->rows.model = r->model = cns_xcopy_n(at, n);
}

static bool is_comment(const char *line)
{
    return line[strspn(line, " \t")] == '#';
}

static bool is_empty(const char *line)
{
    return line[strspn(line, " \t")] == '\0';
}

/* The next line that is neither a comment nor empty; false as read_line(). */
static bool read_content(cns_table_reader *r, cns_code *code, cns_error *err)
{
    while (read_line(r, code, err)) {
        if (is_comment(r->line))
            read_comment(r);
        else if (!is_empty(r->line))
            return true;
    }
    return false;
}

/* One value: without blanks at its ends, and without the quotes around it. */
static void add_cell(cns_table_reader *r, char *begin, char *end)
{
    while (begin < end && (*begin == ' ' || *begin == '\t'))
        begin++;
    while (end > begin && (end[-1] == ' ' || end[-1] == '\t'))
        end--;
    if (r->n == r->room_cells) {
        r->room_cells = r->room_cells * 2 + 16;
        r->cell = cns_xgrow(r->cell, (size_t)r->room_cells, sizeof *r->cell);
        r->place = cns_xgrow(r->place, (size_t)r->room_cells, sizeof *r->place);
    }
    r->place[r->n] = (int)(begin - r->line) + 1;
    if (end - begin >= 2 && *begin == '"' && end[-1] == '"') {
        begin++;
        end--;
    }
    *end = '\0';
    r->cell[r->n++] = begin;
}

/* Cuts the line at hand into values. */
static void cut(cns_table_reader *r)
{
    char *at = r->line;
    r->n = 0;
    if (r->separator == ' ') {
        for (at += strspn(at, " \t"); *at;) {
            char *end = at + strcspn(at, " \t");
            char *next = end + strspn(end, " \t");
            add_cell(r, at, end);
            at = next;
        }
        return;
    }
    for (char *end; (end = strchr(at, r->separator)) != NULL; at = end + 1)
        add_cell(r, at, end);
    add_cell(r, at, at + strlen(at));
}

static bool looks_like_number(const char *text)
{
    char *end;
    strtod(text, &end);
    return *text && *end == '\0' && strspn(text, "+-.0123456789eE") == strlen(text);
}

static cns_code read_header(cns_table_reader *r, cns_error *err)
{
    cns_code code;
    if (!read_content(r, &code, err))
        return code ? code : wrong(r, 1, err, "no header line: this is not a table");
    r->separator = strchr(r->line, ',')    ? ','
                   : strchr(r->line, ';')  ? ';'
                   : strchr(r->line, '\t') ? '\t'
                                           : ' ';
    cut(r);
    if (r->n > 1 && r->cell[r->n - 1][0] == '\0') /* a separator at the end of the line */
        r->n--;
    r->rows.n = r->n;
    r->name = cns_xalloc((size_t)r->n, sizeof *r->name);
    r->rows.time = -1;
    for (int i = 0; i < r->n; i++) {
        r->name[i] = cns_text_printable(r->cell[i]);
        if (looks_like_number(r->cell[i]))
            return wrong(r, r->place[i], err, "a number where the header should name the columns");
        for (int j = 0; j < i; j++)
            if (*r->name[i] && !strcmp(r->name[i], r->name[j]))
                return wrong(r, r->place[i], err, "a second column '%s'", cns_quote(r->name[i]).text);
        if (r->rows.time < 0 && (!strcasecmp(r->name[i], "t") || !strcasecmp(r->name[i], "time")))
            r->rows.time = i;
    }
    if (r->rows.time < 0)
        r->rows.time = 0;
    return CNS_OK;
}

static cns_code next(void *context, bool *more, cns_error *err)
{
    cns_table_reader *r = context;
    cns_code code;
    *more = read_content(r, &code, err);
    if (!*more)
        return code;
    cut(r);
    if (r->n == r->rows.n + 1 && r->cell[r->n - 1][0] == '\0')
        r->n--;
    if (r->n == r->rows.n)
        return CNS_OK;
    return wrong(r, r->place[r->n > r->rows.n ? r->rows.n : r->n - 1], err,
                 "%d value%s, but the header names %d column%s", r->n, r->n == 1 ? "" : "s", r->rows.n,
                 r->rows.n == 1 ? "" : "s");
}

static const char *text(void *context, int column)
{
    static const char *const missing[] = {"", "nan", "-nan", "+nan", "na", "n/a"};
    const cns_table_reader *r = context;
    for (size_t i = 0; i < sizeof missing / sizeof *missing; i++)
        if (!strcasecmp(r->cell[column], missing[i]))
            return NULL;
    return r->cell[column];
}

static const char *name(void *context, int column)
{
    const cns_table_reader *r = context;
    return r->name[column];
}

static cns_code refuse(void *context, int column, const char *why, cns_error *err)
{
    const cns_table_reader *r = context;
    return wrong(r, r->place[column], err, "'%s' in column '%s': %s", cns_quote(r->cell[column]).text,
                 cns_quote(r->name[column]).text, why);
}

cns_table_reader *cns_table_reader_open(const char *path, cns_error *err)
{
    cns_table_reader *r = cns_xalloc(1, sizeof *r);
    const bool standard = !strcmp(path, "-");
    r->shown = standard ? cns_xcopy("<stdin>") : cns_text_printable(path);
    r->rows = (cns_rows){.context = r, .name = name, .next = next, .text = text, .refuse = refuse};
    r->file = standard ? stdin : fopen(path, "r");
    cns_code code = r->file ? read_header(r, err)
                            : cns_fail(err, errno == ENOMEM ? CNS_MEMORY : CNS_IO, "cannot read %s: %s",
                                       r->shown, strerror(errno));
    if (!code)
        return r;
    cns_table_reader_close(r);
    return NULL;
}

void cns_table_reader_close(cns_table_reader *r)
{
    if (!r)
        return;
    if (r->file && r->file != stdin)
        fclose(r->file);
    for (int i = 0; r->name && i < r->rows.n; i++)
        free(r->name[i]);
    free(r->name);
    free(r->cell);
    free(r->place);
    free(r->line);
    free(r->model);
    free(r->shown);
    free(r);
}

const cns_rows *cns_table_reader_rows(cns_table_reader *r)
{
    return &r->rows;
}
