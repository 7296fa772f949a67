#include "cns/status.h"

#include <stdarg.h>
#include <stdio.h>

cns_code cns_fail(cns_error *err, cns_code code, const char *format, ...)
{
    if (err != NULL) {
        va_list args;
        va_start(args, format);
        err->code = code;
        if (vsnprintf(err->text, sizeof err->text, format, args) < 0)
            err->text[0] = '\0';
        va_end(args);
    }
    return code;
}

cns_code cns_out_of_memory(cns_error *err)
{
    return cns_fail(err, CNS_MEMORY, "out of memory; fewer digits, a lower order or fewer threads need less");
}
