/* cns orbit: periodic orbits and their multipliers. */
#include "cns/study/orbit.h"

#include <string.h>

#include "commands.h"
#include "report.h"

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

static const cns_view view = {.text = print_text, .yaml = print_yaml};

static int run(cns_context *cx)
{
    cns_orbit *o = NULL;
    cns_error err = {0};
    cns_code code = cns_orbit_find(cx->system, &cx->c->orbit, &cx->monitor, &o, &err);
    int status = cns_report(cx, code, &err, &view, o);
    cns_orbit_free(o);
    return status;
}

const cns_command cns_command_orbit = {
    .name = "orbit",
    .run = run,
    .opens = CNS_OPENS_SYSTEM,
    .operands = "CASE",
    .least = 1,
    .most = 1,
    .summary = "a periodic orbit, its period and Floquet multipliers",
    .details = "A periodic orbit.\n",
    .options = CNS_TAKES(CNS_OPTION_YAML, CNS_OPTION_SET, CNS_OPTION_MAX_TIME, CNS_OPTION_QUIET),
};
