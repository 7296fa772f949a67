/* A C library with little memory, for tests that put it before a program by LD_PRELOAD (glibc).
 *
 * CNS_TEST_MEMORY_ENDS=N: from the N-th allocation on, no more memory is handed out than is out at that moment.
 * That allocation fails, and later ones until something has been freed, as they do at a limit of the system; but
 * the limit is exact, and lies where the test wants it. CNS_TEST_MEMORY_COUNT=FILE: at the end the number of
 * allocations is written to FILE, and the number of blocks not freed. */
#include <errno.h>
#include <fcntl.h>
#include <malloc.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);
void *__libc_memalign(size_t alignment, size_t size);
void __libc_free(void *p);

static atomic_long allocations, blocks;
static atomic_size_t out, limit = SIZE_MAX; /* bytes */
static long ends;

__attribute__((constructor)) static void begin(void)
{
    const char *text = getenv("CNS_TEST_MEMORY_ENDS");
    ends = text != NULL ? strtol(text, NULL, 10) : 0;
}

__attribute__((destructor)) static void end(void)
{
    const char *path = getenv("CNS_TEST_MEMORY_COUNT");
    char line[64];
    const int length = snprintf(line, sizeof line, "%ld %ld\n", (long)allocations, (long)blocks);
    const int file = path != NULL ? open(path, O_WRONLY | O_CREAT | O_TRUNC, 0666) : -1;
    if (file >= 0 && write(file, line, (size_t)length) == length)
        close(file);
}

/* May `more` bytes go out? */
static bool granted(size_t more)
{
    if (++allocations == ends)
        limit = out;
    const size_t most = limit, now = out;
    if (now <= most && more <= most - now)
        return true;
    errno = ENOMEM;
    return false;
}

static void *handed_out(void *p)
{
    if (p != NULL) {
        out += malloc_usable_size(p);
        blocks++;
    }
    return p;
}

void *malloc(size_t size)
{
    return granted(size) ? handed_out(__libc_malloc(size)) : NULL;
}

void *memalign(size_t alignment, size_t size)
{
    return granted(size) ? handed_out(__libc_memalign(alignment, size)) : NULL;
}

void *aligned_alloc(size_t alignment, size_t size)
{
    return memalign(alignment, size);
}

int posix_memalign(void **p, size_t alignment, size_t size)
{
    *p = memalign(alignment, size);
    return *p != NULL ? 0 : ENOMEM;
}

void *calloc(size_t count, size_t size)
{
    if (size > 0 && count > SIZE_MAX / size) {
        errno = ENOMEM;
        return NULL;
    }
    return granted(count * size) ? handed_out(__libc_calloc(count, size)) : NULL;
}

void free(void *p)
{
    const int before = errno;
    if (p != NULL) {
        out -= malloc_usable_size(p);
        blocks--;
        __libc_free(p);
    }
    errno = before;
}

void *realloc(void *old, size_t size)
{
    if (old == NULL)
        return malloc(size);
    const size_t had = malloc_usable_size(old);
    if (!granted(size > had ? size - had : 0))
        return NULL;
    void *p = __libc_realloc(old, size);
    if (p != NULL)
        out += malloc_usable_size(p) - had;
    else if (size == 0)
        blocks--;
    return p;
}
