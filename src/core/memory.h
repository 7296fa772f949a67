/* Memory, and what happens when there is no more.
 *
 * Small allocations - texts, lists, trees, and what GMP, MPFR and FLINT ask for - do not fail. A program that
 * has called cns_memory_guard() (cns/status.h) has a reserve set aside. When malloc() has nothing more to
 * give, the reserve is handed to it, the allocation is repeated, and the work at hand has that much memory to
 * come to its end in good order: long loops ask cns_go_on() at every turn, which says so. Without a
 * reserve, or when it does not last, the program ends, as GMP, MPFR and FLINT would end it by themselves.
 *
 * Whatever grows with order, digits or series is allocated in a few large blocks by malloc() itself, whose
 * failure is a status, cns_out_of_memory(), and leaves the reserve alone. */
#ifndef CNS_CORE_MEMORY_H
#define CNS_CORE_MEMORY_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>

#include "cns/status.h"

void *cns_xalloc(size_t count, size_t size);           /* zeroed; never NULL; free() frees */
void *cns_xgrow(void *old, size_t count, size_t size); /* realloc to count * size bytes */
char *cns_xcopy(const char *text);
char *cns_xcopy_n(const char *text, size_t length); /* adds the NUL */

/* What these do when malloc() has failed once, and when it has failed again. */
void cns_memory_hand_out(void);
_Noreturn void cns_memory_give_up(void);

/* Whether the reserve has been handed out and cannot be had back, because memory is still short. */
bool cns_memory_short(void);

/* May work go on? CNS_STOPPED: no, *stop was raised (stop may be NULL); CNS_MEMORY: no, memory is short. */
cns_code cns_go_on(const volatile sig_atomic_t *stop, cns_error *err);

#endif
