#include "rows.h"

#include <limits.h>

#include "num/decimal_text.h"

static void multiple(const cns_number *every, unsigned long count, mpq_t time)
{
    mpq_set_ui(time, count, 1);
    mpq_mul(time, time, every->ratio);
}

bool cns_row_time(const cns_number *every, const cns_number *end, unsigned long row, mpq_t time)
{
    multiple(every, row, time);
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

char *cns_row_time_text(const cns_number *every, const cns_number *end, unsigned long row, long decimals)
{
    mpq_t time;
    mpq_init(time);
    multiple(every, row, time);
    const bool at_end = mpq_cmp(time, end->ratio) > 0;
    char *text = at_end ? cns_number_multiple_text(end, 1) : cns_number_multiple_text(every, row);
    if (!text)
        text = cns_text_mpq(at_end ? end->ratio : time, CNS_PLACES_DECIMALS, decimals > 6 ? decimals : 6);
    mpq_clear(time);
    return text;
}
