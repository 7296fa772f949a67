#include "spectrum.h"

void cns_spectrum_init(cns_spectrum *s, int d)
{
    s->d = d;
    s->lambda = _acb_vec_init(d);
    acb_mat_init(s->right, d, d);
    acb_mat_init(s->left, d, d);
    s->simple = false;
}

void cns_spectrum_clear(cns_spectrum *s)
{
    _acb_vec_clear(s->lambda, s->d);
    acb_mat_clear(s->right);
    acb_mat_clear(s->left);
}

static bool comes_before(const acb_t a, const acb_t b)
{
    if (!arb_overlaps(acb_realref(a), acb_realref(b)))
        return arb_gt(acb_realref(a), acb_realref(b)) != 0;
    return arf_cmp(arb_midref(acb_imagref(a)), arb_midref(acb_imagref(b))) > 0;
}

/* In the order the header promises, eigenvectors along. */
static void sort(cns_spectrum *s)
{
    for (int i = 1; i < s->d; i++)
        for (int j = i; j > 0 && comes_before(s->lambda + j, s->lambda + j - 1); j--) {
            acb_swap(s->lambda + j, s->lambda + j - 1);
            for (int k = 0; k < s->d; k++) {
                acb_swap(acb_mat_entry(s->right, k, j), acb_mat_entry(s->right, k, j - 1));
                acb_swap(acb_mat_entry(s->left, j, k), acb_mat_entry(s->left, j - 1, k));
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
static bool enclose_groups(cns_spectrum *s, const acb_mat_t a, slong prec)
{
    const int d = s->d;
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
        acb_mat_approx_eig_qr(guess, NULL, s->right, near, NULL, 0, prec);
        level_columns(s->right, prec);
        acb_mat_eig_global_enclosure(eps, a, guess, s->right, prec);
        if (mag_cmp(eps, least) >= 0)
            continue;
        mag_set(least, eps);
        _acb_vec_set(s->lambda, guess, d);
    }
    for (int i = 0; i < d; i++) {
        acb_get_mid(s->lambda + i, s->lambda + i);
        acb_add_error_mag(s->lambda + i, least);
    }
    join(s->lambda, d, prec);
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
cns_code cns_spectrum_enclose(cns_spectrum *s, const arb_mat_t matrix, slong prec, cns_error *err)
{
    const int d = s->d;
    acb_mat_t a, near;
    acb_ptr guess = _acb_vec_init(d);
    acb_mat_init(a, d, d);
    acb_mat_init(near, d, d);
    acb_mat_set_arb_mat(a, matrix);
    acb_mat_get_mid(near, a);
    acb_mat_approx_eig_qr(guess, NULL, s->right, near, NULL, 0, prec);
    acb_mat_set(near, s->right);
    s->simple = acb_mat_eig_simple(s->lambda, s->left, s->right, a, guess, near, prec) != 0;
    const bool found = s->simple || enclose_groups(s, a, prec);
    acb_mat_clear(a);
    acb_mat_clear(near);
    _acb_vec_clear(guess, d);
    if (!found)
        return cns_fail(err, CNS_NUMERIC, "the eigenvalues could not be enclosed");
    sort(s);
    return CNS_OK;
}

bool cns_spectrum_is_real(const cns_spectrum *s, int k)
{
    acb_t mirror;
    bool real = s->simple && arb_contains_zero(acb_imagref(s->lambda + k));
    acb_init(mirror);
    acb_conj(mirror, s->lambda + k);
    for (int i = 0; i < s->d && real; i++)
        real = i == k || !acb_overlaps(mirror, s->lambda + i);
    acb_clear(mirror);
    return real;
}
