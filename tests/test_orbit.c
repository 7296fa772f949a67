/* Periodic orbits against closed forms: pendulums whose energy is held, whose periods are
 * arithmetic-geometric means; motions around a circle with multipliers that can be written down, in all ways
 * in which a multiplier can cross the unit circle; and the published period of van der Pol's equation. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cns/study/orbit.h"
#include "num/decimal_text.h"
#include "problem.h"
#include "study/orbit/image.h"

enum { BITS = 400, PLACES = 40 };

/* A model of this file: states of scale 1, one parameter p. */
static const cns_model_state states[] = {{"x", "", 1}, {"y", "", 1}, {"u", "", 1}, {"v", "", 1}};
static const cns_model_parameter parameters[] = {{"p", "", NULL, NULL}};

static cns_model model_of(int n, void (*build)(cns_program *p, const cns_model *model))
{
    return (cns_model){.name = "test",
                       .title = "test",
                       .n_states = n,
                       .n_parameters = 1,
                       .states = states,
                       .parameters = parameters,
                       .build = build};
}

static cns_orbit_spec guess(const char *period, long decimals)
{
    cns_orbit_spec spec = {.decimals = decimals, .section = -1};
    cns_error err;
    cns_number_init(&spec.period);
    check_ok(cns_number_parse(&spec.period, period, &err), &err);
    return spec;
}

/* The orbit near a guess, to so many decimals. */
static cns_orbit *orbit(const cns_model *m, const cns_setting *settings, const char *period)
{
    cns_system *s = system_new(m, settings);
    cns_orbit_spec spec = guess(period, PLACES);
    cns_orbit *o;
    cns_error err;
    check_ok(cns_orbit_find(s, &spec, NULL, &o, &err), &err);
    ck_assert_int_eq(o->decimals, PLACES);
    cns_number_clear(&spec.period);
    cns_system_free(s);
    return o;
}

static void check_text(const char *text, const mpfr_t x, const char *what)
{
    char *right = cns_text_mpfr(x, CNS_PLACES_DECIMALS, PLACES);
    ck_assert_msg(!strcmp(text, right), "%s: %s is not %s", what, text, right);
    free(right);
}

/* A pendulum of energy H = y^2/2 - cos x, and a force that brings H to p:
 * x' = y - (H - p) sin x, y' = -sin x - (H - p) y. On H = p it is the free pendulum. */
static void pendulum(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node x = cns_state(p, 0), y = cns_state(p, 1), sin_x, cos_x;
    cns_sincos(p, x, &sin_x, &cos_x);
    cns_node energy = cns_sub(p, cns_mul(p, cns_constant(p, "1/2"), cns_sqr(p, y)), cos_x);
    cns_node off = cns_sub(p, energy, cns_parameter(p, 0));
    cns_derivative(p, 0, cns_sub(p, y, cns_mul(p, off, sin_x)));
    cns_derivative(p, 1, cns_neg(p, cns_add(p, sin_x, cns_mul(p, off, y))));
}

/* y = c pi / agm(1, sqrt(k)). */
static void period_of_pendulum(mpfr_t y, const char *c, const char *k)
{
    mpfr_t x;
    mpfr_init2(x, BITS);
    mpfr_set_ui(y, 1, MPFR_RNDN);
    mpq_t q;
    mpq_init(q);
    mpq_set_str(q, k, 10);
    mpfr_set_q(x, q, MPFR_RNDN);
    mpfr_sqrt(x, x, MPFR_RNDN);
    mpfr_agm(x, x, y, MPFR_RNDN);
    mpfr_const_pi(y, MPFR_RNDN);
    mpq_set_str(q, c, 10);
    mpfr_mul_q(y, y, q, MPFR_RNDN);
    mpfr_div(y, y, x, MPFR_RNDN);
    mpq_clear(q);
    mpfr_clear(x);
}

/* Up to 90 degrees: 2 pi / agm(1, cos 45 degrees), and half of it makes it its own image. */
START_TEST(swinging)
{
    static const signed char minus[2] = {-1, -1};
    static const char *const nowhere[2] = {NULL, NULL};
    static const cns_model_symmetry both[] = {{"mirror", minus, nowhere}};
    static const cns_setting at[] = {{"p", "0"}, {"x", "0"}, {"y", "1.4"}, {NULL, NULL}};
    mpfr_t x;
    mpfr_init2(x, BITS);
    for (int declared = 0; declared < 2; declared++) {
        cns_model m = model_of(2, pendulum);
        m.symmetries = both;
        m.n_symmetries = declared;
        cns_orbit *o = orbit(&m, at, "7.4");
        period_of_pendulum(x, "2", "1/2");
        check_text(o->period, x, "period");
        mpfr_sqrt_ui(x, 2, MPFR_RNDN);
        check_text(o->state[1], x, "y");
        ck_assert_int_eq(o->repetitions, declared ? 2 : 1);
        ck_assert_str_eq(o->symmetry, declared ? "mirror" : "");
        ck_assert_str_eq(o->stability, "stable");
        cns_orbit_free(o);
    }
    mpfr_clear(x);
}
END_TEST

/* Over the top, where the angle goes round: 4 K / sqrt(6), K = pi / 2 agm(1, sqrt(1/3)), for p = 2. */
START_TEST(going_round)
{
    static const signed char plus[2] = {1, 1};
    static const cns_model_motion motion = {
        .angle = 0, .rate = 1, .turns = 1, .height = -1, .turn_sign = plus};
    static const cns_setting at[] = {{"p", "2"}, {"x", "0"}, {"y", "-2.4"}, {NULL, NULL}};
    mpfr_t x;
    mpfr_init2(x, BITS);
    cns_model m = model_of(2, pendulum);
    m.motion = &motion;
    cns_orbit *o = orbit(&m, at, "3.3");
    period_of_pendulum(x, "2", "1/3");
    mpfr_t root;
    mpfr_init2(root, BITS);
    mpfr_sqrt_ui(root, 6, MPFR_RNDN);
    mpfr_div(x, x, root, MPFR_RNDN);
    check_text(o->period, x, "period");
    mpfr_neg(root, root, MPFR_RNDN);
    check_text(o->state[1], root, "y");
    ck_assert_int_eq(o->winding, -1);
    ck_assert_int_eq(o->repetitions, 1);
    cns_orbit_free(o);
    mpfr_clears(x, root, (mpfr_ptr)0);
}
END_TEST

/* x' = y, y' = (1 - x^2) y - x: published to more digits than these. */
static void van_der_pol(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node x = cns_state(p, 0), y = cns_state(p, 1);
    cns_derivative(p, 0, y);
    cns_node damping = cns_mul(p, cns_sub(p, cns_constant(p, "1"), cns_sqr(p, x)), y);
    cns_derivative(p, 1, cns_sub(p, damping, x));
}

START_TEST(van_der_pols)
{
    static const cns_setting near[] = {{"p", "0"}, {"x", "2"}, {"y", "0"}, {NULL, NULL}};
    const cns_model m = model_of(2, van_der_pol);
    cns_orbit *o = orbit(&m, near, "6.6");
    mpfr_t x;
    mpfr_init2(x, BITS);
    mpfr_set_str(x, "6.66328685932313018969968203048232870681264631688387665", 10, MPFR_RNDN);
    check_text(o->period, x, "period");
    cns_orbit_free(o);
    mpfr_clear(x);
}
END_TEST

/* x' = x g - y, y' = y g + x: a circle of radius r, where g(r^2) = 0, in 2 pi, with the multiplier
 * exp(4 pi r^2 g'(r^2)). */
static void around(cns_program *p, cns_node g)
{
    cns_node x = cns_state(p, 0), y = cns_state(p, 1);
    cns_derivative(p, 0, cns_sub(p, cns_mul(p, x, g), y));
    cns_derivative(p, 1, cns_add(p, cns_mul(p, y, g), x));
}

static cns_node radius2(cns_program *p)
{
    return cns_add(p, cns_sqr(p, cns_state(p, 0)), cns_sqr(p, cns_state(p, 1)));
}

/* g = 1 - r^2: the circle of radius 1. */
static void around_unit_circle(cns_program *p)
{
    around(p, cns_sub(p, cns_constant(p, "1"), radius2(p)));
}

/* Two circles, r^2 = 1 +- sqrt(-p), that meet at p = 0. */
static void fold(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node off = cns_sub(p, radius2(p), cns_constant(p, "1"));
    around(p, cns_neg(p, cns_add(p, cns_parameter(p, 0), cns_sqr(p, off))));
}

/* (u, v) turned with half the angle of (x, y), in which frame they grow by p and fall by 1/2:
 * multipliers -exp(2 pi p) and -exp(-pi). */
static void doubling(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node x = cns_state(p, 0), y = cns_state(p, 1), u = cns_state(p, 2), v = cns_state(p, 3);
    cns_node half = cns_constant(p, "1/2");
    cns_node mean = cns_mul(p, half, cns_sub(p, cns_parameter(p, 0), half)),
             part = cns_mul(p, half, cns_add(p, cns_parameter(p, 0), half));
    around_unit_circle(p);
    cns_node cosine = cns_mul(p, part, x), sine = cns_mul(p, part, y);
    cns_derivative(
        p, 2, cns_add(p, cns_mul(p, cns_add(p, mean, cosine), u), cns_mul(p, cns_sub(p, sine, half), v)));
    cns_derivative(
        p, 3, cns_add(p, cns_mul(p, cns_add(p, sine, half), u), cns_mul(p, cns_sub(p, mean, cosine), v)));
}

/* u + i v grows by p + 0.3 i. */
static void spiral(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node u = cns_state(p, 2), v = cns_state(p, 3), a = cns_parameter(p, 0), b = cns_constant(p, "0.3");
    around_unit_circle(p);
    cns_derivative(p, 2, cns_sub(p, cns_mul(p, a, u), cns_mul(p, b, v)));
    cns_derivative(p, 3, cns_add(p, cns_mul(p, b, u), cns_mul(p, a, v)));
}

/* u' = p u - u^3, v' = -v / 2: u = 0 is a branch, others cross it at p = 0. */
static void pitchfork(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node u = cns_state(p, 2), cube = cns_mul(p, cns_sqr(p, u), u);
    around_unit_circle(p);
    cns_derivative(p, 2, cns_sub(p, cns_mul(p, cns_parameter(p, 0), u), cube));
    cns_derivative(p, 3, cns_mul(p, cns_constant(p, "-1/2"), cns_state(p, 3)));
}

/* y = sign exp(2 pi a). */
static void grown(mpfr_t y, int sign, double a)
{
    mpfr_const_pi(y, MPFR_RNDN);
    mpfr_mul_d(y, y, 2 * a, MPFR_RNDN); /* the a of the tests are exact */
    mpfr_exp(y, y, MPFR_RNDN);
    mpfr_mul_si(y, y, sign, MPFR_RNDN);
}

/* The branch p = -1/16, -1/64, 1/32, which passes 0. */
static cns_branch *branch(const cns_model *m, const char *radius, cns_code wanted)
{
    const cns_setting at[] = {{"p", "-1/16"}, {"x", radius}, {NULL, NULL}};
    cns_system *s = system_new(m, at);
    cns_orbit_spec spec = guess("6.28", PLACES);
    cns_sweep sweep;
    cns_branch *b;
    cns_error err = {0};
    check_ok(cns_sweep_parse(&sweep, m, "p=-1/16:1/32:3/64", &err), &err);
    const cns_code code = cns_orbit_follow(s, &spec, &sweep, NULL, &b, &err);
    ck_assert_msg(code == wanted, "%d: %s", (int)code, err.text);
    cns_sweep_clear(&sweep);
    cns_number_clear(&spec.period);
    cns_system_free(s);
    return b;
}

/* Point i of a branch is a crossing at 0. */
static const cns_orbit *crossing(const cns_branch *b, int i, cns_crossing kind)
{
    mpfr_t zero;
    mpfr_init2(zero, BITS);
    mpfr_set_zero(zero, 1);
    ck_assert_int_gt(b->n, i);
    ck_assert_str_eq(cns_crossing_name(b->point[i].crossing), cns_crossing_name(kind));
    check_text(b->point[i].parameter, zero, "parameter");
    for (int k = 0; k < b->n; k++)
        ck_assert(k == i || b->point[k].crossing == CNS_CROSSING_NONE);
    mpfr_clear(zero);
    return b->point[i].orbit;
}

START_TEST(a_doubling)
{
    const cns_model m = model_of(4, doubling);
    cns_branch *b = branch(&m, "0.9", CNS_OK);
    mpfr_t x;
    mpfr_init2(x, BITS);
    ck_assert_int_eq(b->n, 4);
    const cns_orbit *first = b->point[0].orbit, *at = crossing(b, 2, CNS_CROSSING_DOUBLING),
                    *last = b->point[3].orbit;
    mpfr_const_pi(x, MPFR_RNDN);
    mpfr_mul_ui(x, x, 2, MPFR_RNDN);
    check_text(first->period, x, "period");
    grown(x, -1, -0.0625);
    check_text(first->multiplier[0].re, x, "multiplier");
    grown(x, -1, -0.5);
    check_text(first->multiplier[1].re, x, "second multiplier");
    grown(x, 1, -2);
    check_text(first->multiplier[2].re, x, "multiplier of the circle");
    grown(x, -1, 0.03125);
    check_text(last->multiplier[0].re, x, "last multiplier");
    mpfr_set_si(x, -1, MPFR_RNDN);
    check_text(at->multiplier[0].re, x, "multiplier at the doubling");
    ck_assert_str_eq(first->stability, "stable");
    ck_assert_str_eq(at->stability, "not hyperbolic");
    ck_assert_int_eq(last->unstable, 1);
    cns_branch_free(b);
    mpfr_clear(x);
}
END_TEST

START_TEST(a_torus)
{
    const cns_model m = model_of(4, spiral);
    cns_branch *b = branch(&m, "0.9", CNS_OK);
    mpfr_t x, angle;
    mpfr_inits2(BITS, x, angle, (mpfr_ptr)0);
    ck_assert_int_eq(b->n, 4);
    const cns_orbit *at = crossing(b, 2, CNS_CROSSING_NEIMARK_SACKER);
    mpfr_const_pi(angle, MPFR_RNDN);
    mpfr_mul_ui(angle, angle, 6, MPFR_RNDN);
    mpfr_div_ui(angle, angle, 10, MPFR_RNDN);
    mpfr_cos(x, angle, MPFR_RNDN);
    check_text(at->multiplier[0].re, x, "real part");
    mpfr_sin(x, angle, MPFR_RNDN);
    check_text(at->multiplier[0].im, x, "imaginary part");
    mpfr_neg(x, x, MPFR_RNDN);
    check_text(at->multiplier[1].im, x, "that of the other");
    ck_assert_int_eq(b->point[3].orbit->unstable, 2);
    cns_branch_free(b);
    mpfr_clears(x, angle, (mpfr_ptr)0);
}
END_TEST

START_TEST(a_branch_point)
{
    const cns_model m = model_of(4, pitchfork);
    cns_branch *b = branch(&m, "0.9", CNS_OK);
    ck_assert_int_eq(b->n, 4);
    crossing(b, 2, CNS_CROSSING_BRANCH_POINT);
    cns_branch_free(b);
}
END_TEST

/* The outer circle, which attracts; the branch ends where the two meet, at the radius 1. */
START_TEST(a_fold)
{
    const cns_model m = model_of(2, fold);
    cns_branch *b = branch(&m, "1.1", CNS_UNREACHED);
    mpfr_t x;
    mpfr_init2(x, BITS);
    ck_assert_int_eq(b->n, 4);
    ck_assert(b->point[3].orbit == NULL && strstr(b->point[3].note, "turns back") != NULL);
    const cns_orbit *first = b->point[0].orbit, *at = crossing(b, 2, CNS_CROSSING_FOLD);
    mpfr_set_d(x, 1.25, MPFR_RNDN);
    mpfr_sqrt(x, x, MPFR_RNDN);
    check_text(first->state[0], x, "radius");
    grown(x, 1, -4 * 0.25 * 1.25);
    check_text(first->multiplier[0].re, x, "multiplier");
    mpfr_set_ui(x, 1, MPFR_RNDN);
    check_text(at->state[0], x, "radius at the fold");
    check_text(at->multiplier[0].re, x, "multiplier at the fold");
    cns_branch_free(b);
    mpfr_clear(x);
}
END_TEST

/* A family of orbits has none that is alone; a fixed point is no orbit; a wrong guess leads nowhere. */
static void oscillator(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_derivative(p, 0, cns_state(p, 1));
    cns_derivative(p, 1, cns_neg(p, cns_state(p, 0)));
}

static void check_failure(const cns_model *m, const cns_setting *at, const char *period, const char *says)
{
    cns_system *s = system_new(m, at);
    cns_orbit_spec spec = guess(period, 10);
    cns_orbit *o;
    cns_error err = {0};
    ck_assert_int_eq(cns_orbit_find(s, &spec, NULL, &o, &err), CNS_NUMERIC);
    ck_assert_ptr_null(o);
    ck_assert_msg(strstr(err.text, says) != NULL, "%s", err.text);
    cns_number_clear(&spec.period);
    cns_system_free(s);
}

START_TEST(what_is_no_orbit)
{
    static const cns_setting out[] = {{"p", "0"}, {"x", "1"}, {"y", "0"}, {NULL, NULL}};
    static const cns_setting rest[] = {{"p", "0"}, {"x", "1e-9"}, {"y", "0"}, {NULL, NULL}};
    cns_model m = model_of(2, oscillator);
    check_failure(&m, out, "6.28", "not isolated");
    m = model_of(2, van_der_pol);
    check_failure(&m, rest, "1", "orbit");
}
END_TEST

static const cns_image *named(const cns_images *s, const char *name)
{
    for (int i = 0; i < s->n; i++)
        if (!strcmp(s->item[i].name, name))
            return &s->item[i];
    ck_abort_msg("no image %s", name);
}

/* Those of the disk: itself, the half-turn, the mirror image, and both. */
START_TEST(images)
{
    cns_images s;
    long winding;
    cns_images_open(&s, cns_model_find("apw"));
    ck_assert_int_eq(s.n, 4);
    ck_assert_int_eq(cns_image_order(&s, named(&s, "half-turn"), 1, &winding), 2);
    ck_assert_int_eq(winding, 1);
    ck_assert_int_eq(cns_image_order(&s, named(&s, "half-turn"), -3, &winding), 2);
    ck_assert_int_eq(winding, -3);
    ck_assert_int_eq(cns_image_order(&s, named(&s, "mirror"), 2, &winding), 2);
    ck_assert_int_eq(winding, 0);
    ck_assert_int_eq(cns_image_order(&s, named(&s, ""), 2, &winding), 1);
    ck_assert_int_eq(winding, 1);
    cns_images_close(&s);
}
END_TEST

Suite *suite_orbit(void)
{
    Suite *s = suite_create("orbit");
    TCase *t = tcase_create("closed forms");
    tcase_add_test(t, swinging);
    tcase_add_test(t, going_round);
    tcase_add_test(t, van_der_pols);
    suite_add_tcase(s, t);
    t = tcase_create("crossings");
    tcase_add_test(t, a_doubling);
    tcase_add_test(t, a_torus);
    tcase_add_test(t, a_branch_point);
    tcase_add_test(t, a_fold);
    suite_add_tcase(s, t);
    t = tcase_create("the rest");
    tcase_add_test(t, what_is_no_orbit);
    tcase_add_test(t, images);
    suite_add_tcase(s, t);
    return s;
}
