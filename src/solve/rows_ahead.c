#include "rows_ahead.h"

#include <pthread.h>
#include <stdlib.h>
#include <time.h>

#include "core/monitor.h"
#include "problem.h"

enum { RING = 16 };

struct cns_ahead {
    const cns_problem *p;
    cns_trajectory *t;
    unsigned long row; /* the next to compute */
    bool threaded;
    volatile sig_atomic_t halt; /* what the thread's flow looks at */
    struct {
        cns_sample sample;
        cns_found_list found; /* since the sample before */
    } ring[RING];
    int ready;                /* places in the ring that are initialised */
    cns_found_list found;     /* on the way to the next row */
    unsigned long made, used; /* samples; made - used <= RING - 1 are waiting, and one is in use */
    cns_code code;            /* of the sample after the last made */
    cns_error err;
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t changed;
};

/* One sample into its place in the ring. */
static cns_code make(cns_ahead *a, cns_error *err)
{
    mpq_t time;
    mpq_init(time);
    cns_problem_row(a->p, a->row, time);
    cns_code code = cns_trajectory_at(a->t, time, &a->ring[a->made % RING].sample, err);
    if (!code && mpq_equal(time, a->p->end->ratio))
        code = cns_trajectory_tell_rest(a->t, err);
    cns_found_move(&a->ring[a->made % RING].found, &a->found);
    mpq_clear(time);
    a->row++;
    return code;
}

static void *work(void *context)
{
    cns_ahead *a = context;
    cns_error err = {0};
    mpq_t time;
    mpq_init(time);
    pthread_mutex_lock(&a->lock);
    while (!a->code) {
        while (a->made - a->used >= RING - 1 && !a->halt)
            pthread_cond_wait(&a->changed, &a->lock);
        if (a->halt || !cns_problem_row(a->p, a->row, time))
            break;
        pthread_mutex_unlock(&a->lock);
        cns_code code = make(a, &err);
        pthread_mutex_lock(&a->lock);
        a->code = code;
        a->err = err;
        a->made += !code;
        pthread_cond_broadcast(&a->changed);
    }
    pthread_mutex_unlock(&a->lock);
    mpq_clear(time);
    mpfr_free_cache(); /* of this thread */
    return NULL;
}

cns_ahead *cns_ahead_new(const cns_problem *p, const cns_trajectory_spec *spec, unsigned long first_row,
                         bool threaded, cns_error *err)
{
    cns_ahead *a = calloc(1, sizeof *a);
    if (!a) {
        cns_out_of_memory(err);
        return NULL;
    }
    cns_trajectory_spec own = *spec;
    own.met = cns_found_add;
    own.met_context = &a->found;
    a->found.n_states = cns_program_states(cns_system_program(p->system));
    a->p = p;
    a->row = first_row;
    pthread_mutex_init(&a->lock, NULL);
    pthread_cond_init(&a->changed, NULL);
    pthread_mutex_lock(&a->lock); /* the thread waits until there is something to do */
    a->threaded = threaded && pthread_create(&a->thread, NULL, work, a) == 0;
    if (a->threaded)
        own.flow.stop = &a->halt;
    a->t = cns_trajectory_new(&own, err);
    mpfr_prec_t prec = a->t ? cns_flow_prec(cns_trajectory_flow(a->t)) : 0;
    for (; a->t && a->ready < RING; a->ready++)
        if (!cns_sample_init(&a->ring[a->ready].sample, cns_system_program(p->system), prec)) {
            cns_out_of_memory(err);
            break;
        }
    a->halt = a->ready < RING;
    pthread_mutex_unlock(&a->lock);
    if (a->ready == RING)
        return a;
    cns_ahead_free(a);
    return NULL;
}

void cns_ahead_free(cns_ahead *a)
{
    if (!a)
        return;
    if (a->threaded) {
        pthread_mutex_lock(&a->lock);
        a->halt = 1;
        pthread_cond_broadcast(&a->changed);
        pthread_mutex_unlock(&a->lock);
        pthread_join(a->thread, NULL);
    }
    for (int i = 0; i < a->ready; i++) {
        cns_sample_clear(&a->ring[i].sample);
        cns_found_clear(&a->ring[i].found);
    }
    cns_found_clear(&a->found);
    cns_trajectory_free(a->t);
    pthread_cond_destroy(&a->changed);
    pthread_mutex_destroy(&a->lock);
    free(a);
}

/* Waits for a sample, looking at the problem's stop now and then: a signal does not wake a condition. */
static void await(cns_ahead *a)
{
    while (a->made == a->used && !a->code) {
        struct timespec until;
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_nsec += 100000000;
        if (until.tv_nsec >= 1000000000) {
            until.tv_nsec -= 1000000000;
            until.tv_sec++;
        }
        pthread_cond_timedwait(&a->changed, &a->lock, &until);
        if (cns_monitor_stopped(a->p->monitor))
            a->halt = 1;
    }
}

cns_code cns_ahead_next(cns_ahead *a, const cns_sample **s, cns_found_list *found, cns_error *err)
{
    cns_code code = CNS_OK;
    pthread_mutex_lock(&a->lock);
    if (a->threaded) {
        await(a);
        code = a->made == a->used ? a->code : CNS_OK;
        if (code)
            *err = a->err;
    } else {
        code = make(a, err);
        a->made += !code;
    }
    *s = &a->ring[a->used % RING].sample;
    if (!code) {
        cns_found_move(found, &a->ring[a->used % RING].found);
        a->used++;
        pthread_cond_broadcast(&a->changed);
    }
    pthread_mutex_unlock(&a->lock);
    return code;
}

bool cns_ahead_late(const cns_ahead *a)
{
    return cns_trajectory_late(a->t);
}
