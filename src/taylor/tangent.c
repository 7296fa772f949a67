#include "tangent.h"

#include <stdlib.h>

#include "program_internal.h"

int cns_dynamic_states(const cns_program *p, int *index)
{
    int d = 0;
    for (int i = 0; i < p->n_states; i++)
        if (p->dynamic[i])
            index[d++] = i;
    return d;
}

/* Sums and products in which -1 stands for zero: most derivatives of most nodes are. */
static cns_node plus(cns_program *q, cns_node a, cns_node b)
{
    return a < 0 ? b : b < 0 ? a : cns_add(q, a, b);
}

static cns_node times(cns_program *q, cns_node a, cns_node db)
{
    return db < 0 ? -1 : cns_mul(q, a, db);
}

static cns_node over(cns_program *q, cns_node da, cns_node b)
{
    return da < 0 ? -1 : cns_div(q, da, b);
}

static cns_node minus(cns_program *q, cns_node a)
{
    return a < 0 ? -1 : cns_neg(q, a);
}

/* The node of q that computes node v of p; map holds those of its operands. */
static cns_node copy(cns_program *q, const cns_program *p, int v, const int *map, const int *state)
{
    const cns_tape_node *n = &p->node[v];
    int a = n->arg[0] >= 0 ? map[n->arg[0]] : -1, b = n->arg[1] >= 0 ? map[n->arg[1]] : -1;
    cns_node s, c;
    switch (n->op) {
    case CNS_OP_STATE:
        return cns_state(q, state[n->index]);
    case CNS_OP_PARAMETER:
        return cns_parameter(q, n->index);
    case CNS_OP_CONSTANT:
        return n->index < 0 ? cns_intern(q, CNS_OP_CONSTANT, -1, -1, -1, -1, -1)
                            : cns_constant(q, p->constants[n->index].text);
    case CNS_OP_HYPOT:
        return cns_hypot(q, a, b);
    case CNS_OP_SIN:
        cns_sincos(q, a, &s, &c);
        return s;
    case CNS_OP_COS:
        cns_sincos(q, a, &s, &c);
        return c;
    case CNS_OP_EXP:
        return cns_exp(q, a);
    case CNS_OP_LOG:
        return cns_log(q, a);
    case CNS_OP_POW:
        return cns_pow(q, a, b);
    case CNS_OP_SMOOTH_ABS:
        return cns_abs(q, b);
    case CNS_OP_EULER:
        return a; /* made anew by whoever needs it */
    default:
        return cns_intern(q, n->op, n->index, a, b, -1, -1);
    }
}

/* The derivative of node v along one direction; d holds those of its operands, w is its copy. */
static cns_node derive(cns_program *q, const cns_program *p, int v, const int *map, const int *d)
{
    const cns_tape_node *n = &p->node[v];
    int ia = n->arg[0], ib = n->arg[1], w = map[v];
    int a = ia >= 0 ? map[ia] : -1, b = ib >= 0 ? map[ib] : -1;
    int da = ia >= 0 ? d[ia] : -1, db = ib >= 0 ? d[ib] : -1;
    switch (n->op) {
    case CNS_OP_ADD:
        return plus(q, da, db);
    case CNS_OP_SUB:
        return plus(q, da, minus(q, db));
    case CNS_OP_NEG:
        return minus(q, da);
    case CNS_OP_MUL:
        return plus(q, times(q, a, db), times(q, b, da));
    case CNS_OP_SQR:
        return da < 0 ? -1 : cns_mul(q, cns_constant(q, "2"), cns_mul(q, a, da));
    case CNS_OP_SCALE:
        return times(q, a, db);
    case CNS_OP_DIV:
        return over(q, plus(q, da, minus(q, times(q, w, db))), b);
    case CNS_OP_SQRT:
    case CNS_OP_SMOOTH_ABS:
        return over(q, da < 0 ? -1 : cns_mul(q, cns_constant(q, "1/2"), da), w);
    case CNS_OP_HYPOT:
        return over(q, plus(q, times(q, a, da), times(q, b, db)), w);
    case CNS_OP_SIN: /* the cosine is the next node of the copy, too */
        return times(q, w + 1, da);
    case CNS_OP_COS:
        return minus(q, times(q, map[n->arg[2]], da));
    case CNS_OP_EXP:
        return times(q, w, da);
    case CNS_OP_LOG:
        return over(q, da, a);
    case CNS_OP_POW:
        return over(q, da < 0 ? -1 : cns_mul(q, b, cns_mul(q, w, da)), a);
    case CNS_OP_ABS:
        return da < 0 ? -1 : cns_signed(q, w, da);
    case CNS_OP_SIGNED:
        return db < 0 ? -1 : cns_signed(q, a, db);
    default:
        return -1;
    }
}

/* f of state i as p computes it: the derivative node with the factor that fold() took off. */
static cns_node with_factor(cns_program *q, const cns_program *p, int i, const int *map, cns_node f)
{
    return p->factor[i] < 0 || f < 0 ? f : cns_mul(q, map[p->factor[i]], f);
}

cns_code cns_tangent_program(const cns_program *p, int directions, cns_program **tangent, cns_error *err)
{
    int *index = malloc(((size_t)p->n_states + 1) * sizeof *index);
    int *state = malloc(((size_t)p->n_states + 1) * sizeof *state);
    int *map = malloc(((size_t)p->n_nodes + 1) * sizeof *map);
    int *d = malloc(((size_t)p->n_nodes + 1) * sizeof *d);
    bool *wanted = calloc((size_t)p->n_nodes + 1, sizeof *wanted);
    cns_program *q = NULL;
    cns_code code = CNS_NUMERIC;
    *tangent = NULL;
    if (index && state && map && d && wanted) {
        int dims = cns_dynamic_states(p, index);
        cns_program_options options = {.smooth = p->is_smooth ? &p->smooth : NULL};
        q = cns_program_new(dims * (1 + directions), p->n_parameters, p->parameters, &options);
        for (int k = 0; k < p->n_states; k++)
            state[k] = -1;
        for (int k = 0; k < dims; k++) {
            state[index[k]] = k;
            wanted[p->derivative[index[k]]] = true;
            if (p->factor[index[k]] >= 0)
                wanted[p->factor[index[k]]] = true;
        }
        for (int v = p->n_nodes - 1; v >= 0; v--)
            for (int k = 0; k < 4; k++)
                if (wanted[v] && p->node[v].arg[k] >= 0)
                    wanted[p->node[v].arg[k]] = true;
        for (int v = 0; q && v < p->n_nodes; v++)
            map[v] = wanted[v] ? copy(q, p, v, map, state) : -1;
        for (int k = 0; q && k < dims; k++)
            cns_derivative(q, k, with_factor(q, p, index[k], map, map[p->derivative[index[k]]]));
        for (int j = 0; q && j < directions; j++) {
            for (int v = 0; v < p->n_nodes; v++) {
                const cns_tape_node *n = &p->node[v];
                d[v] = !wanted[v] || n->constant ? -1
                       : n->op == CNS_OP_STATE   ? cns_state(q, dims * (1 + j) + state[n->index])
                                                 : derive(q, p, v, map, d);
            }
            for (int k = 0; k < dims; k++) {
                cns_node f = with_factor(q, p, index[k], map, d[p->derivative[index[k]]]);
                cns_derivative(q, dims * (1 + j) + k, f < 0 ? cns_constant(q, "0") : f);
            }
        }
        if (q)
            code = cns_program_finish(q, err);
    }
    if (!q)
        code = cns_fail(err, CNS_NUMERIC, "out of memory");
    free(index);
    free(state);
    free(map);
    free(d);
    free(wanted);
    if (code)
        cns_program_free(q);
    else
        *tangent = q;
    return code;
}
