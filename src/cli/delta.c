#include "delta.h"

#include "core/text.h"
#include "report.h"

int cns_delta_read(const cns_options *o, cns_number *delta)
{
    cns_error err;
    const char *text = o->delta ? o->delta : "0.01";
    cns_number_init(delta);
    if (!cns_number_parse(delta, text, &err) && cns_number_sign(delta) > 0 && delta->pi_power == 0)
        return 0;
    cns_number_clear(delta);
    return cns_complain(CNS_USAGE, "--delta takes a number > 0, such as 0.01, not '%s'",
                        cns_quote(text).text);
}
