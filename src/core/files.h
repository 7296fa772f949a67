/* Whole files and whole texts: nothing is kept that was not written to its end. */
#ifndef CNS_CORE_FILES_H
#define CNS_CORE_FILES_H

#include <stdbool.h>
#include <stdio.h>

#include "cns/status.h"

/* The text of a file, NUL-terminated, a new string; NULL when it cannot be read. */
char *cns_file_text(const char *path);

/* A file that is being written: under a name of its own until it is whole, so that a reader finds the old
 * one, the new one, or none. A device or a pipe is written to directly. */
typedef struct cns_file {
    FILE *stream;
    char *path, *aside; /* aside NULL: directly */
} cns_file;

cns_code cns_file_create(cns_file *f, const char *path, cns_error *err);
/* It will be put at `path` instead, which is in the same directory. Not for one that is written directly. */
void cns_file_redirect(cns_file *f, const char *path);
/* Closes it: puts it in its place, or, with keep false or after a failure, removes it. */
cns_code cns_file_close(cns_file *f, bool keep, cns_error *err);
/* "cannot WHAT PATH: ..." for errno `cause`; CNS_IO, or CNS_MEMORY. */
cns_code cns_file_failed(const char *what, const char *path, int cause, cns_error *err);

/* Removes what has been created and not closed: for a program about to end, also in a signal handler. */
void cns_files_remove_unfinished(void);

/* Writes a file whole. */
cns_code cns_file_replace(const char *path, const char *text, cns_error *err);

/* Makes the directory if it is not there; its parent must be. */
cns_code cns_directory_make(const char *path, cns_error *err);

/* A text that is written like a file. */
typedef struct cns_text_stream {
    FILE *file; /* print into this; never NULL */
    char *text;
    size_t size;
} cns_text_stream;

void cns_text_open(cns_text_stream *s);
/* The text, a new string; NULL: there was not memory for all of it. */
char *cns_text_close(cns_text_stream *s, cns_error *err);

#endif
