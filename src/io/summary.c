#include "summary.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

#include "core/memory.h"

enum { DEPTH = 16 };

struct cns_summary {
    yaml_emitter_t emitter;
    int failed, depth;
    char list[DEPTH]; /* per open collection: is it a list? */
};

static void emit(cns_summary *s, yaml_event_t *event, int made)
{
    if (s->failed || !made || !yaml_emitter_emit(&s->emitter, event))
        s->failed = 1;
}

cns_summary *cns_summary_open(FILE *out)
{
    cns_summary *s = cns_xalloc(1, sizeof *s);
    yaml_event_t event;
    if (!yaml_emitter_initialize(&s->emitter)) {
        s->failed = 1;
        return s;
    }
    yaml_emitter_set_output_file(&s->emitter, out);
    yaml_emitter_set_unicode(&s->emitter, 1);
    emit(s, &event, yaml_stream_start_event_initialize(&event, YAML_UTF8_ENCODING));
    emit(s, &event, yaml_document_start_event_initialize(&event, NULL, NULL, NULL, 1));
    emit(s, &event, yaml_mapping_start_event_initialize(&event, NULL, NULL, 1, YAML_BLOCK_MAPPING_STYLE));
    return s;
}

static void scalar(cns_summary *s, const char *text)
{
    yaml_event_t event;
    emit(s, &event,
         yaml_scalar_event_initialize(&event, NULL, NULL, (const yaml_char_t *)text, (int)strlen(text), 1, 1,
                                      YAML_ANY_SCALAR_STYLE));
}

void cns_summary_text(cns_summary *s, const char *key, const char *text)
{
    if (key != NULL)
        scalar(s, key);
    scalar(s, text);
}

void cns_summary_number(cns_summary *s, const char *key, double value, int digits)
{
    char text[48];
    snprintf(text, sizeof text, "%.*g", digits, value == 0 ? 0 : value); /* no -0 */
    cns_summary_text(s, key, isfinite(value) ? text : "null");
}

static void open_collection(cns_summary *s, const char *key, int list)
{
    yaml_event_t event;
    if (key != NULL)
        scalar(s, key);
    if (s->depth == DEPTH) {
        s->failed = 1;
        return;
    }
    s->list[s->depth++] = (char)list;
    if (list)
        emit(s, &event,
             yaml_sequence_start_event_initialize(&event, NULL, NULL, 1, YAML_BLOCK_SEQUENCE_STYLE));
    else
        emit(s, &event, yaml_mapping_start_event_initialize(&event, NULL, NULL, 1, YAML_BLOCK_MAPPING_STYLE));
}

void cns_summary_open_mapping(cns_summary *s, const char *key)
{
    open_collection(s, key, 0);
}

void cns_summary_open_list(cns_summary *s, const char *key)
{
    open_collection(s, key, 1);
}

void cns_summary_shut(cns_summary *s)
{
    yaml_event_t event;
    if (s->depth == 0)
        s->failed = 1;
    else if (s->list[--s->depth])
        emit(s, &event, yaml_sequence_end_event_initialize(&event));
    else
        emit(s, &event, yaml_mapping_end_event_initialize(&event));
}

void cns_summary_long(cns_summary *s, const char *key, long value)
{
    char text[32];
    snprintf(text, sizeof text, "%ld", value);
    cns_summary_text(s, key, text);
}

void cns_summary_seconds(cns_summary *s, const char *key, double value)
{
    char text[32];
    snprintf(text, sizeof text, "%.3f", value);
    cns_summary_text(s, key, text);
}

int cns_summary_close(cns_summary *s)
{
    yaml_event_t event;
    emit(s, &event, yaml_mapping_end_event_initialize(&event));
    emit(s, &event, yaml_document_end_event_initialize(&event, 1));
    emit(s, &event, yaml_stream_end_event_initialize(&event));
    int ok = !s->failed;
    yaml_emitter_delete(&s->emitter);
    free(s);
    return ok;
}
