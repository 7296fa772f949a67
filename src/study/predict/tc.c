#include "tc_internal.h"

#include <math.h>
#include <stdlib.h>

#include "core/memory.h"
#include "core/monitor.h"
#include "envelope.h"
#include "integrate/numerics.h"
#include "integrate/rows.h"
#include "num/logs.h"
#include "peak.h"
#include "solve/problem.h"
#include "solve/proof.h"

enum {
    PREC = 64,           /* of differences and limits */
    TRUST_LOG2 = 44,     /* 24 for what noise may exceed its estimate by, 20 for the accuracy of T_c */
    ROW_GATE_LOG2 = 30,  /* intervals between rows are looked into once a difference is so near to delta */
    STEP_GATE_LOG2 = 12, /* and steps of the reference, in which differences grow by a few powers of e; */
    LEAP_LOG2 = 6,       /* where one was not, and ends so near to delta, it should have been */
    PIECES = 16,         /* parts of an interval that no step may leap over */
    ROW_RESOLUTION_LOG2 = 24,  /* of T_c, in intervals between rows */
    STEP_RESOLUTION_LOG2 = 40, /* and in steps of the reference */
    UNEXCITED_LOG2 = 8,        /* a difference so far below what noise would have grown to has not grown */
    WORKING_DIGITS = 12        /* of a K-digit run, beyond K */
};

const char *cns_tc_criterion_name(cns_tc_criterion criterion)
{
    return criterion == CNS_TC_ROWS ? "rows" : "envelope";
}

void cns_tc_result_clear(cns_tc_result *r)
{
    free(r->time);
    r->time = NULL;
}

/* The two runs at one time, and what is known of each observable. Both are compared at stops: at rows, or,
 * with an envelope, at the ends of the reference's steps, which are the same whatever rows a table has. */
typedef struct walk {
    const cns_tc_pair *pair;
    const cns_program *program;
    const double *scales;
    bool rows; /* the criterion is that of the rows */
    cns_trajectory *test, *reference;
    cns_envelope envelope;
    cns_sample u1, u2;
    double t; /* of the samples */
    int n;
    mpq_t from, to, now, at; /* the interval between stops; scratch */
    mpfr_t delta, d, limit;
    double gate, leap, resolution, spacing, trust_log2;
    bool *found, *differs;
    double *part;                /* the difference as a part of its limit, where it was looked at last */
    double *next;                /* scratch */
    double *since;               /* where it began to exceed the limit; NAN: it has not, or that is unknown */
    unsigned long *missed;       /* the first stop that it leapt to, without a look before; 0: none */
    double largest[2];           /* log2 of the largest distance in either half of the time */
    const unsigned long *forced; /* for each observable, a stop to look before; NULL: none */
} walk;

static void walk_clear(walk *w)
{
    cns_trajectory_free(w->test);
    cns_trajectory_free(w->reference);
    cns_sample_clear(&w->u1);
    cns_sample_clear(&w->u2);
    mpq_clears(w->from, w->to, w->now, w->at, (mpq_ptr)0);
    mpfr_clears(w->delta, w->d, w->limit, (mpfr_ptr)0);
    cns_envelope_clear(&w->envelope);
    free(w->found);
    free(w->differs);
    free(w->part);
    free(w->next);
    free(w->since);
    free(w->missed);
}

static cns_code walk_init(walk *w, const cns_tc_pair *pair, int n, cns_error *err)
{
    const double every = fmin(cns_number_get_d(pair->every), cns_number_get_d(pair->end));
    const bool rows = pair->criterion == CNS_TC_ROWS;
    *w = (walk){.pair = pair,
                .program = pair->reference->flow.program,
                .scales = pair->reference->flow.scales,
                .rows = rows,
                .n = n,
                .gate = ldexp(1, rows ? -ROW_GATE_LOG2 : -STEP_GATE_LOG2),
                .leap = rows ? 1 : ldexp(1, -LEAP_LOG2),
                .resolution = ldexp(fmin(1, every), -ROW_RESOLUTION_LOG2),
                .spacing = every / PIECES,
                .largest = {-HUGE_VAL, -HUGE_VAL}};
    const size_t room = (size_t)n;
    mpq_inits(w->from, w->to, w->now, w->at, (mpq_ptr)0);
    mpfr_inits2(PREC, w->delta, w->d, w->limit, (mpfr_ptr)0);
    cns_number_get_mpfr(w->delta, pair->delta);
    w->trust_log2 = cns_log2_mpfr(w->delta) - TRUST_LOG2;
    w->found = cns_xalloc(room, sizeof *w->found);
    w->differs = cns_xalloc(room, sizeof *w->differs);
    w->part = cns_xalloc(room, sizeof *w->part);
    w->next = cns_xalloc(room, sizeof *w->next);
    w->since = cns_xalloc(room, sizeof *w->since);
    w->missed = cns_xalloc(room, sizeof *w->missed);
    w->test = cns_trajectory_new(pair->test, err);
    w->reference = w->test ? cns_trajectory_new(pair->reference, err) : NULL;
    if (!w->reference)
        return err->code;
    if (!cns_sample_init(&w->u1, pair->test->flow.program, cns_flow_prec(cns_trajectory_flow(w->test))) ||
        !cns_sample_init(&w->u2, w->program, cns_flow_prec(cns_trajectory_flow(w->reference))))
        return cns_out_of_memory(err);
    cns_code code = rows ? CNS_OK : cns_envelope_init(&w->envelope, n, &pair->reference->flow, err);
    if (!code && !rows && pair->before)
        cns_envelope_raise(&w->envelope, pair->until, pair->before);
    return code;
}

/* w->d = the distance of the dynamic states, in scales. */
static void distance(walk *w)
{
    mpfr_set_zero(w->d, 1);
    for (int i = 0; i < w->u1.n_states; i++) {
        if (!cns_program_is_dynamic(w->program, i))
            continue;
        mpfr_sub(w->limit, w->u1.state[i], w->u2.state[i], MPFR_RNDN);
        mpfr_div_d(w->limit, w->limit, w->scales[i], MPFR_RNDN);
        mpfr_hypot(w->d, w->d, w->limit, MPFR_RNDN);
    }
}

/* The difference of observable i in the samples as a part of what it may be: above 1 it exceeds that. w->d is
 * left as the absolute difference. */
static double part_of_limit(walk *w, int i)
{
    if (i == CNS_TC_NORM) {
        distance(w);
        mpfr_set(w->limit, w->delta, MPFR_RNDN);
    } else {
        mpfr_srcptr u1 = cns_observable_of(&w->u1, i), u2 = cns_observable_of(&w->u2, i);
        mpfr_sub(w->d, u1, u2, MPFR_RNDN);
        mpfr_abs(w->d, w->d, MPFR_RNDN);
        if (mpfr_nan_p(w->d)) { /* 0/0 in a derived quantity: undefined in both runs is the same */
            mpfr_set_zero(w->d, 1);
            return mpfr_nan_p(u1) != mpfr_nan_p(u2) ? HUGE_VAL : 0;
        }
        if (w->rows)
            mpfr_abs(w->limit, u2, MPFR_RNDN);
        else
            cns_envelope_at(&w->envelope, i, w->t, u2, w->limit);
        mpfr_mul(w->limit, w->limit, w->delta, MPFR_RNDN);
    }
    if (mpfr_zero_p(w->d))
        return 0;
    mpfr_div(w->limit, w->d, w->limit, MPFR_RNDN); /* anything but 0 is infinitely off 0 */
    return mpfr_get_d(w->limit, MPFR_RNDU);
}

static void peek(walk *w, double t)
{
    mpq_set_d(w->at, t);
    cns_trajectory_peek(w->test, w->at, &w->u1);
    cns_trajectory_peek(w->reference, w->at, &w->u2);
    w->t = t;
}

/* It does not hold at `low` and does at `high`, both within the last steps: where it begins to. */
static double refine(walk *w, int i, double low, double high)
{
    while (high - low > w->resolution) {
        const double middle = low + (high - low) / 2;
        if (middle <= low || middle >= high)
            break;
        peek(w, middle);
        if (part_of_limit(w, i) > 1)
            high = middle;
        else
            low = middle;
    }
    return high;
}

typedef struct probe {
    walk *w;
    int i;
} probe;

static double part_at(void *context, double t)
{
    const probe *p = context;
    peek(p->w, t);
    return part_of_limit(p->w, p->i);
}

/* It does not hold at `low` or `high`, where the parts are these; near to it, it may in between. */
static void look_between(walk *w, int i, double low, double at_low, double high, double at_high)
{
    if (fmax(at_low, at_high) < 0.5)
        return;
    probe p = {w, i};
    const double t[] = {low, low + (high - low) / 2, high};
    const double value[] = {at_low, part_at(&p, t[1]), at_high};
    const cns_peak peak = cns_peak_find(part_at, &p, t, value, CNS_PEAK_NEAR);
    if (peak.value > 1)
        w->since[i] = refine(w, i, low, peak.t);
}

/* Looks at t, after `before`, both within the last steps of both runs. */
static void look(walk *w, double before, double t)
{
    peek(w, t);
    for (int i = 0; i < w->n; i++)
        w->next[i] = part_of_limit(w, i);
    for (int i = 0; i < w->n; i++) {
        const bool settled = w->found[i] || (!w->rows && !isnan(w->since[i])); /* the first time counts */
        if (!settled && w->next[i] > 1 && !(w->part[i] > 1))
            w->since[i] = refine(w, i, before, t);
        else if (!settled && !w->rows && !(w->next[i] > 1))
            look_between(w, i, before, w->part[i], t, w->next[i]);
        w->part[i] = w->next[i];
    }
}

/* Steps until the last step ends after t. */
static cns_code step_beyond(cns_trajectory *trajectory, const mpq_t t, cns_error *err)
{
    while (mpfr_cmp_q(cns_flow_end(cns_trajectory_flow(trajectory)), t) <= 0) {
        cns_code code = cns_trajectory_step(trajectory, err);
        if (code)
            return code;
    }
    return CNS_OK;
}

static void no_later_than(mpq_t t, cns_trajectory *trajectory, mpq_t scratch)
{
    mpfr_get_q(scratch, cns_flow_end(cns_trajectory_flow(trajectory)));
    if (mpq_cmp(scratch, t) < 0)
        mpq_set(t, scratch);
}

/* Through the interval from w->from to w->to, looking at both runs at the ends of the steps of either, and
 * often enough between them. */
static cns_code look_through(walk *w, cns_error *err)
{
    mpq_t next;
    cns_code code = CNS_OK;
    mpq_init(next);
    mpq_set(w->now, w->from);
    while (mpq_cmp(w->now, w->to) < 0) {
        code = step_beyond(w->test, w->now, err);
        if (!code)
            code = step_beyond(w->reference, w->now, err);
        if (code)
            break;
        mpq_set(next, w->to);
        no_later_than(next, w->test, w->at);
        no_later_than(next, w->reference, w->at);
        const double a = mpq_get_d(w->now), b = mpq_get_d(next);
        const int pieces = (int)ceil((b - a) / w->spacing);
        double before = a;
        for (int j = 1; j < pieces; j++) {
            const double t = a + (b - a) * j / pieces;
            if (t <= before || t >= b)
                continue;
            look(w, before, t);
            before = t;
        }
        look(w, before, b);
        mpq_swap(w->now, next);
    }
    mpq_clear(next);
    return code;
}

/* Must the interval before this stop be looked through? Where a difference is near its limit at the beginning
 * of it, and where a pass before this one found that it should have looked. */
static bool wants_a_look(const walk *w, unsigned long stop)
{
    for (int i = 0; i < w->n; i++)
        if ((!w->found[i] && w->part[i] > w->gate) || (w->forced && w->forced[i] == stop))
            return true;
    return false;
}

/* The stop at w->to, the samples being there. looked: the interval before was looked through. */
static void note_stop(walk *w, unsigned long stop, bool looked, cns_tc_result *r)
{
    const double half = cns_number_get_d(w->pair->end) / 2;
    w->t = mpq_get_d(w->to);
    for (int i = 0; i < w->n; i++) {
        w->part[i] = part_of_limit(w, i);
        const bool holds = w->part[i] > 1;
        w->differs[i] = w->differs[i] || holds || !mpfr_zero_p(w->d);
        if (i == CNS_TC_NORM)
            w->largest[w->t > half] = fmax(w->largest[w->t > half], cns_log2_mpfr(w->d));
        if (!looked && !w->found[i] && !w->missed[i] && w->part[i] > w->leap)
            w->missed[i] = stop;
        if (!w->found[i] && (holds || (!w->rows && !isnan(w->since[i])))) {
            w->found[i] = true;
            r->time[i] = (cns_tc_time){CNS_TC_FOUND, isnan(w->since[i]) ? w->t : w->since[i], w->t};
            if (!w->rows)
                r->time[i].row = r->time[i].t;
        }
        w->since[i] = NAN;
    }
    r->compared = w->t;
}

static bool enough(const walk *w)
{
    if (w->pair->until != CNS_TC_EVERY_ONE)
        return w->found[w->pair->until];
    for (int i = 0; i < w->n; i++)
        if (!w->found[i])
            return false;
    return true;
}

static cns_code test_failed(cns_code code, cns_error *err)
{
    const cns_error inner = *err;
    return code == CNS_STOPPED ? code : cns_fail(err, code, "the run under test: %s", inner.text);
}

/* w->to = the time of a stop. *more is false if there is none. */
static cns_code next_stop(walk *w, unsigned long stop, bool *more, cns_error *err)
{
    if (w->rows || stop == 0) {
        *more = cns_row_time(w->pair->every, w->pair->end, stop, w->to);
        return CNS_OK;
    }
    *more = mpq_cmp(w->from, w->pair->end->ratio) < 0;
    cns_code code = *more ? cns_trajectory_step(w->reference, err) : CNS_OK;
    if (code || !*more)
        return code;
    cns_envelope_follow(&w->envelope, w->reference);
    mpq_set(w->to, w->pair->end->ratio);
    no_later_than(w->to, w->reference, w->at);
    const double length = mpq_get_d(w->to) - mpq_get_d(w->from);
    w->spacing = length / PIECES;
    w->resolution = ldexp(length, -STEP_RESOLUTION_LOG2);
    return CNS_OK;
}

/* Both samples at w->to. */
static cns_code sample(walk *w, cns_error *err)
{
    cns_code code = cns_trajectory_at(w->test, w->to, &w->u1, err);
    return code ? test_failed(code, err) : cns_trajectory_at(w->reference, w->to, &w->u2, err);
}

/* One pass from stop to stop. */
static cns_code go(walk *w, cns_tc_result *r, cns_error *err)
{
    const double end = cns_number_get_d(w->pair->end);
    for (unsigned long stop = 0;; stop++) {
        bool more;
        cns_code code = next_stop(w, stop, &more, err);
        if (code || !more)
            return code;
        const bool looked = stop > 0 && wants_a_look(w, stop);
        if (looked)
            code = look_through(w, err);
        if (!code)
            code = sample(w, err);
        if (code)
            return code;
        if (w->u2.error_log2 > w->trust_log2) {
            r->trusted = false;
            return cns_fail(err, CNS_UNREACHED,
                            "t = %.12g: the error of the reference may be 10^%.1f, not far enough below "
                            "delta: it needs more digits",
                            mpq_get_d(w->to), w->u2.error_log2 * CNS_LOG10_2);
        }
        note_stop(w, stop, looked, r);
        if (enough(w))
            return CNS_OK;
        cns_monitor_tell(w->pair->monitor, mpq_get_d(w->to) / end, "the run under test and its reference");
        mpq_set(w->from, w->to);
    }
}

/* Is there a difference that does not grow? Not larger in the second half of the time, and either the
 * tangents say that none would, or they say that noise of all directions would have grown far beyond what is
 * there, as beside an invariant line. In between nothing is said: chaos pauses, too. */
static bool does_not_grow(const walk *w, const cns_tc_result *r)
{
    if (w->pair->test->no_growth || r->compared < cns_number_get_d(w->pair->end) ||
        w->largest[0] == -HUGE_VAL || w->largest[1] > w->largest[0] + 0.5)
        return false;
    return w->u1.growth <= 0 || w->largest[1] < w->u1.error_log2 - UNEXCITED_LOG2;
}

/* What is said of the observables without a T_c. */
static void conclude(const walk *w, cns_tc_result *r)
{
    const bool still = does_not_grow(w, r);
    for (int i = 0; i < w->n; i++) {
        const bool dynamic =
            i == CNS_TC_NORM || (i <= w->u1.n_states && cns_program_is_dynamic(w->program, i - 1));
        if (w->found[i])
            continue;
        r->time[i] = (cns_tc_time){CNS_TC_BEYOND, r->compared, r->compared};
        if (!w->differs[i])
            r->time[i].kind = CNS_TC_IDENTICAL;
        else if (still && dynamic)
            r->time[i].kind = CNS_TC_STILL;
    }
}

/* missed: for each observable, the stop before which a pass should have looked and did not; 0: none. */
static cns_code pass(const cns_tc_pair *pair, const unsigned long *forced, cns_tc_result *r,
                     unsigned long *missed, cns_error *err)
{
    walk w;
    cns_code code = walk_init(&w, pair, r->n, err);
    w.forced = forced;
    for (int i = 0; i < r->n; i++) {
        r->time[i] = (cns_tc_time){CNS_TC_BEYOND, 0, 0};
        w.since[i] = NAN;
    }
    r->trusted = true;
    r->compared = 0;
    if (!code)
        code = go(&w, r, err);
    if (w.u1.state)
        conclude(&w, r);
    if (w.test && w.reference) {
        r->steps = cns_flow_steps(cns_trajectory_flow(w.test));
        r->reference_steps = cns_flow_steps(cns_trajectory_flow(w.reference));
    }
    for (int i = 0; i < r->n; i++)
        missed[i] = w.missed[i];
    walk_clear(&w);
    return code;
}

cns_code cns_tc_compare(const cns_tc_pair *pair, cns_tc_result *result, cns_error *err)
{
    const cns_program *p = pair->reference->flow.program;
    const bool outputs = pair->reference->outputs && pair->test->outputs;
    *result = (cns_tc_result){.n = 1 + cns_program_states(p) + (outputs ? cns_program_outputs(p) : 0)};
    result->time = cns_xalloc((size_t)result->n, sizeof *result->time);
    if (pair->reference->no_growth)
        return cns_fail(err, CNS_USAGE, "a reference whose growth is not followed cannot be trusted");
    unsigned long *missed = cns_xalloc(2 * (size_t)result->n, sizeof *missed), any = 0;
    cns_code code = pass(pair, NULL, result, missed, err);
    for (int i = 0; i < result->n; i++)
        any |= missed[i];
    /* A difference that came from nowhere within one interval: again, with an eye on that interval. */
    if (any && (!code || code == CNS_UNREACHED))
        code = pass(pair, missed, result, missed + result->n, err);
    free(missed);
    return code;
}

cns_flow_spec cns_tc_flow(const cns_system *s, const cns_numerics *n, const volatile sig_atomic_t *stop)
{
    cns_flow_spec spec = cns_flow_spec_given(cns_system_program(s), cns_system_scales(s), n, WORKING_DIGITS);
    spec.round_digits = n->arithmetic == CNS_ARITH_DOUBLE ? 0 : n->digits;
    spec.stop = stop;
    return spec;
}

static cns_flow_spec reference_flow(const cns_system *s, long digits, const volatile sig_atomic_t *stop)
{
    cns_flow_spec spec =
        cns_flow_spec_taylor(cns_system_program(s), cns_system_scales(s), CNS_ARITH_FAST, digits);
    spec.safety = CNS_FINE_SAFETY;
    spec.verify = true;
    spec.stop = stop;
    return spec;
}

cns_code cns_tc_measure(const cns_problem *p, const cns_tc_spec *spec, cns_tc_result *result, cns_error *err)
{
    const bool automatic = spec->reference_digits == 0, outputs = cns_wants_outputs(p);
    const volatile sig_atomic_t *stop = cns_monitor_stop(p->monitor);
    const long own =
        spec->numerics->arithmetic == CNS_ARITH_DOUBLE ? CNS_DOUBLE_DIGITS : spec->numerics->digits;
    const double end = cns_number_get_d(p->end);
    long digits = automatic ? own + CNS_ANOTHER_LIMB : spec->reference_digits;
    const cns_trajectory_spec test = {.flow = cns_tc_flow(p->system, spec->numerics, stop),
                                      .initial = cns_system_initial(p->system),
                                      .outputs = outputs,
                                      .end = end,
                                      .most_steps = cns_most_steps(p, 0)};
    for (;;) {
        const cns_trajectory_spec reference = {
            .flow = reference_flow(spec->truth != NULL ? spec->truth : p->system, digits, stop),
            .initial = test.initial,
            .outputs = outputs,
            .end = end};
        const cns_tc_pair pair = {.test = &test,
                                  .reference = &reference,
                                  .end = p->end,
                                  .every = cns_every(p),
                                  .delta = spec->delta,
                                  .criterion = spec->criterion,
                                  .until = spec->until,
                                  .monitor = p->monitor};
        cns_code code = cns_tc_compare(&pair, result, err);
        result->reference_digits = digits;
        const long more = digits + 10 + digits / 4;
        if (!automatic || code != CNS_UNREACHED || more > CNS_TC_MAX_DIGITS)
            return code;
        digits = more;
        cns_tc_result_clear(result);
    }
}
