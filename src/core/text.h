/* Helpers for messages. */
#ifndef CNS_CORE_TEXT_H
#define CNS_CORE_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#define CNS_QUOTE 64 /* bytes enough for any quotation */

typedef struct cns_quotation {
    char text[CNS_QUOTE];
} cns_quotation;

/* User text for a message: control characters and stray bytes as '?', cut with "..." when long.
 * Use as cns_quote(s).text in the same full expression. */
cns_quotation cns_quote(const char *s);

/* A new copy of any length, free of control characters and stray bytes: a name fit for one line. */
char *cns_text_printable(const char *s);

/* The same in place. */
void cns_text_make_printable(char *s);

/* Edits (insert, delete, replace, swap of neighbours), letters compared without case. Texts longer
 * than 63 bytes count as entirely different. */
int cns_text_distance(const char *a, const char *b);

/* The nearest of n names when it is near enough to be a likely meaning, else the one that it abbreviates, as
 * `out` does `output`, or goes on from, but for its last letter; else NULL. The first of equally near ones
 * wins. name(i, context) gives the names. */
const char *cns_text_nearest(const char *s, int n, const char *(*name)(int i, const void *context),
                             const void *context);

/* "a, b or c", cut where `to` is full. */
void cns_text_list(char *to, size_t size, const char *const *names, int n);

/* Prints a text of one or more lines, folded at blanks into lines of at most `width` columns as far as there
 * are blanks. A line goes on at least `hang` columns from the left; where it has a gap of two blanks or more
 * in its first half, as in "  KEY   MEANING", it goes on under the text behind the last of them. A newline
 * ends the text, whether it has one or not. */
void cns_text_fold(FILE *out, const char *text, int width, int hang);

/* Length of the valid UTF-8 sequence at s (1..4), 0 if it is not one. n > 0 bytes may be read. */
int cns_utf8_length(const unsigned char *s, size_t n);

#endif
