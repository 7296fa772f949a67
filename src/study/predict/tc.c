#include "tc_internal.h"

#include <math.h>
#include <stdlib.h>

#include "core/memory.h"
#include "core/monitor.h"
#include "integrate/numerics.h"
#include "integrate/rows.h"
#include "num/logs.h"
#include "solve/problem.h"
#include "solve/proof.h"

enum {
    PREC = 64,            /* of differences and limits */
    TRUST_LOG2 = 44,      /* 24 for what noise may exceed its estimate by, 20 for the accuracy of T_c */
    GATE_LOG2 = 30,       /* intervals are looked into once a difference is within this of delta */
    PIECES = 16,          /* parts of an interval that no step may leap over */
    RESOLUTION_LOG2 = 24, /* of T_c, in intervals */
    UNEXCITED_LOG2 = 8,   /* a difference so far below what noise would have grown to has not grown */
    WORKING_DIGITS = 12   /* of a K-digit run, beyond K */
};

void cns_tc_result_clear(cns_tc_result *r)
{
    free(r->time);
    r->time = NULL;
}

/* The two runs at one time, and what is known of each observable. */
typedef struct walk {
    const cns_tc_pair *pair;
    const cns_program *program;
    const double *scales;
    cns_trajectory *test, *reference;
    cns_sample u1, u2;
    int n;
    mpq_t from, to, now, at; /* the interval; scratch */
    mpfr_t delta, gate, d, limit;
    double resolution, spacing, trust_log2;
    bool *found, *holds, *differs;
    bool *next;         /* scratch */
    double *since;      /* the beginning of the stretch on which it holds; NAN: unknown */
    bool *missed;       /* found at a row whose interval was not looked into */
    double largest[2];  /* log2 of the largest distance in either half of the time */
    const bool *forced; /* rows to look before; NULL: none */
    unsigned long n_forced;
} walk;

static void walk_clear(walk *w)
{
    cns_trajectory_free(w->test);
    cns_trajectory_free(w->reference);
    cns_sample_clear(&w->u1);
    cns_sample_clear(&w->u2);
    mpq_clears(w->from, w->to, w->now, w->at, (mpq_ptr)0);
    mpfr_clears(w->delta, w->gate, w->d, w->limit, (mpfr_ptr)0);
    free(w->found);
    free(w->holds);
    free(w->differs);
    free(w->next);
    free(w->since);
    free(w->missed);
}

static cns_code walk_init(walk *w, const cns_tc_pair *pair, int n, cns_error *err)
{
    const double every = fmin(cns_number_get_d(pair->every), cns_number_get_d(pair->end));
    *w = (walk){.pair = pair,
                .program = pair->reference->flow.program,
                .scales = pair->reference->flow.scales,
                .n = n,
                .resolution = ldexp(fmin(1, every), -RESOLUTION_LOG2),
                .spacing = every / PIECES,
                .largest = {-HUGE_VAL, -HUGE_VAL}};
    const size_t room = (size_t)n;
    mpq_inits(w->from, w->to, w->now, w->at, (mpq_ptr)0);
    mpfr_inits2(PREC, w->delta, w->gate, w->d, w->limit, (mpfr_ptr)0);
    cns_number_get_mpfr(w->delta, pair->delta);
    mpfr_div_2ui(w->gate, w->delta, GATE_LOG2, MPFR_RNDN);
    w->trust_log2 = cns_log2_mpfr(w->delta) - TRUST_LOG2;
    w->found = cns_xalloc(room, sizeof *w->found);
    w->holds = cns_xalloc(room, sizeof *w->holds);
    w->differs = cns_xalloc(room, sizeof *w->differs);
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
    return CNS_OK;
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

/* Does observable i exceed delta in the samples? w->d is left as the absolute difference. */
static bool exceeds(walk *w, int i, mpfr_srcptr delta)
{
    if (i == CNS_TC_NORM) {
        distance(w);
        return mpfr_cmp(w->d, delta) > 0;
    }
    const bool state = i <= w->u1.n_states;
    const int k = state ? i - 1 : i - 1 - w->u1.n_states;
    mpfr_srcptr u1 = state ? w->u1.state[k] : w->u1.output[k], u2 = state ? w->u2.state[k] : w->u2.output[k];
    mpfr_sub(w->d, u1, u2, MPFR_RNDN);
    mpfr_abs(w->d, w->d, MPFR_RNDN);
    if (mpfr_nan_p(w->d)) { /* 0/0 in a derived quantity: undefined in both runs is the same */
        mpfr_set_zero(w->d, 1);
        return mpfr_nan_p(u1) != mpfr_nan_p(u2);
    }
    mpfr_mul(w->limit, delta, u2, MPFR_RNDN);
    return mpfr_cmpabs(w->d, w->limit) > 0; /* also where u2 = 0: anything but 0 is infinitely off */
}

static void peek(walk *w, const mpq_t t)
{
    cns_trajectory_peek(w->test, t, &w->u1);
    cns_trajectory_peek(w->reference, t, &w->u2);
}

/* It does not hold at `low` and does at `high`, both within the last steps: where it begins to. */
static double refine(walk *w, int i, double low, double high)
{
    while (high - low > w->resolution) {
        const double middle = low + (high - low) / 2;
        if (middle <= low || middle >= high)
            break;
        mpq_set_d(w->at, middle);
        peek(w, w->at);
        if (exceeds(w, i, w->delta))
            high = middle;
        else
            low = middle;
    }
    return high;
}

/* Looks at t, after `before`, both within the last steps of both runs. */
static void look(walk *w, double before, const mpq_t t)
{
    const double now = mpq_get_d(t);
    peek(w, t);
    for (int i = 0; i < w->n; i++)
        w->next[i] = exceeds(w, i, w->delta);
    for (int i = 0; i < w->n; i++) {
        if (!w->found[i] && w->next[i] && !w->holds[i])
            w->since[i] = refine(w, i, before, now);
        w->holds[i] = w->next[i];
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
            mpq_t inner;
            mpq_init(inner);
            mpq_set_d(inner, t);
            look(w, before, inner);
            mpq_clear(inner);
            before = t;
        }
        look(w, before, next);
        mpq_swap(w->now, next);
    }
    mpq_clear(next);
    return code;
}

/* Is any difference near delta? Of the samples at w->from. */
static bool gate_open(walk *w)
{
    for (int i = 0; i < w->n; i++)
        if (!w->found[i] && exceeds(w, i, w->gate))
            return true;
    return false;
}

/* The row at w->to, the samples being there. */
static void note_row(walk *w, cns_tc_result *r)
{
    const double t = mpq_get_d(w->to), half = cns_number_get_d(w->pair->end) / 2;
    for (int i = 0; i < w->n; i++) {
        const bool holds = exceeds(w, i, w->delta);
        w->differs[i] = w->differs[i] || holds || !mpfr_zero_p(w->d);
        if (i == CNS_TC_NORM)
            w->largest[t > half] = fmax(w->largest[t > half], cns_log2_mpfr(w->d));
        if (holds && !w->found[i]) {
            w->found[i] = true;
            w->missed[i] = isnan(w->since[i]) && mpq_sgn(w->to) > 0;
            r->time[i] = (cns_tc_time){CNS_TC_FOUND, isnan(w->since[i]) ? t : w->since[i], t};
        }
        w->holds[i] = holds;
        w->since[i] = NAN;
    }
    r->compared = t;
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

/* One pass from row to row. *row: in the end, the number of rows compared. */
static cns_code go(walk *w, cns_tc_result *r, unsigned long *row, cns_error *err)
{
    const double end = cns_number_get_d(w->pair->end);
    for (*row = 0; cns_row_time(w->pair->every, w->pair->end, *row, w->to); ++*row) {
        cns_code code = CNS_OK;
        const bool forced = w->forced && *row < w->n_forced && w->forced[*row];
        if (*row > 0 && (forced || gate_open(w)))
            code = look_through(w, err);
        if (!code) {
            code = cns_trajectory_at(w->test, w->to, &w->u1, err);
            if (code)
                return test_failed(code, err);
            code = cns_trajectory_at(w->reference, w->to, &w->u2, err);
        }
        if (code)
            return code;
        if (w->u2.error_log2 > w->trust_log2) {
            r->trusted = false;
            return cns_fail(err, CNS_UNREACHED,
                            "t = %.12g: the error of the reference may be 10^%.1f, not far enough below "
                            "delta: it needs more digits",
                            mpq_get_d(w->to), w->u2.error_log2 * CNS_LOG10_2);
        }
        note_row(w, r);
        if (enough(w)) {
            ++*row;
            break;
        }
        cns_monitor_tell(w->pair->monitor, mpq_get_d(w->to) / end, "the run under test and its reference");
        mpq_set(w->from, w->to);
    }
    return CNS_OK;
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

static cns_code pass(const cns_tc_pair *pair, const bool *forced, unsigned long n_forced, cns_tc_result *r,
                     bool *missed, unsigned long *rows, cns_error *err)
{
    walk w;
    cns_code code = walk_init(&w, pair, r->n, err);
    w.forced = forced;
    w.n_forced = n_forced;
    for (int i = 0; i < r->n; i++) {
        r->time[i] = (cns_tc_time){CNS_TC_BEYOND, 0, 0};
        w.since[i] = NAN;
    }
    r->trusted = true;
    r->compared = 0;
    if (!code)
        code = go(&w, r, rows, err);
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

/* The rows before which the pass should have looked; NULL: none. */
static bool *rows_missed(const cns_tc_pair *pair, const cns_tc_result *r, const bool *missed,
                         unsigned long rows)
{
    bool *forced = NULL;
    mpq_t t;
    mpq_init(t);
    for (int i = 0; i < r->n; i++)
        for (unsigned long row = 0; missed[i] && row < rows; row++)
            if (cns_row_time(pair->every, pair->end, row, t) && mpq_get_d(t) == r->time[i].row) {
                if (!forced)
                    forced = cns_xalloc(rows, sizeof *forced);
                forced[row] = true;
            }
    mpq_clear(t);
    return forced;
}

cns_code cns_tc_compare(const cns_tc_pair *pair, cns_tc_result *result, cns_error *err)
{
    const cns_program *p = pair->reference->flow.program;
    const bool outputs = pair->reference->outputs && pair->test->outputs;
    *result = (cns_tc_result){.n = 1 + cns_program_states(p) + (outputs ? cns_program_outputs(p) : 0)};
    result->time = cns_xalloc((size_t)result->n, sizeof *result->time);
    if (pair->reference->no_growth)
        return cns_fail(err, CNS_USAGE, "a reference whose growth is not followed cannot be trusted");
    bool *missed = cns_xalloc((size_t)result->n, sizeof *missed);
    unsigned long rows = 0;
    cns_code code = pass(pair, NULL, 0, result, missed, &rows, err);
    /* A difference that came from nowhere within one interval: again, with an eye on that interval. */
    bool *forced = !code || code == CNS_UNREACHED ? rows_missed(pair, result, missed, rows) : NULL;
    if (forced)
        code = pass(pair, forced, rows, result, missed, &rows, err);
    free(forced);
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
