#include "ball_text.h"

#include "decimal_text.h"
#include "logs.h"

enum { GUARD_BITS = 64, MAX_SIZE_BITS = 1 << 20 };

char *cns_text_ball(const arb_t x, long decimals)
{
    mpfr_t low, high, radius;
    const slong size = arf_is_special(arb_midref(x)) ? 0 : arf_abs_bound_lt_2exp_si(arb_midref(x));
    char *text = NULL;
    if (!arb_is_finite(x) || size > MAX_SIZE_BITS)
        return NULL;
    mpfr_inits2((slong)((double)decimals * CNS_LOG2_10) + (size > 0 ? size : 0) + 2 * GUARD_BITS, low, high,
                radius, (mpfr_ptr)0);
    arb_get_interval_mpfr(low, high, x);
    mpfr_sub(radius, high, low, MPFR_RNDU);
    mpfr_div_2ui(radius, radius, 1, MPFR_RNDU);
    mpfr_add(low, low, radius, MPFR_RNDN);
    mpfr_mul_ui(radius, radius, 2, MPFR_RNDU); /* for the rounding of the middle; nothing else was lost */
    if (cns_text_certain(low, radius, CNS_PLACES_DECIMALS, decimals))
        text = cns_text_mpfr(low, CNS_PLACES_DECIMALS, decimals);
    mpfr_clears(low, high, radius, (mpfr_ptr)0);
    return text;
}
