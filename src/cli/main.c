#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include <gmp.h>
#include <mpfr.h>
#include <yaml.h>

#include "commands.h"
#include "core/files.h"
#include "report.h"
#include "signals.h"

/* The libraries that run, not those that were compiled against. */
static void print_version(FILE *out, const cns_context *cx, const void *result)
{
    (void)cx;
    (void)result;
    fprintf(out, "cns %s (MPFR %s, GMP %s, libyaml %s)\n", CNS_VERSION, mpfr_get_version(), gmp_version,
            yaml_get_version_string());
}

static int show_version(cns_context *cx)
{
    return cns_show(cx, &(cns_view){.text = print_version}, NULL);
}

static int run(const cns_options *o)
{
    static const cns_command version = {.run = show_version};
    const cns_command *command = o->version ? &version : o->help ? &cns_command_help : o->command;
    cns_context cx;
    int status = cns_context_open(&cx, o, command->opens);
    if (!status)
        status = command->run(&cx);
    cns_context_close(&cx);
    return status;
}

/* Memory is exhausted to the last, on any thread: nothing that allocates can be called any more. */
static void exhausted(void)
{
    static const char message[] =
        "cns: out of memory; fewer digits, a lower order or fewer threads need less\n";
    cns_files_remove_unfinished();
    if (write(STDERR_FILENO, message, sizeof message - 1) < 0)
        _exit(CNS_IO);
    _exit(CNS_NUMERIC);
}

/* The stack grows into address space that may be used up by then (ulimit -v), and where malloc() could only
 * fail, that ends the program with a segmentation fault. GMP puts temporaries of up to 64 KiB each there. So
 * the stack is made to grow first, if there is room for it. */
enum { STACK = 1 << 20 };

static void touch_deep_stack(void)
{
    volatile char deep[STACK];
    deep[0] = 0;
    (void)deep[0];
}

static void grow_stack(void)
{
    void (*volatile touch)(void) = touch_deep_stack; /* volatile: inlined, it would touch before it asks */
    struct rlimit limit;
    void *volatile room = malloc(2 * STACK);
    free(room);
    if (room != NULL && getrlimit(RLIMIT_STACK, &limit) == 0 && limit.rlim_cur >= 4 * STACK)
        touch();
}

int main(int argc, char **argv)
{
    grow_stack();
    cns_memory_guard(exhausted);
    cns_signals_as_failures();

    cns_options o;
    cns_error err;
    int status = cns_options_parse(&o, argc, argv, &err) ? cns_complain(err.code, "%s", err.text) : run(&o);
    cns_options_clear(&o);
    mpfr_free_cache();
    return status == CNS_MEMORY ? CNS_NUMERIC : status;
}
