/* Means of terms that remember each other: their error, and whether they have one.
 *
 * The error is that of batch means: batches that are long enough do not remember each other, and their
 * scatter tells the error of the whole. Two tests say where that fails. Batches of more than one term end at
 * irregular places: a period of the terms, which could be in step with regular ones, and then be overlooked,
 * looks like the noise that it is. */
#ifndef CNS_STUDY_BATCHES_H
#define CNS_STUDY_BATCHES_H

#include <stdbool.h>

/* The standard error of the mean of x[0..n-1] from 2 <= batches <= n batches of about the same length. */
double cns_batch_error(const double *x, int n, int batches);

/* Do batches remember each other, so that their error is too small? The correlation of neighbouring batches
 * (G. S. Fishman, Management Science 24 (1978) 510) is then above 0.55, more than three standard deviations
 * for 32 of them. Independent terms: 1 of 10000 series; terms that remember for a fifth of a batch, by which
 * the error becomes too small by a tenth: 1 of 1000 (measured). */
bool cns_batches_remember(const double *x, int n, int batches);

/* The place k at which the mean of x changes, x[0..k-1] before and x[k..n-1] after; 0: it does not. It does
 * where two means, for the batches before and after some place, at least two on either side, leave less than
 * 0.415 of the squares that one mean leaves: for 32 batches, where the difference of both is more than 6.5 of
 * its standard errors. Independent normal terms: 1 of 50000 series; independent batches with exponential
 * tails, or ones that remember their neighbours with correlation 0.3: 1 of 1000 (measured). The place is the
 * one that leaves the least squares of the terms. Changes by which the mean after k differs from that of the
 * whole by less than `least` do not count. */
int cns_find_change(const double *x, int n, int batches, double least);

#endif
