/* Tables read row by row: our own, and anyone's columns of numbers.
 *
 * Lines that begin with # are comments; empty lines are skipped. The first other line names the columns.
 * Values are separated by commas, semicolons, tabs or blanks, whichever the header line has (the first of
 * these that occurs in it). A value in double quotes loses them. Empty values, NaN and NA are missing. Lines
 * may end in CR LF, and be of any length. */
#ifndef CNS_IO_READ_TABLE_H
#define CNS_IO_READ_TABLE_H

#include "cns/study/compare.h"

typedef struct cns_table_reader cns_table_reader;

/* Opens the file, "-" being standard input, and reads up to the header line. CNS_IO: it cannot be read;
 * CNS_USAGE: it is not such a table. */
cns_table_reader *cns_table_reader_open(const char *path, cns_error *err);
void cns_table_reader_close(cns_table_reader *r);

/* The rows, for cns_compare(); valid as long as the reader. Messages begin with "file:line:column: ". */
const cns_rows *cns_table_reader_rows(cns_table_reader *r);

#endif
