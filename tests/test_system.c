/* Systems: numbers by name and their defaults, one value changed, what tells two of them apart, and equations
 * that are data of their model. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cns/solve.h"
#include "cns/study/classify.h"
#include "cns/study/sweep.h"
#include "problem.h"

/* x' = sum a_k x^k, by the model's data: the texts a_0, a_1, ..., NULL. The last one is parameter 0's. */
static void polynomial(cns_program *p, const cns_model *model)
{
    const char *const *a = model->data;
    cns_node x = cns_state(p, 0), power = cns_constant(p, "1"), sum = cns_constant(p, "0");
    for (; *a; a++, power = cns_mul(p, power, x))
        sum = cns_add(p, sum, cns_mul(p, cns_constant(p, *a), power));
    cns_derivative(p, 0, cns_add(p, sum, cns_mul(p, cns_parameter(p, 0), power)));
}

static const cns_model_state x_state[] = {{"x", "", 2}};
static const cns_model_parameter parameters[] = {{"a", "", "-1", NULL}, {"b", "", NULL, "0"}};

static cns_model polynomial_model(const char *const *data)
{
    return (cns_model){.name = "polynomial",
                       .n_states = 1,
                       .n_parameters = 1,
                       .states = x_state,
                       .parameters = parameters,
                       .build = polynomial,
                       .data = data};
}

static const cns_setting none[] = {{NULL, NULL}};

START_TEST(numbers_by_name)
{
    const cns_setting settings[] = {{"omega", "1"}, {"I", "3/2"}, {"smooth", "1e-5"}, {"theta", "pi/3"}, {0}};
    const cns_model *m = cns_model_find("apw");
    cns_system *s = system_new(m, settings);
    ck_assert_ptr_eq(cns_system_model(s), m);
    ck_assert_str_eq(cns_system_parameters(s)[0].text, "3/2");
    for (int i = 1; i < m->n_parameters; i++)
        ck_assert_str_eq(cns_system_parameters(s)[i].text, m->parameters[i].standard);
    static const char *const initial[] = {"0", "0", "pi/3", "0", "0", "1"};
    for (int i = 0; i < m->n_states; i++) {
        ck_assert_str_eq(cns_system_initial(s)[i].text, initial[i]);
        ck_assert(cns_system_scales(s)[i] == m->states[i].scale);
    }
    ck_assert_str_eq(cns_system_smooth(s)->text, "1e-5");
    ck_assert(cns_program_is_smooth(cns_system_program(s)));
    cns_system_free(s);
    s = system_new(m, none);
    ck_assert_ptr_null(cns_system_smooth(s));
    ck_assert(!cns_program_is_smooth(cns_system_program(s)));
    cns_system_free(s);
}
END_TEST

static const struct {
    cns_setting setting;
    const char *says;
} wrong[] = {
    {{"Rho", "28"}, "neither a parameter nor a state 'Rho'"},
    {{"R", "2,8"}, "'R': "},
    {{"x", ""}, "'x': "},
    {{"smooth", "0"}, "smoothing must be > 0"},
    {{"smooth", "-1e-3"}, "smoothing must be > 0"},
};

START_TEST(wrong_settings_are_named)
{
    const cns_setting settings[] = {wrong[_i].setting, {NULL, NULL}};
    cns_error err = {0};
    ck_assert_ptr_null(cns_system_parse(cns_model_find("lorenz"), settings, &err));
    ck_assert_int_eq(err.code, CNS_USAGE);
    ck_assert_msg(strstr(err.text, wrong[_i].says) != NULL, "%s", err.text);
}
END_TEST

START_TEST(what_cannot_be_a_system)
{
    static const char *const data[] = {"1", NULL};
    const cns_setting zero[] = {{"b", "0"}, {NULL, NULL}}, below[] = {{"I", "0"}, {NULL, NULL}};
    cns_model m = polynomial_model(data);
    cns_error err = {0};
    m.n_parameters = 2; /* b has no default, and must be > 0 */
    ck_assert_ptr_null(cns_system_parse(&m, none, &err));
    ck_assert_msg(strstr(err.text, "'b'") && strstr(err.text, "no default"), "%s", err.text);
    ck_assert_ptr_null(cns_system_new(&m, NULL, NULL, NULL, &err));
    ck_assert_ptr_null(cns_system_parse(&m, zero, &err));
    ck_assert_msg(strstr(err.text, "'b' must be > 0"), "%s", err.text);
    ck_assert_ptr_null(cns_system_parse(cns_model_find("apw"), below, &err));
    ck_assert_int_eq(err.code, CNS_USAGE);
    ck_assert_ptr_null(cns_system_parse(cns_model_find("no such thing"), none, &err));
    ck_assert_int_eq(err.code, CNS_USAGE);
    static const cns_model_state flat[] = {{"x", "", 0}};
    m = polynomial_model(data);
    m.states = flat;
    ck_assert_ptr_null(cns_system_parse(&m, none, &err));
    ck_assert_msg(strstr(err.text, "scale of state 'x'"), "%s", err.text);
    m = polynomial_model(data);
    m.n_outputs = 1; /* which build does not compute */
    ck_assert_ptr_null(cns_system_parse(&m, none, &err));
    ck_assert_msg(err.code == CNS_USAGE && strstr(err.text, "derived quantities"), "%s", err.text);
    static const char *const bad[] = {"1", "1..5", NULL}; /* the program's own failure */
    m = polynomial_model(bad);
    ck_assert_ptr_null(cns_system_parse(&m, none, &err));
    ck_assert_msg(strstr(err.text, "1..5"), "%s", err.text);
    cns_system_free(NULL);
}
END_TEST

START_TEST(another_value_is_another_system)
{
    const char *texts[] = {"1.25", "1e-3"};
    cns_error err;
    cns_number *x = numbers_new(2, texts);
    cns_system *s = system_new(cns_model_find("apw"), (const cns_setting[]){{"theta", "1"}, {NULL, NULL}});
    cns_system *with = cns_system_with(s, 0, &x[0], &err), *smooth = cns_system_smoothed(with, &x[1], &err),
               *exact = cns_system_smoothed(smooth, NULL, &err);
    const cns_system *all[] = {s, with, smooth, exact};
    for (int i = 0; i < 4; i++) {
        ck_assert_ptr_nonnull(all[i]);
        ck_assert_str_eq(cns_system_parameters(all[i])[0].text, i > 0 ? "1.25" : "2.2");
        ck_assert_str_eq(cns_system_parameters(all[i])[1].text, "1.2");
        ck_assert_str_eq(cns_system_initial(all[i])[2].text, "1");
        ck_assert_int_eq(cns_system_smooth(all[i]) != NULL, i == 2);
        ck_assert_int_eq(cns_program_is_smooth(cns_system_program(all[i])), i == 2);
    }
    cns_system *second = cns_system_with(smooth, 1, &x[1], &err); /* keeps the smoothing */
    ck_assert_str_eq(cns_system_smooth(second)->text, "1e-3");
    cns_system_free(second);
    for (int i = 0; i < 4; i++)
        cns_system_free((cns_system *)(size_t)all[i]);
    numbers_free(x, 2);
}
END_TEST

/* Identities differ if a number, the smoothing, the scales, the equations or what is done differ; a value
 * that is varied does not count. */
START_TEST(identities)
{
    static const char *const data[] = {"1", NULL}, *const other_data[] = {"2", NULL};
    static const cns_model_state wide[] = {{"x", "", 3}};
    const cns_model m = polynomial_model(data), equations = polynomial_model(other_data);
    cns_model scales = m;
    scales.states = wide;
    const struct {
        const cns_model *model;
        cns_setting settings[3];
    } systems[] = {{&m, {{0}}},         {&m, {{"x", "1"}}}, {&m, {{"smooth", "1e-3"}}},
                   {&equations, {{0}}}, {&scales, {{0}}},   {&m, {{"a", "-2"}}}};
    enum { N = COUNT(systems) };
    char *text[N], *varied[N];
    for (int i = 0; i < N; i++) {
        cns_system *s = system_new(systems[i].model, systems[i].settings);
        text[i] = cns_system_identity(s, -1, "test %d", 7);
        varied[i] = cns_system_identity(s, 0, "test %d", 7);
        cns_system_free(s);
    }
    for (int i = 0; i < N; i++)
        for (int k = 0; k < N; k++) {
            ck_assert_int_eq(strcmp(text[i], text[k]) == 0, i == k);
            ck_assert_int_eq(strcmp(varied[i], varied[k]) == 0, i == k || (i + k == N - 1 && i * k == 0));
        }
    cns_system *again = system_new(&m, none);
    char *same = cns_system_identity(again, -1, "test %d", 7), *task = cns_system_identity(again, -1, "test");
    ck_assert_str_eq(same, text[0]);
    ck_assert_str_ne(task, text[0]);
    free(same);
    free(task);
    cns_system_free(again);
    for (int i = 0; i < N; i++) {
        free(text[i]);
        free(varied[i]);
    }
}
END_TEST

/* A pendulum drawn to a level of energy, the level being a parameter, or, by the model's data, twice that. */
static void pendulum(cns_program *p, const cns_model *model)
{
    cns_node angle = cns_state(p, 0), w = cns_state(p, 1), sine, cosine;
    cns_node level = cns_mul(p, cns_constant(p, model->data), cns_parameter(p, 0));
    cns_sincos(p, angle, &sine, &cosine);
    cns_node energy = cns_sub(p, cns_mul(p, cns_constant(p, "1/2"), cns_sqr(p, w)), cosine);
    cns_derivative(p, 0, w);
    cns_derivative(p, 1, cns_sub(p, cns_mul(p, cns_sub(p, level, energy), w), sine));
}

static const cns_model_state pendulum_states[] = {{"angle", "", 1}, {"w", "", 1}};
static const signed char no_change[] = {1, 1};
static const cns_model_motion turning = {
    .angle = 0, .rate = 1, .turns = 1, .height = -1, .turn_sign = no_change};

static cns_code name_mode(void *context, const cns_system *s, const char *value, const cns_monitor *monitor,
                          FILE *const *table, cns_error *err)
{
    const cns_classify_spec spec = {.observable = -1, .max_digits = 200};
    cns_motion motion;
    (void)context;
    cns_code code = cns_classify(s, &spec, monitor, &motion, err);
    fprintf(table[0], "%s,%s\n", value, cns_mode_name(motion.mode));
    cns_motion_clear(&motion);
    return code;
}

/* The mode at a = 0.75, by a sweep that keeps what it finds. */
static void mode_of(const char *factor, const char *directory, char mode[32])
{
    const cns_model m = {.name = "pendulum",
                         .n_states = 2,
                         .n_parameters = 1,
                         .states = pendulum_states,
                         .parameters = parameters,
                         .motion = &turning,
                         .build = pendulum,
                         .data = factor};
    const cns_setting start[] = {{"angle", "1"}, {"w", "1.5"}, {NULL, NULL}};
    const cns_sweep_study study = {.name = "mode", .rows = name_mode};
    cns_system *s = system_new(&m, start);
    cns_sweep sweep;
    cns_error err;
    cns_sweep_rows row;
    check_ok(cns_sweep_parse(&sweep, &m, "a=0.75:0.75:1", &err), &err);
    check_ok(cns_sweep_run(s, &sweep, &study, directory, NULL, &row, &err), &err);
    ck_assert_int_eq(sscanf(row.table[0], "0.75,%31[a-z]", mode), 1);
    cns_sweep_rows_clear(&row, 1);
    cns_sweep_clear(&sweep);
    cns_system_free(s);
}

/* What is kept under the name of a model is not taken for a model of the same name with other equations. */
START_TEST(kept_results_are_those_of_the_equations)
{
    char directory[] = "/tmp/cns-test-XXXXXX", command[64], mode[32];
    ck_assert_ptr_nonnull(mkdtemp(directory));
    mode_of("1", directory, mode);
    ck_assert_str_eq(mode, "flutter");
    mode_of("2", directory, mode);
    ck_assert_str_eq(mode, "tumble");
    snprintf(command, sizeof command, "rm -r %s", directory);
    ck_assert_int_eq(system(command), 0);
}
END_TEST

static cns_code print_rows(const cns_model *m, const cns_setting *settings, const char *end,
                           const char *every, long decimals, char **text, cns_error *err)
{
    size_t size;
    cns_system *s = system_new(m, settings);
    FILE *out = open_memstream(text, &size);
    ck_assert_ptr_nonnull(out);
    const cns_code code = cns_solve_print(s, end, every, decimals, out, err);
    fclose(out);
    cns_system_free(s);
    return code;
}

/* x' = 1 - x from 3: x = 1 + 2 e^-t. */
START_TEST(own_equations_solved)
{
    static const char *const data[] = {"1", NULL};
    const cns_model m = polynomial_model(data);
    const cns_setting start[] = {{"x", "3"}, {NULL, NULL}};
    char *text, want[512];
    cns_error err;
    mpfr_t x[2];
    mpfr_inits2(400, x[0], x[1], (mpfr_ptr)0);
    for (int i = 0; i < 2; i++) {
        mpfr_set_d(x[i], i == 0 ? -0.5 : -0.75, MPFR_RNDN);
        mpfr_exp(x[i], x[i], MPFR_RNDN);
        mpfr_mul_ui(x[i], x[i], 2, MPFR_RNDN);
        mpfr_add_ui(x[i], x[i], 1, MPFR_RNDN);
    }
    check_ok(print_rows(&m, start, "3/4", "1/2", 60, &text, &err), &err);
    mpfr_snprintf(want, sizeof want, "t,x\n0,3.%060d\n0.5,%.60RNf\n0.75,%.60RNf\n", 0, x[0], x[1]);
    ck_assert_str_eq(text, want);
    free(text);
    check_ok(print_rows(&m, start, "0.75", NULL, 5, &text, &err), &err);
    mpfr_snprintf(want, sizeof want, "t,x\n0,3.00000\n0.75,%.5RNf\n", x[1]);
    ck_assert_str_eq(text, want);
    free(text);
    static const char *const bad[][2] = {{"0", "1"}, {"-1", "1"}, {"pi", "1"},
                                         {"x", "1"}, {"1", "0"},  {"1", "2 2"}};
    for (int i = 0; i < COUNT(bad); i++) {
        ck_assert_int_eq(print_rows(&m, start, bad[i][0], bad[i][1], 5, &text, &err), CNS_USAGE);
        ck_assert_str_eq(text, "");
        free(text);
    }
    mpfr_clears(x[0], x[1], (mpfr_ptr)0);
}
END_TEST

Suite *suite_system(void)
{
    Suite *s = suite_create("system");
    TCase *t = tcase_create("system");
    tcase_add_test(t, numbers_by_name);
    add_table_test(t, wrong_settings_are_named, wrong);
    tcase_add_test(t, what_cannot_be_a_system);
    tcase_add_test(t, another_value_is_another_system);
    tcase_add_test(t, identities);
    tcase_add_test(t, kept_results_are_those_of_the_equations);
    tcase_add_test(t, own_equations_solved);
    suite_add_tcase(s, t);
    return s;
}
