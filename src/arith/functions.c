#include "functions.h"

void cns_function_mpfr(cns_function f, mpfr_ptr w, mpfr_ptr w2, mpfr_srcptr a, mpfr_srcptr b)
{
    switch (f) {
    case CNS_FN_SQRT:
        mpfr_sqrt(w, a, MPFR_RNDN);
        break;
    case CNS_FN_HYPOT:
        mpfr_hypot(w, a, b, MPFR_RNDN);
        break;
    case CNS_FN_SINCOS:
        mpfr_sin_cos(w, w2, a, MPFR_RNDN);
        break;
    case CNS_FN_EXP:
        mpfr_exp(w, a, MPFR_RNDN);
        break;
    case CNS_FN_LOG:
        mpfr_log(w, a, MPFR_RNDN);
        break;
    case CNS_FN_POW:
        mpfr_pow(w, a, b, MPFR_RNDN);
        break;
    }
}
