#include <stdlib.h>

#include "cns/study/bisect.h"

void cns_bisect_clear(cns_bisect_result *r)
{
    free(r->lower);
    free(r->upper);
    free(r->critical);
    *r = (cns_bisect_result){.decimals = -1};
}
