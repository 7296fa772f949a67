/* The command line: one table of commands and one of options drive parsing, help and suggestions. */
#ifndef CNS_CLI_OPTIONS_H
#define CNS_CLI_OPTIONS_H

#include <stdbool.h>
#include <stdio.h>

#include "cns/status.h"

#define CNS_MAX_THREADS  4096
#define CNS_MAX_DECIMALS 10000
#define CNS_MAX_SECONDS  1000000

typedef struct cns_options {
    const struct cns_command *command; /* NULL: none given */
    const char *const *operands;       /* n_operands */
    int n_operands;
    const char *const *sets; /* --set, in order */
    int n_sets;
    const char *const *sections; /* --section, in order */
    int n_sections;
    bool yaml, prove, quiet, help, version;
    int verbose; /* how many -v */

    /* NULL or 0: not given */
    const char *output, *events, *delta, *until, *sweep, *observable;
    long threads, reference_digits, decimals, digits;
    double seconds;

    const char **list; /* room for operands, sets and sections */
} cns_options;

typedef struct cns_command {
    const char *name;
    int (*run)(const cns_options *o); /* an exit status */
    const char *operands;             /* as shown in the usage */
    int least, most;                  /* how many operands */
    const char *summary;
    const char *details; /* paragraphs for `cns help NAME` */
} cns_command;

int cns_command_count(void);
const cns_command *cns_command_at(int i);
const cns_command *cns_command_find(const char *name);
const char *cns_command_nearest(const char *name); /* NULL: nothing near */

/* CNS_USAGE with a message in err when the line is wrong. With help or version set the rest was not
 * checked. argv must outlive o; cns_options_clear() frees the lists. */
cns_code cns_options_parse(cns_options *o, int argc, char *const *argv, cns_error *err);
void cns_options_clear(cns_options *o);

/* The options that a command takes, one per line; NULL: those that every command takes. */
void cns_options_print(const cns_command *command, FILE *out);

#endif
