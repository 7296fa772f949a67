/* Traces: what the recurrences do at one order, recorded, and done again at others. */
#ifndef CNS_ARITH_TRACE_H
#define CNS_ARITH_TRACE_H

#include "arith.h"

/* An arithmetic that computes nothing: it records the calls of its primitives. */
extern const cns_arith_ops cns_arith_recorder;
cns_arith *cns_recorder_new(void); /* NULL: out of memory */
void cns_recorder_free(cns_arith *recorder);
void cns_recorder_clear(cns_arith *recorder);

/* The recorder holds the calls of order k followed by those of order k + 1. True: they are the same but for
 * arguments that grow by one; *trace, which says so, lives until the recorder is cleared. False also where a
 * recurrence looked at a value: what it does next may depend on it. */
bool cns_recorder_trace(cns_arith *recorder, int k, cns_trace *trace);

/* The arguments of a call at order k. */
static inline void cns_trace_arguments(const cns_trace *trace, const cns_trace_call *call, int k, int *x)
{
    for (int i = 0; i < CNS_MOST_ARGUMENTS; i++)
        x[i] = call->arg[i] + (call->grows[i] ? k - trace->order : 0);
}

#define CNS_ELEMENTS_0(x)
#define CNS_ELEMENTS_2(x) , x[0], x[1]
#define CNS_ELEMENTS_3(x) , x[0], x[1], x[2]
#define CNS_ELEMENTS_4(x) , x[0], x[1], x[2], x[3]
#define CNS_ELEMENTS_5(x) , x[0], x[1], x[2], x[3], x[4]
#define CNS_ELEMENTS_6(x) , x[0], x[1], x[2], x[3], x[4], x[5]

/* Makes the calls from the one numbered `first` on, at order k. In line, so that an arithmetic that names its
 * own primitives calls them directly. */
static inline void cns_trace_replay(const cns_arith_ops *ops, cns_arith *A, const cns_trace *trace, int first,
                                    int k)
{
    for (const cns_trace_call *c = trace->call + first; c < trace->call + trace->n; c++) {
        int x[CNS_MOST_ARGUMENTS];
        cns_trace_arguments(trace, c, k, x);
        switch (c->primitive) {
#define PRIMITIVE(KIND, name, n, ...)                                                                        \
    case CNS_PRIMITIVE_##KIND:                                                                               \
        ops->name(A CNS_ELEMENTS_##n(x));                                                                    \
        break;
#include "primitives.def"
#undef PRIMITIVE
        }
    }
}

#endif
