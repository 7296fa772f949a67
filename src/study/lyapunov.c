#include "cns/study/lyapunov.h"

#include <math.h>
#include <stdlib.h>

#include "batches.h"
#include "core/memory.h"
#include "core/monitor.h"
#include "integrate/numerics.h"
#include "num/logs.h"
#include "taylor/tangent.h"

enum {
    BLOCKS = 2048, /* growth is recorded this often: 64 to a row of the table */
    BATCHES = 32,  /* for the standard error */
    BLOCKS_PER_ROW = BLOCKS / CNS_LYAPUNOV_ROWS,
    DISCARDED_PART = 10,
    /* In double: measured to be the quickest for the falling disk, at a tolerance next to the rounding. */
    DOUBLE_ORDER = 22,
    DOUBLE_TOLERANCE_LOG2 = -50
};

static const int batch_counts[CNS_LYAPUNOV_COUNTS] = {16, 32, 64, 128};
static const double ln_2 = 0.69314718055994530942;

typedef struct walk {
    int d; /* dynamic states */
    int order;
    int *index;
    double *scales; /* of the 2 d states of the tangent program */
    cns_number *initial;
    cns_program *program;
    cns_flow *flow;
    mpfr_t *x;
    mpq_t time;
    long exponent; /* the tangent is v 2^exponent */
} walk;

/* Any direction will do that no symmetry of a model singles out: parts of multiples of the golden ratio. */
static double direction(int i)
{
    double x = (i + 1) * 0.61803398874989484820;
    return x - floor(x);
}

static cns_code walk_open(walk *w, const cns_system *s, const cns_lyapunov_spec *l,
                          const volatile sig_atomic_t *stop, cns_error *err)
{
    const cns_program *program = cns_system_program(s);
    const int n = cns_program_states(program);
    *w = (walk){.d = 0};
    mpq_init(w->time);
    w->index = cns_xalloc((size_t)n + 1, sizeof *w->index);
    w->d = cns_dynamic_states(program, w->index);
    if (w->d == 0)
        return cns_fail(err, CNS_NUMERIC, "no state feeds back on another: there is no exponent to find");
    w->scales = cns_xalloc(2 * (size_t)w->d, sizeof *w->scales);
    w->initial = cns_xalloc(2 * (size_t)w->d, sizeof *w->initial);
    w->x = cns_xalloc(2 * (size_t)w->d, sizeof *w->x);
    for (int i = 0; i < w->d; i++) {
        const double scale = cns_system_scales(s)[w->index[i]];
        w->scales[i] = w->scales[w->d + i] = scale;
        cns_number_init(&w->initial[i]);
        cns_number_set(&w->initial[i], &cns_system_initial(s)[w->index[i]]);
        cns_number_init(&w->initial[w->d + i]);
        mpq_set_d(w->initial[w->d + i].ratio, l->tangent ? l->tangent[i] : scale * direction(i));
    }
    cns_code code = cns_tangent_program(program, 1, &w->program, err);
    if (code)
        return code;
    const bool in_double = l->arithmetic == CNS_ARITH_DOUBLE;
    cns_flow_spec spec =
        cns_flow_spec_taylor(w->program, w->scales, l->arithmetic, in_double ? CNS_DOUBLE_DIGITS : l->digits);
    if (in_double) {
        spec.order = DOUBLE_ORDER;
        spec.tolerance_log2 = DOUBLE_TOLERANCE_LOG2;
    }
    spec.stop = stop;
    for (int i = 0; i < 2 * w->d; i++)
        mpfr_init2(w->x[i], spec.prec);
    w->order = spec.order;
    w->flow = cns_flow_new(&spec, err);
    if (!w->flow)
        return err->code;
    cns_flow_start(w->flow, w->initial);
    return CNS_OK;
}

static void walk_close(walk *w)
{
    for (int i = 0; w->x && i < 2 * w->d; i++) {
        cns_number_clear(&w->initial[i]);
        if (w->program)
            mpfr_clear(w->x[i]);
    }
    cns_flow_free(w->flow);
    cns_program_free(w->program);
    mpq_clear(w->time);
    free(w->index);
    free(w->scales);
    free(w->initial);
    free(w->x);
}

/* The tangent's length in the scales of its states. */
static double length(const walk *w, const mpfr_t *x)
{
    double sum = 0;
    for (int i = w->d; i < 2 * w->d; i++) {
        double v = mpfr_get_d(x[i], MPFR_RNDN) / w->scales[i];
        sum += v * v;
    }
    return sqrt(sum);
}

/* Tolerances are relative to the scales, so the tangent is kept at length 0.5 to 1 where a step begins. */
static cns_code renormalise(walk *w, cns_error *err)
{
    int e;
    double l = length(w, cns_flow_state(w->flow));
    if (!(l > 0) || !isfinite(l))
        return cns_fail(err, CNS_NUMERIC,
                        "t = %.12g: the tangent vanishes, or grows out of range in one step",
                        mpfr_get_d(cns_flow_end(w->flow), MPFR_RNDN));
    frexp(l, &e);
    if (e != 0)
        cns_flow_rescale(w->flow, w->d, w->d, -e);
    w->exponent += e;
    return CNS_OK;
}

/* ln |v(t)|, t not before that of the last call. */
static cns_code growth_at(walk *w, double t, double *growth, cns_error *err)
{
    mpq_set_d(w->time, t);
    while (cns_flow_steps(w->flow) == 0 || mpfr_cmp_q(cns_flow_end(w->flow), w->time) < 0) {
        cns_code code = renormalise(w, err);
        if (!code)
            code = cns_flow_step(w->flow, err);
        if (code)
            return code;
    }
    cns_flow_eval(w->flow, w->time, w->x);
    double l = length(w, (const mpfr_t *)w->x);
    if (!(l > 0) || !isfinite(l))
        return cns_fail(err, CNS_NUMERIC,
                        "t = %.12g: the tangent vanishes, or grows out of range in one step", t);
    *growth = cns_log2_2exp(l, w->exponent) * ln_2;
    return CNS_OK;
}

cns_code cns_lyapunov(const cns_system *s, const cns_lyapunov_spec *spec, const cns_monitor *monitor,
                      cns_lyapunov_result *result, cns_error *err)
{
    walk w;
    double rate[BLOCKS], start = 0, before = 0;
    const double time = cns_number_get_d(&spec->time);
    *result = (cns_lyapunov_result){.discarded = time / DISCARDED_PART};
    cns_code code = walk_open(&w, s, spec, cns_monitor_stop(monitor), err);
    for (int k = 1 - BLOCKS / DISCARDED_PART; !code && k <= BLOCKS; k++) {
        const double block = time / BLOCKS, t = result->discarded + k * block;
        double growth = 0;
        code = growth_at(&w, t, &growth, err);
        if (code)
            break;
        if (k <= 0)
            start = growth;
        else
            rate[k - 1] = (growth - before) / block;
        before = growth;
        if (k > 0 && k % BLOCKS_PER_ROW == 0)
            result->row[k / BLOCKS_PER_ROW - 1] = (cns_lyapunov_row){
                .t = t, .lambda = (growth - start) / (k * block), .se = cns_batch_error(rate, k, BATCHES)};
        cns_monitor_tell(monitor, t / (result->discarded + time), "largest exponent");
    }
    if (!code) {
        result->lambda = result->row[CNS_LYAPUNOV_ROWS - 1].lambda;
        result->se = result->row[CNS_LYAPUNOV_ROWS - 1].se;
        for (int b = 0; b < CNS_LYAPUNOV_COUNTS; b++) {
            result->batch[b].count = batch_counts[b];
            result->batch[b].length = time / batch_counts[b];
            result->batch[b].se = cns_batch_error(rate, BLOCKS, batch_counts[b]);
        }
        result->order = w.order;
        result->steps = cns_flow_steps(w.flow);
        result->landings = cns_flow_landings(w.flow);
    }
    walk_close(&w);
    return code;
}
