#include "fraction.h"

/* Continued fractions: p1/q1 is the last convergent of x whose denominator is small enough, p0/q0 the one
 * before it, and n/d what is still to be expanded. Whatever is nearest to x is p1/q1 or the last of the
 * fractions (p0 + k p1)/(q0 + k q1), on the other side of x, that are small enough. */
void cns_fraction_nearest(mpq_t y, mpq_srcptr x, mpz_srcptr most)
{
    mpz_t p0, q0, p1, q1, n, d, k;
    mpq_t other, near, far;
    if (mpz_cmp(mpq_denref(x), most) <= 0) {
        mpq_set(y, x);
        return;
    }
    mpz_inits(p0, q0, p1, q1, n, d, k, (mpz_ptr)0);
    mpq_inits(other, near, far, (mpq_ptr)0);
    mpz_set_ui(q0, 1);
    mpz_set_ui(p1, 1);
    mpz_set(n, mpq_numref(x));
    mpz_set(d, mpq_denref(x));
    for (;;) {
        mpz_fdiv_qr(k, n, n, d);
        mpz_addmul(q0, k, q1);
        if (mpz_cmp(q0, most) > 0)
            break;
        mpz_addmul(p0, k, p1);
        mpz_swap(p0, p1);
        mpz_swap(q0, q1);
        mpz_swap(n, d);
    }
    mpz_submul(q0, k, q1);
    mpz_sub(k, most, q0);
    mpz_fdiv_q(k, k, q1);
    mpz_addmul(p0, k, p1);
    mpz_addmul(q0, k, q1);
    mpz_set(mpq_numref(other), p0);
    mpz_set(mpq_denref(other), q0);
    mpq_sub(far, other, x);
    mpq_abs(far, far);
    mpz_swap(mpq_numref(y), p1);
    mpz_swap(mpq_denref(y), q1);
    mpq_sub(near, y, x);
    mpq_abs(near, near);
    const int order = mpq_cmp(far, near);
    if (order < 0 || (order == 0 && mpz_cmp(mpq_denref(other), mpq_denref(y)) < 0))
        mpq_set(y, other);
    mpz_clears(p0, q0, p1, q1, n, d, k, (mpz_ptr)0);
    mpq_clears(other, near, far, (mpq_ptr)0);
}

long cns_fraction_decimals(mpz_srcptr most)
{
    enum { OF_DOUBLES = 16 };
    long digits = (long)mpz_sizeinbase(most, 10); /* or one more */
    mpz_t power;
    mpz_init(power);
    mpz_ui_pow_ui(power, 10, (unsigned long)digits - 1);
    digits -= mpz_cmp(power, most) > 0;
    mpz_clear(power);
    return digits + (digits > OF_DOUBLES ? digits : OF_DOUBLES);
}
