/* The boundary methods behind one table of operations, chosen by name. */
#ifndef HC_BOUNDARY_METHODS_H
#define HC_BOUNDARY_METHODS_H

#include "sph/sweeps.h"

typedef struct hc_boundary_ops {
  const char *name;
  /* Prepares own boundary particles once they are placed: what the sweeps read of them. `list` holds their
   * boundary neighbours, ghosts included; `factor` scales the volumes. Local; the caller refreshes the
   * ghosts. */
  void (*prepare)(const hc_sweeps *sweeps, const hc_sweep *sweep, hc_particles *boundary,
                  const hc_neighbors *list, double factor);
  /* The last word before own fluid particles move by dt: takes away what would carry one into a wall. `limit`
   * is the wall density of a particle on a flat wall's wetted surface. The push adds to the particle's
   * pressure. Returns how many were held. Local. */
  int64_t (*contact)(hc_particles *fluid, double rest_density, double limit, double dt);
} hc_boundary_ops;

/* Single layer, volumes V_b = factor / sum W over boundary particles, pressure mirrored from the fluid
 * particle (Akinci et al. 2012; Carensac et al. 2023, A.2), with a contact for particles that pressure does
 * not stop. */
extern const hc_boundary_ops hc_boundary_akinci2012;

#endif
