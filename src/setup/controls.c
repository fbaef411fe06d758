#include "controls.h"

#include "base/memory.h"
#include "setup/fluid.h"
#include "stepping/adaptive.h"
#include "stepping/cfl.h"
#include "stepping/constant.h"

static hc_step_settings common_settings(const hc_scene *scene, double longest) {
  return (hc_step_settings){.longest = longest,
                            .min = scene->time_step.min,
                            .spacing = scene->particle_spacing,
                            .support_radius = scene->support_radius,
                            .viscosity = hc_setup_kinematic_viscosity(scene),
                            .end_time = scene->end_time};
}

static hc_step_settings *constant_settings(const hc_scene *scene) {
  hc_step_settings *settings = hc_alloc(1, sizeof *settings);
  *settings = common_settings(scene, scene->time_step.size);
  return settings;
}

static hc_step_settings *cfl_settings(const hc_scene *scene) {
  hc_cfl_settings *settings = hc_alloc(1, sizeof *settings);
  *settings = (hc_cfl_settings){common_settings(scene, scene->time_step.max), scene->time_step.factor};
  return &settings->common;
}

static hc_step_settings *adaptive_settings(const hc_scene *scene) {
  hc_adaptive_settings *settings = hc_alloc(1, sizeof *settings);
  const hc_time_adaptive *a = &scene->time_step.adaptive;
  *settings = (hc_adaptive_settings){
      .common = common_settings(scene, scene->time_step.max),
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
      .gravity = hc_setup_gravity(scene),
      .depth = hc_setup_fluid_height(scene)};
  return &settings->common;
}

static const struct {
  const hc_control_ops *ops;
  hc_step_settings *(*settings)(const hc_scene *scene);
} controls[] = {[HC_TIME_CONSTANT] = {&hc_control_constant, constant_settings},
                [HC_TIME_CFL] = {&hc_control_cfl, cfl_settings},
                [HC_TIME_ADAPTIVE] = {&hc_control_adaptive, adaptive_settings}};

const hc_control_ops *hc_setup_control_ops(const hc_scene *scene) {
  return controls[scene->time_step.control].ops;
}

hc_control hc_setup_control(const hc_scene *scene) {
  hc_control control;
  hc_control_init(&control, hc_setup_control_ops(scene), controls[scene->time_step.control].settings(scene));
  return control;
}

double hc_setup_settle_step(const hc_scene *scene) {
  if (scene->fluid.settle_steps == 0) return 0.0;
  hc_control control = hc_setup_control(scene);
  const double step = hc_control_still(&control);
  hc_control_free(&control);
  return step;
}
