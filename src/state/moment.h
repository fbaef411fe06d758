/* A moment of a run: what snapshots and checkpoints are made of. */
#ifndef HC_MOMENT_H
#define HC_MOMENT_H

#include "particles/particles.h"
#include "space/frame.h"

/* Borrowed: valid as long as the run stands still. */
typedef struct hc_moment {
  const hc_frame *frame;
  const hc_particles *fluid, *boundary; /* boundary: of walls that stand still */
  int64_t step;
  double time, dt;            /* s */
  double particle_mass;       /* kg, of a fluid particle */
  const hc_particles *moving; /* boundary particles of walls that move; null: none */
} hc_moment;

#endif
