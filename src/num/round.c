#include "round.h"

#include <gmp.h>
#include <math.h>
#include <stdlib.h>

#include "logs.h"

/* q = floor(m 2^e 10^shift), m > 0; *rest compares what is cut off with one half: -1, 0 or 1. */
static void scale(mpz_t q, int *rest, const mpz_t m, mpfr_exp_t e, long shift)
{
    mpz_t divisor, left;
    mpz_inits(divisor, left, (mpz_ptr)0);
    mpz_ui_pow_ui(left, 10, (unsigned long)labs(shift));
    mpz_set_ui(divisor, 1);
    if (shift >= 0) {
        mpz_mul(q, m, left);
    } else {
        mpz_set(q, m);
        mpz_swap(divisor, left);
    }
    if (e >= 0)
        mpz_mul_2exp(q, q, (mp_bitcnt_t)e);
    else
        mpz_mul_2exp(divisor, divisor, (mp_bitcnt_t)-e);
    mpz_fdiv_qr(q, left, q, divisor);
    mpz_mul_2exp(left, left, 1);
    *rest = mpz_cmp(left, divisor);
    mpz_clears(divisor, left, (mpz_ptr)0);
}

void cns_round_significant(mpfr_t x, long digits)
{
    if (!mpfr_regular_p(x))
        return;
    mpz_t m, q, least, power;
    int rest;
    mpz_inits(m, q, least, power, (mpz_ptr)0);
    const int negative = mpfr_signbit(x);
    mpfr_exp_t e = mpfr_get_z_2exp(m, x);
    mpz_abs(m, m);

    /* The exponent of the first digit, from that of the last bit: right, or off by one. */
    long first = (long)floor((double)(mpfr_get_exp(x) - 1) * CNS_LOG10_2);
    mpz_ui_pow_ui(least, 10, (unsigned long)digits - 1);
    for (;;) {
        scale(q, &rest, m, e, digits - 1 - first);
        if (mpz_cmp(q, least) < 0) {
            first--;
            continue;
        }
        mpz_mul_ui(power, least, 10);
        if (mpz_cmp(q, power) < 0)
            break;
        first++;
    }
    if (rest > 0 || (rest == 0 && mpz_odd_p(q)))
        mpz_add_ui(q, q, 1);

    const long shift = digits - 1 - first;
    mpfr_t decimal, ten;
    mpz_ui_pow_ui(power, 10, (unsigned long)labs(shift));
    mpfr_init2(decimal, (mpfr_prec_t)mpz_sizeinbase(q, 2) + 1);
    mpfr_init2(ten, (mpfr_prec_t)mpz_sizeinbase(power, 2) + 1);
    mpfr_set_z(decimal, q, MPFR_RNDN); /* both exact */
    mpfr_set_z(ten, power, MPFR_RNDN);
    if (shift >= 0)
        mpfr_div(x, decimal, ten, MPFR_RNDN);
    else
        mpfr_mul(x, decimal, ten, MPFR_RNDN);
    mpfr_setsign(x, x, negative, MPFR_RNDN);
    mpfr_clears(decimal, ten, (mpfr_ptr)0);
    mpz_clears(m, q, least, power, (mpz_ptr)0);
}
