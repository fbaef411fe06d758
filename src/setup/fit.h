/* Rest states fit themselves to what is there: particles within their blocks' shapes are fluid, those within
 * a support radius around are air, which completes the neighbourhoods while it is chosen which of the fluid
 * stays; and none is behind a wetted surface (Carensac et al. 2023, section 3.1). */
#ifndef HC_FIT_H
#define HC_FIT_H

#include "setup/source.h"

/* What rest states must keep away from. */
typedef struct hc_fit {
  const hc_frame *frame;
  const hc_setup_source *surfaces; /* walls, then bodies as they start */
  int walls, bodies;
  double distance; /* m: from wetted surfaces */
} hc_fit;

/* What the scene's rest states keep away from: its surfaces, as their sources say. */
hc_fit hc_setup_fit_of(const hc_scene *scene, const hc_frame *frame, const hc_setup_source *surfaces);

/* Leaves out samples of a block that is filled by a rest state, and makes its air: the same samples, of which
 * others are left out. Where a periodic axis is filled all around, the block ends as its period does. Local.
 */
void hc_setup_fit(const hc_fit *fit, hc_setup_source *block, hc_setup_source *air);

#endif
