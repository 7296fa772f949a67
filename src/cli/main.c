#include <signal.h>

#include <gmp.h>
#include <mpfr.h>
#include <yaml.h>

#include "cns/version.h"
#include "commands.h"
#include "report.h"

static int print_version(void)
{
    cns_page page;
    cns_code code = cns_page_open(&page);
    if (code != CNS_OK)
        return (int)code;
    /* the libraries that run, not those that were compiled against */
    fprintf(page.file, "cns %s (MPFR %s, GMP %s, libyaml %s)\n", CNS_VERSION, mpfr_get_version(), gmp_version,
            yaml_get_version_string());
    return cns_page_print(&page);
}

int main(int argc, char **argv)
{
    /* A reader that goes away (`| head`) shows as a failed write, after which files can be put in order;
     * the exit status is the one that the signal would have given. */
    signal(SIGPIPE, SIG_IGN);

    cns_options o;
    cns_error err;
    int status;
    if (cns_options_parse(&o, argc, argv, &err) != CNS_OK)
        status = cns_complain(err.code, "%s", err.text);
    else if (o.version)
        status = print_version();
    else if (o.help)
        status = cns_command_help.run(&o);
    else
        status = o.command->run(&o);
    cns_options_clear(&o);
    mpfr_free_cache();
    return status;
}
