/* The Lorenz system step by step, to t = 4: its states at any time (dense output), and events, which are here
 * the moments at which z passes 27.
 *
 *     cc dense_output.c $(pkg-config --cflags --libs cns) -o dense_output && ./dense_output
 *
 * This is one run of 40 digits, of which noise has taken a few by t = 4. How many are right, only a second
 * run can tell: cns_solve_goal() makes one.
 */
#include <stdio.h>
#include <stdlib.h>

#include <cns/cns.h>

static cns_error err;

static void check(bool good)
{
    if (!good) {
        fprintf(stderr, "%s\n", err.text);
        exit(1);
    }
}

int main(void)
{
    const cns_setting start[] = {{"x", "1"}, {"y", "1"}, {"z", "1"}, {NULL, NULL}};
    cns_system *lorenz = cns_system_parse(cns_model_find("lorenz"), start, &err);
    check(lorenz != NULL);
    const double *scales = cns_system_scales(lorenz);
    const cns_flow_spec spec = cns_flow_spec_taylor(cns_system_program(lorenz), scales, CNS_ARITH_FAST, 40);
    cns_flow *flow = cns_flow_new(&spec, &err);
    check(flow != NULL);
    cns_event_condition plane; /* a state, here number 2 of x, y, z, that has a value */
    cns_event_condition_init(&plane);
    plane.state = 2;
    cns_number_parse(&plane.value, "27", &err);
    cns_meetings *meetings = cns_meetings_new(&plane, 1, cns_flow_states(flow), scales, spec.prec, &err);
    check(meetings != NULL);

    mpq_t t;
    mpfr_t x[3];
    mpq_init(t);
    mpfr_inits2(spec.prec, x[0], x[1], x[2], (mpfr_ptr)0);
    cns_flow_start(flow, cns_system_initial(lorenz));
    cns_meetings_start(meetings);
    for (double wanted = 0; wanted <= 4;) { /* the states are printed at multiples of 1/2 */
        check(cns_flow_step(flow, &err) == CNS_OK);
        check(cns_meetings_follow(meetings, flow, &err) == CNS_OK);
        for (int i = 0; i < cns_meetings_count(meetings); i++) {
            const cns_meeting *m = cns_meetings_meeting(meetings, i);
            mpfr_printf("event %.20RNf %.20RNf %.20RNf %d\n", m->time, m->state[0], m->state[1],
                        m->direction);
        }
        for (; wanted <= 4 && mpfr_cmp_d(cns_flow_end(flow), wanted) >= 0; wanted += 0.5) {
            mpq_set_d(t, wanted);
            cns_flow_eval(flow, t, x);
            mpfr_printf("state %g %.20RNf %.20RNf %.20RNf\n", wanted, x[0], x[1], x[2]);
        }
    }
    mpfr_clears(x[0], x[1], x[2], (mpfr_ptr)0);
    mpq_clear(t);
    cns_meetings_free(meetings);
    cns_event_condition_clear(&plane);
    cns_flow_free(flow);
    cns_system_free(lorenz);
    return 0;
}
