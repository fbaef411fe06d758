/* Weakly compressible SPH: He, Ban, Liu, Wang 2015, section 2.1 and algorithm 1, which is Monaghan 1994 and
 * Becker and Teschner 2007, on the single-layer boundary of Akinci et al. 2012.
 *
 * Densities are sums, pressures follow from them (sph/tait.h), and everything that acts is explicit:
 * pressure, viscosity, walls, gravity give an acceleration, and v += dt a, x += dt v. A wall pushes with the
 * particle's own pressure along B = sum V_b grad W. The sound speed is chosen so that the density stays
 * within the fluctuation that is permitted: c = v/sqrt(fluctuation). Pressures are clamped at 0: a free
 * surface does not pull.
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

static void evaluate(hc_world *world, const hc_solver_settings *settings, hc_step_report *report) {
  const hc_weak_settings *const weak = &own_of(settings)->weak;
  hc_error_total total;
  memset(&total, 0, sizeof total);
  memset(report, 0, sizeof *report);
  hc_remember_velocities(world);
  hc_fault_watch_start(world, weak->longest, &report->fault);
  hc_stopwatch_enter(&world->watch, HC_STAGE_DENSITY);
  hc_weak_pressures(world, weak, world->listed, NULL, NULL, &total);
  hc_fault_watch_density(world, &report->fault);

  hc_stopwatch_enter(&world->watch, HC_STAGE_FORCES);
  hc_wall_layer_list(world, settings->depth_pressure);
  const double strongest = hc_weak_accelerations(world, weak, world->fluid->density_rate, world->listed);
  double most[2] = {sqrt(hc_fastest(world->fluid)), strongest};
  hc_tally tally = {.count = 0};
  hc_tally_max_f64(&tally, most, 2);
  const double particles = world->fluid_total > 0 ? (double)world->fluid_total : 1.0;
  report->density_error_avg =
      hc_reduce_errors(world->comm, &total, &tally, &report->density_error_max) / particles;
  report->v_max = most[0];
  report->force_max = most[1];
}

/* v += dt a */
static void accelerate(hc_world *world, double dt) {
  hc_particles *const fluid = world->fluid;
  const float *const acceleration = hc_weak_accelerations_of(world);
  for (int32_t i = 0; i < fluid->own; i++)
    for (int axis = 0; axis < 3; axis++) {
      double *const velocity = &fluid->velocity[3 * (size_t)i + (size_t)axis];
      *velocity += dt * (double)acceleration[3 * (size_t)i + (size_t)axis];
      fluid->motion[i].v[axis] = (float)*velocity;
    }
}

static hc_status step(hc_world *world, hc_bodies *bodies, const hc_solver_settings *settings, double dt,
                      double dt_before, hc_step_report *report, hc_error *error) {
  const hc_wcsph_settings *const own = own_of(settings);
  (void)bodies; /* pressures follow from densities: they need not know how bodies yield */
  (void)dt_before;
  if (own->individual.on)
    return hc_individual_advance(world, &own->weak, &own->individual, dt, report, error);
  hc_wall_layer_shorten(world, dt / own->weak.longest);
  hc_stopwatch_enter(&world->watch, HC_STAGE_MOVE);
  accelerate(world, dt);
  return hc_move(world, settings, dt, HC_MOVE_BY_VELOCITY, false, report, error);
}

static double reach(const hc_solver_settings *settings, const hc_step_report *report, double dt) {
  const hc_wcsph_settings *const own = own_of(settings);
  if (!own->individual.on) return 0.0;
  return hc_individual_reach(&own->weak, &own->individual, report->v_max, report->force_max, dt);
}

static void densities(hc_world *world, const hc_solver_settings *settings) {
  hc_error_total total;
  memset(&total, 0, sizeof total);
  hc_weak_pressures(world, &own_of(settings)->weak, world->listed, NULL, NULL, &total);
}

static void describe(const hc_solver_settings *settings, char *text, size_t size) {
  const hc_weak_settings *const weak = &own_of(settings)->weak;
  snprintf(text, size, "sound speed %.6g m/s, steps of at most %.4g s", weak->sound_speed, weak->longest);
}

static bool doubt(const hc_solver_settings *settings, const hc_step_report *report, char *text, size_t size) {
  const hc_weak_settings *const weak = &own_of(settings)->weak;
  if (!(report->density_error_avg > weak->fluctuation)) return false;
  snprintf(text, size,
           "densities are off by %.3g %% on average, more than solver.density_fluctuation, %.3g %%: the "
           "water is faster "
           "than the sound speed of %.4g m/s was chosen for, see solver.sound_speed",
           100.0 * report->density_error_avg, 100.0 * weak->fluctuation, weak->sound_speed);
  return true;
}

static const char *const controls[] = {"individual", "global", "constant", NULL};

const hc_solver_ops hc_solver_wcsph = {.name = "wcsph",
                                       .features = HC_FOR_WCSPH,
                                       .walls = 1u << HC_WALLS_MIRRORED,
                                       .walls_why =
                                           "the others move predicted positions, which only pcisph has",
                                       .compressible = true,
                                       .squared_walls = true,
                                       .controls = controls,
                                       .reach = reach,
                                       .evaluate = evaluate,
                                       .step = step,
                                       .densities = densities,
                                       .check_start = hc_solver_check_settled,
                                       .describe = describe,
                                       .doubt = doubt};
