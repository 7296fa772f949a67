/* The list of operations, and the rules that many of them share. */
#include "rules.h"

const cns_operation *const cns_operations[CNS_OP_COUNT] = {
#define OP(enumerator, name) &cns_op_##name,
#include "operations.def"
#undef OP
};

cns_code cns_singular(const cns_jet *J, int v, const char *what, cns_error *err)
{
    const char *equation = cns_equation_of(J->p, v);
    return cns_fail(err, CNS_NUMERIC, "%s in %s%s", what,
                    equation != NULL ? "the equation of " : "a derived quantity",
                    equation != NULL ? equation : "");
}

int cns_known_as_first(const cns_jet *J, int v)
{
    return J->known[J->p->node[v].arg[0]];
}

int cns_known_as_second(const cns_jet *J, int v)
{
    return J->known[J->p->node[v].arg[1]];
}

int cns_known_as_both(const cns_jet *J, int v)
{
    return cns_least(cns_known_as_first(J, v), cns_known_as_second(J, v));
}

int cns_known_beside_companion(const cns_jet *J, int v)
{
    return cns_least(cns_known_as_first(J, v), J->known[v + 1] + 1);
}

bool cns_never_vanishes(const cns_jet *J, int v)
{
    (void)J, (void)v;
    return false;
}

bool cns_vanishes_with_first(const cns_jet *J, int v)
{
    return J->vanishes[J->p->node[v].arg[0]];
}

bool cns_vanishes_with_second(const cns_jet *J, int v)
{
    return J->vanishes[J->p->node[v].arg[1]];
}

bool cns_vanishes_with_both(const cns_jet *J, int v)
{
    const int *arg = J->p->node[v].arg;
    return J->vanishes[arg[0]] && J->vanishes[arg[1]];
}

bool cns_vanishes_with_either(const cns_jet *J, int v)
{
    const int *arg = J->p->node[v].arg;
    return J->vanishes[arg[0]] || J->vanishes[arg[1]];
}
