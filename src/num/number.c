#include "cns/number.h"

#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/text.h"

void cns_number_init(cns_number *x)
{
    x->text = cns_xcopy("0");
    mpq_init(x->ratio);
    x->pi_power = 0;
}

void cns_number_clear(cns_number *x)
{
    free(x->text);
    x->text = NULL;
    mpq_clear(x->ratio);
}

void cns_number_set(cns_number *x, const cns_number *y)
{
    if (x == y)
        return;
    free(x->text);
    x->text = cns_xcopy(y->text);
    mpq_set(x->ratio, y->ratio);
    x->pi_power = y->pi_power;
}

/* Reading. The value read so far is num/den * 10^exponent * pi^pi_power. */

typedef struct reader {
    const char *whole; /* for messages */
    const char *at;
    mpz_t num, den, factor;
    long exponent;  /* decimal: of the value so far */
    long magnitude; /* sum of the |exponents| read, so that a long product cannot grow without bound */
    int pi_power;
} reader;

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static void skip_spaces(reader *r)
{
    while (*r->at == ' ')
        r->at++;
}

static cns_code refuse(const reader *r, const char *why, cns_error *err)
{
    return cns_fail(err, CNS_USAGE, "'%s' is not a number: %s", cns_quote(r->whole).text, why);
}

static cns_code too_large(const reader *r, cns_error *err)
{
    return cns_fail(err, CNS_USAGE, "'%s' is out of range: decimal exponents may add up to %d at most",
                    cns_quote(r->whole).text, CNS_NUMBER_MAX_EXPONENT);
}

/* Habits of other programs and of keyboards, and what to write here. The first that the text goes on with
 * holds. */
static const struct habit {
    const char *text;
    bool after_digit; /* only right behind a digit */
    const char *cure;
} habits[] = {
    {",", true, "write a point for the decimal comma, as in 1.5"},
    {".", true, "one point is enough; thousands are not separated"},
    {"_", true, "digits are written without separators"},
    {"'", true, "digits are written without separators"},
    {" ", true, "no blanks inside a number"},
    {"\xC2\xA0", false, "it holds a no-break space (U+00A0); take it out"},
    {"\xE2\x80\xAF", false, "it holds a narrow no-break space (U+202F); take it out"},
    {"\xE2\x80\x89", false, "it holds a thin space (U+2009); take it out"},
    {"\xE2\x88\x92", false, "it holds the character U+2212; write the minus as a plain -"},
    {"\xE2\x80\x90", false, "it holds a typographic hyphen (U+2010); write the minus as a plain -"},
    {"\xE2\x80\x91", false, "it holds a typographic hyphen (U+2011); write the minus as a plain -"},
    {"\xE2\x80\x93", false, "it holds a dash (U+2013); write the minus as a plain -"},
    {"\xE2\x80\x94", false, "it holds a dash (U+2014); write the minus as a plain -"},
    {"\xC2\xB0", false, "angles are in radians: write degrees as 90*pi/180"},
    {"deg", false, "angles are in radians: write degrees as 90*pi/180"},
    {"\xCF\x80", false, "write pi in two letters"},
    {"Pi", false, "write pi in small letters"},
    {"PI", false, "write pi in small letters"},
    {"pi", true, "write * between factors, as in 2*pi"},
    {"**", false, "powers are not computed: write 1e-3, or the number itself"},
    {"^", false, "powers are not computed: write 1e-3, or the number itself"},
    {"+", false, "sums are not computed: write the number itself"},
    {"-", false, "differences are not computed: write the number itself"},
    {"d", true, "write the exponent with an e, as in 1e-3"},
    {"D", true, "write the exponent with an e, as in 1e-3"},
};

/* What is wrong at a place where a number cannot go on, or no factor can begin. */
static cns_code refuse_here(const reader *r, cns_error *err)
{
    const bool inside = r->at > r->whole, after_digit = inside && is_digit(r->at[-1]);
    for (const struct habit *h = habits; h < habits + sizeof habits / sizeof *habits; h++)
        if ((after_digit || !h->after_digit) && strncmp(r->at, h->text, strlen(h->text)) == 0)
            return refuse(r, h->cure, err);
    return refuse(r, "use decimals, fractions and pi, as in 2.2, 1e-30, 8/3, 2*pi/3", err);
}

/* What is wrong at a place where a factor should begin. */
static cns_code refuse_factor(const reader *r, cns_error *err)
{
    if (*r->at == '\0')
        return refuse(r, "it ends where a number or pi is expected", err);
    if (*r->at == '.' && is_digit(r->at[1]))
        return refuse(r, "a digit must stand before the point, as in 0.5", err);
    if (*r->at == '+' || *r->at == '-')
        return refuse(r, "only one sign is allowed, at the beginning", err);
    return refuse_here(r, err);
}

static cns_code read_factor(reader *r, bool divide, cns_error *err)
{
    if (r->at[0] == 'p' && r->at[1] == 'i') {
        r->at += 2;
        r->pi_power += divide ? -1 : 1;
        return CNS_OK;
    }
    if (!is_digit(*r->at))
        return refuse_factor(r, err);
    if (r->at[0] == '0' && (r->at[1] == 'x' || r->at[1] == 'X' || r->at[1] == 'b' || r->at[1] == 'o'))
        return refuse(r, "numbers are decimal here", err);
    if (r->at[0] == '0' && is_digit(r->at[1]))
        return refuse(r, "a leading zero could mean octal; leave it out", err);

    /* the digits without the point */
    char *digits = cns_xgrow(NULL, strlen(r->at) + 1, 1);
    size_t n = 0;
    long after_point = 0, exponent = 0;
    while (is_digit(*r->at))
        digits[n++] = *r->at++;
    if (*r->at == '.') {
        r->at++;
        if (!is_digit(*r->at)) {
            free(digits);
            return refuse(r, "a digit must follow the point", err);
        }
        while (is_digit(*r->at)) {
            digits[n++] = *r->at++;
            after_point++;
        }
    }
    digits[n] = '\0';
    mpz_set_str(r->factor, digits, 10);
    free(digits);

    if (*r->at == 'e' || *r->at == 'E') {
        r->at++;
        bool negative = *r->at == '-';
        if (*r->at == '+' || *r->at == '-')
            r->at++;
        if (!is_digit(*r->at))
            return *r->at != '\0' && (unsigned char)*r->at >= 0x80
                       ? refuse_here(r, err)
                       : refuse(r, "digits must follow the e of an exponent", err);
        while (is_digit(*r->at)) {
            exponent = 10 * exponent + (*r->at++ - '0');
            if (exponent > CNS_NUMBER_MAX_EXPONENT)
                return too_large(r, err);
        }
        r->magnitude += exponent;
        if (r->magnitude > CNS_NUMBER_MAX_EXPONENT)
            return too_large(r, err);
        if (negative)
            exponent = -exponent;
    }
    exponent -= after_point;
    r->exponent += divide ? -exponent : exponent;
    if (!divide)
        mpz_mul(r->num, r->num, r->factor);
    else if (mpz_sgn(r->factor) == 0)
        return cns_fail(err, CNS_USAGE, "'%s' divides by zero", cns_quote(r->whole).text);
    else
        mpz_mul(r->den, r->den, r->factor);
    return CNS_OK;
}

static cns_code read_value(reader *r, cns_error *err)
{
    skip_spaces(r);
    if (*r->at == '\0')
        return cns_fail(err, CNS_USAGE, "a number is missing");
    if (*r->at == '+' || *r->at == '-') {
        if (*r->at == '-')
            mpz_set_si(r->num, -1);
        r->at++;
    }
    bool divide = false;
    for (;;) {
        cns_code code = read_factor(r, divide, err);
        if (code != CNS_OK)
            return code;
        skip_spaces(r);
        if (*r->at == '\0')
            break;
        if ((*r->at != '*' && *r->at != '/') || r->at[1] == '*') {
            if (is_digit(*r->at) && r->at[-1] == ' ' && is_digit(r->at[-2]))
                r->at--; /* in 1 000 the mistake is the blank */
            return refuse_here(r, err);
        }
        divide = *r->at++ == '/';
        skip_spaces(r);
    }
    if (r->pi_power < -1 || r->pi_power > 1)
        return cns_fail(err, CNS_USAGE, "'%s': pi may come to the power 1, 0 or -1, not %d",
                        cns_quote(r->whole).text, r->pi_power);
    return CNS_OK;
}

cns_code cns_number_parse(cns_number *x, const char *text, cns_error *err)
{
    size_t length = strlen(text);
    if (length > CNS_NUMBER_MAX_TEXT)
        return cns_fail(err, CNS_USAGE, "a number of %zu characters; at most %d are read", length,
                        CNS_NUMBER_MAX_TEXT);
    reader r = {.whole = text, .at = text};
    mpz_inits(r.num, r.den, r.factor, (mpz_ptr)NULL);
    mpz_set_ui(r.num, 1);
    mpz_set_ui(r.den, 1);
    cns_code code = read_value(&r, err);
    if (code == CNS_OK) {
        if (mpz_sgn(r.num) != 0) {
            mpz_ui_pow_ui(r.factor, 10, (unsigned long)labs(r.exponent));
            mpz_ptr scaled = r.exponent > 0 ? r.num : r.den;
            mpz_mul(scaled, scaled, r.factor);
        } else {
            r.pi_power = 0; /* zero has one form */
        }
        mpz_swap(mpq_numref(x->ratio), r.num);
        mpz_swap(mpq_denref(x->ratio), r.den);
        mpq_canonicalize(x->ratio);
        x->pi_power = r.pi_power;
        /* the text may be x's own */
        const char *from = text + strspn(text, " ");
        size_t size = strlen(from);
        while (size > 0 && from[size - 1] == ' ')
            size--;
        char *kept = cns_xcopy_n(from, size);
        free(x->text);
        x->text = kept;
    }
    mpz_clears(r.num, r.den, r.factor, (mpz_ptr)NULL);
    return code;
}

/* y = ratio * pi^(+-1), with a relative error below 2^(2 - prec(y)): three roundings to nearest. */
static void multiply_by_pi(mpfr_t y, const cns_number *x)
{
    mpfr_t pi;
    mpfr_init2(pi, mpfr_get_prec(y));
    mpfr_const_pi(pi, MPFR_RNDN);
    mpfr_set_q(y, x->ratio, MPFR_RNDN);
    if (x->pi_power > 0)
        mpfr_mul(y, y, pi, MPFR_RNDN);
    else
        mpfr_div(y, y, pi, MPFR_RNDN);
    mpfr_clear(pi);
}

void cns_number_get_mpfr(mpfr_t y, const cns_number *x)
{
    if (x->pi_power == 0) {
        mpfr_set_q(y, x->ratio, MPFR_RNDN);
        return;
    }
    /* Ziv: more bits until the error cannot change the rounding; the value is irrational, so this ends. */
    mpfr_prec_t prec = mpfr_get_prec(y);
    mpfr_t t;
    mpfr_init2(t, prec + 16);
    for (mpfr_prec_t extra = 16;; extra *= 2) {
        mpfr_set_prec(t, prec + extra);
        multiply_by_pi(t, x);
        if (mpfr_can_round(t, prec + extra - 3, MPFR_RNDN, MPFR_RNDZ, prec + 1))
            break;
    }
    mpfr_set(y, t, MPFR_RNDN);
    mpfr_clear(t);
}

double cns_number_get_d(const cns_number *x)
{
    mpfr_t y;
    mpfr_init2(y, 53);
    cns_number_get_mpfr(y, x);
    double d = mpfr_get_d(y, MPFR_RNDN);
    mpfr_clear(y);
    return d;
}

int cns_number_sign(const cns_number *x)
{
    return mpq_sgn(x->ratio);
}

int cns_number_cmp(const cns_number *x, const cns_number *y)
{
    int sx = mpq_sgn(x->ratio), sy = mpq_sgn(y->ratio);
    if (sx != sy)
        return sx < sy ? -1 : 1;
    if (x->pi_power == y->pi_power) {
        int c = mpq_cmp(x->ratio, y->ratio);
        return (c > 0) - (c < 0);
    }
    if (sx == 0)
        return 0;
    /* Different powers of pi: never equal, so that enough bits tell them apart. */
    mpfr_t a, b;
    mpfr_init2(a, 64);
    mpfr_init2(b, 64);
    int c = 0;
    for (mpfr_prec_t prec = 64; c == 0; prec *= 2) {
        mpfr_set_prec(a, prec);
        mpfr_set_prec(b, prec);
        cns_number_get_mpfr(a, x);
        cns_number_get_mpfr(b, y);
        c = mpfr_cmp(a, b); /* rounding keeps order: unequal after it, unequal before it */
    }
    mpfr_clear(a);
    mpfr_clear(b);
    return (c > 0) - (c < 0);
}
