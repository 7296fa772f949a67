#include "returns.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "integrate/numerics.h"
#include "integrate/trajectory.h"
#include "num/logs.h"
#include "num/vector.h"
#include "study/batches.h"
#include "study/saddle/fixed_point.h"
#include "taylor/tangent.h"

enum {
    LIMIT = 60000,      /* steps; a step is some fraction of the time in which the motion changes */
    LEVEL_STEPS = 4000, /* steps after which a level is chosen, from the second half of them */
    HISTORY = CNS_LATE_RETURNS,
    CALM = 32,         /* steps in a row with hardly any change: steady */
    BATCH_STEPS = 250, /* of the exponent */
    LEAST_BATCHES = 32,
    MOST_BATCHES = 512,
    GROUPS = 16, /* batch means, for the exponent's error */
    DOUBLE_TOLERANCE_LOG2 = -52
};

#define LOG2_E 1.4426950408889634074 /* log2 e */

static const double calm_log2 = -36;     /* rates of change, in scales, that are hardly any */
static const double repeat_log2 = -24;   /* returns this near to earlier ones repeat them */
static const double distrust_log2 = -16; /* noise at a return that could decide on what follows */
static const double sure = 6;            /* standard errors by which an exponent is positive */
static const double settled_log2 = -10;  /* nearer to its late motion than this, the transient is over */

mpfr_prec_t cns_modes_bits(long digits)
{
    return digits > 0 ? cns_digits_to_bits(digits) : CNS_DOUBLE_BITS;
}

cns_flow_spec cns_return_map_flow(const cns_return_map *S, const cns_program *p, const double *scales,
                                  long digits)
{
    cns_flow_spec spec = digits > 0 ? cns_flow_spec_taylor(p, scales, CNS_ARITH_FAST, digits)
                                    : cns_flow_spec_taylor(p, scales, CNS_ARITH_DOUBLE, CNS_DOUBLE_DIGITS);
    if (digits == 0)
        spec.tolerance_log2 = DOUBLE_TOLERANCE_LOG2;
    spec.portable = true;
    spec.stop = S->stop;
    return spec;
}

void cns_number_from_mpfr(cns_number *n, mpfr_srcptr x)
{
    cns_error err;
    mpq_t q;
    mpq_init(q);
    mpfr_get_q(q, x);
    char *text = mpq_get_str(NULL, 10, q);
    if (cns_number_parse(n, text, &err)) /* too long a text for the grammar: the value will do */
        mpq_set(n->ratio, q);
    n->pi_power = 0;
    free(text);
    mpq_clear(q);
}

/* Sections. */

static void angle_section(cns_return_map *S)
{
    cns_error err;
    char text[32];
    snprintf(text, sizeof text, "2*pi/%d", S->motion->turns);
    S->section.kind = CNS_CONDITION_PERIODS;
    S->section.state = S->motion->angle;
    cns_number_parse(&S->section.value, "0", &err);
    cns_number_parse(&S->section.period, text, &err);
}

/* The state with the widest range in the late motion, in scales, and the middle of that range; and whether
 * the angle passes its section there. */
static cns_code choose_section(cns_return_map *S, cns_error *err)
{
    double *low = cns_xalloc((size_t)S->n, sizeof *low), *high = cns_xalloc((size_t)S->n, sizeof *high);
    int passes = 0;
    if (S->motion != NULL)
        angle_section(S);
    const cns_trajectory_spec spec = {.flow = cns_return_map_flow(S, S->program, S->scales, 0),
                                      .initial = cns_system_initial(S->system),
                                      .no_growth = true,
                                      .conditions = &S->section,
                                      .n_conditions = S->motion != NULL};
    cns_trajectory *t = cns_trajectory_new(&spec, err);
    cns_code code = t == NULL ? err->code : CNS_OK;
    for (long step = 0; !code && step < LEVEL_STEPS && passes < 2; step++) {
        code = cns_trajectory_step(t, err);
        if (code)
            break;
        if (S->motion != NULL && step >= LEVEL_STEPS / 8)
            passes += cns_meetings_count(cns_trajectory_meetings(t));
        for (int i = 0; i < S->n; i++) {
            const double x = mpfr_get_d(cns_flow_state(cns_trajectory_flow(t))[i], MPFR_RNDN);
            low[i] = step <= LEVEL_STEPS / 2 ? x : fmin(low[i], x);
            high[i] = step <= LEVEL_STEPS / 2 ? x : fmax(high[i], x);
        }
    }
    if (!code && passes < 2) {
        double widest = -1, level = 0;
        S->motion = NULL;
        for (int k = 0; k < S->d; k++) {
            const int i = S->index[k];
            if ((high[i] - low[i]) / S->scales[i] > widest) {
                widest = (high[i] - low[i]) / S->scales[i];
                S->section.state = i;
                level = 0.5 * (low[i] + high[i]);
            }
        }
        mpfr_t x;
        mpfr_init2(x, 24); /* a level need not be exact, but it must be the same at every precision */
        mpfr_set_d(x, level, MPFR_RNDN);
        cns_number_from_mpfr(&S->section.value, x);
        mpfr_clear(x);
        S->section.kind = CNS_CONDITION_VALUE;
    }
    cns_trajectory_free(t);
    free(low);
    free(high);
    return code;
}

cns_code cns_return_map_open(cns_return_map *S, const cns_system *system, int observable, double until,
                             const volatile sig_atomic_t *stop, cns_error *err)
{
    const cns_model *m = cns_system_model(system);
    *S = (cns_return_map){.system = system,
                          .program = cns_system_program(system),
                          .scales = cns_system_scales(system),
                          .stop = stop,
                          .motion = m->motion,
                          .n = m->n_states,
                          .limit = LIMIT};
    cns_event_condition_init(&S->section);
    cns_images_open(&S->images, m);
    S->index = cns_xalloc((size_t)S->n + 1, sizeof *S->index);
    S->d = cns_dynamic_states(S->program, S->index);
    if (S->d < 2)
        return cns_fail(err, CNS_USAGE, "a motion with less than two dynamic states has no modes");
    S->observable = observable >= 0 ? observable : S->index[S->d - 1];
    S->until = until;
    return choose_section(S, err);
}

void cns_return_map_close(cns_return_map *S)
{
    cns_event_condition_clear(&S->section);
    cns_images_close(&S->images);
    free(S->index);
}

static bool mirrors(const cns_return_map *S)
{
    return S->motion != NULL && S->motion->mirror_sign != NULL;
}

int cns_return_map_sign(const cns_return_map *S, int i, long turns, int direction)
{
    const int state = S->index[i];
    if (S->motion == NULL)
        return 1;
    const int sign = turns % 2 != 0 ? S->motion->turn_sign[state] : 1;
    return direction < 0 && mirrors(S) ? sign * S->motion->mirror_sign[state] : sign;
}

bool cns_return_map_counts(const cns_return_map *S, const cns_meeting *m, int before)
{
    if (m->direction == 0)
        return false;
    if (S->motion == NULL)
        return m->direction > 0;
    return mirrors(S) || before == 0 || m->direction == before;
}

/* Following. */

typedef struct follower {
    const cns_return_map *S;
    cns_late *late;
    cns_trajectory *trajectory; /* with events: condition 0 are returns, 1 extrema of the observable */
    cns_flow *flow;             /* the trajectory's */
    mpq_t time;                 /* scratch, */
    mpfr_t x;                   /* and of the run's precision */

    /* The last returns, number j in place j % HISTORY: reduced states of d numbers, the direction in which
     * the angle moved there, as the reduced state has it and as it was, and the turns it had made. */
    long count;
    mpfr_t *z;
    int direction[HISTORY], side[HISTORY];
    long turns[HISTORY];
    int streak[CNS_MOST_RETURNS + 1]; /* [n]: how many returns in a row were near to the one n before them */

    /* All returns, in double, to tell afterwards when the transient ended. */
    double *all, *times;
    long room;
    int extrema_room;

    int calm;       /* steps in a row with hardly any change */
    double fastest; /* log2 of the largest rate of change since the last return */

    /* Growth, in batches of batch_steps steps: log10 of it at their ends, and the times of these. When the
     * batches are full, each two become one. */
    int batches;
    double batch[MOST_BATCHES], batch_time[MOST_BATCHES];
    long batch_steps, next_batch; /* the latter a number of steps of the run */
    bool chaos;                   /* the exponent is above zero by `sure` standard errors */
    double growing_until;         /* growth is no longer followed from this time on; < 0: it is */
} follower;

static void close_follower(follower *F)
{
    cns_vector_free(F->z);
    cns_trajectory_free(F->trajectory);
    mpq_clear(F->time);
    mpfr_clear(F->x);
    free(F->all);
    free(F->times);
}

static cns_code open_follower(follower *F, const cns_return_map *S, long digits, cns_late *late,
                              cns_error *err)
{
    cns_event_condition both[2];
    const cns_trajectory_spec spec = {.flow = cns_return_map_flow(S, S->program, S->scales, digits),
                                      .initial = cns_system_initial(S->system),
                                      .conditions = both,
                                      .n_conditions = 2};
    *F = (follower){
        .S = S, .late = late, .fastest = -HUGE_VAL, .growing_until = -1, .batch_steps = BATCH_STEPS};
    F->next_batch = BATCH_STEPS;
    mpq_init(F->time);
    mpfr_init2(F->x, spec.flow.prec);
    F->z = cns_vector_xnew(HISTORY * S->d, spec.flow.prec);
    both[0] = S->section;
    cns_event_condition_init(&both[1]);
    both[1].kind = CNS_CONDITION_EXTREMUM;
    both[1].state = S->observable;
    F->trajectory = cns_trajectory_new(&spec, err);
    cns_event_condition_clear(&both[1]);
    if (F->trajectory == NULL)
        return err->code;
    F->flow = cns_trajectory_flow(F->trajectory);
    return CNS_OK;
}

/* log2 of the largest rate of change of the dynamic states at the beginning of the last step, in scales. */
static double rate_log2(follower *F)
{
    double fastest = -HUGE_VAL;
    for (int k = 0; k < F->S->d; k++) {
        const int i = F->S->index[k];
        int degree;
        mpfr_t *c = cns_flow_polynomial(F->flow, i, &degree, F->x);
        if (degree < 1 || mpfr_zero_p(c[1]))
            continue;
        fastest =
            fmax(fastest, cns_log2_mpfr(c[1]) - cns_log2_mpfr(F->x) - cns_log2_2exp(F->S->scales[i], 0));
    }
    return fastest;
}

/* log2 of the largest distance of the reduced states of returns a and b, in scales. */
static double gap_log2(follower *F, long a, long b)
{
    const int d = F->S->d;
    double gap = -HUGE_VAL;
    for (int i = 0; i < d; i++) {
        mpfr_sub(F->x, F->z[a % HISTORY * d + i], F->z[b % HISTORY * d + i], MPFR_RNDN);
        gap = fmax(gap, cns_log2_mpfr(F->x) - cns_log2_2exp(F->S->scales[F->S->index[i]], 0));
    }
    return gap;
}

static void remember(follower *F, const cns_meeting *m)
{
    const cns_return_map *S = F->S;
    const int d = S->d;
    const long j = F->count;
    if (j == F->room) {
        F->room = 2 * F->room + 64;
        F->all = cns_xgrow(F->all, (size_t)(F->room * d), sizeof *F->all);
        F->times = cns_xgrow(F->times, (size_t)F->room, sizeof *F->times);
    }
    for (int i = 0; i < d; i++) {
        mpfr_t *z = &F->z[j % HISTORY * d + i];
        if (S->index[i] == S->section.state)
            mpfr_set_zero(*z, 1);
        else
            mpfr_mul_si(*z, m->state[S->index[i]], cns_return_map_sign(S, i, m->k, m->direction), MPFR_RNDN);
        F->all[j * d + i] = mpfr_get_d(*z, MPFR_RNDN);
    }
    F->direction[j % HISTORY] = mirrors(S) ? 1 : m->direction;
    F->side[j % HISTORY] = m->direction;
    F->turns[j % HISTORY] = m->k;
    F->times[j] = mpfr_get_d(m->time, MPFR_RNDN);
    F->count++;
}

/* The state in which it rests. */
static void settle(follower *F)
{
    const cns_return_map *S = F->S;
    cns_late *late = F->late;
    late->kind = CNS_LATE_STEADY;
    late->rest = cns_xalloc((size_t)S->d, sizeof *late->rest);
    late->moves = cns_xalloc((size_t)S->d, sizeof *late->moves);
    for (int k = 0; k < S->d; k++) {
        const mpfr_t *x = &cns_flow_state(F->flow)[S->index[k]];
        late->rest[k] = mpfr_get_d(*x, MPFR_RNDN);
        cns_number_get_mpfr(F->x, &cns_system_initial(S->system)[S->index[k]]);
        late->moves[k] = !mpfr_equal_p(F->x, *x);
    }
}

/* The transient ends with the first return that is near the one of the late cycle that it will become. */
static void measure_transient(follower *F, int n)
{
    const int d = F->S->d;
    const double near = ldexp(1, (int)settled_log2);
    long j = F->count - 1;
    for (; j >= 0; j--) {
        const long late = F->count - 1 - (F->count - 1 - j) % n;
        double gap = 0;
        for (int i = 0; i < d; i++)
            gap = fmax(gap, fabs(F->all[j * d + i] - F->all[late * d + i]) / F->S->scales[F->S->index[i]]);
        if (gap > near)
            break;
    }
    F->late->transient = F->times[j + 1];
}

/* The last returns, n of which are, or nearly are, a repetition. */
static void keep_returns(follower *F, int n)
{
    cns_late *late = F->late;
    const long j = F->count - 1;
    late->returns = n;
    late->known = (int)(F->count < HISTORY ? F->count : HISTORY);
    late->direction = F->direction[j % HISTORY];
    late->d = F->S->d;
    late->z = cns_vector_xnew(late->known * late->d, mpfr_get_prec(F->x));
    for (int k = 0; k < late->known; k++)
        for (int i = 0; i < late->d; i++)
            mpfr_set(late->z[k * late->d + i], F->z[(j - k) % HISTORY * late->d + i], MPFR_RNDN);
}

static double repetition_gap(follower *F, int n)
{
    const long j = F->count - 1;
    return F->direction[j % HISTORY] == F->direction[(j - n) % HISTORY] ? gap_log2(F, j, j - n) : HUGE_VAL;
}

static bool repeats(follower *F)
{
    cns_late *late = F->late;
    const long j = F->count - 1;
    int found = 0;
    for (int n = 1; n <= CNS_MOST_RETURNS && n <= j; n++) {
        F->streak[n] = repetition_gap(F, n) < repeat_log2 + fmin(F->fastest, 0) ? F->streak[n] + 1 : 0;
        if (found == 0 && F->streak[n] >= (n < 2 ? 5 : 2 * n + 2))
            found = n;
    }
    if (found == 0)
        return false;
    late->kind = CNS_LATE_CYCLE;
    late->cycle_turns = F->turns[j % HISTORY] - F->turns[(j - found) % HISTORY];
    late->cycle_mirrored = F->side[j % HISTORY] != F->side[(j - found) % HISTORY];
    keep_returns(F, found);
    measure_transient(F, found);
    return true;
}

/* What a motion repeats best that has not settled. */
static void propose(follower *F)
{
    int best = 0;
    double least = HUGE_VAL;
    for (int n = 1; n <= CNS_MOST_RETURNS && n < F->count; n++)
        if (repetition_gap(F, n) < least) {
            least = repetition_gap(F, n);
            best = n;
        }
    if (best == 0)
        return;
    keep_returns(F, best);
    measure_transient(F, best);
}

/* ln of the growth per time from the end of batch a - 1 to that of batch b - 1. */
static double rate(const follower *F, int a, int b)
{
    return (F->batch[b - 1] - F->batch[a - 1]) * CNS_LOG2_10 * 0.69314718055994530942 /
           (F->batch_time[b - 1] - F->batch_time[a - 1]);
}

/* The mean of (growth per time) over batches from..to-1 and its standard error from means of groups. */
static void exponent(follower *F, int from, int to)
{
    cns_late *late = F->late;
    double mean[GROUPS];
    const int size = (to - from) / GROUPS;
    late->lambda_se = -1;
    if (size < 1)
        return;
    from = to - GROUPS * size;
    for (int g = 0; g < GROUPS; g++)
        mean[g] = rate(F, from + g * size, from + (g + 1) * size);
    late->lambda = rate(F, from, to);
    late->lambda_se = cns_batch_error(mean, GROUPS, GROUPS);
}

/* Notes the growth at the end of a batch. */
static cns_code end_batch(follower *F, cns_error *err)
{
    double growth = 0, noise;
    mpfr_get_q(F->time, cns_flow_end(F->flow));
    cns_code code = cns_growth_at(cns_trajectory_growth(F->trajectory), F->time, &growth, &noise, err);
    if (F->batches == MOST_BATCHES) { /* twice as long ones from now on */
        for (int i = 0; i < MOST_BATCHES / 2; i++) {
            F->batch[i] = F->batch[2 * i + 1];
            F->batch_time[i] = F->batch_time[2 * i + 1];
        }
        F->batches /= 2;
        F->batch_steps *= 2;
    }
    F->batch[F->batches] = growth;
    F->batch_time[F->batches++] = mpfr_get_d(cns_flow_end(F->flow), MPFR_RNDN);
    F->next_batch += F->batch_steps;
    if (F->batches < LEAST_BATCHES || F->batches % 8 != 0)
        return code;
    const int half = F->batches / 2;
    exponent(F, half, F->batches);
    const double span = F->batch_time[F->batches - 1] - F->batch_time[half];
    F->chaos =
        F->late->lambda_se >= 0 && F->late->lambda > sure * F->late->lambda_se && F->late->lambda * span > 20;
    return code;
}

static void note_maximum(follower *F, const cns_meeting *m)
{
    cns_late *late = F->late;
    if (late->extrema == F->extrema_room) {
        F->extrema_room = 2 * F->extrema_room + 64;
        late->extremum = cns_xgrow(late->extremum, (size_t)F->extrema_room, sizeof *late->extremum);
    }
    late->extremum[late->extrema].t = mpfr_get_d(m->time, MPFR_RNDN);
    late->extremum[late->extrema++].value = mpfr_get_d(m->state[F->S->observable], MPFR_RNDN);
}

static cns_code at_meetings(follower *F, bool *over, cns_error *err)
{
    cns_late *late = F->late;
    double growth = 0, noise;
    cns_code code = CNS_OK;
    const cns_meetings *meetings = cns_trajectory_meetings(F->trajectory);
    for (int i = 0; i < cns_meetings_count(meetings) && !code && !*over; i++) {
        const cns_meeting *m = cns_meetings_meeting(meetings, i);
        if (m->condition == 1) {
            if (m->direction < 0)
                note_maximum(F, m);
            continue;
        }
        if (!cns_return_map_counts(F->S, m, 0))
            continue;
        if (F->growing_until < 0) {
            mpfr_get_q(F->time, m->time);
            code = cns_growth_at(cns_trajectory_growth(F->trajectory), F->time, &growth, &noise, err);
            if (code)
                break;
            late->noise_log2 = fmax(late->noise_log2, noise);
            if (late->noise_log2 < distrust_log2)
                late->trusted_time = late->time;
        }
        remember(F, m);
        late->side = m->direction;
        late->turns = m->k;
        *over = repeats(F);
        F->fastest = -HUGE_VAL;
    }
    return code;
}

cns_code cns_late_find(const cns_return_map *S, long digits, double horizon, cns_late *late, cns_error *err)
{
    follower F;
    bool over = false;
    *late = (cns_late){.lambda_se = -1, .noise_log2 = -HUGE_VAL};
    cns_code code = open_follower(&F, S, digits, late, err);
    while (!code && !over) {
        const long steps = cns_flow_steps(F.flow);
        const bool noisy = late->noise_log2 >= distrust_log2;
        if (S->until > 0 ? late->time >= S->until : steps >= S->limit) {
            late->kind = F.chaos ? CNS_LATE_CHAOS : CNS_LATE_OPEN;
            if (!F.chaos)
                propose(&F);
            break;
        }
        if (digits > 0 && noisy && (horizon > 0 ? late->time >= horizon : F.chaos))
            break;
        if (F.chaos && noisy && F.growing_until < 0) {
            F.growing_until = late->time;
            cns_trajectory_leave_growth(F.trajectory);
        }
        code = cns_trajectory_step(F.trajectory, err);
        if (code)
            break;
        late->time = mpfr_get_d(cns_flow_end(F.flow), MPFR_RNDN);
        const double fast = rate_log2(&F), floor = digits > 0 ? calm_log2 * (double)digits / 16 : calm_log2;
        F.fastest = fmax(F.fastest, fast);
        F.calm = fast < floor ? F.calm + 1 : 0;
        if (F.calm == 1)
            late->transient = late->time;
        if (F.calm >= CALM) {
            settle(&F);
            break;
        }
        code = at_meetings(&F, &over, err);
        if (!code && !over && F.growing_until < 0 && cns_flow_steps(F.flow) >= F.next_batch)
            code = end_batch(&F, err);
    }
    if (late->kind == CNS_LATE_CHAOS)
        late->transient = F.batch_time[F.batches / 2];
    late->looks_chaotic = F.chaos;
    late->trusted = late->noise_log2 < distrust_log2;
    if (F.growing_until >= 0) /* noise was not followed from then on: it grows at the mean rate */
        late->noise_log2 += late->lambda * (late->time - F.growing_until) * LOG2_E;
    close_follower(&F);
    return code;
}

void cns_late_clear(cns_late *late)
{
    cns_vector_free(late->z);
    free(late->rest);
    free(late->moves);
    free(late->extremum);
    late->extremum = NULL;
    late->z = NULL;
    late->rest = NULL;
    late->moves = NULL;
}

bool cns_late_attracts(const cns_return_map *S, const cns_late *late)
{
    cns_reduced r;
    cns_fixed_point f;
    cns_error err;
    bool found = false, attracts = false;
    if (!cns_reduced_open(&r, S->program, &err)) {
        cns_fixed_point_init(&f, S->d);
        for (slong prec = 128; prec <= 1024 && !found; prec *= 2)
            found = !cns_fixed_point_find(&r, late->rest, prec, &f, &err);
        double gap = 0;
        for (int k = 0; k < S->d && found; k++)
            gap = fmax(gap, fabs(arf_get_d(arb_midref(f.x + k), ARF_RND_NEAR) - late->rest[k]) /
                                S->scales[S->index[k]]);
        attracts = found && gap < exp2(settled_log2) && cns_fixed_point_attracts(&f, late->moves);
        cns_fixed_point_clear(&f);
    }
    cns_reduced_close(&r);
    return attracts;
}
