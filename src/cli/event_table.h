/* The table of events of `cns run --events`. */
#ifndef CNS_CLI_EVENT_TABLE_H
#define CNS_CLI_EVENT_TABLE_H

#include "cns/solve.h"
#include "context.h"

/* The sections that the command line asks for, and the model's own. */
typedef struct cns_wanted {
    const cns_options *o;
    int n;
    cns_event_condition *sections;
} cns_wanted;

/* An exit status; when it is not 0 the message is out and nothing is left to close. */
int cns_wanted_open(cns_wanted *w, const cns_options *o, const cns_model *model);
void cns_wanted_close(cns_wanted *w);

/* Finds the events of the run that gave this result and writes their table. */
int cns_wanted_write(const cns_wanted *w, cns_context *s, const cns_result *result);

#endif
