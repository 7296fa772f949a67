/* Programs, jets and flows for the suites that test them. */
#ifndef TESTS_PROBLEM_H
#define TESTS_PROBLEM_H

#include <mpfr.h>

#include "cns/flow.h"
#include "cns/model.h"
#include "cns/program.h"
#include "cns/solve.h"
#include "cns/system.h"
#include "num/vector.h"
#include "support.h"
#include "taylor/jet.h"

enum { MAX_SCALES = 64 };
extern const double unit_scales[MAX_SCALES]; /* ones */

cns_number *numbers_new(int n, const char *const *texts);
void numbers_free(cns_number *x, int n);

/* The test fails unless the code is CNS_OK. */
void check_ok(cns_code code, const cns_error *err);

cns_program *program_new(int n_states, const char *smooth); /* no parameters; smooth may be NULL */
cns_program *finished(cns_program *p);                      /* p, finished without an error */

/* A model with its default parameters. */
cns_program *model_program(const char *model, const char *smooth);

/* A model of n states of scale 1, without parameters, whose right-hand sides `build` writes from data. */
cns_model unit_model(int n, void (*build)(cns_program *p, const cns_model *model), const void *data);

/* A system with the model's default parameters, those settings apart (NULL: none); the test fails on errors.
 */
cns_system *system_new(const cns_model *m, const cns_setting *settings);

/* The same of unit_model(), with these initial states. */
cns_system *unit_system(const cns_model *m, const char *const *initial);

cns_jet *jet_new(const cns_program *p, const cns_arith_ops *ops, int order, mpfr_prec_t prec);

/* Taylor, MPFR, adaptive, all scales 1, order and tolerance for so many digits. */
cns_flow_spec taylor_spec(const cns_program *p, long digits);
cns_flow *flow_new(const cns_flow_spec *spec);
cns_flow *flow_started(const cns_flow_spec *spec, const char *const *initial);

/* So many decimals, or significant digits. */
cns_goal goal_of(cns_places places, long count, long max_digits);

/* Steps until time t is reached; x gets the states there. */
cns_code try_flow_to(cns_flow *f, const char *t, mpfr_t *x, cns_error *err);
void flow_to(cns_flow *f, const char *t, mpfr_t *x); /* the test fails on errors */

double log2_of(const mpfr_t x);                       /* log2 |x|; -HUGE_VAL for 0 */
double log2_distance(const mpfr_t x, const mpfr_t y); /* log2 |x - y| */

/* |x - y| < 2^bound, or the test fails and says what was compared. */
#define check_close(x, y, bound, ...)                                                                        \
    do {                                                                                                     \
        double distance_ = log2_distance(x, y);                                                              \
        if (!(distance_ < (bound))) {                                                                        \
            char what_[256], text_[512];                                                                     \
            snprintf(what_, sizeof what_, __VA_ARGS__);                                                      \
            mpfr_snprintf(text_, sizeof text_, "%.50Rg and %.50Rg", x, y);                                   \
            ck_abort_msg("%s: %s differ by 2^%.1f, not less than 2^%.1f", what_, text_, distance_,           \
                         (double)(bound));                                                                   \
        }                                                                                                    \
    } while (0)

#define DECIMALS(d) (-(d)*3.3219280948873623479)

/* What follows t in the row of time t of tests/reference/TABLE: values, between commas; to be freed. */
char *reference_text(const char *table, const char *t);
void reference_row(const char *table, const char *t, mpfr_t *x, int n); /* the first n of them */

#endif
