/* Summaries as YAML documents, through libyaml's emitter. */
#ifndef CNS_IO_SUMMARY_H
#define CNS_IO_SUMMARY_H

#include <stdio.h>

typedef struct cns_summary cns_summary;

cns_summary *cns_summary_open(FILE *out);
/* A scalar of the current mapping; numbers as decimal text. */
void cns_summary_text(cns_summary *s, const char *key, const char *text);
void cns_summary_long(cns_summary *s, const char *key, long value);
void cns_summary_seconds(cns_summary *s, const char *key, double value);
/* %.*g with so many significant digits; not finite: null. */
void cns_summary_number(cns_summary *s, const char *key, double value, int digits);

/* A mapping or a list as the value of key; key is NULL for an item of a list, also in the calls above.
 * What follows goes into it until it is shut. */
void cns_summary_open_mapping(cns_summary *s, const char *key);
void cns_summary_open_list(cns_summary *s, const char *key);
void cns_summary_shut(cns_summary *s);

/* Ends the document and frees s; false if anything could not be written. */
int cns_summary_close(cns_summary *s);

#endif
