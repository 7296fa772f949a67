/* What a problem asks for: its rows, and the specs of the runs that answer it. */
#include "num/logs.h"
#include "solve/solve_internal.h"

bool cns_row_time(const cns_problem *p, unsigned long row, mpq_t time)
{
    mpz_t count;
    mpz_init_set_ui(count, row);
    mpq_set_z(time, count);
    mpz_clear(count);
    mpq_mul(time, time, p->every->ratio);
    if (mpq_cmp(time, p->end->ratio) < 0)
        return true;
    /* The end is a row, once: it is this one if the row before was not at the end yet. */
    mpq_sub(time, time, p->every->ratio);
    bool first = row == 0 || mpq_cmp(time, p->end->ratio) < 0;
    mpq_set(time, p->end->ratio);
    return first;
}

bool cns_wants_outputs(const cns_problem *p)
{
    for (int i = 0; i < p->n_columns; i++)
        if (p->columns[i].kind == CNS_COLUMN_OUTPUT)
            return true;
    return false;
}

cns_flow_spec cns_taylor_spec(const cns_problem *p, long digits)
{
    double tolerance = -(double)digits * CNS_LOG2_10;
    return (cns_flow_spec){.program = p->program,
                           .scales = p->scales,
                           .method = CNS_METHOD_TAYLOR,
                           .arithmetic = CNS_ARITH_FAST,
                           .prec = cns_digits_to_bits(digits),
                           .order = cns_order_for(tolerance, CNS_ARITH_FAST),
                           .tolerance_log2 = tolerance,
                           .stop = p->stop};
}

void cns_proof_specs(const cns_problem *p, long digits, const cns_schedule *schedule, long shift,
                     cns_flow_spec *fine, cns_flow_spec *coarse)
{
    *fine = cns_taylor_spec(p, digits);
    *coarse = cns_taylor_spec(p, digits - CNS_PROOF_DIGITS);
    fine->safety = CNS_FINE_SAFETY;
    fine->schedule = coarse->schedule = schedule;
    fine->schedule_shift = shift + CNS_PROOF_DIGITS;
    coarse->schedule_shift = shift;
}

cns_flow_spec cns_given_spec(const cns_problem *p, const cns_numerics *n)
{
    cns_flow_spec given = cns_taylor_spec(p, n->digits > 0 ? n->digits : 16);
    given.method = n->method;
    given.arithmetic = n->arithmetic;
    given.step = n->fixed_step ? &n->step : NULL;
    if (!n->auto_tolerance) {
        mpfr_t x;
        mpfr_init2(x, 64);
        cns_number_get_mpfr(x, &n->tolerance);
        given.tolerance_log2 = cns_log2_mpfr(x);
        mpfr_clear(x);
    }
    given.order = cns_order_for(given.tolerance_log2, given.arithmetic);
    if (n->order > 0)
        given.order = (int)n->order;
    return given;
}
