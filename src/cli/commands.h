/* The commands: each is described whole in its own file, and commands.def lists them. */
#ifndef CNS_CLI_COMMANDS_H
#define CNS_CLI_COMMANDS_H

#include "context.h"
#include "options.h"

typedef struct cns_command {
    const char *name;
    int (*run)(cns_context *cx); /* an exit status */
    cns_opens opens;             /* of the context */
    const char *operands;        /* as shown in the usage */
    int least, most;             /* how many operands */
    const char *summary;
    const char *details; /* paragraphs for `cns help NAME`; NULL: the summary says it all */
    const cns_option
        *options; /* in the order of the help, made by CNS_TAKES; NULL: only those of every command */
} cns_command;

#define CNS_TAKES(...) ((const cns_option[]){__VA_ARGS__, CNS_OPTIONS_END})

#define COMMAND(name) extern const cns_command cns_command_##name;
#include "commands.def"
#undef COMMAND

const cns_command *cns_command_at(int i); /* from 0; NULL: there are no more */
const cns_command *cns_command_find(const char *name);
const char *cns_command_nearest(const char *name); /* NULL: nothing near */

#endif
