/* The Runge-Kutta method in double precision against twenty lines of C: the disk to t = 100 with steps of
 * 1e-4. Both times are of the processor, medians of runs in turn; the results agree as far as rounding lets
 * them.
 *
 * usage: bench_rk4 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cns/cns.h"
#include "core/clock.h"

enum { X, Y, THETA, VX, VY, OMEGA, N, TURNS = 5, STEPS = 1000000 };
static const char *const initial[N] = {"0", "0", "1", "0", "0.01", "1"};
static double sink[N]; /* the library's last row */

static void slopes(const double *u, double *f)
{
    const double I = 2.2, CT = 1.2, pi = 3.14159265358979323846, A = 1.4, B = 1, mu1 = 0.2, mu2 = 0.2;
    const double s = hypot(u[VX], u[VY]), sine = sin(u[THETA]), cosine = cos(u[THETA]);
    const double gamma = 2 / pi * (pi * u[OMEGA] - CT * u[VX] * u[VY] / s);
    const double drag = (A * s - B * (u[VX] * u[VX] - u[VY] * u[VY]) / s) / pi;
    f[X] = u[VX] * cosine - u[VY] * sine;
    f[Y] = u[VX] * sine + u[VY] * cosine;
    f[THETA] = u[OMEGA];
    f[VX] = (((I + 1) * u[OMEGA] - gamma) * u[VY] - sine - drag * u[VX]) / I;
    f[VY] = ((gamma - I * u[OMEGA]) * u[VX] - cosine - drag * u[VY]) / (I + 1);
    f[OMEGA] = (-u[VX] * u[VY] - (mu1 + mu2 * fabs(u[OMEGA])) * u[OMEGA]) / ((I + 0.5) / 4);
}

static void by_hand(double *u, double h)
{
    double f[4][N], v[N];
    for (long step = 0; step < STEPS; step++) {
        slopes(u, f[0]);
        for (int stage = 1; stage < 4; stage++) {
            for (int i = 0; i < N; i++)
                v[i] = u[i] + (stage < 3 ? h / 2 : h) * f[stage - 1][i];
            slopes(v, f[stage]);
        }
        for (int i = 0; i < N; i++)
            u[i] += h / 6 * (f[0][i] + 2 * f[1][i] + 2 * f[2][i] + f[3][i]);
    }
}

static cns_code keep(void *context, const cns_row *row, cns_error *err)
{
    (void)context, (void)err;
    for (int i = 0; i < N; i++)
        sink[i] = strtod(row->text[1 + i], NULL);
    return CNS_OK;
}

static void by_library(const cns_system *s, const cns_numerics *n)
{
    cns_number end;
    cns_error err;
    cns_result result;
    const cns_sink rows = {.row = keep};
    const cns_problem p = {.system = s, .end = &end, .sink = &rows};
    cns_number_init(&end);
    if (cns_number_parse(&end, "100", &err) || cns_solve_numerics(&p, n, false, &result, &err)) {
        fprintf(stderr, "bench_rk4: %s\n", err.text);
        exit(1);
    }
    cns_number_clear(&end);
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int main(void)
{
    static const cns_setting settings[] = {{"theta", "1"}, {"Vy", "0.01"}, {"omega", "1"}, {NULL, NULL}};
    cns_numerics n = {.method = CNS_METHOD_RK4, .arithmetic = CNS_ARITH_DOUBLE};
    cns_error err;
    cns_system *s = cns_system_parse(cns_model_find("apw"), settings, &err);
    double hand[TURNS], library[TURNS], u[N], apart = 0;
    cns_number_init(&n.step);
    cns_number_init(&n.tolerance);
    if (!s || cns_number_parse(&n.step, "1e-4", &err)) {
        fprintf(stderr, "bench_rk4: %s\n", err.text);
        return 1;
    }
    for (int turn = 0; turn < TURNS; turn++) {
        for (int i = 0; i < N; i++)
            u[i] = strtod(initial[i], NULL);
        const double a = cns_process_seconds();
        by_hand(u, 1e-4);
        const double b = cns_process_seconds();
        by_library(s, &n);
        hand[turn] = b - a;
        library[turn] = cns_process_seconds() - b;
    }
    for (int i = 0; i < N; i++)
        apart = fmax(apart, fabs(u[i] - sink[i]));
    qsort(hand, TURNS, sizeof *hand, ascending);
    qsort(library, TURNS, sizeof *library, ascending);
    printf("a million steps: by hand %.3f s, cns %.3f s, ratio %.2f; results within %.0e\n", hand[TURNS / 2],
           library[TURNS / 2], library[TURNS / 2] / hand[TURNS / 2], apart);
    cns_number_clear(&n.step);
    cns_number_clear(&n.tolerance);
    cns_system_free(s);
    return 0;
}
