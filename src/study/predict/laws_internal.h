/* What the files of the laws share. The work goes like this: jobs are listed, one for each point of each law
 * (laws.c); the reference is made, long enough for the point that should last longest (laws_reference.c); all
 * jobs run against it (laws_runs.c), and if one outlasts it both are done again, longer; lines are fitted to
 * what was found (laws_fit.c). Private to src/study/predict. */
#ifndef CNS_STUDY_PREDICT_LAWS_INTERNAL_H
#define CNS_STUDY_PREDICT_LAWS_INTERNAL_H

#include "cns/study/laws.h"

enum {
    CNS_LAWS_KEPT_DIGITS = 40, /* of a reference's states: they are compared with delta only */
    CNS_LAWS_KEPT_BITS = 160,
    CNS_LAWS_FINE_DIGITS = 34,  /* of the continuation inside an interval */
    CNS_LAWS_CHECK_DIGITS = 10, /* that the second reference has fewer: another limb, another order */
    CNS_LAWS_TRUST_DIGITS = 6   /* by which the reference's own error stays below delta */
};

/* The reference at multiples of `every`. */
typedef struct cns_law_reference {
    long digits;
    int rows;
    mpfr_t *state; /* n per row, and the envelope of the observable up to it (0 where there is none) */
    double *growth, *error;
} cns_law_reference;

/* A run: a point of a law, or the second reference, which checks the first. */
#define CNS_LAW_CHECK CNS_LAW_KINDS
typedef struct cns_law_job {
    cns_law_kind kind;
    char *text; /* of the value */
    double x;
    cns_number value; /* the step or eps */
    long digits;
    double level;     /* digits of growth that it should bear */
    const char *skip; /* why it is not run; NULL: it is */
    double predicted; /* T_c, roughly */
} cns_law_job;

typedef struct cns_laws_work {
    const cns_problem *problem;
    const cns_system *system; /* the reference's: the problem's own */
    const cns_laws_spec *spec;
    const char *directory;
    char *identity;
    int n; /* states */
    double every, delta_log10;
    int order;
    int jobs;
    cns_law_job *job;
    int *listed, n_listed; /* the jobs that are run */
    double level;          /* growth at which the reference ends */
    cns_law_reference ref;
    /* progress of the two ensembles as one */
    cns_monitor inner;
    double base, span;
} cns_laws_work;

/* Noise that is made late has less time to grow: a reference that began with so many digits can do with fewer
 * by as many as growth has used. What that leaves of its accuracy is measured like all noise, by its tangents
 * and by the second reference. */
typedef struct cns_falling {
    cns_schedule schedule; /* what a flow is told, of one part */
    long begun, digits;
} cns_falling;

double cns_laws_log10(const cns_number *x);

/* The reference. */
void cns_laws_row_time(const cns_laws_work *l, int row, mpq_t t);
int cns_laws_last_row(const cns_laws_work *l); /* that the end allows; rows are multiples of `every` only */
cns_flow_spec cns_laws_taylor(const cns_laws_work *l, const cns_system *s, long digits, double safety);
void cns_falling_init(cns_falling *f, long digits);
void cns_falling_follow(cns_falling *f, double growth);
cns_code cns_laws_make_reference(cns_laws_work *l, cns_error *err); /* instead of the one there was */
void cns_laws_reference_clear(cns_law_reference *r);
double cns_laws_growth_at(const cns_laws_work *l, double t);

/* Runs. results[i] is that of job listed[i]: "tc T", "beyond" with log10 of the largest distance, or "failed"
 * and why. */
cns_code cns_laws_run_all(cns_laws_work *l, char **results, cns_error *err);
/* log10 of the truncation error of the first step size after a while, by a run of the method against a
 * Taylor run: what smaller steps are predicted from. */
cns_code cns_laws_probe(const cns_laws_work *l, const cns_law_job *first, double *truncation, cns_error *err);

/* Lines. */
cns_code cns_laws_conclude(const cns_laws_work *l, char **results, cns_laws_result *r, cns_error *err);

#endif
