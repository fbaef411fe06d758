/* timings.json: where the time of a run went. Local, for rank 0, with numbers that were reduced before. */
#ifndef HC_TIMINGS_H
#define HC_TIMINGS_H

#include "halocline/error.h"

#include <stdint.h>

/* Over the ranks. */
typedef struct hc_timings_spread {
  double min, mean, max;
} hc_timings_spread;

typedef struct hc_timings_stage {
  const char *name;
  hc_timings_spread seconds;
} hc_timings_stage;

typedef struct hc_timings {
  int ranks;
  int64_t steps;
  int64_t fluid_particles, boundary_particles; /* at the end */
  double particle_steps;                       /* fluid particles summed over the steps */
  double wall_seconds;                         /* of the steps, set-up not counted */
  double simulated_seconds;
  int64_t halo_bytes, messages;              /* of all ranks together, set-up included */
  int64_t sparse_exchanges, reductions;      /* of one rank, as all take part; likewise */
  int64_t other_collectives, gathered_bytes; /* likewise */
  int64_t rebalances, moved_particles;       /* moved by rebalances, boundary particles included */
  double rebalance_seconds;                  /* the slowest rank's */
  double imbalance;                          /* largest over mean work of a rank, over all steps */
  int64_t rollbacks, rollback_steps;         /* since the run's start; steps that they took back */
  hc_timings_spread ghosts;                  /* at the end */
  hc_timings_spread private_bytes;           /* resident at the end, without files and what processes share */
  hc_timings_spread memory_bytes;            /* high-water mark of resident memory */
  const hc_timings_stage *stages;
  int stage_count;
} hc_timings;

/* Writes DIRECTORY/timings.json, whole or not at all, with particle_steps_per_second and ns_per_particle_step
 * worked out. HC_IO_FAILED if it cannot be written. */
hc_status hc_timings_write(const hc_timings *timings, const char *directory, hc_error *error);

#endif
