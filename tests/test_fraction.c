/* Fractions had back from decimals: against all fractions there are, and through the texts of times. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "integrate/rows.h"
#include "num/decimal_text.h"
#include "num/fraction.h"
#include "support.h"

/* The nearest p/q with q <= most by looking at each q. */
static void nearest_of_all(mpq_t y, mpq_srcptr x, unsigned long most)
{
    mpq_t try, d, least;
    mpz_t p;
    mpq_inits(try, d, least, (mpq_ptr)0);
    mpz_init(p);
    for (unsigned long q = 1; q <= most; q++) {
        mpz_mul_ui(p, mpq_numref(x), q);
        mpz_fdiv_q(p, p, mpq_denref(x));
        for (int up = 0; up < 2; up++) {
            mpz_add_ui(mpq_numref(try), p, (unsigned long)up);
            mpz_set_ui(mpq_denref(try), q);
            mpq_canonicalize(try);
            mpq_sub(d, try, x);
            mpq_abs(d, d);
            if ((q > 1 || up > 0) && mpq_cmp(d, least) >= 0)
                continue;
            mpq_set(least, d);
            mpq_set(y, try);
        }
    }
    mpq_clears(try, d, least, (mpq_ptr)0);
    mpz_clear(p);
}

START_TEST(nearest_is_nearest)
{
    uint64_t s = test_seed();
    mpq_t x, y, z;
    mpz_t most;
    mpq_inits(x, y, z, (mpq_ptr)0);
    mpz_init(most);
    for (int round = 0; round < 3000; round++) {
        const unsigned long q = 1 + test_random_below(&s, 60),
                            d = 1 + test_random_below(&s, round % 2 ? 200 : 1000000);
        mpz_set_si(mpq_numref(x), (long)test_random_below(&s, 4 * d) - (long)(2 * d));
        mpz_set_ui(mpq_denref(x), d);
        mpq_canonicalize(x);
        mpz_set_ui(most, q);
        cns_fraction_nearest(y, x, most);
        nearest_of_all(z, x, q);
        mpq_sub(z, z, x);
        mpq_abs(z, z);
        ck_assert_int_le((int)mpz_cmp_ui(mpq_denref(y), q), 0);
        mpq_t distance;
        mpq_init(distance);
        mpq_sub(distance, y, x);
        mpq_abs(distance, distance);
        ck_assert_msg(mpq_equal(distance, z), "nearest to %.17g with denominators to %lu: not %.17g",
                      mpq_get_d(x), q, mpq_get_d(y));
        mpq_clear(distance);
        nearest_of_all(z, x, q);
        ck_assert_msg(mpz_cmp(mpq_denref(y), mpq_denref(z)) <= 0, "a larger denominator");
        mpq_canonicalize(y);
        mpz_gcd(most, mpq_numref(y), mpq_denref(y));
        ck_assert(mpz_cmp_ui(most, 1) == 0);
    }
    mpq_clears(x, y, z, (mpq_ptr)0);
    mpz_clear(most);
}
END_TEST

/* Every time of a grid is had back from its text, is later than the one before, and has the double that its
 * text has from 1/2 on. */
static void check_grid(const char *every, const char *end)
{
    cns_number step, last, text_value;
    cns_time_form form;
    mpq_t zero, time, back, before;
    mpq_inits(zero, time, back, before, (mpq_ptr)0);
    cns_number_init(&step);
    cns_number_init(&last);
    cns_number_init(&text_value);
    ck_assert_int_eq(cns_number_parse(&step, every, NULL), CNS_OK);
    ck_assert_int_eq(cns_number_parse(&last, end, NULL), CNS_OK);
    cns_time_form_init(&form);
    cns_time_form_add_grid(&form, zero, step.ratio);
    cns_time_form_add(&form, last.ratio);
    for (unsigned long row = 0; row < 200 && cns_row_time(&step, &last, row, time); row++) {
        char *text = cns_time_text(&form, time);
        ck_assert_msg(strspn(text, "0123456789.") == strlen(text), "%s", text);
        ck_assert_int_eq(cns_number_parse(&text_value, text, NULL), CNS_OK);
        if (form.fractions)
            cns_fraction_nearest(back, text_value.ratio, form.denominator);
        else
            mpq_set(back, text_value.ratio);
        ck_assert_msg(mpq_equal(back, time), "row %lu of %s: %s is another time", row, every, text);
        ck_assert(row == 0 || mpq_cmp(text_value.ratio, before) > 0);
        mpq_set(before, text_value.ratio);
        mpfr_t nearest;
        mpfr_init2(nearest, 53);
        mpfr_set_q(nearest, time, MPFR_RNDN);
        if (mpfr_cmp_d(nearest, 0.5) >= 0)
            ck_assert_msg(strtod(text, NULL) == mpfr_get_d(nearest, MPFR_RNDN), "%s", text);
        mpfr_clear(nearest);
        free(text);
    }
    cns_time_form_clear(&form);
    cns_number_clear(&step);
    cns_number_clear(&last);
    cns_number_clear(&text_value);
    mpq_clears(zero, time, back, before, (mpq_ptr)0);
}

START_TEST(times_are_had_back)
{
    static const struct {
        const char *every, *end;
    } grid[] = {{"1/3", "1"},       {"1e-7/3", "1e-6"},   {"1/3", "1e6/7"},     {"0.1", "2/3"},
                {"4/3", "1"},       {"1/3", "1/3"},       {"1/123456789", "1"}, {"0.333333333333", "10/3"},
                {"1e30/7", "1e32"}, {"1/1e40", "5/3e39"}, {"1000/3", "1e5"},    {"1/1024", "1"}};
    uint64_t s = test_seed();
    for (size_t i = 0; i < sizeof grid / sizeof *grid; i++)
        check_grid(grid[i].every, grid[i].end);
    for (int round = 0; round < 300; round++) {
        char every[64], end[64];
        const unsigned long q = 1 + test_random_below(&s, 2000000000);
        snprintf(every, sizeof every, "%lu/%lu", 1 + (unsigned long)test_random_below(&s, 3 * q), q);
        snprintf(end, sizeof end, "%lu/%lu", 1 + (unsigned long)test_random_below(&s, 1000000),
                 1 + (unsigned long)test_random_below(&s, round % 2 ? 9 : 1000000));
        check_grid(every, end);
    }
}
END_TEST

Suite *suite_fraction(void)
{
    Suite *suite = suite_create("fraction");
    TCase *tc = tcase_create("fraction");
    tcase_add_test(tc, nearest_is_nearest);
    tcase_add_test(tc, times_are_had_back);
    suite_add_tcase(suite, tc);
    return suite;
}
