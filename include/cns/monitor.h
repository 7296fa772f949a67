/* How work that takes long is watched and stopped. Wherever a monitor is asked for, NULL stands for one
 * thread that nobody watches or stops. No result depends on a monitor. */
#ifndef CNS_MONITOR_H
#define CNS_MONITOR_H

#include <signal.h>
#include <stdbool.h>

#include "cns/status.h"

CNS_BEGIN_DECLS

typedef struct cns_monitor {
    int threads;                       /* at most so many at work; 0 means 1 */
    const volatile sig_atomic_t *stop; /* not 0: give up, with CNS_STOPPED; NULL: never. A signal handler may
                                          set it */
    bool limited;                      /* `stop` will come in time: also begin what has no end in sight */
    /* What is going on, as a fraction of the whole and in words; NULL: nobody listens. One call at a time. */
    void (*progress)(void *context, double fraction, const char *what);
    void *context;
} cns_monitor;

CNS_END_DECLS

#endif
