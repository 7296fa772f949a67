#include "cns/solve.h"

#include <math.h>
#include <stdlib.h>

#include "core/memory.h"
#include "core/monitor.h"
#include "integrate/growth.h"
#include "integrate/method.h"
#include "num/decimal_text.h"
#include "num/logs.h"
#include "num/vector.h"
#include "proof.h"

enum { DOUBLE_PRINTED = 17 };

typedef struct found {
    cns_meeting m;
    double noise_log2; /* what noise has grown to, in scales */
} found;

typedef struct list {
    int n, room, n_states;
    found *at;
} list;

static void clear_list(list *l)
{
    for (int i = 0; i < l->n; i++) {
        mpfr_clear(l->at[i].m.time);
        cns_vector_free(l->at[i].m.state, l->n_states);
    }
    free(l->at);
}

static cns_code keep(list *l, const cns_meeting *m, double noise_log2, cns_error *err)
{
    if (l->n == l->room) {
        l->room = 2 * l->room + 16;
        l->at = cns_xgrow(l->at, (size_t)l->room, sizeof *l->at);
    }
    found *f = &l->at[l->n];
    f->m = *m;
    f->noise_log2 = noise_log2;
    f->m.state = cns_vector_new(l->n_states, mpfr_get_prec(m->state[0]));
    if (f->m.state == NULL)
        return cns_fail(err, CNS_NUMERIC, "out of memory");
    mpfr_init2(f->m.time, mpfr_get_prec(m->time));
    mpfr_set(f->m.time, m->time, MPFR_RNDN);
    for (int i = 0; i < l->n_states; i++)
        mpfr_set(f->m.state[i], m->state[i], MPFR_RNDN);
    l->n++;
    return CNS_OK;
}

/* All meetings of a run up to the end, or, to spare, to the end of the step that reaches it. */
static cns_code collect(const cns_problem *p, const cns_events_spec *spec, cns_flow_spec flow, bool verify,
                        bool to_spare, list *l, cns_error *err)
{
    const int n = cns_program_states(cns_system_program(p->system));
    cns_code code = CNS_OK;
    cns_growth *g = NULL;
    cns_meetings *s = NULL;
    mpq_t time;
    mpq_init(time);
    *l = (list){.n_states = n};
    flow.verify = verify;
    cns_flow *f = cns_flow_new(&flow, err);
    if (f != NULL)
        g = cns_growth_new(cns_system_program(p->system), cns_system_scales(p->system), err);
    if (g != NULL)
        s = cns_meetings_new(spec->sections, spec->n_sections, n, cns_system_scales(p->system),
                             cns_flow_prec(f), err);
    if (s == NULL)
        code = err->code;
    if (!code) {
        cns_flow_start(f, cns_system_initial(p->system));
        cns_growth_start(g);
        cns_meetings_start(s);
    }
    while (!code && mpfr_cmp_q(cns_flow_end(f), p->end->ratio) < 0) {
        double growth, noise;
        code = cns_flow_step(f, err);
        if (!code)
            code = cns_growth_follow(g, f, cns_flow_noise_log2(f), err);
        if (!code)
            code = cns_meetings_follow(s, f, err);
        for (int i = 0; !code && i < cns_meetings_count(s); i++) {
            const cns_meeting *m = cns_meetings_meeting(s, i);
            if (!to_spare && mpfr_cmp_q(m->time, p->end->ratio) > 0)
                break;
            mpfr_get_q(time, m->time);
            code = cns_growth_at(g, time, &growth, &noise, err);
            if (!code)
                code = keep(l, m, noise, err);
        }
    }
    cns_meetings_free(s);
    cns_growth_free(g);
    cns_flow_free(f);
    mpq_clear(time);
    return code;
}

/* The partner of event i of the finer run: the meeting of the same number with the same section. */
static const found *partner(const list *fine, const list *coarse, int i)
{
    const int section = fine->at[i].m.section;
    int number = 0;
    for (int k = 0; k < i; k++)
        number += fine->at[k].m.section == section;
    for (int k = 0; k < coarse->n; k++)
        if (coarse->at[k].m.section == section && number-- == 0)
            return &coarse->at[k];
    return NULL;
}

/* e of the time and of the states: differences, or the noise that has grown by then as it shows at the
 * section: a deviation of the states moves the meeting in time by as much as it is large against the rate
 * there. */
static void bound(const cns_problem *p, const found *a, const found *b, int n, mpfr_t time_error,
                  mpfr_t state_error)
{
    mpfr_t x, noise;
    mpfr_inits2(64, x, noise, (mpfr_ptr)0);
    double largest = 1, rate = fabs(a->m.rate);
    for (int i = 0; i < n; i++)
        largest =
            fmax(largest, fmax(cns_system_scales(p->system)[i], fabs(mpfr_get_d(a->m.state[i], MPFR_RNDN))));
    mpfr_sub(time_error, a->m.time, b->m.time, MPFR_RNDA);
    mpfr_abs(time_error, time_error, MPFR_RNDN);
    mpfr_set_zero(state_error, 1);
    for (int i = 0; i < n; i++) {
        mpfr_sub(x, a->m.state[i], b->m.state[i], MPFR_RNDA);
        mpfr_abs(x, x, MPFR_RNDN);
        mpfr_max(state_error, state_error, x, MPFR_RNDU);
    }
    mpfr_set_d(x, b->noise_log2, MPFR_RNDU);
    mpfr_exp2(noise, x, MPFR_RNDU);
    mpfr_mul_d(noise, noise, largest, MPFR_RNDU);
    if (a->m.direction == 0) /* a touch moves like the root of the noise */
        mpfr_sqrt(noise, noise, MPFR_RNDU);
    else
        mpfr_mul_d(noise, noise, 1 + 1 / rate, MPFR_RNDU);
    mpfr_max(time_error, time_error, noise, MPFR_RNDU);
    mpfr_max(state_error, state_error, noise, MPFR_RNDU);
    mpfr_max(state_error, state_error, time_error, MPFR_RNDU);
    mpfr_mul_2ui(time_error, time_error, CNS_PROOF_SAFETY_LOG2, MPFR_RNDU);
    mpfr_mul_2ui(state_error, state_error, CNS_PROOF_SAFETY_LOG2, MPFR_RNDU);
    mpfr_clears(x, noise, (mpfr_ptr)0);
}

static bool certain(const found *f, int n, int own, const mpfr_t te, const mpfr_t se, cns_places places,
                    long count)
{
    if (!cns_text_certain(f->m.time, te, places, count))
        return false;
    for (int i = 0; i < n; i++)
        if (i != own && !cns_text_certain(f->m.state[i], se, places, count))
            return false;
    return true;
}

static char *free_text(mpfr_srcptr x, long digits)
{
    char *made;
    if (mpfr_zero_p(x))
        return cns_xcopy("0");
    if (mpfr_asprintf(&made, "%.*Rg", (int)digits, x) < 0)
        abort();
    char *text = cns_xcopy(made);
    mpfr_free_str(made);
    return text;
}

/* count < 0: no proof, so many digits of the arithmetic. */
static void add_event(cns_events *events, const found *f, cns_places places, long count, long digits)
{
    events->event = cns_xgrow(events->event, (size_t)events->n + 1, sizeof *events->event);
    cns_event *e = &events->event[events->n++];
    *e = (cns_event){.section = f->m.section,
                     .k = f->m.k,
                     .direction = f->m.direction,
                     .decimals = count < 0 ? -1 : count};
    e->state = cns_xalloc((size_t)events->n_states + 1, sizeof *e->state);
    e->time = count < 0 ? free_text(f->m.time, digits) : cns_text_mpfr(f->m.time, places, count);
    for (int i = 0; i < events->n_states; i++)
        e->state[i] =
            count < 0 ? free_text(f->m.state[i], digits) : cns_text_mpfr(f->m.state[i], places, count);
}

/* The events on which two runs agree, with what is certain of them. */
static cns_code agree(const cns_problem *p, const cns_events_spec *spec, const list *fine, const list *coarse,
                      cns_events *events, cns_error *err)
{
    mpfr_t te, se;
    cns_code code = CNS_OK;
    mpfr_inits2(64, te, se, (mpfr_ptr)0);
    for (int i = 0; i < fine->n && !code; i++) {
        const found *a = &fine->at[i], *b = partner(fine, coarse, i);
        const cns_event_condition *section = &spec->sections[a->m.section];
        const int own = section->kind == CNS_CONDITION_EXTREMUM || a->m.direction == 0 ? -1 : section->state;
        const long least = spec->places == CNS_PLACES_DECIMALS ? 0 : 1;
        long count = least - 1;
        if (b != NULL && b->m.k == a->m.k && b->m.direction == a->m.direction) {
            bound(p, a, b, fine->n_states, te, se);
            for (count = spec->count; count >= least; count--)
                if (certain(a, fine->n_states, own, te, se, spec->places, count))
                    break;
        }
        if (count < least)
            code = cns_fail(err, CNS_UNREACHED, "the two runs do not agree on the event at t = %.12g",
                            mpfr_get_d(a->m.time, MPFR_RNDN));
        else
            add_event(events, a, spec->places, count, 0);
    }
    mpfr_clears(te, se, (mpfr_ptr)0);
    return code;
}

cns_code cns_solve_events(const cns_problem *p, const cns_events_spec *spec, cns_events *events,
                          cns_error *err)
{
    const cns_numerics *n = spec->numerics;
    const bool proof = n == NULL || spec->prove;
    const long given = n != NULL && n->digits > 0 ? n->digits : 16;
    list fine = {0}, coarse = {0};
    *events = (cns_events){.n_states = cns_program_states(cns_system_program(p->system))};
    if (!proof) {
        const bool is_double = n->arithmetic == CNS_ARITH_DOUBLE;
        cns_code code = collect(
            p, spec, cns_flow_spec_given(cns_system_program(p->system), cns_system_scales(p->system), n, 0),
            false, false, &fine, err);
        for (int i = 0; i < fine.n && !code; i++)
            add_event(events, &fine.at[i], CNS_PLACES_DECIMALS, -1, is_double ? DOUBLE_PRINTED : given);
        clear_list(&fine);
        return code;
    }
    cns_flow_spec finer = cns_flow_spec_taylor(cns_system_program(p->system), cns_system_scales(p->system),
                                               CNS_ARITH_FAST,
                                               n != NULL ? given + CNS_ANOTHER_LIMB : spec->digits),
                  coarser = n != NULL ? cns_flow_spec_given(cns_system_program(p->system),
                                                            cns_system_scales(p->system), n, 0)
                                      : cns_flow_spec_taylor(cns_system_program(p->system),
                                                             cns_system_scales(p->system), CNS_ARITH_FAST,
                                                             spec->digits - CNS_ANOTHER_LIMB);
    finer.stop = coarser.stop = cns_monitor_stop(p->monitor);
    cns_code code = collect(p, spec, finer, true, false, &fine, err);
    if (!code)
        code = collect(p, spec, coarser, coarser.method == CNS_METHOD_TAYLOR, true, &coarse, err);
    if (!code)
        code = agree(p, spec, &fine, &coarse, events, err);
    clear_list(&fine);
    clear_list(&coarse);
    return code;
}

void cns_events_clear(cns_events *events)
{
    for (int i = 0; i < events->n; i++) {
        free(events->event[i].time);
        for (int k = 0; k < events->n_states; k++)
            free(events->event[i].state[k]);
        free(events->event[i].state);
    }
    free(events->event);
    *events = (cns_events){0};
}
