/* The models, one file each. Private to src/model. */
#ifndef CNS_MODEL_MODELS_H
#define CNS_MODEL_MODELS_H

#include "cns/model.h"

extern const cns_model cns_model_apw;
extern const cns_model cns_model_lorenz;

#endif
