#include "cns/case.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/sha256.h"
#include "core/text.h"
#include "yaml_tree.h"

/* The keys.
 *
 * One row per key: checking, `cns check`, `cns help case` and the suggestions in messages all come from
 * here. A new key is an enumerator, a row, and its use in resolve() and print_value(). */

typedef enum key_kind {
    KEY_SECTION,    /* a mapping of keys that have rows here */
    KEY_MODEL,      /* name of a model */
    KEY_PARAMETERS, /* mapping from the model's parameters to numbers */
    KEY_INITIAL,    /* mapping from the model's states to numbers */
    KEY_COLUMNS,    /* list of t, states and outputs of the model */
    KEY_STATE,      /* name of a state, or one of words */
    KEY_PARAMETER,  /* name of a parameter */
    KEY_INTEGER,    /* least..most, or one of words */
    KEY_NUMBER,     /* above < value < below, or one of words */
    KEY_WORD        /* one of words */
} key_kind;

typedef struct key_row {
    const char *section; /* NULL: at the top; sections in sections have dots: "laws.digits" */
    const char *key;
    key_kind kind;
    const char *words[3]; /* a section that has words may be one of these instead of a mapping */
    long least, most;
    const char *above, *below; /* open ends, as text; NULL: none */
    const char *standard;      /* for the help; NULL: there is none */
    const char *meaning;
    bool rational; /* a multiple of pi will not do: rows and steps are counted exactly */
} key_row;

#define LIMIT_DECIMALS         10000
#define LIMIT_DIGITS           100000
#define LIMIT_ORDER            100000
#define MAX_DIGITS             5000 /* default of goal.max_digits */
#define LEAST_MAX_DIGITS       26   /* the second run of a proof has 22 digits fewer, and a few are needed */
#define DOUBLE_ORDER           30   /* beyond it coefficients scaled in double underflow or cancel to noise */
#define LIMIT_ROWS             10000000L
#define STANDARD_DELTA         "0.01"
#define STANDARD_LYAPUNOV_TIME "20000"
#define LIMIT_STEPS            "1e15" /* of a fixed step up to the end: a month of the fastest is far below */

#define TEXT_OF(x)  #x
#define TEXT_OF2(x) TEXT_OF(x)

typedef enum key_id {
    K_MODEL,
    K_PARAMETERS,
    K_INITIAL,
    K_TIME,
    K_END,
    K_EVERY,
    K_ABS,
    K_SMOOTH,
    K_GOAL,
    K_DECIMALS,
    K_SIGNIFICANT,
    K_MAX_DIGITS,
    K_MAX_TIME,
    K_NUMERICS,
    K_METHOD,
    K_ARITHMETIC,
    K_DIGITS,
    K_ORDER,
    K_STEP,
    K_TOLERANCE,
    K_OUTPUT,
    K_COLUMNS,
    K_LAWS,
    K_DELTA,
    K_OBSERVABLE,
    K_LAWS_DIGITS,
    K_DIGITS_FROM,
    K_DIGITS_TO,
    K_DIGITS_BY,
    K_LAWS_STEPS,
    K_STEPS_METHOD,
    K_STEPS_ORDER,
    K_STEPS_DIGITS,
    K_STEPS_FROM,
    K_STEPS_TO,
    K_STEPS_PER_DECADE,
    K_LAWS_SMOOTHING,
    K_SMOOTHING_FROM,
    K_SMOOTHING_TO,
    K_SMOOTHING_PER_DECADE,
    K_LYAPUNOV,
    K_LYAPUNOV_TIME,
    K_LYAPUNOV_ARITHMETIC,
    K_LYAPUNOV_DIGITS,
    K_BISECT,
    K_BISECT_PARAMETER,
    K_BISECT_LOWER,
    K_BISECT_UPPER,
    K_BISECT_BY,
    K_BISECT_DECIMALS,
    N_KEYS
} key_id;

/* clang-format off */
static const key_row rows[N_KEYS] = {
    [K_MODEL] = {.key = "model", .kind = KEY_MODEL,
        .meaning = "the equations: `cns models` lists them; required"},
    [K_PARAMETERS] = {.key = "parameters", .kind = KEY_PARAMETERS,
        .meaning = "values of the model's parameters; those left out take the model's defaults"},
    [K_INITIAL] = {.key = "initial", .kind = KEY_INITIAL,
        .meaning = "the state at t = 0; those left out are 0"},

    [K_TIME] = {.key = "time", .kind = KEY_SECTION, .meaning = "required"},
    [K_END] = {.section = "time", .key = "end", .kind = KEY_NUMBER, .above = "0", .rational = true,
        .meaning = "the last time; required"},
    [K_EVERY] = {.section = "time", .key = "every", .kind = KEY_NUMBER, .above = "0", .rational = true, .standard = "end",
        .meaning = "rows at 0, at multiples of this and at the end"},

    [K_ABS] = {.key = "abs", .kind = KEY_SECTION, .words = {"exact"}, .standard = "exact",
        .meaning = "absolute values in the equations: true ones, or a mapping with `smooth`"},
    [K_SMOOTH] = {.section = "abs", .key = "smooth", .kind = KEY_NUMBER, .above = "0",
        .meaning = "eps: abs(u) becomes sqrt(u^2 + eps^2)"},

    [K_GOAL] = {.key = "goal", .kind = KEY_SECTION,
        .meaning = "what the table must prove; the program chooses the numerics"},
    [K_DECIMALS] = {.section = "goal", .key = "decimals", .kind = KEY_INTEGER,
        .least = 1, .most = LIMIT_DECIMALS, .meaning = "right decimals in every value; or:"},
    [K_SIGNIFICANT] = {.section = "goal", .key = "significant", .kind = KEY_INTEGER,
        .least = 1, .most = LIMIT_DECIMALS, .meaning = "right significant digits in every value"},
    [K_MAX_DIGITS] = {.section = "goal", .key = "max_digits", .kind = KEY_INTEGER,
        .least = LEAST_MAX_DIGITS, .most = LIMIT_DIGITS, .standard = TEXT_OF2(MAX_DIGITS),
        .meaning = "give up rather than compute with more digits"},
    [K_MAX_TIME] = {.section = "goal", .key = "max_time", .kind = KEY_NUMBER, .above = "0", .below = "1e12",
        .standard = "no limit", .meaning = "seconds after which to give up"},

    [K_NUMERICS] = {.key = "numerics", .kind = KEY_SECTION,
        .meaning = "the numerics by hand, instead of `goal`"},
    [K_METHOD] = {.section = "numerics", .key = "method", .kind = KEY_WORD, .words = {"taylor", "rk4"},
        .standard = "taylor", .meaning = "how a step is made; rk4 needs a fixed step"},
    [K_ARITHMETIC] = {.section = "numerics", .key = "arithmetic", .kind = KEY_WORD,
        .words = {"fast", "mpfr", "double"}, .standard = "fast (taylor) or mpfr (rk4)",
        .meaning = "fast: fixed point; double: with rk4, or taylor of order <= " TEXT_OF2(DOUBLE_ORDER) ", no digits"},
    [K_DIGITS] = {.section = "numerics", .key = "digits", .kind = KEY_INTEGER,
        .least = 1, .most = LIMIT_DIGITS, .meaning = "decimal digits to compute with; required with mpfr"},
    [K_ORDER] = {.section = "numerics", .key = "order", .kind = KEY_INTEGER, .words = {"auto"},
        .least = 1, .most = LIMIT_ORDER, .standard = "auto", .meaning = "of the Taylor series"},
    [K_STEP] = {.section = "numerics", .key = "step", .kind = KEY_NUMBER, .words = {"adaptive"},
        .above = "0", .rational = true, .standard = "adaptive", .meaning = "adaptive, or the fixed step"},
    [K_TOLERANCE] = {.section = "numerics", .key = "tolerance", .kind = KEY_NUMBER, .words = {"auto"},
        .above = "0", .below = "1", .standard = "auto",
        .meaning = "local, relative to the model's scales; auto: 10^-digits"},

    [K_OUTPUT] = {.key = "output", .kind = KEY_SECTION, .meaning = "what the table shows"},
    [K_COLUMNS] = {.section = "output", .key = "columns", .kind = KEY_COLUMNS,
        .standard = "[t, the states]", .meaning = "t, states and derived quantities of the model"},

    [K_LAWS] = {.key = "laws", .kind = KEY_SECTION,
        .meaning = "of `cns laws` and `cns tc`: which runs, and when two part"},
    [K_DELTA] = {.section = "laws", .key = "delta", .kind = KEY_NUMBER, .above = "0", .standard = STANDARD_DELTA,
        .meaning = "the difference at which a run has parted from the reference"},
    [K_OBSERVABLE] = {.section = "laws", .key = "observable", .kind = KEY_STATE, .words = {"norm"}, .standard = "norm",
        .meaning = "what differs: the distance of the dynamic states in the model's scales, or one state"},
    [K_LAWS_DIGITS] = {.section = "laws", .key = "digits", .kind = KEY_SECTION,
        .meaning = "runs of K digits each"},
    [K_DIGITS_FROM] = {.section = "laws.digits", .key = "from", .kind = KEY_INTEGER, .least = 4, .most = LIMIT_DIGITS,
        .meaning = "the smallest K; required"},
    [K_DIGITS_TO] = {.section = "laws.digits", .key = "to", .kind = KEY_INTEGER, .least = 4, .most = LIMIT_DIGITS,
        .meaning = "the largest K; required"},
    [K_DIGITS_BY] = {.section = "laws.digits", .key = "by", .kind = KEY_INTEGER, .least = 1, .most = LIMIT_DIGITS,
        .standard = "1", .meaning = "from one K to the next"},
    [K_LAWS_STEPS] = {.section = "laws", .key = "steps", .kind = KEY_SECTION,
        .meaning = "runs with a fixed step h each"},
    [K_STEPS_METHOD] = {.section = "laws.steps", .key = "method", .kind = KEY_WORD, .words = {"rk4", "taylor"},
        .standard = "rk4", .meaning = "how a step is made"},
    [K_STEPS_ORDER] = {.section = "laws.steps", .key = "order", .kind = KEY_INTEGER, .words = {"auto"},
        .least = 1, .most = LIMIT_ORDER, .standard = "auto", .meaning = "of the Taylor series; that of rk4 is 4"},
    [K_STEPS_DIGITS] = {.section = "laws.steps", .key = "digits", .kind = KEY_INTEGER, .least = 4, .most = LIMIT_DIGITS,
        .standard = "60", .meaning = "decimal digits to compute with"},
    [K_STEPS_FROM] = {.section = "laws.steps", .key = "from", .kind = KEY_NUMBER, .above = "0", .rational = true,
        .meaning = "the largest h; required"},
    [K_STEPS_TO] = {.section = "laws.steps", .key = "to", .kind = KEY_NUMBER, .above = "0", .rational = true,
        .meaning = "the smallest h; required"},
    [K_STEPS_PER_DECADE] = {.section = "laws.steps", .key = "per_decade", .kind = KEY_INTEGER, .least = 1, .most = 100,
        .standard = "1", .meaning = "values of h in a factor of ten"},
    [K_LAWS_SMOOTHING] = {.section = "laws", .key = "smoothing", .kind = KEY_SECTION,
        .meaning = "runs with smoothed absolute values each"},
    [K_SMOOTHING_FROM] = {.section = "laws.smoothing", .key = "from", .kind = KEY_NUMBER, .above = "0", .rational = true,
        .meaning = "the largest eps; required"},
    [K_SMOOTHING_TO] = {.section = "laws.smoothing", .key = "to", .kind = KEY_NUMBER, .above = "0", .rational = true,
        .meaning = "the smallest eps; required"},
    [K_SMOOTHING_PER_DECADE] = {.section = "laws.smoothing", .key = "per_decade", .kind = KEY_INTEGER, .least = 1, .most = 100,
        .standard = "1", .meaning = "values of eps in a factor of ten"},

    [K_LYAPUNOV] = {.key = "lyapunov", .kind = KEY_SECTION, .meaning = "of `cns lyapunov`"},
    [K_LYAPUNOV_TIME] = {.section = "lyapunov", .key = "time", .kind = KEY_NUMBER, .above = "0", .rational = true,
        .standard = STANDARD_LYAPUNOV_TIME, .meaning = "to follow the tangents for"},
    [K_LYAPUNOV_ARITHMETIC] = {.section = "lyapunov", .key = "arithmetic", .kind = KEY_WORD,
        .words = {"fast", "mpfr", "double"}, .standard = "double", .meaning = "of states and tangents"},
    [K_LYAPUNOV_DIGITS] = {.section = "lyapunov", .key = "digits", .kind = KEY_INTEGER, .least = 4, .most = LIMIT_DIGITS,
        .standard = "30", .meaning = "decimal digits to compute with; not with double"},

    [K_BISECT] = {.key = "bisect", .kind = KEY_SECTION, .meaning = "of `cns bisect`"},
    [K_BISECT_PARAMETER] = {.section = "bisect", .key = "parameter", .kind = KEY_PARAMETER,
        .meaning = "what is varied: a parameter of the model; required"},
    [K_BISECT_LOWER] = {.section = "bisect", .key = "lower", .kind = KEY_NUMBER, .rational = true,
        .meaning = "lower end of the bracket; required"},
    [K_BISECT_UPPER] = {.section = "bisect", .key = "upper", .kind = KEY_NUMBER, .rational = true,
        .meaning = "upper end of the bracket; required"},
    [K_BISECT_BY] = {.section = "bisect", .key = "by", .kind = KEY_WORD, .words = {"manifold", "trajectory"},
        .standard = "manifold", .meaning = "what a probe is: the saddle's unstable manifold, or the case's trajectory"},
    [K_BISECT_DECIMALS] = {.section = "bisect", .key = "decimals", .kind = KEY_INTEGER,
        .least = 1, .most = LIMIT_DECIMALS, .standard = "20", .meaning = "right decimals of the critical value"},
};
/* clang-format on */

static bool same_section(const char *a, const char *b)
{
    return a == b || (a != NULL && b != NULL && strcmp(a, b) == 0);
}

static int find_key(const char *section, const char *key)
{
    for (int k = 0; k < N_KEYS; k++)
        if (same_section(rows[k].section, section) && strcmp(rows[k].key, key) == 0)
            return k;
    return -1;
}

/* The name that the keys of section k give as theirs. */
typedef struct section_path {
    char text[64];
} section_path;

static section_path path_of(key_id k)
{
    section_path p;
    snprintf(p.text, sizeof p.text, "%s%s%s", rows[k].section != NULL ? rows[k].section : "",
             rows[k].section != NULL ? "." : "", rows[k].key);
    return p;
}

/* The row of a section, by such a name. */
static int find_section(const char *path)
{
    for (int k = 0; k < N_KEYS; k++)
        if (rows[k].kind == KEY_SECTION && strcmp(path_of((key_id)k).text, path) == 0)
            return k;
    return -1;
}

/* Sets of names, for suggestions and messages. */

enum { MAX_NAMES = 256 }; /* parameters, or columns, of a model; or keys */

typedef struct name_set {
    int count;
    const char *names[MAX_NAMES];
} name_set;

static void add_name(name_set *s, const char *name)
{
    if (s->count < MAX_NAMES)
        s->names[s->count++] = name;
}

static const char *name_at(int i, const void *context)
{
    return ((const name_set *)context)->names[i];
}

static void key_names(name_set *s, const char *section)
{
    s->count = 0;
    for (int k = 0; k < N_KEYS; k++)
        if (same_section(rows[k].section, section))
            add_name(s, rows[k].key);
}

static void model_names(name_set *s)
{
    s->count = 0;
    for (int i = 0; i < cns_model_count(); i++)
        add_name(s, cns_model_at(i)->name);
}

static void state_names(name_set *s, const cns_model *m)
{
    s->count = 0;
    for (int i = 0; i < m->n_states; i++)
        add_name(s, m->states[i].name);
}

static void parameter_names(name_set *s, const cns_model *m)
{
    s->count = 0;
    for (int i = 0; i < m->n_parameters; i++)
        add_name(s, m->parameters[i].name);
}

static void column_names(name_set *s, const cns_model *m)
{
    s->count = 0;
    add_name(s, "t");
    for (int i = 0; i < m->n_states; i++)
        add_name(s, m->states[i].name);
    for (int i = 0; i < m->n_outputs; i++)
        add_name(s, m->outputs[i].name);
}

/* "a, b or c" */
static void list_names(char *to, size_t size, const char *const *names, int count)
{
    size_t used = 0;
    to[0] = '\0';
    for (int i = 0; i < count && used < size; i++) {
        const char *before = i == 0 ? "" : i == count - 1 ? " or " : ", ";
        int n = snprintf(to + used, size - used, "%s%s", before, names[i]);
        used += n > 0 ? (size_t)n : 0;
    }
}

/* Reports an unknown name with the likely one, which is returned, or else with all. `what` says "key",
 * `where` " in 'time'" or " of model apw" or nothing. */
static const char *unknown_name(cns_faults *f, cns_mark mark, const char *what, const char *name,
                                const char *where, const name_set *known)
{
    const char *nearest = cns_text_nearest(name, known->count, name_at, known);
    if (nearest != NULL) {
        cns_faults_add(f, mark, "unknown %s '%s'%s; did you mean '%s'?", what, cns_quote(name).text, where,
                       nearest);
        return nearest;
    }
    char list[512];
    list_names(list, sizeof list, known->names, known->count);
    if (known->count > 0)
        cns_faults_add(f, mark, "unknown %s '%s'%s; use %s", what, cns_quote(name).text, where, list);
    else
        cns_faults_add(f, mark, "unknown %s '%s'%s; there are none", what, cns_quote(name).text, where);
    return NULL;
}

/* Checking. */

typedef struct key_value {
    const cns_yaml_node *node; /* NULL: not given */
    bool good;                 /* given, and within its own range */
    int word;                  /* which of the row's words; -1: none of them */
    long integer;
    cns_number number;
} key_value;

typedef struct loader {
    cns_case *c;
    cns_faults faults;
    cns_yaml_node *root;
    key_value values[N_KEYS];
} loader;

static bool given(const loader *l, key_id k)
{
    return l->values[k].good;
}

/* Where a fault about key k is shown: at its value, else at its section, else at the top. */
static cns_mark place_of(const loader *l, key_id k)
{
    if (l->values[k].node != NULL)
        return l->values[k].node->mark;
    for (const char *path = rows[k].section; path != NULL;) {
        const int section = find_section(path);
        if (l->values[section].node != NULL)
            return l->values[section].node->key_mark;
        path = rows[section].section;
    }
    return l->root->mark;
}

/* Full name of a key for messages: 'end' in 'time'. */
typedef struct key_title {
    char text[64];
} key_title;

static key_title title_of(key_id k)
{
    key_title t;
    if (rows[k].section != NULL)
        snprintf(t.text, sizeof t.text, "'%s' in '%s'", rows[k].key, rows[k].section);
    else
        snprintf(t.text, sizeof t.text, "'%s'", rows[k].key);
    return t;
}

static const char *kind_of_node(const cns_yaml_node *node)
{
    if (node->kind == CNS_YAML_MAPPING)
        return "a mapping";
    return node->kind == CNS_YAML_SEQUENCE ? "a list" : "a single value";
}

/* A single, non-empty value; else a fault that says what is wanted. */
static bool is_value(loader *l, const cns_yaml_node *node, const char *title, const char *wanted)
{
    if (node->kind != CNS_YAML_SCALAR) {
        cns_faults_add(&l->faults, node->mark, "%s must be %s, not %s", title, wanted, kind_of_node(node));
        return false;
    }
    if (node->text[0] == '\0') {
        cns_faults_add(&l->faults, node->mark, "%s has no value; it must be %s", title, wanted);
        return false;
    }
    return true;
}

static bool is_mapping(loader *l, const cns_yaml_node *node, const char *title)
{
    if (node->kind == CNS_YAML_MAPPING)
        return true;
    if (node->kind == CNS_YAML_SCALAR && node->text[0] == '\0')
        cns_faults_add(&l->faults, node->mark, "%s has no value; it must be a mapping of keys to values",
                       title);
    else
        cns_faults_add(&l->faults, node->mark, "%s must be a mapping of keys to values, not %s", title,
                       kind_of_node(node));
    return false;
}

static int find_word(const key_row *row, const char *text)
{
    for (int i = 0; i < 3 && row->words[i] != NULL; i++)
        if (strcmp(row->words[i], text) == 0)
            return i;
    return -1;
}

static int count_words(const key_row *row)
{
    int n = 0;
    while (n < 3 && row->words[n] != NULL)
        n++;
    return n;
}

/* What a key takes: "an integer from 1 to 100000, or auto". */
typedef struct range_text {
    char text[192];
} range_text;

static range_text range_of(const key_row *row)
{
    range_text r;
    char words[64], all[96] = "";
    list_names(words, sizeof words, row->words, count_words(row));
    switch (row->kind) {
    case KEY_INTEGER:
        snprintf(all, sizeof all, "an integer from %ld to %ld", row->least, row->most);
        break;
    case KEY_NUMBER:
        if (row->above != NULL && row->below != NULL)
            snprintf(all, sizeof all, "a number between %s and %s", row->above, row->below);
        else if (row->above != NULL)
            snprintf(all, sizeof all, "a number > %s", row->above);
        else
            snprintf(all, sizeof all, "a number");
        break;
    case KEY_COLUMNS:
        snprintf(all, sizeof all, "a list of names");
        break;
    case KEY_MODEL:
        snprintf(all, sizeof all, "a name");
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

static bool parse_integer(const char *text, long *value)
{
    const char *digits = text + (*text == '-');
    size_t n = strspn(digits, "0123456789");
    if (n == 0 || digits[n] != '\0' || (n > 1 && digits[0] == '0'))
        return false;
    errno = 0;
    *value = strtol(text, NULL, 10); /* out of range: the nearest end, outside every range here */
    return true;
}

static void check_integer(loader *l, key_id k, const cns_yaml_node *node)
{
    const key_row *row = &rows[k];
    key_value *v = &l->values[k];
    if (!is_value(l, node, title_of(k).text, range_of(row).text))
        return;
    v->word = find_word(row, node->text);
    v->good = v->word >= 0 ||
              (parse_integer(node->text, &v->integer) && v->integer >= row->least && v->integer <= row->most);
    if (!v->good)
        cns_faults_add(&l->faults, node->mark, "%s must be %s, not '%s'", title_of(k).text,
                       range_of(row).text, cns_quote(node->text).text);
}

static bool within(const cns_number *x, const char *above, const char *below)
{
    cns_number limit;
    cns_number_init(&limit);
    bool good = true;
    if (above != NULL && cns_number_parse(&limit, above, NULL) == CNS_OK)
        good = cns_number_cmp(x, &limit) > 0;
    if (good && below != NULL && cns_number_parse(&limit, below, NULL) == CNS_OK)
        good = cns_number_cmp(x, &limit) < 0;
    cns_number_clear(&limit);
    return good;
}

static void check_number(loader *l, key_id k, const cns_yaml_node *node)
{
    const key_row *row = &rows[k];
    key_value *v = &l->values[k];
    if (!is_value(l, node, title_of(k).text, range_of(row).text))
        return;
    v->word = find_word(row, node->text);
    v->good = v->word >= 0;
    if (v->good)
        return;
    cns_error err;
    if (cns_number_parse(&v->number, node->text, &err) != CNS_OK)
        cns_faults_add(&l->faults, node->mark, "%s must be %s; %s", title_of(k).text, range_of(row).text,
                       err.text);
    else if (row->rational && v->number.pi_power != 0)
        cns_faults_add(&l->faults, node->mark, "%s must be a decimal or a fraction, not '%s'",
                       title_of(k).text, cns_quote(node->text).text);
    else if (!within(&v->number, row->above, row->below))
        cns_faults_add(&l->faults, node->mark, "%s must be %s, not '%s'", title_of(k).text,
                       range_of(row).text, cns_quote(node->text).text);
    else
        v->good = true;
}

static void check_word(loader *l, key_id k, const cns_yaml_node *node)
{
    const key_row *row = &rows[k];
    if (!is_value(l, node, title_of(k).text, range_of(row).text))
        return;
    l->values[k].word = find_word(row, node->text);
    l->values[k].good = l->values[k].word >= 0;
    if (l->values[k].good)
        return;
    name_set words = {0};
    for (int i = 0; i < count_words(row); i++)
        add_name(&words, row->words[i]);
    const char *nearest = cns_text_nearest(node->text, words.count, name_at, &words);
    if (nearest != NULL)
        cns_faults_add(&l->faults, node->mark, "%s must be %s, not '%s'; did you mean '%s'?",
                       title_of(k).text, range_of(row).text, cns_quote(node->text).text, nearest);
    else
        cns_faults_add(&l->faults, node->mark, "%s must be %s, not '%s'", title_of(k).text,
                       range_of(row).text, cns_quote(node->text).text);
}

static void check_model(loader *l, const cns_yaml_node *node)
{
    if (!is_value(l, node, "'model'", "the name of a model"))
        return;
    l->c->model = cns_model_find(node->text);
    l->values[K_MODEL].good = l->c->model != NULL;
    if (l->c->model == NULL) {
        name_set known;
        model_names(&known);
        unknown_name(&l->faults, node->mark, "model", node->text, "", &known);
    }
}

/* Index of a name in a set, -1 when it is not there. */
static int find_name(const name_set *s, const char *name)
{
    for (int i = 0; i < s->count; i++)
        if (strcmp(s->names[i], name) == 0)
            return i;
    return -1;
}

/* `parameters` and `initial`: numbers by the names of the model. Without a model the numbers are still
 * checked, into nothing. */
static void check_numbers(loader *l, key_id k, const cns_yaml_node *section, cns_number *values, bool *got)
{
    const cns_model *m = l->c->model;
    const bool parameters = k == K_PARAMETERS;
    name_set known = {0};
    if (m != NULL && parameters)
        parameter_names(&known, m);
    else if (m != NULL)
        state_names(&known, m);
    cns_number spare;
    cns_number_init(&spare);
    for (const cns_yaml_node *node = section->first; node != NULL; node = node->next) {
        if (node->refused)
            continue;
        int i = find_name(&known, node->key);
        if (m != NULL && i < 0) {
            char where[64];
            snprintf(where, sizeof where, " of model %s", m->name);
            unknown_name(&l->faults, node->key_mark, parameters ? "parameter" : "state", node->key, where,
                         &known);
        }
        char title[CNS_QUOTE + 32];
        snprintf(title, sizeof title, "'%s' in '%s'", cns_quote(node->key).text, rows[k].key);
        if (!is_value(l, node, title, "a number"))
            continue;
        cns_number *value = i >= 0 ? &values[i] : &spare;
        cns_error err;
        if (cns_number_parse(value, node->text, &err) != CNS_OK) {
            cns_faults_add(&l->faults, node->mark, "%s: %s", title, err.text);
            continue;
        }
        const char *minimum = i >= 0 && parameters ? m->parameters[i].minimum : NULL;
        if (minimum != NULL && !within(value, minimum, NULL))
            cns_faults_add(&l->faults, node->mark, "%s must be > %s for model %s, not '%s'", title, minimum,
                           m->name, cns_quote(node->text).text);
        else if (i >= 0)
            got[i] = true;
    }
    cns_number_clear(&spare);
}

static void check_parameters(loader *l, const cns_yaml_node *node)
{
    cns_case *c = l->c;
    bool got[MAX_NAMES] = {false};
    if (node != NULL && !node->refused && is_mapping(l, node, "'parameters'"))
        check_numbers(l, K_PARAMETERS, node, c->parameters, got);
    if (c->model == NULL)
        return;
    for (int i = 0; i < c->model->n_parameters && i < MAX_NAMES; i++) {
        const cns_model_parameter *p = &c->model->parameters[i];
        if (got[i])
            continue;
        if (p->standard != NULL)
            cns_number_parse(&c->parameters[i], p->standard, NULL);
        else if (cns_yaml_find(node, p->name) == NULL)
            cns_faults_add(&l->faults, node != NULL ? node->key_mark : l->root->mark,
                           "missing parameter '%s': model %s has no default for it", p->name, c->model->name);
    }
}

static void check_initial(loader *l, const cns_yaml_node *node)
{
    bool got[MAX_NAMES];
    if (node != NULL && !node->refused && is_mapping(l, node, "'initial'"))
        check_numbers(l, K_INITIAL, node, l->c->initial, got);
}

static cns_column column_of(const cns_model *m, int i)
{
    if (i == 0)
        return (cns_column){CNS_COLUMN_TIME, 0};
    if (i <= m->n_states)
        return (cns_column){CNS_COLUMN_STATE, i - 1};
    return (cns_column){CNS_COLUMN_OUTPUT, i - 1 - m->n_states};
}

static void check_columns(loader *l, const cns_yaml_node *list)
{
    cns_case *c = l->c;
    if (list->kind != CNS_YAML_SEQUENCE || list->first == NULL) {
        cns_faults_add(&l->faults, list->mark, "%s must be a list of names, such as [t, x]",
                       title_of(K_COLUMNS).text);
        return;
    }
    if (c->model == NULL)
        return;
    name_set known;
    column_names(&known, c->model);
    bool seen[MAX_NAMES] = {false};
    c->columns = cns_xalloc((size_t)known.count, sizeof *c->columns);
    for (const cns_yaml_node *node = list->first; node != NULL; node = node->next) {
        if (node->refused || !is_value(l, node, "a column", "a name"))
            continue;
        int i = find_name(&known, node->text);
        if (i < 0 && (strcmp(node->text, "decimals") == 0 || strcmp(node->text, "growth") == 0)) {
            cns_faults_add(&l->faults, node->mark, "column '%s' is always printed, last; leave it out",
                           node->text);
        } else if (i < 0) {
            char where[64];
            snprintf(where, sizeof where, " of model %s", c->model->name);
            unknown_name(&l->faults, node->mark, "column", node->text, where, &known);
        } else if (seen[i]) {
            cns_faults_add(&l->faults, node->mark, "doubled column '%s'", node->text);
        } else {
            seen[i] = true;
            c->columns[c->n_columns++] = column_of(c->model, i);
        }
    }
}

/* A state or a parameter of the model: its index is the integer of the value. */
static void check_name(loader *l, key_id k, const cns_yaml_node *node)
{
    const key_row *row = &rows[k];
    const cns_model *m = l->c->model;
    key_value *v = &l->values[k];
    if (!is_value(l, node, title_of(k).text, range_of(row).text))
        return;
    v->word = find_word(row, node->text);
    v->good = v->word >= 0;
    if (v->good || m == NULL)
        return;
    name_set known;
    const bool state = row->kind == KEY_STATE;
    if (state)
        state_names(&known, m);
    else
        parameter_names(&known, m);
    v->integer = find_name(&known, node->text);
    v->good = v->integer >= 0;
    if (v->good)
        return;
    for (int i = 0; i < count_words(row); i++)
        add_name(&known, row->words[i]);
    char where[64];
    snprintf(where, sizeof where, " of model %s", m->name);
    unknown_name(&l->faults, node->mark, state ? "state" : "parameter", node->text, where, &known);
}

static void check_section(loader *l, const char *section, const cns_yaml_node *mapping);

static void check_key(loader *l, key_id k, const cns_yaml_node *node)
{
    const key_row *row = &rows[k];
    l->values[k].node = node;
    switch (row->kind) {
    case KEY_SECTION:
        if (node->kind == CNS_YAML_SCALAR && row->words[0] != NULL) {
            check_word(l, k, node);
        } else if (is_mapping(l, node, title_of(k).text)) {
            l->values[k].good = true;
            check_section(l, path_of(k).text, node);
        }
        break;
    case KEY_STATE:
    case KEY_PARAMETER:
        check_name(l, k, node);
        break;
    case KEY_COLUMNS:
        check_columns(l, node);
        break;
    case KEY_INTEGER:
        check_integer(l, k, node);
        break;
    case KEY_NUMBER:
        check_number(l, k, node);
        break;
    case KEY_WORD:
        check_word(l, k, node);
        break;
    case KEY_MODEL:
    case KEY_PARAMETERS:
    case KEY_INITIAL:
        break; /* in check_case(), which knows their order */
    }
}

static void unknown_key(loader *l, const char *section, const cns_yaml_node *node)
{
    /* a key in the wrong section: say where it belongs */
    for (int k = 0; k < N_KEYS; k++) {
        if (strcmp(rows[k].key, node->key) != 0)
            continue;
        if (rows[k].section != NULL && section != NULL)
            cns_faults_add(&l->faults, node->key_mark, "unknown key '%s' in '%s'; it belongs in '%s'",
                           rows[k].key, section, rows[k].section);
        else if (rows[k].section != NULL)
            cns_faults_add(&l->faults, node->key_mark, "unknown key '%s'; it belongs in '%s'", rows[k].key,
                           rows[k].section);
        else
            cns_faults_add(&l->faults, node->key_mark,
                           "unknown key '%s' in '%s'; it belongs at the top, not indented", rows[k].key,
                           section);
        return;
    }
    name_set known;
    char where[64] = "";
    key_names(&known, section);
    if (section != NULL)
        snprintf(where, sizeof where, " in '%s'", section);
    const char *meant = unknown_name(&l->faults, node->key_mark, "key", node->key, where, &known);
    /* a misspelt key is not missing as well */
    int k = meant != NULL ? find_key(section, meant) : -1;
    if (k >= 0 && l->values[k].node == NULL)
        l->values[k].node = node;
}

static void check_section(loader *l, const char *section, const cns_yaml_node *mapping)
{
    for (const cns_yaml_node *node = mapping->first; node != NULL; node = node->next) {
        int k = find_key(section, node->key);
        if (node->refused) {
            /* present, at least: nothing is missing on top of what was reported */
            if (k >= 0 && l->values[k].node == NULL)
                l->values[k].node = node;
        } else if (k < 0) {
            unknown_key(l, section, node);
        } else {
            check_key(l, (key_id)k, node);
        }
    }
}

static void require(loader *l, key_id k)
{
    if (l->values[k].node != NULL)
        return;
    cns_mark mark = place_of(l, k);
    if (rows[k].section != NULL)
        cns_faults_add(&l->faults, mark, "missing key '%s' in '%s': %s", rows[k].key, rows[k].section,
                       range_of(&rows[k]).text);
    else
        cns_faults_add(&l->faults, mark, "missing key '%s'", rows[k].key);
}

/* end / part > limit, to 128 bits */
static bool quotient_above(const cns_number *end, const cns_number *part, const char *limit)
{
    mpfr_t q, d;
    mpfr_init2(q, 128);
    mpfr_init2(d, 128);
    cns_number_get_mpfr(q, end);
    cns_number_get_mpfr(d, part);
    mpfr_div(q, q, d, MPFR_RNDN);
    mpfr_set_str(d, limit, 10, MPFR_RNDN);
    bool above = mpfr_cmp(q, d) > 0;
    mpfr_clear(q);
    mpfr_clear(d);
    return above;
}

static void resolve_time(loader *l)
{
    cns_case *c = l->c;
    if (l->values[K_TIME].node == NULL)
        require(l, K_TIME);
    else if (given(l, K_TIME))
        require(l, K_END);
    if (!given(l, K_END))
        return;
    cns_number_set(&c->end, &l->values[K_END].number);
    cns_number_set(&c->every, given(l, K_EVERY) ? &l->values[K_EVERY].number : &c->end);
    if (quotient_above(&c->end, &c->every, TEXT_OF2(1e7)))
        cns_faults_add(&l->faults, place_of(l, K_EVERY),
                       "'every' in 'time' makes more than %ld rows up to the end", LIMIT_ROWS);
}

static void resolve_abs(loader *l)
{
    if (given(l, K_ABS) && l->values[K_ABS].word < 0)
        require(l, K_SMOOTH);
    if (given(l, K_SMOOTH)) {
        l->c->smooth = true;
        cns_number_set(&l->c->eps, &l->values[K_SMOOTH].number);
    }
}

static void resolve_goal(loader *l)
{
    cns_goal *g = &l->c->goal;
    l->c->has_goal = true;
    const key_value *decimals = &l->values[K_DECIMALS], *significant = &l->values[K_SIGNIFICANT];
    if (decimals->node != NULL && significant->node != NULL)
        cns_faults_add(&l->faults, significant->node->key_mark,
                       "'goal' takes either 'decimals' or 'significant', not both");
    else if (decimals->node == NULL && significant->node == NULL)
        cns_faults_add(&l->faults, l->values[K_GOAL].node->key_mark,
                       "missing key in 'goal': 'decimals' or 'significant'");
    g->places = significant->node != NULL ? CNS_PLACES_SIGNIFICANT : CNS_PLACES_DECIMALS;
    key_id asked = significant->node != NULL ? K_SIGNIFICANT : K_DECIMALS;
    g->count = l->values[asked].integer;
    g->max_digits = given(l, K_MAX_DIGITS) ? l->values[K_MAX_DIGITS].integer : MAX_DIGITS;
    g->max_time = given(l, K_MAX_TIME) ? cns_number_get_d(&l->values[K_MAX_TIME].number) : 0;
    bool limit_good = given(l, K_MAX_DIGITS) || l->values[K_MAX_DIGITS].node == NULL;
    if (given(l, asked) && limit_good && g->count > g->max_digits)
        cns_faults_add(&l->faults, place_of(l, asked), "%s is above 'max_digits' (%ld%s)",
                       title_of(asked).text, g->max_digits, given(l, K_MAX_DIGITS) ? "" : ", its default");
}

static void resolve_numerics(loader *l)
{
    cns_numerics *n = &l->c->numerics;
    const key_value *v = l->values;
    l->c->has_numerics = true;
    n->method = given(l, K_METHOD) && v[K_METHOD].word == 1 ? CNS_METHOD_RK4 : CNS_METHOD_TAYLOR;
    static const cns_arithmetic words[] = {CNS_ARITH_FAST, CNS_ARITH_MPFR, CNS_ARITH_DOUBLE};
    n->arithmetic = given(l, K_ARITHMETIC)        ? words[v[K_ARITHMETIC].word]
                    : n->method == CNS_METHOD_RK4 ? CNS_ARITH_MPFR
                                                  : CNS_ARITH_FAST;
    n->digits = given(l, K_DIGITS) ? v[K_DIGITS].integer : 0;
    bool own_order = given(l, K_ORDER) && v[K_ORDER].word < 0;
    n->order = own_order ? v[K_ORDER].integer : 0;
    n->fixed_step = given(l, K_STEP) && v[K_STEP].word < 0;
    if (n->fixed_step)
        cns_number_set(&n->step, &v[K_STEP].number);
    n->auto_tolerance = !(given(l, K_TOLERANCE) && v[K_TOLERANCE].word < 0);
    if (!n->auto_tolerance)
        cns_number_set(&n->tolerance, &v[K_TOLERANCE].number);

    /* Keys that do not go together; after a bad method or arithmetic these would only mislead. */
    bool method_known = v[K_METHOD].node == NULL || given(l, K_METHOD);
    bool arithmetic_known = v[K_ARITHMETIC].node == NULL || given(l, K_ARITHMETIC);
    if (arithmetic_known && n->arithmetic != CNS_ARITH_DOUBLE)
        require(l, K_DIGITS);
    if (arithmetic_known && n->arithmetic == CNS_ARITH_DOUBLE && v[K_DIGITS].node != NULL)
        cns_faults_add(&l->faults, v[K_DIGITS].node->key_mark,
                       "'digits' does not go with 'arithmetic: double', which has its own 53 bits");
    if (method_known && n->method == CNS_METHOD_RK4) {
        if (v[K_STEP].node == NULL || (given(l, K_STEP) && !n->fixed_step))
            cns_faults_add(&l->faults, place_of(l, K_STEP),
                           "'method: rk4' needs a fixed 'step', such as 1e-3");
        if (arithmetic_known && n->arithmetic == CNS_ARITH_FAST)
            cns_faults_add(&l->faults, place_of(l, K_ARITHMETIC), "'method: rk4' computes in mpfr or double");
        if (own_order && n->order != 4)
            cns_faults_add(&l->faults, place_of(l, K_ORDER), "'order' of 'method: rk4' is 4 (or auto)");
        if (!n->auto_tolerance)
            cns_faults_add(&l->faults, v[K_TOLERANCE].node->key_mark,
                           "'tolerance' does not go with 'method: rk4', whose step is fixed");
        n->order = 4;
    } else if (method_known && arithmetic_known && n->arithmetic == CNS_ARITH_DOUBLE &&
               n->order > DOUBLE_ORDER) {
        cns_faults_add(&l->faults, place_of(l, K_ORDER), "'order' is at most %d with 'arithmetic: double'",
                       DOUBLE_ORDER);
    }
    if (n->fixed_step && given(l, K_END) && quotient_above(&l->c->end, &n->step, LIMIT_STEPS))
        cns_faults_add(&l->faults, place_of(l, K_STEP), "'step' makes more than %s steps up to the end",
                       LIMIT_STEPS);
}

/* Two ends of a range, wherever both are good: `from` must be `order` of `to` (1 above, -1 below). */
static void check_ends(loader *l, key_id from, key_id to, int order)
{
    const key_value *v = l->values;
    if (!given(l, from) || !given(l, to))
        return;
    const int found = rows[from].kind == KEY_INTEGER
                          ? (v[from].integer > v[to].integer) - (v[from].integer < v[to].integer)
                          : cns_number_cmp(&v[from].number, &v[to].number);
    if (found == -order || (found == 0 && rows[from].kind != KEY_INTEGER))
        cns_faults_add(&l->faults, v[to].node->mark, "%s must be %s %s", title_of(to).text,
                       order > 0 ? "below" : "above", title_of(from).text);
}

static void resolve_decades(loader *l, cns_decades *d, key_id from, key_id to, key_id per_decade)
{
    require(l, from);
    require(l, to);
    check_ends(l, from, to, 1);
    if (given(l, from))
        cns_number_set(&d->from, &l->values[from].number);
    if (given(l, to))
        cns_number_set(&d->to, &l->values[to].number);
    d->per_decade = given(l, per_decade) ? l->values[per_decade].integer : 1;
}

static void resolve_laws(loader *l)
{
    cns_laws_spec *laws = &l->c->laws;
    const key_value *v = l->values;
    l->c->has_laws = given(l, K_LAWS);
    if (given(l, K_DELTA))
        cns_number_set(&laws->delta, &v[K_DELTA].number);
    else
        cns_number_parse(&laws->delta, STANDARD_DELTA, NULL);
    laws->observable = given(l, K_OBSERVABLE) && v[K_OBSERVABLE].word < 0 ? (int)v[K_OBSERVABLE].integer
                                                                          : CNS_OBSERVABLE_NORM;
    laws->has_digits = given(l, K_LAWS_DIGITS);
    if (laws->has_digits) {
        require(l, K_DIGITS_FROM);
        require(l, K_DIGITS_TO);
        check_ends(l, K_DIGITS_FROM, K_DIGITS_TO, -1);
        laws->digits.from = v[K_DIGITS_FROM].integer;
        laws->digits.to = v[K_DIGITS_TO].integer;
        laws->digits.by = given(l, K_DIGITS_BY) ? v[K_DIGITS_BY].integer : 1;
    }
    laws->has_steps = given(l, K_LAWS_STEPS);
    if (laws->has_steps) {
        const bool taylor = given(l, K_STEPS_METHOD) && v[K_STEPS_METHOD].word == 1;
        const bool own_order = given(l, K_STEPS_ORDER) && v[K_STEPS_ORDER].word < 0;
        laws->steps.method = taylor ? CNS_METHOD_TAYLOR : CNS_METHOD_RK4;
        laws->steps.order = own_order ? v[K_STEPS_ORDER].integer : taylor ? 0 : 4;
        if (!taylor && laws->steps.order != 4)
            cns_faults_add(&l->faults, place_of(l, K_STEPS_ORDER), "'order' of 'method: rk4' is 4 (or auto)");
        laws->steps.digits = given(l, K_STEPS_DIGITS) ? v[K_STEPS_DIGITS].integer : 60;
        resolve_decades(l, &laws->steps.sizes, K_STEPS_FROM, K_STEPS_TO, K_STEPS_PER_DECADE);
    }
    laws->has_smoothing = given(l, K_LAWS_SMOOTHING);
    if (laws->has_smoothing)
        resolve_decades(l, &laws->smoothing, K_SMOOTHING_FROM, K_SMOOTHING_TO, K_SMOOTHING_PER_DECADE);
}

static void resolve_lyapunov(loader *l)
{
    cns_lyapunov_spec *y = &l->c->lyapunov;
    const key_value *v = l->values;
    static const cns_arithmetic words[] = {CNS_ARITH_FAST, CNS_ARITH_MPFR, CNS_ARITH_DOUBLE};
    l->c->has_lyapunov = given(l, K_LYAPUNOV);
    if (given(l, K_LYAPUNOV_TIME))
        cns_number_set(&y->time, &v[K_LYAPUNOV_TIME].number);
    else
        cns_number_parse(&y->time, STANDARD_LYAPUNOV_TIME, NULL);
    y->arithmetic = given(l, K_LYAPUNOV_ARITHMETIC) ? words[v[K_LYAPUNOV_ARITHMETIC].word] : CNS_ARITH_DOUBLE;
    y->digits = given(l, K_LYAPUNOV_DIGITS) ? v[K_LYAPUNOV_DIGITS].integer : 30;
    if (y->arithmetic == CNS_ARITH_DOUBLE) {
        y->digits = 0;
        if (given(l, K_LYAPUNOV_DIGITS))
            cns_faults_add(&l->faults, v[K_LYAPUNOV_DIGITS].node->key_mark,
                           "'digits' does not go with 'arithmetic: double', which has its own 53 bits");
    }
}

static void resolve_bisect(loader *l)
{
    cns_bisect_spec *b = &l->c->bisect;
    const key_value *v = l->values;
    l->c->has_bisect = given(l, K_BISECT);
    if (!l->c->has_bisect)
        return;
    require(l, K_BISECT_PARAMETER);
    require(l, K_BISECT_LOWER);
    require(l, K_BISECT_UPPER);
    check_ends(l, K_BISECT_LOWER, K_BISECT_UPPER, -1);
    b->parameter = (int)v[K_BISECT_PARAMETER].integer;
    for (int end = 0; end < 2; end++) {
        const key_id k = end == 0 ? K_BISECT_LOWER : K_BISECT_UPPER;
        if (!given(l, k))
            continue;
        cns_number_set(end == 0 ? &b->lower : &b->upper, &v[k].number);
        const char *minimum = given(l, K_BISECT_PARAMETER) && l->c->model
                                  ? l->c->model->parameters[b->parameter].minimum
                                  : NULL;
        if (minimum != NULL && !within(&v[k].number, minimum, NULL))
            cns_faults_add(&l->faults, v[k].node->mark, "%s must be > %s for model %s", title_of(k).text,
                           minimum, l->c->model->name);
    }
    b->by_manifold = !(given(l, K_BISECT_BY) && v[K_BISECT_BY].word == 1);
    b->decimals = given(l, K_BISECT_DECIMALS) ? v[K_BISECT_DECIMALS].integer : 20;
}

static bool comes_later(cns_mark a, cns_mark b)
{
    if (a.set != b.set)
        return a.set > b.set;
    return a.line != b.line ? a.line > b.line : a.column > b.column;
}

static void resolve_columns(loader *l)
{
    cns_case *c = l->c;
    if (c->n_columns > 0 || c->model == NULL)
        return;
    free(c->columns);
    c->n_columns = 1 + c->model->n_states;
    c->columns = cns_xalloc((size_t)c->n_columns, sizeof *c->columns);
    for (int i = 0; i < c->n_columns; i++)
        c->columns[i] = column_of(c->model, i);
}

static cns_number *new_numbers(int n)
{
    cns_number *numbers = cns_xalloc((size_t)n, sizeof *numbers);
    for (int i = 0; i < n; i++)
        cns_number_init(&numbers[i]);
    return numbers;
}

static void free_numbers(cns_number *numbers, int n)
{
    for (int i = 0; numbers != NULL && i < n; i++)
        cns_number_clear(&numbers[i]);
    free(numbers);
}

static void check_case(loader *l)
{
    cns_case *c = l->c;
    const cns_yaml_node *root = l->root;
    if (root->kind != CNS_YAML_MAPPING) {
        cns_faults_add(&l->faults, root->mark, "a case file is a mapping of keys to values, not %s",
                       kind_of_node(root));
        return;
    }
    const cns_yaml_node *model = cns_yaml_find(root, rows[K_MODEL].key);
    if (model != NULL && !model->refused)
        check_model(l, model);
    if (c->model != NULL) {
        c->parameters = new_numbers(c->model->n_parameters);
        c->initial = new_numbers(c->model->n_states);
    }
    check_section(l, NULL, root);
    check_parameters(l, cns_yaml_find(root, rows[K_PARAMETERS].key));
    check_initial(l, cns_yaml_find(root, rows[K_INITIAL].key));

    require(l, K_MODEL);
    resolve_time(l);
    resolve_abs(l);
    resolve_columns(l);
    const cns_yaml_node *goal = l->values[K_GOAL].node, *numerics = l->values[K_NUMERICS].node;
    if (goal != NULL && numerics != NULL) {
        const cns_yaml_node *second = comes_later(goal->key_mark, numerics->key_mark) ? goal : numerics;
        cns_faults_add(&l->faults, second->key_mark, "'goal' and 'numerics' exclude each other: keep one");
    }
    if (given(l, K_GOAL))
        resolve_goal(l);
    if (given(l, K_NUMERICS))
        resolve_numerics(l);
    resolve_laws(l);
    resolve_lyapunov(l);
    resolve_bisect(l);
}

/* Overrides. */

static bool plain_text(const char *s)
{
    for (size_t left = strlen(s); left > 0;) {
        int step = cns_utf8_length((const unsigned char *)s, left);
        if (step == 0 || (step == 1 && ((unsigned char)*s < 0x20 || *s == 0x7F)))
            return false;
        s += step;
        left -= (size_t)step;
    }
    return true;
}

static void apply_sets(loader *l, const char *const *sets, int n_sets)
{
    for (int i = 0; i < n_sets; i++) {
        const cns_mark mark = {0, 0, i};
        const char *equals = strchr(sets[i], '=');
        if (!plain_text(sets[i])) {
            cns_faults_add(&l->faults, mark, "not plain text in UTF-8");
            continue;
        }
        size_t path_length = equals != NULL ? (size_t)(equals - sets[i]) : 0;
        while (path_length > 0 && sets[i][path_length - 1] == ' ')
            path_length--;
        const char *value = equals != NULL ? equals + 1 : "";
        value += strspn(value, " ");
        if (equals == NULL || !cns_yaml_override(l->root, sets[i], path_length, value, i))
            cns_faults_add(&l->faults, mark, "write SECTION.KEY=VALUE, as in numerics.digits=80");
    }
}

static char *join_lines(const char *const *lines, int n)
{
    if (n == 0)
        return NULL;
    size_t size = 0;
    for (int i = 0; i < n; i++)
        size += strlen(lines[i]) + 1;
    char *all = cns_xgrow(NULL, size, 1), *to = all;
    for (int i = 0; i < n; i++) {
        char *line = cns_text_printable(lines[i]); /* never longer than the line itself */
        const size_t length = strlen(line);
        memcpy(to, line, length);
        free(line);
        to += length;
        *to++ = i + 1 < n ? '\n' : '\0';
    }
    return all;
}

/* Loading. */

/* The numbers that every case has. */
static void for_numbers(cns_case *c, void (*act)(cns_number *))
{
    cns_number *const all[] = {&c->end,
                               &c->every,
                               &c->eps,
                               &c->numerics.step,
                               &c->numerics.tolerance,
                               &c->laws.delta,
                               &c->laws.steps.sizes.from,
                               &c->laws.steps.sizes.to,
                               &c->laws.smoothing.from,
                               &c->laws.smoothing.to,
                               &c->lyapunov.time,
                               &c->bisect.lower,
                               &c->bisect.upper};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        act(all[i]);
}

cns_code cns_case_parse(const char *name, const char *text, size_t length, const char *const *sets,
                        int n_sets, cns_case **c, char **report)
{
    loader l = {0};
    *c = NULL;
    *report = NULL;
    l.root = cns_yaml_parse(text, length, &l.faults);
    l.c = cns_xalloc(1, sizeof *l.c);
    for_numbers(l.c, cns_number_init);
    for (int k = 0; k < N_KEYS; k++) {
        l.values[k].word = -1;
        cns_number_init(&l.values[k].number);
    }
    if (l.root != NULL) {
        l.c->name = cns_text_printable(name);
        l.c->text = cns_xcopy_n(text, length);
        l.c->length = length;
        cns_sha256_hex(l.c->sha256, text, length);
        l.c->overrides = join_lines(sets, n_sets);
        if (l.root->kind == CNS_YAML_MAPPING)
            apply_sets(&l, sets, n_sets);
        check_case(&l);
    }
    char *shown = cns_text_printable(name);
    *report = cns_faults_report(&l.faults, shown, sets);
    free(shown);
    cns_faults_clear(&l.faults);
    cns_yaml_free(l.root);
    for (int k = 0; k < N_KEYS; k++)
        cns_number_clear(&l.values[k].number);
    if (*report != NULL) {
        cns_case_free(l.c);
        return CNS_USAGE;
    }
    *c = l.c;
    return CNS_OK;
}

/* At most CNS_YAML_MAX_BYTES + 1 bytes, so that a huge or endless file is neither read nor held. */
static char *read_text(FILE *in, size_t *length)
{
    size_t size = 4096, used = 0;
    const size_t most = (size_t)CNS_YAML_MAX_BYTES + 1;
    char *text = cns_xgrow(NULL, size, 1);
    while (used < most) {
        if (used == size) {
            size = size < most / 2 ? 2 * size : most;
            text = cns_xgrow(text, size, 1);
        }
        size_t got = fread(text + used, 1, size - used, in);
        if (got == 0)
            break;
        used += got;
    }
    *length = used;
    return text;
}

cns_code cns_case_load(const char *path, const char *const *sets, int n_sets, cns_case **c, char **report)
{
    bool standard = strcmp(path, "-") == 0;
    *c = NULL;
    *report = NULL;
    errno = 0;
    FILE *in = standard ? stdin : fopen(path, "rb");
    char *text = NULL;
    size_t length = 0;
    bool failed = in == NULL;
    if (!failed) {
        text = read_text(in, &length);
        failed = ferror(in) != 0;
    }
    int cause = errno;
    if (in != NULL && !standard)
        fclose(in);
    cns_code code;
    if (failed) {
        char *shown = cns_text_printable(standard ? "<stdin>" : path);
        char message[512];
        snprintf(message, sizeof message, "cannot read %.300s: %s", shown, strerror(cause));
        free(shown);
        *report = cns_xcopy(message);
        code = CNS_IO;
    } else {
        code = cns_case_parse(standard ? "<stdin>" : path, text, length, sets, n_sets, c, report);
    }
    free(text);
    return code;
}

void cns_case_free(cns_case *c)
{
    if (c == NULL)
        return;
    if (c->model != NULL) {
        free_numbers(c->parameters, c->model->n_parameters);
        free_numbers(c->initial, c->model->n_states);
    }
    for_numbers(c, cns_number_clear);
    free(c->columns);
    free(c->overrides);
    free(c->text);
    free(c->name);
    free(c);
}

/* Printing. */

const char *cns_case_column_name(const cns_case *c, int column)
{
    cns_column k = c->columns[column];
    switch (k.kind) {
    case CNS_COLUMN_STATE:
        return c->model->states[k.index].name;
    case CNS_COLUMN_OUTPUT:
        return c->model->outputs[k.index].name;
    default:
        return "t";
    }
}

/* The word for an arithmetic; rows list them in this order. */
static const char *word_of(key_id k, cns_arithmetic a)
{
    return rows[k].words[a == CNS_ARITH_FAST ? 0 : a == CNS_ARITH_MPFR ? 1 : 2];
}

/* The value of a key in a resolved case, or false when the case has none. */
static bool print_value(const cns_case *c, key_id k, const char *lead, FILE *out)
{
    const cns_goal *g = &c->goal;
    const cns_numerics *n = &c->numerics;
    const char *text = NULL;
    const cns_laws_spec *laws = &c->laws;
    const bool arithmetic_free = c->lyapunov.arithmetic != CNS_ARITH_DOUBLE;
    char number[32];
    long integer = 0;
    bool decimals = g->places == CNS_PLACES_DECIMALS;
    switch (k) {
    case K_MODEL:
        text = c->model->name;
        break;
    case K_END:
        text = c->end.text;
        break;
    case K_EVERY:
        text = c->every.text;
        break;
    case K_SMOOTH:
        text = c->eps.text;
        break;
    case K_DECIMALS:
        integer = decimals ? g->count : 0;
        break;
    case K_SIGNIFICANT:
        integer = decimals ? 0 : g->count;
        break;
    case K_MAX_DIGITS:
        integer = g->max_digits;
        break;
    case K_MAX_TIME:
        if (g->max_time > 0) {
            snprintf(number, sizeof number, "%.17g", g->max_time);
            text = number;
        }
        break;
    case K_METHOD:
        text = rows[k].words[n->method == CNS_METHOD_RK4];
        break;
    case K_ARITHMETIC:
        text = word_of(k, n->arithmetic);
        break;
    case K_DIGITS:
        integer = n->digits;
        break;
    case K_ORDER:
        integer = n->order;
        text = integer == 0 ? "auto" : NULL;
        break;
    case K_STEP:
        text = n->fixed_step ? n->step.text : "adaptive";
        break;
    case K_TOLERANCE:
        /* a fixed-step method that has no use for a tolerance does not show one */
        if (n->method != CNS_METHOD_RK4)
            text = n->auto_tolerance ? "auto" : n->tolerance.text;
        break;
    case K_DELTA:
        text = laws->delta.text;
        break;
    case K_OBSERVABLE:
        text = laws->observable < 0 ? rows[k].words[0] : c->model->states[laws->observable].name;
        break;
    case K_DIGITS_FROM:
        integer = laws->digits.from;
        break;
    case K_DIGITS_TO:
        integer = laws->digits.to;
        break;
    case K_DIGITS_BY:
        integer = laws->digits.by;
        break;
    case K_STEPS_METHOD:
        text = rows[k].words[laws->steps.method == CNS_METHOD_TAYLOR];
        break;
    case K_STEPS_ORDER:
        integer = laws->steps.order;
        text = integer == 0 ? "auto" : NULL;
        break;
    case K_STEPS_DIGITS:
        integer = laws->steps.digits;
        break;
    case K_STEPS_FROM:
        text = laws->steps.sizes.from.text;
        break;
    case K_STEPS_TO:
        text = laws->steps.sizes.to.text;
        break;
    case K_STEPS_PER_DECADE:
        integer = laws->steps.sizes.per_decade;
        break;
    case K_SMOOTHING_FROM:
        text = laws->smoothing.from.text;
        break;
    case K_SMOOTHING_TO:
        text = laws->smoothing.to.text;
        break;
    case K_SMOOTHING_PER_DECADE:
        integer = laws->smoothing.per_decade;
        break;
    case K_LYAPUNOV_TIME:
        text = c->lyapunov.time.text;
        break;
    case K_LYAPUNOV_ARITHMETIC:
        text = word_of(k, c->lyapunov.arithmetic);
        break;
    case K_LYAPUNOV_DIGITS:
        integer = arithmetic_free ? c->lyapunov.digits : 0;
        break;
    case K_BISECT_PARAMETER:
        text = c->model->parameters[c->bisect.parameter].name;
        break;
    case K_BISECT_LOWER:
        text = c->bisect.lower.text;
        break;
    case K_BISECT_UPPER:
        text = c->bisect.upper.text;
        break;
    case K_BISECT_BY:
        text = rows[k].words[!c->bisect.by_manifold];
        break;
    case K_BISECT_DECIMALS:
        integer = c->bisect.decimals;
        break;
    default:
        break;
    }
    if (integer > 0) {
        snprintf(number, sizeof number, "%ld", integer);
        text = number;
    }
    if (text == NULL)
        return false;
    fprintf(out, "%s%s: %s\n", lead, rows[k].key, text);
    return true;
}

static bool section_present(const cns_case *c, key_id k)
{
    switch (k) {
    case K_GOAL:
        return c->has_goal;
    case K_NUMERICS:
        return c->has_numerics;
    case K_ABS:
        return c->smooth;
    case K_LAWS:
        return c->has_laws;
    case K_LAWS_DIGITS:
        return c->laws.has_digits;
    case K_LAWS_STEPS:
        return c->laws.has_steps;
    case K_LAWS_SMOOTHING:
        return c->laws.has_smoothing;
    case K_LYAPUNOV:
        return c->has_lyapunov;
    case K_BISECT:
        return c->has_bisect;
    default:
        return true;
    }
}

static const char *indent(key_id k)
{
    const char *section = rows[k].section;
    return section == NULL ? "" : strchr(section, '.') == NULL ? "    " : "        ";
}

void cns_case_print(const cns_case *c, FILE *out)
{
    bool shown = true; /* the section at work */
    for (int i = 0; i < N_KEYS; i++) {
        key_id k = (key_id)i;
        switch (rows[k].kind) {
        case KEY_SECTION:
            shown = section_present(c, k);
            if (shown)
                fprintf(out, "%s%s:\n", indent(k), rows[k].key);
            else if (k == K_ABS)
                fprintf(out, "%s: exact\n", rows[k].key);
            break;
        case KEY_PARAMETERS:
            fprintf(out, "%s:%s\n", rows[k].key, c->model->n_parameters == 0 ? " {}" : "");
            for (int p = 0; p < c->model->n_parameters; p++)
                fprintf(out, "    %s: %s\n", c->model->parameters[p].name, c->parameters[p].text);
            break;
        case KEY_INITIAL:
            fprintf(out, "%s:\n", rows[k].key);
            for (int s = 0; s < c->model->n_states; s++)
                fprintf(out, "    %s: %s\n", c->model->states[s].name, c->initial[s].text);
            break;
        case KEY_COLUMNS:
            fprintf(out, "    %s: [", rows[k].key);
            for (int j = 0; j < c->n_columns; j++)
                fprintf(out, "%s%s", j > 0 ? ", " : "", cns_case_column_name(c, j));
            fputs("]\n", out);
            break;
        default:
            if (rows[k].section == NULL || shown)
                print_value(c, k, indent(k), out);
            break;
        }
    }
}

void cns_case_print_keys(FILE *out)
{
    fputs("A case file is YAML: keys and values, at most three levels deep. Values are exact: decimals, "
          "fractions and\n"
          "pi, as in 2.2, 1e-30, 8/3, 2*pi/3. `--set SECTION.KEY=VALUE` overrides a value.\n\n",
          out);
    for (int k = 0; k < N_KEYS; k++) {
        const key_row *row = &rows[k];
        const char *lead = indent((key_id)k);
        bool named = row->kind != KEY_SECTION && row->kind != KEY_MODEL && row->kind != KEY_PARAMETERS &&
                     row->kind != KEY_INITIAL && row->kind != KEY_COLUMNS;
        fprintf(out, "%s%-*s%s", lead, 20 - (int)strlen(lead), row->key, row->meaning);
        if (named || row->standard != NULL)
            fprintf(out, "\n%22s%s%s%s%s", named ? "" : "", "  ", named ? range_of(row).text : "",
                    named && row->standard != NULL ? "; " : "", row->standard != NULL ? "default " : "");
        if (row->standard != NULL)
            fputs(row->standard, out);
        fputc('\n', out);
    }
    fputs(
        "\n`run` needs `goal` or `numerics`, never both. In a list of columns, `t` is the time; `decimals`\n"
        "and `growth` are always printed, last.\n",
        out);
}
