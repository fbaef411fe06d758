/* Akinci, Ihmsen, Akinci, Solenthaler, Teschner 2012, "Versatile rigid-fluid coupling for incompressible
 * SPH".
 *
 * A boundary particle stands for the volume V_b = factor / sum W, the sum over boundary particles only. The
 * paper's factor is 1, which over-counts a flat wall; the scene's default is computed so that a resting
 * lattice one spacing from a flat wall has exactly the rest density (setup/rest_lattice.h). The wall's push
 * enters the pressure sweep through wall_gradient. Known weakness: no tangential pressure gradient at the
 * wall; corners stay a little light. */
#include "boundary.h"

static void prepare(const hc_sweeps *sweeps, const hc_sweep *sweep, hc_particles *boundary,
                    const hc_neighbors *list, double factor) {
  sweeps->boundary_volume(sweep, boundary, list, (float)factor);
}

const hc_boundary_ops hc_boundary_akinci2012 = {"akinci2012", prepare};
