#include "fixed_point.h"

#include <stdlib.h>

#include "core/memory.h"
#include "taylor/ball.h"
#include "taylor/tangent.h"

enum { NEWTON_STEPS = 200, INFLATION_BITS = 8 };

cns_code cns_reduced_open(cns_reduced *r, const cns_program *p, cns_error *err)
{
    *r = (cns_reduced){.index = cns_xalloc((size_t)cns_program_states(p) + 1, sizeof *r->index)};
    r->d = cns_dynamic_states(p, r->index);
    if (r->d == 0)
        return cns_fail(err, CNS_USAGE,
                        "no state feeds back on any other: there is no fixed point to look for");
    cns_code code = cns_tangent_program(p, 0, &r->field, err);
    return code ? code : cns_tangent_program(p, r->d, &r->tangent, err);
}

void cns_reduced_close(cns_reduced *r)
{
    cns_program_free(r->field);
    cns_program_free(r->tangent);
    free(r->index);
    *r = (cns_reduced){0};
}

void cns_fixed_point_init(cns_fixed_point *f, int d)
{
    f->d = d;
    f->x = _arb_vec_init(d);
    arb_mat_init(f->jacobian, d, d);
    cns_spectrum_init(&f->spectrum, d);
}

void cns_fixed_point_clear(cns_fixed_point *f)
{
    _arb_vec_clear(f->x, f->d);
    arb_mat_clear(f->jacobian);
    cns_spectrum_clear(&f->spectrum);
}

/* f, d balls, and the Jacobian over the box x. */
static cns_code linearise(const cns_reduced *r, arb_srcptr x, arb_mat_t f, arb_mat_t jacobian, slong prec,
                          cns_error *err)
{
    const int d = r->d, n = d * (1 + d);
    arb_ptr state = _arb_vec_init(n), value = _arb_vec_init(n);
    _arb_vec_set(state, x, d);
    for (int j = 0; j < d; j++)
        arb_one(state + d * (1 + j) + j);
    cns_code code = cns_ball_derivatives(r->tangent, state, value, prec, err);
    for (int i = 0; i < d && !code; i++) {
        arb_set(arb_mat_entry(f, i, 0), value + i);
        for (int j = 0; j < d; j++)
            arb_set(arb_mat_entry(jacobian, i, j), value + d * (1 + j) + i);
    }
    _arb_vec_clear(state, n);
    _arb_vec_clear(value, n);
    return code;
}

/* Newton's method on midpoints, until steps are rounding; *size_log2 is of the last. */
static cns_code newton(const cns_reduced *r, arb_ptr x, slong prec, slong *size_log2, cns_error *err)
{
    const int d = r->d;
    arb_mat_t f, jacobian, step;
    cns_code code = CNS_OK;
    bool close = false;
    arb_mat_init(f, d, 1);
    arb_mat_init(step, d, 1);
    arb_mat_init(jacobian, d, d);
    for (int turn = 0; !code; turn++) {
        fmpz_t e;
        code = linearise(r, x, f, jacobian, prec, err);
        if (code)
            break;
        arb_mat_get_mid(f, f);
        arb_mat_get_mid(jacobian, jacobian);
        if (!arb_mat_approx_solve(step, jacobian, f, prec)) {
            code = cns_fail(err, CNS_NUMERIC, "the Jacobian is singular");
            break;
        }
        slong largest = -8 * prec;
        fmpz_init(e);
        for (int i = 0; i < d; i++) {
            arb_sub(x + i, x + i, arb_mat_entry(step, i, 0), prec);
            mag_zero(arb_radref(x + i));
            if (arb_is_zero(arb_mat_entry(step, i, 0)))
                continue;
            arf_abs_bound_lt_2exp_fmpz(e, arb_midref(arb_mat_entry(step, i, 0)));
            slong size = fmpz_fits_si(e) ? fmpz_get_si(e) : 8 * prec;
            largest = size > largest ? size : largest;
        }
        fmpz_clear(e);
        if (largest > prec || turn == NEWTON_STEPS)
            code = cns_fail(err, CNS_NUMERIC, "Newton's method does not converge");
        if (close || largest == -8 * prec) {
            *size_log2 = largest;
            break;
        }
        close = largest < -prec / 2; /* one more step: it doubles the digits */
    }
    arb_mat_clear(f);
    arb_mat_clear(step);
    arb_mat_clear(jacobian);
    return code;
}

/* K(X) = x - Y f(x) + (1 - Y J(X)) (X - x) for the box X of radius 2^radius_log2 about x. If K(X) lies inside
 * X, there is exactly one fixed point in X, and it lies in K(X), which becomes x. */
static cns_code krawczyk(const cns_reduced *r, arb_ptr x, slong radius_log2, slong prec, bool *proven,
                         cns_error *err)
{
    const int d = r->d;
    arb_ptr box = _arb_vec_init(d);
    arb_mat_t f, middle, jacobian, inverse, product, deviation, image;
    arb_mat_init(f, d, 1);
    arb_mat_init(deviation, d, 1);
    arb_mat_init(image, d, 1);
    arb_mat_init(middle, d, d);
    arb_mat_init(jacobian, d, d);
    arb_mat_init(inverse, d, d);
    arb_mat_init(product, d, d);
    *proven = false;
    cns_code code = linearise(r, x, f, middle, prec, err);
    for (int i = 0; i < d && !code; i++) {
        mag_set_ui_2exp_si(arb_radref(arb_mat_entry(deviation, i, 0)), 1, radius_log2);
        arb_add(box + i, x + i, arb_mat_entry(deviation, i, 0), prec);
    }
    if (!code)
        code = linearise(r, box, image, jacobian, prec, err);
    if (!code) {
        arb_mat_get_mid(middle, middle);
        *proven = arb_mat_approx_inv(inverse, middle, prec) != 0;
    }
    if (!code && *proven) {
        arb_mat_get_mid(inverse, inverse);
        arb_mat_mul(product, inverse, jacobian, prec);
        arb_mat_one(jacobian);
        arb_mat_sub(product, jacobian, product, prec);
        arb_mat_mul(image, product, deviation, prec);
        arb_mat_mul(f, inverse, f, prec);
        arb_mat_sub(image, image, f, prec);
        for (int i = 0; i < d; i++) {
            arb_add(arb_mat_entry(image, i, 0), arb_mat_entry(image, i, 0), x + i, prec);
            *proven = *proven && arb_contains_interior(box + i, arb_mat_entry(image, i, 0));
        }
    }
    if (!code && *proven)
        for (int i = 0; i < d; i++)
            arb_set(x + i, arb_mat_entry(image, i, 0));
    arb_mat_clear(f);
    arb_mat_clear(deviation);
    arb_mat_clear(image);
    arb_mat_clear(middle);
    arb_mat_clear(jacobian);
    arb_mat_clear(inverse);
    arb_mat_clear(product);
    _arb_vec_clear(box, d);
    return code;
}

cns_code cns_fixed_point_find(const cns_reduced *r, const double *guess, slong prec, cns_fixed_point *f,
                              cns_error *err)
{
    slong size_log2 = 0;
    bool proven = false;
    cns_error inner;
    for (int i = 0; i < r->d; i++)
        arb_set_d(f->x + i, guess[i]);
    cns_code code = newton(r, f->x, prec, &size_log2, &inner);
    /* The error left is about the last step, or rounding: the box must hold it with room. */
    slong radius_log2 = (size_log2 > -prec ? size_log2 : -prec) + INFLATION_BITS;
    for (; !code && !proven && radius_log2 < -prec / 4; radius_log2 += INFLATION_BITS)
        code = krawczyk(r, f->x, radius_log2, prec, &proven, &inner);
    if (!code && !proven)
        code = cns_fail(&inner, CNS_NUMERIC, "it could not be proven to be one");
    if (!code) {
        arb_mat_t value;
        arb_mat_init(value, r->d, 1);
        code = linearise(r, f->x, value, f->jacobian, prec, &inner);
        arb_mat_clear(value);
    }
    if (!code)
        code = cns_spectrum_enclose(&f->spectrum, f->jacobian, prec, &inner);
    return code ? cns_fail(err, code, "%s", inner.text) : CNS_OK;
}

bool cns_fixed_point_attracts(const cns_fixed_point *f, const bool *in_states)
{
    const slong prec = 128;
    cns_spectrum of_block;
    arb_mat_t block;
    cns_error ignored;
    int d = 0, row = 0;
    for (int i = 0; i < f->d; i++)
        d += in_states[i];
    cns_spectrum_init(&of_block, d);
    arb_mat_init(block, d, d);
    for (int i = 0; i < f->d; i++) {
        if (!in_states[i])
            continue;
        for (int j = 0, column = 0; j < f->d; j++)
            if (in_states[j])
                arb_set(arb_mat_entry(block, row, column++), arb_mat_entry(f->jacobian, i, j));
        row++;
    }
    bool attracts = d == 0 || !cns_spectrum_enclose(&of_block, block, prec, &ignored);
    for (int i = 0; i < d && attracts; i++)
        attracts = arb_is_negative(acb_realref(of_block.lambda + i)) != 0;
    cns_spectrum_clear(&of_block);
    arb_mat_clear(block);
    return attracts;
}
