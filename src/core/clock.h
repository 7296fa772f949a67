/* Clocks, in seconds: for progress, deadlines and predictions, never for results. */
#ifndef CNS_CORE_CLOCK_H
#define CNS_CORE_CLOCK_H

typedef enum cns_clock {
    CNS_CLOCK_WALL,   /* since some moment in the past; never set back */
    CNS_CLOCK_THREAD, /* processor time of this thread */
    CNS_CLOCK_PROCESS /* processor time of all threads */
} cns_clock;

double cns_seconds(void); /* CNS_CLOCK_WALL */
double cns_thread_seconds(void);
double cns_process_seconds(void);

/* For tests, which must not depend on how fast a machine is: from now on every clock is read by this
 * function, by any thread at any time; NULL: by the system again. */
void cns_clock_replace(double (*read)(cns_clock clock));

#endif
