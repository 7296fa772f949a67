#include "laws_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "fit.h"

enum {
    DIGITS_A_WINDOW = 8, /* of mean growth */
    MOST_WINDOWS = 64,
    LEAST_WINDOWS = 10,
    LEAST_GROWTH = 1, /* digits, before a T_c says something of growth */
    SURE = 3,         /* standard errors by which lambda must be above zero for a line */
    WHY = 256
};

/* The statistics of growth along the reference, by windows. The fluctuation of growth has a bounded part,
 * too, which comes and goes within a few digits: in short windows it passes for a stronger walk (0.20 digits
 * per root of time in windows of 5 time units, 0.12 in 40, 0.08 in 160, for the falling disk at I = 2.2). So
 * windows have eight digits of mean growth each where the reference is long enough for ten of them; in a
 * short one they are shorter, and the errors err towards too large. */
static void statistics(const cns_laws_work *l, cns_laws_result *r)
{
    const cns_law_reference *ref = &l->ref;
    const int rows = ref->rows - 1;
    const double time = rows * l->every, total = ref->growth[rows];
    long windows = (long)(total / DIGITS_A_WINDOW);
    windows = windows > MOST_WINDOWS ? MOST_WINDOWS : windows < LEAST_WINDOWS ? LEAST_WINDOWS : windows;
    double sum = 0;
    r->rate = total / time;
    for (long k = 0; k < windows; k++) {
        const int a = (int)(rows * k / windows), b = (int)(rows * (k + 1) / windows);
        const double d = ref->growth[b] - ref->growth[a] - r->rate * (b - a) * l->every;
        sum += d * d / fmax(l->every, (b - a) * l->every);
    }
    r->windows = windows;
    r->variance = sum / (double)(windows - 1);
    r->lambda = r->rate * log(10);
    r->lambda_se = sqrt(r->variance / time) * log(10);
}

static void fit_law(const cns_laws_result *r, cns_law *law)
{
    double *x = cns_xalloc(3 * (size_t)law->n, sizeof *x), *y = x + law->n, *g = y + law->n;
    int n = 0;
    cns_error ignored;
    for (int i = 0; i < law->n; i++) {
        if (law->point[i].left_out)
            continue;
        x[n] = law->point[i].x;
        y[n] = law->point[i].tc;
        g[n++] = law->point[i].growth;
    }
    const cns_spread independent = {.kind = CNS_SPREAD_INDEPENDENT};
    /* Without exponential growth T_c follows no line, and points that seem to lie on one tell nothing: along
     * a periodic motion a difference grows like a power of time, and growth does not rise with x. */
    law->fitted = r->lambda > SURE * r->lambda_se &&
                  cns_fit_line(x, g, n, &independent, &law->level, &ignored) == CNS_OK &&
                  cns_fit_line(x, y, n, &independent, &law->time, &ignored) == CNS_OK;
    if (law->fitted) {
        const double mu2 = r->rate * r->rate, v = law->level.residual_sd * law->level.residual_sd;
        const long dof = r->windows - 1 < n - 2 ? r->windows - 1 : n - 2;
        const cns_spread given = {.kind = CNS_SPREAD_GIVEN,
                                  .walk = r->variance * fmax(0, law->time.slope) / mu2,
                                  .jitter = v / mu2,
                                  .dof = dof,
                                  .start = fmin(x[0], -law->time.intercept / law->time.slope)};
        law->fitted = cns_fit_line(x, y, n, &given, &law->time, &ignored) == CNS_OK;
    }
    free(x);
}

static void take_point(const cns_laws_work *l, const cns_law_job *j, const char *result, cns_law_point *p)
{
    char why[WHY];
    *p = (cns_law_point){.text = cns_xcopy(j->text), .x = j->x, .tc = NAN, .growth = NAN};
    if (result && strncmp(result, "tc ", 3) == 0) {
        p->tc = strtod(result + 3, NULL);
        p->growth = cns_laws_growth_at(l, p->tc);
        if (p->growth >= LEAST_GROWTH)
            return;
        snprintf(why, sizeof why, "it parts at t = %.6g by its own error, not by growth", p->tc);
    } else if (!result)
        snprintf(why, sizeof why, "%s", j->skip);
    else if (strncmp(result, "beyond", 6) == 0)
        snprintf(why, sizeof why, "no T_c up to t = %.12g, where the reference ends",
                 (l->ref.rows - 1) * l->every);
    else
        snprintf(why, sizeof why, "%.*s", (int)strcspn(result, "\n"), result);
    p->left_out = cns_xcopy(why);
}

cns_code cns_laws_conclude(const cns_laws_work *l, char **results, cns_laws_result *r, cns_error *err)
{
    int next = 0;
    r->reference_digits = l->ref.digits;
    r->reference_end = (l->ref.rows - 1) * l->every;
    r->reference_error = l->ref.error[l->ref.rows - 1];
    for (int i = 0; i < l->jobs; i++) {
        const cns_law_job *j = &l->job[i];
        const char *result = j->skip ? NULL : results[next++];
        if (j->kind == CNS_LAW_CHECK) {
            r->reference_check = strtod(result + strlen("beyond "), NULL);
            continue;
        }
        cns_law *law = &r->law[j->kind];
        law->point = cns_xgrow(law->point, (size_t)law->n + 1, sizeof *law->point);
        take_point(l, j, result, &law->point[law->n++]);
    }
    if (r->reference_check > l->delta_log10 - CNS_LAWS_TRUST_DIGITS / 2.0)
        return cns_fail(err, CNS_NUMERIC,
                        "a second reference with %d digits fewer differs by 10^%.1f, too near to delta: no "
                        "T_c can be trusted",
                        CNS_LAWS_CHECK_DIGITS, r->reference_check);
    statistics(l, r);
    for (int k = 0; k < CNS_LAW_KINDS; k++)
        fit_law(r, &r->law[k]);
    return CNS_OK;
}
