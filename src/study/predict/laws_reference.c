#include <stdio.h> /* before mpfr.h, for mpfr_fprintf() */

#include "laws_internal.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/files.h"
#include "core/memory.h"
#include "core/monitor.h"
#include "envelope.h"
#include "integrate/rows.h"
#include "integrate/trajectory.h"
#include "num/logs.h"
#include "num/vector.h"
#include "solve/problem.h"
#include "study/ensemble.h"

enum {
    SPARE = 24,     /* digits of the reference beyond the growth at which it ends */
    MOST_GROWTH = 2 /* digits between two rows */
};

void cns_laws_row_time(const cns_laws_work *l, int row, mpq_t t)
{
    cns_row_time(cns_every(l->problem), l->problem->end, (unsigned long)row, t);
}

int cns_laws_last_row(const cns_laws_work *l)
{
    const long last = cns_last_multiple(cns_every(l->problem), l->problem->end);
    return last < INT_MAX ? (int)last : INT_MAX - 1;
}

cns_flow_spec cns_laws_taylor(const cns_laws_work *l, const cns_system *s, long digits, double safety)
{
    cns_flow_spec spec =
        cns_flow_spec_taylor(cns_system_program(s), cns_system_scales(s), CNS_ARITH_FAST, digits);
    spec.safety = safety;
    spec.stop = cns_monitor_stop(l->problem->monitor);
    return spec;
}

void cns_falling_init(cns_falling *f, long digits)
{
    *f = (cns_falling){.begun = digits, .digits = digits};
    f->schedule = (cns_schedule){.end = 1, .n = 1, .digits = &f->digits};
}

void cns_falling_follow(cns_falling *f, double growth)
{
    const long left = f->begun - (long)floor(growth);
    if (left < f->digits)
        f->digits = left;
}

void cns_laws_reference_clear(cns_law_reference *r)
{
    cns_vector_free(r->state);
    free(r->growth);
    free(r->error);
    *r = (cns_law_reference){0};
}

double cns_laws_growth_at(const cns_laws_work *l, double t)
{
    const double at = t / l->every;
    const int row = (int)fmin(floor(at), l->ref.rows - 2);
    return l->ref.growth[row] + (at - row) * (l->ref.growth[row + 1] - l->ref.growth[row]);
}

/* Has the observable an envelope that is followed? */
static bool has_envelope(const cns_laws_work *l)
{
    return l->spec->criterion == CNS_TC_ENVELOPE && l->spec->observable != CNS_OBSERVABLE_NORM;
}

/* The reference, as the one job of an ensemble: a line for each row, with growth, error, states, and the
 * envelope of the observable. */

static void reference_name(void *context, int i, char *name, size_t size)
{
    const cns_laws_work *l = context;
    (void)i;
    snprintf(name, size, "reference-%ld-growth-%.0f", l->ref.digits, l->level);
}

static double one(void *context, int i)
{
    (void)context;
    (void)i;
    return 1;
}

static cns_code reference_run(void *context, int number, cns_ensemble_job *told, char **result,
                              cns_error *err)
{
    cns_laws_work *l = context;
    (void)number;
    cns_text_stream lines;
    cns_falling precision;
    cns_falling_init(&precision, l->ref.digits);
    cns_trajectory_spec spec = {.flow = cns_laws_taylor(l, l->system, l->ref.digits, 0),
                                .initial = cns_system_initial(l->system)};
    spec.flow.verify = true;
    spec.flow.schedule = &precision.schedule;
    cns_trajectory *t = cns_trajectory_new(&spec, err);
    cns_sample s = {0};
    cns_envelope envelope = {0};
    mpfr_t high;
    mpfr_init2(high, CNS_ENVELOPE_BITS);
    mpfr_set_zero(high, 1);
    cns_code code = !t ? err->code
                    : cns_sample_init(&s, cns_system_program(l->system), CNS_LAWS_KEPT_BITS)
                        ? CNS_OK
                        : cns_out_of_memory(err);
    if (!code && has_envelope(l))
        code = cns_envelope_init(&envelope, 1 + l->n, &spec.flow, err);
    mpq_t time;
    mpq_init(time);
    cns_text_open(&lines);
    FILE *out = lines.file;
    const int last = cns_laws_last_row(l);
    for (int row = 0; !code && row <= last; row++) {
        cns_laws_row_time(l, row, time);
        while (!code && mpfr_cmp_q(cns_flow_end(cns_trajectory_flow(t)), time) < 0) {
            code = cns_trajectory_step(t, err);
            if (!code && has_envelope(l))
                cns_envelope_follow(&envelope, t);
        }
        if (!code)
            code = cns_trajectory_at(t, time, &s, err);
        if (code)
            break;
        if (has_envelope(l))
            cns_envelope_at(&envelope, CNS_TC_STATE(l->spec->observable), mpq_get_d(time),
                            s.state[l->spec->observable], high);
        cns_falling_follow(&precision, s.growth);
        fprintf(out, "%.10g %.10g", s.growth, fmax(s.error_log2 * CNS_LOG10_2, -1e9));
        for (int i = 0; i < l->n; i++)
            mpfr_fprintf(out, " %.*Re", CNS_LAWS_KEPT_DIGITS - 1, s.state[i]);
        mpfr_fprintf(out, " %.20Re", high);
        fputc('\n', out);
        cns_ensemble_tell(told, fmax(0, fmin(1, fmax(s.growth / l->level, (double)row / last))));
        if (s.growth >= l->level)
            break;
    }
    mpq_clear(time);
    mpfr_clear(high);
    cns_envelope_clear(&envelope);
    cns_trajectory_free(t);
    cns_sample_clear(&s);
    char *text = cns_text_close(&lines, code ? NULL : err);
    if (!code && text)
        *result = text;
    else
        free(text);
    return code || text ? code : err->code;
}

static cns_code reference_read(cns_laws_work *l, const char *text, cns_error *err)
{
    cns_law_reference *r = &l->ref;
    int rows = 0;
    for (const char *at = text; (at = strchr(at, '\n')) != NULL; at++)
        rows++;
    r->growth = cns_xalloc((size_t)rows, sizeof *r->growth);
    r->error = cns_xalloc((size_t)rows, sizeof *r->error);
    const int columns = l->n + 1;
    r->state = cns_vector_new(rows * columns, CNS_LAWS_KEPT_BITS);
    if (!r->state)
        return cns_out_of_memory(err);
    r->rows = rows;
    char *at = (char *)(size_t)text; /* only read: strtod's and MPFR's ends are not const */
    for (int row = 0; row < rows; row++) {
        r->growth[row] = strtod(at, &at);
        r->error[row] = strtod(at, &at);
        for (int i = 0; i < columns; i++) {
            char *begin = at;
            mpfr_strtofr(r->state[row * columns + i], begin, &at, 10, MPFR_RNDN);
            if (at == begin)
                mpfr_set_nan(r->state[row * columns + i]);
        }
        if (*at++ != '\n')
            return cns_fail(err, CNS_IO, "row %d of the reference that was kept is damaged", row);
    }
    return rows > 1 ? CNS_OK : cns_fail(err, CNS_USAGE, "'time: end' leaves no row to compare");
}

/* Between two rows only what the difference was at the first one is followed: noise made later must not
 * count, and growth is interpolated. So rows have to be close. */
static cns_code rows_are_close(const cns_laws_work *l, cns_error *err)
{
    const cns_law_reference *r = &l->ref;
    for (int row = 1; row < r->rows; row++) {
        const double rise = r->growth[row] - r->growth[row - 1];
        if (!(rise <= MOST_GROWTH))
            return cns_fail(err, CNS_USAGE,
                            "'time: every' is too coarse: differences grow by 10^%.1f from t = %.12g to "
                            "%.12g, and rows at most 10^%d apart are needed",
                            rise, (row - 1) * l->every, row * l->every, MOST_GROWTH);
    }
    return CNS_OK;
}

cns_code cns_laws_make_reference(cns_laws_work *l, cns_error *err)
{
    char *result = NULL;
    cns_laws_reference_clear(&l->ref);
    l->ref.digits = (long)ceil(l->level - l->delta_log10 - 1e-6) + SPARE;
    l->base = 0;
    l->span = 0.2;
    const cns_ensemble e = {.n = 1,
                            .monitor = &l->inner,
                            .directory = l->directory,
                            .identity = l->identity,
                            .context = l,
                            .name = reference_name,
                            .cost = one,
                            .run = reference_run};
    cns_code code = cns_ensemble_run(&e, &result, err);
    if (!code)
        code = reference_read(l, result, err);
    free(result);
    if (!code)
        code = rows_are_close(l, err);
    const double error = code ? 0 : l->ref.error[l->ref.rows - 1];
    if (!code && error > l->delta_log10 - CNS_LAWS_TRUST_DIGITS)
        code = cns_fail(err, CNS_NUMERIC, "the reference's own error grows to 10^%.1f, too near to delta",
                        error);
    return code;
}
