/* What acts in a weakly compressible fluid: pressures from densities, accelerations from pressures,
 * viscosity, walls and gravity, of the particles of a selection. The solver that steps with it is wcsph.c. */
#ifndef HC_WEAK_H
#define HC_WEAK_H

#include "solver.h"

typedef struct hc_weak_settings {
  hc_solver_settings common;
  hc_tait tait;
  double sound_speed;    /* m/s */
  double fluctuation;    /* permitted on average, a fraction of the rest density */
  double support_radius; /* m */
  double longest;        /* s: the longest step that is stable, of a particle too */
} hc_weak_settings;

/* The lists are of all particles; `selection` is all, or with an index of_all. Local but for the halo. */

/* Densities, pressures and what walls share in them, of selected own particles, and of the copies of `chosen`
 * (bits of own particles; null: all); `ghosts`, unless null, receives a bit for each of these copies. Adds
 * what hc_sweeps.weak_density does to the total. Places of ghosts must be current. Collective among partners.
 */
void hc_weak_pressures(hc_world *world, const hc_weak_settings *settings, hc_selection selection,
                       const uint64_t *chosen, uint64_t *ghosts, hc_error_total *total);

/* Accelerations of selected own particles, m/s2, three a particle, gravity included, in the store's scratch;
 * into `rate`, unless null, dD/dt. What walls do beside their pressure, behind hc_wall_layer_look, is found
 * as over the longest step, of which friction is a small share. Returns the largest of finite ones. Pressures
 * and motions must be current, those of ghosts too. Local. */
double hc_weak_accelerations(hc_world *world, const hc_weak_settings *settings, float *rate,
                             hc_selection selection);

/* Where hc_weak_accelerations has left them. */
static inline float *hc_weak_accelerations_of(hc_world *world) {
  return hc_particles_scratch(world->fluid, 3 * sizeof(float));
}

#endif
