#include "batches.h"

#include <math.h>
#include <stdlib.h>

#include "core/memory.h"

static const double remembers = 0.55, changes = 0.585;
enum { LEAST_BATCHES = 2 }; /* before a change, and after it */

/* Where batch b of `batches` ends: up to half a batch from its regular end, without any pattern. */
static int irregular_end(int n, int batches, int b)
{
    const double size = (double)n / batches, x = (double)b * b * 0.61803398874989484820;
    if (b == batches || n < 2 * batches)
        return (int)((long)n * b / batches);
    return (int)(size * (b + x - floor(x) - 0.5));
}

/* The sums of x less the mean of x over irregular batches; to be freed. */
static double *irregular_sums(const double *x, int n, int batches)
{
    double *sum = cns_xalloc((size_t)batches, sizeof *sum), mean = 0;
    for (int i = 0; i < n; i++)
        mean += x[i] / n;
    for (int b = 0, i = 0; b < batches; b++)
        for (const int end = irregular_end(n, batches, b + 1); i < end; i++)
            sum[b] += x[i] - mean;
    return sum;
}

double cns_batch_error(const double *x, int n, int batches)
{
    double *sum = irregular_sums(x, n, batches), squares = 0;
    for (int b = 0; b < batches; b++)
        squares += sum[b] * sum[b];
    free(sum);
    return sqrt(squares * batches / (batches - 1)) / n;
}

bool cns_batches_remember(const double *x, int n, int batches)
{
    double *sum = irregular_sums(x, n, batches), squares = 0, products = 0;
    for (int b = 0; b < batches; b++) {
        squares += sum[b] * sum[b];
        products += b > 0 ? sum[b - 1] * sum[b] : 0;
    }
    free(sum);
    return products > remembers * squares;
}

/* How much smaller sum_i (x[i] - mean)^2 is with a mean of their own for the first k terms and for the
 * others; part: the sum of the first k terms less k times the mean of all. */
static double explained(double part, int k, int n)
{
    return part * part * n / ((double)k * (n - k));
}

/* The k for which that is largest, at least `margin` from both ends. */
static int best_place(const double *x, int n, int margin, double *most)
{
    double mean = 0, part = 0;
    int place = 0;
    *most = 0;
    for (int i = 0; i < n; i++)
        mean += x[i] / n;
    for (int k = 1; k <= n - margin; k++) {
        part += x[k - 1] - mean;
        if (k >= margin && explained(part, k, n) > *most) {
            *most = explained(part, k, n);
            place = k;
        }
    }
    return place;
}

int cns_find_change(const double *x, int n, int batches, double least)
{
    double *sum = irregular_sums(x, n, batches), squares = 0, most;
    for (int b = 0; b < batches; b++)
        squares += sum[b] * sum[b];
    best_place(sum, batches, LEAST_BATCHES, &most);
    free(sum);
    if (!(most > changes * squares))
        return 0;
    const int at = best_place(x, n, LEAST_BATCHES * n / batches, &most);
    double whole = 0, after = 0;
    for (int i = 0; i < n; i++) {
        whole += x[i] / n;
        after += i >= at ? x[i] / (n - at) : 0;
    }
    return fabs(after - whole) < least ? 0 : at;
}
