/* From a plan to the numbers of its samples. */
#ifndef HC_SAMPLES_H
#define HC_SAMPLES_H

#include "setup/populate.h"
#include "sources/places.h"

/* Numbers those of the blocks; the caller frees `first`, also after an error. HC_BAD_INPUT: more than ids can
 * name. Local. */
hc_status hc_setup_sample_numbers(const hc_setup_plan *plan, hc_sample_numbers *numbers, hc_error *error);

#endif
