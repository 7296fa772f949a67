/* Compiling an order (fixed.h): its trace becomes a list of steps, for the block exponents as they are. The
 * functions here, one for each primitive, follow what those of order_by_calls.h do to the accumulator's
 * exponent and load, without its value: what they decide by exponents and loads is decided here, once. What
 * they decide by a value cannot be, and is not compiled. */
#include <stdlib.h>

#include "fixed.h"

/* To take the bias off products that share the lanes, sums of u of their operands are added up: two for a
 * convolution, a double one for a square. So many of them, each of a load of 4 * 17 (correct(),
 * order_by_calls.h), need no carry: they stay below FX_CORR_LOAD. */
enum { MOST_SUMS = 10 };

typedef struct state {
    fx *F;
    const cns_trace *trace;
    int k;
    int group; /* the call that began the sum */

    /* Of the accumulator. Exponents are those at order 0: those of order k are all lower by d k. */
    bool empty, normal;
    int load;
    long exp;

    /* Products that wait in the lanes until they are added, for others that can share them. */
    fx_step product[MOST_SUMS];
    int products, sums;
    long lanes_exp;
} state;

static bool append(fx *F, const fx_step *step)
{
    fx_compiled *C = &F->compiled;
    if (C->n == C->capacity) {
        const int capacity = 2 * C->capacity + 64;
        fx_step *grown = realloc(C->step, (size_t)capacity * sizeof *grown);
        if (grown == NULL)
            return false;
        C->step = grown;
        C->capacity = capacity;
    }
    C->step[C->n++] = *step;
    return true;
}

/* A step that adds a number with this exponent, as add() of order_by_calls.h does. */
static bool add(state *s, fx_step step, long exp)
{
    step.group = s->group;
    const long shift = exp - s->exp;
    if (s->empty) {
        step.fresh = true;
        s->empty = false;
        s->load = 1;
        s->exp = exp;
        s->normal = step.flip == 0;
        return append(s->F, &step);
    }
    if (shift >= 0 && shift <= 7) {
        step.carry = s->load + (1 << shift) > FX_MAX_LOAD;
        step.up_x = (int)shift;
        s->load = (step.carry ? 1 : s->load) + (1 << shift);
    } else if (shift < 0 && shift >= -7) {
        step.carry = (s->load << -shift) + 1 > FX_MAX_LOAD;
        step.up = (int)-shift;
        s->load = ((step.carry ? 1 : s->load) << -shift) + 1;
        s->exp = exp;
    } else if (shift < 0) {
        step.down_x = -shift;
        step.carry = s->load + 1 > FX_MAX_LOAD;
        s->load = (step.carry ? 1 : s->load) + 1;
    } else {
        step.carry = !s->normal;
        step.down = shift;
        s->load = 2;
        s->exp = exp;
    }
    s->normal = false;
    return append(s->F, &step);
}

/* The products that wait are added. */
static bool flush(state *s)
{
    const int n = s->products;
    s->products = s->sums = 0;
    for (int i = 0; i < n; i++) {
        fx_step *step = &s->product[i];
        step->open = i == 0;
        step->close = i == n - 1;
        step->group = s->group;
        if (step->close ? !add(s, *step, s->lanes_exp) : !append(s->F, step))
            return false;
    }
    return true;
}

static bool into_lanes(state *s, fx_step step, long exp, int sums)
{
    if (s->products > 0 && s->lanes_exp != exp && !flush(s))
        return false;
    s->sums += sums;
    if (s->sums > MOST_SUMS)
        return false;
    s->product[s->products++] = step;
    s->lanes_exp = exp;
    return true;
}

/* Is argument j the order itself? */
static bool is_k(const state *s, const cns_trace_call *c, int j)
{
    return c->grows[j] && c->arg[j] == s->trace->order;
}

/* Is it the same at every order? */
static bool fixed(const cns_trace_call *c, int j)
{
    return !c->grows[j];
}

static uint64_t flip(int sign)
{
    return sign < 0 ? ~UINT64_C(0) : 0;
}

static const fx_const *constant(fx *F, int c)
{
    if (!F->constant[c].valid)
        cns_fx_prepare_constant(F, c);
    return &F->constant[c];
}

static bool zero(state *s, const cns_trace_call *c)
{
    s->group = (int)(c - s->trace->call);
    s->empty = true;
    s->products = s->sums = 0;
    return true;
}

static bool coef(state *s, const cns_trace_call *c)
{
    const int a = c->arg[1];
    const fx_series *x = &s->F->series[a];
    const bool sign = fixed(c, 0) && (c->arg[0] == 1 || c->arg[0] == -1);
    if (!is_k(s, c, 2) || !x->live || s->F->will_store[a] <= s->k)
        return false;
    if (sign)
        return add(s, (fx_step){.kind = FX_DO_COEF, .flip = flip(c->arg[0]), .a = x}, x->exp + 1);
    /* A weight other than 1 or -1 is that of an Euler derivative, k a_k, which is a sum of its own. */
    if (!s->empty || s->products > 0 || c->arg[0] < 1 || s->F->order + 1 + c->arg[0] > FX_LANE_LOAD)
        return false;
    return add(s,
               (fx_step){.kind = FX_DO_COEF,
                         .weight = c->arg[0],
                         .weight_grows = c->grows[0],
                         .order = s->trace->order,
                         .a = x},
               x->exp + 1);
}

static bool scaled(state *s, const cns_trace_call *call)
{
    const int c = call->arg[1], a = call->arg[2];
    fx *F = s->F;
    const fx_series *x = &F->series[a];
    const fx_const *m = constant(F, c);
    if (!is_k(s, call, 3) || !x->live || F->will_store[a] <= s->k || m->sign == 0)
        return false;
    return add(s, (fx_step){.kind = FX_DO_SCALED, .flip = flip(call->arg[0]), .a = x, .c = m},
               x->exp + 1 + m->exp);
}

static bool conv(state *s, const cns_trace_call *c)
{
    fx *F = s->F;
    int a = c->arg[1], b = c->arg[2], lo = c->arg[4], above = c->arg[3] - c->arg[5];
    if (!is_k(s, c, 3) || !fixed(c, 4) || !c->grows[5] || lo < 0 || above < 0 || s->k - above < lo)
        return false;
    const fx_series *x = &F->series[a], *y = &F->series[b];
    if (!x->live || !y->live || F->will_store[a] <= s->k - above || F->will_store[b] <= s->k - lo)
        return false;
    const int forwards = FX_FWD | FX_SUMS, backwards = FX_REV | FX_SUMS;
    if (((x->parts & forwards) != forwards || (y->parts & backwards) != backwards) &&
        cns_fx_orient(F, a, b)) {
        const fx_series *const swap = x;
        const int swap_lo = lo;
        x = y;
        y = swap;
        lo = above;
        above = swap_lo;
    }
    return into_lanes(
        s, (fx_step){.kind = FX_DO_CONV, .sign = c->arg[0], .a = x, .b = y, .lo = lo, .above = above},
        x->exp + y->exp + 1, 2);
}

static bool square(state *s, const cns_trace_call *c)
{
    fx *F = s->F;
    const int a = c->arg[1], lo = c->arg[3], all = FX_FWD | FX_REV | FX_SUMS;
    const fx_series *x = &F->series[a];
    if (!is_k(s, c, 2) || !fixed(c, 3) || lo < 0 || lo > s->k - lo || !x->live ||
        F->will_store[a] <= s->k - lo)
        return false;
    if ((x->parts & all) != all)
        cns_fx_want(F, a, all);
    return into_lanes(s, (fx_step){.kind = FX_DO_SQUARE, .sign = c->arg[0], .a = x, .lo = lo}, 2 * x->exp + 1,
                      1);
}

/* What every store begins with. */
static bool complete(state *s, const cns_trace_call *c, fx_step *step)
{
    if (!flush(s) || !is_k(s, c, 1))
        return false;
    *step = (fx_step){.kind = FX_DO_STORE,
                      .group = s->group,
                      .w = &s->F->series[c->arg[0]],
                      .carry = !s->empty && !s->normal,
                      .empty = s->empty};
    return true;
}

/* What every store ends with; the step knows its factor now. */
static bool put(state *s, const cns_trace_call *c, fx_step *step)
{
    fx *F = s->F;
    int *will_store = &F->will_store[c->arg[0]];
    if (*will_store != s->k + step->next)
        return false;
    if (!step->empty && (!step->w->live || (step->c != NULL && step->c->sign == 0)))
        return false;
    ++*will_store;
    step->exp = s->exp - (step->w->exp + 1) + step->next * F->decay;
    if (step->times == FX_TIMES_CONST)
        step->exp += step->c->exp;
    return append(F, step);
}

static bool store(state *s, const cns_trace_call *c)
{
    fx_step step;
    return complete(s, c, &step) && put(s, c, &step);
}

static bool store_scaled(state *s, const cns_trace_call *c)
{
    fx_step step;
    if (!complete(s, c, &step))
        return false;
    step.times = FX_TIMES_CONST;
    step.c = constant(s->F, c->arg[2]);
    return put(s, c, &step);
}

static bool store_over(state *s, const cns_trace_call *c)
{
    fx_step step;
    const fx_const *reciprocal = &s->F->reciprocal[c->arg[2]];
    if (!complete(s, c, &step) || !fixed(c, 3) || !reciprocal->valid || reciprocal->index != c->arg[3])
        return false;
    step.times = FX_TIMES_CONST;
    step.c = reciprocal;
    s->exp -= c->arg[4] != 0;
    return put(s, c, &step);
}

static bool store_ratio(state *s, const cns_trace_call *c)
{
    fx_step step;
    if (!complete(s, c, &step) || c->arg[2] != 1 || !fixed(c, 2) || !is_k(s, c, 3))
        return false;
    step.times = FX_TIMES_INVERSE;
    return put(s, c, &step);
}

static bool store_next(state *s, const cns_trace_call *c)
{
    fx *F = s->F;
    fx_step step;
    if (!complete(s, c, &step))
        return false;
    const int slot = c->arg[2] < 0 ? F->n_series : c->arg[2];
    if (!F->step_const[slot].valid)
        cns_fx_prepare_step(F, c->arg[2]);
    step.times = FX_TIMES_NEXT;
    step.c = &F->step_const[slot];
    step.made = &F->next_const[slot];
    step.next = 1;
    return put(s, c, &step);
}

static bool compile(state *s, const cns_trace_call *c)
{
    switch (c->primitive) {
#define PRIMITIVE(KIND, name, n, ...)                                                                        \
    case CNS_PRIMITIVE_##KIND:                                                                               \
        return name(s, c);
#include "arith/primitives.def"
#undef PRIMITIVE
    }
    return false;
}

bool cns_fx_compile(fx *F, const cns_trace *trace, int k)
{
    state s = {.F = F, .trace = trace, .k = k};
    F->compiled.n = 0;
    for (int a = 0; a < F->n_series; a++)
        F->will_store[a] = F->series[a].stored;
    for (const cns_trace_call *c = trace->call; c < trace->call + trace->n; c++)
        if (!compile(&s, c))
            return false;
    return true;
}
