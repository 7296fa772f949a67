/* SHA-256 (FIPS 180-4), for provenance only: it says which text a table came from. */
#ifndef CNS_CORE_SHA256_H
#define CNS_CORE_SHA256_H

#include <stddef.h>

/* hex: 64 lower-case digits and a NUL. */
void cns_sha256_hex(char hex[65], const void *data, size_t length);

#endif
