/* The nearest known name: what an unknown one was probably meant to be. */
#ifndef HC_NEAREST_H
#define HC_NEAREST_H

#include "params.h"

/* The known key or map most like the unknown `path`, into `nearest`; false if none is close. */
bool hc_nearest_key(const hc_param_table *table, const char *path, char nearest[static HC_PARAM_PATH]);

/* The name most like `name` among `count` names, or null if none is close. */
const char *hc_nearest_name(const char *const *names, int count, const char *name);

#endif
