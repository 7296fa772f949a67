#include "context.h"

#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include "arith/fast.h"
#include "core/clock.h"
#include "core/text.h"
#include "outputs.h"
#include "report.h"

static volatile sig_atomic_t stop_signal; /* the one thing a signal handler can reach */

static void on_signal(int number)
{
    stop_signal = number;
}

static void catch_signals(void)
{
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)(SA_RESETHAND | SA_RESTART)};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    sigaction(SIGHUP, &action, NULL);
}

static void on_progress(void *context, double fraction, const char *what)
{
    cns_context *cx = context;
    cns_meter_show(&cx->meter, fraction, cns_seconds() - cx->since, what);
}

void cns_context_watch(cns_context *cx)
{
    cx->monitor.stop = &stop_signal;
    cx->monitor.progress = on_progress;
    cx->monitor.context = cx;
    catch_signals();
    cns_meter_init(&cx->meter, cx->o->quiet);
}

static int open_case(cns_context *cx)
{
    const cns_options *o = cx->o;
    char *faults = NULL;
    cns_code code = cns_case_load(o->operands.at[0], o->sets.at, o->sets.n, &cx->c, &faults);
    if (faults != NULL && code == CNS_USAGE)
        fprintf(stderr, "%s\n", faults); /* the lines begin with the place, as compilers have it */
    else if (faults != NULL)
        cns_complain(code, "%s", faults);
    free(faults);
    return (int)code;
}

static int open_system(cns_context *cx)
{
    const cns_case *c = cx->c;
    const cns_options *o = cx->o;
    cns_error err = {0};
    const char *kernel = getenv("CNS_KERNEL");
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    if (cns_fast_choose_kernel(kernel, &err))
        return cns_complain(err.code, "CNS_KERNEL=%s: %s", cns_quote(kernel).text, err.text);
    cx->system = cns_system_new(c->model, c->parameters, c->initial, c->smooth ? &c->eps : NULL, &err);
    if (cx->system == NULL)
        return cns_complain(err.code, "%s", err.text);
    cx->monitor.threads = o->threads > 0 ? (int)o->threads : processors > 0 ? (int)processors : 1;
    cx->problem = (cns_problem){.system = cx->system,
                                .end = &c->end,
                                .every = &c->every,
                                .columns = c->columns,
                                .n_columns = c->n_columns,
                                .monitor = &cx->monitor};
    cns_context_watch(cx);
    return 0;
}

int cns_context_open(cns_context *cx, const cns_options *o, cns_opens opens)
{
    *cx = (cns_context){.o = o, .since = cns_seconds()};
    int status = cns_outputs_check(o);
    if (!status && opens >= CNS_OPENS_CASE)
        status = open_case(cx);
    return status || opens < CNS_OPENS_SYSTEM ? status : open_system(cx);
}

void cns_context_close(cns_context *cx)
{
    cns_meter_clear(&cx->meter);
    cns_system_free(cx->system);
    cns_case_free(cx->c);
}

int cns_context_status(cns_context *cx, cns_code code, const cns_error *err)
{
    cns_meter_clear(&cx->meter);
    if (code == CNS_STOPPED)
        return CNS_STOPPED + (int)stop_signal;
    return code ? cns_complain(code, "%s", err->text) : 0;
}
