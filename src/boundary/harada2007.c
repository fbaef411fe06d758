/* Harada, Koshizuka, Kawaguchi 2007, "Smoothed particle hydrodynamics on GPUs", section 4.3, in a
 * predictive-corrective form (Ihmsen et al. 2010, section 2).
 *
 * The distance from a wall is that from the plane through the samples near a particle. Nearer than r0 to it,
 * the particle is held at r0, by a force that does so within the step: so the velocity changes with the
 * position. The wall adds to the density what a half space of the rest lattice would at that distance,
 * whatever its shape. Known weaknesses: one plane stands for all walls near, so corners are too light; the
 * force is stiff at long steps. */
#include "boundary.h"

static int64_t collide(const hc_collision *collision, hc_selection selection) {
  collision->sweeps->contacts(collision->sweep, HC_CONTACT_DISTANCE, collision->contacts, selection);
  int64_t held = 0;
  for (int32_t row = selection.begin; row < selection.end; row++) {
    const int32_t i = hc_selected(selection, row);
    const hc_record contact = collision->contacts[i];
    collision->contacts[i] = (hc_record){.scalar = 0.0f};
    double n[3];
    if (!(contact.scalar > 0.0f) || !hc_collision_direction(&contact, n)) continue;
    hc_collision_shift(collision, i, contact.scalar, n);
    for (int axis = 0; axis < 3 && collision->respond; axis++)
      hc_collision_change(collision, i, axis, contact.scalar / collision->dt * n[axis]);
    held++;
  }
  return held;
}

const hc_boundary_ops hc_boundary_harada2007 = {
    "harada2007", HC_WALLS_DISTANCE, HC_FOR_RIGID_WALLS, hc_boundary_prepare_frozen, NULL, collide};
