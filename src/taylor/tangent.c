#include "tangent.h"

#include <stdio.h>
#include <stdlib.h>

#include "core/text.h"
#include "op/rules.h"

int cns_dynamic_states(const cns_program *p, int *index)
{
    int d = 0;
    for (int i = 0; i < p->n_states; i++)
        if (p->dynamic[i])
            index[d++] = i;
    return d;
}

bool cns_is_in_derivatives(const cns_program *p, int i)
{
    return p->state_node[i] >= 0 && p->node[p->state_node[i]].needed;
}

int cns_states_in_derivatives(const cns_program *p, int *index)
{
    int d = 0;
    for (int i = 0; i < p->n_states; i++)
        if (cns_is_in_derivatives(p, i))
            index[d++] = i;
    return d;
}

cns_node cns_plus(const cns_direction *d, cns_node da, cns_node db)
{
    return da < 0 ? db : db < 0 ? da : cns_add(d->q, da, db);
}

cns_node cns_minus(const cns_direction *d, cns_node da)
{
    return da < 0 ? -1 : cns_neg(d->q, da);
}

cns_node cns_times(const cns_direction *d, cns_node a, cns_node db)
{
    return db < 0 ? -1 : cns_mul(d->q, a, db);
}

cns_node cns_over(const cns_direction *d, cns_node da, cns_node b)
{
    return da < 0 ? -1 : cns_div(d->q, da, b);
}

cns_node cns_component(const cns_direction *d)
{
    const int component = d->component[d->node->index];
    return component == CNS_COMPONENT_ONE    ? cns_constant(d->q, "1")
           : component == CNS_COMPONENT_ZERO ? -1
                                             : cns_state(d->q, component);
}

/* Which nodes of p the derivatives of its dynamic states need, companions included. */
static void mark_wanted(const cns_program *p, const int *index, int dims, bool *wanted)
{
    for (int k = 0; k < dims; k++) {
        wanted[p->derivative[index[k]]] = true;
        if (p->factor[index[k]] >= 0)
            wanted[p->factor[index[k]]] = true;
    }
    for (int v = p->n_nodes - 1; v >= 0; v--)
        for (int k = 0; k < 4; k++)
            if (wanted[v] && p->node[v].arg[k] >= 0)
                wanted[p->node[v].arg[k]] = true;
    for (int v = 0; v + 1 < p->n_nodes; v++)
        if (wanted[v] && cns_operations[p->node[v].op]->has_companion)
            wanted[v + 1] = true;
}

/* Node v of p in q, where nothing is but the wanted nodes before it, in the same order: so a companion is
 * again the next node. */
static cns_node copy(cns_program *q, const cns_program *p, int v, const cns_node *map, const int *state)
{
    const cns_program_node *n = &p->node[v];
    cns_node x[4];
    if (n->op == CNS_OP_STATE)
        return cns_state(q, state[n->index]);
    if (n->op == CNS_OP_CONSTANT && n->index >= 0)
        return cns_constant(q, p->constants[n->index].text);
    for (int k = 0; k < 4; k++)
        x[k] = n->arg[k] < 0 ? -1 : map[n->arg[k]];
    return cns_intern(q, n->op, n->index, x[0], x[1], x[2], x[3]);
}

/* The derivatives of the wanted nodes of p along one direction. */
static void derive(cns_program *q, const cns_program *p, const bool *wanted, const cns_node *map,
                   const int *component, cns_node *derivative)
{
    for (int v = 0; v < p->n_nodes; v++) {
        const cns_program_node *n = &p->node[v];
        cns_direction d = {.q = q, .node = n, .w = map[v], .component = component};
        for (int k = 0; k < 4; k++) {
            d.x[k] = n->arg[k] < 0 ? -1 : map[n->arg[k]];
            d.dx[k] = n->arg[k] < 0 ? -1 : derivative[n->arg[k]];
        }
        derivative[v] = wanted[v] && !n->constant ? cns_operations[n->op]->derive(&d) : -1;
    }
}

/* f times the factor that cns_program_finish() has taken off the derivative of state i. */
static cns_node with_factor(cns_program *q, const cns_program *p, int i, const cns_node *map, cns_node f)
{
    return p->factor[i] < 0 || f < 0 ? f : cns_mul(q, map[p->factor[i]], f);
}

/* Writes into q the tangent vectors of p's dynamic states (as cns_tangent_program() has them), and then, if
 * `traced`, the integral of the trace: the sum over k of component k of the derivative along unit vector k.
 */
static void write_tangents(cns_program *q, const cns_program *p, const int *index, int dims, int directions,
                           bool traced, const bool *wanted, const cns_node *map, int *component, cns_node *d)
{
    for (int j = 0; j < directions; j++) {
        for (int k = 0; k < dims; k++)
            component[index[k]] = dims * (1 + j) + k;
        derive(q, p, wanted, map, component, d);
        for (int k = 0; k < dims; k++) {
            cns_node f = with_factor(q, p, index[k], map, d[p->derivative[index[k]]]);
            cns_derivative(q, component[index[k]], f < 0 ? cns_constant(q, "0") : f);
        }
    }
    cns_node trace = -1;
    for (int k = 0; k < dims && traced; k++) {
        for (int i = 0; i < dims; i++)
            component[index[i]] = i == k ? CNS_COMPONENT_ONE : CNS_COMPONENT_ZERO;
        derive(q, p, wanted, map, component, d);
        cns_node f = with_factor(q, p, index[k], map, d[p->derivative[index[k]]]);
        trace = f < 0 ? trace : trace < 0 ? f : cns_add(q, trace, f);
    }
    if (traced)
        cns_derivative(q, dims * (1 + directions), trace < 0 ? cns_constant(q, "0") : trace);
}

/* whole: of all states, not the dynamic ones only. */
static cns_code variational(const cns_program *p, int directions, bool whole, bool traced,
                            cns_program **tangent, cns_error *err)
{
    int *index = malloc(((size_t)p->n_states + 1) * sizeof *index);
    int *state = malloc(((size_t)p->n_states + 1) * sizeof *state);
    int *component = malloc(((size_t)p->n_states + 1) * sizeof *component);
    cns_node *map = malloc(((size_t)p->n_nodes + 1) * sizeof *map);
    cns_node *d = malloc(((size_t)p->n_nodes + 1) * sizeof *d);
    bool *wanted = calloc((size_t)p->n_nodes + 1, sizeof *wanted);
    cns_program *q = NULL;
    cns_code code = CNS_NUMERIC;
    *tangent = NULL;
    if (index && state && component && map && d && wanted) {
        int dims = whole ? p->n_states : cns_dynamic_states(p, index);
        for (int k = 0; k < dims && whole; k++)
            index[k] = k;
        cns_program_options options = {.smooth = p->is_smooth ? &p->smooth : NULL};
        q = cns_program_new(dims * (1 + directions) + traced, p->n_parameters, p->parameters, &options);
        for (int k = 0; k < p->n_states; k++)
            state[k] = component[k] = CNS_COMPONENT_ZERO;
        for (int k = 0; k < dims; k++)
            state[index[k]] = k;
        for (int k = 0; q && k < dims * (1 + directions); k++) {
            char name[2 * CNS_QUOTE];
            snprintf(name, sizeof name, "%s%s", k < dims ? "" : "the tangent of ", p->name[index[k % dims]]);
            cns_name_state(q, k, name);
        }
        mark_wanted(p, index, dims, wanted);
        for (int v = 0; q && v < p->n_nodes; v++)
            map[v] = wanted[v] ? copy(q, p, v, map, state) : -1;
        for (int k = 0; q && k < dims; k++)
            cns_derivative(q, k, with_factor(q, p, index[k], map, map[p->derivative[index[k]]]));
        if (q)
            write_tangents(q, p, index, dims, directions, traced, wanted, map, component, d);
        if (q)
            code = cns_program_finish(q, err);
    }
    if (!q)
        code = cns_out_of_memory(err);
    free(index);
    free(state);
    free(component);
    free(map);
    free(d);
    free(wanted);
    if (code)
        cns_program_free(q);
    else
        *tangent = q;
    return code;
}

cns_code cns_tangent_program(const cns_program *p, int directions, cns_program **tangent, cns_error *err)
{
    return variational(p, directions, false, false, tangent, err);
}

cns_code cns_whole_tangent_program(const cns_program *p, int directions, cns_program **tangent,
                                   cns_error *err)
{
    return variational(p, directions, true, false, tangent, err);
}

cns_code cns_traced_tangent_program(const cns_program *p, int directions, cns_program **tangent,
                                    cns_error *err)
{
    return variational(p, directions, false, true, tangent, err);
}

/* Sets y to node v if that is a rational number, made of such ones. */
static bool exact_node(const cns_program *p, cns_node v, mpq_t y)
{
    const cns_program_node *n = &p->node[v];
    const cns_operation *op = cns_operations[n->op];
    mpq_t x[4];
    bool is = n->constant && op->exact != NULL;
    for (int k = 0; k < 4; k++)
        mpq_init(x[k]);
    for (int k = 0; k < op->operands && is; k++)
        is = exact_node(p, n->arg[k], x[k]);
    is = is && op->exact(p, n, (const mpq_t *)x, y);
    for (int k = 0; k < 4; k++)
        mpq_clear(x[k]);
    return is;
}

bool cns_exact_derivative(const cns_program *p, int i, mpq_t y)
{
    mpq_t factor;
    mpq_init(factor);
    bool is = exact_node(p, p->derivative[i], y) && (p->factor[i] < 0 || exact_node(p, p->factor[i], factor));
    if (is && p->factor[i] >= 0)
        mpq_mul(y, y, factor);
    mpq_clear(factor);
    return is;
}
