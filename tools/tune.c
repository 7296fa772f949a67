/* Measures the constants of the committed rule for order, step and guard bits, and prints what each costs
 * beside what the program has. It changes nothing: results must not depend on the machine, so a constant is
 * changed by hand, in src/integrate, and for every machine.
 *
 * usage: tune [order|decay|small]...     all by default; tune order:DIGITS for one number of digits
 *   order  bits by which coefficients fall per order (cns_order_for): processor time per unit of integrated
 *          time for orders about the rule's choice, relative to the rule's
 *   decay  bits per order that the fixed-point window falls by, and guard bits: one expansion per unit of H
 *   small  few digits and low orders: the fast arithmetic against the plain engine */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arith/fast.h"
#include "bench/bench.h"
#include "cns/flow.h"
#include "core/clock.h"
#include "integrate/numerics.h"
#include "num/logs.h"
#include "taylor/jet.h"

static void die(const char *what)
{
    fprintf(stderr, "tune: %s\n", what);
    exit(1);
}

static cns_system *problem(cns_bench_system system)
{
    cns_error err;
    cns_system *p = cns_bench_system_new(system, &err);
    if (!p)
        die(err.text);
    return p;
}

/* What one choice costs: repeats do the same steps, and the least time that each step took, which other
 * programs on the machine have disturbed least, is what it costs. */
typedef struct cost {
    int taken;
    double *least; /* seconds of each step */
    double covered, steps;
} cost;

static void measure(cost *c, const cns_system *p, cns_bench_engine engine, long digits, int order,
                    double until)
{
    cns_error err;
    cns_bench_run run = {0};
    const cns_bench_job job = {.engine = engine, .digits = digits, .order = order, .until = until};
    if (cns_bench_measure(p, &job, &run, &err))
        die(err.text);
    if (!c->least) {
        *c = (cost){.taken = run.taken, .least = run.each, .covered = run.covered, .steps = run.steps};
        run.each = NULL;
    } else if (c->taken != run.taken) {
        die("a repeat took other steps");
    }
    for (int i = 0; i < run.taken && run.each; i++)
        c->least[i] = fmin(c->least[i], run.each[i]);
    cns_bench_run_clear(&run);
}

/* Per unit of time. */
static double total(const cost *c)
{
    double sum = 0;
    for (int i = 0; i < c->taken; i++)
        sum += c->least[i];
    return sum / c->covered;
}

/* Orders. All candidates take turns; the least of several rounds is what the candidate costs. */

enum { ROUNDS = 300, LEAST_ROUNDS = 3 };

static const double candidates[] = {2.65, 2.75, 2.85, 2.95, 3.0, 3.05, 3.1, 3.2, 3.35, 3.5};
enum { CANDIDATES = sizeof candidates / sizeof *candidates };

static double committed_bits(void)
{
    enum { FEW = -100000, MANY = -1000000 };
    return (FEW - MANY) / (double)(cns_order_for(MANY, CNS_ARITH_FAST) - cns_order_for(FEW, CNS_ARITH_FAST));
}

static int order_by(double bits, long digits)
{
    return (int)(1.5 + (double)digits * CNS_LOG2_10 / bits) + 1; /* as cns_order_for() rounds */
}

static void order_row(cns_bench_system system, cns_bench_engine engine, long digits, double *log_sum)
{
    const double seconds = 8; /* for a row, about */
    cns_system *p = problem(system);
    cost rule = {0}, each[CANDIDATES] = {{0}};
    const double until = system == CNS_BENCH_LORENZ ? 1 : 3, began = cns_process_seconds();
    for (int r = 0; r < ROUNDS && (r < LEAST_ROUNDS || cns_process_seconds() - began < seconds); r++) {
        measure(&rule, p, engine, digits, 0, until);
        for (int i = 0; i < CANDIDATES; i++) {
            const int turn = (i + r) % CANDIDATES;
            measure(&each[turn], p, engine, digits, order_by(candidates[turn], digits), until);
        }
    }
    int least = 0;
    printf("%-8s %-10s %6ld %9.4g", cns_bench_system_name(system), cns_bench_engine_name(engine), digits,
           total(&rule));
    for (int i = 0; i < CANDIDATES; i++) {
        const double ratio = total(&each[i]) / total(&rule);
        printf(" %5.3f", ratio);
        log_sum[i] += log(ratio);
        least = total(&each[i]) < total(&each[least]) ? i : least;
    }
    printf("   %.2f\n", candidates[least]);
    fflush(stdout);
    for (int i = 0; i < CANDIDATES; i++)
        free(each[i].least);
    free(rule.least);
    cns_system_free(p);
}

static void tune_order(long only)
{
    static const long digits[] = {30, 60, 120, 300, 600, 1000};
    const cns_bench_system systems[] = {CNS_BENCH_APW, CNS_BENCH_LORENZ};
    printf("\nTime with the order -log2(tolerance)/bits, over the time with the committed %.2f bits per "
           "order\n%-8s %-10s %6s %9s",
           committed_bits(), "model", "kernel", "digits", "s / unit");
    for (int i = 0; i < CANDIDATES; i++)
        printf(" %5.2f", candidates[i]);
    puts("   least");
    for (int e = CNS_BENCH_PORTABLE; e < CNS_BENCH_ENGINES; e++) {
        if (!cns_bench_has((cns_bench_engine)e))
            continue;
        double log_sum[CANDIDATES] = {0};
        int rows = 0, least = 0;
        for (size_t d = 0; d < sizeof digits / sizeof *digits; d++) {
            /* The portable kernel takes minutes beyond, and tells nothing else. */
            if (only ? digits[d] != only : digits[d] > (e == CNS_BENCH_IFMA ? 600 : 300))
                continue;
            for (int s = 0; s < 2; s++, rows++)
                order_row(systems[s], (cns_bench_engine)e, digits[d], log_sum);
        }
        printf("%-8s %-10s %6s %9s", "mean", cns_bench_engine_name((cns_bench_engine)e), "", "");
        for (int i = 0; i < CANDIDATES && rows > 0; i++) {
            printf(" %5.3f", exp(log_sum[i] / rows));
            least = log_sum[i] < log_sum[least] ? i : least;
        }
        printf("   %.2f\n", candidates[least]);
    }
}

/* Decay of the window, and guard bits: one expansion at the start with the H for which coefficients fall by
 * so many bits per order. The radius of convergence is taken from an expansion in MPFR. */

typedef struct expansion {
    cns_jet *J;
    int order;
    double H, best, noise;
} expansion;

/* False where the coefficients do not fit. */
static bool expand(const cns_system *p, const mpfr_t *state, cns_jet *J, int order, double H)
{
    cns_error err;
    cns_jet_begin(J, H);
    for (int i = 0; i < cns_program_states(cns_system_program(p)); i++)
        cns_jet_set_state(J, i, state[i]);
    return !cns_jet_expand(J, order, &err);
}

/* The step at which the last coefficients are below 2^-tolerance. */
static double step_for(const cns_system *p, const mpfr_t *state, int order, double tolerance)
{
    enum { PREC = 128, TESTED = 4 };
    cns_error err;
    const cns_jet_spec spec = {
        .program = cns_system_program(p), .ops = &cns_arith_mpfr, .order = order, .prec = PREC};
    cns_jet *J = cns_jet_new(&spec, &err);
    if (!J)
        die(err.text);
    if (!expand(p, state, J, order, 1))
        die("no expansion in MPFR");
    double best = HUGE_VAL;
    for (int k = order - TESTED + 1; k <= order; k++)
        for (int i = 0; i < cns_program_states(cns_system_program(p)); i++) {
            long e;
            const double m = fabs(cns_jet_coefficient_2exp(J, &e, i, k));
            if (m > 0 && cns_program_is_dynamic(cns_system_program(p), i))
                best = fmin(best, (-tolerance - cns_log2_2exp(m, e)) / k);
        }
    cns_jet_free(J);
    return exp2(best);
}

/* What the fast arithmetic allows for noise, in bits above the tolerance: src/integrate/taylor.c. */
enum { NOISE_ALLOWED = 10, STATE_GUARD = 17 };

/* The worst bound on the noise of expansions along the arc, with these steps. */
static double worst_noise(const cns_system *p, cns_jet *J, int order, double tolerance)
{
    enum { POINTS = 24 };
    static const double end = 7.5;
    cns_error err;
    double worst = -HUGE_VAL;
    bool fits = false;
    for (int i = 0; i < POINTS; i++) {
        cns_bench_run run = {0};
        const cns_bench_job job = {
            .engine = CNS_BENCH_PORTABLE, .digits = 16, .until = 1e-3 + end * i / POINTS};
        if (cns_bench_measure(p, &job, &run, &err))
            die(err.text);
        const double H = step_for(p, (const mpfr_t *)run.end, order, tolerance);
        for (int again = 0; again < 2; again++) /* block exponents are learnt from one to the next */
            fits = expand(p, (const mpfr_t *)run.end, J, order, H);
        worst = fmax(worst, fits ? cns_arith_fast.noise_log2(cns_jet_arith(J)) : HUGE_VAL);
        cns_bench_run_clear(&run);
    }
    return worst;
}

static void decay_row(long digits)
{
    static const struct {
        double bits;
        int decay, guard;
    } choice[] = {{2.05, 2, 40}, {2.2, 2, 40}, {2.5, 2, 40},  {2.9, 2, 40},  {2.65, 3, 40},
                  {2.8, 3, 40},  {2.9, 3, 40}, {3.05, 3, 40}, {3.05, 2, 40}, {3.5, 3, 40},
                  {4.05, 4, 40}, {3.05, 3, 0}, {3.05, 3, 20}, {3.05, 3, 60}};
    enum { CHOICES = sizeof choice / sizeof *choice, COMMITTED = 7, REPEATS = 2000, BURST = 2 };
    const double seconds = 12, tolerance = (double)digits * CNS_LOG2_10;
    cns_system *p = problem(CNS_BENCH_APW);
    expansion x[CHOICES];
    cns_error err;
    cns_bench_run at = {0};
    const cns_bench_job job = {.engine = CNS_BENCH_PORTABLE, .digits = digits, .until = 1e-9};
    if (cns_bench_measure(p, &job, &at, &err))
        die(err.text);
    for (int c = 0; c < CHOICES; c++) {
        x[c].order = order_by(choice[c].bits, digits);
        const cns_jet_spec spec = {.program = cns_system_program(p),
                                   .ops = &cns_arith_fast,
                                   .order = x[c].order,
                                   .prec = cns_digits_to_bits(digits) + choice[c].guard};
        x[c].J = cns_jet_new(&spec, &err);
        if (!x[c].J)
            die(err.text);
        cns_fast_set_decay(cns_jet_arith(x[c].J), choice[c].decay);
        x[c].best = HUGE_VAL;
        x[c].noise = worst_noise(p, x[c].J, x[c].order, tolerance);
        x[c].H = step_for(p, (const mpfr_t *)at.end, x[c].order, tolerance);
        for (int i = 0; i < BURST; i++)
            expand(p, (const mpfr_t *)at.end, x[c].J, x[c].order, x[c].H);
    }
    const double began = cns_process_seconds();
    for (int r = 0; r < REPEATS && (r < LEAST_ROUNDS || cns_process_seconds() - began < seconds); r++)
        for (int c = 0; c < CHOICES; c++) {
            const double from = cns_process_seconds();
            for (int i = 0; i < BURST; i++)
                expand(p, (const mpfr_t *)at.end, x[c].J, x[c].order, x[c].H);
            x[c].best = fmin(x[c].best, (cns_process_seconds() - from) / BURST / x[c].H);
        }
    const double allowed = NOISE_ALLOWED - STATE_GUARD;
    for (int c = 0; c < CHOICES; c++) {
        const double noise = x[c].noise + tolerance;
        printf("%6ld %6.2f %6d %6d %6d %10.4g %7.3f %8.1f%s\n", digits, choice[c].bits, choice[c].decay,
               choice[c].guard, x[c].order, x[c].best, x[c].best / x[COMMITTED].best, noise,
               noise == HUGE_VAL ? "  does not fit"
               : noise > allowed ? "  too much"
                                 : "");
        cns_jet_free(x[c].J);
    }
    fflush(stdout);
    cns_bench_run_clear(&at);
    cns_system_free(p);
}

static void tune_decay(long only)
{
    static const long digits[] = {60, 120, 300};
    cns_error err;
    if (cns_fast_choose_kernel(getenv("CNS_KERNEL"), &err))
        die(err.text);
    printf(
        "\nOne expansion of the disk at t = 0 over its step H, kernel %s, beside bits per order, decay and "
        "guard bits as committed (3.05, 3, 40);\nnoise: log2 of its bound over the tolerance, the most on "
        "the way to t = 7.5; %d is allowed\n%6s %6s %6s %6s %6s %10s %7s %8s\n",
        cns_fast_kernel_name(), NOISE_ALLOWED - STATE_GUARD, "digits", "bits", "decay", "guard", "order",
        "s / unit", "ratio", "noise");
    for (size_t d = 0; d < sizeof digits / sizeof *digits; d++)
        if (!only || digits[d] == only)
            decay_row(digits[d]);
}

/* Few digits, low orders: a given number of steps from the start, so that a low order with many digits does
 * not take for ever. */

static void small_row(cns_bench_system system, long digits, int order)
{
    enum { STEPS = 200, SMALL_ROUNDS = 60 };
    const double seconds = 2; /* for a row, about */
    cns_system *p = problem(system);
    cost first = {0}, cost_of[CNS_BENCH_ENGINES] = {{0}};
    measure(&first, p, CNS_BENCH_MPFR, digits, order, 1e-9);
    const double until = STEPS / first.steps, began = cns_process_seconds();
    free(first.least);
    for (int r = 0; r < SMALL_ROUNDS && (r < LEAST_ROUNDS || cns_process_seconds() - began < seconds); r++)
        for (int e = 0; e < CNS_BENCH_ENGINES; e++)
            if (cns_bench_has((cns_bench_engine)e))
                measure(&cost_of[e], p, (cns_bench_engine)e, digits, order, until);
    printf("%-8s %6ld", cns_bench_system_name(system), digits);
    if (order)
        printf(" %6d", order);
    else
        printf(" %6s", "auto");
    const double plain = total(&cost_of[CNS_BENCH_MPFR]);
    printf(" %10.4g", plain);
    for (int e = CNS_BENCH_PORTABLE; e < CNS_BENCH_ENGINES; e++)
        if (cost_of[e].least)
            printf(" %10.2f", plain / total(&cost_of[e]));
    putchar('\n');
    fflush(stdout);
    for (int e = 0; e < CNS_BENCH_ENGINES; e++)
        free(cost_of[e].least);
    cns_system_free(p);
}

static void tune_small(long only)
{
    static const long digits[] = {10, 16, 20, 25, 30};
    static const int orders[] = {4, 8, 12, 20, 0};
    const cns_bench_system systems[] = {CNS_BENCH_APW, CNS_BENCH_LORENZ};
    printf("\nFew digits and low orders: the plain engine's seconds per unit of time, and how many times as "
           "fast each kernel is\n%-8s %6s %6s %10s",
           "model", "digits", "order", "mpfr");
    for (int e = CNS_BENCH_PORTABLE; e < CNS_BENCH_ENGINES; e++)
        if (cns_bench_has((cns_bench_engine)e))
            printf(" %10s", cns_bench_engine_name((cns_bench_engine)e));
    putchar('\n');
    for (int s = 0; s < 2; s++)
        for (size_t d = 0; d < sizeof digits / sizeof *digits; d++)
            for (size_t o = 0; o < sizeof orders / sizeof *orders; o++)
                if (!only || digits[d] == only)
                    small_row(systems[s], digits[d], orders[o]);
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        void (*tune)(long only_digits);
    } part[] = {{"order", tune_order}, {"decay", tune_decay}, {"small", tune_small}};
    enum { PARTS = sizeof part / sizeof *part };
    for (int i = 0; i < PARTS && argc == 1; i++)
        part[i].tune(0);
    for (int a = 1; a < argc; a++) {
        const char *colon = strchr(argv[a], ':');
        const size_t n = colon ? (size_t)(colon - argv[a]) : strlen(argv[a]);
        bool known = false;
        for (int i = 0; i < PARTS; i++)
            if (strlen(part[i].name) == n && !strncmp(part[i].name, argv[a], n)) {
                part[i].tune(colon ? atol(colon + 1) : 0);
                known = true;
            }
        if (!known)
            die("usage: tune [order|decay|small][:DIGITS]...");
    }
    return 0;
}
