/* `halocline info FILE`: what a snapshot holds. */
#ifndef HC_INFO_H
#define HC_INFO_H

#include "halocline/error.h"

#include <stdio.h>

/* Prints the scene, time and step, particles by kind, their extents, the fields with unit and range (of the
 * kinds that have the field; of a vector: of its magnitude) and the pieces. Local. HC_BAD_INPUT if the file
 * cannot be read, HC_IO_FAILED if `out` cannot be written. */
hc_status hc_info_print(const char *path, FILE *out, hc_error *error);

#endif
