/* cns orbit: periodic orbits and their multipliers. */
#include "cns/study/orbit.h"

#include <string.h>

#include "commands.h"
#include "io/provenance.h"
#include "report.h"
#include "signals.h"

static void print_multipliers(FILE *out, const cns_eigenvalue *m, int n, int width)
{
    for (int k = 0; k < n; k++) {
        const bool minus = m[k].im[0] == '-';
        fprintf(out, "%*s %s%s", width, "", m[k].re[0] == '-' ? "" : " ", m[k].re);
        if (strcmp(m[k].im, "0") != 0)
            fprintf(out, " %c %s i", minus ? '-' : '+', m[k].im + minus);
        fputc('\n', out);
    }
}

static void print_value(FILE *out, int width, const char *key, const char *value, const char *meaning)
{
    fprintf(out, "%-*s %s%s%s%s\n", width, key, value[0] == '-' ? "" : " ", value,
            meaning[0] != '\0' ? "   " : "", meaning);
}

enum { WIDTH = 10 };

static void print_text(FILE *out, const cns_context *cx, const void *result)
{
    const cns_orbit *o = result;
    const cns_model *m = cx->c->model;
    print_value(out, WIDTH, "period", o->period, "");
    if (m->motion != NULL)
        fprintf(out, "%-*s  %ld   whole revolutions in a period\n", WIDTH, "winding", o->winding);
    if (o->repetitions > 1)
        fprintf(out, "%-*s  %s after 1/%d of the period\n", WIDTH, "symmetry", o->symmetry, o->repetitions);
    for (int k = 0; k < o->d; k++)
        print_value(out, WIDTH, m->states[o->index[k]].name, o->state[k],
                    o->index[k] == o->held ? "held" : "");
    for (int i = 0; i < o->n_states; i++)
        if (o->drift[i] != NULL) {
            char key[64];
            snprintf(key, sizeof key, "drift %.50s", m->states[i].name);
            print_value(out, WIDTH, key, o->drift[i], "in a period");
        }
    fprintf(out, "%-*s  %s, %d unstable %s\n", WIDTH, "stability", o->stability, o->unstable,
            o->unstable == 1 ? "direction" : "directions");
    fprintf(out, "multipliers of the period, besides the 1 along the orbit\n");
    print_multipliers(out, o->multiplier, o->d - 1, WIDTH);
    if (o->repetitions > 1) {
        fprintf(out, "multipliers of 1/%d of it, the image taken back\n", o->repetitions);
        print_multipliers(out, o->repetition, o->d - 1, WIDTH);
    }
    fprintf(out,
            "%-*s  solutions with %ld and %ld digits, other orders and steps, differ by 10^%.1f;\n"
            "%*s  Kantorovich's h = 10^%.1f; det = exp(integral of trace) within their errors\n",
            WIDTH, "proof", o->digits, o->coarse_digits, o->difference, WIDTH, "", o->kantorovich);
}

static void yaml_multipliers(cns_summary *s, const char *key, const cns_eigenvalue *m, int n)
{
    cns_summary_open_list(s, key);
    for (int k = 0; k < n; k++) {
        cns_summary_open_mapping(s, NULL);
        cns_summary_text(s, "re", m[k].re);
        cns_summary_text(s, "im", m[k].im);
        cns_summary_shut(s);
    }
    cns_summary_shut(s);
}

static void print_yaml(cns_summary *s, const cns_context *cx, const void *result)
{
    const cns_orbit *o = result;
    const cns_model *m = cx->c->model;
    cns_summary_long(s, "decimals", o->decimals);
    cns_summary_text(s, "period", o->period);
    cns_summary_long(s, "winding", o->winding);
    cns_summary_long(s, "repetitions", o->repetitions);
    if (o->repetitions > 1)
        cns_summary_text(s, "symmetry", o->symmetry);
    cns_summary_text(s, "held", m->states[o->held].name);
    cns_summary_open_mapping(s, "state");
    for (int k = 0; k < o->d; k++)
        cns_summary_text(s, m->states[o->index[k]].name, o->state[k]);
    cns_summary_shut(s);
    cns_summary_open_mapping(s, "drift");
    for (int i = 0; i < o->n_states; i++)
        if (o->drift[i] != NULL)
            cns_summary_text(s, m->states[i].name, o->drift[i]);
    cns_summary_shut(s);
    cns_summary_text(s, "stability", o->stability);
    cns_summary_long(s, "unstable", o->unstable);
    yaml_multipliers(s, "multipliers", o->multiplier, o->d - 1);
    if (o->repetitions > 1)
        yaml_multipliers(s, "multipliers_of_repetition", o->repetition, o->d - 1);
    cns_summary_long(s, "digits", o->digits);
    cns_summary_long(s, "proof_digits", o->coarse_digits);
}

static int find(cns_context *cx)
{
    static const cns_view view = {.text = print_text, .yaml = print_yaml};
    cns_orbit *o = NULL;
    cns_error err = {0};
    cns_code code = cns_orbit_find(cx->system, &cx->c->orbit, &cx->monitor, &o, &err);
    int status = cns_report(cx, code, &err, &view, o);
    cns_orbit_free(o);
    return status;
}

/* What a sweep found. */
typedef struct found_branch {
    cns_sweep sweep;
    cns_branch *branch;
    const char *reason; /* why it ends early; NULL: it does not */
} found_branch;

/* The first orbit; NULL: there is none. */
static const cns_orbit *first_orbit(const cns_branch *b)
{
    for (int i = 0; i < b->n; i++)
        if (b->point[i].orbit != NULL)
            return b->point[i].orbit;
    return NULL;
}

static void print_header(FILE *out, const cns_model *m, const char *varied, const cns_orbit *o)
{
    fprintf(out, "%s,crossing,period,repetitions,winding", varied);
    for (int k = 0; k < o->d; k++)
        fprintf(out, ",%s", m->states[o->index[k]].name);
    for (int i = 0; i < o->n_states; i++)
        if (o->drift[i] != NULL)
            fprintf(out, ",drift_%s", m->states[i].name);
    fputs(",stability,unstable", out);
    for (int k = 1; k < o->d; k++)
        fprintf(out, ",multiplier%d,multiplier%d_im", k, k);
    for (int k = 1; k < o->d; k++)
        fprintf(out, ",repetition%d,repetition%d_im", k, k);
    fputs(",decimals\n", out);
}

static void print_row(FILE *out, const cns_branch_point *p)
{
    const cns_orbit *o = p->orbit;
    fprintf(out, "%s,%s,%s,%d,%ld", p->parameter, cns_crossing_name(p->crossing), o->period, o->repetitions,
            o->winding);
    for (int k = 0; k < o->d; k++)
        fprintf(out, ",%s", o->state[k]);
    for (int i = 0; i < o->n_states; i++)
        if (o->drift[i] != NULL)
            fprintf(out, ",%s", o->drift[i]);
    fprintf(out, ",%s,%d", o->stability, o->unstable);
    for (int k = 0; k < o->d - 1; k++)
        fprintf(out, ",%s,%s", o->multiplier[k].re, o->multiplier[k].im);
    for (int k = 0; k < o->d - 1; k++)
        fprintf(out, ",%s,%s", o->repetition[k].re, o->repetition[k].im);
    fprintf(out, ",%ld\n", o->decimals);
}

static void print_branch(FILE *out, const cns_context *cx, const void *result)
{
    const found_branch *found = result;
    const cns_branch *b = found->branch;
    cns_provenance_begin(out, cx->c, "periodic orbits of ", CNS_PROVENANCE_CASE);
    const cns_sweep_title varied = cns_sweep_name(&found->sweep, cx->c->model);
    fprintf(out, "# sweep: %s\n", cx->o->sweep);
    print_header(out, cx->c->model, varied.text, first_orbit(b));
    for (int i = 0; i < b->n; i++) {
        if (b->point[i].orbit != NULL)
            print_row(out, &b->point[i]);
        if (b->point[i].note != NULL)
            fprintf(out, "# %s=%s: %s\n", varied.text, b->point[i].parameter, b->point[i].note);
    }
    cns_provenance_end(out, found->reason);
}

static int follow(cns_context *cx)
{
    static const cns_view view = {.text = print_branch};
    found_branch found = {.branch = NULL};
    cns_error err = {0};
    if (cns_sweep_parse(&found.sweep, cx->c->model, cx->o->sweep, &err))
        return cns_complain(err.code, "--sweep: %s", err.text);
    cns_code code =
        cns_orbit_follow(cx->system, &cx->c->orbit, &found.sweep, &cx->monitor, &found.branch, &err);
    const cns_branch *b = found.branch;
    const bool to_the_end = b->n > 0 && b->point[b->n - 1].orbit != NULL; /* but for some decimals */
    found.reason = !code || (code == CNS_UNREACHED && to_the_end) ? NULL
                   : cns_signal_stop                              ? cns_signal_text()
                                                                  : err.text;
    int status = cns_report(cx, code, &err, &view, first_orbit(found.branch) != NULL ? &found : NULL);
    cns_branch_free(found.branch);
    cns_sweep_clear(&found.sweep);
    return status;
}

static int run(cns_context *cx)
{
    if (cx->o->sweep != NULL && cx->o->yaml)
        return cns_complain(CNS_USAGE, "--sweep prints a table: it does not go with --yaml");
    return cx->o->sweep != NULL ? follow(cx) : find(cx);
}

const cns_command cns_command_orbit = {
    .name = "orbit",
    .run = run,
    .opens = CNS_OPENS_SYSTEM,
    .operands = "CASE",
    .least = 1,
    .most = 1,
    .summary = "a periodic orbit, its period and Floquet multipliers",
    .details =
        "Newton's method with the variational equations, in multiple precision, from a guess (`initial` and "
        "`orbit.period`), or, without a period, from the late motion: the cycle that it tends to, or one "
        "that a "
        "chaotic motion comes near to. `orbit.decimals` says how many decimals. Keys:\n"
        "  period       after which the motion repeats, up to place and whole revolutions of its angle "
        "(winding)\n"
        "  symmetry     the part of a period, a repetition, after which the motion is an image of itself\n"
        "  multipliers  of small deviations in a period, and in a repetition with the image taken back; the "
        "1 "
        "along the orbit is left out; all inside the unit circle: stable\n"
        "  proof        every value comes from two solutions that differ in digits, orders and all steps\n"
        "With --sweep the orbit is followed in a parameter, stable or not, and a table printed. Where a "
        "multiplier "
        "of a repetition crosses the unit circle a row is added, with the place to as many decimals. "
        "crossing: fold "
        "(1, the branch turns back), branch point (1, another branch crosses), doubling (-1, an orbit of "
        "twice "
        "the period branches off), symmetry breaking (-1 of an even part of a period: orbits of the same "
        "period "
        "without the symmetry branch off), Neimark-Sacker (a complex pair).\n",
    .options =
        CNS_TAKES(CNS_OPTION_YAML, CNS_OPTION_SET, CNS_OPTION_SWEEP, CNS_OPTION_MAX_TIME, CNS_OPTION_QUIET),
};
