#include "cns/study/lyapunov.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "batches.h"
#include "cns/study/equilibria.h"
#include "core/memory.h"
#include "core/monitor.h"
#include "frame.h"
#include "taylor/tangent.h"

enum {
    PARTS = 8,                     /* of the time: as many as are left out, or not, as a whole */
    PART = 32 * CNS_LYAPUNOV_ROWS, /* blocks: 32 batches of one block in the first row of one part */
    BLOCKS = PARTS * PART,         /* growth is recorded this often */
    BATCHES = 32,                  /* for the standard error */
    TRANSIENT_PART = 10            /* the transient that is always left out is such a part of the time */
};

static const int batch_counts[CNS_LYAPUNOV_COUNTS] = {16, 32, 64, 128};
static const double invisible = 0.5e-9; /* differences of exponents that nine decimals do not show */
static const double covered = 2;        /* standard errors: the error tells of changes so small */
static const double below = 3;          /* standard errors below zero: negative; above it: positive */

/* Growth at the ends of blocks, from the first one's beginning on. */
typedef struct record {
    int n, d;
    double block;   /* its length */
    double *growth; /* of exponent i at the end of block k - 1: [i * (BLOCKS + 1) + k] */
    double *rate;   /* of exponent i in block k: [i * BLOCKS + k] */
    double *trace;  /* its integral, like growth; NULL: not followed */
} record;

static cns_code follow(record *r, cns_frame *f, double discarded, const cns_monitor *monitor, cns_error *err)
{
    const int lead = BLOCKS / TRANSIENT_PART;
    double *growth = cns_xalloc((size_t)r->n, sizeof *growth), trace = 0;
    cns_code code = CNS_OK;
    for (int k = 1 - lead; k <= BLOCKS && !code; k++) {
        const double t = discarded + k * r->block;
        code = cns_frame_at(f, t, growth, &trace, err);
        for (int i = 0; i < r->n && k >= 0; i++)
            r->growth[i * (BLOCKS + 1) + k] = growth[i];
        if (r->trace && k >= 0)
            r->trace[k] = trace;
        cns_monitor_tell(monitor, (double)(k + lead) / (BLOCKS + lead),
                         r->n > 1 ? "exponents" : "largest exponent");
    }
    free(growth);
    for (int i = 0; i < r->n && !code; i++)
        for (int k = 0; k < BLOCKS; k++)
            r->rate[i * BLOCKS + k] =
                (r->growth[i * (BLOCKS + 1) + k + 1] - r->growth[i * (BLOCKS + 1) + k]) / r->block;
    return code;
}

/* The mean of exponent i over blocks from..to-1. */
static double mean(const record *r, int i, int from, int to)
{
    const double *growth = r->growth + i * (BLOCKS + 1);
    return (growth[to] - growth[from]) / ((to - from) * r->block);
}

static double error(const record *r, int i, int from, int to, int batches)
{
    return cns_batch_error(r->rate + i * BLOCKS + from, to - from, batches);
}

/* The last block before the rate of an exponent changes, of those that change from block `from` on; false:
 * none does. */
static bool find_change(const record *r, int from, int *at, cns_lyapunov_change *change)
{
    *at = 0;
    for (int i = 0; i < r->n; i++) {
        const double least = fmax(covered * error(r, i, from, BLOCKS, BATCHES), invisible);
        const int k = cns_find_change(r->rate + i * BLOCKS + from, BLOCKS - from, BATCHES, least);
        if (k == 0 || from + k <= *at)
            continue;
        *at = from + k;
        *change = (cns_lyapunov_change){
            .exponent = i, .before = mean(r, i, from, *at), .after = mean(r, i, *at, BLOCKS)};
    }
    return *at > 0;
}

static const char *name_of(char *text, size_t size, const record *r, int i)
{
    snprintf(text, size, r->n > 1 ? "exponent %d" : "the tangent's growth", i + 1);
    return text;
}

/* Do the batches from block `from` on remember each other? Then the note says so. */
static bool remember(const record *r, int from, cns_lyapunov_result *result)
{
    char name[32];
    for (int i = 0; i < r->n; i++)
        if (error(r, i, from, BLOCKS, BATCHES) > invisible &&
            cns_batches_remember(r->rate + i * BLOCKS + from, BLOCKS - from, BATCHES)) {
            snprintf(result->note, sizeof result->note,
                     "the rate of %s varies over longer than the %.3g that a batch lasts",
                     name_of(name, sizeof name, r, i), (BLOCKS - from) * r->block / BATCHES);
            return true;
        }
    return false;
}

/* The block from which on growth is stationary; BLOCKS: there is none, and the note says why. */
static int find_beginning(const record *r, double discarded, cns_lyapunov_result *result)
{
    char name[32];
    cns_lyapunov_change *c = result->change;
    int at, from = 0;
    for (; result->changes < CNS_LYAPUNOV_CHANGES && from < BLOCKS; result->changes++, c++) {
        if (!find_change(r, from, &at, c))
            return remember(r, from, result) ? BLOCKS : from;
        c->t = discarded + at * r->block;
        /* The place of a change is known to about a batch. */
        from = (at + (BLOCKS - from) / BATCHES + PART - 1) / PART * PART;
    }
    name_of(name, sizeof name, r, result->change[0].exponent);
    if (result->changes > 1)
        snprintf(result->note, sizeof result->note,
                 "the rate of %s changes at t about %.3g, from %.3g to %.3g, and again at t about %.3g", name,
                 result->change[0].t, result->change[0].before, result->change[0].after, result->change[1].t);
    else
        snprintf(result->note, sizeof result->note,
                 "the rate of %s changes at t about %.3g, from %.3g to %.3g, and too little time follows",
                 name, result->change[0].t, result->change[0].before, result->change[0].after);
    return BLOCKS;
}

/* Exponent i over the blocks from `from` on. */
static void measure(const record *r, int i, int from, cns_exponent *e)
{
    const int n = BLOCKS - from;
    for (int k = 0; k < CNS_LYAPUNOV_ROWS; k++) {
        const int to = from + (k + 1) * (n / CNS_LYAPUNOV_ROWS);
        e->row[k].lambda = mean(r, i, from, to);
        e->row[k].se = error(r, i, from, to, BATCHES);
    }
    e->lambda = e->row[CNS_LYAPUNOV_ROWS - 1].lambda;
    e->se = e->row[CNS_LYAPUNOV_ROWS - 1].se;
    for (int b = 0; b < CNS_LYAPUNOV_COUNTS; b++)
        e->batch_se[b] = error(r, i, from, BLOCKS, batch_counts[b]);
}

/* How exponent i grew where there is no figure. */
static void tell(const record *r, int i, cns_exponent *e)
{
    const int n = BLOCKS / CNS_LYAPUNOV_ROWS;
    for (int k = 0; k < CNS_LYAPUNOV_ROWS; k++)
        e->row[k] = (cns_lyapunov_figure){mean(r, i, k * n, (k + 1) * n), NAN};
    e->lambda = e->se = NAN;
    for (int b = 0; b < CNS_LYAPUNOV_COUNTS; b++)
        e->batch_se[b] = NAN;
}

/* The error of sum_i weight[i] lambda_i over the blocks from `from` on. */
static double combined_error(const record *r, const double *weight, int from)
{
    double *x = cns_xalloc((size_t)(BLOCKS - from), sizeof *x);
    for (int i = 0; i < r->n; i++)
        for (int k = from; k < BLOCKS; k++)
            x[k - from] += weight[i] * r->rate[i * BLOCKS + k];
    const double se = cns_batch_error(x, BLOCKS - from, BATCHES);
    free(x);
    return se;
}

static void find_dimension(const record *r, int from, cns_lyapunov_result *result)
{
    double *weight = cns_xalloc((size_t)r->n, sizeof *weight), sum = 0;
    int j = 0;
    for (; j < r->n; j++) {
        const double next = sum + result->exponent[j].lambda;
        weight[j] = 1;
        if (next < -below * combined_error(r, weight, from) - invisible)
            break;
        sum = next;
    }
    result->dimension = j < r->n || r->n == r->d ? (double)j : NAN; /* j = n = d: no volume shrinks */
    result->dimension_se = 0;
    if (j > 0 && j < r->n) { /* with s the sum and l the next exponent: d(j - s/l) = -ds/l + s dl/l^2 */
        const double l = result->exponent[j].lambda;
        for (int i = 0; i < j; i++)
            weight[i] = -1 / l;
        weight[j] = sum / (l * l);
        result->dimension = j - sum / l;
        result->dimension_se = combined_error(r, weight, from);
    }
    free(weight);
}

static void find_sum(const record *r, const cns_frame *f, int from, cns_lyapunov_result *result)
{
    mpq_t trace;
    if (r->trace == NULL)
        return;
    result->sum = 0;
    for (int i = 0; i < r->n; i++)
        result->sum += result->exponent[i].lambda;
    result->trace = (r->trace[BLOCKS] - r->trace[from]) / ((BLOCKS - from) * r->block);
    mpq_init(trace);
    if (cns_frame_constant_trace(f, trace)) {
        result->exact_trace = mpq_get_str(NULL, 10, trace);
        result->trace = mpq_get_d(trace);
    }
    mpq_clear(trace);
}

cns_code cns_lyapunov(const cns_system *s, const cns_lyapunov_spec *spec, const cns_monitor *monitor,
                      cns_lyapunov_result *result, cns_error *err)
{
    const double time = cns_number_get_d(&spec->time);
    *result = (cns_lyapunov_result){.discarded = time / TRANSIENT_PART, .time = time};
    int *index = cns_xalloc((size_t)cns_program_states(cns_system_program(s)) + 1, sizeof *index);
    const int d = cns_dynamic_states(cns_system_program(s), index);
    free(index);
    const cns_frame_spec frame = {.system = s,
                                  .arithmetic = spec->arithmetic,
                                  .digits = spec->digits,
                                  .portable = spec->portable,
                                  .vectors = spec->exponents,
                                  .first = spec->tangent,
                                  .traced =
                                      spec->exponents != 1 && (spec->exponents == 0 || spec->exponents == d),
                                  .stop = cns_monitor_stop(monitor)};
    cns_frame *f = cns_frame_new(&frame, err);
    if (f == NULL)
        return err->code;
    const size_t n = (size_t)cns_frame_vectors(f);
    record r = {.n = (int)n, .d = d, .block = time / BLOCKS};
    r.growth = cns_xalloc(n * (BLOCKS + 1), sizeof *r.growth);
    r.rate = cns_xalloc(n * BLOCKS, sizeof *r.rate);
    r.trace = frame.traced ? cns_xalloc(BLOCKS + 1, sizeof *r.trace) : NULL;
    cns_code code = follow(&r, f, result->discarded, monitor, err);
    if (!code) {
        int from = find_beginning(&r, result->discarded, result);
        const bool found = from < BLOCKS;
        from = found ? from : 0;
        result->n = r.n;
        result->exponent = cns_xalloc(n, sizeof *result->exponent);
        result->discarded += from * r.block;
        result->time = (BLOCKS - from) * r.block;
        for (int i = 0; i < r.n; i++)
            if (found)
                measure(&r, i, from, &result->exponent[i]);
            else
                tell(&r, i, &result->exponent[i]);
        for (int k = 0; k < CNS_LYAPUNOV_ROWS; k++)
            result->t[k] = result->discarded + (k + 1) * (BLOCKS - from) / CNS_LYAPUNOV_ROWS * r.block;
        for (int b = 0; b < CNS_LYAPUNOV_COUNTS; b++)
            result->batches[b] = batch_counts[b];
        result->dimension = result->dimension_se = result->sum = result->trace = NAN;
        if (found) {
            find_dimension(&r, from, result);
            find_sum(&r, f, from, result);
        }
        if (found && result->exponent[0].lambda > below * result->exponent[0].se + invisible)
            result->attractors = cns_equilibria_attractors(s, monitor);
        result->order = cns_frame_order(f);
        result->steps = cns_flow_steps(cns_frame_flow(f));
        result->landings = cns_flow_landings(cns_frame_flow(f));
        if (!found)
            code = cns_fail(err, CNS_UNREACHED, "no figure: %s: take a longer lyapunov.time", result->note);
    }
    free(r.growth);
    free(r.rate);
    free(r.trace);
    cns_frame_free(f);
    return code;
}

void cns_lyapunov_result_clear(cns_lyapunov_result *r)
{
    free(r->exponent);
    free(r->exact_trace);
    free(r->attractors);
    r->attractors = NULL;
    r->exponent = NULL;
    r->exact_trace = NULL;
}
