/* The primitives of block fixed point, called one by one: what the engine calls for every coefficient.
 * Compiled once per kernel. The including file defines FX_KERNEL_NAME, FX_KERNEL and the kernel itself, the
 * functions on limbs, all of which sum the same limb pairs exactly, so that every kernel gives the same bits:
 *   k_conv(lanes, load, rows, a, b, stride, lo, hi, sign)         lanes += sign * sum_{j=lo..hi} a[j] b[j];
 *                                                                 *load = 0: the lanes were empty
 *   k_square(lanes, load, rows, a, b, stride, lo, hi, mid, sign)  lanes += sign * (2 sum + a[mid] b[mid]);
 *                                                                 mid = -1: the sum only
 *   k_carry_lanes(lanes, load, rows)                              carries from column to column, lane by lane
 *   k_reduce(t, lanes, columns)                                   t[p] = the sum of the lanes of column p
 *   k_mul(out, x, rows, c)       out = floor(x c), of the limb pairs i + j <= rows + 1, normalised:
 *                                out[1..rows + 1] are limbs
 *   k_mul_short(out, x, rows, c)                                  the same where c->used <= 1, not normalised
 *   k_carry(t, rows)                                              normalises t
 *   BEFORE(p), AFTER(p)                                           the vectors at p - 1 and p + 1
 * k_name_one does the same as k_name on a number of one vector, eight words, in a register; order_compiled.h
 * says what more it asks for. Nothing here allocates, divides or converts. */
#include "fixed.h"

/* Vectors of eight limbs: the arrays of numbers are padded to whole ones. What lies beyond the last limb of a
 * number is arbitrary; sums and shifts to the left are unsigned, so that nothing is undefined where it
 * overflows. */
typedef int64_t fx_v __attribute__((vector_size(64), aligned(8), may_alias));
typedef uint64_t fx_u __attribute__((vector_size(64), aligned(8), may_alias));
#define V(p)  (*(fx_u *)(p))
#define CV(p) (*(const fx_u *)(p))
#define SV(p) (*(const fx_v *)(p))

static inline int vectors(int rows)
{
    return (rows + 8) >> 3; /* covering t[0..rows] */
}

/* Does something for every vector v of t[0..rows]; most numbers have only one. */
#define EACH_VECTOR(rows, ...)                                                                               \
    do {                                                                                                     \
        if ((rows) < 8) {                                                                                    \
            enum { v = 0 };                                                                                  \
            __VA_ARGS__;                                                                                     \
        } else {                                                                                             \
            for (int v = 0; v < vectors(rows); v++)                                                          \
                __VA_ARGS__;                                                                                 \
        }                                                                                                    \
    } while (0)

static inline void normalise(fx_number *x)
{
    if (!x->normal) {
        k_carry(x->t, x->rows);
        x->normal = true;
        x->load = 1;
    }
}

/* out = t 2^(-shift), shift >= 0, t normalised, with zeros before t[0]. The value is right, but a negative
 * one is not normalised: the sign stays in the limb to which t[0] has moved, instead of filling those before
 * it. To be added to something, it need not be. */
static inline void shift_down(int64_t *out, const int64_t *t, int rows, long shift)
{
    if (shift > (long)FX_BITS * rows) {
        const long left = shift - (long)FX_BITS * rows;
        const int64_t whole = t[0]; /* out may be t */
        EACH_VECTOR(rows, V(out + 8 * v) = (fx_u){0});
        out[rows] = whole >> (left > 63 ? 63 : left);
        return;
    }
    const int q = (int)(shift / FX_BITS);
    const int r = (int)(shift % FX_BITS);
    for (int v = vectors(rows) - 1; v >= 0; v--) {
        const int64_t *const s = t + 8 * v - q;
        V(out + 8 * v) = (fx_u)(SV(s) >> r) + ((CV(s - 1) << (FX_BITS - r)) & (uint64_t)FX_MASK);
    }
}

/* weight * x * 2^shift: where the weight is 1 or -1, by a faster way than multiplying. */
#define TIMES(x, shift) (size == 1 ? ((CV(x) << (uint64_t)(shift)) ^ flip) - flip : CV(x) * (w << (shift)))

/* acc += weight * x 2^exp; x is normalised, and an array of a number or part of a record; |weight| <= 128.
 * The one of the two with the lower exponent sets the scale where that is at most 7 bits off; otherwise it is
 * moved down to the other's. */
static void add(fx *F, const int64_t *x, int rows, long exp, int weight)
{
    fx_number *acc = &F->acc;
    const uint64_t w = (uint64_t)(int64_t)weight;
    const int size = weight < 0 ? -weight : weight;
    const uint64_t flip = weight < 0 ? ~UINT64_C(0) : 0;
    if (acc->load == 0) {
        EACH_VECTOR(rows, V(acc->t + 8 * v) = TIMES(x + 8 * v, 0));
        acc->rows = rows;
        acc->load = size;
        acc->exp = exp;
        acc->normal = weight == 1;
        return;
    }
    if (rows > acc->rows) {
        for (int i = acc->rows + 1; i < 8 * vectors(rows); i++)
            acc->t[i] = 0;
        acc->rows = rows;
    } else if (rows < acc->rows) {
        for (int i = 0; i < 8 * vectors(acc->rows); i++)
            F->tmp3[i] = i <= rows ? x[i] : 0;
        x = F->tmp3;
        rows = acc->rows;
    }
    const long shift = exp - acc->exp;
    if (shift >= 0 && shift <= 7 && (size << shift) <= 128) {
        if (acc->load + (size << shift) > FX_MAX_LOAD)
            normalise(acc);
        EACH_VECTOR(rows, V(acc->t + 8 * v) += TIMES(x + 8 * v, shift));
        acc->load += size << shift;
    } else if (shift < 0 && shift >= -7) {
        if ((acc->load << -shift) + size > FX_MAX_LOAD)
            normalise(acc);
        const int s = (int)-shift;
        EACH_VECTOR(rows, V(acc->t + 8 * v) = (CV(acc->t + 8 * v) << s) + TIMES(x + 8 * v, 0));
        acc->load = (acc->load << s) + size;
        acc->exp = exp;
    } else if (shift < 0) {
        if (-shift >= 8 * FX_BITS && x != F->tmp &&
            x != F->tmp3) { /* a record has only eight zeros before x */
            EACH_VECTOR(rows, V(F->tmp3 + 8 * v) = CV(x + 8 * v));
            x = F->tmp3;
        }
        shift_down(F->tmp2, x, rows, -shift);
        if (acc->load + size > FX_MAX_LOAD)
            normalise(acc);
        EACH_VECTOR(rows, V(acc->t + 8 * v) += TIMES(F->tmp2 + 8 * v, 0));
        acc->load += size;
    } else {
        normalise(acc);
        shift_down(acc->t, acc->t, rows, shift);
        EACH_VECTOR(rows, V(acc->t + 8 * v) += TIMES(x + 8 * v, 0));
        acc->load = 1 + size;
        acc->exp = exp;
    }
    acc->normal = false;
}

/* Vector v of a mask that has the limbs 0..rows of a number. */
static const uint64_t mask_words[16] = {~UINT64_C(0), ~UINT64_C(0), ~UINT64_C(0), ~UINT64_C(0),
                                        ~UINT64_C(0), ~UINT64_C(0), ~UINT64_C(0), ~UINT64_C(0)};

static inline const uint64_t *below_row(int rows, int v)
{
    const int n = rows + 1 - 8 * v;
    return mask_words + (n >= 8 ? 0 : n <= 0 ? 8 : 8 - n);
}

/* Adds what is in the lanes to the accumulator: the sum of products u v, without its bias (fixed.h), which is
 * 2 sum u v - (sum u + sum v) + (number of terms)/2 at the exponent of the lanes, 2^(e_a + e_b + 1 - d n). */
static void flush(fx *F)
{
    const int rows = F->lanes_rows;
    int64_t *t = F->acc.load == 0 ? F->acc.t : F->tmp;
    if (8 * F->lanes_load > FX_SUM_LOAD)
        k_carry_lanes(F->lanes, &F->lanes_load, rows);
    const uint64_t terms = (uint64_t)F->terms;
    const fx_u count = {(uint64_t)(F->terms >> 1), (terms & 1) * (uint64_t)FX_HALF};
    if (rows < 7) {
        fx_u x;
        k_reduce_one(&x, F->lanes, rows + 2);
        x = x * 2 - (CV(F->corr) & CV(below_row(rows, 0))) + count;
        k_carry_one(&x, rows + 1);
        V(t) = x;
    } else {
        k_reduce(t, F->lanes, rows + 2);
        V(t) = CV(t) * 2 - (CV(F->corr) & CV(below_row(rows, 0))) + count;
        for (int v = 1; v < vectors(rows + 1); v++)
            V(t + 8 * v) = CV(t + 8 * v) * 2 - (CV(F->corr + 8 * v) & CV(below_row(rows, v)));
        k_carry(t, rows + 1);
    }
    F->lanes_used = false;
    if (t == F->acc.t) {
        F->acc.rows = rows;
        F->acc.load = 1;
        F->acc.exp = F->lanes_exp;
        F->acc.normal = true;
    } else {
        add(F, t, rows, F->lanes_exp, 1);
    }
}

static inline void open_lanes(fx *F, int rows, long exp)
{
    if (F->lanes_used) {
        if (F->lanes_rows == rows && F->lanes_exp == exp)
            return;
        flush(F);
    }
    F->lanes_used = true;
    F->lanes_rows = rows;
    F->lanes_exp = exp;
    F->lanes_load = F->corr_load = 0;
    F->terms = 0;
}

static inline int64_t *record_at(const fx *F, const fx_series *s, int k)
{
    return s->record + (size_t)k * (size_t)F->record;
}

/* D_k is D_(k-1) + u_k, normalised at every sixteenth order only: its limbs stay below 17 * 2^52. */
#define SUM_LOAD 17

/* Takes weight * (u_lo + ... + u_hi) = weight * (D_hi - D_(lo - 1)) into the correction of the lanes. */

static inline void correct(fx *F, int rows, int weight, const fx_series *s, int lo, int hi)
{
    const int64_t *d = record_at(F, s, hi);
    const int64_t *below = lo == 0 ? F->zeros : record_at(F, s, lo - 1);
    const uint64_t flip = weight < 0 ? ~UINT64_C(0) : 0;
    const int twice = weight == 2 || weight == -2; /* +-1 or +-2 */
    if (F->corr_load > FX_CORR_LOAD - 4 * SUM_LOAD) {
        k_carry(F->corr, rows);
        F->corr_load = 1;
    }
    const uint64_t old = F->corr_load == 0 ? 0 : ~UINT64_C(0);
    EACH_VECTOR(rows, V(F->corr + 8 * v) = (CV(F->corr + 8 * v) & old) +
                                           (((CV(d + 8 * v) - CV(below + 8 * v)) << twice) ^ flip) - flip);
    F->corr_load += 4 * SUM_LOAD;
}

static void f_zero(fx *F)
{
    F->acc.load = 0;
    F->lanes_used = false;
}

static void add_weighted(fx *F, const int64_t *x, int rows, long exp, int weight)
{
    if (weight >= -128 && weight <= 128) {
        if (weight != 0)
            add(F, x, rows, exp, weight);
        return;
    }
    __int128 c = 0;
    for (int i = rows; i >= 1; i--) {
        c += (__int128)x[i] * weight;
        F->tmp[i] = (int64_t)c & FX_MASK;
        c >>= FX_BITS;
    }
    F->tmp[0] = x[0] * weight + (int64_t)c;
    add(F, F->tmp, rows, exp, 1);
}

static void f_coef(fx *F, int weight, int a, int k)
{
    fx_series *s = &F->series[a];
    if (!s->live || k >= s->stored)
        return;
    const int rows = F->rows[k];
    add_weighted(F, record_at(F, s, k) + F->value, rows, s->exp + 1 - (long)F->decay * k, weight);
}

static void f_scaled(fx *F, int sign, int c, int a, int k)
{
    fx_series *s = &F->series[a];
    if (!F->constant[c].valid)
        cns_fx_prepare_constant(F, c);
    const fx_const *m = &F->constant[c];
    if (!s->live || k >= s->stored || m->sign == 0)
        return;
    const int rows = F->rows[k];
    k_mul(F->tmp, record_at(F, s, k) + F->value, rows, m);
    add(F, F->tmp, rows, s->exp + 1 - (long)F->decay * k + m->exp, sign);
}

static inline bool has(const fx_series *s, int parts)
{
    return (s->parts & parts) == parts;
}

static void f_conv(fx *F, int sign, int a, int b, int n, int lo, int hi)
{
    fx_series *s = &F->series[a], *t = &F->series[b];
    if (lo > hi || !s->live || !t->live)
        return;
    if ((!has(s, FX_FWD | FX_SUMS) || !has(t, FX_REV | FX_SUMS)) && cns_fx_orient(F, a, b)) {
        const int swap = a, swap_lo = lo;
        fx_series *const swap_series = s;
        a = b;
        b = swap;
        s = t;
        t = swap_series;
        lo = n - hi;
        hi = n - swap_lo;
    }
    if (s->stored <= hi)
        cns_fx_fill(F, a, hi);
    if (t->stored <= n - lo)
        cns_fx_fill(F, b, n - lo);
    const int rows = F->rows[n];
    open_lanes(F, rows, s->exp + t->exp + 1 - (long)F->decay * n);
    correct(F, rows, sign, s, lo, hi);
    correct(F, rows, sign, t, n - hi, n - lo);
    F->terms += sign * (hi - lo + 1);
    k_conv(F->lanes, &F->lanes_load, rows, s->fwd, t->rev + (F->order - n), F->stride, lo, hi, sign);
}

static void f_square(fx *F, int sign, int a, int n, int lo)
{
    fx_series *s = &F->series[a];
    if (lo > n - lo || !s->live)
        return;
    if (!has(s, FX_FWD | FX_REV | FX_SUMS))
        cns_fx_want(F, a, FX_FWD | FX_REV | FX_SUMS);
    if (s->stored <= n - lo)
        cns_fx_fill(F, a, n - lo);
    const int rows = F->rows[n];
    open_lanes(F, rows, 2 * s->exp + 1 - (long)F->decay * n);
    correct(F, rows, 2 * sign, s, lo, n - lo);
    F->terms += sign * (n - 2 * lo + 1);
    k_square(F->lanes, &F->lanes_load, rows, s->fwd, s->rev + (F->order - n), F->stride, lo, (n - 1) >> 1,
             n % 2 == 0 ? n / 2 : -1, sign);
}

/* Completes and normalises the accumulator; false: it is an empty sum. */
static inline bool finish(fx *F)
{
    if (F->lanes_used)
        flush(F);
    if (F->acc.load == 0)
        return false;
    normalise(&F->acc);
    return true;
}

#define ALL_LIMBS(m0)                                                                                        \
    {                                                                                                        \
        (m0), (uint64_t)FX_MASK, (uint64_t)FX_MASK, (uint64_t)FX_MASK, (uint64_t)FX_MASK, (uint64_t)FX_MASK, \
            (uint64_t)FX_MASK, (uint64_t)FX_MASK                                                             \
    }

/* w_k = the accumulator, normalised, or 0. The limbs are written wherever convolutions will read them. */
static void put(fx *F, int w, int k, bool nonzero)
{
    fx_series *s = &F->series[w];
    const int rows = F->rows[k];
    if (k > s->stored)
        cns_fx_fill(F, w, k - 1);
    if (nonzero && !s->live)
        cns_fx_choose(F, w, k);
    int64_t *record = record_at(F, s, k);
    int64_t *x = record + F->value;
    if (!nonzero || !s->live) {
        EACH_VECTOR(rows, V(x + 8 * v) = (fx_u){0});
    } else {
        const fx_number *acc = &F->acc;
        const int64_t *t = acc->t;
        const fx_u whole_first = ALL_LIMBS(~UINT64_C(0)), limb_mask = ALL_LIMBS((uint64_t)FX_MASK);
        const long shift = acc->exp - (s->exp + 1 - (long)F->decay * k);
        if (acc->rows >= rows && shift <= 0 && shift > -FX_BITS) {
            const int r = (int)-shift;
            EACH_VECTOR(rows, V(x + 8 * v) = (fx_u)(SV(t + 8 * v) >> r) +
                                             ((BEFORE(t + 8 * v) << (FX_BITS - r)) & (uint64_t)FX_MASK));
        } else if (acc->rows > rows && shift > 0 && shift < FX_BITS && t[0] >= -1024 && t[0] < 1024) {
            const int l = (int)shift;
            EACH_VECTOR(rows, V(x + 8 * v) = ((CV(t + 8 * v) << l) & (v == 0 ? whole_first : limb_mask)) +
                                             (AFTER(t + 8 * v) >> (FX_BITS - l)));
        } else {
            cns_fx_shift(x, t, rows, acc->rows, shift);
        }
        const int64_t first = x[1] + FX_HALF;
        if (x[0] + (first >> FX_BITS) != 0) {
            cns_fx_raise(F, w, k);
            put(F, w, k, !F->singular); /* out of range, the expansion has failed: zero will do */
            return;
        }
    }
    const int64_t top = x[0] < 0 ? FX_MASK - x[1] : x[1];
    s->peak = top > s->peak ? top : s->peak;

    /* u = x + 1/2, in [0, 1): its integer part has been found to be 0. */
    const uint64_t first_limb = (uint64_t)((x[1] + FX_HALF) & FX_MASK);
    const size_t stride = F->stride;
    const uint64_t *u = (const uint64_t *)x + 1;
    if (s->parts & FX_FWD) {
        uint64_t *fwd = s->fwd + k;
        *fwd = first_limb;
        for (int i = 1; i < rows; i++)
            *(fwd += stride) = u[i];
    }
    if (s->parts & FX_REV) {
        uint64_t *rev = s->rev + (F->order - k);
        *rev = first_limb;
        for (int i = 1; i < rows; i++)
            *(rev += stride) = u[i];
    }
    if (k < s->stored) {
        cns_fx_sums(F, w, k);
        return;
    }
    s->stored = k + 1;
    if (!(s->parts & FX_SUMS))
        return;
    const fx_u half = {0, (uint64_t)FX_HALF};
    const fx_u no_whole = ALL_LIMBS(0);
    const fx_u u0 = (CV(x) + half) & no_whole;
    if (k == 0) {
        V(record) = u0;
        for (int v = 1; v < vectors(rows); v++)
            V(record + 8 * v) = CV(x + 8 * v);
    } else {
        const int64_t *before = record - F->record;
        V(record) = CV(before) + u0;
        for (int v = 1; v < vectors(rows); v++)
            V(record + 8 * v) = CV(before + 8 * v) + CV(x + 8 * v);
        if (k % 16 == 0 || F->rows[k] != F->rows[k + 1])
            k_carry(record, rows);
    }
}

static void f_store(fx *F, int w, int k)
{
    put(F, w, k, finish(F));
}

/* acc *= c; the product has one limb more. False: it is zero. */
static inline bool times(fx *F, const fx_const *c)
{
    if (c->sign == 0)
        return false;
    k_mul(F->tmp, F->acc.t, F->acc.rows, c);
    int64_t *t = F->tmp;
    F->tmp = F->acc.t;
    F->acc.t = t;
    F->acc.rows++;
    F->acc.exp += c->exp;
    return true;
}

static void f_store_scaled(fx *F, int w, int k, int c)
{
    if (!F->constant[c].valid)
        cns_fx_prepare_constant(F, c);
    put(F, w, k, finish(F) && times(F, &F->constant[c]));
}

static void f_store_over(fx *F, int w, int k, int d, int v, int twice)
{
    const fx_const *c = &F->reciprocal[d];
    if (!c->valid || c->index != v)
        c = cns_fx_reciprocal(F, d, v);
    const bool nonzero = finish(F) && times(F, c);
    F->acc.exp -= twice != 0;
    put(F, w, k, nonzero);
}

static void f_store_ratio(fx *F, int w, int k, int p, int q)
{
    bool nonzero = finish(F);
    if (nonzero && p == 1 && q >= 1 && q <= F->order + 1)
        nonzero = times(F, &F->inverse_order[q - 1]);
    else if (nonzero)
        cns_fx_ratio(F, p, q);
    put(F, w, k, nonzero);
}

static void f_store_next(fx *F, int w, int k, int c)
{
    bool nonzero = finish(F);
    if (nonzero) {
        const int slot = c < 0 ? F->n_series : c;
        const fx_const *step = &F->step_const[slot];
        fx_const *next = &F->next_const[slot];
        if (!step->valid)
            cns_fx_prepare_step(F, c);
        const int rows = F->acc.rows + 1;
        if (next->index != k || next->for_rows != rows) {
            const fx_const *inverse = &F->inverse_order[k];
            k_mul(next->limb, step->limb, rows, inverse);
            next->sign = step->sign;
            next->exp = step->exp + inverse->exp;
            next->index = k;
            next->used = rows + 1;
            next->for_rows = rows;
        }
        nonzero = times(F, next);
    }
    put(F, w, k + 1, nonzero);
}

/* Horner's rule from order n down: t = t c + x_k. t has one limb more than x_k, as what a product drops is
 * some units of the last limb of t. For a slope, k x_k takes the place of x_k. */
static void f_sum(fx *F, int a, int n, const fx_const *c, bool slope)
{
    const fx_series *s = &F->series[a];
    const int least = slope ? 1 : 0;
    int64_t *t = F->tmp, *next = F->tmp2;
    int rows = 0; /* of t */
    int k = n;
    f_zero(F);
    if (c->used <= 1 && c->sign != 0 && F->rows[n] < FX_ONE_ROWS) { /* high orders in one vector */
        fx_u sum = {0}, product;
        for (; k >= least && F->rows[k] < FX_ONE_ROWS; k--) {
            const int now = F->rows[k];
            fx_u x = CV(record_at(F, s, k) + F->value) & CV(below_row(now, 0));
            if (slope)
                x *= (uint64_t)k;
            if (now + 1 > rows) {
                sum &= CV(below_row(rows, 0));
                rows = now + 1;
            }
            k_mul_short_one(&product, &sum, rows, c);
            sum = product + x;
            k_carry_one(&sum, rows + 1);
        }
        V(t) = sum;
    }
    for (; k >= least; k--) {
        const int64_t *x = record_at(F, s, k) + F->value;
        const int now = F->rows[k];
        const uint64_t weight = slope ? (uint64_t)k : 1;
        if (k == n || c->sign == 0) {
            EACH_VECTOR(now, V(t + 8 * v) = CV(x + 8 * v) * weight);
            rows = now + 1;
            t[rows] = 0;
            if (slope)
                k_carry(t, rows);
            continue;
        }
        while (rows < now + 1)
            t[++rows] = 0;
        if (c->used <= 1)
            k_mul_short(next, t, rows, c);
        else
            k_mul(next, t, rows, c);
        if (slope)
            EACH_VECTOR(now, V(next + 8 * v) += CV(x + 8 * v) * weight & CV(below_row(now, v)));
        else
            EACH_VECTOR(now, V(next + 8 * v) += CV(x + 8 * v) & CV(below_row(now, v)));
        k_carry(next, rows + 1);
        int64_t *swap = t;
        t = next;
        next = swap;
    }
    EACH_VECTOR(rows, V(F->acc.t + 8 * v) = CV(t + 8 * v));
    F->acc.rows = rows;
    F->acc.load = 1;
    F->acc.normal = true;
    F->acc.exp = s->exp + 1 - (slope ? F->decay : 0);
}
