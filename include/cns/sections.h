/* Sections: the moments at which a trajectory meets given conditions, found from the polynomials of its
 * steps.
 *
 * A section is a condition on one state: state = value, state = value + k period for any integer k, or an
 * extremum of the state. After each step of a flow the meetings inside it, t0 < t <= t1, are isolated by
 * the polynomial's Bernstein coefficients, not by sampling, and refined to the precision of the flow; two in
 * a step, and one exactly at its end, are both found, each once. Nothing at t = 0 counts.
 *
 * A section may be touched without being crossed. What can be said of that in finite precision is that the
 * distance has an extremum and is there below the noise of the step: then direction is 0. Two crossings
 * whose excursion is below that noise are such a touch, too. */
#ifndef CNS_SECTIONS_H
#define CNS_SECTIONS_H

#include "cns/integrate.h"

typedef enum cns_section_kind {
    CNS_SECTION_VALUE,   /* state = value */
    CNS_SECTION_PERIODS, /* state = value + k period */
    CNS_SECTION_EXTREMUM /* the state's derivative vanishes; value is not used */
} cns_section_kind;

typedef struct cns_section {
    cns_section_kind kind;
    int state;
    cns_number value, period; /* period > 0 */
} cns_section;

typedef struct cns_meeting {
    int section;
    long k;        /* CNS_SECTION_PERIODS: the state is value + k period */
    int direction; /* sign of the change of state (of its derivative, at an extremum: -1 is a maximum); 0:
                      touched only */
    double rate;   /* that change per unit of time */
    mpfr_t time;
    mpfr_t *state; /* all states; the section's own is exactly the value, rounded */
} cns_meeting;

typedef struct cns_sections cns_sections;

/* For flows of programs with n_states states at this precision, of these scales. The sections are copied. */
cns_sections *cns_sections_new(const cns_section *section, int n, int n_states, const double *scales,
                               mpfr_prec_t prec, cns_error *err);
void cns_sections_free(cns_sections *s);

/* After cns_flow_start(). */
void cns_sections_start(cns_sections *s);

/* After each step: finds the meetings in it. */
cns_code cns_sections_follow(cns_sections *s, cns_flow *f, cns_error *err);

/* Those of the last step in order of time; valid until the next call. */
int cns_sections_count(const cns_sections *s);
const cns_meeting *cns_sections_meeting(const cns_sections *s, int i);

void cns_section_init(cns_section *s);
void cns_section_clear(cns_section *s);
void cns_section_set(cns_section *s, const cns_section *from);

#endif
