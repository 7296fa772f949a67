#include "trace.h"

#include <limits.h>
#include <stdlib.h>

struct cns_arith {
    cns_call *call;
    int n, capacity;
    bool failed; /* a value was asked for, or memory ran out */
};

cns_arith *cns_notes_new(void)
{
    return calloc(1, sizeof(cns_arith));
}

void cns_notes_free(cns_arith *notes)
{
    if (!notes)
        return;
    free(notes->call);
    free(notes);
}

void cns_notes_clear(cns_arith *notes)
{
    notes->n = 0;
    notes->failed = false;
}

bool cns_notes_agree(cns_arith *notes, int k, cns_calls *calls)
{
    const int n = notes->n / 2;
    if (notes->failed || notes->n % 2)
        return false;
    for (int i = 0; i < n; i++) {
        cns_call *now = &notes->call[i];
        const cns_call *then = &notes->call[n + i];
        if (now->kind != then->kind)
            return false;
        for (int j = 0; j < CNS_CALL_ARGUMENTS; j++) {
            now->grows[j] = then->arg[j] != now->arg[j];
            if (now->grows[j] && then->arg[j] != now->arg[j] + 1)
                return false;
        }
    }
    *calls = (cns_calls){.call = notes->call, .n = n, .order = k};
    return true;
}

static void note(cns_arith *A, cns_call call)
{
    if (A->n == A->capacity) {
        const int capacity = 2 * A->capacity + 64;
        cns_call *grown = realloc(A->call, (size_t)capacity * sizeof *grown);
        if (!grown) {
            A->failed = true;
            return;
        }
        A->call = grown;
        A->capacity = capacity;
    }
    A->call[A->n++] = call;
}

static void begin(cns_arith *A, double H)
{
    (void)A, (void)H;
}

static void get(const cns_arith *A, mpfr_t y, int a, int k)
{
    (void)a, (void)k;
    ((cns_arith *)A)->failed = true;
    mpfr_set_zero(y, 1);
}

static void set(cns_arith *A, int w, int k, const mpfr_t y, bool keep)
{
    (void)w, (void)k, (void)y, (void)keep;
    A->failed = true;
}

static double get_2exp(const cns_arith *A, long *e, int a, int k)
{
    (void)a, (void)k;
    ((cns_arith *)A)->failed = true;
    *e = 0;
    return 0;
}

static void function(cns_arith *A, cns_function f, int w, int w2, int a, int b)
{
    (void)f, (void)w, (void)w2, (void)a, (void)b;
    A->failed = true;
}

static void zero(cns_arith *A)
{
    note(A, (cns_call){.kind = CNS_CALL_ZERO});
}

static void coef(cns_arith *A, long weight, int a, int k)
{
    if (weight > INT_MAX || weight < -INT_MAX)
        A->failed = true;
    else
        note(A, (cns_call){.kind = CNS_CALL_COEF, .arg = {(int)weight, a, k}});
}

static void scaled(cns_arith *A, int sign, int c, int a, int k)
{
    note(A, (cns_call){.kind = CNS_CALL_SCALED, .arg = {sign, c, a, k}});
}

static void conv(cns_arith *A, int sign, int a, int b, int n, int lo, int hi)
{
    note(A, (cns_call){.kind = CNS_CALL_CONV, .arg = {sign, a, b, n, lo, hi}});
}

static void square(cns_arith *A, int sign, int a, int n, int lo)
{
    note(A, (cns_call){.kind = CNS_CALL_SQUARE, .arg = {sign, a, n, lo}});
}

static void store(cns_arith *A, int w, int k)
{
    note(A, (cns_call){.kind = CNS_CALL_STORE, .arg = {w, k}});
}

static void store_scaled(cns_arith *A, int w, int k, int c)
{
    note(A, (cns_call){.kind = CNS_CALL_STORE_SCALED, .arg = {w, k, c}});
}

static void store_ratio(cns_arith *A, int w, int k, long p, long q)
{
    if (p > INT_MAX || p < -INT_MAX || q > INT_MAX || q < -INT_MAX)
        A->failed = true;
    else
        note(A, (cns_call){.kind = CNS_CALL_STORE_RATIO, .arg = {w, k, (int)p, (int)q}});
}

static void store_over(cns_arith *A, int w, int k, int d, int v, int twice)
{
    note(A, (cns_call){.kind = CNS_CALL_STORE_OVER, .arg = {w, k, d, v, twice}});
}

static void store_next(cns_arith *A, int x, int k, int c)
{
    note(A, (cns_call){.kind = CNS_CALL_STORE_NEXT, .arg = {x, k, c}});
}

const cns_arith_ops cns_arith_notes = {
    .name = "notes",
    .begin = begin,
    .get = get,
    .set = set,
    .get_2exp = get_2exp,
    .zero = zero,
    .coef = coef,
    .scaled = scaled,
    .conv = conv,
    .square = square,
    .store = store,
    .store_scaled = store_scaled,
    .store_ratio = store_ratio,
    .store_over = store_over,
    .store_next = store_next,
    .function = function,
};
