/* FLINT's headers have a directory of their own since version 3; before it, Arb's lay outside. */
#ifndef CNS_NUM_FLINT_H
#define CNS_NUM_FLINT_H

#if __has_include(<flint/acb_mat.h>)
#include <flint/acb_mat.h>
#include <flint/acb_poly.h>
#include <flint/arb_mat.h>
#else
#include <acb_mat.h>
#include <acb_poly.h>
#include <arb_mat.h>
#endif

#endif
