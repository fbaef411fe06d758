#include "controls.h"

#include "base/memory.h"
#include "setup/fluid.h"
#include "setup/solvers.h"
#include "stepping/adaptive.h"
#include "stepping/cfl.h"
#include "stepping/constant.h"
#include "stepping/global.h"
#include "stepping/individual.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- settings ---- */

static double size_of(const hc_scene *scene) {
  return scene->time_step.size;
}

/* That many spacings at the speed of a shallow wave of such depth; INFINITY without. */
static double by_depth(const hc_scene *scene, double spacings, double depth) {
  const double speed = sqrt(hc_setup_gravity(scene) * depth);
  return speed > 0.0 ? spacings * scene->particle_spacing / speed : INFINITY;
}

/* A share of the time of a fall over a support radius; INFINITY without gravity. */
static double by_gravity(const hc_scene *scene, double share) {
  const double gravity = hc_setup_pull(scene);
  return gravity > 0.0 ? share * sqrt(scene->support_radius / gravity) : INFINITY;
}

/* Where neither the scene nor gravity says how long a step is at most: a spacing at the speed of the start;
 * without a speed too there is but the end of the run to go by. */
static double by_speed(const hc_scene *scene) {
  static const double PARTS = 100.0;
  const double speed = hc_setup_start_speed(scene);
  return speed > 0.0 ? scene->particle_spacing / speed : scene->end_time / PARTS;
}

static double longest_of(const hc_scene *scene, double bound) {
  if (scene->time_step.max > 0.0) return fmin(scene->time_step.max, bound);
  return isfinite(bound) ? bound : by_speed(scene);
}

/* Longer steps need as many iterations more as they save, and fluid at rest does not stay at rest: at 20
 * layers of depth it boils from 0.15 sqrt(h/g) on. */
static double cfl_longest(const hc_scene *scene) {
  static const double SHARE = 0.05, SPACINGS = 0.3;
  return longest_of(scene,
                    fmin(by_gravity(scene, SHARE), by_depth(scene, SPACINGS, hc_setup_block_height(scene))));
}

/* The control has a bound by forces of its own, which a scene may widen. */
static double adaptive_longest(const hc_scene *scene) {
  return scene->time_step.max > 0.0
             ? scene->time_step.max
             : longest_of(scene, by_gravity(scene, scene->time_step.adaptive.shrink.force));
}

static double global_longest(const hc_scene *scene) {
  const double stable = hc_setup_solver_longest(scene);
  return scene->time_step.max > 0.0 ? fmin(scene->time_step.max, stable) : stable;
}

static hc_step_settings common_settings(const hc_scene *scene, double longest) {
  return (hc_step_settings){.longest = longest,
                            .min = scene->time_step.min,
                            .spacing = scene->particle_spacing,
                            .support_radius = scene->support_radius,
                            .viscosity = hc_setup_kinematic_viscosity(scene),
                            .first = INFINITY,
                            .end_time = scene->end_time};
}

static hc_step_settings *constant_settings(const hc_scene *scene) {
  hc_step_settings *settings = hc_alloc(1, sizeof *settings);
  *settings = common_settings(scene, size_of(scene));
  return settings;
}

static hc_step_settings *cfl_settings(const hc_scene *scene) {
  static const double SPARE = 0.05;
  static const double FIRST = 0.2; /* spacings: fluid that starts at rest has no pressure to go by */
  hc_cfl_settings *settings = hc_alloc(1, sizeof *settings);
  *settings = (hc_cfl_settings){common_settings(scene, cfl_longest(scene)), scene->time_step.factor,
                                scene->solver.density_error_avg};
  settings->common.spare = SPARE;
  settings->common.first = by_depth(scene, FIRST, hc_setup_fluid_height(scene));
  return &settings->common;
}

static hc_step_settings *adaptive_settings(const hc_scene *scene) {
  hc_adaptive_settings *settings = hc_alloc(1, sizeof *settings);
  const hc_time_adaptive *a = &scene->time_step.adaptive;
  *settings = (hc_adaptive_settings){
      .common = common_settings(scene, adaptive_longest(scene)),
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
      .first_velocity = a->first.velocity};
  settings->common.spare = 1.5 * a->change;
  settings->common.first = by_depth(scene, a->first.depth, hc_setup_fluid_height(scene));
  return &settings->common;
}

static hc_step_settings *global_settings(const hc_scene *scene) {
  hc_global_settings *settings = hc_alloc(1, sizeof *settings);
  *settings = (hc_global_settings){common_settings(scene, global_longest(scene)), scene->time_step.velocity,
                                   scene->time_step.force};
  return &settings->common;
}

/* A block of individual steps: so many of the longest; one where walls move, which are posed once in a block.
 */
static double individual_longest(const hc_scene *scene) {
  static const double MOST = 4.0;
  bool moves = false;
  for (int k = 0; k < hc_scene_surfaces(scene); k++) moves |= !hc_scene_stands(scene, k);
  return (moves ? 1.0 : MOST) * global_longest(scene);
}

static hc_step_settings *individual_settings(const hc_scene *scene) {
  hc_individual_control *settings = hc_alloc(1, sizeof *settings);
  *settings =
      (hc_individual_control){common_settings(scene, individual_longest(scene)), global_longest(scene),
                              0.5 * scene->time_step.margin * scene->support_radius};
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
  if (scene->time_step.max == 0.0 || size <= scene->time_step.max) return;
  char size_text[HC_PARAM_NUMBER_TEXT], max_text[HC_PARAM_NUMBER_TEXT];
  hc_params_number_text(size, size_text);
  hc_params_number_text(scene->time_step.max, max_text);
  hc_findings_error(findings, "time_step.size", "time_step.size must be <= time_step.max, not %s > %s",
                    size_text, max_text);
}

static void complete_individual(hc_scene *scene, hc_findings *findings) {
  static const double RAW = 0.5; /* of what powers of two bear */
  if (scene->fluid.viscosity.model != HC_VISCOSITY_ARTIFICIAL)
    hc_findings_warning(
        findings, "fluid.viscosity.model",
        "fluid.viscosity.model should be artificial with time_step.control individual: what "
        "particles that are not active are guessed to do adds energy, which little viscosity leaves "
        "there (Martin and Moyce's column with water's: 2 to 5 %%)");
  if (scene->time_step.steps != HC_STEPS_RAW) return;
  if (!hc_given_has(findings->given, "time_step.velocity")) scene->time_step.velocity *= RAW;
  if (!hc_given_has(findings->given, "time_step.force")) scene->time_step.force *= RAW;
}

/* ---- the table ---- */

static const struct {
  const hc_control_ops *ops;
  double (*longest)(const hc_scene *scene); /* step, s */
  hc_step_settings *(*settings)(const hc_scene *scene);
  void (*complete)(hc_scene *scene, hc_findings *findings); /* null: nothing to do */
} controls[] = {
    [HC_TIME_CONSTANT] = {&hc_control_constant, size_of, constant_settings, complete_constant},
    [HC_TIME_CFL] = {&hc_control_cfl, cfl_longest, cfl_settings, NULL},
    [HC_TIME_ADAPTIVE] = {&hc_control_adaptive, adaptive_longest, adaptive_settings, complete_adaptive},
    [HC_TIME_GLOBAL] = {&hc_control_global, global_longest, global_settings, NULL},
    [HC_TIME_INDIVIDUAL] = {&hc_control_individual, individual_longest, individual_settings,
                            complete_individual}};

void hc_setup_control_complete(hc_scene *scene, hc_findings *findings) {
  if (controls[scene->time_step.control].complete)
    controls[scene->time_step.control].complete(scene, findings);
}

/* What keeps the solver from being stable. */
static void review_stable(const hc_scene *scene, hc_findings *findings) {
  const double stable = hc_setup_solver_longest(scene);
  const bool any = scene->fluid.block_count + scene->fluid.emitter_count > 0;
  if (any && isinf(stable) && hc_setup_solver_ops(scene)->evaluate)
    hc_findings_error(
        findings, "solver.method",
        "missing key 'solver.sound_speed': without gravity, speeds at the start or emitters there is "
        "nothing to estimate it by");
  if (hc_setup_control_ops(scene)->foreseen && scene->time_step.size > stable * (1.0 + 1e-12))
    hc_findings_error(
        findings, "time_step.size",
        "time_step.size must be <= the longest step with which sound is stable, %.4g s, not %.4g", stable,
        scene->time_step.size);
}

void hc_setup_control_review(const hc_scene *scene, hc_findings *findings) {
  const double most = hc_setup_control_longest(scene);
  review_stable(scene, findings);
  if (scene->time_step.min <= most) return;
  char min_text[HC_PARAM_NUMBER_TEXT], max_text[HC_PARAM_NUMBER_TEXT];
  hc_params_number_text(scene->time_step.min, min_text);
  hc_params_number_text(most, max_text);
  hc_findings_error(findings, "time_step.min", "time_step.min must be <= the largest time step, not %s > %s",
                    min_text, max_text);
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

double hc_setup_control_longest(const hc_scene *scene) {
  return controls[scene->time_step.control].longest(scene);
}

int hc_setup_goes_back(const hc_scene *scene) {
  const int control = hc_setup_control_ops(scene)->goes_back, solver = hc_setup_solver_ops(scene)->goes_back;
  return control > 0 && solver > control ? solver : control;
}

hc_control hc_setup_control(const hc_scene *scene) {
  hc_control control;
  hc_control_init(&control, hc_setup_control_ops(scene), controls[scene->time_step.control].settings(scene));
  control.goes_back = hc_setup_goes_back(scene);
  return control;
}

double hc_setup_settle_step(const hc_scene *scene) {
  return scene->fluid.settle_steps > 0 ? hc_setup_calm_step(scene) : 0.0;
}

double hc_setup_calm_step(const hc_scene *scene) {
  hc_control control = hc_setup_control(scene);
  static const double CALM = 0.5; /* of the longest stable step: what forgets its speed bears half of it */
  const double step = fmin(hc_control_still(&control), CALM * hc_setup_solver_longest(scene));
  hc_control_free(&control);
  return step;
}
