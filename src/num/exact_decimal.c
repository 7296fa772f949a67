#include "exact_decimal.h"

#include <stdlib.h>
#include <string.h>

#include "core/memory.h"

void cns_exact_decimal_init(cns_exact_decimal *x)
{
    mpz_init(x->digits);
    x->exponent = 0;
}

void cns_exact_decimal_clear(cns_exact_decimal *x)
{
    mpz_clear(x->digits);
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* A sign and three digits: where the exponent leaves no room for its letter, Fortran prints none. */
static bool is_exponent_of_fortran(const char *at)
{
    return (*at == '+' || *at == '-') && is_digit(at[1]) && is_digit(at[2]) && is_digit(at[3]) &&
           at[4] == '\0';
}

const char *cns_exact_decimal_parse(cns_exact_decimal *x, const char *text)
{
    enum { SHORT = 64 };
    char small[SHORT], *digits = small;
    const char *at = text;
    const size_t length = strlen(text);
    size_t n = 0;
    long exponent = 0, after_point = 0;
    bool negative = false;
    if (*at == '+' || *at == '-')
        negative = *at++ == '-';
    if (length >= SHORT)
        digits = cns_xgrow(NULL, length + 1, 1);
    while (is_digit(*at))
        digits[n++] = *at++;
    const bool point = *at == '.';
    if (point)
        for (at++; is_digit(*at); after_point++)
            digits[n++] = *at++;
    digits[n] = '\0';
    if (n > 0)
        mpz_set_str(x->digits, digits, 10);
    if (digits != small)
        free(digits);
    if (n == 0)
        return "not a number";
    const bool letter = *at != '\0' && strchr("eEdDqQ", *at);
    if (letter || (point && is_exponent_of_fortran(at))) {
        at += letter;
        const bool down = *at == '-';
        if (*at == '+' || *at == '-')
            at++;
        if (!is_digit(*at))
            return "digits must follow the e of an exponent";
        while (is_digit(*at)) {
            exponent = 10 * exponent + (*at++ - '0');
            if (exponent > CNS_EXACT_DECIMAL_MAX_EXPONENT)
                return "the exponent is out of range";
        }
        if (down)
            exponent = -exponent;
    }
    if (*at != '\0')
        return "not a number";
    if (negative)
        mpz_neg(x->digits, x->digits);
    x->exponent = exponent - after_point;
    return NULL;
}

/* z *= 10^count */
static void shift(mpz_t z, long count)
{
    if (count == 0)
        return;
    mpz_t power;
    mpz_init(power);
    mpz_ui_pow_ui(power, 10, (unsigned long)count);
    mpz_mul(z, z, power);
    mpz_clear(power);
}

void cns_exact_decimal_get_mpq(mpq_t q, const cns_exact_decimal *x)
{
    mpz_set(mpq_numref(q), x->digits);
    mpz_set_ui(mpq_denref(q), 1);
    shift(x->exponent < 0 ? mpq_denref(q) : mpq_numref(q), labs(x->exponent));
    mpq_canonicalize(q);
}

long cns_exact_decimal_difference(mpz_t d, const cns_exact_decimal *a, const cns_exact_decimal *b)
{
    const bool finer = a->exponent < b->exponent;
    const cns_exact_decimal *coarse = finer ? b : a, *fine = finer ? a : b;
    mpz_set(d, coarse->digits);
    shift(d, coarse->exponent - fine->exponent);
    mpz_sub(d, d, fine->digits);
    if (finer)
        mpz_neg(d, d);
    return fine->exponent;
}

long cns_exact_decimal_agreed(const mpz_t d, long e)
{
    mpz_t twice, power;
    mpz_init(twice);
    mpz_init(power);
    mpz_mul_2exp(twice, d, 1);
    mpz_abs(twice, twice);
    /* The least L with 2 |d| <= 10^L: from the number of digits, which GMP tells or exceeds by one. */
    long count = (long)mpz_sizeinbase(twice, 10);
    for (; count > 0; count--) {
        mpz_ui_pow_ui(power, 10, (unsigned long)count - 1);
        if (mpz_cmp(twice, power) > 0)
            break;
    }
    mpz_clear(twice);
    mpz_clear(power);
    return -e - count;
}
