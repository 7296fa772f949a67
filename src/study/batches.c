#include "batches.h"

#include <math.h>

double cns_batch_error(const double *x, int n, int batches)
{
    const int size = n / batches;
    double mean = 0, sum = 0;
    for (int i = 0; i < n; i++)
        mean += x[i] / n;
    for (int b = 0; b < batches; b++) {
        double deviation = 0;
        for (int i = 0; i < size; i++)
            deviation += x[b * size + i] - mean;
        deviation /= size;
        sum += deviation * deviation;
    }
    return sqrt(sum / ((double)batches * (batches - 1)));
}
