/* The Taylor method: jet, step from the last coefficients, kinks, evaluation.
 *
 * A series is in tau = (t - t0)/H. The fast arithmetic keeps all coefficients of a series with one exponent,
 * and so wants them to fall slowly and evenly: for it H is about the length of the step, guessed before the
 * expansion. For the other arithmetics H = 1. What is called tau here is in units of H, what is called h or t
 * in the unit of time. */
#include <math.h>
#include <stdlib.h>

#include "method.h"
#include "num/logs.h"
#include "numerics.h"
#include "roots.h"

struct cns_stepper {
    cns_flow_spec spec;
    int n;
    cns_jet *jet;     /* the one expanded last: plain or fast */
    cns_jet *plain;   /* H = 1; if there is a fast one, made when that does not fit for the first time */
    cns_jet *fast;    /* NULL: the arithmetic needs no H */
    cns_jet *scout;   /* in double, to guess the first H */
    double H;         /* of the last expansion */
    double next_log2; /* the next H, log2: a guess at the next step; HUGE_VAL: there is none */
    mpfr_prec_t prec; /* of this step, with its tolerance and order: the spec's, or the schedule's */
    double tolerance_log2;
    int order_asked;
    int order;    /* of the last expansion */
    mpfr_t *poly; /* its coefficients, spec.order + 1 per state, once loaded */
    bool loaded;
    mpfr_t *watch;   /* the same of one watched quantity: what stands under an abs or a root (taylor/jet.h) */
    bool *landed_on; /* watched quantities on whose zeros the last step ended */
    mpfr_t tau, root, sum, term;
    double noise_log2;
};

enum {
    TESTED = 4, /* coefficients that choose the step */
    MAX_STEP_LOG2 = 10,
    SCOUT_ORDER = 24,
    /* Of the fast arithmetic, beyond the flow's precision: the one exponent of a series is that of its
     * largest coefficient, which may be above the state's own, and divisions lose some. */
    FAST_GUARD_BITS = 40,
    NOISE_BITS = 10, /* what the noise of the fast arithmetic may take of the 16 guard bits (numerics.c) */
    FAST_TRIES = 5,  /* with H halved each time */
    /* The guess at the next step is at most 2^4 of this one. Where the last coefficients fall faster than
     * that they sink into the noise of the fixed point, and do not tell how much longer a step could be. */
    MAX_GAIN_LOG2 = 4,
    LEAST_DIGITS = 8, /* that a schedule may ask for */
    MOST_DECAY = 3,   /* bits per order by which the fast arithmetic can let coefficients fall */
    MANTISSA = 24     /* bits of H and of adaptive steps: few, so that time stays exact */
};

static void destroy(cns_stepper *s)
{
    if (!s)
        return;
    cns_jet_free(s->plain);
    cns_jet_free(s->fast);
    cns_jet_free(s->scout);
    cns_vector_free(s->poly);
    cns_vector_free(s->watch);
    free(s->landed_on);
    mpfr_clears(s->tau, s->root, s->sum, s->term, (mpfr_ptr)0);
    free(s);
}

static cns_jet *new_jet(const cns_stepper *s, const cns_arith_ops *ops, int order, mpfr_prec_t prec,
                        cns_error *err)
{
    cns_jet_spec jet = {
        .program = s->spec.program, .ops = ops, .order = order, .prec = prec, .kernel = s->spec.kernel};
    return cns_jet_new(&jet, err);
}

static cns_stepper *create(const cns_flow_spec *spec, cns_error *err)
{
    const cns_arith_ops *ops = cns_flow_arith(spec);
    cns_stepper *s = calloc(1, sizeof *s);
    if (!s) {
        cns_out_of_memory(err);
        return NULL;
    }
    s->spec = *spec;
    s->n = cns_program_states(spec->program);
    mpfr_inits2(spec->prec, s->tau, s->root, s->sum, s->term, (mpfr_ptr)0);
    cns_error why = {0};
    if (ops->in_steps) {
        s->fast = new_jet(s, ops, spec->order, spec->prec + FAST_GUARD_BITS, &why);
        s->jet = s->fast;
    }
    /* Also where the fast one does not fit; not where there is no memory for it, or no such kernel. */
    if (!s->jet && why.code != CNS_MEMORY && why.code != CNS_USAGE)
        s->jet = s->plain = new_jet(s, cns_flow_reference_arith(spec), spec->order, spec->prec, &why);
    if (s->jet && ops->in_steps)
        s->scout = new_jet(s, &cns_arith_double, SCOUT_ORDER, 53, &why);
    if (!s->jet || (ops->in_steps && !s->scout)) {
        cns_fail(err, why.code, "%s", why.text);
        destroy(s);
        return NULL;
    }
    s->poly = cns_vector_new(s->n * (spec->order + 1), spec->prec);
    s->watch = cns_vector_new(spec->order + 1, spec->prec);
    s->landed_on = calloc((size_t)cns_jet_watched(s->jet) + 1, sizeof *s->landed_on);
    if (!s->poly || !s->watch || !s->landed_on) {
        cns_out_of_memory(err);
        destroy(s);
        return NULL;
    }
    return s;
}

/* Tells the fast arithmetic by how many whole bits per order coefficients will fall: as many as reach the
 * tolerance at the end of the series, and no sooner than two or three orders before it. */
static void set_decay(cns_stepper *s)
{
    const cns_arith_ops *ops = cns_flow_arith(&s->spec);
    if (s->fast && ops->set_decay)
        ops->set_decay(cns_jet_arith(s->fast), -s->tolerance_log2 >= MOST_DECAY * (s->order_asked - 2.5)
                                                   ? MOST_DECAY
                                               : -s->tolerance_log2 >= 2.1 * (s->order_asked - 2.5) ? 2
                                                                                                    : 1);
}

static void start(cns_stepper *s)
{
    for (int w = 0; w < cns_jet_watched(s->jet); w++)
        s->landed_on[w] = false;
    s->next_log2 = HUGE_VAL;
    s->prec = s->spec.prec;
    s->tolerance_log2 = s->spec.tolerance_log2;
    s->order_asked = s->spec.order;
    set_decay(s);
}

static size_t bytes(const cns_stepper *s)
{
    return cns_jet_bytes(s->plain) + cns_jet_bytes(s->fast) + cns_jet_bytes(s->scout) +
           cns_vector_bytes((s->n + 1) * (s->spec.order + 1), s->spec.prec);
}

static mpfr_t *coefficients(cns_stepper *s, int i)
{
    return s->poly + (size_t)i * ((size_t)s->spec.order + 1);
}

/* log2 of the largest |x_{i,k}| / scale_i over the dynamic states; false if all are zero. Passive states
 * do not steer steps, unless there are no others. */
static bool norm_log2(const cns_stepper *s, int k, double *log2_norm)
{
    bool any = false, passive_too = true;
    for (int i = 0; i < s->n; i++)
        if (cns_program_is_dynamic(s->spec.program, i))
            passive_too = false;
    for (int i = 0; i < s->n; i++) {
        long e;
        if (!passive_too && !cns_program_is_dynamic(s->spec.program, i))
            continue;
        double m = fabs(cns_jet_coefficient_2exp(s->jet, &e, i, k) / s->spec.scales[i]);
        if (m == 0)
            continue;
        double l = cns_log2_2exp(m, e);
        if (!any || l > *log2_norm)
            *log2_norm = l;
        any = true;
    }
    return any;
}

/* The last four coefficients of a series, or as many as half of a short one has. */
static int first_tested(int order)
{
    int tested = order / 2 < TESTED ? (order + 1) / 2 : TESTED;
    return order - tested + 1;
}

/* log2 of Jorba and Zou's step from the last coefficients of a series of this order, which may be lower than
 * the last expansion's. Four coefficients, since parity may make every second one vanish: the largest tau
 * with |x_k| tau^k <= tolerance for each. */
static double largest_log2(const cns_stepper *s, double tolerance_log2, int order)
{
    double best = MAX_STEP_LOG2, l;
    for (int k = first_tested(order); k <= order; k++)
        if (norm_log2(s, k, &l) && (tolerance_log2 - l) / k < best)
            best = (tolerance_log2 - l) / k;
    return best;
}

static double allowed_log2(const cns_stepper *s)
{
    return largest_log2(s, s->tolerance_log2, s->order) - s->spec.safety - 1.0 / s->order;
}

/* log2 of the truncation error at tau: the last coefficients' largest term. */
static double truncation_log2(const cns_stepper *s, double tau_log2)
{
    double worst = -HUGE_VAL, l;
    for (int k = first_tested(s->order); k <= s->order; k++)
        if (norm_log2(s, k, &l) && l + k * tau_log2 > worst)
            worst = l + k * tau_log2;
    return worst;
}

/* 2^x, rounded down to few bits. */
static double short_exp2(double x)
{
    long e;
    double m = cns_exp2_2exp(x, &e);
    return ldexp(floor(ldexp(m, MANTISSA)), (int)e - MANTISSA);
}

static void horner(mpfr_t y, mpfr_t *c, int order, const mpfr_t tau)
{
    mpfr_set(y, c[order], MPFR_RNDN);
    for (int k = order - 1; k >= 0; k--) {
        mpfr_mul(y, y, tau, MPFR_RNDN);
        mpfr_add(y, y, c[k], MPFR_RNDN);
    }
}

/* s->tau = t / H. */
static void set_tau(cns_stepper *s, const mpfr_t t)
{
    if (s->H == 1)
        mpfr_set(s->tau, t, MPFR_RNDN);
    else
        mpfr_div_d(s->tau, t, s->H, MPFR_RNDN);
}

/* Coefficients are converted to MPFR only when something between the ends of a step is asked for. */
static void load(cns_stepper *s)
{
    for (int i = 0; i < s->n && !s->loaded; i++)
        for (int k = 0; k <= s->order; k++)
            cns_jet_coefficient(s->jet, coefficients(s, i)[k], i, k);
    s->loaded = true;
}

/* The states at s->tau. */
static void eval_tau(cns_stepper *s, mpfr_t *x)
{
    if (s->jet == s->fast) {
        for (int i = 0; i < s->n; i++)
            cns_jet_ops(s->jet)->sum(cns_jet_arith(s->jet), x[i], cns_jet_state_series(s->jet, i), s->order,
                                     s->tau);
        return;
    }
    load(s);
    for (int i = 0; i < s->n; i++) {
        horner(s->sum, coefficients(s, i), s->order, s->tau);
        mpfr_set(x[i], s->sum, MPFR_RNDN);
    }
}

static void eval(cns_stepper *s, const mpfr_t t, mpfr_t *x)
{
    set_tau(s, t);
    eval_tau(s, x);
}

static mpfr_t *polynomial(cns_stepper *s, int i, int *degree, mpfr_t unit)
{
    load(s);
    *degree = s->order;
    mpfr_set_d(unit, s->H, MPFR_RNDN);
    return coefficients(s, i);
}

static cns_code expand(cns_stepper *s, cns_jet *jet, int order, double H, mpfr_t *x, cns_error *err)
{
    s->jet = jet;
    s->H = H;
    cns_jet_begin(jet, H);
    for (int i = 0; i < s->n; i++)
        cns_jet_set_state(jet, i, x[i]);
    for (int w = 0; w < cns_jet_watched(jet); w++)
        if (s->landed_on[w])
            cns_jet_set_zero(jet, w);
    cns_code code = cns_jet_expand(jet, order, err);
    s->order = cns_jet_order(jet);
    return code;
}

/* log2 of the step that a series of a higher order would allow: the last coefficients continued to it by the
 * rate at which they grow over the second half of this series. False if they are all zero. */
static bool reach_beyond(const cns_stepper *s, double tolerance_log2, int order, double *h_log2)
{
    double end = -HUGE_VAL, middle = -HUGE_VAL, l;
    const int half = s->order / 2;
    for (int k = first_tested(s->order); k <= s->order; k++)
        if (norm_log2(s, k, &l))
            end = fmax(end, l);
    for (int k = first_tested(s->order) - half; k <= s->order - half; k++)
        if (k > 0 && norm_log2(s, k, &l))
            middle = fmax(middle, l);
    if (end == -HUGE_VAL || middle == -HUGE_VAL)
        return false;
    double last = end + (end - middle) / half * (order - s->order);
    *h_log2 = fmin((tolerance_log2 - last) / order, MAX_STEP_LOG2) + cns_log2_2exp(s->H, 0);
    return true;
}

static bool reach(const cns_stepper *s, double tolerance_log2, int order, double *h_log2)
{
    if (order > s->order)
        return reach_beyond(s, tolerance_log2, order, h_log2);
    *h_log2 = largest_log2(s, tolerance_log2, order) + cns_log2_2exp(s->H, 0);
    return true;
}

/* A guess at the next step from a short expansion in double. */
static bool scout(cns_stepper *s, mpfr_t *x)
{
    cns_error ignored;
    return !expand(s, s->scout, SCOUT_ORDER, 1, x, &ignored) &&
           reach_beyond(s, s->tolerance_log2, s->order_asked, &s->next_log2);
}

/* The expansion in the fast arithmetic. False if it does not fit: because of leading zeros, because its noise
 * is above the precision with every H tried, or because a given step is longer than H can be. */
static bool expand_fast(cns_stepper *s, const cns_step *step, mpfr_t *x)
{
    cns_error ignored;
    if (s->next_log2 == HUGE_VAL && !scout(s, x))
        return false;
    for (int attempt = 0; attempt < FAST_TRIES; attempt++, s->next_log2 -= 1) {
        double H = short_exp2(s->next_log2 < MAX_STEP_LOG2 ? s->next_log2 : MAX_STEP_LOG2);
        if (step->limit && mpfr_cmp_d(*step->limit, H) < 0)
            H = mpfr_get_d(*step->limit, MPFR_RNDU);
        if (step->limit && mpfr_cmp_d(*step->limit, H) > 0)
            return false;
        if (expand(s, s->fast, s->order_asked, H, x, &ignored))
            continue;
        s->noise_log2 = cns_jet_ops(s->fast)->noise_log2(cns_jet_arith(s->fast));
        if (s->noise_log2 <= NOISE_BITS - (double)s->prec)
            return true;
    }
    return false;
}

static cns_code expand_any(cns_stepper *s, const cns_step *step, mpfr_t *x, cns_error *err)
{
    if (s->fast && expand_fast(s, step, x))
        return CNS_OK;
    s->noise_log2 = -(double)s->prec;
    if (!s->plain)
        s->plain = new_jet(s, cns_flow_reference_arith(&s->spec), s->spec.order, s->spec.prec, err);
    return s->plain ? expand(s, s->plain, s->order_asked, 1, x, err) : err->code;
}

/* Is it certain that the watched polynomial has no root in (0, tau], because its first coefficient outweighs
 * the others? Sums of leading doubles, with a margin. */
static bool clearly_rootless(const cns_stepper *s, const cns_watch *w, double tau, long tau_exponent)
{
    const cns_arith_ops *ops = cns_jet_ops(s->jet);
    const cns_arith *A = cns_jet_arith(s->jet);
    long e0, e;
    double lead = fabs(ops->get_2exp(A, &e0, w->series, w->zeros)), rest = 0, power = 1;
    long power_e = 0;
    for (int k = w->zeros + 1; k <= w->order && rest < lead; k++) {
        int shift;
        power = frexp(power * tau, &shift);
        power_e += tau_exponent + shift;
        double m = fabs(ops->get_2exp(A, &e, w->series, k));
        long relative = e + power_e - e0;
        if (m == 0)
            continue;
        if (relative > 60)
            return false;
        rest += relative < -1000 ? 0 : ldexp(m * power, (int)relative);
    }
    return rest < 0.999 * lead;
}

/* The first root within h of a watched polynomial, in tau, into s->root. Its coefficients from the first one
 * that is not zero are left in s->watch. */
static cns_code first_root(cns_stepper *s, const cns_watch *watch, const mpfr_t h, bool *found,
                           cns_error *err)
{
    long exponent;
    set_tau(s, h);
    double mantissa = mpfr_get_d_2exp(&exponent, s->tau, MPFR_RNDN);
    *found = false;
    if (watch->order <= watch->zeros || clearly_rootless(s, watch, mantissa, exponent))
        return CNS_OK;
    for (int k = watch->zeros; k <= watch->order; k++)
        cns_jet_ops(s->jet)->get(cns_jet_arith(s->jet), s->watch[k - watch->zeros], watch->series, k);
    if (mpfr_zero_p(s->watch[0]))
        return CNS_OK;
    return cns_first_root(s->root, found, s->watch, watch->order - watch->zeros, s->tau, err);
}

/* Shortens h to half of a distance, in few bits, so that time stays exact. */
static void approach(cns_stepper *s, const mpfr_t distance, mpfr_t h)
{
    mpfr_div_2ui(s->sum, distance, 1, MPFR_RNDN);
    if (mpfr_cmp(s->sum, h) >= 0)
        return;
    mpfr_prec_round(s->sum, MANTISSA, MPFR_RNDD);
    mpfr_set(h, s->sum, MPFR_RNDN);
    mpfr_prec_round(s->sum, s->prec, MPFR_RNDN);
}

/* A step towards a zero of u in sqrt(u^2 + eps^2), at tau = s->root, goes at most half way to the
 * singularities beside it, which are eps/|u'| off the real axis. The coefficients of the states do not show
 * them when eps is far below the tolerance, and a step past them would continue the wrong branch, -u. */
static void approach_smoothed(cns_stepper *s, const cns_watch *watch, mpfr_t h)
{
    int degree = watch->order - watch->zeros;
    for (int k = 1; k <= degree; k++) /* du/dtau near the zero: the deflated polynomial's will do */
        mpfr_mul_ui(s->watch[k - 1], s->watch[k], (unsigned long)k, MPFR_RNDN);
    horner(s->sum, s->watch, degree - 1, s->root);
    cns_jet_ops(s->jet)->get(cns_jet_arith(s->jet), s->term, watch->eps, 0);
    mpfr_div(s->term, s->term, s->sum, MPFR_RNDN);
    if (!mpfr_number_p(s->term))
        return; /* a double zero: the singularities are far away */
    mpfr_hypot(s->term, s->term, s->root, MPFR_RNDN);
    mpfr_mul_d(s->term, s->term, s->H, MPFR_RNDN);
    approach(s, s->term, h);
}

/* Shortens h to the first kink in (0, h] and marks what is landed on. Smoothed kinks are approached with
 * care, and so are zeros of square roots: one that is near is a true singularity, or only looks like a zero
 * to a short series, and a shorter step tells them apart. */
static cns_code find_kink(cns_stepper *s, mpfr_t h, bool *landed, cns_error *err)
{
    *landed = false;
    for (int w = 0; w < cns_jet_watched(s->jet); w++) {
        cns_watch watch;
        bool found;
        s->landed_on[w] = false;
        if (!cns_jet_watch(s->jet, w, &watch))
            continue;
        cns_code code = first_root(s, &watch, h, &found, err);
        if (code)
            return code;
        if (!found)
            continue;
        if (watch.kind == CNS_WATCH_SMOOTH) {
            approach_smoothed(s, &watch, h);
            continue;
        }
        mpfr_mul_d(s->root, s->root, s->H, MPFR_RNDN);
        if (watch.kind == CNS_WATCH_ROOT) {
            approach(s, s->root, h);
            continue;
        }
        if (mpfr_cmp(s->root, h) < 0)
            for (int v = 0; v < w; v++)
                s->landed_on[v] = false;
        if (mpfr_cmp(s->root, h) <= 0) {
            mpfr_set(h, s->root, MPFR_RNDN);
            *landed = s->landed_on[w] = true;
        }
    }
    return CNS_OK;
}

/* States that are zero where a watched quantity is become exactly zero. */
static void set_zeros(cns_stepper *s, mpfr_t *y)
{
    for (int w = 0; w < cns_jet_watched(s->jet); w++) {
        cns_watch watch;
        if (s->landed_on[w] && cns_jet_watch(s->jet, w, &watch) && watch.state >= 0)
            mpfr_set_zero(y[watch.state], 1);
    }
}

/* Precision, tolerance and order for a step that begins at t, by the schedule; they only fall. The numbers
 * that hold coefficients get the same precision, which makes evaluation cheaper, too. */
static void choose_accuracy(cns_stepper *s, double t)
{
    if (!s->spec.schedule)
        return;
    long digits = cns_schedule_at(s->spec.schedule, t) + s->spec.schedule_shift;
    mpfr_prec_t prec = cns_digits_to_bits(digits < LEAST_DIGITS ? LEAST_DIGITS : digits);
    if (prec >= s->prec)
        return;
    s->prec = prec;
    s->tolerance_log2 = cns_digits_to_tolerance(digits);
    s->order_asked = cns_order_for(s->tolerance_log2, s->spec.arithmetic);
    cns_vector_set_prec(s->poly, s->n * (s->spec.order + 1), prec);
    cns_vector_set_prec(s->watch, s->spec.order + 1, prec);
    mpfr_set_prec(s->tau, prec);
    mpfr_set_prec(s->root, prec);
    mpfr_set_prec(s->sum, prec);
    mpfr_set_prec(s->term, prec);
    const cns_arith_ops *ops = cns_flow_arith(&s->spec);
    if (s->fast && ops->set_precision)
        ops->set_precision(cns_jet_arith(s->fast), prec + FAST_GUARD_BITS);
    set_decay(s);
}

static cns_code step(cns_stepper *s, cns_step *step, mpfr_t *x, mpfr_t *y, cns_error *err)
{
    choose_accuracy(s, step->t0);
    cns_code code = expand_any(s, step, x, err);
    if (code)
        return code;
    bool in_steps = s->jet == s->fast;
    s->loaded = false;
    if (!in_steps)
        load(s);
    for (int i = 0; i < s->n && !in_steps; i++)
        for (int k = 0; k <= s->order; k++)
            if (!mpfr_number_p(coefficients(s, i)[k]))
                return cns_fail(err, CNS_NUMERIC, "coefficient %d of %s is out of range", k,
                                cns_state_name(s->spec.program, i));
    double allowed = allowed_log2(s), H_log2 = cns_log2_2exp(s->H, 0);
    s->next_log2 = H_log2 + (in_steps && allowed > MAX_GAIN_LOG2 ? MAX_GAIN_LOG2 : allowed);
    if (step->limit)
        mpfr_set(step->h, *step->limit, MPFR_RNDN);
    else if (in_steps) /* few bits times few bits: exact */
        mpfr_set_d(step->h, short_exp2(fmin(allowed, cns_jet_ops(s->jet)->reach_log2)) * s->H, MPFR_RNDN);
    else
        mpfr_set_d(step->h, short_exp2(allowed + H_log2), MPFR_RNDN);
    code = find_kink(s, step->h, &step->landed, err);
    if (code)
        return code;
    double truncation = truncation_log2(s, cns_log2_mpfr(step->h) - H_log2);
    s->noise_log2 = step->noise_log2 = fmax(truncation, fmax(s->noise_log2, -(double)s->prec));
    eval(s, step->h, y);
    if (step->landed)
        set_zeros(s, y);
    return CNS_OK;
}

/* dx_i/dtau at s->tau, and log2 of the largest of its terms times tau. */
static void slope(cns_stepper *s, int i, mpfr_t dx, double *largest_log2)
{
    const cns_arith_ops *ops = cns_jet_ops(s->jet);
    if (ops->slope && ops->slope(cns_jet_arith(s->jet), dx, largest_log2, cns_jet_state_series(s->jet, i),
                                 s->order, s->tau))
        return;
    load(s);
    mpfr_t *c = coefficients(s, i);
    const double tau_log2 = cns_log2_mpfr(s->tau);
    *largest_log2 = -HUGE_VAL;
    mpfr_set_zero(s->sum, 1);
    for (int k = s->order; k >= 1; k--) {
        mpfr_mul(s->sum, s->sum, s->tau, MPFR_RNDN);
        mpfr_mul_ui(s->term, c[k], (unsigned long)k, MPFR_RNDN);
        mpfr_add(s->sum, s->sum, s->term, MPFR_RNDN);
        if (!mpfr_zero_p(s->term))
            *largest_log2 = fmax(*largest_log2, (double)mpfr_get_exp(s->term) + k * tau_log2);
    }
    mpfr_set(dx, s->sum, MPFR_RNDN);
}

/* dx/dt at time t after the beginning, and a bound on its error. */
static void derivative(cns_stepper *s, const mpfr_t t, mpfr_t *dx, mpfr_t tolerance)
{
    double l, largest_log2; /* of the terms of tau dx/dtau, or 1 / dt */
    set_tau(s, t);
    largest_log2 = cns_log2_mpfr(s->tau);
    for (int i = 0; i < s->n; i++) {
        long e;
        slope(s, i, dx[i], &l);
        largest_log2 = fmax(largest_log2, l);
        const double size = fabs(cns_jet_coefficient_2exp(s->jet, &e, i, 0));
        if (size > 0 && cns_program_is_dynamic(s->spec.program, i))
            largest_log2 = fmax(largest_log2, cns_log2_2exp(size, e));
        mpfr_div_d(dx[i], dx[i], s->H, MPFR_RNDN);
    }
    /* Rounding: a few dozen operations, relative to the largest terms and to the states that f is evaluated
     * at, each rounded relative to its own size. Truncation: the state's error times
     * order/h, and room for a tail that the last coefficients belittle, as they can by a few digits where a
     * pair of singularities makes them oscillate. The errors looked for are larger by far. */
    mpfr_set_d(s->sum, largest_log2 + 24 - (double)s->prec, MPFR_RNDU);
    mpfr_exp2(s->sum, s->sum, MPFR_RNDU);
    mpfr_div(tolerance, s->sum, t, MPFR_RNDU);
    mpfr_set_d(s->sum, s->noise_log2, MPFR_RNDU);
    mpfr_exp2(s->sum, s->sum, MPFR_RNDU);
    mpfr_mul_ui(s->sum, s->sum, ((unsigned long)s->order + 1) << 20, MPFR_RNDU);
    mpfr_div(s->sum, s->sum, t, MPFR_RNDU);
    mpfr_add(tolerance, tolerance, s->sum, MPFR_RNDU);
}

static const cns_jet *expansion(const cns_stepper *s, double *H)
{
    *H = s->H;
    return s->jet;
}

const cns_method_ops cns_method_taylor = {
    .name = "taylor",
    .create = create,
    .destroy = destroy,
    .bytes = bytes,
    .reach = reach,
    .start = start,
    .step = step,
    .eval = eval,
    .polynomial = polynomial,
    .derivative = derivative,
    .expansion = expansion,
};
