/* Each key of a case file by itself: its value against its row in the table. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "case_internal.h"
#include "core/memory.h"
#include "core/text.h"

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

/* Index of a name in a set, -1 when it is not there. */
static int find_name(const name_set *s, const char *name)
{
    for (int i = 0; i < s->count; i++)
        if (strcmp(s->names[i], name) == 0)
            return i;
    return -1;
}

static void add_states(name_set *s, const cns_model *m)
{
    for (int i = 0; i < m->n_states; i++)
        add_name(s, m->states[i].name);
}

static void add_parameters(name_set *s, const cns_model *m)
{
    for (int i = 0; i < m->n_parameters; i++)
        add_name(s, m->parameters[i].name);
}

static void add_words(name_set *s, const cns_key *k)
{
    for (int i = 0; i < CNS_KEY_WORDS && k->words[i].text != NULL; i++)
        add_name(s, k->words[i].text);
}

/* Reports an unknown name with the likely one, which is returned, or else with all. `what` says "key",
 * `where` " in 'time'" or " of model apw" or nothing. */
static const char *unknown_name(cns_case_reader *r, cns_mark mark, const char *what, const char *name,
                                const char *where, const name_set *known)
{
    const char *nearest = cns_text_nearest(name, known->count, name_at, known);
    char list[512];
    cns_text_list(list, sizeof list, known->names, known->count);
    if (nearest != NULL)
        cns_faults_add(&r->faults, mark, "unknown %s '%s'%s; did you mean '%s'?", what, cns_quote(name).text,
                       where, nearest);
    else if (known->count > 0)
        cns_faults_add(&r->faults, mark, "unknown %s '%s'%s; use %s", what, cns_quote(name).text, where,
                       list);
    else
        cns_faults_add(&r->faults, mark, "unknown %s '%s'%s; there are none", what, cns_quote(name).text,
                       where);
    return nearest;
}

static void unknown_of_model(cns_case_reader *r, cns_mark mark, const char *what, const char *name,
                             const name_set *known)
{
    char where[64];
    snprintf(where, sizeof where, " of model %s", r->c->model->name);
    unknown_name(r, mark, what, name, where, known);
}

/* Nodes. */

/* How to write the mapping that must have been meant by a single value or a list. */
static cns_key_text mapping_meant(const cns_yaml_node *node)
{
    cns_key_text t = {"; keys and values stand in braces, as in {key: value}, or on lines of their own"};
    const char *text = node->kind == CNS_YAML_SCALAR ? node->text : "";
    const size_t name = strcspn(text, ":= ");
    const char *value = text + name + strspn(text + name, " ");
    if (name > 0 && *value == '=')
        snprintf(t.text, sizeof t.text, "; write 'key: value', with a colon and a space, not '%s'",
                 cns_quote(text).text);
    else if (name > 0 && *value == ':' && value[1] != ' ' && value[1] != '\0')
        snprintf(t.text, sizeof t.text, "; a space is missing after the colon in '%s'", cns_quote(text).text);
    return t;
}

/* Is the node of this kind, and not empty? Else a fault that says what is wanted. */
static bool is_a(cns_case_reader *r, const cns_yaml_node *node, cns_yaml_kind kind, const char *title,
                 const char *wanted)
{
    if (node->kind == CNS_YAML_SCALAR && node->text[0] == '\0')
        cns_faults_add(&r->faults, node->mark, "%s has no value; it must be %s", title, wanted);
    else if (node->kind != kind)
        cns_faults_add(&r->faults, node->mark, "%s must be %s, not %s%s", title, wanted,
                       cns_yaml_kind_name(node->kind),
                       kind == CNS_YAML_MAPPING ? mapping_meant(node).text : "");
    else
        return true;
    return false;
}

static bool is_mapping(cns_case_reader *r, const cns_yaml_node *node, const char *title)
{
    return is_a(r, node, CNS_YAML_MAPPING, title, "a mapping of keys to values");
}

/* Single values: each reads the node's text into the field, or reports why not. */

static bool refuse(cns_case_reader *r, const cns_key *k, const cns_yaml_node *node, const char *meant)
{
    const bool hint = meant == NULL && k->hint != NULL;
    cns_faults_add(&r->faults, node->mark, "%s must be %s, not '%s'%s%s%s", cns_key_title(k).text,
                   cns_key_range(k).text, cns_quote(node->text).text,
                   meant != NULL ? "; did you mean '"
                   : hint        ? "; "
                                 : "",
                   meant != NULL ? meant
                   : hint        ? k->hint
                                 : "",
                   meant != NULL ? "'?" : "");
    return false;
}

static bool read_integer(cns_case_reader *r, const cns_key *k, const cns_yaml_node *node)
{
    const char *digits = node->text + (node->text[0] == '-');
    const size_t n = strspn(digits, "0123456789");
    if (n == 0 || digits[n] != '\0' || (n > 1 && digits[0] == '0'))
        return refuse(r, k, node, NULL);
    const long value = strtol(node->text, NULL, 10); /* too long for it: an end, outside every range here */
    if (value < k->least || value > k->most)
        return refuse(r, k, node, NULL);
    cns_key_put(k, r->c, value);
    return true;
}

bool cns_case_within(const cns_number *x, const char *above, const char *below)
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

static bool read_number(cns_case_reader *r, const cns_key *k, const cns_yaml_node *node)
{
    cns_number x;
    cns_error err;
    bool good = false;
    cns_number_init(&x);
    if (cns_number_parse(&x, node->text, &err) != CNS_OK)
        cns_faults_add(&r->faults, node->mark, "%s must be %s; %s", cns_key_title(k).text,
                       cns_key_range(k).text, err.text);
    else if (k->rational && x.pi_power != 0)
        cns_faults_add(&r->faults, node->mark, "%s must be a decimal or a fraction, not '%s'",
                       cns_key_title(k).text, cns_quote(node->text).text);
    else
        good = cns_case_within(&x, k->above, k->below) || refuse(r, k, node, NULL);
    if (good && k->type == FIELD_DOUBLE)
        *(double *)cns_key_field(k, r->c) = cns_number_get_d(&x);
    else if (good)
        cns_number_set(cns_key_field(k, r->c), &x);
    cns_number_clear(&x);
    return good;
}

static bool read_word(cns_case_reader *r, const cns_key *k, const cns_yaml_node *node)
{
    name_set words = {0};
    add_words(&words, k);
    const char *nearest = cns_text_nearest(node->text, words.count, name_at, &words);
    const bool other = nearest != NULL && k->hint != NULL && cns_text_distance(node->text, nearest) > 0 &&
                       strpbrk(node->text, "0123456789") != NULL; /* as rk45, which is no slip for rk4 */
    return refuse(r, k, node, other ? NULL : nearest);
}

/* The name of a state or parameter; what names there are is not known without a model. */
static bool read_name(cns_case_reader *r, const cns_key *k, const cns_yaml_node *node)
{
    const cns_model *m = r->c->model;
    name_set known = {0};
    if (m == NULL)
        return false;
    if (k->kind == KEY_STATE)
        add_states(&known, m);
    else
        add_parameters(&known, m);
    const int i = find_name(&known, node->text);
    if (i >= 0) {
        cns_key_put(k, r->c, i);
        return true;
    }
    add_words(&known, k);
    unknown_of_model(r, node->mark, k->kind == KEY_STATE ? "state" : "parameter", node->text, &known);
    return false;
}

static bool read_value(cns_case_reader *r, const cns_key *k, const cns_yaml_node *node)
{
    if (!is_a(r, node, CNS_YAML_SCALAR, cns_key_title(k).text, cns_key_range(k).text))
        return false;
    const cns_key_word *word = cns_key_word_named(k, node->text);
    if (word != NULL) {
        cns_key_put(k, r->c, word->value);
        return true;
    }
    switch (k->kind) {
    case KEY_INTEGER:
        return read_integer(r, k, node);
    case KEY_NUMBER:
        return read_number(r, k, node);
    case KEY_STATE:
    case KEY_PARAMETER:
        return read_name(r, k, node);
    default:
        return read_word(r, k, node);
    }
}

/* What is not a single value. */

static bool read_model(cns_case_reader *r, const cns_yaml_node *node)
{
    if (!is_a(r, node, CNS_YAML_SCALAR, "'model'", "the name of a model"))
        return false;
    r->c->model = cns_model_find(node->text);
    if (r->c->model != NULL)
        return true;
    name_set known = {0};
    for (int i = 0; i < cns_model_count(); i++)
        add_name(&known, cns_model_at(i)->name);
    unknown_name(r, node->mark, "model", node->text, "", &known);
    return false;
}

/* A name that is one of the model's, in a section where it is not known: the fault says where it belongs.
 * False, and no fault: the model has no such name. */
static bool name_of_model(cns_case_reader *r, const cns_yaml_node *node, const char *where)
{
    const cns_model *m = r->c->model;
    name_set states = {0}, parameters = {0};
    if (m == NULL)
        return false;
    add_states(&states, m);
    add_parameters(&parameters, m);
    const bool state = find_name(&states, node->key) >= 0;
    if (!state && find_name(&parameters, node->key) < 0)
        return false;
    cns_faults_add(&r->faults, node->key_mark, "unknown key '%s'%s; a %s of model %s belongs in '%s'",
                   node->key, where, state ? "state" : "parameter", m->name,
                   state ? "initial" : "parameters");
    return true;
}

/* Of a state at the start and of a parameter: preliminary runs hold them, and small multiples, in doubles. */
#define MOST "1e300"

/* `parameters` and `initial`: numbers by the names of the model. Without a model the numbers are still
 * checked, into nothing. */
static bool read_numbers(cns_case_reader *r, const cns_key *k, const cns_yaml_node *section)
{
    const cns_model *m = r->c->model;
    const bool parameters = k->kind == KEY_PARAMETERS;
    cns_number *values = parameters ? r->c->parameters : r->c->initial, spare;
    name_set known = {0};
    if (!is_mapping(r, section, cns_key_title(k).text))
        return false;
    if (m != NULL && parameters)
        add_parameters(&known, m);
    else if (m != NULL)
        add_states(&known, m);
    cns_number_init(&spare);
    for (const cns_yaml_node *node = section->first; node != NULL; node = node->next) {
        if (node->refused)
            continue;
        const int i = find_name(&known, node->key);
        if (m != NULL && i < 0 && !name_of_model(r, node, parameters ? " in 'parameters'" : " in 'initial'"))
            unknown_of_model(r, node->key_mark, parameters ? "parameter" : "state", node->key, &known);
        char title[CNS_QUOTE + 32];
        snprintf(title, sizeof title, "'%s' in '%s'", cns_quote(node->key).text, k->path);
        cns_number *value = i >= 0 ? &values[i] : &spare;
        const char *minimum = i >= 0 && parameters ? m->parameters[i].minimum : NULL;
        cns_error err;
        if (!is_a(r, node, CNS_YAML_SCALAR, title, "a number"))
            continue;
        if (cns_number_parse(value, node->text, &err) != CNS_OK)
            cns_faults_add(&r->faults, node->mark, "%s: %s", title, err.text);
        else if (!cns_case_within(value, minimum, NULL))
            cns_faults_add(&r->faults, node->mark, "%s must be > %s for model %s, not '%s'", title, minimum,
                           m->name, cns_quote(node->text).text);
        else if (!cns_case_within(value, "-" MOST, MOST))
            cns_faults_add(&r->faults, node->mark,
                           "%s must be between -" MOST " and " MOST
                           ", where runs in double precision can plan for it, "
                           "not '%s'",
                           title, cns_quote(node->text).text);
    }
    cns_number_clear(&spare);
    return true;
}

/* Columns are numbered: t, the states, the outputs. */
static cns_column column_of(const cns_model *m, int i)
{
    if (i == 0)
        return (cns_column){CNS_COLUMN_TIME, 0};
    if (i <= m->n_states)
        return (cns_column){CNS_COLUMN_STATE, i - 1};
    return (cns_column){CNS_COLUMN_OUTPUT, i - 1 - m->n_states};
}

static bool read_columns(cns_case_reader *r, const cns_key *k, const cns_yaml_node *list)
{
    cns_case *c = r->c;
    const cns_model *m = c->model;
    name_set known = {1, {"t"}};
    bool seen[MAX_NAMES] = {false};
    if (list->kind != CNS_YAML_SEQUENCE || list->first == NULL) {
        cns_faults_add(&r->faults, list->mark, "%s must be a list of names, such as [t, x]",
                       cns_key_title(k).text);
        return false;
    }
    if (m == NULL)
        return false;
    add_states(&known, m);
    for (int i = 0; i < m->n_outputs; i++)
        add_name(&known, m->outputs[i].name);
    c->n_columns = 0;
    for (const cns_yaml_node *node = list->first; node != NULL; node = node->next) {
        if (node->refused || !is_a(r, node, CNS_YAML_SCALAR, "a column", "a name"))
            continue;
        const int i = find_name(&known, node->text);
        if (i < 0 && (strcmp(node->text, "decimals") == 0 || strcmp(node->text, "growth") == 0)) {
            cns_faults_add(&r->faults, node->mark, "column '%s' is always printed, last; leave it out",
                           node->text);
        } else if (i < 0) {
            unknown_of_model(r, node->mark, "column", node->text, &known);
        } else if (seen[i]) {
            cns_faults_add(&r->faults, node->mark, "doubled column '%s'", node->text);
        } else {
            seen[i] = true;
            c->columns[c->n_columns++] = column_of(m, i);
        }
    }
    return true;
}

static bool refuse_time(cns_case_reader *r, const cns_yaml_node *node, const char *why)
{
    cns_faults_add(&r->faults, node->mark, "a time must be a decimal or a fraction; %s", why);
    return false;
}

static bool read_times(cns_case_reader *r, const cns_key *k, const cns_yaml_node *list)
{
    cns_case *c = r->c;
    int n = 0;
    bool good = list->kind == CNS_YAML_SEQUENCE && list->first != NULL;
    if (!good)
        cns_faults_add(&r->faults, list->mark, "%s must be a list of times, such as [0.5, 2/3, 10]",
                       cns_key_title(k).text);
    for (const cns_yaml_node *node = good ? list->first : NULL; node != NULL; node = node->next)
        n++;
    if (good && n > CNS_CASE_MAX_ROWS) {
        cns_faults_add(&r->faults, list->mark, "more than %d times", CNS_CASE_MAX_ROWS);
        return false;
    }
    c->at = good ? cns_xalloc((size_t)n, sizeof *c->at) : NULL;
    for (const cns_yaml_node *node = good ? list->first : NULL; node != NULL; node = node->next) {
        cns_error err;
        cns_number *x = &c->at[c->n_at++];
        cns_number_init(x);
        if (node->refused || !is_a(r, node, CNS_YAML_SCALAR, "a time", "a number"))
            good = false;
        else if (cns_number_parse(x, node->text, &err) != CNS_OK)
            good = refuse_time(r, node, err.text);
        else if (x->pi_power != 0)
            good = refuse_time(r, node, "a multiple of pi is none");
    }
    return good;
}

/* Sections. */

static void check_keys(cns_case_reader *r, const cns_key *section, const cns_yaml_node *mapping);

/* Would this text do for the key, as far as its kind says? */
static bool could_be(const cns_key *k, const char *text)
{
    cns_number x;
    if (cns_key_word_named(k, text) != NULL)
        return k->kind != KEY_SECTION;
    if (k->kind == KEY_INTEGER)
        return text[0] != '\0' && text[strspn(text, "0123456789")] == '\0';
    if (k->kind != KEY_NUMBER)
        return false;
    cns_number_init(&x);
    const bool good = cns_number_parse(&x, text, NULL) == CNS_OK && cns_case_within(&x, k->above, k->below);
    cns_number_clear(&x);
    return good;
}

static bool list_could_be(const cns_key *k, const cns_yaml_node *list)
{
    return k->kind == KEY_COLUMNS ||
           (k->kind == KEY_TIMES && list->first != NULL && list->first->kind == CNS_YAML_SCALAR);
}

/* A value right behind the name of a section, as in `time: 300`, most often belongs to its first key that can
 * take it: a fault that says so. False, and no fault: there is no such key. */
static bool value_for_section(cns_case_reader *r, const cns_key *section, const cns_yaml_node *node)
{
    if (node->kind == CNS_YAML_MAPPING)
        return false;
    for (const cns_key *k = cns_keys; k < cns_keys + CNS_KEYS; k++) {
        const bool list = node->kind == CNS_YAML_SEQUENCE;
        if (cns_key_section(k) != section || (list ? !list_could_be(k, node) : !could_be(k, node->text)))
            continue;
        cns_faults_add(&r->faults, node->mark, "%s must be a mapping of keys to values: write '%s: {%s: %s}'",
                       cns_key_title(section).text, cns_key_name(section), cns_key_name(k),
                       list ? "[...]" : cns_quote(node->text).text);
        return true;
    }
    return false;
}

static bool read_section(cns_case_reader *r, const cns_key *k, const cns_yaml_node *node)
{
    if (node->kind == CNS_YAML_SCALAR && k->words[0].text != NULL &&
        cns_key_word_named(k, node->text) != NULL)
        return read_value(r, k, node);
    if (value_for_section(r, k, node))
        return false;
    if (node->kind == CNS_YAML_SCALAR && k->words[0].text != NULL)
        return read_value(r, k, node);
    if (!is_mapping(r, node, cns_key_title(k).text))
        return false;
    cns_key_put(k, r->c, true);
    check_keys(r, k, node);
    return true;
}

static bool read_key(cns_case_reader *r, const cns_key *k, const cns_yaml_node *node)
{
    switch (k->kind) {
    case KEY_SECTION:
        return read_section(r, k, node);
    case KEY_MODEL:
        return r->c->model != NULL; /* it was read before all others, which need it */
    case KEY_PARAMETERS:
    case KEY_INITIAL:
        return read_numbers(r, k, node);
    case KEY_COLUMNS:
        return read_columns(r, k, node);
    case KEY_TIMES:
        return read_times(r, k, node);
    default:
        return read_value(r, k, node);
    }
}

/* The row of the key of this name in a section, NULL being the top. */
static const cns_key *find_in(const cns_key *section, const char *name)
{
    for (const cns_key *k = cns_keys; k < cns_keys + CNS_KEYS; k++)
        if (strcmp(cns_key_name(k), name) == 0 && cns_key_section(k) == section)
            return k;
    return NULL;
}

/* Reports a key that has no row in this section. Returns the row of the key that was likely meant, or NULL.
 */
static const cns_key *unknown_key(cns_case_reader *r, const cns_key *section, const cns_yaml_node *node)
{
    char where[64] = "";
    name_set known = {0};
    if (section != NULL)
        snprintf(where, sizeof where, " in '%s'", section->path);
    for (const cns_key *k = cns_keys; k < cns_keys + CNS_KEYS; k++)
        if (cns_key_section(k) == section)
            add_name(&known, cns_key_name(k));
    const char *slip = cns_text_nearest(node->key, known.count, name_at, &known);
    if (slip != NULL && cns_text_distance(node->key, slip) > 1)
        slip = NULL; /* not so near that a key of this name elsewhere is not meant */
    for (const cns_key *k = cns_keys; k < cns_keys + CNS_KEYS; k++) {
        const cns_key *home = cns_key_section(k);
        if (slip == NULL && strcmp(cns_key_name(k), node->key) == 0) {
            if (home != NULL)
                cns_faults_add(&r->faults, node->key_mark, "unknown key '%s'%s; it belongs in '%s'",
                               node->key, where, home->path);
            else
                cns_faults_add(&r->faults, node->key_mark,
                               "unknown key '%s'%s; it belongs at the top, not indented", node->key, where);
            return NULL;
        }
    }
    if (slip == NULL && name_of_model(r, node, where))
        return NULL;
    const char *meant = unknown_name(r, node->key_mark, "key", node->key, where, &known);
    return meant != NULL ? find_in(section, meant) : NULL;
}

static void check_keys(cns_case_reader *r, const cns_key *section, const cns_yaml_node *mapping)
{
    for (const cns_yaml_node *node = mapping->first; node != NULL; node = node->next) {
        const cns_key *k = find_in(section, node->key);
        const bool readable = k != NULL && !node->refused;
        if (k == NULL && !node->refused)
            k = unknown_key(r, section, node);
        if (k == NULL)
            continue;
        cns_key_seen *seen = &r->seen[k - cns_keys];
        if (readable)
            *seen = (cns_key_seen){node, read_key(r, k, node)};
        else if (seen->node == NULL)
            seen->node = node; /* misspelt, or refused: at least it is not missing as well */
    }
}

/* What the model has a default for: parameters, initial states (0), and columns (t and the states). */
static void set_defaults_of_model(cns_case *c)
{
    const cns_model *m = c->model;
    c->parameters = cns_xalloc((size_t)m->n_parameters, sizeof *c->parameters);
    c->initial = cns_xalloc((size_t)m->n_states, sizeof *c->initial);
    c->columns = cns_xalloc((size_t)(1 + m->n_states + m->n_outputs), sizeof *c->columns);
    for (int i = 0; i < m->n_parameters; i++) {
        cns_number_init(&c->parameters[i]);
        if (m->parameters[i].standard != NULL)
            cns_number_parse(&c->parameters[i], m->parameters[i].standard, NULL);
    }
    for (int i = 0; i < m->n_states; i++)
        cns_number_init(&c->initial[i]);
    for (c->n_columns = 0; c->n_columns < 1 + m->n_states; c->n_columns++)
        c->columns[c->n_columns] = column_of(m, c->n_columns);
}

void cns_case_check(cns_case_reader *r)
{
    const cns_yaml_node *model = cns_yaml_find(r->root, "model");
    if (model != NULL && !model->refused && read_model(r, model))
        set_defaults_of_model(r->c);
    for (const cns_key *k = cns_keys; k < cns_keys + CNS_KEYS; k++)
        if (k->standard != NULL)
            read_value(r, k, &(cns_yaml_node){.kind = CNS_YAML_SCALAR, .text = (char *)k->standard});
    check_keys(r, NULL, r->root);
}
