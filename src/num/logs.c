#include "logs.h"

#include <math.h>

double cns_log2_2exp(double m, long e)
{
    int shift;
    m = frexp(m, &shift);
    double x = (double)e + shift;
    if (m < 0.70710678118654752440) {
        m *= 2;
        x -= 1;
    }
    /* ln m = 2 artanh z, z = (m-1)/(m+1), |z| < 0.172: z^13/13 is below 1e-11. */
    double z = (m - 1) / (m + 1), z2 = z * z, s = 0;
    for (int k = 11; k >= 1; k -= 2)
        s = s * z2 + 1.0 / k;
    return x + 2 * z * s * 1.4426950408889634074;
}

double cns_exp2_2exp(double x, long *e)
{
    double whole = floor(x), y = (x - whole) * 0.69314718055994530942, s = 1;
    for (int k = 14; k >= 1; k--) /* y < 0.7: y^15/15! is below 1e-14 */
        s = 1 + s * y / k;
    *e = (long)whole + 1;
    s /= 2;
    if (s >= 1) { /* rounding at the upper end */
        s /= 2;
        ++*e;
    }
    return s;
}

double cns_log10_2exp(double m, long e)
{
    return cns_log2_2exp(m, e) * CNS_LOG10_2;
}

double cns_log2_mpfr(mpfr_srcptr x)
{
    long e;
    if (mpfr_zero_p(x))
        return -HUGE_VAL;
    double m = fabs(mpfr_get_d_2exp(&e, x, MPFR_RNDN));
    return cns_log2_2exp(m, e);
}
