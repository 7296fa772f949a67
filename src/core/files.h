/* Whole files: read at once, written aside and renamed, so that a file is old, new, or not there. */
#ifndef CNS_CORE_FILES_H
#define CNS_CORE_FILES_H

#include "cns/status.h"

/* The text of a file, NUL-terminated, a new string; NULL when it cannot be read. */
char *cns_file_text(const char *path);

cns_code cns_file_replace(const char *path, const char *text, cns_error *err);

/* Makes the directory if it is not there; its parent must be. */
cns_code cns_directory_make(const char *path, cns_error *err);

#endif
