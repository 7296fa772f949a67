/* The first crossing of zero of a polynomial, against polynomials made from their roots. */
#include <stdio.h>
#include <stdlib.h>

#include "integrate/roots.h"
#include "problem.h"

enum { MAX_DEGREE = 300 };

/* A polynomial under construction, coefficients 0..degree. */
typedef struct poly {
    int degree;
    mpfr_prec_t prec;
    mpfr_t *c;
} poly;

static poly poly_new(long constant, mpfr_prec_t prec)
{
    poly p = {0, prec, cns_vector_xnew(MAX_DEGREE + 1, prec)};
    mpfr_set_si(p.c[0], constant, MPFR_RNDN);
    return p;
}

static void poly_free(poly *p)
{
    cns_vector_free(p->c);
}

/* p = p (t - r). */
static void times_root(poly *p, const mpfr_t r)
{
    mpfr_t x;
    mpfr_init2(x, p->prec);
    p->degree++;
    for (int k = p->degree; k >= 0; k--) {
        mpfr_mul(x, p->c[k], r, MPFR_RNDN);
        mpfr_neg(x, x, MPFR_RNDN);
        if (k > 0)
            mpfr_add(x, x, p->c[k - 1], MPFR_RNDN);
        mpfr_set(p->c[k], x, MPFR_RNDN);
    }
    mpfr_clear(x);
}

/* p = p ((t - a)^2 + b), b of either sign. */
static void times_quadratic(poly *p, const mpfr_t a, const mpfr_t b)
{
    poly q = poly_new(1, p->prec);
    mpfr_t *c = cns_vector_xnew(MAX_DEGREE + 1, p->prec), x;
    mpfr_init2(x, p->prec);
    times_root(&q, a);
    times_root(&q, a);
    mpfr_add(q.c[0], q.c[0], b, MPFR_RNDN);
    for (int i = 0; i <= p->degree; i++)
        for (int j = 0; j <= 2; j++) {
            mpfr_mul(x, p->c[i], q.c[j], MPFR_RNDN);
            mpfr_add(c[i + j], c[i + j], x, MPFR_RNDN);
        }
    p->degree += 2;
    for (int k = 0; k <= p->degree; k++)
        mpfr_set(p->c[k], c[k], MPFR_RNDN);
    mpfr_clear(x);
    cns_vector_free(c);
    poly_free(&q);
}

/* x of a text of cns_number. */
static void value(mpfr_t x, const char *text)
{
    cns_number *n = numbers_new(1, &text);
    cns_number_get_mpfr(x, n);
    numbers_free(n, 1);
}

static void times_root_text(poly *p, const char *root, int multiplicity)
{
    mpfr_t r;
    mpfr_init2(r, p->prec);
    value(r, root);
    for (int i = 0; i < multiplicity; i++)
        times_root(p, r);
    mpfr_clear(r);
}

static void times_quadratic_text(poly *p, const char *a, const char *b)
{
    mpfr_t x, y;
    mpfr_inits2(p->prec, x, y, (mpfr_ptr)0);
    value(x, a);
    value(y, b);
    times_quadratic(p, x, y);
    mpfr_clears(x, y, (mpfr_ptr)0);
}

/* The first crossing of p in (0, h] is `expected` to bits of accuracy, or there is none (NULL). -p too. */
static void check_root(const poly *p, const char *h, const mpfr_t expected, double bits, const char *what)
{
    mpfr_t limit, root;
    mpfr_inits2(p->prec, limit, root, (mpfr_ptr)0);
    value(limit, h);
    for (int negated = 0; negated < 2; negated++) {
        cns_error err;
        bool found;
        check_ok(cns_first_root(root, &found, p->c, p->degree, limit, &err), &err);
        if (!expected) {
            if (found)
                ck_abort_msg("%s: a root at %.20g", what, mpfr_get_d(root, MPFR_RNDN));
        } else {
            ck_assert_msg(found, "%s: no root", what);
            ck_assert(mpfr_sgn(root) > 0 && mpfr_cmp(root, limit) <= 0);
            check_close(root, expected, -bits, "%s", what);
        }
        for (int k = 0; k <= p->degree; k++)
            mpfr_neg(p->c[k], p->c[k], MPFR_RNDN);
    }
    mpfr_clears(limit, root, (mpfr_ptr)0);
}

static void check_root_text(const poly *p, const char *h, const char *expected, double bits, const char *what)
{
    mpfr_t x;
    mpfr_init2(x, p->prec);
    if (expected)
        value(x, expected);
    check_root(p, h, expected ? x : NULL, bits, what);
    mpfr_clear(x);
}

/* Roots of a polynomial (with multiplicities), the interval, the answer, its accuracy in bits when the
 * precision is 400. */
static const struct {
    const char *root[6];
    int multiplicity[6];
    const char *h, *expected;
    double bits;
} rows[] = {
    {{"1/3"}, {1}, "1", "1/3", 395},
    {{"1/3"}, {1}, "1/4", NULL, 0},
    {{"1/3"}, {1}, "1000", "1/3", 385},
    {{"-1/3"}, {1}, "1000", NULL, 0},
    {{"1e-30"}, {1}, "1", "1e-30", 490},
    {{"1e-30", "2e-30"}, {1, 1}, "1", "1e-30", 390},
    {{"1e20"}, {1}, "1e30", "1e20", 320},
    {{"1/3"}, {2}, "1", NULL, 0},
    {{"1/2"}, {2}, "1", NULL, 0},
    {{"1/4"}, {4}, "1", NULL, 0},
    {{"1/3", "9/10"}, {2, 1}, "1", "9/10", 390},
    {{"1/2", "9/10"}, {2, 1}, "1", "9/10", 390},
    {{"1/2", "3/4"}, {2, 1}, "1", "3/4", 390},
    {{"1/3"}, {3}, "1", "1/3", 100},
    {{"1/2"}, {3}, "1", "1/2", 100},
    {{"1/2"}, {1}, "1", "1/2", 395},
    {{"1/4"}, {1}, "1", "1/4", 395},
    {{"3/4", "1/4", "1/2"}, {1, 1, 1}, "1", "1/4", 390},
    {{"1/2", "1/4"}, {1, 2}, "1", "1/2", 380},
    {{"0.3", "0.30000000000000000001"}, {1, 1}, "1", "0.3", 320},
    {{"0.3", "0.30000000000000000000000000000000000000000000000001"}, {1, 1}, "1", "0.3", 220},
    {{"0.3", "0.30000000000000000001", "0.30000000000000000002"}, {1, 1, 1}, "1", "0.3", 250},
    {{"0.3", "0.30000000000000000001", "0.29999999999999999999"},
     {2, 1, 0},
     "1",
     "0.30000000000000000001",
     250},
    {{"0.999999999999999999999999999999"}, {1}, "1", "0.999999999999999999999999999999", 390},
    {{"1.000000000000000000000000000001"}, {1}, "1", NULL, 0},
    {{"0.7", "0.2", "-0.2", "5"}, {1, 1, 1, 1}, "1", "0.2", 390},
};

START_TEST(finds_the_first_crossing)
{
    poly p = poly_new(-3, 400);
    char what[64];
    snprintf(what, sizeof what, "row %d", _i);
    for (int i = 0; i < 6 && rows[_i].root[i]; i++)
        times_root_text(&p, rows[_i].root[i], rows[_i].multiplicity[i]);
    check_root_text(&p, rows[_i].h, rows[_i].expected, rows[_i].bits, what);
    poly_free(&p);
}
END_TEST

/* (t - 1/pi)^2 -+ d^2, d = 1e-30, 1e-60: an excursion that only just crosses, or only just does not. A search
 * by sampling sees one sign at each of a hundred thousand points. */
START_TEST(sees_what_sampling_cannot)
{
    enum { POINTS = 100000 };
    for (int deep = 0; deep < 2; deep++) {
        const char *square = deep ? "1e-120" : "1e-60";
        poly crossing = poly_new(1, 600), touching = poly_new(1, 600);
        char negative[16];
        mpfr_t x, y, t;
        mpfr_inits2(600, x, y, t, (mpfr_ptr)0);
        snprintf(negative, sizeof negative, "-%s", square);
        times_quadratic_text(&crossing, "1/pi", negative);
        times_quadratic_text(&touching, "1/pi", square);
        for (int i = 0; i <= POINTS && !deep; i++) {
            mpfr_set_ui(t, (unsigned long)i, MPFR_RNDN);
            mpfr_div_ui(t, t, POINTS, MPFR_RNDN);
            mpfr_mul(y, crossing.c[2], t, MPFR_RNDN);
            mpfr_add(y, y, crossing.c[1], MPFR_RNDN);
            mpfr_mul(y, y, t, MPFR_RNDN);
            mpfr_add(y, y, crossing.c[0], MPFR_RNDN);
            ck_assert(mpfr_sgn(y) > 0);
        }
        value(x, "1/pi");
        value(y, deep ? "1e-60" : "1e-30");
        mpfr_sub(x, x, y, MPFR_RNDN);
        check_root(&crossing, "1", x, deep ? 380 : 480, "crossing");
        check_root(&touching, "1", NULL, 0, "touching");
        mpfr_clears(x, y, t, (mpfr_ptr)0);
        poly_free(&crossing);
        poly_free(&touching);
    }
}
END_TEST

/* Two roots closer than the noise of the coefficients: none, or one where the sign differs behind them. */
START_TEST(below_the_noise_only_the_sign_counts)
{
    poly p = poly_new(1, 100);
    times_root_text(&p, "1/3", 2);
    check_root_text(&p, "1", NULL, 0, "a double root, rounded");
    times_root_text(&p, "1/3", 1);
    check_root_text(&p, "1", "1/3", 25, "a triple root, rounded");
    poly_free(&p);
}
END_TEST

/* A root at the very end of the interval: found there, or left to the next interval, never elsewhere. */
START_TEST(a_root_at_the_end)
{
    static const char *const ends[] = {"1", "3/4", "1/3", "1e-5", "123/7"};
    for (int i = 0; i < COUNT(ends); i++) {
        poly p = poly_new(1, 200);
        mpfr_t h, root;
        cns_error err;
        bool found;
        mpfr_inits2(200, h, root, (mpfr_ptr)0);
        times_root_text(&p, ends[i], 1);
        times_root_text(&p, "-2", 1);
        value(h, ends[i]);
        check_ok(cns_first_root(root, &found, p.c, p.degree, h, &err), &err);
        if (found)
            check_close(root, h, log2_of(h) - 190, "end %s", ends[i]);
        mpfr_clears(h, root, (mpfr_ptr)0);
        poly_free(&p);
    }
}
END_TEST

START_TEST(random_products)
{
    uint64_t s = test_seed() + (uint64_t)_i;
    const mpfr_prec_t prec = 640;
    poly p = poly_new(test_random_below(&s, 2) ? 1 : -1, prec);
    mpfr_t r, x, first;
    bool any = false;
    double gap = test_random_below(&s, 2) ? 0 : 25; /* factors may come in clusters 2^-gap wide */
    int factors = 1 + (int)test_random_below(&s, gap > 0 ? 4 : 9);
    double centre = test_random_unit(&s);
    mpfr_inits2(prec, r, x, first, (mpfr_ptr)0);
    for (int i = 0; i < factors; i++) {
        int kind = (int)test_random_below(&s, 6);
        mpfr_set_d(r, 2 * test_random_unit(&s) - 0.3, MPFR_RNDN);
        if (gap > 0 && test_random_below(&s, 2)) {
            mpfr_set_d(r, test_random_unit(&s), MPFR_RNDN);
            mpfr_div_2ui(r, r, (unsigned long)gap, MPFR_RNDN);
            mpfr_add_d(r, r, centre, MPFR_RNDN);
        }
        if (mpfr_zero_p(r))
            continue;
        if (kind == 0) { /* two conjugate roots, near the real axis or not */
            mpfr_set_d(x, 1e-3 + test_random_unit(&s), MPFR_RNDN);
            mpfr_div_2ui(x, x, test_random_below(&s, 60), MPFR_RNDN);
            times_quadratic(&p, r, x);
            continue;
        }
        int multiplicity = kind == 1 ? 2 : kind == 2 ? 3 : 1;
        for (int k = 0; k < multiplicity; k++)
            times_root(&p, r);
        if (multiplicity % 2 && mpfr_sgn(r) > 0 && mpfr_cmp_ui(r, 1) <= 0 &&
            (!any || mpfr_cmp(r, first) < 0)) {
            mpfr_set(first, r, MPFR_RNDN);
            any = true;
        }
    }
    if (mpfr_zero_p(p.c[0]))
        mpfr_set_ui(p.c[0], 1, MPFR_RNDN);
    else
        check_root(&p, "1", any ? first : NULL, 70, "a random product");
    mpfr_clears(r, x, first, (mpfr_ptr)0);
    poly_free(&p);
}
END_TEST

START_TEST(high_degrees)
{
    poly p = poly_new(1, 500);
    mpfr_t x;
    mpfr_init2(x, 500);

    /* cos 20 t: the first of the roots pi/40, 3 pi/40, ... */
    for (int k = 2; k <= 300; k += 2) {
        mpfr_mul_si(p.c[k], p.c[k - 2], -400, MPFR_RNDN);
        mpfr_div_ui(p.c[k], p.c[k], (unsigned long)(k * (k - 1)), MPFR_RNDN);
    }
    p.degree = 300;
    check_root_text(&p, "1", "pi/40", 460, "cos 20 t");
    check_root_text(&p, "1/13", NULL, 0, "cos 20 t before its root");
    mpfr_set_d(x, 1e-40, MPFR_RNDN); /* 1 + cos 20 t only touches, 1 - 1e-40 + cos 20 t crosses */
    mpfr_add_ui(p.c[0], p.c[0], 1, MPFR_RNDN);
    check_root(&p, "1/4", NULL, 0, "1 + cos 20 t");
    mpfr_sub(p.c[0], p.c[0], x, MPFR_RNDN);
    mpfr_sqrt(x, x, MPFR_RNDN); /* 20 (t - pi/20) = -acos(1 - d), which is sqrt(2 d) (1 + d/12 + ...) */
    mpfr_set_d(x, 1e-40, MPFR_RNDN);
    mpfr_ui_sub(x, 1, x, MPFR_RNDN);
    mpfr_acos(x, x, MPFR_RNDN);
    mpfr_div_ui(x, x, 20, MPFR_RNDN);
    mpfr_t y;
    mpfr_init2(y, 500);
    value(y, "pi/20");
    mpfr_sub(x, y, x, MPFR_RNDN);
    check_root(&p, "1/4", x, 330, "1 - 1e-40 + cos 20 t");
    mpfr_clear(y);
    poly_free(&p);

    p = poly_new(-1, 500); /* 2 t^300 - 1 */
    p.degree = 300;
    mpfr_set_ui(p.c[300], 2, MPFR_RNDN);
    mpfr_set_ui(x, 2, MPFR_RNDN);
    mpfr_rootn_ui(x, x, 300, MPFR_RNDN);
    mpfr_ui_div(x, 1, x, MPFR_RNDN);
    check_root(&p, "1", x, 480, "2 t^300 - 1");
    poly_free(&p);

    p = poly_new(1, 500); /* Chebyshev's T_60(1 - t): roots 1 - cos((2j+1) pi/120) in (0, 2) */
    mpfr_t *a = cns_vector_xnew(61, 500), *b = cns_vector_xnew(61, 500), *c = cns_vector_xnew(61, 500);
    mpfr_set_ui(a[0], 1, MPFR_RNDN);
    mpfr_set_ui(b[0], 1, MPFR_RNDN);
    mpfr_set_si(b[1], -1, MPFR_RNDN);
    for (int n = 2; n <= 60; n++) {
        for (int k = 0; k <= n; k++) {
            mpfr_set(c[k], b[k], MPFR_RNDN);
            if (k > 0)
                mpfr_sub(c[k], c[k], b[k - 1], MPFR_RNDN);
            mpfr_mul_ui(c[k], c[k], 2, MPFR_RNDN);
            mpfr_sub(c[k], c[k], a[k], MPFR_RNDN);
        }
        for (int k = 0; k <= n; k++) {
            mpfr_set(a[k], b[k], MPFR_RNDN);
            mpfr_set(b[k], c[k], MPFR_RNDN);
        }
    }
    for (int k = 0; k <= 60; k++)
        mpfr_set(p.c[k], b[k], MPFR_RNDN);
    p.degree = 60;
    value(x, "pi/120");
    mpfr_cos(x, x, MPFR_RNDN);
    mpfr_ui_sub(x, 1, x, MPFR_RNDN);
    check_root(&p, "2", x, 300, "T_60");
    cns_vector_free(a);
    cns_vector_free(b);
    cns_vector_free(c);
    poly_free(&p);
    mpfr_clear(x);
}
END_TEST

/* Coefficients of very different sizes, as those of a long step in few bits. */
START_TEST(works_in_53_bits)
{
    poly p = poly_new(1, 53);
    times_root_text(&p, "1/3", 1);
    times_root_text(&p, "1/2", 1);
    times_root_text(&p, "-4", 3);
    check_root_text(&p, "1", "1/3", 46, "53 bits");
    poly_free(&p);
}
END_TEST

Suite *suite_roots(void)
{
    Suite *s = suite_create("roots");
    TCase *t = tcase_create("roots");
    add_table_test(t, finds_the_first_crossing, rows);
    tcase_add_test(t, sees_what_sampling_cannot);
    tcase_add_test(t, below_the_noise_only_the_sign_counts);
    tcase_add_test(t, a_root_at_the_end);
    tcase_add_loop_test(t, random_products, 0, 60);
    tcase_add_test(t, high_degrees);
    tcase_add_test(t, works_in_53_bits);
    suite_add_tcase(s, t);
    return s;
}
