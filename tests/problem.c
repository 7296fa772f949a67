#include "problem.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const double unit_scales[MAX_SCALES] = {
    1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1,
    1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1,
};

cns_number *numbers_new(int n, const char *const *texts)
{
    cns_number *x = malloc(((size_t)n + 1) * sizeof *x);
    ck_assert_ptr_nonnull(x);
    for (int i = 0; i < n; i++) {
        cns_error err;
        cns_number_init(&x[i]);
        check_ok(cns_number_parse(&x[i], texts[i], &err), &err);
    }
    return x;
}

void numbers_free(cns_number *x, int n)
{
    for (int i = 0; i < n; i++)
        cns_number_clear(&x[i]);
    free(x);
}

void check_ok(cns_code code, const cns_error *err)
{
    if (code)
        ck_abort_msg("code %d: %s", (int)code, err->text);
}

cns_program *program_new(int n_states, const char *smooth)
{
    cns_program_options options = {NULL};
    cns_number *eps = smooth ? numbers_new(1, &smooth) : NULL;
    options.smooth = eps;
    cns_program *p = cns_program_new(n_states, 0, NULL, &options);
    ck_assert_ptr_nonnull(p);
    if (eps)
        numbers_free(eps, 1);
    return p;
}

cns_program *finished(cns_program *p)
{
    cns_error err;
    check_ok(cns_program_finish(p, &err), &err);
    return p;
}

cns_program *model_program(const char *model, const char *smooth)
{
    const cns_model *m = cns_model_find(model);
    const char *texts[MAX_SCALES];
    cns_program_options options = {NULL};
    cns_program *p;
    cns_error err;
    ck_assert_ptr_nonnull(m);
    for (int i = 0; i < m->n_parameters; i++)
        texts[i] = m->parameters[i].standard;
    cns_number *parameters = numbers_new(m->n_parameters, texts);
    cns_number *eps = smooth ? numbers_new(1, &smooth) : NULL;
    options.smooth = eps;
    check_ok(cns_model_program(m, parameters, &options, &p, &err), &err);
    numbers_free(parameters, m->n_parameters);
    if (eps)
        numbers_free(eps, 1);
    return p;
}

cns_model unit_model(int n, void (*build)(cns_program *p, const cns_model *model), const void *data)
{
    static const cns_model_state states[] = {{"x0", "", 1}, {"x1", "", 1}, {"x2", "", 1},
                                             {"x3", "", 1}, {"x4", "", 1}, {"x5", "", 1}};
    ck_assert_int_le(n, COUNT(states));
    return (cns_model){.name = "test", .n_states = n, .states = states, .build = build, .data = data};
}

cns_system *system_new(const cns_model *m, const cns_setting *settings)
{
    static const cns_setting none[] = {{NULL, NULL}};
    cns_error err;
    cns_system *s = cns_system_parse(m, settings ? settings : none, &err);
    if (!s)
        ck_abort_msg("no system: %s", err.text);
    return s;
}

cns_system *unit_system(const cns_model *m, const char *const *initial)
{
    cns_setting settings[7] = {{NULL, NULL}};
    for (int i = 0; i < m->n_states; i++)
        settings[i] = (cns_setting){m->states[i].name, initial[i]};
    return system_new(m, settings);
}

cns_jet *jet_new(const cns_program *p, const cns_arith_ops *ops, int order, mpfr_prec_t prec)
{
    cns_jet_spec spec = {.program = p, .ops = ops, .order = order, .prec = prec};
    cns_error err;
    cns_jet *J = cns_jet_new(&spec, &err);
    if (!J)
        ck_abort_msg("no jet: %s", err.text);
    return J;
}

cns_flow_spec taylor_spec(const cns_program *p, long digits)
{
    cns_flow_spec spec = cns_flow_spec_taylor(p, unit_scales, CNS_ARITH_MPFR, digits);
    spec.safety = 0.5;
    spec.verify = true;
    return spec;
}

cns_flow *flow_new(const cns_flow_spec *spec)
{
    cns_error err;
    ck_assert_int_le(cns_program_states(spec->program), MAX_SCALES);
    cns_flow *f = cns_flow_new(spec, &err);
    if (!f)
        ck_abort_msg("no flow: %s", err.text);
    return f;
}

cns_flow *flow_started(const cns_flow_spec *spec, const char *const *initial)
{
    int n = cns_program_states(spec->program);
    cns_flow *f = flow_new(spec);
    cns_number *x = numbers_new(n, initial);
    cns_flow_start(f, x);
    numbers_free(x, n);
    return f;
}

cns_goal goal_of(cns_places places, long count, long max_digits)
{
    const bool significant = places == CNS_PLACES_SIGNIFICANT;
    return (cns_goal){.decimals = significant ? 0 : count,
                      .significant = significant ? count : 0,
                      .max_digits = max_digits};
}

cns_code try_flow_to(cns_flow *f, const char *t, mpfr_t *x, cns_error *err)
{
    cns_number *time = numbers_new(1, &t);
    cns_code code = CNS_OK;
    while (!code && mpfr_cmp_q(cns_flow_end(f), time->ratio) < 0) {
        ck_assert_msg(cns_flow_steps(f) < 1000000, "too many steps");
        code = cns_flow_step(f, err);
    }
    if (!code)
        cns_flow_eval(f, time->ratio, x);
    numbers_free(time, 1);
    return code;
}

void flow_to(cns_flow *f, const char *t, mpfr_t *x)
{
    cns_error err;
    check_ok(try_flow_to(f, t, x, &err), &err);
}

double log2_of(const mpfr_t x)
{
    long e;
    if (mpfr_zero_p(x))
        return -HUGE_VAL;
    double m = fabs(mpfr_get_d_2exp(&e, x, MPFR_RNDN));
    return log2(m) + (double)e;
}

double log2_distance(const mpfr_t x, const mpfr_t y)
{
    mpfr_t d;
    mpfr_prec_t prec = mpfr_get_prec(x) > mpfr_get_prec(y) ? mpfr_get_prec(x) : mpfr_get_prec(y);
    if (!mpfr_number_p(x) || !mpfr_number_p(y))
        return HUGE_VAL;
    mpfr_init2(d, prec);
    mpfr_sub(d, x, y, MPFR_RNDN);
    double l = log2_of(d);
    mpfr_clear(d);
    return l;
}

char *reference_text(const char *table, const char *t)
{
    char path[512], line[4096], *found = NULL;
    const char *tests = getenv("CNS_TESTS");
    size_t length = strlen(t);
    snprintf(path, sizeof path, "%s/reference/%s", tests && *tests ? tests : "tests", table);
    FILE *in = fopen(path, "r");
    ck_assert_msg(in != NULL, "%s: cannot be opened", path);
    while (!found && fgets(line, sizeof line, in))
        if (!strncmp(line, t, length) && line[length] == ',')
            found = strdup(line + length + 1);
    fclose(in);
    ck_assert_msg(found != NULL, "%s: no row %s", path, t);
    return found;
}

void reference_row(const char *table, const char *t, mpfr_t *x, int n)
{
    char *text = reference_text(table, t), *end = text;
    for (int i = 0; i < n; i++) {
        ck_assert_msg(i == 0 || *end == ',', "%s: row %s is short", table, t);
        mpfr_strtofr(x[i], i == 0 ? end : end + 1, &end, 10, MPFR_RNDN);
    }
    free(text);
}
