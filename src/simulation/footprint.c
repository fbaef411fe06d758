#include "footprint.h"

#include "state/copy.h"

#include <math.h>

enum {
  FLUID = 170,
  NEIGHBORS = 20 /* times the cube of the support radius in spacings */
};

double hc_footprint_fluid(const hc_scene *scene) {
  /* to go back to, and one more while a checkpoint is written */
  const int copies = scene->time_step.control == HC_TIME_ADAPTIVE ? HC_STATE_HISTORY + 1 : 0;
  return FLUID + NEIGHBORS * pow(scene->support_radius / scene->particle_spacing, 3) +
         copies * (double)hc_particles_state_bytes(HC_FLUID);
}

double hc_footprint_least(const hc_scene *scene, const hc_setup_plan *plan, int64_t ranks) {
  return HC_FOOTPRINT_PROGRAM + (hc_footprint_fluid(scene) * (double)plan->fluid_count +
                                 HC_FOOTPRINT_WALL * (double)plan->boundary_count) /
                                    (double)ranks;
}
