/* Runs the suites: all of them, or those named on the command line. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "support.h"

/* suites.def has SUITE(name) for each tests/test_name.c; the Makefile writes it. */
#define SUITE(name) Suite *suite_##name(void);
#include "suites.def"
#undef SUITE

typedef struct entry {
    const char *name;
    Suite *(*suite)(void);
} entry;

static const entry entries[] = {
#define SUITE(name) {#name, suite_##name},
#include "suites.def"
#undef SUITE
    {NULL, NULL}};

static const char usage[] =
    "usage: cns-tests [OPTION]... [SUITE]...\n"
    "  -l        list the suites\n"
    "  -c CASE   only the test cases of this name\n"
    "  -n        do not fork: one process for a debugger\n"
    "  -v        one line for every test\n"
    "  -o FILE   write the counts \"passed failed\" to FILE\n"
    "CNS_TEST_SEED=N repeats a run, CNS_TEST_SLOW=N waits N times as long before it gives up a\n"
    "test (10 min); the variables of Check (CK_...) work too.\n";

static const entry *find_entry(const char *name)
{
    for (const entry *e = entries; e->name; e++)
        if (strcmp(e->name, name) == 0)
            return e;
    return NULL;
}

static int write_counts(const char *path, int passed, int failed)
{
    FILE *f = fopen(path, "w");
    int bad = !f || fprintf(f, "%d %d\n", passed, failed) < 0;
    if (f && fclose(f) != 0)
        bad = 1;
    if (bad)
        fprintf(stderr, "cns-tests: %s: %s\n", path, strerror(errno));
    return bad;
}

static void choose_seed(void)
{
    const char *given = getenv("CNS_TEST_SEED");
    if (!given || !*given) {
        struct timespec now;
        char text[32];
        clock_gettime(CLOCK_REALTIME, &now);
        uint64_t state = (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
        snprintf(text, sizeof text, "%llu", (unsigned long long)(test_random(&state) >> 32));
        setenv("CNS_TEST_SEED", text, 1);
    }
    printf("CNS_TEST_SEED=%llu\n", (unsigned long long)test_seed());
    fflush(stdout);
}

int main(int argc, char **argv)
{
    const char *tcase = NULL, *counts = NULL;
    enum print_output mode = CK_ENV;
    enum fork_status fork_mode = CK_FORK_GETENV;
    int i = 1;

    for (; i < argc && argv[i][0] == '-'; i++) {
        if (strcmp(argv[i], "-l") == 0) {
            for (const entry *e = entries; e->name; e++)
                puts(e->name);
            return EXIT_SUCCESS;
        }
        if (strcmp(argv[i], "-v") == 0)
            mode = CK_VERBOSE;
        else if (strcmp(argv[i], "-n") == 0)
            fork_mode = CK_NOFORK;
        else if (strcmp(argv[i], "-c") == 0 && i + 1 < argc)
            tcase = argv[++i];
        else if (strcmp(argv[i], "-o") == 0 && i + 1 < argc)
            counts = argv[++i];
        else {
            fputs(usage, stderr);
            return 2;
        }
    }

    choose_seed();
    /* No test depends on how long anything takes: it is ended only because it might wait for ever. */
    const char *slow = getenv("CNS_TEST_SLOW");
    setenv("CK_DEFAULT_TIMEOUT", "600", 0);
    setenv("CK_TIMEOUT_MULTIPLIER", slow && *slow ? slow : "1", 0);

    SRunner *runner = srunner_create(NULL);
    srunner_set_fork_status(runner, fork_mode);
    if (i == argc)
        for (const entry *e = entries; e->name; e++)
            srunner_add_suite(runner, e->suite());
    for (; i < argc; i++) {
        const entry *e = find_entry(argv[i]);
        if (!e) {
            fprintf(stderr, "cns-tests: no suite '%s' (-l lists them)\n", argv[i]);
            srunner_free(runner);
            return 2;
        }
        srunner_add_suite(runner, e->suite());
    }

    srunner_run(runner, NULL, tcase, mode);
    int failed = srunner_ntests_failed(runner);
    int passed = srunner_ntests_run(runner) - failed;
    srunner_free(runner);
    if (counts && write_counts(counts, passed, failed))
        return 2;
    return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
