#include "cns/study/laws.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/files.h"
#include "core/memory.h"
#include "core/monitor.h"
#include "integrate/numerics.h"
#include "laws_internal.h"
#include "num/logs.h"
#include "solve/problem.h"

enum {
    BEYOND = 3,  /* digits of growth by which the reference outlasts the predicted last T_c */
    LONGER = 12, /* digits of growth added when a run outlasts the reference */
    EXTENSIONS = 4,
    ABOVE_ROUNDING = 3, /* digits by which truncation has to stand above rounding in the step law */
    SMOOTH_DIGITS = 14, /* of a smoothed run beyond eps^2 */
    LINE = 64
};

static void on_progress(void *context, double fraction, const char *what)
{
    const cns_laws_work *l = context;
    char text[160];
    snprintf(text, sizeof text, "%s: %s", l->base > 0 ? "laws" : "reference", what);
    cns_monitor_tell(l->problem->monitor, l->base + l->span * fraction, text);
}

/* What is asked for. */

static cns_law_job *add_job(cns_laws_work *l, cns_law_kind kind)
{
    l->job = cns_xgrow(l->job, (size_t)l->jobs + 1, sizeof *l->job);
    cns_law_job *j = &l->job[l->jobs++];
    *j = (cns_law_job){.kind = kind, .predicted = 1};
    cns_number_init(&j->value);
    return j;
}

double cns_laws_log10(const cns_number *x)
{
    mpfr_t y;
    mpfr_init2(y, 64);
    cns_number_get_mpfr(y, x);
    const double log10 = cns_log2_mpfr(y) * CNS_LOG10_2;
    mpfr_clear(y);
    return log10;
}

/* Values in equal ratios, as texts of four digits; what is run is the text. */
static void add_decades(cns_laws_work *l, cns_law_kind kind, const cns_decades *d)
{
    const double from = cns_laws_log10(&d->from), to = cns_laws_log10(&d->to);
    for (long k = 0; from - (double)k / (double)d->per_decade > to - 1e-6; k++) {
        char text[LINE];
        const double at = from - (double)k / (double)d->per_decade + 1e-9, e = floor(at);
        snprintf(text, sizeof text, "%.4ge%.0f", pow(10, at - e), e);
        cns_law_job *j = add_job(l, kind);
        j->text = cns_xcopy(k == 0 ? d->from.text : text);
        cns_number_parse(&j->value, j->text, NULL);
        j->x = -cns_laws_log10(&j->value);
    }
}

static cns_code add_jobs(cns_laws_work *l, cns_error *err)
{
    const cns_laws_spec *s = l->spec;
    for (long k = s->digits.from; s->has_digits && k <= s->digits.to; k += s->digits.by) {
        char text[LINE];
        cns_law_job *j = add_job(l, CNS_LAW_DIGITS);
        snprintf(text, sizeof text, "%ld", k);
        j->text = cns_xcopy(text);
        j->x = j->level = (double)k;
        j->digits = k;
    }
    const int first = l->jobs;
    if (s->has_steps)
        add_decades(l, CNS_LAW_STEPS, &s->steps.sizes);
    double truncation = 0;
    for (int i = first; i < l->jobs; i++) {
        cns_law_job *j = &l->job[i];
        j->digits = s->steps.digits;
        if (i == first) {
            cns_code code = cns_laws_probe(l, j, &truncation, err);
            if (code)
                return code;
        }
        j->level = l->order * (j->x - l->job[first].x) - truncation;
        /* Rounding adds up over 1/h steps per unit of time. */
        if (j->level > (double)j->digits - fmax(0, j->x) - ABOVE_ROUNDING)
            j->skip = "truncation would not stand above rounding";
    }
    if (s->has_smoothing)
        add_decades(l, CNS_LAW_SMOOTHING, &s->smoothing);
    for (int i = 0; i < l->jobs; i++)
        if (l->job[i].kind == CNS_LAW_SMOOTHING) {
            cns_law_job *j = &l->job[i];
            j->level = 2 * j->x;
            j->digits = (long)ceil(2 * fmax(0, j->x)) + SMOOTH_DIGITS;
        }
    l->level = 0;
    for (int i = 0; i < l->jobs; i++)
        if (!l->job[i].skip)
            l->level = fmax(l->level, ceil(l->job[i].level));
    l->level += BEYOND;
    add_job(l, CNS_LAW_CHECK)->text = cns_xcopy("reference");
    return CNS_OK;
}

static bool any_beyond(const cns_laws_work *l, char **results)
{
    for (int i = 0; i < l->n_listed; i++)
        if (l->job[l->listed[i]].kind != CNS_LAW_CHECK && strncmp(results[i], "beyond", 6) == 0)
            return true;
    return false;
}

static cns_code check(const cns_laws_work *l, cns_error *err)
{
    const cns_laws_spec *s = l->spec;
    if (!s->has_digits && !s->has_steps && !s->has_smoothing)
        return cns_fail(err, CNS_USAGE, "'laws' asks for none of 'digits', 'steps' and 'smoothing'");
    if (s->has_smoothing && cns_system_smooth(l->system))
        return cns_fail(err, CNS_USAGE, "'laws: smoothing' needs 'abs: exact', which it is compared with");
    if (l->delta_log10 < CNS_LAWS_TRUST_DIGITS - CNS_LAWS_FINE_DIGITS / 2 - 1e-9)
        return cns_fail(err, CNS_USAGE, "'laws: delta' is too small: at least 1e%d",
                        CNS_LAWS_TRUST_DIGITS - CNS_LAWS_FINE_DIGITS / 2);
    return CNS_OK;
}

cns_code cns_laws(const cns_problem *problem, const cns_laws_spec *spec, const char *directory,
                  cns_laws_result *r, cns_error *err)
{
    cns_laws_work l = {.problem = problem,
                       .system = problem->system,
                       .spec = spec,
                       .directory = directory,
                       .n = cns_system_model(problem->system)->n_states,
                       .every = cns_number_get_d(cns_every(problem)),
                       .delta_log10 = cns_laws_log10(&spec->delta)};
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
    l.identity = cns_system_identity(
        l.system, -1, "laws, end %s, every %s, delta %s, criterion %s, observable %d", problem->end->text,
        cns_every(problem)->text, spec->delta.text, cns_tc_criterion_name(spec->criterion), spec->observable);
    code = l.identity != NULL ? add_jobs(&l, err) : cns_out_of_memory(err);
    char **results = cns_xalloc((size_t)l.jobs, sizeof *results);
    l.listed = cns_xalloc((size_t)l.jobs, sizeof *l.listed);
    for (int extension = 0; !code; extension++) {
        code = cns_laws_make_reference(&l, err);
        if (!code)
            code = cns_laws_run_all(&l, results, err);
        const bool done =
            code || extension == EXTENSIONS || l.ref.rows > cns_laws_last_row(&l) || !any_beyond(&l, results);
        if (!code && done)
            code = cns_laws_conclude(&l, results, r, err);
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
    cns_laws_reference_clear(&l.ref);
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
