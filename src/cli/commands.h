/* The commands: each has a file of its own, cmd_NAME.c, that says all about it, and a row in commands.def. */
#ifndef CNS_CLI_COMMANDS_H
#define CNS_CLI_COMMANDS_H

#include "context.h"
#include "options.h"

typedef struct cns_command {
    const char *name;
    int (*run)(cns_context *cx); /* an exit status */
    cns_opens opens;             /* of the context */
    bool limits; /* it keeps to the limit of time of a goal; else that raises the monitor's stop */
    /* What it makes of a start other than 0, an end before the start, and a list of times. */
    enum { CNS_TIMES_IGNORED, CNS_TIMES_REFUSED, CNS_TIMES_TAKEN } times;
    bool reads;           /* the operands are files that it reads; always, if it opens the case */
    const char *operands; /* as shown in the usage */
    int least, most;      /* how many operands */
    const char *summary;
    const char *details; /* for `cns help NAME`, a line for each paragraph; NULL: the summary says it all */
    /* Those that it takes besides --help and --version, in the order of the help: CNS_TAKES, or NULL. */
    const cns_option *options;
} cns_command;

/* A list of options. */
#define CNS_TAKES(...) ((const cns_option[]){__VA_ARGS__, CNS_OPTIONS_END})

#define COMMAND(name) extern const cns_command cns_command_##name;
#include "commands.def"
#undef COMMAND

const cns_command *cns_command_at(int i); /* from 0; NULL: there are no more */
const cns_command *cns_command_find(const char *name);
const char *cns_command_nearest(const char *name); /* NULL: nothing near */

#endif
