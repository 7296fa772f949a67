/* Clocks, in seconds: for progress, deadlines and predictions, never for results. */
#ifndef CNS_CORE_CLOCK_H
#define CNS_CORE_CLOCK_H

double cns_seconds(void);         /* since some moment in the past; never set back */
double cns_thread_seconds(void);  /* of processor time of this thread */
double cns_process_seconds(void); /* of all threads */

#endif
