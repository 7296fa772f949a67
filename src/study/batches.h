/* The error of a mean whose terms remember each other, by batch means: batches that are long enough do not.
 */
#ifndef CNS_STUDY_BATCHES_H
#define CNS_STUDY_BATCHES_H

/* The standard error of the mean of x[0..n-1] from `batches` batches of n / batches each, which must divide
 * n; at least 2. */
double cns_batch_error(const double *x, int n, int batches);

#endif
