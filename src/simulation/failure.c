#include "failure.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { RECENT = 10 }; /* steps */

/* What is known of the particle that a fault names; NaN and -1 where it is gone. */
typedef struct victim {
  int fluid_neighbors, wall_neighbors;
  double at[3], speed;  /* m, m/s */
  double density_error; /* 1 */
  double nearest;       /* distance of the nearest neighbour, particle or sample, in spacings */
  bool below;           /* outside the walls' box, on a side other than against gravity */
} victim;

/* A failed step. */
typedef struct failure {
  const hc_simulation *simulation;
  const hc_step_report *before;
  hc_fault fault;
  double dt;
  victim victim;
} failure;

/* ---- the particle ---- */

static double nearest_of(const hc_world *world, const hc_neighbors *list, const hc_particles *others,
                         int32_t i) {
  const int32_t *own = world->fluid->place[i].x;
  double nearest = INFINITY;
  for (int k = 0; k < hc_list_count(list, i); k++) {
    const uint32_t offset = hc_list_row(list, i)[k];
    const int32_t *other = others->place[offset / sizeof(hc_record)].x;
    double square = 0.0;
    for (int axis = 0; axis < 3; axis++) {
      const double d =
          (double)(int32_t)((uint32_t)own[axis] - (uint32_t)other[axis]) * world->frame.unit[axis];
      square += d * d;
    }
    nearest = fmin(nearest, sqrt(square));
  }
  return nearest;
}

/* The smallest box around all boundary samples, as -low and high, so that one maximum makes it. Collective.
 */
static void box_of_walls(const hc_world *world, int64_t box[6]) {
  for (int k = 0; k < 6; k++) box[k] = INT64_MIN;
  for (int32_t k = 0; k < world->boundary->own; k++)
    for (int axis = 0; axis < 3; axis++) {
      const int64_t x = world->boundary->position[3 * (size_t)k + (size_t)axis];
      if (-x > box[axis]) box[axis] = -x;
      if (x > box[3 + axis]) box[3 + axis] = x;
    }
  hc_comm_max_i64(world->comm, box, 6);
}

static bool is_below(const hc_simulation *simulation, const int64_t box[6], const int64_t x[3]) {
  const hc_world *world = &simulation->world;
  if (world->boundary_total == 0) return false;
  for (int axis = 0; axis < 3; axis++) {
    if (world->frame.period[axis] > 0) continue;
    const double gravity = simulation->scene->gravity[axis];
    if ((-x[axis] > box[axis] && gravity <= 0.0) || (x[axis] > box[3 + axis] && gravity >= 0.0)) return true;
  }
  return false;
}

static victim describe(const hc_simulation *simulation, const int64_t box[6], int32_t i) {
  const hc_world *world = &simulation->world;
  const hc_particles *fluid = world->fluid;
  const double *v = &fluid->velocity[3 * (size_t)i];
  const int64_t *x = &fluid->position[3 * (size_t)i];
  const double rest = simulation->scene->fluid.rest_density, spacing = simulation->scene->particle_spacing;
  victim found = {.fluid_neighbors = hc_list_count(&world->list, i),
                  .wall_neighbors = hc_list_count(&world->walls, i),
                  .speed = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]),
                  .density_error = (double)fluid->density[i] / rest - 1.0,
                  .nearest = fmin(nearest_of(world, &world->list, fluid, i),
                                  nearest_of(world, &world->walls, world->boundary, i)) /
                             spacing,
                  .below = is_below(simulation, box, x)};
  for (int axis = 0; axis < 3; axis++) found.at[axis] = hc_frame_to_metres(&world->frame, axis, x[axis]);
  return found;
}

/* The particle of this id, from its owner. Collective. */
static victim find_victim(hc_simulation *simulation, uint64_t id) {
  hc_comm *comm = simulation->comm;
  int64_t box[6], owner = -1;
  victim found = {-1, -1, {NAN, NAN, NAN}, NAN, NAN, NAN, false};
  box_of_walls(&simulation->world, box);
  for (int32_t k = 0; k < simulation->world.fluid->own; k++) {
    if (simulation->world.fluid->id[k] != id) continue;
    owner = comm->rank;
    found = describe(simulation, box, k);
  }
  hc_comm_max_i64(comm, &owner, 1);
  if (owner >= 0) hc_comm_broadcast(comm, &found, sizeof found, (int)owner);
  return found;
}

/* ---- the likely cause: the first rule that holds ---- */

typedef bool rule(const failure *failure, char *text, size_t size);

static bool by_hook(const failure *f, char *text, size_t size) {
  const hc_scene *scene = f->simulation->scene;
  const int64_t step = f->simulation->step;
  const bool nan = scene->faults.nan_at > 0 && scene->faults.nan_at == step;
  if (!nan && !(scene->faults.kick_at > 0 && scene->faults.kick_at == step)) return false;
  snprintf(text, size, "the test hook faults.%s", nan ? "nan_at" : "kick_at");
  return true;
}

static bool by_shock(const failure *f, char *text, size_t size) {
  const hc_shock_guard *guard = &f->simulation->control.guard;
  if (f->fault.kind != HC_FAULT_TIME_STEP || guard->until == 0.0) return false;
  char what[HC_SHOCK_TEXT];
  hc_shock_text(&guard->shock, what);
  snprintf(text, size,
           "a shock at %.6g s, that %lld restarts with ever shorter steps did not get past: %s; see "
           "solver.density_error_max and time_step.adaptive",
           guard->shock.time, (long long)guard->restarts - 1, what);
  return true;
}

/* An adaptive step that shrank and shrank. */
static bool by_error(const failure *f, char *text, size_t size) {
  const hc_step_bound bound = f->simulation->control.bound;
  if (f->fault.kind != HC_FAULT_TIME_STEP || (bound != HC_BOUND_ERROR_AVG && bound != HC_BOUND_ERROR_MAX))
    return false;
  snprintf(text, size,
           "the %s stays above what shrinks the step, however short it is; see solver.density_error_avg and "
           "time_step.adaptive.shrink",
           hc_step_bound_name(bound));
  return true;
}

static bool by_gap(const failure *f, char *text, size_t size) {
  if (f->fault.kind != HC_FAULT_LEFT && !f->victim.below) return false;
  if (f->fault.kind == HC_FAULT_LEFT && !f->victim.below)
    snprintf(text, size,
             "it was thrown out by an impact, or flew out of an open face; domain.limits are too narrow "
             "for this scene, or domain.leaving: remove is wanted");
  else
    snprintf(text, size,
             "it is outside the walls: a gap in them, an open face, or a wall thinner than a support "
             "radius; domain.leaving: remove takes such particles out");
  return true;
}

/* Steps in which gravity alone crosses a support radius press particles together, too. */
static bool by_overlap(const failure *f, char *text, size_t size) {
  const double fall = 0.25 * sqrt(f->simulation->control.settings->support_radius / f->before->force_max);
  if (f->simulation->step >= RECENT || !(f->victim.nearest < 0.5) || f->dt > fall) return false;
  snprintf(text, size,
           "its nearest neighbour is %.3g spacings away, this early: blocks overlap each other or a wall",
           f->victim.nearest);
  return true;
}

static bool by_viscosity(const failure *f, char *text, size_t size) {
  const hc_step_settings *settings = f->simulation->control.settings;
  const double bound = hc_time_step_viscous_bound(settings);
  const bool floored =
      f->fault.kind == HC_FAULT_TIME_STEP && f->simulation->control.bound == HC_BOUND_VISCOUS;
  if (!floored && f->dt <= bound * (1.0 + 1e-9)) return false;
  snprintf(text, size,
           floored ? "the viscosity allows %.3g s and no more: lower time_step.min (%.3g s), the viscosity "
                     "or the resolution"
                   : "the viscosity allows time steps of %.3g s, not of %.3g s: lower time_step.size",
           bound, floored ? hc_time_step_floor(settings) : f->dt);
  return true;
}

/* Judged by the speed before the failure, or of the start, which the failure cannot have made. */
static bool by_step(const failure *f, char *text, size_t size) {
  const hc_control *control = &f->simulation->control;
  const double speed = f->fault.kind == HC_FAULT_START_SPEED ? f->fault.value : f->before->v_max;
  const double usual = hc_control_usual(control, speed);
  if (f->fault.kind == HC_FAULT_TIME_STEP || !(f->dt > 1.5 * usual)) return false;
  snprintf(text, size,
           "the time step is too long: a speed of %.3g m/s allows %.3g s (%.3g spacings), not %.3g s; lower "
           "time_step.%s",
           speed, usual, usual * speed / control->settings->spacing, f->dt, control->ops->speed_key);
  return true;
}

static bool by_cap(const failure *f, char *text, size_t size) {
  const hc_simulation *simulation = f->simulation;
  const hc_control_ops *control = simulation->control.ops;
  const char *steadier = simulation->solver->steadier;
  const int64_t failed = simulation->step + 1;
  const int64_t capped = simulation->report.density_capped ? failed : simulation->capped_at;
  if (capped == 0 || failed - capped >= RECENT) return false;
  char advice[128] = "";
  if (steadier && strcmp(steadier, control->name) != 0)
    snprintf(advice, sizeof advice, ", or have steps that follow the forces (time_step.control: %s)",
             steadier);
  snprintf(text, size,
           "the density solver was at its cap of %d iterations in step %lld: the pressure did not converge; "
           "lower the time step (time_step.%s) or raise solver.density_iterations.max%s",
           simulation->scene->solver.density_iterations.max, (long long)capped, control->longest_key, advice);
  return true;
}

static bool by_own_step(const failure *f, char *text, size_t size) {
  if (f->fault.kind != HC_FAULT_OWN_STEP) return false;
  snprintf(text, size, "its speed or its acceleration, of an impact perhaps: lower time_step.min");
  return true;
}

static bool by_scene(const failure *f, char *text, size_t size) {
  if (f->fault.kind != HC_FAULT_TIME_STEP || f->simulation->step > 0) return false;
  snprintf(text, size, "the scene itself: its %s asks for a step under the floor, %.3g s; see time_step.min",
           f->simulation->control.bound == HC_BOUND_VELOCITY ? "speed" : "gravity",
           hc_time_step_floor(f->simulation->control.settings));
  return true;
}

static void find_cause(const failure *failure, char *text, size_t size) {
  static rule *const rules[] = {by_hook,      by_own_step, by_shock, by_error, by_overlap,
                                by_viscosity, by_scene,    by_step,  by_gap,   by_cap};
  for (size_t k = 0; k < sizeof rules / sizeof *rules; k++)
    if (rules[k](failure, text, size)) return;
  snprintf(text, size,
           "none of the usual ones (time step, solver at its cap, overlaps, gaps): look at the particle and "
           "its neighbours in the snapshots");
}

/* ---- the message ---- */

static void describe_victim(const failure *f, char *text, size_t size) {
  const victim *v = &f->victim;
  if (v->fluid_neighbors < 0) return;
  snprintf(text, size,
           "\n  particle %s: at (%.6g, %.6g, %.6g) m, speed %.4g m/s, density error %.3g %%, %d "
           "neighbours and %d of walls",
           hc_simulation_particle_name(f->simulation->scene, f->fault.id).text, v->at[0], v->at[1], v->at[2],
           fabs(v->speed), 100.0 * v->density_error, v->fluid_neighbors, v->wall_neighbors);
}

void hc_failure_explain(hc_simulation *simulation, double dt, const hc_step_report *before, hc_error *error) {
  const hc_fault fault = simulation->report.fault;
  if (fault.kind == HC_FAULT_NONE) { /* no particle's: the error says it all */
    const hc_error found = *error;
    hc_error_set(error, HC_FAILED, "the simulation failed in step %lld at %.6g s: %.4000s",
                 (long long)simulation->step + 1, simulation->time, found.text);
    return;
  }
  const failure failure = {simulation, before, fault, dt, find_victim(simulation, fault.id)};
  char what[256], cause[512], particle[512] = "";
  snprintf(what, sizeof what, "%.*s", (int)sizeof what - 1, error->text);
  find_cause(&failure, cause, sizeof cause);
  describe_victim(&failure, particle, sizeof particle);
  hc_error_set(error, HC_FAILED,
               "the simulation %s in step %lld at %.6g s: %s%s\n  time step %.4g s, bounded by: %s\n  likely "
               "cause: %s",
               fault.kind == HC_FAULT_LEFT ? "failed" : "diverged", (long long)simulation->step + 1,
               simulation->time, what, particle, dt, hc_step_bound_name(simulation->control.bound), cause);
}

/* ---- faults on demand ---- */

/* The first particle by id at or behind the middle of all ids. Collective. */
static uint64_t middle_particle(hc_simulation *simulation) {
  const hc_particles *fluid = simulation->world.fluid;
  int64_t ends[2] = {INT64_MIN, INT64_MIN}, middle = INT64_MAX; /* -smallest, largest */
  for (int32_t k = 0; k < fluid->own; k++) {
    const int64_t id = (int64_t)fluid->id[k];
    if (-id > ends[0]) ends[0] = -id;
    if (id > ends[1]) ends[1] = id;
  }
  hc_comm_max_i64(simulation->comm, ends, 2);
  for (int32_t k = 0; k < fluid->own; k++) {
    const int64_t id = (int64_t)fluid->id[k];
    if (id >= (ends[1] - ends[0]) / 2 && id < middle) middle = id;
  }
  hc_comm_min_i64(simulation->comm, &middle, 1);
  return (uint64_t)middle;
}

void hc_failure_inject(hc_simulation *simulation) {
  const hc_scene *scene = simulation->scene;
  const bool nan = scene->faults.nan_at == simulation->step, kick = scene->faults.kick_at == simulation->step;
  if (simulation->step == 0 || (!nan && !kick)) return;
  const uint64_t id = middle_particle(simulation);
  hc_particles *fluid = simulation->world.fluid;
  for (int32_t k = 0; k < fluid->own; k++)
    if (fluid->id[k] == id) fluid->velocity[3 * (size_t)k] = nan ? NAN : 1e5;
}
