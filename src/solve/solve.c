#include "cns/solve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arith/arith.h"
#include "core/clock.h"
#include "core/memory.h"
#include "num/decimal_text.h"
#include "num/logs.h"
#include "rows_ahead.h"
#include "solve_internal.h"

enum {
    /* The difference of the two runs may exceed noise times growth by this factor, 2^NOISE_SLACK: a step
     * rounds some hundred times, and not always gently. */
    NOISE_SLACK = 24,
    SEARCH = 60, /* decimals looked through for one that does not straddle */
    RAISES = 12,
    DOUBLE_PRINTED = 17 /* digits that tell doubles apart */
};

/* One or two trajectories walking from row to row. */
typedef struct walk {
    const cns_problem *p;
    cns_trajectory *fine;
    cns_ahead *coarse; /* NULL without a proof */
    cns_sample s;
    const cns_sample *c; /* the coarse run's */
    long digits;         /* printed without a proof: those of the arithmetic */
    bool explain;        /* compare the difference with noise times growth */
    mpq_t time;
    mpfr_t error, x;
    double error_log10; /* log10 of e, -HUGE_VAL: none */
    char **text;
} walk;

static void walk_clear(walk *w)
{
    cns_trajectory_free(w->fine);
    cns_ahead_free(w->coarse);
    cns_sample_clear(&w->s);
    mpq_clear(w->time);
    mpfr_clears(w->error, w->x, (mpfr_ptr)0);
    for (int i = 0; w->text && i < w->p->n_columns; i++)
        free(w->text[i]);
    free(w->text);
}

static cns_code walk_init(walk *w, const cns_problem *p, const cns_flow_spec *fine,
                          const cns_flow_spec *coarse, long digits, unsigned long first_row, double deadline,
                          cns_error *err)
{
    cns_trajectory_spec spec = {
        .flow = *fine, .initial = p->initial, .outputs = cns_wants_outputs(p), .deadline = deadline};
    *w = (walk){.p = p, .explain = coarse && coarse->method == CNS_METHOD_TAYLOR};
    mpq_init(w->time);
    mpfr_prec_t prec = fine->arithmetic == CNS_ARITH_DOUBLE ? 53 : fine->prec;
    mpfr_inits2(prec, w->error, w->x, (mpfr_ptr)0);
    w->digits = fine->arithmetic == CNS_ARITH_DOUBLE ? DOUBLE_PRINTED : digits;
    w->text = cns_xalloc((size_t)p->n_columns + 1, sizeof *w->text);
    spec.flow.verify = coarse != NULL;
    spec.no_growth = coarse != NULL; /* the coarser run's will do: it is the same trajectory */
    w->fine = cns_trajectory_new(&spec, err);
    if (!w->fine)
        return err->code;
    if (!cns_sample_init(&w->s, p->program, prec))
        return cns_fail(err, CNS_NUMERIC, "out of memory");
    if (!coarse)
        return CNS_OK;
    spec.flow = *coarse;
    spec.flow.verify = true;
    spec.no_growth = false;
    w->coarse = cns_ahead_new(p, &spec, first_row, p->threads > 1, err);
    return w->coarse ? CNS_OK : err->code;
}

/* Raises largest to |a - b| / scale. */
static void differ(mpfr_t largest, mpfr_srcptr a, mpfr_srcptr b, double scale)
{
    mpfr_t x;
    mpfr_init2(x, mpfr_get_prec(largest));
    mpfr_sub(x, a, b, MPFR_RNDA);
    mpfr_abs(x, x, MPFR_RNDN);
    if (scale != 1)
        mpfr_div_d(x, x, scale, MPFR_RNDU);
    if (mpfr_number_p(x) && mpfr_cmp(x, largest) > 0)
        mpfr_set(largest, x, MPFR_RNDN);
    mpfr_clear(x);
}

cns_code cns_proof_explained(const cns_problem *p, const cns_sample *fine, const cns_sample *coarse, double t,
                             cns_error *err)
{
    mpfr_t largest;
    mpfr_init2(largest, 64);
    mpfr_set_zero(largest, 1);
    for (int i = 0; i < fine->n_states; i++)
        if (cns_program_is_dynamic(p->program, i))
            differ(largest, fine->state[i], coarse->state[i], p->scales[i]);
    double noise = coarse->error_log2, difference = cns_log2_mpfr(largest);
    mpfr_clear(largest);
    if (noise == -HUGE_VAL || difference <= noise + NOISE_SLACK)
        return CNS_OK;
    return cns_fail(
        err, CNS_NUMERIC,
        "t = %.12g: the two runs of the proof differ by 10^%.1f, but noise has grown to 10^%.1f only: "
        "this is an error, not chaos",
        t, difference * CNS_LOG10_2, noise * CNS_LOG10_2);
}

/* Both runs to w->time; w->error becomes e. */
static cns_code walk_to(walk *w, cns_error *err)
{
    cns_code code = cns_trajectory_at(w->fine, w->time, &w->s, err);
    if (code || !w->coarse)
        return code;
    code = cns_ahead_next(w->coarse, &w->c, err);
    if (!code && w->explain)
        code = cns_proof_explained(w->p, &w->s, w->c, mpq_get_d(w->time), err);
    if (code)
        return code;
    double noise = w->c->error_log2;
    mpfr_set_zero(w->error, 1);
    for (int i = 0; i < w->s.n_states; i++)
        differ(w->error, w->s.state[i], w->c->state[i], 1);
    for (int i = 0; i < w->s.n_outputs && cns_wants_outputs(w->p); i++)
        differ(w->error, w->s.output[i], w->c->output[i], 1);
    if (w->explain && noise > cns_log2_mpfr(w->error)) { /* a difference can be small by accident */
        mpfr_set_d(w->x, noise, MPFR_RNDU);
        mpfr_exp2(w->error, w->x, MPFR_RNDU);
    }
    mpfr_mul_2ui(w->error, w->error, CNS_PROOF_SAFETY_LOG2, MPFR_RNDU);
    w->error_log10 = cns_log2_mpfr(w->error) * CNS_LOG10_2;
    return CNS_OK;
}

static mpfr_srcptr value(const walk *w, int column)
{
    const cns_column *c = &w->p->columns[column];
    return c->kind == CNS_COLUMN_STATE ? w->s.state[c->index] : w->s.output[c->index];
}

/* States at t = 0 are known exactly. Zero in both runs is an invariant line, and exact. */
static bool is_exact(const walk *w, int column)
{
    const cns_column *c = &w->p->columns[column];
    if (c->kind != CNS_COLUMN_STATE)
        return false;
    return mpq_sgn(w->time) == 0 ||
           (w->coarse && mpfr_zero_p(w->s.state[c->index]) && mpfr_zero_p(w->c->state[c->index]));
}

/* Are all values certain to so many places? */
static bool certain(const walk *w, cns_places places, long count)
{
    for (int i = 0; i < w->p->n_columns; i++)
        if (w->p->columns[i].kind != CNS_COLUMN_TIME && !is_exact(w, i) &&
            !cns_text_certain(value(w, i), w->error, places, count))
            return false;
    return true;
}

/* The largest number of places, at most `most`, to which all values are certain; -1 if there is none. */
static long proven_places(const walk *w, cns_places places, long most)
{
    const long least = places == CNS_PLACES_DECIMALS ? 0 : 1;
    if (places == CNS_PLACES_DECIMALS && w->error_log10 > -HUGE_VAL && -w->error_log10 < (double)most)
        most = (long)floor(-w->error_log10);
    for (long count = most, tries = 0; count >= least; count--, tries++) {
        if (certain(w, places, count))
            return count;
        if (places == CNS_PLACES_DECIMALS && tries > SEARCH)
            break;
    }
    return -1;
}

static void set_text(walk *w, int column, char *text)
{
    free(w->text[column]);
    w->text[column] = text;
}

/* The texts of a row; count < 0: no proof, all digits of the arithmetic. */
static void write_texts(walk *w, unsigned long row, cns_places places, long count)
{
    for (int i = 0; i < w->p->n_columns; i++) {
        const cns_column *c = &w->p->columns[i];
        if (c->kind == CNS_COLUMN_TIME) {
            bool multiple = true;
            mpq_t t;
            mpq_init(t);
            mpq_set_ui(t, row, 1);
            mpq_mul(t, t, w->p->every->ratio);
            multiple = mpq_equal(t, w->time) != 0;
            mpq_clear(t);
            char *text = multiple ? cns_number_multiple_text(w->p->every, row)
                                  : cns_number_multiple_text(w->p->end, 1);
            set_text(w, i, text ? text : cns_text_mpq(w->time, CNS_PLACES_DECIMALS, count > 6 ? count : 6));
        } else if (count < 0) {
            char *made;
            if (mpfr_asprintf(&made, "%.*Rg", (int)w->digits, value(w, i)) < 0)
                abort();
            set_text(w, i, cns_xcopy(mpfr_zero_p(value(w, i)) ? "0" : made));
            mpfr_free_str(made);
        } else if (c->kind == CNS_COLUMN_STATE && mpq_sgn(w->time) == 0) {
            set_text(w, i, cns_text_number(&w->p->initial[c->index], places, count));
        } else {
            set_text(w, i, cns_text_mpfr(value(w, i), places, count));
        }
    }
}

/* The decimals that so many significant digits are, the least over all values. */
static long as_decimals(const walk *w, cns_places places, long count)
{
    if (places == CNS_PLACES_DECIMALS || count < 0)
        return count;
    long least = -1;
    for (int i = 0; i < w->p->n_columns; i++) {
        if (w->p->columns[i].kind == CNS_COLUMN_TIME || !mpfr_regular_p(value(w, i)))
            continue;
        mpfr_t x;
        mpfr_init2(x, mpfr_get_prec(value(w, i)));
        mpfr_abs(x, value(w, i), MPFR_RNDN);
        long decimals = count - 1 - (long)floor(cns_log2_mpfr(x) * CNS_LOG10_2);
        mpfr_clear(x);
        if (least < 0 || decimals < least)
            least = decimals > 0 ? decimals : 0;
    }
    return least < 0 ? count : least;
}

static cns_code emit(walk *w, unsigned long row, cns_places places, long count, cns_result *result,
                     cns_error *err)
{
    const cns_sink *sink = w->p->sink;
    write_texts(w, row, places, count);
    cns_row out = {.text = w->text,
                   .decimals = as_decimals(w, places, count),
                   .growth = w->coarse ? w->c->growth : w->s.growth};
    if (w->coarse && (result->rows == 0 || out.decimals < result->decimals))
        result->decimals = out.decimals;
    result->rows++;
    result->end = mpq_get_d(w->time);
    return sink->row ? sink->row(sink->context, &out, err) : CNS_OK;
}

/* Precision that falls with time makes the first rows the dearest. */
static double work_done(const cns_run_info *run, double time)
{
    const double parts = time * CNS_PLAN_PARTS; /* time: a fraction of the whole */
    const int i = parts < CNS_PLAN_PARTS ? (int)parts : CNS_PLAN_PARTS - 1;
    if (!run->planned)
        return time;
    const double before = i > 0 ? run->done[i - 1] : 0;
    return before + (run->done[i] - before) * (parts - i);
}

static void progress(const walk *w, const cns_result *result, double since)
{
    const cns_sink *sink = w->p->sink;
    cns_progress out = {.run = &result->run,
                        .t = mpq_get_d(w->time),
                        .end = cns_number_get_d(w->p->end),
                        .seconds = cns_seconds() - since};
    out.fraction = work_done(&result->run, out.t / out.end);
    if (sink->progress)
        sink->progress(sink->context, &out);
}

static cns_code begin(const cns_problem *p, const cns_result *result, cns_error *err)
{
    return p->sink->begin ? p->sink->begin(p->sink->context, &result->run, err) : CNS_OK;
}

static void finish(walk *w, cns_result *result)
{
    if (w->fine) {
        result->steps = cns_flow_steps(cns_trajectory_flow(w->fine));
        result->events = cns_flow_landings(cns_trajectory_flow(w->fine));
    }
}

static cns_code describe(cns_run_info *info, long digits, const cns_flow_spec *fine,
                         const cns_flow_spec *coarse, cns_error *err)
{
    info->digits = digits;
    info->prec = fine->arithmetic == CNS_ARITH_DOUBLE ? 53 : fine->prec;
    info->order = fine->order;
    if (coarse) {
        info->proof_prec = coarse->arithmetic == CNS_ARITH_DOUBLE ? 53 : coarse->prec;
        info->proof_order = coarse->order;
    }
    const cns_arithmetic arithmetic = cns_arithmetic_for(fine->arithmetic, fine->order);
    info->kernel = arithmetic == CNS_ARITH_DOUBLE ? "double" : "mpfr";
    return arithmetic == CNS_ARITH_FAST ? cns_fast_kernel_name(&info->kernel, err) : CNS_OK;
}

/* One attempt at a goal from row *row on (rows before are final). Returns CNS_OK with *shortage > 0 when the
 * digits do not suffice at *row and may be raised. last: they may not; tie: row *row may have fewer places.
 */
static cns_code attempt(const cns_problem *p, const cns_goal *goal, const cns_schedule *schedule, bool last,
                        bool tie, double deadline, unsigned long *row, double *shortage, cns_result *result,
                        cns_error *err)
{
    const unsigned long short_row = *row;
    cns_flow_spec fine, coarse;
    walk w;
    double since = cns_seconds();
    const long coarse_digits = result->run.digits - CNS_PROOF_DIGITS;
    cns_proof_specs(p, result->run.digits, schedule, coarse_digits - schedule->digits[0], &fine, &coarse);
    *shortage = 0;
    cns_code code = describe(&result->run, result->run.digits, &fine, &coarse, err);
    if (code)
        return code;
    code = walk_init(&w, p, &fine, &coarse, result->run.digits, *row, deadline, err);
    if (!code)
        code = begin(p, result, err);
    while (!code && cns_row_time(p, *row, w.time)) {
        code = walk_to(&w, err);
        if (code)
            break;
        long places = proven_places(&w, goal->places, goal->count);
        if (places < goal->count && !last && !(tie && *row == short_row)) {
            double have = goal->places == CNS_PLACES_DECIMALS ? -w.error_log10
                          : places < 0                        ? 0
                                                              : (double)places;
            *shortage = fmax(1, (double)goal->count - have);
            break;
        }
        if (places < 0) {
            code = cns_fail(err, CNS_UNREACHED, "no decimal can be proven from t = %.12g on with %ld digits",
                            mpq_get_d(w.time), result->run.digits);
            break;
        }
        result->reached = result->reached && places >= goal->count;
        code = emit(&w, *row, goal->places, places, result, err);
        ++*row;
        progress(&w, result, since);
    }
    if (code == CNS_STOPPED && (cns_trajectory_late(w.fine) || (w.coarse && cns_ahead_late(w.coarse))))
        code = cns_fail(err, CNS_UNREACHED, "max_time is used up at t = %.12g", mpq_get_d(w.time));
    finish(&w, result);
    walk_clear(&w);
    return code;
}

cns_code cns_solve_goal(const cns_problem *p, const cns_goal *goal, cns_result *result, cns_error *err)
{
    double since = cns_seconds(), deadline = goal->max_time > 0 ? since + goal->max_time : 0, shortage = 0;
    unsigned long row = 0, short_row = 0;
    int stuck = 0;
    bool doubted = false;
    long digits[CNS_PLAN_PARTS];
    cns_schedule schedule = {.digits = digits};
    *result = (cns_result){.decimals = -1, .reached = true};
    cns_code code = cns_plan(p, goal, &result->run, &schedule, err);
    while (!code) {
        bool last = result->run.digits >= goal->max_digits || result->run.attempt > RAISES;
        if (result->run.digits > goal->max_digits)
            result->run.digits =
                goal->max_digits > CNS_PROOF_DIGITS + 4 ? goal->max_digits : CNS_PROOF_DIGITS + 4;
        result->run.proof_digits = result->run.digits - CNS_PROOF_DIGITS;
        code = attempt(p, goal, &schedule, last, stuck >= 2, deadline, &row, &shortage, result, err);
        if (code == CNS_NUMERIC && !doubted && !last) {
            /* Digits lost in the problem itself can look like an error, or like a singularity: ask again with
             * more before saying so. */
            doubted = true;
            code = CNS_OK;
            shortage = 10 + (double)result->run.digits / 2;
        }
        if (code || shortage <= 0) {
            result->complete = !code;
            break;
        }
        /* A raise makes up for what was short, and more: a row that is short still has a value that
         * straddles, a tie or a zero. Two raises decide that, and it gets fewer places. */
        stuck = row == short_row && result->run.attempt > 1 ? stuck + 1 : 0;
        short_row = row;
        result->run.planned = false;
        result->run.attempt++;
        result->run.digits += (long)ceil(1.2 * shortage) + 6 + result->run.digits / 30;
    }
    result->wall_s = cns_seconds() - since;
    if (!code && !result->reached)
        code = cns_fail(err, CNS_UNREACHED, "some rows have fewer than the %ld %s asked for", goal->count,
                        goal->places == CNS_PLACES_DECIMALS ? "decimals" : "significant digits");
    return code;
}

cns_code cns_solve_numerics(const cns_problem *p, const cns_numerics *n, bool prove, cns_result *result,
                            cns_error *err)
{
    double since = cns_seconds();
    cns_flow_spec given = cns_given_spec(p, n), fine;
    cns_number half_step;
    walk w;
    *result = (cns_result){.decimals = -1, .run = {.attempt = 1}};

    /* The finer run of a proof: more digits; a Taylor run also another order and smaller steps, a
     * Runge-Kutta run half the step. */
    fine = given;
    cns_number_init(&half_step);
    long fine_digits = n->digits;
    if (prove) {
        fine_digits = (n->digits > 0 ? n->digits : 16) + CNS_PROOF_DIGITS;
        fine.arithmetic =
            n->method == CNS_METHOD_RK4 || n->arithmetic == CNS_ARITH_MPFR ? CNS_ARITH_MPFR : CNS_ARITH_FAST;
        fine.prec = cns_digits_to_bits(fine_digits);
        if (n->fixed_step) {
            cns_number_set(&half_step, &n->step);
            mpq_div_2exp(half_step.ratio, half_step.ratio, 1);
            fine.step = &half_step;
        }
        fine.tolerance_log2 -= CNS_PROOF_DIGITS * CNS_LOG2_10;
        fine.safety = CNS_FINE_SAFETY;
        if (n->method == CNS_METHOD_TAYLOR)
            fine.order = n->order > 0 ? given.order + given.order / 8 + 2
                                      : cns_order_for(fine.tolerance_log2, fine.arithmetic);
        result->run.proof_digits = n->digits > 0 ? n->digits : 16;
    }
    cns_code code = describe(&result->run, fine_digits, &fine, prove ? &given : NULL, err);
    if (code) {
        cns_number_clear(&half_step);
        return code;
    }
    code = walk_init(&w, p, &fine, prove ? &given : NULL, fine_digits, 0, 0, err);
    if (!code)
        code = begin(p, result, err);
    for (unsigned long row = 0; !code && cns_row_time(p, row, w.time); row++) {
        long places = -1;
        code = walk_to(&w, err);
        if (code)
            break;
        if (prove) {
            places = proven_places(&w, CNS_PLACES_DECIMALS, n->digits > 0 ? n->digits : 16);
            if (places < 0) {
                code = cns_fail(err, CNS_UNREACHED, "no decimal can be proven from t = %.12g on",
                                mpq_get_d(w.time));
                break;
            }
        }
        code = emit(&w, row, CNS_PLACES_DECIMALS, places, result, err);
        progress(&w, result, since);
    }
    finish(&w, result);
    walk_clear(&w);
    cns_number_clear(&half_step);
    result->complete = !code;
    result->wall_s = cns_seconds() - since;
    return code;
}
