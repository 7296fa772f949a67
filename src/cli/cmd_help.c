/* cns help: the overview, a command, or the keys of case files. */
#include <string.h>

#include "cns/case.h"
#include "commands.h"
#include "core/text.h"
#include "report.h"

static void print_statuses(FILE *out)
{
    fputs("\nExit status: 0 done; 1 the asked decimals were not reached (what was is printed); 2 command "
          "line or "
          "case file; 3 numerical failure; 4 input or output; 128 + n stopped by signal n (141: the reader "
          "of the "
          "output has gone).\n",
          out);
}

static void print_overview(FILE *out, const cns_context *cx, const void *result)
{
    (void)cx;
    (void)result;
    fputs("cns: trajectories of chaotic systems with every printed decimal right\n\nUsage:\n", out);
    const cns_command *c;
    for (int i = 0; (c = cns_command_at(i)) != NULL; i++) {
        char shown[64];
        snprintf(shown, sizeof shown, "%s %s", c->name, c->operands);
        fprintf(out, "  cns %-16s %s\n", shown, c->summary);
    }
    fputs("\nOptions of every command:\n", out);
    cns_options_print(NULL, out);
    fputs("\n`cns help COMMAND` shows a command's own options, `cns help case` the keys of case files.\n",
          out);
    print_statuses(out);
}

static void print_command(FILE *out, const cns_context *cx, const void *result)
{
    const cns_command *c = result;
    (void)cx;
    fprintf(out, "Usage: cns %s %s\n\n%s\n", c->name, c->operands, c->summary);
    if (c->details != NULL)
        fprintf(out, "\n%s", c->details);
    fputs("\nOptions:\n", out);
    cns_options_print(c, out);
    print_statuses(out);
}

static void print_keys(FILE *out, const cns_context *cx, const void *result)
{
    (void)cx;
    (void)result;
    cns_case_print_keys(out);
}

/* `cns help [TOPIC]`, `cns -h`, and `cns COMMAND -h`. */
static int run(cns_context *cx)
{
    const cns_options *o = cx->o;
    const char *topic = !o->help && o->operands.n > 0 ? o->operands.at[0] : NULL;
    const cns_command *c = topic != NULL ? cns_command_find(topic) : o->help ? o->command : NULL;
    if (topic != NULL && c == NULL && strcmp(topic, "case") == 0)
        return cns_show(cx, &(cns_view){.text = print_keys, .folded = true}, NULL);
    if (topic != NULL && c == NULL) {
        const char *nearest = cns_command_nearest(topic);
        if (nearest != NULL)
            return cns_complain(CNS_USAGE, "no help on '%s'; did you mean '%s'?", cns_quote(topic).text,
                                nearest);
        return cns_complain(CNS_USAGE, "no help on '%s'; `cns help` lists the commands",
                            cns_quote(topic).text);
    }
    return cns_show(cx, &(cns_view){.text = c != NULL ? print_command : print_overview, .folded = true}, c);
}

const cns_command cns_command_help = {
    .name = "help",
    .run = run,
    .operands = "[COMMAND]",
    .least = 0,
    .most = 1,
    .summary = "describe a command, or the keys of case files (`help case`)",
};
