/* The AVX-512 IFMA kernel (order_by_calls.h). IFMA multiplies limbs of 52 bits and adds the low or the high
 * half of each product, for eight terms of a convolution, a block, at once: term j is in lane j mod 8. */
#include "fixed.h"

#ifdef FX_HAVE_IFMA

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx512f,avx512dq,avx512vl,avx512bw,avx512ifma,bmi2"))),  \
                             apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx512vl,avx512bw,avx512ifma,bmi2,prefer-vector-width=512")
#endif
#include <immintrin.h>

#define INLINE static inline __attribute__((always_inline))

/* Part of the triangle of limb pairs i + j < rows, for a strip of blocks: the pairs i < r,
 * j < w + (corner ? r - 1 - i : 0), limb i of the one operand with limb j of the other. Diagonal p = i + j <
 * r + w - 1 has sums of the low halves, l, and of the high halves, h; and each of these in up to three sets
 * a, b, c (by i), so that an addition need not wait for the one before. All conditions are decided when
 * compiling, as r, w, corner and sets are constants. Sums are variables with names, because compilers keep
 * arrays in memory. */
#define MAX_DIAGONALS 12
#define EACH(X)       X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7) X(8) X(9) X(10) X(11)

#define DECLARE(p)                                                                                           \
    __m512i la##p = zero, lb##p = zero, lc##p = zero, ha##p = zero, hb##p = zero, hc##p = zero, x##p = zero;
#define LOAD(i)                                                                                              \
    if (i < r)                                                                                               \
        x##i = _mm512_maskz_loadu_epi64(mask, a + (size_t)i * stride);
#define INTO(s, p, i)                                                                                        \
    do {                                                                                                     \
        l##s##p = _mm512_madd52lo_epu64(l##s##p, x##i, y);                                                   \
        h##s##p = _mm512_madd52hi_epu64(h##s##p, x##i, y);                                                   \
    } while (0)
#define PAIR(i, p)                                                                                           \
    if (i < r && (p - i) < w + (corner ? r - 1 - i : 0)) {                                                   \
        if (i % sets == 0)                                                                                   \
            INTO(a, p, i);                                                                                   \
        else if (i % sets == 1)                                                                              \
            INTO(b, p, i);                                                                                   \
        else                                                                                                 \
            INTO(c, p, i);                                                                                   \
    }
#define LIMB(j, PAIRS)                                                                                       \
    if (j < w + (corner ? r - 1 : 0)) {                                                                      \
        const __m512i y = _mm512_loadu_si512(b + (size_t)j * stride);                                        \
        PAIRS                                                                                                \
    }
#define TWICE(p)                                                                                             \
    la##p = _mm512_add_epi64(la##p, la##p), lb##p = _mm512_add_epi64(lb##p, lb##p),                          \
    lc##p = _mm512_add_epi64(lc##p, lc##p), ha##p = _mm512_add_epi64(ha##p, ha##p),                          \
    hb##p = _mm512_add_epi64(hb##p, hb##p), hc##p = _mm512_add_epi64(hc##p, hc##p);
/* For column p + 1: `high`, the high halves of diagonal p and the low halves of diagonal p - 1, which
 * `carried` brings. */
#define GATHER(p)                                                                                            \
    __m512i high = _mm512_add_epi64(ha##p, carried);                                                         \
    carried = la##p;                                                                                         \
    if (sets > 1) {                                                                                          \
        high = _mm512_add_epi64(high, hb##p);                                                                \
        carried = _mm512_add_epi64(carried, lb##p);                                                          \
    }                                                                                                        \
    if (sets > 2) {                                                                                          \
        high = _mm512_add_epi64(high, hc##p);                                                                \
        carried = _mm512_add_epi64(carried, lc##p);                                                          \
    }
#define OUT(p)                                                                                               \
    if (p < d) {                                                                                             \
        GATHER(p)                                                                                            \
        into(lanes + 8 * (p + 1), high, sign, keep);                                                         \
    }

/* The same into registers c1, c2, ...: column q = p + 1, and after the last diagonal column n = p + 2. */
#define COLUMN(p, q, n)                                                                                      \
    if (p < d) {                                                                                             \
        GATHER(p)                                                                                            \
        c##q = high;                                                                                         \
        if (p == d - 1)                                                                                      \
            c##n = carried;                                                                                  \
    }

/* Word p of the result is the sum of the lanes of column p: a transpose of eight by eight, which adds halves
 * where it would otherwise move them. */
INLINE __m512i across(__m512i c0, __m512i c1, __m512i c2, __m512i c3, __m512i c4, __m512i c5, __m512i c6,
                      __m512i c7)
{
    const __m512i s0 = _mm512_add_epi64(_mm512_unpacklo_epi64(c0, c1), _mm512_unpackhi_epi64(c0, c1));
    const __m512i s1 = _mm512_add_epi64(_mm512_unpacklo_epi64(c2, c3), _mm512_unpackhi_epi64(c2, c3));
    const __m512i s2 = _mm512_add_epi64(_mm512_unpacklo_epi64(c4, c5), _mm512_unpackhi_epi64(c4, c5));
    const __m512i s3 = _mm512_add_epi64(_mm512_unpacklo_epi64(c6, c7), _mm512_unpackhi_epi64(c6, c7));
    /* Each s now has, in four parts of 128 bits, sums of two lanes of its two columns. */
    const __m512i u0 =
        _mm512_add_epi64(_mm512_shuffle_i64x2(s0, s1, 0x88), _mm512_shuffle_i64x2(s0, s1, 0xdd));
    const __m512i u1 =
        _mm512_add_epi64(_mm512_shuffle_i64x2(s2, s3, 0x88), _mm512_shuffle_i64x2(s2, s3, 0xdd));
    return _mm512_add_epi64(_mm512_shuffle_i64x2(u0, u1, 0x88), _mm512_shuffle_i64x2(u0, u1, 0xdd));
}

INLINE void into(int64_t *lane, __m512i x, int sign, __mmask8 keep)
{
    const __m512i s = _mm512_maskz_load_epi64(keep, lane);
    _mm512_store_si512(lane, sign < 0 ? _mm512_sub_epi64(s, x) : _mm512_add_epi64(s, x));
}

/* Columns p + 1 and p + 2 of the lanes += sign * diagonal p of the sum over `blocks` blocks of a and b, of
 * which the masks first and last say which terms of the first and the last block count. For a square twice
 * that, and the term of order mid >= 0, in a0 and b0, once. keep = 0: the lanes were not set before. reduced:
 * the columns are summed over their lanes into it instead. */
INLINE void tile(int64_t *lanes, const uint64_t *a, const uint64_t *b, size_t stride, int blocks,
                 __mmask8 first, __mmask8 last, const int sign, __mmask8 keep, const int r, const int w,
                 const int corner, const int sets, const int square, int mid, const uint64_t *a0,
                 const uint64_t *b0, __m512i *reduced)
{
    const int d = r + w - 1;
    const __m512i zero = _mm512_setzero_si512();
    EACH(DECLARE)
    __mmask8 mask = first;
    for (;;) {
        if (blocks <= 1) {
            if (square && blocks <= 0) {
                if (mid < 0)
                    break;
                EACH(TWICE)
                a = a0 + (mid & ~7);
                b = b0 + (mid & ~7);
                mask = (__mmask8)(1 << (mid & 7));
            } else {
                mask &= last;
            }
        }
        EACH(LOAD)
        LIMB(0, PAIR(0, 0) PAIR(1, 1) PAIR(2, 2) PAIR(3, 3) PAIR(4, 4) PAIR(5, 5) PAIR(6, 6) PAIR(7, 7)
                    PAIR(8, 8) PAIR(9, 9) PAIR(10, 10) PAIR(11, 11))
        LIMB(1, PAIR(0, 1) PAIR(1, 2) PAIR(2, 3) PAIR(3, 4) PAIR(4, 5) PAIR(5, 6) PAIR(6, 7) PAIR(7, 8)
                    PAIR(8, 9) PAIR(9, 10) PAIR(10, 11))
        LIMB(2, PAIR(0, 2) PAIR(1, 3) PAIR(2, 4) PAIR(3, 5) PAIR(4, 6) PAIR(5, 7) PAIR(6, 8) PAIR(7, 9)
                    PAIR(8, 10) PAIR(9, 11))
        LIMB(3, PAIR(0, 3) PAIR(1, 4) PAIR(2, 5) PAIR(3, 6) PAIR(4, 7) PAIR(5, 8) PAIR(6, 9) PAIR(7, 10)
                    PAIR(8, 11))
        LIMB(4, PAIR(0, 4) PAIR(1, 5) PAIR(2, 6) PAIR(3, 7) PAIR(4, 8) PAIR(5, 9) PAIR(6, 10) PAIR(7, 11))
        LIMB(5, PAIR(0, 5) PAIR(1, 6) PAIR(2, 7) PAIR(3, 8) PAIR(4, 9) PAIR(5, 10) PAIR(6, 11))
        LIMB(6, PAIR(0, 6) PAIR(1, 7) PAIR(2, 8) PAIR(3, 9) PAIR(4, 10) PAIR(5, 11))
        LIMB(7, PAIR(0, 7) PAIR(1, 8) PAIR(2, 9) PAIR(3, 10) PAIR(4, 11))
        LIMB(8, PAIR(0, 8) PAIR(1, 9) PAIR(2, 10) PAIR(3, 11))
        LIMB(9, PAIR(0, 9) PAIR(1, 10) PAIR(2, 11))
        LIMB(10, PAIR(0, 10) PAIR(1, 11))
        LIMB(11, PAIR(0, 11))
        mask = 0xff;
        a += 8;
        b += 8;
        blocks--;
        if (square ? blocks < 0 : blocks <= 0)
            break;
    }
    if (square && mid < 0) {
        EACH(TWICE)
    }
    __m512i carried = zero;
    if (reduced != NULL) {
        __m512i c1 = zero, c2 = zero, c3 = zero, c4 = zero, c5 = zero, c6 = zero, c7 = zero;
        COLUMN(0, 1, 2)
        COLUMN(1, 2, 3)
        COLUMN(2, 3, 4)
        COLUMN(3, 4, 5)
        COLUMN(4, 5, 6)
        COLUMN(5, 6, 7)
        *reduced = across(zero, c1, c2, c3, c4, c5, c6, c7);
        return;
    }
    EACH(OUT)
    into(lanes + 8 * (d + 1), carried, sign, keep);
}

#define ARGS                                                                                                 \
    int64_t *lanes, const uint64_t *a, const uint64_t *b, size_t stride, int blocks, __mmask8 first,         \
        __mmask8 last, int sign, __mmask8 keep, int mid, const uint64_t *a0, const uint64_t *b0
typedef void triangle_function(ARGS);

#define TRIANGLE(M, SETS)                                                                                    \
    static void conv_##M(ARGS)                                                                               \
    {                                                                                                        \
        tile(lanes, a, b, stride, blocks, first, last, sign, keep, M, 1, 1, SETS, 0, mid, a0, b0, NULL);     \
    }                                                                                                        \
    static void square_##M(ARGS)                                                                             \
    {                                                                                                        \
        tile(lanes, a, b, stride, blocks, first, last, sign, keep, M, 1, 1, SETS, 1, mid, a0, b0, NULL);     \
    }
#define SETS(M) ((M) == 3 ? 3 : (M) == 1 || (M) > 6 ? 1 : 2)
TRIANGLE(1, 1)
TRIANGLE(2, 2)
TRIANGLE(3, 3)
TRIANGLE(4, 2)
TRIANGLE(5, 2)
TRIANGLE(6, 2)
TRIANGLE(7, 1)
TRIANGLE(8, 1)
TRIANGLE(9, 1)
TRIANGLE(10, 1)

#define SMALL 10 /* up to so many rows one call makes the whole triangle */
#define TILE                                                                                                 \
    6 /* beyond, it is made of squares of so many limbs, a trapezoid and a triangle per strip of rows */

static triangle_function *const conv_small[SMALL + 1] = {NULL,   conv_1, conv_2, conv_3, conv_4, conv_5,
                                                         conv_6, conv_7, conv_8, conv_9, conv_10};
static triangle_function *const square_small[SMALL + 1] = {NULL,     square_1, square_2, square_3,
                                                           square_4, square_5, square_6, square_7,
                                                           square_8, square_9, square_10};

#define TRAPEZOID(W)                                                                                         \
    static void trapezoid_##W(ARGS)                                                                          \
    {                                                                                                        \
        tile(lanes, a, b, stride, blocks, first, last, sign, keep, TILE, W, 1, 1, 0, mid, a0, b0, NULL);     \
    }
TRAPEZOID(1)
TRAPEZOID(2)
TRAPEZOID(3)
TRAPEZOID(4)
TRAPEZOID(5)
TRAPEZOID(6)
static triangle_function *const trapezoid[TILE + 1] = {NULL,        trapezoid_1, trapezoid_2, trapezoid_3,
                                                       trapezoid_4, trapezoid_5, trapezoid_6};

static void full_tile(ARGS)
{
    tile(lanes, a, b, stride, blocks, first, last, sign, keep, TILE, TILE, 0, 1, 0, mid, a0, b0, NULL);
}

static void k_carry_lanes(int64_t *lanes, int *load, int rows)
{
    const __m512i mask = _mm512_set1_epi64(FX_MASK);
    __m512i c = _mm512_setzero_si512();
    for (int p = rows + 1; p >= 1; p--) {
        const __m512i s = _mm512_add_epi64(_mm512_load_si512(lanes + 8 * p), c);
        _mm512_store_si512(lanes + 8 * p, _mm512_and_si512(s, mask));
        c = _mm512_srai_epi64(s, FX_BITS);
    }
    _mm512_store_si512(lanes, _mm512_add_epi64(_mm512_load_si512(lanes), c));
    *load = 1;
}

/* Blocks per call of tile(), few enough that two strips of rows stay in the first-level cache, and that
 * nothing overflows: per block the sum of a diagonal grows by at most SMALL numbers of 52 bits, and the load
 * of a lane by 2 * min(rows, TILE or SMALL). */
#define BLOCKS 24

static inline void reserve(int64_t *lanes, int *load, int rows, int more)
{
    if (*load + more > FX_LANE_LOAD)
        k_carry_lanes(lanes, load, rows);
    *load += more;
}

/* `keep` for the next call: does it add to the lanes, or set them? In the latter case columns 0..zeros, which
 * it does not write, are set to zero here. */
INLINE __mmask8 fresh(int64_t *lanes, int load, int zeros)
{
    if (load != 0)
        return 0xff;
    for (int p = 0; p <= zeros; p++)
        _mm512_store_si512(lanes + 8 * p, _mm512_setzero_si512());
    return 0;
}

static void large(int64_t *lanes, int *load, int rows, const uint64_t *a, const uint64_t *b, size_t stride,
                  int blocks, __mmask8 first, __mmask8 last, int sign, int weight)
{
    for (int i = 0; i < rows; i += TILE) {
        const uint64_t *ai = a + (size_t)i * stride;
        int width = rows - i; /* of row i; one less per row */
        for (int twice = 0; twice < weight; twice++) {
            reserve(lanes, load, rows, 2 * TILE * blocks);
            int64_t *out = lanes + 8 * i;
            const uint64_t *bj = b;
            width = rows - i;
            if (width <= TILE) {
                conv_small[width](out, ai, bj, stride, blocks, first, last, sign, 0xff, -1, a, b);
                continue;
            }
            while (width >= 2 * TILE) {
                full_tile(out, ai, bj, stride, blocks, first, last, sign, 0xff, -1, a, b);
                bj += TILE * stride;
                out += 8 * TILE;
                width -= TILE;
            }
            trapezoid[width - TILE + 1](out, ai, bj, stride, blocks, first, last, sign, 0xff, -1, a, b);
        }
    }
}

static inline void k_conv(int64_t *lanes, int *load, int rows, const uint64_t *a, const uint64_t *b,
                          size_t stride, int lo, int hi, int sign)
{
    int j = lo & ~7;
    __mmask8 first = (__mmask8)(0xff << (lo & 7));
    const __mmask8 last = (__mmask8)(0xff >> (7 - (hi & 7)));
    for (int left = (hi >> 3) - (lo >> 3) + 1; left > 0; left -= BLOCKS) {
        const int blocks = left < BLOCKS ? left : BLOCKS;
        const __mmask8 end = left <= BLOCKS ? last : 0xff;
        if (rows <= SMALL) {
            const __mmask8 keep = fresh(lanes, *load, 0);
            reserve(lanes, load, rows, 2 * rows * blocks);
            conv_small[rows](lanes, a + j, b + j, stride, blocks, first, end, sign, keep, -1, a, b);
        } else {
            fresh(lanes, *load, rows + 1);
            large(lanes, load, rows, a + j, b + j, stride, blocks, first, end, sign, 1);
        }
        first = 0xff;
        j += 8 * blocks;
    }
}

static inline void k_square(int64_t *lanes, int *load, int rows, const uint64_t *a, const uint64_t *b,
                            size_t stride, int lo, int hi, int mid, int sign)
{
    int j = lo & ~7;
    __mmask8 first = (__mmask8)(0xff << (lo & 7));
    const __mmask8 last = (__mmask8)(0xff >> (7 - (hi & 7)));
    int left = hi < lo ? 0 : (hi >> 3) - (lo >> 3) + 1;
    if (rows <= SMALL && left <= BLOCKS) {
        const __mmask8 keep = fresh(lanes, *load, 0);
        reserve(lanes, load, rows, 2 * rows * (2 * left + 1));
        square_small[rows](lanes, a + j, b + j, stride, left, first, last, sign, keep, mid, a, b);
        return;
    }
    for (; left > 0; left -= BLOCKS) {
        const int blocks = left < BLOCKS ? left : BLOCKS;
        const __mmask8 end = left <= BLOCKS ? last : 0xff;
        if (rows <= SMALL) {
            const __mmask8 keep = fresh(lanes, *load, 0);
            reserve(lanes, load, rows, 4 * rows * blocks);
            square_small[rows](lanes, a + j, b + j, stride, blocks, first, end, sign, keep, -1, a, b);
        } else {
            fresh(lanes, *load, rows + 1);
            large(lanes, load, rows, a + j, b + j, stride, blocks, first, end, sign, 2);
        }
        first = 0xff;
        j += 8 * blocks;
    }
    if (mid >= 0)
        k_conv(lanes, load, rows, a, b, stride, mid, mid, sign);
}

static void carry_slowly(int64_t *t, int rows)
{
    int64_t c = 0;
    for (int i = rows; i >= 1; i--) {
        const int64_t s = t[i] + c;
        t[i] = s & FX_MASK;
        c = s >> FX_BITS;
    }
    t[0] += c;
}

static void carry_long(int64_t *t, int rows)
{
    const __m512i limb = _mm512_set1_epi64(FX_MASK);
    const int last = rows >> 3;
    const __mmask8 tail = (__mmask8)(0xff >> (7 - (rows & 7)));
    __mmask8 bad = 0;
    for (int pass = 0; pass < 2; pass++) {
        __mmask8 moves = 0xfe; /* t[0] is whole */
        __m512i x = _mm512_loadu_si512(t);
        bad = 0;
        for (int v = 0; v <= last; v++, moves = 0xff) {
            __m512i next = _mm512_setzero_si512();
            if (v < last) {
                next = _mm512_loadu_si512(t + 8 * (v + 1));
                if (v + 1 == last)
                    next = _mm512_maskz_mov_epi64(tail, next);
            }
            const __m512i c =
                _mm512_alignr_epi64(_mm512_srai_epi64(next, FX_BITS), _mm512_srai_epi64(x, FX_BITS), 1);
            const __m512i s = _mm512_add_epi64(_mm512_mask_and_epi64(x, moves, x, limb), c);
            _mm512_storeu_si512(t + 8 * v, s);
            bad |= _mm512_mask_cmpgt_epu64_mask(moves, s, limb);
            x = next;
        }
    }
    if (bad != 0)
        carry_slowly(t, rows);
}

typedef uint64_t vector __attribute__((vector_size(64), aligned(8), may_alias));
#define BEFORE(p) ((vector)_mm512_alignr_epi64(_mm512_loadu_si512(p), _mm512_loadu_si512((p)-8), 7))
#define AFTER(p)  ((vector)_mm512_alignr_epi64(_mm512_loadu_si512((p) + 8), _mm512_loadu_si512(p), 1))

/* All carries at once, each by one limb: a limb is then in [-2^11, 2^52 + 2^11], and of random limbs all but
 * one in 2^41 are in [0, 2^52). Otherwise carries have further to go, limb by limb. */
INLINE void k_carry_one(vector *t, int rows)
{
    const __m512i limb = _mm512_set1_epi64(FX_MASK);
    const __mmask8 moves = (__mmask8)((2 << rows) - 2);
    __m512i x = _mm512_maskz_mov_epi64((__mmask8)(moves | 1), (__m512i)*t);
    x = _mm512_add_epi64(_mm512_mask_and_epi64(x, 0xfe, x, limb),
                         _mm512_alignr_epi64(_mm512_setzero_si512(), _mm512_srai_epi64(x, FX_BITS), 1));
    *t = (vector)x;
    if (__builtin_expect(_mm512_mask_cmpgt_epu64_mask(0xfe, x, limb) != 0, 0)) {
        vector slow = *t; /* a copy, so that *t need not have an address and can stay in a register */
        carry_slowly((int64_t *)&slow, rows);
        *t = slow;
    }
}

INLINE void k_carry(int64_t *t, int rows)
{
    if (rows > 7)
        carry_long(t, rows);
    else
        k_carry_one((vector *)t, rows);
}

/* Eight columns at a time; nobody looks at those beyond the last. */
INLINE __m512i reduce_eight(const int64_t *lanes)
{
    return across(_mm512_load_si512(lanes), _mm512_load_si512(lanes + 8), _mm512_load_si512(lanes + 16),
                  _mm512_load_si512(lanes + 24), _mm512_load_si512(lanes + 32), _mm512_load_si512(lanes + 40),
                  _mm512_load_si512(lanes + 48), _mm512_load_si512(lanes + 56));
}

static inline void k_reduce(int64_t *t, const int64_t *lanes, int columns)
{
    for (int p = 0; p < columns; p += 8, lanes += 64)
        _mm512_storeu_si512(t + p, reduce_eight(lanes));
}

INLINE void k_reduce_one(vector *x, const int64_t *lanes, int columns)
{
    (void)columns;
    *x = (vector)reduce_eight(lanes);
}

static void mul_wide(int64_t *out, const int64_t *x, int rows, const fx_const *c)
{
    __int128 s = 0;
    for (int p = rows + 1; p >= 1; p--) {
        __int128 d = 0;
        for (int i = p <= rows ? p - 1 : rows; i >= 0; i--)
            d += (__int128)x[i] * c->limb[p - i];
        s += c->sign < 0 ? -d : d;
        out[p] = (int64_t)s & FX_MASK;
        s >>= FX_BITS;
    }
    out[0] = (int64_t)s;
}

static inline void k_mul(int64_t *out, const int64_t *x, int rows, const fx_const *c)
{
    if (x[0] < -400 || x[0] > 400) {
        mul_wide(out, x, rows, c);
        return;
    }
    const int64_t *limb = c->limb;
    const __m512i flip = _mm512_set1_epi64(c->sign < 0 ? -1 : 0);
    const __m512i whole = _mm512_set1_epi64(x[0]);
    for (int p = 0; p <= rows + 1; p += 8) {
        __m512i low = _mm512_mullo_epi64(whole, _mm512_loadu_si512(limb + p));
        __m512i high = _mm512_setzero_si512();
        __m512i before = _mm512_loadu_si512(limb + p);
        const int n = p + 7 < rows ? p + 7 : rows;
        for (int i = 1; i <= n; i++) {
            const __m512i xi = _mm512_set1_epi64(x[i]);
            high = _mm512_madd52hi_epu64(high, xi, before);
            before = _mm512_loadu_si512(limb + p - i);
            low = _mm512_madd52lo_epu64(low, xi, before);
        }
        const __mmask8 keep = (__mmask8)(rows + 1 - p >= 8 ? 0xff : (1 << (rows + 1 - p)) - 1);
        __m512i sum = _mm512_mask_add_epi64(low, keep, low, high);
        sum = _mm512_sub_epi64(_mm512_xor_si512(sum, flip), flip);
        _mm512_storeu_si512(out + p, sum);
    }
    k_carry(out, rows + 1);
}

/* c has one limb only, c > 0, |x[0]| <= 400: the limbs of the product are below 2^54, out[0] is below 2^62.
 */
static inline void k_mul_short(int64_t *out, const int64_t *x, int rows, const fx_const *c)
{
    const __m512i f = _mm512_set1_epi64(c->limb[1]);
    __m512i left = _mm512_setzero_si512(); /* the vector before, of which the last limb is needed */
    const int64_t whole = x[0] * c->limb[1];
    for (int p = 0; p <= rows + 1; p += 8) {
        const int n = rows + 1 - p; /* limbs x[p].. that count */
        __m512i now = _mm512_maskz_loadu_epi64((__mmask8)(n >= 8 ? 0xff : (1 << n) - 1), x + p);
        if (p == 0)
            now = _mm512_maskz_mov_epi64(0xfe, now);
        const __m512i shifted = _mm512_alignr_epi64(now, left, 7);
        const __m512i high = _mm512_madd52hi_epu64(_mm512_setzero_si512(), now, f);
        _mm512_storeu_si512(out + p, _mm512_madd52lo_epu64(high, shifted, f));
        left = now;
    }
    out[1] += whole;
}

INLINE void k_mul_short_one(vector *out, const vector *x, int rows, const fx_const *c)
{
    const __m512i f = _mm512_set1_epi64(c->limb[1]);
    const __m512i now = _mm512_maskz_mov_epi64((__mmask8)((2 << rows) - 2), (__m512i)*x);
    const __m512i shifted = _mm512_alignr_epi64(now, _mm512_setzero_si512(), 7);
    const __m512i high = _mm512_madd52hi_epu64(_mm512_setzero_si512(), now, f);
    const __m512i whole = _mm512_maskz_set1_epi64(2, (int64_t)(*x)[0] * c->limb[1]);
    *out = (vector)_mm512_add_epi64(_mm512_madd52lo_epu64(high, shifted, f), whole);
}

INLINE void k_mul_one(vector *out, const int64_t *x, const int rows, const fx_const *c)
{
    if (__builtin_expect(x[0] < -400 || x[0] > 400, 0)) {
        vector wide = {0};
        mul_wide((int64_t *)&wide, x, rows, c);
        *out = wide;
        return;
    }
    __m512i sum;
    if (c->used <= 1) {
        vector y;
        k_mul_short_one(&y, (const vector *)x, rows, c);
        sum = (__m512i)y;
    } else {
        const int64_t *const limb = c->limb;
        __m512i low = _mm512_setzero_si512(), high = low;
        const __m512i whole = _mm512_mullo_epi64(_mm512_set1_epi64(x[0]), _mm512_loadu_si512(limb));
#pragma GCC unroll 8
        for (int i = 1; i <= rows; i++) {
            const __m512i xi = _mm512_set1_epi64(x[i]);
            high = _mm512_madd52hi_epu64(high, xi, _mm512_loadu_si512(limb + 1 - i));
            low = _mm512_madd52lo_epu64(low, xi, _mm512_loadu_si512(limb - i));
        }
        low = _mm512_add_epi64(low, whole);
        sum = _mm512_mask_add_epi64(low, (__mmask8)((2 << rows) - 1), low, high);
    }
    if (c->sign < 0)
        sum = _mm512_sub_epi64(_mm512_setzero_si512(), sum);
    *out = (vector)sum;
    k_carry_one(out, rows + 1);
}

/* Can one call of tile() make the product, and its sum be added to the lanes without a carry between? The
 * load bounds each of eight lanes: 8 * 256 * 2^52 = 2^63. */
INLINE bool fits(int load, const int rows, int blocks)
{
    return load + 2 * rows * blocks < 256 && blocks <= BLOCKS;
}

/* *x = sign * sum, and unless the product was the only one, the lanes as well; |x[i]| < 2^53 for i >= 1. */
INLINE void close_one(const int64_t *lanes, const int rows, int sign, bool open, __m512i sum, vector *x)
{
    if (sign < 0)
        sum = _mm512_sub_epi64(_mm512_setzero_si512(), sum);
    if (!open)
        sum = _mm512_add_epi64(sum, reduce_eight(lanes));
    sum = _mm512_maskz_mov_epi64((__mmask8)((4 << rows) - 1), sum);
    sum = _mm512_add_epi64(_mm512_mask_and_epi64(sum, 0xfe, sum, _mm512_set1_epi64(FX_MASK)),
                           _mm512_alignr_epi64(_mm512_setzero_si512(), _mm512_srai_epi64(sum, FX_BITS), 1));
    *x = (vector)sum;
}

INLINE void close_lanes(int64_t *lanes, int *load, const int rows, vector *x)
{
    if (8 * *load > FX_SUM_LOAD)
        k_carry_lanes(lanes, load, rows);
    *x = (vector)reduce_eight(lanes);
}

/* The sum of the last product of its lanes need not go through them. */
INLINE void k_conv_one(int64_t *lanes, int *load, const int rows, const uint64_t *a, const uint64_t *b,
                       size_t stride, int lo, int hi, int sign, bool open, bool close, vector *x)
{
    const int j = lo & ~7, blocks = (hi >> 3) - (lo >> 3) + 1;
    if (close && fits(*load, rows, blocks)) {
        const __mmask8 first = (__mmask8)(0xff << (lo & 7)), last = (__mmask8)(0xff >> (7 - (hi & 7)));
        __m512i sum;
        tile(NULL, a + j, b + j, stride, blocks, first, last, 1, 0, rows, 1, 1, SETS(rows), 0, -1, a, b,
             &sum);
        close_one(lanes, rows, sign, open, sum, x);
        return;
    }
    k_conv(lanes, load, rows, a, b, stride, lo, hi, sign);
    if (close)
        close_lanes(lanes, load, rows, x);
}

INLINE void k_square_one(int64_t *lanes, int *load, const int rows, const uint64_t *a, const uint64_t *b,
                         size_t stride, int lo, int hi, int mid, int sign, bool open, bool close, vector *x)
{
    const int j = lo & ~7, blocks = hi < lo ? 0 : (hi >> 3) - (lo >> 3) + 1;
    if (close && fits(*load, rows, 2 * blocks + 1)) {
        const __mmask8 first = (__mmask8)(0xff << (lo & 7)), last = (__mmask8)(0xff >> (7 - (hi & 7)));
        __m512i sum;
        tile(NULL, a + j, b + j, stride, blocks, first, last, 1, 0, rows, 1, 1, SETS(rows), 1, mid, a, b,
             &sum);
        close_one(lanes, rows, sign, open, sum, x);
        return;
    }
    k_square(lanes, load, rows, a, b, stride, lo, hi, mid, sign);
    if (close)
        close_lanes(lanes, load, rows, x);
}

INLINE void k_before_one(vector *y, const vector *x)
{
    *y = (vector)_mm512_alignr_epi64((__m512i)*x, _mm512_setzero_si512(), 7);
}

INLINE void k_after_one(vector *y, const vector *x)
{
    *y = (vector)_mm512_alignr_epi64(_mm512_setzero_si512(), (__m512i)*x, 1);
}

/* Word i of the result is word i - q, or that of `fill` where there is none. */
INLINE __m512i words_up(__m512i x, int q, __m512i fill)
{
    const __m512i from = _mm512_sub_epi64(_mm512_set_epi64(7, 6, 5, 4, 3, 2, 1, 0), _mm512_set1_epi64(q));
    return _mm512_mask_permutexvar_epi64(fill, (__mmask8)(0xff << (q < 8 ? q : 8)), from, x);
}

INLINE void k_down_one(vector *x, int q, int r)
{
    const __m512i zero = _mm512_setzero_si512(), limb = _mm512_set1_epi64(FX_MASK);
    const __m512i t = words_up((__m512i)*x, q, zero), before = words_up((__m512i)*x, q + 1, zero);
    *x = (vector)_mm512_add_epi64(
        _mm512_sra_epi64(t, _mm_cvtsi32_si128(r)),
        _mm512_and_si512(_mm512_sll_epi64(before, _mm_cvtsi32_si128(FX_BITS - r)), limb));
}

INLINE void k_floor_one(vector *x, long shift)
{
    const int64_t whole = (int64_t)(*x)[0];
    const int q = shift < 8 * FX_BITS ? (int)(shift / FX_BITS) : 8, r = (int)(shift % FX_BITS);
    const __m512i limb = _mm512_set1_epi64(FX_MASK), sign = _mm512_set1_epi64(whole < 0 ? FX_MASK : 0),
                  all = _mm512_and_si512((__m512i)*x, limb);
    const __m512i t = words_up(all, q, sign), before = words_up(all, q + 1, sign);
    const __m512i y =
        _mm512_or_si512(_mm512_srl_epi64(t, _mm_cvtsi32_si128(r)),
                        _mm512_and_si512(_mm512_sll_epi64(before, _mm_cvtsi32_si128(FX_BITS - r)), limb));
    *x = (vector)_mm512_mask_set1_epi64(y, 1, whole >> (shift > 63 ? 63 : shift));
}

#define FX_KERNEL_NAME "avx512ifma"
#define FX_KERNEL      cns_fx_kernel_avx512ifma
#include "order_by_calls.h"
#include "order_compiled.h"

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
