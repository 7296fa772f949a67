/* A system: the equations of a model with their numbers, which is what one can integrate and study.
 *
 * It holds a model, values for its parameters, initial states, the smoothing of absolute values if there is
 * one, and the finished program of all that. It is read-only once it is made: threads may share it, and a
 * system with another value is another system. */
#ifndef CNS_SYSTEM_H
#define CNS_SYSTEM_H

#include "cns/model.h"
#include "cns/number.h"
#include "cns/program.h"
#include "cns/status.h"

CNS_BEGIN_DECLS

typedef struct cns_system cns_system;

/* parameters: model->n_parameters numbers; NULL: the model's defaults. initial: model->n_states numbers, the
 * states at the start, t = 0; NULL: zeros. smooth: eps > 0, so that sqrt(a^2 + eps^2) stands for every
 * abs(a); NULL: true absolute values. Numbers are copied; the model is not, and outlives the system. NULL on
 * failure: CNS_USAGE, a parameter below its minimum or without a value; CNS_NUMERIC, what the program says.
 */
cns_system *cns_system_new(const cns_model *model, const cns_number *parameters, const cns_number *initial,
                           const cns_number *smooth, cns_error *err);

/* A parameter or a state of the model by its name, or "smooth", and its number as text (see number.h). */
typedef struct cns_setting {
    const char *name, *text;
} cns_setting;

/* The same by names. settings: a list that ends with {NULL, NULL}; what it leaves out is as above. NULL on
 * failure, CNS_USAGE also for a name that the model does not have, for a text that is no number, and for
 * model NULL, which is what cns_model_find() says of a name that it does not know. */
cns_system *cns_system_parse(const cns_model *model, const cns_setting *settings, cns_error *err);

/* The same system but for one number, or for the smoothing (eps NULL: true absolute values). varied: a
 * parameter; from n_parameters on, the states at t = 0. */
cns_system *cns_system_with(const cns_system *s, int varied, const cns_number *value, cns_error *err);
cns_system *cns_system_smoothed(const cns_system *s, const cns_number *eps, cns_error *err);

/* The same system, whose initial states are those at the time `start`, rational; followed from there against
 * time, if `backwards`. All that computes with a system counts the time that passes, from 0 on: rows and
 * events of cns/solve.h, and messages, have its time. */
cns_system *cns_system_from(const cns_system *s, const cns_number *start, bool backwards, cns_error *err);
bool cns_system_is_backwards(const cns_system *s);
const cns_number *cns_system_start(const cns_system *s);
/* time = the time at which so much has passed, exactly; they may be the same. */
void cns_system_time(const cns_system *s, mpq_t time, mpq_srcptr passed);

void cns_system_free(cns_system *s); /* NULL: nothing */

const cns_model *cns_system_model(const cns_system *s);
const cns_program *cns_system_program(const cns_system *s);   /* finished */
const cns_number *cns_system_parameters(const cns_system *s); /* model->n_parameters */
const cns_number *cns_system_initial(const cns_system *s);    /* model->n_states */
const cns_number *cns_system_smooth(const cns_system *s);     /* NULL: true absolute values */
const double *cns_system_scales(const cns_system *s);         /* model->n_states: the model's typical sizes */

/* Which states keep their initial value for ever (constant, n_states), and which outputs are zero for ever
 * (zero_output, n_outputs). Both are proven, not measured: a derivative vanishes identically, or the dynamic
 * states begin in a fixed point of one of the model's symmetries, or of a product of them, so that what
 * changes its sign under it cannot move. CNS_MEMORY; CNS_NUMERIC, as for cns_flow_new(). */
cns_code cns_system_constants(const cns_system *s, bool *constant, bool *zero_output, cns_error *err);

/* The model's guesses for the fixed points of this system, at most CNS_MODEL_MAX_GUESSES; returns how many.
 */
int cns_system_guesses(const cns_system *s, cns_model_guess *guesses);

/* A new text of all that results of this system depend on (version, parameters, initial states, smoothing,
 * scales and the program itself), to tell whether results that were kept are those of this system. It begins
 * with what is done with the system, formatted. varied: a number that is left out, as in cns_system_with(),
 * because results are kept under its value; -1: none. NULL: out of memory. */
#if defined(__GNUC__)
__attribute__((format(printf, 3, 4)))
#endif
char *
cns_system_identity(const cns_system *s, int varied, const char *format, ...);

CNS_END_DECLS

#endif
