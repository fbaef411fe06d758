/* Everything wrong with one input, or doubtful in it, collected so that the user hears it in one go. */
#ifndef HC_COMPLAINTS_H
#define HC_COMPLAINTS_H

#include "base/warnings.h"

#include <stddef.h>

/* A text that is read: the scene file, or the value of one override. */
typedef struct hc_source {
  const char *name; /* shown before a message: the file's name, or "--set key=value" */
  const char *text;
  size_t length;
  int override; /* 0: a file, shown with line, column and the line itself; k: the k-th override, counted from
                   1 */
} hc_source;

typedef struct hc_place {
  const hc_source *source;
  int line, column; /* from 1; columns count characters. Line 0: the source as a whole */
} hc_place;

enum { HC_COMPLAINTS_MOST = 50, HC_COMPLAINT_TEXT = 512 };

typedef struct hc_complaint {
  hc_place place;
  int sequence; /* order of arrival */
  char text[HC_COMPLAINT_TEXT];
} hc_complaint;

typedef struct hc_complaints {
  hc_complaint kept[HC_COMPLAINTS_MOST];
  int total; /* may exceed the number kept */
} hc_complaints;

void hc_complaints_add(hc_complaints *complaints, hc_place place, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Sorts by place and writes all that fits, then whether there are more. */
void hc_complaints_text(hc_complaints *complaints, char *text, size_t size);

/* Sorts by place and adds each to `warnings` (which may be null). */
void hc_complaints_warn(hc_complaints *complaints, hc_warnings *warnings);

/* Bytes of the UTF-8 character at the start of `text`; 0 if it is none, -1 if it is a control character
 * (which must not reach a terminal) other than tab and line breaks. */
int hc_complaints_character(const char *text, size_t length);

#endif
