/* Tables read row by row: our own, and anyone's columns of numbers.
 *
 * The first line that is neither empty nor a comment names the columns; if it holds numbers, the comment
 * above it does, as numpy.savetxt() has it. Values are separated by semicolons, commas, tabs or blanks: the
 * first of these that the line has, or what a first line `sep=,` says. Where semicolons separate, numbers may
 * have a decimal comma. A value may stand in double quotes, in which separators mean nothing and two quotes
 * stand for one. Lines that begin with # are comments, and what follows a # behind a blank is one. No value,
 * NaN and its like, and infinity are missing. Lines end in LF, CR LF or CR, and may be of any length; a byte
 * order mark of UTF-8 is skipped.
 *
 * Of our own tables, which begin with "# cns ", the format is checked, and times are had back as the table
 * says. */
#ifndef CNS_IO_READ_TABLE_H
#define CNS_IO_READ_TABLE_H

#include "cns/study/compare.h"

typedef struct cns_table_reader cns_table_reader;

/* Opens the file, "-" being standard input, and reads up to the names of the columns. CNS_IO: it cannot be
 * read; CNS_USAGE: it is not such a table. */
cns_table_reader *cns_table_reader_open(const char *path, cns_error *err);
void cns_table_reader_close(cns_table_reader *r);

/* The rows, for cns_compare(); valid as long as the reader. Messages begin with "file:line:column: ". */
const cns_rows *cns_table_reader_rows(cns_table_reader *r);

#endif
