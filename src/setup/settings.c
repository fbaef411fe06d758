#include "settings.h"

#include "setup/rest_lattice.h"
#include "setup/source.h"

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

/* Sound speed of the artificial viscosity if the scene names none: ten times the speed of a fall over the
 * fluid's height, which keeps a weakly compressible fluid within 1 %. */
static double default_sound_speed(const hc_scene *scene) {
  double gravity = 0.0, height = 0.0;
  for (int axis = 0; axis < 3; axis++) gravity += scene->gravity[axis] * scene->gravity[axis];
  for (int block = 0; block < scene->fluid.block_count; block++) {
    const hc_box box = hc_source_block_bounds(&scene->fluid.blocks[block]);
    double extent = 0.0;
    for (int axis = 0; axis < 3; axis++)
      extent += (box.max[axis] - box.min[axis]) *
                (gravity > 0.0 ? fabs(scene->gravity[axis]) / sqrt(gravity) : 1.0);
    height = fmax(height, extent);
  }
  return 10.0 * sqrt(2.0 * (gravity > 0.0 ? sqrt(gravity) : 1.0) * height);
}

/* Likewise of what emitters bring: ten times its speed. */
static double emitted_sound_speed(const hc_scene *scene) {
  double speed = 0.0;
  for (int k = 0; k < scene->fluid.emitter_count; k++) {
    const hc_scene_emitter *emitter = &scene->fluid.emitters[k];
    const double area = emitter->form == HC_EMITTER_DISC
                            ? 3.14159265358979323846 * emitter->radius * emitter->radius
                            : emitter->size[0] * emitter->size[1];
    speed = fmax(speed, fmax(emitter->speed, emitter->rate / area));
  }
  return 10.0 * speed;
}

static double sound_speed(const hc_scene *scene) {
  if (scene->fluid.viscosity.model != HC_VISCOSITY_ARTIFICIAL) return 0.0;
  return scene->fluid.viscosity.sound_speed > 0.0
             ? scene->fluid.viscosity.sound_speed
             : fmax(default_sound_speed(scene), emitted_sound_speed(scene));
}

/* Of all blocks together, along gravity, m; 0 without gravity. */
static double fluid_height(const hc_scene *scene, double gravity) {
  double low = INFINITY, high = -INFINITY;
  for (int block = 0; block < scene->fluid.block_count && gravity > 0.0; block++) {
    const hc_box box = hc_source_block_bounds(&scene->fluid.blocks[block]);
    double ends[2] = {0.0, 0.0};
    for (int axis = 0; axis < 3; axis++) {
      const double down = scene->gravity[axis] / gravity;
      ends[down < 0.0] += down * box.min[axis];
      ends[down >= 0.0] += down * box.max[axis];
    }
    low = fmin(low, ends[0]);
    high = fmax(high, ends[1]);
  }
  return high > low ? high - low : 0.0;
}

static hc_adaptive_settings adaptive_settings_of(const hc_scene *scene) {
  const hc_time_adaptive *a = &scene->time_step.adaptive;
  const double gravity = hc_settings_start_report(scene, 0.0).force_max;
  return (hc_adaptive_settings){
      .error_avg = scene->solver.density_error_avg,
      .error_max = hc_scene_density_error_max(scene),
      .change = a->change,
      .grow = {a->grow.force, a->grow.velocity, a->grow.error_max, a->grow.error_avg},
      .shrink = {a->shrink.force, a->shrink.velocity, a->shrink.error_max, a->shrink.error_avg},
      .shock_rise = hc_scene_shock_rise(scene),
      .shock_velocity = a->shock.velocity,
      .restart_force = a->restart.force,
      .restart_velocity = a->restart.velocity,
      .restart_share = a->restart.share,
      .most_restarts = a->restart.most,
      .first_velocity = a->first.velocity,
      .first_depth = a->first.depth,
      .gravity = gravity,
      .depth = fluid_height(scene, gravity)};
}

static hc_step_control control_of(hc_time_control control) {
  switch (control) {
  case HC_TIME_CONSTANT:
    return HC_STEP_CONSTANT;
  case HC_TIME_CFL:
    return HC_STEP_CFL;
  case HC_TIME_ADAPTIVE:
    return HC_STEP_ADAPTIVE;
  }
  return HC_STEP_CFL;
}

hc_step_settings hc_settings_step(const hc_scene *scene) {
  const bool laminar = scene->fluid.viscosity.model == HC_VISCOSITY_LAMINAR;
  const double coefficient = scene->fluid.viscosity.coefficient;
  return (hc_step_settings){
      .control = control_of(scene->time_step.control),
      .size = scene->time_step.size,
      .max = scene->time_step.max,
      .min = scene->time_step.min,
      .factor = scene->time_step.factor,
      .spacing = scene->particle_spacing,
      .support_radius = scene->support_radius,
      /* artificial: the kinematic viscosity it amounts to in three dimensions, alpha h c / 10 (Monaghan 2005)
       */
      .viscosity = laminar ? coefficient : 0.1 * coefficient * scene->support_radius * sound_speed(scene),
      .end_time = scene->end_time,
      .adaptive = adaptive_settings_of(scene)};
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
                               .sound_speed = sound_speed(scene),
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
  double force = 0.0;
  for (int axis = 0; axis < 3; axis++) force += scene->gravity[axis] * scene->gravity[axis];
  return (hc_step_report){.v_max = sqrt(v2_max), .force_max = sqrt(force)};
}

double hc_settings_settle_step(const hc_scene *scene) {
  if (scene->fluid.settle_steps == 0) return 0.0;
  if (scene->time_step.control == HC_TIME_CONSTANT) return scene->time_step.size;
  if (scene->time_step.control == HC_TIME_CFL) return scene->time_step.max;
  const hc_step_settings settings = hc_settings_step(scene);
  const hc_step_report still = {.v_max = 0.0};
  hc_step_bound unused;
  return hc_time_step_next(&settings, 0.0, 0.0, &still, &unused);
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
