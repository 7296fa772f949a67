#include "memory.h"

#include <flint/flint.h>
#include <gmp.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* The reserve is address space: nobody writes to it, so that it takes no memory while it lies idle. The least
 * is what the clean-up of any work needs. */
enum { MOST_RESERVE = 32 << 20, LEAST_RESERVE = 1 << 20 };

static struct {
    pthread_mutex_t lock;
    size_t size; /* 0: there is none */
    void *block; /* NULL: handed out */
    void (*exhausted)(void);
} reserve = {.lock = PTHREAD_MUTEX_INITIALIZER};

static atomic_bool handed_out; /* a copy of size > 0 && !block, which loops read without the lock */

static void set_aside(void)
{
    reserve.block = malloc(reserve.size);
    atomic_store(&handed_out, reserve.block == NULL);
}

void cns_memory_hand_out(void)
{
    pthread_mutex_lock(&reserve.lock);
    free(reserve.block);
    reserve.block = NULL;
    atomic_store(&handed_out, reserve.size > 0);
    pthread_mutex_unlock(&reserve.lock);
}

bool cns_memory_short(void)
{
    if (!atomic_load_explicit(&handed_out, memory_order_relaxed))
        return false;
    pthread_mutex_lock(&reserve.lock);
    if (reserve.block == NULL)
        set_aside();
    const bool is_short = reserve.block == NULL;
    pthread_mutex_unlock(&reserve.lock);
    return is_short;
}

_Noreturn void cns_memory_give_up(void)
{
    if (reserve.exhausted != NULL)
        reserve.exhausted();
    abort();
}

void *cns_xalloc(size_t count, size_t size)
{
    count = count > 0 ? count : 1; /* calloc() of nothing may be NULL without being a failure */
    size = size > 0 ? size : 1;
    void *p = calloc(count, size);
    if (p == NULL) {
        cns_memory_hand_out(); /* also where another thread has just done so: then there is memory now */
        p = calloc(count, size);
    }
    if (p == NULL)
        cns_memory_give_up();
    return p;
}

void *cns_xgrow(void *old, size_t count, size_t size)
{
    if (size > 0 && count > SIZE_MAX / size)
        cns_memory_give_up();
    const size_t bytes = count * size > 0 ? count * size : 1;
    void *p = realloc(old, bytes);
    if (p == NULL) {
        cns_memory_hand_out();
        p = realloc(old, bytes);
    }
    if (p == NULL)
        cns_memory_give_up();
    return p;
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

cns_code cns_go_on(const volatile sig_atomic_t *stop, cns_error *err)
{
    if (stop != NULL && *stop)
        return cns_fail(err, CNS_STOPPED, "stopped");
    return cns_memory_short() ? cns_out_of_memory(err) : CNS_OK;
}

/* The forms in which GMP (MPFR takes GMP's) and FLINT want their functions. All of them free by free(), so
 * that what these libraries have allocated before stays theirs to free. */

static void *gmp_alloc(size_t bytes)
{
    return cns_xgrow(NULL, bytes, 1);
}

static void *gmp_realloc(void *old, size_t old_bytes, size_t bytes)
{
    (void)old_bytes;
    return cns_xgrow(old, bytes, 1);
}

static void gmp_free(void *p, size_t bytes)
{
    (void)bytes;
    free(p);
}

static void *flint_grow(void *old, size_t bytes)
{
    return cns_xgrow(old, bytes, 1);
}

void cns_memory_guard(void (*exhausted)(void))
{
    pthread_mutex_lock(&reserve.lock);
    reserve.exhausted = exhausted;
    /* Where memory is scarce from the start, at most half of what there is. */
    for (size_t size = MOST_RESERVE; reserve.size == 0 && size >= LEAST_RESERVE; size /= 2) {
        void *volatile twice = malloc(2 * size); /* volatile: the compiler may leave out what nobody reads */
        if (twice == NULL)
            continue;
        free(twice);
        reserve.size = size;
        set_aside();
    }
    pthread_mutex_unlock(&reserve.lock);
    mp_set_memory_functions(gmp_alloc, gmp_realloc, gmp_free);
    __flint_set_memory_functions(gmp_alloc, cns_xalloc, flint_grow, free);
}
