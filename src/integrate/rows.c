#include "rows.h"

#include <limits.h>
#include <stdlib.h>

#include "num/decimal_text.h"
#include "num/fraction.h"

bool cns_row_time(const cns_number *every, const cns_number *end, unsigned long row, mpq_t time)
{
    mpq_set_ui(time, row, 1);
    mpq_mul(time, time, every->ratio);
    if (mpq_cmp(time, end->ratio) < 0)
        return true;
    /* The end is a row, once: it is this one if the row before was not at the end yet. */
    mpq_sub(time, time, every->ratio);
    const bool first = row == 0 || mpq_cmp(time, end->ratio) < 0;
    mpq_set(time, end->ratio);
    return first;
}

long cns_last_multiple(const cns_number *every, const cns_number *end)
{
    mpq_t q;
    mpq_init(q);
    mpq_div(q, end->ratio, every->ratio);
    mpz_fdiv_q(mpq_numref(q), mpq_numref(q), mpq_denref(q));
    const long last = mpz_fits_slong_p(mpq_numref(q)) ? mpz_get_si(mpq_numref(q)) : LONG_MAX;
    mpq_clear(q);
    return last;
}

void cns_time_form_init(cns_time_form *f)
{
    mpz_init(f->denominator);
    f->decimals = 0;
    f->fractions = false;
}

static bool is_decimal(mpq_srcptr x)
{
    char *text = cns_text_exact(x);
    free(text);
    return text != NULL;
}

static void add_denominator(cns_time_form *f, mpz_srcptr denominator)
{
    if (mpz_cmp(denominator, f->denominator) <= 0)
        return;
    mpz_set(f->denominator, denominator);
    f->decimals = cns_fraction_decimals(f->denominator);
}

void cns_time_form_add(cns_time_form *f, mpq_srcptr time)
{
    f->fractions = f->fractions || !is_decimal(time);
    add_denominator(f, mpq_denref(time));
}

void cns_time_form_add_grid(cns_time_form *f, mpq_srcptr start, mpq_srcptr every)
{
    mpz_t common;
    mpz_init(common);
    mpz_lcm(common, mpq_denref(start), mpq_denref(every));
    f->fractions = f->fractions || !is_decimal(start) || !is_decimal(every);
    add_denominator(f, common);
    mpz_clear(common);
}

void cns_time_form_clear(cns_time_form *f)
{
    mpz_clear(f->denominator);
}

char *cns_time_text(const cns_time_form *f, mpq_srcptr time)
{
    char *text = cns_text_exact(time);
    return text != NULL ? text : cns_text_mpq(time, CNS_PLACES_DECIMALS, f->decimals);
}
