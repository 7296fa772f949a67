#include "cns/events.h"

#include <math.h>
#include <stdlib.h>

#include "core/memory.h"
#include "method.h"
#include "roots.h"

enum { MOST_ROOTS = 64 }; /* of one condition in one step */

/* Below the noise of a step, times this, a distance counts as none. */
static const double noise_factor_log2 = 6;

struct cns_meetings {
    cns_event_condition *condition;
    int n, n_states;
    double *scales;
    mpfr_prec_t prec;
    int *sign; /* of each extremum's derivative at the end of the last step; 0: not known */
    cns_meeting *meeting;
    int count, room;
    mpfr_t *p, *q, *d; /* polynomials: of the condition, deflated, derivative */
    int size;
    mpfr_t value, unit, end, root, base, rest, x, y, curve, tolerance;
    mpfr_t found[MOST_ROOTS];
};

void cns_event_condition_init(cns_event_condition *s)
{
    s->kind = CNS_CONDITION_VALUE;
    s->state = 0;
    cns_number_init(&s->value);
    cns_number_init(&s->period);
}

void cns_event_condition_clear(cns_event_condition *s)
{
    cns_number_clear(&s->value);
    cns_number_clear(&s->period);
}

void cns_event_condition_set(cns_event_condition *s, const cns_event_condition *from)
{
    s->kind = from->kind;
    s->state = from->state;
    cns_number_set(&s->value, &from->value);
    cns_number_set(&s->period, &from->period);
}

cns_meetings *cns_meetings_new(const cns_event_condition *condition, int n, int n_states,
                               const double *scales, mpfr_prec_t prec, cns_error *err)
{
    for (int i = 0; i < n; i++)
        if (condition[i].state < 0 || condition[i].state >= n_states ||
            (condition[i].kind == CNS_CONDITION_PERIODS && cns_number_sign(&condition[i].period) <= 0)) {
            cns_fail(err, CNS_USAGE, "condition %d: no such state, or a period that is not positive", i);
            return NULL;
        }
    cns_meetings *s = cns_xalloc(1, sizeof *s);
    s->condition = cns_xalloc((size_t)n + 1, sizeof *s->condition);
    s->sign = cns_xalloc((size_t)n + 1, sizeof *s->sign);
    s->scales = cns_xalloc((size_t)n_states + 1, sizeof *s->scales);
    s->n = n;
    s->n_states = n_states;
    s->prec = prec;
    for (int i = 0; i < n; i++) {
        cns_event_condition_init(&s->condition[i]);
        cns_event_condition_set(&s->condition[i], &condition[i]);
    }
    for (int i = 0; i < n_states; i++)
        s->scales[i] = scales[i];
    mpfr_inits2(prec, s->value, s->unit, s->end, s->root, s->base, s->rest, s->x, s->y, s->curve,
                s->tolerance, (mpfr_ptr)0);
    for (int i = 0; i < MOST_ROOTS; i++)
        mpfr_init2(s->found[i], prec);
    return s;
}

static void free_meeting(cns_meeting *m)
{
    mpfr_clear(m->time);
    cns_vector_free(m->state);
}

void cns_meetings_free(cns_meetings *s)
{
    if (s == NULL)
        return;
    for (int i = 0; i < s->n; i++)
        cns_event_condition_clear(&s->condition[i]);
    for (int i = 0; i < s->room; i++)
        free_meeting(&s->meeting[i]);
    cns_vector_free(s->p);
    cns_vector_free(s->q);
    cns_vector_free(s->d);
    mpfr_clears(s->value, s->unit, s->end, s->root, s->base, s->rest, s->x, s->y, s->curve, s->tolerance,
                (mpfr_ptr)0);
    for (int i = 0; i < MOST_ROOTS; i++)
        mpfr_clear(s->found[i]);
    free(s->meeting);
    free(s->condition);
    free(s->scales);
    free(s->sign);
    free(s);
}

void cns_meetings_start(cns_meetings *s)
{
    s->count = 0;
    for (int i = 0; i < s->n; i++)
        s->sign[i] = 0;
}

int cns_meetings_count(const cns_meetings *s)
{
    return s->count;
}

const cns_meeting *cns_meetings_meeting(const cns_meetings *s, int i)
{
    return &s->meeting[i];
}

static cns_code make_room(cns_meetings *s, int coefficients, cns_error *err)
{
    if (coefficients <= s->size)
        return CNS_OK;
    cns_vector_free(s->p);
    cns_vector_free(s->q);
    cns_vector_free(s->d);
    s->size = coefficients;
    s->p = cns_vector_new(coefficients, s->prec);
    s->q = cns_vector_new(coefficients, s->prec);
    s->d = cns_vector_new(coefficients, s->prec);
    return s->p && s->q && s->d ? CNS_OK : cns_out_of_memory(err);
}

static void horner(mpfr_t y, mpfr_t *c, int degree, const mpfr_t u)
{
    mpfr_set(y, c[degree], MPFR_RNDN);
    for (int k = degree - 1; k >= 0; k--) {
        mpfr_mul(y, y, u, MPFR_RNDN);
        mpfr_add(y, y, c[k], MPFR_RNDN);
    }
}

/* d = the derivative of p, as a polynomial in the same variable. */
static void differentiate(mpfr_t *d, mpfr_t *p, int degree)
{
    for (int k = 1; k <= degree; k++)
        mpfr_mul_ui(d[k - 1], p[k], (unsigned long)k, MPFR_RNDN);
}

/* p(u) becomes p(u + r). */
static void shift(mpfr_t *p, int degree, const mpfr_t r, mpfr_t scratch)
{
    for (int i = 0; i < degree; i++)
        for (int k = degree - 1; k >= i; k--) {
            mpfr_mul(scratch, p[k + 1], r, MPFR_RNDN);
            mpfr_add(p[k], p[k], scratch, MPFR_RNDN);
        }
}

/* Half the width of the range of p beyond its first coefficient on (0, end]. */
static double reach(mpfr_t *p, int degree, const mpfr_t end)
{
    const double e = mpfr_get_d(end, MPFR_RNDU);
    double sum = 0;
    for (int k = degree; k >= 1; k--)
        sum = (sum + fabs(mpfr_get_d(p[k], MPFR_RNDA))) * e;
    if (isfinite(sum))
        return sum * (1 + 1e-9);
    /* Beside a singularity steps are so short that coefficients leave the range of double. */
    mpfr_t s, c;
    mpfr_inits2(53, s, c, (mpfr_ptr)0);
    mpfr_set_zero(s, 1);
    for (int k = degree; k >= 1; k--) {
        mpfr_abs(c, p[k], MPFR_RNDU);
        mpfr_add(s, s, c, MPFR_RNDU);
        mpfr_mul(s, s, end, MPFR_RNDU);
    }
    sum = mpfr_get_d(s, MPFR_RNDU);
    mpfr_clears(s, c, (mpfr_ptr)0);
    return sum;
}

/* All sign changes of q in (0, s->end], in order, into s->found; q is used up. A factor of u is taken out
 * first, and each root once it is known: what is left has a sign of its own there. */
static cns_code roots(cns_meetings *s, mpfr_t *q, int degree, int *count, cns_error *err)
{
    bool found = true;
    *count = 0;
    mpfr_set_zero(s->base, 1);
    mpfr_set(s->rest, s->end, MPFR_RNDN);
    while (mpfr_sgn(s->rest) > 0) {
        if (*count == MOST_ROOTS)
            return cns_fail(err, CNS_NUMERIC, "a condition is met more than %d times in one step",
                            MOST_ROOTS);
        while (degree >= 0 && mpfr_zero_p(q[0])) {
            for (int k = 0; k < degree; k++)
                mpfr_swap(q[k], q[k + 1]);
            degree--;
        }
        if (degree < 1)
            return CNS_OK;
        cns_code code = cns_first_root(s->root, &found, q, degree, s->rest, err);
        if (code || !found)
            return code;
        if (*count == MOST_ROOTS)
            return cns_fail(err, CNS_NUMERIC, "a condition is met more than %d times in one step",
                            MOST_ROOTS);
        mpfr_add(s->base, s->base, s->root, MPFR_RNDN);
        mpfr_sub(s->rest, s->rest, s->root, MPFR_RNDN);
        mpfr_set(s->found[(*count)++], s->base, MPFR_RNDN);
        shift(q, degree, s->root, s->x);
        mpfr_set_zero(q[0], 1);
    }
    return CNS_OK;
}

static int first_sign(mpfr_t *p, int degree)
{
    for (int k = 0; k <= degree; k++)
        if (!mpfr_zero_p(p[k]))
            return mpfr_sgn(p[k]);
    return 0;
}

/* Is p, which has a root at u, so flat there that no crossing can be told from a touch? Its slope p' moves it
 * by less than its noise in the whole step; and, as steps may be short beside a singularity, in the longer
 * run the parabola with this slope and curvature leaves zero by no more than its noise, p'^2 / (2 |p''|),
 * before it comes back. p' is left in s->x. */
static bool is_touch(cns_meetings *s, int degree, mpfr_srcptr u)
{
    differentiate(s->d, s->p, degree);
    horner(s->x, s->d, degree - 1, u);
    mpfr_mul(s->y, s->x, s->end, MPFR_RNDN);
    if (mpfr_cmpabs(s->y, s->tolerance) > 0)
        return false;
    if (degree < 2)
        return mpfr_zero_p(s->x);
    differentiate(s->d, s->d, degree - 1);
    horner(s->y, s->d, degree - 2, u);
    mpfr_mul(s->y, s->y, s->tolerance, MPFR_RNDN);
    mpfr_mul_2ui(s->y, s->y, 1, MPFR_RNDN);
    mpfr_sqr(s->curve, s->x, MPFR_RNDN);
    return mpfr_cmpabs(s->curve, s->y) <= 0;
}

/* A meeting at u of the condition, whose condition is p = 0; at_end: exactly at the end of the step. */
static cns_code add(cns_meetings *s, cns_flow *f, int condition, long k, int degree, mpfr_srcptr u,
                    bool at_end, bool touch, cns_error *err)
{
    const cns_event_condition *sec = &s->condition[condition];
    if (s->count == s->room) {
        s->room = 2 * s->room + 4;
        s->meeting = cns_xgrow(s->meeting, (size_t)s->room, sizeof *s->meeting);
        for (int i = s->count; i < s->room; i++) {
            mpfr_init2(s->meeting[i].time, mpfr_get_prec(cns_flow_end(f)));
            s->meeting[i].state = cns_vector_new(s->n_states, s->prec);
            if (s->meeting[i].state == NULL) {
                s->room = i + 1;
                return cns_out_of_memory(err);
            }
        }
    }
    cns_meeting *m = &s->meeting[s->count++];
    m->condition = condition;
    m->k = k;
    const bool flat = is_touch(s, degree, at_end ? s->end : u);
    m->direction = touch || flat ? 0 : mpfr_sgn(s->x);
    mpfr_div(s->x, s->x, s->unit, MPFR_RNDN);
    m->rate = mpfr_get_d(s->x, MPFR_RNDN);
    if (at_end) {
        mpfr_set(m->time, cns_flow_end(f), MPFR_RNDN);
        for (int i = 0; i < s->n_states; i++)
            mpfr_set(m->state[i], cns_flow_state(f)[i], MPFR_RNDN);
    } else {
        mpfr_mul(m->time, u, s->unit, MPFR_RNDN);
        mpfr_add(m->time, m->time, cns_flow_begin(f), MPFR_RNDN);
        for (int i = 0; i < s->n_states; i++) {
            int its_degree;
            mpfr_t *c = cns_flow_polynomial(f, i, &its_degree, s->y);
            horner(s->x, c, its_degree, u);
            mpfr_set(m->state[i], s->x, MPFR_RNDN);
        }
    }
    if (sec->kind != CNS_CONDITION_EXTREMUM && !touch)
        mpfr_set(m->state[sec->state], s->value, MPFR_RNDN);
    return CNS_OK;
}

/* Is p so small at u that nothing can be said of its sign? */
static bool within_noise(cns_meetings *s, int degree, const mpfr_t u)
{
    horner(s->x, s->p, degree, u);
    return mpfr_cmpabs(s->x, s->tolerance) <= 0;
}

/* Is p within noise all the way from u to one of the meetings from..to-1? */
static bool joins_crossing(cns_meetings *s, cns_flow *f, int degree, const mpfr_t u, int from, int to)
{
    for (int i = from; i < to; i++) {
        mpfr_sub(s->y, s->meeting[i].time, cns_flow_begin(f), MPFR_RNDN);
        mpfr_div(s->y, s->y, s->unit, MPFR_RNDN);
        mpfr_add(s->y, s->y, u, MPFR_RNDN);
        mpfr_div_2ui(s->y, s->y, 1, MPFR_RNDN);
        if (within_noise(s, degree, s->y))
            return true;
    }
    return false;
}

/* The meetings with p = 0, p of this degree in s->p. before and after are the signs of p at both ends of the
 * step as the states tell them: neighbouring steps agree on those, so that no meeting at a joint is lost or
 * counted twice, whatever the rounding of p there. */
static cns_code meet(cns_meetings *s, cns_flow *f, int condition, long k, int degree, int before, int after,
                     cns_error *err)
{
    int count;
    for (int i = 0; i <= degree; i++)
        mpfr_set(s->q[i], s->p[i], MPFR_RNDN);
    cns_code code = roots(s, s->q, degree, &count, err);
    if (code)
        return code;
    const int start = before != 0 ? before : first_sign(s->p, degree);
    const int now = count % 2 ? -start : start; /* as p tells it */
    bool at_end = after == 0 && start != 0;
    if (count > 0 && (after == 0 || now != after) && within_noise(s, degree, s->end)) {
        /* The last root is the joint itself, or lies beyond it. */
        mpfr_sub(s->y, s->end, s->found[count - 1], MPFR_RNDN);
        differentiate(s->d, s->p, degree);
        horner(s->x, s->d, degree - 1, s->end);
        mpfr_mul(s->y, s->y, s->x, MPFR_RNDN);
        if (mpfr_cmpabs(s->y, s->tolerance) <= 0)
            count--;
    }
    if (after != 0 && (count % 2 ? -start : start) != after)
        at_end = start != 0;
    for (int i = 0; i < count && !code; i++)
        code = add(s, f, condition, k, degree, s->found[i], false, false, err);
    if (at_end && !code)
        code = add(s, f, condition, k, degree, s->end, true, false, err);
    if (code || degree < 2 || start == 0 || s->condition[condition].kind == CNS_CONDITION_EXTREMUM)
        return code;
    /* Where does it touch? At an extremum of p that is not on the way to a crossing. */
    const int first = s->count - count - at_end, crossings = s->count;
    differentiate(s->q, s->p, degree);
    code = roots(s, s->q, degree - 1, &count, err);
    for (int i = 0; i < count && !code; i++)
        if (within_noise(s, degree, s->found[i]) &&
            !joins_crossing(s, f, degree, s->found[i], first, crossings))
            code = add(s, f, condition, k, degree, s->found[i], false, true, err);
    return code;
}

/* p = 0 for one value of the state; s->p has the state's polynomial, its first coefficient is replaced. */
static cns_code meet_value(cns_meetings *s, cns_flow *f, int condition, long k, int degree, double span,
                           cns_error *err)
{
    const int state = s->condition[condition].state;
    mpfr_sub(s->p[0], cns_flow_begin_state(f)[state], s->value, MPFR_RNDN);
    if (fabs(mpfr_get_d(s->p[0], MPFR_RNDZ)) > span + 1e-280)
        return CNS_OK;
    const int before = mpfr_sgn(s->p[0]), after = mpfr_cmp(cns_flow_state(f)[state], s->value);
    return meet(s, f, condition, k, degree, before, after > 0 ? 1 : after < 0 ? -1 : 0, err);
}

static cns_code meet_periods(cns_meetings *s, cns_flow *f, int condition, int degree, double span,
                             cns_error *err)
{
    const cns_event_condition *sec = &s->condition[condition];
    const double period = cns_number_get_d(&sec->period), value = cns_number_get_d(&sec->value);
    const double x = mpfr_get_d(cns_flow_begin_state(f)[sec->state], MPFR_RNDN);
    const double low = ceil((x - span - value) / period - 1e-6),
                 high = floor((x + span - value) / period + 1e-6);
    if (!(fabs(low) < 1e15 && fabs(high) < 1e15 && high - low < 1e4))
        return cns_fail(err, CNS_NUMERIC, "a state passes too many values of its condition in one step");
    for (long k = (long)low; k <= (long)high; k++) {
        cns_number_get_mpfr(s->x, &sec->period);
        mpfr_mul_si(s->x, s->x, k, MPFR_RNDN);
        cns_number_get_mpfr(s->value, &sec->value);
        mpfr_add(s->value, s->value, s->x, MPFR_RNDN);
        cns_code code = meet_value(s, f, condition, k, degree, span, err);
        if (code)
            return code;
    }
    return CNS_OK;
}

static cns_code meet_extremum(cns_meetings *s, cns_flow *f, int condition, int degree, cns_error *err)
{
    int *sign = &s->sign[condition];
    for (int k = 1; k <= degree; k++)
        mpfr_mul_ui(s->p[k - 1], s->p[k], (unsigned long)k, MPFR_RNDN);
    degree--;
    const int own = first_sign(s->p, degree);
    if (degree < 1 || own == 0)
        return CNS_OK;
    mpfr_mul_si(s->tolerance, s->tolerance, degree, MPFR_RNDU); /* of the derivative by u */
    mpfr_div(s->tolerance, s->tolerance, s->end, MPFR_RNDU);
    /* The derivative at a joint is noise if this step and the last differ on its sign. */
    const int before = *sign;
    horner(s->x, s->p, degree, s->end);
    const int after = mpfr_sgn(s->x);
    cns_code code = CNS_OK;
    if (before != 0 && before != own) {
        mpfr_set_zero(s->root, 1);
        code = add(s, f, condition, 0, degree, s->root, false, false, err);
    }
    if (!code)
        code = meet(s, f, condition, 0, degree, own, after, err);
    *sign = after;
    return code;
}

static int by_time(const void *a, const void *b)
{
    const cns_meeting *p = a, *q = b;
    const int order = mpfr_cmp(p->time, q->time);
    return order != 0 ? order : (p->condition > q->condition) - (p->condition < q->condition);
}

cns_code cns_meetings_follow(cns_meetings *s, cns_flow *f, cns_error *err)
{
    cns_code code = CNS_OK;
    s->count = 0;
    for (int i = 0; i < s->n && !code; i++) {
        const cns_event_condition *sec = &s->condition[i];
        int degree;
        mpfr_t *c = cns_flow_polynomial(f, sec->state, &degree, s->unit);
        code = make_room(s, degree + 1, err);
        if (code || degree < 1)
            break;
        mpfr_sub(s->end, cns_flow_end(f), cns_flow_begin(f), MPFR_RNDN);
        mpfr_div(s->end, s->end, s->unit, MPFR_RNDN);
        for (int k = 0; k <= degree; k++)
            mpfr_set(s->p[k], c[k], MPFR_RNDN);
        mpfr_set_d(s->tolerance, cns_flow_noise_log2(f) + noise_factor_log2, MPFR_RNDU);
        mpfr_exp2(s->tolerance, s->tolerance, MPFR_RNDU);
        mpfr_mul_d(s->tolerance, s->tolerance, s->scales[sec->state], MPFR_RNDU);
        const double span = reach(s->p, degree, s->end) + mpfr_get_d(s->tolerance, MPFR_RNDU);
        if (sec->kind == CNS_CONDITION_EXTREMUM) {
            code = meet_extremum(s, f, i, degree, err);
        } else if (sec->kind == CNS_CONDITION_PERIODS) {
            code = meet_periods(s, f, i, degree, span, err);
        } else {
            cns_number_get_mpfr(s->value, &sec->value);
            code = meet_value(s, f, i, 0, degree, span, err);
        }
    }
    if (s->count > 1)
        qsort(s->meeting, (size_t)s->count, sizeof *s->meeting, by_time);
    return code;
}
