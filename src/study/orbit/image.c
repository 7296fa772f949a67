#include "image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cns/number.h"
#include "core/memory.h"

enum { MOST_IMAGES = 64, MOST_ORDER = 64 };

int cns_images_turns(const cns_images *s)
{
    return s->model->motion != NULL ? s->model->motion->turns : 1;
}

static long modulo(long a, long n)
{
    return (a % n + n) % n;
}

static int angle_sign(const cns_images *s, const cns_image *a)
{
    return s->model->motion != NULL ? a->sign[s->model->motion->angle] : 1;
}

static bool same(const cns_images *s, const cns_image *a, const cns_image *b)
{
    return a->turns == b->turns && memcmp(a->sign, b->sign, (size_t)s->model->n_states) == 0;
}

/* Adds an image unless it is there. Takes its sign. */
static void add(cns_images *s, cns_image a)
{
    a.turns = modulo(a.turns, cns_images_turns(s));
    bool known = s->n == MOST_IMAGES;
    for (int i = 0; i < s->n && !known; i++)
        known = same(s, &s->item[i], &a);
    if (known)
        free(a.sign);
    else
        s->item[s->n++] = a;
}

static cns_image image(const cns_images *s, const signed char *sign, long turns, const char *name)
{
    const size_t n = (size_t)s->model->n_states;
    cns_image a = {.sign = cns_xalloc(n, 1), .turns = turns};
    for (size_t i = 0; i < n; i++)
        a.sign[i] = sign != NULL ? sign[i] : 1;
    snprintf(a.name, sizeof a.name, "%s", name);
    return a;
}

/* b, then a. */
static cns_image product(const cns_images *s, const cns_image *a, const cns_image *b)
{
    cns_image c = image(s, a->sign, a->turns + angle_sign(s, a) * b->turns, "");
    for (int i = 0; i < s->model->n_states; i++)
        c.sign[i] = (signed char)(c.sign[i] * b->sign[i]);
    snprintf(c.name, sizeof c.name, "%.60s and %.60s", b->name, a->name);
    return c;
}

/* The turns that a symmetry adds to the angle. False: it shifts something else, or by no such turns. */
static bool whole_turns(const cns_images *s, const cns_model_symmetry *y, long *turns)
{
    const cns_model_motion *m = s->model->motion;
    cns_error err;
    cns_number x;
    bool whole = true;
    *turns = 0;
    cns_number_init(&x);
    for (int i = 0; i < s->model->n_states && whole; i++) {
        if (y->shift[i] == NULL || cns_number_parse(&x, y->shift[i], &err) || cns_number_sign(&x) == 0)
            continue;
        whole = m != NULL && i == m->angle && x.pi_power == 1;
        if (!whole)
            break;
        mpz_mul_si(mpq_numref(x.ratio), mpq_numref(x.ratio), m->turns);
        mpz_mul_ui(mpq_denref(x.ratio), mpq_denref(x.ratio), 2);
        mpq_canonicalize(x.ratio);
        whole = mpz_cmp_ui(mpq_denref(x.ratio), 1) == 0 && mpz_fits_slong_p(mpq_numref(x.ratio));
        *turns = whole ? mpz_get_si(mpq_numref(x.ratio)) : 0;
    }
    cns_number_clear(&x);
    return whole;
}

void cns_images_open(cns_images *s, const cns_model *model)
{
    const cns_model_motion *m = model->motion;
    long turns;
    *s = (cns_images){.model = model, .item = cns_xalloc(MOST_IMAGES, sizeof *s->item)};
    add(s, image(s, NULL, 0, ""));
    for (int i = 0; i < model->n_symmetries; i++)
        if (whole_turns(s, &model->symmetries[i], &turns))
            add(s, image(s, model->symmetries[i].sign, turns, model->symmetries[i].name));
    if (m != NULL)
        add(s, image(s, m->turn_sign, 1, "turn"));
    if (m != NULL && m->mirror_sign != NULL)
        add(s, image(s, m->mirror_sign, 0, "mirror"));
    for (int i = 1; i < s->n; i++)
        for (int j = 1; j <= i && s->n < MOST_IMAGES; j++)
            add(s, product(s, &s->item[i], &s->item[j]));
}

void cns_images_close(cns_images *s)
{
    for (int i = 0; i < s->n; i++)
        free(s->item[i].sign);
    free(s->item);
    *s = (cns_images){0};
}

int cns_image_order(const cns_images *s, const cns_image *a, long turns, long *winding)
{
    const int n = cns_images_turns(s);
    cns_image power = image(s, a->sign, turns, "");
    int order = 1;
    bool back = false;
    while (!back && order < MOST_ORDER) {
        back = modulo(power.turns, n) == 0;
        for (int i = 0; i < s->model->n_states; i++)
            back = back && power.sign[i] > 0;
        if (back)
            break;
        power.turns = turns + angle_sign(s, a) * power.turns;
        for (int i = 0; i < s->model->n_states; i++)
            power.sign[i] = (signed char)(power.sign[i] * a->sign[i]);
        order++;
    }
    *winding = power.turns / n;
    free(power.sign);
    return order;
}
