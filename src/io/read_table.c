#include "read_table.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "case_internal.h"
#include "core/memory.h"
#include "core/text.h"
#include "num/exact_decimal.h"
#include "provenance.h"
#include "write_table.h"

struct cns_table_reader {
    char *shown; /* the name, fit for messages */
    FILE *file;
    cns_rows rows;
    mpz_t denominator; /* rows.denominator */
    char *line;        /* the line at hand, cut into values */
    size_t room;
    long number;    /* of the line, from 1 */
    bool noted;     /* a note behind the values was left out */
    char separator; /* ' ': blanks and tabs, any number of them; 0: not known yet */
    char mark;      /* '.' or ',', the decimal mark of the numbers so far; 0: there was none */
    char *comment;  /* the last line of comment before the values, without its # */
    long comment_number;
    char *held; /* a row that stood where the header should; NULL: none, or it has been given */
    int n, room_cells;
    char **cell; /* n values of the line */
    int *place;  /* n: at which character of the line each begins, from 1 */
    char **name; /* rows.n: of the columns */
    char *model; /* rows.model */
    cns_exact_decimal number_at_hand;
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

/* Lines. */

static void put(cns_table_reader *r, size_t at, int c)
{
    if (at == r->room) {
        r->room = 2 * r->room + 256;
        r->line = cns_xgrow(r->line, r->room, 1);
    }
    r->line[at] = (char)c;
}

/* The next line without its end; false at the end of the file, or with *code. */
static bool read_line(cns_table_reader *r, cns_code *code, cns_error *err)
{
    size_t n = 0;
    errno = 0;
    int c = getc_unlocked(r->file);
    *code = CNS_OK;
    if (c != EOF)
        r->number++;
    const bool any = c != EOF;
    for (; c != EOF && c != '\n' && c != '\r'; c = getc_unlocked(r->file)) {
        put(r, n++, c);
        if (r->number == 1 && n == 2 && (!memcmp(r->line, "\xFF\xFE", 2) || !memcmp(r->line, "\xFE\xFF", 2)))
            *code = wrong(r, 1, err, "a text in UTF-16: save it as UTF-8");
        else if (c == '\0')
            *code = wrong(r, (int)n, err, "a zero byte: this is not a text");
        if (*code)
            return false;
    }
    if (c == '\r') { /* CR LF, or CR alone */
        c = getc_unlocked(r->file);
        if (c != '\n' && c != EOF)
            ungetc(c, r->file);
    }
    put(r, n, '\0');
    if (ferror(r->file))
        *code = cns_fail(err, CNS_IO, "cannot read %s: %s", r->shown, strerror(errno));
    if (r->number == 1 && !strncmp(r->line, "\xEF\xBB\xBF", 3)) /* a byte order mark */
        memmove(r->line, r->line + 3, n - 3 + 1);
    return any && !*code;
}

/* What stands behind the # of a line of comment; NULL: it is none. Spreadsheets put such lines in quotes. */
static const char *comment_in(const char *line)
{
    line += strspn(line, " \t");
    line += *line == '"';
    if (*line != '#')
        return NULL;
    line += strspn(line, "#");
    return line + strspn(line, " \t");
}

static bool begins(const char *text, const char *with)
{
    return !strncmp(text, with, strlen(with));
}

/* A natural number at the beginning of a text; false: there is none. */
static bool read_natural(mpz_t x, const char *text)
{
    char *digits = cns_xcopy_n(text, strspn(text, "0123456789"));
    const bool good = *digits != '\0' && mpz_set_str(x, digits, 10) == 0;
    free(digits);
    return good;
}

static cns_code check_format(const cns_table_reader *r, const char *text, cns_error *err)
{
    mpz_t format;
    mpz_init(format);
    const bool known = read_natural(format, text) && mpz_cmp_ui(format, CNS_TABLE_FORMAT) <= 0;
    mpz_clear(format);
    return known ? CNS_OK
                 : wrong(r, 1, err,
                         "a table of format %s, from a newer cns: this one reads tables up to format %d",
                         cns_quote(text).text, CNS_TABLE_FORMAT);
}

/* "# cns VERSION: ...", "# format: N", "# times: ..." and "# | model: NAME" of our tables, "# model: NAME" of
 * others. */
static cns_code read_comment(cns_table_reader *r, const char *at, cns_error *err)
{
    if (r->number == 1 && begins(at, "cns "))
        r->rows.ours = true;
    if (r->rows.ours && begins(at, "format: "))
        return check_format(r, at + strlen("format: "), err);
    if (r->rows.ours && begins(at, CNS_TABLE_TIMES)) {
        if (!read_natural(r->denominator, at + strlen(CNS_TABLE_TIMES)) || mpz_sgn(r->denominator) == 0)
            return wrong(r, 1, err, "times are to be had back in a way that is not known");
        r->rows.denominator = r->denominator;
        return CNS_OK;
    }
    if (*at == '|')
        at += 1 + strspn(at + 1, " \t");
    if (r->model || !begins(at, "model:"))
        return CNS_OK;
    at += strlen("model:");
    at += strspn(at, " \t\"'");
    const size_t n = strcspn(at, " \t\"';,#");
    if (n > 0)
        r->rows.model = r->model = cns_xcopy_n(at, n);
    return CNS_OK;
}

/* The next line that is neither a comment nor empty; false as read_line(). */
static bool read_content(cns_table_reader *r, cns_code *code, cns_error *err)
{
    while (read_line(r, code, err)) {
        const char *comment = comment_in(r->line);
        if (!comment && r->line[strspn(r->line, " \t")] != '\0')
            return true;
        if (!comment || r->rows.n > 0)
            continue;
        *code = read_comment(r, comment, err);
        if (*code)
            return false;
        free(r->comment);
        r->comment = cns_xcopy(comment);
        r->comment_number = r->number;
    }
    return false;
}

/* Values. */

/* Behind the quotation that begins at `text`; NULL: it does not end. */
static char *quotation_end(char *text)
{
    for (text++; *text; text++)
        if (*text == '"' && *++text != '"')
            return text;
    return NULL;
}

/* The first of these characters that is not in quotes; the end if there is none. A quotation begins where a
 * value does. */
static char *find_plain(char *line, const char *characters)
{
    char stops[8], *at = line;
    snprintf(stops, sizeof stops, "%s\"", characters);
    while (*(at += strcspn(at, stops)) == '"') {
        char *end = at == line || strchr(" \t,;|", at[-1]) ? quotation_end(at) : NULL;
        at = end ? end : at + 1;
    }
    return at;
}

/* Ends the line where a note begins: at a # behind a blank. */
static void drop_note(cns_table_reader *r, char *line)
{
    char *at = line;
    r->noted = false;
    if (!strchr(line, '#'))
        return;
    while (*(at = find_plain(at, "#")) && (at == line || (at[-1] != ' ' && at[-1] != '\t')))
        at++;
    if (*at) {
        r->noted = true;
        *at = '\0';
    }
}

static char separator_of(char *line)
{
    return *find_plain(line, ";") ? ';' : *find_plain(line, ",") ? ',' : *find_plain(line, "\t") ? '\t' : ' ';
}

/* One value: without blanks at its ends, and without the quotes around it. */
static void add_cell(cns_table_reader *r, const char *line, char *begin, char *end)
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
    r->place[r->n] = (int)(begin - line) + 1;
    *end = '\0';
    r->cell[r->n++] = begin;
    if (*begin != '"' || end - begin < 2 || end[-1] != '"')
        return;
    r->cell[r->n - 1] = ++begin;
    end[-1] = '\0';
    for (char *to = begin; (*to = *begin) != '\0'; to++)
        begin += *begin == '"' ? 2 : 1; /* a doubled quote */
}

/* Cuts a line into values. */
static void cut(cns_table_reader *r, char *line)
{
    const char plain[2] = {r->separator, '\0'};
    const char *ends = r->separator == ' ' ? " \t" : plain;
    char *at = line;
    r->n = 0;
    drop_note(r, line);
    for (;;) {
        at += strspn(at, r->separator == '\t' ? " " : " \t");
        if (!*at && r->separator == ' ')
            return;
        char *end = find_plain(at, ends);
        const bool last = *end == '\0';
        add_cell(r, line, at, end);
        if (last)
            return;
        at = end + 1;
    }
}

/* A separator at the end of a line makes no value. */
static void drop_last_if_empty(cns_table_reader *r, int above)
{
    if (r->n > above && r->cell[r->n - 1][0] == '\0')
        r->n--;
}

/* How programs write that there is no number. 1.#QNAN and its like are Microsoft's. */
static bool is_missing(const char *text)
{
    static const char *const words[] = {"nan", "na",       "n/a",    "#n/a",   "<na>",    "null",   "none",
                                        "inf", "infinity", "1.#inf", "1.#ind", "1.#qnan", "1.#snan"};
    char word[16];
    if (text[0] == '\0')
        return true;
    text += *text == '-' || *text == '+';
    const bool microsoft = begins(text, "1.#");
    if (strchr("0123456789.", *text) && !microsoft)
        return false;
    if (!strncasecmp(text, "nan(", 4))
        return true;
    size_t n = strlen(text);
    while (microsoft && text[n - 1] == '0') /* of a %f */
        n--;
    if (n >= sizeof word)
        return false;
    memcpy(word, text, n);
    word[n] = '\0';
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (!strcasecmp(word, words[i]))
            return true;
    return false;
}

static bool is_number(cns_table_reader *r, const char *text)
{
    return cns_exact_decimal_parse(&r->number_at_hand, text) == NULL;
}

/* Makes points of decimal commas: where semicolons separate, and never both in one table, since then one of
 * them would part thousands. */
static cns_code unify_marks(cns_table_reader *r, cns_error *err)
{
    for (int i = 0; i < r->n && r->separator == ';'; i++) {
        char *at = strpbrk(r->cell[i], ".,");
        if (!at)
            continue;
        const char mark = *at;
        *at = '.';
        if (!is_number(r, r->cell[i])) {
            *at = mark;
            continue;
        }
        if (r->mark && mark != r->mark) {
            *at = mark;
            return wrong(
                r, r->place[i], err, "'%s' has a decimal %s, but numbers before it have a decimal %s",
                cns_quote(r->cell[i]).text, mark == ',' ? "comma" : "point", mark == ',' ? "point" : "comma");
        }
        r->mark = mark;
    }
    return CNS_OK;
}

/* Are all values of the line numbers or missing, and not all missing? */
static bool is_row(cns_table_reader *r)
{
    int numbers = 0;
    for (int i = 0; i < r->n; i++) {
        if (is_number(r, r->cell[i]))
            numbers++;
        else if (!is_missing(r->cell[i]))
            return false;
    }
    return numbers > 0;
}

/* The header. */

/* Excel's first line `sep=,`. */
static bool read_separator(cns_table_reader *r)
{
    char *at = r->line + (r->line[0] == '"');
    if (r->number != 1 || !begins(at, "sep=") || !at[4] || strchr("\"#", at[4]))
        return false;
    r->separator = at[4];
    return true;
}

/* Names the columns after the values of the line at hand. */
static cns_code name_columns(cns_table_reader *r, cns_error *err)
{
    r->rows.n = r->n;
    r->name = cns_xalloc((size_t)r->n, sizeof *r->name);
    r->rows.time = -1;
    for (int i = 0; i < r->n; i++) {
        r->name[i] = cns_text_printable(r->cell[i]);
        if (is_number(r, r->cell[i]))
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

/* The line at hand is a row of n values: the names stand in the comment above it, separated like the row or
 * in their own way. */
static cns_code names_in_comment(cns_table_reader *r, int n, cns_error *err)
{
    const char of_rows = r->separator;
    const long number = r->number;
    char *names = NULL;
    r->n = 0;
    for (int own = 0; own < 2 && r->comment && r->n != n; own++) {
        free(names);
        names = cns_xcopy(r->comment);
        r->separator = own ? separator_of(names) : of_rows;
        cut(r, names);
        drop_last_if_empty(r, n);
    }
    r->separator = of_rows;
    r->number = r->comment_number;
    const bool found = r->n == n && !is_row(r);
    cns_code code = found ? name_columns(r, err) : CNS_OK;
    r->number = number;
    free(names);
    if (found)
        return code;
    return wrong(r, 1, err,
                 "no header: put a line with the names of the %d columns above the numbers, such as t,x%s", n,
                 n > 2 ? ",y" : "");
}

static cns_code read_header(cns_table_reader *r, cns_error *err)
{
    cns_code code;
    do
        if (!read_content(r, &code, err))
            return code ? code : wrong(r, 1, err, "no header line: this is not a table");
    while (read_separator(r));
    const size_t word = strcspn(r->line, ":");
    for (const cns_key *k = cns_keys; k < cns_keys + CNS_KEYS; k++)
        if (r->line[word] == ':' && (r->line[word + 1] == ' ' || r->line[word + 1] == '\0') &&
            strlen(k->path) == word && strncmp(r->line, k->path, word) == 0)
            return wrong(r, 1, err, "this looks like a case file, not a table: `cns run` makes the table");
    char *whole = cns_xcopy(r->line);
    if (!r->separator)
        r->separator = separator_of(r->line);
    cut(r, r->line);
    drop_last_if_empty(r, 1);
    code = unify_marks(r, err);
    const bool row = !code && is_row(r);
    if (row)
        r->held = whole;
    else
        free(whole);
    return code ? code : row ? names_in_comment(r, r->n, err) : name_columns(r, err);
}

/* The rows. */

static cns_code next(void *context, bool *more, cns_error *err)
{
    cns_table_reader *r = context;
    cns_code code = CNS_OK;
    *more = r->held != NULL || read_content(r, &code, err);
    if (!*more)
        return code;
    if (r->held) {
        free(r->line);
        r->line = r->held;
        r->room = strlen(r->line) + 1;
        r->held = NULL;
    }
    cut(r, r->line);
    if (r->n == r->rows.n + 1)
        drop_last_if_empty(r, 1);
    if (r->n == r->rows.n)
        return unify_marks(r, err);
    return wrong(r, r->place[r->n > r->rows.n ? r->rows.n : r->n - 1], err,
                 "%d value%s, but the header names %d column%s%s", r->n, r->n == 1 ? "" : "s", r->rows.n,
                 r->rows.n == 1 ? "" : "s", r->noted ? "; what follows # is a note" : "");
}

static const char *text(void *context, int column)
{
    const cns_table_reader *r = context;
    return is_missing(r->cell[column]) ? NULL : r->cell[column];
}

static const char *name(void *context, int column)
{
    const cns_table_reader *r = context;
    return r->name[column];
}

static cns_code refuse(void *context, int column, const char *why, cns_error *err)
{
    const cns_table_reader *r = context;
    const char *cell = r->cell[column];
    const bool comma = r->separator != ';' && strchr(cell, ',') != NULL;
    return wrong(r, r->place[column], err, "'%s' in column '%s': %s%s", cns_quote(cell).text,
                 cns_quote(r->name[column]).text, why,
                 comma ? " (a decimal comma needs semicolons between the values)" : "");
}

cns_table_reader *cns_table_reader_open(const char *path, cns_error *err)
{
    cns_table_reader *r = cns_xalloc(1, sizeof *r);
    const bool standard = !strcmp(path, "-");
    r->shown = standard ? cns_xcopy("<stdin>") : cns_text_printable(path);
    r->rows = (cns_rows){.context = r, .name = name, .next = next, .text = text, .refuse = refuse};
    mpz_init(r->denominator);
    cns_exact_decimal_init(&r->number_at_hand);
    r->file = standard ? stdin : fopen(path, "r");
    cns_code code = r->file ? read_header(r, err)
                            : cns_fail(err, CNS_IO, "cannot read %s: %s", r->shown, strerror(errno));
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
    free(r->comment);
    free(r->held);
    free(r->model);
    free(r->shown);
    mpz_clear(r->denominator);
    cns_exact_decimal_clear(&r->number_at_hand);
    free(r);
}

const cns_rows *cns_table_reader_rows(cns_table_reader *r)
{
    return &r->rows;
}
