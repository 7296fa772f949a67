/* cns: trajectories of chaotic differential equations, to as many decimals as asked for, every one proven.
 *
 *     #include <stdio.h>
 *     #include <cns/cns.h>
 *
 *     int main(void)
 *     {
 *         cns_error err;
 *         const cns_setting start[] = {{"x", "1"}, {"y", "1"}, {"z", "1"}, {NULL, NULL}};
 *         cns_system *lorenz = cns_system_parse(cns_model_find("lorenz"), start, &err);
 *         if (lorenz == NULL || cns_solve_print(lorenz, "20", "5", 20, stdout, &err) != CNS_OK)
 *             fprintf(stderr, "%s\n", err.text);
 *         cns_system_free(lorenz);
 *     }
 *
 *     cc lorenz.c $(pkg-config --cflags --libs cns)
 *     cc lorenz.c $(pkg-config --static --cflags --libs cns | sed 's/-lcns/-l:libcns.a/')     without
 * libcns.so
 *
 * This file takes all others. To read them, begin with those of the example:
 *
 *     status.h   how functions say that they failed, and why
 *     number.h   numbers, exact, as texts
 *     system.h   equations with their numbers: what is integrated and studied
 *     solve.h    tables of a trajectory and of its events, proven
 *
 * Then what you need:
 *
 *     program.h, model.h   equations of your own; the models that are there
 *     flow.h, events.h     step by step, with the states at any time and the moments that meet a condition
 *     monitor.h            threads, progress, stopping
 *     case.h               case files, as the program `cns` reads them
 *     study/tc.h           how long a run can be trusted;  study/laws.h  against digits, step and smoothing
 *     study/compare.h      two tables
 *     study/lyapunov.h     Lyapunov exponents
 *     study/equilibria.h   fixed points;  study/orbit.h  periodic orbits
 *     study/classify.h     the mode of a motion;  study/sweep.h  for each value of a parameter;
 *     study/bisect.h       the value at which it changes
 *
 * Conventions. A function that can fail returns a cns_code, or NULL for a new object, and leaves one line of
 * text in the cns_error that it is given. Structures that you declare have _init and _clear, objects that the
 * library makes have _free. Texts of type char * in a result belong to it; a char * that a function returns
 * is yours, for free(). Different threads may work at the same time on different objects, and share systems
 * and finished programs, which are only read. */
#ifndef CNS_CNS_H
#define CNS_CNS_H

#include "cns/case.h"
#include "cns/events.h"
#include "cns/flow.h"
#include "cns/model.h"
#include "cns/monitor.h"
#include "cns/number.h"
#include "cns/program.h"
#include "cns/solve.h"
#include "cns/status.h"
#include "cns/study/bisect.h"
#include "cns/study/classify.h"
#include "cns/study/compare.h"
#include "cns/study/equilibria.h"
#include "cns/study/laws.h"
#include "cns/study/lyapunov.h"
#include "cns/study/orbit.h"
#include "cns/study/sweep.h"
#include "cns/study/tc.h"
#include "cns/system.h"

#endif
