/* What a command that computes begins and ends with: the case, its program, signals, progress. */
#ifndef CNS_CLI_CONTEXT_H
#define CNS_CLI_CONTEXT_H

#include "cns/case.h"
#include "cns/solve.h"
#include "cns/study.h"
#include "options.h"
#include "progress.h"

typedef struct cns_context {
    const cns_options *o;
    cns_case *c;
    cns_program *program;
    double *scales;
    cns_study study;     /* of the case; its progress goes to the meter */
    cns_problem problem; /* of the case; without a sink */
    cns_meter meter;
    double since; /* cns_seconds() at the beginning */
} cns_context;

/* Opens the case that the command line names, builds its program, and catches SIGINT, SIGTERM and SIGHUP:
 * the first raises the stop of study and problem, the second ends the program. An exit status; when it is
 * not 0 the message is out and nothing has to be closed. */
int cns_context_open(const cns_options *o, cns_context *s);
/* The same for a command without a case: signals, meter, and of `study` only stop and progress. */
void cns_context_begin(const cns_options *o, cns_context *s);
void cns_context_close(cns_context *s);

/* The exit status of `code`: its message, unless a signal is the cause, goes to standard error. */
int cns_context_status(cns_context *s, cns_code code, const cns_error *err);

#endif
