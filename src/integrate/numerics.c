#include "numerics.h"

#include <math.h>

#include "num/logs.h"

enum { GUARD_BITS = 16 };

mpfr_prec_t cns_digits_to_bits(long digits)
{
    return (mpfr_prec_t)((double)digits * CNS_LOG2_10) + 1 + GUARD_BITS;
}

double cns_digits_to_tolerance(long digits)
{
    return -(double)digits * CNS_LOG2_10;
}

/* The cost of a step grows with the square of the order where convolutions are most of it; then the best
 * order lets coefficients fall by 2/ln 2 = 2.9 bits per order. In the fast arithmetic with few digits it
 * grows almost linearly, and longer steps of a higher order pay. A little more than whole bits: the fast
 * arithmetic counts on whole bits of decay (src/integrate/taylor.c). Measured; never falling with the
 * precision. */
static const double LINEAR_BITS = 420, LINEAR_RATE = 2.25, QUADRATIC_RATE = 3.05;

int cns_order_for(double tolerance_log2, cns_arithmetic arithmetic)
{
    double order = -tolerance_log2 * (0.69314718055994530942 / 2);
    if (arithmetic == CNS_ARITH_FAST)
        order = fmax(fmin(-tolerance_log2, LINEAR_BITS) / LINEAR_RATE, -tolerance_log2 / QUADRATIC_RATE);
    return (int)(1.5 + order) + 1;
}

cns_arithmetic cns_arithmetic_for(cns_arithmetic asked, int order)
{
    enum { LEAST_FAST_ORDER = 8 };
    return asked == CNS_ARITH_FAST && order < LEAST_FAST_ORDER ? CNS_ARITH_MPFR : asked;
}

const cns_arith_ops *cns_flow_arith(const cns_flow_spec *spec)
{
    if (spec->arithmetic == CNS_ARITH_DOUBLE)
        return spec->portable ? &cns_arith_double : &cns_arith_libm;
    return spec->arithmetic == CNS_ARITH_FAST ? &cns_arith_fast : &cns_arith_mpfr;
}

const cns_arith_ops *cns_flow_reference_arith(const cns_flow_spec *spec)
{
    const cns_arith_ops *ops = cns_flow_arith(spec);
    return ops->in_steps ? &cns_arith_mpfr : ops;
}

long cns_schedule_at(const cns_schedule *s, double t)
{
    double part = t / s->end * s->n;
    return s->digits[part < 0 ? 0 : part < s->n ? (int)part : s->n - 1];
}

cns_flow_spec cns_flow_spec_taylor(const cns_program *program, const double *scales,
                                   cns_arithmetic arithmetic, long digits)
{
    const double tolerance = cns_digits_to_tolerance(digits);
    return (cns_flow_spec){.program = program,
                           .scales = scales,
                           .method = CNS_METHOD_TAYLOR,
                           .arithmetic = arithmetic,
                           .prec =
                               arithmetic == CNS_ARITH_DOUBLE ? CNS_DOUBLE_BITS : cns_digits_to_bits(digits),
                           .order = cns_order_for(tolerance, arithmetic),
                           .tolerance_log2 = tolerance};
}

cns_flow_spec cns_flow_spec_given(const cns_program *program, const double *scales, const cns_numerics *n,
                                  long spare)
{
    const long digits = n->arithmetic == CNS_ARITH_DOUBLE ? CNS_DOUBLE_DIGITS : n->digits + spare;
    cns_flow_spec spec = cns_flow_spec_taylor(program, scales, n->arithmetic, digits);
    spec.method = n->method;
    spec.step = cns_number_sign(&n->step) > 0 ? &n->step : NULL;
    if (cns_number_sign(&n->tolerance) > 0) {
        mpfr_t x;
        mpfr_init2(x, 64);
        cns_number_get_mpfr(x, &n->tolerance);
        spec.tolerance_log2 = cns_log2_mpfr(x);
        mpfr_clear(x);
    }
    spec.order = n->order > 0 ? (int)n->order : cns_order_for(spec.tolerance_log2, spec.arithmetic);
    return spec;
}
