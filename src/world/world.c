#include "world.h"

#include "base/memory.h"
#include "particles/ids.h"

#include <math.h>
#include <string.h>

static void init_stores(hc_world *world, unsigned features) {
  static const unsigned kinds[HC_STORE_COUNT] = {HC_FLUID, HC_BOUNDARY, HC_BOUNDARY | HC_MOVED};
  for (int k = 0; k < HC_STORE_COUNT; k++) {
    hc_store *store = &world->stores[k];
    hc_particles_init(&store->particles, kinds[k], features);
    hc_cells_init(&store->cells);
    hc_halo_init(&store->halo, &world->domain, &store->particles, k);
    hc_neighbors_init(&store->wetted);
  }
  world->cells = &world->stores[HC_STORE_FLUID].cells;
  world->halo = &world->stores[HC_STORE_FLUID].halo;
  world->fluid = &world->stores[HC_STORE_FLUID].particles;
  world->boundary = &world->stores[HC_STORE_BOUNDARY].particles;
  world->moving = &world->stores[HC_STORE_MOVING].particles;
  hc_particles_join(world->boundary, world->moving);
}

void hc_world_init(hc_world *world, hc_comm *comm, const hc_world_settings *settings) {
  memset(world, 0, sizeof *world);
  hc_stopwatch_start(&world->watch);
  world->comm = comm;
  world->frame = settings->frame;
  world->margin = settings->frame.margin;
  world->mass = settings->mass;
  world->volume_factor = settings->volume_factor;
  world->contact_limit = settings->contact_limit;
  world->start_limit = settings->start_limit;
  world->boundary_ops = settings->boundary_ops;
  hc_domain_init(&world->domain, comm, &world->frame, settings->ranks_per_host);
  init_stores(world, settings->features);
  hc_neighbor_search_init(&world->search, settings->isa);
  hc_neighbors_init(&world->list);
  hc_neighbors_init(&world->walls);
  hc_neighbors_init(&world->some);
  world->sweeps = hc_sweeps_of(settings->isa);
  world->sweep =
      hc_sweep_make(&world->frame, settings->mass / settings->rest_density, settings->rest_density);
  world->sweep.reach = 2.0f * world->sweep.wall_offset * world->sweep.support; /* a spacing */
  world->sweep.walls_add = settings->boundary_ops->walls;
  world->sweep.flat_wall = (float)settings->flat_wall;
  world->sweep.fluid = world->fluid;
  world->sweep.boundary = world->boundary;
  world->sweep.list = &world->list;
  world->sweep.walls = &world->walls;
  world->sweep.holds = &world->holds;
  world->sweep.touches = &world->touches;
  world->sweep.friction = world->friction = settings->friction;
  world->sweep.friction_differs = settings->friction_differs;
  world->sweep.no_slip = settings->no_slip;
  world->sweep.drag = settings->drag;
  world->sweep.compressible = settings->compressible;
}

void hc_world_free(hc_world *world) {
  for (int k = HC_STORE_COUNT - 1; k >= 0; k--) { /* the tail before its head */
    hc_store *store = &world->stores[k];
    hc_halo_free(&store->halo);
    hc_cells_free(&store->cells);
    hc_neighbors_free(&store->wetted);
    hc_particles_free(&store->particles);
  }
  hc_neighbors_free(&world->list);
  hc_neighbors_free(&world->walls);
  hc_neighbors_free(&world->some);
  hc_free(world->contacts);
  hc_free(world->holds.at);
  hc_free(world->touches.at);
  hc_free(world->chosen.index);
  hc_free(world->chosen.bits);
  hc_free(world->chosen.ghosts);
  hc_free(world->chosen.touched);
  hc_free(world->chosen.asked);
  hc_free(world->chosen.before);
  hc_free(world->chosen.placed);
  hc_free(world->friction);
  hc_neighbor_search_free(&world->search);
  hc_domain_free(&world->domain);
}

/* Sends a store's own particles to their owners, sorts them and gives them their ghosts. */
static void place_store(hc_world *world, hc_store *store) {
  hc_stopwatch_enter(&world->watch, HC_STAGE_MIGRATE);
  hc_domain_migrate(&world->domain, &store->particles);
  hc_stopwatch_enter(&world->watch, HC_STAGE_SORT);
  hc_cells_bin(&store->cells, &store->particles);
  hc_halo_mark(&store->halo, &store->cells);
  hc_cells_order(&store->cells, &store->particles);
  hc_stopwatch_enter(&world->watch, HC_STAGE_HALO);
  hc_halo_build(&store->halo, &store->cells);
  store->moved = false;
}

/* What sweeps read of own boundary particles besides their places: volumes, which are state, velocities with
 * the wall's number, normals; no pressure yet. */
static void pack_boundary(hc_particles *boundary) {
  for (int32_t k = 0; k < boundary->own; k++) {
    const size_t at = 3 * (size_t)k;
    boundary->place[k].scalar = boundary->volume[k];
    boundary->pressure[k] = 0.0f;
    hc_record *motion = &boundary->motion[k];
    *motion = (hc_record){.v = {0.0f, 0.0f, 0.0f}, .scalar = (float)hc_id_source_of(boundary->id[k])};
    if (boundary->wall_velocity) memcpy(motion->v, &boundary->wall_velocity[at], sizeof motion->v);
    if (!boundary->facing) continue;
    memcpy(boundary->facing[k].v, &boundary->normal[at], sizeof boundary->facing[k].v);
    boundary->facing[k].scalar = boundary->faces ? boundary->faces[k] : 0.0f;
  }
}

static void place_walls(hc_world *world, hc_store_id id) {
  hc_store *store = &world->stores[id];
  place_store(world, store);
  pack_boundary(&store->particles);
  hc_field_set fields = HC_SCALAR(place) | HC_WHOLE(motion);
  if (store->particles.facing) fields |= HC_WHOLE(facing);
  hc_halo_refresh(&store->halo, fields);
}

/* Walls that stand still, and those that move behind them. */
static void place_boundary(hc_world *world) {
  place_walls(world, HC_STORE_BOUNDARY);
  hc_particles_trim(world->boundary); /* they are seldom sorted */
  place_walls(world, HC_STORE_MOVING);
}

/* Leaves in a list of samples into themselves only neighbours of the same wall. */
static void keep_own_wall(const hc_particles *walls, hc_neighbors *list) {
  uint32_t used = 0;
  list->pairs = 0;
  for (int32_t i = 0; i < walls->own; i++) {
    const uint32_t *row = hc_list_row(list, i), first = used;
    const int32_t count = hc_list_count(list, i);
    for (int32_t k = 0; k < count; k++)
      if (walls->motion[row[k] / sizeof(hc_record)].scalar == walls->motion[i].scalar)
        list->offset[used++] = row[k];
    list->pairs += used - first;
    const uint32_t fillers = -used % HC_LIST_GROUP;
    for (uint32_t k = 0; k < fillers; k++) list->offset[used++] = (uint32_t)((size_t)i * sizeof(hc_record));
    list->row[i] = first | fillers;
  }
  list->row[walls->own] = used;
}

/* Boundary volumes, from the cells and ghosts as they are. */
static void measure_boundary(hc_world *world, hc_store_id id) {
  hc_store *store = &world->stores[id];
  hc_particles *walls = &store->particles;
  hc_neighbors list;
  hc_neighbors_init(&list);
  hc_neighbors_build(&list, &world->search, &store->cells, walls, hc_select_all(walls),
                     &(hc_neighbor_source){&store->cells, walls}, 1);
  if (id == HC_STORE_MOVING) keep_own_wall(walls, &list);
  world->boundary_ops->prepare(world->sweeps, &world->sweep, walls, &list, world->volume_factor);
  hc_neighbors_free(&list);
  hc_halo_refresh(&store->halo, HC_SCALAR(place) | (walls->facing ? HC_WHOLE(facing) : 0));
}

void hc_world_rebalance(hc_world *world, hc_divider divider, double busy) {
  hc_stopwatch_enter(&world->watch, HC_STAGE_BALANCE);
  hc_work work = {.fluid = world->fluid,
                  .boundary = world->boundary,
                  .moving = world->moving,
                  .busy = busy,
                  .block = world->block};
  if (world->listed.end == world->fluid->own && !world->listed.index) {
    work.neighbors = &world->list;
    work.walls = &world->walls;
  }
  hc_domain_balance(&world->domain, divider, &work, &world->division);
  world->listed = hc_select_range(0, -1);
  hc_domain_migrate(&world->domain, world->fluid);
  place_boundary(world);
}

void hc_world_distribute(hc_world *world, hc_divider divider) {
  int64_t totals[2] = {world->fluid->own, world->boundary->own + world->moving->own};
  hc_comm_sum_i64(world->comm, totals, 2);
  world->fluid_total = totals[0];
  world->boundary_total = totals[1];
  world->listed = hc_select_range(0, -1);
  hc_world_rebalance(world, divider, 0.0);
}

void hc_world_count_fluid(hc_world *world) {
  world->fluid_total = world->fluid->own;
  hc_comm_sum_i64(world->comm, &world->fluid_total, 1);
}

void hc_world_start(hc_world *world, hc_divider divider) {
  hc_world_distribute(world, divider);
  measure_boundary(world, HC_STORE_BOUNDARY);
  measure_boundary(world, HC_STORE_MOVING);
}

void hc_world_place(hc_world *world) {
  hc_particles *fluid = world->fluid;
  if (world->stores[HC_STORE_BOUNDARY].moved)
    place_boundary(world);
  else if (world->stores[HC_STORE_MOVING].moved)
    place_walls(world, HC_STORE_MOVING);
  place_store(world, &world->stores[HC_STORE_FLUID]);
  hc_domain_settle_partners(&world->domain, fluid);
  for (int32_t k = 0; k < fluid->own; k++) {
    for (int axis = 0; axis < 3; axis++)
      fluid->motion[k].v[axis] = (float)fluid->velocity[3 * (size_t)k + axis];
    fluid->motion[k].scalar = 0.0f;
  }
}

void hc_world_reach(hc_world *world, double margin) {
  const hc_frame *const frame = &world->frame;
  world->margin = fmin(margin, frame->margin);
  world->search.reach = HC_CUT_EDGE;
  if (world->margin == frame->margin) return;
  const double edge = fmin(frame->unit[0], fmin(frame->unit[1], frame->unit[2])) * (double)HC_CELL_UNITS;
  world->search.reach =
      (int32_t)ceil(HC_CUT_EDGE * fmin(1.0, (frame->support_radius + world->margin) / edge));
}

void hc_world_list(hc_world *world, const hc_selection *selection) {
  const hc_selection selected = selection ? *selection : hc_select_all(world->fluid);
  hc_store *stores = world->stores, *fluid = &stores[HC_STORE_FLUID];
  hc_neighbor_source sources[HC_STORE_COUNT];
  for (int k = 0; k < HC_STORE_COUNT; k++)
    sources[k] = (hc_neighbor_source){&stores[k].cells, &stores[k].particles};
  hc_stopwatch_enter(&world->watch, HC_STAGE_LISTS);
  hc_halo_begin(&fluid->halo, HC_WHOLE(motion));
  hc_neighbors_build(&world->list, &world->search, &fluid->cells, world->fluid, selected,
                     &sources[HC_STORE_FLUID], 1);
  const int32_t reach = world->search.reach;
  world->search.reach = HC_CUT_EDGE;
  hc_neighbors_build(&world->walls, &world->search, &fluid->cells, world->fluid, selected,
                     &sources[HC_STORE_BOUNDARY], 2);
  for (int k = HC_STORE_BOUNDARY; k <= HC_STORE_MOVING && world->boundary_ops->walls == HC_WALLS_PRESSURE;
       k++)
    hc_neighbors_build(&stores[k].wetted, &world->search, &stores[k].cells, &stores[k].particles,
                       hc_select_all(&stores[k].particles), &sources[HC_STORE_FLUID], 1);
  world->search.reach = reach;
  world->listed = selected;
  hc_world_show_all(world);
  hc_halo_end(&fluid->halo);
}

void hc_world_remember_places(hc_world *world) {
  const size_t records = (size_t)world->fluid->own + (size_t)world->fluid->ghosts + HC_SPARE;
  hc_chosen *const chosen = &world->chosen;
  hc_reserve((void **)&chosen->placed, &chosen->placed_room, records, 0, sizeof *chosen->placed);
  memcpy(chosen->placed, world->fluid->place, records * sizeof *chosen->placed);
}

void hc_world_list_some(hc_world *world, hc_selection selection) {
  hc_store *const fluid = &world->stores[HC_STORE_FLUID];
  hc_record *const now = fluid->particles.place;
  const int32_t reach = world->search.reach;
  fluid->particles.place = world->chosen.placed;
  world->search.reach = HC_CUT_EDGE;
  selection.of_all = false;
  hc_neighbors_build(&world->some, &world->search, &fluid->cells, world->fluid, selection,
                     &(hc_neighbor_source){&fluid->cells, &fluid->particles}, 1);
  hc_neighbors_spread(&world->some, selection, world->fluid->own);
  world->search.reach = reach;
  fluid->particles.place = now;
  world->sweep.list = &world->some;
}

void hc_world_show_all(hc_world *world) {
  world->sweep.list = &world->list;
}

void hc_world_update(hc_world *world) {
  hc_world_place(world);
  hc_world_list(world, NULL);
}

static int64_t count_active(const hc_cells *fluid, const hc_cells *walls) {
  int64_t active = 0;
  int32_t brick = -1, adjacent[HC_ADJACENT];
  bool any = false;
  for (int32_t k = 0; k < walls->own_cell_count; k++) {
    const int32_t slot = walls->own_cells[k];
    if (slot / HC_BRICK_CELLS != brick) {
      brick = slot / HC_BRICK_CELLS;
      any = hc_brick_set_around(&fluid->bricks, walls->bricks.bricks[brick], adjacent);
    }
    const int cell = slot % HC_BRICK_CELLS;
    if (any && hc_cells_any_around(fluid, adjacent, cell)) active += walls->count[brick][cell];
  }
  return active;
}

int64_t hc_world_active_boundary(const hc_world *world) {
  const hc_cells *fluid = &world->stores[HC_STORE_FLUID].cells;
  return count_active(fluid, &world->stores[HC_STORE_BOUNDARY].cells) +
         count_active(fluid, &world->stores[HC_STORE_MOVING].cells);
}
