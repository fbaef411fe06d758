#include "rest_choice.h"

#include "base/memory.h"
#include "particles/ids.h"
#include "sph/kernel.h"

#include <math.h>
#include <string.h>

/* What a particle is; in motion.scalar, of ghosts too. */
typedef enum what { GONE, HERE, FRESH, AIR } what;

static const double NEAREST = 0.25; /* spacings, to fluid that is here: half a radius */
enum { MOST_PASSES = 1000 };

/* Where the solver squares wall densities, the plain sum is right in the mean, for as much water as there is
 * room, but keeps particles that sit in the surface; the square alone takes 3 % of a box's water away. So the
 * square counts by this beside the plain sum (not in the paper). */
static const double COUNTED = 0.1;

typedef struct choice {
  hc_world *world;
  const hc_scene_rest *rules;
  const hc_rest_fresh *fresh;
  int32_t *near;       /* own particles that may be, ascending */
  int32_t *candidates; /* ascending */
  int32_t count;
  double *constant; /* of candidates: density of what stays, walls first; of the rest density */
  double *density;  /* of candidates */
  bool *denied;     /* of candidates: too dense, and not protected */
  double cap;
} choice;

static what what_of(const hc_world *world, int32_t j) {
  return (what)world->fluid->motion[j].scalar;
}

/* In support radii. */
static double distance(const hc_world *world, int32_t i, int32_t j) {
  const hc_record *const place = world->fluid->place;
  double square = 0.0;
  for (int axis = 0; axis < 3; axis++) {
    const double d = (double)(int32_t)((uint32_t)place[i].x[axis] - (uint32_t)place[j].x[axis]) *
                     (double)world->sweep.scale[axis];
    square += d * d;
  }
  return sqrt(square);
}

/* What a particle adds to the density at a distance, of the rest density. */
static double share_at(const hc_world *world, double q) {
  return q < 1.0 ? (double)world->sweep.volume * (double)world->sweep.kernel * hc_kernel_shape(q) : 0.0;
}

/* Densities at a particle by what makes them, itself not counted; and the nearest of what is here. */
typedef struct around {
  double of[AIR + 1], nearest;
} around;

static around look_around(const hc_world *world, int32_t i) {
  around found = {.nearest = 1.0};
  const uint32_t *const row = hc_list_row(&world->list, i);
  for (int32_t k = 0; k < hc_list_count(&world->list, i); k++) {
    const int32_t j = (int32_t)(row[k] / sizeof(hc_record));
    const what other = what_of(world, j);
    const double q = distance(world, i, j);
    found.of[other] += share_at(world, q);
    if (other == HERE) found.nearest = fmin(found.nearest, q);
  }
  return found;
}

/* What walls add to a particle's density, of the rest density. */
typedef struct walls_around {
  bool any;
  double plain;   /* the sum over their volumes; without volumes as counted */
  double counted; /* what the solver makes of it */
} walls_around;

/* `fluid`: its density by all fluid that there is, which with walls makes the solver's. */
static walls_around look_at_walls(const hc_world *world, int32_t i, double fluid) {
  const uint32_t *const row = hc_list_row(&world->walls, i);
  walls_around found = {.any = false};
  for (int32_t k = 0; k < hc_list_count(&world->walls, i); k++) {
    const int32_t b = (int32_t)(row[k] / sizeof(hc_record));
    double d[3];
    hc_sweep_from_wall(&world->sweep, i, b, d);
    const double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    if (!(square < 1.0)) continue;
    found.any = true;
    found.plain += (double)world->boundary->place[b].scalar * (double)world->sweep.kernel *
                   hc_kernel_shape(sqrt(square));
  }
  if (!found.any) return found;
  found.counted = (double)world->fluid->density[i] / (double)world->sweep.rest_density - fluid;
  if (world->sweep.walls_add != HC_WALLS_MIRRORED) found.plain = found.counted;
  return found;
}

/* ---- who is looked at ---- */

static void show(const choice *c) {
  hc_halo_refresh(c->world->halo, HC_SCALAR(motion));
}

static bool is_fresh(const hc_rest_fresh *fresh, uint64_t id) {
  const int64_t source = hc_id_source_of(id);
  return (source < fresh->sources && fresh->source[source]) || (id >= fresh->from && id < fresh->to);
}

static void tell_apart(const choice *c, hc_rest_chosen *chosen) {
  hc_particles *const fluid = c->world->fluid;
  chosen->loaded = chosen->air = 0;
  for (int32_t i = 0; i < fluid->own; i++) {
    const bool air = hc_id_kind_of(fluid->id[i]) == HC_ID_AIR, fresh = is_fresh(c->fresh, fluid->id[i]);
    fluid->motion[i].scalar = (float)(air ? AIR : fresh ? FRESH : HERE);
    chosen->loaded += !air && fresh;
    chosen->air += air;
  }
  show(c);
}

/* Which cells, of own particles and ghosts, hold fluid that is here: a bit for each, by brick. */
static uint64_t *cells_here(const hc_world *world) {
  const hc_cells *const cells = world->cells;
  uint64_t *const bits = hc_alloc_zero((size_t)cells->bricks.count, sizeof *bits);
  for (int32_t brick = 0; brick < cells->bricks.count; brick++)
    for (int cell = 0; cell < HC_BRICK_CELLS; cell++)
      for (int32_t k = 0; k < cells->count[brick][cell]; k++)
        if (what_of(world, cells->begin[brick][cell] + k) == HERE) bits[brick] |= (uint64_t)1 << cell;
  return bits;
}

static bool any_here(const uint64_t *here, const int32_t adjacent[HC_ADJACENT], int cell) {
  bool any = false;
  for (int way = 0; way < HC_ADJACENT && !any; way++) {
    int there;
    const int32_t brick = hc_cells_next(adjacent, cell, way, &there);
    any = brick >= 0 && (here[brick] >> there & 1);
  }
  return any;
}

/* Are there walls in or around the cell of a brick? */
static bool any_wall(const hc_world *world, hc_brick place, int cell) {
  bool any = false;
  for (int k = HC_STORE_BOUNDARY; k <= HC_STORE_MOVING && !any; k++) {
    const hc_cells *const walls = &world->stores[k].cells;
    int32_t adjacent[HC_ADJACENT];
    any = hc_brick_set_around(&walls->bricks, place, adjacent) && hc_cells_any_around(walls, adjacent, cell);
  }
  return any;
}

/* Lists own particles of cells that have walls, or fluid that is here, in or around them: the others cannot
 * be candidates, and how many they are costs nothing. */
static void list_near(choice *c) {
  hc_world *const world = c->world;
  const hc_cells *const cells = world->cells;
  uint64_t *const here = cells_here(world);
  size_t room = 0;
  int32_t count = 0;
  for (int32_t k = 0; k < cells->own_cell_count; k++) {
    const int32_t brick = cells->own_cells[k] / HC_BRICK_CELLS, cell = cells->own_cells[k] % HC_BRICK_CELLS;
    const hc_brick place = cells->bricks.bricks[brick];
    int32_t around[HC_ADJACENT];
    hc_brick_set_around(&cells->bricks, place, around);
    const bool looked_at =
        any_here(here, around, cell) || (!c->fresh->fitted && any_wall(world, place, cell));
    if (!looked_at) continue;
    const int32_t first = cells->begin[brick][cell], more = cells->count[brick][cell];
    hc_reserve((void **)&c->near, &room, 2 * (size_t)(count + more), (size_t)count, sizeof *c->near);
    for (int32_t n = 0; n < more; n++) c->near[count++] = first + n;
  }
  hc_free(here);
  hc_selection selection = {c->near, 0, count, false};
  hc_world_list(world, &selection);
  hc_neighbors_spread(&world->list, selection, world->fluid->own);
  hc_neighbors_spread(&world->walls, selection, world->fluid->own);
  selection.of_all = true;
  world->listed = selection;
}

/* ---- before the passes ---- */

/* Takes away who is too near to what is there, or gets too much density from it, and finds the candidates. */
static void start(choice *c) {
  hc_world *const world = c->world;
  hc_particles *const fluid = world->fluid;
  const double itself = share_at(world, 0.0), nearest = NEAREST * 2.0 * (double)world->sweep.wall_offset;
  size_t room[2] = {0, 0};
  for (int32_t i = 0; i < fluid->own; i++) /* who goes is noted there, as all judge on the state before */
    fluid->place[i].scalar = 0.0f;
  for (int32_t row = 0; row < world->listed.end; row++) {
    const int32_t i = hc_selected(world->listed, row);
    const what it = what_of(world, i);
    if (it != FRESH && it != AIR) continue;
    const around all = look_around(world, i);
    const walls_around walls = look_at_walls(world, i, itself + all.of[HERE] + all.of[FRESH] + all.of[AIR]);
    if (all.nearest < nearest || walls.plain + all.of[HERE] > c->rules->early_density) {
      fluid->place[i].scalar = 1.0f;
      continue;
    }
    if (it != FRESH || !((walls.any && !c->fresh->fitted) || all.nearest < 1.0)) continue;
    const size_t kept = (size_t)c->count;
    hc_reserve((void **)&c->candidates, &room[0], kept + 1, kept, sizeof *c->candidates);
    hc_reserve((void **)&c->constant, &room[1], kept + 1, kept, sizeof *c->constant);
    c->candidates[c->count] = i;
    c->constant[c->count++] = walls.plain + COUNTED * (walls.counted - walls.plain) + all.of[HERE];
  }
  for (int32_t i = 0; i < fluid->own; i++) {
    if (fluid->place[i].scalar != 0.0f) fluid->motion[i].scalar = (float)GONE;
    fluid->place[i].scalar = 0.0f;
  }
  show(c);
  c->density = hc_alloc((size_t)c->count, sizeof *c->density);
  c->denied = hc_alloc((size_t)c->count, sizeof *c->denied);
}

/* ---- passes ---- */

/* Densities of the candidates that are left, their ghosts' too; their number, mean and largest. */
static void find_densities(choice *c, bool air_too, int64_t *left, double *mean, double *most) {
  hc_world *const world = c->world;
  const double itself = share_at(world, 0.0);
  hc_sum sum;
  memset(&sum, 0, sizeof sum);
  *left = 0;
  *most = 0.0;
  for (int32_t k = 0; k < c->count; k++) {
    const int32_t i = c->candidates[k];
    if (what_of(world, i) != FRESH) {
      world->fluid->place[i].scalar = 0.0f;
      continue;
    }
    const around found = look_around(world, i);
    if (air_too) c->constant[k] += found.of[AIR];
    c->density[k] = c->constant[k] + itself + found.of[FRESH];
    world->fluid->place[i].scalar = (float)c->density[k];
    hc_sum_add(&sum, c->density[k]);
    *most = fmax(*most, c->density[k]);
    ++*left;
  }
  hc_halo_refresh(world->halo, HC_SCALAR(place));
  hc_tally tally = {.count = 0};
  hc_tally_sum_exact(&tally, &sum, 1);
  hc_tally_sum_i64(&tally, left, 1);
  hc_tally_max_f64(&tally, most, 1);
  hc_tally_reduce(world->comm, &tally);
  *mean = *left > 0 ? hc_sum_value(&sum) / (double)*left : 0.0;
}

/* Without a denser neighbour it would be below the threshold. */
static bool is_protected(const choice *c, int32_t k) {
  const hc_world *const world = c->world;
  const hc_record *const place = world->fluid->place;
  const int32_t i = c->candidates[k];
  const uint32_t *const row = hc_list_row(&world->list, i);
  bool safe = false;
  for (int32_t n = 0; n < hc_list_count(&world->list, i) && !safe; n++) {
    const int32_t j = (int32_t)(row[n] / sizeof(hc_record));
    safe =
        place[j].scalar > place[i].scalar && c->density[k] - share_at(world, distance(world, i, j)) < c->cap;
  }
  return safe;
}

static void deny(choice *c) {
  hc_world *const world = c->world;
  for (int32_t k = 0; k < c->count; k++)
    c->denied[k] = what_of(world, c->candidates[k]) == FRESH && c->density[k] > c->cap &&
                   !(c->rules->protection && is_protected(c, k));
  for (int32_t k = 0; k < c->count; k++)
    if (c->denied[k]) world->fluid->motion[c->candidates[k]].scalar = (float)GONE;
  show(c);
}

/* How far the threshold falls. */
static double fall(const choice *c, double mean) {
  const hc_scene_rest *const rules = c->rules;
  double by = rules->step;
  if (rules->regulator > 0.0) {
    by = fmin((mean - rules->target) * rules->regulator, 0.5 * (c->cap - rules->target));
    by = fmax(by, rules->step);
  }
  return by;
}

static void select_candidates(choice *c, hc_rest_chosen *chosen) {
  double most;
  find_densities(c, true, &chosen->before, &chosen->mean, &most);
  chosen->candidates = chosen->before;
  c->cap = most;
  while (chosen->mean > c->rules->target && chosen->candidates > 0 && chosen->iterations < MOST_PASSES) {
    c->cap -= fall(c, chosen->mean);
    deny(c);
    find_densities(c, false, &chosen->candidates, &chosen->mean, &most);
    chosen->iterations++;
  }
}

static void find_deviation(const choice *c, hc_rest_chosen *chosen) {
  hc_sum sum;
  memset(&sum, 0, sizeof sum);
  for (int32_t k = 0; k < c->count; k++) {
    const double off = c->density[k] - c->rules->target;
    if (what_of(c->world, c->candidates[k]) == FRESH) hc_sum_add(&sum, off * off);
  }
  hc_comm_sum_exact(c->world->comm, &sum, 1);
  chosen->deviation = chosen->candidates > 0 ? sqrt(hc_sum_value(&sum) / (double)chosen->candidates) : 0.0;
}

/* ---- who has a say ---- */

/* Gives a part to those that are away and in the support of selected particles, whoever owns them. */
static void spread(const choice *c, const hc_neighbors *list, hc_selection from, hc_rest_part give,
                   hc_rest_part *part) {
  hc_world *const world = c->world;
  const hc_particles *const fluid = world->fluid;
  const size_t records = (size_t)fluid->own + (size_t)fluid->ghosts;
  float *const asked = hc_alloc_zero(records + 1, sizeof *asked); /* less than 0: asked */
  uint64_t *const bits = hc_alloc_zero(records / 64 + 1, sizeof *bits);
  for (int32_t row = from.begin; row < from.end; row++) {
    const int32_t i = hc_selected(from, row), at = hc_row_of(from, row);
    const uint32_t *const offset = hc_list_row(list, at);
    for (int32_t n = 0; n < hc_list_count(list, at); n++) {
      const int32_t j = (int32_t)(offset[n] / sizeof(hc_record));
      if (distance(world, i, j) < 1.0) asked[j] = -1.0f;
    }
  }
  for (size_t j = (size_t)fluid->own; j < records; j++)
    if (asked[j] < 0.0f) bits[j / 64] |= (uint64_t)1 << j % 64;
  hc_halo_fold_least(world->halo, HC_TYPE_f32, 1, asked, bits);
  for (int32_t i = 0; i < fluid->own; i++)
    if (asked[i] < 0.0f && part[i] == HC_REST_AWAY) part[i] = give;
  hc_free(asked);
  hc_free(bits);
}

/* Own particles of a part. */
static hc_selection select_part(const hc_particles *fluid, const hc_rest_part *part, hc_rest_part wanted,
                                int32_t **index) {
  int32_t count = 0;
  for (int32_t i = 0; i < fluid->own; i++) count += part[i] == wanted;
  *index = hc_alloc((size_t)count + 1, sizeof **index);
  count = 0;
  for (int32_t i = 0; i < fluid->own; i++)
    if (part[i] == wanted) (*index)[count++] = i;
  return (hc_selection){*index, 0, count, false};
}

static void share_parts(const choice *c, hc_rest_part *part) {
  hc_world *const world = c->world;
  const hc_particles *const fluid = world->fluid;
  for (int32_t i = 0; i < fluid->own; i++) {
    const what it = what_of(world, i);
    part[i] = it == GONE || it == AIR ? HC_REST_GONE : HC_REST_AWAY;
  }
  for (int32_t k = 0; k < c->count; k++)
    if (part[c->candidates[k]] != HC_REST_GONE) part[c->candidates[k]] = HC_REST_CANDIDATE;
  int32_t *candidates, *beside;
  hc_selection from = select_part(fluid, part, HC_REST_CANDIDATE, &candidates);
  from.of_all = true;
  spread(c, &world->list, from, HC_REST_BESIDE, part);
  hc_neighbors list;
  hc_neighbors_init(&list);
  from = select_part(fluid, part, HC_REST_BESIDE, &beside);
  hc_neighbors_build(&list, &world->search, world->cells, fluid, from,
                     &(hc_neighbor_source){world->cells, fluid}, 1);
  spread(c, &list, from, HC_REST_BEHIND, part);
  hc_neighbors_free(&list);
  hc_free(candidates);
  hc_free(beside);
}

void hc_rest_choose(const hc_resting *resting, const hc_scene_rest *rules, const hc_rest_fresh *fresh,
                    hc_rest_part *part, hc_rest_chosen *chosen) {
  choice c = {.world = resting->world, .rules = rules, .fresh = fresh};
  memset(chosen, 0, sizeof *chosen);
  tell_apart(&c, chosen);
  list_near(&c);
  resting->solver->densities(c.world, resting->settings);
  tell_apart(&c, chosen); /* lists and densities overwrite it */
  start(&c);
  select_candidates(&c, chosen);
  find_deviation(&c, chosen);
  share_parts(&c, part);
  int64_t counts[2] = {chosen->loaded, chosen->air};
  hc_comm_sum_i64(c.world->comm, counts, 2);
  chosen->loaded = counts[0];
  chosen->air = counts[1];
  c.world->listed = hc_select_range(0, -1); /* the lists' rows go with `near` */
  hc_free(c.near);
  hc_free(c.candidates);
  hc_free(c.constant);
  hc_free(c.density);
  hc_free(c.denied);
}
