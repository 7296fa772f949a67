#include "cns/program.h"

#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "num/logs.h"
#include "program_internal.h"

static void *grow(cns_program *p, void *array, int count, int *capacity, size_t size)
{
    if (count < *capacity)
        return array;
    int wanted = *capacity ? 2 * *capacity : 32;
    void *larger = realloc(array, (size_t)wanted * size);
    if (!larger) {
        if (!p->error.code)
            cns_out_of_memory(&p->error);
        return NULL;
    }
    *capacity = wanted;
    return larger;
}

cns_program *cns_program_new(int n_states, int n_parameters, const cns_number *parameters,
                             const cns_program_options *options)
{
    cns_program *p = calloc(1, sizeof *p);
    if (!p)
        return NULL;
    size_t n = (size_t)n_states + 1;
    p->parameters = calloc((size_t)n_parameters + 1, sizeof *p->parameters);
    p->name = cns_xalloc(n, sizeof *p->name);
    p->derivative = malloc(n * sizeof *p->derivative);
    p->factor = malloc(n * sizeof *p->factor);
    p->state_node = malloc(n * sizeof *p->state_node);
    p->dynamic = calloc(n, sizeof *p->dynamic);
    p->hash_size = 256;
    p->hash = calloc((size_t)p->hash_size, sizeof *p->hash);
    cns_number_init(&p->smooth);
    if (p->parameters)
        for (; p->n_parameters < n_parameters; p->n_parameters++) {
            cns_number_init(&p->parameters[p->n_parameters]);
            cns_number_set(&p->parameters[p->n_parameters], &parameters[p->n_parameters]);
        }
    if (!p->parameters || !p->derivative || !p->factor || !p->state_node || !p->dynamic || !p->hash) {
        cns_program_free(p);
        return NULL;
    }
    p->backwards = options != NULL && options->backwards;
    p->start = options != NULL ? options->start : 0;
    p->n_states = n_states;
    for (int i = 0; i < n_states; i++) {
        char name[32];
        snprintf(name, sizeof name, "state %d", i);
        cns_name_state(p, i, name);
    }
    for (int i = 0; i < n_states; i++)
        p->derivative[i] = p->factor[i] = p->state_node[i] = -1;
    if (options && options->smooth) {
        p->is_smooth = true;
        cns_number_set(&p->smooth, options->smooth);
    }
    return p;
}

double cns_program_time(const cns_program *p, double passed)
{
    return p->backwards ? p->start - passed : p->start + passed;
}

void cns_program_free(cns_program *p)
{
    if (!p)
        return;
    for (int i = 0; i < p->n_parameters; i++)
        cns_number_clear(&p->parameters[i]);
    for (int i = 0; i < p->n_constants; i++)
        cns_number_clear(&p->constants[i]);
    cns_number_clear(&p->smooth);
    free(p->parameters);
    free(p->constants);
    free(p->node);
    free(p->hash);
    for (int i = 0; i < p->n_states; i++)
        free(p->name[i]);
    free(p->name);
    free(p->derivative);
    free(p->factor);
    free(p->state_node);
    free(p->dynamic);
    free(p->output);
    free(p->watch);
    free(p);
}

static unsigned node_hash(const cns_program_node *n)
{
    unsigned h = 2166136261u ^ (unsigned)n->op;
    for (int i = 0; i < 4; i++)
        h = (h ^ (unsigned)(n->arg[i] + 1)) * 16777619u;
    return (h ^ (unsigned)n->index) * 16777619u;
}

static bool rehash(cns_program *p)
{
    int size = 2 * p->hash_size;
    int *table = calloc((size_t)size, sizeof *table);
    if (!table) {
        cns_out_of_memory(&p->error);
        return false;
    }
    for (int i = 0; i < p->n_nodes; i++) {
        unsigned h = node_hash(&p->node[i]) & (unsigned)(size - 1);
        while (table[h])
            h = (h + 1) & (unsigned)(size - 1);
        table[h] = i + 1;
    }
    free(p->hash);
    p->hash = table;
    p->hash_size = size;
    return true;
}

cns_node cns_intern(cns_program *p, cns_op op, int index, int a, int b, int c, int d)
{
    int arg[4] = {a, b, c, d};
    cns_program_node n = {.op = op, .index = index, .constant = true};
    if (p->error.code)
        return -1;
    if (p->finished) {
        cns_fail(&p->error, CNS_NUMERIC, "a finished program cannot be extended");
        return -1;
    }
    for (int i = 0; i < 4; i++) {
        bool wanted = i < cns_operations[op]->operands;
        if (wanted && (arg[i] < 0 || arg[i] >= p->n_nodes)) {
            cns_fail(&p->error, CNS_NUMERIC, "operand %d of '%s' is not a node of this program", i + 1,
                     cns_operations[op]->name);
            return -1;
        }
        n.arg[i] = wanted ? arg[i] : -1;
        if (wanted && !p->node[arg[i]].constant)
            n.constant = false;
    }
    if (op == CNS_OP_STATE)
        n.constant = false;
    unsigned mask = (unsigned)(p->hash_size - 1), h = node_hash(&n) & mask;
    for (; p->hash[h]; h = (h + 1) & mask) {
        const cns_program_node *m = &p->node[p->hash[h] - 1];
        if (m->op == n.op && m->index == n.index && !memcmp(m->arg, n.arg, sizeof n.arg))
            return p->hash[h] - 1;
    }
    cns_program_node *array = grow(p, p->node, p->n_nodes, &p->nodes_capacity, sizeof *p->node);
    if (!array)
        return -1;
    p->node = array;
    p->node[p->n_nodes++] = n;
    p->hash[h] = p->n_nodes;
    if (2 * p->n_nodes > p->hash_size && !rehash(p))
        return -1;
    return p->n_nodes - 1;
}

static bool is_constant(const cns_program *p, cns_node a)
{
    return a >= 0 && a < p->n_nodes && p->node[a].constant;
}

static cns_node commutative(cns_program *p, cns_op op, cns_node a, cns_node b)
{
    return a <= b ? cns_intern(p, op, 0, a, b, -1, -1) : cns_intern(p, op, 0, b, a, -1, -1);
}

cns_node cns_state(cns_program *p, int i)
{
    if (i < 0 || i >= p->n_states) {
        if (!p->error.code)
            cns_fail(&p->error, CNS_NUMERIC, "state %d does not exist", i);
        return -1;
    }
    return p->state_node[i] = cns_intern(p, CNS_OP_STATE, i, -1, -1, -1, -1);
}

cns_node cns_parameter(cns_program *p, int i)
{
    if (i < 0 || i >= p->n_parameters) {
        if (!p->error.code)
            cns_fail(&p->error, CNS_NUMERIC, "parameter %d does not exist", i);
        return -1;
    }
    return cns_intern(p, CNS_OP_PARAMETER, i, -1, -1, -1, -1);
}

cns_node cns_constant(cns_program *p, const char *text)
{
    if (p->error.code)
        return -1;
    cns_number x;
    cns_number_init(&x);
    if (cns_number_parse(&x, text, &p->error)) {
        cns_number_clear(&x);
        return -1;
    }
    for (int i = 0; i < p->n_constants; i++)
        if (p->constants[i].pi_power == x.pi_power && mpq_equal(p->constants[i].ratio, x.ratio)) {
            cns_number_clear(&x);
            return cns_intern(p, CNS_OP_CONSTANT, i, -1, -1, -1, -1);
        }
    cns_number *array = grow(p, p->constants, p->n_constants, &p->constants_capacity, sizeof *p->constants);
    if (!array) {
        cns_number_clear(&x);
        return -1;
    }
    p->constants = array;
    p->constants[p->n_constants++] = x;
    return cns_intern(p, CNS_OP_CONSTANT, p->n_constants - 1, -1, -1, -1, -1);
}

cns_node cns_add(cns_program *p, cns_node a, cns_node b)
{
    return commutative(p, CNS_OP_ADD, a, b);
}

cns_node cns_sub(cns_program *p, cns_node a, cns_node b)
{
    return cns_intern(p, CNS_OP_SUB, 0, a, b, -1, -1);
}

cns_node cns_neg(cns_program *p, cns_node a)
{
    if (a >= 0 && a < p->n_nodes && p->node[a].op == CNS_OP_NEG)
        return p->node[a].arg[0];
    return cns_intern(p, CNS_OP_NEG, 0, a, -1, -1, -1);
}

static bool is_abs_of(const cns_program *p, cns_node a, cns_node b)
{
    return a >= 0 && a < p->n_nodes && p->node[a].op == CNS_OP_ABS && p->node[a].arg[0] == b;
}

cns_node cns_mul(cns_program *p, cns_node a, cns_node b)
{
    if (a == b)
        return cns_sqr(p, a);
    bool ca = is_constant(p, a), cb = is_constant(p, b);
    if (ca && !cb)
        return cns_intern(p, CNS_OP_SCALE, 0, a, b, -1, -1);
    if (cb && !ca)
        return cns_intern(p, CNS_OP_SCALE, 0, b, a, -1, -1);
    /* |u| u is the held sign times u^2: a square is half the work of a product. */
    if (is_abs_of(p, a, b))
        return cns_signed(p, a, cns_sqr(p, b));
    if (is_abs_of(p, b, a))
        return cns_signed(p, b, cns_sqr(p, a));
    return commutative(p, CNS_OP_MUL, a, b);
}

cns_node cns_sqr(cns_program *p, cns_node a)
{
    return cns_intern(p, CNS_OP_SQR, 0, a, -1, -1, -1);
}

cns_node cns_div(cns_program *p, cns_node a, cns_node b)
{
    if (is_constant(p, b) && !is_constant(p, a))
        return cns_mul(p, cns_intern(p, CNS_OP_DIV, 0, cns_constant(p, "1"), b, -1, -1), a);
    return cns_intern(p, CNS_OP_DIV, 0, a, b, -1, -1);
}

cns_node cns_sqrt(cns_program *p, cns_node a)
{
    if (a >= 0 && a < p->n_nodes && p->node[a].op == CNS_OP_SQR) /* sqrt(u^2) is |u|, with its kink */
        return cns_intern(p, CNS_OP_ABS, 0, p->node[a].arg[0], -1, -1, -1);
    return cns_intern(p, CNS_OP_SQRT, 0, a, -1, -1, -1);
}

cns_node cns_hypot(cns_program *p, cns_node a, cns_node b)
{
    if (a > b) {
        cns_node swap = a;
        a = b;
        b = swap;
    }
    return cns_intern(p, CNS_OP_HYPOT, 0, a, b, cns_sqr(p, a), cns_sqr(p, b));
}

static cns_node euler(cns_program *p, cns_node a)
{
    return cns_intern(p, CNS_OP_EULER, 0, a, -1, -1, -1);
}

/* A sine is followed by its cosine, a logarithm and a power by the Euler derivative of their own result:
 * the recurrences find these companions at the next index. They are made together, so if the first
 * exists already, so does the second. */
void cns_sincos(cns_program *p, cns_node a, cns_node *sin_a, cns_node *cos_a)
{
    cns_node du = euler(p, a);
    *sin_a = cns_intern(p, CNS_OP_SIN, 0, a, du, -1, -1);
    *cos_a = cns_intern(p, CNS_OP_COS, 0, a, du, *sin_a, -1);
}

cns_node cns_exp(cns_program *p, cns_node a)
{
    return cns_intern(p, CNS_OP_EXP, 0, a, euler(p, a), -1, -1);
}

cns_node cns_log(cns_program *p, cns_node a)
{
    cns_node du = euler(p, a), w = cns_intern(p, CNS_OP_LOG, 0, a, du, -1, -1);
    return euler(p, w) < 0 ? -1 : w;
}

cns_node cns_pow(cns_program *p, cns_node a, cns_node exponent)
{
    if (!p->error.code && !is_constant(p, exponent)) {
        cns_fail(&p->error, CNS_NUMERIC, "the exponent of a power must be constant");
        return -1;
    }
    cns_node du = euler(p, a), adu = cns_mul(p, exponent, du);
    cns_node w = cns_intern(p, CNS_OP_POW, 0, a, exponent, adu, -1);
    return euler(p, w) < 0 ? -1 : w;
}

cns_node cns_abs(cns_program *p, cns_node a)
{
    if (!p->is_smooth || is_constant(p, a))
        return cns_intern(p, CNS_OP_ABS, 0, a, -1, -1, -1);
    /* eps is p->smooth: the constant of index -1. */
    cns_node eps = cns_intern(p, CNS_OP_CONSTANT, -1, -1, -1, -1, -1);
    return cns_intern(p, CNS_OP_SMOOTH_ABS, 0, cns_add(p, cns_sqr(p, a), cns_sqr(p, eps)), a, eps, -1);
}

cns_node cns_signed(cns_program *p, cns_node abs_node, cns_node a)
{
    return cns_intern(p, CNS_OP_SIGNED, 0, abs_node, a, -1, -1);
}

cns_node cns_smooth_sign(cns_program *p, cns_node smooth_abs_node)
{
    return cns_intern(p, CNS_OP_SMOOTH_SIGN, 0, smooth_abs_node, p->node[smooth_abs_node].arg[1], -1, -1);
}

void cns_name_state(cns_program *p, int i, const char *name)
{
    free(p->name[i]);
    p->name[i] = cns_xcopy(name);
}

const char *cns_state_name(const cns_program *p, int i)
{
    return p->name[i];
}

const char *cns_equation_of(const cns_program *p, int v)
{
    bool *made_of_v = cns_xalloc((size_t)p->n_nodes + 1, sizeof *made_of_v);
    const char *name = NULL;
    made_of_v[v] = true;
    for (int w = v + 1; w < p->n_nodes; w++)
        for (int k = 0; k < 4; k++)
            made_of_v[w] = made_of_v[w] || (p->node[w].arg[k] >= 0 && made_of_v[p->node[w].arg[k]]);
    for (int i = 0; i < p->n_states && name == NULL; i++)
        if (made_of_v[p->derivative[i]])
            name = p->name[i];
    free(made_of_v);
    return name;
}

void cns_derivative(cns_program *p, int i, cns_node f)
{
    if (p->error.code)
        return;
    if (i < 0 || i >= p->n_states || f < 0 || f >= p->n_nodes)
        cns_fail(&p->error, CNS_NUMERIC, "the derivative of state %d is not a node of this program", i);
    else
        p->derivative[i] = f;
}

int cns_output(cns_program *p, cns_node f)
{
    if (p->error.code)
        return -1;
    if (f < 0 || f >= p->n_nodes) {
        cns_fail(&p->error, CNS_NUMERIC, "output %d is not a node of this program", p->n_outputs);
        return -1;
    }
    int *array = grow(p, p->output, p->n_outputs, &p->outputs_capacity, sizeof *p->output);
    if (!array)
        return -1;
    p->output = array;
    p->output[p->n_outputs] = f;
    return p->n_outputs++;
}

void cns_program_print(const cns_program *p, FILE *out)
{
    for (int v = 0; v < p->n_nodes; v++) {
        const cns_program_node *n = &p->node[v];
        fprintf(out, "%%%d = %s", v, cns_operations[n->op]->name);
        if (n->op == CNS_OP_STATE || n->op == CNS_OP_PARAMETER)
            fprintf(out, " %d", n->index);
        if (n->op == CNS_OP_CONSTANT)
            fprintf(out, " %s", n->index < 0 ? p->smooth.text : p->constants[n->index].text);
        for (int k = 0; k < 4 && n->arg[k] >= 0; k++)
            fprintf(out, " %%%d", n->arg[k]);
        if (p->finished)
            fprintf(out, "%s%s%s", n->constant ? "  ; constant" : "", n->folded ? "  ; folded" : "",
                    n->needed || n->constant ? "" : "  ; output only");
        fputc('\n', out);
    }
    for (int i = 0; i < p->n_states; i++) {
        fprintf(out, "state %d' = ", i);
        if (p->factor[i] >= 0)
            fprintf(out, "%%%d * ", p->factor[i]);
        fprintf(out, "%%%d%s\n", p->derivative[i], p->finished && !p->dynamic[i] ? "  ; passive" : "");
    }
    for (int i = 0; i < p->n_outputs; i++)
        fprintf(out, "output %d = %%%d\n", i, p->output[i]);
}

bool cns_program_is_dynamic(const cns_program *p, int i)
{
    return p->dynamic[i];
}

int cns_program_states(const cns_program *p)
{
    return p->n_states;
}

int cns_program_outputs(const cns_program *p)
{
    return p->n_outputs;
}

bool cns_program_is_smooth(const cns_program *p)
{
    return p->is_smooth;
}

double cns_program_smooth_log2(const cns_program *p)
{
    mpfr_t eps;
    mpfr_init2(eps, 53);
    cns_number_get_mpfr(eps, &p->smooth);
    double l = cns_log2_mpfr(eps);
    mpfr_clear(eps);
    return l;
}
