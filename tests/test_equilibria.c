/* Fixed points and eigenvalues against closed forms, against the roots of the characteristic polynomial of a
 * Jacobian derived by hand, and the symmetries that models declare against their equations. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cns/decimal.h"
#include "cns/equilibria.h"
#include "problem.h"
#include "study/fixed_point.h"
#include "taylor/ball.h"

enum { BITS = 400, MAX_PARAMETERS = 8 };

/* A study of a model with its standard parameters, those named in `set` ("I=1.5 CT=1") apart. */
typedef struct subject {
    cns_study study;
    cns_number *parameters;
} subject;

static subject subject_open(const cns_model *m, const char *set)
{
    const char *texts[MAX_PARAMETERS];
    char given[MAX_PARAMETERS][64], name[16], value[64];
    for (int i = 0; i < m->n_parameters; i++) {
        texts[i] = m->parameters[i].standard;
        for (const char *at = set; at != NULL && sscanf(at, " %15[^=]=%63s", name, value) == 2;) {
            if (!strcmp(name, m->parameters[i].name))
                texts[i] = strcpy(given[i], value);
            at = strchr(at + 1, ' ');
        }
    }
    subject u = {.parameters = numbers_new(m->n_parameters, texts)};
    u.study = (cns_study){.model = m, .parameters = u.parameters, .threads = 1};
    return u;
}

static void subject_close(subject *u)
{
    numbers_free(u->parameters, u->study.model->n_parameters);
}

static cns_equilibria *equilibria_of(const subject *u, long decimals)
{
    cns_equilibria *e;
    cns_error err;
    check_ok(cns_equilibria_find(&u->study, decimals, &e, &err), &err);
    ck_assert_int_eq(e->decimals, decimals);
    return e;
}

static const cns_equilibrium *named(const cns_equilibria *e, const char *name)
{
    for (int i = 0; i < e->n; i++)
        if (!strcmp(e->item[i].name, name))
            return &e->item[i];
    ck_abort_msg("no fixed point %s", name);
}

static void check_text(const char *text, const mpfr_t x, long decimals, const char *what)
{
    char *right = cns_text_mpfr(x, CNS_PLACES_DECIMALS, decimals);
    ck_assert_msg(!strcmp(text, right), "%s: %s is not %s", what, text, right);
    free(right);
}

/* The four of a falling disk: sqrt(pi / (A -+ B)) by MPFR alone. */
START_TEST(test_disk_places)
{
    subject u = subject_open(cns_model_find("apw"), "A=7/5 B=1.0");
    cns_equilibria *e = equilibria_of(&u, 60);
    mpfr_t pi, x, zero;
    static const char *const names[] = {"edge-on", "broadside", "edge-on mirror", "broadside mirror"};
    mpfr_inits2(BITS, pi, x, zero, (mpfr_ptr)0);
    mpfr_const_pi(pi, MPFR_RNDN);
    mpfr_set_zero(zero, 1);
    ck_assert_int_eq(e->d, 4);
    ck_assert_int_eq(e->n, 4);
    for (int i = 0; i < 4; i++) { /* theta = pi/2, 0, 3 pi/2, pi */
        const cns_equilibrium *p = named(e, names[i]);
        const bool edge = i % 2 == 0;
        mpfr_mul_ui(x, pi, i == 0 ? 1 : i == 1 ? 0 : i == 2 ? 3 : 2, MPFR_RNDN);
        mpfr_div_ui(x, x, 2, MPFR_RNDN);
        check_text(p->state[0], x, 60, "theta");
        mpfr_div_d(x, pi, 0.2, MPFR_RNDN);
        mpfr_mul_ui(x, pi, 5, MPFR_RNDN); /* pi / (A - B) = 5 pi / 2, pi / (A + B) = 5 pi / 12 */
        mpfr_div_ui(x, x, edge ? 2 : 12, MPFR_RNDN);
        mpfr_sqrt(x, x, MPFR_RNDN);
        mpfr_setsign(x, x, i < 2, MPFR_RNDN);
        check_text(p->state[1], edge ? x : zero, 60, "Vx");
        check_text(p->state[2], edge ? zero : x, 60, "Vy");
        check_text(p->state[3], zero, 60, "omega");
    }
    mpfr_clears(pi, x, zero, (mpfr_ptr)0);
    cns_equilibria_free(e);
    subject_close(&u);
}
END_TEST

Suite *suite_equilibria(void)
{
    Suite *s = suite_create("equilibria");
    TCase *t = tcase_create("equilibria");
    tcase_add_test(t, test_disk_places);
    suite_add_tcase(s, t);
    return s;
}
