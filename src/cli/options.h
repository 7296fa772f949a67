/* The command line: options.def lists the options, and drives parsing, help and suggestions. */
#ifndef CNS_CLI_OPTIONS_H
#define CNS_CLI_OPTIONS_H

#include <stdbool.h>
#include <stdio.h>

#include "cns/status.h"

#define CNS_MAX_THREADS  4096
#define CNS_MAX_DECIMALS 10000
#define CNS_MAX_SECONDS  1000000

struct cns_command;

/* The values of an option that may be given many times, in order. */
typedef struct cns_texts {
    const char **at;
    int n;
} cns_texts;

typedef struct cns_options {
    const struct cns_command *command; /* NULL: none given */
    cns_texts operands;

    /* One member for each name in options.def; the kind of the option says of which type. */
    bool yaml, prove, quiet, help, version; /* FLAG: given? */
    int verbose;                            /* COUNT: how many times */
    const char *output, *events, *until, *sweep, *keep, *maxima,
        *observable;                                  /* TEXT; NAME and WRITTEN, not empty; NULL: not given */
    const char *delta;                                /* RATIONAL: a number > 0, no multiple of pi */
    long threads, reference_digits, decimals, digits; /* INTEGER: in its range; 0: not given */
    double seconds, max_time;                         /* POSITIVE: > 0; 0: not given */
    cns_texts sets, sections;                         /* LIST */
} cns_options;

typedef enum cns_option {
#define OPTION(id, ...) CNS_OPTION_##id,
#include "options.def"
#undef OPTION
    CNS_OPTIONS_END
} cns_option;

/* CNS_USAGE with a message in err when the line is wrong. With help or version set the rest was not
 * checked. argv must outlive o; cns_options_clear() frees the lists. */
cns_code cns_options_parse(cns_options *o, int argc, char *const *argv, cns_error *err);
void cns_options_clear(cns_options *o);

/* A file that the command writes, and the option that names it. */
typedef struct cns_written {
    const char *option, *path;
} cns_written;

/* Those that are given, in the order of the help; returns how many, at most `most`. */
int cns_options_written(const cns_options *o, cns_written *list, int most);

/* The options that a command takes, one per line; NULL: those that every command takes. */
void cns_options_print(const struct cns_command *command, FILE *out);

#endif
