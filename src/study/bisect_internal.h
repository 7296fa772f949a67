/* What the two ways to bisect share. Private to src/study. */
#ifndef CNS_STUDY_BISECT_INTERNAL_H
#define CNS_STUDY_BISECT_INTERNAL_H

#include "cns/study/bisect.h"

typedef struct cns_bisection {
    const cns_system *system;
    const cns_bisect_spec *spec;
    const cns_monitor *monitor;
    const char *directory, *identity; /* of the probes that are kept: see ensemble.h */
    cns_bisect_result *r;             /* empty at first */
} cns_bisection;

cns_code cns_bisect_by_trajectory(const cns_bisection *b, cns_error *err);
cns_code cns_bisect_by_manifold(const cns_bisection *b, cns_error *err);

#endif
