#include "branch.h"

#include <math.h>
#include <stdlib.h>

#include "core/memory.h"
#include "num/logs.h"
#include "num/vector.h"
#include "taylor/jet.h"

enum { TESTED = 4, MAX_START_LOG2 = 0, CHECK_BITS = 64, SLACK_BITS = 40, POINTS = 4 };

static mpfr_t *coefficient(const cns_branch *b, int n)
{
    return b->p + (size_t)n * (size_t)b->d;
}

/* The middle of a ball; exactly 0 where it may be 0: a state that lies on a kink lies there exactly. */
static void middle(mpfr_t y, const arb_t x)
{
    if (arb_contains_zero(x))
        mpfr_set_zero(y, 1);
    else
        arf_get_mpfr(y, arb_midref(x), MPFR_RNDN);
}

/* p_0 and p_1: the saddle, and its unstable eigenvector, the largest component in scales 1, turned so that
 * `along` grows. */
static cns_code begin(cns_branch *b, const cns_fixed_point *f, int along, const double *scales,
                      cns_error *err)
{
    int unstable = 0, stable = 0, largest = 0;
    double size = 0;
    for (int k = 0; k < f->d; k++) {
        unstable += arb_is_positive(acb_realref(f->spectrum.lambda + k)) != 0;
        stable += arb_is_negative(acb_realref(f->spectrum.lambda + k)) != 0;
    }
    if (unstable != 1 || stable != f->d - 1 || !f->spectrum.simple || !cns_spectrum_is_real(&f->spectrum, 0))
        return cns_fail(err, CNS_NUMERIC, "it is not a saddle with one unstable direction");
    arf_get_mpfr(b->lambda, arb_midref(acb_realref(f->spectrum.lambda)), MPFR_RNDN);
    acb_t turned;
    acb_init(turned);
    for (int i = 0; i < b->d; i++) {
        acb_srcptr v = acb_mat_entry(f->spectrum.right, i, 0);
        double here = hypot(arf_get_d(arb_midref(acb_realref(v)), ARF_RND_NEAR),
                            arf_get_d(arb_midref(acb_imagref(v)), ARF_RND_NEAR)) /
                      scales[i];
        if (here > size) {
            size = here;
            largest = i;
        }
    }
    for (int i = 0; i < b->d; i++) { /* any complex multiple of a real vector may have come */
        acb_div(turned, acb_mat_entry(f->spectrum.right, i, 0), acb_mat_entry(f->spectrum.right, largest, 0),
                (slong)b->prec + 64);
        middle(coefficient(b, 0)[i], f->x + i);
        middle(coefficient(b, 1)[i], acb_realref(turned));
        mpfr_mul_d(coefficient(b, 1)[i], coefficient(b, 1)[i], scales[largest], MPFR_RNDN);
    }
    acb_clear(turned);
    if (mpfr_zero_p(coefficient(b, 1)[along]))
        return cns_fail(err, CNS_NUMERIC, "its unstable direction does not move the state to follow");
    if (mpfr_sgn(coefficient(b, 1)[along]) < 0)
        for (int i = 0; i < b->d; i++)
            mpfr_neg(coefficient(b, 1)[i], coefficient(b, 1)[i], MPFR_RNDN);
    return CNS_OK;
}

static cns_code compose(cns_jet *J, const cns_branch *b, int n, cns_error *err)
{
    for (int i = 0; i < b->d; i++)
        cns_jet_set_coefficient(J, i, n, coefficient(b, n)[i]);
    return cns_jet_compose(J, n, err);
}

/* (n lambda - J) p_n = r_n, r_n being coefficient n of f(x) with p_n = 0. */
static cns_code solve_order(cns_jet *J, const cns_branch *b, const cns_fixed_point *f, int n,
                            arb_mat_t matrix, arb_mat_t rest, mpfr_t y, cns_error *err)
{
    const slong prec = (slong)b->prec;
    for (int i = 0; i < b->d; i++)
        for (int j = 0; j < b->d; j++) {
            arb_neg(arb_mat_entry(matrix, i, j), arb_mat_entry(f->jacobian, i, j));
            if (i == j) {
                mpfr_mul_ui(y, b->lambda, (unsigned long)n, MPFR_RNDN);
                arb_t shift;
                arb_init(shift);
                arf_set_mpfr(arb_midref(shift), y);
                arb_add(arb_mat_entry(matrix, i, j), arb_mat_entry(matrix, i, j), shift, prec);
                arb_clear(shift);
            }
            mag_zero(arb_radref(arb_mat_entry(matrix, i, j)));
        }
    for (int i = 0; i < b->d; i++) {
        cns_jet_composed(J, y, i, n);
        arb_zero(arb_mat_entry(rest, i, 0));
        arf_set_mpfr(arb_midref(arb_mat_entry(rest, i, 0)), y);
    }
    if (!arb_mat_approx_solve(rest, matrix, rest, prec))
        return cns_fail(err, CNS_NUMERIC, "a resonance of its eigenvalues");
    for (int i = 0; i < b->d; i++)
        arf_get_mpfr(coefficient(b, n)[i], arb_midref(arb_mat_entry(rest, i, 0)), MPFR_RNDN);
    return CNS_OK;
}

static cns_code expand(cns_branch *b, const cns_reduced *r, const cns_fixed_point *f, cns_error *err)
{
    cns_jet_spec spec = {
        .program = r->field, .ops = &cns_arith_mpfr, .order = b->order, .prec = b->prec, .registers = 1};
    cns_jet *J = cns_jet_new(&spec, err);
    arb_mat_t matrix, rest;
    mpfr_t y;
    if (J == NULL)
        return err->code;
    arb_mat_init(matrix, b->d, b->d);
    arb_mat_init(rest, b->d, 1);
    mpfr_init2(y, b->prec);
    cns_jet_begin(J, 1);
    cns_code code = compose(J, b, 0, err);
    if (!code)
        code = compose(J, b, 1, err);
    for (int n = 2; n <= b->order && !code; n++) {
        code = compose(J, b, n, err); /* with p_n = 0 */
        if (!code)
            code = solve_order(J, b, f, n, matrix, rest, y, err);
        if (!code && n < b->order)
            code = compose(J, b, n, err);
    }
    arb_mat_clear(matrix);
    arb_mat_clear(rest);
    mpfr_clear(y);
    cns_jet_free(J);
    return code;
}

static double size_log2(const cns_branch *b, int n, const double *scales)
{
    double largest = -HUGE_VAL;
    for (int i = 0; i < b->d; i++)
        if (!mpfr_zero_p(coefficient(b, n)[i]))
            largest = fmax(largest, cns_log2_mpfr(coefficient(b, n)[i]) - cns_log2_2exp(scales[i], 0));
    return largest;
}

/* The largest start that the last terms allow, a power of 2. */
static void choose_start(cns_branch *b, const double *scales)
{
    double reach = MAX_START_LOG2;
    for (int n = b->order - TESTED + 1; n <= b->order; n++) {
        const double l = size_log2(b, n, scales);
        if (l > -HUGE_VAL)
            reach = fmin(reach, (-(double)b->prec - l) / n);
    }
    mpfr_set_ui_2exp(b->s, 1, (mpfr_exp_t)floor(reach), MPFR_RNDN);
}

/* slope = lambda s dx_i/ds. */
static void slope_at(const cns_branch *b, const mpfr_t s, int i, mpfr_t slope, mpfr_t scratch)
{
    mpfr_set_zero(slope, 1);
    for (int n = b->order; n >= 1; n--) {
        mpfr_mul(slope, slope, s, MPFR_RNDN);
        mpfr_mul_ui(scratch, coefficient(b, n)[i], (unsigned long)n, MPFR_RNDN);
        mpfr_add(slope, slope, scratch, MPFR_RNDN);
    }
    mpfr_mul(slope, slope, s, MPFR_RNDN);
    mpfr_mul(slope, slope, b->lambda, MPFR_RNDN);
}

/* lambda s x'(s) against f(x(s)), evaluated pointwise with true absolute values and more bits, here and there
 * on the way to the start: says whether the series is the branch, and on the side of every kink that was
 * assumed. */
static cns_code check(const cns_branch *b, const cns_reduced *r, const double *scales, cns_error *err)
{
    const mpfr_prec_t prec = b->prec + CHECK_BITS;
    cns_jet_spec spec = {
        .program = r->field, .ops = &cns_arith_mpfr, .order = 1, .prec = prec, .sharp_prec = b->prec};
    cns_jet *J = cns_jet_new(&spec, err);
    mpfr_t *x = cns_vector_new(b->d, prec);
    mpfr_t at, slope, f;
    if (J == NULL || x == NULL) {
        cns_jet_free(J);
        cns_vector_free(x);
        return cns_out_of_memory(err);
    }
    cns_code code = CNS_OK;
    mpfr_inits2(prec, at, slope, f, (mpfr_ptr)0);
    for (int point = 0; point < POINTS && !code; point++) {
        mpfr_div_2ui(at, b->s, (unsigned long)point, MPFR_RNDN);
        cns_branch_eval(b, at, x);
        cns_jet_begin(J, 1);
        for (int i = 0; i < b->d; i++)
            cns_jet_set_state(J, i, x[i]);
        code = cns_jet_expand(J, 1, err);
        for (int i = 0; i < b->d && !code; i++) {
            slope_at(b, at, i, slope, f);
            cns_jet_coefficient(J, f, i, 1);
            mpfr_sub(slope, slope, f, MPFR_RNDN);
            const double off = mpfr_zero_p(slope) ? -HUGE_VAL : cns_log2_mpfr(slope);
            if (off - cns_log2_2exp(scales[i], 0) > SLACK_BITS - (double)b->prec)
                code = cns_fail(
                    err, CNS_NUMERIC,
                    "the series of its unstable manifold does not solve the equations (state %d is off "
                    "by 2^%.0f)",
                    i, off);
        }
    }
    mpfr_clears(at, slope, f, (mpfr_ptr)0);
    cns_vector_free(x);
    cns_jet_free(J);
    return code;
}

cns_code cns_branch_open(cns_branch *b, const cns_reduced *r, const cns_fixed_point *f, int along,
                         const double *scales, int order, mpfr_prec_t prec, cns_error *err)
{
    *b = (cns_branch){.d = r->d, .order = order < 2 * TESTED ? 2 * TESTED : order, .prec = prec};
    mpfr_inits2(prec, b->lambda, b->s, (mpfr_ptr)0);
    b->p = cns_vector_new(b->d * (b->order + 1), prec);
    cns_code code = b->p == NULL ? cns_out_of_memory(err) : begin(b, f, along, scales, err);
    if (!code)
        code = expand(b, r, f, err);
    if (!code) {
        choose_start(b, scales);
        code = check(b, r, scales, err);
    }
    return code;
}

void cns_branch_close(cns_branch *b)
{
    cns_vector_free(b->p);
    mpfr_clears(b->lambda, b->s, (mpfr_ptr)0);
}

void cns_branch_eval(const cns_branch *b, const mpfr_t s, mpfr_t *x)
{
    for (int i = 0; i < b->d; i++) {
        mpfr_set(x[i], coefficient(b, b->order)[i], MPFR_RNDN);
        for (int n = b->order - 1; n >= 0; n--) {
            mpfr_mul(x[i], x[i], s, MPFR_RNDN);
            mpfr_add(x[i], x[i], coefficient(b, n)[i], MPFR_RNDN);
        }
    }
}
