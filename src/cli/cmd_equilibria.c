/* cns equilibria: fixed points and how they attract or repel. */
#include "cns/study/equilibria.h"

#include <string.h>

#include "commands.h"
#include "report.h"

enum { STANDARD_DECIMALS = 30 };

static void print_text(FILE *out, const cns_context *cx, const void *result)
{
    const cns_model *m = cx->c->model;
    const cns_equilibria *e = result;
    int width = 2;
    for (int k = 0; k < e->d; k++)
        if ((int)strlen(m->states[e->index[k]].name) > width)
            width = (int)strlen(m->states[e->index[k]].name);
    for (int i = 0; i < e->n; i++) {
        const cns_equilibrium *p = &e->item[i];
        fprintf(out, "%s%s: %s, %d unstable %s\n", i > 0 ? "\n" : "", p->name, p->stability, p->unstable,
                p->unstable == 1 ? "direction" : "directions");
        for (int k = 0; k < e->d; k++)
            fprintf(out, "  %-*s %s%s\n", width, m->states[e->index[k]].name,
                    p->state[k][0] == '-' ? "" : " ", p->state[k]);
        fputs("  eigenvalues\n", out);
        for (int k = 0; k < e->d; k++) {
            const cns_eigenvalue *l = &p->eigenvalues[k];
            const bool minus = l->im[0] == '-';
            fprintf(out, "  %*s %s%s", width, "", l->re[0] == '-' ? "" : " ", l->re);
            if (strcmp(l->im, "0") != 0)
                fprintf(out, " %c %s i", minus ? '-' : '+', l->im + minus);
            fputc('\n', out);
        }
    }
}

static void print_yaml(cns_summary *s, const cns_context *cx, const void *result)
{
    const cns_model *m = cx->c->model;
    const cns_equilibria *e = result;
    cns_summary_long(s, "decimals", e->decimals);
    cns_summary_open_list(s, "equilibria");
    for (int i = 0; i < e->n; i++) {
        const cns_equilibrium *p = &e->item[i];
        cns_summary_open_mapping(s, NULL);
        cns_summary_text(s, "name", p->name);
        cns_summary_text(s, "stability", p->stability);
        cns_summary_long(s, "unstable", p->unstable);
        cns_summary_open_mapping(s, "state");
        for (int k = 0; k < e->d; k++)
            cns_summary_text(s, m->states[e->index[k]].name, p->state[k]);
        cns_summary_shut(s);
        cns_summary_open_list(s, "eigenvalues");
        for (int k = 0; k < e->d; k++) {
            cns_summary_open_mapping(s, NULL);
            cns_summary_text(s, "re", p->eigenvalues[k].re);
            cns_summary_text(s, "im", p->eigenvalues[k].im);
            cns_summary_shut(s);
        }
        cns_summary_shut(s);
        cns_summary_shut(s);
    }
    cns_summary_shut(s);
}

static const cns_view view = {.text = print_text, .yaml = print_yaml};

static int run(cns_context *cx)
{
    cns_equilibria *e;
    cns_error err = {0};
    const long decimals = cx->o->digits > 0 ? cx->o->digits : STANDARD_DECIMALS;
    cns_code code = cns_equilibria_find(cx->system, decimals, &cx->monitor, &e, &err);
    int status = cns_report(cx, code, &err, &view, e);
    cns_equilibria_free(e);
    return status;
}

const cns_command cns_command_equilibria = {
    .name = "equilibria",
    .run = run,
    .opens = CNS_OPENS_SYSTEM,
    .operands = "CASE",
    .least = 1,
    .most = 1,
    .summary = "fixed points, eigenvalues, stability",
    .details =
        "Fixed points of the states that feed back, such as the ways in which a disk can fall steadily, "
        "with the eigenvalues of the equations linearised there. All digits are proven in ball arithmetic. "
        "Only the case's model, parameters and abs matter.\n",
    .options =
        CNS_TAKES(CNS_OPTION_YAML, CNS_OPTION_SET, CNS_OPTION_DIGITS, CNS_OPTION_MAX_TIME, CNS_OPTION_QUIET),
};
