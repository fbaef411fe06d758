/* Weakly compressible SPH: He, Ban, Liu, Wang 2015, section 2.1 and algorithm 1, which is Monaghan 1994 and
 * Becker and Teschner 2007, on the single-layer boundary of Akinci et al. 2012.
 *
 * Densities are sums, pressures follow from them (sph/tait.h), and everything that acts is explicit:
 * pressure, viscosity, walls, gravity give an acceleration, and v += dt a, x += dt v. A wall pushes with the
 * particle's own pressure along B = sum V_b grad W. The sound speed is chosen so that the density stays
 * within the fluctuation that is permitted: c = v/sqrt(fluctuation). Pressures are clamped at 0: a free
 * surface does not pull.
 *
 * What walls do beside their pressure (wall_layer.h) is found as over the longest step, of which friction is
 * a small share, so that accelerations do not depend on the step.
 *
 * Known weakness: sound. A start that is not at rest rings, and what it rings with is only damped by the
 * viscosity. */
#include "wcsph.h"

#include "wall_layer.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const hc_wcsph_settings *own_of(const hc_solver_settings *settings) {
  return (const hc_wcsph_settings *)settings;
}

/* Densities and pressures of own particles, and of their ghosts. */
static hc_error_total find_pressures(hc_world *world, const hc_wcsph_settings *settings) {
  hc_error_total total;
  memset(&total, 0, sizeof total);
  const hc_selection border = hc_select_border(world->listed, world->fluid),
                     interior = hc_select_interior(world->listed, world->fluid);
  world->sweeps->weak_density(&world->sweep, &settings->tait, border, &total);
  hc_halo_begin(world->halo, HC_SCALAR(place));
  world->sweeps->weak_density(&world->sweep, &settings->tait, interior, &total);
  hc_halo_end(world->halo);
  return total;
}

/* The change of velocity over the longest step, but by gravity, three a particle, in the store's scratch. */
static float *find_changes(hc_world *world, const hc_wcsph_settings *settings) {
  hc_solver_settings others = settings->common;
  float viscosity = 0.0f;
  if (others.viscosity == HC_VISCOUS_ARTIFICIAL) {
    viscosity = (float)(others.viscosity_coefficient * world->frame.support_radius * others.sound_speed);
    others.viscosity = HC_VISCOUS_NONE;
  }
  float *change = hc_find_forces(world, &others, settings->longest);
  hc_wall_layer_add(world, &settings->common, settings->longest, change, world->listed);
  world->sweeps->weak_forces(&world->sweep, viscosity, (float)settings->longest, change, NULL, world->listed);
  return change;
}

/* Changes become accelerations, gravity included. Returns the largest, m/s2. */
static double find_accelerations(const hc_world *world, const hc_wcsph_settings *settings, float *change) {
  const double rate = 1.0 / settings->longest;
  const bool alike = settings->common.central_rate == 0.0;
  double largest = 0.0, body[3];
  memcpy(body, settings->common.gravity, sizeof body);
  for (int32_t i = 0; i < world->fluid->own; i++) {
    double square = 0.0;
    if (!alike) hc_body_force(world, &settings->common, i, body);
    for (int axis = 0; axis < 3; axis++) {
      const double a = (double)change[3 * (size_t)i + (size_t)axis] * rate + body[axis];
      change[3 * (size_t)i + (size_t)axis] = (float)a;
      square += a * a;
    }
    if (square > largest) largest = square;
  }
  return sqrt(largest);
}

static double largest_speed(const hc_particles *fluid) {
  double largest = 0.0;
  for (int32_t i = 0; i < fluid->own; i++) {
    const double *const v = &fluid->velocity[3 * (size_t)i], square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (square > largest) largest = square;
  }
  return sqrt(largest);
}

static void evaluate(hc_world *world, const hc_solver_settings *settings, hc_step_report *report) {
  const hc_wcsph_settings *const own = own_of(settings);
  memset(report, 0, sizeof *report);
  hc_remember_velocities(world);
  hc_fault_watch_start(world, own->longest, &report->fault);
  hc_stopwatch_enter(&world->watch, HC_STAGE_DENSITY);
  const hc_error_total total = find_pressures(world, own);
  hc_fault_watch_density(world, &report->fault);

  hc_stopwatch_enter(&world->watch, HC_STAGE_FORCES);
  hc_wall_layer_look(world, settings, settings->depth_pressure ? world->fluid->pressure : NULL);
  double most[2] = {largest_speed(world->fluid), find_accelerations(world, own, find_changes(world, own))};
  hc_tally tally = {.count = 0};
  hc_tally_max_f64(&tally, most, 2);
  const double particles = world->fluid_total > 0 ? (double)world->fluid_total : 1.0;
  report->density_error_avg =
      hc_reduce_errors(world->comm, &total, &tally, &report->density_error_max) / particles;
  report->v_max = most[0];
  report->force_max = most[1];
}

/* v += dt a */
static void accelerate(hc_world *world, const float *acceleration, double dt) {
  hc_particles *const fluid = world->fluid;
  for (int32_t i = 0; i < fluid->own; i++)
    for (int axis = 0; axis < 3; axis++) {
      double *const velocity = &fluid->velocity[3 * (size_t)i + (size_t)axis];
      *velocity += dt * (double)acceleration[3 * (size_t)i + (size_t)axis];
      fluid->motion[i].v[axis] = (float)*velocity;
    }
}

/* What friction took over the longest step becomes what it took over dt. */
static void shorten_rubs(hc_touches *touches, double share) {
  for (size_t k = 0; k < touches->count; k++)
    for (int axis = 0; axis < 3; axis++) touches->at[k].rub[axis] *= (float)share;
}

static hc_status step(hc_world *world, const hc_solver_settings *settings, double dt, double dt_before,
                      hc_step_report *report, hc_error *error) {
  (void)dt_before;
  hc_stopwatch_enter(&world->watch, HC_STAGE_MOVE);
  accelerate(world, hc_particles_scratch(world->fluid, 3 * sizeof(float)), dt);
  shorten_rubs(&world->touches, dt / own_of(settings)->longest);
  return hc_move(world, settings, dt, HC_MOVE_BY_VELOCITY, false, report, error);
}

static void densities(hc_world *world, const hc_solver_settings *settings) {
  find_pressures(world, own_of(settings));
}

/* What is compressed at the start flies apart with the sound speed. */
static hc_status check_start(const hc_world *world, const hc_solver_settings *settings, hc_error *error) {
  static const double MOST = 0.05, MOST_IN_FULL = 0.2, FULL = 0.9;
  const double most = world->volume_factor > FULL ? MOST_IN_FULL : MOST;
  if (hc_solver_check_density(world, settings, most, "", error) != HC_OK) return error->status;
  return hc_solver_check_walls(world, error);
}

static void describe(const hc_solver_settings *settings, char *text, size_t size) {
  const hc_wcsph_settings *const own = own_of(settings);
  snprintf(text, size, "sound speed %.6g m/s, steps of at most %.4g s", own->sound_speed, own->longest);
}

static const char *const controls[] = {"global", "constant", NULL};

const hc_solver_ops hc_solver_wcsph = {.name = "wcsph",
                                       .features = HC_FOR_WCSPH,
                                       .walls = 1u << HC_WALLS_MIRRORED,
                                       .walls_why =
                                           "the others move predicted positions, which only pcisph has",
                                       .compressible = true,
                                       .squared_walls = true,
                                       .controls = controls,
                                       .evaluate = evaluate,
                                       .step = step,
                                       .densities = densities,
                                       .check_start = check_start,
                                       .describe = describe};
