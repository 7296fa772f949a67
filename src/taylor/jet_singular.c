/* Expansions from a point t0 where a divisor or a radicand vanishes, as in a release from rest.
 *
 * A coefficient of a quotient a/b with m leading zeros in b needs a coefficient of a that is m orders higher.
 * So nodes are not computed order by order, but each as far as its operands allow, again and again, and each
 * state as far as its derivative allows, until nothing becomes known any more. Leading zeros are counted on
 * the way. A quotient waits until its divisor's first coefficient that is not zero is known. It is taken to
 * be finite; a product of it with something that has leading zeros is known that many orders further than the
 * quotient itself, which is how states get ahead of it. Where they cannot, the expansion gets stuck, and
 * fails. */
#include <limits.h>

#include "jet_internal.h"
#include "op/rules.h"

enum {
    FAR = INT_MAX / 4, /* `known` of a series of which all coefficients are known */
    NEVER = -FAR       /* `known` of what has no value at t0; only outputs may need it */
};

static void begin(cns_jet *J, int room)
{
    const cns_program *p = J->p;
    for (int v = 0; v < p->n_nodes; v++) {
        const bool fixed = p->node[v].constant || J->vanishes[v];
        J->known[v] = fixed ? FAR : p->node[v].op == CNS_OP_STATE ? 1 : 0;
        J->val[v] = J->vanishes[v] ? room : 0;
        J->sign[v] = 0;
    }
    for (int i = 0; i < p->n_states; i++)
        J->state_known[i] = 1;
}

/* Computes node v until `count` of its coefficients are known, and counts its leading zeros. */
static cns_code compute(cns_jet *J, int v, int count, bool *progress, cns_error *err)
{
    const cns_operation *op = cns_operation_of(J, v);
    while (J->known[v] < count) {
        const int k = J->known[v];
        cns_code code = op->recurrence(J, v, k, err);
        if (code && J->p->node[v].needed)
            return code;
        if (code) {
            J->known[v] = NEVER;
            break;
        }
        J->known[v]++;
        if (J->val[v] == k && cns_is_zero(J, J->series[v], k))
            J->val[v] = k + 1;
        *progress = true;
        if (op->has_companion)
            break; /* whose turn it is */
    }
    return CNS_OK;
}

static cns_code advance_node(cns_jet *J, int v, int room, bool *progress, cns_error *err)
{
    const cns_program_node *n = &J->p->node[v];
    const cns_operation *op = cns_operations[n->op];
    if (n->constant || J->vanishes[v] || (!n->needed && !J->spec.outputs) || J->known[v] < 0)
        return CNS_OK;
    if (n->op == CNS_OP_STATE) {
        while (J->val[v] < J->known[v] && J->val[v] < room && cns_is_zero(J, J->series[v], J->val[v]))
            J->val[v]++;
        return CNS_OK;
    }
    const int count = cns_least(op->known(J, v), room);
    if (count == CNS_POLE) {
        if (n->needed)
            return cns_singular(J, v, "division by zero", err);
        J->known[v] = NEVER;
        return CNS_OK;
    }
    if (J->series[v] >= 0)
        return compute(J, v, count, progress, err);
    *progress = *progress || count > J->known[v];
    J->known[v] = count;
    J->val[v] = cns_least(op->zeros(J, v), room);
    return CNS_OK;
}

/* Returns the number of coefficients that are known of every state. */
static int advance_states(cns_jet *J, int order, bool *progress)
{
    const cns_program *p = J->p;
    int least = FAR;
    for (int i = 0; i < p->n_states; i++) {
        const int reach = J->state_vanishes[i] ? order : cns_least(J->known[p->derivative[i]], order);
        for (; J->state_known[i] <= reach; J->state_known[i]++) {
            *progress = true;
            cns_jet_next_state(J, i, J->state_known[i] - 1);
        }
        if (p->state_node[i] >= 0 && !J->vanishes[p->state_node[i]])
            J->known[p->state_node[i]] = J->state_known[i];
        least = cns_least(least, J->state_known[i]);
    }
    return least;
}

cns_code cns_jet_expand_singular(cns_jet *J, int order, cns_error *err)
{
    const cns_program *p = J->p;
    const int room = J->spec.order + CNS_LOOKAHEAD + 1;
    bool progress = true;
    int least = 1;
    begin(J, room);
    while (progress && (least <= order || J->spec.outputs)) {
        progress = false;
        for (int v = 0; v < p->n_nodes; v++) {
            cns_code code = advance_node(J, v, room, &progress, err);
            if (code)
                return code;
        }
        least = advance_states(J, order, &progress);
    }
    for (int v = 0; v < p->n_nodes && J->spec.outputs;
         v++) /* nor has what is made of something without a value */
        for (int k = 0; k < 4; k++)
            if (p->node[v].arg[k] >= 0 && J->known[p->node[v].arg[k]] < 1 && !J->vanishes[v])
                J->known[v] = NEVER;
    /* Products may need coefficients beyond the room; a few orders less are no failure. */
    J->order = least - 1;
    if (J->order < order - CNS_LOOKAHEAD || J->order < 1)
        return cns_fail(err, CNS_NUMERIC, "the equations are singular");
    return CNS_OK;
}
