/* The calls that the recurrences make of an arithmetic at one order, written down. */
#ifndef CNS_ARITH_TRACE_H
#define CNS_ARITH_TRACE_H

#include "arith.h"

/* An arithmetic that computes nothing: what is called is appended to its list. */
extern const cns_arith_ops cns_arith_notes;
cns_arith *cns_notes_new(void); /* NULL: out of memory */
void cns_notes_free(cns_arith *notes);
void cns_notes_clear(cns_arith *notes);

/* `notes` are the calls of order k followed by those of order k + 1. True: they are the same but for
 * arguments that grow by one, and *calls says so until the notes are cleared. False also where a recurrence
 * looked at a value: what it does next may depend on it. */
bool cns_notes_agree(cns_arith *notes, int k, cns_calls *calls);

/* The calls from the one numbered `first` on, at order k. In line, so that an arithmetic that names its own
 * primitives calls them directly. */
static inline void cns_make_calls(const cns_arith_ops *ops, cns_arith *A, const cns_calls *calls, int first,
                                  int k)
{
    for (const cns_call *c = calls->call + first; c < calls->call + calls->n; c++) {
        int x[CNS_CALL_ARGUMENTS];
        for (int i = 0; i < CNS_CALL_ARGUMENTS; i++)
            x[i] = c->arg[i] + (c->grows[i] ? k - calls->order : 0);
        switch (c->kind) {
        case CNS_CALL_ZERO:
            ops->zero(A);
            break;
        case CNS_CALL_COEF:
            ops->coef(A, x[0], x[1], x[2]);
            break;
        case CNS_CALL_SCALED:
            ops->scaled(A, x[0], x[1], x[2], x[3]);
            break;
        case CNS_CALL_CONV:
            ops->conv(A, x[0], x[1], x[2], x[3], x[4], x[5]);
            break;
        case CNS_CALL_SQUARE:
            ops->square(A, x[0], x[1], x[2], x[3]);
            break;
        case CNS_CALL_STORE:
            ops->store(A, x[0], x[1]);
            break;
        case CNS_CALL_STORE_SCALED:
            ops->store_scaled(A, x[0], x[1], x[2]);
            break;
        case CNS_CALL_STORE_RATIO:
            ops->store_ratio(A, x[0], x[1], x[2], x[3]);
            break;
        case CNS_CALL_STORE_OVER:
            ops->store_over(A, x[0], x[1], x[2], x[3], x[4]);
            break;
        case CNS_CALL_STORE_NEXT:
            ops->store_next(A, x[0], x[1], x[2]);
            break;
        }
    }
}

#endif
