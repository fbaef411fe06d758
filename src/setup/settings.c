#include "settings.h"

#include "setup/fluid.h"
#include "setup/rest_lattice.h"
#include "setup/solvers.h"

#include <math.h>

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

double hc_settings_wall_factor(const hc_scene *scene) {
  const double ratio = scene->particle_spacing / scene->support_radius;
  if (hc_settings_boundary(scene)->walls != HC_WALLS_MIRRORED) return hc_setup_wall_share(ratio);
  return scene->boundary.volume_factor > 0.0 ? scene->boundary.volume_factor : hc_setup_wall_factor(ratio);
}

hc_step_report hc_settings_start_report(const hc_scene *scene, double v2_max) {
  return (hc_step_report){.v_max = sqrt(v2_max), .force_max = hc_setup_pull(scene)};
}

unsigned hc_settings_features(const hc_scene *scene) {
  unsigned features = hc_setup_solver_ops(scene)->features | hc_settings_boundary(scene)->features;
  for (int k = 0; k < scene->boundary.wall_count; k++)
    if (scene->boundary.walls[k].motion.type != HC_WALL_STANDS) features |= HC_FOR_MOVERS;
  return features;
}
