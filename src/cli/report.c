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

static int write_out(const char *text)
{
    const size_t size = strlen(text);
    errno = 0;
    if (fwrite(text, 1, size, stdout) == size && fflush(stdout) == 0)
        return 0;
    if (errno == EPIPE)
        return CNS_STOPPED + SIGPIPE;
    return cns_complain(CNS_IO, "cannot write to standard output: %s", strerror(errno));
}

int cns_page_write(cns_text_stream *page, const char *path)
{
    cns_error err;
    int status = 0;
    char *text = cns_text_close(page, &err);
    if (text != NULL && path == NULL)
        status = write_out(text);
    else if (text == NULL || cns_file_replace(path, text, &err))
        status = cns_complain(err.code, "%s", err.text);
    free(text);
    return status;
}

static int show_text(const cns_context *cx, const cns_view *view, const void *result, const char *path)
{
    cns_text_stream page;
    cns_text_open(&page);
    view->text(page.file, cx, result);
    return cns_page_write(&page, path);
}

static int show_summary(const cns_context *cx, const cns_view *view, const void *result)
{
    cns_text_stream page;
    cns_text_open(&page);
    cns_summary *s = cns_summary_open(page.file);
    view->yaml(s, cx, result);
    if (cns_summary_close(s))
        return cns_page_write(&page, NULL);
    free(cns_text_close(&page, NULL));
    return cns_complain(CNS_MEMORY, "out of memory: cannot write the summary");
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
