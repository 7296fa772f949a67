/* Progress on standard error: on a terminal one line that is rewritten, elsewhere a new line twice a minute.
 */
#ifndef CNS_CLI_PROGRESS_H
#define CNS_CLI_PROGRESS_H

#include <stdbool.h>

typedef struct cns_meter {
    bool quiet;    /* show nothing */
    bool terminal; /* standard error is one */
    bool shared;   /* and standard output, too */
    bool shown;    /* there is a line on the terminal */
    double next;   /* when to speak again, in cns_seconds() */
} cns_meter;

void cns_meter_init(cns_meter *m, bool quiet);
/* The part done, 0 to 1, the seconds that it took, and in words what is being done. The caller may call as
 * often as it likes. */
void cns_meter_show(cns_meter *m, double fraction, double seconds, const char *what);
/* Takes the line away, before anything else is written to standard error. */
void cns_meter_clear(cns_meter *m);
/* The same before something is written to standard output, if that is a terminal, too. */
void cns_meter_make_way(cns_meter *m);

#endif
