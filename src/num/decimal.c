#include "cns/decimal.h"

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

char *cns_text_mpfr(mpfr_srcptr x, cns_places places, long count)
{
    char *made, *text;
    if (!mpfr_number_p(x))
        return cns_xcopy("nan");
    if (places == CNS_PLACES_SIGNIFICANT && mpfr_zero_p(x))
        return cns_xcopy("0");
    if (mpfr_asprintf(&made, places == CNS_PLACES_DECIMALS ? "%.*RNf" : "%.*RNe",
                      (int)(places == CNS_PLACES_DECIMALS ? count : count - 1), x) < 0)
        abort();
    text = cns_xcopy(made);
    mpfr_free_str(made);
    return without_minus_zero(text);
}

char *cns_text_mpq(mpq_srcptr x, cns_places places, long count)
{
    if (places == CNS_PLACES_SIGNIFICANT) { /* no ties matter here: enough bits to decide all others */
        mpfr_t y;
        mpfr_init2(y, 4 * count + 64 + (mpfr_prec_t)mpz_sizeinbase(mpq_denref(x), 2));
        mpfr_set_q(y, x, MPFR_RNDN);
        char *text = cns_text_mpfr(y, places, count);
        mpfr_clear(y);
        return text;
    }
    /* round(|x| 10^count) with ties to even, then the point. */
    mpz_t scaled, rest, twice;
    mpz_inits(scaled, rest, twice, (mpz_ptr)0);
    mpz_ui_pow_ui(scaled, 10, (unsigned long)count);
    mpz_mul(scaled, scaled, mpq_numref(x));
    mpz_abs(scaled, scaled);
    mpz_fdiv_qr(scaled, rest, scaled, mpq_denref(x));
    mpz_mul_2exp(twice, rest, 1);
    int half = mpz_cmp(twice, mpq_denref(x));
    if (half > 0 || (half == 0 && mpz_odd_p(scaled)))
        mpz_add_ui(scaled, scaled, 1);
    char *digits = mpz_get_str(NULL, 10, scaled);
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
    void (*release)(void *, size_t);
    mp_get_memory_functions(NULL, NULL, &release);
    release(digits, length + 1);
    mpz_clears(scaled, rest, twice, (mpz_ptr)0);
    return without_minus_zero(text);
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
