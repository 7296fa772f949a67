#include "cns/study/equilibria.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/files.h"
#include "core/memory.h"
#include "core/monitor.h"
#include "fixed_point.h"
#include "num/ball_text.h"
#include "num/logs.h"

enum { GUARD_BITS = 64, TRIES = 4 };

/* The fixed points that were found, in ball arithmetic. */
typedef struct find {
    const cns_system *s;
    const cns_monitor *monitor;
    cns_reduced reduced;
    cns_model_guess guess[CNS_MODEL_MAX_GUESSES];
    double start[CNS_MODEL_MAX_GUESSES][CNS_MODEL_MAX_STATES]; /* of the dynamic states */
    bool found[CNS_MODEL_MAX_GUESSES];
    cns_fixed_point point[CNS_MODEL_MAX_GUESSES];
    int n;
    char missing[512]; /* why some were not found */
} find;

static void miss(find *f, int i, const cns_error *why)
{
    const size_t used = strlen(f->missing);
    snprintf(f->missing + used, sizeof f->missing - used, "%s%s: %s", used > 0 ? "; " : "", f->guess[i].name,
             why->text);
}

/* All points at a precision. */
static cns_code locate(find *f, slong prec, cns_error *err)
{
    cns_code code = CNS_OK;
    f->missing[0] = '\0';
    for (int i = 0; i < f->n && !code; i++) {
        cns_error why;
        code = cns_go_on(cns_monitor_stop(f->monitor), err);
        cns_monitor_tell(f->monitor, (double)i / f->n, f->guess[i].name);
        f->found[i] = !code && !cns_fixed_point_find(&f->reduced, f->start[i], prec, &f->point[i], &why);
        if (!code && !f->found[i])
            miss(f, i, &why);
    }
    return code;
}

static void clear_item(cns_equilibrium *e, int d)
{
    for (int k = 0; k < d; k++) {
        if (e->state != NULL)
            free(e->state[k]);
        if (e->eigenvalues != NULL) {
            free(e->eigenvalues[k].re);
            free(e->eigenvalues[k].im);
        }
    }
    free(e->name);
    free(e->state);
    free(e->eigenvalues);
    *e = (cns_equilibrium){0};
}

static const char *stability(const cns_fixed_point *p, int stable, int unstable)
{
    bool spiral = false;
    for (int k = 0; k < p->d; k++)
        spiral = spiral || !arb_contains_zero(acb_imagref(p->spectrum.lambda + k));
    if (stable + unstable < p->d)
        return "not hyperbolic";
    if (unstable == 0)
        return spiral ? "stable focus" : "stable node";
    if (stable == 0)
        return spiral ? "unstable focus" : "unstable node";
    return spiral ? "saddle-focus" : "saddle";
}

/* False: not all texts are certain. */
static bool describe(const cns_fixed_point *p, const char *name, long decimals, cns_equilibrium *e)
{
    const int d = p->d;
    bool certain = true;
    *e = (cns_equilibrium){.name = cns_xcopy(name),
                           .state = cns_xalloc((size_t)d, sizeof *e->state),
                           .eigenvalues = cns_xalloc((size_t)d, sizeof *e->eigenvalues)};
    for (int k = 0; k < d; k++) {
        cns_eigenvalue *l = &e->eigenvalues[k];
        e->state[k] = cns_text_ball(p->x + k, decimals);
        l->re = cns_text_ball(acb_realref(p->spectrum.lambda + k), decimals);
        l->im = cns_spectrum_is_real(&p->spectrum, k)
                    ? cns_xcopy("0")
                    : cns_text_ball(acb_imagref(p->spectrum.lambda + k), decimals);
        certain = certain && e->state[k] != NULL && l->re != NULL && l->im != NULL;
        e->stable += arb_is_negative(acb_realref(p->spectrum.lambda + k)) != 0;
        e->unstable += arb_is_positive(acb_realref(p->spectrum.lambda + k)) != 0;
    }
    e->stability = stability(p, e->stable, e->unstable);
    return certain;
}

/* Two guesses may lead to one point. */
static bool seen_before(const find *f, int i)
{
    for (int j = 0; j < i; j++) {
        bool same = f->found[j];
        for (int k = 0; k < f->reduced.d && same; k++)
            same = arb_overlaps(f->point[i].x + k, f->point[j].x + k) != 0;
        if (same)
            return true;
    }
    return false;
}

static bool describe_all(const find *f, long decimals, cns_equilibria *e)
{
    bool certain = true;
    for (int i = 0; i < e->n; i++)
        clear_item(&e->item[i], e->d);
    e->n = 0;
    e->decimals = decimals;
    for (int i = 0; i < f->n && certain; i++)
        if (f->found[i] && !seen_before(f, i))
            certain = describe(&f->point[i], f->guess[i].name, decimals, &e->item[e->n++]);
    return certain;
}

static cns_code search(find *f, long decimals, cns_equilibria *e, cns_error *err)
{
    cns_code code = CNS_OK;
    bool certain = false;
    slong prec = (slong)((double)decimals * CNS_LOG2_10) + GUARD_BITS;
    for (int attempt = 0; attempt < TRIES && !code && !certain; attempt++, prec += prec / 2) {
        code = locate(f, prec, err);
        certain = !code && describe_all(f, decimals, e);
        if (certain && f->missing[0] == '\0')
            return CNS_OK;
        certain = certain && attempt > 0; /* more bits may find what is missing */
    }
    if (code)
        return code;
    while (!describe_all(f, decimals, e) && decimals > 0)
        decimals--;
    if (decimals == 0)
        return cns_fail(err, CNS_NUMERIC, "not one decimal of the fixed points is certain");
    if (f->missing[0] != '\0')
        return cns_fail(err, CNS_UNREACHED, "not found: %s", f->missing);
    return cns_fail(err, CNS_UNREACHED,
                    "only %ld decimals are certain: a number lies at a tie, or eigenvalues meet", decimals);
}

static cns_code prepare(find *f, cns_error *err)
{
    const cns_model *m = cns_system_model(f->s);
    if (m->equilibria == NULL || m->n_states > CNS_MODEL_MAX_STATES)
        return cns_fail(err, CNS_USAGE, "the model %s names no fixed points to start from", m->name);
    cns_code code = cns_reduced_open(&f->reduced, cns_system_program(f->s), err);
    if (code)
        return code;
    f->n = cns_system_guesses(f->s, f->guess);
    for (int i = 0; i < f->n; i++) {
        cns_fixed_point_init(&f->point[i], f->reduced.d);
        for (int k = 0; k < f->reduced.d; k++)
            f->start[i][k] = f->guess[i].state[f->reduced.index[k]];
    }
    return f->n > 0
               ? CNS_OK
               : cns_fail(err, CNS_USAGE, "the model %s has no fixed points with these parameters", m->name);
}

cns_code cns_equilibria_find(const cns_system *s, long decimals, const cns_monitor *monitor,
                             cns_equilibria **result, cns_error *err)
{
    find *f = cns_xalloc(1, sizeof *f);
    f->s = s;
    f->monitor = monitor;
    *result = NULL;
    cns_code code = prepare(f, err);
    if (!code) {
        cns_equilibria *e = *result = cns_xalloc(1, sizeof *e);
        e->d = f->reduced.d;
        e->index = cns_xalloc((size_t)e->d, sizeof *e->index);
        memcpy(e->index, f->reduced.index, (size_t)e->d * sizeof *e->index);
        e->item = cns_xalloc((size_t)f->n, sizeof *e->item);
        code = search(f, decimals, e, err);
        if (code && code != CNS_UNREACHED) {
            cns_equilibria_free(e);
            *result = NULL;
        }
    }
    for (int i = 0; i < f->n; i++)
        cns_fixed_point_clear(&f->point[i]);
    cns_reduced_close(&f->reduced);
    free(f);
    return code;
}

void cns_equilibria_free(cns_equilibria *e)
{
    if (e == NULL)
        return;
    for (int i = 0; i < e->n; i++)
        clear_item(&e->item[i], e->d);
    free(e->item);
    free(e->index);
    free(e);
}

char *cns_equilibria_attractors(const cns_system *s, const cns_monitor *monitor)
{
    enum { DECIMALS = 6 };
    const cns_monitor quiet = {.stop = cns_monitor_stop(monitor)};
    cns_equilibria *e = NULL;
    cns_error ignored;
    cns_text_stream text;
    int n = 0;
    cns_equilibria_find(s, DECIMALS, &quiet, &e, &ignored);
    cns_text_open(&text);
    for (int i = 0; e != NULL && i < e->n; i++)
        if (e->item[i].stable == e->d)
            fprintf(text.file, "%s%s", n++ > 0 ? ", " : "", e->item[i].name);
    cns_equilibria_free(e);
    char *names = cns_text_close(&text, &ignored);
    if (n > 0)
        return names;
    free(names);
    return NULL;
}
