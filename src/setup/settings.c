#include "settings.h"

#include "base/memory.h"
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

double hc_settings_flat_wall(const hc_scene *scene) {
  if (hc_settings_boundary(scene)->walls != HC_WALLS_MIRRORED ||
      scene->boundary.wall_density != HC_WALL_DENSITY_SQUARED)
    return 0.0;
  return hc_setup_flat_wall(scene->particle_spacing / scene->support_radius, hc_settings_wall_factor(scene));
}

static hc_friction_law law_of(const hc_scene *scene, int wall) {
  switch (hc_scene_surface(scene, wall)->friction_law) {
  case HC_SCENE_FRICTION_NONE:
    break;
  case HC_SCENE_FRICTION_NO_SLIP:
    return HC_FRICTION_NO_SLIP;
  case HC_SCENE_FRICTION_SMOOTH:
    return HC_FRICTION_SMOOTH;
  case HC_SCENE_FRICTION_ROUGH:
    return HC_FRICTION_ROUGH;
  }
  return HC_FRICTION_NONE;
}

bool hc_settings_no_slip(const hc_scene *scene) {
  const int count = hc_scene_surfaces(scene);
  return scene->fluid.viscosity.model == HC_VISCOSITY_LAMINAR && count > 0 &&
         law_of(scene, 0) == HC_FRICTION_NO_SLIP; /* all, or none */
}

hc_wall_friction *hc_settings_friction(const hc_scene *scene) {
  const int count = hc_scene_surfaces(scene);
  if (hc_settings_no_slip(scene)) return NULL;
  hc_wall_friction *const friction = hc_alloc_zero((size_t)count, sizeof *friction);
  bool any = false;
  for (int k = 0; k < count; k++) {
    friction[k] = (hc_wall_friction){law_of(scene, k), hc_scene_surface(scene, k)->roughness};
    any |= friction[k].law != HC_FRICTION_NONE;
  }
  if (any) return friction;
  hc_free(friction);
  return NULL;
}

bool hc_settings_friction_differs(const hc_scene *scene) {
  for (int k = 1; k < hc_scene_surfaces(scene); k++) {
    const hc_wall *const first = hc_scene_surface(scene, 0), *const other = hc_scene_surface(scene, k);
    if (other->friction_law != first->friction_law || other->roughness < first->roughness ||
        other->roughness > first->roughness)
      return true;
  }
  return false;
}

hc_step_report hc_settings_start_report(const hc_scene *scene, double v2_max) {
  return (hc_step_report){.v_max = sqrt(v2_max), .force_max = hc_setup_pull(scene)};
}

unsigned hc_settings_features(const hc_scene *scene) {
  unsigned features = hc_setup_solver_ops(scene)->features | hc_settings_boundary(scene)->features;
  for (int k = 0; k < hc_scene_surfaces(scene); k++)
    if (!hc_scene_stands(scene, k)) features |= HC_FOR_MOVERS;
  if (scene->time_step.control == HC_TIME_INDIVIDUAL) features |= HC_FOR_INDIVIDUAL;
  return features;
}
