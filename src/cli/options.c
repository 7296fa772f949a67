#include "options.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "cns/case.h"
#include "cns/number.h"
#include "cns/study/equilibria.h"
#include "cns/study/laws.h"
#include "cns/study/tc.h"
#include "commands.h"
#include "core/memory.h"
#include "core/text.h"

/* What the value of an option must be, and so the type of its member of cns_options. */
typedef enum kind {
    KIND_FLAG,     /* bool; no value */
    KIND_COUNT,    /* int: how often the option is given; no value */
    KIND_TEXT,     /* const char *: anything; its command checks it */
    KIND_NAME,     /* const char *, not empty: of a directory */
    KIND_WRITTEN,  /* const char *, not empty: of a file that the command writes */
    KIND_RATIONAL, /* const char *: a number > 0 of the grammar of case files, without pi */
    KIND_LIST,     /* cns_texts: anything, and many times */
    KIND_INTEGER,  /* long, from least to most */
    KIND_POSITIVE, /* double, above 0 and up to most */
} kind;

typedef struct option_row {
    const char *name; /* without the -- */
    char letter;      /* 0: none */
    const char *argument;
    kind kind;
    size_t member; /* its offset in cns_options */
    long least, most;
    const char *meaning;
} option_row;

#define MEMBER(kind, member)         kind, offsetof(cns_options, member)
#define FLAG(member)                 MEMBER(KIND_FLAG, member), 0, 0
#define COUNT(member)                MEMBER(KIND_COUNT, member), 0, 0
#define TEXT(member)                 MEMBER(KIND_TEXT, member), 0, 0
#define NAME(member)                 MEMBER(KIND_NAME, member), 0, 0
#define WRITTEN(member)              MEMBER(KIND_WRITTEN, member), 0, 0
#define RATIONAL(member)             MEMBER(KIND_RATIONAL, member), 0, 0
#define LIST(member)                 MEMBER(KIND_LIST, member), 0, 0
#define INTEGER(member, least, most) MEMBER(KIND_INTEGER, member), least, most
#define POSITIVE(member, most)       MEMBER(KIND_POSITIVE, member), 0, most

static const option_row options[] = {
#define OPTION(id, ...) [CNS_OPTION_##id] = {__VA_ARGS__},
#include "options.def"
#undef OPTION
};

static const cns_option of_every_command[] = {CNS_OPTION_VERSION, CNS_OPTION_HELP, CNS_OPTIONS_END};

static const char *option_name(int i, const void *context)
{
    (void)context;
    return options[i].name;
}

/* The first row with this name: what is known of an option before its command is. */
static int first_of_name(const char *name, size_t length)
{
    int i = 0;
    while (i < CNS_OPTIONS_END &&
           (strlen(options[i].name) != length || strncmp(options[i].name, name, length) != 0))
        i++;
    return i;
}

static bool takes(const cns_option *list, int option)
{
    for (; list != NULL && *list != CNS_OPTIONS_END; list++)
        if (strcmp(options[*list].name, options[option].name) == 0)
            return true;
    return false;
}

static void print_options(const cns_option *list, FILE *out)
{
    for (; list != NULL && *list != CNS_OPTIONS_END; list++) {
        const option_row *row = &options[*list];
        char shown[64];
        snprintf(shown, sizeof shown, "--%s%s%s", row->name, row->argument != NULL ? " " : "",
                 row->argument != NULL ? row->argument : "");
        if (row->letter != 0)
            fprintf(out, "  -%c, %-20s  %s\n", row->letter, shown, row->meaning);
        else
            fprintf(out, "      %-20s  %s\n", shown, row->meaning);
    }
}

void cns_options_print(const cns_command *command, FILE *out)
{
    if (command != NULL)
        print_options(command->options, out);
    print_options(of_every_command, out);
}

/* Parsing. */

typedef struct parser {
    cns_options *o;
    cns_error *err;
    int argc, at; /* at: the argument to read next */
    char *const *argv;
    bool seen[CNS_OPTIONS_END]; /* by the first row of the name */
} parser;

static cns_code take_integer(parser *p, const option_row *row, const char *text, long *value)
{
    char *end;
    long n = text[0] >= '0' && text[0] <= '9' ? strtol(text, &end, 10) : row->least - 1;
    if (n < row->least || n > row->most || *end != '\0')
        return cns_fail(p->err, CNS_USAGE, "--%s takes an integer from %ld to %ld, not '%s'", row->name,
                        row->least, row->most, cns_quote(text).text);
    *value = n;
    return CNS_OK;
}

static cns_code take_positive(parser *p, const option_row *row, const char *text, double *value)
{
    char *end;
    double x = text[0] >= '0' && text[0] <= '9' ? strtod(text, &end) : 0;
    if (!(x > 0 && x <= (double)row->most) || *end != '\0')
        return cns_fail(p->err, CNS_USAGE, "--%s takes a number above 0 and up to %ld, not '%s'", row->name,
                        row->most, cns_quote(text).text);
    *value = x;
    return CNS_OK;
}

static cns_code check_rational(parser *p, const option_row *row, const char *text)
{
    cns_number x;
    cns_error err;
    cns_number_init(&x);
    const cns_code parsed = cns_number_parse(&x, text, &err);
    const bool good = !parsed && cns_number_sign(&x) > 0 && x.pi_power == 0;
    cns_number_clear(&x);
    if (parsed)
        return cns_fail(p->err, CNS_USAGE, "--%s takes a number > 0, such as 0.01; %s", row->name, err.text);
    return good ? CNS_OK
                : cns_fail(p->err, CNS_USAGE, "--%s takes a number > 0, such as 0.01, not '%s'", row->name,
                           cns_quote(text).text);
}

static cns_code take(parser *p, int option, const char *value)
{
    const option_row *row = &options[option];
    void *member = (char *)p->o + row->member;
    if (p->seen[option] && row->argument != NULL && row->kind != KIND_LIST)
        return cns_fail(p->err, CNS_USAGE, "--%s is given twice", row->name);
    p->seen[option] = true;
    switch (row->kind) {
    case KIND_FLAG:
        *(bool *)member = true;
        break;
    case KIND_COUNT:
        ++*(int *)member;
        break;
    case KIND_LIST: {
        cns_texts *list = member;
        list->at[list->n++] = value;
        break;
    }
    case KIND_INTEGER:
        return take_integer(p, row, value, member);
    case KIND_POSITIVE:
        return take_positive(p, row, value, member);
    case KIND_RATIONAL:
    case KIND_NAME:
    case KIND_WRITTEN:
    case KIND_TEXT:
        if ((row->kind == KIND_NAME || row->kind == KIND_WRITTEN) && value[0] == '\0')
            return cns_fail(p->err, CNS_USAGE, "--%s needs a name", row->name);
        *(const char **)member = value;
        return row->kind == KIND_RATIONAL ? check_rational(p, row, value) : CNS_OK;
    }
    return CNS_OK;
}

/* Option number `option`, whose value is what is attached to it, or else the next argument. */
static cns_code take_with_value(parser *p, int option, const char *attached)
{
    const option_row *row = &options[option];
    const char *value = attached;
    if (row->argument != NULL && value == NULL && p->at < p->argc)
        value = p->argv[p->at++];
    if (row->argument != NULL && value == NULL)
        return cns_fail(p->err, CNS_USAGE, "--%s needs a value: --%s %s", row->name, row->name,
                        row->argument);
    return take(p, option, value);
}

static cns_code parse_long(parser *p, const char *text)
{
    const char *equals = strchr(text, '=');
    size_t n = equals != NULL ? (size_t)(equals - text) : strlen(text);
    const int option = first_of_name(text, n);
    if (option < CNS_OPTIONS_END) {
        if (options[option].argument == NULL && equals != NULL)
            return cns_fail(p->err, CNS_USAGE, "--%s takes no value", options[option].name);
        return take_with_value(p, option, equals != NULL ? equals + 1 : NULL);
    }
    char *name = cns_xcopy_n(text, n);
    const char *nearest = cns_text_nearest(name, CNS_OPTIONS_END, option_name, NULL);
    const char *key = cns_case_key_of_run(name);
    cns_code code =
        key != NULL       ? cns_fail(p->err, CNS_USAGE,
                                     "unknown option --%s; it is a key of case files: --set %s=VALUE", name, key)
        : nearest != NULL ? cns_fail(p->err, CNS_USAGE, "unknown option --%s; did you mean --%s?",
                                     cns_quote(name).text, nearest)
                          : cns_fail(p->err, CNS_USAGE, "unknown option --%s; `cns help` lists the options",
                                     cns_quote(name).text);
    free(name);
    return code;
}

/* -q, -qv, -o FILE, -oFILE */
static cns_code parse_letters(parser *p, const char *letters)
{
    const char *equals = strchr(letters, '=');
    const size_t n = equals != NULL ? (size_t)(equals - letters) : strlen(letters);
    if (n > 1 && first_of_name(letters, n) < CNS_OPTIONS_END)
        return cns_fail(p->err, CNS_USAGE, "-%s: write two hyphens, --%s", cns_quote(letters).text,
                        cns_quote(letters).text);
    for (; *letters != '\0'; letters++) {
        int option = 0;
        while (option < CNS_OPTIONS_END && options[option].letter != *letters)
            option++;
        if (option == CNS_OPTIONS_END)
            return cns_fail(p->err, CNS_USAGE, "unknown option -%s; `cns help` lists the options",
                            cns_quote(letters).text);
        if (options[option].argument != NULL)
            return take_with_value(p, option, letters[1] != '\0' ? letters + 1 : NULL);
        cns_code code = take(p, option, NULL);
        if (code != CNS_OK)
            return code;
    }
    return CNS_OK;
}

/* Does it begin with a dash that editors and chats make of hyphens? U+2010 to U+2015, and U+2212. */
static bool typographic_dash(const char *word)
{
    return (strncmp(word, "\xE2\x80", 2) == 0 && (unsigned char)word[2] >= 0x90 &&
            (unsigned char)word[2] <= 0x95) ||
           strncmp(word, "\xE2\x88\x92", 3) == 0;
}

static cns_code parse_word(parser *p, const char *word)
{
    cns_options *o = p->o;
    if (o->command != NULL) {
        o->operands.at[o->operands.n++] = word;
        return CNS_OK;
    }
    o->command = cns_command_find(word);
    if (o->command != NULL)
        return CNS_OK;
    size_t n = strlen(word);
    const char *nearest = cns_command_nearest(word);
    if (typographic_dash(word))
        return cns_fail(p->err, CNS_USAGE, "'%s' begins with a typographic dash: write plain hyphens, --",
                        cns_quote(word).text);
    if (first_of_name(word, n) < CNS_OPTIONS_END)
        return cns_fail(p->err, CNS_USAGE, "unknown command '%s'; did you mean --%s?", word, word);
    if (nearest != NULL)
        return cns_fail(p->err, CNS_USAGE, "unknown command '%s'; did you mean '%s'?", cns_quote(word).text,
                        nearest);
    if ((n > 5 && strcmp(word + n - 5, ".yaml") == 0) || (n > 4 && strcmp(word + n - 4, ".yml") == 0))
        return cns_fail(p->err, CNS_USAGE, "a command is missing before '%s', such as `cns run`",
                        cns_quote(word).text);
    return cns_fail(p->err, CNS_USAGE, "unknown command '%s'; `cns help` lists the commands",
                    cns_quote(word).text);
}

/* An option that other commands take: what to type instead. */
static cns_code refuse_foreign(parser *p, int option)
{
    const cns_command *c = p->o->command, *other;
    const char *name = options[option].name, *names[64];
    const char *key = strcmp(name, "until") == 0 ? "time.end" : cns_case_key_of_run(name);
    char list[256];
    int n = 0;
    if (c == &cns_command_run && key != NULL)
        return cns_fail(p->err, CNS_USAGE, "--%s does not go with `cns run`; write --set %s=VALUE", name,
                        key);
    for (int i = 0; (other = cns_command_at(i)) != NULL; i++)
        if (takes(other->options, option) && n < (int)(sizeof names / sizeof *names))
            names[n++] = other->name;
    cns_text_list(list, sizeof list, names, n);
    return cns_fail(p->err, CNS_USAGE, "--%s does not go with `cns %s`, but with %s", name, c->name, list);
}

/* More words than the command takes: what was most likely meant. */
static cns_code refuse_surplus(parser *p)
{
    const cns_options *o = p->o;
    const cns_command *c = o->command;
    const char *word = o->operands.at[c->most];
    for (int i = 0; i < o->sets.n; i++) {
        const char *equals = strchr(o->sets.at[i], '=');
        if (equals == NULL || equals[1] == '\0')
            return cns_fail(p->err, CNS_USAGE,
                            "--set takes one argument, without spaces or in quotes: --set '%.*s=VALUE'",
                            (int)strcspn(cns_quote(o->sets.at[i]).text, "="), cns_quote(o->sets.at[i]).text);
    }
    if (typographic_dash(word))
        return cns_fail(p->err, CNS_USAGE, "'%s' begins with a typographic dash: write plain hyphens, --",
                        cns_quote(word).text);
    if (strchr(word, '=') != NULL && takes(c->options, CNS_OPTION_SET))
        return cns_fail(p->err, CNS_USAGE, "one argument too many, '%s'; to override a value write --set %s",
                        cns_quote(word).text, cns_quote(word).text);
    return cns_fail(p->err, CNS_USAGE, "one argument too many, '%s': cns %s %s", cns_quote(word).text,
                    c->name, c->operands);
}

static cns_code check_use(parser *p)
{
    const cns_options *o = p->o;
    const cns_command *c = o->command;
    if (c == NULL)
        return cns_fail(p->err, CNS_USAGE, "a command is missing; `cns help` lists the commands");
    for (int i = 0; i < CNS_OPTIONS_END; i++)
        if (p->seen[i] && !takes(c->options, i) && !takes(of_every_command, i))
            return refuse_foreign(p, i);
    if (o->operands.n > 0 && o->operands.n < c->least)
        return cns_fail(p->err, CNS_USAGE, "only '%s' is given: cns %s %s", cns_quote(o->operands.at[0]).text,
                        c->name, c->operands);
    if (o->operands.n < c->least)
        return cns_fail(p->err, CNS_USAGE, "%s is missing: cns %s %s", c->operands, c->name, c->operands);
    if (o->operands.n > c->most)
        return refuse_surplus(p);
    if (o->quiet && o->verbose > 0)
        return cns_fail(p->err, CNS_USAGE, "--quiet and --verbose contradict each other");
    return CNS_OK;
}

cns_code cns_options_parse(cns_options *o, int argc, char *const *argv, cns_error *err)
{
    *o = (cns_options){0};
    const size_t room = argc > 0 ? (size_t)argc : 1;
    o->operands.at = cns_xalloc(room, sizeof *o->operands.at);
    o->sets.at = cns_xalloc(room, sizeof *o->sets.at);
    o->sections.at = cns_xalloc(room, sizeof *o->sections.at);
    parser p = {.o = o, .err = err, .argc = argc, .at = 1, .argv = argv};
    bool only_words = false;
    while (p.at < argc) {
        const char *word = argv[p.at++];
        cns_code code;
        if (!only_words && strcmp(word, "--") == 0) {
            only_words = true;
            continue;
        }
        if (!only_words && word[0] == '-' && word[1] == '-')
            code = parse_long(&p, word + 2);
        else if (!only_words && word[0] == '-' && word[1] != '\0')
            code = parse_letters(&p, word + 1);
        else
            code = parse_word(&p, word);
        if (code != CNS_OK)
            return code;
    }
    if (o->help || o->version)
        return CNS_OK;
    return check_use(&p);
}

int cns_options_written(const cns_options *o, cns_written *list, int most)
{
    int n = 0;
    for (const cns_option *at = o->command->options; at != NULL && *at != CNS_OPTIONS_END && n < most; at++) {
        const option_row *row = &options[*at];
        const char *path =
            row->kind == KIND_WRITTEN ? *(const char *const *)((const char *)o + row->member) : NULL;
        if (path != NULL)
            list[n++] = (cns_written){row->name, path};
    }
    return n;
}

void cns_options_clear(cns_options *o)
{
    free(o->operands.at);
    free(o->sets.at);
    free(o->sections.at);
    *o = (cns_options){0};
}
