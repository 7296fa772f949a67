#include "support.h"

#include <stdlib.h>

uint64_t test_seed(void)
{
    const char *text = getenv("CNS_TEST_SEED");
    return text ? strtoull(text, NULL, 10) : 0;
}

/* Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014. */
uint64_t test_random(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

uint64_t test_random_below(uint64_t *state, uint64_t n)
{
    uint64_t skip = (0 - n) % n; /* 2^64 mod n: draws below it would favour the small results */
    uint64_t r = test_random(state);
    while (r < skip)
        r = test_random(state);
    return r % n;
}

double test_random_unit(uint64_t *state)
{
    return (double)(test_random(state) >> 11) * 0x1p-53;
}
