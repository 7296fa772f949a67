/* Tangents: the variational equations of a program, derived from it operation by operation. */
#ifndef CNS_TAYLOR_TANGENT_H
#define CNS_TAYLOR_TANGENT_H

#include "cns/program.h"

/* A new finished program for the dynamic states of p and `directions` tangent vectors along with them.
 * With d dynamic states, its states are: the d dynamic states in p's order, then the d components of the
 * first tangent vector, and so on. An abs() contributes the sign that it holds. Tangents do not jump where it
 * changes, as the right-hand side is continuous there (the saltation matrix is the identity). */
cns_code cns_tangent_program(const cns_program *p, int directions, cns_program **tangent, cns_error *err);

/* The same for all n states of p: the n states, then the n components of the first vector, and so on. */
cns_code cns_whole_tangent_program(const cns_program *p, int directions, cns_program **tangent,
                                   cns_error *err);

/* The first with one state more, the last: its derivative is the trace of the Jacobian of the dynamic states,
 * so that it grows by the integral of that. Nothing feeds back on it. */
cns_code cns_traced_tangent_program(const cns_program *p, int directions, cns_program **tangent,
                                    cns_error *err);

/* Sets y to d state_i/dt if that is the same rational number everywhere, by the texts of its constants. */
bool cns_exact_derivative(const cns_program *p, int i, mpq_t y);

/* The number of dynamic states, and which they are: index[0..d-1]. */
int cns_dynamic_states(const cns_program *p, int *index);

/* Does the derivative of any state depend on state i? Of passive states, those that others are made of. And
 * all such states. */
bool cns_is_in_derivatives(const cns_program *p, int i);
int cns_states_in_derivatives(const cns_program *p, int *index);

#endif
