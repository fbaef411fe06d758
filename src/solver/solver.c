#include "solver.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

bool hc_solver_works_with(const hc_solver_ops *solver, const char *control) {
  if (!solver->controls) return true;
  for (const char *const *name = solver->controls; *name; name++)
    if (strcmp(*name, control) == 0) return true;
  return false;
}

void hc_solver_tell_caps(const hc_solver_caps *caps, char *text, size_t size) {
  snprintf(text, size,
           "iteration caps hit: density solver %" PRId64 ", divergence solver %" PRId64 " of %" PRId64
           " steps",
           caps->density, caps->divergence, caps->steps);
}

/* Refuses the particle with the largest value, of all ranks, if that is more than `most`; `text` says why,
 * with its place before it. */
static hc_status refuse_largest(const hc_world *world, const float *values, double sign, double most,
                                const char *text, hc_error *error) {
  const hc_particles *fluid = world->fluid;
  int32_t worst = 0;
  for (int32_t k = 1; k < fluid->own; k++)
    if (sign * (double)values[k] > sign * (double)values[worst]) worst = k;
  const double own = fluid->own > 0 ? sign * (double)values[worst] : -INFINITY;
  double largest = own;
  hc_comm_max_f64(world->comm, &largest, 1);
  if (largest > most && largest == own) {
    double at[3];
    for (int axis = 0; axis < 3; axis++)
      at[axis] = hc_frame_to_metres(&world->frame, axis, fluid->position[3 * (size_t)worst + (size_t)axis]);
    hc_error_set(error, HC_BAD_INPUT, "the fluid at (%.6g, %.6g, %.6g) m %s", at[0], at[1], at[2], text);
  }
  return hc_comm_agree(world->comm, error);
}

hc_status hc_solver_check_density(const hc_world *world, const hc_solver_settings *settings, double most,
                                  const char *key, hc_error *error) {
  static const double FULL = 0.9; /* beside a free surface it is 0.85 at most */
  char text[256];
  snprintf(text, sizeof text,
           "is more than %.3g %%%s too dense at the start: fluid lattices must not overlap, be settled if "
           "they are disordered, and keep half a spacing from walls, which must be a spacing thick",
           100.0 * most, key);
  if (refuse_largest(world, world->fluid->density, 1.0, settings->rest_density * (1.0 + most), text, error) !=
      HC_OK)
    return error->status;
  if (!settings->negative_pressure) return HC_OK;
  snprintf(
      text, sizeof text,
      "has less than %.3g %% of its rest density at the start, as at a free surface: "
      "solver.negative_pressure must not be true there, for it would pull the fluid together in one step",
      100.0 * FULL);
  return refuse_largest(world, world->fluid->density, -1.0, -FULL * settings->rest_density, text, error);
}

hc_status hc_solver_check_walls(const hc_world *world, hc_error *error) {
  return refuse_largest(
      world, world->fluid->wall_density, 1.0, world->start_limit,
      "starts within the samples of a wall: it must keep half a spacing from walls, and a solid "
      "between two fluids must be a spacing thick",
      error);
}

hc_status hc_solver_check_settled(const hc_world *world, const hc_solver_settings *settings,
                                  hc_error *error) {
  static const double MOST = 0.05, MOST_IN_FULL = 0.2, FULL = 0.9;
  const double most = world->volume_factor > FULL ? MOST_IN_FULL : MOST;
  if (hc_solver_check_density(world, settings, most, "", error) != HC_OK) return error->status;
  return hc_solver_check_walls(world, error);
}
