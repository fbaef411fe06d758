#include "settings.h"

#include "setup/fluid.h"
#include "setup/rest_lattice.h"

#include <math.h>
#include <string.h>

const hc_boundary_ops *hc_settings_boundary(const hc_scene *scene) {
  switch (scene->boundary.method) {
  case HC_BOUNDARY_AKINCI2012:
    return &hc_boundary_akinci2012;
  case HC_BOUNDARY_IHMSEN2010:
    return &hc_boundary_ihmsen2010;
  case HC_BOUNDARY_BECKER2009:
    return &hc_boundary_becker2009;
  case HC_BOUNDARY_HARADA2007:
    return &hc_boundary_harada2007;
  }
  return NULL;
}

const hc_solver_ops *hc_settings_solver_ops(const hc_scene *scene) {
  switch (scene->solver.method) {
  case HC_SOLVER_DFSPH:
    return &hc_solver_dfsph;
  case HC_SOLVER_PCISPH:
    return &hc_solver_pcisph;
  }
  return NULL;
}

static hc_viscous_force viscosity_of(hc_viscosity_model model) {
  switch (model) {
  case HC_VISCOSITY_NONE:
    return HC_VISCOUS_NONE;
  case HC_VISCOSITY_XSPH:
    return HC_VISCOUS_XSPH;
  case HC_VISCOSITY_ARTIFICIAL:
    return HC_VISCOUS_ARTIFICIAL;
  case HC_VISCOSITY_LAMINAR:
    return HC_VISCOUS_LAMINAR;
  }
  return HC_VISCOUS_NONE;
}

/* What PCISPH reads besides. */
static void choose_prediction(const hc_scene *scene, hc_solver_settings *solver) {
  const double h = scene->support_radius, ratio = scene->particle_spacing / h;
  solver->density_error_max = hc_scene_density_error_max(scene);
  const double h2 = h * h, h4 = h2 * h2;
  solver->gradient_square = hc_setup_rest_lattice_gradient(ratio) / (h4 * h4);
  solver->shepard = scene->solver.density_correction == HC_CORRECTION_SHEPARD;
  solver->friction = scene->boundary.friction;
  solver->elasticity = scene->boundary.elasticity;
  const double volume = scene->fluid.mass_factor / hc_setup_rest_lattice_sum(ratio); /* in h3 */
  for (int k = 0; k <= HC_WALL_WEIGHTS; k++)
    solver->wall_weights[k] = (float)(volume * hc_setup_half_space(ratio, (double)k / HC_WALL_WEIGHTS));
}

hc_solver_settings hc_settings_solver(const hc_scene *scene) {
  hc_solver_settings solver = {.rest_density = scene->fluid.rest_density,
                               .viscosity = viscosity_of(scene->fluid.viscosity.model),
                               .viscosity_coefficient = scene->fluid.viscosity.coefficient,
                               .sound_speed = hc_setup_sound_speed(scene),
                               .density_error_avg = scene->solver.density_error_avg,
                               .divergence_error = scene->solver.divergence_error,
                               .density_min = scene->solver.density_iterations.min,
                               .density_max = scene->solver.density_iterations.max,
                               .divergence_min = scene->solver.divergence_iterations.min,
                               .divergence_max = scene->solver.divergence_iterations.max,
                               .warm_start = scene->solver.warm_start,
                               .relaxation = scene->solver.relaxation,
                               .min_divergence_neighbors = scene->solver.min_divergence_neighbors,
                               .negative_pressure = scene->solver.negative_pressure};
  memcpy(solver.gravity, scene->gravity, sizeof solver.gravity);
  if (scene->fluid.surface_tension.model == HC_TENSION_BECKER2007)
    solver.surface_tension = scene->fluid.surface_tension.coefficient;
  if (scene->solver.method == HC_SOLVER_PCISPH) choose_prediction(scene, &solver);
  return solver;
}

double hc_settings_wall_factor(const hc_scene *scene) {
  const double ratio = scene->particle_spacing / scene->support_radius;
  if (scene->boundary.method != HC_BOUNDARY_AKINCI2012) return hc_setup_wall_share(ratio);
  return scene->boundary.volume_factor > 0.0 ? scene->boundary.volume_factor : hc_setup_wall_factor(ratio);
}

hc_step_report hc_settings_start_report(const hc_scene *scene, double v2_max) {
  return (hc_step_report){.v_max = sqrt(v2_max), .force_max = hc_setup_gravity(scene)};
}

double hc_settings_longest_step(const hc_scene *scene) {
  return fmax(scene->time_step.max, scene->time_step.size);
}

unsigned hc_settings_features(const hc_scene *scene) {
  unsigned features = hc_settings_solver_ops(scene)->features | hc_settings_boundary(scene)->features;
  for (int k = 0; k < scene->boundary.wall_count; k++)
    if (scene->boundary.walls[k].motion.type != HC_WALL_STANDS) features |= HC_FOR_MOVERS;
  return features;
}
