/* Block fixed point outside the order loop: storage, conversions, constants, block exponents. */
#include "fixed.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define GRAIN                                                                                                \
    4 /* block exponents are multiples of it: products then often have the same, and share lanes             \
       */
#define RANGE  (1L << 16) /* block exponents are between -RANGE and RANGE; a multiple of GRAIN */
#define MARGIN 2          /* bits by which a block exponent is above the largest coefficient seen */

static long round_up(long e)
{
    const long r = e % GRAIN;
    return r > 0 ? e + GRAIN - r : e - r;
}

static int log2_ceil(unsigned long n)
{
    int e = 0;
    while ((1UL << e) < n)
        e++;
    return e;
}

/* The window W for a working precision of prec bits and N = order. A convolution drops less than (N+1)(L+1)
 * units of the last limb of L (fixed.h): so many bits more are held. 12 more are for a block exponent that is
 * up to GRAIN + MARGIN bits above its series, and for the other roundings, of which each costs a unit. */
static long window_bits(int order, mpfr_prec_t prec)
{
    const unsigned long limbs = (unsigned long)prec / FX_BITS + 2;
    return (long)prec + 12 + log2_ceil(((unsigned long)order + 1) * (limbs + 1));
}

static int limbs_for(long bits)
{
    return bits <= FX_BITS ? 1 : (int)((bits + FX_BITS - 1) / FX_BITS);
}

static _Thread_local size_t allocated; /* bytes, by words() and cells(), since cns_fx_create() began */

/* Zeroed memory, words of 64 bits and aligned as vectors are. *ok becomes false where there is none. */
static void *words(size_t n, bool *ok)
{
    const size_t size = (n * 8 + 63) / 64 * 64;
    void *p = n > SIZE_MAX / 16 ? NULL : aligned_alloc(64, size);
    allocated += size;
    if (p == NULL)
        *ok = false;
    else
        memset(p, 0, size);
    return p;
}

static void *cells(size_t n, size_t size, bool *ok)
{
    void *p = calloc(n, size);
    allocated += n * size;
    if (p == NULL)
        *ok = false;
    return p;
}

static int const_limbs(const fx *F)
{
    return F->max_limbs + 2;
}

static size_t padded_words(const fx *F)
{
    return (size_t)F->pad + (size_t)F->width + 32;
}

static void const_init(const fx *F, fx_const *c, bool *ok)
{
    int64_t *p = words(padded_words(F), ok);
    c->limb = p == NULL ? NULL : p + F->pad;
    c->index = -1;
}

static void const_clear(const fx *F, fx_const *c)
{
    if (c->limb != NULL)
        free(c->limb - F->pad);
}

/* c = x, with the given exponent, |x| < 2^exp. What is below the last limb is cut off. */
static void const_set_scaled(fx *F, fx_const *c, const mpfr_t x, long exp)
{
    c->sign = mpfr_sgn(x);
    c->valid = true;
    c->exp = exp;
    c->used = 0;
    memset(c->limb, 0, (size_t)(const_limbs(F) + 1) * 8);
    if (c->sign == 0)
        return;
    const long bits = (long)FX_BITS * const_limbs(F);
    long e = (long)mpfr_get_z_2exp(F->z, x);
    mpz_abs(F->z, F->z);
    e += bits - exp;
    if (e >= 0)
        mpz_mul_2exp(F->z, F->z, (mp_bitcnt_t)e);
    else
        mpz_fdiv_q_2exp(F->z, F->z, (mp_bitcnt_t)-e);
    if (mpz_sgn(F->z) == 0)
        return;
    const int count = (int)((mpz_sizeinbase(F->z, 2) + FX_BITS - 1) / FX_BITS);
    mpz_export(c->limb + 1 + const_limbs(F) - count, NULL, 1, 8, 0, 64 - FX_BITS, F->z);
    c->used = const_limbs(F);
    while (c->limb[c->used] == 0)
        c->used--;
}

static void const_set(fx *F, fx_const *c, const mpfr_t x)
{
    const_set_scaled(F, c, x, mpfr_zero_p(x) ? 0 : (long)mpfr_get_exp(x));
}

static void set_window(fx *F)
{
    const long bits = F->window = window_bits(F->order, F->prec);
    for (int k = 0; k <= F->order + 1; k++)
        F->rows[k] = limbs_for(bits - (long)F->decay * k + ((long)FX_REACH * k + 7) / 8);
    F->limbs = F->rows[0];
}

fx *cns_fx_create(int n_series, int order, mpfr_prec_t prec, const fx_kernel *kernel)
{
    bool ok = true;
    fx *F = calloc(1, sizeof *F);
    if (F == NULL)
        return NULL;
    allocated = sizeof *F;
    F->kernel = kernel;
    F->n_series = n_series;
    F->order = order;
    F->decay = F->next_decay = 3;
    F->max_prec = F->prec = F->next_prec = prec;
    F->max_limbs = limbs_for(window_bits(order, prec));
    F->width = (F->max_limbs + 8) / 8 * 8;
    F->pad = F->width + 16;
    F->value = F->width + 8;
    F->record = F->value + F->width;
    size_t lines = ((size_t)order + 9 + 7) / 8;
    lines += lines % 2 == 0;
    F->stride = 8 * lines;
    F->H = 1;
    mpz_inits(F->z, F->z2, (mpz_ptr)NULL);
    mpfr_inits2((mpfr_prec_t)FX_BITS * (const_limbs(F) + 1), F->f, F->f2, F->f3, F->g, F->g2, (mpfr_ptr)NULL);

    const size_t n = (size_t)n_series;
    const size_t orders = (size_t)order + 1;
    F->rows = cells(orders + 1, sizeof *F->rows, &ok);
    F->series = cells(n, sizeof *F->series, &ok);
    F->lanes = words(8 * ((size_t)F->max_limbs + 10), &ok);
    F->corr = words(padded_words(F), &ok);
    int64_t **numbers[] = {&F->acc.t, &F->tmp, &F->tmp2, &F->tmp3, &F->zeros};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        int64_t *p = words(padded_words(F), &ok);
        *numbers[i] = p == NULL ? NULL : p + F->pad;
    }
    F->inverse_order = cells(orders, sizeof(fx_const), &ok);
    F->constant = cells(n, sizeof(fx_const), &ok);
    F->step_const = cells(n + 1, sizeof(fx_const), &ok);
    F->next_const = cells(n + 1, sizeof(fx_const), &ok);
    F->reciprocal = cells(n, sizeof(fx_const), &ok);
    F->kept = cells(n, sizeof(mpfr_t), &ok);
    F->has_kept = cells(n, sizeof(bool), &ok);
    F->will_store = cells(n, sizeof(int), &ok);
    if (!ok) {
        cns_fx_destroy(F);
        return NULL;
    }
    for (size_t i = 0; i < n; i++) {
        fx_series *s = &F->series[i];
        s->fwd = words(F->stride * (size_t)F->max_limbs + 8, &ok);
        s->rev = words(F->stride * (size_t)F->max_limbs + 8, &ok);
        s->record = words((orders + 1) * (size_t)F->record, &ok);
        const_init(F, &F->constant[i], &ok);
        const_init(F, &F->reciprocal[i], &ok);
    }
    for (size_t i = 0; i <= n; i++) {
        const_init(F, &F->step_const[i], &ok);
        const_init(F, &F->next_const[i], &ok);
    }
    for (size_t k = 0; k < orders && ok; k++)
        const_init(F, &F->inverse_order[k], &ok);
    const_init(F, &F->tau, &ok);
    if (!ok) {
        cns_fx_destroy(F);
        return NULL;
    }
    F->bytes = allocated;
    for (size_t k = 0; k < orders; k++) {
        mpfr_set_ui(F->f, k + 1, MPFR_RNDN);
        mpfr_ui_div(F->f, 1, F->f, MPFR_RNDN);
        const_set(F, &F->inverse_order[k], F->f);
    }
    set_window(F);
    return F;
}

void cns_fx_destroy(fx *F)
{
    if (F == NULL)
        return;
    const size_t n = (size_t)F->n_series;
    for (size_t i = 0; i < n; i++) {
        if (F->series != NULL) {
            free(F->series[i].fwd);
            free(F->series[i].rev);
            free(F->series[i].record);
        }
        if (F->constant != NULL)
            const_clear(F, &F->constant[i]);
        if (F->reciprocal != NULL)
            const_clear(F, &F->reciprocal[i]);
        if (F->has_kept != NULL && F->kept != NULL && F->has_kept[i])
            mpfr_clear(F->kept[i]);
    }
    for (size_t i = 0; i <= n; i++) {
        if (F->step_const != NULL)
            const_clear(F, &F->step_const[i]);
        if (F->next_const != NULL)
            const_clear(F, &F->next_const[i]);
    }
    for (int k = 0; k <= F->order && F->inverse_order != NULL; k++)
        const_clear(F, &F->inverse_order[k]);
    const_clear(F, &F->tau);
    int64_t *numbers[] = {F->acc.t, F->tmp, F->tmp2, F->tmp3, F->zeros};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        if (numbers[i] != NULL)
            free(numbers[i] - F->pad);
    }
    free(F->rows);
    free(F->series);
    free(F->lanes);
    free(F->corr);
    free(F->inverse_order);
    free(F->constant);
    free(F->step_const);
    free(F->next_const);
    free(F->reciprocal);
    free(F->kept);
    free(F->has_kept);
    free(F->will_store);
    free(F->compiled.step);
    mpz_clears(F->z, F->z2, (mpz_ptr)NULL);
    mpfr_clears(F->f, F->f2, F->f3, F->g, F->g2, (mpfr_ptr)NULL);
    free(F);
}

static int64_t *record_of(const fx *F, const fx_series *s, int k)
{
    return s->record + (size_t)k * (size_t)F->record;
}

static int64_t *value_of(const fx *F, const fx_series *s, int k)
{
    return record_of(F, s, k) + F->value;
}

static bool all_zero(const fx *F, const fx_series *s)
{
    for (int k = 0; k < s->stored; k++) {
        const int64_t *x = value_of(F, s, k);
        for (int i = 0; i <= F->rows[k]; i++) {
            if (x[i] != 0)
                return false;
        }
    }
    return true;
}

long cns_fx_learnt(const fx *F, int a)
{
    const fx_series *s = &F->series[a];
    if (s->constant || !s->live || s->stored == 0)
        return s->live ? s->exp : LONG_MIN;
    if (s->peak > 0)
        return round_up(s->exp + 1 + log2_ceil((unsigned long)s->peak + 1) - FX_BITS + MARGIN);
    if (all_zero(F, s))
        return LONG_MIN;
    return round_up(s->exp - FX_BITS + 2 + MARGIN);
}

void cns_fx_set_exponent(fx *F, int a, long e)
{
    F->series[a].live = e != LONG_MIN;
    if (F->series[a].live)
        F->series[a].exp = e;
}

void cns_fx_begin(fx *F, double H)
{
    for (int i = 0; i < F->n_series; i++) {
        fx_series *s = &F->series[i];
        if (!s->constant) {
            cns_fx_set_exponent(F, i, cns_fx_learnt(F, i));
            s->stored = 0;
            s->peak = 0;
            F->constant[i].valid = false;
        }
        F->reciprocal[i].valid = false;
    }
    F->H = H;
    for (int i = 0; i <= F->n_series; i++) {
        F->step_const[i].valid = false;
        F->next_const[i].index = -1;
    }
    F->raised = 0;
    F->raised_series = -1;
    F->singular = false;
    F->kernel->zero(F);
    if (F->prec == F->next_prec && F->decay == F->next_decay)
        return;
    F->prec = F->next_prec;
    F->decay = F->next_decay;
    set_window(F);
    for (int i = 0; i < F->n_series; i++) {
        if (F->series[i].constant) {
            F->series[i].stored = 0;
            mpfr_set(F->f3, F->kept[i], MPFR_RNDN);
            cns_fx_set(F, i, 0, F->f3, false);
        }
    }
}

void cns_fx_get(const fx *F, mpfr_t y, int a, int k)
{
    const fx_series *s = &F->series[a];
    if (s->constant && k == 0) {
        mpfr_set(y, F->kept[a], MPFR_RNDN);
        return;
    }
    if (!s->live || k >= s->stored) {
        mpfr_set_zero(y, 1);
        return;
    }
    const int rows = F->rows[k];
    const int64_t *x = value_of(F, s, k);
    mpz_ptr z = ((fx *)F)->z2;
    mpz_import(z, (size_t)rows, 1, 8, 0, 64 - FX_BITS, x + 1);
    if (x[0] < 0) {
        mpz_ptr one = ((fx *)F)->z;
        mpz_set_ui(one, 1);
        mpz_mul_2exp(one, one, (mp_bitcnt_t)FX_BITS * (mp_bitcnt_t)rows);
        mpz_sub(z, z, one);
    }
    mpfr_set_z_2exp(y, z, s->exp + 1 - (long)F->decay * k - (long)FX_BITS * rows, MPFR_RNDN);
}

/* Limb i of |x|, limb `last` of x being its last one that is not zero. */
static inline int64_t limb_of_size(const int64_t *x, int last, int i)
{
    if (i > last)
        return 0;
    if (x[0] >= 0)
        return x[i];
    if (i == 0)
        return last == 0;
    return FX_MASK - x[i] + (i == last);
}

double cns_fx_get_2exp(const fx *F, long *e, int a, int k)
{
    const fx_series *s = &F->series[a];
    *e = 0;
    if (!s->live || k >= s->stored)
        return 0;
    const int rows = F->rows[k];
    const int64_t *x = value_of(F, s, k);
    const bool negative = x[0] < 0;
    int last = rows;
    while (last >= 1 && x[last] == 0)
        last--;
    if (last == 0 && !negative)
        return 0;
    int i = 0;
    while (limb_of_size(x, last, i) == 0)
        i++;
    /* Its leading 55 bits or more, and whether there are others below them, in 64: enough to round to double.
     */
    unsigned __int128 m = (unsigned __int128)limb_of_size(x, last, i);
    int used = i;
    while (used < i + 2 && m >> 60 == 0) {
        used++;
        m = m << FX_BITS | (unsigned __int128)limb_of_size(x, last, used);
    }
    bool sticky = last > used;
    const uint64_t above = (uint64_t)(m >> 62);
    const int shift = above == 0 ? 0 : 64 - __builtin_clzl(above);
    if (shift > 0 && (m & (((unsigned __int128)1 << shift) - 1)) != 0)
        sticky = true;
    const uint64_t top = (uint64_t)(m >> shift) << 1 | sticky;
    int f;
    const double d = frexp((double)top, &f);
    *e = f - 1 + shift - (long)FX_BITS * used + s->exp + 1 - (long)F->decay * k;
    return negative ? -d : d;
}

/* From the first two limbs, unless what they hold is small: then digits below would count. */
void cns_fx_leading(const fx *F, double *m, long *e, int a, int n)
{
    enum { ENOUGH = 1 << 12 };
    const fx_series *s = &F->series[a];
    for (int k = 0; k < n; k++) {
        m[k] = 0;
        e[k] = 0;
        if (!s->live || k >= s->stored)
            continue;
        const int64_t *x = value_of(F, s, k), top = x[0] * (FX_MASK + 1) + x[1];
        if (top < ENOUGH && top > -ENOUGH) {
            m[k] = cns_fx_get_2exp(F, &e[k], a, k);
            continue;
        }
        m[k] = (double)top + (F->rows[k] > 1 ? ldexp((double)x[2], -FX_BITS) : 0);
        e[k] = s->exp + 1 - (long)F->decay * k - FX_BITS;
    }
}

void cns_fx_shift(int64_t *out, const int64_t *t, int rows, int t_rows, long shift)
{
    const int64_t far = INT64_C(1) << 61;
    const int64_t sign = t[0] < 0 ? FX_MASK : 0;
    long q = shift / FX_BITS;
    if (shift % FX_BITS < 0)
        q--;
    const int r = (int)(shift - q * FX_BITS);
    int64_t before = 0;
    for (long l = rows + 1; l >= 1; l--) {
        const long i = l + q;
        int64_t digit;
        if (i > t_rows)
            digit = 0;
        else if (i >= 1)
            digit = t[i];
        else if (i == 0)
            digit = t[0] & FX_MASK;
        else if (i == -1)
            digit = (t[0] >> FX_BITS) & FX_MASK;
        else
            digit = sign;
        if (l <= rows)
            out[l] = (int64_t)((uint64_t)digit << r & (uint64_t)FX_MASK) | (before >> (FX_BITS - r));
        before = digit;
    }
    __int128 whole = t[0];
    if (q >= 0) {
        for (long i = 1; i <= q && whole < far && whole > -far; i++)
            whole = whole * (INT64_C(1) << FX_BITS) + (i <= t_rows ? t[i] : 0);
        if (whole < far && whole > -far)
            whole = whole * (INT64_C(1) << r) + (before >> (FX_BITS - r));
    } else {
        const long down = -q * FX_BITS - r;
        whole = t[0] >> (down > 63 ? 63 : down);
    }
    out[0] = whole > far ? far : whole < -far ? -far : (int64_t)whole;
}

/* The least b with |t| < 2^b; LONG_MIN for 0. */
static long bits_of(const int64_t *t, int rows)
{
    if (t[0] != 0 && t[0] != -1)
        return log2_ceil((unsigned long)(t[0] < 0 ? -t[0] : t[0]) + 1);
    const int64_t fill = t[0] < 0 ? FX_MASK : 0;
    for (int i = 1; i <= rows; i++) {
        if (t[i] != fill)
            return log2_ceil((unsigned long)(t[i] ^ fill) + 1) - (long)FX_BITS * i + (t[0] < 0);
    }
    return t[0] < 0 ? 1 - (long)FX_BITS * rows : LONG_MIN;
}

static void write_limbs(fx *F, fx_series *s, int k)
{
    const int64_t *x = value_of(F, s, k);
    for (int i = 0; i < F->rows[k]; i++) {
        const uint64_t u = (uint64_t)((x[i + 1] + (i == 0 ? FX_HALF : 0)) & FX_MASK);
        if (s->parts & FX_FWD)
            s->fwd[(size_t)i * F->stride + (size_t)k] = u;
        if (s->parts & FX_REV)
            s->rev[(size_t)i * F->stride + (size_t)(F->order - k)] = u;
    }
}

void cns_fx_sums(fx *F, int w, int k)
{
    fx_series *s = &F->series[w];
    for (int j = k; j < s->stored && s->parts & FX_SUMS; j++) {
        int64_t *d = record_of(F, s, j);
        int64_t c = 0;
        for (int i = F->rows[j]; i >= 1; i--) {
            int64_t u = d[F->value + i] + c;
            if (i == 1)
                u = ((d[F->value + 1] + FX_HALF) & FX_MASK) + c;
            if (j > 0)
                u += d[i - F->record];
            d[i] = u & FX_MASK;
            c = u >> FX_BITS;
        }
        d[0] = c + (j > 0 ? d[-F->record] : 0);
    }
}

void cns_fx_want(fx *F, int a, int parts)
{
    fx_series *s = &F->series[a];
    s->parts |= parts;
    for (int k = 0; k < s->stored; k++)
        write_limbs(F, s, k);
    cns_fx_sums(F, a, 0);
}

static bool has(const fx_series *s, int parts)
{
    return (s->parts & parts) == parts;
}

/* Either operand may be the one that is read forwards: the way that needs fewer new copies of series is
 * taken. */
bool cns_fx_orient(fx *F, int a, int b)
{
    const fx_series *s = &F->series[a], *t = &F->series[b];
    const int missing = !(s->parts & FX_FWD) + !(t->parts & FX_REV),
              missing_swapped = !(t->parts & FX_FWD) + !(s->parts & FX_REV);
    const bool swap = missing_swapped < missing;
    const int forwards = swap ? b : a, backwards = swap ? a : b;
    if (!has(&F->series[forwards], FX_FWD | FX_SUMS))
        cns_fx_want(F, forwards, FX_FWD | FX_SUMS);
    if (!has(&F->series[backwards], FX_REV | FX_SUMS))
        cns_fx_want(F, backwards, FX_REV | FX_SUMS);
    return swap;
}

void cns_fx_fill(fx *F, int a, int k)
{
    fx_series *s = &F->series[a];
    const int from = s->stored;
    for (int j = from; j <= k; j++) {
        memset(value_of(F, s, j), 0, (size_t)F->width * 8);
        write_limbs(F, s, j);
    }
    if (k >= from) {
        s->stored = k + 1;
        cns_fx_sums(F, a, from);
    }
}

/* exp, but within the range of block exponents. A series leaves it only where H is far too large, so that
 * coefficients grow from order to order like repeated squares: the expansion has failed, and goes on with
 * small numbers until it is thrown away. */
static long bounded(fx *F, long exp)
{
    if (exp <= RANGE && exp >= -RANGE)
        return exp;
    F->singular = true;
    return exp > 0 ? RANGE : -RANGE;
}

void cns_fx_choose(fx *F, int w, int k)
{
    const long bits = bits_of(F->acc.t, F->acc.rows);
    if (bits == LONG_MIN)
        return;
    F->series[w].exp = bounded(F, round_up(bits + F->acc.exp + (long)F->decay * k + MARGIN));
    F->series[w].live = true;
}

/* Raises the block exponent of w until it is above `bits`; what is stored moves down by as many bits. */
static void raise_to(fx *F, int w, long bits)
{
    fx_series *s = &F->series[w];
    const long exp = bounded(F, round_up(bits + MARGIN));
    const long by = exp - s->exp;
    for (int k = 0; k < s->stored; k++) {
        int64_t *x = value_of(F, s, k);
        memcpy(F->tmp3, x, (size_t)(F->rows[k] + 1) * 8);
        cns_fx_shift(x, F->tmp3, F->rows[k], F->rows[k], -by);
        write_limbs(F, s, k);
    }
    s->exp = exp;
    s->peak = by < 63 ? s->peak >> by : 0;
    cns_fx_sums(F, w, 0);
    if (by > F->raised) {
        F->raised = by > 1000000 ? 1000000 : (int)by;
        F->raised_series = w;
    }
}

void cns_fx_raise(fx *F, int w, int k)
{
    raise_to(F, w, bits_of(F->acc.t, F->acc.rows) + F->acc.exp + (long)F->decay * k);
}

void cns_fx_set(fx *F, int w, int k, const mpfr_t y, bool keep)
{
    fx_series *s = &F->series[w];
    F->constant[w].valid = false;
    F->step_const[w].valid = false;
    F->next_const[w].index = -1;
    F->reciprocal[w].valid = false;
    if (keep && k == 0) {
        if (!F->has_kept[w])
            mpfr_init2(F->kept[w], mpfr_get_prec(y));
        else
            mpfr_set_prec(F->kept[w], mpfr_get_prec(y));
        F->has_kept[w] = true;
        mpfr_set(F->kept[w], y, MPFR_RNDN);
        s->constant = true;
        s->live = false;
        s->stored = 0;
    }
    F->kernel->zero(F);
    if (!mpfr_regular_p(y) || mpfr_get_exp(y) > RANGE || mpfr_get_exp(y) < -RANGE) {
        F->singular = F->singular || !mpfr_zero_p(y);
        F->kernel->store(F, w, k);
        return;
    }
    const long decayed = (long)F->decay * k;
    const long bits = (long)mpfr_get_exp(y) + decayed;
    if (!s->live) {
        s->exp = bounded(F, round_up(bits + MARGIN));
        s->live = true;
    } else if (bits >= s->exp) {
        raise_to(F, w, bits);
    }
    if (F->singular) { /* out of range: the value does not fit, and zero is stored */
        F->kernel->store(F, w, k);
        return;
    }
    const int rows = F->rows[k];
    const long e = (long)mpfr_get_z_2exp(F->z, y) + (long)FX_BITS * rows - (s->exp + 1 - decayed);
    if (e >= 0) {
        mpz_mul_2exp(F->z, F->z, (mp_bitcnt_t)e);
    } else {
        mpz_set_ui(F->z2, 1);
        mpz_mul_2exp(F->z2, F->z2, (mp_bitcnt_t)(-e - 1));
        mpz_add(F->z, F->z, F->z2);
        mpz_fdiv_q_2exp(F->z, F->z, (mp_bitcnt_t)-e);
    }
    int64_t *t = F->acc.t;
    const bool negative = mpz_sgn(F->z) < 0;
    if (negative) {
        mpz_set_ui(F->z2, 1);
        mpz_mul_2exp(F->z2, F->z2, (mp_bitcnt_t)(FX_BITS * rows));
        mpz_add(F->z, F->z, F->z2);
    }
    memset(t, 0, (size_t)F->width * 8);
    const size_t used = (mpz_sizeinbase(F->z, 2) + FX_BITS - 1) / FX_BITS;
    if (mpz_sgn(F->z) != 0)
        mpz_export(t + 1 + (size_t)rows - used, NULL, 1, 8, 0, 64 - FX_BITS, F->z);
    t[0] = negative ? -1 : 0;
    F->acc.rows = rows;
    F->acc.exp = s->exp + 1 - decayed;
    F->acc.load = 1;
    F->acc.normal = true;
    F->kernel->store(F, w, k);
}

void cns_fx_prepare_constant(fx *F, int c)
{
    cns_fx_get(F, F->f, c, 0);
    const_set(F, &F->constant[c], F->f);
}

void cns_fx_prepare_step(fx *F, int c)
{
    if (c < 0) {
        mpfr_set_d(F->f, F->H, MPFR_RNDN);
    } else {
        cns_fx_get(F, F->f, c, 0);
        mpfr_mul_d(F->f, F->f, F->H, MPFR_RNDN);
    }
    const_set(F, &F->step_const[c < 0 ? F->n_series : c], F->f);
}

const fx_const *cns_fx_reciprocal(fx *F, int d, int v)
{
    fx_const *c = &F->reciprocal[d];
    if (c->valid && c->index == v)
        return c;
    cns_fx_get(F, F->f, d, v);
    if (mpfr_zero_p(F->f)) {
        F->singular = true;
        c->sign = 0;
        c->valid = true;
        c->index = v;
        return c;
    }
    c->divisor_exp = (long)mpfr_get_exp(F->f);
    /* As many bits as this expansion can use; fewer than there is room for, if its precision is lower. */
    mpfr_set_prec(F->f2, (mpfr_prec_t)FX_BITS * (F->limbs + 3));
    mpfr_ui_div(F->f2, 1, F->f, MPFR_RNDN);
    const_set(F, c, F->f2);
    c->index = v;
    return c;
}

void cns_fx_ratio(fx *F, long p, long q)
{
    fx_number *acc = &F->acc;
    __int128 c = 0;
    if (q < 0) {
        p = -p;
        q = -q;
    }
    for (int i = acc->rows; i >= 1; i--) {
        c += (__int128)acc->t[i] * p;
        acc->t[i] = (int64_t)c & FX_MASK;
        c >>= FX_BITS;
    }
    __int128 rest = (__int128)acc->t[0] * p + c;
    for (int i = 0; i <= acc->rows; i++) {
        if (i > 0)
            rest = rest * (INT64_C(1) << FX_BITS) + acc->t[i];
        __int128 d = rest / q;
        if (d * q > rest)
            d--;
        acc->t[i] = (int64_t)d;
        rest -= d * q;
    }
}

static void sum(fx *F, mpfr_t y, int a, int n, const mpfr_t tau, bool slope)
{
    const_set_scaled(F, &F->tau, tau, F->decay);
    F->kernel->sum(F, a, n, &F->tau, slope);
    const int rows = F->acc.rows;
    const int64_t *t = F->acc.t;
    mpz_import(F->z, (size_t)rows, 1, 8, 0, 64 - FX_BITS, t + 1);
    mpz_set_si(F->z2, (long)t[0]);
    mpz_mul_2exp(F->z2, F->z2, (mp_bitcnt_t)(FX_BITS * rows));
    mpz_add(F->z, F->z, F->z2);
    mpfr_set_z_2exp(y, F->z, F->acc.exp - (long)FX_BITS * rows, MPFR_RNDN);
}

void cns_fx_sum(fx *F, mpfr_t y, int a, int n, const mpfr_t tau)
{
    const fx_series *s = &F->series[a];
    if (n >= s->stored)
        n = s->stored - 1;
    if (!s->live || n < 0)
        mpfr_set_zero(y, 1);
    else
        sum(F, y, a, n, tau, false);
}

void cns_fx_slope(fx *F, mpfr_t y, double *largest, int a, int n, const mpfr_t tau)
{
    const fx_series *s = &F->series[a];
    long e;
    *largest = -HUGE_VAL;
    if (n >= s->stored)
        n = s->stored - 1;
    if (!s->live || n < 1) {
        mpfr_set_zero(y, 1);
        return;
    }
    sum(F, y, a, n, tau, true);
    const double m = mpfr_get_d_2exp(&e, tau, MPFR_RNDN), tau_log2 = log2(m) + (double)e;
    for (int k = 1; k <= n; k++) { /* terms fall at least as k 2^(-3k/4): soon none can be larger */
        const double bound = (double)s->exp + log2(k) + k * (tau_log2 - (double)F->decay);
        if (k >= 2 && bound < *largest)
            break;
        const double x = cns_fx_get_2exp(F, &e, a, k);
        int more;
        frexp(x * k, &more);
        if (x != 0)
            *largest = fmax(*largest, (double)(e + more) + k * tau_log2);
    }
}

const fx_kernel *cns_fx_kernel_find(const char *name)
{
#ifdef FX_HAVE_IFMA
    const bool ifma = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw") &&
                      __builtin_cpu_supports("avx512ifma") && __builtin_cpu_supports("bmi2");
    if (ifma && (strcmp(name, "auto") == 0 || strcmp(name, "avx512ifma") == 0))
        return &cns_fx_kernel_avx512ifma;
#endif
    if (strcmp(name, "auto") == 0 || strcmp(name, "portable") == 0)
        return &cns_fx_kernel_portable;
    return NULL;
}
