/* Integration step by step, by any method, with dense output.
 *
 * A flow is one trajectory of a program, x' = f(x) from x(0), in the units of the equations. It holds its
 * last step [t0, t1], the states at both ends, and the states anywhere in between (dense output). In order:
 *
 *     cns_flow_new(), cns_flow_start(), then again and again cns_flow_step(),
 *
 * and after each step what is of interest: cns_flow_end() and cns_flow_state(), or cns_flow_eval() at times
 * within it. Steps are a function of the problem and the numerics alone: output times never change them.
 *
 * One thread at a time may use a flow. Flows share nothing but their program, which is only read. */
#ifndef CNS_FLOW_H
#define CNS_FLOW_H

#include <gmp.h>
#include <mpfr.h>
#include <signal.h>
#include <stdbool.h>

#include "cns/number.h"
#include "cns/program.h"
#include "cns/status.h"

CNS_BEGIN_DECLS

typedef enum cns_method {
    CNS_METHOD_TAYLOR, /* Taylor series, order and step as below, landing on kinks */
    CNS_METHOD_RK4     /* the classical Runge-Kutta method, fixed step, blind to kinks */
} cns_method;

typedef enum cns_arithmetic {
    CNS_ARITH_FAST,  /* block fixed point, and MPFR where that does not fit; Taylor only */
    CNS_ARITH_MPFR,  /* every operation correctly rounded to prec bits */
    CNS_ARITH_DOUBLE /* IEEE double; functions by the C library */
} cns_arithmetic;

/* Precision that falls with time: digits for steps that begin in each of n equal parts of [0, end], never
 * more than in the part before; after the end, those of the last part. A rounding error made at time t grows
 * only from t on: the later it is made, the less it has grown by the end, and the fewer digits are needed. */
typedef struct cns_schedule {
    double end;
    int n;
    long *digits;
} cns_schedule;

long cns_schedule_at(const cns_schedule *s, double t); /* the digits of a step that begins at t */

typedef struct cns_flow_spec {
    const cns_program *program; /* finished; outlives the flow */
    const double *scales;       /* per state, > 0, typical sizes: what tolerances and noise are relative to */
    cns_method method;
    cns_arithmetic arithmetic;
    const char *kernel;           /* fast: "portable" or "avx512ifma", with the same bits; NULL: the best
                                     that this machine has, or as chosen for the process */
    bool portable;                /* double: correctly rounded functions, the same bits on every machine */
    mpfr_prec_t prec;             /* bits; ignored (53) for double */
    int order;                    /* of the Taylor series, >= 1 */
    const cns_number *step;       /* NULL: adaptive; else fixed: > 0, rational. RK4 needs one */
    double tolerance_log2;        /* adaptive: log2 of the local truncation error, in scales */
    double safety;                /* adaptive: steps are 2^-safety of what the coefficients allow; >= 0 */
    const cns_schedule *schedule; /* Taylor, adaptive: digits by time instead of prec, order and tolerance,
                                     which stand for the most; NULL: none. Outlives the flow */
    long schedule_shift;          /* added to the schedule's digits */
    bool verify;                  /* after each step, compare the derivative with the right-hand side */
    long round_digits; /* K > 0: a K-digit run. After every step and every landing each state is rounded to
                          K significant decimals, half to even; prec should hold some ten digits more,
                          so that nothing else matters. Dense output stays that of the step. Not with
                          double. 0: none */
    const volatile sig_atomic_t *stop; /* non-zero: give up (may be NULL) */
} cns_flow_spec;

/* Numerics as a case file gives them. */
typedef struct cns_numerics {
    cns_method method;
    cns_arithmetic arithmetic;
    long digits;          /* 0 with arithmetic double */
    long order;           /* 0: auto */
    cns_number step;      /* the fixed step, > 0; 0: adaptive */
    cns_number tolerance; /* > 0; 0: auto, by the digits */
} cns_numerics;

typedef struct cns_flow cns_flow;

/* Digits K mean ceil(K log2 10) bits and guard bits against the rounding inside one step. */
mpfr_prec_t cns_digits_to_bits(long digits);

/* The spec of a Taylor run of so many digits, all else automatic: tolerance 10^-digits, the order at which
 * that costs least, steps as they come. With arithmetic double digits set the tolerance only, and 16 are
 * next to its rounding. */
cns_flow_spec cns_flow_spec_taylor(const cns_program *program, const double *scales,
                                   cns_arithmetic arithmetic, long digits);

/* The spec of a run by given numerics, which outlive it, computed with `spare` digits more than they say
 * (not in double). */
cns_flow_spec cns_flow_spec_given(const cns_program *program, const double *scales,
                                  const cns_numerics *numerics, long spare);

/* A new flow, which cns_flow_free() frees, or NULL: CNS_USAGE, what is asked for makes no sense; CNS_NUMERIC,
 * a constant that is not finite; CNS_MEMORY; err->code says which. */
cns_flow *cns_flow_new(const cns_flow_spec *spec, cns_error *err);
void cns_flow_free(cns_flow *f);
size_t cns_flow_bytes(const cns_flow *f); /* of memory that it holds: series and vectors */

/* To t = 0 with these states (one per state), converted at the flow's precision. */
void cns_flow_start(cns_flow *f, const cns_number *initial);
/* The same with states that are results, not texts: rounded to the flow's precision. */
void cns_flow_start_at(cns_flow *f, const mpfr_t *initial);

/* Sets the states first .. first + count - 1 at t1 to x, rounded to the flow's precision: for tangents, which
 * have to be brought back to a common length and to right angles. The next step begins with them; the last
 * step still evaluates to what it was. */
void cns_flow_replace(cns_flow *f, int first, int count, const mpfr_t *x);

/* One step: t0 = the old t1. CNS_NUMERIC: singularity, underflow, a number that is not finite, or (verify) a
 * derivative that is not the right-hand side; the message says where. CNS_STOPPED: spec.stop was raised. */
cns_code cns_flow_step(cns_flow *f, cns_error *err);

/* Steps of a fixed length that end before `time`, all but the last of them and no more than so many at once
 * that a signal need not wait, where they can be made faster if nobody looks at them: with the Runge-Kutta
 * method in double precision. The results are the same as those of cns_flow_step(), which has to be called
 * before anything is asked of the last step. Returns how many were made; where there is something to say of a
 * step, it is left to cns_flow_step(). */
long cns_flow_skip(cns_flow *f, double time);

/* Of the last step; before the first one t0 = t1 = 0. What they point to changes with the next step. */
mpfr_srcptr cns_flow_begin(const cns_flow *f);         /* t0 */
mpfr_srcptr cns_flow_end(const cns_flow *f);           /* t1 */
const mpfr_t *cns_flow_begin_state(const cns_flow *f); /* at t0, one per state */
const mpfr_t *cns_flow_state(const cns_flow *f);       /* at t1, one per state */
bool cns_flow_landed(const cns_flow *f);               /* did it end on a kink, a zero of some abs()? */
double cns_flow_noise_log2(const cns_flow *f); /* log2 of its error, rounding or truncation, in scales */

int cns_flow_states(const cns_flow *f);       /* how many */
mpfr_prec_t cns_flow_prec(const cns_flow *f); /* bits of the states */

/* log2 of the step that a series of this order would allow where the last step began, at this tolerance,
 * from the last step's coefficients: an estimate. False if they tell nothing. */
bool cns_flow_reach(const cns_flow *f, double tolerance_log2, int order, double *h_log2);

/* Since the start: steps, and those of them that ended on a kink. */
long cns_flow_steps(const cns_flow *f);
long cns_flow_landings(const cns_flow *f);

/* States at time t0 <= t <= t1 of the last step; x has one number per state, rounded to its precision. */
void cns_flow_eval(cns_flow *f, const mpq_t t, mpfr_t *x);

/* The dense output of the last step, one state's polynomial: x(t0 + u unit) = sum_k c_k u^k, coefficients
 * 0..*degree, valid until the next step or call. Only after a step. */
mpfr_t *cns_flow_polynomial(cns_flow *f, int state, int *degree, mpfr_t unit);

CNS_END_DECLS

#endif
