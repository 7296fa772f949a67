#include <stdlib.h>

#include "bisect_internal.h"

cns_code cns_bisect(const cns_system *s, const cns_bisect_spec *spec, const char *directory,
                    const cns_monitor *monitor, cns_bisect_result *r, cns_error *err)
{
    char *identity = cns_system_identity(s, spec->parameter, "bisect by %s",
                                         spec->by_manifold ? "manifold" : "trajectory");
    const cns_bisection b = {s, spec, monitor, directory, identity, r};
    *r = (cns_bisect_result){.decimals = -1};
    const cns_code code =
        spec->by_manifold ? cns_bisect_by_manifold(&b, err) : cns_bisect_by_trajectory(&b, err);
    free(identity);
    return code;
}

void cns_bisect_clear(cns_bisect_result *r)
{
    free(r->lower);
    free(r->upper);
    free(r->critical);
    *r = (cns_bisect_result){.decimals = -1};
}
