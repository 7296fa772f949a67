/* cns check: the case, with its faults or its defaults. */
#include "commands.h"
#include "report.h"

static void print_text(FILE *out, const cns_context *cx, const void *result)
{
    (void)result;
    cns_case_print(cx->c, out);
    if (!cx->c->has_goal && !cx->c->has_numerics)
        fputs("# neither goal nor numerics: `cns run` needs one\n", out);
}

static int run(cns_context *cx)
{
    return cx->o->quiet ? 0 : cns_show(cx, &(cns_view){.text = print_text}, NULL);
}

const cns_command cns_command_check = {
    .name = "check",
    .run = run,
    .opens = CNS_OPENS_CASE,
    .operands = "CASE",
    .least = 1,
    .most = 1,
    .summary = "check a case file and print it with all defaults filled in",
    .details =
        "All faults are reported, one per line, with line and column. What is printed is a case file again "
        "(sections of studies left out), with the overrides of --set applied. With -q nothing is printed: "
        "the exit status tells.\n",
    .options = CNS_TAKES(CNS_OPTION_SET, CNS_OPTION_QUIET),
};
