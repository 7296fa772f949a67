/* Signals: which of them stop the work in good order, and which end the program at once. In either case no
 * unfinished file stays. */
#ifndef CNS_CLI_SIGNALS_H
#define CNS_CLI_SIGNALS_H

#include <signal.h>

/* A write into a pipe whose reader has gone (`| head`), or beyond the largest file allowed (ulimit -f), fails
 * like any other write, after which files can be put in order, instead of ending the program. */
void cns_signals_as_failures(void);

/* INT, TERM, HUP, XCPU (ulimit -t), USR1 and USR2 (by which batch systems announce the end) raise
 * cns_signal_stop; a second INT or TERM of the same kind ends the program at once, as do QUIT and ABRT. Those
 * that are ignored from the start, as HUP by nohup, stay so, except INT, which shells have ignored by all
 * that they start in the background. */
void cns_signals_catch(void);

/* 0, or the signal that came last of those that stop. */
extern volatile sig_atomic_t cns_signal_stop;

/* Raises cns_signal_stop, with SIGALRM, when so many seconds have passed: the limit `max_time`. */
void cns_signals_limit(double seconds);

/* "signal INT (Ctrl-C)" for the one that came, "max_time of 5 s" for the limit. */
const char *cns_signal_text(void);

/* The exit status of what was stopped: 128 + the signal, or for the limit CNS_UNREACHED. */
int cns_signal_status(void);

#endif
