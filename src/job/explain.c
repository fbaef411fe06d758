#include "explain.h"

#include <math.h>

/* A particle that stands out. */
typedef struct standout {
  double size; /* of its velocity or acceleration */
  int64_t id;
  double place[3]; /* m */
} standout;

static double square_of(const hc_particles *fluid, hc_step_bound bound, int32_t i) {
  double square = 0.0;
  for (int axis = 0; axis < 3; axis++) {
    const size_t at = 3 * (size_t)i + (size_t)axis;
    const double value = bound == HC_BOUND_VELOCITY ? fluid->velocity[at] : (double)fluid->acceleration[at];
    square += value * value;
  }
  return square;
}

/* The fluid particle with the largest velocity or acceleration, the smallest id among equals. */
static standout find_standout(const hc_world *world, hc_step_bound bound) {
  const hc_particles *fluid = world->fluid;
  double largest = -1.0;
  int32_t own = -1;
  for (int32_t i = 0; i < fluid->own; i++) {
    const double square = square_of(fluid, bound, i);
    if (square > largest || (square == largest && fluid->id[i] < fluid->id[own])) {
      largest = square;
      own = i;
    }
  }
  standout found = {.size = largest, .id = INT64_MAX, .place = {-INFINITY, -INFINITY, -INFINITY}};
  hc_comm_max_f64(world->comm, &found.size, 1);
  if (own >= 0 && largest == found.size) found.id = (int64_t)fluid->id[own];
  hc_comm_min_i64(world->comm, &found.id, 1);
  for (int axis = 0; axis < 3 && own >= 0 && (int64_t)fluid->id[own] == found.id; axis++)
    found.place[axis] =
        hc_frame_to_metres(&world->frame, axis, fluid->position[3 * (size_t)own + (size_t)axis]);
  hc_comm_max_f64(world->comm, found.place, 3);
  found.size = sqrt(found.size);
  return found;
}

void hc_explain_time_step(hc_explained *explained, const hc_simulation *simulation, hc_log *log) {
  const double dt = simulation->dt;
  const hc_step_bound bound = simulation->control.bound;
  const bool far = dt < 0.5 * explained->dt || dt > 2.0 * explained->dt;
  if (!far && (bound == explained->bound || bound == HC_BOUND_END)) return;
  /* A bound that takes turns with another one, or with growth, is no news. */
  if (!far && (bound == HC_BOUND_GROWTH || fabs(dt - explained->dt) < 0.1 * dt)) return;
  *explained = (hc_explained){dt, bound};
  if (simulation->world.fluid_total == 0 || (bound != HC_BOUND_VELOCITY && bound != HC_BOUND_FORCE)) {
    hc_log_info(log, "step %lld, t = %g s: time step %.4g s, bounded by: %s", (long long)simulation->step,
                simulation->time, dt, hc_step_bound_name(bound));
    return;
  }
  const standout found = find_standout(&simulation->world, bound);
  const double largest = hc_simulation_seen_by_control(simulation).v_max;
  if (bound == HC_BOUND_VELOCITY && largest > simulation->report.v_max) {
    hc_log_info(
        log, "step %lld, t = %g s: time step %.4g s, bounded by: velocity; walls or emitters have %.4g m/s",
        (long long)simulation->step, simulation->time, dt, largest);
    return;
  }
  hc_log_info(log,
              "step %lld, t = %g s: time step %.4g s, bounded by: %s; now particle %s at (%g, %g, %g) m "
              "has %.4g %s",
              (long long)simulation->step, simulation->time, dt, hc_step_bound_name(bound),
              hc_simulation_particle_name(simulation->scene, found.id).text, found.place[0], found.place[1],
              found.place[2], found.size, bound == HC_BOUND_VELOCITY ? "m/s" : "m/s2");
}
