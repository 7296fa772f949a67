#include "context.h"

#include <math.h>
#include <stdlib.h>
#include <unistd.h>

#include "arith/fast.h"
#include "commands.h"
#include "core/clock.h"
#include "core/memory.h"
#include "core/text.h"
#include "outputs.h"
#include "report.h"
#include "signals.h"

void cns_context_tell(void *context, double fraction, const char *what)
{
    cns_context *cx = context;
    cns_meter_show(&cx->meter, fraction, cns_seconds() - cx->since, what);
    cx->fraction = fraction;
    snprintf(cx->what, sizeof cx->what, "%s", what);
}

void cns_context_watch(cns_context *cx)
{
    cx->monitor.stop = &cns_signal_stop;
    cx->monitor.progress = cns_context_tell;
    cx->monitor.context = cx;
    cns_signals_catch();
    cns_meter_init(&cx->meter, cx->o->quiet);
}

static int open_case(cns_context *cx)
{
    const cns_options *o = cx->o;
    char *faults = NULL;
    cns_code code = cns_case_load(o->operands.at[0], o->sets.at, o->sets.n, &cx->c, &faults);
    if (faults != NULL && code == CNS_USAGE)
        cns_say(faults); /* the lines begin with the place, as compilers have it */
    else if (faults != NULL)
        cns_complain(code, "%s", faults);
    free(faults);
    if (cx->c != NULL && cx->c->replaced != NULL)
        cns_note(cx, "--set %s replaces '%s' of %s", cx->c->has_goal ? "goal..." : "numerics...",
                 cx->c->replaced, cx->c->name);
    return (int)code;
}

/* A run with a goal, and its plan, keep to a limit by themselves; all else is stopped. */
static void limit_time(cns_context *cx)
{
    cns_case *c = cx->c;
    const double limit = cx->o->max_time > 0 ? cx->o->max_time : c->max_time;
    if (!(limit > 0))
        return;
    if (cx->o->command->limits && cx->o->sweep == NULL && !c->has_numerics) {
        c->goal.max_time = c->goal.max_time > 0 ? fmin(c->goal.max_time, limit) : limit;
    } else {
        cx->monitor.limited = true;
        cns_signals_limit(limit);
    }
}

/* The system to the case's start and direction, and its list of times to what has passed since. */
static bool move(cns_context *cx, cns_error *err)
{
    const cns_case *c = cx->c;
    const bool moved = c->backwards || cns_number_sign(&c->start) != 0;
    if (cx->o->command->times == CNS_TIMES_REFUSED && (moved || c->at != NULL))
        return cns_fail(err, CNS_USAGE, "%s: `cns %s` counts time from 0 on, in rows: it takes no %s",
                        c->name, cx->o->command->name,
                        c->at != NULL  ? "list of times"
                        : c->backwards ? "end before the start"
                                       : "other start") == CNS_OK;
    cns_system *other = moved ? cns_system_from(cx->system, &c->start, c->backwards, err) : NULL;
    if (moved && other == NULL)
        return false;
    if (moved) {
        cns_system_free(cx->system);
        cx->system = other;
    }
    if (c->at == NULL)
        return true;
    cx->at = cns_xalloc((size_t)c->n_at, sizeof *cx->at);
    for (int i = 0; i < c->n_at; i++) {
        cns_number_init(&cx->at[i]);
        cns_number_set(&cx->at[i], &c->at[i]);
        mpq_sub(cx->at[i].ratio, c->at[i].ratio, c->start.ratio);
        mpq_abs(cx->at[i].ratio, cx->at[i].ratio);
    }
    return true;
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
    if (o->command->times != CNS_TIMES_IGNORED && !move(cx, &err))
        return cns_complain(err.code, "%s", err.text);
    cx->monitor.threads = o->threads > 0 ? (int)o->threads : processors > 0 ? (int)processors : 1;
    cx->problem = (cns_problem){.system = cx->system,
                                .end = &c->span,
                                .every = &c->every,
                                .at = cx->at,
                                .n_at = c->n_at,
                                .columns = c->columns,
                                .n_columns = c->n_columns,
                                .monitor = &cx->monitor};
    cns_context_watch(cx);
    limit_time(cx);
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
    for (int i = 0; cx->at != NULL && i < cx->c->n_at; i++)
        cns_number_clear(&cx->at[i]);
    free(cx->at);
    cns_case_free(cx->c);
}

/* Where a study was stopped, what there is of it, and how to go on. */
static void tell_stop(cns_context *cx)
{
    char where[sizeof cx->what + 32] = "", kept[400];
    const char *printed = cx->shown ? "; what was found so far is printed" : "";
    if (cx->what[0] != '\0')
        snprintf(where, sizeof where, " at %.0f %% (%s)", 100 * cx->fraction, cx->what);
    if (cx->kept != NULL)
        snprintf(kept, sizeof kept, "what is finished is kept in %.300s: the same command goes on from there",
                 cx->kept);
    else
        snprintf(kept, sizeof kept, "nothing is kept: the same command begins anew%s%s%s",
                 cx->keeper != NULL ? ", with " : "", cx->keeper != NULL ? cx->keeper : "",
                 cx->keeper != NULL ? " it would go on" : "");
    cns_meter_clear(&cx->meter);
    if (!cx->o->quiet || cns_signal_status() == CNS_UNREACHED) /* who sends a signal knows of it */
        cns_complain(CNS_OK, "stopped by %s%s%s; %s", cns_signal_text(), where, printed, kept);
}

int cns_context_status(cns_context *cx, cns_code code, const cns_error *err)
{
    cns_meter_clear(&cx->meter);
    if (code == CNS_STOPPED) {
        tell_stop(cx);
        return cns_signal_status();
    }
    return code ? cns_complain(code, "%s", err->text) : 0;
}
