/* The operations of a program. All that the engine knows of an operation is its cns_operation; whoever walks
 * over the nodes of a program asks it, and nobody else distinguishes one operation from another.
 *
 * A new operation is a row in operations.def, its rules in the file of a family (through rules.h), and a
 * function that builds its node (program.h, program.c). */
#ifndef CNS_TAYLOR_OP_OP_H
#define CNS_TAYLOR_OP_OP_H

#include <limits.h>
#include <stdbool.h>

#include "cns/program.h"
#include "cns/status.h"

typedef enum cns_op {
#define OP(enumerator, name) CNS_OP_##enumerator,
#include "operations.def"
#undef OP
    CNS_OP_COUNT
} cns_op;

struct cns_jet; /* jet_internal.h */
struct cns_watched;
struct cns_program_node; /* program_internal.h */
struct cns_direction;    /* rules.h */
struct cns_enclosure;
struct cns_defect; /* defect_internal.h */

/* An operation by its rules. w is its result, node v of a program; its operands are other nodes. */
typedef struct cns_operation {
    const char *name;
    int operands;

    /* Computes coefficient n of w from the operands' coefficients up to n and w's own below n. The regular
     * case asks for n = 0 first. CNS_NUMERIC: w is singular at the point of expansion. */
    cns_code (*recurrence)(struct cns_jet *J, int v, int n, cns_error *err);

    /* How many coefficients of w the known coefficients of its operands determine, J->known and J->val being
     * known of them; CNS_POLE: none, as w has a pole at the point of expansion. */
    int (*known)(const struct cns_jet *J, int v);

    /* Is w identically zero because operands are (J->vanishes)? */
    bool (*vanishes)(const struct cns_jet *J, int v);

    /* The node in whose zeros w has a value but is not analytic, as |u| in the zeros of u: no step may pass
     * one. NULL: there is none. A pole is not of this kind: before it coefficients grow, and steps become
     * small by themselves. */
    struct cns_watched (*watch)(const struct cns_jet *J, int v);

    /* The derivative of w along a direction as a node of another program, -1 standing for zero. */
    cns_node (*derive)(const struct cns_direction *d);

    /* Encloses w where the operands are in given balls. */
    void (*enclose)(const struct cns_enclosure *e);

    /* Bounds the remainder of w from those of its operands (taylor/defect_internal.h): sets e0 and e1 of node
     * v. False: there is no bound, as what is divided by, or under a root, may be zero. */
    bool (*remainder)(struct cns_defect *d, int v);

    /* Sets y to w for rational operands x; false: it is not rational, or there is none. NULL: not in general.
     */
    bool (*exact)(const cns_program *p, const struct cns_program_node *n, const mpq_t *x, mpq_t y);

    /* Where w is a sum or a product and has one user, which only adds it to its own accumulator, it need not
     * be stored: it is folded into its user. accumulate adds sign * (coefficient n of w) to the accumulator;
     * zeros is a lower bound of the number of its leading zeros, J->val being those of its operands. NULL: w
     * is always stored. */
    void (*accumulate)(struct cns_jet *J, int sign, int v, int n);
    int (*zeros)(const struct cns_jet *J, int v);
    /* Bit k: w only adds its operand k to the accumulator, so that the operand may be folded into w. */
    unsigned adds;

    /* The node after w belongs to it, and each of their recurrences needs the other's coefficients so far. */
    bool has_companion;
} cns_operation;

enum { CNS_POLE = INT_MIN };

#define OP(enumerator, name) extern const cns_operation cns_op_##name;
#include "operations.def"
#undef OP

extern const cns_operation *const cns_operations[CNS_OP_COUNT];

#endif
