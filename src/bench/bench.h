/* Speed: processor time per unit of integrated time of the plain engine (MPFR, every operation rounded) and
 * of the fast arithmetic with each kernel, on built-in problems, at the same digits and over the same
 * stretch of time from t = 0, and how many digits are right at its end.
 *
 * Every engine takes the order that the program would choose for it (cns_order_for) unless told otherwise,
 * and adaptive steps of tolerance 10^-digits. The first step, which converts constants and guesses the step,
 * is made before the clock starts. Times are of the process, so that other programs do not count: nothing
 * else may run in it. */
#ifndef CNS_BENCH_BENCH_H
#define CNS_BENCH_BENCH_H

#include <mpfr.h>
#include <signal.h>
#include <stdbool.h>

#include "cns/monitor.h"
#include "cns/system.h"

typedef enum cns_bench_engine {
    CNS_BENCH_MPFR,
    CNS_BENCH_PORTABLE,
    CNS_BENCH_IFMA,
    CNS_BENCH_ENGINES
} cns_bench_engine;

typedef enum cns_bench_system {
    CNS_BENCH_APW,        /* the falling disk, |omega| exact, on an arc where omega > 0 up to t = 8 */
    CNS_BENCH_APW_SMOOTH, /* the same with eps = 1e-3 */
    CNS_BENCH_LORENZ,
    CNS_BENCH_SYSTEMS
} cns_bench_system;

const char *cns_bench_engine_name(cns_bench_engine engine); /* mpfr, portable, avx512ifma */
const char *cns_bench_system_name(cns_bench_system system);
bool cns_bench_has(cns_bench_engine engine); /* on this machine */

/* NULL, with err, when memory ends. */
cns_system *cns_bench_system_new(cns_bench_system system, cns_error *err);

/* One run. */

typedef struct cns_bench_job {
    cns_bench_engine engine;
    long digits;  /* >= 1 */
    int order;    /* 0: the program's choice for this engine */
    double until; /* > 0: the run ends with the first step that reaches it, or with the second step */
    const volatile sig_atomic_t *stop; /* may be NULL */
} cns_bench_job;

typedef struct cns_bench_run {
    double seconds; /* per unit of integrated time */
    double steps;   /* per unit of integrated time */
    int order;
    double covered; /* the time that was measured */
    int taken;      /* steps that were measured, */
    double *each;   /* and the seconds of each */
    int n;          /* numbers in end */
    mpfr_t *end;    /* the states at `until` */
} cns_bench_run;

/* *run must be zeros or an earlier run, which it replaces. CNS_USAGE: no such engine on this machine. */
cns_code cns_bench_measure(const cns_system *p, const cns_bench_job *job, cns_bench_run *run, cns_error *err);
void cns_bench_run_clear(cns_bench_run *run);

/* Digits that n states x have in common with y, relative to the scales of the model: the least over the
 * dynamic states; HUGE_VAL when all are equal. */
double cns_bench_agreed(const cns_system *p, const mpfr_t *x, const mpfr_t *y);

/* The true states at `until`, by the fast arithmetic with a fifth more digits and some. */
cns_code cns_bench_reference(const cns_system *p, long digits, double until,
                             const volatile sig_atomic_t *stop, cns_bench_run *run, cns_error *err);

/* Tables. */

enum { CNS_BENCH_RUNS = 5 };

typedef struct cns_bench_cell {
    int runs; /* 0: left out */
    double seconds[CNS_BENCH_RUNS];
    double steps;
    int order;
    double right; /* digits right at the end */
} cns_bench_cell;

typedef struct cns_bench_row {
    cns_bench_system system; /* in */
    long digits;             /* in */
    double until;            /* in */
    cns_bench_cell cells[CNS_BENCH_ENGINES];
} cns_bench_row;

typedef struct cns_bench_spec {
    double seconds; /* of the clock for all; what is expected to exceed it is left out. 0: no limit */
    int runs;       /* at most, of each cell; 1..CNS_BENCH_RUNS */
    const cns_monitor *monitor;
} cns_bench_spec;

/* Fills the cells of all rows, which must come with the digits of a system increasing. Engines take turns.
 * CNS_NUMERIC also when two kernels end with different bits. */
cns_code cns_bench_fill(const cns_bench_spec *spec, cns_bench_row *rows, int n, cns_error *err);

/* Median over the runs of a cell that has some, seconds per unit of integrated time. */
double cns_bench_median(const cns_bench_cell *cell);

#endif
