/* Tables: `#` lines of provenance, a header row, comma-separated rows, a last line that says how it ended.
 * Where times are no finite decimals, a line says how they are had back: "# times: each the nearest fraction
 * with a denominator up to 3". */
#ifndef CNS_IO_WRITE_TABLE_H
#define CNS_IO_WRITE_TABLE_H

#include <stdio.h>

#include "cns/case.h"
#include "cns/solve.h"
#include "cns/status.h"

#define CNS_TABLE_TIMES "times: each the nearest fraction with a denominator up to "

typedef struct cns_table cns_table;

/* path NULL: written to out, standard output, which stays open. Else the table is written beside path, and
 * put in its place when it is closed (cns_provenance_close()); nothing is left behind, and an older file
 * stays, when it cannot be written. */
cns_table *cns_table_open(const char *path, FILE *out, const cns_case *c, cns_error *err);

/* The provenance and the header row at the first call; later ones note a new attempt. */
cns_code cns_table_begin(cns_table *t, const cns_run_info *run, cns_error *err);
cns_code cns_table_row(cns_table *t, const cns_row *row, cns_error *err);

/* The names of the columns, without an end of the line, and a row, with one. */
void cns_table_print_names(FILE *out, const cns_case *c);
void cns_table_print_row(FILE *out, const cns_case *c, const cns_row *row);

/* Ends the table: `# complete`, or `# stopped: REASON` if reason is not NULL. Frees t, whatever the result.
 * *kept as in cns_provenance_close(); NULL for standard output. CNS_IO: it could not be written; CNS_STOPPED:
 * the reader of standard output has gone. */
cns_code cns_table_close(cns_table *t, const char *reason, char **kept, cns_error *err);

/* The same without writing anything more and without a file left at path. */
void cns_table_abandon(cns_table *t);

/* The reader of standard output has gone (EPIPE). */
bool cns_table_reader_gone(const cns_table *t);

#endif
