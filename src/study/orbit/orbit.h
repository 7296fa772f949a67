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

/* Newton's method from the guess u, with the first digits; sets the loop's image. Then the shortest time
 * after which the orbit is an image of itself, and that image. u becomes the solution. */
cns_code cns_orbit_settle(cns_loop *l, mpfr_t *u, cns_error *err);

/* From the first solution u (whose last number is the parameter, if one varies) to the orbit. */
cns_code cns_orbit_prove(const cns_loop *l, const mpfr_t *u, long decimals, cns_orbit **result,
                         cns_error *err);

/* Digits of Newton's method, raised from those of u to `digits`. u becomes no better. */
cns_code cns_orbit_raise(const cns_loop *l, long digits, const cns_chord *chord, const mpfr_t *u,
                         cns_corrected *c, cns_error *err);

#endif
