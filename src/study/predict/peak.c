#include "peak.h"

#include <math.h>

static const double golden = 0.61803398874989485;
static const double margin = 0.25, fine = 1e-9; /* parts of the interval */

cns_peak cns_peak_find(double (*f)(void *context, double t), void *context, const double t[3],
                       const double value[3], double least)
{
    cns_peak best = {t[0], value[0]};
    for (int k = 1; k < 3; k++)
        if (value[k] > best.value)
            best = (cns_peak){t[k], value[k]};
    /* value[1] + slope s + bend s^2, s from -1 to 1 */
    const double slope = (value[2] - value[0]) / 2, bend = (value[2] + value[0]) / 2 - value[1];
    if (!(bend < 0) || !(fabs(slope) <= -2 * bend * (1 + 2 * margin)) ||
        !(value[1] - slope * slope / (4 * bend) >= least))
        return best;
    double a = t[0], b = t[2], c = b - golden * (b - a), d = a + golden * (b - a);
    const double resolution = (b - a) * fine;
    double at_c = f(context, c), at_d = f(context, d);
    while (b - a > resolution && a < c && c < d && d < b) {
        if (at_c > at_d) {
            b = d;
            d = c;
            at_d = at_c;
            c = b - golden * (b - a);
            at_c = f(context, c);
        } else {
            a = c;
            c = d;
            at_c = at_d;
            d = a + golden * (b - a);
            at_d = f(context, d);
        }
    }
    if (at_c > best.value)
        best = (cns_peak){c, at_c};
    if (at_d > best.value)
        best = (cns_peak){d, at_d};
    return best;
}
