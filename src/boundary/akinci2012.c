/* Akinci, Ihmsen, Akinci, Solenthaler, Teschner 2012, "Versatile rigid-fluid coupling for incompressible
 * SPH".
 *
 * A boundary particle stands for the volume V_b = factor / sum W, the sum over boundary particles only. The
 * paper's factor is 1, which over-counts a flat wall; the scene's default is computed so that a resting
 * lattice one spacing from a flat wall has exactly the rest density (setup/rest_lattice.h). The wall's push
 * enters the pressure sweep through wall_gradient. Known weakness: no tangential pressure gradient at the
 * wall; corners stay a little light.
 *
 * Contact. A single layer weighs as much as one layer of fluid, so pressure stops a particle only where its
 * density reaches the rest density: a drop of few particles passes through the layer, whose gradient vanishes
 * in the middle. Not in the paper: the part of the velocity along the gradient B of the wall density D_b is
 * cut so that D_b + dt (v . B - sum V_b v_b . grad W), which follows moving walls, stays within the value on
 * the wetted surface of a flat wall; a particle already beyond keeps no approaching velocity, but is not
 * thrown out. Fluid at rest stays a spacing away and never notices. */
#include "boundary.h"

static void prepare(const hc_sweeps *sweeps, const hc_sweep *sweep, hc_particles *boundary,
                    const hc_neighbors *list, double factor) {
  sweeps->boundary_volume(sweep, boundary, list, (float)factor);
}

static int64_t contact(hc_particles *fluid, double rest_density, double limit, double dt) {
  int64_t held = 0;
  for (int32_t i = 0; i < fluid->own; i++) {
    const double room = limit - (double)fluid->wall_density[i];
    if (room == limit) continue; /* no wall near */
    const float *gradient = &fluid->wall_gradient[3 * (size_t)i];
    double *velocity = &fluid->velocity[3 * (size_t)i];
    double approach = fluid->wall_rate ? -(double)fluid->wall_rate[i] : -0.0, square = 0.0;
    for (int axis = 0; axis < 3; axis++) {
      approach += velocity[axis] * gradient[axis];
      square += (double)gradient[axis] * gradient[axis];
    }
    const double allowed = room > 0.0 ? room / dt : 0.0;
    if (approach <= allowed || square == 0.0) continue;
    const double push =
        (approach - allowed) / square; /* acts like a divergence multiplier: rho0 push/dt in Pa */
    for (int axis = 0; axis < 3; axis++) {
      velocity[axis] -= push * gradient[axis];
      fluid->motion[i].v[axis] = (float)velocity[axis];
    }
    fluid->pressure[i] += (float)(rest_density * push / dt);
    held++;
  }
  return held;
}

const hc_boundary_ops hc_boundary_akinci2012 = {"akinci2012", HC_WALLS_MIRRORED, HC_FOR_WALL_VOLUMES,
                                                prepare,      contact,           NULL};
