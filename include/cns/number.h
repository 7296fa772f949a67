/* Exact numbers: decimals, fractions, multiples and fractions of pi, kept exact and converted anew at
 * each precision in use, never through a double, so that two runs at different precisions solve the
 * same problem.
 *
 * Grammar: [+-] factor { ('*' | '/') factor }, factor = digits[.digits][(e|E)[+-]digits] | pi.
 * Spaces are allowed around operators and at the ends. An integer part has no leading zeros (010 is
 * octal elsewhere). pi may end up to the power 1, 0 or -1. The decimal exponents of a text add up, in
 * absolute value, to at most CNS_NUMBER_MAX_EXPONENT, and it has at most CNS_NUMBER_MAX_TEXT bytes. */
#ifndef CNS_NUMBER_H
#define CNS_NUMBER_H

#include <gmp.h>
#include <mpfr.h>
#include <stdbool.h>

#include "cns/status.h"

CNS_BEGIN_DECLS

#define CNS_NUMBER_MAX_EXPONENT 100000
#define CNS_NUMBER_MAX_TEXT     20000

typedef struct cns_number {
    char *text;  /* as given, without spaces at the ends; never NULL */
    mpq_t ratio; /* value = ratio * pi^pi_power */
    int pi_power;
} cns_number;

/* How many places a printed value has: a count of decimals, or of significant digits. */
typedef enum cns_places {
    CNS_PLACES_DECIMALS,   /* so many digits after the point: -0.0123; never -0.0000 */
    CNS_PLACES_SIGNIFICANT /* so many significant digits: -1.23e-02; zero is 0 */
} cns_places;

/* Every number is initialised before it is used and cleared afterwards. */
void cns_number_init(cns_number *x); /* x = 0 */
void cns_number_clear(cns_number *x);
void cns_number_set(cns_number *x, const cns_number *y); /* x = y, both initialised */

/* x = text. CNS_USAGE, with x unchanged, when the text is not a number of the grammar. */
cns_code cns_number_parse(cns_number *x, const char *text, cns_error *err);

/* y = x rounded to nearest at y's precision (correctly rounded, pi included). */
void cns_number_get_mpfr(mpfr_t y, const cns_number *x);

double cns_number_get_d(const cns_number *x); /* for messages, predictions and limits only; may be infinite */
int cns_number_sign(const cns_number *x);     /* -1, 0, 1 */
int cns_number_cmp(const cns_number *x, const cns_number *y); /* -1, 0, 1, exactly */

CNS_END_DECLS

#endif
