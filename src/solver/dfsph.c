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
 * Warm start: the share `warm_start` of the last step's K, scaled by (dt/dt_before)^2 (k by dt/dt_before) so
 * that the pressure stays the same, where the predicted error is positive. The full share makes a resting
 * column swell. Known weakness: only compression is corrected, so a full closed domain cannot come to rest;
 * fill it 1 % under. */
#include "dfsph.h"

#include "sph/error_rule.h"
#include "wall_layer.h"
#include "yield.h"

#include <math.h>
#include <string.h>

/* One of the two solves. */
typedef struct solve {
  hc_world *world;
  hc_yield *yield;
  hc_error_rule rule;
  float weight;      /* of velocity corrections: 1 or 1/dt */
  float *multiplier; /* K or k */
  float warm;        /* share of the last multipliers to start from */
  double threshold;  /* of the average error */
  int min, max;      /* iterations */
} solve;

typedef struct solved {
  int iterations;
  bool capped;
  bool broken; /* the errors are no numbers, or beyond 2^30: stopped at once */
  double average, max;
} solved;

/* Starts the multiplier of selected particles from the last step's where the error says so. */
static void warm_start(const solve *solve, hc_selection selection) {
  hc_record *place = solve->world->fluid->place;
  const bool always = solve->rule.signed_error;
  for (int32_t row = selection.begin; row < selection.end; row++) {
    const int32_t i = hc_selected(selection, row);
    place[i].scalar = always || place[i].scalar > 0.0f ? solve->warm * solve->multiplier[i] : 0.0f;
    solve->multiplier[i] = 0.0f;
  }
}

/* The first prediction of a solve takes over the warm start's multipliers; the first of a step finds the
 * density rates ready, from the density sweep. */
typedef enum prediction { FROM_RATES, FIRST, AGAIN } prediction;

static void predict_part(const solve *solve, prediction which, hc_selection part, hc_error_total *total) {
  hc_world *world = solve->world;
  if (which == FROM_RATES)
    hc_error_from_rate(&world->sweep, &solve->rule, part, total);
  else
    world->sweeps->error(&world->sweep, &solve->rule, part, total);
  if (which != AGAIN) warm_start(solve, part);
}

/* Predicts the errors of all own particles and gives ghosts their multipliers. */
static hc_error_total predict(const solve *solve, prediction which) {
  hc_world *world = solve->world;
  hc_error_total total;
  memset(&total, 0, sizeof total);
  predict_part(solve, which, hc_select_border(world->listed, world->fluid), &total);
  hc_halo_begin(world->halo, HC_SCALAR(place));
  predict_part(solve, which, hc_select_interior(world->listed, world->fluid), &total);
  hc_halo_end(world->halo);
  return total;
}

/* Corrects velocities by the multipliers in place.scalar, bodies' too. */
static void correct(const solve *solve) {
  hc_world *world = solve->world;
  world->sweeps->pressure(&world->sweep, solve->weight, solve->multiplier,
                          hc_select_border(world->listed, world->fluid));
  hc_hold_still(world, 0, world->fluid->border);
  hc_halo_begin(world->halo, HC_WHOLE(motion));
  world->sweeps->pressure(&world->sweep, solve->weight, solve->multiplier,
                          hc_select_interior(world->listed, world->fluid));
  hc_hold_still(world, world->fluid->border, world->fluid->own);
  hc_yield_act(solve->yield);
  hc_halo_end(world->halo);
}

/* Algorithms 3 and 4: predict, then correct and predict until the average error is below the threshold. The
 * total is asked for below the least number of iterations too: what is no number must not spread unseen. */
static solved iterate(const solve *solve, prediction first) {
  hc_world *world = solve->world;
  const double particles = world->fluid_total > 0 ? (double)world->fluid_total : 1.0;
  hc_tally pushes = {.count = 0}; /* on bodies, of the correction to come */
  predict(solve, first);
  hc_yield_note(solve->yield, (double)solve->weight, &pushes);
  hc_tally_reduce(world->comm, &pushes);
  correct(solve);
  solved result = {0};
  for (;; result.iterations++) {
    const hc_error_total total = predict(solve, AGAIN);
    hc_yield_note(solve->yield, (double)solve->weight, &pushes);
    result.average = hc_reduce_errors(world->comm, &total, &pushes, &result.max) / particles;
    result.broken = !isfinite(result.average) || solve->yield->impulses.broken;
    if (result.broken || (result.average <= solve->threshold && result.iterations >= solve->min)) break;
    result.capped = result.iterations >= solve->max;
    if (result.capped) break;
    correct(solve);
  }
  return result;
}

/* Algorithm 4: the average of positive density rates goes below divergence_error/dt. */
static solved correct_divergence_error(hc_world *world, hc_yield *yield, const hc_dfsph_settings *settings,
                                       double dt, double dt_before) {
  const solve solve = {.world = world,
                       .yield = yield,
                       .rule = {.of_rate = 1.0f,
                                .of_gap = settings->gap_rule ? (float)(1.0 / dt) : 0.0f,
                                .min_neighbors = settings->min_divergence_neighbors,
                                .signed_error = settings->common.negative_pressure,
                                .relaxation = (float)settings->relaxation},
                       .weight = 1.0f,
                       .multiplier = world->fluid->divergence_multiplier,
                       .warm = dt_before > 0.0 ? (float)(settings->warm_start * (dt / dt_before)) : 0.0f,
                       .threshold = settings->divergence_error / dt,
                       .min = settings->divergence_min,
                       .max = settings->divergence_max};
  return iterate(&solve, FROM_RATES);
}

/* Algorithm 3: the average of predicted compressions goes below density_error_avg. */
static solved correct_density_error(hc_world *world, hc_yield *yield, const hc_dfsph_settings *settings,
                                    double dt, double dt_before) {
  const double ratio = dt_before > 0.0 ? dt / dt_before : 0.0;
  const solve solve = {.world = world,
                       .yield = yield,
                       .rule = {.of_density = 1.0f,
                                .of_rate = (float)dt,
                                .signed_error = settings->common.negative_pressure,
                                .relaxation = (float)settings->relaxation},
                       .weight = (float)(1.0 / dt),
                       .multiplier = world->fluid->pressure_multiplier,
                       .warm = (float)(settings->warm_start * ratio * ratio),
                       .threshold = settings->density_error_avg,
                       .min = settings->density_min,
                       .max = settings->density_max};
  return iterate(&solve, FIRST);
}

/* v += dt * non-pressure accelerations, and what walls do beside them; ghosts too. */
static void apply_forces(hc_world *world, const hc_solver_settings *settings, double dt,
                         hc_step_report *report) {
  const int32_t border = world->fluid->border, own = world->fluid->own;
  const float *change = hc_find_forces(world, settings, dt, world->listed);
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
  const solved divergence = correct_divergence_error(world, &yield, own, dt, dt_before);

  hc_stopwatch_enter(&world->watch, HC_STAGE_FORCES);
  if (!divergence.broken) {
    apply_forces(world, settings, dt, report);
    hc_yield_accelerate(&yield);
  }

  /* correctDensityError(alpha, v) */
  hc_stopwatch_enter(&world->watch, HC_STAGE_PRESSURE);
  const solved density =
      divergence.broken ? divergence : correct_density_error(world, &yield, own, dt, dt_before);

  hc_yield_show(&yield);
  hc_yield_end(&yield);

  /* x += dt * v */
  hc_stopwatch_enter(&world->watch, HC_STAGE_MOVE);
  store_pressure(world->fluid, settings->rest_density, dt);
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
