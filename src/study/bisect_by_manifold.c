/* A critical parameter by shooting along an unstable manifold: the zero of the signed miss (see manifold.h).
 *
 * The bracket is narrowed by secants through the two probes nearest to the zero, by bisection where these do
 * not narrow it. Errors multiply: a zero found to a and b decimals from probes gives the next one a + b, less
 * a constant, so that some ten probes give a hundred decimals, the first of them in few digits. In the end
 * both ends of a bracket no wider than the last decimal are probed twice each, with different digits, orders,
 * starts and steps: only if all four agree in side and in size is it the answer. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bisect_internal.h"
#include "cns/flow.h"
#include "core/memory.h"
#include "core/monitor.h"
#include "core/sha256.h"
#include "ensemble.h"
#include "num/decimal_text.h"
#include "num/logs.h"
#include "study/saddle/manifold.h"

enum {
    GUARD_DIGITS = 20, /* of a probe, beyond the decimals of the next estimate */
    LEAST_DIGITS = 30,
    MISS_DIGITS = 10,   /* of the text of a miss, beyond the probe's digits */
    SPARE_DECIMALS = 4, /* of an estimate, beyond those it is thought to have */
    FIRST_SPARE = 2, /* decimals of the last bracket beyond those asked for; more where it straddles a tie */
    MORE_SPARE = 4,
    MAX_PROBES = 200,
    MAX_PROOFS = 8,
    SMOOTH_DECIMALS = 10, /* beyond those asked for, by which smoothing may not show */
    END_TURNS = 2,        /* the first tells what a start loses */
    RECENT = 3
};

/* A parameter that was probed, and what the probe said (see cns_passage). */
typedef struct point {
    char *text;
    mpfr_t value; /* of the text */
    mpfr_t miss;
    int side; /* 0: the digits of the probe did not tell */
    double loss;
} point;

typedef struct search {
    const cns_bisection *b;
    const cns_system *s; /* the bisection's, without a smoothing that does not show */
    const cns_bisect_spec *spec;
    cns_bisect_result *r;
    cns_monitor own; /* progress of the whole search, not of a batch of probes */
    mpfr_prec_t prec;
    long spare;   /* decimals of the last bracket beyond those asked for */
    double known; /* decimals so far, for progress */
    point lower, upper;
    point recent[RECENT]; /* the last probes, the latest first */
    int n_recent;
    /* log10 of K: a secant through two points whose distances from the zero are e1 and e2 leads to within
     * K e1 e2 of it. */
    double gain_log10;
    double loss;    /* digits by which a probe needs more than its miss shall have (see cns_passage) */
    char word[128]; /* what is going on, for progress */
} search;

/* Probes, as jobs of an ensemble. */

typedef struct job {
    const char *text; /* of the parameter */
    long digits;
    int variant;
} job;

typedef struct batch {
    const search *f;
    job jobs[4];
    int n;
} batch;

static void name_of(void *context, int i, char *name, size_t size)
{
    const batch *b = context;
    char sum[65];
    cns_sha256_hex(sum, b->jobs[i].text, strlen(b->jobs[i].text));
    snprintf(name, size, "probe-%.24s-%ld-%d", sum, b->jobs[i].digits, b->jobs[i].variant);
}

static double cost_of(void *context, int i)
{
    const batch *b = context;
    return (double)b->jobs[i].digits;
}

static void tell(void *context, double fraction, const char *what)
{
    (void)what;
    cns_ensemble_tell(context, fraction);
}

static cns_code pass(const search *f, const job *j, cns_ensemble_job *handle, cns_passage *passage,
                     cns_error *err)
{
    const cns_passage_spec spec = {.digits = j->digits, .variant = j->variant};
    const cns_monitor monitor = {
        .stop = cns_monitor_stop(f->b->monitor), .progress = tell, .context = handle};
    cns_number value;
    cns_number_init(&value);
    cns_code code = cns_number_parse(&value, j->text, err);
    cns_system *s = code ? NULL : cns_system_with(f->s, f->spec->parameter, &value, err);
    code = s != NULL ? cns_manifold_passage(s, &spec, &monitor, passage, err) : err->code;
    cns_system_free(s);
    cns_number_clear(&value);
    return code;
}

static cns_code run(void *context, int i, cns_ensemble_job *handle, char **result, cns_error *err)
{
    const batch *b = context;
    const search *f = b->f;
    const job *j = &b->jobs[i];
    cns_passage passage;
    cns_error inner;
    cns_passage_init(&passage, cns_digits_to_bits(j->digits + MISS_DIGITS));
    cns_code code = pass(f, j, handle, &passage, &inner);
    if (!code) {
        const size_t size = strlen(j->text) + (size_t)j->digits + 256;
        *result = cns_xalloc(size, 1);
        mpfr_snprintf(
            *result, size,
            "parameter: %s\nside: %d\nmiss: %.*Re\nloss: %.3g\ntime: %.12g\nlambda: %.17g\nsteps: %ld\n",
            j->text, passage.side, (int)j->digits + MISS_DIGITS, passage.miss, passage.loss, passage.time,
            passage.lambda, passage.steps);
    } else if (code == CNS_UNREACHED) { /* a result, too: more digits are needed */
        *result = cns_xalloc(128, 1);
        snprintf(*result, 128, "side: 0\nmiss: 0\nloss: %.3g\n", passage.loss);
        code = CNS_OK;
    } else {
        cns_fail(err, code, "%s = %.40s: %s", cns_system_model(f->s)->parameters[f->spec->parameter].name,
                 j->text, inner.text);
    }
    cns_passage_clear(&passage);
    return code;
}

static bool read_result(const char *text, point *p)
{
    const char *side = strstr(text, "side: "), *miss = strstr(text, "miss: "), *loss = strstr(text, "loss: ");
    if (side == NULL || miss == NULL || loss == NULL)
        return false;
    p->loss = strtod(loss + 6, NULL);
    p->side = (int)strtol(side + 6, NULL, 10);
    mpfr_strtofr(p->miss, miss + 6, NULL, 10, MPFR_RNDN);
    return mpfr_number_p(p->miss) && mpfr_sgn(p->miss) == p->side; /* 0: not told */
}

/* Runs the jobs of b; points[i] gets what job i says. */
static cns_code probe(search *f, batch *b, point **points, cns_error *err)
{
    char *results[4] = {NULL};
    const cns_ensemble e = {.n = b->n,
                            .monitor = &f->own,
                            .directory = f->b->directory,
                            .identity = f->b->identity,
                            .context = b,
                            .name = name_of,
                            .cost = cost_of,
                            .run = run};
    b->f = f;
    cns_code code = cns_ensemble_run(&e, results, err);
    for (int i = 0; i < b->n; i++) {
        if (!code && !read_result(results[i], points[i]))
            code = cns_fail(err, CNS_IO, "the result of a probe cannot be read");
        if (!code)
            f->loss = fmax(f->loss, points[i]->loss);
        free(results[i]);
    }
    f->r->probes += b->n;
    return code;
}

static void on_progress(void *context, double fraction, const char *what)
{
    search *f = context;
    (void)what;
    (void)fraction;
    const double whole = (double)(f->spec->decimals + f->spare);
    cns_monitor_tell(f->b->monitor, fmin(fmax(f->known, 0) / whole, 1), f->word);
}

/* Points. */

static void point_init(point *p, mpfr_prec_t prec)
{
    *p = (point){0};
    mpfr_inits2(prec, p->value, p->miss, (mpfr_ptr)0);
}

static void point_clear(point *p)
{
    free(p->text);
    mpfr_clears(p->value, p->miss, (mpfr_ptr)0);
}

static void point_set(point *p, const char *text)
{
    cns_number number;
    cns_error ignored;
    cns_number_init(&number);
    cns_number_parse(&number, text, &ignored);
    cns_number_get_mpfr(p->value, &number);
    cns_number_clear(&number);
    free(p->text);
    p->text = cns_xcopy(text);
}

static void point_copy(point *to, const point *from)
{
    free(to->text);
    to->text = cns_xcopy(from->text);
    to->side = from->side;
    mpfr_set(to->value, from->value, MPFR_RNDN);
    mpfr_set(to->miss, from->miss, MPFR_RNDN);
}

/* A probe's result narrows the bracket and becomes the latest point of the next secant. */
static void learn(search *f, const point *p)
{
    if (mpfr_cmp(p->value, f->lower.value) > 0 && mpfr_cmp(p->value, f->upper.value) < 0)
        point_copy(p->side == f->lower.side ? &f->lower : &f->upper, p);
    for (int i = RECENT - 1; i > 0; i--)
        if (i <= f->n_recent && f->recent[i - 1].text != NULL)
            point_copy(&f->recent[i], &f->recent[i - 1]);
    point_copy(&f->recent[0], p);
    if (f->n_recent < RECENT)
        f->n_recent++;
}

/* Estimates. */

/* -log10 |a - b|: the decimals to which they agree. */
static double agreement(const search *f, const mpfr_t a, const mpfr_t b)
{
    mpfr_t difference;
    mpfr_init2(difference, f->prec);
    mpfr_sub(difference, a, b, MPFR_RNDN);
    const double decimals =
        mpfr_zero_p(difference) ? (double)f->prec * CNS_LOG10_2 : -cns_log2_mpfr(difference) * CNS_LOG10_2;
    mpfr_clear(difference);
    return decimals;
}

/* The zero of the line through two points. */
static void secant(mpfr_t zero, const point *a, const point *b)
{
    mpfr_t slope;
    mpfr_init2(slope, mpfr_get_prec(zero));
    mpfr_sub(zero, a->value, b->value, MPFR_RNDN);
    mpfr_sub(slope, a->miss, b->miss, MPFR_RNDN);
    mpfr_div(zero, zero, slope, MPFR_RNDN);
    mpfr_mul(zero, zero, a->miss, MPFR_RNDN);
    mpfr_sub(zero, a->value, zero, MPFR_RNDN);
    mpfr_clear(slope);
}

static bool inside(const search *f, const mpfr_t x)
{
    return mpfr_number_p(x) && mpfr_cmp(x, f->lower.value) > 0 && mpfr_cmp(x, f->upper.value) < 0;
}

/* The next estimate of the zero; returns how many decimals it is thought to have. */
static double estimate(search *f, mpfr_t x)
{
    const point *a = &f->recent[0], *b = &f->recent[1];
    secant(x, a, b);
    const double to_a = agreement(f, x, a->value), to_b = agreement(f, x, b->value);
    /* Secants that do not get shorter are not converging. */
    if (inside(f, x) && (f->n_recent < RECENT || to_a > agreement(f, a->value, b->value))) {
        if (f->n_recent == RECENT) /* a's own error shows now */
            f->gain_log10 =
                1 - to_a + agreement(f, a->value, b->value) + agreement(f, a->value, f->recent[2].value);
        /* Decimals grow by no larger a factor than they did before: less than secants give a smooth function
         * where the passage itself adds powers of the miss that are not whole. */
        return fmin(to_a + to_b - f->gain_log10, to_a * to_a / fmax(to_b, 1) - 1);
    }
    mpfr_add(x, f->lower.value, f->upper.value, MPFR_RNDN);
    mpfr_div_2ui(x, x, 1, MPFR_RNDN);
    f->n_recent = 2; /* what came of secants so far tells nothing of those to come */
    return agreement(f, f->lower.value, f->upper.value);
}

/* Probes an estimate of so many decimals, with more digits where these do not tell the side. *hit: not even
 * those do that the last bracket will have, so that x is right to all decimals asked for, and more. */
static cns_code narrow(search *f, const mpfr_t x, double decimals, bool *hit, cns_error *err)
{
    const long places = (long)fmax(decimals, 0) + SPARE_DECIMALS, guard = GUARD_DIGITS + (long)f->loss,
               most = f->spec->decimals + f->spare + guard;
    const double next = fmin(decimals + agreement(f, x, f->recent[0].value), (double)(most - guard));
    long digits = (long)fmax(next, decimals) + guard;
    char *text = cns_text_mpfr(x, CNS_PLACES_DECIMALS, places);
    point p, *out[1] = {&p};
    cns_code code = CNS_OK;
    point_init(&p, f->prec);
    point_set(&p, text);
    *hit = false;
    for (bool told = false; !code && !told && !*hit; digits += digits / 2) {
        digits = digits < LEAST_DIGITS ? LEAST_DIGITS : digits > most ? most : digits;
        batch b = {.n = 1, .jobs = {{.text = text, .digits = digits}}};
        code = probe(f, &b, out, err);
        told = p.side != 0;
        *hit = !code && !told && digits == most;
    }
    if (!code && !*hit)
        learn(f, &p);
    point_clear(&p);
    free(text);
    return code;
}

/* Proofs. */

/* Do two numerics agree? Within a hundredth of the miss: then neither its sign nor its size is noise. */
static bool agree(const search *f, const point *a, const point *b)
{
    mpfr_t difference;
    mpfr_init2(difference, f->prec);
    mpfr_sub(difference, a->miss, b->miss, MPFR_RNDN);
    mpfr_mul_ui(difference, difference, 100, MPFR_RNDN);
    const bool same = a->side != 0 && a->side == b->side && mpfr_cmpabs(difference, a->miss) <= 0;
    mpfr_clear(difference);
    return same;
}

static void set_mode(const search *f, char mode[CNS_MODE_NAME], int side)
{
    const cns_model_connection *c = cns_system_model(f->s)->connection;
    snprintf(mode, CNS_MODE_NAME, "%s", side < 0 ? c->back : c->beyond);
}

/* The bracket goes into the result. */
static void report(search *f, const point *lower, const point *upper)
{
    cns_bisect_result *r = f->r;
    free(r->lower);
    free(r->upper);
    r->lower = cns_xcopy(lower->text);
    r->upper = cns_xcopy(upper->text);
    set_mode(f, r->lower_mode, lower->side);
    set_mode(f, r->upper_mode, upper->side);
}

/* Probes both ends of a bracket of the last decimals about x, twice each. *done: they prove it. */
static cns_code prove(search *f, const mpfr_t x, bool *done, cns_error *err)
{
    const long places = f->spec->decimals + f->spare, digits = places + GUARD_DIGITS + (long)f->loss;
    mpfr_t unit, end;
    point p[4], *out[4];
    batch b = {.n = 4};
    char *texts[2], *rounded[2];
    *done = false;
    mpfr_inits2(f->prec, unit, end, (mpfr_ptr)0);
    mpfr_set_ui(unit, 10, MPFR_RNDN);
    mpfr_pow_si(unit, unit, -places, MPFR_RNDN);
    for (int i = 0; i < 2; i++) {
        (i == 0 ? mpfr_sub : mpfr_add)(end, x, unit, MPFR_RNDN);
        texts[i] = cns_text_mpfr(end, CNS_PLACES_DECIMALS, places);
    }
    for (int i = 0; i < 4; i++) {
        out[i] = &p[i];
        point_init(&p[i], f->prec);
        point_set(&p[i], texts[i / 2]);
        b.jobs[i] = (job){.text = texts[i / 2], .digits = digits, .variant = i % 2};
    }
    for (int i = 0; i < 2; i++) { /* of the ends as they are printed */
        cns_number number;
        cns_number_init(&number);
        cns_number_parse(&number, texts[i], err);
        rounded[i] = cns_text_number(&number, CNS_PLACES_DECIMALS, f->spec->decimals);
        cns_number_clear(&number);
    }
    const bool straddles = strcmp(rounded[0], rounded[1]) != 0;
    cns_code code = CNS_OK;
    if (straddles)
        f->spare += MORE_SPARE;
    else
        code = probe(f, &b, out, err);
    if (!code && !straddles && !(agree(f, &p[0], &p[1]) && agree(f, &p[2], &p[3])))
        code = cns_fail(
            err, CNS_NUMERIC,
            "two probes of the same parameter with different numerics do not agree within a hundredth "
            "of their distance from the connection");
    if (!code && !straddles && p[0].side == p[2].side) {
        learn(
            f,
            &p[mpfr_cmpabs(p[0].miss, p[2].miss) < 0 ? 0 : 2]); /* the zero is farther off than was thought */
    } else if (!code && !straddles) {
        if (-cns_log2_mpfr(p[0].miss) * CNS_LOG10_2 < (double)places / 2)
            code = cns_fail(
                err, CNS_NUMERIC,
                "the side changes by a jump near %s, not because the manifolds connect: give a narrower "
                "bracket",
                texts[0]);
        if (!code) {
            report(f, &p[0], &p[2]);
            f->r->critical = cns_xcopy(rounded[0]);
            f->r->decimals = f->spec->decimals;
            *done = true;
        }
    }
    for (int i = 0; i < 4; i++)
        point_clear(&p[i]);
    for (int i = 0; i < 2; i++) {
        free(texts[i]);
        free(rounded[i]);
    }
    mpfr_clears(unit, end, (mpfr_ptr)0);
    return code;
}

static cns_code ends(search *f, cns_error *err)
{
    point *out[2] = {&f->lower, &f->upper};
    point_set(&f->lower, f->spec->lower.text);
    point_set(&f->upper, f->spec->upper.text);
    snprintf(f->word, sizeof f->word, "the ends of the bracket");
    for (int turn = 0; turn < END_TURNS && (f->lower.side == 0 || f->upper.side == 0); turn++) {
        const long digits = LEAST_DIGITS + (long)f->loss;
        batch b = {.n = 2, .jobs = {{f->lower.text, digits, 0}, {f->upper.text, digits, 0}}};
        cns_code code = probe(f, &b, out, err);
        if (code)
            return code;
    }
    if (f->lower.side == 0 || f->upper.side == 0)
        return cns_fail(err, CNS_UNREACHED,
                        "an end of the bracket lies on the connection within %d digits: widen it",
                        LEAST_DIGITS);
    report(f, &f->lower, &f->upper);
    if (f->lower.side == f->upper.side)
        return cns_fail(err, CNS_UNREACHED,
                        "%s is %s at both ends of the bracket, %s and %s: nothing to bisect",
                        cns_system_model(f->s)->parameters[f->spec->parameter].name, f->r->lower_mode,
                        f->lower.text, f->upper.text);
    f->gain_log10 = agreement(f, f->lower.value, f->upper.value);
    learn(f, &f->lower);
    learn(f, &f->upper);
    return CNS_OK;
}

static cns_code iterate(search *f, cns_error *err)
{
    mpfr_t x;
    cns_code code = ends(f, err);
    int proofs = 0;
    bool done = false, hit = false;
    mpfr_init2(x, f->prec);
    while (!code && !done) {
        const double decimals = f->known = hit ? (double)(f->spec->decimals + f->spare + 2) : estimate(f, x);
        if (f->r->probes >= MAX_PROBES || proofs >= MAX_PROOFS) {
            code = cns_fail(err, CNS_UNREACHED, "%ld probes have not led to a connection", f->r->probes);
        } else if (decimals > (double)(f->spec->decimals + f->spare + 1)) {
            snprintf(f->word, sizeof f->word, "proving both ends of the last bracket, with two numerics");
            proofs++;
            hit = false;
            code = prove(f, x, &done, err);
        } else {
            snprintf(f->word, sizeof f->word, "probe %ld, an estimate of some %.0f decimals",
                     f->r->probes + 1, fmax(decimals, 0));
            code = narrow(f, x, decimals, &hit, err);
        }
        if (!done)
            report(f, &f->lower, &f->upper);
    }
    mpfr_clear(x);
    return code;
}

/* Smoothing moves a connection by some eps^2, by eps^1.5 at most: does that show in the decimals asked for?
 * If not, true absolute values give the same decimals in a fraction of the time. */
static bool smoothing_shows(const cns_number *smooth, const cns_bisect_spec *spec)
{
    mpfr_t eps;
    mpfr_init2(eps, 53);
    cns_number_get_mpfr(eps, smooth);
    const bool shows = 1.5 * cns_log2_mpfr(eps) * CNS_LOG10_2 > -(double)(spec->decimals + SMOOTH_DECIMALS);
    mpfr_clear(eps);
    return shows;
}

cns_code cns_bisect_by_manifold(const cns_bisection *b, cns_error *err)
{
    const cns_model *m = cns_system_model(b->system);
    const cns_number *smooth = cns_system_smooth(b->system);
    cns_system *exact = NULL;
    if (m->connection == NULL || m->equilibria == NULL)
        return cns_fail(err, CNS_USAGE, "the model %s names no saddle whose unstable manifold to follow",
                        m->name);
    if (smooth != NULL && !smoothing_shows(smooth, b->spec) &&
        !(exact = cns_system_smoothed(b->system, NULL, err)))
        return err->code;
    search f = {.b = b,
                .s = exact != NULL ? exact : b->system,
                .spec = b->spec,
                .r = b->r,
                .own = {.threads = cns_monitor_threads(b->monitor),
                        .stop = cns_monitor_stop(b->monitor),
                        .progress = on_progress,
                        .context = &f},
                .prec = cns_digits_to_bits(b->spec->decimals + 2 * GUARD_DIGITS + MAX_PROOFS * MORE_SPARE),
                .spare = FIRST_SPARE};
    point_init(&f.lower, f.prec);
    point_init(&f.upper, f.prec);
    for (int i = 0; i < RECENT; i++)
        point_init(&f.recent[i], f.prec);
    cns_code code = iterate(&f, err);
    for (int i = 0; i < RECENT; i++)
        point_clear(&f.recent[i]);
    point_clear(&f.lower);
    point_clear(&f.upper);
    cns_system_free(exact);
    return code;
}
