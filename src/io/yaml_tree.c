#include "yaml_tree.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <yaml.h>

#include "core/memory.h"
#include "core/text.h"

/* Faults. */

void cns_faults_add(cns_faults *f, cns_mark mark, const char *format, ...)
{
    f->count++;
    if (f->kept == CNS_YAML_MAX_FAULTS)
        return;
    char text[1024];
    va_list args;
    va_start(args, format);
    if (vsnprintf(text, sizeof text, format, args) < 0)
        text[0] = '\0';
    va_end(args);
    if (f->list == NULL)
        f->list = cns_xalloc(CNS_YAML_MAX_FAULTS, sizeof *f->list);
    f->list[f->kept] = (cns_fault){mark, f->kept, cns_xcopy(text)};
    f->kept++;
}

int cns_mark_order(cns_mark a, cns_mark b)
{
    if (a.set != b.set)
        return a.set < b.set ? -1 : 1;
    if (a.line != b.line)
        return a.line < b.line ? -1 : 1;
    return (a.column > b.column) - (a.column < b.column);
}

static int order_of_faults(const void *pa, const void *pb)
{
    const cns_fault *a = pa, *b = pb;
    const int order = cns_mark_order(a->mark, b->mark);
    return order != 0 ? order : (a->number > b->number) - (a->number < b->number);
}

char *cns_faults_report(cns_faults *f, const char *name, const char *const *sets)
{
    if (f->count == 0)
        return NULL;
    qsort(f->list, f->kept, sizeof *f->list, order_of_faults);
    size_t size = 64 + strlen(name);
    for (size_t i = 0; i < f->kept; i++)
        size += strlen(name) + strlen(f->list[i].message) + 64 + CNS_QUOTE;
    char *report = cns_xgrow(NULL, size, 1);
    size_t used = 0;
    for (size_t i = 0; i < f->kept; i++) {
        const cns_fault *x = &f->list[i];
        int n;
        if (x->mark.set >= 0)
            n = snprintf(report + used, size - used, "--set %s: %s\n", cns_quote(sets[x->mark.set]).text,
                         x->message);
        else
            n = snprintf(report + used, size - used, "%s:%zu:%zu: %s\n", name, x->mark.line, x->mark.column,
                         x->message);
        used += n > 0 ? (size_t)n : 0;
    }
    if (f->count > f->kept) {
        int n = snprintf(report + used, size - used, "%s: %zu more\n", name, f->count - f->kept);
        used += n > 0 ? (size_t)n : 0;
    }
    report[used - 1] = '\0'; /* the last newline */
    return report;
}

void cns_faults_clear(cns_faults *f)
{
    for (size_t i = 0; i < f->kept; i++)
        free(f->list[i].message);
    free(f->list);
    *f = (cns_faults){0};
}

/* The tree. */

const char *cns_yaml_kind_name(cns_yaml_kind kind)
{
    static const char *const names[] = {"a single value", "a mapping", "a list"};
    return names[kind];
}

static cns_yaml_node *new_node(cns_yaml_kind kind, cns_mark mark)
{
    cns_yaml_node *node = cns_xalloc(1, sizeof *node);
    node->kind = kind;
    node->mark = mark;
    return node;
}

static void append(cns_yaml_node *parent, cns_yaml_node *child)
{
    if (parent->last != NULL)
        parent->last->next = child;
    else
        parent->first = child;
    parent->last = child;
}

void cns_yaml_free(cns_yaml_node *node)
{
    if (node == NULL)
        return;
    for (cns_yaml_node *child = node->first, *next; child != NULL; child = next) {
        next = child->next;
        cns_yaml_free(child);
    }
    free(node->text);
    free(node->key);
    free(node);
}

cns_yaml_node *cns_yaml_find(const cns_yaml_node *mapping, const char *key)
{
    if (mapping == NULL || mapping->kind != CNS_YAML_MAPPING)
        return NULL;
    for (cns_yaml_node *child = mapping->first; child != NULL; child = child->next)
        if (strcmp(child->key, key) == 0)
            return child;
    return NULL;
}

void cns_yaml_remove(cns_yaml_node *mapping, const char *key)
{
    cns_yaml_node *kept = mapping->first;
    mapping->first = mapping->last = NULL;
    for (cns_yaml_node *child = kept, *next; child != NULL; child = next) {
        next = child->next;
        child->next = NULL;
        if (strcmp(child->key, key) == 0)
            cns_yaml_free(child);
        else
            append(mapping, child);
    }
}

/* Makes a node an empty one of another kind. Its key, and its place among its siblings, stay. */
static void reset_node(cns_yaml_node *node, cns_yaml_kind kind, cns_mark mark)
{
    for (cns_yaml_node *child = node->first, *next; child != NULL; child = next) {
        next = child->next;
        cns_yaml_free(child);
    }
    free(node->text);
    node->text = NULL;
    node->first = node->last = NULL;
    node->kind = kind;
    node->mark = mark;
}

/* Reading. */

typedef struct builder {
    yaml_parser_t parser;
    const char *text, *end; /* what is read */
    const char *at;         /* a place in it, */
    size_t index;           /* and the number of characters before that */
    cns_faults *faults;
    int set; /* the number of the override whose value this is; -1: it is a file */
    size_t nodes;
    bool stopped; /* a fault after which reading on makes no sense */
} builder;

static cns_mark mark_of(const builder *b, yaml_mark_t m)
{
    return b->set >= 0 ? (cns_mark){0, 0, b->set} : (cns_mark){m.line + 1, m.column + 1, -1};
}

/* The place of a mark in the text. Marks count characters; those asked for mostly go forwards. */
static const char *place_of(builder *b, yaml_mark_t m)
{
    if (m.index < b->index) {
        b->at = b->text;
        b->index = 0;
    }
    for (; b->index < m.index && b->at < b->end; b->index++)
        b->at += cns_utf8_length((const unsigned char *)b->at, (size_t)(b->end - b->at));
    return b->at;
}

static bool line_end(char c)
{
    return c == '\n' || c == '\r';
}

static const char *line_start(const builder *b, const char *at)
{
    while (at > b->text && !line_end(at[-1]))
        at--;
    return at;
}

/* Is there "KEY: " or "KEY:" at the end, from `at` up to `end`? */
static bool holds_key(const char *at, const char *end)
{
    for (; at < end && *at != '#'; at++)
        if (*at == ':' && (at + 1 == end || at[1] == ' '))
            return true;
    return false;
}

/* The cure where a colon stands that YAML does not expect at `at`. */
static const char *misplaced_colon(const builder *b, const char *at)
{
    const char *start = line_start(b, at), *end;
    if (holds_key(start, at))
        return "a second ': ' on one line; keys of a section stand in braces, as in time: {end: 1}, or on "
               "lines of "
               "their own";
    do { /* the line above that says something */
        end = start;
        while (end > b->text && (line_end(end[-1]) || end[-1] == ' '))
            end--;
        start = line_start(b, end);
    } while (end > b->text && start[strspn(start, " ")] == '#');
    if (!holds_key(start, end))
        return "the line above is not 'key: value', with a space after the colon";
    return "indented deeper than the line above, which has its value; keys of a section begin in one column";
}

/* The mistake that people make where libyaml reports this problem, and its cure; NULL: none is known. */
static const char *cure_of(builder *b)
{
    const yaml_parser_t *p = &b->parser;
    const char *problem = p->problem, *at = place_of(b, p->problem_mark);
    const char here = at < b->end ? *at : '\0';
    if (here == '\t' && (strstr(problem, "tab character") != NULL || strstr(problem, "cannot start") != NULL))
        return "a tab; indent with spaces";
    if (strstr(problem, "cannot start any token") != NULL)
        return "a value that begins with this character must stand in quotes";
    if (strstr(problem, "mapping values are not allowed") != NULL)
        return misplaced_colon(b, at);
    if (strstr(problem, "expected key") != NULL) {
        const char *start = line_start(b, at);
        if (here == '}' || here == ']')
            return "this bracket closes nothing";
        if (start + strspn(start, " ") < at)
            return "nothing may stand between the end of a value and the end of its line";
        return "indented unlike the lines above; keys of a section begin in one column";
    }
    if (strstr(problem, "expected ',' or") != NULL && p->problem_mark.line == p->context_mark.line &&
        here != '\0')
        return "a comma must separate one value from the next, as in {end: 1, every: 0.5}";
    if (strstr(problem, "could not find expected ':'") != NULL)
        return "the line above is not 'key: value', with a space after the colon";
    if (strstr(problem, "document start") != NULL)
        return "text after the end of the first value; a case file is lines of 'key: value'; is this a "
               "table?";
    return NULL;
}

/* What is left open at the end of the text or of its section, and since which line; NULL: nothing. */
static const char *left_open(const yaml_parser_t *p)
{
    if (p->context == NULL || p->context_mark.line == p->problem_mark.line)
        return NULL;
    if (strstr(p->context, "quoted scalar") != NULL)
        return "quotation mark";
    return strstr(p->context, "flow mapping") != NULL    ? "'{'"
           : strstr(p->context, "flow sequence") != NULL ? "'['"
                                                         : NULL;
}

static bool next_event(builder *b, yaml_event_t *event)
{
    if (yaml_parser_parse(&b->parser, event))
        return true;
    const yaml_parser_t *p = &b->parser;
    cns_mark mark = mark_of(b, p->problem_mark);
    const bool memory = p->error == YAML_MEMORY_ERROR;
    const char *open = memory ? NULL : left_open(p), *cure = memory || open != NULL ? NULL : cure_of(b);
    if (memory)
        b->faults->out_of_memory = true;
    else if (open != NULL && b->set < 0)
        cns_faults_add(b->faults, mark, "not YAML: the %s of line %zu is not closed", open,
                       p->context_mark.line + 1);
    else if (cure != NULL)
        cns_faults_add(b->faults, mark, "not YAML: %s", cure);
    else if (p->context != NULL && b->set < 0 && p->context_mark.line != p->problem_mark.line)
        cns_faults_add(b->faults, mark, "not YAML: %s, %s that began on line %zu", p->problem, p->context,
                       p->context_mark.line + 1);
    else if (p->context != NULL)
        cns_faults_add(b->faults, mark, "not YAML: %s, %s", p->problem, p->context);
    else
        cns_faults_add(b->faults, mark, "not YAML: %s", p->problem);
    b->stopped = true;
    return false;
}

static void refuse_properties(builder *b, cns_mark mark, const yaml_char_t *anchor, const yaml_char_t *tag)
{
    if (anchor != NULL)
        cns_faults_add(b->faults, mark, "anchors and aliases are not accepted: '&%s'",
                       cns_quote((const char *)anchor).text);
    if (tag != NULL)
        cns_faults_add(b->faults, mark, "tags are not accepted: '%s'", cns_quote((const char *)tag).text);
}

static cns_yaml_node *build(builder *b, const yaml_event_t *event, int depth, const char *key);

static cns_yaml_node *build_scalar(builder *b, const yaml_event_t *event, cns_mark mark)
{
    const char *value = (const char *)event->data.scalar.value;
    size_t length = event->data.scalar.length;
    refuse_properties(b, mark, event->data.scalar.anchor, event->data.scalar.tag);
    if (memchr(value, '\0', length) != NULL)
        cns_faults_add(b->faults, mark, "a NUL character inside a text");
    cns_yaml_node *node = new_node(CNS_YAML_SCALAR, mark);
    node->text = cns_xcopy_n(value, length);
    return node;
}

static cns_yaml_node *build_sequence(builder *b, cns_mark mark, int depth)
{
    cns_yaml_node *node = new_node(CNS_YAML_SEQUENCE, mark);
    while (!b->stopped) {
        yaml_event_t event;
        if (!next_event(b, &event))
            break;
        if (event.type == YAML_SEQUENCE_END_EVENT) {
            yaml_event_delete(&event);
            break;
        }
        cns_yaml_node *child = build(b, &event, depth + 1, NULL);
        yaml_event_delete(&event);
        if (child != NULL)
            append(node, child);
    }
    return node;
}

/* Refuses `child`, which is to be added to the mapping, if its key is there already. `where` is the key that
 * the mapping stands at, NULL at the top. */
static void refuse_doubled(builder *b, const cns_yaml_node *mapping, const char *where, cns_yaml_node *child)
{
    const cns_yaml_node *first = cns_yaml_find(mapping, child->key);
    if (first == NULL)
        return;
    child->refused = true;
    char place[64] = "";
    if (b->set < 0)
        snprintf(place, sizeof place, "; it is already on line %zu", first->key_mark.line);
    cns_faults_add(b->faults, child->key_mark, "doubled key '%s'%s%s%s%s", cns_quote(child->key).text,
                   where != NULL ? " in '" : "", where != NULL ? cns_quote(where).text : "",
                   where != NULL ? "'" : "", place);
}

/* What stands between braces without ': ' is a key without a value to YAML. Where people mean something else
 * by it, says so, and returns the name of the key that is meant, a new string; NULL: it is not known what is
 * meant, or the word belongs to the value before, the last of the mapping. `word` begins at `at` in the text.
 */
static char *refuse_bare(builder *b, cns_yaml_node *mapping, const char *word, const char *at, cns_mark mark)
{
    cns_yaml_node *before = mapping->last;
    const size_t name = strcspn(word, ":=");
    const char *value = word + name + 1;
    while (at > b->text && at[-1] == ' ')
        at--;
    if (word[0] >= '0' && word[0] <= '9' && before != NULL && before->kind == CNS_YAML_SCALAR &&
        at > b->text && at[-1] == ',') {
        before->refused = true;
        cns_faults_add(b->faults, before->mark,
                       "'%s,%s' is two values; write a point for the decimal comma: %s.%s",
                       cns_quote(before->text).text, cns_quote(word).text, cns_quote(before->text).text,
                       cns_quote(word).text);
        return NULL;
    }
    if (name == 0 || word[name] == '\0' || *value == '\0')
        return NULL;
    char *meant = cns_xcopy_n(word, name);
    if (word[name] == ':')
        cns_faults_add(b->faults, mark, "a space is missing after the colon: write '%s: %s'",
                       cns_quote(meant).text, cns_quote(value).text);
    else
        cns_faults_add(b->faults, mark, "write '%s: %s', with a colon and a space, not '%s'",
                       cns_quote(meant).text, cns_quote(value).text, cns_quote(word).text);
    return meant;
}

static cns_yaml_node *build_mapping(builder *b, cns_mark mark, int depth, const char *own_key)
{
    cns_yaml_node *node = new_node(CNS_YAML_MAPPING, mark);
    while (!b->stopped) {
        yaml_event_t event;
        if (!next_event(b, &event))
            break;
        if (event.type == YAML_MAPPING_END_EVENT) {
            yaml_event_delete(&event);
            break;
        }
        const cns_mark key_mark = mark_of(b, event.start_mark);
        const char *key_at = place_of(b, event.start_mark), *key_end = place_of(b, event.end_mark);
        cns_yaml_node *key = build(b, &event, depth + 1, NULL);
        yaml_event_delete(&event);
        if (key != NULL && key->kind != CNS_YAML_SCALAR)
            cns_faults_add(b->faults, key_mark, "a key must be a word");
        const char *name = key != NULL && key->kind == CNS_YAML_SCALAR && !key->refused ? key->text : NULL;
        cns_yaml_node *value = NULL;
        if (!b->stopped && next_event(b, &event)) {
            const char *value_at = place_of(b, event.start_mark);
            const bool bare =
                value_at >= key_end && memchr(key_end, ':', (size_t)(value_at - key_end)) == NULL;
            const size_t faults = b->faults->count;
            value = build(b, &event, depth + 1, name);
            yaml_event_delete(&event);
            if (bare && name != NULL && value != NULL) {
                char *meant = refuse_bare(b, node, name, key_at, key_mark);
                value->refused = b->faults->count > faults;
                if (meant != NULL) {
                    free(key->text);
                    name = key->text = meant;
                }
            }
        }
        if (value != NULL && name != NULL) {
            value->key = cns_xcopy(name);
            value->key_mark = key_mark;
            refuse_doubled(b, node, own_key, value);
            append(node, value);
        } else {
            cns_yaml_free(value);
        }
        cns_yaml_free(key);
    }
    return node;
}

/* Stands for an alias, which is refused: without a node the next key would be taken for the value. */
static cns_yaml_node *refused_scalar(cns_mark mark)
{
    cns_yaml_node *node = new_node(CNS_YAML_SCALAR, mark);
    node->text = cns_xcopy("");
    node->refused = true;
    return node;
}

/* The node that an event begins; NULL for one that was refused. `key`: the key it stands at, or NULL. */
static cns_yaml_node *build(builder *b, const yaml_event_t *event, int depth, const char *key)
{
    cns_mark mark = mark_of(b, event->start_mark);
    if (++b->nodes > CNS_YAML_MAX_NODES) {
        cns_faults_add(b->faults, mark, "more than %d keys and values; reading stops here",
                       CNS_YAML_MAX_NODES);
        b->stopped = true;
        return NULL;
    }
    if (depth > CNS_YAML_MAX_DEPTH) {
        cns_faults_add(b->faults, mark, "nested more than %d deep; reading stops here", CNS_YAML_MAX_DEPTH);
        b->stopped = true;
        return NULL;
    }
    switch (event->type) {
    case YAML_SCALAR_EVENT:
        return build_scalar(b, event, mark);
    case YAML_SEQUENCE_START_EVENT:
        refuse_properties(b, mark, event->data.sequence_start.anchor, event->data.sequence_start.tag);
        return build_sequence(b, mark, depth);
    case YAML_MAPPING_START_EVENT:
        refuse_properties(b, mark, event->data.mapping_start.anchor, event->data.mapping_start.tag);
        return build_mapping(b, mark, depth, key);
    case YAML_ALIAS_EVENT:
        cns_faults_add(b->faults, mark, "anchors and aliases are not accepted: '*%s'",
                       cns_quote((const char *)event->data.alias.anchor).text);
        return refused_scalar(mark);
    default:
        return NULL;
    }
}

/* Refuses bytes that are no text, with their place: libyaml reports some of them without a place, and accepts
 * others. */
static bool check_bytes(const char *text, size_t length, cns_faults *f)
{
    cns_mark mark = {1, 1, -1};
    const unsigned char *s = (const unsigned char *)text;
    for (size_t i = 0; i < length;) {
        int step = cns_utf8_length(s + i, length - i);
        if (step == 0) {
            const bool wide = i == 0 && length > 1 && s[0] + s[1] == 0xFE + 0xFF; /* a byte order mark */
            cns_faults_add(f, mark, "byte 0x%02X is not UTF-8 text; %ssave the file as UTF-8", s[i],
                           wide ? "this is UTF-16: " : "");
            return false;
        }
        bool c1 = s[i] == 0xC2 && s[i + 1] < 0xA0 && s[i + 1] != 0x85;
        if ((s[i] < 0x20 && s[i] != '\t' && s[i] != '\n' && s[i] != '\r') || s[i] == 0x7F || c1) {
            cns_faults_add(f, mark, "control character 0x%02X; is this a text file?", c1 ? s[i + 1] : s[i]);
            return false;
        }
        if (step == 3 && s[i] == 0xEF && s[i + 1] == 0xBF && s[i + 2] >= 0xBE) { /* U+FFFE, U+FFFF */
            cns_faults_add(f, mark, "a character that is no text; is this a text file?");
            return false;
        }
        if (s[i] == '\n' || (s[i] == '\r' && !(i + 1 < length && s[i + 1] == '\n'))) {
            mark.line++;
            mark.column = 1;
        } else {
            mark.column++;
        }
        i += (size_t)step;
    }
    return true;
}

/* Reads up to the event of the first content, then up to the end of the stream. */
static cns_yaml_node *read_stream(builder *b)
{
    cns_yaml_node *root = NULL;
    int documents = 0;
    for (bool done = false; !done && !b->stopped;) {
        yaml_event_t event;
        if (!next_event(b, &event))
            break;
        switch (event.type) {
        case YAML_STREAM_START_EVENT:
        case YAML_DOCUMENT_END_EVENT:
            break;
        case YAML_DOCUMENT_START_EVENT:
            if (++documents > 1) {
                cns_faults_add(b->faults, mark_of(b, event.start_mark),
                               "a second document begins; a case file holds one");
                b->stopped = true;
            }
            break;
        case YAML_STREAM_END_EVENT:
            done = true;
            break;
        default:
            root = build(b, &event, 1, NULL);
            break;
        }
        yaml_event_delete(&event);
    }
    return root;
}

static cns_yaml_node *parse(const char *text, size_t length, int set, cns_faults *f)
{
    builder b = {.text = text, .end = text + length, .at = text, .faults = f, .set = set};
    if (!yaml_parser_initialize(&b.parser)) {
        f->out_of_memory = true;
        return NULL;
    }
    yaml_parser_set_input_string(&b.parser, (const unsigned char *)text, length);
    cns_yaml_node *root = read_stream(&b);
    yaml_parser_delete(&b.parser);
    if (!b.stopped && root == NULL)
        cns_faults_add(f, (cns_mark){1, 1, -1},
                       "the file is empty, or all comments; `cns help case` lists what a case file says");
    if (b.stopped) {
        cns_yaml_free(root);
        root = NULL;
    }
    return root;
}

cns_yaml_node *cns_yaml_parse(const char *text, size_t length, cns_faults *f)
{
    static const char byte_order_mark[] = "\xEF\xBB\xBF";
    const cns_mark start = {1, 1, -1};
    if (length >= 3 && memcmp(text, byte_order_mark, 3) == 0) {
        text += 3;
        length -= 3;
    }
    if (length > (size_t)CNS_YAML_MAX_BYTES) {
        cns_faults_add(f, start, "larger than 1 MiB; this cannot be a case file");
        return NULL;
    }
    if (!check_bytes(text, length, f))
        return NULL;
    return parse(text, length, -1, f);
}

/* Overrides. */

/* The node at the path, and mappings on the way; NULL: the path is malformed or too deep. */
static cns_yaml_node *node_at(cns_yaml_node *root, const char *path, size_t path_length, cns_mark mark)
{
    const char *end = path + path_length;
    size_t depth = 1;
    for (const char *p = path; p < end; p++)
        depth += *p == '.';
    if (path_length == 0 || *path == '.' || end[-1] == '.' || depth > CNS_YAML_MAX_DEPTH)
        return NULL;
    for (const char *p = path; p + 1 < end; p++)
        if (p[0] == '.' && p[1] == '.')
            return NULL;
    cns_yaml_node *node = root;
    for (const char *p = path; p < end;) {
        const char *stop = memchr(p, '.', (size_t)(end - p));
        if (stop == NULL)
            stop = end;
        if (node->kind != CNS_YAML_MAPPING)
            reset_node(node, CNS_YAML_MAPPING, mark);
        char *key = cns_xcopy_n(p, (size_t)(stop - p));
        cns_yaml_node *child = cns_yaml_find(node, key);
        if (child == NULL) {
            child = new_node(CNS_YAML_MAPPING, mark);
            child->key = key;
            child->key_mark = mark;
            append(node, child);
        } else {
            free(key);
        }
        node = child;
        p = stop + (stop < end);
    }
    return node;
}

bool cns_yaml_override(cns_yaml_node *root, const char *path, size_t path_length, const char *value, int set,
                       cns_faults *f)
{
    const cns_mark mark = {0, 0, set};
    cns_yaml_node *node = node_at(root, path, path_length, mark);
    if (node == NULL)
        return false;
    /* A line of a file: the key, for messages, and the value. */
    const bool word = strspn(node->key, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") ==
                      strlen(node->key);
    const char *key = word ? node->key : "value";
    const size_t size = strlen(key) + strlen(value) + 3;
    char *line = cns_xalloc(size, 1);
    snprintf(line, size, "%s: %s", key, value);
    cns_yaml_node *whole = parse(line, size - 1, set, f);
    free(line);
    cns_yaml_node *given = whole != NULL ? whole->first : NULL; /* NULL: refused, and reported */
    reset_node(node, given != NULL ? given->kind : CNS_YAML_SCALAR, mark);
    node->refused = given == NULL || given->refused;
    if (given != NULL) {
        node->text = given->text;
        node->first = given->first;
        node->last = given->last;
        given->text = NULL;
        given->first = given->last = NULL;
    } else {
        node->text = cns_xcopy("");
    }
    cns_yaml_free(whole);
    return true;
}
