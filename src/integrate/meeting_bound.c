#include "meeting_bound.h"

#include <math.h>

#include "taylor/ball.h"

enum { BOX_BITS = 64, MORE_BITS = 64 };

void cns_meeting_bound_init(cns_meeting_bound *b, int n_states)
{
    b->proven = false;
    mag_init(b->time);
    b->state = _mag_vec_init(n_states + 1);
}

void cns_meeting_bound_clear(cns_meeting_bound *b, int n_states)
{
    if (b->state == NULL)
        return;
    mag_clear(b->time);
    _mag_vec_clear(b->state, n_states + 1);
    b->state = NULL;
}

/* Balls about the states of m. */
static void set_box(arb_ptr x, const cns_meeting *m, int n, mag_srcptr radius, slong prec)
{
    for (int i = 0; i < n; i++) {
        arb_set_interval_mpfr(x + i, m->state[i], m->state[i], prec);
        arb_add_error_mag(x + i, radius + i);
    }
}

/* The condition's function g over a box, whose zero the meeting is; and its derivative along the solution, f
 * being the states' derivatives over the box. x: 2 n balls, the first n being the box. */
static bool condition_over(arb_t g, const cns_program *p, const cns_event_condition *c, const cns_meeting *m,
                           arb_srcptr x, arb_ptr f, slong prec)
{
    cns_error ignored;
    if (c->kind == CNS_CONDITION_EXTREMUM) {
        if (cns_ball_derivatives(p, x, f, prec, &ignored))
            return false;
        arb_set(g, f + c->state);
        return true;
    }
    arb_t v;
    arb_init(v);
    cns_ball_number(g, &c->value, prec);
    if (c->kind == CNS_CONDITION_PERIODS) {
        cns_ball_number(v, &c->period, prec);
        arb_addmul_si(g, v, m->k, prec);
    }
    arb_sub(g, x + c->state, g, prec);
    arb_clear(v);
    return true;
}

static bool derivative_over(arb_t rate, const cns_program *tangent, const cns_event_condition *c, int n,
                            arb_ptr x, arb_srcptr f, arb_ptr scratch)
{
    cns_error ignored;
    if (c->kind != CNS_CONDITION_EXTREMUM) {
        arb_set(rate, f + c->state);
        return true;
    }
    for (int i = 0; i < n; i++) /* the direction of the solution itself */
        arb_set(x + n + i, f + i);
    if (cns_ball_derivatives(tangent, x, scratch, BOX_BITS, &ignored))
        return false;
    arb_set(rate, scratch + n + c->state);
    return true;
}

/* Within a time d of the meeting the solution stays in a box of radii R_i, if error_i + d F_i <= R_i where
 * F_i bounds |x_i'| over the box; and there g' has one sign and at least the size r. As |g| <= e at the time
 * of the meeting, g has a zero within e / r, which must not be more than d, and no other within d. */
void cns_meeting_prove(cns_meeting_bound *b, const cns_program *p, const cns_program *tangent,
                       const cns_event_condition *c, const cns_meeting *m, mag_srcptr error, slong prec)
{
    const int n = cns_program_states(p);
    arb_ptr x = _arb_vec_init(2 * n), f = _arb_vec_init(2 * n), scratch = _arb_vec_init(2 * n);
    mag_ptr radius = _mag_vec_init(n + 1), first = _mag_vec_init(n + 1);
    arb_t g, rate;
    mag_t e, d, y, most;
    cns_error ignored;
    arb_init(g);
    arb_init(rate);
    mag_init(e);
    mag_init(d);
    mag_init(y);
    mag_init(most);
    set_box(x, m, n, error, prec + MORE_BITS);
    b->proven = m->direction != 0 && condition_over(g, p, c, m, x, f, prec + MORE_BITS) &&
                !cns_ball_derivatives(p, x, f, BOX_BITS, &ignored);
    if (b->proven) {
        arb_get_mag(e, g);
        mag_set_d(y, fabs(m->rate) / 4);
        mag_div(d, e, y);
        for (int i = 0; i < n; i++) {
            arb_get_mag(first + i, f + i);
            mag_max(most, most, first + i);
        }
        mag_mul_2exp_si(most, most, -8);
        for (int i = 0; i < n; i++) {
            mag_add(y, first + i, most);
            mag_mul(y, y, d);
            mag_mul_2exp_si(y, y, 1);
            mag_add(radius + i, error + i, y);
        }
        set_box(x, m, n, radius, BOX_BITS);
        b->proven = !cns_ball_derivatives(p, x, f, BOX_BITS, &ignored) &&
                    derivative_over(rate, tangent, c, n, x, f, scratch) &&
                    (m->direction > 0 ? arb_is_positive(rate) : arb_is_negative(rate));
    }
    if (b->proven) {
        arb_get_mag_lower(y, rate);
        mag_div(b->time, e, y);
        b->proven = mag_is_finite(b->time) && mag_cmp(b->time, d) <= 0;
    }
    for (int i = 0; i < n && b->proven; i++) {
        arb_get_mag(y, f + i);
        mag_mul(most, y, d);
        mag_add(most, most, error + i);
        b->proven = mag_cmp(most, radius + i) <= 0;
        mag_mul(b->state + i, y, b->time);
        mag_add(b->state + i, b->state + i, error + i);
    }
    _arb_vec_clear(x, 2 * n);
    _arb_vec_clear(f, 2 * n);
    _arb_vec_clear(scratch, 2 * n);
    _mag_vec_clear(radius, n + 1);
    _mag_vec_clear(first, n + 1);
    arb_clear(g);
    arb_clear(rate);
    mag_clear(e);
    mag_clear(d);
    mag_clear(y);
    mag_clear(most);
}
