/* The portable kernel (order_by_calls.h). The products of limb i and limb j with the same i + j = p, a
 * diagonal, have the same weight: they are summed in 128 bits, and the sum goes to three columns. Of the
 * eight lanes of a column only the first is used. */
#include "fixed.h"

typedef unsigned __int128 wide;

enum {
    MOST_ROWS = 1024, /* the fast arithmetic has fewer (MAX_PREC in arith/fast.c) */
    BLOCK = 128,      /* terms of a convolution at a time: they stay in the first-level cache */
    FEW_ROWS = 5      /* up to so many rows diagonal() is faster than diagonals() */
};

static wide row_product(const uint64_t *a, const uint64_t *b, int lo, int hi)
{
    wide s0 = 0, s1 = 0;
    int j = lo;
    for (; j < hi; j += 2) {
        s0 += (wide)a[j] * b[j];
        s1 += (wide)a[j + 1] * b[j + 1];
    }
    if (j == hi)
        s0 += (wide)a[j] * b[j];
    return s0 + s1;
}

/* Diagonal p of the products of terms lo..hi, pair by pair. */
static wide diagonal(const uint64_t *a, const uint64_t *b, size_t stride, int p, int lo, int hi)
{
    wide s0 = 0, s1 = 0;
    int i = 0;
    for (; i + 1 <= p; i += 2) {
        const uint64_t *a0 = a + (size_t)i * stride, *a1 = a0 + stride;
        const uint64_t *b1 = b + (size_t)(p - i - 1) * stride, *b0 = b1 + stride;
        for (int j = lo; j <= hi; j++) {
            s0 += (wide)a0[j] * b0[j];
            s1 += (wide)a1[j] * b1[j];
        }
    }
    if (i == p)
        s0 += row_product(a + (size_t)i * stride, b, lo, hi);
    return s0 + s1;
}

/* All diagonals with half the multiplications: for i < j
 *     a_i b_j + a_j b_i = (a_i + a_j)(b_i + b_j) - a_i b_i - a_j b_j,
 * and what is subtracted from diagonal p is, over all its pairs, the sum of a_i b_i over i <= p, but twice
 * the middle one. Sums modulo 2^128, the results being below 2^(104 + 10 + 7). */
static void diagonals(wide *s, const uint64_t *a, const uint64_t *b, size_t stride, int rows, int lo, int hi)
{
    wide own[MOST_ROWS], sum = 0;
    for (int i = 0; i < rows; i++)
        own[i] = row_product(a + (size_t)i * stride, b + (size_t)i * stride, lo, hi);
    for (int p = 0; p < rows; p++) {
        sum += own[p];
        s[p] = (p % 2 == 0 ? 2 * own[p / 2] : 0) - sum;
    }
    for (int i = 0; 2 * i + 1 < rows; i++) {
        const uint64_t *ai = a + (size_t)i * stride, *bi = b + (size_t)i * stride;
        const uint64_t *a0 = ai + stride, *b0 = bi + stride;
        int p = 2 * i + 1;
        for (; p + 1 < rows; p += 2) {
            const uint64_t *a1 = a0 + stride, *b1 = b0 + stride;
            wide s0 = 0, s1 = 0;
            for (int j = lo; j <= hi; j++) {
                const uint64_t x = ai[j], y = bi[j];
                s0 += (wide)(x + a0[j]) * (y + b0[j]);
                s1 += (wide)(x + a1[j]) * (y + b1[j]);
            }
            s[p] += s0;
            s[p + 1] += s1;
            a0 = a1 + stride;
            b0 = b1 + stride;
        }
        if (p < rows) {
            wide s0 = 0;
            for (int j = lo; j <= hi; j++)
                s0 += (wide)(ai[j] + a0[j]) * (bi[j] + b0[j]);
            s[p] += s0;
        }
    }
}

static void block(wide *s, const uint64_t *a, const uint64_t *b, size_t stride, int rows, int lo, int hi)
{
    if (rows > FEW_ROWS && hi > lo) {
        diagonals(s, a, b, stride, rows, lo, hi);
        return;
    }
    for (int p = 0; p < rows; p++)
        s[p] = diagonal(a, b, stride, p, lo, hi);
}

typedef uint64_t vector __attribute__((vector_size(64), aligned(8), may_alias));
#define BEFORE(p) (*(const vector *)((p)-1))
#define AFTER(p)  (*(const vector *)((p) + 1))

static inline void scatter(int64_t *lanes, int p, wide s, int sign)
{
    const int64_t w = sign;
    lanes[8 * (p + 2)] += w * ((int64_t)s & FX_MASK);
    lanes[8 * (p + 1)] += w * ((int64_t)(s >> FX_BITS) & FX_MASK);
    lanes[8 * p] += w * (int64_t)(s >> (2 * FX_BITS));
}

static void k_carry_lanes(int64_t *lanes, int *load, int rows)
{
    for (int p = rows + 1; p >= 1; p--) {
        lanes[8 * (p - 1)] += lanes[8 * p] >> FX_BITS;
        lanes[8 * p] &= FX_MASK;
    }
    *load = 2;
}

static void scatter_all(int64_t *lanes, int *load, int rows, const wide *s, int sign)
{
    if (*load == 0)
        for (int p = 0; p < rows + 2; p++)
            lanes[8 * p] = 0;
    for (int p = 0; p < rows; p++)
        scatter(lanes, p, s[p], sign);
    *load += 3;
    if (*load > 40)
        k_carry_lanes(lanes, load, rows);
}

static void k_conv(int64_t *lanes, int *load, int rows, const uint64_t *a, const uint64_t *b, size_t stride,
                   int lo, int hi, int sign)
{
    wide s[MOST_ROWS];
    for (int j = lo; j <= hi; j += BLOCK) {
        block(s, a, b, stride, rows, j, hi - j < BLOCK ? hi : j + BLOCK - 1);
        scatter_all(lanes, load, rows, s, sign);
    }
}

static void k_square(int64_t *lanes, int *load, int rows, const uint64_t *a, const uint64_t *b, size_t stride,
                     int lo, int hi, int mid, int sign)
{
    wide s[MOST_ROWS];
    for (int j = lo; j <= hi; j += BLOCK) {
        const bool last = hi - j < BLOCK;
        block(s, a, b, stride, rows, j, last ? hi : j + BLOCK - 1);
        for (int p = 0; p < rows; p++) {
            s[p] *= 2;
            if (last && mid >= 0)
                s[p] += diagonal(a, b, stride, p, mid, mid);
        }
        scatter_all(lanes, load, rows, s, sign);
    }
    if (hi < lo && mid >= 0)
        k_conv(lanes, load, rows, a, b, stride, mid, mid, sign);
}

static inline void k_carry(int64_t *t, int rows)
{
    int64_t c = 0;
    for (int i = rows; i >= 1; i--) {
        const int64_t s = t[i] + c;
        t[i] = s & FX_MASK;
        c = s >> FX_BITS;
    }
    t[0] += c;
}

static inline void k_reduce(int64_t *t, const int64_t *lanes, int columns)
{
    for (int p = 0; p < columns; p++)
        t[p] = lanes[8 * p];
}

static inline void k_reduce_one(vector *x, const int64_t *lanes, int columns)
{
    k_reduce((int64_t *)x, lanes, columns);
}

static inline void k_carry_one(vector *x, int rows)
{
    k_carry((int64_t *)x, rows);
}

static inline void k_mul(int64_t *out, const int64_t *x, int rows, const fx_const *c)
{
    __int128 s = 0;
    for (int p = rows + 1; p >= 1; p--) {
        const int least = p > c->used ? p - c->used : 0;
        __int128 d = 0;
        for (int i = p <= rows ? p - 1 : rows; i >= least; i--)
            d += (__int128)x[i] * c->limb[p - i];
        s += c->sign < 0 ? -d : d;
        out[p] = (int64_t)s & FX_MASK;
        s >>= FX_BITS;
    }
    out[0] = (int64_t)s;
}

static inline void k_mul_short(int64_t *out, const int64_t *x, int rows, const fx_const *c)
{
    k_mul(out, x, rows, c);
}

static inline void k_mul_short_one(vector *out, const vector *x, int rows, const fx_const *c)
{
    k_mul((int64_t *)out, (const int64_t *)x, rows, c);
}

static inline void k_mul_one(vector *out, const int64_t *x, int rows, const fx_const *c)
{
    k_mul((int64_t *)out, x, rows, c);
}

static inline void k_conv_one(int64_t *lanes, int *load, int rows, const uint64_t *a, const uint64_t *b,
                              size_t stride, int lo, int hi, int sign, bool open, bool close, vector *x)
{
    (void)open;
    k_conv(lanes, load, rows, a, b, stride, lo, hi, sign);
    if (close)
        k_reduce_one(x, lanes, rows + 2);
}

static inline void k_square_one(int64_t *lanes, int *load, int rows, const uint64_t *a, const uint64_t *b,
                                size_t stride, int lo, int hi, int mid, int sign, bool open, bool close,
                                vector *x)
{
    (void)open;
    k_square(lanes, load, rows, a, b, stride, lo, hi, mid, sign);
    if (close)
        k_reduce_one(x, lanes, rows + 2);
}

static inline void k_before_one(vector *y, const vector *x)
{
    for (int i = 7; i >= 1; i--)
        (*y)[i] = (*x)[i - 1];
    (*y)[0] = 0;
}

static inline void k_after_one(vector *y, const vector *x)
{
    for (int i = 0; i < 7; i++)
        (*y)[i] = (*x)[i + 1];
    (*y)[7] = 0;
}

static inline void k_down_one(vector *x, int q, int r)
{
    int64_t *t = (int64_t *)x;
    for (int i = 7; i >= 0; i--)
        t[i] = (i >= q ? t[i - q] >> r : 0) +
               (i > q ? (int64_t)((uint64_t)t[i - q - 1] << (FX_BITS - r)) & FX_MASK : 0);
}

static inline void k_floor_one(vector *x, long shift)
{
    const vector t = *x;
    cns_fx_shift((int64_t *)x, (const int64_t *)&t, 7, 7, -shift);
}

#define FX_KERNEL_NAME "portable"
#define FX_KERNEL      cns_fx_kernel_portable
#include "order_by_calls.h"
#include "order_compiled.h"
