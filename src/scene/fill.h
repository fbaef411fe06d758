/* A struct from what was given for its table: values, defaults, missing keys, alternatives, lists. */
#ifndef HC_FILL_H
#define HC_FILL_H

#include "given.h"
#include "scene_limits.h"

/* Fills the zeroed struct `owner`; lists are allocated with hc_alloc and become the struct's. Marks bad
 * values in `given`. Complains of all that is wrong. */
void hc_fill(hc_given *given, void *owner, const hc_scene_limits *limits, hc_complaints *complaints);

/* Sets a member to its default, or to zero if it has none (lists: no items, nothing is freed). */
void hc_fill_default(const hc_param *param, void *owner);

#endif
