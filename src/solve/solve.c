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
#include "cost.h"
#include "events.h"
#include "integrate/numerics.h"
#include "integrate/rows.h"
#include "num/decimal_text.h"
#include "num/logs.h"
#include "num/vector.h"
#include "problem.h"
#include "proof.h"
#include "rows_ahead.h"

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
    mpq_t time;          /* passed since the start */
    mpq_t now;           /* scratch: the time itself */
    cns_time_form times;
    bool unbounded;       /* the enclosure has ended in a derived quantity */
    bool enclosed, proof; /* by an enclosure; by that or by the coarser run */
    mpfr_t *error;        /* per column, and the largest: e */
    char **text;
    cns_bounded *value;           /* scratch, of columns */
    bool *constant, *zero_output; /* what never changes (cns/system.h) */
    long *own;                    /* per column at a tie: its places, in this row; -1: it has the row's */
    bool *own_decimals;           /* and whether they are decimals though the goal counts digits */
    cns_found_list found, found_again; /* events not told yet: of the printed run, of the other */
    mpfr_t *told_until;                /* per condition: the end of what the time of its last event may be */
    mpq_t before;                      /* the last row's time */
    long told;                         /* events */
} walk;

/* A row, or an event found on the way to it: its number, from 0; -1: the row itself. */
typedef struct item {
    unsigned long row;
    long event;
} item;

/* What rows and events are to have, and what has fewer places. */
typedef struct demand {
    cns_places places;
    long count;                /* of the goal, or the most that is looked for */
    bool raise;                /* with fewer the walk ends: another one follows, with more digits */
    unsigned long row;         /* the next; those before are final */
    long passed;               /* events before this one have been told, by this or an earlier attempt */
    item last, now;            /* where the attempt before ended like that; where this one has */
    bool excused;              /* `last` gets fewer: more digits have not helped */
    double missing;            /* places, at `now`; 0: nothing */
    bool few_rows, few_events; /* some have been told with fewer */
    bool *tied;                /* columns that have been at a tie once: more digits do not help them */
    bool few_beside;           /* and not for a tie alone */
    int tie;                   /* the last that got fewer places for that; -1: none, -2: others did, too */
    double tie_time;
} demand;

static bool is_exact(const walk *w, int column);

/* e of an enclosure: of each column its own. CNS_NUMERIC: a derived quantity has none. */
static cns_code take_errors(walk *w, cns_error *err)
{
    cns_code code = CNS_OK;
    const int columns = cns_columns(w->p);
    arf_t y;
    arf_init(y);
    mpfr_set_zero(w->error[columns], 1);
    for (int i = 0; i < columns; i++) {
        const cns_column c = cns_column_at(w->p, i);
        mpfr_set_zero(w->error[i], 1);
        if (c.kind == CNS_COLUMN_TIME || is_exact(w, i))
            continue;
        arf_set_mag(y, (c.kind == CNS_COLUMN_STATE ? w->s.state_error : w->s.output_error) + c.index);
        arf_get_mpfr(w->error[i], y, MPFR_RNDU);
        mpfr_max(w->error[columns], w->error[columns], w->error[i], MPFR_RNDN);
        if (mpfr_number_p(w->error[i]))
            continue;
        w->unbounded = true;
        code = cns_fail(err, CNS_NUMERIC, "no bound of the error of %s at t = %.12g",
                        cns_system_model(w->p->system)->outputs[c.index].name, mpq_get_d(w->time));
    }
    arf_clear(y);
    return code;
}

/* What is zero for ever, by the equations. */
static void set_zeros(walk *w)
{
    for (int i = 0; i < w->s.n_states; i++)
        if (w->constant[i] && cns_number_sign(&cns_system_initial(w->p->system)[i]) == 0)
            mpfr_set_zero(w->s.state[i], 1);
    for (int i = 0; i < w->s.n_outputs; i++)
        if (w->zero_output[i])
            mpfr_set_zero(w->s.output[i], 1);
}

/* The runs to w->time; w->error becomes e. */
static cns_code walk_to(walk *w, cns_error *err)
{
    cns_code code = cns_trajectory_at(w->fine, w->time, &w->s, err);
    if (code || !w->proof)
        return code;
    if (w->enclosed) {
        set_zeros(w);
        return take_errors(w, err);
    }
    code = cns_ahead_next(w->coarse, &w->c, &w->found_again, err);
    if (!code && w->explain)
        code = cns_proof_explained(w->p, &w->s, w->c, cns_problem_time(w->p, w->time), err);
    if (code)
        return code;
    const double noise = w->c->error_log2;
    mpfr_ptr e = w->error[cns_columns(w->p)];
    set_zeros(w);
    mpfr_set_zero(e, 1);
    for (int i = 0; i < w->s.n_states; i++)
        cns_proof_error(e, w->s.state[i], w->c->state[i], noise);
    for (int i = 0; i < w->s.n_outputs && cns_wants_outputs(w->p); i++)
        cns_proof_error(e, w->s.output[i], w->c->output[i], noise);
    for (int i = 0; i < cns_columns(w->p); i++)
        mpfr_set(w->error[i], e, MPFR_RNDU);
    return CNS_OK;
}

static mpfr_srcptr value(const walk *w, int column)
{
    const cns_column c = cns_column_at(w->p, column);
    return c.kind == CNS_COLUMN_STATE ? w->s.state[c.index] : w->s.output[c.index];
}

/* States at t = 0 are known exactly, and so is what never changes. Zero in both runs is an invariant line,
 * and exact. */
static bool is_exact(const walk *w, int column)
{
    const cns_column c = cns_column_at(w->p, column);
    if (c.kind != CNS_COLUMN_STATE)
        return w->proof && w->zero_output[c.index];
    return mpq_sgn(w->time) == 0 || (w->proof && w->constant[c.index]) ||
           (w->coarse && mpfr_zero_p(w->s.state[c.index]) && mpfr_zero_p(w->c->state[c.index]));
}

/* Does e leave room for a hundred times the places asked for? Then a text is not certain because the value is
 * next to a tie of rounding, or to zero, which has no significant digits. */
static bool has_room(const walk *w, int column, cns_places places, long most)
{
    const double error = cns_log2_mpfr(w->error[column]) * CNS_LOG10_2, spare = 2;
    double have = -error;
    if (places == CNS_PLACES_SIGNIFICANT && mpfr_cmpabs(value(w, column), w->error[column]) > 0) {
        mpfr_t x;
        mpfr_init2(x, ERROR_BITS);
        mpfr_abs(x, value(w, column), MPFR_RNDN);
        have += cns_log2_mpfr(x) * CNS_LOG10_2;
        mpfr_clear(x);
    }
    return have >= (double)most + spare;
}

/* The places, at most `most`, to which all values of the row are certain; -1: none. Columns at a tie have
 * their own; *tie is the first of them, or one that has not been tied before; -1: there is none. */
static long proven_places(walk *w, demand *d, long most, int *tie)
{
    int n = 0;
    *tie = -1;
    for (int i = 0; i < cns_columns(w->p); i++) {
        w->own[i] = -1;
        if (cns_column_at(w->p, i).kind == CNS_COLUMN_TIME || is_exact(w, i))
            continue;
        w->value[n] = (cns_bounded){value(w, i), w->error[i]};
        if (d->tied == NULL || cns_text_certain(value(w, i), w->error[i], d->places, most) ||
            !has_room(w, i, d->places, most)) {
            n++;
            continue;
        }
        w->own[i] = cns_proof_places(&w->value[n], 1, d->places, most);
        w->own_decimals[i] = d->places == CNS_PLACES_DECIMALS || w->own[i] < 0;
        if (w->own[i] < 0)
            w->own[i] = cns_proof_places(&w->value[n], 1, CNS_PLACES_DECIMALS, most);
        n += w->own[i] < 0;
        if (w->own[i] >= 0 && (*tie < 0 || !d->tied[i]))
            *tie = i;
    }
    return cns_proof_places(w->value, n, d->places, most);
}

/* A column at a tie gets one more attempt, with more digits, and then the places that it has. */
static bool is_fresh_tie(const walk *w, demand *d)
{
    bool fresh = false;
    for (int i = 0; i < cns_columns(w->p); i++) {
        if (w->own[i] < 0)
            continue;
        fresh = fresh || !d->tied[i];
        d->tied[i] = true;
        d->tie = d->tie == -1 || d->tie == i ? i : -2;
        d->tie_time = cns_problem_time(w->p, w->time);
    }
    return fresh;
}

static void set_text(walk *w, int column, char *text)
{
    free(w->text[column]);
    w->text[column] = text;
}

/* The texts of a row; count < 0: no proof, all digits of the arithmetic. */
static void write_texts(walk *w, cns_places places, long count)
{
    for (int i = 0; i < cns_columns(w->p); i++) {
        const cns_column c = cns_column_at(w->p, i);
        if (c.kind == CNS_COLUMN_TIME) {
            cns_system_time(w->p->system, w->now, w->time);
            set_text(w, i, cns_time_text(&w->times, w->now));
        } else if (count < 0) {
            set_text(w, i, cns_text_digits(value(w, i), w->digits));
        } else if (w->own[i] >= 0) {
            set_text(
                w, i,
                cns_text_mpfr(value(w, i), w->own_decimals[i] ? CNS_PLACES_DECIMALS : places, w->own[i]));
        } else if (c.kind == CNS_COLUMN_STATE && (mpq_sgn(w->time) == 0 || w->constant[c.index])) {
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

static cns_code emit(walk *w, cns_places places, long count, cns_result *result, cns_error *err)
{
    const cns_sink *sink = w->p->sink;
    write_texts(w, places, count);
    cns_row out = {.text = w->text,
                   .decimals = as_decimals(w, places, count),
                   .growth = w->coarse ? w->c->growth : w->s.growth};
    for (int i = 0; i < cns_columns(w->p) && w->proof; i++) {
        if (w->own[i] < 0)
            continue;
        const long own = w->own_decimals[i] ? w->own[i] : as_decimals(w, places, w->own[i]);
        out.decimals = own < out.decimals ? own : out.decimals;
    }
    if (w->proof && (result->rows == 0 || out.decimals < result->decimals))
        result->decimals = out.decimals;
    result->rows++;
    result->end = cns_problem_time(w->p, w->time);
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
    char what[128];
    snprintf(what, sizeof what, "t = %g of %g, %ld digits", cns_problem_time(w->p, w->time),
             cns_problem_time(w->p, w->p->end->ratio), result->run.digits);
    cns_monitor_tell(w->p->monitor, work_done(&result->run, mpq_get_d(w->time) / cns_number_get_d(w->p->end)),
                     what);
}

static void describe(cns_run_info *info, const cns_proof_runs *runs)
{
    info->digits = runs->fine_digits;
    info->prec = runs->fine.prec;
    info->order = runs->fine.order;
    info->enclosed = runs->enclosed;
    info->proof_digits = runs->coarse_digits;
    info->proof_prec = runs->coarse.prec;
    info->proof_order = runs->coarse.order;
    const cns_arithmetic arithmetic = cns_arithmetic_for(runs->fine.arithmetic, runs->fine.order);
    info->kernel = arithmetic == CNS_ARITH_FAST     ? cns_fast_kernel_name()
                   : arithmetic == CNS_ARITH_DOUBLE ? "double"
                                                    : "mpfr";
}

static void set_time_form(walk *w)
{
    const cns_problem *p = w->p;
    const mpq_srcptr start = cns_system_start(p->system)->ratio;
    cns_time_form_init(&w->times);
    cns_system_time(p->system, w->now, p->end->ratio);
    cns_time_form_add(&w->times, w->now);
    for (int i = 0; p->at != NULL && i < p->n_at; i++) {
        cns_system_time(p->system, w->now, p->at[i].ratio);
        cns_time_form_add(&w->times, w->now);
    }
    if (p->at == NULL && cns_number_cmp(cns_every(p), p->end) < 0)
        cns_time_form_add_grid(&w->times, start, cns_every(p)->ratio);
    else if (p->at == NULL)
        cns_time_form_add(&w->times, start);
}

/* To be closed whatever is returned. */
static cns_code walk_open(walk *w, const cns_problem *p, const cns_proof_runs *runs, unsigned long first_row,
                          double since, double max_time, cns_result *result, cns_error *err)
{
    cns_trajectory_spec spec = {.flow = runs->fine,
                                .initial = cns_system_initial(p->system),
                                .outputs = cns_wants_outputs(p),
                                .tube = runs->enclosed,
                                .no_growth =
                                    runs->proof || runs->enclosed, /* the coarser run or the tube tells */
                                .conditions = p->conditions,
                                .n_conditions = p->n_conditions,
                                .met = cns_found_add,
                                .met_context = &w->found,
                                .end = cns_number_get_d(p->end),
                                .most_steps = cns_most_steps(p, max_time),
                                .deadline = max_time > 0 ? since + max_time : 0};
    *w = (walk){.p = p,
                .enclosed = runs->enclosed,
                .proof = runs->enclosed || runs->proof,
                .explain = runs->proof && runs->coarse.method == CNS_METHOD_TAYLOR,
                .digits = runs->fine.arithmetic == CNS_ARITH_DOUBLE ? DOUBLE_PRINTED : runs->fine_digits};
    mpq_inits(w->time, w->now, w->before, (mpq_ptr)0);
    set_time_form(w);
    w->error = cns_vector_xnew(cns_columns(p) + 1, ERROR_BITS);
    w->found.n_states = cns_program_states(cns_system_program(p->system));
    result->events_end = (cns_error){0};
    w->text = cns_xalloc((size_t)cns_columns(p) + 1, sizeof *w->text);
    w->value = cns_xalloc((size_t)cns_columns(p) + 1, sizeof *w->value);
    w->own = cns_xalloc((size_t)cns_columns(p) + 1, sizeof *w->own);
    w->own_decimals = cns_xalloc((size_t)cns_columns(p) + 1, sizeof *w->own_decimals);
    w->told_until = cns_vector_xnew(p->n_conditions, ERROR_BITS); /* the start: nothing at t = 0 counts */
    w->constant = cns_xalloc((size_t)w->found.n_states + 1, sizeof *w->constant);
    w->zero_output = cns_xalloc((size_t)cns_system_model(p->system)->n_outputs + 1, sizeof *w->zero_output);
    describe(&result->run, runs);
    w->fine = cns_trajectory_new(&spec, err);
    if (!w->fine)
        return err->code;
    if (!cns_sample_init(&w->s, cns_system_program(p->system), runs->fine.prec))
        return cns_out_of_memory(err);
    if (runs->enclosed)
        cns_sample_want_errors(&w->s);
    if (w->proof) {
        const cns_code code = cns_system_constants(p->system, w->constant, w->zero_output, err);
        if (code)
            return code;
    }
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
    cns_found_clear(&w->found);
    cns_found_clear(&w->found_again);
    mpq_clears(w->time, w->now, w->before, (mpq_ptr)0);
    cns_time_form_clear(&w->times);
    cns_vector_free(w->error);
    for (int i = 0; i < cns_columns(w->p); i++)
        free(w->text[i]);
    free(w->text);
    free(w->value);
    cns_vector_free(w->told_until);
    free(w->own);
    free(w->own_decimals);
    free(w->constant);
    free(w->zero_output);
}

/* An item has fewer places than asked for, by so many. Does the walk end there? */
static bool falls_short(demand *d, item at, double missing)
{
    const bool again = d->last.row == at.row && d->last.event == at.event;
    if (!d->raise || (at.event >= 0 && at.event < d->passed) || (d->excused && again))
        return false;
    d->now = at;
    d->missing = fmax(1, missing);
    return true;
}

/* Places that are missing, from those found (-1: none) and the error's bound. */
static double missing_places(const demand *d, long found, double error_log10)
{
    const double have = d->places == CNS_PLACES_DECIMALS && isfinite(error_log10) ? -error_log10
                        : found > 0                                               ? (double)found
                                                                                  : 0;
    return (double)d->count - have;
}

/* The places of the event f, by what the coarser run says of it (cns_event_places). An event that may lie at
 * the start, where nothing counts, or may be the one told before it, may be none: -1. until: the latest time
 * that its own error allows. */
static long event_places(const walk *w, const demand *d, const cns_found *f, const cns_found *again,
                         double *error_log10, mpfr_t until)
{
    mpfr_t error, since;
    mpfr_inits2(ERROR_BITS, error, since, (mpfr_ptr)0);
    long places = cns_event_places(w->p, f, again, w->constant, d->places, d->count, error_log10, error);
    if (places >= 0) {
        mpfr_sub(since, f->m.time, error, MPFR_RNDD);
        mpfr_add(until, f->m.time, error, MPFR_RNDU);
        if (mpfr_lessequal_p(since, w->told_until[f->m.condition])) {
            places = -1;
            *error_log10 = HUGE_VAL;
        }
    }
    mpfr_clears(error, since, (mpfr_ptr)0);
    return places;
}

/* The first of the events that are not told yet, if it is proven, with *until as above; false: it waits,
 * falls short, or ends them. */
static bool prove_event(walk *w, demand *d, long *places, mpfr_t until, cns_result *result)
{
    const cns_found *f = &w->found.at[w->found.first];
    const int partner = w->enclosed ? -1 : cns_event_partner(&w->found, &w->found_again);
    double error_log10 = HUGE_VAL;
    *places = -1;
    if (partner >= 0 || w->enclosed)
        *places =
            event_places(w, d, f, w->enclosed ? NULL : &w->found_again.at[partner], &error_log10, until);
    else if (!mpq_equal(w->time, w->p->end->ratio) && mpfr_cmp_q(f->m.time, w->before) > 0)
        return false; /* the coarser run may meet it just behind the row */
    /* A touch moves by the root of the noise: it takes two digits for each. */
    const double missing = missing_places(d, *places, error_log10) * (f->m.direction == 0 ? 2 : 1);
    if (*places < d->count && falls_short(d, (item){d->row, w->told}, missing))
        return false;
    d->few_events = d->few_events || *places < d->count;
    if (*places < 0) {
        cns_fail(&result->events_end, CNS_UNREACHED,
                 "%s the event at t = %.12g, or it cannot be told from the start or the event before",
                 w->enclosed ? "nothing is proven of" : "the two runs do not agree on",
                 cns_program_time(cns_system_program(w->p->system), mpfr_get_d(f->m.time, MPFR_RNDN)));
        return false;
    }
    if (!w->enclosed)
        cns_found_drop(&w->found_again, partner);
    return true;
}

/* Tells the events up to the row that is reached, in order. */
static cns_code tell_events(walk *w, demand *d, cns_result *result, cns_error *err)
{
    cns_code code = CNS_OK;
    long places = -1;
    mpfr_t until;
    mpfr_init2(until, ERROR_BITS);
    while (!code && w->found.first < w->found.n && !result->events_end.code) {
        if (w->proof) {
            if (!prove_event(w, d, &places, until, result))
                break;
            mpfr_set(w->told_until[w->found.at[w->found.first].m.condition], until, MPFR_RNDU);
        }
        code = cns_event_tell(w->p, &w->found.at[w->found.first].m, w->constant, d->places, places, w->digits,
                              err);
        cns_found_drop(&w->found, w->found.first);
        w->told++;
    }
    mpfr_clear(until);
    if (result->events_end.code) {
        cns_found_clear(&w->found);
        cns_found_clear(&w->found_again);
    }
    return code;
}

/* From row d->row on to the end, or to where something falls short (d->missing > 0). */
static cns_code go(walk *w, demand *d, cns_result *result, cns_error *err)
{
    const cns_problem *p = w->p;
    cns_code code = CNS_OK;
    d->few_events = false;
    d->missing = 0;
    while (!code && cns_problem_row(p, d->row, w->time)) {
        long places = -1;
        code = walk_to(w, err);
        if (!code)
            code = tell_events(w, d, result, err);
        if (code || d->missing > 0)
            return code;
        if (w->proof) {
            int tie;
            places = proven_places(w, d, d->count, &tie);
            const bool fresh = tie >= 0 && is_fresh_tie(w, d);
            if (fresh && falls_short(d, (item){d->row, -1}, 1))
                return CNS_OK;
            const double missing =
                missing_places(d, places, cns_log2_mpfr(w->error[cns_columns(p)]) * CNS_LOG10_2);
            if (places < d->count && falls_short(d, (item){d->row, -1}, missing))
                return CNS_OK;
            if (places < 0)
                return cns_fail(err, CNS_UNREACHED,
                                "no decimal can be proven from t = %.12g on with %ld digits",
                                cns_problem_time(p, w->time), result->run.digits);
            d->few_rows = d->few_rows || places < d->count || tie >= 0;
            d->few_beside = d->few_beside || places < d->count;
        }
        code = emit(w, d->places, places, result, err);
        d->row++;
        mpq_set(w->before, w->time);
        progress(w, result);
    }
    return code;
}

/* One attempt at a goal, from row d->row on. *unbounded: an enclosure has ended, and err says why. */
static cns_code attempt(const cns_problem *p, const cns_goal *goal, const cns_schedule *schedule, demand *d,
                        double since, cns_result *result, bool *unbounded, cns_error *err)
{
    cns_proof_runs runs;
    walk w;
    if (result->run.enclosed)
        cns_proof_enclosed(&runs, p, result->run.digits, schedule);
    else
        cns_proof_of_goal(&runs, p, result->run.digits, schedule);
    cns_code code = walk_open(&w, p, &runs, d->row, since, goal->max_time, result, err);
    if (!code)
        code = go(&w, d, result, err);
    if (code == CNS_STOPPED && (cns_trajectory_late(w.fine) || (w.coarse && cns_ahead_late(w.coarse))))
        code = cns_fail(err, CNS_UNREACHED, "max_time of %g s is used up at t = %.12g", goal->max_time,
                        cns_program_time(cns_system_program(p->system),
                                         mpfr_get_d(cns_flow_end(cns_trajectory_flow(w.fine)), MPFR_RNDN)));
    *unbounded = code && w.fine && (w.unbounded || cns_trajectory_unbounded(w.fine));
    d->passed = w.told > d->passed ? w.told : d->passed;
    walk_close(&w, result);
    cns_proof_runs_clear(&runs);
    return code;
}

/* What is said of a walk that came to its end. */
static cns_code conclude(const cns_problem *p, const demand *d, const cns_result *result, cns_error *err)
{
    const cns_model *m = cns_system_model(p->system);
    if (result->events_end.code)
        return cns_fail(err, result->events_end.code, "%s", result->events_end.text);
    if (result->reached)
        return CNS_OK;
    char why[160] = "";
    if (d->few_rows && !d->few_beside && d->tie >= 0) {
        const cns_column c = cns_column_at(p, d->tie);
        snprintf(why, sizeof why,
                 ": %s is zero, or next to a tie of rounding (at t = %.12g); the other columns have them",
                 c.kind == CNS_COLUMN_STATE ? m->states[c.index].name : m->outputs[c.index].name,
                 d->tie_time);
    } else if (d->few_rows && !d->few_beside) {
        snprintf(why, sizeof why, ": several columns are zero, or next to a tie of rounding (at t = %.12g)",
                 d->tie_time);
    }
    return cns_fail(err, CNS_UNREACHED, "some %s have fewer than the %ld %s asked for%s",
                    !d->few_events ? "rows"
                    : d->few_rows  ? "rows and events"
                                   : "events",
                    d->count, d->places == CNS_PLACES_DECIMALS ? "decimals" : "significant digits", why);
}

cns_code cns_solve_goal(const cns_problem *p, const cns_goal *goal, cns_result *result, cns_error *err)
{
    const double since = cns_seconds();
    const long most = goal->max_digits > 0 ? goal->max_digits : LONG_MAX;
    int stuck = 0;
    bool doubted = false, unbounded;
    long digits[CNS_PLAN_PARTS];
    cns_schedule schedule = {.digits = digits};
    demand d = {.places = cns_goal_places(goal),
                .count = cns_goal_count(goal),
                .tied = cns_xalloc((size_t)cns_columns(p) + 1, sizeof *d.tied),
                .tie = -1};
    *result = (cns_result){.decimals = -1};
    cns_code code = cns_plan(p, goal, &result->run, &schedule, err);
    while (!code) {
        d.raise = result->run.digits < most && result->run.attempt <= RAISES;
        if (result->run.digits > most)
            result->run.digits = most > CNS_LEAST_PROOF_DIGITS ? most : CNS_LEAST_PROOF_DIGITS;
        code = attempt(p, goal, &schedule, &d, since, result, &unbounded, err);
        if (unbounded && (code == CNS_NUMERIC || !d.raise || result->run.attempt > 2)) {
            /* No enclosure goes further: two runs do. */
            snprintf(result->run.why_not, sizeof result->run.why_not, "%.255s", err->text);
            result->run.enclosed = result->run.planned = false;
            result->run.attempt++;
            result->run.digits += CNS_ANOTHER_LIMB;
            code = CNS_OK;
            continue;
        }
        if (unbounded) { /* the bound has grown too large: more digits */
            code = CNS_OK;
            d.now = (item){d.row, -1};
            d.missing = 10 + (double)result->run.digits / 2;
        }
        if (code == CNS_NUMERIC && !doubted && d.raise) {
            /* Digits lost in the problem itself can look like an error, or like a singularity: ask again with
             * more before saying so. */
            doubted = true;
            code = CNS_OK;
            d.now = (item){d.row, -1};
            d.missing = 10 + (double)result->run.digits / 2;
        }
        if (code || d.missing <= 0)
            break;
        /* A raise makes up for what was missing, and more: what is short still has a value that straddles, a
         * tie or a zero. Two raises decide that, and it gets fewer places. */
        const bool again = d.now.row == d.last.row && d.now.event == d.last.event;
        stuck = again && result->run.attempt > 1 ? stuck + 1 : 0;
        d.excused = stuck >= 2;
        d.last = d.now;
        result->run.planned = false;
        result->run.why_not[0] = '\0';
        result->run.attempt++;
        result->run.digits += (long)ceil(1.2 * d.missing) + 6 + result->run.digits / 30;
    }
    result->complete = !code;
    free(d.tied);
    result->reached = result->complete && !d.few_rows && !d.few_events;
    result->wall_s = cns_seconds() - since;
    return code ? code : conclude(p, &d, result, err);
}

/* The walk of given numerics from row d->row on. *unbounded as for attempt(). */
static cns_code walk_as_given(const cns_problem *p, const cns_proof_runs *runs, demand *d, double since,
                              cns_result *result, bool *unbounded, cns_error *err)
{
    walk w;
    d->count = runs->enclosed ? runs->fine_digits : runs->coarse_digits;
    cns_code code = walk_open(&w, p, runs, d->row, since, 0, result, err);
    if (!code)
        code = go(&w, d, result, err);
    *unbounded = code && w.fine && (w.unbounded || cns_trajectory_unbounded(w.fine));
    walk_close(&w, result);
    return code;
}

cns_code cns_solve_numerics(const cns_problem *p, const cns_numerics *n, bool prove, cns_result *result,
                            cns_error *err)
{
    const double since = cns_seconds();
    cns_proof_runs runs;
    bool unbounded = false;
    *result = (cns_result){.decimals = -1, .run = {.attempt = 1}};
    cns_code code = cns_problem_check(p, err);
    if (code)
        return code;
    demand d = {.places = CNS_PLACES_DECIMALS};
    cns_proof_of_numerics(&runs, p, n, prove ? CNS_PROOF_ENCLOSURE : CNS_PROOF_NONE);
    code = cns_cost_of_numerics(p, &runs, &result->run, err);
    if (!code)
        code = walk_as_given(p, &runs, &d, since, result, &unbounded, err);
    cns_proof_runs_clear(&runs);
    if (unbounded && code == CNS_NUMERIC) { /* two runs go on */
        snprintf(result->run.why_not, sizeof result->run.why_not, "%.255s", err->text);
        result->run.attempt++;
        cns_proof_of_numerics(&runs, p, n, CNS_PROOF_TWO_RUNS);
        code = walk_as_given(p, &runs, &d, since, result, &unbounded, err);
        cns_proof_runs_clear(&runs);
    }
    result->complete = result->reached = !code;
    result->wall_s = cns_seconds() - since;
    return code ? code : conclude(p, &d, result, err);
}
