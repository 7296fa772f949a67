#include "straight.h"

#include <math.h>
#include <stdlib.h>

/* An instruction adds one or two terms to the accumulator, which the first may start anew, and may store it.
 * A term is a value or a product of two. That the accumulator would start from zero, and turn a negative zero
 * into a positive one, is left out: no sign of a zero can reach a state. */
#define STARTS(X)     X(VALUE) X(MINUS_VALUE) X(PRODUCT) X(MINUS_PRODUCT) X(GO_ON)
#define SECONDS(X, s) X(s, NONE) X(s, VALUE) X(s, MINUS_VALUE) X(s, PRODUCT) X(s, MINUS_PRODUCT)
#define ENDS(X, s, t)                                                                                        \
    X(s, t, KEEP) X(s, t, STORE) X(s, t, STORE_SCALED) X(s, t, STORE_OVER) X(s, t, STORE_OVER_TWICE)

typedef enum start { VALUE, MINUS_VALUE, PRODUCT, MINUS_PRODUCT, GO_ON, N_STARTS } start;
typedef enum second {
    THEN_NONE,
    THEN_VALUE,
    THEN_MINUS_VALUE,
    THEN_PRODUCT,
    THEN_MINUS_PRODUCT,
    N_SECONDS
} second;
typedef enum end { KEEP, STORE, STORE_SCALED, STORE_OVER, STORE_OVER_TWICE, N_ENDS } end;

#define CODE(s, t, e) (((int)(s)*N_SECONDS + (int)(t)) * N_ENDS + (int)(e))

enum {
    FUNCTIONS = CODE(N_STARTS, 0, 0), /* and a cns_function */
    IS_POSITIVE = FUNCTIONS + CNS_FN_POW + 1,
    IS_NEGATIVE,
    FINISHED
};

typedef unsigned short slot;

typedef struct instruction {
    slot code, a, b, c, d; /* terms a b and c d, or the operands of a function */
    slot by;               /* the factor or divisor, or the cosine */
    slot to;
} instruction;

typedef struct sign {
    slot of;
    double sign;
} sign;

struct cns_arith {
    int series;
    const cns_arith_ops *ops;
    cns_arith *A;
    double *v;
    instruction *code;
    int n, capacity;
    instruction nowhere; /* for what there is no memory for */
    sign *entry;         /* signs of what is not computed here */
    int n_entry;
    bool *stored, *seen; /* per series: by this code; its sign, since then */
    bool failed;
    bool fresh; /* the accumulator holds nothing yet */
};

cns_arith *cns_straight_new(int series)
{
    const size_t n = (size_t)series + 1;
    cns_arith *S = calloc(1, sizeof *S);
    if (!S)
        return NULL;
    S->series = series;
    S->v = calloc(2 * n, sizeof *S->v);
    S->entry = calloc(n, sizeof *S->entry);
    S->stored = calloc(n, sizeof *S->stored);
    S->seen = calloc(n, sizeof *S->seen);
    if (S->v && S->entry && S->stored && S->seen)
        return S;
    cns_straight_free(S);
    return NULL;
}

void cns_straight_free(cns_arith *S)
{
    if (!S)
        return;
    free(S->v);
    free(S->code);
    free(S->entry);
    free(S->stored);
    free(S->seen);
    free(S);
}

double *cns_straight_values(cns_arith *S)
{
    return S->v;
}

void cns_straight_begin(cns_arith *S, const cns_arith_ops *ops, cns_arith *A)
{
    S->ops = ops;
    S->A = A;
    S->n = S->n_entry = 0;
    S->failed = 2 * S->series >= (slot)-1;
    S->fresh = true;
    for (int a = 0; a < S->series; a++)
        S->stored[a] = S->seen[a] = false;
}

static instruction *add(cns_arith *S, int code)
{
    if (S->n == S->capacity) {
        const int capacity = 2 * S->capacity + 64;
        instruction *grown = realloc(S->code, (size_t)capacity * sizeof *grown);
        if (!grown) {
            S->failed = true;
            S->n = 0; /* nothing of it will be run */
        } else {
            S->code = grown;
            S->capacity = capacity;
        }
    }
    if (S->n == S->capacity)
        return &S->nowhere;
    S->code[S->n] = (instruction){.code = (slot)code};
    return &S->code[S->n++];
}

bool cns_straight_compile(cns_arith *S)
{
    add(S, FINISHED);
    if (S->failed)
        return false;
    for (int a = 0; a < S->series; a++) {
        long e;
        const double m = S->ops->get_2exp(S->A, &e, a, 0);
        S->v[a] = ldexp(m, (int)e);
    }
    return true;
}

/* The accumulator as an instruction that a term may join, or none. */
static instruction *open_instruction(const cns_arith *S)
{
    instruction *last = S->n > 0 ? &S->code[S->n - 1] : NULL;
    return !S->fresh && last && last->code < FUNCTIONS && last->code % N_ENDS == KEEP ? last : NULL;
}

/* sign * a, or with b >= 0 sign * a b, to the accumulator. */
static void term(cns_arith *S, int times, int a, int b)
{
    const int kind = (b >= 0 ? PRODUCT : VALUE) + (times < 0);
    instruction *last = open_instruction(S);
    S->failed = S->failed || (times != 1 && times != -1);
    if (last && last->code / N_ENDS % N_SECONDS == THEN_NONE) {
        last->code = (slot)(last->code + N_ENDS * (kind + 1));
        last->c = (slot)a;
        last->d = (slot)(b >= 0 ? b : 0);
        return;
    }
    const bool fresh = S->fresh;
    instruction *i = add(S, fresh ? CODE(kind, THEN_NONE, KEEP) : CODE(GO_ON, kind + 1, KEEP));
    *(fresh ? &i->a : &i->c) = (slot)a;
    *(fresh ? &i->b : &i->d) = (slot)(b >= 0 ? b : 0);
    S->fresh = false;
}

static void ends(cns_arith *S, end how, int to, int by)
{
    instruction *last = open_instruction(S);
    if (!last) { /* an empty sum is zero for ever, and needs no code */
        S->failed = S->failed || !S->fresh || to >= S->series;
        return;
    }
    last->code = (slot)(last->code + (int)how);
    last->to = (slot)to;
    last->by = (slot)(by >= 0 ? by : 0);
    if (to < S->series) {
        S->stored[to] = true;
        S->seen[to] = false;
    }
    S->fresh = true;
}

/* Recording. */

static void only_order_zero(cns_arith *S, bool is_so)
{
    S->failed = S->failed || !is_so;
}

static void zero(cns_arith *S)
{
    S->ops->zero(S->A);
    S->fresh = true;
}

static void coef(cns_arith *S, int weight, int a, int k)
{
    S->ops->coef(S->A, weight, a, k);
    only_order_zero(S, k == 0);
    term(S, weight, a, -1);
}

static void scaled(cns_arith *S, int times, int c, int a, int k)
{
    S->ops->scaled(S->A, times, c, a, k);
    only_order_zero(S, k == 0);
    term(S, times, c, a);
}

static void conv(cns_arith *S, int times, int a, int b, int n, int lo, int hi)
{
    S->ops->conv(S->A, times, a, b, n, lo, hi);
    only_order_zero(S, n == 0 && lo == 0 && hi == 0);
    term(S, times, a, b);
}

static void square(cns_arith *S, int times, int a, int n, int lo)
{
    S->ops->square(S->A, times, a, n, lo);
    only_order_zero(S, n == 0 && lo == 0);
    term(S, times, a, a);
}

static void store(cns_arith *S, int w, int k)
{
    S->ops->store(S->A, w, k);
    only_order_zero(S, k == 0);
    ends(S, STORE, w, -1);
}

static void store_scaled(cns_arith *S, int w, int k, int c)
{
    S->ops->store_scaled(S->A, w, k, c);
    only_order_zero(S, k == 0);
    ends(S, STORE_SCALED, w, c);
}

static void store_ratio(cns_arith *S, int w, int k, int p, int q)
{
    S->ops->store_ratio(S->A, w, k, p, q);
    S->failed = true;
}

static void store_over(cns_arith *S, int w, int k, int d, int v, int twice)
{
    S->ops->store_over(S->A, w, k, d, v, twice);
    only_order_zero(S, k == 0 && v == 0);
    ends(S, twice ? STORE_OVER_TWICE : STORE_OVER, w, d);
}

static void store_next(cns_arith *S, int x, int k, int c)
{
    S->ops->store_next(S->A, x, k, c);
    only_order_zero(S, k == 0);
    ends(S, c >= 0 ? STORE_SCALED : STORE, S->series + x, c);
}

static void begin(cns_arith *S, double H)
{
    S->ops->begin(S->A, H);
    S->failed = true;
}

static void get(const cns_arith *S, mpfr_t y, int a, int k)
{
    S->ops->get(S->A, y, a, k);
    ((cns_arith *)S)->failed = true;
}

static void set(cns_arith *S, int w, int k, const mpfr_t y, bool keep)
{
    S->ops->set(S->A, w, k, y, keep);
    S->failed = true;
}

static double get_2exp(const cns_arith *constant, long *e, int a, int k)
{
    cns_arith *S = (cns_arith *)constant;
    const double m = S->ops->get_2exp(S->A, e, a, k);
    only_order_zero(S, k == 0 && m != 0);
    if (S->seen[a])
        return m;
    S->seen[a] = true;
    if (!S->stored[a])
        S->entry[S->n_entry++] = (sign){(slot)a, m < 0 ? -1 : 1};
    else
        add(S, m < 0 ? IS_NEGATIVE : IS_POSITIVE)->a = (slot)a;
    return m;
}

static void function(cns_arith *S, cns_function f, int w, int w2, int a, int b)
{
    S->ops->function(S->A, f, w, w2, a, b);
    instruction *i = add(S, FUNCTIONS + (int)f);
    i->a = (slot)a;
    i->b = (slot)(b >= 0 ? b : 0);
    i->to = (slot)w;
    i->by = (slot)(w2 >= 0 ? w2 : 0);
    S->stored[w] = true;
    S->seen[w] = false;
    if (w2 >= 0) {
        S->stored[w2] = true;
        S->seen[w2] = false;
    }
}

#define PRIMITIVE(KIND, name, n, ...) .name = name,
const cns_arith_ops cns_arith_straight = {
    .name = "straight",
    .begin = begin,
    .get = get,
    .set = set,
    .get_2exp = get_2exp,
    .function = function,
#include "primitives.def"
};
#undef PRIMITIVE

/* Running. */

#define START_VALUE         acc = v[i->a];
#define START_MINUS_VALUE   acc = -v[i->a];
#define START_PRODUCT       acc = v[i->a] * v[i->b];
#define START_MINUS_PRODUCT acc = -(v[i->a] * v[i->b]);
#define START_GO_ON
#define THEN_DO_NONE
#define THEN_DO_VALUE         acc += v[i->c];
#define THEN_DO_MINUS_VALUE   acc -= v[i->c];
#define THEN_DO_PRODUCT       acc += v[i->c] * v[i->d];
#define THEN_DO_MINUS_PRODUCT acc -= v[i->c] * v[i->d];
#define END_KEEP
#define END_STORE            v[i->to] = acc;
#define END_STORE_SCALED     v[i->to] = v[i->by] * acc;
#define END_STORE_OVER       v[i->to] = acc / v[i->by];
#define END_STORE_OVER_TWICE v[i->to] = acc / (2 * v[i->by]);

#define CASE(s, t, e)                                                                                        \
    case CODE(s, THEN_##t, e):                                                                               \
        START_##s THEN_DO_##t END_##e break;
#define CASES_OF_SECOND(s, t) ENDS(CASE, s, t)
#define CASES_OF_START(s)     SECONDS(CASES_OF_SECOND, s)

bool cns_straight_run(cns_arith *S)
{
    double *const v = S->v;
    double acc = 0;
    for (const sign *s = S->entry; s < S->entry + S->n_entry; s++)
        if (!(v[s->of] * s->sign > 0))
            return false;
    for (const instruction *i = S->code;; i++) {
        switch (i->code) {
            STARTS(CASES_OF_START)
        case FUNCTIONS + CNS_FN_SQRT:
            v[i->to] = sqrt(v[i->a]);
            break;
        case FUNCTIONS + CNS_FN_HYPOT:
            v[i->to] = hypot(v[i->a], v[i->b]);
            break;
        case FUNCTIONS + CNS_FN_SINCOS: {
            const double u = v[i->a];
            v[i->to] = sin(u);
            v[i->by] = cos(u);
            break;
        }
        case FUNCTIONS + CNS_FN_EXP:
            v[i->to] = exp(v[i->a]);
            break;
        case FUNCTIONS + CNS_FN_LOG:
            v[i->to] = log(v[i->a]);
            break;
        case FUNCTIONS + CNS_FN_POW:
            v[i->to] = pow(v[i->a], v[i->b]);
            break;
        case IS_POSITIVE:
            if (!(v[i->a] > 0))
                return false;
            break;
        case IS_NEGATIVE:
            if (!(v[i->a] < 0))
                return false;
            break;
        default: /* FINISHED */
            return true;
        }
    }
}
