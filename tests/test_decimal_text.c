/* Decimal texts: rounding, signs, ties, and the question whether a text is certain, against long division. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "num/decimal_text.h"
#include "support.h"

/* The oracle: schoolbook long division on GMP integers, and rounding on the text. */

/* Adds one in the last digit of a text of digits and at most one point; digit[0] is a spare '0'. */
static void increment(char *digit)
{
    size_t i = strlen(digit);
    for (;;) {
        i--;
        if (digit[i] == '.')
            continue;
        if (digit[i] != '9') {
            digit[i]++;
            return;
        }
        digit[i] = '0';
    }
}

/* |q| rounded to `count` decimals, half to even, no sign; "0" stands before the digits as room for a carry.
 * The caller frees. */
static char *rounded_digits(const mpq_t q, long count)
{
    mpz_t whole, rest, digit;
    mpz_inits(whole, rest, digit, (mpz_ptr)0);
    mpz_abs(rest, mpq_numref(q));
    mpz_fdiv_qr(whole, rest, rest, mpq_denref(q));
    char *text = malloc(mpz_sizeinbase(whole, 10) + (size_t)count + 4), *at = text;
    ck_assert_ptr_nonnull(text);
    *at++ = '0';
    mpz_get_str(at, 10, whole);
    at += strlen(at);
    if (count > 0)
        *at++ = '.';
    for (long i = 0; i < count; i++) {
        mpz_mul_ui(rest, rest, 10);
        mpz_fdiv_qr(digit, rest, rest, mpq_denref(q));
        *at++ = (char)('0' + (int)mpz_get_ui(digit));
    }
    *at = '\0';
    mpz_mul_2exp(rest, rest, 1);
    int half = mpz_cmp(rest, mpq_denref(q));
    bool odd = (at[-1] - '0') % 2 != 0;
    if (half > 0 || (half == 0 && odd))
        increment(text);
    mpz_clears(whole, rest, digit, (mpz_ptr)0);
    return text;
}

static char *oracle_decimals(const mpq_t q, long count)
{
    char *digits = rounded_digits(q, count), *text = malloc(strlen(digits) + 2);
    ck_assert_ptr_nonnull(text);
    const char *from = digits;
    while (from[0] == '0' && from[1] >= '0' && from[1] <= '9')
        from++;
    bool negative = mpq_sgn(q) < 0 && strspn(from, "0.") != strlen(from);
    sprintf(text, "%s%s", negative ? "-" : "", from);
    free(digits);
    return text;
}

/* m.mmme+xx: scaled by powers of ten until one digit stands before the point. */
static char *oracle_significant(const mpq_t q, long count)
{
    long e = 0;
    mpq_t x, ten;
    char *text = malloc((size_t)count + 40);
    ck_assert_ptr_nonnull(text);
    if (mpq_sgn(q) == 0) {
        strcpy(text, "0");
        return text;
    }
    mpq_inits(x, ten, (mpq_ptr)0);
    mpq_set_ui(ten, 10, 1);
    mpq_abs(x, q);
    while (mpq_cmp(x, ten) >= 0) {
        mpq_div(x, x, ten);
        e++;
    }
    while (mpq_cmp_ui(x, 1, 1) < 0) {
        mpq_mul(x, x, ten);
        e--;
    }
    char *digits = oracle_decimals(x, count - 1);
    if (!strncmp(digits, "10", 2)) { /* 9.99 became 10.0 */
        free(digits);
        mpq_set_ui(x, 1, 1);
        digits = oracle_decimals(x, count - 1);
        e++;
    }
    sprintf(text, "%s%se%c%02ld", mpq_sgn(q) < 0 ? "-" : "", digits, e < 0 ? '-' : '+', labs(e));
    free(digits);
    mpq_clears(x, ten, (mpq_ptr)0);
    return text;
}

static char *oracle(const mpq_t q, cns_places places, long count)
{
    return places == CNS_PLACES_DECIMALS ? oracle_decimals(q, count) : oracle_significant(q, count);
}

static const char *places_name(cns_places places)
{
    return places == CNS_PLACES_DECIMALS ? "decimals" : "significant digits";
}

/* The library's text of q, by every route that holds q exactly, against the oracle's. */
static void check_exact(const mpq_t q, cns_places places, long count)
{
    char *want = oracle(q, places, count), *got = cns_text_mpq(q, places, count);
    if (strcmp(want, got) != 0) {
        gmp_printf("%Qd\n", q);
        ck_abort_msg("%ld %s of a ratio: %s, not %s", count, places_name(places), got, want);
    }
    free(want);
    free(got);
}

static void check_mpfr(const mpfr_t x, cns_places places, long count)
{
    mpq_t q;
    mpq_init(q);
    mpfr_get_q(q, x);
    char *want = oracle(q, places, count), *got = cns_text_mpfr(x, places, count);
    if (strcmp(want, got) != 0) {
        mpfr_printf("%Ra\n", x);
        ck_abort_msg("%ld %s of a number: %s, not %s", count, places_name(places), got, want);
    }
    free(want);
    free(got);
    check_exact(q, places, count);
    mpq_clear(q);
}

static void check_number(const char *text, cns_places places, long count, const char *want)
{
    cns_number x;
    cns_error err;
    cns_number_init(&x);
    if (cns_number_parse(&x, text, &err))
        ck_abort_msg("%s", err.text);
    char *got = cns_text_number(&x, places, count);
    ck_assert_msg(!strcmp(got, want), "%s to %ld %s: %s, not %s", text, count, places_name(places), got,
                  want);
    free(got);
    cns_number_clear(&x);
}

#define decimals(text, count, want)    check_number(text, CNS_PLACES_DECIMALS, count, want)
#define significant(text, count, want) check_number(text, CNS_PLACES_SIGNIFICANT, count, want)

START_TEST(ties_go_to_even)
{
    decimals("0.5", 0, "0");
    decimals("1.5", 0, "2");
    decimals("2.5", 0, "2");
    decimals("-2.5", 0, "-2");
    decimals("-3.5", 0, "-4");
    decimals("0.015", 2, "0.02");
    decimals("0.025", 2, "0.02");
    decimals("0.035", 2, "0.04");
    decimals("-0.025", 2, "-0.02");
    decimals("0.0250000000000000000000000000000000000001", 2, "0.03");
    decimals("0.0249999999999999999999999999999999999999", 2, "0.02");
    decimals("9.995", 2, "10.00");
    decimals("999.5", 0, "1000");
    significant("0.15", 1, "2e-01");
    significant("0.25", 1, "2e-01");
    significant("0.35", 1, "4e-01");
    significant("-0.45", 1, "-4e-01");
    significant("9.95", 2, "1.0e+01");
    significant("1e-300*35", 1, "4e-299");
    significant("1e300*45", 1, "4e+301");
}
END_TEST

START_TEST(zero_has_no_sign)
{
    mpfr_t x;
    decimals("0", 0, "0");
    decimals("0", 3, "0.000");
    decimals("-0.0004", 3, "0.000");
    decimals("-0.0005", 3, "0.000");
    decimals("-0.00051", 3, "-0.001");
    decimals("-0.4", 0, "0");
    decimals("-pi/10000", 3, "0.000");
    significant("0", 1, "0");
    significant("0", 9, "0");
    mpfr_init2(x, 90);
    for (int i = 0; i < 2; i++) {
        char *text;
        mpfr_set_zero(x, -1);
        if (i)
            mpfr_set_d(x, -1e-9, MPFR_RNDN);
        text = cns_text_mpfr(x, CNS_PLACES_DECIMALS, 4);
        ck_assert_str_eq(text, "0.0000");
        free(text);
    }
    mpfr_set_zero(x, -1);
    char *text = cns_text_mpfr(x, CNS_PLACES_SIGNIFICANT, 4);
    ck_assert_str_eq(text, "0");
    free(text);
    mpfr_clear(x);
}
END_TEST

START_TEST(multiples_of_pi)
{
    decimals("pi", 20, "3.14159265358979323846");
    decimals("pi", 0, "3");
    decimals("-pi/2", 5, "-1.57080");
    decimals("2*pi/3", 30, "2.094395102393195492308428922186");
    significant("pi", 7, "3.141593e+00");
    significant("1e40*pi", 3, "3.14e+40");
    significant("1/pi", 12, "3.18309886184e-01");
    decimals("1e40*pi", 2, "31415926535897932384626433832795028841971.69");
}
END_TEST

static void random_mpz(mpz_t z, uint64_t *s, int bits)
{
    mpz_set_ui(z, 0);
    for (int done = 0; done < bits; done += 32) {
        mpz_mul_2exp(z, z, 32);
        mpz_add_ui(z, z, (unsigned long)(test_random(s) >> 32));
    }
    mpz_fdiv_r_2exp(z, z, (mp_bitcnt_t)bits);
}

static cns_places random_places(uint64_t *s, long *count)
{
    cns_places places = test_random_below(s, 2) ? CNS_PLACES_DECIMALS : CNS_PLACES_SIGNIFICANT;
    *count = (long)test_random_below(s, 60) + (places == CNS_PLACES_SIGNIFICANT);
    return places;
}

START_TEST(random_numbers)
{
    uint64_t s = test_seed();
    mpz_t z;
    mpz_init(z);
    for (int i = 0; i < 4000; i++) {
        mpfr_t x;
        long count;
        cns_places places = random_places(&s, &count);
        int bits = 2 + (int)test_random_below(&s, 300);
        mpfr_init2(x, bits);
        random_mpz(z, &s, bits);
        mpfr_set_z(x, z, MPFR_RNDN);
        mpfr_mul_2si(x, x, (long)test_random_below(&s, 250) - 200 - bits / 2, MPFR_RNDN);
        if (test_random_below(&s, 2))
            mpfr_neg(x, x, MPFR_RNDN);
        check_mpfr(x, places, count);
        mpfr_clear(x);
    }
    mpz_clear(z);
}
END_TEST

/* Ratios within a hair of a tie, or on it: (2k + 1)/(2 10^c), plus or minus 10^-far. */
START_TEST(random_ties)
{
    uint64_t s = test_seed() + 1;
    mpq_t q, hair;
    mpz_t z;
    mpq_inits(q, hair, (mpq_ptr)0);
    mpz_init(z);
    for (int i = 0; i < 4000; i++) {
        long count = (long)test_random_below(&s, 50), more = 1 + (long)test_random_below(&s, 100);
        int bits = 1 + (int)test_random_below(&s, 130);
        random_mpz(mpq_numref(q), &s, bits);
        mpz_mul_2exp(mpq_numref(q), mpq_numref(q), 1);
        mpz_add_ui(mpq_numref(q), mpq_numref(q), 1);
        mpz_ui_pow_ui(z, 10, (unsigned long)count);
        mpz_mul_2exp(mpq_denref(q), z, 1);
        /* As significant digits: as many as k has. */
        mpz_fdiv_q_2exp(z, mpq_numref(q), 1);
        char *k = mpz_get_str(NULL, 10, z);
        long digits = mpz_sgn(z) ? (long)strlen(k) : 0;
        void (*release)(void *, size_t);
        mp_get_memory_functions(NULL, NULL, &release);
        release(k, strlen(k) + 1);
        mpq_canonicalize(q);
        int which = (int)test_random_below(&s, 3) - 1;
        if (which) {
            mpz_set_si(mpq_numref(hair), which);
            mpz_ui_pow_ui(mpq_denref(hair), 10, (unsigned long)(count + more));
            mpq_add(q, q, hair);
        }
        if (test_random_below(&s, 2))
            mpq_neg(q, q);
        check_exact(q, CNS_PLACES_DECIMALS, count);
        if (digits > 0)
            check_exact(q, CNS_PLACES_SIGNIFICANT, digits);
    }
    mpz_clear(z);
    mpq_clears(q, hair, (mpq_ptr)0);
}
END_TEST

static bool certain(const char *x, const char *e, cns_places places, long count)
{
    mpfr_t a, b;
    mpfr_inits2(200, a, b, (mpfr_ptr)0);
    mpfr_set_str(a, x, 10, MPFR_RNDN);
    mpfr_set_str(b, e, 10, MPFR_RNDN);
    bool yes = cns_text_certain(a, b, places, count);
    mpfr_clears(a, b, (mpfr_ptr)0);
    return yes;
}

START_TEST(certainty_at_straddles)
{
    const cns_places d = CNS_PLACES_DECIMALS, g = CNS_PLACES_SIGNIFICANT;
    ck_assert(certain("1.2345", "1e-9", d, 2));
    ck_assert(!certain("1.2345", "1e-9", d, 3));
    ck_assert(!certain("0.12345", "1e-6", d, 4));
    ck_assert(certain("0.12345", "1e-6", d, 3));
    ck_assert(certain("0.123451", "9e-7", d, 4));
    ck_assert(!certain("0.123451", "1.1e-6", d, 4));
    /* An error that reaches across zero. */
    ck_assert(certain("0.0001", "0.001", d, 2));
    ck_assert(certain("-0.0001", "0.001", d, 2));
    ck_assert(!certain("0.0001", "0.001", d, 3));
    ck_assert(!certain("0.0001", "0.001", g, 1));
    ck_assert(certain("0", "0", g, 5));
    ck_assert(!certain("0", "1e-50", g, 5));
    ck_assert(certain("0", "1e-50", d, 49));
    ck_assert(!certain("0", "1e-50", d, 50));
    /* A power of ten: the exponent changes, the text is the same or not. */
    ck_assert(certain("9.99999", "1e-6", g, 3));
    ck_assert(!certain("9.995", "1e-3", g, 3));
    ck_assert(certain("10", "1e-3", g, 3));
    ck_assert(!certain("10", "1e-3", g, 5));
    /* Larger than anything, and no numbers. */
    ck_assert(!certain("1", "1e300", d, 0));
    ck_assert(!certain("nan", "0", d, 0));
    ck_assert(!certain("1", "nan", d, 0));
    ck_assert(!certain("inf", "0", d, 0));
    ck_assert(!certain("1", "inf", d, 0));
}
END_TEST

START_TEST(an_exact_tie_is_certain)
{
    mpfr_t x, e;
    mpfr_inits2(100, x, e, (mpfr_ptr)0);
    mpfr_set_d(x, 0.125, MPFR_RNDN);
    mpfr_set_zero(e, 1);
    ck_assert(cns_text_certain(x, e, CNS_PLACES_DECIMALS, 2));
    mpfr_set_d(e, 0x1p-150, MPFR_RNDN); /* below the last bit of x, and yet an error */
    ck_assert(!cns_text_certain(x, e, CNS_PLACES_DECIMALS, 2));
    mpfr_set_d(e, 0x1p-900, MPFR_RNDN);
    ck_assert(!cns_text_certain(x, e, CNS_PLACES_DECIMALS, 2));
    mpfr_clears(x, e, (mpfr_ptr)0);
}
END_TEST

/* certain: x - e and x + e have one text, and so has a number between; never certain when they differ. */
START_TEST(random_certainty)
{
    uint64_t s = test_seed() + 2;
    mpq_t low, high, mid;
    mpz_t z;
    long yes = 0, no = 0, shy = 0;
    mpq_inits(low, high, mid, (mpq_ptr)0);
    mpz_init(z);
    for (int i = 0; i < 4000; i++) {
        mpfr_t x, e;
        long count = 1 + (long)test_random_below(&s, 40);
        cns_places places = test_random_below(&s, 2) ? CNS_PLACES_DECIMALS : CNS_PLACES_SIGNIFICANT;
        mpfr_inits2(40 + (mpfr_prec_t)test_random_below(&s, 200), x, e, (mpfr_ptr)0);
        /* Near a tie of `count` decimals: (k + 1/2) 10^-count, of either sign, or near 0. */
        random_mpz(z, &s, 1 + (int)test_random_below(&s, 60));
        mpfr_set_z(x, z, MPFR_RNDN);
        mpfr_add_d(x, x, test_random_below(&s, 2) ? 0.5 : test_random_unit(&s), MPFR_RNDN);
        mpfr_set_ui(e, 10, MPFR_RNDN);
        mpfr_pow_si(e, e, -count, MPFR_RNDN);
        mpfr_mul(x, x, e, MPFR_RNDN);
        if (test_random_below(&s, 2))
            mpfr_neg(x, x, MPFR_RNDN);
        mpfr_mul_d(e, e, test_random_unit(&s), MPFR_RNDN);
        mpfr_mul_2si(e, e, -(long)test_random_below(&s, 300), MPFR_RNDN);
        bool certainly = cns_text_certain(x, e, places, count);
        mpfr_get_q(mid, x);
        mpfr_get_q(high, e);
        mpq_sub(low, mid, high);
        mpq_add(high, mid, high);
        char *a = oracle(low, places, count), *b = oracle(high, places, count),
             *m = oracle(mid, places, count);
        bool same = !strcmp(a, b);
        if (certainly && (!same || strcmp(a, m) != 0)) {
            mpfr_printf("x = %Ra, e = %Ra\n", x, e);
            ck_abort_msg("%ld %s said to be certain of %s and %s", count, places_name(places), a, b);
        }
        yes += certainly;
        no += !same;
        shy += same && !certainly && 10 * count < 3 * (long)mpfr_get_prec(x); /* more is not in x */
        free(a);
        free(b);
        free(m);
        mpfr_clears(x, e, (mpfr_ptr)0);
    }
    ck_assert_msg(yes > 500 && no > 200, "%ld certain, %ld straddles: nothing was tested", yes, no);
    ck_assert_msg(shy <= 20, "%ld of 4000 certain texts were refused", shy);
    mpz_clear(z);
    mpq_clears(low, high, mid, (mpq_ptr)0);
}
END_TEST

static const struct {
    const char *x, *text; /* NULL: x is no finite decimal */
} exact[] = {{"25/2", "12.5"},    {"0", "0"},           {"300", "300"},
             {"1/1000", "0.001"}, {"3/8", "0.375"},     {"-1/20", "-0.05"},
             {"-5", "-5"},        {"1/3", NULL},        {"100/3", NULL},
             {"1/30", NULL},      {"-7/250", "-0.028"}, {"1000000000000000000001", "1000000000000000000001"}};

START_TEST(finite_decimals_are_exact)
{
    mpq_t x;
    mpq_init(x);
    ck_assert_int_eq(mpq_set_str(x, exact[_i].x, 10), 0);
    char *text = cns_text_exact(x);
    if (exact[_i].text == NULL)
        ck_assert_ptr_null(text);
    else
        ck_assert_str_eq(text, exact[_i].text);
    free(text);
    mpq_clear(x);
}
END_TEST

/* k 2^a 5^b, back from its text. */
START_TEST(random_finite_decimals)
{
    uint64_t s = test_seed();
    cns_number y;
    mpq_t x;
    mpq_init(x);
    cns_number_init(&y);
    for (int round = 0; round < 2000; round++) {
        mpz_set_si(mpq_numref(x), (long)(test_random(&s) >> test_random_below(&s, 64)));
        mpz_ui_pow_ui(mpq_denref(x), 5, test_random_below(&s, 40));
        mpz_mul_2exp(mpq_denref(x), mpq_denref(x), test_random_below(&s, 40));
        mpq_canonicalize(x);
        char *text = cns_text_exact(x);
        ck_assert_ptr_nonnull(text);
        ck_assert(strpbrk(text, "eE") == NULL);
        ck_assert_int_eq(cns_number_parse(&y, text, NULL), CNS_OK);
        ck_assert_msg(mpq_equal(x, y.ratio), "%s", text);
        free(text);
    }
    cns_number_clear(&y);
    mpq_clear(x);
}
END_TEST

Suite *suite_decimal_text(void)
{
    Suite *suite = suite_create("decimal_text");
    TCase *tc = tcase_create("texts");
    tcase_add_test(tc, ties_go_to_even);
    tcase_add_test(tc, zero_has_no_sign);
    tcase_add_test(tc, multiples_of_pi);
    add_table_test(tc, finite_decimals_are_exact, exact);
    tcase_add_test(tc, random_finite_decimals);
    tcase_add_test(tc, random_numbers);
    tcase_add_test(tc, random_ties);
    suite_add_tcase(suite, tc);
    tc = tcase_create("certain");
    tcase_add_test(tc, certainty_at_straddles);
    tcase_add_test(tc, an_exact_tie_is_certain);
    tcase_add_test(tc, random_certainty);
    suite_add_tcase(suite, tc);
    return suite;
}
