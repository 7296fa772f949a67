#include "fit.h"

#include <math.h>
#include <stdlib.h>

#include "core/memory.h"

enum { BISECTIONS = 200, LARGE_DOF = 100000 };

double cns_student_within(double t, long dof)
{
    const double pi = 3.14159265358979323846;
    if (dof > LARGE_DOF)
        return erf(t / sqrt(2));
    const double theta = atan(t / sqrt((double)dof)), c = cos(theta), s = sin(theta);
    double term = dof % 2 ? c : 1, sum = dof == 1 ? 0 : term;
    for (long k = dof % 2 ? 3 : 2; k < dof; k += 2) {
        term *= c * c * (double)(k - 1) / (double)k;
        sum += term;
    }
    return dof % 2 ? 2 / pi * (theta + s * sum) : s * sum;
}

double cns_student_limit(double p, long dof)
{
    double low = 0, high = 1;
    while (cns_student_within(high, dof) < p && high < 1e300)
        high *= 2;
    for (int i = 0; i < BISECTIONS; i++) {
        const double middle = 0.5 * (low + high);
        if (cns_student_within(middle, dof) < p)
            low = middle;
        else
            high = middle;
    }
    return 0.5 * (low + high);
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double theil_sen(const double *x, const double *y, int n)
{
    const size_t pairs = (size_t)n * (size_t)(n - 1) / 2;
    double *slope = cns_xalloc(pairs, sizeof *slope);
    size_t k = 0;
    for (int i = 0; i < n; i++)
        for (int j = i + 1; j < n; j++)
            slope[k++] = (y[j] - y[i]) / (x[j] - x[i]);
    qsort(slope, pairs, sizeof *slope, compare);
    const double median = 0.5 * (slope[(pairs - 1) / 2] + slope[pairs / 2]);
    free(slope);
    return median;
}

/* The variance per unit of x of a walk: its increments, less their mean, are independent, and the slope that
 * does best for them runs from end to end. */
static double walk_of(const double *x, const double *y, int n)
{
    const double slope = (y[n - 1] - y[0]) / (x[n - 1] - x[0]);
    double sum = 0;
    for (int i = 1; i < n; i++) {
        const double d = x[i] - x[i - 1], r = y[i] - y[i - 1] - slope * d;
        sum += r * r / d;
    }
    return sum / (n - 2);
}

/* Solves L z = b in place, L the lower triangle of a. */
static void forward(const double *a, int n, double *z)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < i; j++)
            z[i] -= a[i * n + j] * z[j];
        z[i] /= a[i * n + i];
    }
}

/* Slope and its error by generalised least squares: points and line are made independent by the Cholesky
 * factor of the covariance, which is overwritten. NaN if the covariance is singular. */
static void generalised(double *cov, const double *x, const double *y, int n, cns_fit *f)
{
    double *one = cns_xalloc(3 * (size_t)n, sizeof *one), *u = one + n, *v = u + n;
    double s11 = 0, s1x = 0, sxx = 0, s1y = 0, sxy = 0;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            double s = cov[i * n + j];
            for (int k = 0; k < j; k++)
                s -= cov[i * n + k] * cov[j * n + k];
            cov[i * n + j] = i == j ? sqrt(s) : s / cov[j * n + j];
        }
        one[i] = 1;
        u[i] = x[i] - x[0];
        v[i] = y[i] - y[0];
    }
    forward(cov, n, one);
    forward(cov, n, u);
    forward(cov, n, v);
    for (int i = 0; i < n; i++) {
        s11 += one[i] * one[i];
        s1x += one[i] * u[i];
        sxx += u[i] * u[i];
        s1y += one[i] * v[i];
        sxy += u[i] * v[i];
    }
    const double determinant = s11 * sxx - s1x * s1x;
    f->slope_gls = (s11 * sxy - s1x * s1y) / determinant;
    f->slope_gls_se = sqrt(s11 / determinant);
    free(one);
}

cns_code cns_fit_line(const double *x, const double *y, int n, const cns_spread *spread, cns_fit *f,
                      cns_error *err)
{
    double mx = 0, my = 0, sxx = 0, sxy = 0, syy = 0, rss = 0;
    *f = (cns_fit){.n = n};
    if (n < 3)
        return cns_fail(err, CNS_USAGE, "a fit needs at least three points, not %d", n);
    for (int i = 0; i < n; i++) {
        if (!isfinite(x[i]) || !isfinite(y[i]) || (i > 0 && x[i] <= x[i - 1]))
            return cns_fail(err, CNS_USAGE, "point %d of a fit is not finite, or not in order", i);
        mx += x[i] / n;
        my += y[i] / n;
    }
    for (int i = 0; i < n; i++) {
        sxx += (x[i] - mx) * (x[i] - mx);
        sxy += (x[i] - mx) * (y[i] - my);
        syy += (y[i] - my) * (y[i] - my);
    }
    f->slope = sxy / sxx;
    f->intercept = my - f->slope * mx;
    for (int i = 0; i < n; i++) {
        const double r = y[i] - my - f->slope * (x[i] - mx);
        rss += r * r;
    }
    f->r2 = syy > 0 ? 1 - rss / syy : NAN;
    f->residual_sd = sqrt(rss / (n - 2));
    f->slope_robust = theil_sen(x, y, n);

    f->walk = spread->kind == CNS_SPREAD_GIVEN  ? spread->walk
              : spread->kind == CNS_SPREAD_WALK ? walk_of(x, y, n)
                                                : 0;
    f->jitter = spread->kind == CNS_SPREAD_GIVEN         ? spread->jitter
                : spread->kind == CNS_SPREAD_INDEPENDENT ? f->residual_sd * f->residual_sd
                                                         : 0;
    f->dof = spread->kind == CNS_SPREAD_GIVEN ? spread->dof : n - 2;
    double slope2 = 0, intercept2 = 0;
    double *cov = cns_xalloc((size_t)n * (size_t)n, sizeof *cov);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            const double c = f->walk * (fmin(x[i], x[j]) - spread->start) + (i == j ? f->jitter : 0);
            const double wi = (x[i] - mx) / sxx, wj = (x[j] - mx) / sxx;
            slope2 += c * wi * wj;
            intercept2 += c * (1.0 / n - mx * wi) * (1.0 / n - mx * wj);
            /* A constant added to all covariances changes no slope: from the first x on they are the walk's
             * alone, and never singular. */
            cov[i * n + j] = c + f->walk * (spread->start - x[0] + (x[n - 1] - x[0]) / n);
        }
    f->slope_se = sqrt(fmax(0, slope2));
    f->intercept_se = sqrt(fmax(0, intercept2));
    const double t = cns_student_limit(0.95, f->dof);
    f->slope_95 = t * f->slope_se;
    f->intercept_95 = t * f->intercept_se;
    f->slope_gls = f->slope;
    f->slope_gls_se = f->slope_se;
    if (f->walk > 0 || f->jitter > 0)
        generalised(cov, x, y, n, f);
    free(cov);
    return CNS_OK;
}
