/* What a method must do: one step, and its dense output. Private to src/integrate. */
#ifndef CNS_INTEGRATE_METHOD_H
#define CNS_INTEGRATE_METHOD_H

#include "cns/flow.h"
#include "num/vector.h"
#include "taylor/jet.h"

typedef struct cns_step {
    mpfr_t h;            /* out: the length of the step, at the precision of time; in: see limit */
    double t0;           /* in: when it begins */
    const mpfr_t *limit; /* fixed step: the step to take unless a kink comes first; NULL: choose */
    bool landed;         /* out */
    double noise_log2;   /* out: log2 of the step's own error, rounding or truncation, in scales */
} cns_step;

typedef struct cns_stepper cns_stepper;

typedef struct cns_method_ops {
    const char *name;
    cns_stepper *(*create)(const cns_flow_spec *spec, cns_error *err);
    void (*destroy)(cns_stepper *s);
    size_t (*bytes)(const cns_stepper *s); /* of memory that it holds */
    /* As cns_flow_reach(); NULL if the method chooses no steps. */
    bool (*reach)(const cns_stepper *s, double tolerance_log2, int order, double *h_log2);
    void (*start)(cns_stepper *s);
    /* From x to y, both of one number per state at the flow's precision. */
    cns_code (*step)(cns_stepper *s, cns_step *step, mpfr_t *x, mpfr_t *y, cns_error *err);
    /* Up to `most` steps of length h from x, in place, with the same results as `step`, for as long as no
     * |x_i| reaches bound_i; returns how many it made. Nothing can be asked between them, or of the last one.
     * NULL: there is nothing faster than `step`. */
    long (*stride)(cns_stepper *s, const mpfr_t h, const double *bound, long most, mpfr_t *x);
    /* States at tau after the beginning of the last step, 0 <= tau <= h. */
    void (*eval)(cns_stepper *s, const mpfr_t tau, mpfr_t *x);
    /* The same as a polynomial: coefficients 0..*degree of state i in tau/unit, valid until the next call. */
    mpfr_t *(*polynomial)(cns_stepper *s, int i, int *degree, mpfr_t unit);
    /* Derivatives of the states at tau, from the dense output; NULL if the method cannot tell. *tolerance is
     * set to a bound on their error from rounding and truncation. */
    void (*derivative)(cns_stepper *s, const mpfr_t tau, mpfr_t *dx, mpfr_t tolerance);
    /* The expansion of the last step, in tau = (t - t0)/H; NULL if the method has none. */
    const cns_jet *(*expansion)(const cns_stepper *s, double *H);
} cns_method_ops;

extern const cns_method_ops cns_method_taylor;
extern const cns_method_ops cns_method_rk4;

/* The expansion of a flow's last step; NULL: it has none. */
const cns_jet *cns_flow_expansion(const cns_flow *f, double *H);

#endif
