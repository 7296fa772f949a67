/* The portable kernel: diagonals of limb products in 128-bit sums, one lane. */
#include "fixed.h"

typedef unsigned __int128 wide;

/* Sums of rows * terms products of 104 bits: below 2^128 for 2^24 of them. */
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
    if (i == p) {
        const uint64_t *a0 = a + (size_t)i * stride, *b0 = b;
        int j = lo;
        for (; j < hi; j += 2) {
            s0 += (wide)a0[j] * b0[j];
            s1 += (wide)a0[j + 1] * b0[j + 1];
        }
        if (j == hi)
            s0 += (wide)a0[j] * b0[j];
    }
    return s0 + s1;
}

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

static void k_conv(int64_t *lanes, int *load, int rows, const uint64_t *a, const uint64_t *b, size_t stride,
                   int lo, int hi, int sign)
{
    for (int p = 0; p < rows; p++)
        scatter(lanes, p, diagonal(a, b, stride, p, lo, hi), sign);
    *load += 3;
    if (*load > 40)
        k_carry_lanes(lanes, load, rows);
}

static void k_square(int64_t *lanes, int *load, int rows, const uint64_t *a, const uint64_t *b, size_t stride,
                     int lo, int hi, int mid, int sign)
{
    for (int p = 0; p < rows; p++) {
        wide s = 2 * diagonal(a, b, stride, p, lo, hi);
        if (mid >= 0)
            s += diagonal(a, b, stride, p, mid, mid);
        scatter(lanes, p, s, sign);
    }
    *load += 3;
    if (*load > 40)
        k_carry_lanes(lanes, load, rows);
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

#define FX_KERNEL_NAME "portable"
#define FX_KERNEL      fx_kernel_portable
#include "fixed_core.h"
