#include <signal.h>

#include <gmp.h>
#include <mpfr.h>
#include <yaml.h>

#include "cns/version.h"
#include "commands.h"
#include "report.h"

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

int main(int argc, char **argv)
{
    /* A reader that goes away (`| head`) shows as a failed write, after which files can be put in order;
     * the exit status is the one that the signal would have given. */
    signal(SIGPIPE, SIG_IGN);

    cns_options o;
    cns_error err;
    int status = cns_options_parse(&o, argc, argv, &err) ? cns_complain(err.code, "%s", err.text) : run(&o);
    cns_options_clear(&o);
    mpfr_free_cache();
    return status;
}
