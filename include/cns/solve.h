/* Whole trajectories, as rows and events: by a goal, or by given numerics with or without a proof.
 *
 * A goal is proven by an enclosure: bounds of the error of the one run, rounded up, which are theorems
 * (src/integrate/tube.h has the method, and says on what they rest). A text is proven when value - e and
 * value + e both have it, e being the bound of that value.
 *
 * Where there is no enclosure, or on demand, proof is Clean Numerical Simulation's own criterion, convergence
 * under refinement, strengthened: strong evidence, and no theorem. Every value is computed by two runs that
 * differ in precision (by at least one limb), order, safety factor and hence every step, with every constant
 * converted anew from its text. The finer run is told. Its error is at most e, which is 16 times the largest
 * difference of the two runs in any state or derived quantity, or 16 times what the measured growth makes of
 * the coarser run's noise, whichever is larger. Two more checks make an error of the program, rather than
 * chaos, show itself: the difference must be explained by noise times measured growth, and after every step
 * of both runs the derivative of the series must be the right-hand side evaluated pointwise. */
#ifndef CNS_SOLVE_H
#define CNS_SOLVE_H

#include <stdio.h>

#include "cns/events.h"
#include "cns/flow.h"
#include "cns/monitor.h"
#include "cns/number.h"
#include "cns/system.h"

CNS_BEGIN_DECLS

/* A column of the table: a state, a derived quantity, or the time. */
typedef enum cns_column_kind { CNS_COLUMN_TIME, CNS_COLUMN_STATE, CNS_COLUMN_OUTPUT } cns_column_kind;
typedef struct cns_column {
    cns_column_kind kind;
    int index; /* of the state or output */
} cns_column;

/* How decimals are proven. */
typedef enum cns_proof_kind {
    CNS_PROOF_ENCLOSURE, /* by bounds of the error of the one run, which are theorems; from where on there is
                            no such bound, by two runs */
    CNS_PROOF_TWO_RUNS,  /* by a second run of other precision, order and steps, and the measured growth of
                            noise */
    CNS_PROOF_NONE       /* of given numerics: not at all; no goal has it */
} cns_proof_kind;

typedef struct cns_goal {
    long decimals, significant; /* right ones in every value: one of the two is above 0, the other is 0 */
    cns_proof_kind proof;
    long max_digits; /* of the printed run; 0: no limit */
    double max_time; /* seconds; 0: no limit */
} cns_goal;

#define CNS_PLAN_PARTS 64

/* How a run is done, resolved: for provenance and messages. */
typedef struct cns_run_info {
    long attempt; /* 1.. */
    long digits;  /* of the printed run; 0: double */
    mpfr_prec_t prec;
    int order;
    bool enclosed;     /* the proof is an enclosure: the following three are 0 */
    char why_not[256]; /* in the attempt that follows an enclosure that has ended: why it has; else empty */
    long proof_digits; /* of the coarser run; 0: no proof by two runs */
    mpfr_prec_t proof_prec;
    int proof_order;
    const char *kernel;    /* of the printed run's arithmetic: avx512ifma, portable, mpfr, double */
    double steps, seconds; /* predicted: of the printed run; of both, on a machine with nothing else to do. 0:
                              no prediction */
    bool planned;          /* by goal: the following are predictions, too */
    double followed;       /* the last time that the preliminary run reached */
    double growth;         /* log10 of the largest growth of noise expected */
    double margin;         /* digits added for its fluctuation */
    /* The fraction of these seconds that is over at the end of each of so many equal parts of the time. */
    double done[CNS_PLAN_PARTS];
    double memory; /* bytes, the program itself and its libraries with it */
} cns_run_info;

/* A run of more steps than this is refused, unless a time is set after which it gives up: in double it would
 * take the better part of an hour at least, in many digits a day and more. */
#define CNS_MOST_STEPS 1e10

typedef struct cns_row {
    /* One per column. The time is exact where it is a finite decimal; else it is the fraction nearest to its
     * text of those with a denominator up to the largest that any row's time has. */
    char **text;
    long decimals; /* proven; -1: no proof */
    double growth;
} cns_row;

/* A meeting of the trajectory with a condition (cns/events.h), after the start and up to the end. Against
 * time, too, its direction is that of a change with time. Both runs of a proof find theirs independently; the
 * i-th meeting with each condition must be the same in both, and e bounds the error of its time and states.
 * The noise in e is carried along the flow to the meeting: slow crossings lose digits. */
typedef struct cns_event {
    int condition; /* which of the problem's */
    long k;        /* see cns_meeting */
    int direction; /* -1, 1; 0: touched */
    char *time;
    char **state;  /* one per state */
    long decimals; /* proven, or significant digits where those are asked for; -1: no proof */
} cns_event;

/* What a run reports, while it goes on. Any function may be NULL. A sink's failure ends the run. */
typedef struct cns_sink {
    void *context;
    /* Each attempt at a goal. Rows that were told before are final; events are told anew, from t = 0. */
    cns_code (*begin)(void *context, const cns_run_info *run, cns_error *err);
    cns_code (*row)(void *context, const cns_row *row, cns_error *err);
    cns_code (*event)(void *context, const cns_event *event, cns_error *err); /* in order of time */
} cns_sink;

/* A system, and the rows and events wanted of its trajectory. All is borrowed. */
typedef struct cns_problem {
    const cns_system *system;
    /* Times are those that have passed since the start (cns_system_from()), which is 0 unless it is moved. */
    const cns_number *end;   /* rational, > 0 */
    const cns_number *every; /* rows at its multiples and at the end; rational, > 0; NULL: at 0 and the end */
    const cns_number
        *at; /* rows at these n_at times instead, increasing, >= 0, the last being `end`; NULL: none */
    int n_at;
    const cns_column *columns; /* n_columns of them; NULL: the time and all states */
    int n_columns;
    const cns_event_condition *conditions; /* whose meetings are wanted, too; NULL: none */
    int n_conditions;
    const cns_monitor *monitor; /* more than one thread: the two runs of a proof side by side */
    const cns_sink *sink;       /* NULL: nobody wants to see them */
} cns_problem;

typedef struct cns_result {
    cns_run_info run;     /* of the last attempt */
    long steps, landings; /* of the printed run; landings are steps that end on a kink */
    long rows;
    long decimals;        /* the least proven in any row; -1: no proof, or no row */
    bool complete;        /* all rows are there */
    bool reached;         /* and, of a goal: no row and no event has fewer places than asked for */
    cns_error events_end; /* CNS_UNREACHED: the two runs differ from some event on (a touch that may be no
                             meeting, or two), and those after it were not told */
    double end;           /* the last row's time, rounded */
    double wall_s;
} cns_result;

/* The rows and events of a problem, to its sink. CNS_UNREACHED: the table is honest but falls short of the
 * goal (err says how), or the time allowed is used up; CNS_USAGE: times that are not rational and positive, a
 * count below 1, times that do not increase, numerics that take more than CNS_MOST_STEPS (err says what would
 * do); CNS_NUMERIC: a singularity, a plan that takes as many steps, or an error that the proof found;
 * CNS_STOPPED by the monitor; or what the sink returned. */
cns_code cns_solve_goal(const cns_problem *p, const cns_goal *goal, cns_result *result, cns_error *err);
cns_code cns_solve_numerics(const cns_problem *p, const cns_numerics *numerics, bool prove,
                            cns_result *result, cns_error *err);

/* Time, states and derived quantities at t = 0, every, 2 every, ... and end, proven to so many decimals, as
 * lines of comma-separated values after a line of names: the simplest use of cns_solve_goal(), rows being
 * written to `out` as they are proven. Times are texts (see number.h), rational and > 0; every NULL: at 0 and
 * the end.
 */
cns_code cns_solve_print(const cns_system *s, const char *end, const char *every, long decimals, FILE *out,
                         cns_error *err);

/* What a goal needs, from a preliminary run in double with tangents: see plan.c.
 * schedule->digits has room for CNS_PLAN_PARTS numbers: the digits of the coarser run by time,
 * plan->proof_digits being the most. A preliminary run that fails is no error: plan->followed is then below
 * the end, and err says why. */
cns_code cns_plan(const cns_problem *p, const cns_goal *goal, cns_run_info *plan, cns_schedule *schedule,
                  cns_error *err);

CNS_END_DECLS

#endif
