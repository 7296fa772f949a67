/* The engine's overhead: one expansion of the falling disk through cns_jet in MPFR arithmetic, against the
 * same recurrences written out by hand with the same MPFR calls. Both take turns; medians are compared. */
#include <mpfr.h>
#include <stdio.h>
#include <stdlib.h>

#include "cns/flow.h"
#include "cns/model.h"
#include "core/clock.h"
#include "integrate/numerics.h"
#include "taylor/jet.h"

enum { X, Y, THETA, VX, VY, OMEGA, STATES };

/* The series of the hand-written loop. */
enum {
    SIN = STATES, /* sin theta, cos theta */
    COS,
    OMEGA_K, /* k omega_{k-1}, that is, k theta_k */
    VX2,     /* squares, shared by s and e */
    VY2,
    S,    /* sqrt(Vx^2 + Vy^2) */
    VXVY, /* shared by r and the torque */
    R,    /* Vx Vy / s */
    E,    /* (Vx^2 - Vy^2) / s */
    GX,   /* (I+1) omega - Gamma */
    GY,   /* Gamma - I omega */
    F,    /* (A s - B e) / pi */
    SERIES
};
enum { GX_OMEGA, GY_OMEGA, TURN, A_PI, B_PI, OVER_I, OVER_I1, OVER_Q, MU1, MU2, CONSTANTS };

static const char *const start[STATES] = {"0", "0", "1.7", "-0.45", "-0.3", "0.6"};

typedef struct hand {
    int order;
    mpfr_t *c; /* coefficient k of series a is c[a (order+1) + k] */
    mpfr_t constant[CONSTANTS];
    mpfr_t acc, acc2, term;
} hand;

static mpfr_t *series(hand *h, int a)
{
    return h->c + (size_t)a * ((size_t)h->order + 1);
}

static void hand_init(hand *h, int order, mpfr_prec_t prec)
{
    mpfr_t pi;
    h->order = order;
    size_t n = SERIES * ((size_t)order + 1);
    h->c = malloc(n * sizeof *h->c);
    if (!h->c)
        exit(1);
    for (size_t i = 0; i < n; i++)
        mpfr_init2(h->c[i], prec);
    for (int i = 0; i < CONSTANTS; i++)
        mpfr_init2(h->constant[i], prec);
    mpfr_inits2(prec, pi, h->acc, h->acc2, h->term, (mpfr_ptr)0);
    mpfr_const_pi(pi, MPFR_RNDN);
    mpfr_set_str(h->constant[GX_OMEGA], "1.2", 10, MPFR_RNDN); /* I + 1 - 2 CR/pi, CR = pi */
    mpfr_set_str(h->constant[GY_OMEGA], "-0.2", 10, MPFR_RNDN);
    mpfr_set_str(h->constant[TURN], "2.4", 10, MPFR_RNDN); /* 2 CT/pi */
    mpfr_div(h->constant[TURN], h->constant[TURN], pi, MPFR_RNDN);
    mpfr_set_str(h->constant[A_PI], "1.4", 10, MPFR_RNDN);
    mpfr_div(h->constant[A_PI], h->constant[A_PI], pi, MPFR_RNDN);
    mpfr_ui_div(h->constant[B_PI], 1, pi, MPFR_RNDN);
    mpfr_set_str(h->constant[OVER_I], "2.2", 10, MPFR_RNDN);
    mpfr_ui_div(h->constant[OVER_I], 1, h->constant[OVER_I], MPFR_RNDN);
    mpfr_set_str(h->constant[OVER_I1], "3.2", 10, MPFR_RNDN);
    mpfr_ui_div(h->constant[OVER_I1], 1, h->constant[OVER_I1], MPFR_RNDN);
    mpfr_set_str(h->constant[OVER_Q], "0.675", 10, MPFR_RNDN); /* (I + 1/2)/4 */
    mpfr_ui_div(h->constant[OVER_Q], 1, h->constant[OVER_Q], MPFR_RNDN);
    mpfr_set_str(h->constant[MU1], "0.2", 10, MPFR_RNDN);
    mpfr_set(h->constant[MU2], h->constant[MU1], MPFR_RNDN);
    mpfr_clear(pi);
}

static void hand_clear(hand *h)
{
    for (size_t i = 0; i < SERIES * ((size_t)h->order + 1); i++)
        mpfr_clear(h->c[i]);
    for (int i = 0; i < CONSTANTS; i++)
        mpfr_clear(h->constant[i]);
    mpfr_clears(h->acc, h->acc2, h->term, (mpfr_ptr)0);
    free(h->c);
}

/* acc +- sum_{j=lo..n} a_j b_{n-j} */
static void convolve(hand *h, mpfr_t acc, int subtract, const mpfr_t *a, const mpfr_t *b, int n, int lo)
{
    if (subtract)
        for (int j = lo; j <= n; j++) {
            mpfr_mul(h->term, a[j], b[n - j], MPFR_RNDN);
            mpfr_sub(acc, acc, h->term, MPFR_RNDN);
        }
    else
        for (int j = lo; j <= n; j++) {
            mpfr_mul(h->term, a[j], b[n - j], MPFR_RNDN);
            mpfr_add(acc, acc, h->term, MPFR_RNDN);
        }
}

/* acc = sum_{j=lo..n-lo} a_j a_{n-j}, in half the products. */
static void half_square(hand *h, mpfr_t acc, const mpfr_t *a, int n, int lo)
{
    int j = lo;
    mpfr_set_zero(acc, 1);
    for (; 2 * j < n; j++) {
        mpfr_mul(h->term, a[j], a[n - j], MPFR_RNDN);
        mpfr_add(acc, acc, h->term, MPFR_RNDN);
    }
    mpfr_mul_2ui(acc, acc, 1, MPFR_RNDN);
    if (2 * j == n) {
        mpfr_sqr(h->term, a[j], MPFR_RNDN);
        mpfr_add(acc, acc, h->term, MPFR_RNDN);
    }
}

static void hand_expand(hand *h)
{
    mpfr_t *theta = series(h, THETA), *vx = series(h, VX), *vy = series(h, VY), *omega = series(h, OMEGA);
    mpfr_t *x = series(h, X), *y = series(h, Y), *sn = series(h, SIN), *cs = series(h, COS),
           *dt = series(h, OMEGA_K);
    mpfr_t *vx2 = series(h, VX2), *vy2 = series(h, VY2), *s = series(h, S), *vxvy = series(h, VXVY);
    mpfr_t *r = series(h, R), *e = series(h, E), *gx = series(h, GX), *gy = series(h, GY), *f = series(h, F);
    mpfr_t *C = h->constant;
    mpfr_ptr acc = h->acc, acc2 = h->acc2, term = h->term;
    for (int i = 0; i < STATES; i++)
        mpfr_set_str(series(h, i)[0], start[i], 10, MPFR_RNDN);
    int sign = mpfr_sgn(omega[0]);
    for (int k = 0; k < h->order; k++) {
        unsigned long k1 = (unsigned long)k + 1;
        /* n sin_n = sum j theta_j cos_{n-j},  n cos_n = -sum j theta_j sin_{n-j} */
        if (k == 0) {
            mpfr_sin_cos(sn[0], cs[0], theta[0], MPFR_RNDN);
            mpfr_set_zero(dt[0], 1);
        } else {
            mpfr_mul_ui(dt[k], theta[k], (unsigned long)k, MPFR_RNDN);
            mpfr_set_zero(acc, 1);
            convolve(h, acc, 0, dt, cs, k, 1);
            mpfr_div_ui(sn[k], acc, (unsigned long)k, MPFR_RNDN);
            mpfr_set_zero(acc, 1);
            convolve(h, acc, 1, dt, sn, k, 1);
            mpfr_div_ui(cs[k], acc, (unsigned long)k, MPFR_RNDN);
        }
        half_square(h, vx2[k], vx, k, 0);
        half_square(h, vy2[k], vy, k, 0);
        /* 2 s_0 s_n = q_n - sum_{0<j<n} s_j s_{n-j} */
        if (k == 0) {
            mpfr_hypot(s[0], vx[0], vy[0], MPFR_RNDN);
        } else {
            half_square(h, acc, s, k, 1);
            mpfr_add(acc2, vx2[k], vy2[k], MPFR_RNDN);
            mpfr_sub(acc, acc2, acc, MPFR_RNDN);
            mpfr_div(s[k], acc, s[0], MPFR_RNDN);
            mpfr_div_2ui(s[k], s[k], 1, MPFR_RNDN);
        }
        mpfr_set_zero(vxvy[k], 1);
        convolve(h, vxvy[k], 0, vx, vy, k, 0);
        mpfr_set(acc, vxvy[k], MPFR_RNDN);
        convolve(h, acc, 1, s, r, k, 1);
        mpfr_div(r[k], acc, s[0], MPFR_RNDN);
        mpfr_sub(acc, vx2[k], vy2[k], MPFR_RNDN);
        convolve(h, acc, 1, s, e, k, 1);
        mpfr_div(e[k], acc, s[0], MPFR_RNDN);
        mpfr_mul(term, C[TURN], r[k], MPFR_RNDN);
        mpfr_mul(gx[k], C[GX_OMEGA], omega[k], MPFR_RNDN);
        mpfr_add(gx[k], gx[k], term, MPFR_RNDN);
        mpfr_mul(gy[k], C[GY_OMEGA], omega[k], MPFR_RNDN);
        mpfr_sub(gy[k], gy[k], term, MPFR_RNDN);
        mpfr_mul(f[k], C[A_PI], s[k], MPFR_RNDN);
        mpfr_mul(term, C[B_PI], e[k], MPFR_RNDN);
        mpfr_sub(f[k], f[k], term, MPFR_RNDN);

        mpfr_set_zero(acc, 1);
        convolve(h, acc, 0, gx, vy, k, 0);
        convolve(h, acc, 1, f, vx, k, 0);
        mpfr_sub(acc, acc, sn[k], MPFR_RNDN);
        mpfr_mul(acc, acc, C[OVER_I], MPFR_RNDN);
        mpfr_div_ui(vx[k + 1], acc, k1, MPFR_RNDN);
        mpfr_set_zero(acc, 1);
        convolve(h, acc, 0, gy, vx, k, 0);
        convolve(h, acc, 1, f, vy, k, 0);
        mpfr_sub(acc, acc, cs[k], MPFR_RNDN);
        mpfr_mul(acc, acc, C[OVER_I1], MPFR_RNDN);
        mpfr_div_ui(vy[k + 1], acc, k1, MPFR_RNDN);
        half_square(h, acc, omega, k, 0);
        mpfr_mul(acc, acc, C[MU2], MPFR_RNDN);
        if (sign < 0)
            mpfr_neg(acc, acc, MPFR_RNDN);
        mpfr_mul(term, C[MU1], omega[k], MPFR_RNDN);
        mpfr_add(acc, acc, term, MPFR_RNDN);
        mpfr_add(acc, acc, vxvy[k], MPFR_RNDN);
        mpfr_neg(acc, acc, MPFR_RNDN);
        mpfr_mul(acc, acc, C[OVER_Q], MPFR_RNDN);
        mpfr_div_ui(omega[k + 1], acc, k1, MPFR_RNDN);
        mpfr_div_ui(theta[k + 1], omega[k], k1, MPFR_RNDN);
        mpfr_set_zero(acc, 1);
        convolve(h, acc, 0, vx, cs, k, 0);
        convolve(h, acc, 1, vy, sn, k, 0);
        mpfr_div_ui(x[k + 1], acc, k1, MPFR_RNDN);
        mpfr_set_zero(acc, 1);
        convolve(h, acc, 0, vx, sn, k, 0);
        convolve(h, acc, 0, vy, cs, k, 0);
        mpfr_div_ui(y[k + 1], acc, k1, MPFR_RNDN);
    }
}

static void engine_expand(cns_jet *J, int order, mpfr_t *state)
{
    cns_error err;
    cns_jet_begin(J, 1);
    for (int i = 0; i < STATES; i++)
        cns_jet_set_state(J, i, state[i]);
    if (cns_jet_expand(J, order, &err)) {
        fprintf(stderr, "bench: %s\n", err.text);
        exit(1);
    }
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *x, int n)
{
    qsort(x, (size_t)n, sizeof *x, by_size);
    return x[n / 2];
}

/* The two expansions must be the same in at least half the bits, or the times mean nothing. */
static void check_same(hand *h, const cns_jet *J, mpfr_prec_t prec)
{
    mpfr_t y, bound;
    mpfr_inits2(prec, y, bound, (mpfr_ptr)0);
    for (int i = 0; i < STATES; i++) {
        mpfr_ptr x = series(h, i)[h->order];
        cns_jet_coefficient(J, y, i, h->order);
        mpfr_sub(y, y, x, MPFR_RNDN);
        mpfr_div_2si(bound, x, (long)prec / 2, MPFR_RNDN);
        if (mpfr_cmpabs(y, bound) > 0) {
            fprintf(stderr, "bench: coefficient %d of state %d differs\n", h->order, i);
            exit(1);
        }
    }
    mpfr_clears(y, bound, (mpfr_ptr)0);
}

/* Processor time: other programs do not count. */
static void run(const cns_program *program, long digits, int order, double seconds)
{
    enum { MOST = 1001 };
    static double engine[MOST], byhand[MOST], ratio[MOST];
    const mpfr_prec_t prec = cns_digits_to_bits(digits);
    cns_error err;
    cns_jet_spec spec = {.program = program, .ops = &cns_arith_mpfr, .order = order, .prec = prec};
    cns_jet *J = cns_jet_new(&spec, &err);
    if (!J) {
        fprintf(stderr, "bench: %s\n", err.text);
        exit(1);
    }
    mpfr_t state[STATES];
    hand h;
    hand_init(&h, order, prec);
    for (int i = 0; i < STATES; i++)
        mpfr_init2(state[i], prec);
    for (int i = 0; i < STATES; i++)
        mpfr_set_str(state[i], start[i], 10, MPFR_RNDN);
    engine_expand(J, order, state);
    hand_expand(&h);
    check_same(&h, J, prec);
    int n = 0;
    for (double from = cns_process_seconds(); n < MOST && (n < 9 || cns_process_seconds() - from < seconds);
         n++) {
        double t[3];
        t[0] = cns_process_seconds();
        if (n % 2)
            engine_expand(J, order, state);
        else
            hand_expand(&h);
        t[1] = cns_process_seconds();
        if (n % 2)
            hand_expand(&h);
        else
            engine_expand(J, order, state);
        t[2] = cns_process_seconds();
        engine[n] = n % 2 ? t[1] - t[0] : t[2] - t[1];
        byhand[n] = n % 2 ? t[2] - t[1] : t[1] - t[0];
        ratio[n] = engine[n] / byhand[n];
    }
    double ms_engine = 1e3 * median(engine, n), ms_hand = 1e3 * median(byhand, n);
    printf("%6ld %6d %12.3f %12.3f %8.3f %6d\n", digits, order, ms_engine, ms_hand, median(ratio, n), n);
    fflush(stdout);
    for (int i = 0; i < STATES; i++)
        mpfr_clear(state[i]);
    hand_clear(&h);
    cns_jet_free(J);
}

int main(void)
{
    const cns_model *m = cns_model_find("apw");
    cns_program_options options = {NULL};
    cns_program *program;
    cns_error err;
    cns_number *values = malloc((size_t)m->n_parameters * sizeof *values);
    if (!values)
        return 1;
    for (int i = 0; i < m->n_parameters; i++) {
        cns_number_init(&values[i]);
        if (cns_number_parse(&values[i], m->parameters[i].standard, &err))
            return 1;
    }
    if (cns_model_program(m, values, &options, &program, &err)) {
        fprintf(stderr, "bench: %s\n", err.text);
        return 1;
    }
    printf("one expansion of the falling disk, all six states, in ms of processor time; medians of runs in "
           "turn\n");
    printf("%6s %6s %12s %12s %8s %6s\n", "digits", "order", "engine", "by hand", "ratio", "runs");
    run(program, 60, 70, 2);
    run(program, 60, 350, 4);
    run(program, 300, 70, 2);
    run(program, 300, 350, 5);
    cns_program_free(program);
    for (int i = 0; i < m->n_parameters; i++)
        cns_number_clear(&values[i]);
    free(values);
    return 0;
}
