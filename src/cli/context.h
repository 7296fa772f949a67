/* What a command works with: the command line, and as far as the command asks for them, the case, the system
 * that it describes, signals and progress. */
#ifndef CNS_CLI_CONTEXT_H
#define CNS_CLI_CONTEXT_H

#include "cns/case.h"
#include "cns/solve.h"
#include "options.h"
#include "progress.h"

typedef struct cns_context {
    const cns_options *o;
    cns_case *c;
    cns_system *system;  /* of the case */
    cns_problem problem; /* of the case; without a sink */
    cns_monitor monitor; /* its progress goes to the meter */
    cns_meter meter;
    double since; /* cns_seconds() at the beginning */
} cns_context;

/* How much to open; each includes those before it. */
typedef enum cns_opens {
    CNS_OPENS_NOTHING,
    CNS_OPENS_CASE,  /* that of the command line, with its --set options; faults go to standard error */
    CNS_OPENS_SYSTEM /* the case's system and problem; signals and progress as below */
} cns_opens;

/* An exit status; when it is not 0 the message is out. To be closed in any case. */
int cns_context_open(cns_context *cx, const cns_options *o, cns_opens opens);
void cns_context_close(cns_context *cx);

/* Catches SIGINT, SIGTERM and SIGHUP: the first raises the monitor's stop, the second ends the program.
 * Progress goes to the meter from here on. */
void cns_context_watch(cns_context *cx);

/* The exit status of `code`: its message, unless a signal is the cause, goes to standard error. */
int cns_context_status(cns_context *cx, cns_code code, const cns_error *err);

#endif
