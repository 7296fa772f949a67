/* Equations of one's own: the system of Henon and Heiles (Astronomical Journal 69 (1964) 73),
 *
 *     x' = u,   y' = v,   u' = -x - 2 x y,   v' = -y - x^2 + y^2,
 *
 * to t = 100 with 15 proven decimals. The last column is the energy of each row's states,
 *
 *     H = (x^2 + y^2 + u^2 + v^2)/2 + x^2 y - y^3/3.
 *
 * The equations conserve it, which the program does not know: it must stay 1/8 to all decimals.
 *
 *     cc own_equations.c $(pkg-config --cflags --libs cns) -o own_equations && ./own_equations
 */
#include <stdio.h>

#include <cns/cns.h>

/* Writes the equations down in p, one operation per call. Equal operations are computed once. */
static void build(cns_program *p, const cns_model *model)
{
    (void)model;
    cns_node x = cns_state(p, 0), y = cns_state(p, 1), u = cns_state(p, 2), v = cns_state(p, 3);
    cns_node xx = cns_sqr(p, x), yy = cns_sqr(p, y), two = cns_constant(p, "2"), three = cns_constant(p, "3");
    cns_derivative(p, 0, u);
    cns_derivative(p, 1, v);
    cns_derivative(p, 2, cns_neg(p, cns_add(p, x, cns_mul(p, two, cns_mul(p, x, y)))));
    cns_derivative(p, 3, cns_sub(p, cns_sub(p, yy, xx), y));
    cns_node squares = cns_add(p, cns_add(p, xx, yy), cns_add(p, cns_sqr(p, u), cns_sqr(p, v)));
    cns_node cubes = cns_mul(p, y, cns_sub(p, xx, cns_div(p, yy, three)));
    cns_output(p, cns_add(p, cns_div(p, squares, two), cubes));
}

/* Name, meaning and typical size of each state; name and meaning of each derived quantity. */
static const cns_model_state states[] = {
    {"x", "place", 1}, {"y", "place", 1}, {"u", "velocity", 1}, {"v", "velocity", 1}};
static const cns_model_output outputs[] = {{"H", "energy"}};
static const cns_model henon_heiles = {.name = "henon-heiles",
                                       .n_states = 4,
                                       .states = states,
                                       .n_outputs = 1,
                                       .outputs = outputs,
                                       .build = build};

int main(void)
{
    cns_error err;
    const cns_setting start[] = {{"u", "0.3"}, {"v", "0.4"}, {NULL, NULL}}; /* x and y begin at 0 */
    cns_system *star = cns_system_parse(&henon_heiles, start, &err);
    const bool good = star != NULL && cns_solve_print(star, "100", "20", 15, stdout, &err) == CNS_OK;
    if (!good)
        fprintf(stderr, "%s\n", err.text);
    cns_system_free(star);
    return good ? 0 : 1;
}
