#include "trajectory.h"

#include <math.h>
#include <stdlib.h>

#include "core/clock.h"
#include "method.h"
#include "numerics.h"
#include "taylor/ball.h"
#include "taylor/jet.h"
#include "taylor/tangent.h"

enum { OUTPUT_ORDER = 4 }; /* from a start with leading zeros, 0/0 needs a few orders */

struct cns_trajectory {
    cns_trajectory_spec spec;
    cns_flow *flow;
    cns_growth *growth;
    cns_meetings *meetings;
    int told; /* of the last step's meetings */
    cns_jet *outputs;
    cns_tube *tube;
    cns_program *tangent; /* of one direction, and scratch: for meetings within the tube */
    cns_meeting_bound bound;
    mag_ptr error;
    mpq_t time;
    bool late, unbounded;
    long looked_steps;   /* those made until the last look */
    double looked, left; /* at the last look: the time, and the steps that were left; 0: none before */
};

bool cns_sample_init(cns_sample *s, const cns_program *p, mpfr_prec_t prec)
{
    s->n_states = cns_program_states(p);
    s->n_outputs = cns_program_outputs(p);
    s->state = cns_vector_new(s->n_states, prec);
    s->output = cns_vector_new(s->n_outputs, prec);
    s->state_error = s->output_error = NULL;
    s->growth = 0;
    s->error_log2 = -HUGE_VAL;
    if (s->state && s->output)
        return true;
    cns_sample_clear(s);
    return false;
}

void cns_sample_want_errors(cns_sample *s)
{
    s->state_error = _mag_vec_init(s->n_states + 1);
    s->output_error = _mag_vec_init(s->n_outputs + 1);
}

void cns_sample_clear(cns_sample *s)
{
    if (s->state_error != NULL)
        _mag_vec_clear(s->state_error, s->n_states + 1);
    if (s->output_error != NULL)
        _mag_vec_clear(s->output_error, s->n_outputs + 1);
    s->state_error = s->output_error = NULL;
    cns_vector_free(s->state);
    cns_vector_free(s->output);
    s->state = s->output = NULL;
}

/* The flow, and what follows it. False: *err says why. */
static bool open_followers(cns_trajectory *t, cns_error *err)
{
    const cns_flow_spec *flow = &t->spec.flow;
    t->flow = cns_flow_new(flow, err);
    if (t->flow == NULL)
        return false;
    const mpfr_prec_t prec = cns_flow_prec(t->flow);
    if (!t->spec.no_growth) {
        t->growth = cns_growth_new(flow->program, flow->scales, err);
        if (t->growth == NULL)
            return false;
    }
    if (t->spec.tube) {
        t->tube = cns_tube_new(flow->program, prec, err);
        if (t->tube == NULL)
            return false;
        const int n = cns_program_states(flow->program);
        cns_meeting_bound_init(&t->bound, n);
        t->error = _mag_vec_init(n + 1);
        if (t->spec.n_conditions > 0 && cns_whole_tangent_program(flow->program, 1, &t->tangent, err))
            return false;
    }
    if (t->spec.n_conditions > 0) {
        t->meetings = cns_meetings_new(t->spec.conditions, t->spec.n_conditions, cns_flow_states(t->flow),
                                       flow->scales, prec, err);
        if (t->meetings == NULL)
            return false;
    }
    if (t->spec.outputs && cns_program_outputs(flow->program) > 0) {
        const cns_jet_spec jet = {.program = flow->program,
                                  .ops = cns_flow_reference_arith(flow),
                                  .order = OUTPUT_ORDER,
                                  .prec = prec,
                                  .outputs = true};
        t->outputs = cns_jet_new(&jet, err);
        if (t->outputs == NULL)
            return false;
    }
    return true;
}

cns_trajectory *cns_trajectory_new(const cns_trajectory_spec *spec, cns_error *err)
{
    cns_trajectory *t = calloc(1, sizeof *t);
    if (!t) {
        cns_out_of_memory(err);
        return NULL;
    }
    t->spec = *spec;
    mpq_init(t->time);
    if (!open_followers(t, err)) {
        cns_trajectory_free(t);
        return NULL;
    }
    if (spec->initial)
        cns_trajectory_start(t, spec->initial);
    return t;
}

void cns_trajectory_free(cns_trajectory *t)
{
    if (!t)
        return;
    cns_flow_free(t->flow);
    cns_growth_free(t->growth);
    cns_tube_free(t->tube);
    cns_program_free(t->tangent);
    const int n = cns_program_states(t->spec.flow.program);
    cns_meeting_bound_clear(&t->bound, n);
    if (t->error != NULL)
        _mag_vec_clear(t->error, n + 1);
    cns_meetings_free(t->meetings);
    cns_jet_free(t->outputs);
    mpq_clear(t->time);
    free(t);
}

void cns_trajectory_start(cns_trajectory *t, const cns_number *initial)
{
    cns_flow_start(t->flow, initial);
    if (t->growth)
        cns_growth_start(t->growth);
    if (t->tube)
        cns_tube_start(t->tube, t->flow, initial);
    if (t->meetings)
        cns_meetings_start(t->meetings);
    t->told = 0;
    t->looked = t->left = 0;
    t->looked_steps = 0;
    t->unbounded = false;
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

/* spec.met for the meetings of the last step up to `until` (NULL: all) that have not been told. */
static cns_code tell(cns_trajectory *t, mpq_srcptr until, cns_error *err)
{
    cns_code code = CNS_OK;
    if (!t->meetings || !t->spec.met)
        return code;
    for (; !code && t->told < cns_meetings_count(t->meetings); t->told++) {
        const cns_meeting *m = cns_meetings_meeting(t->meetings, t->told);
        double growth, noise = -HUGE_VAL;
        if (until && mpfr_cmp_q(m->time, until) > 0)
            break;
        mpfr_get_q(t->time, m->time);
        if (!t->spec.no_growth)
            code = cns_growth_at(t->growth, t->time, &growth, &noise, err);
        if (t->tube) {
            cns_tube_at(t->tube, t->flow, t->time, (const mpfr_t *)m->state, t->error);
            cns_meeting_prove(&t->bound, t->spec.flow.program, t->tangent, &t->spec.conditions[m->condition],
                              m, t->error, cns_flow_prec(t->flow));
        }
        if (!code)
            code = t->spec.met(t->spec.met_context, m, t->tube ? &t->bound : NULL, noise, err);
    }
    return code;
}

cns_code cns_trajectory_tell_rest(cns_trajectory *t, cns_error *err)
{
    return tell(t, NULL, err);
}

/* Would the run have no end? Its pace is looked at after every so many steps, which is more than a narrow
 * smoothed kink takes (3.3 times the order). At a start beside a singularity steps grow from look to look. */
static cns_code look_at_pace(cns_trajectory *t, cns_error *err)
{
    const long least = 1024 + 4 * (long)t->spec.flow.order,
               between = cns_flow_steps(t->flow) - t->looked_steps;
    if (t->spec.most_steps == 0 || between < least)
        return CNS_OK;
    const double now = mpfr_get_d(cns_flow_end(t->flow), MPFR_RNDN), passed = now - t->looked,
                 left = (t->spec.end - now) / passed * (double)between;
    const bool is_endless = t->left > t->spec.most_steps && left > t->left / 2;
    t->looked = now;
    t->looked_steps = cns_flow_steps(t->flow);
    t->left = left;
    if (!is_endless)
        return CNS_OK;
    return cns_fail(err, CNS_USAGE,
                    "t = %.12g: with steps of %.1e, more than %.0e up to t = %g, the run does not end; with "
                    "max_time it goes as far as it comes",
                    cns_program_time(t->spec.flow.program, now), passed / (double)between, t->spec.most_steps,
                    cns_program_time(t->spec.flow.program, t->spec.end));
}

cns_code cns_trajectory_step(cns_trajectory *t, cns_error *err)
{
    if (t->spec.deadline != 0 && cns_seconds() > t->spec.deadline) {
        t->late = true;
        return cns_fail(err, CNS_STOPPED, "the time allowed is used up");
    }
    cns_code code = tell(t, NULL, err);
    if (!code)
        code = cns_flow_step(t->flow, err);
    if (code)
        return code;
    if (t->spec.stepped)
        t->spec.stepped(t->spec.context, t->flow);
    if (!t->spec.no_growth) {
        const double noise = t->spec.unit_noise ? 0 : cns_flow_noise_log2(t->flow);
        code = cns_growth_follow(t->growth, t->flow, noise, err);
        if (!code && t->spec.origins && origin_is_due(t))
            code = cns_growth_mark(t->growth, err);
    }
    if (!code && t->tube) {
        code = cns_tube_follow(t->tube, t->flow, err);
        t->unbounded = code == CNS_NUMERIC || code == CNS_UNREACHED;
    }
    if (!code && t->meetings)
        code = cns_meetings_follow(t->meetings, t->flow, err);
    t->told = 0;
    return code ? code : look_at_pace(t, err);
}

void cns_trajectory_peek(cns_trajectory *t, const mpq_t time, cns_sample *s)
{
    cns_flow_eval(t->flow, time, s->state);
    if (t->outputs)
        evaluate_outputs(t, s);
}

/* Steps that nobody looks at, on the way to `time`. */
static void hurry(cns_trajectory *t, const mpq_t time)
{
    double until = mpq_get_d(time);
    if (t->meetings || t->tube || t->spec.stepped || t->spec.origins)
        return;
    if (!t->spec.no_growth)
        until = fmin(until, cns_growth_free_until(t->growth));
    const long made = cns_flow_skip(t->flow, until);
    if (made > 0 && !t->spec.no_growth)
        cns_growth_skipped(t->growth, made, t->spec.unit_noise ? 0 : -(double)cns_flow_prec(t->flow));
}

/* Bounds of the errors of derived quantities: balls over the box of the states, about what was computed. */
static void bound_outputs(const cns_trajectory *t, cns_sample *s)
{
    const slong prec = cns_flow_prec(t->flow) + 64;
    arb_ptr x = _arb_vec_init(s->n_states), y = _arb_vec_init(s->n_outputs);
    arb_t computed;
    arb_init(computed);
    for (int i = 0; i < s->n_states; i++) {
        arb_set_interval_mpfr(x + i, s->state[i], s->state[i], prec);
        arb_add_error_mag(x + i, s->state_error + i);
    }
    cns_ball_outputs(t->spec.flow.program, x, y, prec);
    for (int i = 0; i < s->n_outputs; i++) {
        if (mpfr_number_p(s->output[i]))
            arb_set_interval_mpfr(computed, s->output[i], s->output[i], prec);
        else
            arb_indeterminate(computed);
        arb_sub(y + i, y + i, computed, prec);
        arb_get_mag(s->output_error + i, y + i);
    }
    arb_clear(computed);
    _arb_vec_clear(x, s->n_states);
    _arb_vec_clear(y, s->n_outputs);
}

cns_code cns_trajectory_at(cns_trajectory *t, const mpq_t time, cns_sample *s, cns_error *err)
{
    while (mpfr_cmp_q(cns_flow_end(t->flow), time) < 0) {
        hurry(t, time);
        cns_code code = cns_trajectory_step(t, err);
        if (code)
            return code;
    }
    cns_code code = tell(t, time, err);
    if (code)
        return code;
    cns_trajectory_peek(t, time, s);
    s->growth = 0;
    s->error_log2 = -HUGE_VAL;
    if (t->tube) {
        cns_tube_at(t->tube, t->flow, time, s->state, s->state_error);
        s->growth = cns_tube_growth(t->tube, t->flow, time);
        if (t->outputs)
            bound_outputs(t, s);
    }
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

void cns_trajectory_leave_growth(cns_trajectory *t)
{
    t->spec.no_growth = true;
}

const cns_meetings *cns_trajectory_meetings(cns_trajectory *t)
{
    return t->meetings;
}

bool cns_trajectory_unbounded(const cns_trajectory *t)
{
    return t->unbounded;
}

bool cns_trajectory_late(const cns_trajectory *t)
{
    return t->late;
}
