/* Case files: YAML that says what to compute. cns_case_print_keys() and cases/README.md list the keys.
 *
 * The system of a case c is
 *
 *     cns_system_new(c->model, c->parameters, c->initial, c->smooth ? &c->eps : NULL, &err),
 *
 * and where it begins at c->start, or goes backwards, cns_system_from() moves it. */
#ifndef CNS_CASE_H
#define CNS_CASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "cns/model.h"
#include "cns/number.h"
#include "cns/solve.h"
#include "cns/status.h"
#include "cns/study/bisect.h"
#include "cns/study/laws.h"
#include "cns/study/lyapunov.h"
#include "cns/study/orbit.h"

CNS_BEGIN_DECLS

#define CNS_CASE_MAX_ROWS 10000000 /* |end - start| / every is at most that */

/* What a case file says. Without a section its fields hold the defaults. All belongs to the case. */
typedef struct cns_case {
    char *name; /* of the file, "<stdin>" for standard input; control characters in it are '?' */
    char *text; /* its bytes, NUL-terminated; UTF-8 without control characters other than tab, CR, LF */
    size_t length;
    char sha256[65]; /* of text, without the overrides */
    char *overrides; /* the --set options, one per line and each fit for one; NULL when there are none */
    const char
        *replaced; /* "goal" or "numerics", which overrides of the other took the place of; NULL: neither */
    const cns_model *model;
    cns_number *parameters; /* model->n_parameters */
    cns_number *initial;    /* model->n_states */
    cns_number start, end;  /* the times of the initial states and of the last row; they differ */
    cns_number every;       /* > 0 */
    cns_number *at; /* n_at times of rows, the last being `end`, each farther from the start than the one
                       before; NULL: rows are `every` apart, from the start on */
    int n_at;
    bool backwards;  /* end < start */
    cns_number span; /* |end - start|, with the text of `end` */
    double max_time; /* seconds after which to stop; 0: no limit */
    bool smooth;     /* abs: {smooth: eps} */
    cns_number eps;
    bool has_goal, has_numerics; /* never both */
    cns_goal goal;
    cns_numerics numerics;
    bool has_laws, has_lyapunov, has_orbit,
        has_bisect; /* is there such a section? laws and lyapunov have defaults */
    cns_laws_spec laws;
    cns_lyapunov_spec lyapunov;
    cns_orbit_spec orbit;
    cns_bisect_spec bisect;
    int n_columns;
    cns_column *columns;
} cns_case;

/* Reads and checks a case file, "-" being standard input. `sets` are n_sets texts "key.key=value" that
 * override values, each by one that may stand behind "key: " on a line of the file. Overrides of `numerics`
 * take the place of the file's `goal`, and those of `goal` of its `numerics`. Every fault is reported, one
 * per line without a final newline ("name:line:column: message", then "--set TEXT: message"), in *report, a
 * new string (NULL when there are none) that the caller frees; then the result is CNS_USAGE. CNS_IO, with one
 * line in *report, when the file cannot be read. On CNS_OK *c is a new case; else it is NULL.
 *
 * Neither `goal` nor `numerics` is needed here: `run` needs one, studies can choose for themselves. */
cns_code cns_case_load(const char *path, const char *const *sets, int n_sets, cns_case **c, char **report);

/* The same for a text in memory; `name` stands in messages. */
cns_code cns_case_parse(const char *name, const char *text, size_t length, const char *const *sets,
                        int n_sets, cns_case **c, char **report);
void cns_case_free(cns_case *c);

/* The resolved case, defaults filled in, as a case file that resolves to the same. */
void cns_case_print(const cns_case *c, FILE *out);

/* The keys of case files, with their ranges, defaults and meanings, in lines that may be long. */
void cns_case_print_keys(FILE *out);

/* The key of this name that says what `cns run` computes, "numerics.method" for "method"; NULL: there is
 * none. */
const char *cns_case_key_of_run(const char *name);

const char *cns_case_column_name(const cns_case *c, int column); /* "t", a state or a derived quantity */

CNS_END_DECLS

#endif
