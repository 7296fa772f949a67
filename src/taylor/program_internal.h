/* The inside of a program: its nodes. Private to src/taylor. */
#ifndef CNS_TAYLOR_PROGRAM_INTERNAL_H
#define CNS_TAYLOR_PROGRAM_INTERNAL_H

#include "cns/program.h"
#include "op/op.h"

/* Operands: arg[0..], unused ones -1; which they are stands where the operation is defined (op/). */
typedef struct cns_program_node {
    cns_op op;
    int arg[4];
    int index;     /* of the state, parameter or constant */
    bool constant; /* depends on no state */
    bool needed;   /* by a derivative; if not, only outputs use it */
    bool folded;   /* a sum or product that is not stored: its only user adds it to its own accumulator */
    int uses;      /* by needed nodes and derivatives */
} cns_program_node;

struct cns_program {
    int n_states, n_parameters, n_constants, n_outputs;
    cns_number *parameters;
    cns_number *constants;
    cns_number smooth; /* eps of smoothed abs */
    bool is_smooth, backwards;
    double start;
    cns_program_node *node;
    int n_nodes, nodes_capacity, constants_capacity, outputs_capacity;
    int *hash; /* a table of nodes, to find equal ones: node index + 1, or 0; open addressing */
    int hash_size;
    char **name;     /* per state */
    int *derivative; /* per state: node, -1 while unset */
    int *factor;     /* per state: its derivative is this constant node times `derivative`; -1: it is that */
    int *state_node; /* per state: its node, -1 if nothing reads it */
    int *output;
    bool *dynamic; /* per state: does anything feed back on it? */
    int *watch;    /* the nodes whose operations have something to watch */
    int n_watch;
    cns_error error; /* the first */
    bool finished;
};

/* The node with this operation and these operands: the one there is, or a new one. */
cns_node cns_intern(cns_program *p, cns_op op, int index, int a, int b, int c, int d);

/* The name of the first state whose equation needs node v; NULL: none, only outputs do. */
const char *cns_equation_of(const cns_program *p, int v);

/* The sign that node `abs_node`, an abs(u), holds, times a: the tangent of |u| along a. */
cns_node cns_signed(cns_program *p, cns_node abs_node, cns_node a);

/* u / sqrt(u^2 + eps^2) of a smooth_abs node, which is the derivative of that node with respect to u. */
cns_node cns_smooth_sign(cns_program *p, cns_node smooth_abs_node);

#endif
