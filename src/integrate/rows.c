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

static bool is_decimal(const cns_number *x)
{
    char *text = cns_text_exact(x->ratio);
    free(text);
    return text != NULL;
}

void cns_time_form_init(cns_time_form *f, const cns_number *every, const cns_number *end)
{
    const bool between = cns_number_cmp(every, end) < 0; /* is there a row at `every`? */
    mpz_init(f->denominator);
    f->decimals = 0;
    if (is_decimal(end) && (!between || is_decimal(every)))
        return;
    mpz_set(f->denominator, mpq_denref(end->ratio));
    if (between && mpz_cmp(mpq_denref(every->ratio), f->denominator) > 0)
        mpz_set(f->denominator, mpq_denref(every->ratio));
    f->decimals = cns_fraction_decimals(f->denominator);
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
