#include "individual.h"

#include "wall_layer.h"

#include "base/memory.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double TICKS = 0x1p20; /* of a block */

static double fastest_wall(const hc_particles *walls) {
  double largest = 0.0;
  for (int32_t k = 0; k < walls->own; k++) {
    const float *const v = walls->motion[k].v;
    const double square =
        (double)v[0] * (double)v[0] + (double)v[1] * (double)v[1] + (double)v[2] * (double)v[2];
    if (square > largest) largest = square;
  }
  return sqrt(largest);
}

/* ---- cells and lists ---- */

/* How fast a particle may go on: one that was active t s ago moves by dt (v + t a), and its own step bounds t
 * a. */
static double speed_bound(const hc_individual_settings *individual, double h, double fastest,
                          double strongest) {
  return fastest + individual->force * sqrt(h * strongest);
}

static double reach_for(const hc_weak_settings *settings, const hc_individual_settings *individual,
                        double speed, double force, double dt) {
  static const double BOTH = 2.0, SPARE = 1.1; /* it becomes faster */
  return BOTH * SPARE * dt * speed_bound(individual, settings->support_radius, speed, force);
}

/* In a block of one longest step few are active but at its beginning, if steps are powers of two. */
static bool is_exact(const hc_weak_settings *settings, const hc_individual_settings *individual, double dt) {
  return individual->lasting && !individual->raw && dt < 1.5 * settings->longest;
}

double hc_individual_reach(const hc_weak_settings *settings, const hc_individual_settings *individual,
                           double speed, double force, double dt) {
  return is_exact(settings, individual, dt) ? 0.0 : reach_for(settings, individual, speed, force, dt);
}

static void place_anew(hc_individual_block *b) {
  hc_world *const world = b->world;
  hc_block_shift(b, 1);
  int64_t outside = hc_domain_watch_partners(&world->domain);
  hc_comm_max_i64(world->comm, &outside, 1);
  hc_domain_agree_partners(&world->domain, outside != 0);
  hc_world_place(world);
  hc_block_shift(b, -1);
  hc_block_activate(b);
  hc_block_touch(b, true);
  hc_block_show_own(b);
  hc_world_reach(world,
                 b->exact ? 0.0
                          : reach_for(b->settings, b->individual, b->speed, 0.0, (TICKS - b->now) * b->unit));
  hc_world_list(world, NULL);
  hc_wall_layer_list(world, b->settings->common.depth_pressure);
  b->ghosts_new = true;
  hc_block_tell_ghosts(b);
  hc_block_show_ghosts(b);
  if (b->exact) hc_world_remember_places(world);
  world->holds.count = 0;
  b->relisted = true;
  b->used =
      b->walls_fastest * b->now * b->unit; /* of walls, which are in the cells of the block's beginning */
}

/* ---- a sub-step: what active particles find ---- */

/* Goes on to the next sub-step: who is active then, and all that they look at. Collective. */
static void begin_substep(hc_individual_block *b) {
  const double margin = b->exact ? b->world->frame.margin : b->world->margin;
  const bool anew = !b->individual->lasting || b->used > 0.5 * margin;
  hc_stopwatch_enter(&b->world->watch, HC_STAGE_STEPS);
  if (!anew) hc_block_tell_ghosts(b);
  b->now = b->next;
  if (anew) {
    place_anew(b);
  } else {
    hc_block_activate(b);
    if (b->exact) hc_world_list_some(b->world, b->active);
    hc_block_touch(b, false);
    hc_block_show_own(b);
    hc_block_show_ghosts(b);
  }
  hc_block_show_walls(b);
}

/* Lines 3 to 11 of active particles. Collective. */
static void evaluate(hc_individual_block *b) {
  hc_world *const world = b->world;
  hc_chosen *const chosen = &world->chosen;
  hc_error_total unused;
  memset(&unused, 0, sizeof unused);
  hc_stopwatch_enter(&world->watch, HC_STAGE_DENSITY);
  hc_weak_pressures(world, b->settings, b->active, chosen->bits, chosen->ghosts, &unused);
  hc_block_activate_ghosts(b);
  hc_stopwatch_enter(&world->watch, HC_STAGE_FORCES);
  const double strongest = hc_weak_accelerations(world, b->settings, world->fluid->density_rate, b->active);
  b->strongest = fmax(b->strongest, strongest);
  b->evaluated += b->active.end - b->active.begin;
}

/* ---- how long their steps are: lines 12 and 16 ---- */

/* The power of two that is no more than that. */
static double power_below(double ticks) {
  uint64_t bits;
  memcpy(&bits, &ticks, sizeof bits);
  bits &= 0xfff0000000000000u;
  memcpy(&ticks, &bits, sizeof ticks);
  return ticks;
}

static double square(double x) {
  return x * x;
}

/* A step in ticks. */
static float raw_ticks(const hc_individual_block *b, double step) {
  const double ticks = step / b->unit;
  if (!(ticks < TICKS)) return (float)TICKS;
  if (ticks < 1.0) return 1.0f;
  return (float)(b->individual->raw ? floor(ticks) : power_below(ticks));
}

/* A raw step in ticks, of a particle that the longest is not short enough for. */
static float short_step(const hc_individual_block *b, int32_t i, double v2, double a2, hc_fault *fault) {
  const double h = b->world->frame.support_radius, speed = sqrt(v2), force = sqrt(a2);
  double step = b->longest;
  if (!(speed < INFINITY && force < INFINITY)) { /* no number, too */
    hc_fault_note(fault, HC_FAULT_VALUE, 0.0, b->world->fluid->id[i]);
    return b->most;
  }
  if (step * speed > b->individual->velocity * h) step = b->individual->velocity * h / speed;
  const double by_force =
      b->individual->force * b->individual->force * h; /* over the force: a step's square */
  if (step * step * force > by_force) step = sqrt(by_force / force);
  if (step < b->individual->shortest) {
    hc_fault_note(fault, HC_FAULT_OWN_STEP, 1.0 / step, b->world->fluid->id[i]);
    step = b->individual->shortest;
  }
  return raw_ticks(b, step);
}

static float raw_step(const hc_individual_block *b, int32_t i, hc_fault *fault) {
  const hc_particles *const fluid = b->world->fluid;
  const double *const v = &fluid->velocity[3 * (size_t)i];
  const float *const a = &fluid->force[3 * (size_t)i];
  const double v2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2],
               a2 = (double)a[0] * (double)a[0] + (double)a[1] * (double)a[1] + (double)a[2] * (double)a[2];
  return v2 <= b->calm_v2 && a2 <= b->calm_a2 ? b->most : short_step(b, i, v2, a2, fault);
}

/* When a step of so many ticks is over that begins at `from`, or, in powers of two, whose rhythm is taken up.
 */
static float end_of(const hc_individual_block *b, double from, float step) {
  const int32_t ticks = (int32_t)step;
  const double end = b->individual->raw ? from + (double)step : (double)(((int32_t)b->now & -ticks) + ticks);
  return (float)(end < TICKS ? end : TICKS);
}

/* Active particles take over what was found, and their raw steps. */
static void take_over(const hc_individual_block *b) {
  hc_particles *const fluid = b->world->fluid;
  const float *const acceleration = hc_weak_accelerations_of(b->world);
  const float per_density = (float)(1.0 / b->settings->common.rest_density);
  for (int32_t row = b->active.begin; row < b->active.end; row++) {
    const int32_t i = b->active.index[row];
    memcpy(&fluid->force[3 * (size_t)i], &acceleration[3 * (size_t)i], 3 * sizeof *acceleration);
    fluid->last_density[i] = per_density * fluid->density[i];
    hc_block_schedule(b, i)[HC_RAW] = raw_step(b, i, &b->report->fault);
    fluid->time_step[i] += 1.0f; /* counts them until the block's end */
  }
}

/* An active particle asks those next to it not to have longer steps than its raw one, and is asked by those
 * of them that are not active, if there are such `others`. */
static void ask(const hc_individual_block *b, int32_t i, bool others) {
  const hc_neighbors *const list = b->world->sweep.list;
  float *const asked = b->world->chosen.asked;
  const float raw = hc_block_schedule(b, i)[HC_RAW];
  const bool shorter = raw < b->most;
  if (!shorter && !others) return;
  const uint32_t *const neighbors = hc_list_row(list, i);
  const int32_t count = hc_list_count(list, i);
  for (int32_t k = 0; k < count; k++) {
    const int32_t j = (int32_t)(neighbors[k] / sizeof(hc_record));
    if (shorter && raw < asked[j]) asked[j] = raw;
    if (others && !hc_block_is_active(b, j)) asked[i] = fminf(asked[i], hc_block_schedule(b, j)[HC_RAW]);
  }
}

/* Line 16: an active particle's step is no longer than what it is asked for; another one is woken in time. */
static void heed(const hc_individual_block *b, int32_t i) {
  float *const schedule = hc_block_schedule(b, i);
  const float asked = b->world->chosen.asked[i];
  const bool active = (double)schedule[HC_LAST] == b->now;
  if (!active && asked == FLT_MAX) return;
  const float end = end_of(b, (double)schedule[HC_LAST], active ? fminf(schedule[HC_RAW], asked) : asked);
  if (active || end < schedule[HC_DUE]) schedule[HC_DUE] = end;
}

/* The next sub-step, as far as own particles say: when the first is due, or, in raw steps, when the shortest
 * of all steps is over. */
static double next_of_own(const hc_individual_block *b) {
  const bool raw = b->individual->raw;
  float soonest = (float)TICKS;
  for (int32_t i = 0; i < b->world->fluid->own; i++) {
    const float *const schedule = hc_block_schedule(b, i);
    const float next = raw ? schedule[HC_DUE] - schedule[HC_LAST] : schedule[HC_DUE];
    soonest = next < soonest ? next : soonest;
  }
  return fmin(raw ? b->now + (double)soonest : (double)soonest, TICKS);
}

/* Gives active particles their steps and shortens those of others next to them. Collective among partners. */
static void spread_steps(hc_individual_block *b) {
  hc_world *const world = b->world;
  const int32_t own = world->fluid->own, records = own + world->fluid->ghosts;
  hc_chosen *const chosen = &world->chosen;
  hc_reserve((void **)&chosen->asked, &chosen->asked_room, (size_t)records + 1, 0, sizeof *chosen->asked);
  HC_FOR_TOUCHED(b, i, 0, records) chosen->asked[i] = FLT_MAX;
  for (int32_t row = b->active.begin; row < b->active.end; row++)
    ask(b, b->active.index[row], b->substeps > 0);
  hc_halo_fold_least(world->halo, HC_TYPE_f32, 1, chosen->asked, chosen->touched);
  HC_FOR_TOUCHED(b, i, 0, own) heed(b, i);
  b->next = next_of_own(b);
}

/* Contact with walls over each one's own step: what it changes velocities by becomes part of the forces. */
static void hold(hc_individual_block *b) {
  hc_world *const world = b->world;
  hc_particles *const fluid = world->fluid;
  hc_chosen *const chosen = &world->chosen;
  if (!world->boundary_ops->contact || !(world->contact_limit > 0.0)) return;
  hc_reserve((void **)&chosen->before, &chosen->before_room, 3 * (size_t)b->active.end + 1, 0,
             sizeof *chosen->before);
  for (int32_t row = b->active.begin; row < b->active.end; row++) {
    const int32_t i = b->active.index[row];
    if (fluid->wall_density[i] == 0.0f) continue;
    double *const velocity = &fluid->velocity[3 * (size_t)i];
    const float *const schedule = hc_block_schedule(b, i);
    chosen->asked[i] = (float)((double)(schedule[HC_DUE] - schedule[HC_LAST]) * b->unit);
    memcpy(&chosen->before[3 * (size_t)row], velocity, 3 * sizeof *velocity);
    for (int axis = 0; axis < 3; axis++)
      velocity[axis] += (double)chosen->asked[i] * (double)fluid->force[3 * (size_t)i + (size_t)axis];
  }
  b->report->contacts +=
      world->boundary_ops->contact(&world->sweep, b->active, world->contact_limit, 1.0, chosen->asked);
  for (int32_t row = b->active.begin; row < b->active.end; row++) {
    const int32_t i = b->active.index[row];
    if (fluid->wall_density[i] == 0.0f) continue;
    double *const velocity = &fluid->velocity[3 * (size_t)i];
    for (int axis = 0; axis < 3; axis++) {
      const double before = chosen->before[3 * (size_t)row + (size_t)axis];
      fluid->force[3 * (size_t)i + (size_t)axis] =
          (float)((velocity[axis] - before) / (double)chosen->asked[i]);
      velocity[axis] = before;
      fluid->motion[i].v[axis] = (float)before;
    }
  }
}

/* ---- the block ---- */

/* What was found of active particles: lines 12 to 17. Collective. */
static void plan(hc_individual_block *b) {
  hc_world *const world = b->world;
  hc_stopwatch_enter(&world->watch, HC_STAGE_STEPS);
  take_over(b);
  spread_steps(b);
  hold(b);
  int64_t broken = b->report->fault.kind != HC_FAULT_NONE;
  double most[4] = {-b->next, b->fastest, b->strongest, b->walls_fastest};
  hc_tally tally = {.count = 0};
  hc_tally_max_i64(&tally, &broken, 1);
  hc_tally_max_f64(&tally, most, 4);
  hc_tally_reduce(world->comm, &tally);
  b->next = broken ? TICKS : -most[0];
  b->walls_fastest = most[3];
  b->substeps++;
  b->speed = speed_bound(b->individual, world->frame.support_radius, most[1], most[2]) + most[3];
  b->used += (b->next - b->now) * b->unit * b->speed;
}

static void start(hc_individual_block *b) {
  hc_particles *const fluid = b->world->fluid;
  for (int32_t i = 0; i < fluid->own; i++) {
    float *const schedule = hc_block_schedule(b, i);
    schedule[HC_LAST] = schedule[HC_DUE] = 0.0f;
    schedule[HC_RAW] = (float)TICKS;
    fluid->time_step[i] = 0.0f;
  }
  b->walls_fastest = fastest_wall(b->world->moving);
  b->world->holds.count = 0;
  hc_block_activate_all(b);
  b->ghosts_new = true;
  b->evaluated = b->active.end;
  if (b->exact) hc_world_remember_places(b->world);
}

static int by_particle(const void *a, const void *b) {
  const hc_hold *p = a, *q = b;
  if (p->particle != q->particle) return p->particle < q->particle ? -1 : 1;
  for (int axis = 0; axis < 3; axis++) /* the same sum on any number of ranks */
    if (p->change[axis] != q->change[axis]) return p->change[axis] < q->change[axis] ? -1 : 1;
  return 0;
}

/* What contact took in all sub-steps, once a particle. */
static void merge_holds(hc_holds *holds) {
  size_t kept = 0;
  if (holds->count == 0) return;
  qsort(holds->at, holds->count, sizeof *holds->at, by_particle);
  for (size_t k = 1; k < holds->count; k++) {
    if (holds->at[k].particle != holds->at[kept].particle) {
      holds->at[++kept] = holds->at[k];
      continue;
    }
    for (int axis = 0; axis < 3; axis++) holds->at[kept].change[axis] += holds->at[k].change[axis];
  }
  holds->count = kept + 1;
}

/* All particles as they are at the end: in place, and their velocities. What hc_move takes for the velocity
 * of the beginning makes their last forces their accelerations: that of the beginning is lost when they are
 * placed anew. */
static void finish(hc_individual_block *b) {
  hc_particles *const fluid = b->world->fluid;
  hc_world_show_all(b->world);
  hc_block_fill_pressures(b);
  hc_block_activate(b);
  hc_block_show_walls(b);
  b->world->stores[HC_STORE_MOVING].moved |=
      b->world->sweep.walls_move; /* the next placing puts them right */
  const double dt = TICKS * b->unit;
  for (int32_t i = 0; i < fluid->own; i++) {
    for (size_t axis = 3 * (size_t)i; axis < 3 * (size_t)i + 3; axis++)
      fluid->acceleration[axis] = (float)(fluid->velocity[axis] - dt * (double)fluid->force[axis]);
    fluid->time_step[i] = (float)dt / fluid->time_step[i];
  }
  b->world->block = dt;
  merge_holds(&b->world->holds);
  if (b->relisted) /* what walls do was only found of particles that were active since */
    hc_wall_layer_add(b->world, &b->settings->common, b->settings->longest,
                      hc_weak_accelerations_of(b->world), hc_select_all(fluid));
  hc_wall_layer_shorten(b->world, TICKS * b->unit / b->settings->longest);
}

hc_status hc_individual_advance(hc_world *world, const hc_weak_settings *settings,
                                const hc_individual_settings *individual, double dt, hc_step_report *report,
                                hc_error *error) {
  hc_individual_block b = {.world = world,
                           .settings = settings,
                           .individual = individual,
                           .unit = dt / TICKS,
                           .longest = fmin(dt, settings->longest),
                           .fastest = report->v_max,
                           .strongest = report->force_max,
                           .report = report};
  const double h = world->frame.support_radius;
  for (int axis = 0; axis < 3; axis++) b.per_metre[axis] = 1.0 / world->frame.unit[axis];
  b.exact = is_exact(settings, individual, dt);
  b.most = raw_ticks(&b, b.longest);
  b.calm_v2 = square(individual->velocity * h / b.longest);
  b.calm_a2 = square(square(individual->force / b.longest) * h);
  start(&b);
  for (plan(&b); b.next < TICKS; plan(&b)) {
    begin_substep(&b);
    evaluate(&b);
  }
  b.now = TICKS;
  hc_stopwatch_enter(&world->watch, HC_STAGE_MOVE);
  finish(&b);
  report->substeps = b.substeps;
  report->evaluated = b.evaluated;
  return hc_move(world, &settings->common, dt, HC_MOVE_TO_PLACE, false, report, error);
}
