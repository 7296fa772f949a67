/* The Taylor method: jet, step from the last coefficients, kinks, evaluation. */
#include <math.h>
#include <stdlib.h>

#include "method.h"
#include "num/logs.h"
#include "roots.h"

struct cns_stepper {
    cns_flow_spec spec;
    int n;
    cns_jet *jet;
    int order;       /* of the last expansion */
    mpfr_t *poly;    /* its coefficients, order + 1 per state */
    mpfr_t *watch;   /* those of one watched quantity */
    bool *landed_on; /* watched quantities on whose zeros the last step ended */
    mpfr_t tau, power, root, sum;
    double noise_log2;
};

enum { TESTED = 4, MAX_STEP_LOG2 = 10 };

static void destroy(cns_stepper *s)
{
    if (!s)
        return;
    cns_jet_free(s->jet);
    cns_vector_free(s->poly, s->n * (s->spec.order + 1));
    cns_vector_free(s->watch, s->spec.order + 1);
    free(s->landed_on);
    mpfr_clears(s->tau, s->power, s->root, s->sum, (mpfr_ptr)0);
    free(s);
}

static cns_stepper *create(const cns_flow_spec *spec, cns_error *err)
{
    cns_stepper *s = calloc(1, sizeof *s);
    if (!s) {
        cns_fail(err, CNS_NUMERIC, "out of memory");
        return NULL;
    }
    s->spec = *spec;
    s->n = cns_program_states(spec->program);
    mpfr_inits2(spec->prec, s->tau, s->power, s->root, s->sum, (mpfr_ptr)0);
    cns_jet_spec jet = {
        .program = spec->program, .ops = cns_flow_arith(spec), .order = spec->order, .prec = spec->prec};
    s->jet = cns_jet_new(&jet, err);
    if (!s->jet) {
        destroy(s);
        return NULL;
    }
    s->poly = cns_vector_new(s->n * (spec->order + 1), spec->prec);
    s->watch = cns_vector_new(spec->order + 1, spec->prec);
    s->landed_on = calloc((size_t)cns_jet_watched(s->jet) + 1, sizeof *s->landed_on);
    if (!s->poly || !s->watch || !s->landed_on) {
        cns_fail(err, CNS_NUMERIC, "out of memory");
        destroy(s);
        return NULL;
    }
    return s;
}

static void start(cns_stepper *s)
{
    for (int w = 0; w < cns_jet_watched(s->jet); w++)
        s->landed_on[w] = false;
}

static mpfr_t *coefficients(cns_stepper *s, int i)
{
    return s->poly + (size_t)i * ((size_t)s->spec.order + 1);
}

/* log2 of the largest |x_{i,k}| / scale_i over the dynamic states; false if all are zero. Passive states
 * do not steer steps. */
static bool norm_log2(const cns_stepper *s, int k, double *log2_norm)
{
    bool any = false, passive_too = true;
    for (int i = 0; i < s->n; i++)
        if (cns_program_is_dynamic(s->spec.program, i))
            passive_too = false; /* only a system without feedback lets its quadratures steer */
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

static int first_tested(const cns_stepper *s)
{
    return s->order >= TESTED ? s->order - TESTED + 1 : 1;
}

/* Jorba and Zou's step from the last coefficients, four of them since parity may make every second one
 * vanish: the largest h with |x_k| h^k <= tolerance for each. */
static double step_log2(const cns_stepper *s)
{
    double best = MAX_STEP_LOG2, l;
    for (int k = first_tested(s); k <= s->order; k++)
        if (norm_log2(s, k, &l) && (s->spec.tolerance_log2 - l) / k < best)
            best = (s->spec.tolerance_log2 - l) / k;
    return best - s->spec.safety - 1.0 / s->order;
}

/* log2 of the truncation error at h: the last coefficients' largest term. */
static double truncation_log2(const cns_stepper *s, double h_log2)
{
    double worst = -HUGE_VAL, l;
    for (int k = first_tested(s); k <= s->order; k++)
        if (norm_log2(s, k, &l) && l + k * h_log2 > worst)
            worst = l + k * h_log2;
    return worst;
}

static double log2_of(const mpfr_t x)
{
    long e;
    double m = mpfr_get_d_2exp(&e, x, MPFR_RNDN);
    return cns_log2_2exp(m, e);
}

/* Is it certain that the watched polynomial has no root in (0, h], because its first coefficient outweighs
 * the others? Sums of leading doubles, with a margin. */
static bool clearly_rootless(const cns_stepper *s, const cns_watch *w, double h_mantissa, long h_exponent)
{
    const cns_arith_ops *ops = cns_jet_ops(s->jet);
    const cns_arith *A = cns_jet_arith(s->jet);
    long e0, e;
    double lead = fabs(ops->get_2exp(A, &e0, w->series, w->zeros)), rest = 0, power = 1;
    long power_e = 0;
    for (int k = w->zeros + 1; k <= w->order; k++) {
        int shift;
        power = frexp(power * h_mantissa, &shift);
        power_e += h_exponent + shift;
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

static void horner(mpfr_t y, mpfr_t *c, int order, const mpfr_t tau)
{
    mpfr_set(y, c[order], MPFR_RNDN);
    for (int k = order - 1; k >= 0; k--) {
        mpfr_mul(y, y, tau, MPFR_RNDN);
        mpfr_add(y, y, c[k], MPFR_RNDN);
    }
}

/* The first root in (0, h] of a watched polynomial, into s->root. */
static cns_code first_root(cns_stepper *s, const cns_watch *watch, const mpfr_t h, bool *found,
                           cns_error *err)
{
    long h_exponent;
    double h_mantissa = mpfr_get_d_2exp(&h_exponent, h, MPFR_RNDN);
    *found = false;
    if (watch->order <= watch->zeros || clearly_rootless(s, watch, h_mantissa, h_exponent))
        return CNS_OK;
    for (int k = watch->zeros; k <= watch->order; k++)
        cns_jet_ops(s->jet)->get(cns_jet_arith(s->jet), s->watch[k - watch->zeros], watch->series, k);
    if (mpfr_zero_p(s->watch[0]))
        return CNS_OK;
    mpfr_set(s->tau, h, MPFR_RNDN);
    return cns_first_root(s->root, found, s->watch, watch->order - watch->zeros, s->tau, err);
}

/* A step towards a zero of u in sqrt(u^2 + eps^2) goes at most half way to the singularities beside it,
 * which are eps/|u'| off the real axis. The coefficients of the states do not show them when eps is far
 * below the tolerance, and a step past them would continue the wrong branch, -u. */
static void approach_smoothed(cns_stepper *s, const cns_watch *watch, mpfr_t h)
{
    int degree = watch->order - watch->zeros;
    for (int k = 1; k <= degree; k++) /* u' near the zero: the deflated polynomial's will do */
        mpfr_mul_ui(s->watch[k - 1], s->watch[k], (unsigned long)k, MPFR_RNDN);
    horner(s->sum, s->watch, degree - 1, s->root);
    cns_jet_ops(s->jet)->get(cns_jet_arith(s->jet), s->tau, watch->eps, 0);
    mpfr_div(s->tau, s->tau, s->sum, MPFR_RNDN);
    if (!mpfr_number_p(s->tau))
        return; /* a double zero: the singularities are far away */
    mpfr_hypot(s->tau, s->tau, s->root, MPFR_RNDN);
    mpfr_div_2ui(s->tau, s->tau, 1, MPFR_RNDN);
    if (mpfr_cmp(s->tau, h) < 0) {
        mpfr_prec_round(s->tau, 24, MPFR_RNDD); /* few bits, so that time stays exact */
        mpfr_set(h, s->tau, MPFR_RNDN);
        mpfr_prec_round(s->tau, s->spec.prec, MPFR_RNDN);
    }
}

/* Shortens h to the first kink in (0, h] and marks what is landed on; approaches smoothed ones with care. */
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
        if (watch.kind == CNS_WATCH_ROOT)
            return cns_fail(err, CNS_NUMERIC,
                            "a square root reaches zero after %.6g more, where the equations are singular%s",
                            mpfr_get_d(s->root, MPFR_RNDN),
                            s->spec.step ? " (or the fixed step exceeds the radius of convergence)" : "");
        bool earlier = mpfr_cmp(s->root, h) < 0;
        if (watch.kind == CNS_WATCH_SMOOTH) {
            approach_smoothed(s, &watch, h);
            earlier = false;
        }
        if (earlier)
            for (int v = 0; v < w; v++)
                s->landed_on[v] = false;
        if (watch.kind == CNS_WATCH_KINK && mpfr_cmp(s->root, h) <= 0) {
            mpfr_set(h, s->root, MPFR_RNDN);
            *landed = s->landed_on[w] = true;
        }
    }
    return CNS_OK;
}

static void eval(cns_stepper *s, const mpfr_t tau, mpfr_t *x)
{
    mpfr_set(s->tau, tau, MPFR_RNDN);
    for (int i = 0; i < s->n; i++) {
        horner(s->sum, coefficients(s, i), s->order, s->tau);
        mpfr_set(x[i], s->sum, MPFR_RNDN);
    }
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

static cns_code step(cns_stepper *s, cns_step *step, mpfr_t *x, mpfr_t *y, cns_error *err)
{
    cns_jet_begin(s->jet, 1);
    for (int i = 0; i < s->n; i++)
        cns_jet_set_state(s->jet, i, x[i]);
    for (int w = 0; w < cns_jet_watched(s->jet); w++)
        if (s->landed_on[w])
            cns_jet_set_zero(s->jet, w);
    cns_code code = cns_jet_expand(s->jet, s->spec.order, err);
    if (code)
        return code;
    s->order = cns_jet_order(s->jet);
    for (int i = 0; i < s->n; i++)
        for (int k = 0; k <= s->order; k++) {
            cns_jet_coefficient(s->jet, coefficients(s, i)[k], i, k);
            if (!mpfr_number_p(coefficients(s, i)[k]))
                return cns_fail(err, CNS_NUMERIC, "coefficient %d of state %d is out of range", k, i);
        }
    double h_log2;
    if (step->limit) {
        mpfr_set(step->h, *step->limit, MPFR_RNDN);
        h_log2 = log2_of(step->h);
    } else { /* few bits, so that time stays exact */
        long e;
        h_log2 = step_log2(s);
        double m = cns_exp2_2exp(h_log2, &e);
        mpfr_set_d(step->h, floor(ldexp(m, 24)), MPFR_RNDN);
        mpfr_mul_2si(step->h, step->h, e - 24, MPFR_RNDN);
    }
    code = find_kink(s, step->h, &step->landed, err);
    if (code)
        return code;
    double truncation = truncation_log2(s, step->landed ? log2_of(step->h) : h_log2);
    s->noise_log2 = step->noise_log2 =
        truncation > -(double)s->spec.prec ? truncation : -(double)s->spec.prec;
    eval(s, step->h, y);
    if (step->landed)
        set_zeros(s, y);
    return CNS_OK;
}

static void derivative(cns_stepper *s, const mpfr_t tau, mpfr_t *dx, mpfr_t tolerance)
{
    double largest = 1, h = mpfr_get_d(tau, MPFR_RNDN);
    for (int i = 0; i < s->n; i++) {
        mpfr_t *c = coefficients(s, i);
        double sum = 0, power = 1;
        mpfr_set(s->tau, tau, MPFR_RNDN);
        mpfr_set_zero(s->sum, 1);
        for (int k = s->order; k >= 1; k--) {
            mpfr_mul(s->sum, s->sum, s->tau, MPFR_RNDN);
            mpfr_mul_ui(s->power, c[k], (unsigned long)k, MPFR_RNDN);
            mpfr_add(s->sum, s->sum, s->power, MPFR_RNDN);
        }
        mpfr_set(dx[i], s->sum, MPFR_RNDN);
        for (int k = 1; k <= s->order && power > 1e-30; k++, power *= h)
            sum += k * fabs(mpfr_get_d(c[k], MPFR_RNDN)) * power;
        largest = fmax(largest, sum);
    }
    /* Rounding: a few dozen operations, relative to the largest terms. Truncation: the state's error times
     * order/h, and a factor for the tail. */
    mpfr_set_d(tolerance, largest, MPFR_RNDU);
    mpfr_mul_2si(tolerance, tolerance, 20 - (long)s->spec.prec, MPFR_RNDU);
    mpfr_set_d(s->sum, s->noise_log2, MPFR_RNDU);
    mpfr_exp2(s->sum, s->sum, MPFR_RNDU);
    mpfr_mul_ui(s->sum, s->sum, 64ul * (unsigned long)(s->order + 1), MPFR_RNDU);
    mpfr_div(s->sum, s->sum, tau, MPFR_RNDU);
    mpfr_add(tolerance, tolerance, s->sum, MPFR_RNDU);
}

const cns_method_ops cns_method_taylor = {
    .name = "taylor",
    .create = create,
    .destroy = destroy,
    .start = start,
    .step = step,
    .eval = eval,
    .derivative = derivative,
};
