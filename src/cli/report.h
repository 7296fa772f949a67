/* What the commands share: messages, case files, and output that does not fail in silence. */
#ifndef CNS_CLI_REPORT_H
#define CNS_CLI_REPORT_H

#include <stdio.h>

#include "cns/case.h"
#include "cns/status.h"
#include "options.h"

/* "cns: MESSAGE" on standard error; returns code. */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
int cns_complain(cns_code code, const char *format, ...);

/* The case file that the command line names, with its --set options; faults go to standard error. */
cns_code cns_open_case(const cns_options *o, cns_case **c);

/* A short text for standard output, built in memory and written at once, so that every failure to write
 * is seen and a reader gets all of it or a failure. */
typedef struct cns_page {
    FILE *file; /* print into this */
    char *text;
    size_t size;
} cns_page;

cns_code cns_page_open(cns_page *p);
/* Writes and frees. 128 + 13 without a message when the reader has gone (as in `| head`), CNS_IO with one
 * for any other failure. */
int cns_page_print(cns_page *p);
/* The same into a file, which is replaced as a whole; a device or pipe is written to. path NULL: standard
 * output. */
int cns_page_write(cns_page *p, const char *path);

/* What cns_page_print() answers for errno `cause` of a failed write to standard output. */
int cns_stdout_failed(int cause);

#endif
