/* Where a command writes: never over what it reads, and never twice to one file. */
#ifndef CNS_CLI_OUTPUTS_H
#define CNS_CLI_OUTPUTS_H

#include "options.h"

/* To be called before anything is opened. CNS_USAGE, with the message out, if a file that the command line
 * has the command write, standard output among them, is one that it reads, under whatever name, or another
 * that it writes. Devices and pipes may be named as often as one likes. */
int cns_outputs_check(const cns_options *o);

#endif
