#include "jet.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arith/straight.h"
#include "arith/trace.h"
#include "jet_internal.h"

/* From this order on every recurrence makes the same calls, with indices one higher at every order. The last
 * call to begin is the square in that of a root, at order 2. */
enum { FIRST_REPEATED = 3 };

/* Constants are computed once, by the same recurrences, in MPFR with bits to spare; J->x, too, has them then.
 */
static cns_code compute_constants(cns_jet *J, cns_error *err)
{
    const mpfr_prec_t prec = J->spec.prec + 64;
    cns_arith_spec spec = {.series = J->p->n_nodes + 1, .order = 1, .prec = prec};
    cns_arith *target = J->A;
    int *series = J->series;
    cns_code code = CNS_OK;

    J->A = cns_arith_mpfr.create(&spec, err);
    J->series = malloc(((size_t)J->p->n_nodes + 1) * sizeof *J->series);
    if (!J->A || !J->series) {
        code = cns_out_of_memory(err);
    } else {
        mpfr_set_prec(J->x, prec);
        J->ops = &cns_arith_mpfr;
        for (int v = 0; v < J->p->n_nodes; v++)
            J->series[v] = v;
        for (int v = 0; v < J->p->n_nodes && !code; v++)
            if (J->p->node[v].constant)
                code = cns_operation_of(J, v)->recurrence(J, v, 0, err);
        for (int v = 0; v < J->p->n_nodes && !code; v++)
            if (J->p->node[v].constant) {
                J->ops->get(J->A, J->x, v, 0);
                if (!mpfr_number_p(J->x))
                    code = cns_fail(err, CNS_NUMERIC, "a constant of the model is not a finite number");
                J->spec.ops->set(target, series[v], 0, J->x, true);
                J->constant_zero[v] = mpfr_zero_p(J->x) != 0;
            }
        mpfr_set_prec(J->x, J->spec.prec);
    }
    if (J->A)
        cns_arith_mpfr.destroy(J->A);
    free(J->series);
    J->A = target;
    J->series = series;
    J->ops = J->spec.ops;
    return code;
}

/* eps < 2^-(2/3 prec + 16). */
bool cns_jet_is_sharp(const cns_program *p, mpfr_prec_t prec)
{
    mpfr_t eps;
    if (!p->is_smooth)
        return false;
    mpfr_init2(eps, 53);
    cns_number_get_mpfr(eps, &p->smooth);
    bool sharp = mpfr_get_exp(eps) < -(2 * prec / 3 + 16);
    mpfr_clear(eps);
    return sharp;
}

cns_jet *cns_jet_new(const cns_jet_spec *spec, cns_error *err)
{
    const cns_program *p = spec->program;
    size_t n = (size_t)p->n_nodes + 1;
    cns_jet *J = calloc(1, sizeof *J);
    if (!J) {
        cns_out_of_memory(err);
        return NULL;
    }
    J->spec = *spec;
    J->p = p;
    J->ops = spec->ops;
    mpfr_inits2(spec->prec, J->x, J->y, J->z, (mpfr_ptr)0);
    J->series = malloc(n * sizeof *J->series);
    J->plan = malloc(n * sizeof *J->plan);
    J->state_series = malloc(((size_t)p->n_states + 1) * sizeof *J->state_series);
    J->sign = calloc(n, sizeof *J->sign);
    J->held = calloc(n, sizeof *J->held);
    J->vanishes = calloc(n, sizeof *J->vanishes);
    J->constant_zero = calloc(n, sizeof *J->constant_zero);
    J->at_zero = calloc(n, sizeof *J->at_zero);
    J->state_vanishes = calloc((size_t)p->n_states + 1, sizeof *J->state_vanishes);
    J->state_known = calloc((size_t)p->n_states + 1, sizeof *J->state_known);
    J->val = calloc(n, sizeof *J->val);
    J->known = calloc(n, sizeof *J->known);
    J->recorder = cns_recorder_new();
    J->traced_for = calloc(3 * n + (size_t)p->n_states, sizeof *J->traced_for);
    if (!J->series || !J->plan || !J->state_series || !J->sign || !J->held || !J->vanishes ||
        !J->constant_zero || !J->at_zero || !J->state_vanishes || !J->state_known || !J->val || !J->known ||
        !J->recorder || !J->traced_for) {
        cns_out_of_memory(err);
        cns_jet_free(J);
        return NULL;
    }
    int series = 0;
    for (int i = 0; i < p->n_states; i++)
        J->state_series[i] = series++;
    for (int v = 0; v < p->n_nodes; v++) {
        const cns_program_node *node = &p->node[v];
        bool wanted = node->constant || ((node->needed || spec->outputs) && (spec->outputs || !node->folded));
        if (node->op == CNS_OP_STATE) {
            J->series[v] = J->state_series[node->index];
            continue;
        }
        J->series[v] = wanted ? series++ : -1;
        if (wanted && !node->constant)
            J->plan[J->n_plan++] = v;
    }
    J->sharp = cns_jet_is_sharp(p, spec->sharp_prec ? spec->sharp_prec : spec->prec);
    J->registers_from = series;
    cns_arith_spec arith = {.series = series + spec->registers,
                            .order = spec->order + CNS_LOOKAHEAD,
                            .prec = spec->prec,
                            .kernel = spec->kernel};
    J->A = J->ops->create(&arith, err);
    if (!J->A || compute_constants(J, err)) {
        cns_jet_free(J);
        return NULL;
    }
    return J;
}

void cns_jet_free(cns_jet *J)
{
    if (!J)
        return;
    if (J->A)
        J->ops->destroy(J->A);
    mpfr_clears(J->x, J->y, J->z, (mpfr_ptr)0);
    free(J->series);
    free(J->plan);
    free(J->state_series);
    free(J->sign);
    free(J->held);
    free(J->vanishes);
    free(J->constant_zero);
    free(J->at_zero);
    free(J->state_vanishes);
    free(J->state_known);
    free(J->val);
    free(J->known);
    cns_recorder_free(J->recorder);
    free(J->traced_for);
    free(J);
}

size_t cns_jet_bytes(const cns_jet *J)
{
    return J ? J->ops->bytes(J->A) : 0;
}

void cns_jet_begin(cns_jet *J, double H)
{
    J->ops->begin(J->A, H);
    memset(J->at_zero, 0, (size_t)J->p->n_nodes * sizeof *J->at_zero);
}

void cns_jet_set_state(cns_jet *J, int i, const mpfr_t x)
{
    J->ops->set(J->A, J->state_series[i], 0, x, false);
}

/* Which nodes vanish identically. States that are exactly zero stay zero if their derivatives vanish as long
 * as they do: the solution is on an invariant line or plane of the system. Begins with all states that are
 * zero, and takes those out whose derivative does not vanish, until none is left to take out. */
static void find_vanishing(cns_jet *J)
{
    const cns_program *p = J->p;
    long e;
    bool candidates = false, changed = true;
    memset(J->vanishes, 0, (size_t)p->n_nodes * sizeof *J->vanishes);
    for (int i = 0; i < p->n_states; i++) {
        J->state_vanishes[i] = J->ops->get_2exp(J->A, &e, J->state_series[i], 0) == 0;
        candidates = candidates || J->state_vanishes[i];
    }
    for (int v = 0; v < p->n_nodes && !candidates; v++)
        candidates = J->constant_zero[v];
    if (!candidates)
        return;
    while (changed) {
        for (int v = 0; v < p->n_nodes; v++)
            J->vanishes[v] =
                p->node[v].constant ? J->constant_zero[v] : cns_operation_of(J, v)->vanishes(J, v);
        changed = false;
        for (int i = 0; i < p->n_states; i++)
            if (J->state_vanishes[i] && !J->vanishes[p->derivative[i]] &&
                !(p->factor[i] >= 0 && J->constant_zero[p->factor[i]])) {
                J->state_vanishes[i] = false;
                changed = true;
            }
    }
}

/* The nodes that vanish while the states of J->state_vanishes do; the derivative of a constant does. */
static void spread_vanishing(cns_jet *J, const bool *constant)
{
    const cns_program *p = J->p;
    for (int v = 0; v < p->n_nodes; v++) {
        J->vanishes[v] = p->node[v].constant ? J->constant_zero[v] : cns_operation_of(J, v)->vanishes(J, v);
        for (int i = 0; i < p->n_states; i++)
            J->vanishes[v] = J->vanishes[v] || (constant[i] && p->derivative[i] == v);
    }
}

void cns_jet_constants(cns_jet *J, bool *constant, bool *zero_output)
{
    const cns_program *p = J->p;
    for (int i = 0; i < p->n_states; i++)
        J->state_vanishes[i] = cns_is_zero(J, J->state_series[i], 0);
    for (bool changed = true; changed;) {
        changed = false;
        spread_vanishing(J, constant);
        for (int i = 0; i < p->n_states; i++)
            if (J->state_vanishes[i] && !constant[i] && !J->vanishes[p->derivative[i]]) {
                J->state_vanishes[i] = false;
                changed = true;
            }
    }
    for (int i = 0; i < p->n_states; i++)
        constant[i] = constant[i] || J->vanishes[p->derivative[i]];
    for (int i = 0; i < p->n_outputs; i++)
        zero_output[i] = J->vanishes[p->output[i]];
}

void cns_jet_next_state(cns_jet *J, int i, int k)
{
    int factor = J->p->factor[i];
    J->ops->zero(J->A);
    if (!J->state_vanishes[i])
        cns_accumulate(J, 1, J->p->derivative[i], k);
    J->ops->store_next(J->A, J->state_series[i], k, factor < 0 ? -1 : J->series[factor]);
}

static cns_code compose_order(cns_jet *J, int k, cns_error *err)
{
    for (int i = 0; i < J->n_plan; i++) {
        int v = J->plan[i];
        cns_code code = J->vanishes[v] ? CNS_OK : cns_operation_of(J, v)->recurrence(J, v, k, err);
        if (code)
            return code;
    }
    return CNS_OK;
}

static cns_code next_order(cns_jet *J, int k, cns_error *err)
{
    cns_code code = compose_order(J, k, err);
    for (int i = 0; i < J->p->n_states && !code; i++)
        cns_jet_next_state(J, i, k);
    return code;
}

/* Are the arrays that the trace depends on as they were? Keeps them as they are now. */
static bool trace_holds(cns_jet *J)
{
    const size_t nodes = (size_t)J->p->n_nodes, states = (size_t)J->p->n_states;
    const void *const now[] = {J->sign, J->held, J->vanishes, J->state_vanishes};
    const size_t size[] = {nodes, nodes, nodes, states};
    signed char *then = J->traced_for;
    bool same = true;
    for (int i = 0; i < 4; then += size[i++]) {
        same = same && !memcmp(then, now[i], size[i]);
        memcpy(then, now[i], size[i]);
    }
    return same;
}

/* Records orders k and k + 1, by the recurrences themselves, as the trace. False: they look at values still,
 * as of an abs() whose sign is not decided. */
static bool trace_orders(cns_jet *J, int k)
{
    cns_error ignored;
    if (trace_holds(J) && J->traced)
        return true;
    cns_arith *const A = J->A;
    const cns_arith_ops *const ops = J->ops;
    J->A = J->recorder;
    J->ops = &cns_arith_recorder;
    cns_recorder_clear(J->recorder);
    J->traced = !next_order(J, k, &ignored) && !next_order(J, k + 1, &ignored) &&
                cns_recorder_trace(J->recorder, k, &J->trace);
    J->A = A;
    J->ops = ops;
    return J->traced;
}

static cns_code expand_regular(cns_jet *J, int order, cns_error *err)
{
    for (int k = 0; k < order; k++) {
        if (J->ops->orders && k >= FIRST_REPEATED && trace_orders(J, k)) {
            if (!J->ops->orders(J->A, &J->trace, k, order))
                return cns_fail(err, CNS_NUMERIC, "the coefficients are out of range");
            break;
        }
        cns_code code = next_order(J, k, err);
        if (code)
            return code;
        if (k % 8 == 7 && J->ops->in_steps && J->ops->noise_log2(J->A) == HUGE_VAL)
            return cns_fail(err, CNS_NUMERIC, "the coefficients are out of range");
    }
    J->order = order;
    return CNS_OK;
}

static cns_code expand(cns_jet *J, int order, cns_error *err)
{
    const cns_program *p = J->p;
    cns_error regular;
    memset(J->sign, 0, (size_t)p->n_nodes * sizeof *J->sign);
    memset(J->val, 0, (size_t)p->n_nodes * sizeof *J->val);
    J->singular = J->sign_late = false;
    if (!expand_regular(J, order, &regular))
        return CNS_OK;
    if (J->ops->in_steps) /* leading zeros make steep series, which fixed point holds badly */
        return cns_fail(err, CNS_NUMERIC, "%s", regular.text);
    J->singular = true;
    J->sign_late = false;
    return cns_jet_expand_singular(J, order, err);
}

/* Where u is zero at t0, the sign that abs(u) holds is known only when the first coefficient of u that is not
 * zero is, but the tangent of abs(u) needs it from order 0 on. So there are several passes, each with the
 * signs that the one before found, until they stay. */
cns_code cns_jet_expand(cns_jet *J, int order, cns_error *err)
{
    const size_t bytes = (size_t)J->p->n_nodes * sizeof *J->sign;
    find_vanishing(J);
    memset(J->held, 0, bytes);
    for (int pass = 0;; pass++) {
        cns_code code = expand(J, order, err);
        bool same = !memcmp(J->held, J->sign, bytes);
        if (code || pass > J->p->n_watch || (same && pass > 0) || (!J->sign_late && pass == 0))
            return code;
        memcpy(J->held, J->sign, bytes);
    }
}

void cns_jet_set_coefficient(cns_jet *J, int state, int k, const mpfr_t x)
{
    J->ops->set(J->A, J->state_series[state], k, x, false);
}

cns_code cns_jet_compose(cns_jet *J, int k, cns_error *err)
{
    const size_t n = (size_t)J->p->n_nodes;
    if (k > 0)
        return compose_order(J, k, err);
    memset(J->sign, 0, n * sizeof *J->sign);
    memset(J->val, 0, n * sizeof *J->val);
    memset(J->at_zero, 0, n * sizeof *J->at_zero);
    for (size_t v = 0; v < n; v++)
        J->vanishes[v] = J->constant_zero[v];
    J->singular = false;
    cns_code code = compose_order(J, 0, err);
    if (code || !cns_jet_lies_on_kinks(J))
        return code;
    memset(J->sign, 0, n * sizeof *J->sign);
    return compose_order(J, 0, err);
}

void cns_jet_composed(cns_jet *J, mpfr_t y, int state, int k)
{
    int factor = J->p->factor[state], scratch = cns_jet_register(J, 0);
    J->ops->zero(J->A);
    cns_accumulate(J, 1, J->p->derivative[state], k);
    if (factor < 0)
        J->ops->store(J->A, scratch, k);
    else
        J->ops->store_scaled(J->A, scratch, k, J->series[factor]);
    J->ops->get(J->A, y, scratch, k);
}

bool cns_jet_record(cns_jet *J, cns_arith *straight)
{
    cns_error ignored;
    cns_arith *const A = J->A;
    const cns_arith_ops *const ops = J->ops;
    cns_straight_begin(straight, ops, A);
    J->A = straight;
    J->ops = &cns_arith_straight;
    const cns_code code = cns_jet_expand(J, 1, &ignored);
    J->A = A;
    J->ops = ops;
    return !code && !J->singular && cns_straight_compile(straight);
}

int cns_jet_series(const cns_jet *J)
{
    return J->registers_from;
}

int cns_jet_order(const cns_jet *J)
{
    return J->order;
}

void cns_jet_coefficient(const cns_jet *J, mpfr_t y, int state, int k)
{
    J->ops->get(J->A, y, J->state_series[state], k);
}

double cns_jet_coefficient_2exp(const cns_jet *J, long *e, int state, int k)
{
    return J->ops->get_2exp(J->A, e, J->state_series[state], k);
}

void cns_jet_sum(const cns_jet *J, mpfr_t y, int state, const mpfr_t tau)
{
    enum { MORE_BITS = 64 };
    if (J->state_vanishes[state]) {
        mpfr_set_zero(y, 1);
        return;
    }
    if (J->ops->sum) {
        J->ops->sum(J->A, y, J->state_series[state], J->order, tau);
        return;
    }
    mpfr_t sum, c;
    mpfr_inits2(J->spec.prec + MORE_BITS, sum, c, (mpfr_ptr)0);
    J->ops->get(J->A, sum, J->state_series[state], J->order);
    for (int k = J->order - 1; k >= 0; k--) {
        J->ops->get(J->A, c, J->state_series[state], k);
        mpfr_mul(sum, sum, tau, MPFR_RNDN);
        mpfr_add(sum, sum, c, MPFR_RNDN);
    }
    mpfr_set(y, sum, MPFR_RNDN);
    mpfr_clears(sum, c, (mpfr_ptr)0);
}

bool cns_jet_output(const cns_jet *J, mpfr_t y, int output)
{
    int v = J->p->output[output];
    if (J->vanishes[v])
        mpfr_set_zero(y, 1);
    else if (J->singular && J->known[v] < 1)
        return false;
    else
        J->ops->get(J->A, y, J->series[v], 0);
    return mpfr_number_p(y) != 0;
}

const cns_arith_ops *cns_jet_ops(const cns_jet *J)
{
    return J->ops;
}

cns_arith *cns_jet_arith(const cns_jet *J)
{
    return J->A;
}

int cns_jet_state_series(const cns_jet *J, int i)
{
    return J->state_series[i];
}

int cns_jet_register(const cns_jet *J, int r)
{
    return J->registers_from + r;
}
