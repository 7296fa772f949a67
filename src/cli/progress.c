#include "progress.h"

#include <stdio.h>
#include <unistd.h>

#include "core/clock.h"
#include "terminal.h"

static const double terminal_pause = 0.2, line_pause = 30; /* seconds */

void cns_meter_init(cns_meter *m, bool quiet)
{
    m->quiet = quiet;
    m->terminal = isatty(STDERR_FILENO) == 1;
    m->shared = m->terminal && isatty(STDOUT_FILENO) == 1;
    m->shown = false;
    m->next = cns_seconds() + (m->terminal ? terminal_pause : line_pause);
}

static void duration(char *text, size_t size, double seconds)
{
    if (seconds < 100)
        snprintf(text, size, "%.0f s", seconds);
    else if (seconds < 6000)
        snprintf(text, size, "%.0f min", seconds / 60);
    else
        snprintf(text, size, "%.1f h", seconds / 3600);
}

void cns_meter_show(cns_meter *m, double fraction, double seconds, const char *what)
{
    double now = cns_seconds();
    if (m->quiet || now < m->next)
        return;
    m->next = now + (m->terminal ? terminal_pause : line_pause);
    char eta[32], line[512];
    duration(eta, sizeof eta, fraction > 0 ? seconds * (1 - fraction) / fraction : 0);
    int length =
        snprintf(line, sizeof line, "%5.1f %%  %s left  %s", 100 * fraction, fraction > 0 ? eta : "?", what);
    if (m->terminal) {
        int width = cns_terminal_columns(STDERR_FILENO) - 1;
        if (length > width && width > 0 && width < (int)sizeof line)
            line[width] = '\0';
        fprintf(stderr, "\r%s\033[K", line);
        m->shown = true;
    } else {
        fprintf(stderr, "cns: %s\n", line);
    }
    fflush(stderr);
}

void cns_meter_clear(cns_meter *m)
{
    if (m->shown)
        fputs("\r\033[K", stderr);
    m->shown = false;
    fflush(stderr);
}

void cns_meter_make_way(cns_meter *m)
{
    if (m->shared)
        cns_meter_clear(m);
}
