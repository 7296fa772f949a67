#include "files.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "memory.h"

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

static cns_code failed(const char *path, int cause, cns_error *err)
{
    return cns_fail(err, CNS_IO, "cannot write %.300s: %s", path, strerror(cause));
}

/* A new file beside the path, whose name is the first `length` characters of `aside`. Not mkstemp, whose
 * files nobody else may read. */
static int open_aside(char *aside, size_t length)
{
    enum { NAMES = 0x1000000 };
    const unsigned long own = (unsigned long)getpid();
    int fd = -1;
    for (unsigned long i = 0; fd < 0 && i < NAMES; i++) {
        snprintf(aside + length, 8, ".%06lx", (own + i) % NAMES);
        fd = open(aside, O_WRONLY | O_CREAT | O_EXCL, 0666);
        if (fd < 0 && errno != EEXIST)
            break;
    }
    return fd;
}

cns_code cns_file_replace(const char *path, const char *text, cns_error *err)
{
    char *aside = cns_xalloc(strlen(path) + 8, 1);
    strcpy(aside, path);
    int fd = open_aside(aside, strlen(path));
    FILE *out = fd < 0 ? NULL : fdopen(fd, "wb");
    cns_code code = CNS_OK;
    if (out == NULL) {
        code = failed(path, errno, err);
        if (fd >= 0)
            close(fd);
    } else {
        errno = 0;
        bool good = fputs(text, out) >= 0 && fflush(out) == 0 && fsync(fd) == 0;
        const int cause = errno;
        good = fclose(out) == 0 && good;
        if (!good || rename(aside, path) != 0)
            code = failed(path, good ? errno : cause, err);
    }
    if (code != CNS_OK && fd >= 0)
        unlink(aside);
    free(aside);
    return code;
}

cns_code cns_directory_make(const char *path, cns_error *err)
{
    struct stat what;
    if (mkdir(path, 0777) == 0 || (errno == EEXIST && stat(path, &what) == 0 && S_ISDIR(what.st_mode)))
        return CNS_OK;
    return cns_fail(err, CNS_IO, "cannot make the directory %.300s: %s", path,
                    strerror(errno == EEXIST ? ENOTDIR : errno));
}
