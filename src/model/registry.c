#include <string.h>

#include "models.h"

static const cns_model *const models[] = {
    &cns_model_apw,
    &cns_model_lorenz,
};

int cns_model_count(void)
{
    return (int)(sizeof models / sizeof *models);
}

const cns_model *cns_model_at(int i)
{
    return i >= 0 && i < cns_model_count() ? models[i] : NULL;
}

const cns_model *cns_model_find(const char *name)
{
    for (int i = 0; i < cns_model_count(); i++)
        if (!strcmp(models[i]->name, name))
            return models[i];
    return NULL;
}

cns_code cns_model_program(const cns_model *m, const cns_number *parameters,
                           const cns_program_options *options, cns_program **program, cns_error *err)
{
    cns_program *p = cns_program_new(m->n_states, m->n_parameters, parameters, options);
    *program = NULL;
    if (!p)
        return cns_out_of_memory(err);
    for (int i = 0; i < m->n_states; i++)
        cns_name_state(p, i, m->states[i].name);
    m->build(p, m);
    cns_code code = cns_program_finish(p, err);
    if (!code && cns_program_outputs(p) != m->n_outputs)
        code = cns_fail(err, CNS_USAGE, "model %s names %d derived quantities and computes %d", m->name,
                        m->n_outputs, cns_program_outputs(p));
    if (code)
        cns_program_free(p);
    else
        *program = p;
    return code;
}
