/* What the commands say: messages, and results as text or as a summary, in output that does not fail in
 * silence. */
#ifndef CNS_CLI_REPORT_H
#define CNS_CLI_REPORT_H

#include <stdio.h>

#include "cns/status.h"
#include "context.h"
#include "core/files.h"
#include "io/summary.h"

/* "cns: MESSAGE" on standard error; returns code. */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
int cns_complain(cns_code code, const char *format, ...);

/* "CASE:1:1: MESSAGE": the case lacks what the command needs. Returns CNS_USAGE. */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
int cns_complain_of_case(const cns_case *c, const char *format, ...);

/* "cns: NOTE" on standard error, unless -q was given; the progress line is taken away. */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
void cns_note(cns_context *cx, const char *format, ...);

/* Text on standard error: on a terminal folded to its width, else as it is. */
void cns_say(const char *text);

/* How a command shows its result. */
typedef struct cns_view {
    void (*text)(FILE *out, const cns_context *cx, const void *result);
    void (*yaml)(cns_summary *s, const cns_context *cx, const void *result); /* NULL: takes no --yaml */
    bool folded;  /* the text is for people: to the terminal's width, or CNS_TEXT_WIDTH without one */
    bool to_file; /* -o FILE takes the text, and with --yaml the summary goes to standard output beside it */
} cns_view;

/* The result to standard output, as a summary with --yaml, else as text. An exit status, with the message
 * out. */
int cns_show(const cns_context *cx, const cns_view *view, const void *result);

/* What a study answered: its result, unless that is NULL, and then the message of `code`. An exit status:
 * that of showing, if it failed, else that of `code`. */
int cns_report(cns_context *cx, cns_code code, const cns_error *err, const cns_view *view,
               const void *result);

/* The definition that a T_c of this case goes by, as a line of text and in a summary. */
void cns_print_criterion(FILE *out, const cns_case *c);
void cns_summarise_criterion(cns_summary *s, const cns_case *c);

/* Closes a short text that has been built in memory, so that a reader gets all of it or a failure, and writes
 * it: to standard output, or, where `path` is not NULL, into a file, which is replaced as a whole (a device
 * or pipe is written to). 128 + 13 without a message when the reader has gone (as in `| head`), CNS_IO with
 * one for any other failure. */
int cns_page_write(cns_text_stream *page, const char *path);

#endif
