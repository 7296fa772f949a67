/* The registry of models: equations, states, parameters, scales and derived quantities.
 * A new model is one file in src/model and one row in src/model/registry.c. */
#ifndef CNS_MODEL_H
#define CNS_MODEL_H

#include "cns/program.h"
#include "cns/status.h"

typedef struct cns_model_state {
    const char *name;
    const char *meaning;
    double scale; /* a typical size: tolerances and norms are relative to it; > 0 */
} cns_model_state;

typedef struct cns_model_parameter {
    const char *name;
    const char *meaning;
    const char *standard; /* the default, as text */
    const char *minimum;  /* the open lower end of the range, as text; NULL: none */
} cns_model_parameter;

typedef struct cns_model_output { /* a derived quantity that tables can show */
    const char *name;
    const char *meaning;
} cns_model_output;

/* What makes two states of a motion the same motion. A turn adds 2 pi / turns to the angle and multiplies
 * every state by its turn_sign; the mirror image multiplies every state by its mirror_sign, the angle's being
 * -1. Both map solutions to solutions. */
typedef struct cns_model_motion {
    int angle;                      /* a state */
    int rate;                       /* the state that is the angle's rate of change; -1: none */
    int turns;                      /* in a whole revolution, >= 1 */
    int height;                     /* the state that measures it; -1: none */
    const signed char *turn_sign;   /* n_states: 1 or -1 */
    const signed char *mirror_sign; /* n_states: 1 or -1; NULL: the mirror image is no solution */
} cns_model_motion;

typedef struct cns_model {
    const char *name;
    const char *title;
    const char *source; /* where the equations come from */
    int n_states, n_parameters, n_outputs;
    const cns_model_state *states;
    const cns_model_parameter *parameters;
    const cns_model_output *outputs;
    const cns_model_motion *motion; /* NULL: no state is an angle */
    /* Writes the right-hand side and the outputs (in the order of `outputs`) into a new program. */
    void (*build)(cns_program *p);
} cns_model;

int cns_model_count(void);
const cns_model *cns_model_at(int i);
const cns_model *cns_model_find(const char *name); /* NULL when there is none */

/* A finished program of the model. The parameters are checked against nothing: case files do that. */
cns_code cns_model_program(const cns_model *m, const cns_number *parameters,
                           const cns_program_options *options, cns_program **program, cns_error *err);

#endif
