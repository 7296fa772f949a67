/* A system of ODEs, x' = f(x), as a program of operations.
 *
 * A model's build function (cns/model.h) writes f down once, from states, parameters and constants; series,
 * tangents, enclosures and pointwise values are all computed from this one program. Each call adds a node,
 * the result of one operation; a call whose operation and operands have been seen before returns the earlier
 * node (in sums and products whatever the order of the operands), so nothing is computed twice. Operations on
 * constants give constants, computed once for each precision.
 *
 * Errors (out of memory, an operand of another program, an exponent that is not constant) need no attention
 * while the program is built: from the first on nodes are invalid, and cns_program_finish() reports it. */
#ifndef CNS_PROGRAM_H
#define CNS_PROGRAM_H

#include <stdbool.h>
#include <stdio.h>

#include "cns/number.h"
#include "cns/status.h"

CNS_BEGIN_DECLS

typedef struct cns_program cns_program;
typedef int cns_node; /* index of a node; -1 is invalid */

typedef struct cns_program_options {
    const cns_number *smooth; /* NULL: abs() is exact; else abs(u) becomes sqrt(u^2 + smooth^2) */
    bool backwards;           /* against time: every derivative takes the other sign */
    double start;             /* the time at which it begins, for messages */
} cns_program_options;

/* parameters: the values of the model's parameters, copied; n_states, n_parameters >= 0. options may be NULL.
 * NULL when memory runs out. Programs of models come from cns_system_new(), which calls this. */
cns_program *cns_program_new(int n_states, int n_parameters, const cns_number *parameters,
                             const cns_program_options *options);
void cns_program_free(cns_program *p);

/* The time at which so much has passed since the start, rounded: for messages. */
double cns_program_time(const cns_program *p, double passed);

/* What messages call a state; "state 0" and so on, until it is told. The name is copied. */
void cns_name_state(cns_program *p, int i, const char *name);
const char *cns_state_name(const cns_program *p, int i);

cns_node cns_state(cns_program *p, int i);     /* 0 .. n_states - 1 */
cns_node cns_parameter(cns_program *p, int i); /* 0 .. n_parameters - 1 */
cns_node cns_constant(cns_program *p,
                      const char *text); /* exact, as in cns/number.h: "8/3", "1e-30", "pi/2" */

/* Where an operation is not defined on a trajectory (division by 0, sqrt, log or pow of what is not
 * positive), the trajectory ends with CNS_NUMERIC, unless the singularity cancels, as in
 * x^2 / sqrt(x^2 + y^2) at a start from x = y = 0. */
cns_node cns_add(cns_program *p, cns_node a, cns_node b);
cns_node cns_sub(cns_program *p, cns_node a, cns_node b);
cns_node cns_neg(cns_program *p, cns_node a);
cns_node cns_mul(cns_program *p, cns_node a, cns_node b);
cns_node cns_sqr(cns_program *p, cns_node a); /* a^2 */
cns_node cns_div(cns_program *p, cns_node a, cns_node b);
cns_node cns_sqrt(cns_program *p, cns_node a);
cns_node cns_hypot(cns_program *p, cns_node a, cns_node b); /* sqrt(a^2 + b^2) */
void cns_sincos(cns_program *p, cns_node a, cns_node *sin_a, cns_node *cos_a);
cns_node cns_exp(cns_program *p, cns_node a);
cns_node cns_log(cns_program *p, cns_node a);
cns_node cns_pow(cns_program *p, cns_node a, cns_node exponent); /* exponent a constant, a > 0 */
cns_node cns_abs(cns_program *p, cns_node a);                    /* exact or smoothed, by the options */

/* d state_i / dt = f. Every state needs one. */
void cns_derivative(cns_program *p, int i, cns_node f);

/* A quantity computed with the states, for output: evaluated pointwise. Returns its index. */
int cns_output(cns_program *p, cns_node f);

/* Validates and orders the program. After this it is read-only and may be shared between threads. */
cns_code cns_program_finish(cns_program *p, cns_error *err);

int cns_program_states(const cns_program *p);         /* how many */
int cns_program_outputs(const cns_program *p);        /* how many */
bool cns_program_is_smooth(const cns_program *p);     /* has it smoothed absolute values? */
double cns_program_smooth_log2(const cns_program *p); /* log2 of their eps */

/* Does anything feed back on state i? If not (the position of a falling disk), it is passive: it neither
 * steers steps nor amplifies errors. Of a finished program. */
bool cns_program_is_dynamic(const cns_program *p, int i);

/* One operation per line; parameters by their number, whatever their values. */
void cns_program_print(const cns_program *p, FILE *out);

CNS_END_DECLS

#endif
