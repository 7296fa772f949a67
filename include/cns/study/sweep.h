/* Sweeps: a study done for every value of a parameter, or of a state at t = 0, from..to by step, upwards or
 * downwards, on many threads, its results being rows of tables. The motions of different values know nothing
 * of each other: each begins at the system's own initial state. */
#ifndef CNS_STUDY_SWEEP_H
#define CNS_STUDY_SWEEP_H

#include <stdio.h>

#include "cns/monitor.h"
#include "cns/system.h"

CNS_BEGIN_DECLS

typedef struct cns_sweep {
    int varied;                /* a parameter of the model; from n_parameters on, the states at t = 0 */
    cns_number from, to, step; /* rational; step, not 0, leads from `from` towards `to` */
} cns_sweep;

#define CNS_SWEEP_MOST 1000000 /* values */

/* NAME=FROM:TO:STEP, NAME being a parameter, or parameters.NAME, or initial.NAME. The step may be given
 * without its sign. After a success cns_sweep_clear() frees it. */
cns_code cns_sweep_parse(cns_sweep *s, const cns_model *model, const char *text, cns_error *err);
void cns_sweep_clear(cns_sweep *s);
int cns_sweep_count(const cns_sweep *s);
/* x = from + i step; its text is a decimal where it is one. */
void cns_sweep_value(const cns_sweep *s, int i, cns_number *x);

/* "R", or "initial.x". */
typedef struct cns_sweep_title {
    char text[80];
} cns_sweep_title;

cns_sweep_title cns_sweep_name(const cns_sweep *s, const cns_model *model);

/* A study may fill several tables. */
#define CNS_SWEEP_TABLES 2

typedef struct cns_sweep_rows {
    char *table[CNS_SWEEP_TABLES]; /* whole lines, of any number; NULL: the value was not done */
} cns_sweep_rows;

/* What is done with a value. */
typedef struct cns_sweep_study {
    const char *name; /* the study with all its settings: what rows depend on besides the system */
    void *context;
    /* Writes the rows for the system with this value (its text: an exact decimal, or a fraction), which all
     * begin with the text, to the streams. Runs on any thread. CNS_NUMERIC, CNS_UNREACHED and CNS_USAGE are
     * results: the message goes into the first table behind the rows, as "# NAME=VALUE: MESSAGE". Any other
     * failure ends the sweep. */
    cns_code (*rows)(void *context, const cns_system *s, const char *value, const cns_monitor *monitor,
                     FILE *const *table, cns_error *err);
} cns_sweep_study;

/* rows[0..count-1], to be cleared whatever is returned. directory: where the rows of every value are kept, so
 * that the same sweep again does what is missing; NULL: nowhere. */
cns_code cns_sweep_run(const cns_system *s, const cns_sweep *sweep, const cns_sweep_study *study,
                       const char *directory, const cns_monitor *monitor, cns_sweep_rows *rows,
                       cns_error *err);
void cns_sweep_rows_clear(cns_sweep_rows *rows, int count);

CNS_END_DECLS

#endif
