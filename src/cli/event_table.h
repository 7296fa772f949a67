/* The table of events of `cns run --events`. */
#ifndef CNS_CLI_EVENT_TABLE_H
#define CNS_CLI_EVENT_TABLE_H

#include "cns/solve.h"
#include "context.h"
#include "core/files.h"

typedef struct cns_event_table {
    const cns_context *cx;
    int n, room;                    /* how many conditions, and for how many there is room */
    cns_event_condition *condition; /* the model's own, then those of --section */
    cns_text_stream lines;          /* of the events told so far; file NULL: none were */
    long told;                      /* how many */
    bool enclosed;                  /* they are proven by an enclosure */
    cns_file file;                  /* of --events; path NULL: not open */
} cns_event_table;

/* An exit status, with the message out. To be closed in any case. */
int cns_event_table_open(cns_event_table *t, const cns_context *cx);
void cns_event_table_close(cns_event_table *t);

/* Forgets what an earlier attempt told. */
void cns_event_table_begin(cns_event_table *t, const cns_run_info *run);
void cns_event_table_add(cns_event_table *t, const cns_event *e);

/* Writes the table into the file of --events, as cns_provenance_close() has it. whole_run: it was looked for
 * events to the end, so that to have none counts. reason: why the table ends too early all the same; NULL: it
 * does not. An exit status. */
int cns_event_table_write(cns_event_table *t, bool whole_run, const char *reason);

#endif
