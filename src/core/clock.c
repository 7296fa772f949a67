#include "clock.h"

#include <stdatomic.h>
#include <time.h>

static double read_system(cns_clock clock)
{
    static const clockid_t ids[] = {CLOCK_MONOTONIC, CLOCK_THREAD_CPUTIME_ID, CLOCK_PROCESS_CPUTIME_ID};
    struct timespec now;
    clock_gettime(ids[clock], &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double (*_Atomic read_clock)(cns_clock clock) = read_system;

void cns_clock_replace(double (*read)(cns_clock clock))
{
    atomic_store(&read_clock, read ? read : read_system);
}

double cns_seconds(void)
{
    return atomic_load(&read_clock)(CNS_CLOCK_WALL);
}

double cns_thread_seconds(void)
{
    return atomic_load(&read_clock)(CNS_CLOCK_THREAD);
}

double cns_process_seconds(void)
{
    return atomic_load(&read_clock)(CNS_CLOCK_PROCESS);
}
