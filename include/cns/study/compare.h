/* Two tables compared: to how many decimals they agree, where they first differ, and T_c.
 *
 * Rows meet where their times are equal, exactly; nothing is interpolated. Values are compared exactly, as
 * the decimals that the texts are. Two values agree to p decimals when they differ by no more than half a
 * unit of the p-th, p being at most what the shorter text gives: a value and its correct rounding agree to
 * all decimals of the rounding. Values that are equal set no limit. T_c goes by rows (CNS_TC_ROWS of
 * cns/study/tc.h), without a refinement: it is the first common row at which |1 - u1/u2| > delta, u1 from A
 * and u2 from B, 0/0 counting as 0 and x/0 as infinite, or, for the norm, at which the distance exceeds
 * delta; between rows nothing is known, and T_c depends on them.
 *
 * What is not compared is no agreement, and is told: columns and rows that only one table has, and values
 * that are missing. A value against a missing one is a difference. */
#ifndef CNS_STUDY_COMPARE_H
#define CNS_STUDY_COMPARE_H

#include <limits.h>
#include <stdbool.h>

#include "cns/number.h"
#include "cns/status.h"

CNS_BEGIN_DECLS

#define CNS_COMPARE_NOTHING LONG_MIN       /* no value to compare in this row */
#define CNS_COMPARE_MISSING (LONG_MIN + 1) /* one table has a value, the other has none */

/* Rows of a table, in the order of their times. */
typedef struct cns_rows {
    void *context;
    int n; /* columns */
    const char *(*name)(void *context, int column);
    int time;               /* the column that holds it */
    mpz_srcptr denominator; /* times stand for the nearest fractions with denominators up to this; NULL: for
                               themselves */
    const char *model;      /* that the table names; NULL: none */
    bool ours;              /* a table of this program: its columns decimals and growth are no quantities */
    cns_code (*next)(void *context, bool *more, cns_error *err);
    const char *(*text)(void *context, int column); /* of the row at hand; NULL: missing */
    /* CNS_USAGE, with the place of the row's value and what is wrong with it. */
    cns_code (*refuse)(void *context, int column, const char *why, cns_error *err);
} cns_rows;

typedef struct cns_compare_spec {
    const cns_rows *a, *b;
    const cns_number *delta; /* rational, > 0 */
    long decimals;           /* values that differ are counted if they agree to fewer; 0: none are */
    void *context;
    /* The columns that both tables have, before the first row; may be NULL. */
    void (*begin)(void *context, int n, const char *const *names);
    /* A common row: its time as A has it, the least decimals over the columns, and those of each column,
     * which may be CNS_COMPARE_NOTHING or CNS_COMPARE_MISSING, the least of all. */
    void (*row)(void *context, const char *t, long least, const long *each);
} cns_compare_spec;

/* Two values that were compared. */
typedef struct cns_compare_pair {
    char *t, *a, *b; /* the time as A has it, and the values; a or b NULL: missing */
    int column;
} cns_compare_pair;

typedef enum cns_compare_side { CNS_COMPARE_A, CNS_COMPARE_B, CNS_COMPARE_BOTH } cns_compare_side;

/* Something that was not compared, and where: rows that only A has, values that are missing in A. */
typedef struct cns_compare_gap {
    long count;
    char *first; /* time of the first; NULL: there are none */
} cns_compare_gap;

typedef struct cns_compare_result {
    int n;                   /* columns compared */
    char **name;             /* of each */
    bool *in_norm;           /* is it one of those whose distance is the norm */
    const char *model;       /* whose dynamic states these are; NULL: all columns are in the norm */
    char **tc, *norm_tc;     /* time of the row; NULL: there is none */
    char **last, *norm_last; /* the last row in which it could be told; NULL: in none */
    long rows_a, rows_b, common;
    cns_compare_pair first; /* that differ; t NULL: there are none */
    cns_compare_pair few;   /* the first that agree to fewer than spec->decimals; t NULL: there are none */
    long n_few;             /* how many there are */

    int n_only[2];           /* columns that only A or only B has */
    char **only[2];          /* their names */
    cns_compare_gap rows[2]; /* that only A or only B has */
    cns_compare_gap (
        *values)[3]; /* of each column compared, in common rows: missing in A alone, in B alone, in both */
} cns_compare_result;

/* CNS_USAGE: no common column, no common time, times that do not increase, a value that is no number. result
 * is to be cleared whatever is returned. */
cns_code cns_compare(const cns_compare_spec *spec, cns_compare_result *result, cns_error *err);
void cns_compare_result_clear(cns_compare_result *r);

bool cns_compare_whole(const cns_compare_result *r); /* is there nothing that was not compared? */

CNS_END_DECLS

#endif
