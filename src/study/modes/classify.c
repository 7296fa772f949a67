#include "cns/study/classify.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cns/study/lyapunov.h"
#include "core/memory.h"
#include "core/monitor.h"
#include "cycle.h"
#include "integrate/trajectory.h"
#include "num/decimal_text.h"
#include "num/logs.h"
#include "num/vector.h"
#include "returns.h"
#include "solve/proof.h"

enum {
    SECOND_DIGITS = 30, /* of the run that confirms one in double */
    PRINTED = 10,       /* decimals, at most */
    JOINT_LOG2 = -30,   /* of a period: so near to its end is at its end */
    ROUNDS = 12,
    LEAST_GROWTH = 20,     /* ln of it, for chaos */
    CYCLE_LEAST_BITS = 60, /* of a cycle's state after one repetition */
    LOOKS = 3,             /* at what may be chaos, each one LONGER times as long as the one before */
    LONGER = 4,
    PATIENCE = 8 /* times the usual number of steps, for a motion that neither settles nor is chaotic */
};

static const double sure = 6;        /* standard errors by which an exponent is positive */
static const double near_log2 = -6;  /* nearer to a cycle than this, returns may approach it */
static const double same_log2 = -18; /* reduced returns of two runs this near belong to the same cycle */

const char *cns_mode_name(cns_mode mode)
{
    static const char *const names[] = {"undecided", "steady", "flutter", "tumble", "periodic", "chaotic"};
    return names[mode];
}

void cns_motion_clear(cns_motion *m)
{
    free(m->period);
    free(m->amplitude);
    free(m->descent);
    for (int i = 0; m->drift != NULL && i < m->n_states; i++)
        free(m->drift[i]);
    free(m->drift);
    for (int i = 0; i < m->extrema; i++)
        free(m->maximum[i]);
    free(m->maximum);
    memset(m, 0, sizeof *m);
}

static long gcd(long a, long b)
{
    return b == 0 ? a : gcd(b, a % b);
}

/* How often the cycle repeats, up to symmetry, until it does so up to whole revolutions. */
static long repetitions(const cns_return_map *S, const cns_cycle *c)
{
    if (c->mirrored)
        return 2; /* mirror images turn back what was turned */
    return S->motion == NULL ? 1 : S->motion->turns / gcd(labs(c->turns), S->motion->turns);
}

/* One period, measured in one arithmetic. */
typedef struct measures {
    int n; /* period, amplitude, drifts of all states, maxima */
    mpfr_t *value;
    mpfr_prec_t prec;
    int maxima, drift; /* where the drifts begin, how many maxima follow them */
    long winding;
    int image;                    /* of the model, through which the cycle passes; 0: through none */
    double image_gap, image_time; /* log2 of the distance in scales, and when */
} measures;

static void clear_measures(measures *m)
{
    for (int i = 0; i < m->n; i++)
        mpfr_clear(m->value[i]);
    free(m->value);
}

/* Room for so many values, those that are new being 0. */
static void make_room(measures *m, int n)
{
    if (n <= m->n)
        return;
    m->value = cns_xgrow(m->value, (size_t)n, sizeof *m->value);
    for (; m->n < n; m->n++) {
        mpfr_init2(m->value[m->n], m->prec);
        mpfr_set_zero(m->value[m->n], 1);
    }
}

static bool is_dynamic(const cns_return_map *S, int state)
{
    return cns_program_is_dynamic(S->program, state);
}

/* The state with which a period begins: the cycle's, as the trajectory itself has it, at the origin. */
static void set_start(const cns_return_map *S, const cns_late *late, const cns_cycle *c, long *turns,
                      cns_number *start)
{
    cns_error err;
    *turns = 0;
    for (int i = 0; i < S->n; i++)
        cns_number_parse(&start[i], "0", &err);
    if (S->motion != NULL) {
        char text[64];
        *turns = (late->turns % S->motion->turns + S->motion->turns) % S->motion->turns;
        snprintf(text, sizeof text, "%ld*2*pi/%d", *turns, S->motion->turns);
        if (*turns != 0)
            cns_number_parse(&start[S->section.state], text, &err);
    } else {
        cns_number_set(&start[S->section.state], &S->section.value);
    }
    mpfr_t x;
    mpfr_init2(x, mpfr_get_prec(c->z[0]));
    for (int i = 0; i < S->d; i++) {
        if (S->index[i] == S->section.state)
            continue;
        mpfr_mul_si(x, c->z[i], cns_return_map_sign(S, i, *turns, late->side), MPFR_RNDN);
        cns_number_from_mpfr(&start[S->index[i]], x);
    }
    mpfr_clear(x);
}

/* The dynamic state x of the cycle's first state under an image of the model. */
static void set_image(const cns_return_map *S, const cns_image *image, const mpfr_t *first, int state,
                      mpfr_t x)
{
    const cns_model_motion *angle = S->images.model->motion;
    mpfr_set_zero(x, 1);
    if (angle != NULL && state == angle->angle && image->turns != 0) {
        mpfr_const_pi(x, MPFR_RNDN);
        mpfr_mul_si(x, x, 2 * image->turns, MPFR_RNDN);
        mpfr_div_si(x, x, angle->turns, MPFR_RNDN);
    }
    if (image->sign[state] > 0)
        mpfr_add(x, x, first[state], MPFR_RNDN);
    else
        mpfr_sub(x, x, first[state], MPFR_RNDN);
}

/* Levels that the cycle crosses where it passes through images of its first state. */
static void image_sections(const cns_return_map *S, const mpfr_t *first, cns_event_condition *sections)
{
    mpfr_t x;
    mpfr_init2(x, mpfr_get_prec(first[0]));
    for (int k = 1; k < S->images.n; k++) {
        cns_event_condition *section = &sections[k - 1];
        cns_event_condition_init(section);
        section->kind = CNS_CONDITION_VALUE;
        section->state = S->section.state;
        set_image(S, &S->images.item[k], first, section->state, x);
        cns_number_from_mpfr(&section->value, x);
    }
    mpfr_clear(x);
}

/* Notes how near the cycle comes to the image of its first state. */
static void approach_image(const cns_return_map *S, const mpfr_t *first, const cns_meeting *at, int k,
                           measures *m)
{
    const cns_image *image = &S->images.item[k];
    double gap = -HUGE_VAL;
    mpfr_t x;
    if (at->direction != image->sign[S->section.state])
        return;
    mpfr_init2(x, mpfr_get_prec(first[0]));
    for (int i = 0; i < S->d; i++) {
        const int state = S->index[i];
        set_image(S, image, first, state, x);
        mpfr_sub(x, x, at->state[state], MPFR_RNDN);
        if (state != S->section.state)
            gap = fmax(gap, cns_log2_mpfr(x) - cns_log2_2exp(S->scales[state], 0));
    }
    mpfr_clear(x);
    if (gap < m->image_gap) {
        m->image_gap = gap;
        m->image = k;
        m->image_time = mpfr_get_d(at->time, MPFR_RNDN);
    }
}

static void drop_first_maximum(measures *m, int n_states)
{
    m->maxima--;
    for (int i = 0; i < m->maxima; i++)
        mpfr_swap(m->value[m->drift + n_states + i], m->value[m->drift + n_states + i + 1]);
}

static cns_code measure(const cns_return_map *S, const cns_late *late, const cns_cycle *c, long digits,
                        measures *m, cns_error *err)
{
    const mpfr_prec_t prec = cns_modes_bits(digits);
    const long wanted = repetitions(S, c) * c->returns;
    const int swinging = S->motion != NULL ? S->motion->angle : S->observable;
    cns_number *start = cns_xalloc((size_t)S->n, sizeof *start);
    const int n_images = S->motion == NULL ? S->images.n - 1 : 0;
    cns_event_condition *sections = cns_xalloc((size_t)(3 + n_images), sizeof *sections);
    mpfr_t *state = cns_vector_xnew(S->n, prec);
    long turns, seen = 0;
    *m = (measures){.drift = 2, .prec = prec, .image_gap = HUGE_VAL};
    make_room(m, 2 + S->n);
    mpfr_t low, high, first, last; /* first: the time of the first maximum; last: when to stop looking */
    mpfr_inits2(prec, low, high, first, last, (mpfr_ptr)0);
    mpfr_set_inf(low, 1);
    mpfr_set_inf(high, -1);
    for (int i = 0; i < S->n; i++)
        cns_number_init(&start[i]);
    set_start(S, late, c, &turns, start);
    for (int i = 0; i < S->n; i++)
        cns_number_get_mpfr(state[i], &start[i]);
    sections[0] = S->section;
    for (int k = 1; k < 3; k++) {
        cns_event_condition_init(&sections[k]);
        sections[k].kind = CNS_CONDITION_EXTREMUM;
        sections[k].state = k == 1 ? S->observable : swinging;
    }
    if (n_images > 0)
        image_sections(S, (const mpfr_t *)state, sections + 3);
    const cns_trajectory_spec spec = {.flow = cns_return_map_flow(S, S->program, S->scales, digits),
                                      .initial = start,
                                      .no_growth = true,
                                      .conditions = sections,
                                      .n_conditions = 3 + n_images};
    cns_trajectory *t = cns_trajectory_new(&spec, err);
    cns_code code = t == NULL ? err->code : CNS_OK;
    /* A maximum may lie at the joint of two periods, as for a pendulum that goes round: it counts at the end
     * of one, and not at the beginning, whatever noise does to its time. */
    while (!code && (seen < wanted || mpfr_less_p(cns_flow_end(cns_trajectory_flow(t)), last))) {
        const cns_meetings *s = cns_trajectory_meetings(t);
        code = cns_trajectory_step(t, err);
        if (!code && cns_flow_steps(cns_trajectory_flow(t)) > 100 * S->limit)
            code = cns_fail(err, CNS_UNREACHED, "the cycle does not close");
        for (int i = 0; i < cns_meetings_count(s) && !code; i++) {
            const cns_meeting *at = cns_meetings_meeting(s, i);
            if (seen == wanted && mpfr_greater_p(at->time, last))
                break;
            if (at->condition == 0 && seen < wanted &&
                cns_return_map_counts(S, at, late->direction * (S->motion ? late->side : 1))) {
                if (++seen < wanted)
                    continue;
                mpfr_set(m->value[0], at->time, MPFR_RNDN);
                mpfr_mul_2si(last, at->time, JOINT_LOG2, MPFR_RNDN);
                if (m->maxima > 0 && mpfr_less_p(first, last))
                    drop_first_maximum(m, S->n);
                mpfr_add(last, last, at->time, MPFR_RNDN);
                for (int k = 0; k < S->n; k++)
                    if (!is_dynamic(S, k))
                        mpfr_set(m->value[m->drift + k], at->state[k], MPFR_RNDN);
                m->winding = S->motion != NULL ? (at->k - turns) / S->motion->turns : 0;
            } else if (at->condition == 1 && at->direction < 0) {
                make_room(m, m->drift + S->n + m->maxima + 1);
                if (m->maxima == 0)
                    mpfr_set(first, at->time, MPFR_RNDN);
                mpfr_set(m->value[m->drift + S->n + m->maxima++], at->state[S->observable], MPFR_RNDN);
            } else if (at->condition == 2) {
                mpfr_min(low, low, at->state[swinging], MPFR_RNDN);
                mpfr_max(high, high, at->state[swinging], MPFR_RNDN);
            } else if (at->condition >= 3 && seen < wanted) {
                approach_image(S, (const mpfr_t *)state, at, at->condition - 2, m);
            }
        }
    }
    mpfr_sub(m->value[1], high, low, MPFR_RNDN);
    mpfr_div_2ui(m->value[1], m->value[1], 1, MPFR_RNDN);
    cns_trajectory_free(t);
    for (int k = 1; k < 3 + n_images; k++)
        cns_event_condition_clear(&sections[k]);
    free(sections);
    cns_vector_free(state);
    for (int i = 0; i < S->n; i++)
        cns_number_clear(&start[i]);
    free(start);
    mpfr_clears(low, high, first, last, (mpfr_ptr)0);
    return code;
}

/* What two measurements agree on, of fine, as text; NULL: not even its integer part. */
static char *agreed(mpfr_srcptr coarse, mpfr_srcptr fine, double noise_log2)
{
    mpfr_t e;
    mpfr_init2(e, 64);
    mpfr_set_zero(e, 1);
    cns_proof_error(e, fine, coarse, noise_log2);
    const cns_bounded value = {fine, e};
    const long decimals = cns_proof_places(&value, 1, CNS_PLACES_DECIMALS, PRINTED);
    mpfr_clear(e);
    return decimals >= 0 ? cns_text_mpfr(fine, CNS_PLACES_DECIMALS, decimals) : NULL;
}

/* The symmetry of a cycle, and what is left of it up to symmetry. A cycle that passes through an image of one
 * of its states consists of images of the part up to there. Of two numbers that are the same but for noise,
 * half the digits are. */
static void name_symmetry(const cns_return_map *S, const cns_cycle *c, const measures *m, double noise_log2,
                          cns_motion *motion)
{
    const char *name = c->mirrored ? "mirror" : repetitions(S, c) > 1 ? "turn" : "none";
    int parts = 1;
    if (m->image > 0 && m->image_gap < noise_log2 / 2) {
        name = S->images.item[m->image].name;
        parts = (int)lround(mpfr_get_d(m->value[0], MPFR_RNDN) / m->image_time);
    }
    snprintf(motion->symmetry, sizeof motion->symmetry, "%.*s", CNS_SYMMETRY_NAME - 1, name);
    motion->returns = c->returns % parts == 0 ? c->returns / parts : c->returns;
    motion->multiplier = pow(c->multiplier, 1.0 / parts);
}

/* Fills the motion from a cycle, found and measured in two precisions. */
static cns_code describe(const cns_return_map *S, const cns_late *late, const cns_cycle *coarse,
                         const cns_cycle *fine, long coarse_digits, long fine_digits, cns_motion *motion,
                         cns_error *err)
{
    measures a, b;
    cns_code code = measure(S, late, coarse, coarse_digits, &a, err);
    if (code) {
        clear_measures(&a);
        return code;
    }
    code = measure(S, late, fine, fine_digits, &b, err);
    if (code || a.winding != b.winding || a.maxima != b.maxima) {
        if (!code)
            snprintf(motion->note, sizeof motion->note, "two measurements of a period do not agree");
        clear_measures(&a);
        clear_measures(&b);
        return code;
    }
    const double noise = 10 + fmax(0, fine->growth_log2) - (double)cns_modes_bits(coarse_digits);
    const bool angle = cns_system_model(S->system)->motion != NULL;
    motion->mode = !angle ? CNS_MODE_PERIODIC : b.winding == 0 ? CNS_MODE_FLUTTER : CNS_MODE_TUMBLE;
    name_symmetry(S, fine, &b, noise, motion);
    motion->winding = b.winding;
    motion->lambda = 0;
    motion->lambda_se = -1;
    motion->period = agreed(a.value[0], b.value[0], noise);
    if (b.winding == 0)
        motion->amplitude = agreed(a.value[1], b.value[1], noise);
    motion->drift = cns_xalloc((size_t)S->n, sizeof *motion->drift);
    motion->n_states = S->n;
    for (int i = 0; i < S->n; i++)
        if (!is_dynamic(S, i))
            motion->drift[i] = agreed(a.value[a.drift + i], b.value[b.drift + i], noise);
    if (angle && cns_system_model(S->system)->motion->height >= 0) {
        const int h = cns_system_model(S->system)->motion->height;
        mpfr_t *const both[] = {a.value, b.value};
        for (int k = 0; k < 2; k++) { /* the amplitude's place is free now */
            mpfr_div(both[k][1], both[k][2 + h], both[k][0], MPFR_RNDN);
            mpfr_neg(both[k][1], both[k][1], MPFR_RNDN);
        }
        motion->descent = agreed(a.value[1], b.value[1], noise);
    }
    motion->maximum = cns_xalloc((size_t)b.maxima + 1, sizeof *motion->maximum);
    for (int i = 0; i < b.maxima; i++) {
        char *text = agreed(a.value[a.drift + S->n + i], b.value[b.drift + S->n + i], noise);
        if (text != NULL)
            motion->maximum[motion->extrema++] = text;
    }
    clear_measures(&a);
    clear_measures(&b);
    return CNS_OK;
}

/* Returns that alternate about a cycle while they approach it repeat every second time before they repeat
 * every time: replaces c by the cycle of the fewest returns that it is a multiple of. */
static cns_code reduce_cycle(const cns_return_map *S, long digits, cns_cycle *c, cns_error *err)
{
    for (int n = 1; n < c->returns; n++) {
        cns_cycle part;
        if (c->returns % n != 0)
            continue;
        cns_code code = cns_cycle_find(S, (const mpfr_t *)c->z, n, c->direction, digits, &part, err);
        double gap = HUGE_VAL;
        if (!code) {
            gap = 0;
            for (int i = 0; i < S->d; i++)
                gap = fmax(gap, fabs(mpfr_get_d(part.z[i], MPFR_RNDN) - mpfr_get_d(c->z[i], MPFR_RNDN)) /
                                    S->scales[S->index[i]]);
        }
        if (gap < exp2(2 * same_log2)) {
            cns_cycle_clear(c);
            *c = part;
            return CNS_OK;
        }
        cns_cycle_clear(&part);
        if (code && code != CNS_UNREACHED)
            return code;
    }
    return CNS_OK;
}

/* The largest distance of two reduced states, in scales. */
static double distance(const cns_return_map *S, const mpfr_t *a, const mpfr_t *b)
{
    double gap = 0;
    for (int i = 0; i < S->d; i++)
        gap = fmax(gap,
                   fabs(mpfr_get_d(a[i], MPFR_RNDN) - mpfr_get_d(b[i], MPFR_RNDN)) / S->scales[S->index[i]]);
    return gap;
}

/* Do the last returns of a motion that has not settled come nearer to a cycle, as its multiplier has it? */
static bool approaches(const cns_return_map *S, const cns_late *late, const cns_cycle *c)
{
    const int turns = (late->known - 1) / c->returns;
    if (turns < 1 || !(c->multiplier < 1))
        return false;
    const mpfr_t *z = (const mpfr_t *)late->z, *center = (const mpfr_t *)c->z;
    const double end = distance(S, z, center), begin = distance(S, z + turns * c->returns * S->d, center),
                 rate = log(end / begin) / turns, wanted = log(c->multiplier);
    return end < exp2(near_log2) && rate < 0.5 * wanted && rate > 2 * wanted;
}

/* The cycle near a late motion, in two precisions; the motion's mode stays undecided where there is none or
 * where it does not attract, or where these digits are too few. */
static cns_code settle_cycle(const cns_return_map *S, const cns_late *late, long digits,
                             bool *short_of_digits, cns_motion *motion, cns_error *err)
{
    cns_cycle coarse = {0}, fine = {0};
    const mpfr_t *z = (const mpfr_t *)late->z;
    const long coarse_digits = digits > 0 ? digits : SECOND_DIGITS,
               fine_digits = coarse_digits + CNS_ANOTHER_LIMB;
    cns_code code = cns_cycle_find(S, z, late->returns, late->direction, coarse_digits, &coarse, err);
    /* What grows within one repetition, as near a saddle, takes digits of its own. */
    *short_of_digits =
        code == CNS_NUMERIC ||
        (!code && coarse.growth_log2 > (double)cns_modes_bits(coarse_digits) - CYCLE_LEAST_BITS);
    if (*short_of_digits) {
        cns_cycle_clear(&coarse);
        return CNS_OK;
    }
    if (!code)
        code = reduce_cycle(S, coarse_digits, &coarse, err);
    if (!code)
        code = cns_cycle_find(S, (const mpfr_t *)coarse.z, coarse.returns, late->direction, fine_digits,
                              &fine, err);
    if (code == CNS_UNREACHED && late->kind == CNS_LATE_OPEN) {
        code = CNS_OK;
    } else if (code == CNS_UNREACHED) {
        snprintf(motion->note, sizeof motion->note, "returns repeat, but %.200s", err->text);
        code = CNS_OK;
    } else if (!code && late->kind == CNS_LATE_OPEN && !approaches(S, late, &fine)) {
        motion->mode = CNS_MODE_UNDECIDED; /* and on the way nowhere yet */
    } else if (!code && !(fine.multiplier < 1)) {
        snprintf(motion->note, sizeof motion->note,
                 "the motion comes near a cycle that does not attract (multiplier %.6g)", fine.multiplier);
    } else if (!code) {
        code = describe(S, late, &coarse, &fine, coarse_digits, fine_digits, motion, err);
    }
    cns_cycle_clear(&coarse);
    cns_cycle_clear(&fine);
    return code;
}

/* Have two runs found the same? Their last returns may be at different places of the same cycle. */
static bool same(const cns_return_map *S, const cns_late *a, const cns_late *b)
{
    if (a->kind != b->kind || a->returns != b->returns || a->direction != b->direction)
        return false;
    if (a->kind != CNS_LATE_CYCLE)
        return a->kind != CNS_LATE_OPEN;
    double least = HUGE_VAL;
    for (int k = 0; k < b->returns; k++) {
        double gap = 0;
        for (int i = 0; i < S->d; i++)
            gap = fmax(gap, fabs(mpfr_get_d(a->z[i], MPFR_RNDN) - mpfr_get_d(b->z[k * S->d + i], MPFR_RNDN)) /
                                S->scales[S->index[i]]);
        least = fmin(least, gap);
    }
    return least < exp2(same_log2);
}

/* Digits for the next run: enough for the noise that this one has seen grow, were it as long as the horizon.
 */
static long more_digits(long digits, const cns_late *late, double horizon)
{
    const double base = -(double)cns_modes_bits(digits);
    const double grown = (late->noise_log2 - base) * CNS_LOG10_2 * fmax(1, horizon / late->time);
    const long needed = (long)fmin(grown, 1e6) + 12;
    const long least = digits == 0 ? SECOND_DIGITS : digits + CNS_ANOTHER_LIMB;
    return needed > least ? needed : least;
}

/* Those of the second half of the time. */
static void list_maxima(const cns_late *late, cns_motion *motion)
{
    motion->maximum = cns_xalloc((size_t)late->extrema + 1, sizeof *motion->maximum);
    for (int i = 0; i < late->extrema; i++) {
        char text[32];
        if (late->extremum[i].t < late->time / 2)
            continue;
        snprintf(text, sizeof text, "%.6g", late->extremum[i].value);
        motion->maximum[motion->extrema++] = cns_xcopy(text);
    }
}

/* Is what ran for so long without settling chaos? Its growth is measured in double and tested to be
 * stationary, over a longer time where it is not; motion: what was found, with a note unless it is plain that
 * it is no chaos. */
static cns_code look_for_chaos(const cns_system *s, const cns_classify_spec *spec, double time,
                               const cns_monitor *monitor, cns_motion *motion, cns_error *err)
{
    cns_code code = CNS_UNREACHED;
    cns_lyapunov_result r = {0};
    for (int look = 0; look < LOOKS && code == CNS_UNREACHED; look++, time *= LONGER) {
        char text[32], what[64];
        cns_lyapunov_spec growth = {.arithmetic = CNS_ARITH_DOUBLE, .portable = true, .exponents = 1};
        if (look > 0 && spec->until > 0)
            break;
        cns_lyapunov_result_clear(&r);
        snprintf(text, sizeof text, "%.3g", spec->until > 0 ? spec->until / 1.1 : time);
        snprintf(what, sizeof what, "growth up to t = %.3g", time);
        cns_monitor_tell(monitor, (look + 1) / (look + 2.0), what);
        cns_number_init(&growth.time);
        cns_number_parse(&growth.time, text, err);
        const cns_monitor quiet = {.stop = cns_monitor_stop(monitor)};
        code = cns_lyapunov(s, &growth, &quiet, &r, err);
        cns_number_clear(&growth.time);
    }
    motion->lambda_se = -1;
    motion->time = fmax(motion->time, r.discarded + r.time);
    if (code == CNS_UNREACHED) {
        snprintf(motion->note, sizeof motion->note, "no figure for chaos up to t = %.6g: %.180s",
                 motion->time, r.note);
        code = CNS_OK;
    } else if (!code) {
        const cns_exponent *e = r.exponent;
        motion->time = r.discarded + r.time;
        motion->transient = r.discarded;
        motion->lambda = e->lambda;
        motion->lambda_se = e->se;
        if (e->lambda > sure * e->se && e->lambda * r.time > LEAST_GROWTH) {
            motion->mode = CNS_MODE_CHAOTIC;
            snprintf(motion->note, sizeof motion->note, "up to t = %.6g%s%.180s", motion->time,
                     r.attractors != NULL ? "; it may end later: fixed points that attract: " : "",
                     r.attractors != NULL ? r.attractors : "");
        } else if (r.changes > 0)
            snprintf(motion->note, sizeof motion->note,
                     "chaos ends at t about %.3g, as far as double precision tells", r.change[0].t);
    }
    cns_lyapunov_result_clear(&r);
    return code;
}

/* How long a run with digits has to last: longer than it took others to settle; and longer than the last one
 * did, if that was trusted so long. */
static double next_horizon(double horizon, const cns_late *late)
{
    if (late->kind == CNS_LATE_OPEN && late->trusted_time > 0.9 * horizon)
        return 2 * late->time;
    return fmax(horizon, 1.5 * late->time);
}

cns_code cns_classify(const cns_system *s, const cns_classify_spec *spec, const cns_monitor *monitor,
                      cns_motion *motion, cns_error *err)
{
    cns_return_map S;
    cns_late last = {0}, late = {0};
    long digits = 0;
    double horizon = 0;
    bool have_last = false, done = false, patient = false;
    *motion = (cns_motion){.lambda_se = -1};
    cns_code code = cns_return_map_open(&S, s, spec->observable, spec->until, cns_monitor_stop(monitor), err);
    for (int round = 0; round < ROUNDS && !code && !done; round++) {
        char what[96];
        bool short_of_digits = false;
        snprintf(what, sizeof what,
                 digits > 0 ? "following the motion with %ld digits" : "following the motion", digits);
        cns_monitor_tell(monitor, (double)round / (round + 2.0), what);
        code = cns_late_find(&S, digits, horizon, &late, err);
        if (code)
            break;
        motion->digits = digits;
        motion->lambda = late.lambda;
        motion->lambda_se = late.lambda_se;
        motion->transient = late.transient;
        motion->time = late.time;
        done = true;
        if (late.kind == CNS_LATE_CHAOS || (late.kind == CNS_LATE_OPEN && digits == 0 && !late.trusted)) {
            code = look_for_chaos(s, spec, late.time, monitor, motion, err);
            if (motion->mode == CNS_MODE_CHAOTIC)
                list_maxima(&late, motion);
            done = motion->mode == CNS_MODE_CHAOTIC || motion->note[0] != '\0';
        } else if (late.kind == CNS_LATE_STEADY && have_last && same(&S, &last, &late)) {
            if (cns_late_attracts(&S, &late))
                motion->mode = CNS_MODE_STEADY;
            else
                snprintf(motion->note, sizeof motion->note,
                         "the motion comes to rest at a state that does not attract it");
        } else if (late.kind == CNS_LATE_CYCLE && late.trusted && have_last && same(&S, &last, &late)) {
            code = settle_cycle(&S, &late, digits, &short_of_digits, motion, err);
            done = !short_of_digits;
        } else if (late.kind == CNS_LATE_OPEN && late.trusted) {
            if (late.known > 0) /* a cycle that it comes nearer to, too slowly to wait for it? */
                code = settle_cycle(&S, &late, digits, &short_of_digits, motion, err);
            if (!code && motion->mode == CNS_MODE_UNDECIDED && spec->until == 0 && !patient) {
                S.limit *= PATIENCE;
                patient = true;
                done = false;
                cns_late_clear(&late);
                continue;
            }
            if (motion->mode == CNS_MODE_UNDECIDED)
                snprintf(motion->note, sizeof motion->note,
                         "neither a repetition nor a positive exponent up to t = %.6g", late.time);
        } else {
            done = false;
        }
        if (!done && !code) {
            horizon = next_horizon(horizon, &late);
            digits = more_digits(digits, &late, horizon);
            if (digits > spec->max_digits) {
                snprintf(motion->note, sizeof motion->note,
                         "to follow this trajectory into its late motion takes %ld digits, more than %ld",
                         digits, spec->max_digits);
                done = true;
            }
        }
        cns_late_clear(&last);
        last = late;
        have_last = true;
        late = (cns_late){0};
    }
    if (!done && !code)
        snprintf(motion->note, sizeof motion->note, "runs of different precision do not agree");
    if (code == CNS_STOPPED) {
        motion->time = fmax(motion->time, late.time);
        snprintf(motion->note, sizeof motion->note, "stopped at t = %.6g", motion->time);
    }
    cns_late_clear(&last);
    cns_late_clear(&late);
    cns_return_map_close(&S);
    return code;
}
