/* The full table of speed: processor time per unit of integrated time of the plain engine, of the fast one
 * with each kernel, and of heyoka's multiprecision reals (tools/bench_heyoka.py), on the falling disk with
 * |omega| exact and smoothed and on Lorenz's model; and how near the kernels come to what the processor can
 * multiply.
 *
 * usage: bench_table [-r RUNS] [-y SCRIPT] [DIGITS [MODEL]]
 *   -r RUNS    medians of so many runs (default 5)
 *   -y SCRIPT  compare with heyoka through this script
 *   DIGITS     only these rows; 0: all
 *   MODEL      only this model */
#include <math.h>
#include <mpfr.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "arith/arith.h"
#include "arith/fixed/fixed.h"
#include "bench/bench.h"
#include "cns/flow.h"
#include "core/clock.h"
#include "integrate/numerics.h"
#include "taylor/jet.h"

static double peak[CNS_BENCH_ENGINES]; /* limb products of 52 by 52 bits per second */

static void die(const char *what)
{
    fprintf(stderr, "bench_table: %s\n", what);
    exit(1);
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
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
    double from = cns_process_seconds();
    for (long i = 0; i < loops; i++)
        __asm__ volatile(CHAIN(0) CHAIN(1) CHAIN(2) CHAIN(3) CHAIN(4) CHAIN(5) CHAIN(6) CHAIN(7) CHAIN(8)
                             CHAIN(9) CHAIN(10) CHAIN(11) CHAIN(12) CHAIN(13) CHAIN(14) CHAIN(15)::
                                 : "xmm0", "xmm1", "xmm2", "xmm3", "xmm4", "xmm5", "xmm6", "xmm7", "xmm8",
                                   "xmm9", "xmm10", "xmm11", "xmm12", "xmm13", "xmm14", "xmm15");
    return 16.0 * 8.0 * (double)loops / (cns_process_seconds() - from);
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
    double from = cns_process_seconds();
    for (long i = 0; i < loops; i++) {
        for (int j = 0; j < TERMS; j += 4) {
            s0 += (unsigned __int128)a[j] * b[j];
            s1 += (unsigned __int128)a[j + 1] * b[j + 1];
            s2 += (unsigned __int128)a[j + 2] * b[j + 2];
            s3 += (unsigned __int128)a[j + 3] * b[j + 3];
        }
        a[i & (TERMS - 1)] ^= (uint64_t)s0 & 1; /* not to be moved out of the loop */
    }
    double seconds = cns_process_seconds() - from;
    seed ^= (uint64_t)(s0 + s1 + s2 + s3) & 1;
    return (double)TERMS * (double)loops / seconds;
}

/* Limb products of one expansion: the convolutions of the program, counted by running it in double, each
 * term times the limb pairs that its order keeps (num/fixed.h). A square counts half its terms. */

static struct {
    const int *rows;
    double products;
} count;

static double kept(int n)
{
    const double rows = count.rows[n];
    return rows * (rows + 1) / 2;
}

static void counted_conv(cns_arith *A, int sign, int a, int b, int n, int lo, int hi)
{
    if (hi >= lo)
        count.products += (hi - lo + 1) * kept(n);
    cns_arith_double.conv(A, sign, a, b, n, lo, hi);
}

static void counted_square(cns_arith *A, int sign, int a, int n, int lo)
{
    if (n >= 2 * lo)
        count.products += ((n - 2 * lo) / 2 + 1) * kept(n);
    cns_arith_double.square(A, sign, a, n, lo);
}

static double products(const cns_system *p, int order, long digits)
{
    enum { H_LOG2 = -5, GUARD_BITS = 40 }; /* a small step: nothing overflows; what src/integrate adds */
    cns_error err;
    cns_arith_ops ops = cns_arith_double;
    ops.conv = counted_conv;
    ops.square = counted_square;
    ops.orders = NULL; /* which would call its own */
    cns_jet_spec spec = {.program = cns_system_program(p), .ops = &ops, .order = order, .prec = 53};
    cns_jet *J = cns_jet_new(&spec, &err);
    fx *F = cns_fx_create(1, order, cns_digits_to_bits(digits) + GUARD_BITS, cns_fx_kernel_find("portable"));
    if (!J || !F)
        die("out of memory");
    mpfr_t x;
    mpfr_init2(x, 53);
    cns_jet_begin(J, ldexp(1, H_LOG2));
    for (int i = 0; i < cns_program_states(cns_system_program(p)); i++) {
        cns_number_get_mpfr(x, &cns_system_initial(p)[i]);
        cns_jet_set_state(J, i, x);
    }
    mpfr_clear(x);
    count.rows = F->rows;
    count.products = 0;
    if (cns_jet_expand(J, order, &err))
        die(err.text);
    cns_fx_destroy(F);
    cns_jet_free(J);
    return count.products;
}

/* heyoka. Its tolerance, and the precision with it, are moved until the digits that are right at the end are
 * those of the plain engine, to within one, or one in a hundred. */

typedef struct heyoka_result {
    int runs;
    double seconds;
    double right;
    long digits; /* asked for in the end */
} heyoka_result;

static bool heyoka_run(const char *script, const cns_system *p, const cns_bench_row *row, long digits,
                       int runs, const mpfr_t *truth, heyoka_result *result)
{
    enum { LINE = 1 << 14 };
    static char line[LINE];
    const int n = cns_program_states(cns_system_program(p));
    int states = 0;
    snprintf(line, sizeof line, "python3 '%s' '%s' %ld %.17g %d", script, cns_bench_system_name(row->system),
             digits, row->until, runs);
    FILE *f = popen(line, "r");
    if (!f)
        return false;
    double seconds[CNS_BENCH_RUNS];
    mpfr_t *end = malloc((size_t)n * sizeof *end);
    if (!end)
        die("out of memory");
    for (int i = 0; i < n; i++)
        mpfr_init2(end[i], cns_digits_to_bits(digits) + 64);
    *result = (heyoka_result){.digits = digits};
    while (fgets(line, sizeof line, f)) {
        if (!strncmp(line, "run ", 4) && result->runs < CNS_BENCH_RUNS)
            seconds[result->runs++] = atof(line + 4);
        else if (!strncmp(line, "state ", 6) && states < n)
            states += !mpfr_set_str(end[states], strtok(line + 6, "\n"), 10, MPFR_RNDN);
    }
    const bool good = pclose(f) == 0 && result->runs > 0 && states == n;
    if (good) {
        qsort(seconds, (size_t)result->runs, sizeof *seconds, by_size);
        result->seconds = 0.5 * (seconds[result->runs / 2] + seconds[(result->runs - 1) / 2]);
        result->right = cns_bench_agreed(p, (const mpfr_t *)end, truth);
    }
    for (int i = 0; i < n; i++)
        mpfr_clear(end[i]);
    free(end);
    return good;
}

static bool heyoka(const char *script, const cns_system *p, const cns_bench_row *row, int runs,
                   heyoka_result *result)
{
    enum { TRIES = 3 };
    cns_error err;
    cns_bench_run truth = {0};
    const double wanted = row->cells[CNS_BENCH_MPFR].right, slack = fmax(1, (double)row->digits / 100);
    long digits = row->digits;
    bool good = true;
    if (cns_bench_reference(p, row->digits, row->until, NULL, &truth, &err))
        die(err.text);
    for (int i = 0; i < TRIES && good; i++) {
        good = heyoka_run(script, p, row, digits, runs, (const mpfr_t *)truth.end, result);
        if (!good || fabs(result->right - wanted) <= slack)
            break;
        digits += lround(wanted - result->right);
    }
    cns_bench_run_clear(&truth);
    return good;
}

static const struct {
    long digits;
    double until[CNS_BENCH_SYSTEMS];
} table[] = {{60, {5, 3, 2}}, {120, {4, 2, 2}}, {300, {1, 0.6, 0.5}}, {1000, {0.2, 0.2, 0.04}}};

static void one_row(cns_bench_row *row, int runs, const char *script)
{
    cns_error err;
    const cns_bench_spec spec = {.runs = runs};
    cns_system *p = cns_bench_system_new(row->system, &err);
    if (!p || cns_bench_fill(&spec, row, 1, &err))
        die(err.text);
    const cns_bench_cell *plain = &row->cells[CNS_BENCH_MPFR];
    const double own = cns_bench_median(plain);
    double best = own, right = plain->right;
    printf("%-14s %6ld %5g  %10.4g", cns_bench_system_name(row->system), row->digits, row->until, own);
    for (int e = CNS_BENCH_PORTABLE; e < CNS_BENCH_ENGINES; e++) {
        const cns_bench_cell *c = &row->cells[e];
        if (c->runs == 0) {
            printf("  %10s %6s %4s", "-", "-", "-");
            continue;
        }
        const double seconds = cns_bench_median(c);
        printf("  %10.4g %5.1fx %3.0f%%", seconds, own / seconds,
               100 * products(p, c->order, row->digits) * c->steps / seconds / peak[e]);
        best = fmin(best, seconds);
        right = fmin(right, c->right);
    }
    printf("  %6.1f", right);
    fflush(stdout);
    heyoka_result h;
    if (script && heyoka(script, p, row, runs, &h))
        printf("  %10.4g %5.1fx %4ld %6.1f %4d", h.seconds, h.seconds / best, h.digits, h.right, h.runs);
    putchar('\n');
    fflush(stdout);
    cns_system_free(p);
}

int main(int argc, char **argv)
{
    int option, runs = CNS_BENCH_RUNS;
    const char *script = NULL;
    while ((option = getopt(argc, argv, "r:y:")) != -1) {
        if (option == 'r')
            runs = atoi(optarg);
        else if (option == 'y')
            script = optarg;
        else
            return 2;
    }
    if (runs < 1 || runs > CNS_BENCH_RUNS)
        die("-r takes 1 to 5");
    const long only = optind < argc ? atol(argv[optind]) : 0;
    const char *only_model = optind + 1 < argc ? argv[optind + 1] : NULL;
    peak[CNS_BENCH_PORTABLE] = best_of(wide_rate);
    printf("processor peaks, limb products per second: %.3g in 128-bit sums", peak[CNS_BENCH_PORTABLE]);
#ifdef FX_HAVE_IFMA
    if (cns_bench_has(CNS_BENCH_IFMA)) {
        peak[CNS_BENCH_IFMA] = best_of(ifma_rate);
        printf(", %.3g by IFMA", peak[CNS_BENCH_IFMA]);
    }
#endif
    printf(
        "\nseconds of processor time per unit of integrated time, one thread; medians of %d runs in turn.\n"
        "x: times as fast as the plain engine; %%: limb products per second, of the peak; right: digits "
        "right at the end, the least\n",
        runs);
    if (script)
        puts(
            "heyoka: its real; x: how many times as long as the fastest kernel; asked: its digits, such that "
            "as many\nare right at the end as with the plain engine (to one, or one in a hundred)");
    printf("\n%-14s %6s %5s  %10s  %10s %6s %4s  %10s %6s %4s  %6s", "model", "digits", "until", "mpfr",
           "portable", "x", "%", "avx512ifma", "x", "%", "right");
    if (script)
        printf("  %10s %6s %4s %6s %4s", "heyoka", "x", "asked", "right", "runs");
    putchar('\n');
    for (int s = 0; s < CNS_BENCH_SYSTEMS; s++) {
        if (only_model && strcmp(only_model, cns_bench_system_name((cns_bench_system)s)) != 0)
            continue;
        for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
            cns_bench_row row = {
                .system = (cns_bench_system)s, .digits = table[i].digits, .until = table[i].until[s]};
            if (only == 0 || only == row.digits)
                one_row(&row, runs, script);
        }
    }
    return 0;
}
