#include "write_table.h"

#include <errno.h>
#include <stdlib.h>

#include "core/files.h"
#include "core/memory.h"
#include "integrate/rows.h"
#include "provenance.h"

struct cns_table {
    const cns_case *c;
    FILE *file;
    cns_file own; /* of a path; not standard output */
    bool begun, gone;
    long rows;
};

cns_table *cns_table_open(const char *path, FILE *out, const cns_case *c, cns_error *err)
{
    cns_table *t = cns_xalloc(1, sizeof *t);
    t->c = c;
    t->file = out;
    if (!path)
        return t;
    if (cns_file_create(&t->own, path, err)) {
        free(t);
        return NULL;
    }
    t->file = t->own.stream;
    return t;
}

static cns_code flush(cns_table *t, cns_error *err)
{
    errno = 0;
    if (fflush(t->file) == 0 && !ferror(t->file))
        return CNS_OK;
    const int cause = errno ? errno : EIO;
    t->gone = !t->own.path && cause == EPIPE;
    if (t->gone)
        return cns_fail(err, CNS_STOPPED, "the reader of standard output has gone");
    return cns_file_failed("write", t->own.path ? t->own.path : "to standard output", cause, err);
}

static void print_numerics(FILE *out, const cns_case *c, long digits, mpfr_prec_t prec, int order)
{
    bool rk4 = c->has_numerics && c->numerics.method == CNS_METHOD_RK4;
    if (digits > 0)
        fprintf(out, "%ld digits (%ld bits)", digits, (long)prec);
    else
        fprintf(out, "double (53 bits)");
    if (rk4)
        fprintf(out, ", classical Runge-Kutta method of order 4");
    else
        fprintf(out, ", Taylor series of order %d", order);
}

static void print_times(FILE *out, const cns_case *c)
{
    cns_time_form form;
    cns_time_form_init(&form);
    cns_time_form_add(&form, c->end.ratio);
    for (int i = 0; i < c->n_at; i++)
        cns_time_form_add(&form, c->at[i].ratio);
    if (c->at == NULL && cns_number_cmp(&c->every, &c->span) < 0)
        cns_time_form_add_grid(&form, c->start.ratio, c->every.ratio);
    else if (c->at == NULL)
        cns_time_form_add(&form, c->start.ratio);
    if (form.fractions)
        gmp_fprintf(out, "# " CNS_TABLE_TIMES "%Zd\n", form.denominator);
    cns_time_form_clear(&form);
}

void cns_table_print_names(FILE *out, const cns_case *c)
{
    for (int i = 0; i < c->n_columns; i++)
        fprintf(out, "%s,", cns_case_column_name(c, i));
    fprintf(out, "decimals,growth");
}

static void print_header(const cns_table *t)
{
    print_times(t->file, t->c);
    cns_table_print_names(t->file, t->c);
    fputc('\n', t->file);
}

cns_code cns_table_begin(cns_table *t, const cns_run_info *run, cns_error *err)
{
    const cns_case *c = t->c;
    FILE *out = t->file;
    if (!t->begun)
        cns_provenance_begin(out, c, "", CNS_PROVENANCE_WHOLE);
    fprintf(out, t->begun ? "# again, with: " : "# method: ");
    print_numerics(out, c, run->digits, run->prec, run->order);
    if (c->has_numerics && cns_number_sign(&c->numerics.step) > 0)
        fprintf(out, ", fixed step %s", c->numerics.step.text);
    if (run->proof_prec) {
        fprintf(out, "\n# proof: a second run of ");
        print_numerics(out, c, run->proof_digits, run->proof_prec, run->proof_order);
        fprintf(
            out,
            ", other steps;\n#   convergence under refinement, measured growth and pointwise derivatives; "
            "not interval arithmetic");
    }
    if (run->enclosed)
        fputs("\n# proof: an enclosure: the exact solution from the exact initial values, rounded to the "
              "places "
              "shown, is what\n#   is printed; a theorem, as far as this program's enclosures "
              "(src/integrate/tube.h "
              "says which files), MPFR, GMP\n#   and FLINT are right",
              out);
    fputc('\n', out);
    if (!t->begun) {
        if (!run->proof_prec && !run->enclosed)
            fprintf(out, "# UNPROVEN\n");
        fprintf(out, "# kernel: %s\n# libraries: MPFR %s, GMP %s\n", run->kernel, mpfr_get_version(),
                gmp_version);
        print_header(t);
    }
    t->begun = true;
    return flush(t, err);
}

void cns_table_print_row(FILE *out, const cns_case *c, const cns_row *row)
{
    for (int i = 0; i < c->n_columns; i++)
        fprintf(out, "%s,", row->text[i]);
    if (row->decimals >= 0)
        fprintf(out, "%ld", row->decimals);
    double growth = row->growth < 0 && row->growth > -0.0005 ? 0 : row->growth; /* no -0.000 */
    fprintf(out, ",%.3f\n", growth);
}

cns_code cns_table_row(cns_table *t, const cns_row *row, cns_error *err)
{
    cns_table_print_row(t->file, t->c, row);
    t->rows++;
    return flush(t, err);
}

cns_code cns_table_close(cns_table *t, const char *reason, char **kept, cns_error *err)
{
    cns_code code = CNS_OK;
    *kept = NULL;
    if (!t->begun) { /* stopped while the run was planned */
        cns_provenance_begin(t->file, t->c, "", CNS_PROVENANCE_WHOLE);
        print_header(t);
    }
    if (t->own.path) {
        code = cns_provenance_close(&t->own, t->rows > 0, reason, kept, err);
    } else {
        cns_provenance_end(t->file, reason);
        code = flush(t, err);
    }
    free(t);
    return code;
}

void cns_table_abandon(cns_table *t)
{
    if (t->own.path)
        cns_file_close(&t->own, false, NULL);
    free(t);
}

bool cns_table_reader_gone(const cns_table *t)
{
    return t->gone;
}
