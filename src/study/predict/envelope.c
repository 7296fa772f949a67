#include "envelope.h"

#include <math.h>
#include <stdlib.h>

#include "core/memory.h"
#include "num/vector.h"
#include "peak.h"

enum { PIECES = 8, ORDERS_A_PIECE = 16 };

static int nodes(const cns_envelope *e)
{
    return 2 * e->pieces + 1;
}

cns_code cns_envelope_init(cns_envelope *e, int n, const cns_flow_spec *flow, cns_error *err)
{
    *e = (cns_envelope){.n = n, .pieces = PIECES + flow->order / ORDERS_A_PIECE};
    mpq_init(e->time);
    e->base = cns_vector_new(n, CNS_ENVELOPE_BITS);
    e->crest = cns_vector_new(n * e->pieces, CNS_ENVELOPE_BITS);
    e->crest_at = cns_xalloc((size_t)(n * e->pieces), sizeof *e->crest_at);
    e->node = cns_vector_new(n * nodes(e), CNS_ENVELOPE_BITS);
    e->node_at = cns_xalloc((size_t)nodes(e), sizeof *e->node_at);
    if (!e->base || !e->crest || !e->node || !cns_sample_init(&e->sample, flow->program, CNS_ENVELOPE_BITS))
        return cns_out_of_memory(err);
    for (int i = 0; i < n; i++)
        mpfr_set_zero(e->base[i], 1);
    return CNS_OK;
}

void cns_envelope_clear(cns_envelope *e)
{
    if (!e->crest_at)
        return;
    cns_sample_clear(&e->sample);
    cns_vector_free(e->base);
    cns_vector_free(e->crest);
    cns_vector_free(e->node);
    free(e->crest_at);
    free(e->node_at);
    mpq_clear(e->time);
    *e = (cns_envelope){0};
}

mpfr_srcptr cns_observable_of(const cns_sample *s, int i)
{
    return i <= s->n_states ? s->state[i - 1] : s->output[i - 1 - s->n_states];
}

/* E = max(E, |u|); what is not defined is no value. */
static void lift(mpfr_t E, mpfr_srcptr u)
{
    if (!mpfr_nan_p(u) && mpfr_cmpabs(u, E) > 0)
        mpfr_abs(E, u, MPFR_RNDN);
}

void cns_envelope_raise(cns_envelope *e, int i, mpfr_srcptr u)
{
    lift(e->base[i], u);
}

/* |u| of one observable, in units of `unit`, to look for its maximum. */
typedef struct height {
    cns_envelope *e;
    cns_trajectory *trajectory;
    int i;
    mpfr_t unit, quotient;
} height;

static double height_in_units(height *h, mpfr_srcptr u)
{
    mpfr_div(h->quotient, u, h->unit, MPFR_RNDN);
    return fabs(mpfr_get_d(h->quotient, MPFR_RNDN));
}

static double height_at(void *context, double t)
{
    height *h = context;
    mpq_set_d(h->e->time, t);
    cns_trajectory_peek(h->trajectory, h->e->time, &h->e->sample);
    return height_in_units(h, cns_observable_of(&h->e->sample, h->i));
}

/* The crest of observable h->i in piece k. E is its envelope up to this piece, and is raised. */
static void find_crest(height *h, int k, mpfr_t E)
{
    cns_envelope *e = h->e;
    mpfr_ptr crest = e->crest[h->i * e->pieces + k];
    double *at = &e->crest_at[h->i * e->pieces + k];
    const double *t = e->node_at + 2 * k;
    mpfr_t *u = e->node + h->i * nodes(e) + 2 * k;
    mpfr_set(h->unit, E, MPFR_RNDN);
    for (int j = 0; j < 3; j++)
        lift(h->unit, u[j]);
    if (mpfr_zero_p(h->unit) || mpfr_nan_p(u[0]) || mpfr_nan_p(u[1]) || mpfr_nan_p(u[2])) {
        mpfr_set(crest, h->unit, MPFR_RNDN);
        *at = t[2];
    } else {
        const double value[] = {height_in_units(h, u[0]), height_in_units(h, u[1]), height_in_units(h, u[2])};
        const cns_peak peak = cns_peak_find(height_at, h, t, value, CNS_PEAK_NEAR);
        *at = peak.t;
        mpfr_mul_d(crest, h->unit, peak.value, MPFR_RNDN);
    }
    lift(E, crest);
}

/* The observables at the ends and middles of all pieces. */
static void look_at_nodes(cns_envelope *e, cns_trajectory *trajectory)
{
    const cns_flow *f = cns_trajectory_flow(trajectory);
    const double begin = mpfr_get_d(cns_flow_begin(f), MPFR_RNDN),
                 end = mpfr_get_d(cns_flow_end(f), MPFR_RNDN);
    const int last = nodes(e) - 1;
    for (int j = 0; j <= last; j++) {
        e->node_at[j] = j < last ? begin + (end - begin) * j / last : end;
        mpq_set_d(e->time, e->node_at[j]);
        cns_trajectory_peek(trajectory, e->time, &e->sample);
        for (int i = 1; i < e->n; i++)
            mpfr_abs(e->node[i * nodes(e) + j], cns_observable_of(&e->sample, i), MPFR_RNDN);
    }
}

void cns_envelope_follow(cns_envelope *e, cns_trajectory *trajectory)
{
    mpfr_t E;
    height h = {.e = e, .trajectory = trajectory};
    mpfr_inits2(CNS_ENVELOPE_BITS, E, h.unit, h.quotient, (mpfr_ptr)0);
    look_at_nodes(e, trajectory);
    for (h.i = 1; h.i < e->n; h.i++) {
        for (int k = 0; e->stepped && k < e->pieces; k++)
            lift(e->base[h.i], e->crest[h.i * e->pieces + k]);
        mpfr_set(E, e->base[h.i], MPFR_RNDN);
        for (int k = 0; k < e->pieces; k++)
            find_crest(&h, k, E);
    }
    e->stepped = true;
    mpfr_clears(E, h.unit, h.quotient, (mpfr_ptr)0);
}

void cns_envelope_at(const cns_envelope *e, int i, double t, mpfr_srcptr u, mpfr_t E)
{
    mpfr_set(E, e->base[i], MPFR_RNDN);
    for (int k = 0; e->stepped && k < e->pieces; k++)
        if (e->crest_at[i * e->pieces + k] <= t)
            lift(E, e->crest[i * e->pieces + k]);
    lift(E, u);
}
