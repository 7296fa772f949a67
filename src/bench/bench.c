#include "bench.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arith/fast.h"
#include "cns/flow.h"
#include "core/clock.h"
#include "core/memory.h"
#include "core/monitor.h"
#include "num/logs.h"

#define APW_START                                                                                            \
    {"theta", "1.7"}, {"Vx", "-0.45"}, {"Vy", "-0.3"},                                                       \
    {                                                                                                        \
        "omega", "0.6"                                                                                       \
    }

static const struct {
    const char *name, *model;
    cns_setting settings[8];
} systems[CNS_BENCH_SYSTEMS] = {
    [CNS_BENCH_APW] = {"apw", "apw", {APW_START}},
    [CNS_BENCH_APW_SMOOTH] = {"apw, eps 1e-3", "apw", {APW_START, {"smooth", "1e-3"}}},
    [CNS_BENCH_LORENZ] = {"lorenz", "lorenz", {{"x", "-15.8"}, {"y", "-17.48"}, {"z", "35.64"}}},
};

static const char *const engines[CNS_BENCH_ENGINES] = {"mpfr", "portable", "avx512ifma"};

const char *cns_bench_engine_name(cns_bench_engine engine)
{
    return engines[engine];
}

const char *cns_bench_system_name(cns_bench_system system)
{
    return systems[system].name;
}

cns_system *cns_bench_system_new(cns_bench_system system, cns_error *err)
{
    return cns_system_parse(cns_model_find(systems[system].model), systems[system].settings, err);
}

bool cns_bench_has(cns_bench_engine engine)
{
    return engine == CNS_BENCH_MPFR || cns_fast_has_kernel(engines[engine]);
}

/* One run. */

void cns_bench_run_clear(cns_bench_run *run)
{
    for (int i = 0; i < run->n; i++)
        mpfr_clear(run->end[i]);
    free(run->end);
    free(run->each);
    *run = (cns_bench_run){0};
}

/* Measured steps until `until` lies within the last one. */
static cns_code reach(cns_flow *f, double until, cns_bench_run *run, cns_error *err)
{
    cns_code code = CNS_OK;
    while (!code && mpfr_cmp_d(cns_flow_end(f), until) < 0) {
        const double from = cns_process_seconds();
        code = cns_flow_step(f, err);
        run->each = cns_xgrow(run->each, (size_t)run->taken + 1, sizeof *run->each);
        run->each[run->taken++] = cns_process_seconds() - from;
    }
    return code;
}

static void end_states(cns_flow *f, const cns_system *p, double until, cns_bench_run *run)
{
    run->n = cns_program_states(cns_system_program(p));
    run->end = cns_xalloc((size_t)run->n, sizeof *run->end);
    for (int i = 0; i < run->n; i++)
        mpfr_init2(run->end[i], cns_flow_prec(f));
    mpq_t time;
    mpq_init(time);
    mpq_set_d(time, until);
    cns_flow_eval(f, time, run->end);
    mpq_clear(time);
}

static cns_code follow(cns_flow *f, const cns_system *p, double until, cns_bench_run *run, cns_error *err)
{
    cns_flow_start(f, cns_system_initial(p));
    cns_code code = cns_flow_step(f, err);
    if (code)
        return code;
    const double since = mpfr_get_d(cns_flow_end(f), MPFR_RNDN);
    if ((code = reach(f, until, run, err)))
        return code;
    end_states(f, p, until, run);
    if (run->taken == 0) /* a step at least, to have something to measure */
        if ((code = reach(f, since * (1 + DBL_EPSILON), run, err)))
            return code;
    run->covered = mpfr_get_d(cns_flow_end(f), MPFR_RNDN) - since;
    for (int i = 0; i < run->taken; i++)
        run->seconds += run->each[i] / run->covered;
    run->steps = run->taken / run->covered;
    return CNS_OK;
}

cns_code cns_bench_measure(const cns_system *p, const cns_bench_job *job, cns_bench_run *run, cns_error *err)
{
    const cns_arithmetic arithmetic = job->engine == CNS_BENCH_MPFR ? CNS_ARITH_MPFR : CNS_ARITH_FAST;
    cns_flow_spec spec =
        cns_flow_spec_taylor(cns_system_program(p), cns_system_scales(p), arithmetic, job->digits);
    if (job->order)
        spec.order = job->order;
    spec.kernel = job->engine == CNS_BENCH_MPFR ? NULL : engines[job->engine];
    spec.stop = job->stop;
    cns_bench_run_clear(run);
    cns_flow *f = cns_flow_new(&spec, err);
    if (!f)
        return err->code;
    run->order = spec.order;
    cns_code code = follow(f, p, job->until, run, err);
    cns_flow_free(f);
    return code;
}

double cns_bench_agreed(const cns_system *p, const mpfr_t *x, const mpfr_t *y)
{
    double least = HUGE_VAL;
    mpfr_t d;
    mpfr_init2(d, 64);
    for (int i = 0; i < cns_program_states(cns_system_program(p)); i++) {
        long e;
        mpfr_sub(d, x[i], y[i], MPFR_RNDN);
        if (!cns_program_is_dynamic(cns_system_program(p), i) || mpfr_zero_p(d))
            continue;
        double m = fabs(mpfr_get_d_2exp(&e, d, MPFR_RNDN)) / cns_system_scales(p)[i];
        least = fmin(least, -cns_log10_2exp(m, e));
    }
    mpfr_clear(d);
    return least;
}

static cns_bench_engine best_engine(void)
{
    return cns_bench_has(CNS_BENCH_IFMA) ? CNS_BENCH_IFMA : CNS_BENCH_PORTABLE;
}

cns_code cns_bench_reference(const cns_system *p, long digits, double until,
                             const volatile sig_atomic_t *stop, cns_bench_run *run, cns_error *err)
{
    cns_bench_job job = {
        .engine = best_engine(), .digits = digits + digits / 5 + 20, .until = until, .stop = stop};
    return cns_bench_measure(p, &job, run, err);
}

/* Tables. */

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double cns_bench_median(const cns_bench_cell *cell)
{
    double sorted[CNS_BENCH_RUNS];
    const int n = cell->runs;
    memcpy(sorted, cell->seconds, (size_t)n * sizeof *sorted);
    qsort(sorted, (size_t)n, sizeof *sorted, by_size);
    return n % 2 ? sorted[n / 2] : 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]);
}

typedef struct filling {
    const cns_bench_spec *spec;
    cns_bench_row *rows;
    int n;
    double began;
} filling;

/* Seconds that one more run of a cell is expected to take: as before, or by what fewer digits took. 0 for
 * the first row of a system, of which nothing is known: the cheapest, it is measured in any case. */
static double expected(const filling *w, const cns_bench_row *row, cns_bench_engine engine)
{
    enum { PER_DECADE = 35 }; /* cost per unit of time against digits, tenths of an exponent */
    const cns_bench_cell *cell = &row->cells[engine];
    const cns_bench_row *known = cell->runs ? row : NULL;
    for (const cns_bench_row *r = w->rows; r < row && !cell->runs; r++)
        if (r->system == row->system && r->cells[engine].runs)
            known = r;
    if (!known)
        return 0;
    const cns_bench_cell *c = &known->cells[engine];
    const double time = row->until + 2 / c->steps; /* the first step, and the last one's overshoot */
    return time * cns_bench_median(c) * pow((double)row->digits / (double)known->digits, 0.1 * PER_DECADE);
}

static bool fits(const filling *w, double seconds)
{
    return w->spec->seconds <= 0 || seconds <= 0 || cns_seconds() - w->began + seconds <= w->spec->seconds;
}

static void tell(filling *w, const cns_bench_row *row, cns_bench_engine engine, double fraction)
{
    char what[96];
    snprintf(what, sizeof what, "%s, %ld digits, %s", systems[row->system].name, row->digits,
             engines[engine]);
    cns_monitor_tell(w->spec->monitor, fraction, what);
}

/* A round of the cells of one row: each engine once, beginning with another one each time. */
static cns_code fill_row(filling *w, const cns_system *p, cns_bench_row *row, int round, cns_error *err)
{
    enum { REFERENCE_COST = 2 }; /* in runs of the fastest engine */
    cns_bench_run runs[CNS_BENCH_ENGINES] = {{0}}, reference = {0};
    cns_code code = CNS_OK;
    bool first = false;
    for (int i = 0; i < CNS_BENCH_ENGINES && !code; i++) {
        /* In the first round the fast ones first: where time is short they are what fits. */
        const int turn = round == 0 ? CNS_BENCH_ENGINES - 1 - i : (round + i) % CNS_BENCH_ENGINES;
        const cns_bench_engine engine = (cns_bench_engine)turn;
        cns_bench_cell *cell = &row->cells[engine];
        const double runs_ahead = round == 0 && !first ? 1 + REFERENCE_COST : 1;
        if (cell->runs != round || !cns_bench_has(engine) || !fits(w, runs_ahead * expected(w, row, engine)))
            continue;
        const double fraction = w->spec->seconds > 0
                                    ? (cns_seconds() - w->began) / w->spec->seconds
                                    : ((double)(row - w->rows) / w->n + round) / w->spec->runs;
        tell(w, row, engine, fmin(1, fraction));
        const cns_bench_job job = {.engine = engine,
                                   .digits = row->digits,
                                   .until = row->until,
                                   .stop = cns_monitor_stop(w->spec->monitor)};
        code = cns_bench_measure(p, &job, &runs[engine], err);
        if (code)
            break;
        cell->seconds[cell->runs++] = runs[engine].seconds;
        cell->steps = runs[engine].steps;
        cell->order = runs[engine].order;
        first = round == 0;
    }
    if (!code && first)
        code = cns_bench_reference(p, row->digits, row->until, cns_monitor_stop(w->spec->monitor), &reference,
                                   err);
    for (int i = 0; i < CNS_BENCH_ENGINES && !code && first; i++)
        if (row->cells[i].runs)
            row->cells[i].right =
                cns_bench_agreed(p, (const mpfr_t *)runs[i].end, (const mpfr_t *)reference.end);
    const cns_bench_run *a = &runs[CNS_BENCH_PORTABLE], *b = &runs[CNS_BENCH_IFMA];
    for (int i = 0; i < a->n && b->n && !code; i++)
        if (!mpfr_equal_p(a->end[i], b->end[i]))
            code = cns_fail(err, CNS_NUMERIC, "%s, %ld digits: the kernels differ in state %d",
                            systems[row->system].name, row->digits, i);
    cns_bench_run_clear(&reference);
    for (int i = 0; i < CNS_BENCH_ENGINES; i++)
        cns_bench_run_clear(&runs[i]);
    return code;
}

cns_code cns_bench_fill(const cns_bench_spec *spec, cns_bench_row *rows, int n, cns_error *err)
{
    filling w = {.spec = spec, .rows = rows, .n = n, .began = cns_seconds()};
    cns_system *problems[CNS_BENCH_SYSTEMS] = {NULL};
    cns_code code = CNS_OK;
    for (int i = 0; i < n; i++)
        memset(rows[i].cells, 0, sizeof rows[i].cells);
    for (int i = 0; i < CNS_BENCH_SYSTEMS && !code; i++) {
        problems[i] = cns_bench_system_new((cns_bench_system)i, err);
        code = problems[i] ? CNS_OK : err->code;
    }
    for (int round = 0; round < spec->runs && !code; round++)
        for (int i = 0; i < n && !code; i++)
            code = fill_row(&w, problems[rows[i].system], &rows[i], round, err);
    for (int i = 0; i < CNS_BENCH_SYSTEMS; i++)
        cns_system_free(problems[i]);
    return code;
}
