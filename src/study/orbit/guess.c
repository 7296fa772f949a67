#include <math.h>
#include <stdlib.h>

#include "core/memory.h"
#include "core/monitor.h"
#include "integrate/trajectory.h"
#include "num/vector.h"
#include "orbit.h"
#include "study/modes/cycle.h"
#include "study/modes/returns.h"

enum {
    DIGITS = CNS_ORBIT_FIRST_DIGITS,
    PLACES = 16,        /* along an orbit, at which it may cross a section */
    SAMPLES = 40,       /* of the time before and after that of the guess */
    RECURRENCES = 1000, /* returns that are looked through for one that repeats, after */
    TRANSIENT = 200,    /* so many */
    CANDIDATES = 12,    /* the best of them, from which Newton's method starts */
    MOST_AUTO = 8,      /* returns of a cycle that is looked for unasked */
    MOST_STEPS = 100000,
    LIMIT = 10000 /* steps that the motion may take to settle: a cycle that it is only near to will do */
};

static const double poor = 5;      /* so many times better is another section than a poor one */
static const double window = 0.15; /* of the time of a guess, before and after it */

/* The state whose rate of change at u, in scales, is the largest: there the orbit crosses its section best.
 * *held_rate: that of the state held so far, if there is one. */
static cns_code steepest(const cns_loop *l, const mpfr_t *u, int *state, double *rate, double *held_rate,
                         cns_error *err)
{
    const cns_shooting_spec spec = {.system = l->system, .digits = DIGITS, .tangents = true, .stop = l->stop};
    cns_shooting s;
    mpfr_t soon;
    mpfr_init2(soon, 64);
    mpfr_mul_2si(soon, u[l->d], -20, MPFR_RNDN);
    *rate = *held_rate = -1;
    cns_code code = cns_shooting_open(&s, &spec, err);
    if (!code)
        code = cns_shooting_run(&s, u, soon, err);
    for (int k = 0; k < l->d && !code; k++) {
        const double r = fabs(mpfr_get_d(s.f[k], MPFR_RNDN)) / cns_system_scales(l->system)[l->index[k]];
        if (k == l->held)
            *held_rate = r;
        if (r > *rate) {
            *rate = r;
            *state = k;
        }
    }
    cns_shooting_close(&s);
    mpfr_clear(soon);
    return code;
}

cns_code cns_orbit_turn(cns_loop *l, mpfr_t *u, bool *turned, cns_error *err)
{
    const cns_shooting_spec spec = {.system = l->system, .digits = DIGITS, .stop = l->stop};
    const mpfr_prec_t prec = cns_digits_to_bits(DIGITS);
    mpfr_t *z = cns_vector_xnew(l->d + 2, prec), *best = cns_vector_xnew(l->d + 2, prec), part, value;
    double most, so_far, rate, ignored;
    int held, state;
    cns_shooting s;
    mpfr_init2(part, prec);
    mpfr_init2(value, 24); /* it need not be exact, but it must be the same at every precision */
    mpfr_div_ui(part, u[l->d], PLACES, MPFR_RNDN);
    for (int k = 0; k < l->d + 2; k++)
        mpfr_set(z[k], u[k], MPFR_RNDN);
    cns_code code = steepest(l, u, &held, &most, &so_far, err);
    most = poor * so_far;
    *turned = false;
    if (!code)
        code = cns_shooting_open(&s, &spec, err);
    else
        s = (cns_shooting){0};
    for (int i = 0; i < PLACES && !code; i++) {
        code = cns_shooting_run(&s, (const mpfr_t *)z, part, err);
        for (int k = 0; k < l->d && !code; k++)
            mpfr_set(z[k], s.x[k], MPFR_RNDN);
        if (!code)
            code = steepest(l, (const mpfr_t *)z, &state, &rate, &ignored, err);
        if (code || rate <= most)
            continue;
        *turned = true;
        most = rate;
        held = state;
        for (int k = 0; k < l->d + 2; k++)
            mpfr_set(best[k], z[k], MPFR_RNDN);
    }
    for (int k = 0; k < l->d && !code && *turned; k++)
        mpfr_set(u[k], best[k], MPFR_RNDN);
    if (!code && *turned) {
        l->held = held;
        mpfr_set(value, u[held], MPFR_RNDN);
        cns_number_from_mpfr(&l->held_value, value);
    }
    cns_shooting_close(&s);
    cns_vector_free(z);
    cns_vector_free(best);
    mpfr_clears(part, value, (mpfr_ptr)0);
    return code;
}

/* The time near that of the guess at which the motion comes nearest to an image of its beginning: along the
 * orbit it changes so fast that a guess of three digits may be far away there. */
static cns_code best_time(const cns_loop *l, mpfr_t *u, cns_error *err)
{
    const double guess = mpfr_get_d(u[l->d], MPFR_RNDN), unit = guess * window / SAMPLES;
    const cns_shooting_spec spec = {.system = l->system, .digits = DIGITS, .stop = l->stop};
    cns_shooting s;
    double best = HUGE_VAL, least = guess;
    mpfr_t *z = cns_vector_xnew(l->d, cns_digits_to_bits(DIGITS));
    mpfr_t time;
    mpfr_init2(time, 53);
    cns_code code = cns_shooting_open(&s, &spec, err);
    for (int k = 0; k < l->d; k++)
        mpfr_set(z[k], u[k], MPFR_RNDN);
    for (int k = -SAMPLES; k <= SAMPLES && !code; k++) {
        int image;
        long turns;
        mpfr_set_d(time, k == -SAMPLES ? guess - SAMPLES * unit : unit, MPFR_RNDN);
        code = cns_shooting_run(&s, (const mpfr_t *)z, time, err); /* on from where the last one ended */
        for (int i = 0; i < l->d && !code; i++)
            mpfr_set(z[i], s.x[i], MPFR_RNDN);
        const double gap = code ? HUGE_VAL : cns_loop_match(l, (const mpfr_t *)u, s.x, &image, &turns);
        if (gap < best) {
            best = gap;
            least = guess + k * unit;
        }
    }
    mpfr_set_d(u[l->d], least, MPFR_RNDN);
    cns_shooting_close(&s);
    cns_vector_free(z);
    mpfr_clear(time);
    return code;
}

static cns_code from_case(cns_loop *l, const cns_orbit_spec *spec, mpfr_t *u, cns_error *err)
{
    const cns_number *initial = cns_system_initial(l->system);
    cns_code code = CNS_OK;
    for (int k = 0; k < l->d; k++)
        cns_number_get_mpfr(u[k], &initial[l->index[k]]);
    cns_number_get_mpfr(u[l->d], &spec->period);
    l->held = -1;
    for (int k = 0; k < l->d; k++)
        if (l->index[k] == spec->section)
            l->held = k;
    if (l->held < 0 && spec->section >= 0)
        return cns_fail(err, CNS_USAGE, "nothing feeds back on state '%s': it cannot be held",
                        cns_system_model(l->system)->states[spec->section].name);
    double rate, ignored;
    if (l->held < 0)
        code = steepest(l, (const mpfr_t *)u, &l->held, &rate, &ignored, err);
    if (!code)
        cns_number_set(&l->held_value, &initial[l->index[l->held]]);
    return code ? code : best_time(l, u, err);
}

/* Takes a cycle of the return map as the guess. */
static void take(cns_loop *l, const cns_return_map *S, const cns_cycle *c, mpfr_t *u)
{
    for (int k = 0; k < l->d; k++) {
        mpfr_set(u[k], c->z[k], MPFR_RNDN);
        if (l->index[k] == S->section.state)
            l->held = k;
    }
    cns_number_set(&l->held_value, &S->section.value);
    cns_number_get_mpfr(u[l->held], &l->held_value);
    mpfr_set(u[l->d], c->time, MPFR_RNDN);
}

static cns_code newton(cns_loop *l, const cns_return_map *S, const mpfr_t *z, int returns, int direction,
                       mpfr_t *u, cns_error *err)
{
    cns_cycle c;
    cns_code code = cns_cycle_find(S, z, returns, direction, DIGITS, &c, err);
    if (!code)
        take(l, S, &c, u);
    cns_cycle_clear(&c);
    return code;
}

/* The returns of a motion in double. */
typedef struct history {
    int n, d;
    double *z; /* reduced states */
    int *direction;
} history;

static cns_code follow(const cns_return_map *S, history *h, cns_error *err)
{
    const cns_trajectory_spec spec = {.flow = cns_return_map_flow(S, S->program, S->scales, 0),
                                      .initial = cns_system_initial(S->system),
                                      .no_growth = true,
                                      .conditions = &S->section,
                                      .n_conditions = 1};
    cns_trajectory *t = cns_trajectory_new(&spec, err);
    cns_code code = t != NULL ? CNS_OK : err->code;
    long seen = 0;
    *h = (history){.d = S->d,
                   .z = cns_xalloc((size_t)(RECURRENCES * S->d), sizeof *h->z),
                   .direction = cns_xalloc(RECURRENCES, sizeof *h->direction)};
    for (long step = 0; !code && step < MOST_STEPS && h->n < RECURRENCES; step++) {
        code = cns_trajectory_step(t, err);
        const cns_meetings *meetings = cns_trajectory_meetings(t);
        for (int k = 0; !code && k < cns_meetings_count(meetings) && h->n < RECURRENCES; k++) {
            const cns_meeting *m = cns_meetings_meeting(meetings, k);
            if (!cns_return_map_counts(S, m, 0) || seen++ < TRANSIENT)
                continue;
            for (int i = 0; i < S->d; i++)
                h->z[h->n * S->d + i] = S->index[i] == S->section.state
                                            ? 0
                                            : cns_return_map_sign(S, i, m->k, m->direction) *
                                                  mpfr_get_d(m->state[S->index[i]], MPFR_RNDN);
            h->direction[h->n++] = m->direction;
        }
    }
    cns_trajectory_free(t);
    return code;
}

static double gap(const cns_return_map *S, const history *h, int a, int b)
{
    double largest = 0;
    for (int i = 0; i < h->d; i++)
        largest = fmax(largest, fabs(h->z[a * h->d + i] - h->z[b * h->d + i]) / S->scales[S->index[i]]);
    return largest;
}

/* A cycle of so many returns that the motion comes near to: Newton's method from where it best repeats itself
 * after so many. */
static cns_code near_cycle(cns_loop *l, const cns_return_map *S, const history *h, int returns, mpfr_t *u,
                           bool *found, cns_error *err)
{
    cns_code code = CNS_OK;
    mpfr_t *z = cns_vector_xnew(S->d, cns_modes_bits(DIGITS));
    double last = -1;
    for (int try = 0; try < CANDIDATES && !code && !*found; try++) {
        int best = -1;
        double least = HUGE_VAL;
        for (int j = 0; j + returns < h->n; j++) {
            const double g = gap(S, h, j, j + returns);
            if (g > last && g < least) {
                least = g;
                best = j;
            }
        }
        if (best < 0)
            break;
        last = least;
        for (int i = 0; i < S->d; i++)
            mpfr_set_d(z[i], h->z[best * S->d + i], MPFR_RNDN);
        const bool mirrors = S->motion != NULL && S->motion->mirror_sign != NULL;
        cns_error ignored;
        const cns_code tried =
            newton(l, S, (const mpfr_t *)z, returns, mirrors ? 1 : h->direction[best], u, &ignored);
        *found = !tried;
        if (tried && tried != CNS_UNREACHED && tried != CNS_NUMERIC)
            code = cns_fail(err, tried, "%s", ignored.text);
    }
    cns_vector_free(z);
    return code;
}

/* The same; returns 0: of as few as there are. */
static cns_code near_some_cycle(cns_loop *l, const cns_return_map *S, int returns, mpfr_t *u, cns_error *err)
{
    history h;
    bool found = false;
    const int most = returns > 0 ? returns : MOST_AUTO;
    cns_code code = follow(S, &h, err);
    for (int n = returns > 0 ? returns : 1; n <= most && !code && !found; n++)
        code = near_cycle(l, S, &h, n, u, &found, err);
    free(h.z);
    free(h.direction);
    if (code || found)
        return code;
    return cns_fail(err, CNS_NUMERIC,
                    "no cycle of %s%d returns was found near the motion; a guess with its period may help",
                    returns > 0 ? "" : "up to ", most);
}

static cns_code from_motion(cns_loop *l, const cns_orbit_spec *spec, mpfr_t *u, const cns_monitor *monitor,
                            cns_error *err)
{
    cns_return_map S;
    cns_late late = {0};
    cns_monitor_tell(monitor, 0, "following the motion");
    cns_code code = cns_return_map_open(&S, l->system, -1, 0, l->stop, err);
    S.limit = LIMIT;
    if (!code)
        code = cns_late_find(&S, 0, 0, &late, err);
    if (code) {
    } else if (late.kind == CNS_LATE_STEADY) {
        code = cns_fail(err, CNS_NUMERIC,
                        "the motion comes to rest; another orbit needs a guess with its period");
    } else if (late.kind == CNS_LATE_CYCLE && (spec->returns == 0 || spec->returns == late.returns)) {
        code = newton(l, &S, (const mpfr_t *)late.z, late.returns, late.direction, u, err);
    } else {
        code = near_some_cycle(l, &S, (int)spec->returns, u, err);
    }
    cns_late_clear(&late);
    cns_return_map_close(&S);
    return code;
}

cns_code cns_orbit_guess(cns_loop *l, const cns_orbit_spec *spec, mpfr_t *u, const cns_monitor *monitor,
                         cns_error *err)
{
    if (cns_number_sign(&spec->period) > 0)
        return from_case(l, spec, u, err);
    if (spec->section >= 0)
        return cns_fail(err, CNS_USAGE,
                        "the section of the late motion is chosen; one of your own goes with "
                        "a guess, and its period");
    return from_motion(l, spec, u, monitor, err);
}
