/* Files that are told apart by a number: PREFIX, digits, SUFFIX, such as ckpt_00000012.h5; and their
 * temporaries, with a dot before and ".tmp" behind. Local. */
#ifndef HC_NUMBERED_H
#define HC_NUMBERED_H

#include "halocline/error.h"

#include <stddef.h>
#include <stdint.h>

typedef struct hc_numbered {
  const char *folder, *prefix, *suffix;
} hc_numbered;

/* The numbers of all whole files (no temporaries), largest first, allocated (hc_free). A folder that is not
 * there is empty. HC_IO_FAILED if it cannot be read; there is nothing to free then. */
hc_status hc_numbered_list(const hc_numbered *files, int64_t **numbers, size_t *count, hc_error *error);

/* Removes those with this number or a later one, temporaries too. HC_IO_FAILED if one cannot be. */
hc_status hc_numbered_remove(const hc_numbered *files, int64_t from, hc_error *error);

#endif
