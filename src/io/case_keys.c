/* The table of keys of case files, and the help on them. */
#include <stdio.h>
#include <string.h>

#include "case_internal.h"
#include "core/text.h"
#include "integrate/numerics.h"
#include "solve/proof.h"

#define TEXT_OF(x)  #x
#define TEXT_OF2(x) TEXT_OF(x)

enum { LIMIT_DECIMALS = 10000, LIMIT_DIGITS = 100000, LIMIT_ORDER = 100000 };

static bool has_tolerance(const cns_case *c)
{
    return c->numerics.method != CNS_METHOD_RK4;
}

static bool begins_elsewhere(const cns_case *c)
{
    return cns_number_sign(&c->start) != 0;
}

static bool has_no_list(const cns_case *c)
{
    return c->at == NULL;
}

/* clang-format off */

/* The field of cns_case that holds the value of a key: its offset and its type. */
#define AT(x)                                                                                                           \
    offsetof(cns_case, x),                                                                                              \
    _Generic(((const cns_case *)NULL)->x, bool: FIELD_BOOL, int: FIELD_INT, unsigned: FIELD_INT, long: FIELD_LONG,      \
             double: FIELD_DOUBLE, cns_number: FIELD_NUMBER)

#define ARITHMETICS {{"fast", CNS_ARITH_FAST}, {"mpfr", CNS_ARITH_MPFR}, {"double", CNS_ARITH_DOUBLE}}

const cns_key cns_keys[CNS_KEYS] = {
#define KEY(id, ...) [K_##id] = {__VA_ARGS__},
#include "case_keys.def"
#undef KEY
};
/* clang-format on */

static const cns_key *find(const char *path, size_t length)
{
    for (int i = 0; i < CNS_KEYS; i++)
        if (strncmp(cns_keys[i].path, path, length) == 0 && cns_keys[i].path[length] == '\0')
            return &cns_keys[i];
    return NULL;
}

const char *cns_case_key_of_run(const char *name)
{
    static const cns_key_id sections[] = {K_TIME, K_GOAL, K_NUMERICS};
    for (const cns_key *k = cns_keys; k < cns_keys + CNS_KEYS; k++)
        for (size_t i = 0; i < sizeof sections / sizeof *sections; i++)
            if (cns_key_section(k) == &cns_keys[sections[i]] && strcmp(cns_key_name(k), name) == 0)
                return k->path;
    return NULL;
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
          "fractions and pi, as in 2.2, 1e-30, 8/3, 2*pi/3. `--set SECTION.KEY=VALUE` overrides a value.\n\n",
          out);
    for (const cns_key *k = cns_keys; k < cns_keys + CNS_KEYS; k++) {
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
    fputs("\n`run` needs `goal` or `numerics`, never both: on the command line, `--set` of the one replaces "
          "the other. In a list of columns, `t` is the time; `decimals` "
          "and "
          "`growth` are always printed, last.\n",
          out);
}
