/* Decimal texts as exact numbers, as tables of any program have them: digits times a power of ten. */
#ifndef CNS_NUM_PLAIN_H
#define CNS_NUM_PLAIN_H

#include <gmp.h>
#include <stdbool.h>

/* Decimal exponents up to this are read, so that aligning two numbers stays cheap. */
#define CNS_PLAIN_MAX_EXPONENT 20000

typedef struct cns_plain {
    mpz_t digits;
    long exponent; /* value = digits 10^exponent; the text gives -exponent decimals */
} cns_plain;

void cns_plain_init(cns_plain *x); /* 0 */
void cns_plain_clear(cns_plain *x);

/* [+-] digits [. digits] [(e|E|d|D) [+-] digits], also .5 and 5. ; nothing around it. NULL when x has the
 * value, else what is wrong, and x is undefined. */
const char *cns_plain_parse(cns_plain *x, const char *text);

/* d = (a - b) 10^-e, exactly, with e = min of the two exponents, which is returned. */
long cns_plain_difference(mpz_t d, const cns_plain *a, const cns_plain *b);

int cns_plain_cmp(const cns_plain *a, const cns_plain *b);

/* The largest p with |d| 10^e <= 10^-p / 2, d not 0: to so many decimals two numbers of this difference
 * agree.
 */
long cns_plain_decimals(const mpz_t d, long e);

#endif
