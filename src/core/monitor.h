/* What work asks of its monitor, which may be NULL. */
#ifndef CNS_CORE_MONITOR_H
#define CNS_CORE_MONITOR_H

#include <stdbool.h>
#include <stddef.h>

#include "cns/monitor.h"

static inline int cns_monitor_threads(const cns_monitor *m)
{
    return m != NULL && m->threads > 1 ? m->threads : 1;
}

static inline const volatile sig_atomic_t *cns_monitor_stop(const cns_monitor *m)
{
    return m != NULL ? m->stop : NULL;
}

static inline bool cns_monitor_stopped(const cns_monitor *m)
{
    return m != NULL && m->stop != NULL && *m->stop;
}

static inline bool cns_monitor_limited(const cns_monitor *m)
{
    return m != NULL && m->limited;
}

static inline void cns_monitor_tell(const cns_monitor *m, double fraction, const char *what)
{
    if (m != NULL && m->progress != NULL)
        m->progress(m->context, fraction, what);
}

#endif
