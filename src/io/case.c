#include "cns/case.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "case_internal.h"
#include "core/memory.h"
#include "core/sha256.h"
#include "core/text.h"

/* Overrides. */

/* UTF-8 without control characters. */
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

/* Does an override speak of this section, or of a key in it? */
static bool speaks_of(const char *set, const char *section)
{
    const size_t n = strlen(section);
    return strncmp(set, section, n) == 0 && strchr(".= ", set[n]) != NULL && set[n] != '\0';
}

/* `goal` and `numerics` exclude each other: overrides of the one take the place of the other in the file. The
 * name of that other, or NULL when nothing is replaced; overrides of both are left to the rules, which refuse
 * them. */
static const char *replaced_section(const cns_yaml_node *root, const char *const *sets, int n_sets)
{
    static const char *const sections[] = {"goal", "numerics"};
    bool spoken[2] = {false, false};
    for (int i = 0; i < n_sets; i++)
        for (int k = 0; k < 2; k++)
            spoken[k] = spoken[k] || speaks_of(sets[i], sections[k]);
    for (int k = 0; k < 2; k++)
        if (spoken[1 - k] && !spoken[k] && cns_yaml_find(root, sections[k]) != NULL)
            return sections[k];
    return NULL;
}

/* Puts the values of the overrides into the tree, as if they stood in the file. */
static void apply_sets(cns_yaml_node *root, cns_faults *faults, const char *const *sets, int n_sets)
{
    for (int i = 0; i < n_sets; i++) {
        const cns_mark mark = {0, 0, i};
        const char *equals = strchr(sets[i], '=');
        if (!plain_text(sets[i])) {
            cns_faults_add(faults, mark, "not one line of text in UTF-8 without tabs");
            continue;
        }
        size_t path_length = equals != NULL ? (size_t)(equals - sets[i]) : 0;
        while (path_length > 0 && sets[i][path_length - 1] == ' ')
            path_length--;
        if (equals == NULL || !cns_yaml_override(root, sets[i], path_length, equals + 1, i, faults))
            cns_faults_add(faults, mark, "write SECTION.KEY=VALUE, as in numerics.digits=80");
    }
}

/* One per line, each fit for one line; NULL if there are none. */
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

/* To every number of the case outside the model's lists: each belongs to one key. */
static void for_numbers(cns_case *c, void (*act)(cns_number *))
{
    for (const cns_key *k = cns_keys; k < cns_keys + CNS_KEYS; k++)
        if (k->type == FIELD_NUMBER)
            act(cns_key_field(k, c));
}

/* What a file is most likely that is a single value to YAML. */
static const char *likely_file(const char *text)
{
    if (strchr(text, '=') != NULL)
        return "; write 'key: value', with a colon and a space, not 'key = value'";
    if (strchr(text, ':') != NULL)
        return "; a space is missing after the colon, as in 'model: apw'";
    return strchr(text, ',') != NULL ? "; is this a table? `cns help case` lists what a case file says" : "";
}

cns_code cns_case_parse(const char *name, const char *text, size_t length, const char *const *sets,
                        int n_sets, cns_case **result, char **report)
{
    cns_case_reader r = {0};
    cns_yaml_node *root = cns_yaml_parse(text, length, &r.faults);
    cns_case *c = cns_xalloc(1, sizeof *c);
    for_numbers(c, cns_number_init);
    cns_number_init(&c->span);
    c->name = cns_text_printable(name);
    c->text = cns_xcopy_n(text, length);
    c->length = length;
    cns_sha256_hex(c->sha256, text, length);
    c->overrides = join_lines(sets, n_sets);
    if (root != NULL && root->kind == CNS_YAML_MAPPING) {
        c->replaced = replaced_section(root, sets, n_sets);
        if (c->replaced != NULL)
            cns_yaml_remove(root, c->replaced);
        apply_sets(root, &r.faults, sets, n_sets);
        r.c = c;
        r.root = root;
        r.seen = cns_xalloc((size_t)CNS_KEYS, sizeof *r.seen);
        cns_case_check(&r);
        cns_case_apply_rules(&r);
        free(r.seen);
    } else if (root != NULL) {
        cns_faults_add(&r.faults, root->mark, "a case file is a mapping of keys to values, not %s%s",
                       cns_yaml_kind_name(root->kind),
                       root->kind == CNS_YAML_SCALAR ? likely_file(root->text) : "");
    }
    const bool out_of_memory = r.faults.out_of_memory;
    *report = out_of_memory ? cns_xcopy("out of memory") : cns_faults_report(&r.faults, c->name, sets);
    cns_faults_clear(&r.faults);
    cns_yaml_free(root);
    if (*report != NULL) {
        cns_case_free(c);
        c = NULL;
    }
    *result = c;
    return c != NULL ? CNS_OK : out_of_memory ? CNS_MEMORY : CNS_USAGE;
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
        code = cause == ENOMEM ? CNS_MEMORY : CNS_IO;
    } else {
        code = cns_case_parse(standard ? "<stdin>" : path, text, length, sets, n_sets, c, report);
    }
    free(text);
    return code;
}

static void free_numbers(cns_number *numbers, int n)
{
    for (int i = 0; i < n; i++)
        cns_number_clear(&numbers[i]);
    free(numbers);
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
    cns_number_clear(&c->span);
    free_numbers(c->at, c->n_at);
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

static void print_numbers(const cns_case *c, const cns_key *k, FILE *out)
{
    const cns_model *m = c->model;
    const bool parameters = k->kind == KEY_PARAMETERS;
    const int n = parameters ? m->n_parameters : m->n_states;
    fprintf(out, "%s:%s\n", k->path, n == 0 ? " {}" : "");
    for (int i = 0; i < n; i++)
        fprintf(out, "    %s: %s\n", parameters ? m->parameters[i].name : m->states[i].name,
                parameters ? c->parameters[i].text : c->initial[i].text);
}

static void print_columns(const cns_case *c, const cns_key *k, FILE *out)
{
    fprintf(out, "%s%s: [", cns_key_indent(k), cns_key_name(k));
    for (int i = 0; i < c->n_columns; i++)
        fprintf(out, "%s%s", i > 0 ? ", " : "", cns_case_column_name(c, i));
    fputs("]\n", out);
}

static void print_times(const cns_case *c, const cns_key *k, FILE *out)
{
    fprintf(out, "%s%s: [", cns_key_indent(k), cns_key_name(k));
    for (int i = 0; i < c->n_at; i++)
        fprintf(out, "%s%s", i > 0 ? ", " : "", c->at[i].text);
    fputs("]\n", out);
}

/* The value of a key in a resolved case, in `room` if it has to be made; NULL: the case has none. */
static const char *value_text(const cns_case *c, const cns_key *k, char *room, size_t size)
{
    const long value = cns_key_get(k, c);
    const cns_key_word *word = cns_key_word_for(k, value);
    const void *field = cns_key_field(k, c);
    if (k->printed != NULL && !k->printed(c))
        return NULL;
    if (word != NULL)
        return word->text;
    switch (k->kind) {
    case KEY_MODEL:
        return c->model->name;
    case KEY_STATE:
        return c->model->states[value].name;
    case KEY_PARAMETER:
        return c->model->parameters[value].name;
    case KEY_NUMBER:
        if (k->type == FIELD_NUMBER)
            return ((const cns_number *)field)->text;
        for (int digits = 15; digits <= 17; digits++) { /* as few as tell it from all others */
            snprintf(room, size, "%.*g", digits, *(const double *)field);
            if (strtod(room, NULL) == *(const double *)field)
                break;
        }
        return *(const double *)field > 0 ? room : NULL;
    case KEY_INTEGER:
        snprintf(room, size, "%ld", value);
        return value > 0 ? room : NULL;
    default:
        return NULL;
    }
}

void cns_case_print(const cns_case *c, FILE *out)
{
    for (const cns_key *k = cns_keys; k < cns_keys + CNS_KEYS; k++) {
        const cns_key *section = cns_key_section(k);
        char room[32];
        const char *value = value_text(c, k, room, sizeof room);
        if (section != NULL && !cns_key_get(section, c))
            continue;
        if (value != NULL)
            fprintf(out, "%s%s: %s\n", cns_key_indent(k), cns_key_name(k), value);
        else if (k->kind == KEY_SECTION && cns_key_get(k, c))
            fprintf(out, "%s%s:\n", cns_key_indent(k), cns_key_name(k));
        else if (k->kind == KEY_PARAMETERS || k->kind == KEY_INITIAL)
            print_numbers(c, k, out);
        else if (k->kind == KEY_COLUMNS)
            print_columns(c, k, out);
        else if (k->kind == KEY_TIMES && c->at != NULL)
            print_times(c, k, out);
    }
}
