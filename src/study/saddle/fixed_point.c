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
    f->lambda = _acb_vec_init(d);
    arb_mat_init(f->jacobian, d, d);
    acb_mat_init(f->right, d, d);
    acb_mat_init(f->left, d, d);
    f->simple = false;
}

void cns_fixed_point_clear(cns_fixed_point *f)
{
    _arb_vec_clear(f->x, f->d);
    _acb_vec_clear(f->lambda, f->d);
    arb_mat_clear(f->jacobian);
    acb_mat_clear(f->right);
    acb_mat_clear(f->left);
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

static bool comes_before(const acb_t a, const acb_t b)
{
    if (!arb_overlaps(acb_realref(a), acb_realref(b)))
        return arb_gt(acb_realref(a), acb_realref(b)) != 0;
    return arf_cmp(arb_midref(acb_imagref(a)), arb_midref(acb_imagref(b))) > 0;
}

/* In the order the header promises, eigenvectors along. */
static void sort(cns_fixed_point *f)
{
    for (int i = 1; i < f->d; i++)
        for (int j = i; j > 0 && comes_before(f->lambda + j, f->lambda + j - 1); j--) {
            acb_swap(f->lambda + j, f->lambda + j - 1);
            for (int k = 0; k < f->d; k++) {
                acb_swap(acb_mat_entry(f->right, k, j), acb_mat_entry(f->right, k, j - 1));
                acb_swap(acb_mat_entry(f->left, j, k), acb_mat_entry(f->left, j - 1, k));
            }
        }
}

/* Balls that meet become one, which holds as many eigenvalues as were balls. */
static void join(acb_ptr lambda, int d, slong prec)
{
    for (int turn = 0; turn < d; turn++)
        for (int i = 0; i < d; i++)
            for (int j = 0; j < d; j++)
                if (i != j && acb_overlaps(lambda + i, lambda + j)) {
                    acb_union(lambda + i, lambda + i, lambda + j, prec);
                    acb_set(lambda + j, lambda + i);
                }
}

/* Scales every column to a size near 1; the bound on |F| wants that. */
static void level_columns(acb_mat_t r, slong prec)
{
    arb_t size, largest;
    arb_init(size);
    arb_init(largest);
    for (slong j = 0; j < acb_mat_ncols(r); j++) {
        arb_zero(largest);
        for (slong i = 0; i < acb_mat_nrows(r); i++) {
            acb_abs(size, acb_mat_entry(r, i, j), prec);
            if (arf_cmp(arb_midref(size), arb_midref(largest)) > 0)
                arb_set(largest, size);
        }
        for (slong i = 0; i < acb_mat_nrows(r); i++) {
            acb_div_arb(acb_mat_entry(r, i, j), acb_mat_entry(r, i, j), largest, prec);
            acb_get_mid(acb_mat_entry(r, i, j), acb_mat_entry(r, i, j));
        }
    }
    arb_clear(size);
    arb_clear(largest);
}

/* Enclosures where some eigenvalues lie together: every eigenvalue of A = R (D + F) R^-1 lies within |F| of
 * an entry of D, and connected unions of these discs hold as many eigenvalues as entries, since that is so
 * for D + s F, 0 <= s <= 1. Approximate eigenvectors of a defective matrix are no basis; those of a matrix a
 * little off are one. */
static bool enclose_groups(cns_fixed_point *f, const acb_mat_t a, slong prec)
{
    const int d = f->d;
    acb_ptr guess = _acb_vec_init(d);
    acb_mat_t near;
    mag_t eps, least;
    arb_t off;
    arb_init(off);
    mag_init(eps);
    mag_init(least);
    acb_mat_init(near, d, d);
    mag_inf(least);
    for (int turn = 0; turn < 2; turn++) {
        acb_mat_get_mid(near, a);
        for (int i = 0; i < d && turn > 0; i++)
            for (int j = 0; j < d; j++) {
                arb_set_ui(off, 1 + (unsigned long)((i * 7 + j * j * 5) % 11));
                arb_mul_2exp_si(off, off, -prec / 2);
                acb_add_arb(acb_mat_entry(near, i, j), acb_mat_entry(near, i, j), off, prec);
            }
        acb_mat_get_mid(near, near);
        acb_mat_approx_eig_qr(guess, NULL, f->right, near, NULL, 0, prec);
        level_columns(f->right, prec);
        acb_mat_eig_global_enclosure(eps, a, guess, f->right, prec);
        if (mag_cmp(eps, least) >= 0)
            continue;
        mag_set(least, eps);
        _acb_vec_set(f->lambda, guess, d);
    }
    for (int i = 0; i < d; i++) {
        acb_get_mid(f->lambda + i, f->lambda + i);
        acb_add_error_mag(f->lambda + i, least);
    }
    join(f->lambda, d, prec);
    const bool found = mag_is_finite(least) != 0;
    arb_clear(off);
    mag_clear(eps);
    mag_clear(least);
    acb_mat_clear(near);
    _acb_vec_clear(guess, d);
    return found;
}

/* Approximate eigenvalues by the QR algorithm, then enclosures: of all of them apart, or, where some lie
 * together, of each group. */
static cns_code spectrum(cns_fixed_point *f, slong prec, cns_error *err)
{
    const int d = f->d;
    acb_mat_t a, near;
    acb_ptr guess = _acb_vec_init(d);
    acb_mat_init(a, d, d);
    acb_mat_init(near, d, d);
    acb_mat_set_arb_mat(a, f->jacobian);
    acb_mat_get_mid(near, a);
    acb_mat_approx_eig_qr(guess, NULL, f->right, near, NULL, 0, prec);
    acb_mat_set(near, f->right);
    f->simple = acb_mat_eig_simple(f->lambda, f->left, f->right, a, guess, near, prec) != 0;
    const bool found = f->simple || enclose_groups(f, a, prec);
    acb_mat_clear(a);
    acb_mat_clear(near);
    _acb_vec_clear(guess, d);
    if (!found)
        return cns_fail(err, CNS_NUMERIC, "the eigenvalues could not be enclosed");
    sort(f);
    return CNS_OK;
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
        code = spectrum(f, prec, &inner);
    return code ? cns_fail(err, code, "%s", inner.text) : CNS_OK;
}

bool cns_fixed_point_is_real(const cns_fixed_point *f, int k)
{
    acb_t mirror;
    bool real = f->simple && arb_contains_zero(acb_imagref(f->lambda + k));
    acb_init(mirror);
    acb_conj(mirror, f->lambda + k);
    for (int i = 0; i < f->d && real; i++)
        real = i == k || !acb_overlaps(mirror, f->lambda + i);
    acb_clear(mirror);
    return real;
}

bool cns_fixed_point_attracts(const cns_fixed_point *f, const bool *in_states)
{
    const slong prec = 128;
    cns_fixed_point block;
    cns_error ignored;
    int d = 0, row = 0;
    for (int i = 0; i < f->d; i++)
        d += in_states[i];
    cns_fixed_point_init(&block, d);
    for (int i = 0; i < f->d; i++) {
        if (!in_states[i])
            continue;
        for (int j = 0, column = 0; j < f->d; j++)
            if (in_states[j])
                arb_set(arb_mat_entry(block.jacobian, row, column++), arb_mat_entry(f->jacobian, i, j));
        row++;
    }
    bool attracts = d == 0 || !spectrum(&block, prec, &ignored);
    for (int i = 0; i < d && attracts; i++)
        attracts = arb_is_negative(acb_realref(block.lambda + i)) != 0;
    cns_fixed_point_clear(&block);
    return attracts;
}
