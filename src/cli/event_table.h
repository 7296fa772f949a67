/* The table of events of `cns run --events`. */
#ifndef CNS_CLI_EVENT_TABLE_H
#define CNS_CLI_EVENT_TABLE_H

#include "cns/solve.h"
#include "context.h"

/* The conditions of --section and the model's own, and the lines of events that have been told. */
typedef struct cns_wanted {
    const cns_options *o;
    int n;
    cns_event_condition *sections;
    FILE *lines; /* into text */
    char *text;
    size_t size;
} cns_wanted;

/* An exit status; when it is not 0 the message is out and nothing is left to close. */
int cns_wanted_open(cns_wanted *w, const cns_options *o, const cns_model *model);
void cns_wanted_close(cns_wanted *w);

/* Forgets the lines of an attempt before. */
cns_code cns_wanted_begin(cns_wanted *w, cns_error *err);
void cns_wanted_event(cns_wanted *w, const cns_model *model, const cns_event *e);

/* Writes the table; reason: why it ends too early, NULL: it does not. An exit status. */
int cns_wanted_write(cns_wanted *w, const cns_case *c, const char *reason);

#endif
