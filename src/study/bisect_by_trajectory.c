/* Bisection by trajectory: the mode that the case's own trajectory falls into, on ever smaller brackets.
 *
 * A run of a fixed length finds no more than the threshold of its last passage by the saddle (Xu, Li, Li,
 * Liao, section 3.2, halve their interval like that), and thresholds of later passages are others. Here a
 * probe goes on until passages repeat each other, so that it tells the late motion, and takes the digits that
 * its own noise asks for: near the critical value the passage magnifies it by the inverse of the distance to
 * that. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bisect_internal.h"
#include "cns/study/classify.h"
#include "core/memory.h"
#include "core/monitor.h"
#include "ensemble.h"
#include "num/decimal_text.h"
#include "num/logs.h"
#include "solve/proof.h"
#include "study/modes/returns.h"

enum {
    FIRST_DIGITS = 20,
    EXTRA = 10, /* decimals looked at where both ends round differently */
    MAX_DIGITS = 1000
};

typedef struct search {
    const cns_bisection *b;
    const cns_bisect_spec *spec;
    cns_bisect_result *r;
    cns_number lower, upper;
    int probes_expected;
} search;

/* One probe, as a job, so that it can be kept. */
typedef struct probe {
    const search *f;
    const cns_number *value; /* of the parameter */
    long digits;             /* at least */
} probe;

static cns_mode mode_of(const cns_return_map *S, const cns_late *late)
{
    switch (late->kind) {
    case CNS_LATE_STEADY:
        return cns_late_attracts(S, late) ? CNS_MODE_STEADY : CNS_MODE_UNDECIDED;
    case CNS_LATE_CHAOS:
        return CNS_MODE_CHAOTIC;
    case CNS_LATE_CYCLE:
        if (cns_system_model(S->system)->motion == NULL)
            return CNS_MODE_PERIODIC;
        return late->cycle_mirrored || late->cycle_turns == 0 ? CNS_MODE_FLUTTER : CNS_MODE_TUMBLE;
    case CNS_LATE_OPEN:
        break;
    }
    return CNS_MODE_UNDECIDED;
}

static void name(void *context, int i, char *text, size_t size)
{
    const probe *p = context;
    (void)i;
    snprintf(text, size, "trajectory-%ld-%s", p->digits, cns_ensemble_word_for(p->value->text).text);
}

static double cost(void *context, int i)
{
    (void)context;
    (void)i;
    return 1;
}

/* The mode and the digits that it took, as text. */
static cns_code run(void *context, int i, cns_ensemble_job *job, char **result, cns_error *err)
{
    const probe *p = context;
    const search *f = p->f;
    cns_return_map S;
    cns_mode mode = CNS_MODE_UNDECIDED;
    long digits = p->digits;
    bool looked = false;
    (void)i;
    (void)job;
    cns_system *s = cns_system_with(f->b->system, f->spec->parameter, p->value, err);
    if (s == NULL)
        return err->code;
    cns_code code = cns_return_map_open(&S, s, -1, 0, cns_monitor_stop(f->b->monitor), err);
    while (!code && digits <= MAX_DIGITS) {
        cns_late late;
        code = cns_late_find(&S, digits, 0, &late, err);
        if (!code && late.looks_chaotic && !late.trusted && !looked) { /* for ever? No digits last so long */
            const double noise_log2 = late.noise_log2;
            cns_late_clear(&late);
            code = cns_late_find(&S, 0, 0, &late, err);
            late.noise_log2 = noise_log2;
            late.trusted = false;
            looked = true;
        }
        const bool decided = late.trusted || late.kind == CNS_LATE_CHAOS;
        const double grown = (late.noise_log2 + (double)cns_modes_bits(digits)) * CNS_LOG10_2;
        if (!code && decided)
            mode = mode_of(&S, &late);
        cns_late_clear(&late);
        if (decided)
            break;
        const long needed = (long)fmin(grown, MAX_DIGITS) + 14;
        digits = needed > digits + CNS_ANOTHER_LIMB ? needed : digits + CNS_ANOTHER_LIMB;
    }
    cns_return_map_close(&S);
    cns_system_free(s);
    if (code)
        return code;
    *result = cns_xalloc(64, 1);
    snprintf(*result, 64, "%s %ld\n", cns_mode_name(mode), digits);
    return CNS_OK;
}

static cns_code decide(search *f, const cns_number *value, long digits, char *mode, long *used,
                       cns_error *err)
{
    char *result = NULL;
    const cns_monitor quiet = {.stop = cns_monitor_stop(f->b->monitor)}; /* the search tells its progress */
    probe p = {.f = f, .value = value, .digits = digits};
    const cns_ensemble e = {.n = 1,
                            .monitor = &quiet,
                            .directory = f->b->directory,
                            .identity = f->b->identity,
                            .context = &p,
                            .name = name,
                            .cost = cost,
                            .run = run};
    cns_code code = cns_ensemble_run(&e, &result, err);
    if (!code && (result == NULL || sscanf(result, "%31s %ld", mode, used) != 2))
        code = cns_fail(err, CNS_IO, "a kept probe cannot be read");
    free(result);
    f->r->probes += !code;
    return code;
}

/* x = the middle of the bracket, rounded to a decimal that is well inside it. */
static void middle(const search *f, cns_number *x, long *places)
{
    cns_error err;
    mpq_t q, width;
    mpfr_t w;
    mpq_inits(q, width, (mpq_ptr)0);
    mpq_sub(width, f->upper.ratio, f->lower.ratio);
    mpfr_init2(w, 64);
    mpfr_set_q(w, width, MPFR_RNDD);
    *places = (long)ceil(-cns_log2_mpfr(w) * CNS_LOG10_2) + 2;
    if (*places < 0)
        *places = 0;
    mpq_add(q, f->upper.ratio, f->lower.ratio);
    mpq_div_2exp(q, q, 1);
    char *text = cns_text_mpq(q, CNS_PLACES_DECIMALS, *places);
    cns_number_parse(x, text, &err);
    free(text);
    mpfr_clear(w);
    mpq_clears(q, width, (mpq_ptr)0);
}

/* The most decimals, at most `most`, to which both ends round alike; -1: none. */
static long common(const search *f, long most, char **text)
{
    for (long count = most; count >= 0; count--) {
        char *a = cns_text_mpq(f->lower.ratio, CNS_PLACES_DECIMALS, count),
             *b = cns_text_mpq(f->upper.ratio, CNS_PLACES_DECIMALS, count);
        const bool equal = strcmp(a, b) == 0;
        free(b);
        if (equal) {
            *text = a;
            return count;
        }
        free(a);
    }
    return -1;
}

/* The bracket so far, as the result. */
static void report(search *f)
{
    cns_bisect_result *r = f->r;
    free(r->lower);
    free(r->upper);
    free(r->critical);
    r->critical = NULL;
    r->lower = cns_xcopy(f->lower.text);
    r->upper = cns_xcopy(f->upper.text);
    r->decimals = common(f, f->spec->decimals, &r->critical);
}

static bool usable(const char *mode)
{
    return strcmp(mode, cns_mode_name(CNS_MODE_UNDECIDED)) != 0;
}

/* Both ends once more with other precisions: their modes stand only if nothing depends on rounding. */
static cns_code confirm(search *f, long digits, cns_error *err)
{
    const cns_number *const ends[] = {&f->lower, &f->upper};
    const char *const modes[] = {f->r->lower_mode, f->r->upper_mode};
    for (int i = 0; i < 2; i++) {
        char mode[CNS_MODE_NAME];
        long used;
        cns_code code = decide(f, ends[i], digits, mode, &used, err);
        if (code)
            return code;
        if (strcmp(mode, modes[i]) != 0)
            return cns_fail(err, CNS_NUMERIC, "with %ld digits the motion at %s is %s, with fewer it was %s",
                            used, ends[i]->text, mode, modes[i]);
    }
    return CNS_OK;
}

static cns_code narrow(search *f, cns_error *err)
{
    cns_bisect_result *r = f->r;
    cns_number x;
    long digits = FIRST_DIGITS, used = 0, most = 0, places = 0;
    char mode[CNS_MODE_NAME];
    cns_code code = decide(f, &f->lower, digits, r->lower_mode, &most, err);
    if (!code)
        code = decide(f, &f->upper, digits, r->upper_mode, &used, err);
    if (code)
        return code;
    r->lower = cns_xcopy(f->lower.text);
    r->upper = cns_xcopy(f->upper.text);
    if (!usable(r->lower_mode) || !usable(r->upper_mode) || strcmp(r->lower_mode, r->upper_mode) == 0)
        return cns_fail(err, CNS_UNREACHED, "no change of mode to be found: %s at %s and %s at %s",
                        r->lower_mode, r->lower, r->upper_mode, r->upper);
    most = used > most ? used : most;
    cns_number_init(&x);
    report(f);
    while (!code && r->decimals < f->spec->decimals && places < f->spec->decimals + EXTRA) {
        char what[128];
        middle(f, &x, &places);
        snprintf(what, sizeof what, "probe %ld at %.40s", r->probes + 1, x.text);
        cns_monitor_tell(f->b->monitor, fmin(1, (double)r->probes / f->probes_expected), what);
        /* The distance to the critical value may be as small as the bracket, and a digit's worth more. */
        digits = FIRST_DIGITS + places;
        code = decide(f, &x, digits, mode, &used, err);
        if (code)
            break;
        most = used > most ? used : most;
        if (strcmp(mode, r->lower_mode) == 0)
            cns_number_set(&f->lower, &x);
        else if (strcmp(mode, r->upper_mode) == 0)
            cns_number_set(&f->upper, &x);
        else
            code = cns_fail(err, CNS_UNREACHED, "at %s the motion is %s: neither %s nor %s", x.text, mode,
                            r->lower_mode, r->upper_mode);
        report(f);
    }
    cns_number_clear(&x);
    if (!code)
        code = confirm(f, most + CNS_ANOTHER_LIMB, err);
    if (!code && r->decimals < f->spec->decimals)
        code = cns_fail(err, CNS_UNREACHED, "%ld of %ld decimals", r->decimals, f->spec->decimals);
    return code;
}

cns_code cns_bisect_by_trajectory(const cns_bisection *b, cns_error *err)
{
    const cns_bisect_spec *spec = b->spec;
    search f = {
        .b = b, .spec = spec, .r = b->r, .probes_expected = (int)((double)spec->decimals * CNS_LOG2_10) + 4};
    if (spec->lower.pi_power != 0 || spec->upper.pi_power != 0)
        return cns_fail(err, CNS_USAGE, "the ends of a bracket are decimals or fractions, without pi");
    cns_number_init(&f.lower);
    cns_number_init(&f.upper);
    cns_number_set(&f.lower, &spec->lower);
    cns_number_set(&f.upper, &spec->upper);
    const cns_code code = narrow(&f, err);
    cns_number_clear(&f.lower);
    cns_number_clear(&f.upper);
    return code;
}
