/* Divergence-free SPH: Bender and Koschier 2015 as Carensac, Pronost, Bouakaz 2023 print it (appendix A,
 * algorithms 2 to 4), on the single-layer boundary of Akinci et al. 2012.
 *
 * Densities and errors are fractions of the rest density, so a multiplier kappa = alpha * error has the unit
 * m2 (density solver) or m2/s (divergence solver), and pressure = rho0 (K/dt^2 + k/dt) with K, k the sums of
 * a step's multipliers. Static boundary particles enter through B = sum V_b grad W alone, which holds for a
 * whole step: iterations cost fluid pairs only.
 *
 * Gaps: as printed, the divergence solver removes every rate that compresses, of fluid below the rest density
 * too, and none that expands: what has parted may not come together again, and water swells by some percent
 * in two seconds of splashing. With the gap rule (not in the paper) it leaves alone the part of a rate that
 * only closes a gap within the step.
 *
 * Solves: as printed (diagonal.c), or the density solve along conjugate directions with a start of its own,
 * behind which the divergence solve needs no warm start (conjugate.c).
 *
 * Warm start, as printed: the share `warm_start` of the last step's K, scaled by (dt/dt_before)^2 (k by
 * dt/dt_before) so that the pressure stays the same, where the predicted error is positive. The full share
 * makes a resting column swell. Known weakness: only compression is corrected, so a full closed domain cannot
 * come to rest; fill it 1 % under. */
#include "dfsph.h"

#include "iterations.h"
#include "wall_layer.h"

#include <string.h>

/* The pressure that multipliers of a step of dt stand for; none before the first step. */
static void store_pressure(hc_particles *fluid, double rest_density, double dt) {
  if (!(dt > 0.0)) {
    memset(fluid->pressure, 0, (size_t)fluid->own * sizeof *fluid->pressure);
    return;
  }
  const float of_density = (float)(rest_density / (dt * dt)), of_divergence = (float)(rest_density / dt);
  for (int32_t i = 0; i < fluid->own; i++)
    fluid->pressure[i] =
        of_density * fluid->pressure_multiplier[i] + of_divergence * fluid->divergence_multiplier[i];
}

/* Algorithm 4: the average of positive density rates goes below divergence_error/dt. What then smooths
 * velocities is found with the errors they have. */
static hc_solved correct_divergence_error(hc_world *world, hc_yield *yield, const hc_dfsph_settings *settings,
                                          double dt, double dt_before, const hc_smoothing *smoothing) {
  const hc_solve solve = {
      .world = world,
      .yield = yield,
      .rule = {.of_rate = 1.0f,
               .of_gap = settings->gap_rule ? (float)(1.0 / dt) : 0.0f,
               .min_neighbors = settings->min_divergence_neighbors,
               .signed_error = settings->common.negative_pressure,
               .relaxation = (float)settings->relaxation},
      .weight = 1.0f,
      .multiplier = world->fluid->divergence_multiplier,
      .warm = settings->fast || !(dt_before > 0.0) ? 0.0f : (float)(settings->warm_start * (dt / dt_before)),
      .rates_known = true,
      .threshold = settings->divergence_error / dt,
      .min = settings->divergence_min,
      .max = settings->divergence_max,
      .smoothing = smoothing};
  return hc_solve_diagonal(&solve);
}

/* Algorithm 3: the average of predicted compressions goes below density_error_avg. Pressures follow. */
static hc_solved correct_density_error(hc_world *world, hc_yield *yield, const hc_dfsph_settings *settings,
                                       double dt, double dt_before) {
  const double ratio = dt_before > 0.0 ? dt / dt_before : 0.0, volume = world->sweep.volume;
  const hc_solve solve = {.world = world,
                          .yield = yield,
                          .rule = {.of_density = 1.0f,
                                   .of_rate = (float)dt,
                                   .signed_error = settings->common.negative_pressure,
                                   .relaxation = (float)settings->relaxation},
                          .weight = (float)(1.0 / dt),
                          .multiplier = world->fluid->pressure_multiplier,
                          .warm = (float)((settings->fast ? 1.0 : settings->warm_start) * ratio * ratio),
                          .threshold = settings->density_error_avg,
                          .min = settings->density_min,
                          .max = settings->density_max};
  const hc_solved solved =
      settings->fast ? hc_solve_conjugate(&solve, dt, 1.0 / (volume * volume * settings->gradient_square))
                     : hc_solve_diagonal(&solve);
  store_pressure(world->fluid, settings->common.rest_density, dt);
  if (settings->fast) hc_solve_remember(&solve, &solved);
  return solved;
}

/* v += dt * non-pressure accelerations, and what walls do beside them; ghosts too. */
static void apply_forces(hc_world *world, const hc_solver_settings *settings, double dt,
                         const hc_smoothing *smoothed, hc_step_report *report) {
  const int32_t border = world->fluid->border, own = world->fluid->own;
  const float *change = hc_find_forces(world, settings, dt, smoothed, world->listed);
  hc_accelerate(world, settings, change, dt, 0, border);
  hc_wall_layer_act(world, settings, dt, 0, border);
  hc_hold_still(world, 0, border);
  hc_halo_begin(world->halo, HC_WHOLE(motion));
  hc_accelerate(world, settings, change, dt, border, own);
  hc_wall_layer_act(world, settings, dt, border, own);
  hc_hold_still(world, border, own);
  report->force_max = hc_largest_force(world, settings, dt, change, NULL);
  hc_halo_end(world->halo);
}

/* Algorithm 2; the neighbourhoods are found by hc_world_update before. */
static hc_status step(hc_world *world, hc_bodies *bodies, const hc_solver_settings *settings, double dt,
                      double dt_before, hc_step_report *report, hc_error *error) {
  const hc_dfsph_settings *own = (const hc_dfsph_settings *)settings;
  memset(report, 0, sizeof *report);
  if (settings->depth_pressure) store_pressure(world->fluid, settings->rest_density, dt_before);
  hc_wall_layer_look(world, settings, settings->depth_pressure ? world->fluid->pressure : NULL);
  hc_remember_velocities(world);
  hc_fault_watch_start(world, dt, &report->fault);

  /* densities rho_i, factors alpha_i; and already the rates D rho_i/Dt, from the same neighbours */
  hc_stopwatch_enter(&world->watch, HC_STAGE_DENSITY);
  world->sweeps->density(&world->sweep, world->listed);
  hc_fault_watch_density(world, &report->fault);
  hc_yield yield;
  hc_yield_begin(&yield, world, bodies, dt);
  hc_yield_measure(&yield);
  hc_yield_soften(&yield);

  /* correctDivergenceError(alpha, v) */
  hc_stopwatch_enter(&world->watch, HC_STAGE_DIVERGENCE);
  const hc_smoothing ahead = hc_find_forces_ahead(world, settings), *const smoothing =
                                                                        ahead.change ? &ahead : NULL;
  const hc_solved divergence = correct_divergence_error(world, &yield, own, dt, dt_before, smoothing);

  hc_stopwatch_enter(&world->watch, HC_STAGE_FORCES);
  if (!divergence.broken) {
    apply_forces(world, settings, dt, smoothing, report);
    hc_yield_accelerate(&yield);
  }

  /* correctDensityError(alpha, v) */
  hc_stopwatch_enter(&world->watch, HC_STAGE_PRESSURE);
  const hc_solved density =
      divergence.broken ? divergence : correct_density_error(world, &yield, own, dt, dt_before);

  hc_yield_show(&yield);
  hc_yield_end(&yield);

  /* x += dt * v */
  hc_stopwatch_enter(&world->watch, HC_STAGE_MOVE);
  report->density_iterations = density.iterations;
  report->density_capped = density.capped;
  report->density_error_avg = density.average;
  report->density_error_max = density.max;
  report->divergence_iterations = divergence.iterations;
  report->divergence_capped = divergence.capped;
  return hc_move(world, settings, dt, HC_MOVE_BY_VELOCITY, divergence.broken || density.broken, report,
                 error);
}

static void densities(hc_world *world, const hc_solver_settings *settings) {
  (void)settings;
  world->sweeps->density(&world->sweep, world->listed);
}

static hc_solver_effort effort(hc_solver_settings *settings) {
  hc_dfsph_settings *const own = (hc_dfsph_settings *)settings;
  return (hc_solver_effort){&own->density_error_avg, &own->density_max};
}

static const char *const controls[] = {"cfl", "constant", "adaptive", NULL};

const hc_solver_ops hc_solver_dfsph = {.name = "dfsph",
                                       .features = HC_FOR_DFSPH,
                                       .walls = 1u << HC_WALLS_MIRRORED,
                                       .walls_why =
                                           "the others move predicted positions, which only pcisph has",
                                       .squared_walls = true,
                                       .controls = controls,
                                       .step = step,
                                       .densities = densities,
                                       .effort = effort,
                                       .check_start = hc_solver_check_settled,
                                       .summary = hc_solver_tell_caps};
