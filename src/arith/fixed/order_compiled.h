/* Running a compiled order (fixed.h): the sums of order_by_calls.h, each in one vector of eight words,
 * t[0..rows]. Compiled once for every number of rows up to FX_ONE_ROWS, which `rows` then is: a constant. Of
 * the kernel it asks, beside k_name_one: k_conv_one(..., open, close, x), k_square_one(..., open, close, x)
 *                        as k_conv, but the product is known to be the first of its lanes where `open`, and
 * where `close` the last: then *x becomes the sum over the lanes, |x[i]| < FX_SUM_LOAD 2^52 k_before_one(y,
 * x), k_after_one(y, x)   y = x moved by one word to the back, to the front, a zero coming in k_down_one(x,
 * q, r)  x *= 2^(-52 q - r), not normalised (shift_down) k_floor_one(x, s)    x = floor(x 2^-s), |x| < 2^52,
 * normalised */

#define FX_INLINE static inline __attribute__((always_inline))

/* x *= 2^(-shift), as shift_down. */
FX_INLINE void down_one(fx_u *x, const int rows, long shift)
{
    if (shift > (long)FX_BITS * rows) {
        const long left = shift - (long)FX_BITS * rows;
        const int64_t whole = (int64_t)(*x)[0];
        *x = (fx_u){0};
        (*x)[rows] = (uint64_t)(whole >> (left > 63 ? 63 : left));
        return;
    }
    k_down_one(x, (int)(shift / FX_BITS), (int)(shift % FX_BITS));
}

/* acc += term, moved as step s says; *term is used up. */
FX_INLINE void add_one(fx_u *acc, fx_u *term, const fx_step *s, const int rows)
{
    if (__builtin_expect(s->down_x != 0, 0))
        down_one(term, rows, s->down_x);
    const fx_u x = ((*term << (uint64_t)s->up_x) ^ s->flip) - s->flip;
    if (s->fresh) {
        *acc = x;
        return;
    }
    if (__builtin_expect(s->carry, 0))
        k_carry_one(acc, rows);
    if (__builtin_expect(s->down != 0, 0))
        down_one(acc, rows, s->down);
    *acc = (*acc << (uint64_t)s->up) + x;
}

/* Of the products in the lanes, what fx has as corr, terms and lanes_load. */
typedef struct lanes_state {
    fx_u corr;
    long terms;
    int load;
} lanes_state;

/* corr += sign * (u_lo + ... + u_hi). */
FX_INLINE void correct_one(const fx *F, lanes_state *l, const fx_series *s, int lo, int hi, int sign)
{
    fx_u d = CV(record_at(F, s, hi));
    if (lo > 0)
        d -= CV(record_at(F, s, lo - 1));
    if (sign < 0)
        l->corr -= d;
    else
        l->corr += d;
}

/* Takes a product into the lanes, and where it is their last one, adds what is in them to the accumulator. */
FX_INLINE void product_one(fx *F, fx_u *acc, lanes_state *l, const fx_step *s, int k, const int rows)
{
    fx_u x;
    const int lo = s->lo;
    if (s->open)
        *l = (lanes_state){.corr = {0}};
    if (s->kind == FX_DO_CONV) {
        const int hi = k - s->above;
        correct_one(F, l, s->a, lo, hi, s->sign);
        correct_one(F, l, s->b, s->above, k - lo, s->sign);
        l->terms += s->sign * (hi - lo + 1);
        k_conv_one(F->lanes, &l->load, rows, s->a->fwd, s->b->rev + (F->order - k), F->stride, lo, hi,
                   s->sign, s->open, s->close, &x);
    } else {
        correct_one(F, l, s->a, lo, k - lo, s->sign);
        correct_one(F, l, s->a, lo, k - lo, s->sign);
        l->terms += s->sign * (k - 2 * lo + 1);
        k_square_one(F->lanes, &l->load, rows, s->a->fwd, s->a->rev + (F->order - k), F->stride, lo,
                     (k - 1) >> 1, k % 2 == 0 ? k / 2 : -1, s->sign, s->open, s->close, &x);
    }
    if (!s->close)
        return;
    const fx_u count = {(uint64_t)(l->terms >> 1), ((uint64_t)l->terms & 1) * (uint64_t)FX_HALF};
    x = x * 2 - (l->corr & CV(below_row(rows, 0))) + count;
    k_carry_one(&x, rows + 1);
    add_one(acc, &x, s, rows);
}

/* The factor c/(k + 1) of a state's coefficient, for an accumulator of so many rows; made once per order. */
FX_INLINE const fx_const *next_factor(fx *F, const fx_step *s, int k, const int rows)
{
    fx_const *next = s->made;
    const fx_const *inverse = &F->inverse_order[k];
    if (next->index == k && next->for_rows == rows + 1)
        return next;
    if (s->c->used <= 1 && rows < FX_ONE_ROWS) { /* c, of one limb, is the shorter factor */
        fx_u x;
        k_mul_short_one(&x, (const fx_u *)inverse->limb, rows + 1, s->c);
        k_carry_one(&x, rows + 2);
        V(next->limb) = x;
    } else {
        k_mul(next->limb, s->c->limb, rows + 1, inverse);
    }
    next->sign = s->c->sign;
    next->exp = s->c->exp + inverse->exp;
    next->index = k;
    next->used = rows + 2;
    next->for_rows = rows + 1;
    return next;
}

/* x = floor(t 2^shift). False: it is too large to be a coefficient. */
FX_INLINE bool shift_one(fx_u *x, const fx_u *t, long shift)
{
    const fx_u whole_first = ALL_LIMBS(~UINT64_C(0));
    if (shift <= 0 && shift > -FX_BITS) {
        k_before_one(x, t);
        *x = (fx_u)((fx_v)*t >> -shift) + ((*x << (uint64_t)(FX_BITS + shift)) & (uint64_t)FX_MASK);
    } else if (shift > 0) {
        if (shift >= FX_BITS || (int64_t)(*t)[0] < -1024 || (int64_t)(*t)[0] >= 1024)
            return false;
        k_after_one(x, t);
        *x = ((*t << (uint64_t)shift) & whole_first) + (*x >> (uint64_t)(FX_BITS - shift));
    } else {
        *x = *t;
        k_floor_one(x, -shift);
    }
    return true;
}

/* Stores the accumulator, times the factor of the step, as a coefficient: wherever convolutions will read its
 * limbs. False: it is too large for the block exponent of its series, and nothing has been stored. */
FX_INLINE bool store_one(fx *F, const fx_u *acc, const fx_step *step, int k, const int rows)
{
    fx_series *const s = step->w;
    fx_u t = *acc, x = {0};
    int64_t words[8] __attribute__((aligned(64)));
    k += step->next;
    int64_t *const record = record_at(F, s, k), *const value = record + F->value;
    if (!step->empty) {
        long shift = step->exp;
        if (step->carry)
            k_carry_one(&t, rows);
        if (step->times == FX_TIMES_NOTHING) {
            t &= CV(below_row(rows, 0));
        } else {
            const fx_const *c = step->c;
            if (step->times != FX_TIMES_CONST) {
                c = step->times == FX_TIMES_INVERSE ? &F->inverse_order[k - 1]
                                                    : next_factor(F, step, k - 1, rows);
                shift += c->exp;
            }
            V(words) = t;
            k_mul_one(&t, words, rows, c);
        }
        if (!shift_one(&x, &t, shift))
            return false;
    }
    V(value) = x;
    V(words) = x;
    const int64_t whole = words[0], first = words[1] + FX_HALF;
    if (whole + (first >> FX_BITS) != 0)
        return false;
    const int64_t top = whole < 0 ? FX_MASK - words[1] : words[1];
    s->peak = top > s->peak ? top : s->peak;

    /* u = x + 1/2. x may have limbs after the last that counts; nobody reads them. */
    const uint64_t first_limb = (uint64_t)(first & FX_MASK);
    const size_t stride = F->stride;
    if (s->parts & FX_FWD) {
        uint64_t *fwd = s->fwd + k;
        *fwd = first_limb;
#pragma GCC unroll 8
        for (int i = 2; i <= rows; i++)
            *(fwd += stride) = (uint64_t)words[i];
    }
    if (s->parts & FX_REV) {
        uint64_t *rev = s->rev + (F->order - k);
        *rev = first_limb;
#pragma GCC unroll 8
        for (int i = 2; i <= rows; i++)
            *(rev += stride) = (uint64_t)words[i];
    }
    s->stored = k + 1;
    if (s->parts & FX_SUMS) {
        const fx_u half = {0, (uint64_t)FX_HALF}, no_whole = ALL_LIMBS(0);
        fx_u d = CV(record - F->record) + ((x + half) & no_whole);
        if (k % 16 == 0 || F->rows[k] != F->rows[k + 1])
            k_carry_one(&d, F->rows[k]);
        V(record) = d;
    }
    return true;
}

/* Runs orders *from, *from + 1, ... below `to` for as long as they have so many rows. */
FX_INLINE const fx_step *run_rows(fx *F, const fx_compiled *C, int *from, int to, const int rows)
{
    const fx_step *const end = C->step + C->n;
    int k = *from;
    for (; k < to && F->rows[k] == rows; k++) {
        fx_u acc = {0}, x;
        lanes_state lanes = {.corr = {0}};
        for (const fx_step *s = C->step; s < end; s++) {
            switch (s->kind) {
            case FX_DO_COEF:
                x = CV(record_at(F, s->a, k) + F->value);
                if (s->weight != 0) {
                    x *= (uint64_t)(s->weight + (s->weight_grows ? k - s->order : 0));
                    k_carry_one(&x, rows);
                }
                add_one(&acc, &x, s, rows);
                break;
            case FX_DO_SCALED:
                k_mul_one(&x, record_at(F, s->a, k) + F->value, rows, s->c);
                add_one(&acc, &x, s, rows);
                break;
            case FX_DO_CONV:
            case FX_DO_SQUARE:
                product_one(F, &acc, &lanes, s, k, rows);
                break;
            case FX_DO_STORE:
                if (!store_one(F, &acc, s, k, rows)) {
                    *from = k;
                    return s;
                }
                break;
            }
        }
    }
    *from = k;
    return NULL;
}

#define RUN(M)                                                                                               \
    static const fx_step *run_##M(fx *F, const fx_compiled *C, int *from, int to)                            \
    {                                                                                                        \
        return run_rows(F, C, from, to, M);                                                                  \
    }
RUN(1)
RUN(2)
RUN(3)
RUN(4)
RUN(5)
RUN(6)

static const fx_step *f_run(fx *F, const fx_compiled *C, int *from, int to)
{
    static const fx_step *(*const run[FX_ONE_ROWS + 1])(fx *, const fx_compiled *, int *, int) = {
        NULL, run_1, run_2, run_3, run_4, run_5, run_6};
    const fx_step *stuck = NULL;
    while (*from < to && stuck == NULL)
        stuck = run[F->rows[*from]](F, C, from, to);
    return stuck;
}

const fx_kernel FX_KERNEL = {
    .name = FX_KERNEL_NAME,
#define PRIMITIVE(KIND, name, n, ...) .name = f_##name,
#include "arith/primitives.def"
#undef PRIMITIVE
    .sum = f_sum,
    .run = f_run,
};
