/* Whole files: read at once, written aside and renamed, so that a file is old, new, or not there. */
#ifndef CNS_CORE_FILES_H
#define CNS_CORE_FILES_H

#include <stdbool.h>
#include <stdio.h>

#include "cns/status.h"

/* The text of a file, NUL-terminated, a new string; NULL when it cannot be read. */
char *cns_file_text(const char *path);

/* Opens a file to be written. *aside is a new string, its name until it is renamed to path; NULL for a device
 * or a pipe, which is written to directly. NULL, with errno, when it cannot be opened. */
FILE *cns_file_create(const char *path, char **aside);

/* Ends such a file: forces all of it out and gives it its name, or, unless it is to be kept, removes what was
 * written aside. Frees aside. 0, or the errno of what failed, in the writing before too; then an older file
 * stays as it was. */
int cns_file_finish(FILE *f, const char *path, char *aside, bool keep);

/* Writes it whole. */
cns_code cns_file_replace(const char *path, const char *text, cns_error *err);

/* Makes the directory if it is not there; its parent must be. */
cns_code cns_directory_make(const char *path, cns_error *err);

#endif
