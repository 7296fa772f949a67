/* Progress on standard error: one line that is rewritten on a terminal, a rare plain line elsewhere. */
#ifndef CNS_CLI_PROGRESS_H
#define CNS_CLI_PROGRESS_H

#include <stdbool.h>

typedef struct cns_meter {
    bool quiet, terminal, shown;
    double next; /* when to speak again, in cns_seconds() */
} cns_meter;

void cns_meter_init(cns_meter *m, bool quiet);
/* fraction: 0..1; seconds: so far. The caller may call as often as it likes. */
void cns_meter_show(cns_meter *m, double fraction, double seconds, const char *what);
/* Takes the line away, before anything else is written to standard error. */
void cns_meter_clear(cns_meter *m);

#endif
