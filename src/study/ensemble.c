#include "ensemble.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/clock.h"
#include "core/files.h"
#include "core/memory.h"
#include "core/monitor.h"
#include "core/sha256.h"
#include "core/text.h"
#include "num/flint.h"

struct cns_ensemble_job {
    struct gang *gang;
    int number;
    double cost, fraction;
};

/* The state of a run; threads read and write it under its lock. */
typedef struct gang {
    pthread_mutex_t lock;
    const cns_ensemble *e;
    char **results;
    cns_ensemble_job *jobs; /* the longest first */
    int next;               /* to be done */
    double total, done;     /* costs of what had to be computed, and of what has been */
    int ended, missing;
    double next_word; /* when to speak again */
    bool halt;        /* a job has failed, or no more may be begun */
    cns_error why;    /* no more may be begun: it was stopped, or memory is short */
    cns_code *codes;
    cns_error *errors;
} gang;

enum { WORD = 128 };
static const double pause = 0.1; /* seconds between reports of progress */

static void speak(gang *g, bool now)
{
    const double time = cns_seconds();
    if (!now && time < g->next_word)
        return;
    g->next_word = time + pause;
    char word[WORD];
    snprintf(word, sizeof word, "%d of %d runs done", g->e->n - g->missing + g->ended, g->e->n);
    cns_monitor_tell(g->e->monitor, g->total > 0 ? g->done / g->total : 1, word);
}

void cns_ensemble_tell(cns_ensemble_job *job, double fraction)
{
    gang *g = job->gang;
    pthread_mutex_lock(&g->lock);
    g->done += (fraction - job->fraction) * job->cost;
    job->fraction = fraction;
    speak(g, false);
    pthread_mutex_unlock(&g->lock);
}

/* Files begin with a line that ties them and what they say to the job, and end with one that shows them to be
 * whole. */
static const char mark[] = "# cns result ", whole[] = "# complete\n";
enum { SIGNATURE = 96 };

static void signature(const cns_ensemble *e, const char *name, const char *result, size_t length, char *line)
{
    const size_t size = strlen(e->identity) + strlen(name) + length + 3;
    char *all = cns_xalloc(size, 1), sum[65];
    snprintf(all, size, "%s\n%s\n%.*s", e->identity, name, (int)length, result);
    cns_sha256_hex(sum, all, size - 1);
    snprintf(line, SIGNATURE, "%s%s\n", mark, sum);
    free(all);
}

cns_ensemble_word cns_ensemble_word_for(const char *text)
{
    cns_ensemble_word word;
    if (strlen(text) < sizeof word.text - 1)
        snprintf(word.text, sizeof word.text, "%s", text);
    else
        cns_sha256_hex(word.text, text, strlen(text));
    for (char *at = word.text; *at != '\0'; at++)
        if (*at == '/')
            *at = '_';
    return word;
}

static char *path_of(const cns_ensemble *e, const char *name)
{
    const size_t size = strlen(e->directory) + strlen(name) + 2;
    char *path = cns_xalloc(size, 1);
    snprintf(path, size, "%s/%s", e->directory, name);
    return path;
}

/* The result of job i if it is kept, else NULL. */
static cns_code recall(const cns_ensemble *e, int i, char **result, cns_error *err)
{
    char name[CNS_ENSEMBLE_NAME], line[SIGNATURE];
    e->name(e->context, i, name, sizeof name);
    char *path = path_of(e, name), *text = cns_file_text(path);
    const char *begin = text == NULL ? NULL : strchr(text, '\n');
    const size_t length = begin == NULL ? 0 : strlen(++begin), tail = sizeof whole - 1;
    cns_code code = CNS_OK;
    if (text != NULL && text[0] != '\0' && strncmp(text, mark, sizeof mark - 1) != 0) {
        char *shown = cns_text_printable(path);
        code = cns_fail(err, CNS_USAGE, "%.300s is no kept run, and would be overwritten", shown);
        free(shown);
    } else if (length >= tail && strcmp(begin + length - tail, whole) == 0) {
        signature(e, name, begin, length - tail, line);
        if (strncmp(text, line, strlen(line)) == 0)
            *result = cns_xcopy_n(begin, length - tail);
    }
    free(path);
    free(text);
    return code;
}

static cns_code keep(const cns_ensemble *e, int i, const char *result, cns_error *err)
{
    char name[CNS_ENSEMBLE_NAME], line[SIGNATURE];
    e->name(e->context, i, name, sizeof name);
    signature(e, name, result, strlen(result), line);
    const size_t size = strlen(line) + strlen(result) + sizeof whole;
    char *path = path_of(e, name), *text = cns_xalloc(size, 1);
    snprintf(text, size, "%s%s%s", line, result, whole);
    cns_code code = cns_file_replace(path, text, err);
    free(text);
    free(path);
    return code;
}

static void work(gang *g, cns_ensemble_job *job)
{
    const cns_ensemble *e = g->e;
    const int i = job->number;
    cns_error err = {0};
    char *result = NULL;
    cns_code code = e->run(e->context, i, job, &result, &err);
    if (code == CNS_OK && e->directory != NULL)
        code = keep(e, i, result, &err);
    g->results[i] = result;
    pthread_mutex_lock(&g->lock);
    g->codes[i] = code;
    g->errors[i] = err;
    g->halt = g->halt || code != CNS_OK;
    g->done += (1 - job->fraction) * job->cost;
    job->fraction = 1;
    g->ended += code == CNS_OK;
    speak(g, true);
    pthread_mutex_unlock(&g->lock);
}

/* The next job; NULL: there is none, or no more shall be begun. */
static cns_ensemble_job *take(gang *g)
{
    pthread_mutex_lock(&g->lock);
    g->halt = g->halt || cns_go_on(cns_monitor_stop(g->e->monitor), &g->why) != CNS_OK;
    cns_ensemble_job *job = g->halt || g->next == g->missing ? NULL : &g->jobs[g->next++];
    pthread_mutex_unlock(&g->lock);
    return job;
}

static void work_on(gang *g)
{
    for (cns_ensemble_job *job; (job = take(g)) != NULL;)
        work(g, job);
}

static void *helper(void *context)
{
    work_on(context);
    flint_cleanup(); /* what FLINT and MPFR keep for this thread */
    return NULL;
}

/* The calling thread and as many others as there are jobs and threads for. Where the system grants fewer,
 * these do all the work. */
static void work_together(gang *g)
{
    const int allowed = cns_monitor_threads(g->e->monitor),
              threads = allowed < g->missing ? allowed : g->missing;
    pthread_t *thread = cns_xalloc((size_t)(threads > 0 ? threads : 1), sizeof *thread);
    int others = 0;
    while (others < threads - 1 && pthread_create(&thread[others], NULL, helper, g) == 0)
        others++;
    work_on(g);
    while (others > 0)
        pthread_join(thread[--others], NULL);
    free(thread);
}

static int costlier(const void *a, const void *b)
{
    const cns_ensemble_job *p = a, *q = b;
    if (p->cost != q->cost)
        return p->cost < q->cost ? 1 : -1;
    return (p->number > q->number) - (p->number < q->number);
}

static cns_code verdict(const gang *g, cns_error *err)
{
    const cns_ensemble *e = g->e;
    for (int i = 0; i < e->n; i++)
        if (g->codes[i] != CNS_OK && g->codes[i] != CNS_STOPPED) {
            *err = g->errors[i];
            return g->codes[i];
        }
    if (g->ended < g->missing && g->why.code == CNS_MEMORY)
        return cns_fail(err, CNS_MEMORY, "%s", g->why.text);
    if (g->ended < g->missing)
        return cns_fail(err, CNS_STOPPED, "stopped with %d of %d runs done", e->n - g->missing + g->ended,
                        e->n);
    return CNS_OK;
}

cns_code cns_ensemble_run(const cns_ensemble *e, char **results, cns_error *err)
{
    for (int i = 0; i < e->n; i++)
        results[i] = NULL;
    if (e->directory != NULL && e->identity == NULL)
        return cns_out_of_memory(err);
    if (e->directory != NULL && cns_directory_make(e->directory, err) != CNS_OK)
        return err->code;
    for (int i = 0; i < e->n && e->directory != NULL; i++)
        if (recall(e, i, &results[i], err) != CNS_OK)
            return err->code;
    const size_t n = (size_t)e->n;
    gang g = {.lock = PTHREAD_MUTEX_INITIALIZER,
              .e = e,
              .results = results,
              .jobs = cns_xalloc(n, sizeof *g.jobs),
              .codes = cns_xalloc(n, sizeof *g.codes),
              .errors = cns_xalloc(n, sizeof *g.errors)};
    for (int i = 0; i < e->n; i++) {
        if (results[i] != NULL)
            continue;
        g.jobs[g.missing] = (cns_ensemble_job){&g, i, e->cost(e->context, i), 0};
        g.total += g.jobs[g.missing++].cost;
    }
    qsort(g.jobs, (size_t)g.missing, sizeof *g.jobs, costlier);
    work_together(&g);
    cns_code code = verdict(&g, err);
    free(g.jobs);
    free(g.codes);
    free(g.errors);
    return code;
}
