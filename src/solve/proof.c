#include "proof.h"

#include <math.h>

#include "core/monitor.h"
#include "integrate/numerics.h"
#include "num/decimal_text.h"
#include "num/logs.h"

enum {
    /* The difference of the two runs may exceed noise times growth by this factor, 2^NOISE_SLACK: a step
     * rounds some hundred times, and not always gently. */
    NOISE_SLACK = 24,
    SEARCH = 60 /* numbers of decimals looked through for one that does not straddle */
};

static cns_flow_spec taylor(const cns_problem *p, long digits)
{
    cns_flow_spec spec = cns_flow_spec_taylor(cns_system_program(p->system), cns_system_scales(p->system),
                                              CNS_ARITH_FAST, digits);
    spec.verify = true;
    spec.stop = cns_monitor_stop(p->monitor);
    return spec;
}

void cns_proof_of_goal(cns_proof_runs *r, const cns_problem *p, long digits, const cns_schedule *schedule)
{
    *r = (cns_proof_runs){.proof = true, .fine_digits = digits, .coarse_digits = digits - CNS_ANOTHER_LIMB};
    cns_number_init(&r->half_step);
    r->fine = taylor(p, r->fine_digits);
    r->coarse = taylor(p, r->coarse_digits);
    r->fine.safety = CNS_FINE_SAFETY;
    r->fine.schedule = r->coarse.schedule = schedule;
    r->coarse.schedule_shift = r->coarse_digits - schedule->digits[0];
    r->fine.schedule_shift = r->coarse.schedule_shift + CNS_ANOTHER_LIMB;
}

void cns_proof_enclosed(cns_proof_runs *r, const cns_problem *p, long digits, const cns_schedule *schedule)
{
    *r = (cns_proof_runs){.enclosed = true, .fine_digits = digits};
    cns_number_init(&r->half_step);
    r->fine = taylor(p, digits);
    r->fine.verify = false; /* the defect is bounded */
    r->fine.schedule = schedule;
    r->fine.schedule_shift = digits - schedule->digits[0];
}

void cns_proof_of_numerics(cns_proof_runs *r, const cns_problem *p, const cns_numerics *n,
                           cns_proof_kind kind)
{
    const bool enclosed =
        kind == CNS_PROOF_ENCLOSURE && n->method == CNS_METHOD_TAYLOR && n->arithmetic != CNS_ARITH_DOUBLE;
    const bool proof = kind != CNS_PROOF_NONE && !enclosed;
    *r = (cns_proof_runs){.proof = proof, .enclosed = enclosed, .fine_digits = n->digits};
    cns_number_init(&r->half_step);
    r->fine = cns_flow_spec_given(cns_system_program(p->system), cns_system_scales(p->system), n, 0);
    r->fine.verify = proof;
    r->fine.stop = cns_monitor_stop(p->monitor);
    if (!proof)
        return;
    r->coarse = r->fine;
    r->coarse_digits = n->digits > 0 ? n->digits : CNS_DOUBLE_DIGITS;
    r->fine_digits = r->coarse_digits + CNS_ANOTHER_LIMB;
    r->fine.arithmetic =
        n->method == CNS_METHOD_RK4 || n->arithmetic == CNS_ARITH_MPFR ? CNS_ARITH_MPFR : CNS_ARITH_FAST;
    r->fine.prec = cns_digits_to_bits(r->fine_digits);
    if (cns_number_sign(&n->step) > 0) {
        cns_number_set(&r->half_step, &n->step);
        mpq_div_2exp(r->half_step.ratio, r->half_step.ratio, 1);
        r->fine.step = &r->half_step;
    }
    r->fine.tolerance_log2 += cns_digits_to_tolerance(CNS_ANOTHER_LIMB);
    r->fine.safety = CNS_FINE_SAFETY;
    if (n->method == CNS_METHOD_TAYLOR)
        r->fine.order = n->order > 0 ? r->coarse.order + r->coarse.order / 8 + 2
                                     : cns_order_for(r->fine.tolerance_log2, r->fine.arithmetic);
}

void cns_proof_runs_clear(cns_proof_runs *r)
{
    cns_number_clear(&r->half_step);
}

/* Raises e to |a - b|, if that is a number. */
static void differ(mpfr_t e, mpfr_srcptr a, mpfr_srcptr b)
{
    mpfr_t x;
    mpfr_init2(x, mpfr_get_prec(e));
    mpfr_sub(x, a, b, MPFR_RNDA);
    mpfr_abs(x, x, MPFR_RNDN);
    if (mpfr_number_p(x))
        mpfr_max(e, e, x, MPFR_RNDN);
    mpfr_clear(x);
}

void cns_proof_error(mpfr_t e, mpfr_srcptr fine, mpfr_srcptr coarse, double noise_log2)
{
    mpfr_t own, noise;
    mpfr_inits2(mpfr_get_prec(e), own, noise, (mpfr_ptr)0);
    mpfr_set_d(noise, noise_log2, MPFR_RNDU);
    mpfr_exp2(own, noise, MPFR_RNDU);
    differ(own, fine, coarse);
    mpfr_mul_2ui(own, own, CNS_PROOF_SAFETY_LOG2, MPFR_RNDU);
    mpfr_max(e, e, own, MPFR_RNDU);
    mpfr_clears(own, noise, (mpfr_ptr)0);
}

static bool certain(const cns_bounded *value, int n, cns_places places, long count)
{
    for (int i = 0; i < n; i++)
        if (!cns_text_certain(value[i].x, value[i].e, places, count))
            return false;
    return true;
}

long cns_proof_places(const cns_bounded *value, int n, cns_places places, long most)
{
    const bool decimals = places == CNS_PLACES_DECIMALS;
    double largest = -HUGE_VAL; /* log10 of the largest e */
    for (int i = 0; i < n; i++)
        largest = fmax(largest, cns_log2_mpfr(value[i].e) * CNS_LOG10_2);
    if (decimals && largest > -HUGE_VAL && -largest < (double)most)
        most = (long)floor(-largest); /* with more decimals, e spans several texts */
    for (long count = most, tries = 0; count >= (decimals ? 0 : 1); count--, tries++) {
        if (certain(value, n, places, count))
            return count;
        if (decimals && tries > SEARCH)
            break;
    }
    return -1;
}

cns_code cns_proof_explained(const cns_problem *p, const cns_sample *fine, const cns_sample *coarse, double t,
                             cns_error *err)
{
    double difference = -HUGE_VAL;
    const double noise = coarse->error_log2;
    mpfr_t x;
    mpfr_init2(x, 64);
    for (int i = 0; i < fine->n_states; i++) {
        if (!cns_program_is_dynamic(cns_system_program(p->system), i))
            continue;
        mpfr_set_zero(x, 1);
        differ(x, fine->state[i], coarse->state[i]);
        difference = fmax(difference, cns_log2_mpfr(x) - cns_log2_2exp(cns_system_scales(p->system)[i], 0));
    }
    mpfr_clear(x);
    if (noise == -HUGE_VAL || difference <= noise + NOISE_SLACK)
        return CNS_OK;
    return cns_fail(
        err, CNS_NUMERIC,
        "t = %.12g: the two runs of the proof differ by 10^%.1f, but noise has grown to 10^%.1f only: "
        "this is an error, not chaos",
        t, difference * CNS_LOG10_2, noise * CNS_LOG10_2);
}
