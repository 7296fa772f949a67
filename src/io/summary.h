/* Summaries as YAML documents, through libyaml's emitter. */
#ifndef CNS_IO_SUMMARY_H
#define CNS_IO_SUMMARY_H

#include <stdbool.h>
#include <stdio.h>

typedef struct cns_summary cns_summary;

/* Begins a document, which is a mapping. What fails later is told by cns_summary_close() alone. */
cns_summary *cns_summary_open(FILE *out);

/* A value with its key in the mapping at hand, or, with key NULL, an item of the list at hand. The emitter
 * quotes and escapes texts, which are UTF-8. */
void cns_summary_text(cns_summary *s, const char *key, const char *text);
void cns_summary_long(cns_summary *s, const char *key, long value);
void cns_summary_seconds(cns_summary *s, const char *key, double value); /* three decimals */
void cns_summary_number(cns_summary *s, const char *key, double value,
                        int digits); /* so many significant digits; null if it is not finite */

/* A mapping or a list as the value, at most 16 deep. It is the one at hand until it is shut. */
void cns_summary_open_mapping(cns_summary *s, const char *key);
void cns_summary_open_list(cns_summary *s, const char *key);
void cns_summary_shut(cns_summary *s);

/* Ends the document and frees s; false if anything could not be written. */
bool cns_summary_close(cns_summary *s);

#endif
