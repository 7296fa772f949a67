/* The fast arithmetic's speed: processor time per unit of integrated time, at the same digits, of the plain
 * engine and of the fast one with each kernel, on the falling disk with |omega| exact and smoothed and on
 * Lorenz's model; and how near the kernels come to what the processor can multiply.
 * Usage: bench_fast [DIGITS [MODEL]]: only those rows. */
#include <math.h>
#include <mpfr.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "cns/arith.h"
#include "cns/integrate.h"
#include "cns/model.h"
#include "cns/program.h"
#include "num/fixed.h"

enum { PLAIN, PORTABLE, IFMA, ENGINES, MOST_RUNS = 5, MOST_STATES = 8 };
static const char *const engines[ENGINES] = {"mpfr", "portable", "avx512ifma"};
static const char *const model_names[3] = {"apw", "apw, eps 1e-3", "lorenz"};
static double peak[ENGINES]; /* limb products of 52 by 52 bits per second */

static void die(const char *what)
{
    fprintf(stderr, "bench_fast: %s\n", what);
    exit(1);
}

static double cpu_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(const double *x, int n)
{
    double sorted[MOST_RUNS];
    memcpy(sorted, x, (size_t)n * sizeof *x);
    qsort(sorted, (size_t)n, sizeof *sorted, by_size);
    return n % 2 ? sorted[n / 2] : 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]);
}

/* Peaks: independent multiply-adds in registers. A limb product is two IFMA instructions for eight lanes, or
 * one multiplication and two additions of 64 bits. */

static double best_of(double (*rate)(void))
{
    double best = 0;
    for (int i = 0; i < 7; i++)
        best = fmax(best, rate());
    return best;
}

#ifdef FX_HAVE_IFMA
typedef unsigned long long lanes __attribute__((vector_size(64)));

#define CHAIN(n) "vpmadd52luq %%zmm31, %%zmm30, %%zmm" #n "\n\tvpmadd52huq %%zmm31, %%zmm30, %%zmm" #n "\n\t"
static double ifma_rate(void)
{
    const long loops = 2000000;
    double from = cpu_seconds();
    for (long i = 0; i < loops; i++)
        __asm__ volatile(CHAIN(0) CHAIN(1) CHAIN(2) CHAIN(3) CHAIN(4) CHAIN(5) CHAIN(6) CHAIN(7) CHAIN(8)
                             CHAIN(9) CHAIN(10) CHAIN(11) CHAIN(12) CHAIN(13) CHAIN(14) CHAIN(15)::
                                 : "xmm0", "xmm1", "xmm2", "xmm3", "xmm4", "xmm5", "xmm6", "xmm7", "xmm8",
                                   "xmm9", "xmm10", "xmm11", "xmm12", "xmm13", "xmm14", "xmm15");
    return 16.0 * 8.0 * (double)loops / (cpu_seconds() - from);
}
#endif

static double wide_rate(void)
{
    enum { TERMS = 64 };
    const long loops = 400000;
    static volatile uint64_t seed = 0x123456789abcd;
    uint64_t a[TERMS], b[TERMS];
    for (int i = 0; i < TERMS; i++) {
        a[i] = seed >> (i % 7);
        b[i] = seed >> (i % 5);
    }
    unsigned __int128 s0 = 0, s1 = 0, s2 = 0, s3 = 0;
    double from = cpu_seconds();
    for (long i = 0; i < loops; i++) {
        for (int j = 0; j < TERMS; j += 4) {
            s0 += (unsigned __int128)a[j] * b[j];
            s1 += (unsigned __int128)a[j + 1] * b[j + 1];
            s2 += (unsigned __int128)a[j + 2] * b[j + 2];
            s3 += (unsigned __int128)a[j + 3] * b[j + 3];
        }
        a[i & (TERMS - 1)] ^= (uint64_t)s0 & 1; /* not to be moved out of the loop */
    }
    double seconds = cpu_seconds() - from;
    seed ^= (uint64_t)(s0 + s1 + s2 + s3) & 1;
    return (double)TERMS * (double)loops / seconds;
}

/* Limb products of one expansion: kept pairs per term, rows falling with the order as fixed.h has it. Squares
 * count half their terms. */
static double products(int order, mpfr_prec_t prec, double convolutions)
{
    long limbs = (long)prec / FX_BITS + 2;
    double window = (double)prec + 12 + ceil(log2((order + 1.0) * (double)(limbs + 1))), sum = 0;
    for (int n = 0; n < order; n++) {
        double rows = ceil((window - 3.0 * n) / FX_BITS);
        rows = rows < 1 ? 1 : rows;
        sum += (n + 1) * rows * (rows + 1) / 2;
    }
    return sum * convolutions;
}

/* Of the programs: products, halves for squares. The disk: Vx^2, Vy^2, omega^2, s^2; Vx Vy, sin, cos, r s,
 * e s, two each for Vx', Vy', x', y'. Smoothed: the root's square, a square more, and a product with it. */
static const double convolutions[3] = {15, 16, 2};
static const double guard_bits = 28; /* what the engine adds to the precision */

/* One run. */

typedef struct problem {
    int kind; /* row of model_names */
    cns_program *program;
    cns_number initial[MOST_STATES];
    double scales[MOST_STATES];
} problem;

static void parse(cns_number *x, const char *text)
{
    cns_error err;
    cns_number_init(x);
    if (cns_number_parse(x, text, &err))
        die(err.text);
}

static void problem_init(problem *p, int kind)
{
    static const char *const start[2][MOST_STATES] = {{"0", "0", "1.7", "-0.45", "-0.3", "0.6"},
                                                      {"-15.8", "-17.48", "35.64"}};
    const cns_model *m = cns_model_find(kind == 2 ? "lorenz" : "apw");
    cns_number parameters[MOST_STATES], eps;
    cns_program_options options = {NULL};
    cns_error err;
    p->kind = kind;
    for (int i = 0; i < m->n_parameters; i++)
        parse(&parameters[i], m->parameters[i].standard);
    parse(&eps, "1e-3");
    if (kind == 1)
        options.smooth = &eps;
    if (cns_model_program(m, parameters, &options, &p->program, &err))
        die(err.text);
    for (int i = 0; i < m->n_parameters; i++)
        cns_number_clear(&parameters[i]);
    cns_number_clear(&eps);
    for (int i = 0; i < m->n_states; i++) {
        p->scales[i] = m->states[i].scale;
        parse(&p->initial[i], start[kind == 2][i]);
    }
}

static void problem_clear(problem *p)
{
    for (int i = 0; i < cns_program_states(p->program); i++)
        cns_number_clear(&p->initial[i]);
    cns_program_free(p->program);
}

typedef struct outcome {
    double per_time; /* seconds of processor time per unit of integrated time */
    double steps;    /* per unit of time */
    int order;
    mpfr_t *end; /* the states at the time asked for */
} outcome;

static void run(const problem *p, int engine, long digits, const char *until, outcome *out)
{
    const double tolerance_log2 = -(double)digits * 3.3219280948873623;
    const cns_arithmetic arithmetic = engine == PLAIN ? CNS_ARITH_MPFR : CNS_ARITH_FAST;
    const int n = cns_program_states(p->program);
    cns_flow_spec spec = {.program = p->program,
                          .scales = p->scales,
                          .method = CNS_METHOD_TAYLOR,
                          .arithmetic = arithmetic,
                          .prec = cns_digits_to_bits(digits),
                          .order = cns_order_for(tolerance_log2, arithmetic),
                          .tolerance_log2 = tolerance_log2};
    cns_error err;
    cns_number end;
    parse(&end, until);
    if (engine != PLAIN)
        setenv("CNS_KERNEL", engines[engine], 1);
    cns_flow *f = cns_flow_new(&spec, &err);
    if (!f)
        die(err.text);
    cns_flow_start(f, p->initial);
    if (cns_flow_step(f, &err)) /* constants, first guess of the step: not part of the cost per time */
        die(err.text);
    double since = mpfr_get_d(cns_flow_end(f), MPFR_RNDN), from = cpu_seconds();
    while (mpfr_cmp_q(cns_flow_end(f), end.ratio) < 0)
        if (cns_flow_step(f, &err))
            die(err.text);
    double seconds = cpu_seconds() - from, time = mpfr_get_d(cns_flow_end(f), MPFR_RNDN) - since;
    out->per_time = seconds / time;
    out->steps = (double)(cns_flow_steps(f) - 1) / time;
    out->order = spec.order;
    out->end = malloc((size_t)n * sizeof *out->end);
    if (!out->end)
        die("out of memory");
    for (int i = 0; i < n; i++)
        mpfr_init2(out->end[i], spec.prec);
    cns_flow_eval(f, end.ratio, out->end);
    cns_flow_free(f);
    cns_number_clear(&end);
}

static double agreed_digits(const problem *p, const outcome *a, const outcome *b)
{
    double least = HUGE_VAL;
    mpfr_t d;
    mpfr_init2(d, 64);
    for (int i = 0; i < cns_program_states(p->program); i++) {
        long e;
        mpfr_sub(d, a->end[i], b->end[i], MPFR_RNDN);
        if (mpfr_zero_p(d))
            continue;
        double m = fabs(mpfr_get_d_2exp(&e, d, MPFR_RNDN)) / p->scales[i];
        least = fmin(least, -(log2(m) + (double)e) / 3.3219280948873623);
    }
    mpfr_clear(d);
    return least;
}

static void outcome_clear(const problem *p, outcome *x)
{
    for (int i = 0; i < cns_program_states(p->program); i++)
        mpfr_clear(x->end[i]);
    free(x->end);
}

/* Short integrations: a row is a few seconds. */
static const struct {
    long digits;
    const char *until[3]; /* per kind; NULL: no such row */
    int runs;
} table[] = {{60, {"5", "3", "2"}, 5},
             {120, {"4", "2", "2"}, 5},
             {300, {"2", "0.8", "1"}, 3},
             {1000, {"0.2", NULL, "0.1"}, 1}};

static void row(const problem *p, long digits, const char *until, int runs, const bool *have)
{
    double seconds[ENGINES][MOST_RUNS], agreed = HUGE_VAL;
    outcome last[ENGINES];
    for (int r = 0; r < runs; r++)
        for (int i = 0; i < ENGINES; i++) {
            int engine = (r + i) % ENGINES;
            if (!have[engine])
                continue;
            if (r > 0)
                outcome_clear(p, &last[engine]);
            run(p, engine, digits, until, &last[engine]);
            seconds[engine][r] = last[engine].per_time;
        }
    printf("%-14s %6ld %5s", model_names[p->kind], digits, until);
    double plain = median(seconds[PLAIN], runs);
    printf("  %11.4g", plain);
    const mpfr_prec_t prec = cns_digits_to_bits(digits) + (mpfr_prec_t)guard_bits;
    for (int i = PORTABLE; i < ENGINES; i++) {
        if (!have[i]) {
            printf("  %11s %6s %5s", "-", "-", "-");
            continue;
        }
        double own = median(seconds[i], runs);
        double rate = products(last[i].order, prec, convolutions[p->kind]) * last[i].steps / own;
        printf("  %11.4g %5.1fx %4.0f%%", own, plain / own, 100 * rate / peak[i]);
        agreed = fmin(agreed, agreed_digits(p, &last[i], &last[PLAIN]));
    }
    printf("  %5.0f\n", agreed);
    fflush(stdout);
    for (int i = 0; i < ENGINES; i++)
        if (have[i])
            outcome_clear(p, &last[i]);
}

int main(int argc, char **argv)
{
    bool have[ENGINES] = {true, fx_kernel_choose("portable") != NULL, fx_kernel_choose("avx512ifma") != NULL};
    long only = argc > 1 ? atol(argv[1]) : 0;
    peak[PORTABLE] = best_of(wide_rate);
    printf("processor peaks, limb products per second: %.3g in 128-bit sums", peak[PORTABLE]);
#ifdef FX_HAVE_IFMA
    if (have[IFMA]) {
        peak[IFMA] = best_of(ifma_rate);
        printf(", %.3g by IFMA", peak[IFMA]);
    }
#endif
    printf("\nseconds of processor time per unit of integrated time, one thread; medians of runs in turn.\n"
           "x: times as fast as the plain engine; %%: limb products per second, of the peak; agreed: digits "
           "in common with\nthe plain engine at the end\n\n");
    printf("%-14s %6s %5s  %11s  %11s %6s %5s  %11s %6s %5s  %6s\n", "model", "digits", "until", "mpfr",
           "portable", "x", "%", "avx512ifma", "x", "%", "agreed");
    for (int kind = 0; kind < 3; kind++) {
        if (argc > 2 && strcmp(argv[2], model_names[kind]) != 0)
            continue;
        problem p;
        problem_init(&p, kind);
        for (size_t i = 0; i < sizeof table / sizeof *table; i++)
            if (table[i].until[kind] && (only == 0 || only == table[i].digits))
                row(&p, table[i].digits, table[i].until[kind], table[i].runs, have);
        problem_clear(&p);
    }
    return 0;
}
