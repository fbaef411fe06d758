/* What those who understand more than keys find wrong with a scene, or worth a word, said where the user
 * wrote it. Local. */
#ifndef HC_FINDINGS_H
#define HC_FINDINGS_H

#include "complaints.h"
#include "given.h"

/* The reader makes one while the scene's text is at hand; see hc_scene_limits.check. */
typedef struct hc_findings {
  const hc_given *given;
  hc_complaints *errors, *warnings;
} hc_findings;

/* `path` is a key or an item, such as "domain.max", "fluid.blocks[2]" or "fluid.blocks[2].box.min"; it is
 * where the message points, not part of its text. An error refuses the scene, a warning does not. */
void hc_findings_error(hc_findings *findings, const char *path, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void hc_findings_warning(hc_findings *findings, const char *path, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
