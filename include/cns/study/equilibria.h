/* Fixed points of a model's reduced dynamics, with eigenvalues and stability, to as many decimals as asked
 * for.
 *
 * Every decimal is proven, in ball arithmetic: existence and place by Krawczyk's operator, eigenvalues of the
 * enclosed Jacobian by enclosures of all of them (S. M. Rump, Acta Numerica 19 (2010) 287, section 13).
 * Reduced: the dynamic states alone; what nothing feeds back on, such as the place of a falling disk, drifts.
 */
#ifndef CNS_STUDY_EQUILIBRIA_H
#define CNS_STUDY_EQUILIBRIA_H

#include "cns/monitor.h"
#include "cns/system.h"

CNS_BEGIN_DECLS

typedef struct cns_eigenvalue {
    char *re, *im; /* correctly rounded; im is "0" where the eigenvalue is real */
} cns_eigenvalue;

typedef struct cns_equilibrium {
    char *name;                  /* the model's */
    char **state;                /* per dynamic state, correctly rounded */
    cns_eigenvalue *eigenvalues; /* as many; real parts fall; of a pair, the positive imaginary part first */
    int stable, unstable;        /* eigenvalues with certainly negative and certainly positive real parts */
    const char *stability; /* stable node, stable focus, unstable ..., saddle, saddle-focus, not hyperbolic */
} cns_equilibrium;

typedef struct cns_equilibria {
    int d;      /* dynamic states */
    int *index; /* which of the model's states they are */
    int n;
    cns_equilibrium *item;
    long decimals; /* of all texts; fewer than asked for with CNS_UNREACHED */
} cns_equilibria;

#define CNS_EQUILIBRIA_MAX_DECIMALS 10000

/* decimals: 1..CNS_EQUILIBRIA_MAX_DECIMALS digits after the point. CNS_USAGE: the model knows no fixed
 * points. CNS_UNREACHED: some points could not be proven (err names them), or not to so many decimals;
 * *result holds what could. *result is NULL with any other failure. */
cns_code cns_equilibria_find(const cns_system *s, long decimals, const cns_monitor *monitor,
                             cns_equilibria **result, cns_error *err);
void cns_equilibria_free(cns_equilibria *e);

/* The names of those that certainly attract, as "C+, C-", a new text; NULL: none does, as far as the model
 * knows its fixed points. */
char *cns_equilibria_attractors(const cns_system *s, const cns_monitor *monitor);

CNS_END_DECLS

#endif
