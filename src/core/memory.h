/* Small allocations: texts, lists, trees of at most a few megabytes. When one fails the program aborts
 * with a line on stderr, which is what GMP and MPFR do for the numbers beside them. Anything that grows
 * with order, digits or series must not use these, but report CNS_NUMERIC or CNS_IO instead. */
#ifndef CNS_CORE_MEMORY_H
#define CNS_CORE_MEMORY_H

#include <stddef.h>

void *cns_xalloc(size_t count, size_t size);           /* zeroed; never NULL; free() frees */
void *cns_xgrow(void *old, size_t count, size_t size); /* realloc to count * size bytes */
char *cns_xcopy(const char *text);
char *cns_xcopy_n(const char *text, size_t length); /* adds the NUL */

#endif
