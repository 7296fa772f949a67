/* Laws of the critical predictable time: T_c against digits K, against the step h, against the smoothing eps.
 *
 * Source: Xu, Li, Li, Liao, "Accurate predictions of chaotic motion of a free fall disk", section 2.3,
 * equation for T_c. All runs are compared with one reference, a Taylor run whose end and digits are chosen so
 * that it outlasts them all: growth reaches some digits more than any run can bear, and its own error, by
 * tangents and by a second reference with ten digits fewer, stays far below delta to its very end.
 *
 * T_c is defined in cns/study/tc.h, by either criterion. The reference is kept at rows, the multiples of
 * `every`. Inside the interval between two rows that holds T_c both are begun anew at the first row, the run
 * by the same numerics. Its noise within that one interval is not quite the same, but far below delta. Where
 * that decides whether it has parted by the second row, T_c is that row with CNS_TC_ROWS, and with
 * CNS_TC_ENVELOPE the time between that an exponential growth from row to row gives. With CNS_TC_ROWS the
 * interval ends at the first row beyond delta; with CNS_TC_ENVELOPE every interval is looked into at an end
 * of which the difference is within a factor of 8 of its limit, and `every` has no part in the definition. So
 * rows must be near enough for growth to be within two digits from one to the next; if they are not, that is
 * CNS_USAGE.
 *
 * A run stops when its T_c is found. A run that does not find it before the reference ends makes the
 * reference longer, at most up to the problem's `end`; a point without T_c, or with a failed run, is left out
 * of the fit and named. */
#ifndef CNS_STUDY_LAWS_H
#define CNS_STUDY_LAWS_H

#include "cns/solve.h"
#include "cns/study/tc.h"

CNS_BEGIN_DECLS

/* Values from `from` towards `to`, per_decade of them in a factor of ten. */
typedef struct cns_decades {
    cns_number from, to; /* > 0, from > to */
    long per_decade;     /* >= 1 */
} cns_decades;

/* The Euclidean distance of the dynamic states, each divided by the model's scale. */
#define CNS_OBSERVABLE_NORM (-1)

/* The difference at which two runs have parted where nothing else is said: 1 %, as in the paper. */
#define CNS_STANDARD_DELTA "0.01"

typedef struct cns_laws_spec {
    cns_number delta; /* > 0 */
    cns_tc_criterion criterion;
    int observable; /* a state, or CNS_OBSERVABLE_NORM */
    bool has_digits, has_steps, has_smoothing;
    struct {
        long from, to, by; /* 1 <= from <= to, by >= 1 */
    } digits;
    struct {
        cns_method method;
        long order;  /* 0: the program's choice; RK4's is 4 */
        long digits; /* of the arithmetic */
        cns_decades sizes;
    } steps;
    cns_decades smoothing;
} cns_laws_spec;

typedef enum cns_law_kind { CNS_LAW_DIGITS, CNS_LAW_STEPS, CNS_LAW_SMOOTHING, CNS_LAW_KINDS } cns_law_kind;

/* A straight line y = slope x + intercept through points that fluctuate like a random walk: growth is
 * exponential on average only, and its fluctuation up to one T_c is part of that up to the next. So errors
 * are not those of independent points, which would be several times too small. _se are standard errors. */
typedef struct cns_fit {
    int n;
    double slope, intercept; /* ordinary least squares */
    double slope_se, intercept_se;
    double slope_95, intercept_95; /* half widths of the 95 % limits, by Student's t */
    double slope_gls,
        slope_gls_se;    /* generalised least squares under the covariance of the walk: the efficient one */
    double slope_robust; /* Theil and Sen: the median of the slopes of all pairs */
    double r2;           /* NaN when all ordinates are the same */
    double residual_sd;  /* with n - 2 degrees of freedom */
    double walk, jitter; /* variances, as used: per unit of x, and of each point */
    long dof;
} cns_fit;

typedef struct cns_law_point {
    char *text;     /* K, h or eps, as run */
    double x;       /* K, -log10 h or -log10 eps: T_c grows with x */
    double tc;      /* NaN when left out */
    double growth;  /* log10 of the reference's tangent growth from 0 to T_c */
    char *left_out; /* why; NULL: it is in the fit */
} cns_law_point;

typedef struct cns_law {
    int n; /* 0: not asked for */
    cns_law_point *point;
    bool fitted;   /* three points or more, and growth that is surely exponential */
    cns_fit time;  /* T_c over x; errors by the fluctuation of growth along the reference */
    cns_fit level; /* growth at T_c over x: the digits that x is worth (1 for K, the order for h and eps). The
                      fluctuation of growth cancels here, so this is by far the sharper figure */
} cns_law;

typedef struct cns_laws_result {
    cns_law law[CNS_LAW_KINDS];
    double lambda, lambda_se; /* by the growth along the reference */
    double rate, variance;    /* of log10 of the growth, mean and variance per unit of time: mu, s^2 */
    long windows;             /* that they were found with, of some two digits each */
    long reference_digits;
    double reference_end;
    double reference_error; /* log10 of its own error at its end, by tangents */
    double reference_check; /* log10 of the largest distance of the second reference */
    int order;              /* of the method of the step law */
} cns_laws_result;

/* Of the problem's system, with its rows, at most up to its end; columns and sink are of no use here.
 * directory: where every run is kept, NULL for nowhere; the same again does what is missing. *r is to be
 * cleared whatever is returned. CNS_USAGE: nothing asked for, or what cannot be done. */
cns_code cns_laws(const cns_problem *problem, const cns_laws_spec *spec, const char *directory,
                  cns_laws_result *r, cns_error *err);
void cns_laws_result_clear(cns_laws_result *r);

CNS_END_DECLS

#endif
