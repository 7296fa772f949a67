#include "trajectory.h"

#include <math.h>
#include <stdlib.h>

#include "core/clock.h"
#include "method.h"
#include "numerics.h"
#include "taylor/jet.h"

enum { OUTPUT_ORDER = 4 }; /* from a start with leading zeros, 0/0 needs a few orders */

struct cns_trajectory {
    cns_trajectory_spec spec;
    cns_flow *flow;
    cns_growth *growth;
    cns_jet *outputs;
    mpfr_t x;
    bool late;
};

bool cns_sample_init(cns_sample *s, const cns_program *p, mpfr_prec_t prec)
{
    s->n_states = cns_program_states(p);
    s->n_outputs = cns_program_outputs(p);
    s->state = cns_vector_new(s->n_states, prec);
    s->output = cns_vector_new(s->n_outputs, prec);
    s->growth = 0;
    s->error_log2 = -HUGE_VAL;
    return s->state && s->output;
}

void cns_sample_clear(cns_sample *s)
{
    cns_vector_free(s->state, s->n_states);
    cns_vector_free(s->output, s->n_outputs);
    s->state = s->output = NULL;
}

cns_trajectory *cns_trajectory_new(const cns_trajectory_spec *spec, cns_error *err)
{
    cns_trajectory *t = calloc(1, sizeof *t);
    if (!t) {
        cns_fail(err, CNS_NUMERIC, "out of memory");
        return NULL;
    }
    t->spec = *spec;
    t->flow = cns_flow_new(&spec->flow, err);
    const bool follows = t->flow && !spec->no_growth;
    t->growth = follows ? cns_growth_new(spec->flow.program, spec->flow.scales, err) : NULL;
    mpfr_init2(t->x, t->flow ? cns_flow_prec(t->flow) : MPFR_PREC_MIN);
    bool wanted = spec->outputs && cns_program_outputs(spec->flow.program) > 0;
    const bool failed = !t->flow || (follows && !t->growth);
    if (!failed && wanted) {
        cns_jet_spec jet = {.program = spec->flow.program,
                            .ops = cns_flow_reference_arith(&spec->flow),
                            .order = OUTPUT_ORDER,
                            .prec = cns_flow_prec(t->flow),
                            .outputs = true};
        t->outputs = cns_jet_new(&jet, err);
    }
    if (failed || (wanted && !t->outputs)) {
        cns_trajectory_free(t);
        return NULL;
    }
    cns_flow_start(t->flow, spec->initial);
    if (follows)
        cns_growth_start(t->growth);
    return t;
}

void cns_trajectory_free(cns_trajectory *t)
{
    if (!t)
        return;
    cns_flow_free(t->flow);
    cns_growth_free(t->growth);
    cns_jet_free(t->outputs);
    mpfr_clear(t->x);
    free(t);
}

static void evaluate_outputs(cns_trajectory *t, cns_sample *s)
{
    cns_error singular;
    cns_jet_begin(t->outputs, 1);
    for (int i = 0; i < s->n_states; i++)
        cns_jet_set_state(t->outputs, i, s->state[i]);
    bool defined = !cns_jet_expand(t->outputs, OUTPUT_ORDER, &singular);
    for (int i = 0; i < s->n_outputs; i++)
        if (!defined || !cns_jet_output(t->outputs, s->output[i], i))
            mpfr_set_nan(s->output[i]);
}

/* Has the last step begun at or after the time of the next origin? */
static bool origin_is_due(const cns_trajectory *t)
{
    return mpfr_get_d(cns_flow_begin(t->flow), MPFR_RNDN) >=
           t->spec.end / CNS_GROWTH_ORIGINS * cns_growth_marks(t->growth);
}

cns_code cns_trajectory_step(cns_trajectory *t, cns_error *err)
{
    if (t->spec.deadline != 0 && cns_seconds() > t->spec.deadline) {
        t->late = true;
        return cns_fail(err, CNS_STOPPED, "the time allowed is used up");
    }
    cns_code code = cns_flow_step(t->flow, err);
    if (code)
        return code;
    if (t->spec.stepped)
        t->spec.stepped(t->spec.context, t->flow);
    if (t->spec.no_growth)
        return CNS_OK;
    double noise = t->spec.unit_noise != 0 ? t->spec.unit_noise : cns_flow_noise_log2(t->flow);
    code = cns_growth_follow(t->growth, t->flow, noise, err);
    if (!code && t->spec.origins && origin_is_due(t))
        code = cns_growth_mark(t->growth, err);
    return code;
}

void cns_trajectory_peek(cns_trajectory *t, const mpq_t time, cns_sample *s)
{
    cns_flow_eval(t->flow, time, s->state);
    if (t->outputs)
        evaluate_outputs(t, s);
}

cns_code cns_trajectory_at(cns_trajectory *t, const mpq_t time, cns_sample *s, cns_error *err)
{
    while (mpfr_cmp_q(cns_flow_end(t->flow), time) < 0) {
        cns_code code = cns_trajectory_step(t, err);
        if (code)
            return code;
    }
    cns_trajectory_peek(t, time, s);
    s->growth = 0;
    s->error_log2 = -HUGE_VAL;
    return t->spec.no_growth ? CNS_OK : cns_growth_at(t->growth, time, &s->growth, &s->error_log2, err);
}

cns_flow *cns_trajectory_flow(cns_trajectory *t)
{
    return t->flow;
}

cns_growth *cns_trajectory_growth(cns_trajectory *t)
{
    return t->growth;
}

bool cns_trajectory_late(const cns_trajectory *t)
{
    return t->late;
}
