#include "memory.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void *checked(void *p)
{
    if (p == NULL) {
        fputs("cns: out of memory\n", stderr);
        abort();
    }
    return p;
}

void *cns_xalloc(size_t count, size_t size)
{
    /* malloc(0) may be NULL without being a failure */
    return checked(calloc(count > 0 ? count : 1, size > 0 ? size : 1));
}

void *cns_xgrow(void *old, size_t count, size_t size)
{
    if (size > 0 && count > SIZE_MAX / size)
        return checked(NULL);
    size_t bytes = count * size;
    return checked(realloc(old, bytes > 0 ? bytes : 1));
}

char *cns_xcopy_n(const char *text, size_t length)
{
    char *copy = cns_xgrow(NULL, length + 1, 1);
    if (length > 0)
        memcpy(copy, text, length);
    copy[length] = '\0';
    return copy;
}

char *cns_xcopy(const char *text)
{
    return cns_xcopy_n(text, strlen(text));
}
