#include "context.h"

#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include "arith/arith.h"
#include "core/clock.h"
#include "core/memory.h"
#include "integrate/trajectory.h"
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
    cns_context *s = context;
    cns_meter_show(&s->meter, fraction, cns_seconds() - s->since, what);
}

void cns_context_begin(const cns_options *o, cns_context *s)
{
    *s = (cns_context){.o = o, .since = cns_seconds()};
    s->study = (cns_study){.threads = 1, .stop = &stop_signal, .progress = on_progress, .context = s};
    catch_signals();
    cns_meter_init(&s->meter, o->quiet);
}

int cns_context_open(const cns_options *o, cns_context *s)
{
    cns_error err = {0};
    const char *kernel; /* a wrong CNS_KERNEL is a usage error before anything is opened */
    *s = (cns_context){.o = o, .since = cns_seconds()};
    int status = (int)cns_open_case(o, &s->c);
    if (status != 0)
        return status;
    const cns_case *c = s->c;
    const int n = c->model->n_states;
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    s->scales = cns_xalloc((size_t)n, sizeof *s->scales);
    for (int i = 0; i < n; i++)
        s->scales[i] = c->model->states[i].scale;
    s->study = (cns_study){.model = c->model,
                           .parameters = c->parameters,
                           .initial = c->initial,
                           .smooth = c->smooth ? &c->eps : NULL,
                           .end = &c->end,
                           .every = &c->every,
                           .scales = s->scales,
                           .threads = o->threads > 0   ? (int)o->threads
                                      : processors > 0 ? (int)processors
                                                       : 1,
                           .stop = &stop_signal,
                           .progress = on_progress,
                           .context = s};
    if (cns_fast_kernel_name(&kernel, &err) || cns_study_program(&s->study, &s->program, &err)) {
        cns_context_close(s);
        return cns_complain(err.code, "%s", err.text);
    }
    s->problem = (cns_problem){.program = s->program,
                               .scales = s->scales,
                               .initial = c->initial,
                               .end = &c->end,
                               .every = &c->every,
                               .columns = c->columns,
                               .n_columns = c->n_columns,
                               .threads = s->study.threads,
                               .stop = &stop_signal};
    catch_signals();
    cns_meter_init(&s->meter, o->quiet);
    return 0;
}

void cns_context_close(cns_context *s)
{
    cns_meter_clear(&s->meter);
    cns_program_free(s->program);
    free(s->scales);
    cns_case_free(s->c);
}

int cns_context_status(cns_context *s, cns_code code, const cns_error *err)
{
    cns_meter_clear(&s->meter);
    if (code == CNS_STOPPED)
        return CNS_STOPPED + (int)stop_signal;
    return code ? cns_complain(code, "%s", err->text) : 0;
}
