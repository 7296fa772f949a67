#include "signals.h"

#include <math.h>
#include <stdio.h>
#include <sys/resource.h>
#include <sys/time.h>

#include "cns/status.h"
#include "core/files.h"

volatile sig_atomic_t cns_signal_stop;

static const struct {
    int number;
    const char *text; /* NULL: ends the program at once */
} caught[] = {
    {SIGINT, "signal INT (Ctrl-C)"},
    {SIGTERM, "signal TERM"},
    {SIGHUP, "signal HUP (the terminal has gone)"},
    {SIGXCPU, "signal XCPU (the processor time allowed is used up)"},
    {SIGUSR1, "signal USR1"},
    {SIGUSR2, "signal USR2"},
    {SIGQUIT, NULL},
    {SIGABRT, NULL},
};

/* Only what a signal handler may call. The signal's own action follows when this handler has returned. */
static void end_at_once(int number)
{
    cns_files_remove_unfinished();
    signal(number, SIG_DFL);
    raise(number);
}

/* A second one is impatience. But XCPU is repeated every second, and of a terminal that is closed both the
 * shell and the system may tell. */
static void on_stop(int number)
{
    if (cns_signal_stop == number && (number == SIGINT || number == SIGTERM))
        end_at_once(number);
    cns_signal_stop = number;
}

void cns_signals_as_failures(void)
{
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
}

/* `ulimit -t` sets the limit of processor time that XCPU announces and the one at which the system kills to
 * the same: then the announcement is made to come before, by a tenth of the time, but 1 to 5 s. */
static void be_told_in_time(void)
{
    struct rlimit limit;
    if (getrlimit(RLIMIT_CPU, &limit) != 0 || limit.rlim_cur != limit.rlim_max ||
        limit.rlim_max == RLIM_INFINITY || limit.rlim_max < 2)
        return;
    const rlim_t tenth = limit.rlim_max / 10;
    limit.rlim_cur -= tenth < 1 ? 1 : tenth > 5 ? 5 : tenth;
    setrlimit(RLIMIT_CPU, &limit);
}

void cns_signals_catch(void)
{
    be_told_in_time();
    for (size_t i = 0; i < sizeof caught / sizeof *caught; i++) {
        struct sigaction action = {.sa_handler = caught[i].text != NULL ? on_stop : end_at_once,
                                   .sa_flags = SA_RESTART},
                         before;
        sigemptyset(&action.sa_mask);
        sigaction(caught[i].number, NULL, &before);
        if (before.sa_handler != SIG_IGN || caught[i].number == SIGINT)
            sigaction(caught[i].number, &action, NULL);
    }
}

static char limit_text[64];

static void on_limit(int number)
{
    if (cns_signal_stop == 0)
        cns_signal_stop = number;
}

void cns_signals_limit(double seconds)
{
    const struct sigaction action = {.sa_handler = on_limit, .sa_flags = SA_RESTART};
    const double whole = floor(seconds);
    const struct itimerval timer = {
        .it_value = {.tv_sec = (time_t)whole, .tv_usec = (suseconds_t)((seconds - whole) * 1e6)}};
    snprintf(limit_text, sizeof limit_text, "max_time of %g s", seconds);
    sigaction(SIGALRM, &action, NULL);
    if (seconds < 1e-6) /* which would set no timer */
        on_limit(SIGALRM);
    else
        setitimer(ITIMER_REAL, &timer, NULL);
}

int cns_signal_status(void)
{
    return cns_signal_stop == SIGALRM ? CNS_UNREACHED : CNS_STOPPED + (int)cns_signal_stop;
}

const char *cns_signal_text(void)
{
    if (cns_signal_stop == SIGALRM)
        return limit_text;
    for (size_t i = 0; i < sizeof caught / sizeof *caught; i++)
        if (caught[i].number == cns_signal_stop)
            return caught[i].text;
    return "a signal";
}
