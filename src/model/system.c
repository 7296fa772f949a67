#include "cns/system.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/files.h"
#include "core/memory.h"
#include "core/text.h"
#include "taylor/jet.h"

struct cns_system {
    const cns_model *model;
    cns_number *parameters, *initial;
    bool is_smooth;
    cns_number smooth;
    bool backwards;
    cns_number start; /* the time of the initial states */
    double *scales;
    cns_program *program;
};

/* A system without a program: all numbers 0. */
static cns_system *blank(const cns_model *m)
{
    cns_system *s = cns_xalloc(1, sizeof *s);
    *s = (cns_system){.model = m,
                      .parameters = cns_xalloc((size_t)m->n_parameters + 1, sizeof *s->parameters),
                      .initial = cns_xalloc((size_t)m->n_states + 1, sizeof *s->initial),
                      .scales = cns_xalloc((size_t)m->n_states + 1, sizeof *s->scales)};
    cns_number_init(&s->smooth);
    cns_number_init(&s->start);
    for (int i = 0; i < m->n_parameters; i++)
        cns_number_init(&s->parameters[i]);
    for (int i = 0; i < m->n_states; i++) {
        cns_number_init(&s->initial[i]);
        s->scales[i] = m->states[i].scale;
    }
    return s;
}

void cns_system_free(cns_system *s)
{
    if (s == NULL)
        return;
    for (int i = 0; i < s->model->n_parameters; i++)
        cns_number_clear(&s->parameters[i]);
    for (int i = 0; i < s->model->n_states; i++)
        cns_number_clear(&s->initial[i]);
    cns_number_clear(&s->smooth);
    cns_number_clear(&s->start);
    cns_program_free(s->program);
    free(s->parameters);
    free(s->initial);
    free(s->scales);
    free(s);
}

static void set_smooth(cns_system *s, const cns_number *eps)
{
    s->is_smooth = eps != NULL;
    if (eps != NULL)
        cns_number_set(&s->smooth, eps);
}

static cns_code set_default(cns_system *s, int i, cns_error *err)
{
    const cns_model_parameter *p = &s->model->parameters[i];
    if (p->standard == NULL)
        return cns_fail(err, CNS_USAGE, "parameter '%s' of model %s has no default", p->name, s->model->name);
    return cns_number_parse(&s->parameters[i], p->standard, err);
}

static cns_code check(const cns_system *s, cns_error *err)
{
    cns_code code = CNS_OK;
    cns_number least;
    for (int i = 0; i < s->model->n_states; i++)
        if (!(s->scales[i] > 0) || isinf(s->scales[i]))
            return cns_fail(err, CNS_USAGE, "the scale of state '%s' of model %s must be > 0, not %g",
                            s->model->states[i].name, s->model->name, s->scales[i]);
    cns_number_init(&least);
    for (int i = 0; i < s->model->n_parameters && !code; i++) {
        const cns_model_parameter *p = &s->model->parameters[i];
        if (p->minimum == NULL)
            continue;
        code = cns_number_parse(&least, p->minimum, err);
        if (!code && cns_number_cmp(&s->parameters[i], &least) <= 0)
            code = cns_fail(err, CNS_USAGE, "parameter '%s' must be > %s for model %s, not '%s'", p->name,
                            p->minimum, s->model->name, cns_quote(s->parameters[i].text).text);
    }
    cns_number_clear(&least);
    if (!code && s->is_smooth && cns_number_sign(&s->smooth) <= 0)
        code = cns_fail(err, CNS_USAGE, "a smoothing must be > 0, not '%s'", cns_quote(s->smooth.text).text);
    return code;
}

/* The system with its program, or NULL when there is none, or when it has failed already. */
static cns_system *built(cns_system *s, cns_code code, cns_error *err)
{
    const cns_program_options options = {.smooth = s->is_smooth ? &s->smooth : NULL,
                                         .backwards = s->backwards,
                                         .start = cns_number_get_d(&s->start)};
    if (!code)
        code = check(s, err);
    if (!code)
        code = cns_model_program(s->model, s->parameters, &options, &s->program, err);
    if (!code)
        return s;
    cns_system_free(s);
    return NULL;
}

cns_system *cns_system_new(const cns_model *model, const cns_number *parameters, const cns_number *initial,
                           const cns_number *smooth, cns_error *err)
{
    cns_system *s = blank(model);
    cns_code code = CNS_OK;
    for (int i = 0; i < model->n_parameters && !code; i++)
        if (parameters != NULL)
            cns_number_set(&s->parameters[i], &parameters[i]);
        else
            code = set_default(s, i, err);
    for (int i = 0; i < model->n_states && initial != NULL; i++)
        cns_number_set(&s->initial[i], &initial[i]);
    set_smooth(s, smooth);
    return built(s, code, err);
}

/* Where a setting of this name belongs. */
static cns_number *named(cns_system *s, const char *name)
{
    for (int i = 0; i < s->model->n_parameters; i++)
        if (strcmp(s->model->parameters[i].name, name) == 0)
            return &s->parameters[i];
    for (int i = 0; i < s->model->n_states; i++)
        if (strcmp(s->model->states[i].name, name) == 0)
            return &s->initial[i];
    return strcmp(name, "smooth") == 0 ? &s->smooth : NULL;
}

static bool is_set(const cns_setting *settings, const char *name)
{
    for (; settings->name != NULL; settings++)
        if (strcmp(settings->name, name) == 0)
            return true;
    return false;
}

cns_system *cns_system_parse(const cns_model *model, const cns_setting *settings, cns_error *err)
{
    if (model == NULL) {
        cns_fail(err, CNS_USAGE, "no such model");
        return NULL;
    }
    cns_system *s = blank(model);
    cns_code code = CNS_OK;
    for (int i = 0; i < model->n_parameters && !code; i++)
        if (!is_set(settings, model->parameters[i].name))
            code = set_default(s, i, err);
    for (const cns_setting *at = settings; at->name != NULL && !code; at++) {
        cns_number *value = named(s, at->name);
        cns_error why;
        if (value == NULL)
            code = cns_fail(err, CNS_USAGE, "model %s has neither a parameter nor a state '%s'", model->name,
                            cns_quote(at->name).text);
        else if (cns_number_parse(value, at->text, &why))
            code = cns_fail(err, CNS_USAGE, "'%s': %s", at->name, why.text);
        s->is_smooth = s->is_smooth || value == &s->smooth;
    }
    return built(s, code, err);
}

cns_system *cns_system_with(const cns_system *s, int varied, const cns_number *value, cns_error *err)
{
    const int n = s->model->n_parameters;
    cns_system *other = blank(s->model);
    for (int i = 0; i < n; i++)
        cns_number_set(&other->parameters[i], i == varied ? value : &s->parameters[i]);
    for (int i = 0; i < s->model->n_states; i++)
        cns_number_set(&other->initial[i], n + i == varied ? value : &s->initial[i]);
    set_smooth(other, cns_system_smooth(s));
    cns_number_set(&other->start, &s->start);
    other->backwards = s->backwards;
    return built(other, CNS_OK, err);
}

cns_system *cns_system_from(const cns_system *s, const cns_number *start, bool backwards, cns_error *err)
{
    cns_system *other = blank(s->model);
    for (int i = 0; i < s->model->n_parameters; i++)
        cns_number_set(&other->parameters[i], &s->parameters[i]);
    for (int i = 0; i < s->model->n_states; i++)
        cns_number_set(&other->initial[i], &s->initial[i]);
    set_smooth(other, cns_system_smooth(s));
    cns_number_set(&other->start, start);
    other->backwards = backwards;
    const cns_code code =
        start->pi_power == 0 ? CNS_OK : cns_fail(err, CNS_USAGE, "a start must be rational");
    return built(other, code, err);
}

bool cns_system_is_backwards(const cns_system *s)
{
    return s->backwards;
}

const cns_number *cns_system_start(const cns_system *s)
{
    return &s->start;
}

void cns_system_time(const cns_system *s, mpq_t time, mpq_srcptr passed)
{
    (s->backwards ? mpq_sub : mpq_add)(time, s->start.ratio, passed);
}

cns_system *cns_system_smoothed(const cns_system *s, const cns_number *eps, cns_error *err)
{
    return cns_system_new(s->model, s->parameters, s->initial, eps, err);
}

const cns_model *cns_system_model(const cns_system *s)
{
    return s->model;
}

const cns_program *cns_system_program(const cns_system *s)
{
    return s->program;
}

const cns_number *cns_system_parameters(const cns_system *s)
{
    return s->parameters;
}

const cns_number *cns_system_initial(const cns_system *s)
{
    return s->initial;
}

const cns_number *cns_system_smooth(const cns_system *s)
{
    return s->is_smooth ? &s->smooth : NULL;
}

const double *cns_system_scales(const cns_system *s)
{
    return s->scales;
}

/* The one state that a symmetry shifts, by a multiple of what turns it back; -1: none, -2: several. */
static int shifted(const cns_model *m, const cns_model_symmetry *y)
{
    int found = -1;
    for (int i = 0; i < m->n_states; i++)
        if (y->shift[i] != NULL)
            found = found == -1 ? i : -2;
    return found;
}

/* Is x a fixed point of x -> sign x + (odd ? 1 : 0) shift, up to multiples of 2 shift? shift NULL: none. */
static bool is_fixed(const cns_number *x, int sign, const char *shift, bool odd)
{
    cns_error ignored;
    cns_number by;
    bool fixed = shift == NULL || !odd; /* for sign 1 */
    if (sign > 0)
        return fixed;
    if (shift == NULL || mpq_sgn(x->ratio) == 0)
        return mpq_sgn(x->ratio) == 0 && !odd;
    cns_number_init(&by);
    fixed = !cns_number_parse(&by, shift, &ignored) && by.pi_power == x->pi_power && mpq_sgn(by.ratio) != 0;
    if (fixed) { /* 2 x / shift is an integer, odd or even */
        mpq_div(by.ratio, x->ratio, by.ratio);
        mpq_mul_2exp(by.ratio, by.ratio, 1);
        fixed = mpz_cmp_ui(mpq_denref(by.ratio), 1) == 0 && (mpz_odd_p(mpq_numref(by.ratio)) != 0) == odd;
    }
    cns_number_clear(&by);
    return fixed;
}

/* Marks what the product of a set of symmetries (bits) keeps constant, if the dynamic states begin in a fixed
 * point of it. */
static void mark_fixed(const cns_system *s, unsigned set, bool *constant)
{
    const cns_model *m = s->model;
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < m->n_states; i++) {
            const char *shift = NULL;
            int sign = 1;
            bool odd = false;
            for (int k = 0; k < m->n_symmetries; k++) {
                const cns_model_symmetry *y = &m->symmetries[k];
                if (shifted(m, y) == i && shift == NULL)
                    shift = y->shift[i];
                if (!(set & 1u << k))
                    continue;
                sign *= y->sign[i];
                odd = odd != (y->shift[i] != NULL);
                if (shifted(m, y) == -2 || (y->shift[i] != NULL && strcmp(y->shift[i], shift) != 0))
                    return; /* shifts that are no multiples of one */
            }
            if (pass == 1)
                constant[i] = constant[i] || sign < 0;
            else if (cns_program_is_dynamic(s->program, i) && !is_fixed(&s->initial[i], sign, shift, odd))
                return;
        }
}

cns_code cns_system_constants(const cns_system *s, bool *constant, bool *zero_output, cns_error *err)
{
    const cns_jet_spec spec = {
        .program = s->program, .ops = &cns_arith_mpfr, .order = 1, .prec = 64, .outputs = true};
    mpfr_t x;
    for (int i = 0; i < s->model->n_states; i++)
        constant[i] = false;
    for (unsigned set = 1; set < 1u << s->model->n_symmetries; set++)
        mark_fixed(s, set, constant);
    cns_jet *jet = cns_jet_new(&spec, err);
    if (jet == NULL)
        return err->code;
    mpfr_init2(x, spec.prec);
    cns_jet_begin(jet, 1);
    for (int i = 0; i < s->model->n_states; i++) {
        cns_number_get_mpfr(x, &s->initial[i]);
        cns_jet_set_state(jet, i, x);
    }
    cns_jet_constants(jet, constant, zero_output);
    cns_jet_free(jet);
    mpfr_clear(x);
    return CNS_OK;
}

int cns_system_guesses(const cns_system *s, cns_model_guess *guesses)
{
    const int n = s->model->n_parameters;
    if (s->model->equilibria == NULL)
        return 0;
    double *parameters = cns_xalloc((size_t)n + 1, sizeof *parameters);
    for (int i = 0; i < n; i++)
        parameters[i] = cns_number_get_d(&s->parameters[i]);
    const int found = s->model->equilibria(parameters, guesses);
    free(parameters);
    return found;
}

char *cns_system_identity(const cns_system *s, int varied, const char *format, ...)
{
    cns_text_stream text;
    va_list arguments;
    cns_text_open(&text);
    FILE *out = text.file;
    va_start(arguments, format);
    vfprintf(out, format, arguments);
    va_end(arguments);
    fprintf(out, "\ncns %s, model %s\n", CNS_VERSION, s->model->name);
    for (int i = 0; i < s->model->n_parameters; i++)
        fprintf(out, "parameter %s: %s\n", s->model->parameters[i].name,
                i == varied ? "varied" : s->parameters[i].text);
    for (int i = 0; i < s->model->n_states; i++)
        fprintf(out, "state %s: %s, scale %a\n", s->model->states[i].name,
                s->model->n_parameters + i == varied ? "varied" : s->initial[i].text, s->scales[i]);
    fprintf(out, "smooth: %s\n", s->is_smooth ? s->smooth.text : "no");
    cns_program_print(s->program, out);
    return cns_text_close(&text, NULL);
}
