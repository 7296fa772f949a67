#include "frame.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "core/memory.h"
#include "integrate/numerics.h"
#include "num/logs.h"
#include "num/vector.h"
#include "taylor/tangent.h"

enum {
    /* In double: measured to be the quickest for the falling disk, at a tolerance next to the rounding. */
    DOUBLE_ORDER = 22,
    DOUBLE_TOLERANCE_LOG2 = -50,
    /* Projections are computed in double, whatever the arithmetic: what the first pass leaves by its
     * rounding, the second one removes. */
    PASSES = 2
};

static const double ln_2 = 0.69314718055994530942;

struct cns_frame {
    int d, n, states; /* dynamic states, vectors, states of the program: d (1 + n), and the trace */
    int order;
    bool traced;
    double *scales;       /* of the program's states */
    cns_program *program; /* states and tangents */
    cns_flow *flow;
    mpfr_t *x, term; /* scratch: a state of the flow */
    double *v;       /* scratch: n vectors in scales */
    double *length;  /* scratch: per vector */
    mpq_t time;
    long *exponent; /* per vector: it has become 2^exponent times longer than it is */
};

/* Part i of vector j at t = 0, in scales. Any directions will do that no symmetry of a model singles out: for
 * the first vector parts of multiples of the golden ratio, for the others numbers without a pattern, mixed as
 * in splitmix64 (G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014). */
static double direction(int j, int i)
{
    const double x = (i + 1) * 0.61803398874989484820;
    uint64_t bits = ((uint64_t)j << 32) + (uint64_t)i;
    bits = (bits ^ bits >> 30) * 0xbf58476d1ce4e5b9u;
    bits = (bits ^ bits >> 27) * 0x94d049bb133111ebu;
    bits ^= bits >> 31;
    return j == 0 ? x - floor(x) : ldexp((double)(bits >> 11), -53) - 0.5;
}

static cns_number *initial(const cns_frame *f, const cns_frame_spec *spec, const int *index)
{
    cns_number *x = cns_xalloc((size_t)f->states, sizeof *x);
    for (int i = 0; i < f->states; i++)
        cns_number_init(&x[i]);
    for (int i = 0; i < f->d; i++)
        cns_number_set(&x[i], &cns_system_initial(spec->system)[index[i]]);
    for (int j = 0; j < f->n; j++)
        for (int i = 0; i < f->d; i++)
            mpq_set_d(x[(1 + j) * f->d + i].ratio,
                      j == 0 && spec->first ? spec->first[i] : f->scales[i] * direction(j, i));
    return x;
}

static cns_code start(cns_frame *f, const cns_frame_spec *spec, const int *index, cns_error *err)
{
    const bool in_double = spec->arithmetic == CNS_ARITH_DOUBLE;
    cns_flow_spec flow = cns_flow_spec_taylor(f->program, f->scales, spec->arithmetic,
                                              in_double ? CNS_DOUBLE_DIGITS : spec->digits);
    if (in_double) {
        flow.order = DOUBLE_ORDER;
        flow.tolerance_log2 = DOUBLE_TOLERANCE_LOG2;
    }
    flow.portable = spec->portable;
    flow.stop = spec->stop;
    f->order = flow.order;
    f->x = cns_vector_xnew(f->states, flow.prec);
    mpfr_init2(f->term, flow.prec);
    f->flow = cns_flow_new(&flow, err);
    if (f->flow == NULL)
        return err->code;
    cns_number *x = initial(f, spec, index);
    cns_flow_start(f->flow, x);
    for (int i = 0; i < f->states; i++)
        cns_number_clear(&x[i]);
    free(x);
    return CNS_OK;
}

static cns_code build(cns_frame *f, const cns_frame_spec *spec, int *index, cns_error *err)
{
    const cns_program *program = cns_system_program(spec->system);
    f->d = cns_dynamic_states(program, index);
    f->n = spec->vectors > 0 ? spec->vectors : f->d;
    f->traced = spec->traced;
    f->states = f->d * (1 + f->n) + f->traced;
    if (f->d == 0)
        return cns_fail(err, CNS_NUMERIC, "no state feeds back on another: there is no exponent to find");
    if (f->n > f->d)
        return cns_fail(err, CNS_USAGE,
                        "%d exponents are asked for; there are %d, as many as states that feed back", f->n,
                        f->d);
    f->scales = cns_xalloc((size_t)f->states, sizeof *f->scales);
    f->v = cns_xalloc((size_t)(f->n * f->d), sizeof *f->v);
    f->length = cns_xalloc((size_t)f->n, sizeof *f->length);
    f->exponent = cns_xalloc((size_t)f->n, sizeof *f->exponent);
    for (int i = 0; i < f->states; i++)
        f->scales[i] = cns_system_scales(spec->system)[index[i % f->d]];
    cns_code code = f->traced ? cns_traced_tangent_program(program, f->n, &f->program, err)
                              : cns_tangent_program(program, f->n, &f->program, err);
    return code ? code : start(f, spec, index, err);
}

cns_frame *cns_frame_new(const cns_frame_spec *spec, cns_error *err)
{
    cns_frame *f = cns_xalloc(1, sizeof *f);
    int *index = cns_xalloc((size_t)cns_program_states(cns_system_program(spec->system)) + 1, sizeof *index);
    mpq_init(f->time);
    cns_code code = build(f, spec, index, err);
    free(index);
    if (!code)
        return f;
    cns_frame_free(f);
    return NULL;
}

void cns_frame_free(cns_frame *f)
{
    if (f == NULL)
        return;
    if (f->x != NULL)
        mpfr_clear(f->term);
    cns_vector_free(f->x);
    cns_flow_free(f->flow);
    cns_program_free(f->program);
    mpq_clear(f->time);
    free(f->scales);
    free(f->v);
    free(f->length);
    free(f->exponent);
    free(f);
}

int cns_frame_vectors(const cns_frame *f)
{
    return f->n;
}

int cns_frame_dimensions(const cns_frame *f)
{
    return f->d;
}

int cns_frame_order(const cns_frame *f)
{
    return f->order;
}

const cns_flow *cns_frame_flow(const cns_frame *f)
{
    return f->flow;
}

bool cns_frame_constant_trace(const cns_frame *f, mpq_t y)
{
    return f->traced && cns_exact_derivative(f->program, f->states - 1, y);
}

static double product(const cns_frame *f, int j, int k)
{
    double sum = 0;
    for (int i = 0; i < f->d; i++)
        sum += f->v[j * f->d + i] * f->v[k * f->d + i];
    return sum;
}

/* Vector j of state x into f->v. */
static void read_vector(cns_frame *f, mpfr_t *x, int j)
{
    for (int i = 0; i < f->d; i++)
        f->v[j * f->d + i] = mpfr_get_d(x[(1 + j) * f->d + i], MPFR_RNDN) / f->scales[i];
}

/* Makes the vectors of state x perpendicular to each other, and notes their lengths. */
static void straighten(cns_frame *f, mpfr_t *x)
{
    for (int j = 0; j < f->n; j++) {
        read_vector(f, x, j);
        for (int pass = 0; pass < PASSES && j > 0; pass++) {
            for (int k = 0; k < j; k++) {
                const double part = product(f, j, k) / product(f, k, k);
                for (int i = 0; i < f->d; i++) {
                    mpfr_mul_d(f->term, x[(1 + k) * f->d + i], part, MPFR_RNDN);
                    mpfr_sub(x[(1 + j) * f->d + i], x[(1 + j) * f->d + i], f->term, MPFR_RNDN);
                }
            }
            read_vector(f, x, j);
        }
        f->length[j] = sqrt(product(f, j, j));
    }
}

static cns_code check_lengths(const cns_frame *f, double t, cns_error *err)
{
    for (int j = 0; j < f->n; j++)
        if (!(f->length[j] > 0) || !isfinite(f->length[j]))
            return cns_fail(err, CNS_NUMERIC,
                            "t = %.12g: the tangent vanishes, or grows out of range in one step", t);
    return CNS_OK;
}

/* Tolerances are relative to the scales, so the tangents are kept at length 0.5 to 1 where a step begins. */
static cns_code renormalise(cns_frame *f, cns_error *err)
{
    const int first = f->d, count = f->n * f->d;
    for (int i = first; i < first + count; i++)
        mpfr_set(f->x[i], cns_flow_state(f->flow)[i], MPFR_RNDN);
    straighten(f, f->x);
    if (check_lengths(f, mpfr_get_d(cns_flow_end(f->flow), MPFR_RNDN), err))
        return err->code;
    for (int j = 0; j < f->n; j++) {
        int e;
        frexp(f->length[j], &e);
        for (int i = (1 + j) * f->d; i < (2 + j) * f->d; i++)
            mpfr_mul_2si(f->x[i], f->x[i], -e, MPFR_RNDN);
        f->exponent[j] += e;
    }
    cns_flow_replace(f->flow, first, count, (const mpfr_t *)f->x + first);
    return CNS_OK;
}

cns_code cns_frame_at(cns_frame *f, double t, double *growth, double *trace, cns_error *err)
{
    mpq_set_d(f->time, t);
    while (cns_flow_steps(f->flow) == 0 || mpfr_cmp_q(cns_flow_end(f->flow), f->time) < 0) {
        cns_code code = renormalise(f, err);
        if (!code)
            code = cns_flow_step(f->flow, err);
        if (code)
            return code;
    }
    cns_flow_eval(f->flow, f->time, f->x);
    straighten(f, f->x);
    if (check_lengths(f, t, err))
        return err->code;
    for (int j = 0; j < f->n; j++)
        growth[j] = cns_log2_2exp(f->length[j], f->exponent[j]) * ln_2;
    if (f->traced)
        *trace = mpfr_get_d(f->x[f->states - 1], MPFR_RNDN);
    return CNS_OK;
}
