#include "solvers.h"

#include "base/memory.h"
#include "setup/fluid.h"
#include "setup/rest_lattice.h"
#include "solver/dfsph.h"
#include "solver/pcisph.h"
#include "solver/wcsph.h"
#include "stepping/time_step.h"

#include <math.h>
#include <string.h>

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
  case HC_VISCOSITY_SMAGORINSKY:
    return HC_VISCOUS_SMAGORINSKY;
  }
  return HC_VISCOUS_NONE;
}

static hc_solver_settings common_settings(const hc_scene *scene) {
  hc_solver_settings common = {.rest_density = scene->fluid.rest_density,
                               .viscosity = viscosity_of(scene->fluid.viscosity.model),
                               .viscosity_coefficient = scene->fluid.viscosity.coefficient,
                               .sound_speed = hc_setup_sound_speed(scene),
                               .mixing_length = scene->fluid.viscosity.coefficient * scene->particle_spacing,
                               .kinematic_viscosity = scene->fluid.kinematic_viscosity,
                               .depth_pressure = scene->boundary.depth_pressure &&
                                                 scene->boundary.method == HC_BOUNDARY_AKINCI2012,
                               .negative_pressure = scene->solver.negative_pressure};
  memcpy(common.gravity, scene->gravity, sizeof common.gravity);
  memcpy(common.centre, scene->central_force.center, sizeof common.centre);
  common.central_rate = scene->central_force.rate;
  if (scene->fluid.surface_tension.model == HC_TENSION_BECKER2007)
    common.surface_tension = scene->fluid.surface_tension.coefficient;
  return common;
}

/* Sum of |grad W|^2 in a full support at rest, 1/m8. */
static double gradient_square_of(const hc_scene *scene) {
  const double h = scene->support_radius, h2 = h * h, h4 = h2 * h2;
  return hc_setup_rest_lattice_gradient(scene->particle_spacing / h) / (h4 * h4);
}

/* ---- dfsph ---- */

/* Whole corrections bear what those of the paper's support do, 2.154 spacings; wider ones feed back more.
 * Where errors count both ways they must not overshoot. */
static double relaxation_of(const hc_scene *scene) {
  static const double MOST = 3.2, SIGNED = 0.5;
  if (scene->solver.relaxation > 0.0) return scene->solver.relaxation;
  const double ratio = scene->particle_spacing / scene->support_radius;
  return fmin(scene->solver.negative_pressure ? SIGNED : 1.0, MOST / hc_setup_rest_lattice_eigenvalue(ratio));
}

static hc_solver_settings *dfsph_settings(const hc_scene *scene) {
  hc_dfsph_settings *settings = hc_alloc(1, sizeof *settings);
  *settings = (hc_dfsph_settings){.common = common_settings(scene),
                                  .density_error_avg = scene->solver.density_error_avg,
                                  .divergence_error = scene->solver.divergence_error,
                                  .density_min = scene->solver.density_iterations.min,
                                  .density_max = scene->solver.density_iterations.max,
                                  .divergence_min = scene->solver.divergence_iterations.min,
                                  .divergence_max = scene->solver.divergence_iterations.max,
                                  .warm_start = scene->solver.warm_start,
                                  .relaxation = relaxation_of(scene),
                                  .fast = scene->solver.pressure_solve == HC_PRESSURE_SOLVE_FAST,
                                  .gradient_square = gradient_square_of(scene),
                                  .gap_rule = scene->solver.gap_rule && !scene->solver.negative_pressure,
                                  .min_divergence_neighbors = scene->solver.min_divergence_neighbors};
  return &settings->common;
}

static void complete_dfsph(hc_scene *scene, bool by_errors, hc_findings *findings) {
  (void)by_errors;
  static const int LEAST = 3;
  const hc_given *given = findings->given;
  const bool swells = !scene->solver.gap_rule && !scene->solver.negative_pressure;
  if (!hc_given_has(given, "solver.pressure_solve") && (swells || scene->solver.negative_pressure))
    scene->solver.pressure_solve = HC_PRESSURE_SOLVE_PAPER;
  if (scene->solver.pressure_solve == HC_PRESSURE_SOLVE_FAST) {
    if (swells && !hc_given_is_bad(given, "solver.gap_rule") &&
        !hc_given_is_bad(given, "solver.pressure_solve"))
      hc_findings_error(
          findings, "solver.pressure_solve",
          "solver.pressure_solve must be paper with solver.gap_rule false, not fast: the better "
          "that converges, the more water swells as printed");
    return;
  }
  if (!hc_given_has(given, "solver.divergence_iterations.min"))
    scene->solver.divergence_iterations.min = LEAST;
}

/* ---- pcisph ---- */

static hc_solver_settings *pcisph_settings(const hc_scene *scene) {
  const double ratio = scene->particle_spacing / scene->support_radius;
  hc_pcisph_settings *settings = hc_alloc(1, sizeof *settings);
  *settings = (hc_pcisph_settings){.common = common_settings(scene),
                                   .density_error_avg = scene->solver.density_error_avg,
                                   .density_error_max = hc_scene_density_error_max(scene),
                                   .density_min = scene->solver.density_iterations.min,
                                   .density_max = scene->solver.density_iterations.max,
                                   .gradient_square = gradient_square_of(scene),
                                   .shepard = scene->solver.density_correction == HC_CORRECTION_SHEPARD,
                                   .release_steps = scene->solver.release_steps,
                                   .friction = scene->boundary.friction,
                                   .elasticity = scene->boundary.elasticity};
  const double volume = scene->fluid.mass_factor / hc_setup_rest_lattice_sum(ratio); /* in h3 */
  for (int k = 0; k <= HC_WALL_WEIGHTS; k++)
    settings->wall_weights[k] = (float)(volume * hc_setup_half_space(ratio, (double)k / HC_WALL_WEIGHTS));
  return &settings->common;
}

static void complete_pcisph(hc_scene *scene, bool by_errors, hc_findings *findings) {
  const hc_given *given = findings->given;
  if (!hc_given_has(given, "solver.density_error_avg")) scene->solver.density_error_avg = 0.01;
  if (!hc_given_has(given, "solver.density_iterations.min")) scene->solver.density_iterations.min = 3;
  if (by_errors && !hc_given_has(given, "solver.density_iterations.max"))
    scene->solver.density_iterations.max = scene->solver.density_iterations.min;
  const double average = scene->solver.density_error_avg, most = scene->solver.density_error_max;
  if (by_errors || hc_given_is_bad(given, "solver.density_error_max") ||
      hc_given_is_bad(given, "solver.density_error_avg") || most == 0.0 || most >= average)
    return;
  hc_findings_error(findings, "solver.density_error_max",
                    "solver.density_error_max must be 0 or >= solver.density_error_avg, not %g < %g", most,
                    average);
}

/* ---- wcsph ---- */

/* Sound must not cross more of a support radius in a step. A dam break at one step is stable with 0.8 and not
 * with 1; walls whose density goes with the square are steeper: 0.6, and not 0.8. */
static double wcsph_longest(const hc_scene *scene) {
  static const double SHARE = 0.8, SHARE_SQUARED = 0.6;
  const bool squared = scene->boundary.wall_density == HC_WALL_DENSITY_SQUARED;
  return (squared ? SHARE_SQUARED : SHARE) * scene->support_radius / hc_setup_wave_speed(scene);
}

static hc_solver_settings *wcsph_settings(const hc_scene *scene) {
  const double c = hc_setup_wave_speed(scene);
  hc_step_settings steps = {.min = scene->time_step.min,
                            .support_radius = scene->support_radius,
                            .viscosity = hc_setup_kinematic_viscosity(scene)};
  steps.longest = fmin(wcsph_longest(scene), hc_time_step_viscous_bound(&steps));
  if (scene->time_step.max > 0.0) steps.longest = fmin(steps.longest, scene->time_step.max);
  hc_wcsph_settings *settings = hc_alloc(1, sizeof *settings);
  settings->weak = (hc_weak_settings){.common = common_settings(scene),
                                      .tait = {(float)(c * c / 7.0), scene->solver.negative_pressure},
                                      .sound_speed = c,
                                      .fluctuation = scene->solver.density_fluctuation,
                                      .support_radius = scene->support_radius,
                                      .longest = steps.longest};
  if (scene->fluid.viscosity.sound_speed == 0.0) settings->weak.common.sound_speed = c;
  settings->individual = (hc_individual_settings){.on = scene->time_step.control == HC_TIME_INDIVIDUAL,
                                                  .raw = scene->time_step.steps == HC_STEPS_RAW,
                                                  .lasting = scene->time_step.blocks,
                                                  .velocity = scene->time_step.velocity,
                                                  .force = scene->time_step.force,
                                                  .shortest = hc_time_step_floor(&steps)};
  return &settings->weak.common;
}

static void complete_wcsph(hc_scene *scene, bool by_errors, hc_findings *findings) {
  (void)by_errors;
  const hc_given *given = findings->given;
  static const double USUAL = 0.1;
  const hc_viscosity_model model = scene->fluid.viscosity.model;
  if (hc_given_is_bad(given, "fluid.viscosity.model")) return;
  if (!hc_given_has(given, "fluid.viscosity.model"))
    scene->fluid.viscosity.model = HC_VISCOSITY_ARTIFICIAL;
  else if (model == HC_VISCOSITY_XSPH)
    hc_findings_error(
        findings, "fluid.viscosity.model",
        "fluid.viscosity.model must not be xsph with solver.method wcsph: it smooths velocities "
        "once a step, so its strength would hang on the step; leave it out, or artificial with 0.1");
  if (scene->fluid.viscosity.model == HC_VISCOSITY_ARTIFICIAL &&
      !hc_given_has(given, "fluid.viscosity.coefficient"))
    scene->fluid.viscosity.coefficient = USUAL;
}

/* ---- the table ---- */

static const struct {
  const hc_solver_ops *ops;
  hc_solver_settings *(*settings)(const hc_scene *scene);
  void (*complete)(hc_scene *scene, bool by_errors, hc_findings *findings); /* null: nothing to do */
  double (*longest)(const hc_scene *scene);                                 /* stable step, s; null: any */
} solvers[] = {[HC_SOLVER_DFSPH] = {&hc_solver_dfsph, dfsph_settings, complete_dfsph, NULL},
               [HC_SOLVER_PCISPH] = {&hc_solver_pcisph, pcisph_settings, complete_pcisph, NULL},
               [HC_SOLVER_WCSPH] = {&hc_solver_wcsph, wcsph_settings, complete_wcsph, wcsph_longest}};

double hc_setup_solver_longest(const hc_scene *scene) {
  return solvers[scene->solver.method].longest ? solvers[scene->solver.method].longest(scene) : INFINITY;
}

const hc_solver_ops *hc_setup_solver_ops(const hc_scene *scene) {
  return solvers[scene->solver.method].ops;
}

hc_solver_settings *hc_setup_solver_settings(const hc_scene *scene) {
  return solvers[scene->solver.method].settings(scene);
}

void hc_setup_solver_complete(hc_scene *scene, bool by_errors, hc_findings *findings) {
  if (solvers[scene->solver.method].complete)
    solvers[scene->solver.method].complete(scene, by_errors, findings);
}
