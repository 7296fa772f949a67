#include "laws_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/monitor.h"
#include "num/decimal_text.h"
#include "num/logs.h"
#include "num/vector.h"
#include "solve/problem.h"
#include "study/ensemble.h"
#include "tc_internal.h"

enum { LINE = 64 };
static const double near = 1.0 / 8;  /* parts of the limit from which intervals are looked into */
static const double probe_time = 10; /* over which the first step's truncation is measured */

static void run_name(void *context, int i, char *name, size_t size)
{
    static const char *const kinds[] = {"digits", "step", "smooth", "check"};
    const cns_laws_work *l = context;
    const cns_law_job *j = &l->job[l->listed[i]];
    const cns_ensemble_word value = cns_ensemble_word_for(j->text);
    const int prefix = snprintf(name, size, "%s-", kinds[j->kind]);
    if (j->kind == CNS_LAW_STEPS)
        snprintf(name + prefix, size - (size_t)prefix, "%s-%d-%ld-%s-reference-%ld",
                 l->spec->steps.method == CNS_METHOD_RK4 ? "rk4" : "taylor", l->order, j->digits, value.text,
                 l->ref.digits);
    else
        snprintf(name + prefix, size - (size_t)prefix, "%s-reference-%ld", value.text, l->ref.digits);
}

/* Seconds, roughly; only their order matters. */
static double run_cost(void *context, int i)
{
    const cns_laws_work *l = context;
    const cns_law_job *j = &l->job[l->listed[i]];
    const double precision = pow((double)j->digits / 60, 1.4);
    if (j->kind == CNS_LAW_STEPS)
        return j->predicted / cns_number_get_d(&j->value) * 5e-5 * (0.5 + precision / 2) *
               (l->spec->steps.method == CNS_METHOD_RK4 ? 1 : fmax(1, pow(l->order / 10.0, 2)));
    return j->predicted * 4e-3 * precision * (j->kind == CNS_LAW_SMOOTHING ? 4 : 1);
}

static void distance(const cns_laws_work *l, const mpfr_t *u1, const mpfr_t *u2, mpfr_t sum)
{
    mpfr_t d;
    mpfr_init2(d, CNS_LAWS_KEPT_BITS);
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

/* The difference of the observable as a part of its limit (cns/study/tc.h): it has parted if this is above 1.
 * u2: a row of the reference. */
static double part_of_limit(const cns_laws_work *l, const mpfr_t *u1, const mpfr_t *u2)
{
    const int i = l->spec->observable;
    double part = 0;
    mpfr_t d, limit;
    mpfr_inits2(CNS_LAWS_KEPT_BITS, d, limit, (mpfr_ptr)0);
    cns_number_get_mpfr(limit, &l->spec->delta);
    if (i == CNS_OBSERVABLE_NORM) {
        distance(l, u1, u2, d);
    } else {
        mpfr_sub(d, u2[i], u1[i], MPFR_RNDN);
        mpfr_mul(limit, limit, l->spec->criterion == CNS_TC_ROWS ? u2[i] : u2[l->n], MPFR_RNDN);
    }
    if (!mpfr_zero_p(d)) { /* 0/0 counts as 0, x/0 as infinite */
        mpfr_div(d, d, limit, MPFR_RNDN);
        part = fabs(mpfr_get_d(d, MPFR_RNDA));
    }
    mpfr_clears(d, limit, (mpfr_ptr)0);
    return part;
}

static cns_number *numbers_of(const mpfr_t *x, int n)
{
    cns_number *v = cns_xalloc((size_t)n, sizeof *v);
    for (int i = 0; i < n; i++) {
        char *text = cns_text_mpfr(x[i], CNS_PLACES_SIGNIFICANT, CNS_LAWS_KEPT_DIGITS);
        cns_number_init(&v[i]);
        cns_number_parse(&v[i], text, NULL);
        free(text);
    }
    return v;
}

static void numbers_free(cns_number *v, int n)
{
    for (int i = 0; i < n; i++)
        cns_number_clear(&v[i]);
    free(v);
}

/* How the run of a job is made, with so many digits. s: the system that it is about. */
static cns_flow_spec run_spec(const cns_laws_work *l, const cns_law_job *j, const cns_system *s, long digits)
{
    const cns_numerics k = {.method = CNS_METHOD_TAYLOR, .arithmetic = CNS_ARITH_FAST, .digits = digits};
    if (j->kind == CNS_LAW_DIGITS)
        return cns_tc_flow(s, &k, cns_monitor_stop(l->problem->monitor));
    cns_flow_spec spec = cns_laws_taylor(l, s, digits, 0);
    if (j->kind == CNS_LAW_STEPS) {
        spec.method = l->spec->steps.method;
        spec.arithmetic = CNS_ARITH_MPFR;
        spec.order = l->order;
        spec.step = &j->value;
    }
    return spec;
}

/* precision: of a second reference; it must outlive the flow. */
static cns_code job_flow(const cns_laws_work *l, const cns_law_job *j, const cns_system *s,
                         cns_falling *precision, cns_flow **flow, cns_error *err)
{
    cns_flow_spec spec = run_spec(l, j, s, j->digits);
    if (j->kind == CNS_LAW_CHECK) {
        spec.safety = 0.3;
        cns_falling_init(precision, j->digits);
        spec.schedule = &precision->schedule;
    }
    *flow = cns_flow_new(&spec, err);
    return *flow ? CNS_OK : err->code;
}

/* *part = the time within the interval after two states at which the observable parts; NaN if it does not. */
static cns_code refine(const cns_laws_work *l, const cns_law_job *j, const cns_system *s, const mpfr_t *u1,
                       const mpfr_t *u2, double *part, cns_error *err)
{
    const long digits = j->digits < CNS_LAWS_FINE_DIGITS ? j->digits : CNS_LAWS_FINE_DIGITS;
    cns_number *a = numbers_of(u1, l->n), *b = numbers_of(u2, l->n);
    const cns_trajectory_spec test = {.flow = run_spec(l, j, s, digits), .initial = a},
                              truth = {.flow = cns_laws_taylor(l, l->system, CNS_LAWS_FINE_DIGITS, 0),
                                       .initial = b};
    const int until =
        l->spec->observable == CNS_OBSERVABLE_NORM ? CNS_TC_NORM : CNS_TC_STATE(l->spec->observable);
    const cns_tc_pair pair = {.test = &test,
                              .reference = &truth,
                              .end = cns_every(l->problem),
                              .every = cns_every(l->problem),
                              .delta = &l->spec->delta,
                              .criterion = l->spec->criterion,
                              .until = until,
                              .before = u2[l->n]};
    cns_tc_result r = {0};
    cns_code code = cns_tc_compare(&pair, &r, err);
    *part = !code && r.time[until].kind == CNS_TC_FOUND ? r.time[until].t : NAN;
    cns_tc_result_clear(&r);
    numbers_free(a, l->n);
    numbers_free(b, l->n);
    return code == CNS_STOPPED || code == CNS_MEMORY ? code : CNS_OK;
}

/* The same for a run that has parted at the second row, and begun anew at the first one does not quite, from
 * the parts of the limit at both ends: under the envelope, which changes little, as differences grow; by rows
 * that is the second row. */
static double between(const cns_laws_work *l, double part_before, double part)
{
    if (l->spec->criterion == CNS_TC_ROWS || !(part_before > 0) || !isfinite(part))
        return l->every;
    return l->every * log(1 / part_before) / log(part / part_before);
}

/* A run against the reference, row by row. *tc is NaN when the reference ends first; *apart is then log10 of
 * the largest distance. A run that fails by its own numerics says so in *failure. */
static cns_code compare(const cns_laws_work *l, const cns_law_job *j, cns_flow *f, const cns_system *s,
                        cns_falling *precision, cns_ensemble_job *told, double *tc, double *apart,
                        char **failure, cns_error *err)
{
    mpq_t time;
    mpq_init(time);
    mpfr_t d, largest, *now = cns_vector_xnew(l->n, CNS_LAWS_KEPT_BITS),
                       *before = cns_vector_xnew(l->n, CNS_LAWS_KEPT_BITS);
    mpfr_inits2(CNS_LAWS_KEPT_BITS, d, largest, (mpfr_ptr)0);
    mpfr_set_zero(largest, 1);
    double part = 0;
    cns_flow_start(f, cns_system_initial(l->system));
    *tc = NAN;
    cns_code code = CNS_OK;
    for (int row = 1; row < l->ref.rows && !code && isnan(*tc) && !*failure; row++) {
        cns_laws_row_time(l, row, time);
        cns_falling_follow(precision, l->ref.growth[row - 1]);
        while (!code && mpfr_cmp_q(cns_flow_end(f), time) < 0)
            code = cns_flow_step(f, err);
        if (code == CNS_NUMERIC && j->kind != CNS_LAW_CHECK) {
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
        const mpfr_t *u2 = (const mpfr_t *)l->ref.state + (size_t)row * (size_t)(l->n + 1);
        distance(l, (const mpfr_t *)now, u2, d);
        if (mpfr_greater_p(d, largest))
            mpfr_set(largest, d, MPFR_RNDN);
        const double part_before = part;
        part = part_of_limit(l, (const mpfr_t *)now, u2);
        const bool parted = part > 1,
                   look = parted || (l->spec->criterion == CNS_TC_ENVELOPE && fmax(part, part_before) > near);
        double within = NAN;
        if (j->kind != CNS_LAW_CHECK && look && row > 1)
            code = refine(l, j, s, (const mpfr_t *)before, u2 - (l->n + 1), &within, err);
        if (j->kind != CNS_LAW_CHECK && (parted || !isnan(within)))
            *tc = (row - 1) * l->every + (isnan(within) ? between(l, part_before, part) : within);
        cns_ensemble_tell(told, fmin(0.99, row * l->every / j->predicted));
    }
    *apart = cns_log2_mpfr(largest) * CNS_LOG10_2;
    cns_vector_free(now);
    cns_vector_free(before);
    mpfr_clears(d, largest, (mpfr_ptr)0);
    mpq_clear(time);
    return code;
}

static cns_code run(void *context, int i, cns_ensemble_job *told, char **result, cns_error *err)
{
    const cns_laws_work *l = context;
    const cns_law_job *j = &l->job[l->listed[i]];
    cns_system *smooth = NULL;
    cns_flow *f = NULL;
    cns_code code = CNS_OK;
    double tc = NAN, apart = -HUGE_VAL;
    char *failure = NULL;
    cns_falling precision = {0};
    if (j->kind == CNS_LAW_SMOOTHING && !(smooth = cns_system_smoothed(l->system, &j->value, err)))
        code = err->code;
    const cns_system *s = smooth ? smooth : l->system;
    if (!code)
        code = job_flow(l, j, s, &precision, &f, err);
    if (!code)
        code = compare(l, j, f, s, &precision, told, &tc, &apart, &failure, err);
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

cns_code cns_laws_probe(const cns_laws_work *l, const cns_law_job *first, double *truncation, cns_error *err)
{
    cns_flow *f = NULL, *truth = NULL;
    mpq_t time;
    mpq_init(time);
    const cns_flow_spec fine = cns_laws_taylor(l, l->system, first->digits, 0);
    mpfr_t d, *a = cns_vector_xnew(l->n, fine.prec), *b = cns_vector_xnew(l->n, fine.prec);
    mpfr_init2(d, CNS_LAWS_KEPT_BITS);
    *truncation = -(double)first->digits;
    cns_falling unused;
    cns_code code = job_flow(l, first, l->system, &unused, &f, err);
    if (!code && !(truth = cns_flow_new(&fine, err)))
        code = err->code;
    if (!code) {
        cns_flow_start(f, cns_system_initial(l->system));
        cns_flow_start(truth, cns_system_initial(l->system));
    }
    for (int row = 1; !code && row <= cns_laws_last_row(l) && row * l->every <= probe_time; row++) {
        cns_laws_row_time(l, row, time);
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
    cns_vector_free(a);
    cns_vector_free(b);
    mpfr_clear(d);
    mpq_clear(time);
    cns_flow_free(f);
    cns_flow_free(truth);
    /* A first step too large to go on tells nothing: the others are run, and tell for themselves. */
    return code == CNS_NUMERIC ? CNS_OK : code;
}

static void set_predicted(cns_laws_work *l)
{
    int row = 0;
    for (int i = 0; i < l->jobs; i++) {
        cns_law_job *j = &l->job[i];
        for (row = 1; row < l->ref.rows - 1 && (j->kind == CNS_LAW_CHECK || l->ref.growth[row] < j->level);
             row++)
            ;
        j->predicted = row * l->every;
        if (j->kind == CNS_LAW_CHECK)
            j->digits = l->ref.digits - CNS_LAWS_CHECK_DIGITS;
    }
}

cns_code cns_laws_run_all(cns_laws_work *l, char **results, cns_error *err)
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
