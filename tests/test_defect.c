/* The remainders of operations, and defects: what they bound, evaluated in balls of many more bits, from the
 * polynomials as they are stored. Nothing that the recurrences or the rules compute is used to judge them. */
#include <math.h>
#include <stdlib.h>

#include "problem.h"
#include "taylor/ball.h"
#include "taylor/defect_internal.h"
#include "taylor/op/rules.h"

enum { STATES = 3, PREC = 4000, TIMES = 9 };

static cns_node pick(cns_program *p, const cns_node *pool, int n, uint64_t *s)
{
    (void)p;
    return pool[test_random_below(s, (uint64_t)n)];
}

/* A program in which every operation may be, and none is singular. */
static cns_program *random_program(uint64_t *s, const char *smooth)
{
    enum { OPERATIONS = 14, MOST = 64 };
    cns_program *p = program_new(STATES, smooth);
    cns_node pool[MOST];
    int n = 0;
    for (int i = 0; i < STATES; i++)
        pool[n++] = cns_state(p, i);
    const cns_node one = cns_constant(p, "1"), third = cns_constant(p, "1/3");
    for (int i = 0; i < OPERATIONS; i++) {
        const cns_node a = pick(p, pool, n, s), b = pick(p, pool, n, s);
        const cns_node above = cns_add(p, one, cns_mul(p, third, cns_sqr(p, a)));
        cns_node sine, cosine;
        cns_sincos(p, a, &sine, &cosine);
        switch (test_random_below(s, 14)) {
        case 0:
            pool[n++] = cns_add(p, a, b);
            break;
        case 1:
            pool[n++] = cns_sub(p, a, b);
            break;
        case 2:
            pool[n++] = cns_neg(p, cns_mul(p, third, a));
            break;
        case 3:
            pool[n++] = cns_mul(p, sine, b);
            break;
        case 4:
            pool[n++] = cns_sqr(p, sine);
            break;
        case 5:
            pool[n++] = cns_div(p, b, above);
            break;
        case 6:
            pool[n++] = cns_sqrt(p, above);
            break;
        case 7:
            pool[n++] = cns_hypot(p, above, b);
            break;
        case 8:
            pool[n++] = sine;
            pool[n++] = cosine;
            break;
        case 9:
            pool[n++] = cns_exp(p, cosine);
            break;
        case 10:
            pool[n++] = cns_log(p, above);
            break;
        case 11:
            pool[n++] = cns_pow(p, above, cns_constant(p, "-3/2"));
            break;
        case 12:
            pool[n++] = cns_mul(p, cns_abs(p, a), a);
            break;
        case 13:
            pool[n++] = cns_abs(p, b);
            break;
        }
    }
    for (int i = 0; i < STATES; i++) {
        cns_node f = cns_mul(p, third, pick(p, pool, n, s));
        for (int k = 0; k < 2; k++)
            f = cns_add(p, f, cns_mul(p, third, pick(p, pool, n, s)));
        cns_node sine, cosine;
        cns_sincos(p, f, &sine, &cosine);
        cns_derivative(p, i, sine);
    }
    return finished(p);
}

/* y = sum of the stored coefficients of a series times tau^k. */
static void polynomial(arb_t y, const cns_jet *J, int series, int n, const arb_t tau, bool slope)
{
    mpfr_t c;
    arb_t x;
    mpfr_init2(c, PREC);
    arb_init(x);
    arb_zero(y);
    for (int k = n; k >= slope; k--) {
        J->ops->get(J->A, c, series, k);
        arb_set_interval_mpfr(x, c, c, PREC);
        if (slope)
            arb_mul_si(x, x, k, PREC);
        arb_mul(y, y, tau, PREC);
        arb_add(y, y, x, PREC);
    }
    mpfr_clear(c);
    arb_clear(x);
}

/* Is |x| <= bound possible? */
static bool within(const arb_t x, const mag_t bound)
{
    mag_t least;
    mag_init(least);
    arb_get_mag_lower(least, x);
    const bool is = mag_cmp(least, bound) <= 0;
    mag_clear(least);
    return is;
}

/* All nodes for the states p(tau), exactly; and the remainders. Counts what is checked, and what is wrong. */
static void check_remainders(const cns_defect *d, double sigma, long *checked, long *wrong, const arb_t unit)
{
    const cns_jet *J = d->J;
    const cns_program *p = d->p;
    arb_ptr state = _arb_vec_init(p->n_states), value = _arb_vec_init(p->n_nodes);
    arb_t tau, w;
    mag_t bound, more, power;
    arb_init(tau);
    arb_init(w);
    mag_init(bound);
    mag_init(more);
    mag_init(power);
    arb_set_d(tau, sigma);
    arb_mul(tau, tau, unit, PREC);
    for (int i = 0; i < p->n_states; i++)
        if (!J->state_vanishes[i])
            polynomial(state + i, J, J->state_series[i], d->N, tau, false);
    mag_set_d(power, sigma);
    mag_pow_ui(power, power, (ulong)d->N);
    for (int v = 0; v < p->n_nodes; v++) {
        const cns_program_node *n = &p->node[v];
        cns_enclosure e = {.p = p, .node = n, .y = value + v, .value = value, .state = state, .prec = PREC};
        for (int k = 0; k < 4; k++)
            e.x[k] = n->arg[k] < 0 ? NULL : value + n->arg[k];
        cns_operations[n->op]->enclose(&e);
        if (n->constant || n->op == CNS_OP_STATE || n->op == CNS_OP_EULER || d->row[v] < 0 || J->vanishes[v])
            continue;
        polynomial(w, J, J->series[v], d->N - 1, tau, false);
        arb_sub(w, w, value + v, PREC);
        mag_mul(bound, d->e1 + v, power);
        mag_add(bound, bound, d->e0 + v);
        ++*checked;
        *wrong += !within(w, bound);
    }
    _arb_vec_clear(state, p->n_states);
    _arb_vec_clear(value, p->n_nodes);
    arb_clear(tau);
    arb_clear(w);
    mag_clear(bound);
    mag_clear(more);
    mag_clear(power);
}

/* The integral of |p' - length f(p)| from below: it grows with tau, or is far below the bound. */
static void check_defects(const cns_defect *d, double length, long *checked, long *wrong, const arb_t unit)
{
    enum { PIECES = 24 };
    const cns_jet *J = d->J;
    const cns_program *p = d->p;
    arb_ptr state = _arb_vec_init(p->n_states), f = _arb_vec_init(p->n_states),
            sum = _arb_vec_init(p->n_states);
    arb_t tau, w;
    mag_t bound;
    cns_error err;
    arb_init(tau);
    arb_init(w);
    mag_init(bound);
    for (int j = 0; j < PIECES; j++) {
        arb_set_d(tau, (double)j / PIECES);
        arb_mul(tau, tau, unit, PREC);
        for (int i = 0; i < p->n_states; i++)
            polynomial(state + i, J, J->state_series[i], d->N, tau, false);
        check_ok(cns_ball_derivatives(p, state, f, PREC, &err), &err);
        for (int i = 0; i < p->n_states; i++) {
            polynomial(w, J, J->state_series[i], d->N, tau, true);
            arb_mul(w, w, unit, PREC);
            arb_set_d(tau, length);
            arb_submul(w, tau, f + i, PREC);
            arb_set_d(tau, (double)j / PIECES);
            arb_mul(tau, tau, unit, PREC);
            arb_abs(w, w);
            arb_div_ui(w, w, PIECES, PREC);
            arb_add(sum + i, sum + i, w, PREC);
        }
    }
    for (int i = 0; i < p->n_states; i++) {
        cns_defect_of(bound, d, i);
        ++*checked;
        *wrong += !within(sum + i, bound);
    }
    _arb_vec_clear(state, p->n_states);
    _arb_vec_clear(f, p->n_states);
    _arb_vec_clear(sum, p->n_states);
    arb_clear(tau);
    arb_clear(w);
    mag_clear(bound);
}

/* A number of all ones, or a random one. */
static void random_state(mpfr_t x, uint64_t *s)
{
    mpfr_set_ui(x, 1, MPFR_RNDN);
    mpfr_nextbelow(x);
    if (test_random_below(s, 3) != 0)
        mpfr_mul_d(x, x, test_random_unit(s), MPFR_RNDN);
    if (test_random_below(s, 2) == 0)
        mpfr_neg(x, x, MPFR_RNDN);
}

typedef struct expansion {
    cns_program *p;
    cns_jet *J;
    cns_defect *d;
    double H, length;
    arb_t unit; /* length / H */
    bool bounded;
} expansion;

static void expansion_bound(expansion *x)
{
    cns_error err;
    arb_set_d(x->unit, x->H);
    arb_inv(x->unit, x->unit, PREC);
    arb_t length;
    arb_init(length);
    arb_set_d(length, x->length);
    arb_mul(x->unit, x->unit, length, PREC);
    arb_clear(length);
    x->bounded = !cns_defect_read(x->d, x->H, x->length, &err);
    if (!x->bounded)
        return;
    cns_defect_find_overshoot(x->d, x->unit);
    x->bounded = !cns_defect_bound(x->d, &err);
}

/* False: the expansion did not fit. */
static bool expansion_make(expansion *x, const cns_arith_ops *ops, uint64_t *s)
{
    cns_error err;
    const mpfr_prec_t prec = ops == &cns_arith_double ? 53 : 60 + (mpfr_prec_t)test_random_below(s, 300);
    const int order = 9 + (int)test_random_below(s, 30);
    x->p = random_program(s, test_random_below(s, 3) == 0 ? "1/8" : NULL);
    x->J = jet_new(x->p, ops, order, prec);
    x->H = ldexp(1 + test_random_unit(s), -4 - (int)test_random_below(s, 3));
    x->length = x->H * (0.2 + (ops->in_steps ? 0.9 : 1.2) * test_random_unit(s));
    arb_init(x->unit);
    x->d = cns_defect_new(x->J, &err);
    ck_assert_ptr_nonnull(x->d);
    mpfr_t y;
    mpfr_init2(y, prec);
    cns_jet_begin(x->J, x->H);
    for (int i = 0; i < STATES; i++) {
        random_state(y, s);
        cns_jet_set_state(x->J, i, y);
    }
    mpfr_clear(y);
    if (cns_jet_expand(x->J, order, &err) ||
        (ops->noise_log2 && !isfinite(ops->noise_log2(cns_jet_arith(x->J)))))
        return false;
    expansion_bound(x);
    return true;
}

static void expansion_clear(expansion *x)
{
    cns_defect_free(x->d);
    cns_jet_free(x->J);
    cns_program_free(x->p);
    arb_clear(x->unit);
}

static const cns_arith_ops *const arithmetics[] = {&cns_arith_fast, &cns_arith_mpfr, &cns_arith_double};

/* From the start, where rounding is all there is, to the end, where the tail is. */
START_TEST(remainders_hold)
{
    enum { EXPANSIONS = 60 };
    uint64_t s = test_seed() + (uint64_t)_i;
    long checked = 0, wrong = 0, bounded = 0;
    for (int i = 0; i < EXPANSIONS; i++) {
        expansion x;
        if (expansion_make(&x, arithmetics[_i], &s) && x.bounded) {
            bounded++;
            for (int j = 0; j <= TIMES; j++)
                check_remainders(x.d, (double)(j * j) / (TIMES * TIMES), &checked, &wrong, x.unit);
            check_defects(x.d, x.length, &checked, &wrong, x.unit);
        }
        expansion_clear(&x);
    }
    ck_assert_int_gt(bounded, EXPANSIONS / 2);
    ck_assert_int_gt(checked, 1000);
    ck_assert_int_eq(wrong, 0);
}
END_TEST

/* A coefficient that the recurrence has not made is seen: the judge of the test above can say no. */
START_TEST(a_wrong_coefficient_is_seen)
{
    enum { EXPANSIONS = 40 };
    uint64_t s = test_seed();
    long seen = 0, made = 0;
    for (int i = 0; i < EXPANSIONS; i++) {
        expansion x;
        if (expansion_make(&x, &cns_arith_mpfr, &s) && x.bounded) {
            int v;
            do
                v = (int)test_random_below(&s, (uint64_t)x.p->n_nodes);
            while (x.d->row[v] < 0 || x.J->vanishes[v]);
            long checked = 0, wrong = 0;
            mpfr_t y, by;
            mpfr_init2(y, x.J->spec.prec);
            mpfr_init2(by, 53);
            x.J->ops->get(x.J->A, y, x.J->series[v], 1);
            mpfr_set_ui_2exp(by, 1, -(mpfr_exp_t)x.J->spec.prec / 4, MPFR_RNDN);
            mpfr_add(y, y, by, MPFR_RNDN);
            x.J->ops->set(x.J->A, x.J->series[v], 1, y, false);
            mpfr_clears(y, by, (mpfr_ptr)0);
            expansion_bound(&x);
            for (int j = 0; j <= TIMES; j++)
                check_remainders(x.d, 0.1 * j / TIMES, &checked, &wrong, x.unit);
            check_defects(x.d, x.length, &checked, &wrong, x.unit);
            made++;
            seen += wrong > 0;
        }
        expansion_clear(&x);
    }
    ck_assert_int_gt(made, EXPANSIONS / 2);
    ck_assert_int_ge(10 * seen, 7 * made); /* at low orders the tail may cover one */
}
END_TEST

Suite *suite_defect(void)
{
    Suite *s = suite_create("defect");
    TCase *t = tcase_create("remainders");
    tcase_set_timeout(t, 600);
    add_table_test(t, remainders_hold, arithmetics);
    tcase_add_test(t, a_wrong_coefficient_is_seen);
    suite_add_tcase(s, t);
    return s;
}
