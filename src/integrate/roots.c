#include "roots.h"

#include "num/vector.h"

/* Isolation on [0,1] at one precision. */
typedef struct search {
    int degree;
    mpfr_prec_t bits;
    int depth_limit;
    mpfr_t noise; /* bound on the error of every Bernstein coefficient, hence of p on the interval */
    mpfr_t scratch;
    int sign;      /* of p on the arc, before any root */
    bool doubtful; /* p is within the noise since `from` */
    bool was_doubtful;
    mpfr_t from, to; /* the isolating interval, once found */
    bool out_of_memory;
} search;

/* Sign of x if it exceeds the noise, else 0. */
static int definite_sign(const search *s, const mpfr_t x)
{
    return mpfr_cmpabs(x, s->noise) <= 0 ? 0 : mpfr_sgn(x);
}

/* All definite and of one sign? Returns it, or 0. */
static int one_sign(const search *s, mpfr_t *b)
{
    int first = definite_sign(s, b[0]);
    for (int i = 1; first && i <= s->degree; i++)
        if (definite_sign(s, b[i]) != first)
            return 0;
    return first;
}

/* Are all differences of neighbours definite and of one sign: is p monotone? The noise of a difference is
 * twice that of a coefficient. */
static bool monotone(search *s, mpfr_t *b)
{
    int first = 0;
    for (int i = 0; i < s->degree; i++) {
        mpfr_sub(s->scratch, b[i + 1], b[i], MPFR_RNDN);
        mpfr_div_2ui(s->scratch, s->scratch, 1, MPFR_RNDN);
        int sign = definite_sign(s, s->scratch);
        if (!sign || (first && sign != first))
            return false;
        first = sign;
    }
    return true;
}

static bool within_noise(const search *s, mpfr_t *b)
{
    for (int i = 0; i <= s->degree; i++)
        if (definite_sign(s, b[i]))
            return false;
    return true;
}

static void doubt(search *s, const mpfr_t left)
{
    if (!s->doubtful)
        mpfr_set(s->from, left, MPFR_RNDN);
    s->doubtful = s->was_doubtful = true;
}

static bool visit(search *s, mpfr_t *b, const mpfr_t left, int depth);

/* Halves the interval (de Casteljau: averages, so the noise does not grow) and visits both halves. */
static bool visit_halves(search *s, mpfr_t *b, const mpfr_t left, int depth)
{
    int n = s->degree;
    mpfr_t *l = cns_vector_new(n + 1, s->bits);
    if (!l) {
        s->out_of_memory = true;
        return true;
    }
    mpfr_t middle;
    mpfr_init2(middle, mpfr_get_prec(s->from));
    mpfr_set_ui_2exp(middle, 1, -(mpfr_exp_t)depth - 1, MPFR_RNDN);
    mpfr_add(middle, middle, left, MPFR_RNDN);
    for (int j = 0; j <= n; j++) {
        mpfr_set(l[j], b[0], MPFR_RNDN);
        for (int i = 0; i < n - j; i++) {
            mpfr_add(b[i], b[i], b[i + 1], MPFR_RNDN);
            mpfr_div_2ui(b[i], b[i], 1, MPFR_RNDN);
        }
    }
    bool done = visit(s, l, left, depth + 1) || visit(s, b, middle, depth + 1);
    mpfr_clear(middle);
    cns_vector_free(l);
    return done;
}

/* Visits [left, left + 2^-depth], where p has the Bernstein coefficients b, which it spoils. Intervals
 * come from left to right. True when the first sign change is in [from, to], or memory ran out. */
static bool visit(search *s, mpfr_t *b, const mpfr_t left, int depth)
{
    int sign = one_sign(s, b);
    if (sign == s->sign) {
        s->doubtful = false; /* if it was in the noise, it only touched zero */
        return false;
    }
    if (sign == -s->sign) { /* it crossed in the noise just passed */
        if (!s->doubtful)
            mpfr_set(s->from, left, MPFR_RNDN);
        mpfr_set(s->to, left, MPFR_RNDN);
        return true;
    }
    if (definite_sign(s, b[0]) == s->sign && definite_sign(s, b[s->degree]) == -s->sign && monotone(s, b)) {
        mpfr_set(s->from, left, MPFR_RNDN);
        mpfr_set_ui_2exp(s->to, 1, -(mpfr_exp_t)depth, MPFR_RNDN);
        mpfr_add(s->to, s->to, left, MPFR_RNDN);
        return true;
    }
    if (depth >= s->depth_limit || within_noise(s, b)) {
        doubt(s, left);
        return false;
    }
    return visit_halves(s, b, left, depth);
}

/* The Bernstein coefficients on [0,1] of sum a_k u^k, truncated where the tail is below the precision:
 * b_i = sum_{k<=i} C(i,k)/C(n,k) a_k. Sets the degree and the noise. */
static mpfr_t *bernstein(search *s, mpfr_t *a, int degree)
{
    mpfr_t total, tail, level, x;
    mpfr_inits2(64, total, tail, level, x, (mpfr_ptr)0);
    mpfr_set_zero(total, 1);
    mpfr_set_zero(tail, 1);
    for (int k = 0; k <= degree; k++) {
        mpfr_abs(x, a[k], MPFR_RNDU);
        mpfr_add(total, total, x, MPFR_RNDU);
    }
    mpfr_div_2ui(level, total, (unsigned long)s->bits, MPFR_RNDU);
    for (s->degree = degree; s->degree > 1; s->degree--) {
        mpfr_abs(x, a[s->degree], MPFR_RNDU);
        mpfr_add(x, x, tail, MPFR_RNDU);
        if (mpfr_cmp(x, level) > 0)
            break;
        mpfr_set(tail, x, MPFR_RNDU);
    }
    /* Every b_i is a sum of n rounded terms below `total` after n rounds of additions; each of the at most
     * bits/2 halvings rounds n times more. */
    unsigned long n = (unsigned long)s->degree + 4;
    mpfr_mul_ui(s->noise, level, n * (n + (unsigned long)s->bits), MPFR_RNDU);
    mpfr_add(s->noise, s->noise, tail, MPFR_RNDU);

    mpfr_t *b = cns_vector_new(s->degree + 1, s->bits);
    if (b) {
        mpfr_set_prec(x, s->bits + 32);
        mpfr_set_ui(x, 1, MPFR_RNDN); /* C(n,k) */
        for (int k = 0; k <= s->degree; k++) {
            mpfr_div(b[k], a[k], x, MPFR_RNDN);
            mpfr_mul_ui(x, x, (unsigned long)(s->degree - k), MPFR_RNDN);
            mpfr_div_ui(x, x, (unsigned long)k + 1, MPFR_RNDN);
        }
        for (int j = 1; j <= s->degree; j++)
            for (int i = s->degree; i >= j; i--)
                mpfr_add(b[i], b[i], b[i - 1], MPFR_RNDN);
    }
    mpfr_clears(total, tail, level, x, (mpfr_ptr)0);
    return b;
}

/* Isolates the first sign change of sum a_k u^k on (0,1] in [from, to], working with so many bits. *decided
 * is false if p came within the noise on the way, where more bits would tell more. */
static cns_code isolate(mpfr_t from, mpfr_t to, bool *found, bool *decided, mpfr_t *a, int degree,
                        mpfr_prec_t bits, cns_error *err)
{
    search s = {.bits = bits, .depth_limit = (int)bits, .sign = mpfr_sgn(a[0])};
    mpfr_t origin;
    mpfr_init2(s.noise, 64);
    mpfr_init2(s.scratch, bits);
    mpfr_inits2(2 * bits + 64, s.from, s.to, origin, (mpfr_ptr)0);
    mpfr_set_zero(origin, 1);
    mpfr_t *b = bernstein(&s, a, degree);
    *found = b && visit(&s, b, origin, 0);
    *decided = !s.was_doubtful;
    mpfr_set(from, s.from, MPFR_RNDN);
    mpfr_set(to, s.to, MPFR_RNDN);
    bool failed = !b || s.out_of_memory;
    cns_vector_free(b);
    mpfr_clears(s.noise, s.scratch, s.from, s.to, origin, (mpfr_ptr)0);
    return failed ? cns_out_of_memory(err) : CNS_OK;
}

/* Newton's method on sum a_k u^k from the middle of [from, to], kept inside by bisection. */
static void polish(mpfr_t u, mpfr_t *a, int degree, mpfr_t from, mpfr_t to)
{
    const mpfr_prec_t prec = mpfr_get_prec(u);
    mpfr_t p, dp, step;
    int sign = mpfr_sgn(a[0]);
    mpfr_inits2(prec, p, dp, step, (mpfr_ptr)0);
    mpfr_add(u, from, to, MPFR_RNDN);
    mpfr_div_2ui(u, u, 1, MPFR_RNDN);
    for (long turn = 0; turn < 4 * (long)prec && mpfr_cmp(from, to) < 0; turn++) {
        mpfr_set(p, a[degree], MPFR_RNDN);
        mpfr_set_zero(dp, 1);
        for (int k = degree - 1; k >= 0; k--) {
            mpfr_mul(dp, dp, u, MPFR_RNDN);
            mpfr_add(dp, dp, p, MPFR_RNDN);
            mpfr_mul(p, p, u, MPFR_RNDN);
            mpfr_add(p, p, a[k], MPFR_RNDN);
        }
        if (mpfr_zero_p(p))
            break;
        if (mpfr_sgn(p) == sign)
            mpfr_set(from, u, MPFR_RNDN);
        else
            mpfr_set(to, u, MPFR_RNDN);
        bool newton = !mpfr_zero_p(dp);
        if (newton) {
            mpfr_div(step, p, dp, MPFR_RNDN);
            if (!mpfr_zero_p(step) && mpfr_get_exp(step) < mpfr_get_exp(u) - (mpfr_exp_t)prec + 2)
                break;
            mpfr_sub(step, u, step, MPFR_RNDN);
            newton = mpfr_cmp(step, from) > 0 && mpfr_cmp(step, to) < 0;
        }
        if (!newton) {
            mpfr_add(step, from, to, MPFR_RNDN);
            mpfr_div_2ui(step, step, 1, MPFR_RNDN);
            if (mpfr_equal_p(step, u))
                break;
        }
        mpfr_set(u, step, MPFR_RNDN);
    }
    mpfr_clears(p, dp, step, (mpfr_ptr)0);
}

cns_code cns_first_root(mpfr_t root, bool *found, mpfr_t *p, int degree, const mpfr_t h, cns_error *err)
{
    const mpfr_prec_t prec = mpfr_get_prec(root) + 16;
    cns_code code = CNS_OK;
    mpfr_t power, from, to, u;
    mpfr_t *a = cns_vector_new(degree + 1, prec);
    if (!a)
        return cns_out_of_memory(err);
    mpfr_inits2(prec, power, u, (mpfr_ptr)0);
    mpfr_inits2(2 * prec + 64, from, to, (mpfr_ptr)0);
    mpfr_set_ui(power, 1, MPFR_RNDN);
    for (int k = 0; k <= degree; k++) { /* to the interval (0, 1] */
        mpfr_mul(a[k], p[k], power, MPFR_RNDN);
        mpfr_mul(power, power, h, MPFR_RNDN);
    }
    bool decided = false;
    for (mpfr_prec_t bits = 96; !decided && !code; bits *= 4) {
        bool last = bits >= prec;
        code = isolate(from, to, found, &decided, a, degree, last ? prec : bits, err);
        decided = decided || last;
    }
    if (!code && *found) {
        polish(u, a, degree, from, to);
        mpfr_mul(root, u, h, MPFR_RNDN);
    }
    mpfr_clears(power, from, to, u, (mpfr_ptr)0);
    cns_vector_free(a);
    return code;
}
