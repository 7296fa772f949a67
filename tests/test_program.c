/* Programs: the builder, its merging and folding, and what it refuses. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "problem.h"
#include "taylor/program_internal.h"

static cns_op op_of(const cns_program *p, cns_node v)
{
    ck_assert_msg(v >= 0 && v < p->n_nodes, "no node %d", v);
    return p->node[v].op;
}

START_TEST(merges_equal_operations)
{
    cns_program *p = program_new(2, NULL);
    cns_node a = cns_state(p, 0), b = cns_state(p, 1), s, c, s2, c2;
    cns_node half = cns_constant(p, "1/2");
    ck_assert_int_ne(a, b);
    ck_assert_int_eq(cns_state(p, 0), a);
    ck_assert_int_eq(cns_add(p, a, b), cns_add(p, b, a));
    ck_assert_int_eq(cns_mul(p, a, b), cns_mul(p, b, a));
    ck_assert_int_eq(cns_hypot(p, a, b), cns_hypot(p, b, a));
    ck_assert_int_ne(cns_sub(p, a, b), cns_sub(p, b, a));
    ck_assert_int_ne(cns_div(p, a, b), cns_div(p, b, a));
    ck_assert_int_eq(cns_sub(p, a, b), cns_sub(p, a, b));
    ck_assert_int_eq(cns_div(p, a, b), cns_div(p, a, b));
    ck_assert_int_eq(cns_neg(p, a), cns_neg(p, a));
    ck_assert_int_eq(cns_sqrt(p, a), cns_sqrt(p, a));
    ck_assert_int_ne(cns_sqrt(p, a), cns_sqrt(p, b));
    ck_assert_int_eq(cns_exp(p, a), cns_exp(p, a));
    ck_assert_int_eq(cns_log(p, a), cns_log(p, a));
    ck_assert_int_eq(cns_pow(p, a, half), cns_pow(p, a, half));
    ck_assert_int_ne(cns_pow(p, a, half), cns_sqrt(p, a));
    ck_assert_int_eq(cns_abs(p, a), cns_abs(p, a));
    cns_sincos(p, a, &s, &c);
    cns_sincos(p, a, &s2, &c2);
    ck_assert_int_eq(s, s2);
    ck_assert_int_eq(c, c2);
    ck_assert_int_eq(c, s + 1);
    int before = p->n_nodes;
    cns_hypot(p, a, b);
    cns_log(p, a);
    cns_pow(p, a, cns_constant(p, "0.5"));
    ck_assert_int_eq(p->n_nodes, before);
    cns_program_free(p);
}
END_TEST

START_TEST(merges_equal_constants)
{
    cns_program *p = program_new(0, NULL);
    ck_assert_int_eq(cns_constant(p, "1/2"), cns_constant(p, "0.50"));
    ck_assert_int_eq(cns_constant(p, "2*pi/3"), cns_constant(p, "pi/3*2"));
    ck_assert_int_ne(cns_constant(p, "1"), cns_constant(p, "pi"));
    ck_assert_int_ne(cns_constant(p, "1"), cns_constant(p, "-1"));
    ck_assert_int_ne(cns_constant(p, "pi"), cns_constant(p, "1/pi"));
    cns_program_free(finished(p));
}
END_TEST

START_TEST(simplifies)
{
    cns_program *p = program_new(2, NULL);
    cns_node a = cns_state(p, 0), b = cns_state(p, 1), two = cns_constant(p, "2");
    ck_assert_int_eq(cns_mul(p, a, a), cns_sqr(p, a));
    ck_assert_int_eq(cns_neg(p, cns_neg(p, a)), a);
    ck_assert_int_eq(op_of(p, cns_mul(p, two, a)), CNS_OP_SCALE);
    ck_assert_int_eq(cns_mul(p, two, a), cns_mul(p, a, two));
    ck_assert_int_eq(op_of(p, cns_div(p, a, two)), CNS_OP_SCALE);
    ck_assert_int_eq(op_of(p, cns_div(p, two, a)), CNS_OP_DIV);
    ck_assert_int_eq(cns_sqrt(p, cns_sqr(p, a)), cns_abs(p, a));
    cns_node drag = cns_mul(p, cns_abs(p, a), a);
    ck_assert_int_eq(op_of(p, drag), CNS_OP_SIGNED);
    ck_assert_int_eq(p->node[drag].arg[1], cns_sqr(p, a));
    ck_assert_int_eq(cns_mul(p, a, cns_abs(p, a)), drag);
    ck_assert_int_eq(op_of(p, cns_mul(p, cns_abs(p, a), b)), CNS_OP_MUL);
    cns_program_free(p);

    p = program_new(1, "1e-3");
    a = cns_state(p, 0);
    ck_assert_int_eq(op_of(p, cns_abs(p, a)), CNS_OP_SMOOTH_ABS);
    ck_assert_int_eq(cns_abs(p, a), cns_abs(p, a));
    ck_assert_int_eq(op_of(p, cns_mul(p, cns_abs(p, a), a)), CNS_OP_MUL);
    ck_assert_int_eq(op_of(p, cns_abs(p, cns_constant(p, "-2"))), CNS_OP_ABS); /* nothing to smooth */
    cns_program_free(p);
}
END_TEST

/* The value of x' where x' is a constant: coefficient 1. */
static void constant_value(cns_program *p, mpfr_t y)
{
    cns_error err;
    cns_jet *J = jet_new(p, &cns_arith_mpfr, 1, mpfr_get_prec(y));
    mpfr_set_zero(y, 1);
    cns_jet_begin(J, 1);
    cns_jet_set_state(J, 0, y);
    check_ok(cns_jet_expand(J, 1, &err), &err);
    cns_jet_coefficient(J, y, 0, 1);
    cns_jet_free(J);
}

/* Every operation on constants gives a constant, correct to the last bit but one at each precision. */
START_TEST(computes_constants_at_each_precision)
{
    static const mpfr_prec_t precisions[] = {24, 53, 64, 65, 200, 1000};
    const char *texts[] = {"2.2", "-pi"};
    cns_number *parameters = numbers_new(2, texts);
    cns_program *p = cns_program_new(1, 2, parameters, NULL);
    cns_node a = cns_parameter(p, 0), b = cns_parameter(p, 1), s, c;
    cns_sincos(p, a, &s, &c);
    cns_node terms[] = {
        cns_div(p, cns_add(p, a, cns_constant(p, "8/3")), b),
        s,
        cns_mul(p, c, s),
        cns_sqr(p, b),
        cns_mul(p, a, b),
        cns_neg(p, cns_sub(p, b, a)),
        cns_sqrt(p, a),
        cns_hypot(p, a, b),
        cns_exp(p, b),
        cns_log(p, a),
        cns_pow(p, a, b),
        cns_abs(p, b),
        cns_mul(p, cns_abs(p, b), b),
        cns_sqrt(p, cns_sqr(p, b)),
    };
    cns_node sum = cns_constant(p, "0");
    for (int i = 0; i < COUNT(terms); i++) {
        ck_assert_int_ge(terms[i], 0);
        sum = cns_add(p, sum, terms[i]);
    }
    ck_assert(p->node[sum].constant);
    cns_derivative(p, 0, sum);
    finished(p);
    for (int v = 0; v < p->n_nodes; v++)
        ck_assert_msg(p->node[v].constant, "node %d", v);
    numbers_free(parameters, 2); /* the program has its own */

    mpfr_t x, y, z, w, total, value;
    mpfr_inits2(1200, x, y, z, w, total, (mpfr_ptr)0);
    mpfr_set_ui(x, 11, MPFR_RNDN); /* a */
    mpfr_div_ui(x, x, 5, MPFR_RNDN);
    mpfr_const_pi(y, MPFR_RNDN); /* -b */
    mpfr_set_ui(z, 8, MPFR_RNDN);
    mpfr_div_ui(z, z, 3, MPFR_RNDN);
    mpfr_add(z, z, x, MPFR_RNDN);
    mpfr_div(z, z, y, MPFR_RNDN);
    mpfr_neg(total, z, MPFR_RNDN);
    mpfr_sin_cos(z, w, x, MPFR_RNDN);
    mpfr_add(total, total, z, MPFR_RNDN);
    mpfr_mul(z, z, w, MPFR_RNDN);
    mpfr_add(total, total, z, MPFR_RNDN); /* b^2 and |b| b cancel */
    mpfr_mul(z, x, y, MPFR_RNDN);
    mpfr_sub(total, total, z, MPFR_RNDN);
    mpfr_add(total, total, x, MPFR_RNDN); /* a - b + 2 |b| = a + 3 pi */
    mpfr_mul_ui(z, y, 3, MPFR_RNDN);
    mpfr_add(total, total, z, MPFR_RNDN);
    mpfr_sqrt(z, x, MPFR_RNDN);
    mpfr_add(total, total, z, MPFR_RNDN);
    mpfr_hypot(z, x, y, MPFR_RNDN);
    mpfr_add(total, total, z, MPFR_RNDN);
    mpfr_neg(w, y, MPFR_RNDN);
    mpfr_exp(z, w, MPFR_RNDN);
    mpfr_add(total, total, z, MPFR_RNDN);
    mpfr_log(z, x, MPFR_RNDN);
    mpfr_add(total, total, z, MPFR_RNDN);
    mpfr_pow(z, x, w, MPFR_RNDN);
    mpfr_add(total, total, z, MPFR_RNDN);
    for (int i = 0; i < COUNT(precisions); i++) {
        mpfr_init2(value, precisions[i]);
        constant_value(p, value);
        check_close(value, total, log2_of(total) - (double)precisions[i] + 1, "%ld bits",
                    (long)precisions[i]);
        mpfr_clear(value);
    }
    mpfr_clears(x, y, z, w, total, (mpfr_ptr)0);
    cns_program_free(p);
}
END_TEST

START_TEST(keeps_parameters_of_its_own)
{
    const char *texts[] = {"3"};
    cns_number *parameters = numbers_new(1, texts);
    cns_program *p = cns_program_new(1, 1, parameters, NULL);
    cns_error err;
    cns_derivative(p, 0, cns_parameter(p, 0));
    finished(p);
    check_ok(cns_number_parse(&parameters[0], "4", &err), &err);
    numbers_free(parameters, 1);
    mpfr_t y;
    mpfr_init2(y, 60);
    constant_value(p, y);
    ck_assert_int_eq(mpfr_cmp_ui(y, 3), 0);
    mpfr_clear(y);
    cns_program_free(p);
}
END_TEST

static void check_dynamic(const cns_program *p, const char *which)
{
    for (int i = 0; i < cns_program_states(p); i++)
        ck_assert_msg(cns_program_is_dynamic(p, i) == (which[i] == 'd'), "state %d", i);
}

START_TEST(finds_passive_states)
{
    cns_program *p = model_program("apw", NULL);
    check_dynamic(p, "ppdddd");
    ck_assert_int_eq(cns_program_states(p), 6);
    ck_assert_int_eq(cns_program_outputs(p), cns_model_find("apw")->n_outputs);
    ck_assert(!cns_program_is_smooth(p));
    cns_program_free(p);
    p = model_program("apw", "1e-5");
    check_dynamic(p, "ppdddd");
    ck_assert(cns_program_is_smooth(p));
    cns_program_free(p);
    p = model_program("lorenz", NULL);
    check_dynamic(p, "ddd");
    cns_program_free(p);

    /* 0: a cycle of 0 and 1; 2 feeds it; 3 and 4 are fed by it, 4 through 3; 5 stands alone and feeds 6. */
    p = program_new(7, NULL);
    cns_derivative(p, 0, cns_state(p, 1));
    cns_derivative(p, 1, cns_add(p, cns_state(p, 0), cns_state(p, 2)));
    cns_derivative(p, 2, cns_constant(p, "1"));
    cns_derivative(p, 3, cns_state(p, 0));
    cns_derivative(p, 4, cns_mul(p, cns_state(p, 3), cns_state(p, 1)));
    cns_derivative(p, 5, cns_constant(p, "2"));
    cns_derivative(p, 6, cns_state(p, 5));
    check_dynamic(finished(p), "dddpppp");
    cns_program_free(p);
}
END_TEST

typedef cns_node (*misuse)(cns_program *p, cns_node x);

static cns_node negative_state(cns_program *p, cns_node x)
{
    (void)x;
    return cns_state(p, -1);
}
static cns_node state_beyond(cns_program *p, cns_node x)
{
    (void)x;
    return cns_state(p, 2);
}
static cns_node parameter_beyond(cns_program *p, cns_node x)
{
    (void)x;
    return cns_parameter(p, 0);
}
static cns_node add_invalid(cns_program *p, cns_node x)
{
    return cns_add(p, x, -1);
}
static cns_node sub_foreign(cns_program *p, cns_node x)
{
    return cns_sub(p, x + 1000, x);
}
static cns_node mul_foreign(cns_program *p, cns_node x)
{
    return cns_mul(p, x, x + 1000);
}
static cns_node sqr_invalid(cns_program *p, cns_node x)
{
    (void)x;
    return cns_mul(p, -1, -1);
}
static cns_node neg_foreign(cns_program *p, cns_node x)
{
    return cns_neg(p, x + 1000);
}
static cns_node div_invalid(cns_program *p, cns_node x)
{
    return cns_div(p, x, -1);
}
static cns_node sqrt_invalid(cns_program *p, cns_node x)
{
    (void)x;
    return cns_sqrt(p, -1);
}
static cns_node hypot_foreign(cns_program *p, cns_node x)
{
    return cns_hypot(p, x + 1000, x);
}
static cns_node hypot_invalid(cns_program *p, cns_node x)
{
    return cns_hypot(p, x, -1);
}
static cns_node sincos_invalid(cns_program *p, cns_node x)
{
    cns_node s, c;
    cns_sincos(p, x + 1000, &s, &c);
    ck_assert_int_eq(c, -1);
    return s;
}
static cns_node exp_invalid(cns_program *p, cns_node x)
{
    return cns_exp(p, x + 1000);
}
static cns_node log_invalid(cns_program *p, cns_node x)
{
    return cns_log(p, x + 1000);
}
static cns_node pow_invalid(cns_program *p, cns_node x)
{
    return cns_pow(p, -1, x + 1000);
}
static cns_node pow_of_state(cns_program *p, cns_node x)
{
    return cns_pow(p, x, x);
}
static cns_node abs_invalid(cns_program *p, cns_node x)
{
    return cns_abs(p, x + 1000);
}
static cns_node bad_constant(cns_program *p, cns_node x)
{
    (void)x;
    return cns_constant(p, "1..5");
}
static cns_node bad_output(cns_program *p, cns_node x)
{
    return cns_output(p, x + 1000);
}
static cns_node bad_derivative(cns_program *p, cns_node x)
{
    cns_derivative(p, 0, x + 1000);
    return -1;
}
static cns_node derivative_of_no_state(cns_program *p, cns_node x)
{
    cns_derivative(p, 2, x);
    return -1;
}

static const misuse misuses[] = {
    negative_state,   state_beyond,
    parameter_beyond, add_invalid,
    sub_foreign,      mul_foreign,
    sqr_invalid,      neg_foreign,
    div_invalid,      sqrt_invalid,
    hypot_foreign,    hypot_invalid,
    sincos_invalid,   exp_invalid,
    log_invalid,      pow_invalid,
    pow_of_state,     abs_invalid,
    bad_constant,     bad_output,
    bad_derivative,   derivative_of_no_state,
};

/* The first error stays, everything after it is refused, exact and smoothed alike. */
START_TEST(errors_are_sticky)
{
    for (int smooth = 0; smooth < 2; smooth++) {
        cns_program *p = program_new(2, smooth ? "1/10" : NULL);
        cns_error first, second;
        cns_node x = cns_state(p, 0);
        cns_derivative(p, 0, x);
        cns_derivative(p, 1, x);
        ck_assert_int_eq(misuses[_i](p, x), -1);
        int nodes = p->n_nodes;
        ck_assert_int_eq(cns_state(p, 0), -1);
        ck_assert_int_eq(cns_constant(p, "1"), -1);
        ck_assert_int_eq(cns_add(p, x, x), -1);
        ck_assert_int_eq(cns_pow(p, x, x), -1);
        ck_assert_int_eq(cns_output(p, x), -1);
        cns_derivative(p, 7, x);
        ck_assert_int_eq(p->n_nodes, nodes);
        cns_code code = cns_program_finish(p, &first);
        ck_assert_int_ne(code, CNS_OK);
        ck_assert_int_eq(first.code, code);
        ck_assert_uint_gt(strlen(first.text), 0);
        ck_assert_ptr_null(strstr(first.text, "state 7"));
        ck_assert_int_eq(cns_program_finish(p, &second), code);
        ck_assert_str_eq(first.text, second.text);
        ck_assert_int_eq(cns_program_finish(p, NULL), code);
        cns_program_free(p);
    }
}
END_TEST

START_TEST(every_state_needs_a_derivative)
{
    cns_program *p = program_new(2, NULL);
    cns_error err;
    cns_derivative(p, 0, cns_state(p, 1));
    ck_assert_int_eq(cns_program_finish(p, &err), CNS_NUMERIC);
    ck_assert_ptr_nonnull(strstr(err.text, "state 1"));
    cns_program_free(p);
}
END_TEST

START_TEST(a_finished_program_stays)
{
    cns_program *p = program_new(1, NULL);
    cns_error err;
    cns_node x = cns_state(p, 0);
    cns_derivative(p, 0, cns_neg(p, x));
    finished(p);
    finished(p);
    int nodes = p->n_nodes;
    ck_assert_int_eq(cns_sqr(p, x), -1);
    ck_assert_int_eq(p->n_nodes, nodes);
    ck_assert_int_eq(cns_program_finish(p, &err), CNS_NUMERIC);
    cns_program_free(p);
    cns_program_free(NULL);
}
END_TEST

/* Enough nodes for the table of nodes and its hash to grow many times. */
START_TEST(grows)
{
    enum { N = 5000 };
    cns_program *p = program_new(1, NULL);
    static cns_node sum[N];
    cns_node x = cns_state(p, 0), one = cns_constant(p, "1");
    for (int turn = 0; turn < 2; turn++) {
        cns_node y = x;
        for (int i = 0; i < N; i++) {
            char text[32];
            snprintf(text, sizeof text, "%d/7", i);
            y = cns_sub(p, cns_mul(p, cns_constant(p, text), y), one);
            if (turn)
                ck_assert_int_eq(y, sum[i]);
            sum[i] = y;
        }
    }
    cns_derivative(p, 0, sum[N - 1]);
    ck_assert_int_eq(p->n_constants, N); /* 7/7 is the 1 there was */
    cns_program_free(finished(p));
}
END_TEST

static char *printed(const cns_program *p)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    ck_assert_ptr_nonnull(out);
    cns_program_print(p, out);
    fclose(out);
    return text;
}

START_TEST(prints_one_operation_per_line)
{
    const char *texts[] = {"8/3"};
    cns_number *parameters = numbers_new(1, texts);
    cns_program *p = cns_program_new(2, 1, parameters, NULL);
    cns_node x = cns_state(p, 0), y = cns_state(p, 1), s, c;
    cns_sincos(p, x, &s, &c);
    cns_derivative(p, 0, cns_mul(p, cns_parameter(p, 0), cns_add(p, s, cns_mul(p, x, c))));
    cns_derivative(p, 1, cns_constant(p, "2*pi"));
    cns_output(p, cns_sqr(p, y));
    char *text = printed(p);
    ck_assert_ptr_nonnull(strstr(text, "%0 = state 0\n"));
    ck_assert_ptr_null(strchr(text, ';'));
    free(text);
    text = printed(finished(p));
    ck_assert_str_eq(text, "%0 = state 0\n"
                           "%1 = state 1  ; output only\n"
                           "%2 = euler %0\n"
                           "%3 = sin %0 %2\n"
                           "%4 = cos %0 %2 %3\n"
                           "%5 = mul %0 %4  ; folded\n"
                           "%6 = add %3 %5  ; folded\n"
                           "%7 = parameter 0  ; constant\n"
                           "%8 = scale %7 %6  ; folded\n"
                           "%9 = constant 2*pi  ; constant\n"
                           "%10 = sqr %1  ; output only\n"
                           "state 0' = %7 * %6\n"
                           "state 1' = %9  ; passive\n"
                           "output 0 = %10\n");
    free(text);
    numbers_free(parameters, 1);
    cns_program_free(p);
}
END_TEST

START_TEST(folds_what_only_one_sum_uses)
{
    cns_program *p = program_new(3, NULL);
    cns_node x = cns_state(p, 0), y = cns_state(p, 1), z = cns_state(p, 2);
    cns_node xy = cns_mul(p, x, y), yz = cns_mul(p, y, z), xz = cns_mul(p, x, z), yy = cns_sqr(p, y);
    cns_node once = cns_sub(p, xy, cns_neg(p, yz)); /* folded whole, into the derivative */
    cns_node both = cns_add(p, once, xz);
    cns_node divisor = cns_add(p, yy, z); /* a divisor is stored; xz has two users */
    cns_node quotient = cns_div(p, xz, divisor);
    cns_derivative(p, 0, both);
    cns_derivative(p, 1, quotient);
    cns_derivative(p, 2, cns_mul(p, cns_constant(p, "3"), quotient)); /* the factor is taken off */
    finished(p);
    ck_assert(p->node[xy].folded && p->node[yz].folded && p->node[once].folded && p->node[both].folded);
    ck_assert(!p->node[xz].folded && !p->node[quotient].folded);
    ck_assert(p->node[yy].folded && !p->node[divisor].folded);
    ck_assert_int_eq(p->derivative[2], quotient);
    ck_assert_int_ge(p->factor[2], 0);
    ck_assert_int_eq(p->factor[0], -1);
    cns_program_free(p);
}
END_TEST

/* With outputs nothing is folded: the same coefficients, up to rounding. */
START_TEST(folding_changes_no_value)
{
    static const char *const start[] = {"0", "0", "1", "-0.3", "0.7", "1"};
    enum { ORDER = 30, PREC = 150 };
    cns_program *p = model_program("apw", _i ? "1/8" : NULL);
    cns_number *x0 = numbers_new(6, start);
    cns_jet *J[2];
    mpfr_t x, y;
    mpfr_inits2(PREC, x, y, (mpfr_ptr)0);
    for (int k = 0; k < 2; k++) {
        cns_jet_spec spec = {
            .program = p, .ops = &cns_arith_mpfr, .order = ORDER, .prec = PREC, .outputs = k == 1};
        cns_error err;
        J[k] = cns_jet_new(&spec, &err);
        ck_assert_ptr_nonnull(J[k]);
        cns_jet_begin(J[k], 0.25);
        for (int i = 0; i < 6; i++) {
            cns_number_get_mpfr(x, &x0[i]);
            cns_jet_set_state(J[k], i, x);
        }
        check_ok(cns_jet_expand(J[k], ORDER, &err), &err);
    }
    for (int i = 0; i < 6; i++)
        for (int k = 0; k <= ORDER; k++) {
            cns_jet_coefficient(J[0], x, i, k);
            cns_jet_coefficient(J[1], y, i, k);
            check_close(x, y, 12.0 - PREC, "state %d, coefficient %d", i, k);
        }
    for (int k = 0; k < 2; k++)
        cns_jet_free(J[k]);
    mpfr_clears(x, y, (mpfr_ptr)0);
    numbers_free(x0, 6);
    cns_program_free(p);
}
END_TEST

/* The outputs of a model at the start: speed and torque of the disk. */
START_TEST(evaluates_outputs)
{
    static const char *const start[] = {"0", "0", "0", "3", "-4", "-2"};
    cns_program *p = model_program("apw", NULL);
    cns_number *x0 = numbers_new(6, start);
    cns_jet_spec spec = {.program = p, .ops = &cns_arith_mpfr, .order = 1, .prec = 100, .outputs = true};
    cns_error err;
    cns_jet *J = cns_jet_new(&spec, &err);
    mpfr_t x, y;
    mpfr_inits2(100, x, y, (mpfr_ptr)0);
    ck_assert_ptr_nonnull(J);
    cns_jet_begin(J, 1);
    for (int i = 0; i < 6; i++) {
        cns_number_get_mpfr(x, &x0[i]);
        cns_jet_set_state(J, i, x);
    }
    check_ok(cns_jet_expand(J, 1, &err), &err);
    ck_assert(cns_jet_output(J, x, 4)); /* speed */
    ck_assert_int_eq(mpfr_cmp_ui(x, 5), 0);
    ck_assert(cns_jet_output(J, x, 3)); /* tau = (0.2 + 0.2 * 2) (-2) */
    mpfr_set_si(y, -6, MPFR_RNDN);
    mpfr_div_ui(y, y, 5, MPFR_RNDN);
    check_close(x, y, -97, "tau");
    ck_assert(cns_jet_output(J, x, 5)); /* x' = Vx at theta = 0 */
    ck_assert_int_eq(mpfr_cmp_ui(x, 3), 0);
    ck_assert(cns_jet_output(J, x, 6));
    ck_assert_int_eq(mpfr_cmp_si(x, -4), 0);
    mpfr_clears(x, y, (mpfr_ptr)0);
    cns_jet_free(J);
    numbers_free(x0, 6);
    cns_program_free(p);
}
END_TEST

Suite *suite_program(void)
{
    Suite *s = suite_create("program");
    TCase *t = tcase_create("program");
    tcase_add_test(t, merges_equal_operations);
    tcase_add_test(t, merges_equal_constants);
    tcase_add_test(t, simplifies);
    tcase_add_test(t, computes_constants_at_each_precision);
    tcase_add_test(t, keeps_parameters_of_its_own);
    tcase_add_test(t, finds_passive_states);
    add_table_test(t, errors_are_sticky, misuses);
    tcase_add_test(t, every_state_needs_a_derivative);
    tcase_add_test(t, a_finished_program_stays);
    tcase_add_test(t, grows);
    tcase_add_test(t, prints_one_operation_per_line);
    tcase_add_test(t, folds_what_only_one_sum_uses);
    tcase_add_loop_test(t, folding_changes_no_value, 0, 2);
    tcase_add_test(t, evaluates_outputs);
    suite_add_tcase(s, t);
    return s;
}
