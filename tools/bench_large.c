/* Many digits: where the lanes of fixed.h, which are schoolbook products, lose to GMP's sub-quadratic ones
 * term by term, and where they lose to products of whole series.
 *
 * One term of a convolution: lanes keep the limb pairs of the upper triangle; GMP multiplies whole numbers of
 * as many bits (mpn_mul_n) and adds 2n limbs (mpn_add_n). One convolution of whole series, all its orders:
 * for lanes and for GMP the terms of all orders, each with the limbs that its order keeps; for whole series
 * one mpz_mul of both series packed with room for the sums (Kronecker substitution), and because coefficients
 * come one after the other, log2(N)/2 times that (relaxed multiplication, van der Hoeven 2002).
 *
 * usage: bench_large [MOST_DIGITS]      default 10000; 20000 takes some gigabytes */
#include <gmp.h>
#include <math.h>
#include <mpfr.h>
#include <stdio.h>
#include <stdlib.h>

#include "arith/fixed/fixed.h"
#include "cns/flow.h"
#include "core/clock.h"
#include "integrate/numerics.h"

enum { TERMS = 96, SIZES = 64, KERNELS = 2 };

static void die(const char *what)
{
    fprintf(stderr, "bench_large: %s\n", what);
    exit(1);
}

/* The least time of several bursts, each at least a few milliseconds long. */
typedef struct timing {
    double best, from;
    long bursts;
} timing;

static bool again(timing *t, double per_burst)
{
    enum { BURSTS = 7 };
    const double now = cns_process_seconds();
    if (t->bursts++ > 0)
        t->best = fmin(t->best, (now - t->from) / per_burst);
    t->from = cns_process_seconds();
    return t->bursts <= BURSTS;
}

static gmp_randstate_t random_state;

/* Seconds for one term of R limbs of 52 bits with this kernel. */
static double lanes_term(const fx_kernel *kernel, int R)
{
    const double pairs = 0.5 * R * R;
    const long repeats = 1 + (long)(3e6 / (pairs * TERMS));
    fx *F = cns_fx_create(2, TERMS, (mpfr_prec_t)FX_BITS * (R - 1), kernel);
    mpfr_t x;
    timing t = {.best = HUGE_VAL};
    if (!F)
        die("out of memory");
    F->next_decay = 1; /* so that all terms have the same number of limbs, or one less */
    cns_fx_begin(F, 1);
    mpfr_init2(x, (mpfr_prec_t)FX_BITS * R);
    for (int a = 0; a < 2; a++)
        for (int k = 0; k < TERMS; k++) {
            mpfr_urandomb(x, random_state);
            mpfr_div_2ui(x, x, (unsigned long)k + 1, MPFR_RNDN);
            cns_fx_set(F, a, k, x, false);
        }
    while (again(&t, (double)repeats))
        for (long i = 0; i < repeats; i++) {
            kernel->zero(F);
            kernel->conv(F, 1, 0, 1, TERMS - 1, 0, TERMS - 1);
        }
    mpfr_clear(x);
    cns_fx_destroy(F);
    return t.best / TERMS;
}

/* The same with GMP: n limbs of 64 bits hold the R of 52. */
static double gmp_term(int R)
{
    const mp_size_t n = ((mp_size_t)R * FX_BITS + GMP_NUMB_BITS - 1) / GMP_NUMB_BITS;
    const long repeats = 1 + (long)(3e6 / (pow((double)n, 1.6) * TERMS));
    const size_t bytes = (size_t)n * TERMS * sizeof(mp_limb_t);
    mp_limb_t *a = malloc(bytes), *b = malloc(bytes), *c = malloc(2 * (size_t)n * sizeof *c),
              *sum = calloc(2 * (size_t)n, sizeof *sum);
    timing t = {.best = HUGE_VAL};
    if (!a || !b || !c || !sum)
        die("out of memory");
    mpn_random(a, n * TERMS);
    mpn_random(b, n * TERMS);
    while (again(&t, (double)repeats))
        for (long i = 0; i < repeats; i++)
            for (int j = 0; j < TERMS; j++) {
                mpn_mul_n(c, a + n * j, b + n * (TERMS - 1 - j), n);
                mpn_add_n(sum, sum, c, 2 * n);
            }
    free(a);
    free(b);
    free(c);
    free(sum);
    return t.best / TERMS;
}

static double packed(double bits_each)
{
    mpz_t a, b, c;
    timing t = {.best = HUGE_VAL};
    mpz_inits(a, b, c, (mpz_ptr)0);
    mpz_urandomb(a, random_state, (mp_bitcnt_t)bits_each);
    mpz_urandomb(b, random_state, (mp_bitcnt_t)bits_each);
    mpz_mul(c, a, b);
    for (int i = 0; i < (bits_each < 3e7 ? 5 : 2) && again(&t, 1); i++)
        mpz_mul(c, a, b);
    again(&t, 1);
    mpz_clears(a, b, c, (mpz_ptr)0);
    return t.best;
}

/* Measured terms, at some sizes; between them the logarithm is interpolated. */
typedef struct curve {
    int n, R[SIZES];
    double seconds[SIZES];
} curve;

static double at(const curve *c, int R)
{
    int i = 1;
    while (i < c->n - 1 && c->R[i] < R)
        i++;
    const double x0 = log(c->R[i - 1]), x1 = log(c->R[i]), x = log(R);
    const double y0 = log(c->seconds[i - 1]), y1 = log(c->seconds[i]);
    return exp(y0 + (y1 - y0) * (x - x0) / (x1 - x0));
}

/* From which size on is b quicker for good? 0: nowhere measured. */
static int crossing(const curve *a, const curve *b)
{
    int from = 0;
    for (int i = a->n - 1; i >= 0 && b->seconds[i] < a->seconds[i]; i--)
        from = a->R[i];
    return from;
}

/* All orders of one convolution; where `other` is not NULL each order takes the quicker. */
static double all_orders(const fx *F, int order, const curve *c, const curve *other)
{
    double sum = 0;
    for (int n = 0; n < order; n++) {
        const int R = F->rows[n] > 1 ? F->rows[n] : 2;
        const double own = at(c, R);
        sum += (n + 1) * (other ? fmin(own, at(other, R)) : own);
    }
    return sum;
}

int main(int argc, char **argv)
{
    const double most = argc > 1 ? atof(argv[1]) : 10000;
    static const int some[] = {2,  4,  8,   12,  16,  20,  24,  32,  40,  48,  56,  64,
                               80, 96, 128, 160, 192, 256, 320, 400, 512, 640, 800, 960};
    const fx_kernel *kernels[KERNELS] = {cns_fx_kernel_find("portable"), cns_fx_kernel_find("avx512ifma")};
    curve lanes[KERNELS] = {{0}}, gmp = {0};
    gmp_randinit_default(random_state);
    printf("nanoseconds for one term of a convolution\n%6s %7s %12s %12s %12s\n", "limbs", "digits",
           "portable", "avx512ifma", "mpn");
    for (size_t i = 0; i < sizeof some / sizeof *some; i++) {
        const int R = some[i];
        gmp.R[gmp.n] = R;
        gmp.seconds[gmp.n++] = gmp_term(R);
        printf("%6d %7.0f", R, R * FX_BITS * 0.30103);
        for (int k = 0; k < KERNELS; k++) {
            curve *c = &lanes[k];
            if (!kernels[k]) {
                printf(" %12s", "-");
                continue;
            }
            c->R[c->n] = R;
            c->seconds[c->n] = lanes_term(kernels[k], R);
            printf(" %12.4g", 1e9 * c->seconds[c->n++]);
        }
        printf(" %12.4g\n", 1e9 * gmp.seconds[gmp.n - 1]);
        fflush(stdout);
    }
    for (int k = 0; k < KERNELS; k++)
        if (kernels[k]) {
            const int R = crossing(&lanes[k], &gmp);
            if (R)
                printf("mpn wins over %s from %d limbs on, %.0f digits\n", kernels[k]->name, R,
                       R * FX_BITS * 0.30103);
            else
                printf("mpn does not win over %s\n", kernels[k]->name);
        }
    printf(
        "\nseconds for one convolution of whole series, all orders; best: lanes or mpn, whichever is quicker "
        "at each order\n%7s %7s",
        "digits", "order");
    for (int k = 0; k < KERNELS; k++)
        if (kernels[k])
            printf(" %12s %12s", kernels[k]->name, "best");
    printf(" %12s %12s %12s\n", "mpn", "one product", "relaxed");
    static const long digits[] = {300, 1000, 2000, 3000, 5000, 7000, 10000, 20000};
    for (size_t i = 0; i < sizeof digits / sizeof *digits && (double)digits[i] <= most; i++) {
        const mpfr_prec_t prec = cns_digits_to_bits(digits[i]);
        const int order = cns_order_for(-(double)digits[i] * 3.3219280948873623, CNS_ARITH_FAST);
        fx *F =
            cns_fx_create(1, order, prec, cns_fx_kernel_find("portable")); /* for the limbs of each order */
        if (!F)
            die("out of memory");
        printf("%7ld %7d", digits[i], order);
        for (int k = 0; k < KERNELS; k++)
            if (kernels[k])
                printf(" %12.4g %12.4g", all_orders(F, order, &lanes[k], NULL),
                       all_orders(F, order, &lanes[k], &gmp));
        const double one = packed((2.0 * (double)prec + log2(order)) * order);
        printf(" %12.4g %12.4g %12.4g\n", all_orders(F, order, &gmp, NULL), one, one * log2(order) / 2);
        fflush(stdout);
        cns_fx_destroy(F);
    }
    gmp_randclear(random_state);
    return 0;
}
