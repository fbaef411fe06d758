#include "individual.h"

#include "wall_layer.h"

#include "base/memory.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double TICKS = 0x1p20; /* of a block */

/* Of hc_particles.schedule. */
enum { LAST, DUE, RAW, SCHEDULE }; /* ticks */

/* A block under way. */
typedef struct block {
  hc_world *world;
  const hc_weak_settings *settings;
  const hc_individual_settings *individual;
  double unit;               /* s: of a tick */
  double longest;            /* s: no step of a particle is longer */
  double now, next;          /* ticks: of this sub-step and of the one behind it */
  double walls_shown;        /* ticks: where walls that move are shown */
  double walls_fastest;      /* m/s: of them; of this rank's until it is reduced */
  double fastest, strongest; /* m/s, m/s2: largest of all particles */
  double speed;              /* m/s: no particle goes on faster */
  double used;               /* m: by which particles may have moved since they were listed */
  hc_selection active;       /* in this sub-step, and the same as bits */
  const uint64_t *chosen;
  int64_t evaluated; /* active particles so far, but those of the first sub-step */
  int substeps;
  hc_step_report *report;
} block;

static float *schedule_of(const block *b, int32_t i) {
  return &b->world->fluid->schedule[SCHEDULE * (size_t)i];
}

/* Seconds since a particle was active. */
static double age(const block *b, int32_t i) {
  return (b->now - (double)schedule_of(b, i)[LAST]) * b->unit;
}

/* ---- how particles go on: lines 8, 9 and 18 to 21 ---- */

static float relative_density(const block *b, int32_t i, double t) {
  return b->world->fluid->last_density[i] + (float)t * b->world->fluid->density_rate[i];
}

/* Velocity and way since it was active, units. */
static void go_on(const block *b, int32_t i, double t, double velocity[3], int64_t way[3]) {
  const hc_particles *const fluid = b->world->fluid;
  const double *const unit = b->world->frame.unit;
  for (int axis = 0; axis < 3; axis++) {
    velocity[axis] = fluid->velocity[3 * (size_t)i + (size_t)axis] +
                     t * (double)fluid->force[3 * (size_t)i + (size_t)axis];
    way[axis] = llrint(t * velocity[axis] / unit[axis]);
  }
}

/* Room for all own particles to be chosen; none is. */
static void clear_chosen(block *b) {
  const int32_t own = b->world->fluid->own;
  hc_chosen *const chosen = &b->world->chosen;
  const size_t words = (size_t)own / 64 + 1;
  hc_reserve((void **)&chosen->index, &chosen->index_room, (size_t)own + 1, 0, sizeof *chosen->index);
  hc_reserve((void **)&chosen->bits, &chosen->bits_room, words, 0, sizeof *chosen->bits);
  memset(chosen->bits, 0, words * sizeof *chosen->bits);
  b->chosen = chosen->bits;
}

static void choose(const block *b, int32_t i, int32_t *count) {
  b->world->chosen.index[(*count)++] = i;
  b->world->chosen.bits[i / 64] |= (uint64_t)1 << (i % 64);
}

/* Shows all own particles to the sweeps as they are now; those that are due become active, and go on from
 * here. */
static void drift(block *b) {
  hc_particles *const fluid = b->world->fluid;
  double v2_max = 0.0, a2_max = 0.0;
  int32_t count = 0;
  clear_chosen(b);
  for (int32_t i = 0; i < fluid->own; i++) {
    float *const schedule = schedule_of(b, i);
    const double t = age(b, i);
    const bool due = (double)schedule[DUE] <= b->now;
    hc_record *const place = &fluid->place[i], *const motion = &fluid->motion[i];
    double velocity[3], v2 = 0.0, a2 = 0.0;
    int64_t way[3];
    go_on(b, i, t, velocity, way);
    for (int axis = 0; axis < 3; axis++) {
      const size_t at = 3 * (size_t)i + (size_t)axis;
      const double a = (double)fluid->force[at];
      const int64_t position = fluid->position[at] + way[axis];
      place->x[axis] = (int32_t)(uint32_t)(uint64_t)position;
      motion->v[axis] = (float)velocity[axis];
      v2 += velocity[axis] * velocity[axis];
      a2 += a * a;
      if (!due) continue;
      fluid->position[at] = position;
      fluid->velocity[at] = velocity[axis];
    }
    motion->scalar = schedule[RAW];
    if (v2 > v2_max) v2_max = v2;
    if (a2 > a2_max) a2_max = a2;
    if (due) {
      schedule[LAST] = (float)b->now;
      choose(b, i, &count);
    } else {
      const float relative = relative_density(b, i, t);
      place->scalar = hc_tait_push(hc_tait_pressure(&b->settings->tait, relative), relative);
    }
  }
  b->active = (hc_selection){b->world->chosen.index, 0, count, true};
  b->fastest = sqrt(v2_max);
  b->strongest = sqrt(a2_max);
}

/* Shows walls that move where they are now, as they would go on from the block's beginning. */
static void drift_walls(block *b) {
  hc_particles *const walls = b->world->moving;
  const double before = b->walls_shown * b->unit, now = b->now * b->unit;
  for (int32_t k = 0; k < walls->own + walls->ghosts; k++)
    for (int axis = 0; axis < 3; axis++) {
      const double speed = (double)walls->motion[k].v[axis] / b->world->frame.unit[axis];
      const int64_t change = llrint(now * speed) - llrint(before * speed);
      walls->place[k].x[axis] = (int32_t)((uint32_t)walls->place[k].x[axis] + (uint32_t)(uint64_t)change);
    }
  b->walls_shown = b->now;
}

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

/* Densities and pressures of all own particles as they are now. */
static void fill_pressures(const block *b) {
  hc_particles *const fluid = b->world->fluid;
  const float rest = (float)b->settings->common.rest_density;
  for (int32_t i = 0; i < fluid->own; i++) {
    const float relative = relative_density(b, i, age(b, i));
    fluid->density[i] = rest * relative;
    fluid->pressure[i] = rest * hc_tait_pressure(&b->settings->tait, relative);
  }
}

/* Positions become those of now, `to` 1, or again what they were, -1: both exactly. */
static void shift(const block *b, int to) {
  hc_particles *const fluid = b->world->fluid;
  for (int32_t i = 0; i < fluid->own; i++) {
    double velocity[3];
    int64_t way[3];
    go_on(b, i, age(b, i), velocity, way);
    for (int axis = 0; axis < 3; axis++) {
      int64_t *const position = &fluid->position[3 * (size_t)i + (size_t)axis];
      *position += to * way[axis];
      if (to > 0) *position = hc_frame_wrap(&b->world->frame, axis, *position);
    }
  }
}

/* ---- cells and lists ---- */

/* How fast a particle may go on: one that was active t s ago moves by dt (v + t a), and its own step bounds t
 * a. */
static double speed_bound(const hc_individual_settings *individual, double h, double fastest,
                          double strongest) {
  return fastest + individual->force * sqrt(h * strongest);
}

double hc_individual_reach(const hc_weak_settings *settings, const hc_individual_settings *individual,
                           double speed, double force, double dt) {
  static const double BOTH = 2.0, SPARE = 1.1; /* it becomes faster */
  return BOTH * SPARE * dt * speed_bound(individual, settings->support_radius, speed, force);
}

static void place_anew(block *b) {
  hc_world *const world = b->world;
  shift(b, 1);
  int64_t outside = hc_domain_watch_partners(&world->domain);
  hc_comm_max_i64(world->comm, &outside, 1);
  hc_domain_agree_partners(&world->domain, outside != 0);
  hc_world_place(world);
  shift(b, -1);
  drift(b);
  hc_world_reach(world,
                 hc_individual_reach(b->settings, b->individual, b->speed, 0.0, (TICKS - b->now) * b->unit));
  hc_world_list(world, NULL);
  hc_wall_layer_list(world, b->settings->common.depth_pressure);
  world->holds.count = 0;
  b->used =
      b->walls_fastest * b->now * b->unit; /* of walls, which are in the cells of the block's beginning */
}

/* ---- what active particles find ---- */

/* Lines 3 to 11 of active particles; ghosts are brought up to date before. */
static void evaluate(block *b) {
  hc_world *const world = b->world;
  hc_error_total unused;
  memset(&unused, 0, sizeof unused);
  hc_stopwatch_enter(&world->watch, HC_STAGE_DENSITY);
  hc_halo_refresh(world->halo, HC_WHOLE(place) | HC_WHOLE(motion));
  hc_weak_pressures(world, b->settings, b->active, b->chosen, &unused);
  hc_stopwatch_enter(&world->watch, HC_STAGE_FORCES);
  const double strongest = hc_weak_accelerations(world, b->settings, world->fluid->density_rate, b->active);
  if (strongest > b->strongest) b->strongest = strongest;
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

/* A raw step in ticks. */
static float raw_step(const block *b, int32_t i, hc_fault *fault) {
  const hc_particles *const fluid = b->world->fluid;
  const double h = b->world->frame.support_radius, *const v = &fluid->velocity[3 * (size_t)i];
  const float *const a = &fluid->force[3 * (size_t)i];
  const double speed = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  const double force =
      sqrt((double)a[0] * (double)a[0] + (double)a[1] * (double)a[1] + (double)a[2] * (double)a[2]);
  double step = b->longest;
  if (!(speed < INFINITY && force < INFINITY)) { /* no number, too */
    hc_fault_note(fault, HC_FAULT_VALUE, 0.0, fluid->id[i]);
    return (float)TICKS;
  }
  if (step * speed > b->individual->velocity * h) step = b->individual->velocity * h / speed;
  const double by_force =
      b->individual->force * b->individual->force * h; /* over the force: a step's square */
  if (step * step * force > by_force) step = sqrt(by_force / force);
  if (step < b->individual->shortest) {
    hc_fault_note(fault, HC_FAULT_OWN_STEP, 1.0 / step, fluid->id[i]);
    step = b->individual->shortest;
  }
  const double ticks = step / b->unit;
  if (!(ticks < TICKS)) return (float)TICKS;
  if (ticks < 1.0) return 1.0f;
  return (float)(b->individual->raw ? floor(ticks) : power_below(ticks));
}

/* When a step of so many ticks is over that begins at `from`, or, in powers of two, whose rhythm is taken up.
 */
static float end_of(const block *b, double from, double step) {
  const double end = b->individual->raw ? from + step : (floor(b->now / step) + 1.0) * step;
  return (float)(end < TICKS ? end : TICKS);
}

/* Active particles take over what was found, and their raw steps. */
static void take_over(const block *b, hc_selection selection) {
  hc_particles *const fluid = b->world->fluid;
  const float *const acceleration = hc_weak_accelerations_of(b->world);
  const float per_density = (float)(1.0 / b->settings->common.rest_density);
  for (int32_t row = selection.begin; row < selection.end; row++) {
    const int32_t i = hc_selected(selection, row);
    memcpy(&fluid->force[3 * (size_t)i], &acceleration[3 * (size_t)i], 3 * sizeof *acceleration);
    fluid->last_density[i] = per_density * fluid->density[i];
    fluid->motion[i].scalar = schedule_of(b, i)[RAW] = raw_step(b, i, &b->report->fault);
    fluid->time_step[i] += 1.0f; /* counts them until the block's end */
  }
}

/* Shortens the steps of particles next to those with shorter raw ones, and finds the next sub-step. */
static void spread_steps(block *b) {
  hc_world *const world = b->world;
  hc_particles *const fluid = world->fluid;
  hc_chosen *const chosen = &world->chosen;
  const size_t all = (size_t)fluid->own + (size_t)fluid->ghosts;
  hc_reserve((void **)&chosen->asked, &chosen->asked_room, all + 1, 0, sizeof *chosen->asked);
  for (size_t k = 0; k < all; k++) chosen->asked[k] = FLT_MAX;
  world->sweeps->least_scalar(&world->sweep, chosen->asked, b->active);
  /* now asked of active particles is line 16; of others what those next to them ask for */
  for (int32_t row = b->active.begin; row < b->active.end; row++) {
    const int32_t i = b->active.index[row];
    schedule_of(b, i)[DUE] = end_of(b, b->now, (double)chosen->asked[i]);
  }
  hc_halo_fold_least(world->halo, HC_TYPE_f32, 1, chosen->asked);
  double soonest = TICKS;
  for (int32_t i = 0; i < fluid->own; i++) {
    float *const schedule = schedule_of(b, i);
    if (chosen->asked[i] < FLT_MAX && (double)schedule[LAST] < b->now) {
      const float end = end_of(b, (double)schedule[LAST], (double)chosen->asked[i]);
      if (end < schedule[DUE]) schedule[DUE] = end;
    }
    const double next =
        b->individual->raw ? b->now + (double)(schedule[DUE] - schedule[LAST]) : (double)schedule[DUE];
    if (next < soonest) soonest = next;
  }
  b->next = soonest;
}

/* Contact with walls over each one's own step: what it changes velocities by becomes part of the forces. */
static void hold(block *b) {
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
    const float *const schedule = schedule_of(b, i);
    chosen->asked[i] = (float)((double)(schedule[DUE] - schedule[LAST]) * b->unit);
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
static void plan(block *b) {
  hc_world *const world = b->world;
  hc_stopwatch_enter(&world->watch, HC_STAGE_STEPS);
  take_over(b, hc_select_border(b->active, world->fluid));
  hc_halo_begin_some(world->halo, HC_SCALAR(motion), b->chosen);
  take_over(b, hc_select_interior(b->active, world->fluid));
  hc_halo_end_some(world->halo, NULL);
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

static void start(block *b) {
  hc_particles *const fluid = b->world->fluid;
  for (int32_t i = 0; i < fluid->own; i++) {
    float *const schedule = schedule_of(b, i);
    schedule[LAST] = schedule[DUE] = 0.0f;
    schedule[RAW] = (float)TICKS;
    fluid->time_step[i] = 0.0f;
  }
  b->walls_fastest = fastest_wall(b->world->moving);
  b->world->holds.count = 0;
  int32_t count = 0;
  clear_chosen(b);
  for (int32_t i = 0; i < fluid->own; i++) choose(b, i, &count);
  b->active = (hc_selection){b->world->chosen.index, 0, count, true};
  b->evaluated = count;
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
static void finish(block *b) {
  hc_particles *const fluid = b->world->fluid;
  fill_pressures(b);
  drift(b);
  drift_walls(b);
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
  hc_wall_layer_shorten(b->world, TICKS * b->unit / b->settings->longest);
}

hc_status hc_individual_advance(hc_world *world, const hc_weak_settings *settings,
                                const hc_individual_settings *individual, double dt, hc_step_report *report,
                                hc_error *error) {
  block b = {.world = world,
             .settings = settings,
             .individual = individual,
             .unit = dt / TICKS,
             .longest = fmin(dt, settings->longest),
             .fastest = report->v_max,
             .strongest = report->force_max,
             .report = report};
  start(&b);
  for (;;) {
    plan(&b);
    b.now = b.next;
    if (!(b.now < TICKS)) break;
    hc_stopwatch_enter(&world->watch, HC_STAGE_STEPS);
    if (!individual->lasting || b.used > 0.5 * world->margin)
      place_anew(&b);
    else
      drift(&b);
    drift_walls(&b);
    evaluate(&b);
  }
  hc_stopwatch_enter(&world->watch, HC_STAGE_MOVE);
  finish(&b);
  report->substeps = b.substeps;
  report->evaluated = b.evaluated;
  return hc_move(world, &settings->common, dt, HC_MOVE_TO_PLACE, false, report, error);
}
