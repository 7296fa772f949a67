/* The calls that the recurrences make of an arithmetic at one order, written down. */
#ifndef CNS_TAYLOR_CALLS_H
#define CNS_TAYLOR_CALLS_H

#include "cns/arith.h"

/* An arithmetic that computes nothing: what is called is appended to its list. */
extern const cns_arith_ops cns_arith_notes;
cns_arith *cns_notes_new(void); /* NULL: out of memory */
void cns_notes_free(cns_arith *notes);
void cns_notes_clear(cns_arith *notes);

/* `notes` are the calls of order k followed by those of order k + 1. True: they are the same but for
 * arguments that grow by one, and *calls says so until the notes are cleared. False also where a recurrence
 * looked at a value: what it does next may depend on it. */
bool cns_notes_agree(cns_arith *notes, int k, cns_calls *calls);

#endif
