/* Watched quantities: those in whose zeros the solution is not analytic. */
#include "jet_internal.h"

static cns_watched watched_by(const cns_jet *J, int w)
{
    const int v = J->p->watch[w];
    return cns_operation_of(J, v)->watch(J, v);
}

bool cns_jet_lies_on_kinks(cns_jet *J)
{
    bool any = false;
    long e;
    for (int w = 0; w < J->p->n_watch; w++) {
        const cns_watched watched = watched_by(J, w);
        const int u = watched.node;
        if (watched.kind != CNS_WATCH_KINK || J->p->node[u].constant)
            continue;
        J->at_zero[u] = J->ops->get_2exp(J->A, &e, J->series[u], 0) == 0 || e < -(long)J->spec.prec / 2;
        any = any || J->at_zero[u];
    }
    return any;
}

int cns_jet_watched(const cns_jet *J)
{
    return J->p->n_watch;
}

void cns_jet_set_zero(cns_jet *J, int w)
{
    J->at_zero[watched_by(J, w).node] = true;
}

bool cns_jet_watch(const cns_jet *J, int w, cns_watch *watch)
{
    const cns_watched watched = watched_by(J, w);
    const int v = watched.node, held = J->p->watch[w];
    const cns_program_node *n = &J->p->node[v];
    if (J->vanishes[v])
        return false;
    watch->series = J->series[v];
    watch->state = n->op == CNS_OP_STATE ? n->index : -1;
    watch->kind = watched.kind;
    watch->eps = watch->kind == CNS_WATCH_SMOOTH ? J->series[watched.eps] : -1;
    watch->order = J->singular         ? cns_least(J->known[v] - 1, J->order)
                   : watch->state >= 0 ? J->order
                                       : J->order - 1;
    watch->zeros = 0;
    if (watch->kind == CNS_WATCH_KINK) {
        /* Coefficients of |u| before the one that decided the sign were stored as zero (root.c). */
        if (!J->sign[held])
            return false;
        while (watch->zeros < watch->order && cns_is_zero(J, J->series[held], watch->zeros))
            watch->zeros++;
    } else {
        while (watch->zeros < watch->order && cns_is_zero(J, J->series[v], watch->zeros))
            watch->zeros++;
    }
    return true;
}

/* The next kink of J from watched quantity *w on. */
static bool next_kink(const cns_jet *J, int *w)
{
    while (*w < J->p->n_watch &&
           (watched_by(J, *w).kind != CNS_WATCH_KINK || !J->p->node[J->p->watch[*w]].needed))
        ++*w;
    return *w < J->p->n_watch;
}

bool cns_jet_signs_agree(const cns_jet *J, const cns_jet *of)
{
    int other = 0;
    for (int w = 0; next_kink(J, &w); w++, other++) {
        do
            if (!next_kink(of, &other))
                return false;
        while (J->sign[J->p->watch[w]] != of->sign[of->p->watch[other]] && other++ >= 0);
    }
    return true;
}
