/* Outcomes and messages.
 *
 * A library function that can fail returns a cns_code and leaves one line of text, without a newline,
 * in the cns_error given to it. Nothing in the library prints or exits; the command line does both.
 * The codes are the program's exit statuses. */
#ifndef CNS_STATUS_H
#define CNS_STATUS_H

/* What stands between these two is the interface: callable from C++ too, and visible in the shared library,
 * where all other functions are hidden. So a function becomes public by its declaration in a public header,
 * and needs no mark of its own. */
#ifdef __cplusplus
#define CNS_BEGIN_DECLS                                                                                      \
    _Pragma("GCC visibility push(default)") extern "C"                                                       \
    {
#define CNS_END_DECLS                                                                                        \
    }                                                                                                        \
    _Pragma("GCC visibility pop")
#else
#define CNS_BEGIN_DECLS _Pragma("GCC visibility push(default)")
#define CNS_END_DECLS   _Pragma("GCC visibility pop")
#endif

CNS_BEGIN_DECLS

typedef enum cns_code {
    CNS_OK = 0,
    CNS_UNREACHED = 1, /* the asked decimals or bracket were not reached; the honest result stands */
    CNS_USAGE = 2,     /* command line or case file */
    CNS_NUMERIC = 3,   /* singularity, step underflow, range, or an error that the proof found */
    CNS_IO = 4,        /* input or output */
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

CNS_END_DECLS

#endif
