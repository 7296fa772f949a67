/* Fixed points and eigenvalues against closed forms, against the roots of the characteristic polynomial of a
 * Jacobian derived by hand, and the symmetries that models declare against their equations. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cns/study/equilibria.h"
#include "num/decimal_text.h"
#include "problem.h"
#include "study/saddle/fixed_point.h"
#include "taylor/ball.h"
#include "taylor/tangent.h"

enum { BITS = 400, MAX_PARAMETERS = 8 };

/* A system of a model with its standard parameters, those named in `set` ("I=1.5 CT=1") apart. */
typedef struct subject {
    cns_system *system;
} subject;

static subject subject_open(const cns_model *m, const char *set)
{
    char name[MAX_PARAMETERS][16], value[MAX_PARAMETERS][64];
    cns_setting settings[MAX_PARAMETERS + 1] = {{NULL, NULL}};
    int n = 0;
    for (const char *at = set; at != NULL && sscanf(at, " %15[^=]=%63s", name[n], value[n]) == 2; n++) {
        settings[n] = (cns_setting){name[n], value[n]};
        at = strchr(at + 1, ' ');
    }
    return (subject){system_new(m, settings)};
}

static void subject_close(subject *u)
{
    cns_system_free(u->system);
}

static cns_equilibria *equilibria_of(const subject *u, long decimals)
{
    cns_equilibria *e;
    cns_error err;
    check_ok(cns_equilibria_find(u->system, decimals, NULL, &e, &err), &err);
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
START_TEST(disk_places)
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

/* One real root and those of t^3 + c2 t^2 + c1 t + c0 are the eigenvalues, in any order. */
static void check_spectrum(const cns_equilibrium *p, long decimals, const arb_t single, acb_poly_t cubic)
{
    acb_ptr root = _acb_vec_init(4);
    mpfr_t x;
    int found = 0;
    mpfr_init2(x, BITS);
    ck_assert_int_eq(acb_poly_find_roots(root, cubic, NULL, 0, BITS), 3);
    ck_assert(acb_poly_validate_real_roots(root, cubic, BITS) != 0);
    acb_set_arb(root + 3, single);
    for (int i = 0; i < 4; i++) {
        arf_get_mpfr(x, arb_midref(acb_realref(root + i)), MPFR_RNDN);
        char *re = cns_text_mpfr(x, CNS_PLACES_DECIMALS, decimals);
        arf_get_mpfr(x, arb_midref(acb_imagref(root + i)), MPFR_RNDN);
        const bool real = mpfr_zero_p(x) || mpfr_get_exp(x) < -BITS / 2;
        char *im = real ? NULL : cns_text_mpfr(x, CNS_PLACES_DECIMALS, decimals);
        for (int k = 0; k < 4; k++)
            if (!strcmp(p->eigenvalues[k].re, re) && !strcmp(p->eigenvalues[k].im, im ? im : "0")) {
                found++;
                break;
            }
        free(re);
        free(im);
    }
    ck_assert_msg(found == 4, "%s: only %d of the roots of the characteristic polynomial are eigenvalues",
                  p->name, found);
    mpfr_clear(x);
    _acb_vec_clear(root, 4);
}

/* The Jacobians of a disk that falls edge-on or broadside, by hand. With v the speed, one component of the
 * velocity decouples, with eigenvalue -2 drag v / (pi mass); the others obey d theta' = d omega,  d V' = a d
 * theta + b d V + c d omega,  d omega' = k (v d V - mu1 d omega), whose characteristic polynomial is t^3 + (k
 * mu1 - b) t^2 - (b k mu1 + c k v) t - a k v. */
static void check_disk(const cns_number *parameter, const cns_equilibrium *p, bool edge, long decimals)
{
    enum { I, CT, CR, A, B, MU1, N };
    arb_t q[N], pi, v, a, b, c, k, drag, along, across, t;
    acb_poly_t cubic;
    for (int i = 0; i < N; i++) {
        arb_init(q[i]);
        cns_ball_number(q[i], &parameter[i], BITS);
    }
    arb_ptr all[] = {pi, v, a, b, c, k, drag, along, across, t};
    for (int i = 0; i < COUNT(all); i++)
        arb_init(all[i]);
    acb_poly_init(cubic);
    arb_const_pi(pi, BITS);
    (edge ? arb_sub : arb_add)(drag, q[A], q[B], BITS);
    arb_div(v, pi, drag, BITS);
    arb_sqrt(v, v, BITS);
    arb_add_ui(along, q[I], edge ? 0 : 1, BITS); /* the mass of the component that decouples */
    arb_add_ui(across, q[I], edge ? 1 : 0, BITS);
    arb_set_si(a, edge ? 1 : -1);
    arb_div(a, a, across, BITS);
    arb_mul_ui(b, q[CT], 2, BITS); /* b = (-+ 2 CT - drag) v / (pi mass) */
    if (edge)
        arb_neg(b, b);
    arb_sub(b, b, drag, BITS);
    arb_mul(b, b, v, BITS);
    arb_div(b, b, pi, BITS);
    arb_div(b, b, across, BITS);
    arb_mul_ui(c, q[CR], 2,
               BITS); /* edge: (I - 2 CR / pi) v / (I + 1); broadside: (2 CR / pi - I - 1) v / I */
    arb_div(c, c, pi, BITS);
    arb_sub(c, along, c, BITS);
    if (!edge)
        arb_neg(c, c);
    arb_mul(c, c, v, BITS);
    arb_div(c, c, across, BITS);
    arb_set_d(t, 0.5);
    arb_add(k, q[I], t, BITS);
    arb_ui_div(k, 4, k, BITS);

    acb_poly_set_coeff_si(cubic, 3, 1);
    arb_mul(t, k, q[MU1], BITS);
    arb_sub(t, t, b, BITS);
    acb_poly_fit_length(cubic, 4);
    acb_set_arb(cubic->coeffs + 2, t);
    arb_mul(t, b, q[MU1], BITS);
    arb_addmul(t, c, v, BITS);
    arb_mul(t, t, k, BITS);
    arb_neg(t, t);
    acb_set_arb(cubic->coeffs + 1, t);
    arb_mul(t, a, k, BITS);
    arb_mul(t, t, v, BITS);
    arb_neg(t, t);
    acb_set_arb(cubic->coeffs, t);
    arb_mul(t, drag, v, BITS);
    arb_mul_si(t, t, -2, BITS);
    arb_div(t, t, pi, BITS);
    arb_div(t, t, along, BITS);
    check_spectrum(p, decimals, t, cubic);
    acb_poly_clear(cubic);
    for (int i = 0; i < COUNT(all); i++)
        arb_clear(all[i]);
    for (int i = 0; i < N; i++)
        arb_clear(q[i]);
}

START_TEST(disk_eigenvalues)
{
    uint64_t s = test_seed();
    for (int turn = 0; turn < 6; turn++) {
        char set[256];
        double b = 0.1 + test_random_unit(&s);
        snprintf(set, sizeof set, "I=%.6f CT=%.6f CR=%.6f A=%.6f B=%.6f mu1=%.6f",
                 0.3 + 3 * test_random_unit(&s), 0.2 + 2 * test_random_unit(&s), 1 + 4 * test_random_unit(&s),
                 b + 0.05 + test_random_unit(&s), b, 0.05 + test_random_unit(&s));
        subject u = subject_open(cns_model_find("apw"), turn == 0 ? "I=1.2191" : turn == 1 ? "I=2.2" : set);
        cns_equilibria *e = equilibria_of(&u, 50);
        check_disk(cns_system_parameters(u.system), named(e, "edge-on"), true, 50);
        check_disk(cns_system_parameters(u.system), named(e, "edge-on mirror"), true, 50);
        check_disk(cns_system_parameters(u.system), named(e, "broadside"), false, 50);
        check_disk(cns_system_parameters(u.system), named(e, "broadside mirror"), false, 50);
        cns_equilibria_free(e);
        subject_close(&u);
    }
}
END_TEST

/* The figures of the literature, and what they mean. */
START_TEST(disk_stability)
{
    subject u = subject_open(cns_model_find("apw"), "I=1.2191");
    cns_equilibria *e = equilibria_of(&u, 7);
    const cns_equilibrium *p = named(e, "edge-on");
    static const char *const re[] = {"0.3812957", "-0.5853906", "-0.9861176", "-0.9861176"},
                             *const im[] = {"0", "0", "2.5950357", "-2.5950357"};
    for (int k = 0; k < 4; k++) {
        ck_assert_str_eq(p->eigenvalues[k].re, re[k]);
        ck_assert_str_eq(p->eigenvalues[k].im, im[k]);
    }
    ck_assert_str_eq(p->stability, "saddle-focus");
    ck_assert_int_eq(p->unstable, 1);
    ck_assert_int_eq(p->stable, 3);
    cns_equilibria_free(e);
    subject_close(&u);
}
END_TEST

/* C+ and C- of Lorenz's model: x = y = +-sqrt(b (R - 1)), eigenvalues the roots of
 * t^3 + (sigma + b + 1) t^2 + b (R + sigma) t + 2 b sigma (R - 1); the origin's: -b and two of a quadratic.
 */
START_TEST(the_lorenz_system)
{
    subject u = subject_open(cns_model_find("lorenz"), NULL);
    cns_equilibria *e = equilibria_of(&u, 50);
    acb_poly_t cubic;
    acb_ptr root = _acb_vec_init(3);
    mpfr_t x;
    mpfr_init2(x, BITS);
    acb_poly_init(cubic);
    ck_assert_int_eq(e->n, 3);
    for (int i = 0; i < 2; i++) {
        const cns_equilibrium *p = named(e, i ? "C-" : "C+");
        mpfr_sqrt_ui(x, 72, MPFR_RNDN);
        mpfr_setsign(x, x, i, MPFR_RNDN);
        check_text(p->state[0], x, 50, "x");
        check_text(p->state[1], x, 50, "y");
        ck_assert(!strncmp(p->state[2], "27.000", 6));
        acb_poly_set_coeff_si(cubic, 3, 3);
        acb_poly_set_coeff_si(cubic, 2, 41);
        acb_poly_set_coeff_si(cubic, 1, 304);
        acb_poly_set_coeff_si(cubic, 0, 4320);
        ck_assert_int_eq(acb_poly_find_roots(root, cubic, NULL, 0, BITS), 3);
        for (int k = 0; k < 3; k++) {
            int same = 0;
            for (int j = 0; j < 3; j++) {
                arf_get_mpfr(x, arb_midref(acb_realref(root + j)), MPFR_RNDN);
                char *re = cns_text_mpfr(x, CNS_PLACES_DECIMALS, 50);
                same += !strcmp(re, p->eigenvalues[k].re);
                free(re);
            }
            ck_assert_int_eq(same, k < 2 ? 2 : 1);
        }
        ck_assert_str_eq(p->stability, "saddle-focus");
        ck_assert_int_eq(p->unstable, 2);
    }
    const cns_equilibrium *p = named(e, "origin"); /* t^2 + 11 t - 270 = 0 */
    mpfr_sqrt_ui(x, 1201, MPFR_RNDN);
    mpfr_sub_ui(x, x, 11, MPFR_RNDN);
    mpfr_div_ui(x, x, 2, MPFR_RNDN);
    check_text(p->eigenvalues[0].re, x, 50, "unstable eigenvalue");
    ck_assert_str_eq(p->eigenvalues[1].re, "-2.66666666666666666666666666666666666666666666666667");
    ck_assert_str_eq(p->stability, "saddle");
    for (int k = 0; k < 3; k++)
        ck_assert_str_eq(p->eigenvalues[k].im, "0");
    mpfr_clear(x);
    acb_poly_clear(cubic);
    _acb_vec_clear(root, 3);
    cns_equilibria_free(e);
    subject_close(&u);
}
END_TEST

/* At R = 1 the three meet in one that Newton's method cannot prove. Nothing is claimed. */
START_TEST(degenerate)
{
    subject u = subject_open(cns_model_find("lorenz"), "R=1");
    cns_equilibria *e;
    cns_error err;
    ck_assert_int_eq(cns_equilibria_find(u.system, 20, NULL, &e, &err), CNS_UNREACHED);
    ck_assert_ptr_nonnull(strstr(err.text, "origin"));
    ck_assert_int_eq(e->n, 0);
    cns_equilibria_free(e);
    subject_close(&u);
}
END_TEST

/* Models of one test. */

/* x' = -x, y' = 1/2 - 2 y + x^2, z' = y - z */
static void build_double(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node x = cns_state(p, 0), y = cns_state(p, 1), z = cns_state(p, 2);
    cns_derivative(p, 0, cns_neg(p, x));
    cns_derivative(
        p, 1,
        cns_sub(p, cns_add(p, cns_constant(p, "1/2"), cns_sqr(p, x)), cns_mul(p, cns_constant(p, "2"), y)));
    cns_derivative(p, 2, cns_sub(p, y, z));
}

/* x' = y - x, y' = -y: one eigenvector for the eigenvalue -1 */
static void build_defective(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node x = cns_state(p, 0), y = cns_state(p, 1);
    cns_derivative(p, 0, cns_sub(p, y, x));
    cns_derivative(p, 1, cns_sub(p, cns_mul(p, cns_constant(p, "0"), x), y));
}

/* x' = 1 + x^2 */
static void build_none(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_derivative(p, 0, cns_add(p, cns_constant(p, "1"), cns_sqr(p, cns_state(p, 0))));
}

/* x' = 0.125 - x: two decimals are a tie */
static void build_tie(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_derivative(p, 0, cns_sub(p, cns_constant(p, "0.125"), cns_state(p, 0)));
}

static int one_guess(const double *parameter, cns_model_guess *guess)
{
    (void)parameter;
    guess[0] = (cns_model_guess){.name = "rest", .state = {0.3, 0.2, 0.1}};
    return 1;
}

static const cns_model_state three[] = {{"x", "", 1}, {"y", "", 1}, {"z", "", 1}};

START_TEST(double_eigenvalue)
{
    const cns_model m = {
        .name = "double", .n_states = 3, .states = three, .build = build_double, .equilibria = one_guess};
    subject u = subject_open(&m, NULL);
    cns_equilibria *e = equilibria_of(&u, 5);
    ck_assert_int_eq(e->n, 1);
    ck_assert_str_eq(e->item[0].state[1], "0.25000");
    ck_assert_str_eq(e->item[0].eigenvalues[0].re, "-1.00000");
    ck_assert_str_eq(e->item[0].eigenvalues[1].re, "-1.00000");
    ck_assert_str_eq(e->item[0].eigenvalues[2].re, "-2.00000");
    ck_assert_str_eq(e->item[0].stability, "stable node");
    cns_equilibria_free(e);
    subject_close(&u);

    const cns_model defective = {.name = "defective",
                                 .n_states = 2,
                                 .states = three,
                                 .build = build_defective,
                                 .equilibria = one_guess};
    u = subject_open(&defective, NULL);
    e = equilibria_of(&u, 10);
    ck_assert_int_eq(e->n, 1);
    for (int k = 0; k < 2; k++)
        ck_assert_str_eq(e->item[0].eigenvalues[k].re, "-1.0000000000");
    cns_equilibria_free(e);
    subject_close(&u);
}
END_TEST

START_TEST(none_and_a_tie)
{
    cns_model m = {
        .name = "none", .n_states = 1, .states = three, .build = build_none, .equilibria = one_guess};
    subject u = subject_open(&m, NULL);
    cns_equilibria *e;
    cns_error err;
    ck_assert_int_eq(cns_equilibria_find(u.system, 5, NULL, &e, &err), CNS_UNREACHED);
    ck_assert_int_eq(e->n, 0);
    cns_equilibria_free(e);
    subject_close(&u);
    m.build = build_tie;
    u = subject_open(&m, NULL);
    cns_code code = cns_equilibria_find(u.system, 2, NULL, &e, &err);
    if (code == CNS_UNREACHED) /* nothing is printed that is not certain */
        ck_assert_int_eq(e->decimals, 1);
    else
        check_ok(code, &err);
    ck_assert_str_eq(e->item[0].state[0], code ? "0.1" : "0.12");
    cns_equilibria_free(e);
    m.equilibria = NULL;
    ck_assert_int_eq(cns_equilibria_find(u.system, 2, NULL, &e, &err), CNS_USAGE);
    ck_assert_ptr_null(e);
    subject_close(&u);
}
END_TEST

/* f of states x, by a jet. */
static void field_at(cns_jet *J, int n, mpfr_t *x, mpfr_t *f)
{
    cns_error err;
    cns_jet_begin(J, 1);
    for (int i = 0; i < n; i++)
        cns_jet_set_state(J, i, x[i]);
    check_ok(cns_jet_expand(J, 1, &err), &err);
    for (int i = 0; i < n; i++)
        cns_jet_coefficient(J, f[i], i, 1);
}

/* What a model calls a symmetry takes f(x) to f(g(x)). */
START_TEST(symmetries_of_a_model)
{
    enum { PREC = 200 };
    uint64_t s = test_seed();
    for (int k = 0; k < cns_model_count(); k++) {
        const cns_model *m = cns_model_at(k);
        const int n = m->n_states;
        cns_program *p = model_program(m->name, NULL);
        cns_jet *J = jet_new(p, &cns_arith_mpfr, 1, PREC);
        mpfr_t *x = cns_vector_xnew(n, PREC), *f = cns_vector_xnew(n, PREC), *g = cns_vector_xnew(n, PREC);
        for (int j = 0; j < m->n_symmetries; j++) {
            const cns_model_symmetry *y = &m->symmetries[j];
            for (int i = 0; i < n; i++)
                mpfr_set_d(x[i], 4 * test_random_unit(&s) - 2, MPFR_RNDN);
            field_at(J, n, x, f);
            for (int i = 0; i < n; i++) {
                mpfr_mul_si(x[i], x[i], y->sign[i], MPFR_RNDN);
                if (y->shift[i]) {
                    cns_number *shift = numbers_new(1, &y->shift[i]);
                    cns_number_get_mpfr(g[0], shift);
                    mpfr_add(x[i], x[i], g[0], MPFR_RNDN);
                    numbers_free(shift, 1);
                }
            }
            field_at(J, n, x, g);
            for (int i = 0; i < n; i++) {
                mpfr_mul_si(f[i], f[i], y->sign[i], MPFR_RNDN);
                check_close(f[i], g[i], 20.0 - PREC, "%s, %s, state %d", m->name, y->name, i);
            }
        }
        cns_vector_free(x);
        cns_vector_free(f);
        cns_vector_free(g);
        cns_jet_free(J);
        cns_program_free(p);
    }
}
END_TEST

/* Balls hold the values at points of the box, tangents of |omega| on both sides of its kink included. */
START_TEST(balls)
{
    enum { PREC = 120 };
    uint64_t s = test_seed();
    cns_program *p = model_program("apw", NULL), *tangent;
    cns_error err;
    check_ok(cns_tangent_program(p, 1, &tangent, &err), &err);
    const int n = cns_program_states(tangent);
    cns_jet *J = jet_new(tangent, &cns_arith_mpfr, 1, PREC + 80);
    mpfr_t *x = cns_vector_xnew(n, PREC + 80), *f = cns_vector_xnew(n, PREC + 80);
    arb_ptr box = _arb_vec_init(n), image = _arb_vec_init(n);
    for (int turn = 0; turn < 200; turn++) {
        const slong size = -2 - (slong)test_random_below(&s, 60);
        for (int i = 0; i < n; i++) {
            const bool flat = turn % 4 == 1 && i != 3; /* only omega varies */
            arb_set_d(box + i, i == 3 && turn % 2 ? 0 : 1 + 2 * test_random_unit(&s));
            mpfr_set_d(x[i], flat ? 0 : 2 * test_random_unit(&s) - 1, MPFR_RNDN);
            mpfr_mul_2si(x[i], x[i], size, MPFR_RNDN);
            arf_get_mpfr(f[i], arb_midref(box + i), MPFR_RNDN);
            mpfr_add(x[i], x[i], f[i], MPFR_RNDN);
            if (!flat)
                mag_set_ui_2exp_si(arb_radref(box + i), 1, size);
        }
        check_ok(cns_ball_derivatives(tangent, box, image, PREC, &err), &err);
        field_at(J, n, x, f);
        for (int i = 0; i < n; i++) {
            arf_t value;
            arf_init(value);
            arf_set_mpfr(value, f[i]);
            ck_assert_msg(arb_contains_arf(image + i, value), "state %d lies outside, box 2^%ld", i,
                          (long)size);
            arf_clear(value);
        }
    }
    _arb_vec_clear(box, n);
    _arb_vec_clear(image, n);
    cns_vector_free(x);
    cns_vector_free(f);
    cns_jet_free(J);
    cns_program_free(tangent);
    cns_program_free(p);
}
END_TEST

Suite *suite_equilibria(void)
{
    Suite *s = suite_create("equilibria");
    TCase *t = tcase_create("equilibria");
    tcase_add_test(t, disk_places);
    tcase_add_test(t, disk_eigenvalues);
    tcase_add_test(t, disk_stability);
    tcase_add_test(t, the_lorenz_system);
    tcase_add_test(t, degenerate);
    tcase_add_test(t, double_eigenvalue);
    tcase_add_test(t, none_and_a_tie);
    tcase_add_test(t, symmetries_of_a_model);
    tcase_add_test(t, balls);
    suite_add_tcase(s, t);
    return s;
}
