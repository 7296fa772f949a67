#include <math.h>

#include "models.h"

static const cns_model_state states[] = {
    {"x", "intensity of the convection", 10},
    {"y", "temperature difference between the currents", 10},
    {"z", "distortion of the vertical temperature profile", 10},
};

static const cns_model_parameter parameters[] = {
    {"sigma", "Prandtl number", "10", NULL},
    {"R", "relative Rayleigh number", "28", NULL},
    {"b", "aspect ratio of the rolls", "8/3", NULL},
};

static void build(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node x = cns_state(p, 0), y = cns_state(p, 1), z = cns_state(p, 2);
    cns_node sigma = cns_parameter(p, 0), r = cns_parameter(p, 1), b = cns_parameter(p, 2);
    cns_derivative(p, 0, cns_mul(p, sigma, cns_sub(p, y, x)));
    cns_derivative(p, 1, cns_sub(p, cns_sub(p, cns_mul(p, r, x), y), cns_mul(p, x, z)));
    cns_derivative(p, 2, cns_sub(p, cns_mul(p, x, y), cns_mul(p, b, z)));
}

/* The state at rest, and two states of steady convection, x = y = +-sqrt(b (R - 1)), z = R - 1. */
static int equilibria(const double *parameter, cns_model_guess *guess)
{
    const double height = parameter[1] - 1, square = parameter[2] * height;
    guess[0] = (cns_model_guess){.name = "origin"};
    if (!(square > 0) || !isfinite(square))
        return 1;
    const double x = sqrt(square);
    guess[1] = (cns_model_guess){.name = "C+", .state = {x, x, height}};
    guess[2] = (cns_model_guess){.name = "C-", .state = {-x, -x, height}};
    return 3;
}

static const cns_model_symmetry symmetries[] = {
    {"half-turn", (const signed char[3]){-1, -1, 1}, (const char *const[3]){NULL}},
};

/* One branch of the origin's unstable manifold returns to the origin at R = 13.926... (sigma = 10, b = 8/3).
 */
static const cns_model_connection connection = {
    .saddle = "origin", .along = 0, .back = "across", .beyond = "same side"};

const cns_model cns_model_lorenz = {
    .name = "lorenz",
    .title = "Lorenz's model of convection",
    .source = "E. N. Lorenz, J. Atmos. Sci. 20 (1963) 130, equations (25)-(27)",
    .n_states = 3,
    .n_parameters = 3,
    .states = states,
    .parameters = parameters,
    .build = build,
    .equilibria = equilibria,
    .n_symmetries = sizeof symmetries / sizeof *symmetries,
    .symmetries = symmetries,
    .connection = &connection,
};
