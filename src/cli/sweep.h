/* --sweep: the study of a command for many values of one number, as tables with a line or more for each. */
#ifndef CNS_CLI_SWEEP_H
#define CNS_CLI_SWEEP_H

#include "cns/study/sweep.h"
#include "context.h"

/* A table, in which a column with the value comes before the others. */
typedef struct cns_swept_table {
    const char *what;    /* in its first line, as in "modes of " */
    const char *note;    /* a line of provenance without its '#'; NULL: none */
    const char *columns; /* separated by commas */
    const char *path;    /* NULL: standard output; of all but the first table: it is not wanted */
} cns_swept_table;

typedef struct cns_swept {
    cns_sweep_study study;
    cns_swept_table table[CNS_SWEEP_TABLES];
    const char *directory; /* where finished values are kept; NULL: nowhere */
} cns_swept;

/* Does what --sweep says. An exit status: CNS_UNREACHED also where a value could not be done, as its table
 * then says. */
int cns_sweep_tables(cns_context *cx, const cns_swept *swept);

/* A name for a study of trajectories: what the case says of them besides the system, and `what`. A new text.
 */
char *cns_sweep_study_name(const cns_case *c, const char *what);

/* A text as the last column of a row, with ';' for commas. */
void cns_sweep_print_last(FILE *out, const char *text);

#endif
