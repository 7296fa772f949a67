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

int cns_page_open(cns_page *p)
{
    *p = (cns_page){0};
    p->file = open_memstream(&p->text, &p->size);
    return p->file != NULL ? 0 : cns_complain(CNS_IO, "out of memory");
}

static int write_out(const cns_page *p)
{
    errno = 0;
    if (fwrite(p->text, 1, p->size, stdout) == p->size && fflush(stdout) == 0)
        return 0;
    if (errno == EPIPE)
        return CNS_STOPPED + SIGPIPE;
    return cns_complain(CNS_IO, "cannot write to standard output: %s", strerror(errno));
}

int cns_page_write(cns_page *p, const char *path)
{
    cns_error err;
    int status = 0;
    bool lost = ferror(p->file) != 0;
    if (fclose(p->file) != 0 || lost)
        status = cns_complain(CNS_IO, "out of memory");
    else if (path == NULL)
        status = write_out(p);
    else if (cns_file_replace(path, p->text, &err))
        status = cns_complain(err.code, "%s", err.text);
    free(p->text);
    return status;
}

void cns_page_drop(cns_page *p)
{
    fclose(p->file);
    free(p->text);
}

static int show_text(const cns_context *cx, const cns_view *view, const void *result, const char *path)
{
    cns_page page;
    int status = cns_page_open(&page);
    if (status)
        return status;
    view->text(page.file, cx, result);
    return cns_page_write(&page, path);
}

static int show_summary(const cns_context *cx, const cns_view *view, const void *result)
{
    cns_page page;
    int status = cns_page_open(&page);
    if (status)
        return status;
    cns_summary *s = cns_summary_open(page.file);
    view->yaml(s, cx, result);
    bool written = cns_summary_close(s);
    status = cns_page_write(&page, NULL);
    return status || written ? status : cns_complain(CNS_IO, "cannot write the summary");
}

int cns_show(const cns_context *cx, const cns_view *view, const void *result)
{
    const char *path = view->to_file ? cx->o->output : NULL;
    const bool yaml = cx->o->yaml && view->yaml != NULL;
    int status = 0;
    if (path != NULL || !yaml)
        status = show_text(cx, view, result, path);
    if (!status && yaml)
        status = show_summary(cx, view, result);
    return status;
}

int cns_report(cns_context *cx, cns_code code, const cns_error *err, const cns_view *view, const void *result)
{
    cns_meter_clear(&cx->meter);
    int shown = result != NULL ? cns_show(cx, view, result) : 0;
    int status = cns_context_status(cx, code, err);
    return shown ? shown : status;
}
