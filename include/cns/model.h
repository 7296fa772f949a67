/* Models: equations with the names of their states and parameters, and what else is known of them.
 *
 * The models of this library are found by name. Equations of your own are a cns_model that you fill yourself:
 * name, states and build are needed, parameters and outputs where the equations have some; all else may be 0.
 * A model that the library shall know by name is one file in src/model and one row in src/model/registry.c.
 */
#ifndef CNS_MODEL_H
#define CNS_MODEL_H

#include "cns/program.h"
#include "cns/status.h"

CNS_BEGIN_DECLS

typedef struct cns_model_state {
    const char *name;
    const char *meaning;
    double scale; /* a typical size: tolerances and norms are relative to it; > 0 */
} cns_model_state;

typedef struct cns_model_parameter {
    const char *name;
    const char *meaning;
    const char *standard; /* the default, as text; NULL: it must be given */
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

/* Where Newton's method for a fixed point of the dynamic states may start. */
#define CNS_MODEL_MAX_STATES  16
#define CNS_MODEL_MAX_GUESSES 8
typedef struct cns_model_guess {
    const char *name;
    double state[CNS_MODEL_MAX_STATES]; /* n_states of them; the passive ones do not count */
} cns_model_guess;

/* A map of the states, s_i -> sign_i s_i + shift_i, that takes solutions to solutions. */
typedef struct cns_model_symmetry {
    const char *name;
    const signed char *sign;  /* n_states, 1 or -1 */
    const char *const *shift; /* n_states texts as in case files; NULL: 0 */
} cns_model_symmetry;

/* The unstable manifold of a saddle with one unstable direction that may connect to the saddle itself or to
 * one of its images under the symmetries: a change between two modes. */
typedef struct cns_model_connection {
    const char *saddle;        /* the name of its guess */
    int along;                 /* the state that grows on the branch to be followed */
    const char *back, *beyond; /* the modes: having come near the next saddle, `along` falls or grows away */
} cns_model_connection;

/* A straight line for the critical predictable time (cns/study/laws.h): T_c = slope x + intercept. */
typedef struct cns_model_line {
    double slope, intercept;
} cns_model_line;

/* Laws of the critical predictable time that have been published for the model, to compare with. */
typedef struct cns_model_published {
    const char *authors, *subject; /* whose, and of which motion, as in "their case 1" */
    cns_model_line digits;         /* x = K, the decimal digits of the arithmetic */
    cns_model_line steps;          /* x = -log10 of the fixed step h of a method of this order */
    int order;
} cns_model_published;

typedef struct cns_model cns_model;
struct cns_model {
    const char *name;
    const char *title;
    const char *source; /* where the equations come from */
    int n_states, n_parameters, n_outputs;
    const cns_model_state *states;
    const cns_model_parameter *parameters;
    const cns_model_output *outputs;
    const cns_model_motion *motion; /* NULL: no state is an angle */
    /* Writes the right-hand side and the outputs (in the order of `outputs`) into a new program, from the
     * model's own data if it has some. */
    void (*build)(cns_program *p, const cns_model *model);
    const void *data;
    /* The guesses for all fixed points that there are with these parameters, at most CNS_MODEL_MAX_GUESSES,
     * up to turns of an angle by 2 pi; returns how many. NULL: the model knows none. */
    int (*equilibria)(const double *parameters, cns_model_guess *guesses);
    int n_symmetries;
    const cns_model_symmetry *symmetries;
    const cns_model_connection *connection; /* NULL: none known */
    const cns_model_published *published;   /* NULL: none known */
};

int cns_model_count(void);
const cns_model *cns_model_at(int i);
const cns_model *cns_model_find(const char *name); /* NULL when there is none */

/* A finished program of the model with parameters that are checked against nothing; cns_system_new() does. */
cns_code cns_model_program(const cns_model *m, const cns_number *parameters,
                           const cns_program_options *options, cns_program **program, cns_error *err);

CNS_END_DECLS

#endif
