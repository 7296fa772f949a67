#include "commands.h"

#include "cns/case.h"
#include "report.h"

int cns_cmd_check(const cns_options *o)
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
