/* --delta of the commands that compare. */
#ifndef CNS_CLI_DELTA_H
#define CNS_CLI_DELTA_H

#include "cns/number.h"
#include "options.h"

/* The value of --delta, 0.01 without the option. An exit status, with the message out; delta is to be
 * cleared when it is 0. */
int cns_delta_read(const cns_options *o, cns_number *delta);

#endif
