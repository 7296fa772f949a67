#include "cycle.h"

#include <math.h>
#include <stdlib.h>

#include "core/memory.h"
#include "integrate/trajectory.h"
#include "num/logs.h"
#include "num/vector.h"
#include "taylor/jet.h"
#include "taylor/tangent.h"

enum { TURNS = 40, STEPS_PER_RETURN = 20000, SQUARINGS = 50 };

/* One evaluation of the map of `returns` returns, and of its derivative. */
typedef struct map {
    const cns_return_map *S;
    int d, states; /* states of the tangent program */
    mpfr_prec_t prec;
    double *scales; /* of the tangent program */
    cns_program *tangent;
    cns_trajectory *trajectory; /* of the tangent program; its only condition is the section */
    cns_jet *field;             /* the right-hand side at a point */
    cns_number *start;
    mpfr_t *r, *D,
        *f; /* R(z); d x d, its derivative by columns of the tangents; rates of the dynamic states */
    mpfr_t x, y;
} map;

static void close_map(map *m)
{
    for (int i = 0; m->start != NULL && i < m->states; i++)
        cns_number_clear(&m->start[i]);
    free(m->start);
    cns_vector_free(m->r);
    cns_vector_free(m->D);
    cns_vector_free(m->f);
    cns_jet_free(m->field);
    cns_trajectory_free(m->trajectory);
    cns_program_free(m->tangent);
    free(m->scales);
    mpfr_clears(m->x, m->y, (mpfr_ptr)0);
}

static cns_code open_map(map *m, const cns_return_map *S, long digits, cns_error *err)
{
    const int d = S->d, states = d + d * d;
    *m = (map){.S = S, .d = d, .states = states, .prec = cns_modes_bits(digits)};
    mpfr_inits2(m->prec, m->x, m->y, (mpfr_ptr)0);
    m->scales = cns_xalloc((size_t)states, sizeof *m->scales);
    m->start = cns_xalloc((size_t)states, sizeof *m->start);
    for (int i = 0; i < states; i++) {
        m->scales[i] = S->scales[S->index[i % d]];
        cns_number_init(&m->start[i]);
    }
    m->r = cns_vector_xnew(d, m->prec);
    m->D = cns_vector_xnew(d * d, m->prec);
    m->f = cns_vector_xnew(d, m->prec);
    if (cns_tangent_program(S->program, d, &m->tangent, err))
        return err->code;
    cns_event_condition section = S->section;
    for (int i = 0; i < d; i++)
        if (S->index[i] == S->section.state)
            section.state = i;
    const cns_trajectory_spec spec = {.flow = cns_return_map_flow(S, m->tangent, m->scales, digits),
                                      .no_growth = true,
                                      .conditions = &section,
                                      .n_conditions = 1};
    m->trajectory = cns_trajectory_new(&spec, err);
    if (m->trajectory == NULL)
        return err->code;
    const cns_jet_spec jet = {.program = S->program, .ops = &cns_arith_mpfr, .order = 1, .prec = m->prec};
    m->field = cns_jet_new(&jet, err);
    return m->field != NULL ? CNS_OK : err->code;
}

/* The rates of change of the dynamic states at a state of the tangent program. */
static cns_code rates(map *m, const mpfr_t *state, cns_error *err)
{
    const cns_return_map *S = m->S;
    cns_jet_begin(m->field, 1);
    mpfr_set_zero(m->x, 1);
    for (int i = 0; i < S->n; i++)
        cns_jet_set_state(m->field, i, m->x);
    for (int i = 0; i < m->d; i++)
        cns_jet_set_state(m->field, S->index[i], state[i]);
    cns_code code = cns_jet_expand(m->field, 1, err);
    for (int i = 0; i < m->d && !code; i++)
        cns_jet_coefficient(m->field, m->f[i], S->index[i], 1);
    return code;
}

/* R and DR at c->z, and the time, turns, image and growth of the repetition. Where the flow meets the section
 * a tangent is carried along the flow into it: dz = (1 - f g^T / g f) Phi dz, g the section's normal. */
static cns_code evaluate(map *m, cns_cycle *c, cns_error *err)
{
    const cns_return_map *S = m->S;
    const int d = m->d;
    cns_code code = CNS_OK;
    int at = 0, returns = 0;
    for (int i = 0; i < m->states; i++) {
        mpfr_set_ui(m->x, i >= d && (i - d) / d == (i - d) % d, MPFR_RNDN);
        cns_number_from_mpfr(&m->start[i], i < d ? c->z[i] : m->x);
        if (i < d && S->index[i] == S->section.state) {
            at = i;
            cns_number_set(&m->start[i], &S->section.value);
        }
    }
    const cns_meetings *meetings = cns_trajectory_meetings(m->trajectory);
    cns_trajectory_start(m->trajectory, m->start);
    while (returns < c->returns) {
        if (cns_flow_steps(cns_trajectory_flow(m->trajectory)) > (long)STEPS_PER_RETURN * c->returns)
            return cns_fail(err, CNS_UNREACHED, "the motion does not return");
        code = cns_trajectory_step(m->trajectory, err);
        if (code)
            return code;
        for (int k = 0; k < cns_meetings_count(meetings) && returns < c->returns; k++) {
            const cns_meeting *event = cns_meetings_meeting(meetings, k);
            if (!cns_return_map_counts(S, event, c->direction) || ++returns < c->returns)
                continue;
            mpfr_set(c->time, event->time, MPFR_RNDN);
            c->turns = event->k * c->direction;
            c->mirrored = event->direction != c->direction;
            c->growth_log2 = -HUGE_VAL;
            code = rates(m, (const mpfr_t *)event->state, err);
            for (int i = 0; i < d && !code; i++) {
                const int sign = cns_return_map_sign(S, i, event->k, event->direction);
                mpfr_mul_si(m->r[i], event->state[i], sign, MPFR_RNDN);
                if (i == at)
                    mpfr_set_zero(m->r[i], 1);
                for (int j = 0; j < d; j++) {
                    mpfr_srcptr phi = event->state[d + j * d + i], along = event->state[d + j * d + at];
                    c->growth_log2 = fmax(c->growth_log2, cns_log2_mpfr(phi));
                    mpfr_div(m->x, along, m->f[at], MPFR_RNDN);
                    mpfr_mul(m->x, m->x, m->f[i], MPFR_RNDN);
                    mpfr_sub(m->x, phi, m->x, MPFR_RNDN);
                    mpfr_mul_si(m->D[i * d + j], m->x, i == at || j == at ? 0 : sign, MPFR_RNDN);
                }
            }
        }
    }
    return code;
}

/* Solves (D - 1) s = z - r by elimination with pivoting, into r. False: singular. */
static bool newton_step(map *m, mpfr_t *z)
{
    const int d = m->d;
    mpfr_t *a = m->D;
    for (int i = 0; i < d; i++) {
        mpfr_sub_ui(a[i * d + i], a[i * d + i], 1, MPFR_RNDN);
        mpfr_sub(m->r[i], z[i], m->r[i], MPFR_RNDN);
    }
    for (int k = 0; k < d; k++) {
        int pivot = k;
        for (int i = k + 1; i < d; i++)
            if (mpfr_cmpabs(a[i * d + k], a[pivot * d + k]) > 0)
                pivot = i;
        if (!mpfr_regular_p(a[pivot * d + k]))
            return false;
        for (int j = 0; j < d; j++)
            mpfr_swap(a[k * d + j], a[pivot * d + j]);
        mpfr_swap(m->r[k], m->r[pivot]);
        for (int i = 0; i < d; i++) {
            if (i == k)
                continue;
            mpfr_div(m->x, a[i * d + k], a[k * d + k], MPFR_RNDN);
            for (int j = k; j < d; j++) {
                mpfr_mul(m->y, m->x, a[k * d + j], MPFR_RNDN);
                mpfr_sub(a[i * d + j], a[i * d + j], m->y, MPFR_RNDN);
            }
            mpfr_mul(m->y, m->x, m->r[k], MPFR_RNDN);
            mpfr_sub(m->r[i], m->r[i], m->y, MPFR_RNDN);
        }
    }
    for (int k = 0; k < d; k++)
        mpfr_div(m->r[k], m->r[k], a[k * d + k], MPFR_RNDN);
    return true;
}

static double residual_log2(map *m, mpfr_t *z)
{
    double largest = -HUGE_VAL;
    for (int i = 0; i < m->d; i++) {
        mpfr_sub(m->x, m->r[i], z[i], MPFR_RNDN);
        largest = fmax(largest, cns_log2_mpfr(m->x) - cns_log2_2exp(m->scales[i], 0));
    }
    return largest;
}

/* The spectral radius: |D^(2^k)|^(1/2^k) by squaring, with so large a k that the ratio of norm and radius,
 * which that root is taken of, too, leaves nothing. */
static double spectral_radius(const map *m)
{
    const int d = m->d;
    double *a = cns_xalloc(2 * (size_t)(d * d), sizeof *a), *b = a + d * d, log2_norm = 0, weight = 1;
    for (int i = 0; i < d * d; i++)
        a[i] = mpfr_get_d(m->D[i], MPFR_RNDN) * m->scales[i % d] / m->scales[i / d];
    for (int k = 0; k <= SQUARINGS; k++) {
        double norm = 0;
        for (int i = 0; i < d * d; i++)
            norm = fmax(norm, fabs(a[i]));
        if (!(norm > 0)) {
            free(a);
            return 0;
        }
        log2_norm += weight * log2(norm);
        weight /= 2;
        for (int i = 0; i < d * d; i++)
            a[i] /= norm;
        for (int i = 0; i < d; i++)
            for (int j = 0; j < d; j++) {
                b[i * d + j] = 0;
                for (int l = 0; l < d; l++)
                    b[i * d + j] += a[i * d + l] * a[l * d + j];
            }
        for (int i = 0; i < d * d; i++)
            a[i] = b[i];
    }
    free(a);
    return exp2(log2_norm);
}

cns_code cns_cycle_find(const cns_return_map *S, const mpfr_t *z, int returns, int direction, long digits,
                        cns_cycle *c, cns_error *err)
{
    map m;
    double best = HUGE_VAL;
    *c = (cns_cycle){.d = S->d, .returns = returns, .direction = direction};
    c->z = cns_vector_xnew(S->d, cns_modes_bits(digits));
    mpfr_init2(c->time, cns_modes_bits(digits));
    for (int i = 0; i < S->d; i++)
        mpfr_set(c->z[i], z[i], MPFR_RNDN);
    cns_code code = open_map(&m, S, digits, err);
    for (int turn = 0; turn < TURNS && !code; turn++) {
        code = evaluate(&m, c, err);
        if (code == CNS_NUMERIC && turn > 0) /* a step of Newton's has gone too far */
            code = cns_fail(err, CNS_UNREACHED, "Newton's method finds no cycle nearby");
        if (code)
            break;
        c->residual_log2 = residual_log2(&m, c->z);
        c->multiplier = spectral_radius(&m);
        /* As small as it gets: what the arithmetic's noise, grown over one repetition, leaves. */
        const double noise = c->growth_log2 + 12 - (double)m.prec;
        if (c->residual_log2 <= noise && c->residual_log2 > best - 3)
            break;
        if (c->residual_log2 == -HUGE_VAL)
            break;
        if (turn + 1 == TURNS || (turn > 8 && c->residual_log2 > -8))
            code = cns_fail(err, CNS_UNREACHED, "Newton's method finds no cycle nearby");
        best = fmin(best, c->residual_log2);
        if (!code && !newton_step(&m, c->z))
            code = cns_fail(err, CNS_UNREACHED, "the return map is singular");
        for (int i = 0; i < S->d && !code; i++)
            mpfr_add(c->z[i], c->z[i], m.r[i], MPFR_RNDN);
    }
    close_map(&m);
    return code;
}

void cns_cycle_clear(cns_cycle *c)
{
    cns_vector_free(c->z);
    if (c->z != NULL)
        mpfr_clear(c->time);
    c->z = NULL;
}
