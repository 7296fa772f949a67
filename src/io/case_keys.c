/* The keys of case files: one row each, from which checking, defaults, `cns check`, `cns help case` and the
 * suggestions in messages follow. */
#include <stdio.h>
#include <string.h>

#include "case_internal.h"
#include "core/text.h"
#include "solve/proof.h"

#define TEXT_OF(x)  #x
#define TEXT_OF2(x) TEXT_OF(x)

enum { LIMIT_DECIMALS = 10000, LIMIT_DIGITS = 100000, LIMIT_ORDER = 100000 };

static bool asks_decimals(const cns_case *c)
{
    return c->goal.places == CNS_PLACES_DECIMALS;
}

static bool asks_significant(const cns_case *c)
{
    return c->goal.places == CNS_PLACES_SIGNIFICANT;
}

static bool has_tolerance(const cns_case *c)
{
    return c->numerics.method != CNS_METHOD_RK4;
}

/* clang-format off */

/* The field of cns_case that holds the value of a key: its offset and its type. */
#define AT(x)                                                                                                           \
    offsetof(cns_case, x),                                                                                              \
    _Generic(((const cns_case *)NULL)->x, bool: FIELD_BOOL, int: FIELD_INT, unsigned: FIELD_INT, long: FIELD_LONG,      \
             double: FIELD_DOUBLE, cns_number: FIELD_NUMBER)

#define ARITHMETICS {{"fast", CNS_ARITH_FAST}, {"mpfr", CNS_ARITH_MPFR}, {"double", CNS_ARITH_DOUBLE}}

const cns_key cns_keys[] = {
    {"model", KEY_MODEL, .required = true,
        .meaning = "the equations: `cns models` lists them"},
    {"parameters", KEY_PARAMETERS,
        .meaning = "values of the model's parameters; those left out take the model's defaults"},
    {"initial", KEY_INITIAL,
        .meaning = "the state at t = 0; those left out are 0"},

    {"time", KEY_SECTION, .required = true, .meaning = ""},
    {"time.end", KEY_NUMBER, AT(end), .above = "0", .rational = true, .required = true,
        .meaning = "the last time"},
    {"time.every", KEY_NUMBER, AT(every), .above = "0", .rational = true, .otherwise = "end",
        .meaning = "rows at 0, at multiples of this and at the end"},

    {"abs", KEY_SECTION, AT(smooth), {{"exact", false}}, .otherwise = "exact",
        .meaning = "absolute values in the equations: true ones, or a mapping with `smooth`"},
    {"abs.smooth", KEY_NUMBER, AT(eps), .above = "0",
        .meaning = "eps: abs(u) becomes sqrt(u^2 + eps^2)"},

    {"goal", KEY_SECTION, AT(has_goal),
        .meaning = "what the table must prove; the program chooses the numerics"},
    {"goal.decimals", KEY_INTEGER, AT(goal.count), .least = 1, .most = LIMIT_DECIMALS, .printed = asks_decimals,
        .meaning = "right decimals in every value; or:"},
    {"goal.significant", KEY_INTEGER, AT(goal.count), .least = 1, .most = LIMIT_DECIMALS, .printed = asks_significant,
        .meaning = "right significant digits in every value"},
    {"goal.max_digits", KEY_INTEGER, AT(goal.max_digits), .least = CNS_LEAST_PROOF_DIGITS, .most = LIMIT_DIGITS,
        .standard = "5000", .meaning = "give up rather than compute with more digits"},
    {"goal.max_time", KEY_NUMBER, AT(goal.max_time), .above = "0", .below = "1e12", .otherwise = "no limit",
        .meaning = "seconds after which to give up"},

    {"numerics", KEY_SECTION, AT(has_numerics),
        .meaning = "the numerics by hand, instead of `goal`"},
    {"numerics.method", KEY_WORD, AT(numerics.method), {{"taylor", CNS_METHOD_TAYLOR}, {"rk4", CNS_METHOD_RK4}},
        .standard = "taylor", .meaning = "how a step is made; rk4 needs a fixed step"},
    {"numerics.arithmetic", KEY_WORD, AT(numerics.arithmetic), ARITHMETICS, .otherwise = "fast (taylor) or mpfr (rk4)",
        .meaning = "fast: fixed point; double: with rk4, or taylor of order <= " TEXT_OF2(CNS_DOUBLE_MAX_ORDER)
                   ", no digits"},
    {"numerics.digits", KEY_INTEGER, AT(numerics.digits), .least = 1, .most = LIMIT_DIGITS,
        .meaning = "decimal digits to compute with; required with mpfr"},
    {"numerics.order", KEY_INTEGER, AT(numerics.order), {{"auto", 0}}, .least = 1, .most = LIMIT_ORDER,
        .standard = "auto", .meaning = "of the Taylor series"},
    {"numerics.step", KEY_NUMBER, AT(numerics.step), {{"adaptive", 0}}, .above = "0", .rational = true,
        .standard = "adaptive", .meaning = "adaptive, or the fixed step"},
    {"numerics.tolerance", KEY_NUMBER, AT(numerics.tolerance), {{"auto", 0}}, .above = "0", .below = "1",
        .standard = "auto", .printed = has_tolerance,
        .meaning = "local, relative to the model's scales; auto: 10^-digits"},

    {"output", KEY_SECTION, .meaning = "what the table shows"},
    {"output.columns", KEY_COLUMNS, .otherwise = "[t, the states]",
        .meaning = "t, states and derived quantities of the model"},

    {"laws", KEY_SECTION, AT(has_laws),
        .meaning = "of `cns laws` and `cns tc`: which runs, and when two part"},
    {"laws.delta", KEY_NUMBER, AT(laws.delta), .above = "0", .standard = CNS_STANDARD_DELTA,
        .meaning = "the difference at which a run has parted from the reference"},
    {"laws.observable", KEY_STATE, AT(laws.observable), {{"norm", CNS_OBSERVABLE_NORM}}, .standard = "norm",
        .meaning = "what differs: the distance of the dynamic states in the model's scales, or one state"},
    {"laws.digits", KEY_SECTION, AT(laws.has_digits), .meaning = "runs of K digits each"},
    {"laws.digits.from", KEY_INTEGER, AT(laws.digits.from), .least = 4, .most = LIMIT_DIGITS, .required = true,
        .meaning = "the smallest K"},
    {"laws.digits.to", KEY_INTEGER, AT(laws.digits.to), .least = 4, .most = LIMIT_DIGITS, .required = true,
        .meaning = "the largest K"},
    {"laws.digits.by", KEY_INTEGER, AT(laws.digits.by), .least = 1, .most = LIMIT_DIGITS, .standard = "1",
        .meaning = "from one K to the next"},
    {"laws.steps", KEY_SECTION, AT(laws.has_steps), .meaning = "runs with a fixed step h each"},
    {"laws.steps.method", KEY_WORD, AT(laws.steps.method), {{"rk4", CNS_METHOD_RK4}, {"taylor", CNS_METHOD_TAYLOR}},
        .standard = "rk4", .meaning = "how a step is made"},
    {"laws.steps.order", KEY_INTEGER, AT(laws.steps.order), {{"auto", 0}}, .least = 1, .most = LIMIT_ORDER,
        .standard = "auto", .meaning = "of the Taylor series; that of rk4 is 4"},
    {"laws.steps.digits", KEY_INTEGER, AT(laws.steps.digits), .least = 4, .most = LIMIT_DIGITS, .standard = "60",
        .meaning = "decimal digits to compute with"},
    {"laws.steps.from", KEY_NUMBER, AT(laws.steps.sizes.from), .above = "0", .rational = true, .required = true,
        .meaning = "the largest h"},
    {"laws.steps.to", KEY_NUMBER, AT(laws.steps.sizes.to), .above = "0", .rational = true, .required = true,
        .meaning = "the smallest h"},
    {"laws.steps.per_decade", KEY_INTEGER, AT(laws.steps.sizes.per_decade), .least = 1, .most = 100, .standard = "1",
        .meaning = "values of h in a factor of ten"},
    {"laws.smoothing", KEY_SECTION, AT(laws.has_smoothing), .meaning = "runs with smoothed absolute values each"},
    {"laws.smoothing.from", KEY_NUMBER, AT(laws.smoothing.from), .above = "0", .rational = true, .required = true,
        .meaning = "the largest eps"},
    {"laws.smoothing.to", KEY_NUMBER, AT(laws.smoothing.to), .above = "0", .rational = true, .required = true,
        .meaning = "the smallest eps"},
    {"laws.smoothing.per_decade", KEY_INTEGER, AT(laws.smoothing.per_decade), .least = 1, .most = 100, .standard = "1",
        .meaning = "values of eps in a factor of ten"},

    {"lyapunov", KEY_SECTION, AT(has_lyapunov), .meaning = "of `cns lyapunov`"},
    {"lyapunov.time", KEY_NUMBER, AT(lyapunov.time), .above = "0", .rational = true, .standard = "20000",
        .meaning = "to follow the tangents for"},
    {"lyapunov.arithmetic", KEY_WORD, AT(lyapunov.arithmetic), ARITHMETICS, .standard = "double",
        .meaning = "of states and tangents"},
    {"lyapunov.digits", KEY_INTEGER, AT(lyapunov.digits), .least = 4, .most = LIMIT_DIGITS, .standard = "30",
        .meaning = "decimal digits to compute with; not with double"},

    {"bisect", KEY_SECTION, AT(has_bisect), .meaning = "of `cns bisect`"},
    {"bisect.parameter", KEY_PARAMETER, AT(bisect.parameter), .required = true,
        .meaning = "what is varied: a parameter of the model"},
    {"bisect.lower", KEY_NUMBER, AT(bisect.lower), .rational = true, .required = true,
        .meaning = "lower end of the bracket"},
    {"bisect.upper", KEY_NUMBER, AT(bisect.upper), .rational = true, .required = true,
        .meaning = "upper end of the bracket"},
    {"bisect.by", KEY_WORD, AT(bisect.by_manifold), {{"manifold", true}, {"trajectory", false}}, .standard = "manifold",
        .meaning = "what a probe is: the saddle's unstable manifold, or the case's trajectory"},
    {"bisect.decimals", KEY_INTEGER, AT(bisect.decimals), .least = 1, .most = LIMIT_DECIMALS, .standard = "20",
        .meaning = "right decimals of the critical value"},
};
/* clang-format on */

const int cns_n_keys = sizeof cns_keys / sizeof *cns_keys;

static const cns_key *find(const char *path, size_t length)
{
    for (int i = 0; i < cns_n_keys; i++)
        if (strncmp(cns_keys[i].path, path, length) == 0 && cns_keys[i].path[length] == '\0')
            return &cns_keys[i];
    return NULL;
}

const cns_key *cns_key_find(const char *path)
{
    return find(path, strlen(path));
}

const char *cns_key_name(const cns_key *k)
{
    const char *dot = strrchr(k->path, '.');
    return dot != NULL ? dot + 1 : k->path;
}

const cns_key *cns_key_section(const cns_key *k)
{
    const char *dot = strrchr(k->path, '.');
    return dot != NULL ? find(k->path, (size_t)(dot - k->path)) : NULL;
}

const char *cns_key_indent(const cns_key *k)
{
    const char *dot = strchr(k->path, '.');
    return dot == NULL ? "" : strchr(dot + 1, '.') == NULL ? "    " : "        ";
}

cns_key_text cns_key_title(const cns_key *k)
{
    cns_key_text t;
    const cns_key *section = cns_key_section(k);
    if (section != NULL)
        snprintf(t.text, sizeof t.text, "'%s' in '%s'", cns_key_name(k), section->path);
    else
        snprintf(t.text, sizeof t.text, "'%s'", k->path);
    return t;
}

cns_key_text cns_key_range(const cns_key *k)
{
    cns_key_text r;
    const char *names[CNS_KEY_WORDS];
    char words[64], all[96] = "";
    int n = 0;
    for (; n < CNS_KEY_WORDS && k->words[n].text != NULL; n++)
        names[n] = k->words[n].text;
    cns_text_list(words, sizeof words, names, n);
    switch (k->kind) {
    case KEY_INTEGER:
        snprintf(all, sizeof all, "an integer from %ld to %ld", k->least, k->most);
        break;
    case KEY_NUMBER:
        if (k->above != NULL && k->below != NULL)
            snprintf(all, sizeof all, "a number between %s and %s", k->above, k->below);
        else if (k->above != NULL)
            snprintf(all, sizeof all, "a number > %s", k->above);
        else
            snprintf(all, sizeof all, "a number");
        break;
    case KEY_STATE:
        snprintf(all, sizeof all, "a state of the model");
        break;
    case KEY_PARAMETER:
        snprintf(all, sizeof all, "a parameter of the model");
        break;
    case KEY_WORD:
        break;
    default:
        snprintf(all, sizeof all, "a mapping");
        break;
    }
    snprintf(r.text, sizeof r.text, "%s%s%s", all, all[0] != '\0' && words[0] != '\0' ? ", or " : "", words);
    return r;
}

const cns_key_word *cns_key_word_named(const cns_key *k, const char *text)
{
    for (int i = 0; i < CNS_KEY_WORDS && k->words[i].text != NULL; i++)
        if (strcmp(k->words[i].text, text) == 0)
            return &k->words[i];
    return NULL;
}

const cns_key_word *cns_key_word_for(const cns_key *k, long value)
{
    for (int i = 0; i < CNS_KEY_WORDS && k->words[i].text != NULL; i++)
        if (k->words[i].value == value)
            return &k->words[i];
    return NULL;
}

void *cns_key_field(const cns_key *k, const cns_case *c)
{
    return (char *)c + k->field;
}

void cns_key_put(const cns_key *k, cns_case *c, long value)
{
    void *at = cns_key_field(k, c);
    if (k->type == FIELD_BOOL)
        *(bool *)at = value != 0;
    else if (k->type == FIELD_INT)
        *(int *)at = (int)value;
    else if (k->type == FIELD_LONG)
        *(long *)at = value;
    else if (k->type == FIELD_NUMBER)
        cns_number_parse(at, "0", NULL);
}

long cns_key_get(const cns_key *k, const cns_case *c)
{
    const void *at = cns_key_field(k, c);
    switch (k->type) {
    case FIELD_BOOL:
        return *(const bool *)at;
    case FIELD_INT:
        return *(const int *)at;
    case FIELD_LONG:
        return *(const long *)at;
    case FIELD_NUMBER:
        return cns_number_sign(at);
    default:
        return 1;
    }
}

void cns_case_print_keys(FILE *out)
{
    fputs("A case file is YAML: keys and values, at most three levels deep. Values are exact: decimals, "
          "fractions and\n"
          "pi, as in 2.2, 1e-30, 8/3, 2*pi/3. `--set SECTION.KEY=VALUE` overrides a value.\n\n",
          out);
    for (const cns_key *k = cns_keys; k < cns_keys + cns_n_keys; k++) {
        const char *lead = cns_key_indent(k), *standard = k->standard != NULL ? k->standard : k->otherwise;
        const bool ranged = k->kind >= KEY_STATE;
        fprintf(out, "%s%-*s%s", lead, 20 - (int)strlen(lead), cns_key_name(k), k->meaning);
        if (k->required)
            fprintf(out, "%srequired", k->meaning[0] != '\0' ? "; " : "");
        if (ranged || standard != NULL)
            fprintf(out, "\n%24s%s%s%s%s", "", ranged ? cns_key_range(k).text : "",
                    ranged && standard != NULL ? "; " : "", standard != NULL ? "default " : "",
                    standard != NULL ? standard : "");
        fputc('\n', out);
    }
    fputs(
        "\n`run` needs `goal` or `numerics`, never both. In a list of columns, `t` is the time; `decimals`\n"
        "and `growth` are always printed, last.\n",
        out);
}
