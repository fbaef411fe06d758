#include "controls.h"

#include "base/memory.h"
#include "setup/fluid.h"
#include "stepping/adaptive.h"
#include "stepping/cfl.h"
#include "stepping/constant.h"

#include <stdio.h>
#include <string.h>

/* ---- settings ---- */

static double size_of(const hc_scene *scene) {
  return scene->time_step.size;
}

static double max_of(const hc_scene *scene) {
  return scene->time_step.max;
}

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
  *settings = common_settings(scene, size_of(scene));
  return settings;
}

static hc_step_settings *cfl_settings(const hc_scene *scene) {
  hc_cfl_settings *settings = hc_alloc(1, sizeof *settings);
  *settings = (hc_cfl_settings){common_settings(scene, max_of(scene)), scene->time_step.factor};
  return &settings->common;
}

static hc_step_settings *adaptive_settings(const hc_scene *scene) {
  hc_adaptive_settings *settings = hc_alloc(1, sizeof *settings);
  const hc_time_adaptive *a = &scene->time_step.adaptive;
  *settings = (hc_adaptive_settings){
      .common = common_settings(scene, max_of(scene)),
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

/* ---- rules ---- */

/* `low` must be below `high`, or equal to it where that may be. */
typedef struct order {
  const char *low, *high;
  double low_value, high_value;
  bool equal;
} order;

static void check_order(const order *order, hc_findings *findings) {
  const hc_given *given = findings->given;
  if (hc_given_is_bad(given, order->low) || hc_given_is_bad(given, order->high) ||
      order->low_value < order->high_value || (order->equal && order->low_value == order->high_value))
    return;
  char low_text[HC_PARAM_NUMBER_TEXT], high_text[HC_PARAM_NUMBER_TEXT];
  hc_params_number_text(order->low_value, low_text);
  hc_params_number_text(order->high_value, high_text);
  const char *which = hc_given_has(given, order->low) ? order->low : order->high;
  hc_findings_error(findings, which, "%s must be %s %s, not %s %s %s", order->low, order->equal ? "<=" : "<",
                    order->high, low_text, order->equal ? ">" : ">=", high_text);
}

static void complete_adaptive(hc_scene *scene, hc_findings *findings) {
  const hc_time_adaptive *a = &scene->time_step.adaptive;
  const double average = scene->solver.density_error_avg, most = hc_scene_density_error_max(scene),
               rise = hc_scene_shock_rise(scene);
#define KEY(name) "time_step.adaptive." name
  const order orders[] = {
      {KEY("grow.force"), KEY("shrink.force"), a->grow.force, a->shrink.force, true},
      {KEY("grow.error_max"), KEY("shrink.error_max"), a->grow.error_max, a->shrink.error_max, true},
      {KEY("grow.error_avg"), KEY("shrink.error_avg"), a->grow.error_avg, a->shrink.error_avg, true},
      {KEY("grow.velocity"), KEY("shrink.velocity"), a->grow.velocity, a->shrink.velocity, true},
      {KEY("shrink.velocity"), KEY("shock.velocity"), a->shrink.velocity, a->shock.velocity, true},
      {"solver.density_error_avg", "solver.density_error_max", average, most, false},
      {"solver.density_error_avg", KEY("shock.error_rise"), average, rise, false},
      {KEY("shock.error_rise"), "solver.density_error_max", rise, most, false}};
#undef KEY
  for (size_t k = 0; k < sizeof orders / sizeof *orders; k++) check_order(&orders[k], findings);
}

static void complete_constant(hc_scene *scene, hc_findings *findings) {
  const hc_given *given = findings->given;
  if (!hc_given_has(given, "time_step.size") && !hc_given_is_bad(given, "time_step.size"))
    hc_findings_error(findings, "", "missing key 'time_step.size', required with time_step.control constant");
  if (hc_given_is_bad(given, "time_step.size") || hc_given_is_bad(given, "time_step.max")) return;
  const double size = scene->time_step.size;
  if (size <= scene->time_step.max) return;
  if (!hc_given_has(given, "time_step.max")) { /* the default is no wish */
    scene->time_step.max = size;
    return;
  }
  char size_text[HC_PARAM_NUMBER_TEXT], max_text[HC_PARAM_NUMBER_TEXT];
  hc_params_number_text(size, size_text);
  hc_params_number_text(scene->time_step.max, max_text);
  hc_findings_error(findings, "time_step.size", "time_step.size must be <= time_step.max, not %s > %s",
                    size_text, max_text);
}

/* ---- the table ---- */

static const struct {
  const hc_control_ops *ops;
  double (*longest)(const hc_scene *scene); /* step, s */
  hc_step_settings *(*settings)(const hc_scene *scene);
  void (*complete)(hc_scene *scene, hc_findings *findings); /* null: nothing to do */
} controls[] = {[HC_TIME_CONSTANT] = {&hc_control_constant, size_of, constant_settings, complete_constant},
                [HC_TIME_CFL] = {&hc_control_cfl, max_of, cfl_settings, NULL},
                [HC_TIME_ADAPTIVE] = {&hc_control_adaptive, max_of, adaptive_settings, complete_adaptive}};

static void check_floor(const hc_scene *scene, hc_findings *findings) {
  const hc_given *given = findings->given;
  char largest[HC_PARAM_PATH];
  snprintf(largest, sizeof largest, "time_step.%s", controls[scene->time_step.control].ops->longest_key);
  const double most = controls[scene->time_step.control].longest(scene);
  if (hc_given_is_bad(given, "time_step.min") || hc_given_is_bad(given, largest) ||
      scene->time_step.min <= most || most <= 0.0)
    return;
  char min_text[HC_PARAM_NUMBER_TEXT], max_text[HC_PARAM_NUMBER_TEXT];
  hc_params_number_text(scene->time_step.min, min_text);
  hc_params_number_text(most, max_text);
  hc_findings_error(findings, "time_step.min", "time_step.min must be <= %s, not %s > %s", largest, min_text,
                    max_text);
}

void hc_setup_control_complete(hc_scene *scene, hc_findings *findings) {
  if (controls[scene->time_step.control].complete)
    controls[scene->time_step.control].complete(scene, findings);
  check_floor(scene, findings);
}

bool hc_setup_control_named(const char *name, hc_time_control *control) {
  for (size_t k = 0; k < sizeof controls / sizeof *controls; k++)
    if (strcmp(controls[k].ops->name, name) == 0) {
      *control = (hc_time_control)k;
      return true;
    }
  return false;
}

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
