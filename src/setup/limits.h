/* The limits of the world: where a fluid particle has left it. */
#ifndef HC_LIMITS_H
#define HC_LIMITS_H

#include "setup/populate.h"
#include "sources/emitters.h"

/* Room for splashes, on the side against gravity by default; longest edges of the scene. */
#define HC_LIMITS_ROOM 4.0

/* What lies in [low, high] along all axes is within. */
typedef struct hc_limits {
  int64_t low[3], high[3]; /* units; INT64_MIN and INT64_MAX: no limit */
} hc_limits;

/* The scene's domain.limits where it gives them. Elsewhere the smallest box around all particles at the
 * start, all places that walls come to and emitters, widened by its longest edge on every side, by
 * HC_LIMITS_ROOM of them against gravity; no limits where there are no walls, for nothing holds the fluid
 * there. Periodic axes have none. `plan` and `emitters` are those of the same scene. HC_BAD_INPUT: a block of
 * fluid or an emitter that reaches beyond the limits; a wall that moves beyond all positions. Local. */
hc_status hc_setup_limits(const hc_scene *scene, const hc_setup_plan *plan, const hc_emitters *emitters,
                          hc_limits *limits, hc_error *error);

/* One of them, as the position of a particle, m; infinite where there is none. Local. */
double hc_limits_low(const hc_limits *limits, const hc_frame *frame, int axis);
double hc_limits_high(const hc_limits *limits, const hc_frame *frame, int axis);

/* Local. */
static inline bool hc_limits_hold(const hc_limits *limits, const int64_t position[3]) {
  for (int axis = 0; axis < 3; axis++)
    if (position[axis] < limits->low[axis] || position[axis] > limits->high[axis]) return false;
  return true;
}

#endif
