/* Tables of events: the moments at which a trajectory meets given sections, with the states there.
 *
 * Under a proof two runs of different precision, order and steps find their events independently. The i-th
 * meeting with each section must be the same in both; e = 16 max(their difference, what the measured growth
 * makes of the coarser run's noise, carried along the flow to the section) bounds the error of time and
 * states, and a text is right when value - e and value + e both have it. Where the runs disagree on what
 * happens (a touch that may be no meeting, or two), the table ends before. */
#ifndef CNS_EVENTS_H
#define CNS_EVENTS_H

#include "cns/solve.h"
#include "integrate/meetings.h"

typedef struct cns_event {
    int section;
    long k;        /* see sections.h */
    int direction; /* -1, 1; 0: touched */
    char *time;
    char **state;  /* texts, n_states */
    long decimals; /* proven; -1: no proof */
} cns_event;

typedef struct cns_events {
    int n, n_states;
    cns_event *event;
} cns_events;

/* How to run. Proven: digits > 0, the digits of the finer run of a goal that has been reached, and the places
 * wanted. By given numerics: numerics, and prove or not. */
typedef struct cns_events_spec {
    const cns_event_condition *sections;
    int n_sections;
    long digits;
    cns_places places;
    long count;
    const cns_numerics *numerics; /* NULL: by digits */
    bool prove;
} cns_events_spec;

/* Events in 0 < t <= the problem's end. CNS_UNREACHED: the two runs differ from some event on; the events
 * before it stand. */
cns_code cns_solve_events(const cns_problem *p, const cns_events_spec *spec, cns_events *events,
                          cns_error *err);
void cns_events_clear(cns_events *events);

#endif
