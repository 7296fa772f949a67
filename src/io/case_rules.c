/* Rules between keys: what must be given, what excludes what, and values that follow from those of others. */
#include "case_internal.h"
#include "core/text.h"
#include "integrate/numerics.h"

#define TEXT_OF(x)  #x
#define TEXT_OF2(x) TEXT_OF(x)
#define LIMIT_STEPS 1e15 /* of a fixed step up to the end: a month of the fastest is far below */

static const cns_key *key(cns_key_id id)
{
    return &cns_keys[id];
}

/* Where the key stands in the file; NULL: nowhere. */
static const cns_yaml_node *node_of(const cns_case_reader *r, const cns_key *k)
{
    return r->seen[k - cns_keys].node;
}

static bool present(const cns_case_reader *r, cns_key_id id)
{
    return node_of(r, key(id)) != NULL;
}

/* Present, and as its row allows. */
static bool given(const cns_case_reader *r, cns_key_id id)
{
    return r->seen[id].good;
}

/* Where a fault about a key is shown: at its value, else at its section, else at the top. */
static cns_mark place_of(const cns_case_reader *r, cns_key_id id)
{
    const cns_key *k = key(id);
    if (node_of(r, k) != NULL)
        return node_of(r, k)->mark;
    while ((k = cns_key_section(k)) != NULL)
        if (node_of(r, k) != NULL)
            return node_of(r, k)->key_mark;
    return r->root->mark;
}

/* Where a fault is shown that the key itself is, whatever its value; it is present. */
static cns_mark key_place(const cns_case_reader *r, cns_key_id id)
{
    return node_of(r, key(id))->key_mark;
}

/* Was the section begun on the command line, as when it takes the place of another one? */
static bool begun_by_override(const cns_case_reader *r, cns_key_id section)
{
    return key_place(r, section).set >= 0;
}

static void require(cns_case_reader *r, cns_key_id id)
{
    const cns_key *k = key(id);
    if (!present(r, id))
        cns_faults_add(&r->faults, place_of(r, id), "missing key %s%s%s", cns_key_title(k).text,
                       cns_key_section(k) != NULL ? ": " : "",
                       cns_key_section(k) != NULL ? cns_key_range(k).text : "");
}

/* Is end / part > limit? To 128 bits. */
static bool quotient_above(const cns_number *end, const cns_number *part, double limit)
{
    mpfr_t q, d;
    mpfr_init2(q, 128);
    mpfr_init2(d, 128);
    cns_number_get_mpfr(q, end);
    cns_number_get_mpfr(d, part);
    mpfr_div(q, q, d, MPFR_RNDN);
    const bool above = mpfr_cmp_d(q, limit) > 0;
    mpfr_clear(q);
    mpfr_clear(d);
    return above;
}

static void parameters_without_default(cns_case_reader *r)
{
    const cns_model *m = r->c->model;
    const cns_yaml_node *node = node_of(r, key(K_PARAMETERS));
    for (int i = 0; m != NULL && i < m->n_parameters; i++)
        if (m->parameters[i].standard == NULL && cns_yaml_find(node, m->parameters[i].name) == NULL)
            cns_faults_add(&r->faults, node != NULL ? node->key_mark : r->root->mark,
                           "missing parameter '%s': model %s has no default for it", m->parameters[i].name,
                           m->name);
}

/* Times of rows must go away from the start, in one direction. */
static bool list_of_times(cns_case_reader *r)
{
    cns_case *c = r->c;
    const cns_key_id other = present(r, K_TIME_END) ? K_TIME_END : K_TIME_EVERY;
    if (present(r, other))
        cns_faults_add(&r->faults, key_place(r, other),
                       "%s does not go with 'at', which lists the times of all rows",
                       cns_key_title(key(other)).text);
    if (!given(r, K_TIME_AT))
        return false;
    const int way = cns_number_cmp(&c->at[c->n_at - 1], &c->start);
    const cns_number *before = &c->start;
    for (int i = 0; i < c->n_at; i++) {
        const int order = cns_number_cmp(&c->at[i], before);
        if (way == 0 || (order != way && (i > 0 || order != 0))) {
            cns_faults_add(&r->faults, place_of(r, K_TIME_AT),
                           "the times of 'at' must go away from the start in one direction: %s does not",
                           cns_quote(c->at[i].text).text);
            return false;
        }
        before = &c->at[i];
    }
    cns_number_set(&c->end, before);
    return true;
}

static void rows_of_table(cns_case_reader *r)
{
    cns_case *c = r->c;
    const bool listed = present(r, K_TIME_AT);
    if (!r->seen[K_TIME].good)
        return;
    if (!listed)
        require(r, K_TIME_END);
    if (listed ? !list_of_times(r) : !given(r, K_TIME_END))
        return;
    cns_number_set(&c->span, &c->end);
    mpq_sub(c->span.ratio, c->end.ratio, c->start.ratio);
    c->backwards = mpq_sgn(c->span.ratio) < 0;
    mpq_abs(c->span.ratio, c->span.ratio);
    if (mpq_sgn(c->span.ratio) == 0)
        cns_faults_add(&r->faults, place_of(r, K_TIME_END), "'end' in 'time' must differ from the start, %s",
                       cns_quote(c->start.text).text);
    if (!given(r, K_TIME_EVERY))
        cns_number_set(&c->every, &c->span);
    if (quotient_above(&c->span, &c->every, CNS_CASE_MAX_ROWS))
        cns_faults_add(&r->faults, place_of(r, K_TIME_EVERY),
                       "'every' in 'time' makes more than %d rows up to the end", CNS_CASE_MAX_ROWS);
}

static void goal_or_numerics(cns_case_reader *r)
{
    if (!present(r, K_GOAL) || !present(r, K_NUMERICS))
        return;
    const cns_mark goal = key_place(r, K_GOAL), numerics = key_place(r, K_NUMERICS);
    cns_faults_add(&r->faults, cns_mark_order(goal, numerics) > 0 ? goal : numerics,
                   "'goal' and 'numerics' exclude each other: keep one");
}

static void goal(cns_case_reader *r)
{
    const cns_goal *g = &r->c->goal;
    const bool significant = present(r, K_GOAL_SIGNIFICANT);
    const cns_key_id asked = significant ? K_GOAL_SIGNIFICANT : K_GOAL_DECIMALS;
    if (!given(r, K_GOAL))
        return;
    if (!present(r, asked))
        cns_faults_add(&r->faults, key_place(r, K_GOAL),
                       "missing key in 'goal': 'decimals' or 'significant'%s",
                       begun_by_override(r, K_GOAL) ? "; add --set goal.decimals=10" : "");
    else if (significant && present(r, K_GOAL_DECIMALS))
        cns_faults_add(&r->faults, key_place(r, asked),
                       "'goal' takes either 'decimals' or 'significant', not both");
    const bool limit_good = given(r, K_GOAL_MAX_DIGITS) || !present(r, K_GOAL_MAX_DIGITS);
    if (given(r, asked) && limit_good && cns_key_get(key(asked), r->c) > g->max_digits)
        cns_faults_add(&r->faults, place_of(r, asked), "%s is above 'max_digits' (%ld%s)",
                       cns_key_title(key(asked)).text, g->max_digits,
                       given(r, K_GOAL_MAX_DIGITS) ? "" : ", its default");
}

/* The order that Runge-Kutta's method has, for a key that may ask for none or for just that. */
static long order_of_rk4(cns_case_reader *r, cns_key_id id, long order)
{
    if (order != 0 && order != 4)
        cns_faults_add(&r->faults, place_of(r, id), "'order' of 'method: rk4' is 4 (or auto)");
    return 4;
}

static void no_digits_in_double(cns_case_reader *r, cns_key_id id)
{
    cns_faults_add(&r->faults, key_place(r, id),
                   "'digits' does not go with 'arithmetic: double', which has its own 53 bits");
}

/* Keys without which the numerics are not known: each where it is missing in a file, and all at once, with
 * what to type, on a command line. */
static void missing_numerics(cns_case_reader *r, bool digits, bool step)
{
    if (begun_by_override(r, K_NUMERICS)) {
        if (digits || step)
            cns_faults_add(&r->faults, key_place(r, K_NUMERICS), "missing in 'numerics': %s%s%s; add%s%s",
                           digits ? "'digits'" : "", digits && step ? " and " : "",
                           step ? "a fixed 'step'" : "", digits ? " --set numerics.digits=40" : "",
                           step ? " --set numerics.step=1e-3" : "");
        return;
    }
    if (digits)
        require(r, K_NUMERICS_DIGITS);
    if (step)
        cns_faults_add(&r->faults, place_of(r, K_NUMERICS_STEP),
                       "'method: rk4' needs a fixed 'step', such as 1e-3");
}

static void numerics(cns_case_reader *r)
{
    cns_numerics *n = &r->c->numerics;
    if (!given(r, K_NUMERICS))
        return;
    if (!given(r, K_NUMERICS_ARITHMETIC))
        n->arithmetic = n->method == CNS_METHOD_RK4 ? CNS_ARITH_MPFR : CNS_ARITH_FAST;
    const bool fixed_step = cns_number_sign(&n->step) > 0;
    /* After a bad method or arithmetic, rules about it would only mislead. */
    const bool method_known = given(r, K_NUMERICS_METHOD) || !present(r, K_NUMERICS_METHOD);
    const bool known = given(r, K_NUMERICS_ARITHMETIC) || !present(r, K_NUMERICS_ARITHMETIC);
    const bool in_double = known && n->arithmetic == CNS_ARITH_DOUBLE;
    if (in_double && present(r, K_NUMERICS_DIGITS))
        no_digits_in_double(r, K_NUMERICS_DIGITS);
    missing_numerics(r, known && method_known && !in_double && !present(r, K_NUMERICS_DIGITS),
                     n->method == CNS_METHOD_RK4 && !present(r, K_NUMERICS_STEP));
    if (n->method == CNS_METHOD_RK4) {
        if (given(r, K_NUMERICS_STEP) && !fixed_step)
            cns_faults_add(&r->faults, place_of(r, K_NUMERICS_STEP),
                           "'method: rk4' needs a fixed 'step', such as 1e-3");
        if (known && n->arithmetic == CNS_ARITH_FAST)
            cns_faults_add(&r->faults, place_of(r, K_NUMERICS_ARITHMETIC),
                           "'method: rk4' computes in mpfr or double");
        n->order = order_of_rk4(r, K_NUMERICS_ORDER, n->order);
        if (cns_number_sign(&n->tolerance) > 0)
            cns_faults_add(&r->faults, key_place(r, K_NUMERICS_TOLERANCE),
                           "'tolerance' does not go with 'method: rk4', whose step is fixed");
    } else if (method_known && in_double && n->order > CNS_DOUBLE_MAX_ORDER) {
        cns_faults_add(&r->faults, place_of(r, K_NUMERICS_ORDER),
                       "'order' is at most %d with 'arithmetic: double'", CNS_DOUBLE_MAX_ORDER);
    }
    if (fixed_step && cns_number_sign(&r->c->span) > 0 && quotient_above(&r->c->span, &n->step, LIMIT_STEPS))
        cns_faults_add(&r->faults, place_of(r, K_NUMERICS_STEP),
                       "'step' makes more than " TEXT_OF2(LIMIT_STEPS) " steps up to the end");
}

/* Two ends of a range: numbers must differ, integers may be the same. */
static void ends(cns_case_reader *r, cns_key_id from, cns_key_id to, bool upwards)
{
    const cns_key *a = key(from), *b = key(to);
    if (!given(r, from) || !given(r, to))
        return;
    const bool integers = a->kind == KEY_INTEGER;
    const long x = cns_key_get(a, r->c), y = cns_key_get(b, r->c);
    const int order =
        integers ? (x > y) - (x < y) : cns_number_cmp(cns_key_field(a, r->c), cns_key_field(b, r->c));
    if (order == (upwards ? 1 : -1) || (order == 0 && !integers))
        cns_faults_add(&r->faults, place_of(r, to), "%s must be %s %s", cns_key_title(b).text,
                       upwards ? "above" : "below", cns_key_title(a).text);
}

static void laws(cns_case_reader *r)
{
    cns_laws_spec *l = &r->c->laws;
    ends(r, K_LAWS_DIGITS_FROM, K_LAWS_DIGITS_TO, true);
    if (l->has_steps && l->steps.method == CNS_METHOD_RK4)
        l->steps.order = order_of_rk4(r, K_LAWS_STEPS_ORDER, l->steps.order);
    ends(r, K_LAWS_STEPS_FROM, K_LAWS_STEPS_TO, false);
    ends(r, K_LAWS_SMOOTHING_FROM, K_LAWS_SMOOTHING_TO, false);
}

static void lyapunov(cns_case_reader *r)
{
    cns_lyapunov_spec *l = &r->c->lyapunov;
    if (l->arithmetic != CNS_ARITH_DOUBLE)
        return;
    l->digits = 0;
    if (given(r, K_LYAPUNOV_DIGITS))
        no_digits_in_double(r, K_LYAPUNOV_DIGITS);
}

static void bisect(cns_case_reader *r)
{
    static const cns_key_id bracket[] = {K_BISECT_LOWER, K_BISECT_UPPER};
    const cns_case *c = r->c;
    ends(r, bracket[0], bracket[1], true);
    if (!given(r, K_BISECT_PARAMETER))
        return;
    const char *minimum = c->model->parameters[c->bisect.parameter].minimum;
    for (int i = 0; i < 2; i++)
        if (given(r, bracket[i]) &&
            !cns_case_within(i == 0 ? &c->bisect.lower : &c->bisect.upper, minimum, NULL))
            cns_faults_add(&r->faults, place_of(r, bracket[i]), "%s must be > %s for model %s",
                           cns_key_title(key(bracket[i])).text, minimum, c->model->name);
}

void cns_case_apply_rules(cns_case_reader *r)
{
    parameters_without_default(r);
    laws(r);
    for (cns_key_id id = 0; id < CNS_KEYS; id++) {
        const cns_key *section = cns_key_section(key(id));
        if (key(id)->required && (section == NULL || r->seen[section - cns_keys].good))
            require(r, id);
    }
    rows_of_table(r);
    if (r->c->smooth)
        require(r, K_ABS_SMOOTH);
    goal_or_numerics(r);
    goal(r);
    numerics(r);
    lyapunov(r);
    bisect(r);
}
