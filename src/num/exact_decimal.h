/* Decimal texts as exact numbers, as tables of any program have them: digits times a power of ten. */
#ifndef CNS_NUM_EXACT_DECIMAL_H
#define CNS_NUM_EXACT_DECIMAL_H

#include <gmp.h>
#include <stdbool.h>

/* Decimal exponents up to this are read, so that aligning two numbers stays cheap. */
#define CNS_EXACT_DECIMAL_MAX_EXPONENT 20000

typedef struct cns_exact_decimal {
    mpz_t digits;
    long exponent; /* value = digits 10^exponent; the text gives -exponent decimals */
} cns_exact_decimal;

void cns_exact_decimal_init(cns_exact_decimal *x); /* 0 */
void cns_exact_decimal_clear(cns_exact_decimal *x);

/* [+-] digits [. digits] [(e|E|d|D|q|Q) [+-] digits], also .5 and 5. ; nothing around it. Fortran leaves the
 * letter out before three digits: 1.5-104. NULL when x has the value, else what is wrong, and x is undefined.
 */
const char *cns_exact_decimal_parse(cns_exact_decimal *x, const char *text);

void cns_exact_decimal_get_mpq(mpq_t q, const cns_exact_decimal *x);

/* d = (a - b) 10^-e, exactly, with e = min of the two exponents, which is returned. */
long cns_exact_decimal_difference(mpz_t d, const cns_exact_decimal *a, const cns_exact_decimal *b);

/* The largest p with |d| 10^e <= 10^-p / 2, d not 0: to so many decimals two numbers of this difference
 * agree. */
long cns_exact_decimal_agreed(const mpz_t d, long e);

#endif
