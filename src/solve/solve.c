#include "cns/solve.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arith/fast.h"
#include "core/clock.h"
#include "core/memory.h"
#include "core/monitor.h"
#include "integrate/numerics.h"
#include "integrate/rows.h"
#include "num/decimal_text.h"
#include "num/logs.h"
#include "proof.h"
#include "rows_ahead.h"
#include "solve_internal.h"

enum {
    RAISES = 12,
    DOUBLE_PRINTED = 17, /* digits that tell doubles apart */
    ERROR_BITS = 64      /* of e, a bound that is rounded up */
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
    mpfr_t error; /* e */
    char **text;
    cns_bounded *value; /* scratch, of columns */
} walk;

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
    /* The noise of a method that does not estimate its truncation is no bound. */
    const double noise = w->explain ? w->c->error_log2 : -HUGE_VAL;
    mpfr_set_zero(w->error, 1);
    for (int i = 0; i < w->s.n_states; i++)
        cns_proof_error(w->error, w->s.state[i], w->c->state[i], noise);
    for (int i = 0; i < w->s.n_outputs && cns_wants_outputs(w->p); i++)
        cns_proof_error(w->error, w->s.output[i], w->c->output[i], noise);
    return CNS_OK;
}

static mpfr_srcptr value(const walk *w, int column)
{
    const cns_column c = cns_column_at(w->p, column);
    return c.kind == CNS_COLUMN_STATE ? w->s.state[c.index] : w->s.output[c.index];
}

/* States at t = 0 are known exactly. Zero in both runs is an invariant line, and exact. */
static bool is_exact(const walk *w, int column)
{
    const cns_column c = cns_column_at(w->p, column);
    if (c.kind != CNS_COLUMN_STATE)
        return false;
    return mpq_sgn(w->time) == 0 ||
           (w->coarse && mpfr_zero_p(w->s.state[c.index]) && mpfr_zero_p(w->c->state[c.index]));
}

/* The places, at most `most`, to which all values of the row are certain; -1: none. */
static long proven_places(const walk *w, cns_places places, long most)
{
    int n = 0;
    for (int i = 0; i < cns_columns(w->p); i++)
        if (cns_column_at(w->p, i).kind != CNS_COLUMN_TIME && !is_exact(w, i))
            w->value[n++] = (cns_bounded){value(w, i), w->error};
    return cns_proof_places(w->value, n, places, most);
}

static void set_text(walk *w, int column, char *text)
{
    free(w->text[column]);
    w->text[column] = text;
}

/* The texts of a row; count < 0: no proof, all digits of the arithmetic. */
static void write_texts(walk *w, unsigned long row, cns_places places, long count)
{
    for (int i = 0; i < cns_columns(w->p); i++) {
        const cns_column c = cns_column_at(w->p, i);
        if (c.kind == CNS_COLUMN_TIME) {
            set_text(w, i, cns_row_time_text(cns_every(w->p), w->p->end, row, count));
        } else if (count < 0) {
            set_text(w, i, cns_text_digits(value(w, i), w->digits));
        } else if (c.kind == CNS_COLUMN_STATE && mpq_sgn(w->time) == 0) {
            set_text(w, i, cns_text_number(&cns_system_initial(w->p->system)[c.index], places, count));
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
    for (int i = 0; i < cns_columns(w->p); i++) {
        if (cns_column_at(w->p, i).kind == CNS_COLUMN_TIME || !mpfr_regular_p(value(w, i)))
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
    return sink && sink->row ? sink->row(sink->context, &out, err) : CNS_OK;
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

static void progress(const walk *w, const cns_result *result)
{
    const double t = mpq_get_d(w->time), end = cns_number_get_d(w->p->end);
    char what[128];
    snprintf(what, sizeof what, "t = %g of %g, %ld digits", t, end, result->run.digits);
    cns_monitor_tell(w->p->monitor, work_done(&result->run, t / end), what);
}

static void describe(cns_run_info *info, const cns_proof_runs *runs)
{
    info->digits = runs->fine_digits;
    info->prec = runs->fine.prec;
    info->order = runs->fine.order;
    info->proof_digits = runs->coarse_digits;
    info->proof_prec = runs->coarse.prec;
    info->proof_order = runs->coarse.order;
    const cns_arithmetic arithmetic = cns_arithmetic_for(runs->fine.arithmetic, runs->fine.order);
    info->kernel = arithmetic == CNS_ARITH_FAST     ? cns_fast_kernel_name()
                   : arithmetic == CNS_ARITH_DOUBLE ? "double"
                                                    : "mpfr";
}

/* To be closed whatever is returned. */
static cns_code walk_open(walk *w, const cns_problem *p, const cns_proof_runs *runs, unsigned long first_row,
                          double deadline, cns_result *result, cns_error *err)
{
    cns_trajectory_spec spec = {.flow = runs->fine,
                                .initial = cns_system_initial(p->system),
                                .outputs = cns_wants_outputs(p),
                                .no_growth =
                                    runs->proof, /* the coarser run's will do: it is the same trajectory */
                                .deadline = deadline};
    *w = (walk){.p = p,
                .explain = runs->proof && runs->coarse.method == CNS_METHOD_TAYLOR,
                .digits = runs->fine.arithmetic == CNS_ARITH_DOUBLE ? DOUBLE_PRINTED : runs->fine_digits};
    mpq_init(w->time);
    mpfr_init2(w->error, ERROR_BITS);
    w->text = cns_xalloc((size_t)cns_columns(p) + 1, sizeof *w->text);
    w->value = cns_xalloc((size_t)cns_columns(p) + 1, sizeof *w->value);
    describe(&result->run, runs);
    w->fine = cns_trajectory_new(&spec, err);
    if (!w->fine)
        return err->code;
    if (!cns_sample_init(&w->s, cns_system_program(p->system), runs->fine.prec))
        return cns_fail(err, CNS_NUMERIC, "out of memory");
    if (runs->proof) {
        spec.flow = runs->coarse;
        spec.no_growth = false;
        w->coarse = cns_ahead_new(p, &spec, first_row, cns_monitor_threads(p->monitor) > 1, err);
        if (!w->coarse)
            return err->code;
    }
    return p->sink && p->sink->begin ? p->sink->begin(p->sink->context, &result->run, err) : CNS_OK;
}

static void walk_close(walk *w, cns_result *result)
{
    if (w->fine) {
        result->steps = cns_flow_steps(cns_trajectory_flow(w->fine));
        result->landings = cns_flow_landings(cns_trajectory_flow(w->fine));
    }
    cns_trajectory_free(w->fine);
    cns_ahead_free(w->coarse);
    cns_sample_clear(&w->s);
    mpq_clear(w->time);
    mpfr_clear(w->error);
    for (int i = 0; i < cns_columns(w->p); i++)
        free(w->text[i]);
    free(w->text);
    free(w->value);
}

/* One attempt at a goal from row *row on (rows before are final). Returns CNS_OK with *shortage > 0 when the
 * digits do not suffice at *row and may be raised. last: they may not; tie: row *row may have fewer places.
 */
static cns_code attempt(const cns_problem *p, const cns_goal *goal, const cns_schedule *schedule, bool last,
                        bool tie, double deadline, unsigned long *row, double *shortage, cns_result *result,
                        cns_error *err)
{
    const unsigned long short_row = *row;
    cns_proof_runs runs;
    walk w;
    cns_proof_of_goal(&runs, p, result->run.digits, schedule);
    *shortage = 0;
    cns_code code = walk_open(&w, p, &runs, *row, deadline, result, err);
    while (!code && cns_row_time(cns_every(p), p->end, *row, w.time)) {
        code = walk_to(&w, err);
        if (code)
            break;
        long places = proven_places(&w, goal->places, goal->count);
        if (places < goal->count && !last && !(tie && *row == short_row)) {
            double have = goal->places == CNS_PLACES_DECIMALS ? -cns_log2_mpfr(w.error) * CNS_LOG10_2
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
        progress(&w, result);
    }
    if (code == CNS_STOPPED && (cns_trajectory_late(w.fine) || cns_ahead_late(w.coarse)))
        code = cns_fail(err, CNS_UNREACHED, "max_time is used up at t = %.12g", mpq_get_d(w.time));
    walk_close(&w, result);
    cns_proof_runs_clear(&runs);
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
        const long most = goal->max_digits > 0 ? goal->max_digits : LONG_MAX;
        bool last = result->run.digits >= most || result->run.attempt > RAISES;
        if (result->run.digits > most)
            result->run.digits = most > CNS_ANOTHER_LIMB + 4 ? most : CNS_ANOTHER_LIMB + 4;
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
    cns_proof_runs runs;
    walk w;
    *result = (cns_result){.decimals = -1, .run = {.attempt = 1}};
    cns_proof_of_numerics(&runs, p, n, prove);
    cns_code code = walk_open(&w, p, &runs, 0, 0, result, err);
    for (unsigned long row = 0; !code && cns_row_time(cns_every(p), p->end, row, w.time); row++) {
        long places = -1;
        code = walk_to(&w, err);
        if (code)
            break;
        if (prove) {
            places = proven_places(&w, CNS_PLACES_DECIMALS, runs.coarse_digits);
            if (places < 0) {
                code = cns_fail(err, CNS_UNREACHED, "no decimal can be proven from t = %.12g on",
                                mpq_get_d(w.time));
                break;
            }
        }
        code = emit(&w, row, CNS_PLACES_DECIMALS, places, result, err);
        progress(&w, result);
    }
    walk_close(&w, result);
    cns_proof_runs_clear(&runs);
    result->complete = !code;
    result->wall_s = cns_seconds() - since;
    return code;
}
