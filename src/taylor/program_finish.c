/* What is found out about a program once it is complete: which nodes are needed, what feeds back, what is to
 * be watched, and which sums need not be stored. */
#include <stdlib.h>
#include <string.h>

#include "program_internal.h"

/* Marks the nodes that derivatives need, companions included (whose operands are needed already). */
static void mark_needed(cns_program *p)
{
    for (int i = 0; i < p->n_states; i++)
        p->node[p->derivative[i]].needed = true;
    for (int v = p->n_nodes - 1; v >= 0; v--)
        for (int k = 0; k < 4; k++)
            if (p->node[v].needed && p->node[v].arg[k] >= 0)
                p->node[p->node[v].arg[k]].needed = true;
    for (int v = 0; v + 1 < p->n_nodes; v++)
        if (p->node[v].needed && cns_operations[p->node[v].op]->has_companion)
            p->node[v + 1].needed = true;
}

/* Which states node f is made of. */
static void states_of(const cns_program *p, cns_node f, bool *seen, bool *states)
{
    memset(seen, 0, (size_t)p->n_nodes * sizeof *seen);
    memset(states, 0, (size_t)p->n_states * sizeof *states);
    seen[f] = true;
    for (int v = f; v >= 0; v--)
        if (seen[v]) {
            const cns_program_node *n = &p->node[v];
            if (n->op == CNS_OP_STATE)
                states[n->index] = true;
            for (int k = 0; k < 4; k++)
                if (n->arg[k] >= 0)
                    seen[n->arg[k]] = true;
        }
}

/* A state is passive when it appears in derivatives of passive states only, and not in its own. */
static bool mark_dynamic(cns_program *p)
{
    int n = p->n_states;
    bool *seen = calloc((size_t)p->n_nodes + 1, sizeof *seen);
    bool *feeds = calloc((size_t)n * (size_t)n + 1, sizeof *feeds); /* feeds[j n + i]: i appears in x_j' */
    if (!seen || !feeds) {
        free(seen);
        free(feeds);
        return false;
    }
    for (int j = 0; j < n; j++) {
        states_of(p, p->derivative[j], seen, feeds + (size_t)j * (size_t)n);
        p->dynamic[j] = false;
    }
    /* Transitive closure; a state is dynamic if it reaches a state that reaches itself. */
    for (int k = 0; k < n; k++)
        for (int j = 0; j < n; j++)
            if (feeds[j * n + k])
                for (int i = 0; i < n; i++)
                    if (feeds[k * n + i])
                        feeds[j * n + i] = true;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            if (feeds[j * n + j] && (i == j || feeds[j * n + i]))
                p->dynamic[i] = true;
    free(seen);
    free(feeds);
    return true;
}

/* Folds sums and products whose one user only adds them to its accumulator. And where a derivative is a
 * constant times something, takes the constant c off as its factor: x_{k+1} = (c H/(k+1)) * (coefficient k of
 * something) is one multiplication instead of two. */
static void fold(cns_program *p)
{
    bool *stored = calloc((size_t)p->n_nodes + 1, sizeof *stored);
    if (!stored) {
        cns_out_of_memory(&p->error);
        return;
    }
    for (int i = 0; i < p->n_states; i++)
        p->node[p->derivative[i]].uses++;
    for (int v = 0; v < p->n_nodes; v++) {
        const cns_program_node *n = &p->node[v];
        const cns_operation *op = cns_operations[n->op];
        if (!n->needed || n->constant)
            continue;
        for (int k = 0; k < op->operands; k++) {
            p->node[n->arg[k]].uses++;
            if (!(op->adds >> k & 1))
                stored[n->arg[k]] = true;
        }
        if (op->has_companion)
            stored[v + 1] = true;
    }
    for (int v = 0; v < p->n_nodes; v++) {
        cns_program_node *n = &p->node[v];
        const bool may =
            cns_operations[n->op]->accumulate && !(n->op == CNS_OP_SCALE && p->node[n->arg[1]].folded);
        n->folded = may && !n->constant && n->needed && n->uses == 1 && !stored[v];
    }
    for (int i = 0; i < p->n_states; i++) {
        cns_program_node *n = &p->node[p->derivative[i]];
        if (n->op == CNS_OP_SCALE && !n->constant && n->uses == 1) {
            n->folded = true; /* nobody computes it, only its operand */
            p->factor[i] = n->arg[0];
            p->derivative[i] = n->arg[1];
        }
    }
    free(stored);
}

static bool find_watched(cns_program *p)
{
    p->watch = calloc((size_t)p->n_nodes + 1, sizeof *p->watch);
    if (!p->watch)
        return false;
    for (int v = 0; v < p->n_nodes; v++) {
        const cns_program_node *n = &p->node[v];
        if (n->needed && !n->constant && cns_operations[n->op]->watch)
            p->watch[p->n_watch++] = v;
    }
    return true;
}

cns_code cns_program_finish(cns_program *p, cns_error *err)
{
    for (int i = 0; i < p->n_states && !p->error.code; i++)
        if (p->derivative[i] < 0)
            cns_fail(&p->error, CNS_NUMERIC, "state %d has no derivative", i);
    if (!p->error.code && !p->finished) {
        for (int i = 0; i < p->n_states && p->backwards; i++)
            p->derivative[i] = cns_neg(p, p->derivative[i]);
        mark_needed(p);
        if (!mark_dynamic(p) || !find_watched(p))
            cns_out_of_memory(&p->error);
        else
            fold(p);
        p->finished = true;
    }
    if (p->error.code)
        return cns_fail(err, p->error.code, "%s", p->error.text);
    return CNS_OK;
}
