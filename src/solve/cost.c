#include "cost.h"

#include <math.h>

#include "core/clock.h"
#include "core/monitor.h"
#include "integrate/numerics.h"
#include "integrate/trajectory.h"
#include "num/logs.h"
#include "problem.h"
#include "taylor/jet.h"

enum {
    LEVELS = 3,
    LEAST_LEVEL = 10, /* digits */
    MOST_STEPS = 40,  /* measured at each level */
    /* Digits that are measured: steps of more take seconds to hours. Time beyond follows the power of the
     * digits that it has below, memory their square: series as long as their terms. */
    MOST_MEASURED = 1000,
    SCOUTED = 400, /* steps of the preliminary run for given numerics */
    /* The program, its libraries, stacks and the tables of MPFR: measured on Linux. */
    PROGRAM_BYTES = 4 << 20
};

static const double measuring_part = 1.0 / 600; /* of the time predicted, for each level of each run */

/* What goes along with a run. */
typedef enum follower { NOTHING, GROWTH, TUBE } follower;

typedef struct level {
    double digits, step, row; /* seconds */
} level;

static double two_to(double x)
{
    long e;
    double m = cns_exp2_2exp(x, &e);
    return ldexp(m, (int)e);
}

static double level_digits(int i)
{
    return ldexp(LEAST_LEVEL, i);
}

/* Steps that a smoothed kink costs to a run of so many digits. It has singularities as near to the real axis
 * as the smoothing is narrow, eps. At a distance d of them, d > eps, steps are d 10^(-D/order), where D are
 * the digits that what is singular there still has of all: it is of the order d^3, as for |u| u with u linear
 * in d. Integrated over log d from 1 to eps, on both sides; that other terms limit steps, too, is the factor,
 * which fits runs with eps from 1e-4 to 1e-16 and 42 to 132 digits to 20 %. */
static double crossing_steps(double digits, double eps_log2)
{
    const double order = cns_order_for(-digits * CNS_LOG2_10, CNS_ARITH_FAST);
    const double last = fmax(0, digits + 3 * eps_log2 * CNS_LOG10_2);
    return 0.78 * 2 * order / 3 * (pow(10, digits / order) - pow(10, last / order));
}

/* Is a step of length 2^h, of at most 2^own by its coefficients, one of those across a smoothed kink? A
 * crossing begins with a step that is 8 times shorter than the longest before it, and is over when one is
 * again within a factor of 4 of that. */
static bool crosses(cns_tally *y, int at, double h_log2, double own)
{
    enum { NARROW = 3, WIDE = 2 };
    const double here = fmin(own, h_log2);
    if (y->crossing && here > y->wide - WIDE) {
        for (int i = 0; i < CNS_TALLY_LEVELS; i++)
            y->part[at].steps[i] += crossing_steps(level_digits(i), y->least - y->wide);
        y->crossing = false;
        y->wide = here;
    } else if (!y->crossing && y->begun && here < y->wide - NARROW) {
        y->crossing = true;
        y->least = here;
    }
    y->wide = y->begun ? fmax(y->wide, here) : here;
    y->least = fmin(y->least, here);
    return y->crossing;
}

void cns_tally_step(void *tally, const cns_flow *f)
{
    cns_tally *y = tally;
    const cns_program *p = y->spec->program;
    const double from = mpfr_get_d(cns_flow_begin(f), MPFR_RNDN),
                 h = mpfr_get_d(cns_flow_end(f), MPFR_RNDN) - from;
    const int at = from < y->end ? (int)(from / y->end * CNS_PLAN_PARTS) : CNS_PLAN_PARTS - 1;
    double own, other;
    bool told = cns_flow_reach(f, y->spec->tolerance_log2, y->spec->order, &own);
    if (told && cns_program_is_smooth(p) && !cns_jet_is_sharp(p, y->spec->prec) &&
        crosses(y, at, cns_log2_2exp(h, 0), own))
        return;
    if (cns_flow_landed(f))
        y->part[at].landings++;
    else if (told && h < 0.7 * two_to(own)) {
        y->part[at].approaches++;
        return;
    }
    for (int i = 0; i < CNS_TALLY_LEVELS; i++) {
        const double tolerance = -level_digits(i) * CNS_LOG2_10;
        const int order = cns_order_for(tolerance, CNS_ARITH_FAST);
        if (!told)
            y->part[at].steps[i]++;
        if (!told || !cns_flow_reach(f, tolerance, order, &other))
            continue;
        /* The fast arithmetic wants to know the step beforehand: one is no longer than the last might be. */
        y->part[at].steps[i] += h / two_to((y->begun ? fmin(other, y->before[i]) : other) - 1.0 / order);
        y->before[i] = other;
    }
    y->begun = y->begun || told;
}

/* Steps in part i of a run with this spec. */
static double steps_in(const cns_tally *y, int i, const cns_flow_spec *spec, long digits)
{
    const cns_program *p = spec->program;
    const double l = cns_log2_2exp((double)digits / LEAST_LEVEL, 0);
    const int below = l < 0 ? 0 : l < CNS_TALLY_LEVELS - 1 ? (int)l : CNS_TALLY_LEVELS - 2;
    const double a = y->part[i].steps[below], b = y->part[i].steps[below + 1];
    double steps = (a + (b - a) * fmax(0, l - below)) * two_to(spec->safety) + y->part[i].approaches;
    /* Landing on a kink ends a step early, and the next ones are short: measured, 1.5 are lost. What has been
     * landed on may be smooth at more digits. */
    if (cns_program_is_smooth(p) && !cns_jet_is_sharp(p, spec->prec))
        return steps + y->part[i].landings * crossing_steps((double)digits, cns_program_smooth_log2(p));
    return steps + 1.5 * y->part[i].landings;
}

/* What a step takes, and a row: the evaluation at a time within the last step. The first step of all is not
 * counted: it has more to do. *measured: whether there was anything to measure. A run that fails has been
 * measured up to there; only CNS_STOPPED and CNS_MEMORY are returned. */
static cns_code measure(const cns_problem *p, const cns_flow_spec *spec, follower with, double steps,
                        level *l, bool *measured, double *memory, cns_error *err)
{
    cns_trajectory_spec of = {.flow = *spec,
                              .initial = cns_system_initial(p->system),
                              .outputs = cns_wants_outputs(p),
                              .tube = with == TUBE,
                              .no_growth = with != GROWTH};
    cns_error why = {0};
    cns_trajectory *t = cns_trajectory_new(&of, &why);
    cns_code code = t ? CNS_OK : why.code;
    cns_sample s = {0};
    mpq_t time;
    long counted = 0;
    int turn = 0;
    double spent = 0, in_steps = 0, in_rows = 0;
    mpq_init(time);
    if (t && !cns_sample_init(&s, cns_system_program(p->system), cns_flow_prec(cns_trajectory_flow(t))))
        code = cns_out_of_memory(&why);
    if (!code && with == TUBE)
        cns_sample_want_errors(&s);
    if (!code) {
        cns_flow *f = cns_trajectory_flow(t);
        bool enough = false;
        for (; !enough && turn < MOST_STEPS; turn++) {
            double a = cns_thread_seconds();
            code = cns_trajectory_step(t, &why);
            if (code)
                break;
            mpfr_get_q(time, cns_flow_end(f));
            double b = cns_thread_seconds();
            code = cns_trajectory_at(t, time, &s, &why);
            if (code)
                break;
            double c = cns_thread_seconds();
            spent += c - a;
            if (turn == 0)
                continue;
            counted++;
            in_steps += b - a;
            in_rows += c - b;
            enough = spent > measuring_part * steps * in_steps / (double)counted;
        }
        if (memory)
            *memory += (double)cns_flow_bytes(f);
    }
    if (counted > 0) {
        l->step = in_steps / (double)counted;
        l->row = in_rows / (turn > 1 ? turn - 1 : 1);
    }
    cns_trajectory_free(t);
    cns_sample_clear(&s);
    mpq_clear(time);
    *measured = counted > 0;
    return code == CNS_STOPPED || code == CNS_MEMORY ? cns_fail(err, code, "%s", why.text) : CNS_OK;
}

/* y at x on the power law through two points, which is a line between their logarithms. */
static double between(double x, double x0, double y0, double x1, double y1)
{
    if (x1 == x0 || !(y0 > 0) || !(y1 > 0))
        return y1;
    return y0 * exp(log(y1 / y0) * log(x / x0) / log(x1 / x0));
}

static void cost_at(const level *l, int levels, double digits, double *step, double *row)
{
    int i = 1;
    while (i < levels - 1 && digits < l[i].digits)
        i++;
    if (levels == 1)
        i = 0;
    const level *a = &l[i > 0 ? i - 1 : 0], *b = &l[i];
    *step = between(digits, a->digits, a->step, b->digits, b->step);
    *row = between(digits, a->digits, a->row, b->digits, b->row);
}

/* The digits of a run in part i of its schedule. */
static long digits_in(const cns_flow_spec *spec, int i, long most)
{
    long digits = spec->schedule->digits[i] + spec->schedule_shift;
    return digits < most ? digits : most;
}

static cns_flow_spec spec_for(const cns_problem *p, const cns_flow_spec *like, long digits)
{
    cns_flow_spec spec = cns_flow_spec_taylor(cns_system_program(p->system), cns_system_scales(p->system),
                                              CNS_ARITH_FAST, digits);
    spec.safety = like->safety;
    spec.verify = true;
    spec.stop = cns_monitor_stop(p->monitor);
    return spec;
}

/* part[i]: what part i of the time takes; *seconds: their sum. */
static cns_code run_seconds(const cns_problem *p, const cns_flow_spec *run, long digits, follower with,
                            const cns_tally *tally, double rows, double *part, double *seconds, double *steps,
                            double *memory, cns_error *err)
{
    const int parts = run->schedule->n;
    const long last = digits_in(run, parts - 1, digits);
    long asked[LEVELS] = {digits, lround(sqrt((double)digits * (double)last)), last};
    if (digits > MOST_MEASURED) {
        asked[0] = MOST_MEASURED;
        asked[1] = asked[2] = MOST_MEASURED * 7 / 10;
    }
    level l[LEVELS];
    int levels = 0;
    double bytes = 0;
    *steps = *seconds = 0;
    for (int i = 0; i < parts; i++) {
        const long here = digits_in(run, i, digits);
        cns_flow_spec spec = spec_for(p, run, here);
        *steps += steps_in(tally, i, &spec, here);
    }
    for (int i = 0; i < LEVELS; i++) {
        if (i > 0 && asked[i] == asked[i - 1])
            continue;
        cns_flow_spec spec = spec_for(p, run, asked[i]);
        l[levels].digits = (double)asked[i];
        bool measured;
        cns_code code = measure(p, &spec, with, *steps, &l[levels], &measured, i == 0 ? &bytes : NULL, err);
        if (code)
            return code;
        levels += measured;
    }
    *memory += bytes * pow((double)digits / (double)asked[0], 2);
    for (int i = 0; i < parts && levels > 0; i++) {
        const long here = digits_in(run, i, digits);
        cns_flow_spec spec = spec_for(p, run, here);
        double step, row;
        cost_at(l, levels, (double)here, &step, &row);
        part[i] = steps_in(tally, i, &spec, here) * step + rows / parts * row;
        *seconds += part[i];
    }
    return CNS_OK;
}

cns_code cns_cost_predict(const cns_problem *p, const cns_proof_runs *runs, const cns_tally *tally,
                          cns_run_info *plan, cns_error *err)
{
    const double rows = cns_problem_rows(p);
    double in_printed[CNS_PLAN_PARTS] = {0}, in_proof[CNS_PLAN_PARTS] = {0};
    double printed, proof = 0, ignored, memory = PROGRAM_BYTES, sum = 0;
    cns_code code = run_seconds(p, &runs->fine, plan->digits, runs->enclosed ? TUBE : NOTHING, tally, rows,
                                in_printed, &printed, &plan->steps, &memory, err);
    if (!code && runs->proof)
        code = run_seconds(p, &runs->coarse, plan->proof_digits, GROWTH, tally, rows, in_proof, &proof,
                           &ignored, &memory, err);
    if (code)
        return code;
    plan->seconds = cns_monitor_threads(p->monitor) > 1 ? fmax(printed, proof) : printed + proof;
    for (int i = 0; i < CNS_PLAN_PARTS; i++) {
        sum += in_printed[i] + in_proof[i];
        plan->done[i] = printed + proof > 0 ? fmin(1, sum / (printed + proof)) : (i + 1.0) / CNS_PLAN_PARTS;
    }
    plan->memory = memory;
    return CNS_OK;
}

/* Adaptive steps of runs as `run` describes up to `end`, by the coefficients of a preliminary run in double
 * precision. Beyond the steps that it makes the rest goes on as the later half of them did. 0: nothing can be
 * told. */
static double scouted_steps(const cns_problem *p, const cns_flow_spec *run, double end)
{
    cns_flow_spec spec = cns_flow_spec_taylor(cns_system_program(p->system), cns_system_scales(p->system),
                                              CNS_ARITH_DOUBLE, CNS_DOUBLE_DIGITS);
    cns_error ignored;
    spec.stop = run->stop;
    if (spec.order < run->order) /* what is not extrapolated is certain */
        spec.order = run->order < CNS_DOUBLE_MAX_ORDER ? run->order : CNS_DOUBLE_MAX_ORDER;
    cns_flow *f = cns_flow_new(&spec, &ignored);
    double t = 0, steps = 0, half_t = 0, half_steps = 0, h_log2;
    int made = 0;
    if (f == NULL)
        return 0;
    cns_flow_start(f, cns_system_initial(p->system));
    for (; t < end && made < SCOUTED && !cns_flow_step(f, &ignored); made++) {
        const double before = t;
        t = mpfr_get_d(cns_flow_end(f), MPFR_RNDN);
        if (cns_flow_reach(f, run->tolerance_log2, run->order, &h_log2))
            steps +=
                two_to(cns_log2_2exp(fmin(t, end) - before, 0) - h_log2 + run->safety + 1.0 / run->order);
        else
            steps++;
        if (made < SCOUTED / 2) {
            half_t = t;
            half_steps = steps;
        }
    }
    cns_flow_free(f);
    if (made == SCOUTED && t < end)
        steps += (end - t) * (steps - half_steps) / (t - half_t);
    return steps;
}

static double steps_of(const cns_problem *p, const cns_flow_spec *run)
{
    const double end = cns_number_get_d(p->end);
    return run->step != NULL ? end / cns_number_get_d(run->step) : scouted_steps(p, run, end);
}

static cns_code too_many(const cns_problem *p, const cns_flow_spec *run, double steps, cns_error *err)
{
    char help[96] = "take a longer step";
    cns_flow_spec other = *run;
    other.order = cns_order_for(run->tolerance_log2, run->arithmetic);
    if (run->step == NULL) {
        const double fewer = scouted_steps(p, &other, cns_number_get_d(p->end));
        if (fewer < CNS_MOST_STEPS)
            snprintf(help, sizeof help, "order %d, that of `order: auto`, needs about %.0f", other.order,
                     fewer);
        else
            snprintf(help, sizeof help, "no order needs fewer than %.0e", CNS_MOST_STEPS);
    }
    return cns_fail(
        err, CNS_USAGE,
        "with about %.0e steps up to t = %g the run does not end: %s; with max_time it goes as far as "
        "it comes",
        steps, cns_problem_time(p, p->end->ratio), help);
}

/* A run like this one, of fewer digits. */
static cns_flow_spec with_digits(const cns_flow_spec *run, long digits)
{
    cns_flow_spec spec = *run;
    const mpfr_prec_t prec = cns_digits_to_bits(digits);
    if (run->arithmetic == CNS_ARITH_DOUBLE || prec >= run->prec)
        return spec;
    const int order = cns_order_for(cns_digits_to_tolerance(digits), run->arithmetic);
    spec.prec = prec;
    spec.tolerance_log2 = fmax(run->tolerance_log2, cns_digits_to_tolerance(digits));
    spec.order = run->order < order ? run->order : order;
    return spec;
}

static cns_code given_seconds(const cns_problem *p, const cns_flow_spec *run, long digits, double steps,
                              follower with, double *seconds, cns_error *err)
{
    const double rows = cns_problem_rows(p);
    const long asked[] = {MOST_MEASURED * 7 / 10, MOST_MEASURED};
    level l[2];
    int levels = 0;
    for (int i = digits > MOST_MEASURED ? 0 : 1; i < 2; i++) {
        const cns_flow_spec spec = with_digits(run, asked[i]);
        bool measured;
        l[levels].digits = (double)(digits > MOST_MEASURED ? asked[i] : digits);
        const cns_code code = measure(p, &spec, with, steps, &l[levels], &measured, NULL, err);
        if (code)
            return code;
        levels += measured;
    }
    if (levels > 0) {
        double step, row;
        cost_at(l, levels, (double)digits, &step, &row);
        *seconds = steps * step + rows * row;
    }
    return CNS_OK;
}

cns_code cns_cost_of_numerics(const cns_problem *p, const cns_proof_runs *runs, cns_run_info *info,
                              cns_error *err)
{
    const double steps = steps_of(p, &runs->fine);
    double printed = 0, proof = 0;
    const double most = cns_most_steps(p, 0);
    if (most > 0 && steps > most)
        return too_many(p, &runs->fine, steps, err);
    if (steps <= 0)
        return CNS_OK;
    cns_code code = given_seconds(p, &runs->fine, runs->fine_digits, steps, runs->proof ? NOTHING : GROWTH,
                                  &printed, err);
    if (!code && runs->proof)
        code = given_seconds(p, &runs->coarse, runs->coarse_digits, steps_of(p, &runs->coarse), GROWTH,
                             &proof, err);
    if (code) /* stopped, it says where when it walks */
        return code == CNS_STOPPED ? CNS_OK : code;
    info->steps = steps;
    info->seconds = cns_monitor_threads(p->monitor) > 1 ? fmax(printed, proof) : printed + proof;
    return CNS_OK;
}
