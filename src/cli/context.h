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
    cns_number *at;      /* its list of times, as what has passed since the start; NULL: it has none */
    cns_problem problem; /* of the case; without a sink */
    cns_monitor monitor; /* its progress goes to the meter */
    cns_meter meter;
    double since;    /* cns_seconds() at the beginning */
    double fraction; /* of the work, and in words what was being done, when progress was last told */
    char what[128];
    bool shown; /* a result, or what there is of one */
    const char
        *keeper;      /* the option that keeps finished parts of the study, as "-o DIR", and the directory; */
    const char *kept; /* NULL: it has no parts; none is kept */
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

/* The monitor's progress: to the meter, and remembered. context: a cns_context. */
void cns_context_tell(void *context, double fraction, const char *what);

/* Signals (signals.h) raise the monitor's stop, and progress goes to the meter, from here on. */
void cns_context_watch(cns_context *cx);

/* The exit status of `code`. Its message goes to standard error; where a signal is the cause, a note says
 * where the study was and what is kept of it. */
int cns_context_status(cns_context *cx, cns_code code, const cns_error *err);

#endif
