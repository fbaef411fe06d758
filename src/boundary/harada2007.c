/* Harada, Koshizuka, Kawaguchi 2007, "Smoothed particle hydrodynamics on GPUs", section 4.3, in a
 * predictive-corrective form (Ihmsen et al. 2010, section 2).
 *
 * The distance from a wall is that from the plane through the samples near a particle. Nearer than r0 to it,
 * the particle is held at r0, by a force that does so within the step: so the velocity changes with the
 * position. The wall adds to the density what a half space of the rest lattice would at that distance,
 * whatever its shape. Known weaknesses: one plane stands for all walls near, so corners are too light; the
 * force is stiff at long steps. */
#include "boundary.h"

#include <math.h>

static int64_t collide(const hc_collision *collision, int32_t begin, int32_t end) {
  collision->sweeps->contacts(collision->sweep, HC_CONTACT_DISTANCE, collision->reach, collision->contacts,
                              begin, end);
  int64_t held = 0;
  for (int32_t i = begin; i < end; i++) {
    const hc_record *contact = &collision->contacts[i];
    if (!(contact->scalar > 0.0f)) continue;
    double n[3] = {contact->v[0], contact->v[1], contact->v[2]};
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(length > 0.0)) continue;
    double *velocity = &collision->sweep->fluid->velocity[3 * (size_t)i];
    for (int axis = 0; axis < 3; axis++) {
      n[axis] /= length;
      if (collision->respond) velocity[axis] += contact->scalar / collision->dt * n[axis];
    }
    hc_collision_shift(collision, i, contact->scalar, n);
    held++;
  }
  return held;
}

const hc_boundary_ops hc_boundary_harada2007 = {"harada2007", HC_WALLS_DISTANCE, hc_boundary_prepare_frozen,
                                                NULL, collide};
