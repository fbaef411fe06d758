#include "wall_force.h"

#include "sph/kernel.h"

#include <string.h>

/* A particle and a sample: their distance in support radii, and where the sample is. */
typedef struct pair {
  double d[3], q;
  double at[3];
} pair;

/* `back`: how long the particle has moved since it was where its record says, s. */
static pair make_pair(const hc_sweep *sweep, const hc_frame *frame, double back, int32_t i, int32_t b) {
  const hc_particles *fluid = sweep->fluid;
  pair pair;
  for (int axis = 0; axis < 3; axis++) {
    const int32_t units =
        (int32_t)((uint32_t)fluid->place[i].x[axis] - (uint32_t)sweep->boundary->place[b].x[axis]);
    pair.d[axis] = (double)units * sweep->scale[axis];
    pair.at[axis] = hc_frame_to_metres(frame, axis, fluid->position[3 * (size_t)i + axis]) -
                    back * fluid->velocity[3 * (size_t)i + axis] - (double)units * frame->unit[axis];
  }
  pair.q = sqrt(pair.d[0] * pair.d[0] + pair.d[1] * pair.d[1] + pair.d[2] * pair.d[2]);
  return pair;
}

/* What of a particle's pressure and a sample's acts between them, by how walls take part: times m/rho0 grad W
 * a force. */
static double strength(const hc_sweep *sweep, int32_t i, int32_t b) {
  const hc_particles *fluid = sweep->fluid, *boundary = sweep->boundary;
  switch (sweep->walls_add) {
  case HC_WALLS_MIRRORED:
    return (double)fluid->pressure[i] * (double)boundary->place[b].scalar;
  case HC_WALLS_PRESSURE:
    return (double)sweep->rest_density * sweep->volume *
           ((double)fluid->place[i].scalar + (double)boundary->place[b].scalar);
  case HC_WALLS_NOTHING:
  case HC_WALLS_DISTANCE:
    break;
  }
  return 0.0;
}

/* How much of a contact a sample takes. */
static double share(double q) {
  return fmax(0.0, 1.0 - q);
}

double hc_wall_force_later(const hc_sweep *sweep, double dt) {
  return sweep->contacts ? dt : 0.0;
}

/* What contact with walls has changed a particle's velocity by; null: nothing. `next`: the holds before are
 * those of particles before. */
static const float *contact_of(const hc_sweep *sweep, int32_t i, size_t *next) {
  if (sweep->contacts) return sweep->contacts[i].v;
  const hc_holds *const holds = sweep->holds;
  if (!holds || *next == holds->count || holds->at[*next].particle != i) return NULL;
  return holds->at[(*next)++].change;
}

void hc_wall_force_each(const hc_sweep *sweep, const hc_frame *frame, double dt, hc_wall_push_taker take,
                        void *context) {
  const hc_particles *fluid = sweep->fluid, *boundary = sweep->boundary;
  const double back = dt - hc_wall_force_later(sweep, dt);
  const double of_contact = -(double)sweep->rest_density * sweep->volume / dt;
  size_t next = 0;
  for (int32_t i = 0; i < fluid->own; i++) {
    const int32_t count = hc_list_count(sweep->walls, i);
    const uint32_t *offset = hc_list_row(sweep->walls, i);
    const float *const change = contact_of(sweep, i, &next);
    double shares = 0.0;
    for (int32_t k = 0; change && k < count; k++)
      shares += share(make_pair(sweep, frame, back, i, (int32_t)(offset[k] / sizeof(hc_record))).q);
    for (int32_t k = 0; k < count; k++) {
      const int32_t b = (int32_t)(offset[k] / sizeof(hc_record));
      const pair pair = make_pair(sweep, frame, back, i, b);
      hc_wall_push push = {.wall = (int)boundary->motion[b].scalar};
      memcpy(push.at, pair.at, sizeof push.at);
      const double pressure = pair.q < 1.0 ? strength(sweep, i, b) * sweep->volume * sweep->gradient : 0.0;
      const double contact = shares > 0.0 ? of_contact * share(pair.q) / shares : 0.0;
      if (pressure == 0.0 && contact == 0.0) continue;
      for (int axis = 0; axis < 3; axis++)
        push.force[axis] =
            (pressure != 0.0 ? pressure * hc_kernel_slope_over_q(pair.q) * pair.d[axis] : 0.0) +
            (contact != 0.0 ? contact * (double)change[axis] : 0.0);
      take(context, &push);
    }
  }
}
