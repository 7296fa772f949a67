/* What every test may use.
 *
 * A suite is a file tests/test_NAME.c that exports `Suite *suite_NAME(void)`; the build finds it by its
 * name. Random tests draw from a stream that starts at test_seed(), so that the seed printed at the top
 * of a run repeats it:
 *
 *     uint64_t s = test_seed();
 *     int n = (int)test_random_below(&s, 40);
 */
#ifndef TESTS_SUPPORT_H
#define TESTS_SUPPORT_H

#include <check.h>
#include <stdint.h>

/* The rows of a table; a test run for each row, whose number is _i. */
#define COUNT(table)                       ((int)(sizeof(table) / sizeof *(table)))
#define add_table_test(tcase, test, table) tcase_add_loop_test(tcase, test, 0, COUNT(table))

/* The seed of this run: CNS_TEST_SEED, set by the runner where the user did not. */
uint64_t test_seed(void);

/* The next 64 random bits of the stream *state (splitmix64); any start is a good one. */
uint64_t test_random(uint64_t *state);

/* Uniform in 0..n-1, n > 0. */
uint64_t test_random_below(uint64_t *state, uint64_t n);

/* Uniform in [0, 1), a multiple of 2^-53. */
double test_random_unit(uint64_t *state);

#endif
