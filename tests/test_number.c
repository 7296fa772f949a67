/* Numbers: text to exact value, value to MPFR. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cns/number.h"
#include "support.h"

/* x of the text; the test fails where the library refuses it. */
static void parse(cns_number *x, const char *text)
{
    cns_error err;
    if (cns_number_parse(x, text, &err) != CNS_OK)
        ck_abort_msg("'%s' refused: %s", text, err.text);
}

static void check_ratio(const char *text, const char *ratio, int pi_power)
{
    cns_number x;
    mpq_t q;
    cns_number_init(&x);
    mpq_init(q);
    ck_assert_int_eq(mpq_set_str(q, ratio, 10), 0);
    parse(&x, text);
    ck_assert_msg(mpq_equal(x.ratio, q), "the ratio of '%s' is not %s", text, ratio);
    ck_assert_int_eq(x.pi_power, pi_power);
    mpq_clear(q);
    cns_number_clear(&x);
}

START_TEST(reads_the_grammar)
{
    check_ratio("0", "0", 0);
    check_ratio("2.2", "11/5", 0);
    check_ratio("-0.01", "-1/100", 0);
    check_ratio("+1", "1", 0);
    check_ratio("1e-3", "1/1000", 0);
    check_ratio("1.5E+2", "150", 0);
    check_ratio("8/3", "8/3", 0);
    check_ratio("1/2/3", "1/6", 0);
    check_ratio("6/4*2", "3", 0);
    check_ratio("pi", "1", 1);
    check_ratio("-pi/2", "-1/2", 1);
    check_ratio("2*pi/3", "2/3", 1);
    check_ratio(" 2 * pi / 3 ", "2/3", 1);
    check_ratio("1/pi", "1", -1);
    check_ratio("pi/pi", "1", 0);
    check_ratio("pi*pi/pi", "1", 1);
    check_ratio("0*pi", "0", 0);
    check_ratio("0/5", "0", 0);
    check_ratio("1e2/1e-2", "10000", 0);
}
END_TEST

START_TEST(keeps_the_text)
{
    cns_number x, y;
    cns_number_init(&x);
    cns_number_init(&y);
    ck_assert_str_eq(x.text, "0");
    parse(&x, "  2*pi/3 ");
    ck_assert_str_eq(x.text, "2*pi/3");
    cns_number_set(&y, &x);
    cns_number_set(&y, &y);
    ck_assert_str_eq(y.text, "2*pi/3");
    ck_assert_int_eq(cns_number_cmp(&x, &y), 0);
    parse(&x, x.text); /* its own text */
    ck_assert_str_eq(x.text, "2*pi/3");
    cns_number_clear(&x);
    cns_number_clear(&y);
}
END_TEST

static const char *const refused[] = {"",
                                      " ",
                                      "-",
                                      "+",
                                      "--1",
                                      "+-1",
                                      "1+1",
                                      "1 2",
                                      ".5",
                                      "5.",
                                      "1e",
                                      "1e+",
                                      "e5",
                                      "nan",
                                      "NaN",
                                      "inf",
                                      "-inf",
                                      ".inf",
                                      "0x10",
                                      "0b1",
                                      "0o7",
                                      "010",
                                      "-00.5",
                                      "1_000",
                                      "1,5",
                                      "1/0",
                                      "1/0.0",
                                      "1e5.5",
                                      "pi2",
                                      "2pi",
                                      "pipi",
                                      "pi*pi",
                                      "1/pi/pi",
                                      "*2",
                                      "2*",
                                      "2**3",
                                      "2//3",
                                      "2*-3",
                                      "1e100001",
                                      "(1)",
                                      "1e-100001",
                                      "\xff",
                                      "1\n",
                                      "true",
                                      "1e999999999",
                                      "1e50000*1e50001",
                                      "1e99999999999999999999999",
                                      "1e-99999999999999999999999"};

START_TEST(refuses_what_is_no_number)
{
    cns_number x;
    cns_error err;
    cns_number_init(&x);
    parse(&x, "7/3");
    for (int i = 0; i < COUNT(refused); i++) {
        err.text[0] = '\0';
        ck_assert_msg(cns_number_parse(&x, refused[i], &err) == CNS_USAGE, "'%s' was read", refused[i]);
        ck_assert_msg(err.text[0] != '\0', "'%s' has no message", refused[i]);
        ck_assert(cns_number_parse(&x, refused[i], NULL) == CNS_USAGE);
        ck_assert_str_eq(x.text, "7/3");
        ck_assert(mpq_cmp_si(x.ratio, 7, 3) == 0);
    }
    cns_number_clear(&x);
}
END_TEST

START_TEST(keeps_within_limits)
{
    cns_number x;
    char *text = malloc(CNS_NUMBER_MAX_TEXT + 2);
    cns_number_init(&x);
    parse(&x, "1e100000");
    ck_assert_uint_ge(mpz_sizeinbase(mpq_numref(x.ratio), 10), 100001);
    parse(&x, "1e-100000");
    ck_assert_uint_ge(mpz_sizeinbase(mpq_denref(x.ratio), 10), 100001);
    memset(text, '7', CNS_NUMBER_MAX_TEXT + 1);
    text[CNS_NUMBER_MAX_TEXT + 1] = '\0';
    ck_assert_int_eq(cns_number_parse(&x, text, NULL), CNS_USAGE);
    text[CNS_NUMBER_MAX_TEXT] = '\0';
    parse(&x, text);
    char *digits = mpz_get_str(NULL, 10, mpq_numref(x.ratio));
    ck_assert_str_eq(digits, text);
    free(digits);
    /* a product of many large powers */
    text[0] = '\0';
    for (int i = 0; i < 1000; i++)
        strcat(text, i == 0 ? "1e9999" : "*1e9999");
    ck_assert_int_eq(cns_number_parse(&x, text, NULL), CNS_USAGE);
    cns_number_clear(&x);
    free(text);
}
END_TEST

/* A random decimal, and the same value as a ratio computed without the library. */
static void random_decimal(uint64_t *s, char *text, mpq_t q)
{
    char digits[64];
    int before = 1 + (int)test_random_below(s, 20), after = (int)test_random_below(s, 20), n = 0;
    int exponent = (int)test_random_below(s, 61) - 30;
    for (int i = 0; i < before + after; i++)
        digits[n++] = (char)('0' + test_random_below(s, 10));
    if (before > 1 && digits[0] == '0')
        digits[0] = '1';
    digits[n] = '\0';
    mpz_t power;
    mpz_init(power);
    mpz_set_str(mpq_numref(q), digits, 10);
    mpz_set_ui(mpq_denref(q), 1);
    long shift = exponent - after;
    mpz_ui_pow_ui(power, 10, (unsigned long)labs(shift));
    mpz_ptr side = shift >= 0 ? mpq_numref(q) : mpq_denref(q);
    mpz_mul(side, side, power);
    mpq_canonicalize(q);
    mpz_clear(power);
    if (after > 0)
        sprintf(text, "%.*s.%se%+d", before, digits, digits + before, exponent);
    else
        sprintf(text, "%se%d", digits, exponent);
}

START_TEST(reads_random_products)
{
    uint64_t s = test_seed();
    for (int round = 0; round < 2000; round++) {
        char text[1024], factor[128];
        cns_number x;
        mpq_t value, q;
        cns_number_init(&x);
        mpq_inits(value, q, (mpq_ptr)NULL);
        bool negative = test_random_below(&s, 2) == 0;
        mpq_set_si(value, negative ? -1 : 1, 1);
        strcpy(text, negative ? "-" : "");
        int factors = 1 + (int)test_random_below(&s, 5), pi = 0;
        for (int i = 0; i < factors; i++) {
            bool divide = i > 0 && test_random_below(&s, 2) == 0;
            if (i > 0)
                strcat(text, divide ? " /" : "*");
            if (test_random_below(&s, 4) == 0) {
                strcat(text, "pi");
                pi += divide ? -1 : 1;
                continue;
            }
            do
                random_decimal(&s, factor, q);
            while (divide && mpq_sgn(q) == 0);
            strcat(text, factor);
            if (divide)
                mpq_div(value, value, q);
            else
                mpq_mul(value, value, q);
        }
        if (pi < -1 || pi > 1) {
            ck_assert_int_eq(cns_number_parse(&x, text, NULL), CNS_USAGE);
        } else {
            parse(&x, text);
            ck_assert_msg(mpq_equal(x.ratio, value), "%s", text);
            ck_assert_int_eq(x.pi_power, mpq_sgn(value) != 0 ? pi : 0);
            ck_assert_int_eq(cns_number_sign(&x), mpq_sgn(value));
        }
        mpq_clears(value, q, (mpq_ptr)NULL);
        cns_number_clear(&x);
    }
}
END_TEST

/* Against the value at four times the precision, rounded once more: the two roundings agree except with
 * a chance of about 2^-(3 prec). */
START_TEST(converts_correctly_rounded)
{
    uint64_t s = test_seed();
    for (int round = 0; round < 2000; round++) {
        static const char *const forms[] = {"%s", "%s*pi", "%s/pi", "-pi/%s"};
        char decimal[128], text[160];
        cns_number x;
        mpq_t q;
        cns_number_init(&x);
        mpq_init(q);
        do
            random_decimal(&s, decimal, q);
        while (mpq_sgn(q) == 0);
        int form = (int)test_random_below(&s, 4);
        snprintf(text, sizeof text, forms[form], decimal);
        parse(&x, text);
        mpfr_prec_t prec = 10 + (mpfr_prec_t)test_random_below(&s, 400);
        mpfr_t y, fine, pi;
        mpfr_init2(y, prec);
        mpfr_init2(fine, 4 * prec + 64);
        mpfr_init2(pi, 4 * prec + 64);
        cns_number_get_mpfr(y, &x);
        mpfr_set_q(fine, x.ratio, MPFR_RNDN);
        mpfr_const_pi(pi, MPFR_RNDN);
        if (x.pi_power > 0)
            mpfr_mul(fine, fine, pi, MPFR_RNDN);
        else if (x.pi_power < 0)
            mpfr_div(fine, fine, pi, MPFR_RNDN);
        mpfr_prec_round(fine, prec, MPFR_RNDN);
        ck_assert_msg(mpfr_equal_p(y, fine), "%s at %ld bits", text, (long)prec);
        mpfr_clears(y, fine, pi, (mpfr_ptr)NULL);
        mpq_clear(q);
        cns_number_clear(&x);
    }
    mpfr_free_cache();
}
END_TEST

START_TEST(converts_to_double)
{
    cns_number x;
    cns_number_init(&x);
    parse(&x, "0.1");
    ck_assert(cns_number_get_d(&x) == 0.1);
    parse(&x, "pi");
    ck_assert(cns_number_get_d(&x) == 3.141592653589793);
    parse(&x, "-1e400");
    ck_assert(cns_number_get_d(&x) < -1e308);
    parse(&x, "1e-400");
    ck_assert(cns_number_get_d(&x) == 0);
    cns_number_clear(&x);
    mpfr_free_cache();
}
END_TEST

START_TEST(compares)
{
    static const char *const rising[] = {"-1e100000",   "-pi",
                                         "-3.14159265", "-1/pi",
                                         "-1e-100000",  "0",
                                         "1e-50",       "pi/10",
                                         "1/pi",        "0.3183098862",
                                         "3.14",        "3.1415926535897932384626433832795028841971693993",
                                         "pi",          "3.1415926535897932384626433832795028841971693994",
                                         "22/7",        "1e100000"};
    int n = COUNT(rising);
    cns_number x, y;
    cns_number_init(&x);
    cns_number_init(&y);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            parse(&x, rising[i]);
            parse(&y, rising[j]);
            ck_assert_msg(cns_number_cmp(&x, &y) == (i > j) - (i < j), "%s and %s", rising[i], rising[j]);
        }
    cns_number_clear(&x);
    cns_number_clear(&y);
    mpfr_free_cache();
}
END_TEST

/* Random bytes of the alphabet of numbers: read or refused, never anything else. */
START_TEST(survives_random_texts)
{
    static const char alphabet[] = "0123456789..eE+-*/pi  x\t\xc3";
    uint64_t s = test_seed();
    cns_number x;
    cns_error err;
    cns_number_init(&x);
    for (int round = 0; round < 50000; round++) {
        char text[32];
        size_t n = test_random_below(&s, sizeof text);
        for (size_t i = 0; i < n; i++)
            text[i] = alphabet[test_random_below(&s, sizeof alphabet - 1)];
        text[n] = '\0';
        cns_code code = cns_number_parse(&x, text, &err);
        ck_assert(code == CNS_OK || code == CNS_USAGE);
    }
    cns_number_clear(&x);
}
END_TEST

Suite *suite_number(void)
{
    Suite *suite = suite_create("number");
    TCase *text = tcase_create("text");
    tcase_add_test(text, reads_the_grammar);
    tcase_add_test(text, keeps_the_text);
    tcase_add_test(text, refuses_what_is_no_number);
    tcase_add_test(text, keeps_within_limits);
    tcase_add_test(text, reads_random_products);
    tcase_add_test(text, survives_random_texts);
    suite_add_tcase(suite, text);
    TCase *value = tcase_create("value");
    tcase_add_test(value, converts_correctly_rounded);
    tcase_add_test(value, converts_to_double);
    tcase_add_test(value, compares);
    suite_add_tcase(suite, value);
    return suite;
}
