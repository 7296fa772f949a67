/* What the rules of operations are written with. Private to src/taylor; the files of families include it.
 *
 * Notation of the recurrences: w_n is coefficient n of the result in scaled time; val[a] is the number of
 * leading zeros of a (0 in the regular case), so sums start and end where their terms can differ from zero.
 * Sources: Jorba and Zou, Exp. Math. 14 (2005) 99, proposition 2.1; Neidinger, SIAM Review 52 (2010) 545. */
#ifndef CNS_TAYLOR_OP_RULES_H
#define CNS_TAYLOR_OP_RULES_H

#include "num/flint.h"
#include "taylor/defect_internal.h"

/* A derivative: along one direction, of node w of the new program, which is the copy of `node`. */
typedef struct cns_direction {
    cns_program *q; /* the new program */
    const cns_program_node *node;
    cns_node w;
    cns_node x[4], dx[4]; /* the operands' copies and derivatives, -1 where there is none, or zero */
    const int *component; /* per state of the old program: the state of q that is its part of the tangent,
                             or one of these numbers */
} cns_direction;
enum { CNS_COMPONENT_ZERO = -1, CNS_COMPONENT_ONE = -2 };

/* In sums and products of derivatives -1 stands for zero: most derivatives of most nodes vanish. */
cns_node cns_plus(const cns_direction *d, cns_node da, cns_node db);
cns_node cns_minus(const cns_direction *d, cns_node da);
cns_node cns_times(const cns_direction *d, cns_node a, cns_node db); /* a is a node */
cns_node cns_over(const cns_direction *d, cns_node da, cns_node b);  /* b is a node */
cns_node cns_component(const cns_direction *d);                      /* of the state that `node` is */

/* An enclosure: ball y is to hold the result of `node` for all values of its operands within their balls. */
typedef struct cns_enclosure {
    const cns_program *p;
    const cns_program_node *node;
    arb_ptr y;
    arb_srcptr x[4];         /* of the operands */
    arb_srcptr value, state; /* of all nodes before, and of the states */
    slong prec;
} cns_enclosure;

/* Recurrences. */
cns_code cns_singular(const cns_jet *J, int v, const char *what, cns_error *err);
/* The accumulator gets sign * sum_{j=lo..hi} a_j b_{n-j}, or sign * sum_{j=1..hi} j u_j b_{n-j} from the node
 * du = euler(u). */
void cns_add_product(cns_jet *J, int sign, int a, int b, int n, int lo, int hi);
void cns_add_euler_product(cns_jet *J, int sign, int du, int b, int n, int hi);
cns_code cns_sum_recurrence(cns_jet *J, int v, int n, cns_error *err); /* w_n is what `accumulate` adds */

/* The remainder of a sum: the operands' remainders and leading coefficients added. */
bool cns_sum_remainder(cns_defect *d, int v, int a, int b); /* b < 0: there is none */
bool cns_product_remainder(cns_defect *d, int v, int a, int b);
bool cns_quotient_remainder(cns_defect *d, int v, int a, int b);
bool cns_no_remainder(cns_defect *d, int v); /* of what is given, or no value depends on */

/* `known` and `vanishes` of operations that have nothing special about them. */
int cns_known_as_first(const cns_jet *J, int v);
int cns_known_as_second(const cns_jet *J, int v);
int cns_known_as_both(const cns_jet *J, int v);
int cns_known_beside_companion(const cns_jet *J, int v); /* which is one coefficient behind */
bool cns_never_vanishes(const cns_jet *J, int v);
bool cns_vanishes_with_first(const cns_jet *J, int v);
bool cns_vanishes_with_second(const cns_jet *J, int v);
bool cns_vanishes_with_both(const cns_jet *J, int v);
bool cns_vanishes_with_either(const cns_jet *J, int v);

/* The rules name_derive, an expression in a cns_direction *d, and name_enclose, one that sets e->y. */
#define CNS_DERIVE(name, derivative)                                                                         \
    static cns_node name##_derive(const cns_direction *d)                                                    \
    {                                                                                                        \
        (void)d;                                                                                             \
        return derivative;                                                                                   \
    }
#define CNS_ENCLOSE(name, set_y)                                                                             \
    static void name##_enclose(const cns_enclosure *e)                                                       \
    {                                                                                                        \
        set_y;                                                                                               \
    }
/* The rule name_exact: a condition in p, n, x and y that sets y. */
#define CNS_EXACT(name, is_set)                                                                              \
    static bool name##_exact(const cns_program *p, const cns_program_node *n, const mpq_t *x, mpq_t y)       \
    {                                                                                                        \
        (void)p, (void)n, (void)x;                                                                           \
        return is_set;                                                                                       \
    }

/* Defines an operation by its rules in their order; `...`: what only some have. Four are the functions
 * name_recurrence, name_derive, name_enclose and name_remainder: without one of them it does not compile. */
#define CNS_OPERATION(name, operands, known, vanishes, watch, ...)                                           \
    CNS_OPERATION_OF(name, operands, name##_recurrence, known, vanishes, watch, __VA_ARGS__)

/* The same of one that may be folded: name_accumulate, and its leading zeros, too. */
#define CNS_FOLDED_OPERATION(name, operands, recurrence, known, vanishes, zeros_, adds_, ...)                \
    CNS_OPERATION_OF(name, operands, recurrence, known, vanishes, NULL, .accumulate = name##_accumulate,     \
                     .zeros = zeros_, .adds = adds_, __VA_ARGS__)

#define CNS_OPERATION_OF(name_, operands_, recurrence_, known_, vanishes_, watch_, ...)                      \
    const cns_operation cns_op_##name_ = {.name = #name_,                                                    \
                                          .operands = operands_,                                             \
                                          .recurrence = recurrence_,                                         \
                                          .known = known_,                                                   \
                                          .vanishes = vanishes_,                                             \
                                          .watch = watch_,                                                   \
                                          .derive = name_##_derive,                                          \
                                          .enclose = name_##_enclose,                                        \
                                          .remainder = name_##_remainder,                                    \
                                          __VA_ARGS__}

#endif
