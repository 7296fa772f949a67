/* The version, outcomes, messages, and what happens when memory runs out.
 *
 * A library function that can fail returns a cns_code and leaves one line of text, without a newline,
 * in the cns_error given to it. Nothing in the library prints, exits or aborts, except where memory is
 * exhausted in a way that cannot be a status: see cns_memory_guard(). The codes are the program's exit
 * statuses, except that it ends with 3 for CNS_MEMORY, too. */
#ifndef CNS_STATUS_H
#define CNS_STATUS_H

/* The Makefile, cns.pc and the program all read it here. */
#define CNS_VERSION "0.1.0"

/* What stands between these two is the interface: callable from C++ too, and visible in the shared library,
 * where all other functions are hidden. So a function becomes public by its declaration in a public header,
 * and needs no mark of its own. */
/* clang-format off */
#ifdef __cplusplus
#define CNS_BEGIN_DECLS _Pragma("GCC visibility push(default)") extern "C" {
#define CNS_END_DECLS   } _Pragma("GCC visibility pop")
#else
#define CNS_BEGIN_DECLS _Pragma("GCC visibility push(default)")
#define CNS_END_DECLS   _Pragma("GCC visibility pop")
#endif
/* clang-format on */

CNS_BEGIN_DECLS

typedef enum cns_code {
    CNS_OK = 0,
    CNS_UNREACHED = 1, /* not all that was asked for, such as decimals; what there is holds */
    CNS_USAGE = 2,     /* a mistake in what was asked for: arguments, command line, case file */
    CNS_NUMERIC = 3,   /* singularity, steps too small, out of range, or an error that the proof found */
    CNS_IO = 4,        /* input or output failed */
    CNS_MEMORY = 5,    /* out of memory */
    CNS_STOPPED = 128  /* plus the number of the signal */
} cns_code;

typedef struct cns_error {
    cns_code code;
    char text[1024];
} cns_error;

/* Formats the message into err (which may be NULL) and returns code. */
#if defined(__GNUC__)
__attribute__((format(printf, 3, 4)))
#endif
cns_code
cns_fail(cns_error *err, cns_code code, const char *format, ...);
cns_code cns_out_of_memory(cns_error *err); /* CNS_MEMORY, and what would help */

/* Makes running out of memory a status wherever it can be one. GMP, MPFR and FLINT end the program when
 * malloc() fails, and so do the library's own small allocations. After this call they draw on a reserve
 * instead: up to 32 MiB of address space, set aside here and not touched until then. The work that is under
 * way in any thread, at its next step, ends with CNS_MEMORY and frees what it holds; work begun later goes on
 * as soon as a new reserve can be set aside. Only when the reserve does not last until then is `exhausted`
 * called, from whichever thread it is; it must not return. NULL: abort().
 *
 * Call it once, before other threads use these libraries; numbers that exist already stay valid. Without the
 * call only large allocations fail with CNS_MEMORY, and small ones end the program by abort(). */
void cns_memory_guard(void (*exhausted)(void));

CNS_END_DECLS

#endif
