#include "weak.h"

#include "wall_layer.h"

#include <math.h>
#include <string.h>

void hc_weak_pressures(hc_world *world, const hc_weak_settings *settings, hc_selection selection,
                       const uint64_t *chosen, uint64_t *ghosts, hc_error_total *total) {
  const hc_selection border = hc_select_border(selection, world->fluid),
                     interior = hc_select_interior(selection, world->fluid);
  world->sweeps->weak_density(&world->sweep, &settings->tait, border, total);
  if (chosen)
    hc_halo_begin_some(world->halo, HC_SCALAR(place), chosen);
  else
    hc_halo_begin(world->halo, HC_SCALAR(place));
  world->sweeps->weak_density(&world->sweep, &settings->tait, interior, total);
  if (chosen)
    hc_halo_end_some(world->halo, ghosts);
  else
    hc_halo_end(world->halo);
}

/* The change of velocity over the longest step, but by gravity. */
static float *find_changes(hc_world *world, const hc_weak_settings *settings, float *rate,
                           hc_selection selection) {
  hc_solver_settings others = settings->common;
  float viscosity = 0.0f;
  if (others.viscosity == HC_VISCOUS_ARTIFICIAL) {
    viscosity = (float)(others.viscosity_coefficient * world->frame.support_radius * others.sound_speed);
    others.viscosity = HC_VISCOUS_NONE;
  }
  float *change = hc_find_forces(world, &others, settings->longest, NULL, selection);
  hc_wall_layer_add(world, &settings->common, settings->longest, change, selection);
  world->sweeps->weak_forces(&world->sweep, viscosity, (float)settings->longest, change, rate, selection);
  return change;
}

double hc_weak_accelerations(hc_world *world, const hc_weak_settings *settings, float *rate,
                             hc_selection selection) {
  float *const change = find_changes(world, settings, rate, selection);
  const double per_step = 1.0 / settings->longest;
  const bool alike = settings->common.central_rate == 0.0;
  double largest = 0.0, body[3];
  memcpy(body, settings->common.gravity, sizeof body);
  for (int32_t row = selection.begin; row < selection.end; row++) {
    const int32_t i = hc_selected(selection, row);
    double square = 0.0;
    if (!alike) hc_body_force(world, &settings->common, i, body);
    for (int axis = 0; axis < 3; axis++) {
      const double a = (double)change[3 * (size_t)i + (size_t)axis] * per_step + body[axis];
      change[3 * (size_t)i + (size_t)axis] = (float)a;
      square += a * a;
    }
    if (square > largest) largest = square;
  }
  return sqrt(largest);
}
