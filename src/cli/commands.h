/* The commands: cns_cmd_NAME takes the parsed command line and returns an exit status. */
#ifndef CNS_CLI_COMMANDS_H
#define CNS_CLI_COMMANDS_H

#include "options.h"

int cns_cmd_run(const cns_options *o);
int cns_cmd_tc(const cns_options *o);
int cns_cmd_laws(const cns_options *o);
int cns_cmd_compare(const cns_options *o);
int cns_cmd_plan(const cns_options *o);
int cns_cmd_lyapunov(const cns_options *o);
int cns_cmd_classify(const cns_options *o);
int cns_cmd_equilibria(const cns_options *o);
int cns_cmd_bisect(const cns_options *o);
int cns_cmd_check(const cns_options *o);
int cns_cmd_models(const cns_options *o);
int cns_cmd_bench(const cns_options *o);
int cns_cmd_help(const cns_options *o);

void cns_print_version(FILE *out);

#endif
