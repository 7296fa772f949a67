#include "decimal_text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"

/* "-0.000" is "0.000". */
static char *without_minus_zero(char *text)
{
    if (text[0] == '-' && !text[1 + strspn(text + 1, "0.")])
        memmove(text, text + 1, strlen(text));
    return text;
}

static char *printed(const char *format, long count, mpfr_srcptr x)
{
    char *made;
    if (mpfr_asprintf(&made, format, (int)count, x) < 0)
        cns_memory_give_up(); /* more than INT_MAX characters: nothing else fails in it */
    char *text = cns_xcopy(made);
    mpfr_free_str(made);
    return text;
}

char *cns_text_mpfr(mpfr_srcptr x, cns_places places, long count)
{
    if (!mpfr_number_p(x))
        return cns_xcopy("nan");
    if (places == CNS_PLACES_SIGNIFICANT && mpfr_zero_p(x))
        return cns_xcopy("0");
    return without_minus_zero(places == CNS_PLACES_DECIMALS ? printed("%.*RNf", count, x)
                                                            : printed("%.*RNe", count - 1, x));
}

char *cns_text_digits(mpfr_srcptr x, long digits)
{
    return mpfr_zero_p(x) ? cns_xcopy("0") : printed("%.*Rg", digits, x);
}

/* round(|x| 10^shift) with ties to even. */
static void round_scaled(mpz_t rounded, mpq_srcptr x, long shift)
{
    mpz_t factor, divisor, rest;
    mpz_inits(factor, divisor, rest, (mpz_ptr)0);
    mpz_ui_pow_ui(factor, 10, (unsigned long)labs(shift));
    mpz_set(divisor, mpq_denref(x));
    mpz_abs(rounded, mpq_numref(x));
    if (shift >= 0)
        mpz_mul(rounded, rounded, factor);
    else
        mpz_mul(divisor, divisor, factor);
    mpz_fdiv_qr(rounded, rest, rounded, divisor);
    mpz_mul_2exp(rest, rest, 1);
    int half = mpz_cmp(rest, divisor);
    if (half > 0 || (half == 0 && mpz_odd_p(rounded)))
        mpz_add_ui(rounded, rounded, 1);
    mpz_clears(factor, divisor, rest, (mpz_ptr)0);
}

static char *decimal_digits(const mpz_t z)
{
    char *digits = cns_xgrow(NULL, mpz_sizeinbase(z, 10) + 2, 1);
    return mpz_get_str(digits, 10, z);
}

/* |x| < 10^e ? */
static bool below_power_of_ten(mpq_srcptr x, long e)
{
    mpz_t a, b;
    mpz_inits(a, b, (mpz_ptr)0);
    mpz_abs(a, mpq_numref(x));
    mpz_ui_pow_ui(b, 10, (unsigned long)labs(e));
    if (e >= 0) {
        mpz_mul(b, b, mpq_denref(x));
    } else {
        mpz_mul(a, a, b);
        mpz_set(b, mpq_denref(x));
    }
    bool below = mpz_cmp(a, b) < 0;
    mpz_clears(a, b, (mpz_ptr)0);
    return below;
}

static char *significant_mpq(mpq_srcptr x, long count)
{
    if (mpq_sgn(x) == 0)
        return cns_xcopy("0");
    /* The exponent of the first digit: the sizes of numerator and denominator tell it but for two units. */
    long e = (long)mpz_sizeinbase(mpq_numref(x), 10) - (long)mpz_sizeinbase(mpq_denref(x), 10) + 1;
    while (below_power_of_ten(x, e))
        e--;
    mpz_t z;
    mpz_init(z);
    round_scaled(z, x, count - 1 - e);
    char *digits = decimal_digits(z);
    e += (long)strlen(digits) - count; /* 9.99 became 10.0 */
    mpz_clear(z);
    char *text = cns_xgrow(NULL, (size_t)count + 32, 1), *at = text;
    if (mpq_sgn(x) < 0)
        *at++ = '-';
    *at++ = digits[0];
    if (count > 1)
        *at++ = '.';
    memcpy(at, digits + 1, (size_t)count - 1);
    snprintf(at + count - 1, 28, "e%c%02ld", e < 0 ? '-' : '+', labs(e));
    free(digits);
    return text;
}

char *cns_text_mpq(mpq_srcptr x, cns_places places, long count)
{
    if (places == CNS_PLACES_SIGNIFICANT)
        return significant_mpq(x, count);
    mpz_t scaled;
    mpz_init(scaled);
    round_scaled(scaled, x, count);
    char *digits = decimal_digits(scaled);
    size_t length = strlen(digits), fraction = (size_t)count;
    size_t pad = length <= fraction ? fraction + 1 - length : 0;
    char *text = cns_xgrow(NULL, length + pad + 3, 1), *at = text;
    if (mpq_sgn(x) < 0)
        *at++ = '-';
    for (size_t i = 0; i < length + pad; i++) {
        if (fraction && i == length + pad - fraction)
            *at++ = '.';
        *at++ = i < pad ? '0' : digits[i - pad];
    }
    *at = '\0';
    free(digits);
    mpz_clear(scaled);
    return without_minus_zero(text);
}

/* The decimals of a denominator 2^a 5^b: max(a, b). -1: it has another factor. */
static long decimals_of(mpz_srcptr denominator)
{
    mpz_t rest, five;
    mpz_init(rest);
    mpz_init_set_ui(five, 5);
    const mp_bitcnt_t twos = mpz_scan1(denominator, 0);
    mpz_tdiv_q_2exp(rest, denominator, twos);
    const mp_bitcnt_t fives = mpz_remove(rest, rest, five);
    const bool finite = mpz_cmp_ui(rest, 1) == 0;
    mpz_clear(rest);
    mpz_clear(five);
    return finite ? (long)(twos > fives ? twos : fives) : -1;
}

char *cns_text_exact(mpq_srcptr x)
{
    const long decimals = decimals_of(mpq_denref(x));
    return decimals >= 0 ? cns_text_mpq(x, CNS_PLACES_DECIMALS, decimals) : NULL;
}

char *cns_text_number(const cns_number *x, cns_places places, long count)
{
    if (x->pi_power == 0)
        return cns_text_mpq(x->ratio, places, count);
    mpfr_t y; /* irrational: no ties, and bits to spare */
    mpfr_init2(y, 4 * count + 256 + (mpfr_prec_t)mpz_sizeinbase(mpq_numref(x->ratio), 2));
    cns_number_get_mpfr(y, x);
    char *text = cns_text_mpfr(y, places, count);
    mpfr_clear(y);
    return text;
}

bool cns_text_certain(mpfr_srcptr x, mpfr_srcptr e, cns_places places, long count)
{
    mpfr_t low, high;
    mpfr_prec_t prec = mpfr_get_prec(x) + 64;
    if (!mpfr_number_p(x) || !mpfr_number_p(e))
        return false;
    mpfr_inits2(prec, low, high, (mpfr_ptr)0);
    mpfr_sub(low, x, e, MPFR_RNDD);
    mpfr_add(high, x, e, MPFR_RNDU);
    char *a = cns_text_mpfr(low, places, count), *b = cns_text_mpfr(high, places, count);
    bool certain = !strcmp(a, b);
    free(a);
    free(b);
    mpfr_clears(low, high, (mpfr_ptr)0);
    return certain;
}
