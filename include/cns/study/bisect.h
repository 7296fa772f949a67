/* Critical parameters: where the long-time behaviour of a system changes from one mode to another, to as many
 * decimals as asked for. By trajectory: the mode that the system's own trajectory falls into. By manifold:
 * the side on which the unstable manifold of a saddle passes the next saddle (the model's
 * cns_model_connection says which saddle, and what the sides mean); at the critical value it runs into it. */
#ifndef CNS_STUDY_BISECT_H
#define CNS_STUDY_BISECT_H

#include <stdbool.h>

#include "cns/monitor.h"
#include "cns/system.h"

CNS_BEGIN_DECLS

#define CNS_MODE_NAME 32

typedef struct cns_bisect_spec {
    int parameter;           /* of the model */
    cns_number lower, upper; /* lower < upper */
    bool by_manifold;        /* else by trajectory */
    long decimals;           /* >= 1 */
} cns_bisect_spec;

typedef struct cns_bisect_result {
    char *lower, *upper; /* parameters that were probed, as exact decimals: the change lies between them */
    char *critical; /* what both ends round to, to `decimals` decimals; NULL: not even their integers agree */
    char lower_mode[CNS_MODE_NAME], upper_mode[CNS_MODE_NAME];
    long decimals; /* of `critical`; fewer than asked for with CNS_UNREACHED; -1 without `critical` */
    long probes;   /* trajectories that decided, those read from the directory included */
} cns_bisect_result;

void cns_bisect_clear(cns_bisect_result *r); /* frees the texts */

/* directory: where probes are kept, so that a stopped bisection goes on where it was; NULL: nowhere.
 * CNS_UNREACHED when the ends of the bracket have the same mode (then `critical` is NULL and the modes
 * say which), or when fewer decimals than asked for could be proven; r holds the honest result. CNS_USAGE:
 * the model does not say what is needed. CNS_NUMERIC, CNS_IO, CNS_STOPPED: r holds the bracket so far, if
 * there is one. */
cns_code cns_bisect(const cns_system *s, const cns_bisect_spec *spec, const char *directory,
                    const cns_monitor *monitor, cns_bisect_result *r, cns_error *err);

CNS_END_DECLS

#endif
