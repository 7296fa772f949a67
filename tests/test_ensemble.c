/* Ensembles: the same results whatever the threads; what is kept is not done again. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/files.h"
#include "study/ensemble.h"
#include "support.h"

enum { N = 12 };

typedef struct plan {
    int done[N]; /* how often each was run */
    int fails;   /* this job fails; -1: none */
    int stops;   /* this job raises the stop; -1: none */
    volatile sig_atomic_t stop;
    double last; /* fraction */
} plan;

static void name(void *context, int i, char *text, size_t size)
{
    (void)context;
    snprintf(text, size, "job-%02d", i);
}

static double cost(void *context, int i)
{
    (void)context;
    return 1 + (i * 7) % N;
}

static cns_code run(void *context, int i, cns_ensemble_job *job, char **result, cns_error *err)
{
    plan *p = context;
    p->done[i]++;
    cns_ensemble_tell(job, 0.5);
    if (i == p->fails)
        return cns_fail(err, CNS_NUMERIC, "job %d fails", i);
    if (i == p->stops) {
        p->stop = 2;
        return cns_fail(err, CNS_STOPPED, "stopped");
    }
    *result = malloc(64);
    snprintf(*result, 64, "square %d\ncost %g\n", i * i, cost(p, i));
    return CNS_OK;
}

static void progress(void *context, double fraction, const char *what)
{
    plan *p = context;
    ck_assert(fraction >= p->last - 1e-12 && fraction <= 1 + 1e-12);
    ck_assert_ptr_nonnull(strstr(what, "of 12 runs done"));
    p->last = fraction;
}

static cns_code go(plan *p, int threads, const char *directory, const char *identity, char **results,
                   cns_error *err)
{
    const cns_monitor monitor = {.threads = threads, .stop = &p->stop, .progress = progress, .context = p};
    const cns_ensemble e = {N, &monitor, directory, identity, p, name, cost, run};
    p->last = 0;
    return cns_ensemble_run(&e, results, err);
}

static void expect(char **results)
{
    for (int i = 0; i < N; i++) {
        char text[64];
        snprintf(text, sizeof text, "square %d\ncost %g\n", i * i, cost(NULL, i));
        ck_assert_str_eq(results[i], text);
    }
}

static void drop(char **results)
{
    for (int i = 0; i < N; i++)
        free(results[i]);
}

static void empty(const char *directory)
{
    DIR *d = opendir(directory);
    for (struct dirent *f; (f = readdir(d)) != NULL;) {
        char path[600];
        snprintf(path, sizeof path, "%s/%s", directory, f->d_name);
        unlink(path);
    }
    closedir(d);
    rmdir(directory);
}

START_TEST(any_threads)
{
    static const int counts[] = {1, 2, 5};
    for (int c = 0; c < 3; c++) {
        plan p = {.fails = -1, .stops = -1};
        char *results[N];
        cns_error err;
        ck_assert_int_eq(go(&p, counts[c], NULL, "a", results, &err), CNS_OK);
        expect(results);
        ck_assert_double_eq_tol(p.last, 1, 1e-12);
        drop(results);
    }
}
END_TEST

START_TEST(resumes)
{
    char directory[] = "/tmp/cns-ensemble-XXXXXX", *results[N];
    cns_error err;
    ck_assert_ptr_nonnull(mkdtemp(directory));
    rmdir(directory); /* it makes its own */
    plan p = {.fails = -1, .stops = 3};
    ck_assert_int_eq(go(&p, 1, directory, "a", results, &err), CNS_STOPPED);
    drop(results);
    for (int i = 0; i < N; i++) /* the dearest come first: 5, 10 and 3 */
        ck_assert_int_eq(p.done[i], i == 5 || i == 10 || i == 3);

    p.stops = -1;
    p.stop = 0;
    ck_assert_int_eq(go(&p, 2, directory, "a", results, &err), CNS_OK);
    expect(results);
    drop(results);
    for (int i = 0; i < N; i++)
        ck_assert_int_eq(p.done[i], i == 3 ? 2 : 1);

    /* a file cut short, and one that was tampered with in its head, count as missing */
    char path[64], *text;
    snprintf(path, sizeof path, "%s/job-05", directory);
    text = cns_file_text(path);
    text[strlen(text) - 3] = '\0';
    ck_assert_int_eq(cns_file_replace(path, text, &err), CNS_OK);
    free(text);
    snprintf(path, sizeof path, "%s/job-06", directory);
    text = cns_file_text(path);
    text[15] = text[15] == '0' ? '1' : '0';
    ck_assert_int_eq(cns_file_replace(path, text, &err), CNS_OK);
    free(text);
    /* one whose figures were changed, and one in the place of another */
    snprintf(path, sizeof path, "%s/job-07", directory);
    text = cns_file_text(path);
    strstr(text, "49")[0] = '8';
    ck_assert_int_eq(cns_file_replace(path, text, &err), CNS_OK);
    snprintf(path, sizeof path, "%s/job-08", directory);
    ck_assert_int_eq(cns_file_replace(path, text, &err), CNS_OK);
    free(text);
    ck_assert_int_eq(go(&p, 1, directory, "a", results, &err), CNS_OK);
    expect(results);
    drop(results);
    for (int i = 4; i < 9; i++)
        ck_assert_int_eq(p.done[i], i == 4 ? 1 : 2);

    /* what is no kept run is not overwritten, and nothing is done; an empty file may be */
    snprintf(path, sizeof path, "%s/job-09", directory);
    ck_assert_int_eq(cns_file_replace(path, "model: apw\n", &err), CNS_OK);
    ck_assert_int_eq(go(&p, 1, directory, "b", results, &err), CNS_USAGE);
    ck_assert_ptr_nonnull(strstr(err.text, "job-09 is no kept run"));
    drop(results);
    ck_assert_int_eq(p.done[4], 1);
    text = cns_file_text(path);
    ck_assert_str_eq(text, "model: apw\n");
    free(text);
    ck_assert_int_eq(cns_file_replace(path, "", &err), CNS_OK);

    /* another identity starts afresh */
    ck_assert_int_eq(go(&p, 2, directory, "b", results, &err), CNS_OK);
    drop(results);
    ck_assert_int_eq(p.done[4], 2);

    /* what is kept can be read by whoever may read other new files */
    struct stat what;
    const mode_t mask = umask(027);
    ck_assert_int_eq(cns_file_replace(path, "x", &err), CNS_OK);
    umask(mask);
    ck_assert_int_eq(stat(path, &what), 0);
    ck_assert_int_eq(what.st_mode & 0777, 0640);
    empty(directory);
}
END_TEST

/* Texts in names of files: different for different texts, whatever their length. */
START_TEST(words_of_names)
{
    char a[200], b[200];
    ck_assert_str_eq(cns_ensemble_word_for("1.25").text, "1.25");
    ck_assert_str_eq(cns_ensemble_word_for("1/3").text, "1_3");
    for (int n = 60; n < 199; n++) {
        memset(a, '3', sizeof a);
        a[n] = '\0';
        strcpy(b, a);
        b[n - 1] = '4';
        ck_assert_str_ne(cns_ensemble_word_for(a).text, cns_ensemble_word_for(b).text);
        ck_assert_int_le((int)strlen(cns_ensemble_word_for(a).text), 64);
    }
}
END_TEST

START_TEST(failures)
{
    plan p = {.fails = 4, .stops = -1};
    char *results[N];
    cns_error err;
    ck_assert_int_eq(go(&p, 2, NULL, "a", results, &err), CNS_NUMERIC);
    ck_assert_str_eq(err.text, "job 4 fails");
    ck_assert_ptr_null(results[4]);
    drop(results);
    p.fails = -1;
    ck_assert_int_eq(go(&p, 2, "/proc/none", "a", results, &err), CNS_IO);
}
END_TEST

Suite *suite_ensemble(void)
{
    Suite *s = suite_create("ensemble");
    TCase *tc = tcase_create("ensemble");
    tcase_add_test(tc, any_threads);
    tcase_add_test(tc, resumes);
    tcase_add_test(tc, words_of_names);
    tcase_add_test(tc, failures);
    suite_add_tcase(s, tc);
    return s;
}
