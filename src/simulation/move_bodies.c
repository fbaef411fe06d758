#include "move_bodies.h"

#include "base/memory.h"
#include "geometry/vector.h"

#include <string.h>

static bool is_beyond(const hc_simulation *simulation, const hc_body *body) {
  const hc_frame *const frame = &simulation->world.frame;
  const hc_limits *const limits = &simulation->population.limits;
  bool beyond = false;
  for (int axis = 0; axis < 3; axis++) {
    const double at = hc_frame_to_metres(frame, axis, body->position[axis]);
    beyond |= at + body->reach < hc_limits_low(limits, frame, axis) ||
              at - body->reach > hc_limits_high(limits, frame, axis);
  }
  return beyond;
}

/* A body that has left the world stays there where particles would be taken out, else it is a failure. */
static hc_status stop_body(const hc_simulation *simulation, int number, hc_error *error) {
  hc_body *const body = &simulation->bodies.body[number];
  const hc_frame *const frame = &simulation->world.frame;
  memset(body->velocity, 0, sizeof body->velocity);
  memset(body->momentum, 0, sizeof body->momentum);
  memset(body->held, 0, sizeof body->held);
  if (simulation->population.remove) return HC_OK;
  return hc_error_set(
      error, HC_FAILED,
      "body \"%s\" has left the world's limits at (%.6g, %.6g, %.6g) m: see domain.limits and "
      "domain.leaving",
      simulation->scene->bodies[number].surface.name, hc_frame_to_metres(frame, 0, body->position[0]),
      hc_frame_to_metres(frame, 1, body->position[1]), hc_frame_to_metres(frame, 2, body->position[2]));
}

hc_status hc_simulation_move_bodies(hc_simulation *simulation, double dt, hc_error *error) {
  hc_bodies *const bodies = &simulation->bodies;
  if (bodies->count == 0) return HC_OK;
  const size_t count = (size_t)bodies->count;
  hc_twist *const before = hc_alloc(count, sizeof *before), *const pushed = hc_alloc(count, sizeof *pushed);
  for (size_t k = 0; k < count; k++) before[k] = hc_body_momentum(&bodies->body[k]);
  if (hc_yield_take_loads(&simulation->loads, bodies, dt, error) == HC_OK) {
    for (size_t k = 0; k < count; k++) pushed[k] = hc_body_momentum(&bodies->body[k]);
    hc_contact_resolve(bodies, &simulation->world, dt);
  }
  for (int k = 0; k < bodies->count && error->status == HC_OK; k++) {
    hc_body *const body = &bodies->body[k];
    if (is_beyond(simulation, body)) {
      stop_body(simulation, k, error);
      continue;
    }
    hc_body_expect(bodies, body, &before[k], &pushed[k], dt);
    if (!hc_body_drift(bodies, body, dt))
      hc_error_set(error, HC_FAILED, "body \"%s\" moves at %.4g m/s, by more than a position can hold",
                   simulation->scene->bodies[k].surface.name, hc_vector_length(body->velocity));
  }
  hc_free(before);
  hc_free(pushed);
  return error->status;
}
