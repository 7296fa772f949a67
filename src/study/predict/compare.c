#include "cns/study/compare.h"

#include <mpfr.h>
#include <stdlib.h>
#include <string.h>

#include "cns/system.h"
#include "core/memory.h"
#include "core/text.h"
#include "num/exact_decimal.h"
#include "num/fraction.h"

enum { PREC = 64 };

/* A column that both tables have. */
typedef struct column {
    int a, b; /* its number in either */
    double scale;
} column;

typedef struct side {
    const cns_rows *rows;
    mpq_t time, before;
    cns_exact_decimal value;
    bool begun, more;
    long count;
    int *way; /* of both sides: 1, times increase; -1, they decrease; 0, not known yet */
} side;

typedef struct comparison {
    const cns_compare_spec *spec;
    cns_compare_result *r;
    side a, b;
    int way;
    column *column;
    long *each;
    mpz_t d, left, right;
    mpfr_t norm, term, power, delta;
} comparison;

static void side_init(side *s, const cns_rows *rows)
{
    *s = (side){.rows = rows};
    mpq_inits(s->time, s->before, (mpq_ptr)0);
    cns_exact_decimal_init(&s->value);
}

static void side_clear(side *s)
{
    mpq_clears(s->time, s->before, (mpq_ptr)0);
    cns_exact_decimal_clear(&s->value);
}

static bool is_quantity(const comparison *c, const cns_rows *rows, int i)
{
    const char *name = rows->name(rows->context, i);
    const bool about = !strcmp(name, "decimals") || !strcmp(name, "growth");
    return i != rows->time && name[0] != '\0' && !(about && (c->spec->a->ours || c->spec->b->ours));
}

static int find_column(const cns_rows *rows, const char *name)
{
    for (int i = 0; i < rows->n; i++)
        if (i != rows->time && !strcmp(rows->name(rows->context, i), name))
            return i;
    return -1;
}

static void add_name(char ***names, int *n, const char *name)
{
    *names = cns_xgrow(*names, (size_t)*n + 1, sizeof **names);
    (*names)[(*n)++] = cns_xcopy(name);
}

static cns_code match_columns(comparison *c, cns_error *err)
{
    const cns_rows *a = c->spec->a, *b = c->spec->b;
    cns_compare_result *r = c->r;
    const size_t room = (size_t)a->n;
    c->column = cns_xalloc(room, sizeof *c->column);
    c->each = cns_xalloc(room, sizeof *c->each);
    r->in_norm = cns_xalloc(room, sizeof *r->in_norm);
    r->tc = cns_xalloc(room, sizeof *r->tc);
    r->last = cns_xalloc(room, sizeof *r->last);
    r->values = cns_xalloc(room, sizeof *r->values);
    for (int i = 0; i < a->n; i++) {
        const char *name = a->name(a->context, i);
        const int j = find_column(b, name);
        if (!is_quantity(c, a, i))
            continue;
        if (j < 0) {
            add_name(&r->only[CNS_COMPARE_A], &r->n_only[CNS_COMPARE_A], name);
            continue;
        }
        c->column[r->n] = (column){.a = i, .b = j, .scale = 1};
        add_name(&r->name, &r->n, name);
    }
    for (int j = 0; j < b->n; j++)
        if (is_quantity(c, b, j) && find_column(a, b->name(b->context, j)) < 0)
            add_name(&r->only[CNS_COMPARE_B], &r->n_only[CNS_COMPARE_B], b->name(b->context, j));
    if (r->n == 0)
        return cns_fail(err, CNS_USAGE, "the two tables have no column in common but the time");
    return CNS_OK;
}

/* Where the tables name a model, both the same or only one of them, its dynamic states make the norm; else,
 * or without any of those, all columns do. */
static cns_code choose_norm(comparison *c, cns_error *err)
{
    const char *a = c->spec->a->model, *b = c->spec->b->model;
    cns_compare_result *r = c->r;
    const cns_model *m = a && b && strcmp(a, b) != 0 ? NULL
                         : a                         ? cns_model_find(a)
                         : b                         ? cns_model_find(b)
                                                     : NULL;
    bool any = false;
    if (m) {
        cns_system *system = cns_system_new(m, NULL, NULL, NULL, err);
        if (!system)
            return err->code;
        for (int k = 0; k < r->n; k++)
            for (int i = 0; i < m->n_states; i++)
                if (!strcmp(r->name[k], m->states[i].name) &&
                    cns_program_is_dynamic(cns_system_program(system), i)) {
                    r->in_norm[k] = any = true;
                    c->column[k].scale = m->states[i].scale;
                }
        cns_system_free(system);
        if (any)
            r->model = m->name;
    }
    for (int k = 0; k < r->n && !any; k++)
        r->in_norm[k] = true;
    return CNS_OK;
}

/* NULL when x is the time that a text stands for, else what is wrong with it. */
static const char *read_time(side *s, mpq_t x, const char *text)
{
    const char *why = text ? cns_exact_decimal_parse(&s->value, text) : "a time is missing";
    if (why)
        return why;
    if (!s->rows->denominator) {
        cns_exact_decimal_get_mpq(x, &s->value);
        return NULL;
    }
    mpq_t printed;
    mpq_init(printed);
    cns_exact_decimal_get_mpq(printed, &s->value);
    cns_fraction_nearest(x, printed, s->rows->denominator);
    mpq_clear(printed);
    return NULL;
}

static const char *time_text(const side *s)
{
    return s->rows->text(s->rows->context, s->rows->time);
}

/* To the next row, and its time. */
static cns_code advance(side *s, cns_error *err)
{
    const cns_rows *rows = s->rows;
    mpq_swap(s->before, s->time);
    cns_code code = rows->next(rows->context, &s->more, err);
    if (code || !s->more)
        return code;
    const char *why = read_time(s, s->time, time_text(s));
    if (!why && s->begun) {
        const int way = mpq_cmp(s->time, s->before) > 0 ? 1 : mpq_cmp(s->time, s->before) < 0 ? -1 : 0;
        *s->way = *s->way != 0 ? *s->way : way;
        if (way == 0 || way != *s->way)
            why = *s->way < 0 ? "times must go on decreasing" : "times must increase";
    }
    if (why)
        return rows->refuse(rows->context, rows->time, why, err);
    s->begun = true;
    s->count++;
    return CNS_OK;
}

/* The value in column i; *text NULL: it is missing. */
static cns_code read_value(side *s, int i, const char **text, cns_error *err)
{
    const cns_rows *rows = s->rows;
    *text = rows->text(rows->context, i);
    const char *why = *text ? cns_exact_decimal_parse(&s->value, *text) : NULL;
    return why ? rows->refuse(rows->context, i, why, err) : CNS_OK;
}

/* |d| 10^e > delta |b|, exactly; e is not above b's exponent. */
static bool beyond_delta(comparison *c, long e, const cns_exact_decimal *b)
{
    const cns_number *delta = c->spec->delta;
    mpz_ui_pow_ui(c->left, 10, (unsigned long)(b->exponent - e));
    mpz_mul(c->right, b->digits, c->left);
    mpz_mul(c->right, c->right, mpq_numref(delta->ratio));
    mpz_mul(c->left, c->d, mpq_denref(delta->ratio));
    return mpz_cmpabs(c->left, c->right) > 0;
}

/* Adds d 10^e / scale to the norm. */
static void add_to_norm(comparison *c, long e, double scale)
{
    mpfr_set_z(c->term, c->d, MPFR_RNDN);
    mpfr_ui_pow_ui(c->power, 10, (unsigned long)labs(e), MPFR_RNDN);
    if (e < 0)
        mpfr_div(c->term, c->term, c->power, MPFR_RNDN);
    else
        mpfr_mul(c->term, c->term, c->power, MPFR_RNDN);
    mpfr_div_d(c->term, c->term, scale, MPFR_RNDN);
    mpfr_hypot(c->norm, c->norm, c->term, MPFR_RNDN);
}

/* Keeps the first pair. */
static void note_pair(cns_compare_pair *p, int k, const char *t, const char *a, const char *b)
{
    if (p->t)
        return;
    p->column = k;
    p->t = cns_xcopy(t);
    p->a = a ? cns_xcopy(a) : NULL;
    p->b = b ? cns_xcopy(b) : NULL;
}

static void add_gap(cns_compare_gap *gap, const char *t)
{
    if (gap->count++ == 0)
        gap->first = cns_xcopy(t);
}

static void set_text(char **to, const char *text)
{
    free(*to);
    *to = cns_xcopy(text);
}

static long decimals_of(const cns_exact_decimal *x)
{
    return -x->exponent;
}

/* Column k in a row of time t, a and b being its values, of which one at least is missing. */
static void leave_out(comparison *c, int k, const char *t, const char *a, const char *b)
{
    cns_compare_result *r = c->r;
    add_gap(&r->values[k][a ? CNS_COMPARE_B : b ? CNS_COMPARE_A : CNS_COMPARE_BOTH], t);
    c->each[k] = a || b ? CNS_COMPARE_MISSING : CNS_COMPARE_NOTHING;
    if (a || b)
        note_pair(&r->first, k, t, a, b);
}

/* The same with two values, c->a.value and c->b.value. Does it set a limit to the decimals of the row? */
static bool compare_values(comparison *c, int k, const char *t, const char *a, const char *b)
{
    cns_compare_result *r = c->r;
    const long da = decimals_of(&c->a.value), db = decimals_of(&c->b.value), shorter = da < db ? da : db;
    const long e = cns_exact_decimal_difference(c->d, &c->a.value, &c->b.value);
    c->each[k] = shorter;
    set_text(&r->last[k], t);
    if (mpz_sgn(c->d) == 0)
        return false;
    const long agreed = cns_exact_decimal_agreed(c->d, e);
    if (agreed < shorter) {
        c->each[k] = agreed;
        note_pair(&r->first, k, t, a, b);
    }
    if (c->each[k] < c->spec->decimals) {
        r->n_few++;
        note_pair(&r->few, k, t, a, b);
    }
    if (!r->tc[k] && beyond_delta(c, e, &c->b.value))
        r->tc[k] = cns_xcopy(t);
    if (r->in_norm[k] && !r->norm_tc)
        add_to_norm(c, e, c->column[k].scale);
    return true;
}

/* Both sides are at rows of the same time. */
static cns_code compare_row(comparison *c, cns_error *err)
{
    cns_compare_result *r = c->r;
    const char *t = time_text(&c->a);
    long least = LONG_MAX, given = CNS_COMPARE_NOTHING;
    bool whole = true; /* no value of the norm is missing */
    mpfr_set_zero(c->norm, 1);
    for (int k = 0; k < r->n; k++) {
        const char *a, *b;
        cns_code code = read_value(&c->a, c->column[k].a, &a, err);
        if (!code)
            code = read_value(&c->b, c->column[k].b, &b, err);
        if (code)
            return code;
        bool limits = (a != NULL) != (b != NULL);
        if (a && b) {
            limits = compare_values(c, k, t, a, b);
        } else {
            leave_out(c, k, t, a, b);
            whole = whole && !r->in_norm[k];
        }
        if (limits && c->each[k] < least)
            least = c->each[k];
        if (c->each[k] > given)
            given = c->each[k];
    }
    if (!r->norm_tc && mpfr_cmp(c->norm, c->delta) > 0) /* of a part, if values are missing, and so of all */
        r->norm_tc = cns_xcopy(t);
    if (whole)
        set_text(&r->norm_last, t);
    r->common++;
    c->spec->row(c->spec->context, t, least < LONG_MAX ? least : given, c->each);
    return CNS_OK;
}

/* From a row without a partner to the next: its values are only read, since a table that is broken anywhere
 * is not to be trusted. */
static cns_code skip(comparison *c, side *s, cns_error *err)
{
    const bool in_a = s == &c->a;
    cns_code code = CNS_OK;
    const char *text;
    add_gap(&c->r->rows[in_a ? CNS_COMPARE_A : CNS_COMPARE_B], time_text(s));
    for (int k = 0; k < c->r->n && !code; k++)
        code = read_value(s, in_a ? c->column[k].a : c->column[k].b, &text, err);
    return code ? code : advance(s, err);
}

static cns_code merge(comparison *c, cns_error *err)
{
    cns_code code = advance(&c->a, err);
    if (!code)
        code = advance(&c->b, err);
    while (!code && (c->a.more || c->b.more)) {
        int order = !c->b.more ? -1 : !c->a.more ? 1 : mpq_cmp(c->a.time, c->b.time);
        if (c->a.more && c->b.more && order != 0) {
            c->way = c->way != 0 ? c->way : 1; /* tables against time begin at the same one */
            order *= c->way;
        }
        if (order != 0) {
            code = skip(c, order < 0 ? &c->a : &c->b, err);
            continue;
        }
        code = compare_row(c, err);
        if (!code)
            code = advance(&c->a, err);
        if (!code)
            code = advance(&c->b, err);
    }
    return code;
}

cns_code cns_compare(const cns_compare_spec *spec, cns_compare_result *result, cns_error *err)
{
    comparison c = {.spec = spec, .r = result};
    *result = (cns_compare_result){0};
    side_init(&c.a, spec->a);
    side_init(&c.b, spec->b);
    c.a.way = c.b.way = &c.way;
    mpz_inits(c.d, c.left, c.right, (mpz_ptr)0);
    mpfr_inits2(PREC, c.norm, c.term, c.power, c.delta, (mpfr_ptr)0);
    cns_number_get_mpfr(c.delta, spec->delta);
    cns_code code = match_columns(&c, err);
    if (!code)
        code = choose_norm(&c, err);
    if (!code && spec->begin)
        spec->begin(spec->context, result->n, (const char *const *)result->name);
    if (!code)
        code = merge(&c, err);
    result->rows_a = c.a.count;
    result->rows_b = c.b.count;
    if (!code && result->common == 0)
        code = cns_fail(err, CNS_USAGE,
                        "the two tables have no time in common (%ld and %ld rows): nothing is interpolated",
                        c.a.count, c.b.count);
    side_clear(&c.a);
    side_clear(&c.b);
    mpz_clears(c.d, c.left, c.right, (mpz_ptr)0);
    mpfr_clears(c.norm, c.term, c.power, c.delta, (mpfr_ptr)0);
    free(c.column);
    free(c.each);
    return code;
}

static bool is_empty(const cns_compare_gap *gap, int n)
{
    for (int i = 0; i < n; i++)
        if (gap[i].count > 0)
            return false;
    return true;
}

bool cns_compare_whole(const cns_compare_result *r)
{
    bool whole = r->n_only[CNS_COMPARE_A] == 0 && r->n_only[CNS_COMPARE_B] == 0 && is_empty(r->rows, 2);
    for (int k = 0; k < r->n; k++)
        whole = whole && is_empty(r->values[k], 3);
    return whole;
}

static void free_texts(char **text, int n)
{
    for (int i = 0; text && i < n; i++)
        free(text[i]);
    free(text);
}

static void clear_pair(cns_compare_pair *p)
{
    free(p->t);
    free(p->a);
    free(p->b);
}

void cns_compare_result_clear(cns_compare_result *r)
{
    for (int i = CNS_COMPARE_A; i <= CNS_COMPARE_B; i++) {
        free_texts(r->only[i], r->n_only[i]);
        free(r->rows[i].first);
    }
    for (int k = 0; k < r->n; k++)
        for (int where = 0; where < 3; where++)
            free(r->values[k][where].first);
    free(r->values);
    free_texts(r->name, r->n);
    free_texts(r->tc, r->n);
    free_texts(r->last, r->n);
    free(r->in_norm);
    free(r->norm_tc);
    free(r->norm_last);
    clear_pair(&r->first);
    clear_pair(&r->few);
    *r = (cns_compare_result){0};
}
