#include "batches.h"

#include <math.h>
#include <stdlib.h>

#include "core/memory.h"

static const double remembers = 0.55, changes = 200;

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

/* The sum over j of (x[0] + ... + x[j] less its share of the whole)^2; step -1: x[0], x[-1], ... */
static double wandering(const double *x, int n, int step)
{
    double whole = 0, part = 0, squares = 0;
    for (int i = 0; i < n; i++)
        whole += x[i * step];
    for (int i = 0; i < n; i++) {
        part += x[i * step];
        const double away = part - whole * (i + 1) / n;
        squares += away * away;
    }
    return squares;
}

static double mean_of(const double *x, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += x[i];
    return sum / n;
}

int cns_find_change(const double *x, int n, int size, double least)
{
    const int sums = n / size;
    double *sum = irregular_sums(x, n, sums), part = 0, largest = changes;
    int found = 0;
    for (int k = 1; k < sums; k++) {
        part += sum[k - 1];
        const double v = wandering(sum, k, 1) + wandering(sum + sums - 1, sums - k, -1);
        if (part * part * sums > largest * v) {
            largest = part * part * sums / v;
            found = irregular_end(n, sums, k);
        }
    }
    free(sum);
    if (found > 0 && fabs(mean_of(x + found, n - found) - mean_of(x, n)) < least)
        found = 0;
    return found;
}
