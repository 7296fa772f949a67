#include "events.h"

#include <math.h>
#include <stdlib.h>

#include "core/memory.h"
#include "num/decimal_text.h"
#include "num/logs.h"
#include "num/vector.h"
#include "proof.h"

enum { ERROR_BITS = 64 };

static void set_mag(mpfr_t y, const mag_t x)
{
    arf_t f;
    arf_init(f);
    arf_set_mag(f, x);
    arf_get_mpfr(y, f, MPFR_RNDU);
    arf_clear(f);
}

static void make_room(cns_found_list *l, int more)
{
    if (l->first > 0 && l->first >= l->n / 2) {
        for (int i = l->first; i < l->n; i++)
            l->at[i - l->first] = l->at[i];
        l->n -= l->first;
        l->first = 0;
    }
    if (l->n + more > l->room) {
        l->room = 2 * l->n + more + 16;
        l->at = cns_xgrow(l->at, (size_t)l->room, sizeof *l->at);
    }
}

cns_code cns_found_add(void *list, const cns_meeting *m, const cns_meeting_bound *bound, double noise_log2,
                       cns_error *err)
{
    cns_found_list *l = list;
    make_room(l, 1);
    cns_found *f = &l->at[l->n];
    *f = (cns_found){.m = *m, .noise_log2 = noise_log2};
    f->m.state = cns_vector_new(l->n_states, mpfr_get_prec(m->state[0]));
    if (f->m.state == NULL)
        return cns_out_of_memory(err);
    mpfr_init2(f->m.time, mpfr_get_prec(m->time));
    mpfr_set(f->m.time, m->time, MPFR_RNDN);
    for (int i = 0; i < l->n_states; i++)
        mpfr_set(f->m.state[i], m->state[i], MPFR_RNDN);
    l->n++;
    if (bound == NULL)
        return CNS_OK;
    f->enclosed = bound->proven;
    mpfr_init2(f->time_error, ERROR_BITS);
    set_mag(f->time_error, bound->time);
    f->state_error = cns_vector_xnew(l->n_states, ERROR_BITS);
    for (int i = 0; i < l->n_states; i++)
        set_mag(f->state_error[i], bound->state + i);
    return CNS_OK;
}

void cns_found_move(cns_found_list *to, cns_found_list *from)
{
    to->n_states = from->n_states;
    make_room(to, from->n - from->first);
    for (int i = from->first; i < from->n; i++)
        to->at[to->n++] = from->at[i];
    from->first = from->n = 0;
}

void cns_found_drop(cns_found_list *l, int i)
{
    mpfr_clear(l->at[i].m.time);
    cns_vector_free(l->at[i].m.state);
    if (l->at[i].state_error != NULL) {
        mpfr_clear(l->at[i].time_error);
        cns_vector_free(l->at[i].state_error);
    }
    for (; i > l->first; i--)
        l->at[i] = l->at[i - 1];
    l->first++;
}

void cns_found_clear(cns_found_list *l)
{
    while (l->first < l->n)
        cns_found_drop(l, l->first);
    free(l->at);
    *l = (cns_found_list){.n_states = l->n_states};
}

double cns_event_loss_log2(const cns_problem *p, const cns_meeting *m)
{
    double largest = 1;
    for (int i = 0; i < cns_program_states(cns_system_program(p->system)); i++)
        largest =
            fmax(largest, fmax(cns_system_scales(p->system)[i], fabs(mpfr_get_d(m->state[i], MPFR_RNDN))));
    const double delay = m->direction == 0 ? 0 : 1 / fabs(m->rate);
    return cns_log2_2exp(largest, 0) + (isfinite(delay) ? cns_log2_2exp(1 + delay, 0) : HUGE_VAL);
}

int cns_event_partner(const cns_found_list *fine, const cns_found_list *coarse)
{
    for (int i = coarse->first; i < coarse->n; i++)
        if (coarse->at[i].m.condition == fine->at[fine->first].m.condition)
            return i;
    return -1;
}

/* time = that of the meeting, initialised here, and rounded once where a start is added. */
static void time_of(const cns_problem *p, const cns_meeting *m, mpfr_t time)
{
    mpfr_init2(time, mpfr_get_prec(m->time) + 64);
    mpfr_set(time, m->time, MPFR_RNDN);
    if (cns_system_is_backwards(p->system))
        mpfr_neg(time, time, MPFR_RNDN);
    mpfr_add_q(time, time, cns_system_start(p->system)->ratio, MPFR_RNDN);
}

/* That of the change with time: against time it is met from the other side. The derivative changes its sign
 * both ways alike. */
static int direction_of(const cns_problem *p, const cns_meeting *m)
{
    const bool turned =
        cns_system_is_backwards(p->system) && p->conditions[m->condition].kind != CNS_CONDITION_EXTREMUM;
    return turned ? -m->direction : m->direction;
}

long cns_event_places(const cns_problem *p, const cns_found *fine, const cns_found *coarse,
                      const bool *constant, cns_places places, long most, double *error_log10,
                      mpfr_t time_error)
{
    const cns_meeting *a = &fine->m, *b = coarse != NULL ? &coarse->m : a;
    const cns_event_condition *c = &p->conditions[a->condition];
    const int n = cns_program_states(cns_system_program(p->system));
    /* The state of the condition has its value exactly, except at a touch. */
    const int exact = c->kind == CNS_CONDITION_EXTREMUM || a->direction == 0 ? -1 : c->state;
    const double loss = cns_event_loss_log2(p, a);
    mpfr_t error;
    *error_log10 = HUGE_VAL;
    if (coarse != NULL ? a->k != b->k || a->direction != b->direction : !fine->enclosed)
        return -1;
    mpfr_init2(error, ERROR_BITS);
    if (coarse != NULL) {
        const double own = coarse->noise_log2 + loss, noise = a->direction == 0 ? own / 2 : own;
        mpfr_set_zero(time_error, 1);
        cns_proof_error(time_error, a->time, b->time, noise);
        mpfr_set(error, time_error, MPFR_RNDU); /* what moves in time moves the states, too */
        for (int i = 0; i < n; i++)
            cns_proof_error(error, a->state[i], b->state[i], noise);
    } else {
        mpfr_set(time_error, fine->time_error, MPFR_RNDU);
        mpfr_set(error, time_error, MPFR_RNDU);
        for (int i = 0; i < n; i++)
            mpfr_max(error, error, fine->state_error[i], MPFR_RNDU);
    }
    cns_bounded *value = cns_xalloc((size_t)n + 1, sizeof *value);
    int count = 0;
    mpfr_t time, rounded; /* of what is printed: a unit of its last bit more, where a start is added */
    time_of(p, a, time);
    mpfr_init2(rounded, ERROR_BITS);
    mpfr_set_ui_2exp(rounded, cns_number_sign(cns_system_start(p->system)) != 0 && mpfr_regular_p(time),
                     (mpfr_regular_p(time) ? mpfr_get_exp(time) : 0) - mpfr_get_prec(time), MPFR_RNDU);
    mpfr_add(rounded, rounded, time_error, MPFR_RNDU);
    value[count++] = (cns_bounded){time, rounded};
    for (int i = 0; i < n; i++) /* zero in both runs is an invariant line, and exact */
        if (i != exact && !constant[i] && !(mpfr_zero_p(a->state[i]) && mpfr_zero_p(b->state[i])))
            value[count++] = (cns_bounded){a->state[i], coarse != NULL ? error : fine->state_error[i]};
    const long found = cns_proof_places(value, count, places, most);
    *error_log10 = cns_log2_mpfr(error) * CNS_LOG10_2;
    free(value);
    mpfr_clears(error, time, rounded, (mpfr_ptr)0);
    return found;
}

static char *text_of(mpfr_srcptr x, cns_places places, long count, long digits)
{
    return count < 0 ? cns_text_digits(x, digits) : cns_text_mpfr(x, places, count);
}

cns_code cns_event_tell(const cns_problem *p, const cns_meeting *m, const bool *constant, cns_places places,
                        long count, long digits, cns_error *err)
{
    const int n = cns_program_states(cns_system_program(p->system));
    mpfr_t time;
    time_of(p, m, time);
    cns_event e = {.condition = m->condition,
                   .k = m->k,
                   .direction = direction_of(p, m),
                   .time = text_of(time, places, count, digits),
                   .state = cns_xalloc((size_t)n + 1, sizeof *e.state),
                   .decimals = count < 0 ? -1 : count};
    for (int i = 0; i < n; i++)
        e.state[i] = count >= 0 && constant[i]
                         ? cns_text_number(&cns_system_initial(p->system)[i], places, count)
                         : text_of(m->state[i], places, count, digits);
    cns_code code = p->sink && p->sink->event ? p->sink->event(p->sink->context, &e, err) : CNS_OK;
    for (int i = 0; i < n; i++)
        free(e.state[i]);
    mpfr_clear(time);
    free(e.state);
    free(e.time);
    return code;
}
