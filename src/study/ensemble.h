/* Ensembles: independent jobs over the cores, longest first, each with a text as its result.
 *
 * The results depend neither on the number of threads nor on the order in which jobs end. With a directory
 * every result is kept there in a file of its own as soon as it is there, written aside and renamed, so that
 * nothing that has been computed is lost: the same ensemble with the same directory does only what is
 * missing. A file that belongs to another identity, is not whole, or is not what was written counts as
 * missing. A file of another kind under a name that is needed is not touched: CNS_USAGE, before anything is
 * done. */
#ifndef CNS_STUDY_ENSEMBLE_H
#define CNS_STUDY_ENSEMBLE_H

#include <stddef.h>

#include "cns/monitor.h"
#include "cns/status.h"

typedef struct cns_ensemble_job cns_ensemble_job;

typedef struct cns_ensemble {
    int n;
    const cns_monitor *monitor;
    const char *directory; /* made if it is not there; NULL: nothing is kept */
    const char *identity;  /* whatever all results depend on, by cns_system_identity(), NULL being its lack of
                              memory */
    void *context;
    /* A name for job i, unlike all others: it is the file's name, and part of the job's identity; written
     * to `name`, without slashes. */
    void (*name)(void *context, int i, char *name, size_t size);
    double (*cost)(void *context, int i); /* > 0, in any unit; the longest begin first */
    /* Does job i; *result is a new text, which free() frees. Runs on any thread. CNS_STOPPED when the
     * monitor's stop was raised. Any failure ends the ensemble; a job that has failed in a way that is a
     * result should say so in its text. */
    cns_code (*run)(void *context, int i, cns_ensemble_job *job, char **result, cns_error *err);
} cns_ensemble;

#define CNS_ENSEMBLE_NAME 128

/* A text in such a name: a long one as its SHA-256, since a part of it could be that of another; slashes as
 * '_'. */
typedef struct cns_ensemble_word {
    char text[65];
} cns_ensemble_word;

cns_ensemble_word cns_ensemble_word_for(const char *text);

/* Runs all jobs; results[0..n-1] are new texts, or NULL where a job was not done. The failure of the first
 * job, by number, is returned, after those at work have ended; CNS_STOPPED only if nothing failed. */
cns_code cns_ensemble_run(const cns_ensemble *e, char **results, cns_error *err);

/* How far the job is, 0..1, for the line of progress. Cheap: call it at every row. */
void cns_ensemble_tell(cns_ensemble_job *job, double fraction);

#endif
