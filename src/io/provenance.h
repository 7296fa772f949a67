/* What every table says of itself in `#` lines: which case it comes from, first, and how it ended, last. */
#ifndef CNS_IO_PROVENANCE_H
#define CNS_IO_PROVENANCE_H

#include <stdio.h>

#include "cns/case.h"
#include "core/files.h"

/* What a reader of tables must know in order to read one; it changes when an older reader would go wrong. */
#define CNS_TABLE_FORMAT 1

/* How much of the case a table tells. Each level has the lines of those before it as well. */
typedef enum cns_provenance {
    CNS_PROVENANCE_CASE,      /* the case file's name and SHA-256, and the overrides */
    CNS_PROVENANCE_EQUATIONS, /* where the equations were published */
    CNS_PROVENANCE_WHOLE      /* the case file's text, the parameters, the initial state, and abs */
} cns_provenance;

/* The first two lines are "# cns VERSION: " with `what` and the title of the model, as in "events of " or "",
 * and
 * "# format: " with the number above. */
void cns_provenance_begin(FILE *out, const cns_case *c, const char *what, cns_provenance level);

/* The last line of a table: `# complete`, or `# stopped: REASON` if reason is not NULL. */
void cns_provenance_end(FILE *out, const char *reason);

/* The same for a table in a file, which is closed. A table that ends too early replaces only one that did so
 * as well; beside anything else it goes to "PATH.partial"; without a row it is removed. A device or pipe has
 * been written to. *kept: where the table is, a new string; NULL: it is not. */
cns_code cns_provenance_close(cns_file *f, bool any_rows, const char *reason, char **kept, cns_error *err);

#endif
