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

static void build(cns_program *p)
{
    cns_node x = cns_state(p, 0), y = cns_state(p, 1), z = cns_state(p, 2);
    cns_node sigma = cns_parameter(p, 0), r = cns_parameter(p, 1), b = cns_parameter(p, 2);
    cns_derivative(p, 0, cns_mul(p, sigma, cns_sub(p, y, x)));
    cns_derivative(p, 1, cns_sub(p, cns_sub(p, cns_mul(p, r, x), y), cns_mul(p, x, z)));
    cns_derivative(p, 2, cns_sub(p, cns_mul(p, x, y), cns_mul(p, b, z)));
}

const cns_model cns_model_lorenz = {
    .name = "lorenz",
    .title = "Lorenz's model of convection",
    .source = "E. N. Lorenz, J. Atmos. Sci. 20 (1963) 130, equations (25)-(27)",
    .n_states = 3,
    .n_parameters = 3,
    .states = states,
    .parameters = parameters,
    .build = build,
};
