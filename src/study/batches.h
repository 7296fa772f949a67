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

/* The place k at which the mean of x changes, x[0..k-1] before and x[k..n-1] after; 0: it does not. The test
 * is that of X. Shao and X. Zhang (J. Amer. Stat. Assoc. 105 (2010) 1228), which assumes nothing about how
 * much the terms scatter: the largest over k of m D^2 / V, on m sums of `size` terms, D being the sum up to k
 * less its share of the whole, V the sum of squares of such quantities within both parts. It has to be above
 * 200. Independent terms: 1 of 10000 series; terms that remember for a 40th of the series: 1 of 1000
 * (measured). Changes by which the mean after k differs from that of the whole by less than `least` do not
 * count. */
int cns_find_change(const double *x, int n, int size, double least);

#endif
