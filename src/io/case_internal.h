/* What the sources of case files share: the table of keys, and a case file while it is read.
 *
 * case_keys.def  the table: what keys there are
 * case_keys.c    looking into it; the help on the keys
 * case_check.c   one key at a time: its value in the file against its row in the table
 * case_rules.c   several keys together: what must be given, what excludes what, defaults that depend on
 * others case.c         loading, overriding, printing */
#ifndef CNS_IO_CASE_INTERNAL_H
#define CNS_IO_CASE_INTERNAL_H

#include <stdbool.h>
#include <stddef.h>

#include "cns/case.h"
#include "yaml_tree.h"

typedef enum cns_key_kind {
    KEY_SECTION,    /* a mapping of keys that have rows here, or one of the words */
    KEY_MODEL,      /* name of a model */
    KEY_PARAMETERS, /* mapping from the model's parameters to numbers */
    KEY_INITIAL,    /* mapping from the model's states to numbers */
    KEY_COLUMNS,    /* list of t, states and outputs of the model */
    KEY_TIMES,      /* list of rational numbers */
    /* single values with a range: */
    KEY_STATE,     /* name of a state, or one of the words; the field holds its index */
    KEY_PARAMETER, /* name of a parameter; the field holds its index */
    KEY_INTEGER,   /* least..most, or one of the words */
    KEY_NUMBER,    /* above < value < below, or one of the words, which all mean 0 in the field */
    KEY_WORD       /* one of the words */
} cns_key_kind;

/* The C type of the field that holds a key's value. */
typedef enum cns_field_type {
    FIELD_NONE, /* the key has no field: what reads its kind knows where the value goes */
    FIELD_BOOL,
    FIELD_INT, /* int, or an enumeration */
    FIELD_LONG,
    FIELD_DOUBLE,
    FIELD_NUMBER
} cns_field_type;

/* A word that may stand for a value, and the value. */
typedef struct cns_key_word {
    const char *text;
    int value;
} cns_key_word;

enum { CNS_KEY_WORDS = 3 };

typedef struct cns_key {
    const char *path; /* "laws.digits.from": the key `from` of the section `digits` of the section `laws` */
    cns_key_kind kind;
    size_t field; /* its offset in cns_case; of a section: a bool, is the section there as a mapping? */
    cns_field_type type;
    cns_key_word words[CNS_KEY_WORDS];
    long least, most;
    const char *above, *below;         /* open ends, as text; NULL: none */
    bool rational;                     /* a multiple of pi will not do: rows and steps are counted exactly */
    bool required;                     /* when the section that it stands in is there */
    const char *standard;              /* the default, as a case file would say it; NULL: none */
    const char *otherwise;             /* in the help: a default that case_rules.c finds */
    bool (*printed)(const cns_case *); /* does the resolved case show it? NULL: if it has a value */
    const char *meaning;
    const char *hint; /* to who asks for another word, as they are known from elsewhere; NULL: none */
} cns_key;

/* Their names in the sources, as K_TIME_END: a rule about a key that does not exist does not compile. */
typedef enum cns_key_id {
#define KEY(id, ...) K_##id,
#include "case_keys.def"
#undef KEY
    CNS_KEYS
} cns_key_id;

extern const cns_key cns_keys[CNS_KEYS];

const cns_key *cns_key_section(const cns_key *k); /* that k stands in; NULL: at the top */
const char *cns_key_name(const cns_key *k);       /* "from" of "laws.digits.from" */
const char *cns_key_indent(const cns_key *k);     /* four blanks for each section that it stands in */

typedef struct cns_key_text {
    char text[192];
} cns_key_text;

cns_key_text cns_key_title(const cns_key *k); /* "'end' in 'time'" */
cns_key_text cns_key_range(const cns_key *k); /* "an integer from 1 to 100000, or auto" */

const cns_key_word *cns_key_word_named(const cns_key *k, const char *text); /* NULL: no such word */
const cns_key_word *cns_key_word_for(const cns_key *k, long value);         /* NULL: no word means it */

void *cns_key_field(const cns_key *k, const cns_case *c);

/* The value in the field as an integer. Of a cns_number it is only the sign, and only 0 can be put: that is
 * what a word means there. Without a field it is 1: sections that have none are always there. */
void cns_key_put(const cns_key *k, cns_case *c, long value);
long cns_key_get(const cns_key *k, const cns_case *c);

/* What was found of a key. */
typedef struct cns_key_seen {
    const cns_yaml_node *node; /* NULL: it is not in the file */
    bool good;                 /* it is, with a value that its row allows */
} cns_key_seen;

/* A case file while it is read. */
typedef struct cns_case_reader {
    cns_case *c;
    cns_faults faults;
    const cns_yaml_node *root;
    cns_key_seen *seen; /* of each key, in the order of the table */
} cns_case_reader;

/* Fills the case with the defaults and the values of the file, whose root is a mapping. */
void cns_case_check(cns_case_reader *r);

/* Then: what keys must be given or exclude each other, and the values that follow from those of others. */
void cns_case_apply_rules(cns_case_reader *r);

/* Is x > above and x < below? NULL: no such end. */
bool cns_case_within(const cns_number *x, const char *above, const char *below);

#endif
