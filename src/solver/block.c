#include "block.h"

#include "base/bits.h"
#include "base/memory.h"

#include <math.h>
#include <string.h>

/* Seconds since a particle was active. */
static double age(const hc_individual_block *b, int32_t i) {
  return (b->now - (double)hc_block_schedule(b, i)[HC_LAST]) * b->unit;
}

static float relative_density(const hc_individual_block *b, int32_t i, double t) {
  return b->world->fluid->last_density[i] + (float)t * b->world->fluid->density_rate[i];
}

/* Velocity and way since it was active, units. */
static void go_on(const hc_individual_block *b, int32_t i, double t, double velocity[3], int64_t way[3]) {
  const hc_particles *const fluid = b->world->fluid;
  for (int axis = 0; axis < 3; axis++) {
    velocity[axis] = fluid->velocity[3 * (size_t)i + (size_t)axis] +
                     t * (double)fluid->force[3 * (size_t)i + (size_t)axis];
    way[axis] = llrint(t * velocity[axis] * b->per_metre[axis]);
  }
}

/* ---- who is active, and who is looked at ---- */

static size_t words_of(int32_t count) {
  return (size_t)count / 64 + 1;
}

static void clear_chosen(hc_individual_block *b) {
  const int32_t own = b->world->fluid->own;
  hc_chosen *const chosen = &b->world->chosen;
  hc_reserve((void **)&chosen->index, &chosen->index_room, (size_t)own + 1, 0, sizeof *chosen->index);
  hc_reserve((void **)&chosen->bits, &chosen->bits_room, words_of(own), 0, sizeof *chosen->bits);
  hc_reserve((void **)&chosen->ghosts, &chosen->ghosts_room, words_of(b->world->fluid->ghosts), 0,
             sizeof *chosen->ghosts);
  memset(chosen->bits, 0, words_of(own) * sizeof *chosen->bits);
}

static void choose(const hc_individual_block *b, int32_t i, int32_t *count) {
  b->world->chosen.index[(*count)++] = i;
  hc_bits_add(b->world->chosen.bits, i);
}

bool hc_block_is_active(const hc_individual_block *b, int32_t i) {
  const int32_t own = b->world->fluid->own;
  return i < own ? hc_bits_have(b->world->chosen.bits, i) : hc_bits_have(b->world->chosen.ghosts, i - own);
}

/* Goes on to now, and from there; returns the square of the speed. */
static double arrive(const hc_individual_block *b, int32_t i) {
  hc_particles *const fluid = b->world->fluid;
  double velocity[3], square = 0.0;
  int64_t way[3];
  go_on(b, i, age(b, i), velocity, way);
  for (int axis = 0; axis < 3; axis++) {
    const size_t at = 3 * (size_t)i + (size_t)axis;
    fluid->position[at] += way[axis];
    fluid->velocity[at] = velocity[axis];
    square += velocity[axis] * velocity[axis];
  }
  hc_block_schedule(b, i)[HC_LAST] = (float)b->now;
  return square;
}

void hc_block_activate(hc_individual_block *b) {
  hc_particles *const fluid = b->world->fluid;
  double v2_max = 0.0;
  int32_t count = 0;
  clear_chosen(b);
  for (int32_t i = 0; i < fluid->own; i++) {
    if ((double)hc_block_schedule(b, i)[HC_DUE] > b->now) continue;
    const double v2 = arrive(b, i);
    if (v2 > v2_max) v2_max = v2;
    for (int axis = 0; axis < 3; axis++) {
      const size_t at = 3 * (size_t)i + (size_t)axis;
      fluid->place[i].x[axis] = (int32_t)(uint32_t)(uint64_t)fluid->position[at];
      fluid->motion[i].v[axis] = (float)fluid->velocity[at];
    }
    choose(b, i, &count);
  }
  b->active = (hc_selection){b->world->chosen.index, 0, count, true};
  b->fastest = fmax(b->fastest, sqrt(v2_max));
}

void hc_block_touch(hc_individual_block *b, bool all) {
  static const int32_t FEW = 8; /* to mark the neighbours of one costs about as much as to show four */
  const hc_world *const world = b->world;
  const int32_t records = world->fluid->own + world->fluid->ghosts;
  hc_chosen *const chosen = &b->world->chosen;
  const size_t bytes = words_of(records) * sizeof *chosen->touched;
  hc_reserve((void **)&chosen->touched, &chosen->touched_room, words_of(records), 0, sizeof *chosen->touched);
  all |= FEW * b->active.end > world->fluid->own;
  memset(chosen->touched, all ? 0xff : 0, bytes);
  for (int32_t i = 0; i < world->fluid->border && !all; i++) hc_bits_add(chosen->touched, i);
  for (int32_t row = b->active.begin; row < b->active.end && !all; row++) {
    const int32_t i = b->active.index[row], count = hc_list_count(world->sweep.list, i);
    const uint32_t *const neighbors = hc_list_row(world->sweep.list, i);
    hc_bits_add(chosen->touched, i);
    for (int32_t k = 0; k < count; k++)
      hc_bits_add(chosen->touched, (int32_t)(neighbors[k] / sizeof(hc_record)));
  }
}

void hc_block_activate_all(hc_individual_block *b) {
  int32_t count = 0;
  clear_chosen(b);
  for (int32_t i = 0; i < b->world->fluid->own; i++) choose(b, i, &count);
  b->active = (hc_selection){b->world->chosen.index, 0, count, true};
  memset(b->world->chosen.ghosts, 0xff, words_of(b->world->fluid->ghosts) * sizeof(uint64_t));
  hc_block_touch(b, true);
}

/* ---- what sweeps see ---- */

static void show(const hc_individual_block *b, int32_t i) {
  hc_particles *const fluid = b->world->fluid;
  hc_record *const place = &fluid->place[i], *const motion = &fluid->motion[i];
  const double t = age(b, i);
  const float relative = relative_density(b, i, t);
  double velocity[3];
  int64_t way[3];
  go_on(b, i, t, velocity, way);
  for (int axis = 0; axis < 3; axis++) {
    place->x[axis] = (int32_t)(uint32_t)(uint64_t)(fluid->position[3 * (size_t)i + (size_t)axis] + way[axis]);
    motion->v[axis] = (float)velocity[axis];
  }
  place->scalar = hc_tait_push(hc_tait_pressure(&b->settings->tait, relative), relative);
}

void hc_block_show_own(const hc_individual_block *b) {
  const int32_t own = b->world->fluid->own;
  HC_FOR_TOUCHED(b, i, 0, own) if (!hc_bits_have(b->world->chosen.bits, i)) show(b, i);
}

void hc_block_show_ghosts(const hc_individual_block *b) {
  const hc_particles *const fluid = b->world->fluid;
  HC_FOR_TOUCHED(b, i, fluid->own, fluid->own + fluid->ghosts) show(b, i);
}

void hc_block_show_walls(hc_individual_block *b) {
  hc_particles *const walls = b->world->moving;
  const double before = b->walls_shown * b->unit, now = b->now * b->unit;
  for (int32_t k = 0; k < walls->own + walls->ghosts; k++)
    for (int axis = 0; axis < 3; axis++) {
      const double speed = (double)walls->motion[k].v[axis] * b->per_metre[axis];
      const int64_t change = llrint(now * speed) - llrint(before * speed);
      walls->place[k].x[axis] = (int32_t)((uint32_t)walls->place[k].x[axis] + (uint32_t)(uint64_t)change);
    }
  b->walls_shown = b->now;
}

/* ---- ghosts ---- */

/* They are where they are shown: their low words are all of a position that is used. */
static void place_ghosts(const hc_individual_block *b) {
  hc_particles *const fluid = b->world->fluid;
  for (int32_t i = fluid->own; i < fluid->own + fluid->ghosts; i++) {
    double velocity[3];
    int64_t way[3];
    go_on(b, i, age(b, i), velocity, way);
    for (int axis = 0; axis < 3; axis++)
      fluid->position[3 * (size_t)i + (size_t)axis] = (int64_t)fluid->place[i].x[axis] - way[axis];
  }
}

void hc_block_tell_ghosts(hc_individual_block *b) {
  const hc_field_set found =
      HC_WHOLE(force) | HC_WHOLE(last_density) | HC_WHOLE(density_rate) | HC_WHOLE(schedule);
  hc_world *const world = b->world;
  if (b->ghosts_new) {
    hc_halo_refresh(world->halo, found | HC_WHOLE(velocity));
    place_ghosts(b);
  } else {
    hc_halo_begin_some(world->halo, found, world->chosen.bits);
    hc_halo_end_some(world->halo, NULL);
  }
  b->ghosts_new = false;
}

void hc_block_activate_ghosts(const hc_individual_block *b) {
  const hc_particles *const fluid = b->world->fluid;
  for (int32_t k = 0; k < fluid->ghosts; k++)
    if (hc_bits_have(b->world->chosen.ghosts, k)) arrive(b, fluid->own + k);
}

/* ---- all as they are now ---- */

void hc_block_fill_pressures(const hc_individual_block *b) {
  hc_particles *const fluid = b->world->fluid;
  const float rest = (float)b->settings->common.rest_density;
  for (int32_t i = 0; i < fluid->own; i++) {
    const float relative = relative_density(b, i, age(b, i));
    fluid->density[i] = rest * relative;
    fluid->pressure[i] = rest * hc_tait_pressure(&b->settings->tait, relative);
  }
}

void hc_block_shift(const hc_individual_block *b, int to) {
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
