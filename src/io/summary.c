#include "summary.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

#include "core/memory.h"

enum { DEPTH = 16 };

struct cns_summary {
    yaml_emitter_t emitter;
    bool failed;
    int depth;
    bool is_list[DEPTH]; /* of each open collection */
};

/* Gives the event, if it could be made, to the emitter, which frees it. */
static void emit(cns_summary *s, yaml_event_t *event, int made)
{
    if (s->failed && made)
        yaml_event_delete(event);
    else if (s->failed || !made || !yaml_emitter_emit(&s->emitter, event))
        s->failed = true;
}

static void begin_mapping(cns_summary *s)
{
    yaml_event_t event;
    emit(s, &event, yaml_mapping_start_event_initialize(&event, NULL, NULL, 1, YAML_BLOCK_MAPPING_STYLE));
}

static void end_mapping(cns_summary *s)
{
    yaml_event_t event;
    emit(s, &event, yaml_mapping_end_event_initialize(&event));
}

cns_summary *cns_summary_open(FILE *out)
{
    cns_summary *s = cns_xalloc(1, sizeof *s);
    yaml_event_t event;
    if (!yaml_emitter_initialize(&s->emitter)) {
        s->failed = true;
        return s;
    }
    yaml_emitter_set_output_file(&s->emitter, out);
    yaml_emitter_set_unicode(&s->emitter, 1);
    emit(s, &event, yaml_stream_start_event_initialize(&event, YAML_UTF8_ENCODING));
    emit(s, &event, yaml_document_start_event_initialize(&event, NULL, NULL, NULL, 1));
    begin_mapping(s);
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

void cns_summary_number(cns_summary *s, const char *key, double value, int digits)
{
    char text[48];
    snprintf(text, sizeof text, "%.*g", digits, value == 0 ? 0 : value); /* no -0 */
    cns_summary_text(s, key, isfinite(value) ? text : "null");
}

/* Room for a collection, with its key; false if there is none. */
static bool push(cns_summary *s, const char *key, bool is_list)
{
    if (s->depth == DEPTH) {
        s->failed = true;
        return false;
    }
    s->is_list[s->depth++] = is_list;
    if (key != NULL)
        scalar(s, key);
    return true;
}

void cns_summary_open_mapping(cns_summary *s, const char *key)
{
    if (push(s, key, false))
        begin_mapping(s);
}

void cns_summary_open_list(cns_summary *s, const char *key)
{
    yaml_event_t event;
    if (push(s, key, true))
        emit(s, &event,
             yaml_sequence_start_event_initialize(&event, NULL, NULL, 1, YAML_BLOCK_SEQUENCE_STYLE));
}

void cns_summary_shut(cns_summary *s)
{
    yaml_event_t event;
    if (s->depth == 0)
        s->failed = true;
    else if (s->is_list[--s->depth])
        emit(s, &event, yaml_sequence_end_event_initialize(&event));
    else
        end_mapping(s);
}

bool cns_summary_close(cns_summary *s)
{
    yaml_event_t event;
    end_mapping(s);
    emit(s, &event, yaml_document_end_event_initialize(&event, 1));
    emit(s, &event, yaml_stream_end_event_initialize(&event));
    const bool written = !s->failed;
    yaml_emitter_delete(&s->emitter);
    free(s);
    return written;
}
