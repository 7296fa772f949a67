/* YAML read into a small tree that remembers where everything stood, and the list of what was wrong.
 *
 * A subset on purpose: mappings, lists and plain or quoted text. Anchors, aliases, tags, further
 * documents and doubled keys are faults. Values stay text. */
#ifndef CNS_IO_YAML_TREE_H
#define CNS_IO_YAML_TREE_H

#include <stdbool.h>
#include <stddef.h>

#define CNS_YAML_MAX_BYTES  (1024L * 1024L)
#define CNS_YAML_MAX_DEPTH  16
#define CNS_YAML_MAX_NODES  4096
#define CNS_YAML_MAX_FAULTS 100 /* that are reported; of further ones only the number is */

/* Where something stands: a line and column of the file, from 1, and set = -1; or the override of number
 * `set`. */
typedef struct cns_mark {
    size_t line, column;
    int set;
} cns_mark;

int cns_mark_order(cns_mark a, cns_mark b); /* < 0: a stands before b; > 0: after it */

typedef struct cns_fault {
    cns_mark mark;
    size_t number; /* in order of discovery */
    char *message;
} cns_fault;

typedef struct cns_faults {
    size_t count, kept;
    cns_fault *list;
    bool out_of_memory; /* while reading; no fault of the file */
} cns_faults;

#if defined(__GNUC__)
__attribute__((format(printf, 3, 4)))
#endif
void cns_faults_add(cns_faults *f, cns_mark mark, const char *format, ...);

/* One line per fault, in the order of the file, then of the overrides; NULL when there is none.
 * sets[i] is the text of override i. The caller frees it. */
char *cns_faults_report(cns_faults *f, const char *name, const char *const *sets);
void cns_faults_clear(cns_faults *f);

typedef enum cns_yaml_kind { CNS_YAML_SCALAR, CNS_YAML_MAPPING, CNS_YAML_SEQUENCE } cns_yaml_kind;

const char *cns_yaml_kind_name(cns_yaml_kind kind); /* for messages: "a mapping" */

typedef struct cns_yaml_node {
    cns_yaml_kind kind;
    cns_mark mark;
    char *text; /* of a scalar */
    char *key;  /* when it stands in a mapping */
    cns_mark key_mark;
    bool refused;                              /* a fault has been reported: its value does not count */
    struct cns_yaml_node *first, *last, *next; /* children; next sibling */
} cns_yaml_node;

/* The root of the only document, or NULL when the text could not be read to its end (then there is a
 * fault, or memory has run out). */
cns_yaml_node *cns_yaml_parse(const char *text, size_t length, cns_faults *f);
void cns_yaml_free(cns_yaml_node *node);

cns_yaml_node *cns_yaml_find(const cns_yaml_node *mapping, const char *key); /* NULL: not there */

void cns_yaml_remove(cns_yaml_node *mapping, const char *key); /* every child of this key */

/* Puts a value at the path (keys joined by points), making mappings on the way and replacing the whole of
 * what stood there. The value is what may stand behind `key: ` on one line of a file; faults in it are those
 * of override number `set`. False when the path is malformed or too deep. */
bool cns_yaml_override(cns_yaml_node *root, const char *path, size_t path_length, const char *value, int set,
                       cns_faults *f);

#endif
