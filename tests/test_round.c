/* Rounding to significant decimals, against decimal strings. */
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "num/round.h"
#include "support.h"

/* x rounded to `digits` decimals by hand: the exact decimal expansion of x, cut and rounded as a string. The
 * result is "d.ddd", its exponent in *e. */
static char *rounded_by_string(const mpfr_t x, long digits, long *e)
{
    /* A binary number of p bits and exponent e has at most p + |e| significant decimals. */
    const size_t enough = (size_t)mpfr_get_prec(x) + (size_t)labs((long)mpfr_get_exp(x)) + 10;
    mpfr_exp_t point;
    char *all = mpfr_get_str(NULL, &point, 10, enough, x, MPFR_RNDN);
    char *s = all + (all[0] == '-'), *kept = malloc((size_t)digits + 2);
    ck_assert_ptr_nonnull(kept);
    kept[0] = '0';
    memcpy(kept + 1, s, (size_t)digits);
    kept[digits + 1] = '\0';
    const char *tail = s + digits;
    bool zeros = tail[1 + strspn(tail + 1, "0")] == '\0';
    bool up = tail[0] > '5' || (tail[0] == '5' && (!zeros || (kept[digits] - '0') % 2 == 1));
    for (long i = digits; up && i >= 0; i--) {
        up = kept[i] == '9';
        kept[i] = (char)(up ? '0' : kept[i] + 1);
    }
    *e = (long)point - digits;
    mpfr_free_str(all);
    return kept;
}

static void check_one(const mpfr_t x, long digits)
{
    mpfr_t got, want;
    long e;
    char text[2048];
    mpfr_init2(got, mpfr_get_prec(x));
    mpfr_init2(want, mpfr_get_prec(x));
    mpfr_set(got, x, MPFR_RNDN);
    cns_round_significant(got, digits);
    char *kept = rounded_by_string(x, digits, &e);
    snprintf(text, sizeof text, "%s%se%ld", mpfr_signbit(x) ? "-" : "", kept, e);
    mpfr_set_str(want, text, 10, MPFR_RNDN);
    if (!mpfr_equal_p(got, want)) {
        mpfr_snprintf(text, sizeof text, "%.80Rg to %ld digits: %.80Rg, not %.80Rg", x, digits, got, want);
        ck_abort_msg("%s", text);
    }
    mpfr_set(want, got, MPFR_RNDN); /* what is rounded stays */
    cns_round_significant(got, digits);
    ck_assert(mpfr_equal_p(got, want));
    free(kept);
    mpfr_clears(got, want, (mpfr_ptr)0);
}

START_TEST(random_numbers)
{
    uint64_t s = test_seed();
    gmp_randstate_t state;
    gmp_randinit_mt(state);
    gmp_randseed_ui(state, (unsigned long)test_random(&s));
    for (int i = 0; i < 4000; i++) {
        long digits = 1 + (long)test_random_below(&s, 60);
        mpfr_prec_t prec = (mpfr_prec_t)(3.33 * (double)digits) + 40 + (mpfr_prec_t)test_random_below(&s, 60);
        mpfr_t x;
        mpfr_init2(x, prec);
        mpfr_urandomb(x, state);
        mpfr_mul_2si(x, x, (long)test_random_below(&s, 400) - 200, MPFR_RNDN);
        if (test_random_below(&s, 2))
            mpfr_neg(x, x, MPFR_RNDN);
        if (!mpfr_zero_p(x))
            check_one(x, digits);
        mpfr_clear(x);
    }
    gmp_randclear(state);
}
END_TEST

/* Numbers of few bits: n / 2^k with n small has ties at every number of digits. */
START_TEST(exact_ties)
{
    mpfr_t x;
    mpfr_init2(x, 200);
    for (unsigned long n = 1; n < 700; n++)
        for (int k = 0; k < 6; k++)
            for (long digits = 1; digits < 8; digits++) {
                mpfr_set_ui_2exp(x, n, -k, MPFR_RNDN);
                check_one(x, digits);
            }
    mpfr_clear(x);
}
END_TEST

START_TEST(known)
{
    static const struct {
        const char *x;
        long digits;
        const char *rounded;
    } row[] = {{"2.5", 1, "2"},
               {"3.5", 1, "4"},
               {"-2.5", 1, "-2"},
               {"0.125", 2, "0.12"},
               {"0.375", 2, "0.38"},
               {"9.5", 1, "10"},
               {"99.5", 2, "100"},
               {"8.5", 1, "8"},
               {"1234567", 3, "1230000"},
               {"1235000", 3, "1240000"},
               {"1225000", 3, "1220000"},
               {"1024", 10, "1024"},
               {"1", 1, "1"},
               {"10", 1, "10"},
               {"1000", 2, "1000"},
               {"0.5", 1, "0.5"}};
    mpfr_t x, want;
    mpfr_inits2(160, x, want, (mpfr_ptr)0);
    for (int i = 0; i < COUNT(row); i++) {
        mpfr_set_str(x, row[i].x, 10, MPFR_RNDN);
        mpfr_set_str(want, row[i].rounded, 10, MPFR_RNDN);
        cns_round_significant(x, row[i].digits);
        ck_assert_msg(mpfr_equal_p(x, want), "%s to %ld digits is not %s", row[i].x, row[i].digits,
                      row[i].rounded);
    }
    mpfr_clears(x, want, (mpfr_ptr)0);
}
END_TEST

START_TEST(nothing_to_round)
{
    mpfr_t x;
    mpfr_init2(x, 100);
    mpfr_set_zero(x, -1);
    cns_round_significant(x, 3);
    ck_assert(mpfr_zero_p(x) && mpfr_signbit(x));
    mpfr_set_inf(x, 1);
    cns_round_significant(x, 3);
    ck_assert(mpfr_inf_p(x));
    mpfr_set_nan(x);
    cns_round_significant(x, 3);
    ck_assert(mpfr_nan_p(x));
    mpfr_clear(x);
}
END_TEST

Suite *suite_round(void)
{
    Suite *s = suite_create("round");
    TCase *t = tcase_create("round");
    tcase_add_test(t, random_numbers);
    tcase_add_test(t, exact_ties);
    tcase_add_test(t, known);
    tcase_add_test(t, nothing_to_round);
    suite_add_tcase(s, t);
    return s;
}
