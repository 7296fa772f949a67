#include "cns/study.h"

cns_code cns_study_program(const cns_study *s, cns_program **program, cns_error *err)
{
    const cns_program_options options = {.smooth = s->smooth};
    return cns_model_program(s->model, s->parameters, &options, program, err);
}

void cns_study_progress(const cns_study *s, double fraction, const char *what)
{
    if (s->progress != NULL)
        s->progress(s->context, fraction, what);
}
