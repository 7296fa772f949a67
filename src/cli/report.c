#include "report.h"

#include <errno.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/text.h"
#include "terminal.h"

enum { MESSAGE = 4096, HANG = 5 /* of folded messages: under the text behind "cns: " */ };

void cns_say(const char *text)
{
    const int width = cns_terminal_width(STDERR_FILENO);
    if (width > 0)
        cns_text_fold(stderr, text, width, HANG);
    else /* in one piece: others may write into the same log */
        fprintf(stderr, "%s\n", text);
}

static void say(const char *lead, const char *format, va_list args)
{
    char text[MESSAGE];
    snprintf(text, sizeof text, "%s", lead);
    const size_t used = strlen(text);
    vsnprintf(text + used, sizeof text - used, format, args);
    cns_text_make_printable(text); /* what users have written may hold anything */
    cns_say(text);
}

int cns_complain(cns_code code, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    say("cns: ", format, args);
    va_end(args);
    return (int)code;
}

int cns_complain_of_case(const cns_case *c, const char *format, ...)
{
    char lead[1024];
    va_list args;
    snprintf(lead, sizeof lead, "%.1000s:1:1: ", c->name);
    va_start(args, format);
    say(lead, format, args);
    va_end(args);
    return CNS_USAGE;
}

void cns_note(cns_context *cx, const char *format, ...)
{
    va_list args;
    cns_meter_clear(&cx->meter);
    if (cx->o->quiet)
        return;
    va_start(args, format);
    say("cns: ", format, args);
    va_end(args);
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

void cns_print_criterion(FILE *out, const cns_case *c)
{
    if (c->laws.criterion == CNS_TC_ROWS)
        fprintf(out,
                "criterion rows: |u1 - u2| > delta |u2| (norm: distance > delta) at a row, rows every %s;\n"
                "from the time between that row and the one before from which on it holds\n",
                c->every.text);
    else
        fputs("criterion envelope: the first time of |u1 - u2| > delta max |u2|, the maximum up to then\n"
              "(norm: of distance > delta)\n",
              out);
}

void cns_summarise_criterion(cns_summary *s, const cns_case *c)
{
    cns_summary_text(s, "criterion", cns_tc_criterion_name(c->laws.criterion));
    if (c->laws.criterion == CNS_TC_ROWS)
        cns_summary_text(s, "every", c->every.text);
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

/* Folds what is in the page; nothing is left in it if there is not memory for all of it. */
static int fold(cns_text_stream *page)
{
    cns_error err;
    const int width = cns_terminal_width(STDOUT_FILENO);
    char *text = cns_text_close(page, &err);
    cns_text_open(page);
    if (text == NULL)
        return cns_complain(err.code, "%s", err.text);
    cns_text_fold(page->file, text, width > 0 ? width : CNS_TEXT_WIDTH, 0);
    free(text);
    return 0;
}

static int show_text(const cns_context *cx, const cns_view *view, const void *result, const char *path)
{
    cns_text_stream page;
    cns_text_open(&page);
    view->text(page.file, cx, result);
    const int status = view->folded ? fold(&page) : 0;
    const int written = cns_page_write(&page, path);
    return status ? status : written;
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
    cx->shown = result != NULL;
    int status = cns_context_status(cx, code, err);
    return shown ? shown : status;
}
