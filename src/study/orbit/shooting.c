#include "shooting.h"

#include <stdlib.h>

#include "arith/arith.h"
#include "core/memory.h"
#include "num/vector.h"
#include "solve/proof.h"
#include "taylor/tangent.h"

enum { MOST_STEPS = 1000000 };

cns_code cns_shooting_open(cns_shooting *s, const cns_shooting_spec *spec, cns_error *err)
{
    const cns_program *p = cns_system_program(spec->system);
    const int n = cns_program_states(p);
    *s = (cns_shooting){.n = n,
                        .scales = cns_system_scales(spec->system),
                        .tangents = spec->tangents,
                        .prec = cns_digits_to_bits(spec->digits)};
    mpfr_init2(s->trace, s->prec);
    s->index = cns_xalloc((size_t)n + 1, sizeof *s->index);
    const int d = s->d = cns_dynamic_states(p, s->index);
    const int states = spec->tangents ? d + d * d + 1 : d;
    s->all_scales = cns_xalloc((size_t)states + 1, sizeof *s->all_scales);
    for (int i = 0; i < states; i++)
        s->all_scales[i] = d > 0 ? s->scales[s->index[i % d]] : 1;
    s->x = cns_vector_xnew(d, s->prec);
    s->m = cns_vector_xnew(d * d, s->prec);
    s->f = cns_vector_xnew(d, s->prec);
    s->state = cns_vector_xnew(states, s->prec);
    cns_code code = spec->tangents ? cns_traced_tangent_program(p, d, &s->program, err)
                                   : cns_tangent_program(p, 0, &s->program, err);
    if (code)
        return code;
    cns_flow_spec flow = cns_flow_spec_taylor(s->program, s->all_scales, CNS_ARITH_FAST, spec->digits);
    flow.verify = true;
    flow.stop = spec->stop;
    if (spec->fine)
        flow.safety = CNS_FINE_SAFETY;
    s->flow = cns_flow_new(&flow, err);
    const cns_jet_spec jet = {.program = p, .ops = &cns_arith_mpfr, .order = 1, .prec = s->prec};
    if (s->flow != NULL && spec->tangents)
        s->field = cns_jet_new(&jet, err);
    return s->flow != NULL && (s->field != NULL || !spec->tangents) ? CNS_OK : err->code;
}

void cns_shooting_close(cns_shooting *s)
{
    if (s->index != NULL)
        mpfr_clear(s->trace);
    cns_jet_free(s->field);
    cns_flow_free(s->flow);
    cns_program_free(s->program);
    cns_vector_free(s->x);
    cns_vector_free(s->m);
    cns_vector_free(s->f);
    cns_vector_free(s->state);
    free(s->all_scales);
    free(s->index);
    *s = (cns_shooting){0};
}

/* The rates of change at x; what is not dynamic does not matter to them. */
static cns_code rates(cns_shooting *s, cns_error *err)
{
    cns_jet_begin(s->field, 1);
    mpfr_set_zero(s->state[0], 1);
    for (int i = 0, k = 0; i < s->n; i++) {
        const bool dynamic = k < s->d && s->index[k] == i;
        cns_jet_set_state(s->field, i, dynamic ? s->x[k] : s->state[0]);
        k += dynamic;
    }
    cns_code code = cns_jet_expand(s->field, 1, err);
    for (int k = 0; k < s->d && !code; k++)
        cns_jet_coefficient(s->field, s->f[k], s->index[k], 1);
    return code;
}

cns_code cns_shooting_run(cns_shooting *s, const mpfr_t *z, mpfr_srcptr time, cns_error *err)
{
    const int d = s->d;
    cns_code code = CNS_OK;
    mpq_t end;
    for (int i = 0; i < d; i++)
        mpfr_set(s->state[i], z[i], MPFR_RNDN);
    for (int i = 0; i < d * d && s->tangents; i++)
        mpfr_set_ui(s->state[d + i], i / d == i % d, MPFR_RNDN);
    if (s->tangents)
        mpfr_set_zero(s->state[d + d * d], 1);
    if (!mpfr_number_p(time) || mpfr_sgn(time) <= 0)
        return cns_fail(err, CNS_NUMERIC, "the period is not positive");
    cns_flow_start_at(s->flow, (const mpfr_t *)s->state);
    while (!code && mpfr_less_p(cns_flow_end(s->flow), time)) {
        code = cns_flow_step(s->flow, err);
        if (!code && cns_flow_steps(s->flow) > MOST_STEPS)
            code = cns_fail(err, CNS_NUMERIC, "one period takes more than %d steps", MOST_STEPS);
    }
    if (code)
        return code;
    s->steps = cns_flow_steps(s->flow);
    mpq_init(end);
    mpfr_get_q(end, time);
    cns_flow_eval(s->flow, end, s->state);
    mpq_clear(end);
    for (int i = 0; i < d; i++)
        mpfr_set(s->x[i], s->state[i], MPFR_RNDN);
    for (int i = 0; i < d && s->tangents; i++)
        for (int j = 0; j < d; j++)
            mpfr_set(s->m[i * d + j], s->state[d + j * d + i], MPFR_RNDN);
    if (!s->tangents)
        return CNS_OK;
    mpfr_set(s->trace, s->state[d + d * d], MPFR_RNDN);
    return rates(s, err);
}
