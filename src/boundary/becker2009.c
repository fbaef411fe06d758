/* Becker, Tessendorf, Teschner 2009, "Direct forcing for Lagrangian rigid-fluid coupling", for walls, as
 * Ihmsen et al. 2010 print it (eq. 7 and 8).
 *
 * A particle nearer than r0 to a sample is moved out along its normal until it is r0 away (eq. 8 reads as if
 * by its distance, which explodes) and loses its normal velocity; samples one after the other, in the
 * canonical order. Walls add nothing to densities. Known weakness, which the paper shows: particles stack at
 * walls and in corners. */
#include "boundary.h"

#include <math.h>

static int64_t collide(const hc_collision *collision, hc_selection selection) {
  const hc_sweep *sweep = collision->sweep;
  const hc_neighbors *walls = sweep->walls;
  int64_t held = 0;
  for (int32_t row = selection.begin; row < selection.end; row++) {
    const int32_t i = hc_selected(selection, row);
    const uint32_t *offset = hc_list_row(walls, row);
    bool touched = false;
    collision->contacts[i] = (hc_record){.scalar = 0.0f};
    for (int k = 0; k < hc_list_count(walls, row); k++) {
      const size_t b = offset[k] / sizeof(hc_record);
      const hc_record *place = &sweep->fluid->place[i], *sample = &sweep->boundary->place[b];
      double square = 0.0;
      for (int axis = 0; axis < 3; axis++) {
        const int32_t apart = (int32_t)((uint32_t)place->x[axis] - (uint32_t)sample->x[axis]);
        const double x = apart * collision->unit[axis];
        square += x * x;
      }
      if (square >= (double)sweep->reach * sweep->reach) continue;
      const float *normal = sweep->boundary->facing[b].v;
      const double n[3] = {normal[0], normal[1], normal[2]};
      hc_collision_shift(collision, i, sweep->reach - sqrt(square), n);
      if (collision->respond) hc_collision_respond(collision, i, n, sweep->boundary->motion[b].v);
      touched = true;
    }
    held += touched;
  }
  return held;
}

const hc_boundary_ops hc_boundary_becker2009 = {
    "becker2009", HC_WALLS_NOTHING, HC_FOR_RIGID_WALLS, hc_boundary_prepare_frozen, NULL, collide};
