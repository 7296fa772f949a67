#include "files.h"

#include <errno.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
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

/* There is one umask for all threads, and reading it changes it. */
static pthread_mutex_t umask_lock = PTHREAD_MUTEX_INITIALIZER;

FILE *cns_file_create(const char *path, char **aside)
{
    const size_t size = strlen(path) + 8;
    *aside = NULL;
    if (special(path))
        return fopen(path, "w");
    *aside = cns_xalloc(size, 1);
    snprintf(*aside, size, "%s.XXXXXX", path);
    const int fd = mkstemp(*aside);
    mode_t mask;
    pthread_mutex_lock(&umask_lock);
    mask = umask(0);
    umask(mask);
    pthread_mutex_unlock(&umask_lock);
    if (fd >= 0)
        fchmod(fd, 0666 & ~mask); /* mkstemp is for secrets; this has the mode of any new file */
    FILE *f = fd >= 0 ? fdopen(fd, "w") : NULL;
    if (f == NULL) {
        const int cause = errno;
        free(*aside);
        *aside = NULL;
        errno = cause;
    }
    return f;
}

int cns_file_finish(FILE *f, const char *path, char *aside, bool keep)
{
    bool good = keep && !ferror(f) && fflush(f) == 0 && (aside == NULL || fsync(fileno(f)) == 0);
    int cause = errno;
    if (fclose(f) != 0 && good) {
        good = false;
        cause = errno;
    }
    if (good && aside != NULL && rename(aside, path) != 0) {
        good = false;
        cause = errno;
    }
    if (!good && aside != NULL)
        unlink(aside);
    free(aside);
    return good || !keep ? 0 : cause != 0 ? cause : EIO;
}

/* "cannot WHAT PATH: CAUSE" */
static cns_code failed(const char *what, const char *path, int cause, cns_error *err)
{
    char *shown = cns_text_printable(path);
    const cns_code code = cns_fail(err, CNS_IO, "cannot %s %.300s: %s", what, shown, strerror(cause));
    free(shown);
    return code;
}

cns_code cns_file_replace(const char *path, const char *text, cns_error *err)
{
    char *aside;
    errno = 0;
    FILE *out = cns_file_create(path, &aside);
    int cause = errno;
    if (out != NULL) {
        fputs(text, out);
        cause = cns_file_finish(out, path, aside, true);
    }
    return cause == 0 ? CNS_OK : failed("write", path, cause, err);
}

cns_code cns_directory_make(const char *path, cns_error *err)
{
    struct stat what;
    if (mkdir(path, 0777) == 0 || (errno == EEXIST && stat(path, &what) == 0 && S_ISDIR(what.st_mode)))
        return CNS_OK;
    return failed("make the directory", path, errno == EEXIST ? ENOTDIR : errno, err);
}
