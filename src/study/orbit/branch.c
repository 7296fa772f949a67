#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "core/memory.h"
#include "core/monitor.h"
#include "num/ball_text.h"
#include "num/logs.h"
#include "num/vector.h"
#include "orbit.h"
#include "study/modes/returns.h"

enum {
    DIGITS = CNS_ORBIT_FIRST_DIGITS,
    HALVINGS = 8,    /* of the sweep's step, before the branch is taken to end */
    AROUND = 60,     /* steps around a fold, at most */
    SECANTS = 60,    /* towards a crossing */
    ROUGH_BITS = 30, /* of its place along the chord, before more digits are used */
    CLEAR_LOG2 = -8, /* the noise times the norm of the inverse, for Kantorovich's condition */
    JOINED = 3,      /* parts of a period, at most, after which an orbit repeats that a branch runs into */
    TESTS = 3
};

static const double jump = 0.2; /* in scales: what the next orbit may differ from what was expected of it */

const char *cns_crossing_name(cns_crossing crossing)
{
    static const char *const names[] = {
        "", "fold", "branch point", "doubling", "symmetry breaking", "Neimark-Sacker"};
    return names[crossing];
}

/* Functions that vanish where a multiplier crosses: at -1, at 1, and the product of 1 - mu_i mu_j, i < j. */
typedef enum test { AT_MINUS_ONE, AT_ONE, PAIR } test;

/* A point of the branch, in the first digits. */
typedef struct node {
    mpfr_t *u;
    double test[TESTS];
} node;

typedef struct follower {
    cns_loop l;
    const cns_orbit_spec *spec;
    const cns_monitor *monitor;
    cns_branch *b;
    node before, last; /* the last two nodes; before.u NULL: there is one only */
    cns_error missing; /* code not 0: some of what was asked for is not there */
} follower;

static mpfr_t *new_u(const cns_loop *l)
{
    return cns_vector_xnew(l->d + 2, cns_digits_to_bits(DIGITS));
}

static void copy_u(const cns_loop *l, mpfr_t *to, const mpfr_t *from)
{
    for (int k = 0; k < l->d + 2; k++)
        mpfr_set(to[k], from[k], MPFR_RNDN);
}

/* A test function at a corrected point. */
static cns_code test_value(const cns_loop *l, const cns_corrected *c, test which, mpfr_t y, cns_error *err)
{
    const int n = l->d - 1;
    const slong prec = (slong)c->shooting.prec + 64;
    arb_mat_t p;
    arb_t x;
    arb_init(x);
    arb_mat_init(p, n, n);
    cns_code code = cns_return_matrix(l, c, NULL, p, err);
    if (!code && which != PAIR) {
        for (int i = 0; i < n; i++)
            arb_add_si(arb_mat_entry(p, i, i), arb_mat_entry(p, i, i), which == AT_ONE ? -1 : 1, prec);
        arb_mat_det(x, p, prec);
    } else if (!code) {
        acb_mat_t a;
        acb_ptr mu = _acb_vec_init(n);
        acb_t product, term;
        acb_init(product);
        acb_init(term);
        acb_mat_init(a, n, n);
        acb_mat_set_arb_mat(a, p);
        acb_mat_get_mid(a, a);
        acb_mat_approx_eig_qr(mu, NULL, NULL, a, NULL, 0, prec);
        acb_one(product);
        for (int i = 0; i < n; i++)
            for (int j = 0; j < i; j++) {
                acb_mul(term, mu + i, mu + j, prec);
                acb_sub_si(term, term, 1, prec);
                acb_mul(product, product, term, prec);
            }
        arb_set(x, acb_realref(product));
        acb_clear(product);
        acb_clear(term);
        acb_mat_clear(a);
        _acb_vec_clear(mu, n);
    }
    arf_get_mpfr(y, arb_midref(x), MPFR_RNDN);
    arb_clear(x);
    arb_mat_clear(p);
    return code;
}

static cns_code to_node(const cns_loop *l, const cns_corrected *c, node *to, cns_error *err)
{
    cns_code code = CNS_OK;
    mpfr_t y;
    mpfr_init2(y, 64);
    copy_u(l, to->u, (const mpfr_t *)c->u);
    for (int t = 0; t < TESTS && !code; t++) {
        code = test_value(l, c, (test)t, y, err);
        to->test[t] = mpfr_get_d(y, MPFR_RNDN);
    }
    mpfr_clear(y);
    return code;
}

/* The largest distance of two points, in scales, the parameter left out. */
static double distance(const cns_loop *l, const mpfr_t *a, const mpfr_t *b)
{
    double gap = 0;
    for (int k = 0; k <= l->d; k++) {
        const double x = mpfr_get_d(a[k], MPFR_RNDN), y = mpfr_get_d(b[k], MPFR_RNDN);
        const double unit = k < l->d ? cns_system_scales(l->system)[l->index[k]] : fabs(y);
        gap = fmax(gap, fabs(x - y) / unit);
    }
    return gap;
}

static void move_on(follower *F, node *next)
{
    mpfr_t *free_u = F->before.u != NULL ? F->before.u : new_u(&F->l);
    F->before = F->last;
    F->last = *next;
    next->u = free_u;
}

/* u at parameter p by the line through the last two nodes. */
static void extrapolate(const follower *F, mpfr_srcptr p, mpfr_t *u)
{
    const int d = F->l.d;
    mpfr_t s, x;
    copy_u(&F->l, u, (const mpfr_t *)F->last.u);
    mpfr_inits2(64, s, x, (mpfr_ptr)0);
    if (F->before.u != NULL) {
        mpfr_sub(x, F->last.u[d + 1], F->before.u[d + 1], MPFR_RNDN);
        mpfr_sub(s, p, F->last.u[d + 1], MPFR_RNDN);
        mpfr_div(s, s, x, MPFR_RNDN);
        for (int k = 0; k <= d && mpfr_number_p(s); k++) {
            mpfr_sub(x, F->last.u[k], F->before.u[k], MPFR_RNDN);
            mpfr_fma(u[k], x, s, u[k], MPFR_RNDN);
        }
    }
    mpfr_set(u[d + 1], p, MPFR_RNDN);
    mpfr_clears(s, x, (mpfr_ptr)0);
}

/* Crossings. */

/* A place between two nodes where a test function vanishes. */
typedef struct place {
    test which;
    const mpfr_t *from, *to; /* the chord */
    mpfr_t a, b;             /* s at two places near it */
} place;

/* The test function at s on the chord; c is to be closed. */
static cns_code at_chord(const cns_loop *l, const place *x, long digits, bool fine, mpfr_srcptr s,
                         const mpfr_t *near, cns_corrected *c, mpfr_t y, cns_error *err)
{
    const cns_chord chord = {.from = x->from, .to = x->to, .s = s};
    const mpfr_prec_t prec = cns_digits_to_bits(digits);
    mpfr_t *u = cns_vector_xnew(l->d + 2, prec);
    for (int k = 0; k < l->d + 2; k++) {
        if (near != NULL) {
            mpfr_set(u[k], near[k], MPFR_RNDN);
            continue;
        }
        mpfr_sub(u[k], x->to[k], x->from[k], MPFR_RNDN);
        mpfr_mul(u[k], u[k], s, MPFR_RNDN);
        mpfr_add(u[k], u[k], x->from[k], MPFR_RNDN);
    }
    cns_code code = cns_correct(l, digits, fine, &chord, (const mpfr_t *)u, c, err);
    if (!code)
        code = test_value(l, c, x->which, y, err);
    cns_vector_free(u);
    return code;
}

/* The zero by regula falsi (the Illinois variant: M. Dowell, P. Jarratt, BIT 11 (1971) 168), in the first
 * digits. a and b come together around it. */
static cns_code bracket(const cns_loop *l, place *x, double ya, double yb, cns_error *err)
{
    mpfr_t s, y;
    int side = 0;
    cns_code code = CNS_OK;
    mpfr_inits2(cns_digits_to_bits(DIGITS), s, y, (mpfr_ptr)0);
    for (int turn = 0; turn < SECANTS && !code; turn++) {
        const double a = mpfr_get_d(x->a, MPFR_RNDN), b = mpfr_get_d(x->b, MPFR_RNDN);
        cns_corrected c;
        if (fabs(b - a) < ldexp(1, -ROUGH_BITS))
            break;
        double middle = (a * yb - b * ya) / (yb - ya);
        if (turn % 8 == 7)
            middle = 0.5 * (a + b);
        mpfr_set_d(s, middle, MPFR_RNDN);
        code = at_chord(l, x, DIGITS, false, s, NULL, &c, y, err);
        cns_corrected_close(&c);
        const double ys = mpfr_get_d(y, MPFR_RNDN);
        if (code || ys == 0)
            break;
        if ((ys < 0) == (yb < 0)) {
            ya = side == 1 ? ya / 2 : ya;
            yb = ys;
            side = 1;
            const bool small = fabs(middle - b) < ldexp(1, -ROUGH_BITS);
            mpfr_set(x->b, s, MPFR_RNDN);
            if (small)
                break;
        } else {
            yb = side == -1 ? yb / 2 : yb;
            ya = ys;
            side = -1;
            const bool small = fabs(middle - a) < ldexp(1, -ROUGH_BITS);
            mpfr_set(x->a, s, MPFR_RNDN);
            if (small)
                break;
        }
    }
    if (side < 0) /* b is the better one */
        mpfr_swap(x->a, x->b);
    mpfr_sub(s, x->b, x->a, MPFR_RNDN);
    if (cns_log2_mpfr(s) > -ROUGH_BITS / 2 || mpfr_zero_p(s)) {
        mpfr_set_d(s, ldexp(1, -ROUGH_BITS), MPFR_RNDN);
        mpfr_sub(x->a, x->b, s, MPFR_RNDN);
    }
    mpfr_clears(s, y, (mpfr_ptr)0);
    return code;
}

/* The orbit at the zero, by secants with so many digits: a solver of cns_orbit_prove(). What is left of the
 * way is an error like the noise. Where branches meet the noise grows on the way there, and the best place is
 * one before. */
static cns_code solve_place(void *context, const cns_loop *l, long digits, bool fine, const mpfr_t *near,
                            cns_corrected *c, cns_error *err)
{
    const place *x = context;
    const mpfr_prec_t prec = cns_digits_to_bits(digits);
    mpfr_t s[2], y0, y1, t; /* the last two places, and what the test function is there */
    double error = HUGE_VAL, change = -HUGE_VAL;
    mpfr_t *u = NULL;
    bool done = false;
    (void)near; /* the two solutions have nothing in common but the chord */
    mpfr_inits2(prec, s[0], s[1], y0, y1, t, (mpfr_ptr)0);
    mpfr_set(s[0], x->a, MPFR_RNDN);
    mpfr_set(s[1], x->b, MPFR_RNDN);
    cns_code code = at_chord(l, x, digits, fine, s[0], NULL, c, y0, err);
    for (int turn = 0; turn < SECANTS && !code && !done; turn++) {
        cns_vector_free(u);
        u = c->u;
        c->u = NULL;
        cns_corrected_close(c);
        code = at_chord(l, x, digits, fine, s[1], (const mpfr_t *)u, c, y1, err);
        if (code)
            break;
        mpfr_sub(t, s[1], s[0], MPFR_RNDN);
        mpfr_mul(t, t, y1, MPFR_RNDN);
        mpfr_sub(y0, y1, y0, MPFR_RNDN);
        mpfr_div(t, t, y0, MPFR_RNDN); /* the step that is left, to be subtracted */
        const double step = mpfr_number_p(t) ? cns_log2_mpfr(t) : HUGE_VAL;
        const double left = fmax(step, c->noise_log2);
        const bool too_near = left > error || c->inverse_log2 + c->noise_log2 > CLEAR_LOG2;
        change = fmax(change, c->change_log2);
        if (too_near) {
            cns_corrected_close(c);
            code = at_chord(l, x, digits, fine, s[0], (const mpfr_t *)u, c, y1, err);
        }
        done = too_near || step <= c->noise_log2;
        error = too_near ? error : left;
        mpfr_set(s[0], s[1], MPFR_RNDN);
        mpfr_set(y0, y1, MPFR_RNDN);
        mpfr_sub(s[1], s[1], t, MPFR_RNDN);
    }
    c->noise_log2 = fmax(c->noise_log2, error);
    c->change_log2 = fmax(c->change_log2, change);
    cns_vector_free(u);
    mpfr_clears(s[0], s[1], y0, y1, t, (mpfr_ptr)0);
    return code || done ? code : cns_fail(err, CNS_NUMERIC, "the crossing could not be located");
}

/* Takes the texts and the orbit. */
static void add_point(follower *F, cns_branch_point point)
{
    cns_branch *b = F->b;
    b->point = cns_xgrow(b->point, (size_t)b->n + 1, sizeof *b->point);
    b->point[b->n++] = point;
}

/* Does the branch turn back at parameter p between two nodes? Then it goes beyond both. */
static bool turns_at(const cns_loop *l, const node *a, const node *b, const char *p)
{
    mpfr_t x;
    mpfr_init2(x, cns_digits_to_bits(DIGITS));
    mpfr_set_str(x, p, 10, MPFR_RNDN);
    const int before = mpfr_cmp(x, a->u[l->d + 1]), after = mpfr_cmp(b->u[l->d + 1], x);
    mpfr_clear(x);
    return (before < 0) != (after < 0);
}

/* What the zero of a test function at parameter p, between two nodes, is the sign of. */
static cns_crossing name_of(const cns_loop *l, test which, const node *a, const node *b, const char *p)
{
    long winding;
    const int order = cns_image_order(&l->images, &l->images.item[l->image], l->turns, &winding);
    if (which == AT_ONE)
        return turns_at(l, a, b, p) ? CNS_CROSSING_FOLD : CNS_CROSSING_BRANCH_POINT;
    if (which == AT_MINUS_ONE)
        return order % 2 == 0 ? CNS_CROSSING_SYMMETRY : CNS_CROSSING_DOUBLING;
    return CNS_CROSSING_NEIMARK_SACKER;
}

/* Are some multipliers at a crossing of PAIR a complex pair on the unit circle? Two real ones whose product
 * is 1 are none. */
static bool is_complex_pair(const cns_orbit *o)
{
    for (int k = 0; k + 1 < o->d - 1; k++) {
        const double re = strtod(o->repetition[k].re, NULL), im = strtod(o->repetition[k].im, NULL);
        if (im != 0 && fabs(hypot(re, im) - 1) < 1e-3)
            return true;
    }
    return false;
}

static cns_code locate(follower *F, const node *a, const node *b, test which, cns_error *err)
{
    place x = {.which = which, .from = (const mpfr_t *)a->u, .to = (const mpfr_t *)b->u};
    cns_orbit *o = NULL;
    char what[96];
    snprintf(what, sizeof what, "locating a crossing near %.10g", mpfr_get_d(a->u[F->l.d + 1], MPFR_RNDN));
    cns_monitor_tell(F->monitor, 0.5, what);
    mpfr_inits2(cns_digits_to_bits(DIGITS), x.a, x.b, (mpfr_ptr)0);
    mpfr_set_ui(x.a, 0, MPFR_RNDN);
    mpfr_set_ui(x.b, 1, MPFR_RNDN);
    cns_code code = bracket(&F->l, &x, a->test[which], b->test[which], err);
    if (!code)
        code = cns_orbit_prove(&F->l, &(cns_orbit_solver){solve_place, &x}, F->spec->decimals, &o, err);
    if (o != NULL && which == PAIR && !is_complex_pair(o)) {
        cns_orbit_free(o);
        o = NULL;
        code = CNS_OK;
    }
    if (o != NULL)
        add_point(F, (cns_branch_point){.parameter = cns_xcopy(o->parameter),
                                        .crossing = name_of(&F->l, which, a, b, o->parameter),
                                        .orbit = o});
    mpfr_clears(x.a, x.b, (mpfr_ptr)0);
    return code;
}

/* All crossings between two nodes. */
static cns_code locate_all(follower *F, const node *a, const node *b, cns_error *err)
{
    cns_code code = CNS_OK;
    for (int t = 0; t < TESTS && !code; t++)
        if ((a->test[t] < 0) != (b->test[t] < 0))
            code = locate(F, a, b, (test)t, err);
    return code;
}

/* Along the branch. */

/* The next node, at p; *reached false: there is none so far off. */
static cns_code step_to(follower *F, mpfr_srcptr p, node *next, bool *reached, cns_error *err)
{
    cns_corrected c;
    mpfr_t *u = new_u(&F->l);
    cns_error why;
    extrapolate(F, p, u);
    cns_code code = cns_correct(&F->l, DIGITS, false, NULL, (const mpfr_t *)u, &c, &why);
    *reached = !code && distance(&F->l, (const mpfr_t *)c.u, (const mpfr_t *)u) < jump;
    if (*reached)
        code = to_node(&F->l, &c, next, &why);
    cns_corrected_close(&c);
    cns_vector_free(u);
    if (code == CNS_UNREACHED || code == CNS_NUMERIC) {
        *reached = false;
        code = CNS_OK;
    }
    return code ? cns_fail(err, code, "%s", why.text) : CNS_OK;
}

/* The system at p, for what does not vary. */
static cns_code at_parameter(follower *F, const cns_number *p, cns_loop *still, cns_system **s,
                             cns_error *err)
{
    *s = cns_system_with(F->l.system, F->l.parameter, p, err);
    *still = F->l;
    still->system = *s;
    still->parameter = -1;
    return *s != NULL ? CNS_OK : err->code;
}

/* Beyond the last node the parameter cannot go on: along the curve, until a multiplier has passed 1. *passed
 * false: that was not found. */
static cns_code along_curve(follower *F, bool *passed, cns_error *err)
{
    node next = {.u = new_u(&F->l)};
    double length = 1; /* of the next step, in that of the last one */
    cns_code code = CNS_OK;
    *passed = false;
    for (int turn = 0; turn < AROUND && !code && !*passed && F->before.u != NULL; turn++) {
        cns_corrected c;
        cns_error why;
        mpfr_t s, y;
        mpfr_inits2(64, s, y, (mpfr_ptr)0);
        mpfr_set_d(s, 1 + length, MPFR_RNDN);
        const place x = {
            .which = AT_ONE, .from = (const mpfr_t *)F->before.u, .to = (const mpfr_t *)F->last.u};
        code = at_chord(&F->l, &x, DIGITS, false, s, NULL, &c, y, &why);
        const bool good = !code && distance(&F->l, (const mpfr_t *)c.u, x.to) < jump;
        if (good)
            code = to_node(&F->l, &c, &next, &why);
        cns_corrected_close(&c);
        mpfr_clears(s, y, (mpfr_ptr)0);
        if (code == CNS_UNREACHED || code == CNS_NUMERIC)
            code = CNS_OK;
        else if (code)
            cns_fail(err, code, "%s", why.text);
        if (good && !code) {
            *passed = (next.test[AT_ONE] < 0) != (F->last.test[AT_ONE] < 0);
            code = locate_all(F, &F->last, &next, err);
            move_on(F, &next);
        }
        length = good ? 1.5 : length / 2;
    }
    cns_vector_free(next.u);
    return code;
}

/* From the last node to parameter p, by as many steps as it takes. */
static cns_code advance(follower *F, const cns_number *p, bool *arrived, cns_error *err)
{
    mpfr_t to, step;
    node next = {.u = new_u(&F->l)};
    cns_code code = CNS_OK;
    int halved = 0;
    *arrived = false;
    mpfr_inits2(cns_digits_to_bits(DIGITS), to, step, (mpfr_ptr)0);
    while (!code && !*arrived && halved <= HALVINGS) {
        bool reached = false;
        cns_number_get_mpfr(to, p);
        mpfr_sub(step, to, F->last.u[F->l.d + 1], MPFR_RNDN);
        mpfr_div_2ui(step, step, (unsigned long)halved, MPFR_RNDN);
        if (halved > 0)
            mpfr_add(to, F->last.u[F->l.d + 1], step, MPFR_RNDN);
        code = step_to(F, to, &next, &reached, err);
        if (!code && reached) {
            code = locate_all(F, &F->last, &next, err);
            move_on(F, &next);
            *arrived = halved == 0;
            halved = halved > 0 ? halved - 1 : 0;
        } else {
            halved++;
        }
    }
    mpfr_clears(to, step, (mpfr_ptr)0);
    cns_vector_free(next.u);
    return code;
}

/* The branch may have come to an orbit that repeats after a part of the time. Then the part is followed: back
 * to the parameter before, for the two meet in between, and on from there. */
static cns_code join(follower *F, const cns_number *p, const cns_number *before, cns_error *err)
{
    cns_loop still;
    cns_system *s;
    cns_corrected c = {0};
    bool found = false, arrived;
    mpfr_t *u = new_u(&F->l);
    copy_u(&F->l, u, (const mpfr_t *)F->last.u);
    cns_code code = at_parameter(F, p, &still, &s, err);
    if (!code)
        code = cns_orbit_shorten(&still, u, JOINED, &found, err);
    if (!code && found) {
        node here = {.u = u};
        F->l.image = still.image;
        F->l.turns = still.turns;
        cns_vector_free(F->before.u);
        F->before.u = NULL;
        code = cns_correct(&F->l, DIGITS, false, NULL, (const mpfr_t *)u, &c, err);
        if (!code)
            code = to_node(&F->l, &c, &here, err);
        for (int t = 0; t < TESTS; t++)
            F->last.test[t] = here.test[t];
        copy_u(&F->l, F->last.u, (const mpfr_t *)u);
        if (!code)
            code = advance(F, before, &arrived, err);
        cns_vector_free(F->before.u);
        F->before.u = NULL;
        copy_u(&F->l, F->last.u, (const mpfr_t *)u);
        for (int t = 0; t < TESTS; t++)
            F->last.test[t] = here.test[t];
        add_point(F,
                  (cns_branch_point){
                      .parameter = cns_xcopy(p->text),
                      .note = cns_xcopy(
                          "before this value the orbit becomes one that repeats after a part of its time")});
    }
    cns_corrected_close(&c);
    cns_system_free(s);
    cns_vector_free(u);
    return code;
}

/* The row of the last node, which is at p. */
static cns_code add_row(follower *F, const cns_number *p, cns_error *err)
{
    cns_loop still;
    cns_system *s;
    cns_orbit *o = NULL;
    cns_code code = at_parameter(F, p, &still, &s, err);
    if (!code)
        code =
            cns_orbit_prove(&still, &(cns_orbit_solver){cns_orbit_at, F->last.u}, F->spec->decimals, &o, err);
    if (o != NULL)
        add_point(F, (cns_branch_point){.parameter = cns_xcopy(p->text), .orbit = o});
    cns_system_free(s);
    return code;
}

static cns_code begin(follower *F, const cns_number *p, cns_error *err)
{
    cns_corrected c;
    cns_code code = cns_orbit_guess(&F->l, F->spec, F->last.u, F->monitor, err);
    if (!code)
        code = cns_orbit_settle(&F->l, F->last.u, err);
    if (code)
        return code;
    cns_number_get_mpfr(F->last.u[F->l.d + 1], p);
    code = cns_correct(&F->l, DIGITS, false, NULL, (const mpfr_t *)F->last.u, &c, err);
    if (!code)
        code = to_node(&F->l, &c, &F->last, err);
    cns_corrected_close(&c);
    return code;
}

/* The section may be what the branch does not reach beyond: another one, for the last two nodes. */
static cns_code change_section(follower *F, bool *turned, cns_error *err)
{
    cns_number p;
    cns_loop still;
    cns_system *s;
    cns_corrected c = {0};
    cns_number_init(&p);
    cns_number_from_mpfr(&p, F->last.u[F->l.d + 1]);
    cns_code code = at_parameter(F, &p, &still, &s, err);
    if (!code)
        code = cns_orbit_turn(&still, F->last.u, turned, err);
    cns_system_free(s);
    cns_number_clear(&p);
    if (code || !*turned)
        return code;
    F->l.held = still.held; /* its value is shared */
    F->l.held_value = still.held_value;
    node back = F->before;
    bool reached = false;
    F->before.u = NULL;
    if (!code)
        code = cns_correct(&F->l, DIGITS, false, NULL, (const mpfr_t *)F->last.u, &c, err);
    if (!code)
        code = to_node(&F->l, &c, &F->last, err);
    cns_corrected_close(&c);
    if (!code && back.u != NULL) {
        mpfr_t q;
        mpfr_init2(q, cns_digits_to_bits(DIGITS));
        mpfr_set(q, back.u[F->l.d + 1], MPFR_RNDN);
        code = step_to(F, q, &back, &reached, err);
        mpfr_clear(q);
    }
    if (reached)
        F->before = back;
    else
        cns_vector_free(back.u);
    return code;
}

/* Has the branch gone beyond p already? */
static bool is_behind(const follower *F, const cns_number *p, bool upwards)
{
    mpfr_t x;
    mpfr_init2(x, cns_digits_to_bits(DIGITS));
    cns_number_get_mpfr(x, p);
    const int order = mpfr_cmp(x, F->last.u[F->l.d + 1]);
    mpfr_clear(x);
    return upwards ? order < 0 : order > 0;
}

/* What is missing at p, of a branch that goes on. The row may be there, with fewer decimals. */
static void note_missing(follower *F, cns_code *code, const cns_error *err, const cns_number *p)
{
    cns_fail(&F->missing, CNS_UNREACHED, "at %s = %.40s: %.600s",
             cns_system_model(F->l.system)->parameters[F->l.parameter].name, p->text, err->text);
    add_point(F, (cns_branch_point){.parameter = cns_xcopy(p->text), .note = cns_xcopy(err->text)});
    *code = CNS_OK;
}

/* From value `before` to p, and its row. *end: the branch ends before p. */
static cns_code next_value(follower *F, const cns_number *before, const cns_number *p, bool *end,
                           cns_error *err)
{
    const bool upwards = cns_number_cmp(p, before) > 0;
    bool arrived = false, passed = false, turned = false;
    if (is_behind(F, p, upwards))
        return cns_fail(err, CNS_UNREACHED, "no orbit there");
    cns_code code = advance(F, p, &arrived, err);
    if (!code && !arrived)
        code = change_section(F, &turned, err);
    if (!code && turned) {
        add_point(F, (cns_branch_point){.parameter = cns_xcopy(p->text),
                                        .note = cns_xcopy("from here on the orbit begins on another section, "
                                                          "which it crosses better")});
        code = advance(F, p, &arrived, err);
    }
    if (!code && !arrived)
        code = along_curve(F, &passed, err);
    if (!code && !arrived) {
        *end = !passed || F->b->point[F->b->n - 1].crossing == CNS_CROSSING_FOLD;
        return cns_fail(err, CNS_UNREACHED, "%s",
                        !passed ? "no orbit was found near the last one"
                        : *end  ? "the branch turns back before that, in a fold"
                                : "branches meet there");
    }
    return code ? code : join(F, p, before, err);
}

static cns_code follow(follower *F, const cns_sweep *sweep, cns_error *err)
{
    const int n = cns_sweep_count(sweep);
    cns_code code = CNS_OK;
    cns_number p, before;
    bool end = false;
    cns_number_init(&p);
    cns_number_init(&before);
    for (int i = 0; i < n && !code && !end; i++) {
        char what[96];
        cns_sweep_value(sweep, i, &p);
        snprintf(what, sizeof what, "%s = %.40s",
                 cns_system_model(F->l.system)->parameters[sweep->varied].name, p.text);
        cns_monitor_tell(F->monitor, (double)i / n, what);
        code = i == 0 ? begin(F, &p, err) : next_value(F, &before, &p, &end, err);
        if (i == 0 && code == CNS_UNREACHED) /* then there is nothing to follow */
            code = cns_fail(err, CNS_NUMERIC, "at %s: Newton's method finds no orbit near the guess", what);
        F->l.parameter = sweep->varied;
        if (!code)
            code = add_row(F, &p, err);
        if (code == CNS_UNREACHED)
            note_missing(F, &code, err, &p);
        cns_number_set(&before, &p);
    }
    cns_number_clear(&p);
    cns_number_clear(&before);
    if (!code && F->missing.code)
        *err = F->missing;
    return code ? code : F->missing.code;
}

cns_code cns_orbit_follow(const cns_system *s, const cns_orbit_spec *spec, const cns_sweep *sweep,
                          const cns_monitor *monitor, cns_branch **result, cns_error *err)
{
    follower F = {.spec = spec, .monitor = monitor};
    cns_number first;
    *result = F.b = cns_xalloc(1, sizeof *F.b);
    if (sweep->varied >= cns_system_model(s)->n_parameters)
        return cns_fail(err, CNS_USAGE, "an orbit is followed in a parameter, not in %s",
                        cns_sweep_name(sweep, cns_system_model(s)).text);
    cns_number_init(&first);
    cns_sweep_value(sweep, 0, &first);
    cns_system *at = cns_system_with(s, sweep->varied, &first, err);
    cns_code code = at != NULL ? cns_loop_open(&F.l, at, cns_monitor_stop(monitor), err) : err->code;
    if (at != NULL) {
        F.l.parameter_scale = fabs(cns_number_get_d(&sweep->step));
        F.last.u = new_u(&F.l);
        if (!code)
            code = follow(&F, sweep, err);
        cns_vector_free(F.last.u);
        cns_vector_free(F.before.u);
        cns_loop_close(&F.l);
    }
    cns_system_free(at);
    cns_number_clear(&first);
    return code;
}

void cns_branch_free(cns_branch *b)
{
    if (b == NULL)
        return;
    for (int i = 0; i < b->n; i++) {
        free(b->point[i].parameter);
        free(b->point[i].note);
        cns_orbit_free(b->point[i].orbit);
    }
    free(b->point);
    free(b);
}
