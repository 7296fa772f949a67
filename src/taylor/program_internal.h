/* The inside of a program: its nodes. Private to src/taylor. */
#ifndef CNS_TAYLOR_PROGRAM_INTERNAL_H
#define CNS_TAYLOR_PROGRAM_INTERNAL_H

#include "cns/program.h"
#include "op/op.h"

/* Operands: arg[0..], unused ones -1; which they are stands where the operation is defined (op/). */
typedef struct cns_tape_node {
    cns_op op;
    int arg[4];
    int index;     /* of the state, parameter or constant */
    bool constant; /* depends on no state */
    bool needed;   /* by a derivative; or, if false, at most by an output */
    bool folded;   /* never stored: its only user adds it to its own accumulator */
    int uses;
} cns_tape_node;

struct cns_program {
    int n_states, n_parameters, n_constants, n_outputs;
    cns_number *parameters;
    cns_number *constants;
    cns_number smooth; /* eps of smoothed abs */
    bool is_smooth;
    cns_tape_node *node;
    int n_nodes, nodes_capacity, constants_capacity, outputs_capacity;
    int *hash; /* open addressing, node index + 1 */
    int hash_size;
    int *derivative; /* per state: node, -1 while unset */
    int *factor;     /* per state: a constant node that multiplies `derivative`, or -1 */
    int *state_node; /* per state: its node, -1 if nothing reads it */
    int *output;
    bool *dynamic; /* per state: does anything feed back on it? */
    int *watch;    /* nodes with zeros to watch: of the operand of ABS and SMOOTH_ABS, of the result of SQRT,
                      HYPOT */
    int n_watch;
    cns_error error; /* the first */
    bool finished;
};

/* The node with this operation and these operands (as above), an earlier one if there is one. */
cns_node cns_intern(cns_program *p, cns_op op, int index, int a, int b, int c, int d);

/* sign held by `abs_node` times a; for tangents of abs(). */
cns_node cns_signed(cns_program *p, cns_node abs_node, cns_node a);

#endif
