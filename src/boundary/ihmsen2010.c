/* Ihmsen, Akinci, Gissler, Teschner 2010, "Boundary handling and adaptive time-stepping for PCISPH", section
 * 3.2.
 *
 * A particle nearer than r0 (one spacing) to boundary samples is moved along the weighted mean of their
 * normals (eq. 9 to 11) and loses its velocity along it (eq. 12). Boundary samples count as fluid in
 * densities, and those near fluid have a predicted density and a pressure like fluid (eq. 13), which pushes
 * before contact is made. With samples r0 apart in a single layer, rho_b stays below the rest density and p_b
 * at 0: it takes two layers. Where normals cancel, as between two faces of a thin plate, there is nothing to
 * go along, and the particle is left where it is. */
#include "boundary.h"

/* Is a sample nearer to another than samples of one wall are? */
static bool crowded(const hc_sweep *sweep, const hc_particles *boundary, const hc_neighbors *list,
                    int32_t b) {
  const double least = 0.8 * (double)(sweep->reach / sweep->support);
  const uint32_t *offset = hc_list_row(list, b);
  for (int k = 0; k < hc_list_count(list, b); k++) {
    const hc_record *place = &boundary->place[b], *other = &boundary->place[offset[k] / sizeof(hc_record)];
    double square = 0.0;
    for (int axis = 0; axis < 3; axis++) {
      const int32_t apart = (int32_t)((uint32_t)place->x[axis] - (uint32_t)other->x[axis]);
      const double x = apart * (double)sweep->scale[axis];
      square += x * x;
    }
    if (square < least * least) return true;
  }
  return false;
}

void hc_boundary_prepare_frozen(const hc_sweeps *sweeps, const hc_sweep *sweep, hc_particles *boundary,
                                const hc_neighbors *list, double factor) {
  /* With factor 1, volume = 1/sum W and V sum W = V/volume. Where walls overlap, samples are too dense among
   * themselves, and a pressure from that alone would blow up what touches them. */
  sweeps->boundary_volume(sweep, boundary, list, 1.0f);
  for (int32_t b = 0; b < boundary->own; b++) {
    const float share = sweep->volume / boundary->volume[b], most = (float)factor;
    boundary->boundary_share[b] = share > most && crowded(sweep, boundary, list, b) ? most : share;
    boundary->volume[b] = sweep->volume;
    boundary->place[b].scalar = 0.0f;
  }
}

static int64_t collide(const hc_collision *collision, hc_selection selection) {
  collision->sweeps->contacts(collision->sweep, HC_CONTACT_WEIGHTED, collision->contacts, selection);
  static const float stands[3];
  const bool moved = collision->respond && collision->velocities;
  if (moved) collision->sweeps->wall_velocities(collision->sweep, collision->velocities, selection);
  int64_t held = 0;
  for (int32_t row = selection.begin; row < selection.end; row++) {
    const int32_t i = hc_selected(selection, row);
    const hc_record contact = collision->contacts[i];
    if (!(contact.scalar > 0.0f)) continue;
    collision->contacts[i] = (hc_record){.scalar = 0.0f};
    double n[3];
    if (!hc_collision_direction(&contact, n)) continue;
    hc_collision_shift(collision, i, contact.scalar, n);
    if (collision->respond)
      hc_collision_respond(collision, i, n, moved ? collision->velocities[i].v : stands);
    held++;
  }
  return held;
}

const hc_boundary_ops hc_boundary_ihmsen2010 = {
    "ihmsen2010", HC_WALLS_PRESSURE, HC_FOR_RIGID_WALLS, hc_boundary_prepare_frozen, NULL, collide};
