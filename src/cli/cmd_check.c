#include "commands.h"

#include "cns/case.h"
#include "report.h"

static int run(const cns_options *o)
{
    cns_case *c;
    cns_code code = cns_open_case(o, &c);
    if (code != CNS_OK)
        return (int)code;
    int status = CNS_OK;
    cns_page page;
    if (!o->quiet && (status = (int)cns_page_open(&page)) == CNS_OK) {
        cns_case_print(c, page.file);
        if (!c->has_goal && !c->has_numerics)
            fputs("# neither goal nor numerics: `cns run` needs one\n", page.file);
        status = cns_page_print(&page);
    }
    cns_case_free(c);
    return status;
}

const cns_command cns_command_check = {
    .name = "check",
    .run = run,
    .operands = "CASE",
    .least = 1,
    .most = 1,
    .summary = "check a case file and print it with all defaults filled in",
    .details = "All faults are reported, one per line, with line and column. What is printed is a case\n"
               "file again (sections of studies left out), with the overrides of --set applied.\n"
               "With -q nothing is printed: the exit status tells.\n",
    .options = CNS_TAKES(CNS_OPTION_SET, CNS_OPTION_QUIET),
};
