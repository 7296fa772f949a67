/* A system of ODEs as a program of operations on power series.
 *
 * A model builds its right-hand side once, from states, parameters and constants; the engine computes
 * series, tangents and pointwise values from the same program. Nodes are immutable; a builder call whose
 * operation and operands have been seen before returns the earlier node (common subexpressions are
 * merged, sums and products up to the order of their operands), and operations on constants give
 * constants, evaluated once per precision.
 *
 * Errors (out of memory, an operand of another program, an illegal constant operation) are sticky: the
 * builder returns an invalid node and cns_program_finish() reports the first. */
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
} cns_program_options;

/* parameters: the values of the model's parameters, copied; n_states, n_parameters >= 0. */
cns_program *cns_program_new(int n_states, int n_parameters, const cns_number *parameters,
                             const cns_program_options *options);
void cns_program_free(cns_program *p);

cns_node cns_state(cns_program *p, int i);
cns_node cns_parameter(cns_program *p, int i);
cns_node cns_constant(cns_program *p, const char *text); /* grammar of cns_number */
cns_node cns_add(cns_program *p, cns_node a, cns_node b);
cns_node cns_sub(cns_program *p, cns_node a, cns_node b);
cns_node cns_neg(cns_program *p, cns_node a);
cns_node cns_mul(cns_program *p, cns_node a, cns_node b);
cns_node cns_sqr(cns_program *p, cns_node a);
cns_node cns_div(cns_program *p, cns_node a, cns_node b);
cns_node cns_sqrt(cns_program *p, cns_node a);
cns_node cns_hypot(cns_program *p, cns_node a, cns_node b);
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

int cns_program_states(const cns_program *p);
int cns_program_outputs(const cns_program *p);
bool cns_program_is_smooth(const cns_program *p);
double cns_program_smooth_log2(const cns_program *p); /* log2 of its eps */

/* Does anything feed back on state i? If not (the position of a falling disk), it is passive: it neither
 * steers steps nor amplifies errors. Of a finished program. */
bool cns_program_is_dynamic(const cns_program *p, int i);

/* One operation per line; parameters by their number, whatever their values. */
void cns_program_print(const cns_program *p, FILE *out);

CNS_END_DECLS

#endif
