#include "trace.h"

#include <stdlib.h>
#include <string.h>

struct cns_arith {
    cns_trace_call *call;
    int n, capacity;
    bool failed; /* a value was asked for, of which there is none, or memory ran out */
};

cns_arith *cns_recorder_new(void)
{
    return calloc(1, sizeof(cns_arith));
}

void cns_recorder_free(cns_arith *recorder)
{
    if (!recorder)
        return;
    free(recorder->call);
    free(recorder);
}

void cns_recorder_clear(cns_arith *recorder)
{
    recorder->n = 0;
    recorder->failed = false;
}

bool cns_recorder_trace(cns_arith *recorder, int k, cns_trace *trace)
{
    const int n = recorder->n / 2;
    if (recorder->failed || recorder->n % 2)
        return false;
    for (int i = 0; i < n; i++) {
        cns_trace_call *now = &recorder->call[i];
        const cns_trace_call *next = &recorder->call[n + i];
        if (now->primitive != next->primitive)
            return false;
        for (int j = 0; j < CNS_MOST_ARGUMENTS; j++) {
            now->grows[j] = next->arg[j] != now->arg[j];
            if (now->grows[j] && next->arg[j] != now->arg[j] + 1)
                return false;
        }
    }
    *trace = (cns_trace){.call = recorder->call, .n = n, .order = k};
    return true;
}

static void record(cns_arith *A, cns_primitive primitive, const int *arg)
{
    if (A->n == A->capacity) {
        const int capacity = 2 * A->capacity + 64;
        cns_trace_call *grown = realloc(A->call, (size_t)capacity * sizeof *grown);
        if (!grown) {
            A->failed = true;
            return;
        }
        A->call = grown;
        A->capacity = capacity;
    }
    cns_trace_call *call = &A->call[A->n++];
    call->primitive = primitive;
    memcpy(call->arg, arg, sizeof call->arg);
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

#define PRIMITIVE(KIND, name, n, ...)                                                                        \
    static void name(cns_arith *A CNS_INTS_##n(__VA_ARGS__))                                                 \
    {                                                                                                        \
        record(A, CNS_PRIMITIVE_##KIND, CNS_ARRAY(CNS_NAMES_##n(__VA_ARGS__)));                              \
    }
#include "primitives.def"
#undef PRIMITIVE

const cns_arith_ops cns_arith_recorder = {
    .name = "recorder",
    .begin = begin,
    .get = get,
    .set = set,
    .get_2exp = get_2exp,
    .function = function,
#define PRIMITIVE(KIND, name, n, ...) .name = name,
#include "primitives.def"
#undef PRIMITIVE
};
