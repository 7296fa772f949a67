/* What the studies share: the system that a case describes, and what case files say of each study. */
#ifndef CNS_STUDY_H
#define CNS_STUDY_H

#include <signal.h>
#include <stdbool.h>

#include "cns/flow.h"
#include "cns/model.h"
#include "cns/number.h"
#include "cns/program.h"

CNS_BEGIN_DECLS

/* A model with its parameters and initial states, and how to work on it. Everything is borrowed. */
typedef struct cns_study {
    const cns_model *model;
    const cns_number *parameters;  /* model->n_parameters */
    const cns_number *initial;     /* model->n_states */
    const cns_number *smooth;      /* eps of sqrt(a^2 + eps^2) for abs(a); NULL: true absolute values */
    const cns_number *end, *every; /* > 0 */
    const double *scales;          /* model->n_states, the model's own */
    int threads;                   /* >= 1; no result depends on it */
    const volatile sig_atomic_t *stop;
    /* What is going on, as a fraction of the whole and in words; NULL: nobody listens. One call at a time. */
    void (*progress)(void *context, double fraction, const char *what);
    void *context;
} cns_study;

/* A finished program of the study's model with these parameters and this smoothing. */
cns_code cns_study_program(const cns_study *s, cns_program **program, cns_error *err);

void cns_study_progress(const cns_study *s, double fraction, const char *what);

/* Values from `from` towards `to`, per_decade of them in a factor of ten. */
typedef struct cns_decades {
    cns_number from, to; /* > 0, from > to */
    long per_decade;     /* >= 1 */
} cns_decades;

typedef struct cns_laws_spec {
    cns_number delta; /* > 0 */
    int observable;   /* a state, or CNS_OBSERVABLE_NORM */
    bool has_digits, has_steps, has_smoothing;
    struct {
        long from, to, by; /* 1 <= from <= to, by >= 1 */
    } digits;
    struct {
        cns_method method;
        long order;  /* 0: the program's choice; RK4's is 4 */
        long digits; /* of the arithmetic */
        cns_decades sizes;
    } steps;
    cns_decades smoothing;
} cns_laws_spec;

/* The Euclidean distance of the dynamic states, each divided by the model's scale. */
#define CNS_OBSERVABLE_NORM (-1)

typedef struct cns_lyapunov_spec {
    cns_number time; /* > 0 */
    cns_arithmetic arithmetic;
    long digits; /* 0 with arithmetic double */
} cns_lyapunov_spec;

typedef struct cns_bisect_spec {
    int parameter;           /* of the model */
    cns_number lower, upper; /* lower < upper */
    bool by_manifold;        /* else by trajectory */
    long decimals;           /* >= 1 */
} cns_bisect_spec;

CNS_END_DECLS

#endif
