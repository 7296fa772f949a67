/* An orbit on its way from a guess to proven decimals. Private to src/study. */
#ifndef CNS_STUDY_ORBIT_ORBIT_H
#define CNS_STUDY_ORBIT_ORBIT_H

#include "cns/study/orbit.h"
#include "corrector.h"

enum { CNS_ORBIT_FIRST_DIGITS = 30 }; /* of the first solution, near which nothing is hidden */

/* The guess, by the spec: sets the loop's section and u, d + 2 numbers of the first digits' precision: a
 * state and the time after which it is an image of itself, or nearly. CNS_NUMERIC: the late motion has none.
 */
cns_code cns_orbit_guess(cns_loop *l, const cns_orbit_spec *spec, mpfr_t *u, const cns_monitor *monitor,
                         cns_error *err);

/* If the orbit u crosses its section poorly, it shall begin where it crosses one best, which is held: u is
 * then a guess. */
cns_code cns_orbit_turn(cns_loop *l, mpfr_t *u, bool *turned, cns_error *err);

/* Newton's method from the guess u, with the first digits; sets the loop's image. Then the shortest time
 * after which the orbit is an image of itself, and that image. u becomes the solution. */
cns_code cns_orbit_settle(cns_loop *l, mpfr_t *u, cns_error *err);

/* Is the orbit an image of itself after a part of its time, a `most`-th of it or more? Then the shortest such
 * part, and that image, are the loop's. */
cns_code cns_orbit_shorten(cns_loop *l, mpfr_t *u, int most, bool *found, cns_error *err);

/* What an orbit is that is to be proven: a solution with so many digits. near: a coarser one, or NULL. */
typedef struct cns_orbit_solver {
    cns_code (*solve)(void *context, const cns_loop *l, long digits, bool fine, const mpfr_t *near,
                      cns_corrected *c, cns_error *err);
    void *context;
} cns_orbit_solver;

/* The orbit at the loop's own parameters; context: the first solution. */
cns_code cns_orbit_at(void *context, const cns_loop *l, long digits, bool fine, const mpfr_t *near,
                      cns_corrected *c, cns_error *err);

/* Two solutions, and what they say of the orbit, with the parameter if one varies. */
cns_code cns_orbit_prove(const cns_loop *l, const cns_orbit_solver *solver, long decimals, cns_orbit **result,
                         cns_error *err);

/* The orbit near u at the loop's own parameters with so many digits: these are raised by and by, as Newton's
 * method doubles those that are right. */
cns_code cns_orbit_raise(const cns_loop *l, long digits, const mpfr_t *u, cns_corrected *c, cns_error *err);

#endif
