/* What a number of digits means for a run: bits, tolerance, order and arithmetic. Together with the makers of
 * specs in cns/flow.h this is the one place that decides; everything else asks. */
#ifndef CNS_INTEGRATE_NUMERICS_H
#define CNS_INTEGRATE_NUMERICS_H

#include "arith/arith.h"
#include "cns/flow.h"

#define CNS_DOUBLE_MAX_ORDER 30 /* beyond it coefficients scaled in double underflow or cancel to noise */

enum {
    CNS_DOUBLE_BITS = 53,
    CNS_DOUBLE_DIGITS = 16,  /* what double counts as where digits are asked for */
    CNS_USUAL_SIZE_BITS = 10 /* by which a state may exceed its scale before the digits of its size are
                                counted extra: so many of the guard bits */
};

/* log2 of the local truncation error, in scales, that goes with so many digits: 10^-digits. */
double cns_digits_to_tolerance(long digits);

/* The order at which a Taylor step of local error 2^tolerance_log2 costs least: 1 - ln(tolerance)/2 (Jorba
 * and Zou, Experimental Mathematics 14 (2005) 99, section 3), which makes coefficients fall by 2.9 bits per
 * order; the fast arithmetic wants a little more than the three bits that it is made for. */
int cns_order_for(double tolerance_log2, cns_arithmetic arithmetic);

/* The arithmetic that a Taylor flow of this order really uses: below order 8 MPFR costs less than the fast
 * one, with every kernel and any number of digits (tools/tune small). */
cns_arithmetic cns_arithmetic_for(cns_arithmetic asked, int order);

/* The operations of a flow's arithmetic. The fast one works in whole steps of about the size it was told
 * beforehand; single values, such as the derived quantities of a row, are computed by the second. */
const cns_arith_ops *cns_flow_arith(const cns_flow_spec *spec);
const cns_arith_ops *cns_flow_reference_arith(const cns_flow_spec *spec);

#endif
