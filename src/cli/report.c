#include "report.h"

#include <errno.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "core/files.h"

int cns_complain(cns_code code, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    fputs("cns: ", stderr);
    vfprintf(stderr, format, args);
    fputc('\n', stderr);
    va_end(args);
    return (int)code;
}

cns_code cns_open_case(const cns_options *o, cns_case **c)
{
    char *report = NULL;
    cns_code code = cns_case_load(o->operands.at[0], o->sets.at, o->sets.n, c, &report);
    if (report != NULL && code == CNS_USAGE)
        fprintf(stderr, "%s\n", report); /* the lines begin with the place, as compilers have it */
    else if (report != NULL)
        cns_complain(code, "%s", report);
    free(report);
    return code;
}

int cns_stdout_failed(int cause)
{
    if (cause == EPIPE)
        return CNS_STOPPED + SIGPIPE;
    return cns_complain(CNS_IO, "cannot write to standard output: %s", strerror(cause));
}

cns_code cns_page_open(cns_page *p)
{
    p->text = NULL;
    p->size = 0;
    p->file = open_memstream(&p->text, &p->size);
    if (p->file == NULL)
        return (cns_code)cns_complain(CNS_IO, "out of memory");
    return CNS_OK;
}

int cns_page_print(cns_page *p)
{
    int code = CNS_OK;
    bool lost = ferror(p->file) != 0;
    if (fclose(p->file) != 0 || lost) {
        code = cns_complain(CNS_IO, "out of memory");
    } else {
        errno = 0;
        if (fwrite(p->text, 1, p->size, stdout) != p->size || fflush(stdout) != 0)
            code = cns_stdout_failed(errno);
    }
    free(p->text);
    return code;
}

int cns_page_write(cns_page *p, const char *path)
{
    cns_error err;
    if (path == NULL)
        return cns_page_print(p);
    bool lost = ferror(p->file) != 0;
    if (fclose(p->file) != 0 || lost) {
        free(p->text);
        return cns_complain(CNS_IO, "out of memory");
    }
    cns_code code = cns_file_replace(path, p->text, &err);
    free(p->text);
    return code ? cns_complain(code, "%s", err.text) : CNS_OK;
}
