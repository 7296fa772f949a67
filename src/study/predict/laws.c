#include "cns/study/laws.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/monitor.h"
#include "core/sha256.h"
#include "fit.h"
#include "integrate/numerics.h"
#include "integrate/rows.h"
#include "integrate/trajectory.h"
#include "num/logs.h"
#include "solve/solve_internal.h"
#include "study/ensemble.h"
#include "tc_internal.h"

enum {
    KEPT_DIGITS = 40, /* of a reference's states: they are compared with delta only */
    KEPT_BITS = 160,
    BEYOND = 3,        /* digits of growth by which the reference outlasts the predicted last T_c */
    SPARE = 24,        /* digits of the reference beyond that growth */
    CHECK_DIGITS = 10, /* that the second reference has fewer: another limb, another order */
    TRUST_DIGITS = 6,  /* by which the reference's own error stays below delta */
    FINE_DIGITS = 34,  /* of the continuation inside an interval */
    LONGER = 12,       /* digits of growth added when a run outlasts the reference */
    EXTENSIONS = 4,
    ABOVE_ROUNDING = 3,  /* digits by which truncation has to stand above rounding in the step law */
    SMOOTH_DIGITS = 14,  /* of a smoothed run beyond eps^2 */
    DIGITS_A_WINDOW = 8, /* of mean growth */
    MOST_WINDOWS = 64,
    LEAST_WINDOWS = 10,
    LEAST_GROWTH = 1,   /* digits, before a T_c says something of growth */
    MOST_GROWTH = 2,    /* digits between two rows */
    SURE = 3,           /* standard errors by which lambda must be above zero for a line */
    LONGEST_NAMED = 40, /* characters of a value in the name of a run */
    LINE = 64
};
static const double probe_time = 10; /* over which the first step's truncation is measured */

/* The reference at multiples of `every`. */
typedef struct reference {
    long digits;
    int rows;
    mpfr_t *state; /* n per row */
    double *growth, *error;
} reference;

typedef enum job_kind { JOB_DIGITS, JOB_STEPS, JOB_SMOOTHING, JOB_CHECK } job_kind;

typedef struct job {
    job_kind kind;
    char *text; /* of the value */
    double x;
    cns_number value; /* the step or eps */
    long digits;
    double level;     /* digits of growth that it should bear */
    const char *skip; /* why it is not run; NULL: it is */
    double predicted; /* T_c, roughly */
} job;

typedef struct laws {
    const cns_problem *problem;
    const cns_system *system; /* the reference's: the problem's own */
    const cns_laws_spec *spec;
    const char *directory;
    char *identity;
    int n; /* states */
    double every, end, delta_log10;
    int order;
    int jobs;
    job *job;
    int *listed, n_listed; /* the jobs that are run */
    double level;          /* growth at which the reference ends */
    reference ref;
    /* progress of the two ensembles as one */
    cns_monitor inner;
    double base, span;
} laws;

static void reference_clear(reference *r, int n)
{
    for (int i = 0; i < r->rows * n; i++)
        mpfr_clear(r->state[i]);
    free(r->state);
    free(r->growth);
    free(r->error);
    *r = (reference){0};
}

static void on_progress(void *context, double fraction, const char *what)
{
    const laws *l = context;
    char text[160];
    snprintf(text, sizeof text, "%s: %s", l->base > 0 ? "laws" : "reference", what);
    cns_monitor_tell(l->problem->monitor, l->base + l->span * fraction, text);
}

static void row_time(const laws *l, int row, mpq_t t)
{
    cns_row_time(cns_every(l->problem), l->problem->end, (unsigned long)row, t);
}

/* The last row that the problem's end allows; laws compare at multiples of `every` only. */
static int last_row(const laws *l)
{
    const long last = cns_last_multiple(cns_every(l->problem), l->problem->end);
    return last < INT_MAX ? (int)last : INT_MAX - 1;
}

static cns_flow_spec taylor(const laws *l, const cns_system *s, long digits, double safety)
{
    cns_flow_spec spec =
        cns_flow_spec_taylor(cns_system_program(s), cns_system_scales(s), CNS_ARITH_FAST, digits);
    spec.safety = safety;
    spec.stop = cns_monitor_stop(l->problem->monitor);
    return spec;
}

/* Noise that is made late has less time to grow: a reference that began with so many digits can do with fewer
 * by as many as growth has used. What that leaves of its accuracy is measured like all noise, by its tangents
 * and by the second reference. */
typedef struct falling {
    cns_schedule schedule; /* what a flow is told, of one part */
    long begun, digits;
} falling;

static void falling_init(falling *f, long digits)
{
    *f = (falling){.begun = digits, .digits = digits};
    f->schedule = (cns_schedule){.end = 1, .n = 1, .digits = &f->digits};
}

static void falling_follow(falling *f, double growth)
{
    const long left = f->begun - (long)floor(growth);
    if (left < f->digits)
        f->digits = left;
}

/* The reference, as the one job of an ensemble: a line for each row. */

static void reference_name(void *context, int i, char *name, size_t size)
{
    const laws *l = context;
    (void)i;
    snprintf(name, size, "reference-%ld-growth-%.0f", l->ref.digits, l->level);
}

static double one(void *context, int i)
{
    (void)context;
    (void)i;
    return 1;
}

static cns_code reference_run(void *context, int number, cns_ensemble_job *told, char **result,
                              cns_error *err)
{
    laws *l = context;
    (void)number;
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return cns_fail(err, CNS_NUMERIC, "out of memory");
    falling precision;
    falling_init(&precision, l->ref.digits);
    cns_trajectory_spec spec = {.flow = taylor(l, l->system, l->ref.digits, 0),
                                .initial = cns_system_initial(l->system)};
    spec.flow.verify = true;
    spec.flow.schedule = &precision.schedule;
    cns_trajectory *t = cns_trajectory_new(&spec, err);
    cns_sample s = {0};
    cns_code code = !t ? err->code
                    : cns_sample_init(&s, cns_system_program(l->system), KEPT_BITS)
                        ? CNS_OK
                        : cns_fail(err, CNS_NUMERIC, "out of memory");
    mpq_t time;
    mpq_init(time);
    const int last = last_row(l);
    for (int row = 0; !code && row <= last; row++) {
        row_time(l, row, time);
        code = cns_trajectory_at(t, time, &s, err);
        if (code)
            break;
        falling_follow(&precision, s.growth);
        fprintf(out, "%.10g %.10g", s.growth, fmax(s.error_log2 * CNS_LOG10_2, -1e9));
        for (int i = 0; i < l->n; i++) {
            char *number_text;
            if (mpfr_asprintf(&number_text, " %.*Re", KEPT_DIGITS - 1, s.state[i]) < 0)
                abort();
            fputs(number_text, out);
            mpfr_free_str(number_text);
        }
        fputc('\n', out);
        cns_ensemble_tell(told, fmax(0, fmin(1, fmax(s.growth / l->level, (double)row / last))));
        if (s.growth >= l->level)
            break;
    }
    mpq_clear(time);
    cns_trajectory_free(t);
    cns_sample_clear(&s);
    if (fclose(out) != 0 && !code)
        code = cns_fail(err, CNS_NUMERIC, "out of memory");
    if (code)
        free(text);
    else
        *result = text;
    return code;
}

static cns_code reference_read(laws *l, const char *text, cns_error *err)
{
    reference *r = &l->ref;
    size_t rows = 0;
    for (const char *at = text; (at = strchr(at, '\n')) != NULL; at++)
        rows++;
    r->state = cns_xalloc(rows * (size_t)l->n, sizeof *r->state);
    r->growth = cns_xalloc(rows, sizeof *r->growth);
    r->error = cns_xalloc(rows, sizeof *r->error);
    char *at = (char *)(size_t)text; /* only read: strtod's and MPFR's ends are not const */
    for (size_t row = 0; row < rows; row++) {
        r->growth[row] = strtod(at, &at);
        r->error[row] = strtod(at, &at);
        for (int i = 0; i < l->n; i++) {
            mpfr_ptr x = r->state[row * (size_t)l->n + (size_t)i];
            char *begin = at;
            mpfr_init2(x, KEPT_BITS);
            mpfr_strtofr(x, begin, &at, 10, MPFR_RNDN);
            if (at == begin)
                mpfr_set_nan(x);
        }
        r->rows++;
        if (*at++ != '\n')
            return cns_fail(err, CNS_IO, "row %zu of the reference that was kept is damaged", row);
    }
    return rows > 1 ? CNS_OK : cns_fail(err, CNS_USAGE, "'time: end' leaves no row to compare");
}

/* Between two rows only what the difference was at the first one is followed: noise made later must not
 * count, and growth is interpolated. So rows have to be close. */
static cns_code rows_are_close(const laws *l, cns_error *err)
{
    const reference *r = &l->ref;
    for (int row = 1; row < r->rows; row++) {
        const double rise = r->growth[row] - r->growth[row - 1];
        if (!(rise <= MOST_GROWTH))
            return cns_fail(err, CNS_USAGE,
                            "'time: every' is too coarse: differences grow by 10^%.1f from t = %.12g to "
                            "%.12g, and rows at most 10^%d apart are needed",
                            rise, (row - 1) * l->every, row * l->every, MOST_GROWTH);
    }
    return CNS_OK;
}

static cns_code make_reference(laws *l, cns_error *err)
{
    char *result = NULL;
    reference_clear(&l->ref, l->n);
    l->ref.digits = (long)ceil(l->level - l->delta_log10 - 1e-6) + SPARE;
    l->base = 0;
    l->span = 0.2;
    const cns_ensemble e = {.n = 1,
                            .monitor = &l->inner,
                            .directory = l->directory,
                            .identity = l->identity,
                            .context = l,
                            .name = reference_name,
                            .cost = one,
                            .run = reference_run};
    cns_code code = cns_ensemble_run(&e, &result, err);
    if (!code)
        code = reference_read(l, result, err);
    free(result);
    if (!code)
        code = rows_are_close(l, err);
    const double error = code ? 0 : l->ref.error[l->ref.rows - 1];
    if (!code && error > l->delta_log10 - TRUST_DIGITS)
        code = cns_fail(err, CNS_NUMERIC, "the reference's own error grows to 10^%.1f, too near to delta",
                        error);
    return code;
}

/* Runs. */

static void run_name(void *context, int i, char *name, size_t size)
{
    static const char *const kinds[] = {"digits", "step", "smooth", "check"};
    const laws *l = context;
    const job *j = &l->job[l->listed[i]];
    char value[65];
    if (strlen(j->text) > LONGEST_NAMED) /* names are short, and unlike all others */
        cns_sha256_hex(value, j->text, strlen(j->text));
    else
        snprintf(value, sizeof value, "%s", j->text);
    const int prefix = snprintf(name, size, "%s-", kinds[j->kind]);
    if (j->kind == JOB_STEPS)
        snprintf(name + prefix, size - (size_t)prefix, "%s-%d-%ld-%s-reference-%ld",
                 l->spec->steps.method == CNS_METHOD_RK4 ? "rk4" : "taylor", l->order, j->digits, value,
                 l->ref.digits);
    else
        snprintf(name + prefix, size - (size_t)prefix, "%s-reference-%ld", value, l->ref.digits);
    for (char *c = name; *c; c++)
        if (*c == '/')
            *c = ':';
}

/* Seconds, roughly; only their order matters. */
static double run_cost(void *context, int i)
{
    const laws *l = context;
    const job *j = &l->job[l->listed[i]];
    const double precision = pow((double)j->digits / 60, 1.4);
    if (j->kind == JOB_STEPS)
        return j->predicted / cns_number_get_d(&j->value) * 5e-5 * (0.5 + precision / 2) *
               (l->spec->steps.method == CNS_METHOD_RK4 ? 1 : fmax(1, pow(l->order / 10.0, 2)));
    return j->predicted * 4e-3 * precision * (j->kind == JOB_SMOOTHING ? 4 : 1);
}

static void distance(const laws *l, const mpfr_t *u1, const mpfr_t *u2, mpfr_t sum)
{
    mpfr_t d;
    mpfr_init2(d, KEPT_BITS);
    mpfr_set_zero(sum, 1);
    for (int i = 0; i < l->n; i++) {
        if (!cns_program_is_dynamic(cns_system_program(l->system), i))
            continue;
        mpfr_sub(d, u1[i], u2[i], MPFR_RNDN);
        mpfr_div_d(d, d, cns_system_scales(l->system)[i], MPFR_RNDN);
        mpfr_sqr(d, d, MPFR_RNDN);
        mpfr_add(sum, sum, d, MPFR_RNDN);
    }
    mpfr_sqrt(sum, sum, MPFR_RNDN);
    mpfr_clear(d);
}

/* Has the observable parted by more than delta? */
static bool parted(const laws *l, const mpfr_t *u1, const mpfr_t *u2)
{
    const int i = l->spec->observable;
    bool yes;
    mpfr_t d, delta;
    mpfr_inits2(KEPT_BITS, d, delta, (mpfr_ptr)0);
    cns_number_get_mpfr(delta, &l->spec->delta);
    if (i == CNS_OBSERVABLE_NORM) {
        distance(l, u1, u2, d);
        yes = mpfr_greater_p(d, delta);
    } else { /* |u2 - u1| > delta |u2| is |1 - u1/u2| > delta, 0/0 counting as 0, x/0 as infinite */
        mpfr_sub(d, u2[i], u1[i], MPFR_RNDN);
        mpfr_mul(delta, delta, u2[i], MPFR_RNDN);
        yes = mpfr_cmpabs(d, delta) > 0;
    }
    mpfr_clears(d, delta, (mpfr_ptr)0);
    return yes;
}

static cns_number *numbers_of(const mpfr_t *x, int n)
{
    cns_number *v = cns_xalloc((size_t)n, sizeof *v);
    for (int i = 0; i < n; i++) {
        char *text;
        if (mpfr_asprintf(&text, "%.*Re", KEPT_DIGITS - 1, x[i]) < 0)
            abort();
        cns_number_init(&v[i]);
        cns_number_parse(&v[i], text, NULL);
        mpfr_free_str(text);
    }
    return v;
}

static void numbers_free(cns_number *v, int n)
{
    for (int i = 0; i < n; i++)
        cns_number_clear(&v[i]);
    free(v);
}

/* The time within the interval after two states at which the observable parts; 1 interval if it does not. */
static cns_code refine(const laws *l, const cns_system *s, const mpfr_t *u1, const mpfr_t *u2, double *part,
                       cns_error *err)
{
    cns_number *a = numbers_of(u1, l->n), *b = numbers_of(u2, l->n);
    const cns_trajectory_spec test = {.flow = taylor(l, s, FINE_DIGITS, 0), .initial = a},
                              truth = {.flow = taylor(l, l->system, FINE_DIGITS, 0), .initial = b};
    const int until =
        l->spec->observable == CNS_OBSERVABLE_NORM ? CNS_TC_NORM : CNS_TC_STATE(l->spec->observable);
    const cns_tc_pair pair = {.test = &test,
                              .reference = &truth,
                              .end = cns_every(l->problem),
                              .every = cns_every(l->problem),
                              .delta = &l->spec->delta,
                              .until = until};
    cns_tc_result r = {0};
    cns_code code = cns_tc_compare(&pair, &r, err);
    *part = !code && r.time[until].kind == CNS_TC_FOUND ? r.time[until].t : l->every;
    cns_tc_result_clear(&r);
    numbers_free(a, l->n);
    numbers_free(b, l->n);
    return code == CNS_STOPPED ? code : CNS_OK;
}

/* precision: of a second reference; it must outlive the flow. */
static cns_code job_flow(const laws *l, const job *j, const cns_system *smooth, falling *precision,
                         cns_flow **flow, cns_error *err)
{
    cns_numerics k = {.method = CNS_METHOD_TAYLOR, .arithmetic = CNS_ARITH_FAST, .digits = j->digits};
    cns_flow_spec spec;
    switch (j->kind) {
    case JOB_DIGITS:
        spec = cns_tc_flow(l->system, &k, cns_monitor_stop(l->problem->monitor));
        break;
    case JOB_STEPS:
        spec = taylor(l, l->system, j->digits, 0);
        spec.method = l->spec->steps.method;
        spec.arithmetic = CNS_ARITH_MPFR;
        spec.order = l->order;
        spec.step = &j->value;
        break;
    case JOB_SMOOTHING:
        spec = taylor(l, smooth, j->digits, 0);
        break;
    default:
        spec = taylor(l, l->system, j->digits, 0.3);
        falling_init(precision, j->digits);
        spec.schedule = &precision->schedule;
        break;
    }
    *flow = cns_flow_new(&spec, err);
    return *flow ? CNS_OK : err->code;
}

static double growth_at(const laws *l, double t)
{
    const double at = t / l->every;
    const int row = (int)fmin(floor(at), l->ref.rows - 2);
    return l->ref.growth[row] + (at - row) * (l->ref.growth[row + 1] - l->ref.growth[row]);
}

/* A run against the reference, row by row. *tc is NaN when the reference ends first; *apart is then log10 of
 * the largest distance. A run that fails by its own numerics says so in *failure. */
static cns_code compare(const laws *l, const job *j, cns_flow *f, const cns_system *s, falling *precision,
                        cns_ensemble_job *told, double *tc, double *apart, char **failure, cns_error *err)
{
    mpq_t time;
    mpq_init(time);
    mpfr_t d, largest, *now = cns_xalloc((size_t)l->n, sizeof *now),
                       *before = cns_xalloc((size_t)l->n, sizeof *before);
    mpfr_inits2(KEPT_BITS, d, largest, (mpfr_ptr)0);
    mpfr_set_zero(largest, 1);
    for (int i = 0; i < l->n; i++) {
        mpfr_init2(now[i], KEPT_BITS);
        mpfr_init2(before[i], KEPT_BITS);
    }
    cns_flow_start(f, cns_system_initial(l->system));
    *tc = NAN;
    cns_code code = CNS_OK;
    for (int row = 1; row < l->ref.rows && !code && isnan(*tc) && !*failure; row++) {
        row_time(l, row, time);
        falling_follow(precision, l->ref.growth[row - 1]);
        while (!code && mpfr_cmp_q(cns_flow_end(f), time) < 0)
            code = cns_flow_step(f, err);
        if (code == CNS_NUMERIC && j->kind != JOB_CHECK) {
            *failure = cns_xcopy(err->text);
            code = CNS_OK;
            break;
        }
        if (code)
            break;
        mpfr_t *swap = before;
        before = now;
        now = swap;
        cns_flow_eval(f, time, now);
        const mpfr_t *u2 = (const mpfr_t *)l->ref.state + (size_t)row * (size_t)l->n;
        distance(l, (const mpfr_t *)now, u2, d);
        if (mpfr_greater_p(d, largest))
            mpfr_set(largest, d, MPFR_RNDN);
        if (j->kind != JOB_CHECK && parted(l, (const mpfr_t *)now, u2)) {
            double part = l->every;
            if (row > 1)
                code = refine(l, s, (const mpfr_t *)before, u2 - l->n, &part, err);
            *tc = (row - 1) * l->every + part;
        }
        cns_ensemble_tell(told, fmin(0.99, row * l->every / j->predicted));
    }
    *apart = cns_log2_mpfr(largest) * CNS_LOG10_2;
    for (int i = 0; i < l->n; i++) {
        mpfr_clear(now[i]);
        mpfr_clear(before[i]);
    }
    free(now);
    free(before);
    mpfr_clears(d, largest, (mpfr_ptr)0);
    mpq_clear(time);
    return code;
}

/* The result: "tc T", "beyond" with log10 of the largest distance, or "failed" and why. */
static cns_code run(void *context, int i, cns_ensemble_job *told, char **result, cns_error *err)
{
    const laws *l = context;
    const job *j = &l->job[l->listed[i]];
    cns_system *smooth = NULL;
    cns_flow *f = NULL;
    cns_code code = CNS_OK;
    double tc = NAN, apart = -HUGE_VAL;
    char *failure = NULL;
    falling precision = {0};
    if (j->kind == JOB_SMOOTHING && !(smooth = cns_system_smoothed(l->system, &j->value, err)))
        code = err->code;
    if (!code)
        code = job_flow(l, j, smooth, &precision, &f, err);
    if (!code)
        code = compare(l, j, f, smooth ? smooth : l->system, &precision, told, &tc, &apart, &failure, err);
    if (!code) {
        const size_t size = LINE + (failure ? strlen(failure) : 0);
        *result = cns_xalloc(size, 1);
        if (failure)
            snprintf(*result, size, "failed %s\n", failure);
        else if (isnan(tc))
            snprintf(*result, size, "beyond %.3f\n", fmax(apart, -1e9));
        else
            snprintf(*result, size, "tc %.7f\n", tc);
    }
    free(failure);
    cns_flow_free(f);
    cns_system_free(smooth);
    return code;
}

/* What is asked for. */

static job *add_job(laws *l, job_kind kind)
{
    l->job = cns_xgrow(l->job, (size_t)l->jobs + 1, sizeof *l->job);
    job *j = &l->job[l->jobs++];
    *j = (job){.kind = kind, .predicted = 1};
    cns_number_init(&j->value);
    return j;
}

static double log10_of(const cns_number *x)
{
    mpfr_t y;
    mpfr_init2(y, 64);
    cns_number_get_mpfr(y, x);
    const double log10 = cns_log2_mpfr(y) * CNS_LOG10_2;
    mpfr_clear(y);
    return log10;
}

/* Values in equal ratios, as texts of four digits; what is run is the text. */
static void add_decades(laws *l, job_kind kind, const cns_decades *d)
{
    const double from = log10_of(&d->from), to = log10_of(&d->to);
    for (long k = 0; from - (double)k / (double)d->per_decade > to - 1e-6; k++) {
        char text[LINE];
        const double at = from - (double)k / (double)d->per_decade + 1e-9, e = floor(at);
        snprintf(text, sizeof text, "%.4ge%.0f", pow(10, at - e), e);
        job *j = add_job(l, kind);
        j->text = cns_xcopy(k == 0 ? d->from.text : text);
        cns_number_parse(&j->value, j->text, NULL);
        j->x = -log10_of(&j->value);
    }
}

/* log10 of the truncation error of the first step size after a while, by a run of the method against a
 * Taylor run: what smaller steps are predicted from. */
static cns_code probe(const laws *l, const job *first, double *truncation, cns_error *err)
{
    cns_flow *f = NULL, *truth = NULL;
    mpq_t time;
    mpq_init(time);
    const cns_flow_spec fine = taylor(l, l->system, first->digits, 0);
    mpfr_t d, *a = cns_xalloc((size_t)l->n, sizeof *a), *b = cns_xalloc((size_t)l->n, sizeof *b);
    mpfr_init2(d, KEPT_BITS);
    for (int i = 0; i < l->n; i++)
        mpfr_inits2(fine.prec, a[i], b[i], (mpfr_ptr)0);
    *truncation = -(double)first->digits;
    falling unused;
    cns_code code = job_flow(l, first, NULL, &unused, &f, err);
    if (!code && !(truth = cns_flow_new(&fine, err)))
        code = err->code;
    if (!code) {
        cns_flow_start(f, cns_system_initial(l->system));
        cns_flow_start(truth, cns_system_initial(l->system));
    }
    for (int row = 1; !code && row <= last_row(l) && row * l->every <= probe_time; row++) {
        row_time(l, row, time);
        while (!code && mpfr_cmp_q(cns_flow_end(f), time) < 0)
            code = cns_flow_step(f, err);
        while (!code && mpfr_cmp_q(cns_flow_end(truth), time) < 0)
            code = cns_flow_step(truth, err);
        if (code)
            break;
        cns_flow_eval(f, time, a);
        cns_flow_eval(truth, time, b);
        distance(l, (const mpfr_t *)a, (const mpfr_t *)b, d);
        *truncation = fmax(*truncation, cns_log2_mpfr(d) * CNS_LOG10_2);
    }
    for (int i = 0; i < l->n; i++)
        mpfr_clears(a[i], b[i], (mpfr_ptr)0);
    free(a);
    free(b);
    mpfr_clear(d);
    mpq_clear(time);
    cns_flow_free(f);
    cns_flow_free(truth);
    /* A first step too large to go on tells nothing: the others are run, and tell for themselves. */
    return code == CNS_NUMERIC ? CNS_OK : code;
}

static cns_code add_jobs(laws *l, cns_error *err)
{
    const cns_laws_spec *s = l->spec;
    for (long k = s->digits.from; s->has_digits && k <= s->digits.to; k += s->digits.by) {
        char text[LINE];
        job *j = add_job(l, JOB_DIGITS);
        snprintf(text, sizeof text, "%ld", k);
        j->text = cns_xcopy(text);
        j->x = j->level = (double)k;
        j->digits = k;
    }
    const int first = l->jobs;
    if (s->has_steps)
        add_decades(l, JOB_STEPS, &s->steps.sizes);
    double truncation = 0;
    for (int i = first; i < l->jobs; i++) {
        job *j = &l->job[i];
        j->digits = s->steps.digits;
        if (i == first) {
            cns_code code = probe(l, j, &truncation, err);
            if (code)
                return code;
        }
        j->level = l->order * (j->x - l->job[first].x) - truncation;
        /* Rounding adds up over 1/h steps per unit of time. */
        if (j->level > (double)j->digits - fmax(0, j->x) - ABOVE_ROUNDING)
            j->skip = "truncation would not stand above rounding";
    }
    if (s->has_smoothing)
        add_decades(l, JOB_SMOOTHING, &s->smoothing);
    for (int i = 0; i < l->jobs; i++)
        if (l->job[i].kind == JOB_SMOOTHING) {
            job *j = &l->job[i];
            j->level = 2 * j->x;
            j->digits = (long)ceil(2 * fmax(0, j->x)) + SMOOTH_DIGITS;
        }
    l->level = 0;
    for (int i = 0; i < l->jobs; i++)
        if (!l->job[i].skip)
            l->level = fmax(l->level, ceil(l->job[i].level));
    l->level += BEYOND;
    add_job(l, JOB_CHECK)->text = cns_xcopy("reference");
    return CNS_OK;
}

/* The statistics of growth along the reference, by windows. The fluctuation of growth has a bounded part,
 * too, which comes and goes within a few digits: in short windows it passes for a stronger walk (0.20 digits
 * per root of time in windows of 5 time units, 0.12 in 40, 0.08 in 160, for the falling disk at I = 2.2). So
 * windows have eight digits of mean growth each where the reference is long enough for ten of them; in a
 * short one they are shorter, and the errors err towards too large. */
static void statistics(const laws *l, cns_laws_result *r)
{
    const reference *ref = &l->ref;
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

static void set_predicted(laws *l)
{
    int row = 0;
    for (int i = 0; i < l->jobs; i++) {
        job *j = &l->job[i];
        for (row = 1; row < l->ref.rows - 1 && (j->kind == JOB_CHECK || l->ref.growth[row] < j->level); row++)
            ;
        j->predicted = row * l->every;
        if (j->kind == JOB_CHECK)
            j->digits = l->ref.digits - CHECK_DIGITS;
    }
}

static cns_code run_all(laws *l, char **results, cns_error *err)
{
    set_predicted(l);
    l->n_listed = 0;
    for (int i = 0; i < l->jobs; i++)
        if (!l->job[i].skip)
            l->listed[l->n_listed++] = i;
    l->base = 0.2;
    l->span = 0.8;
    const cns_ensemble e = {.n = l->n_listed,
                            .monitor = &l->inner,
                            .directory = l->directory,
                            .identity = l->identity,
                            .context = l,
                            .name = run_name,
                            .cost = run_cost,
                            .run = run};
    return cns_ensemble_run(&e, results, err);
}

static bool any_beyond(const laws *l, char **results)
{
    for (int i = 0; i < l->n_listed; i++)
        if (l->job[l->listed[i]].kind != JOB_CHECK && strncmp(results[i], "beyond", 6) == 0)
            return true;
    return false;
}

static void take_point(const laws *l, const job *j, const char *result, cns_law_point *p)
{
    char why[LINE * 4];
    *p = (cns_law_point){.text = cns_xcopy(j->text), .x = j->x, .tc = NAN, .growth = NAN};
    if (result && strncmp(result, "tc ", 3) == 0) {
        p->tc = strtod(result + 3, NULL);
        p->growth = growth_at(l, p->tc);
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

static cns_code conclude(const laws *l, char **results, cns_laws_result *r, cns_error *err)
{
    int next = 0;
    r->reference_digits = l->ref.digits;
    r->reference_end = (l->ref.rows - 1) * l->every;
    r->reference_error = l->ref.error[l->ref.rows - 1];
    for (int i = 0; i < l->jobs; i++) {
        const job *j = &l->job[i];
        const char *result = j->skip ? NULL : results[next++];
        if (j->kind == JOB_CHECK) {
            r->reference_check = strtod(result + strlen("beyond "), NULL);
            continue;
        }
        cns_law *law = &r->law[(int)j->kind];
        law->point = cns_xgrow(law->point, (size_t)law->n + 1, sizeof *law->point);
        take_point(l, j, result, &law->point[law->n++]);
    }
    if (r->reference_check > l->delta_log10 - TRUST_DIGITS / 2.0)
        return cns_fail(err, CNS_NUMERIC,
                        "a second reference with %d digits fewer differs by 10^%.1f, too near to delta: no "
                        "T_c can be trusted",
                        CHECK_DIGITS, r->reference_check);
    statistics(l, r);
    for (int k = 0; k < CNS_LAW_KINDS; k++)
        fit_law(r, &r->law[k]);
    return CNS_OK;
}

static cns_code check(const laws *l, cns_error *err)
{
    const cns_laws_spec *s = l->spec;
    if (!s->has_digits && !s->has_steps && !s->has_smoothing)
        return cns_fail(err, CNS_USAGE, "'laws' asks for none of 'digits', 'steps' and 'smoothing'");
    if (s->has_smoothing && cns_system_smooth(l->system))
        return cns_fail(err, CNS_USAGE, "'laws: smoothing' needs 'abs: exact', which it is compared with");
    if (l->delta_log10 < TRUST_DIGITS - FINE_DIGITS / 2 - 1e-9)
        return cns_fail(err, CNS_USAGE, "'laws: delta' is too small: at least 1e%d",
                        TRUST_DIGITS - FINE_DIGITS / 2);
    return CNS_OK;
}

cns_code cns_laws(const cns_problem *problem, const cns_laws_spec *spec, const char *directory,
                  cns_laws_result *r, cns_error *err)
{
    laws l = {.problem = problem,
              .system = problem->system,
              .spec = spec,
              .directory = directory,
              .n = cns_system_model(problem->system)->n_states,
              .every = cns_number_get_d(cns_every(problem)),
              .end = cns_number_get_d(problem->end),
              .delta_log10 = log10_of(&spec->delta)};
    l.inner = (cns_monitor){.threads = cns_monitor_threads(problem->monitor),
                            .stop = cns_monitor_stop(problem->monitor),
                            .progress = on_progress,
                            .context = &l};
    *r = (cns_laws_result){0};
    cns_code code = check(&l, err);
    if (code)
        return code;
    l.order = spec->steps.order > 0
                  ? (int)spec->steps.order
                  : cns_order_for(cns_digits_to_tolerance(spec->steps.digits), CNS_ARITH_MPFR);
    r->order = l.order;
    l.identity =
        cns_system_identity(l.system, -1, "laws, end %s, every %s, delta %s, observable %d",
                            problem->end->text, cns_every(problem)->text, spec->delta.text, spec->observable);
    code = add_jobs(&l, err);
    char **results = cns_xalloc((size_t)l.jobs, sizeof *results);
    l.listed = cns_xalloc((size_t)l.jobs, sizeof *l.listed);
    for (int extension = 0; !code; extension++) {
        code = make_reference(&l, err);
        if (!code)
            code = run_all(&l, results, err);
        const bool done =
            code || extension == EXTENSIONS || l.ref.rows > last_row(&l) || !any_beyond(&l, results);
        if (!code && done)
            code = conclude(&l, results, r, err);
        for (int i = 0; i < l.n_listed; i++) {
            free(results[i]);
            results[i] = NULL;
        }
        if (done)
            break;
        l.level += LONGER;
    }
    for (int i = 0; i < l.jobs; i++) {
        cns_number_clear(&l.job[i].value);
        free(l.job[i].text);
    }
    free(l.job);
    free(l.listed);
    free(results);
    free(l.identity);
    reference_clear(&l.ref, l.n);
    return code;
}

void cns_laws_result_clear(cns_laws_result *r)
{
    for (int k = 0; k < CNS_LAW_KINDS; k++) {
        for (int i = 0; i < r->law[k].n; i++) {
            free(r->law[k].point[i].text);
            free(r->law[k].point[i].left_out);
        }
        free(r->law[k].point);
    }
    *r = (cns_laws_result){0};
}
