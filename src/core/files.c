#include "files.h"

#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "memory.h"
#include "text.h"

char *cns_file_text(const char *path)
{
    FILE *in = fopen(path, "rb");
    if (in == NULL)
        return NULL;
    size_t room = 4096, used = 0, got;
    char *text = cns_xgrow(NULL, room, 1);
    while ((got = fread(text + used, 1, room - used - 1, in)) > 0) {
        used += got;
        if (room - used < 2)
            text = cns_xgrow(text, room *= 2, 1);
    }
    text[used] = '\0';
    if (ferror(in)) {
        free(text);
        text = NULL;
    }
    fclose(in);
    return text;
}

/* What is there and not an ordinary file; /dev/stdout may be one and is meant to be written to all the same.
 */
static bool special(const char *path)
{
    struct stat what;
    return stat(path, &what) == 0 && (!S_ISREG(what.st_mode) || strncmp(path, "/dev/", 5) == 0);
}

cns_code cns_file_failed(const char *what, const char *path, int cause, cns_error *err)
{
    char *shown = cns_text_printable(path);
    const cns_code code = cns_fail(err, cause == ENOMEM ? CNS_MEMORY : CNS_IO, "cannot %s %.300s: %s", what,
                                   shown, strerror(cause));
    free(shown);
    return code;
}

/* The names of files that are being written, where no lock is needed to read them. */
enum { MOST_UNFINISHED = 64 };
static _Atomic(char *) unfinished[MOST_UNFINISHED];

static bool change_unfinished(char *from, char *to)
{
    for (int i = 0; i < MOST_UNFINISHED; i++) {
        char *expected = from;
        if (atomic_compare_exchange_strong(&unfinished[i], &expected, to))
            return true;
    }
    return false;
}

/* A name that is not there any more is being read by cns_files_remove_unfinished(). */
static void forget_unfinished(char *name)
{
    if (change_unfinished(name, NULL))
        free(name);
}

void cns_files_remove_unfinished(void)
{
    for (int i = 0; i < MOST_UNFINISHED; i++) {
        char *name = atomic_exchange(&unfinished[i], NULL);
        if (name != NULL)
            unlink(name);
    }
}

/* There is one umask for all threads, and reading it changes it. */
static pthread_mutex_t umask_lock = PTHREAD_MUTEX_INITIALIZER;

/* A new file beside `path`, with the mode of any new file: mkstemp() is for secrets. */
static FILE *create_aside(const char *path, char **aside)
{
    const size_t size = strlen(path) + 8;
    mode_t mask;
    *aside = cns_xalloc(size, 1);
    snprintf(*aside, size, "%s.XXXXXX", path);
    change_unfinished(NULL, *aside); /* before it is there: a signal may end the program at any time */
    const int fd = mkstemp(*aside);
    FILE *stream = fd >= 0 ? fdopen(fd, "w") : NULL;
    if (stream != NULL) {
        pthread_mutex_lock(&umask_lock);
        mask = umask(0);
        umask(mask);
        pthread_mutex_unlock(&umask_lock);
        fchmod(fd, 0666 & ~mask);
        return stream;
    }
    const int cause = errno;
    if (fd >= 0) {
        unlink(*aside);
        close(fd);
    }
    forget_unfinished(*aside);
    *aside = NULL;
    errno = cause;
    return NULL;
}

cns_code cns_file_create(cns_file *f, const char *path, cns_error *err)
{
    *f = (cns_file){0};
    f->stream = special(path) ? fopen(path, "w") : create_aside(path, &f->aside);
    if (f->stream == NULL)
        return cns_file_failed("write", path, errno, err);
    f->path = cns_xcopy(path);
    return CNS_OK;
}

void cns_file_redirect(cns_file *f, const char *path)
{
    free(f->path);
    f->path = cns_xcopy(path);
}

cns_code cns_file_close(cns_file *f, bool keep, cns_error *err)
{
    cns_code code = CNS_OK;
    errno = 0;
    if (keep &&
        (fflush(f->stream) != 0 || ferror(f->stream) || (f->aside != NULL && fsync(fileno(f->stream)) != 0)))
        code = cns_file_failed("write", f->path, errno != 0 ? errno : EIO, err);
    errno = 0;
    if (fclose(f->stream) != 0 && keep && !code)
        code = cns_file_failed("write", f->path, errno, err);
    if (f->aside != NULL) {
        if (keep && !code && rename(f->aside, f->path) != 0)
            code = cns_file_failed("write", f->path, errno, err);
        if (!keep || code)
            unlink(f->aside);
        forget_unfinished(f->aside);
    }
    free(f->path);
    *f = (cns_file){0};
    return code;
}

cns_code cns_file_replace(const char *path, const char *text, cns_error *err)
{
    cns_file f;
    cns_code code = cns_file_create(&f, path, err);
    if (code)
        return code;
    fputs(text, f.stream);
    return cns_file_close(&f, true, err);
}

void cns_text_open(cns_text_stream *s)
{
    *s = (cns_text_stream){0};
    s->file = open_memstream(&s->text, &s->size);
    if (s->file == NULL) {
        cns_memory_hand_out();
        s->file = open_memstream(&s->text, &s->size);
    }
    if (s->file == NULL)
        cns_memory_give_up();
}

char *cns_text_close(cns_text_stream *s, cns_error *err)
{
    const bool lost = ferror(s->file) != 0;
    if (fclose(s->file) == 0 && !lost)
        return s->text;
    free(s->text);
    cns_out_of_memory(err);
    return NULL;
}

cns_code cns_directory_make(const char *path, cns_error *err)
{
    struct stat what;
    if (mkdir(path, 0777) == 0 || (errno == EEXIST && stat(path, &what) == 0 && S_ISDIR(what.st_mode)))
        return CNS_OK;
    return cns_file_failed("make the directory", path, errno == EEXIST ? ENOTDIR : errno, err);
}
