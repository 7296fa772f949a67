/* cns laws: T_c against digits, step and smoothing. */
#include <math.h>

#include "cns/study/laws.h"
#include "commands.h"
#include "core/clock.h"
#include "report.h"

static const struct words {
    const char *key, *point, *title, *line;
} words[CNS_LAW_KINDS] = {
    {"digits_law", "digits", "T_c against digits K", "K"},
    {"step_law", "step", "T_c against the step h", "(-log10 h)"},
    {"smoothing_law", "eps", "T_c against the smoothing eps", "(-log10 eps)"},
};

/* The published line that a law of this case compares with; NULL: there is none. */
static const cns_model_line *published(const cns_case *c, const cns_laws_result *r, cns_law_kind kind)
{
    const cns_model_published *p = c->model->published;
    if (p != NULL && kind == CNS_LAW_DIGITS)
        return &p->digits;
    if (p != NULL && kind == CNS_LAW_STEPS && r->order == p->order)
        return &p->steps;
    return NULL;
}

static const char *observable(const cns_case *c)
{
    const int i = c->laws.observable;
    return i == CNS_OBSERVABLE_NORM ? "norm" : c->model->states[i].name;
}

static double kappa_of(const cns_laws_result *r)
{
    const cns_law *law = &r->law[CNS_LAW_DIGITS];
    return law->fitted ? log(10) / law->time.slope : NAN;
}

typedef struct short_text {
    char text[32];
} short_text;

/* Growth is known to ten digits (laws_reference.c): a scatter of the points below this is not measured. */
static double least_error(double figure)
{
    return 1e-9 * fmax(fabs(figure), 1);
}

/* An error to the decimals of its figure; where they would show nothing of it, to two digits. */
static short_text error_of(double error, double figure, int decimals)
{
    short_text t;
    const double least = least_error(figure);
    if (error >= 0.5 * pow(10, -decimals))
        snprintf(t.text, sizeof t.text, "%.*f", decimals, error);
    else if (error >= least)
        snprintf(t.text, sizeof t.text, "%.1e", error);
    else
        snprintf(t.text, sizeof t.text, "below %.0e", least);
    return t;
}

/* The same for a summary: what is told, or the least that is. */
static double told(double error, double figure)
{
    return fmax(error, least_error(figure));
}

/* A size by its log10; none at all has one below all numbers that are. */
static short_text size_of(double log10)
{
    short_text t = {"0"};
    if (log10 > -1e9)
        snprintf(t.text, sizeof t.text, "10^%.1f", log10);
    return t;
}

static void print_law(FILE *out, const cns_case *c, const cns_laws_result *r, cns_law_kind kind)
{
    const cns_law *law = &r->law[kind];
    const cns_fit *f = &law->time, *g = &law->level;
    const struct words *w = &words[kind];
    fprintf(out, "\n%s\n  %-12s %12s %10s  %s\n", w->title, w->point, "T_c", "growth", "growth - level");
    for (int i = 0; i < law->n; i++) {
        const cns_law_point *p = &law->point[i];
        if (p->left_out)
            fprintf(out, "  %-12s left out: %s\n", p->text, p->left_out);
        else if (law->fitted)
            fprintf(out, "  %-12s %12.4f %10.2f  %+.2f\n", p->text, p->tc, p->growth,
                    p->growth - (kind == CNS_LAW_DIGITS ? p->x : g->slope * p->x + g->intercept));
        else
            fprintf(out, "  %-12s %12.4f %10.2f\n", p->text, p->tc, p->growth);
    }
    if (!law->fitted) {
        fprintf(out, "  no line: it needs three points and exponential growth\n");
        return;
    }
    fprintf(out, "  T_c = %.3f %s %+.2f\n", f->slope, w->line, f->intercept);
    fprintf(out, "    slope      %.3f, standard error %s, 95 %% limits +- %s\n", f->slope,
            error_of(f->slope_se, f->slope, 3).text, error_of(f->slope_95, f->slope, 3).text);
    fprintf(out, "    intercept  %.2f, standard error %s, 95 %% limits +- %s\n", f->intercept,
            error_of(f->intercept_se, f->intercept, 2).text, error_of(f->intercept_95, f->intercept, 2).text);
    fprintf(out, "    R2 %.4f; robust slope (Theil-Sen) %.3f; efficient slope %.3f, standard error %s\n",
            f->r2, f->slope_robust, f->slope_gls, error_of(f->slope_gls_se, f->slope_gls, 3).text);
    fprintf(out, "    growth at T_c: %.3f digits per unit, standard error %s; scatter %s digits\n", g->slope,
            error_of(g->slope_se, g->slope, 3).text, error_of(g->residual_sd, g->slope, 2).text);
    const cns_law *digits = &r->law[CNS_LAW_DIGITS];
    if (kind != CNS_LAW_DIGITS && digits->fitted)
        fprintf(out, "    slope over the slope per digit: %.3f%s\n", f->slope / digits->time.slope,
                kind == CNS_LAW_STEPS ? ", roughly the order" : "");
    const cns_model_line *known = published(c, r, kind);
    if (known != NULL)
        fprintf(out, "    %s for their %s: %.2f and %.2f; their slope lies %s these 95 %% limits\n",
                c->model->published->authors, c->model->published->subject, known->slope, known->intercept,
                fabs(f->slope - known->slope) <= f->slope_95 ? "within" : "outside");
}

/* T_c is the smaller of what the digits and what the steps allow. */
static void print_both(FILE *out, cns_model_line digits, cns_model_line steps)
{
    fprintf(out, "T_c ~ min{%.2f K %+.2f, %.2f log10 h %+.2f}", digits.slope, digits.intercept, -steps.slope,
            steps.intercept);
}

static void print_text(FILE *out, const cns_context *cx, const void *result)
{
    const cns_case *c = cx->c;
    const cns_laws_result *r = result;
    const double expected = log(10) / r->lambda;
    fprintf(out, "Critical predictable times of %s, observable %s, delta = %s\n", c->name, observable(c),
            c->laws.delta.text);
    cns_print_criterion(out, c);
    fprintf(out,
            "reference: %ld digits to t = %g; its error there %s by tangents, %s by a second reference\n",
            r->reference_digits, r->reference_end, size_of(r->reference_error).text,
            size_of(r->reference_check).text);
    fprintf(out,
            "growth along it: lambda = %.4f +- %s, %.2f per digit; standard deviation %s digits per "
            "root of time\n",
            r->lambda, error_of(r->lambda_se, r->lambda, 4).text, expected,
            error_of(sqrt(r->variance), r->lambda, 3).text);
    for (int k = 0; k < CNS_LAW_KINDS; k++)
        if (r->law[k].n > 0)
            print_law(out, c, r, (cns_law_kind)k);
    const cns_law *a = &r->law[CNS_LAW_DIGITS], *h = &r->law[CNS_LAW_STEPS];
    if (a->fitted)
        fprintf(out, "\nkappa = ln 10 / slope per digit = %.4f; lambda = %.4f +- %s\n", kappa_of(r),
                r->lambda, error_of(r->lambda_se, r->lambda, 4).text);
    if (!a->fitted || !h->fitted)
        return;
    print_both(out, (cns_model_line){a->time.slope, a->time.intercept},
               (cns_model_line){h->time.slope, h->time.intercept});
    fputc('\n', out);
    const cns_model_line *k = published(c, r, CNS_LAW_DIGITS), *l = published(c, r, CNS_LAW_STEPS);
    if (k == NULL || l == NULL)
        return;
    print_both(out, *k, *l);
    fprintf(out, " in the paper, for its %s\n", c->model->published->subject);
}

static void summarise_law(cns_summary *s, const cns_law *law, const struct words *w)
{
    cns_summary_open_mapping(s, w->key);
    if (law->fitted) {
        const cns_fit *f = &law->time;
        cns_summary_number(s, "slope", f->slope, 7);
        cns_summary_number(s, "slope_se", told(f->slope_se, f->slope), 4);
        cns_summary_number(s, "slope_95", told(f->slope_95, f->slope), 4);
        cns_summary_number(s, "intercept", f->intercept, 7);
        cns_summary_number(s, "intercept_se", told(f->intercept_se, f->intercept), 4);
        cns_summary_number(s, "r2", f->r2, 6);
        cns_summary_number(s, "slope_robust", f->slope_robust, 7);
        cns_summary_number(s, "slope_gls", f->slope_gls, 7);
        cns_summary_number(s, "slope_gls_se", told(f->slope_gls_se, f->slope_gls), 4);
        cns_summary_number(s, "growth_slope", law->level.slope, 6);
        cns_summary_number(s, "growth_slope_se", told(law->level.slope_se, law->level.slope), 3);
        cns_summary_number(s, "growth_scatter", told(law->level.residual_sd, law->level.slope), 3);
    }
    for (int out = 0; out < 2; out++) {
        cns_summary_open_list(s, out ? "left_out" : "points");
        for (int i = 0; i < law->n; i++) {
            const cns_law_point *p = &law->point[i];
            if ((p->left_out != NULL) != out)
                continue;
            cns_summary_open_mapping(s, NULL);
            cns_summary_text(s, w->point, p->text);
            if (out) {
                cns_summary_text(s, "why", p->left_out);
            } else {
                cns_summary_number(s, "tc", p->tc, 9);
                cns_summary_number(s, "growth", p->growth, 5);
            }
            cns_summary_shut(s);
        }
        cns_summary_shut(s);
    }
    cns_summary_shut(s);
}

static void print_yaml(cns_summary *s, const cns_context *cx, const void *result)
{
    const cns_laws_result *r = result;
    cns_summary_text(s, "delta", cx->c->laws.delta.text);
    cns_summarise_criterion(s, cx->c);
    cns_summary_text(s, "observable", observable(cx->c));
    cns_summary_long(s, "reference_digits", r->reference_digits);
    cns_summary_number(s, "reference_end", r->reference_end, 12);
    for (int k = 0; k < CNS_LAW_KINDS; k++)
        if (r->law[k].n > 0)
            summarise_law(s, &r->law[k], &words[k]);
    if (r->law[CNS_LAW_DIGITS].fitted)
        cns_summary_number(s, "kappa", kappa_of(r), 6);
    cns_summary_number(s, "lambda", r->lambda, 6);
    cns_summary_number(s, "lambda_se", told(r->lambda_se, r->lambda), 3);
}

static const cns_view view = {.text = print_text, .yaml = print_yaml};

static int run(cns_context *cx)
{
    const cns_case *c = cx->c;
    cns_error err = {0};
    cns_laws_result r;
    if (!c->has_laws)
        return cns_complain_of_case(c, "no 'laws': `cns laws` needs that section");
    cx->keeper = "-o DIR";
    cx->kept = cx->o->output;
    cns_code code = cns_laws(&cx->problem, &c->laws, cx->o->output, &r, &err);
    int status = cns_report(cx, code, &err, &view, code ? NULL : &r);
    for (int k = 0; k < CNS_LAW_KINDS && !status; k++)
        if (r.law[k].n > 0 && !r.law[k].fitted)
            status = cns_complain(CNS_UNREACHED,
                                  "no line for %s: fewer than three points, or no exponential growth",
                                  words[k].key);
    if (cx->o->verbose && !status)
        cns_note(cx, "%.2f s", cns_seconds() - cx->since);
    cns_laws_result_clear(&r);
    return status;
}

const cns_command cns_command_laws = {
    .name = "laws",
    .run = run,
    .opens = CNS_OPENS_SYSTEM,
    .times = CNS_TIMES_REFUSED,
    .operands = "CASE",
    .least = 1,
    .most = 1,
    .summary = "T_c against digits, step and smoothing: runs, fits, errors",
    .details =
        "Runs of K digits, of fixed steps and of smoothed absolute values, as `laws` in the case says, all "
        "against one finer reference, and straight lines through their critical predictable times. Errors "
        "of slopes allow for the fluctuation of growth, which all runs share. Runs stop by themselves; "
        "`time: end` is only where to give up, `time: every` the rows. With -o DIR every run is kept, and "
        "the same command does what is missing.\n",
    .options = CNS_TAKES(CNS_OPTION_OUTPUT_DIR, CNS_OPTION_YAML, CNS_OPTION_SET, CNS_OPTION_MAX_TIME,
                         CNS_OPTION_THREADS, CNS_OPTION_QUIET, CNS_OPTION_VERBOSE),
};
