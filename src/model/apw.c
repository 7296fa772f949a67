/* A disk falling through water: the model of Andersen, Pesavento and Wang. */
#include <math.h>

#include "models.h"

enum { X, Y, THETA, VX, VY, OMEGA, N_STATES };
enum { INERTIA, CT, CR, A, B, MU1, MU2, N_PARAMETERS };

static const cns_model_state states[N_STATES] = {
    [X] = {"x", "horizontal position, global frame", 1},
    [Y] = {"y", "vertical position, global frame (upward)", 1},
    [THETA] = {"theta", "angle of the disk, radians", 1},
    [VX] = {"Vx", "velocity along the disk, in its frame", 1},
    [VY] = {"Vy", "velocity across the disk, in its frame", 1},
    [OMEGA] = {"omega", "angular velocity, theta'", 1},
};

static const cns_model_parameter parameters[N_PARAMETERS] = {
    [INERTIA] = {"I", "dimensionless moment of inertia I*", "2.2", "0"},
    [CT] = {"CT", "circulation from translation", "1.2", NULL},
    [CR] = {"CR", "circulation from rotation", "pi", NULL},
    [A] = {"A", "drag, mean of edge-on and broadside", "1.4", NULL},
    [B] = {"B", "drag, half their difference", "1", NULL},
    [MU1] = {"mu1", "torque, linear in omega", "0.2", NULL},
    [MU2] = {"mu2", "torque, quadratic in omega", "0.2", NULL},
};

static const cns_model_output outputs[] = {
    {"Gamma", "circulation"},
    {"Fx", "drag along the disk"},
    {"Fy", "drag across the disk"},
    {"tau", "torque of the fluid"},
    {"speed", "sqrt(Vx^2 + Vy^2)"},
    {"vx_lab", "x', velocity in the global frame"},
    {"vy_lab", "y', velocity in the global frame"},
};

/* Half a turn puts the other edge ahead: Vx and Vy, in the disk's frame, change sign. */
static const signed char turn_sign[N_STATES] = {
    [X] = 1, [Y] = 1, [THETA] = 1, [VX] = -1, [VY] = -1, [OMEGA] = 1};
static const signed char mirror_sign[N_STATES] = {
    [X] = -1, [Y] = 1, [THETA] = -1, [VX] = -1, [VY] = 1, [OMEGA] = -1};
static const cns_model_motion motion = {.angle = THETA,
                                        .rate = OMEGA,
                                        .turns = 2,
                                        .height = Y,
                                        .turn_sign = turn_sign,
                                        .mirror_sign = mirror_sign};

/* Equations (1)-(4) of Xu, Li, Li, Liao with s = sqrt(Vx^2 + Vy^2), r = Vx Vy / s, e = (Vx^2 - Vy^2) / s:
 *   Gamma = (2/pi) (CR omega - CT r),  f = (A s - B e) / pi,  (Fx, Fy) = f (Vx, Vy),
 *   I Vx'     = ((I+1) omega - Gamma) Vy - sin theta - f Vx
 *   (I+1) Vy' = (Gamma - I omega) Vx - cos theta - f Vy
 *   (I+1/2)/4 omega' = -Vx Vy - (mu1 + mu2 |omega|) omega
 * which costs one root and two quotients and never divides by s^2. */
static void build(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node theta = cns_state(p, THETA), vx = cns_state(p, VX), vy = cns_state(p, VY),
             omega = cns_state(p, OMEGA);
    cns_node inertia = cns_parameter(p, INERTIA), mu1 = cns_parameter(p, MU1), mu2 = cns_parameter(p, MU2);
    cns_node one = cns_constant(p, "1"), pi = cns_constant(p, "pi");
    cns_node inertia1 = cns_add(p, inertia, one);
    cns_node two_over_pi = cns_div(p, cns_constant(p, "2"), pi);
    cns_node sin_theta, cos_theta;

    cns_sincos(p, theta, &sin_theta, &cos_theta);
    cns_node s = cns_hypot(p, vx, vy), vxvy = cns_mul(p, vx, vy);
    cns_node r = cns_div(p, vxvy, s);
    cns_node e = cns_div(p, cns_sub(p, cns_sqr(p, vx), cns_sqr(p, vy)), s);

    /* (I+1) omega - Gamma and Gamma - I omega, constants gathered. */
    cns_node lift = cns_mul(p, two_over_pi, cns_parameter(p, CR)),
             turn = cns_mul(p, two_over_pi, cns_parameter(p, CT));
    cns_node gx = cns_add(p, cns_mul(p, cns_sub(p, inertia1, lift), omega), cns_mul(p, turn, r));
    cns_node gy = cns_sub(p, cns_mul(p, cns_sub(p, lift, inertia), omega), cns_mul(p, turn, r));
    cns_node f = cns_sub(p, cns_mul(p, cns_div(p, cns_parameter(p, A), pi), s),
                         cns_mul(p, cns_div(p, cns_parameter(p, B), pi), e));

    cns_node fx = cns_mul(p, f, vx), fy = cns_mul(p, f, vy);
    cns_derivative(p, VX, cns_div(p, cns_sub(p, cns_sub(p, cns_mul(p, gx, vy), sin_theta), fx), inertia));
    cns_derivative(p, VY, cns_div(p, cns_sub(p, cns_sub(p, cns_mul(p, gy, vx), cos_theta), fy), inertia1));

    /* |omega| omega: on an arc, the held sign times omega^2, half the price of a product. */
    cns_node drag = cns_mul(p, cns_abs(p, omega), omega);
    cns_node tau = cns_add(p, cns_mul(p, mu1, omega), cns_mul(p, mu2, drag));
    cns_node quarter = cns_mul(p, cns_constant(p, "1/4"), cns_add(p, inertia, cns_constant(p, "1/2")));
    cns_derivative(p, OMEGA, cns_div(p, cns_neg(p, cns_add(p, vxvy, tau)), quarter));

    cns_node vx_lab = cns_sub(p, cns_mul(p, vx, cos_theta), cns_mul(p, vy, sin_theta));
    cns_node vy_lab = cns_add(p, cns_mul(p, vx, sin_theta), cns_mul(p, vy, cos_theta));
    cns_derivative(p, THETA, omega);
    cns_derivative(p, X, vx_lab);
    cns_derivative(p, Y, vy_lab);

    cns_output(p, cns_sub(p, cns_mul(p, lift, omega), cns_mul(p, turn, r)));
    cns_output(p, fx);
    cns_output(p, fy);
    cns_output(p, tau);
    cns_output(p, s);
    cns_output(p, vx_lab);
    cns_output(p, vy_lab);
}

/* At rest but for the fall: omega = 0, and omega' = 0 asks that Vx Vy = 0. With Vy = 0, Vy' = 0 asks that
 * cos theta = 0, and Vx' = 0 that (A - B) |Vx| Vx = -pi sin theta; with Vx = 0, Vx' = 0 asks that sin theta =
 * 0, and Vy' = 0 that (A + B) |Vy| Vy = -pi cos theta. There are no others. */
static int equilibria(const double *parameter, cns_model_guess *guess)
{
    const double pi = 3.14159265358979323846;
    const double edge = parameter[A] - parameter[B], broad = parameter[A] + parameter[B];
    int n = 0;
    for (int turn = 0; turn < 2; turn++) {
        const double down = turn == 0 ? -1 : 1;
        if (edge != 0 && isfinite(edge)) {
            guess[n] = (cns_model_guess){.name = turn == 0 ? "edge-on" : "edge-on mirror"};
            guess[n].state[THETA] = pi / 2 + pi * turn;
            guess[n++].state[VX] = copysign(sqrt(pi / fabs(edge)), down * edge);
        }
        if (broad != 0 && isfinite(broad)) {
            guess[n] = (cns_model_guess){.name = turn == 0 ? "broadside" : "broadside mirror"};
            guess[n].state[THETA] = pi * turn;
            guess[n++].state[VY] = copysign(sqrt(pi / fabs(broad)), down * broad);
        }
    }
    return n;
}

/* The disk has two faces and two edges; left and right are alike. */
static const cns_model_symmetry symmetries[] = {
    {"half-turn",
     (const signed char[N_STATES]){[X] = 1, [Y] = 1, [THETA] = 1, [VX] = -1, [VY] = -1, [OMEGA] = 1},
     (const char *const[N_STATES]){[THETA] = "pi"}},
    {"mirror",
     (const signed char[N_STATES]){[X] = -1, [Y] = 1, [THETA] = -1, [VX] = -1, [VY] = 1, [OMEGA] = -1},
     (const char *const[N_STATES]){NULL}},
};

/* An edge-on disk tips over. When it comes near edge-on again, half a turn on, it either swings back, with
 * its other face down, or turns over: the heteroclinic bifurcation of Andersen, Pesavento and Wang. */
static const cns_model_connection connection = {
    .saddle = "edge-on", .along = THETA, .back = "flutter", .beyond = "tumble"};

/* Xu, Li, Li, Liao, equation for T_c: the smaller of the two, with K from 16 to 25 and RK4 with h from 1e-2
 * to 1e-5. */
static const cns_model_published published = {.authors = "Xu, Li, Li, Liao",
                                              .subject = "case 1",
                                              .digits = {10.95, 96.11},
                                              .steps = {42.81, 112.56},
                                              .order = 4};

const cns_model cns_model_apw = {
    .name = "apw",
    .title = "disk falling through water (Andersen-Pesavento-Wang)",
    .source = "A. Andersen, U. Pesavento, Z. J. Wang, J. Fluid Mech. 541 (2005) 65 and 91; "
              "equations as in Xu, Li, Li, Liao, Accurate predictions of chaotic motion of a free fall disk",
    .n_states = N_STATES,
    .n_parameters = N_PARAMETERS,
    .n_outputs = sizeof outputs / sizeof *outputs,
    .states = states,
    .parameters = parameters,
    .outputs = outputs,
    .motion = &motion,
    .build = build,
    .equilibria = equilibria,
    .n_symmetries = sizeof symmetries / sizeof *symmetries,
    .symmetries = symmetries,
    .connection = &connection,
    .published = &published,
};
