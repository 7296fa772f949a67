/* Sweeps: the mode of the motion for every value of a parameter, from..to by step, as rows of a table. */
#ifndef CNS_STUDY_SWEEP_H
#define CNS_STUDY_SWEEP_H

#include "cns/study/classify.h"

CNS_BEGIN_DECLS

typedef struct cns_sweep {
    int parameter;             /* of the model */
    cns_number from, to, step; /* rational, step > 0, from <= to */
} cns_sweep;

#define CNS_SWEEP_MOST 1000000 /* values */

/* NAME=FROM:TO:STEP. After a success cns_sweep_clear() frees it. */
cns_code cns_sweep_parse(cns_sweep *s, const cns_model *model, const char *text, cns_error *err);
void cns_sweep_clear(cns_sweep *s);
int cns_sweep_count(const cns_sweep *s);
/* x = from + i step; its text is a decimal where it is one. */
void cns_sweep_value(const cns_sweep *s, int i, cns_number *x);

/* The columns of a row. */
#define CNS_SWEEP_HEADER                                                                                     \
    "mode,symmetry,returns,winding,period,descent,multiplier,lambda,lambda_se,transient,maxima,note"

/* rows[0..count-1]: new texts without a newline, NULL where a job was not done; they begin with the value of
 * the parameter, an exact decimal or a fraction. A value whose motion cannot be computed has the mode
 * `failed` and says why. directory: where every row is kept, so that the same sweep again does what is
 * missing; NULL: nowhere. */
cns_code cns_sweep_run(const cns_system *s, const cns_sweep *sweep, const cns_classify_spec *spec,
                       const char *directory, const cns_monitor *monitor, char **rows, cns_error *err);

CNS_END_DECLS

#endif
