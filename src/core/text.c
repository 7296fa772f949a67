#include "text.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>

#include "memory.h"

int cns_utf8_length(const unsigned char *s, size_t n)
{
    unsigned char c = s[0];
    int length;
    unsigned long code;
    if (c < 0x80)
        return 1;
    if (c >= 0xC2 && c <= 0xDF) {
        length = 2;
        code = c & 0x1Fu;
    } else if (c >= 0xE0 && c <= 0xEF) {
        length = 3;
        code = c & 0x0Fu;
    } else if (c >= 0xF0 && c <= 0xF4) {
        length = 4;
        code = c & 0x07u;
    } else {
        return 0;
    }
    if ((size_t)length > n)
        return 0;
    for (int i = 1; i < length; i++) {
        if ((s[i] & 0xC0) != 0x80)
            return 0;
        code = code << 6 | (s[i] & 0x3Fu);
    }
    /* overlong forms, surrogates, beyond Unicode */
    if ((length == 3 && code < 0x800) || (length == 4 && code < 0x10000) || code > 0x10FFFF ||
        (code >= 0xD800 && code <= 0xDFFF))
        return 0;
    return length;
}

/* Copies the characters of s into `to`, those that are no text as '?', as long as they fit into `room`
 * bytes. Returns the bytes written; *whole tells whether all fitted. No NUL is added. */
static size_t copy_printable(char *to, size_t room, const char *s, bool *whole)
{
    size_t used = 0, left = strlen(s);
    *whole = true;
    while (left > 0) {
        int length = cns_utf8_length((const unsigned char *)s, left);
        size_t step = length > 0 ? (size_t)length : 1;
        if (used + step > room) {
            *whole = false;
            break;
        }
        unsigned char c = (unsigned char)s[0];
        /* C1 control characters are two bytes, C2 80..9F */
        bool c1 = c == 0xC2 && length == 2 && (unsigned char)s[1] < 0xA0;
        if (length == 0 || c < 0x20 || c == 0x7F || c1) {
            to[used++] = '?';
        } else {
            memmove(to + used, s, step); /* `to` may be s itself */
            used += step;
        }
        s += step;
        left -= step;
    }
    return used;
}

cns_quotation cns_quote(const char *s)
{
    cns_quotation q;
    bool whole;
    size_t used = copy_printable(q.text, CNS_QUOTE - 4, s, &whole); /* room for "..." and the NUL */
    strcpy(q.text + used, whole ? "" : "...");
    return q;
}

char *cns_text_printable(const char *s)
{
    bool whole;
    size_t room = strlen(s);
    char *copy = cns_xalloc(room + 1, 1);
    copy_printable(copy, room, s, &whole);
    return copy;
}

void cns_text_make_printable(char *s)
{
    bool whole;
    s[copy_printable(s, strlen(s), s, &whole)] = '\0';
}

static int lower(char c)
{
    return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c;
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

int cns_text_distance(const char *a, const char *b)
{
    enum { LONGEST = 63 };
    size_t na = strlen(a), nb = strlen(b);
    if (na > LONGEST || nb > LONGEST)
        return INT_MAX;
    int rows[3][LONGEST + 1]; /* the row before last, the last, the one at work */
    int *before = rows[0], *last = rows[1], *row = rows[2];
    for (size_t j = 0; j <= nb; j++)
        last[j] = before[j] = (int)j;
    for (size_t i = 1; i <= na; i++) {
        row[0] = (int)i;
        for (size_t j = 1; j <= nb; j++) {
            int change = lower(a[i - 1]) != lower(b[j - 1]);
            int d = least(least(last[j], row[j - 1]) + 1, last[j - 1] + change);
            if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]))
                d = least(d, before[j - 2] + 1);
            row[j] = d;
        }
        int *spare = before;
        before = last;
        last = row;
        row = spare;
    }
    return last[nb];
}

static size_t shared_beginning(const char *a, const char *b)
{
    size_t n = 0;
    while (a[n] != '\0' && lower(a[n]) == lower(b[n]))
        n++;
    return n;
}

const char *cns_text_nearest(const char *s, int n, const char *(*name)(int i, const void *context),
                             const void *context)
{
    const char *nearest = NULL;
    int least_edits = INT_MAX;
    for (int i = 0; i < n; i++) {
        const char *candidate = name(i, context);
        int edits = cns_text_distance(s, candidate);
        /* one edit in three letters is a slip; more is another word */
        if (edits < least_edits && edits <= (int)(strlen(candidate) + 1) / 3 &&
            edits < (int)strlen(candidate)) {
            nearest = candidate;
            least_edits = edits;
        }
    }
    size_t most = 2; /* shared first letters say nothing if they are fewer than three */
    for (int i = 0; i < n && least_edits == INT_MAX; i++) {
        const char *candidate = name(i, context);
        const size_t length = strlen(s), whole = strlen(candidate), shared = shared_beginning(s, candidate);
        if (shared > most && shared + 1 >= (length < whole ? length : whole)) {
            nearest = candidate;
            most = shared;
        }
    }
    return nearest;
}

void cns_text_list(char *to, size_t size, const char *const *names, int n)
{
    size_t used = 0;
    to[0] = '\0';
    for (int i = 0; i < n && used < size; i++) {
        const char *before = i == 0 ? "" : i == n - 1 ? " or " : ", ";
        const int written = snprintf(to + used, size - used, "%s%s", before, names[i]);
        used += written > 0 ? (size_t)written : 0;
    }
}

/* Columns that n bytes of text take, if every character takes one. */
static int columns(const char *s, size_t n)
{
    int count = 0;
    for (size_t i = 0; i < n; count++) {
        const int step = cns_utf8_length((const unsigned char *)s + i, n - i);
        i += step > 0 ? (size_t)step : 1;
    }
    return count;
}

/* Where the text behind the last gap in the first half of a line begins; behind leading blanks, if there is
 * no other. */
static int text_column(const char *line, size_t length, int width)
{
    int column = 0, found = 0;
    for (size_t i = 0; i < length && column <= width / 2;) {
        const size_t word = strcspn(line + i, " "), blanks = strspn(line + i + word, " ");
        column += columns(line + i, word) + (int)blanks;
        i += word + blanks;
        if ((word == 0 || blanks > 1) && i < length && column <= width / 2)
            found = column;
    }
    return found;
}

static void fold_line(FILE *out, const char *line, size_t length, int width, int hang)
{
    const int under = text_column(line, length, width), lead = under > hang ? under : hang;
    int column = 0;
    for (size_t i = 0; i < length;) {
        const size_t blanks = strspn(line + i, " "), word = strcspn(line + i + blanks, " \n");
        const int wide = columns(line + i + blanks, word);
        if (i > 0 && column + (int)blanks + wide > width && column > lead) {
            fprintf(out, "\n%*s", lead, "");
            column = lead + wide;
        } else {
            fprintf(out, "%*s", (int)blanks, "");
            column += (int)blanks + wide;
        }
        fwrite(line + i + blanks, 1, word, out);
        i += blanks + word;
    }
    fputc('\n', out);
}

void cns_text_fold(FILE *out, const char *text, int width, int hang)
{
    do {
        const size_t length = strcspn(text, "\n");
        fold_line(out, text, length, width, hang);
        text += length + (text[length] == '\n');
    } while (*text != '\0');
}
