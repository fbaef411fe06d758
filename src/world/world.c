#include "world.h"

#include "base/memory.h"
#include "particles/ids.h"

#include <string.h>

void hc_world_init(hc_world *world, hc_comm *comm, const hc_world_settings *settings) {
  memset(world, 0, sizeof *world);
  hc_stopwatch_start(&world->watch);
  world->comm = comm;
  world->listed = -1;
  world->frame = settings->frame;
  world->mass = settings->mass;
  world->volume_factor = settings->volume_factor;
  world->contact_limit = settings->contact_limit;
  world->boundary_ops = settings->boundary_ops;
  hc_domain_init(&world->domain, comm, &world->frame);
  hc_particles_init(&world->fluid, HC_FLUID);
  hc_particles_init(&world->boundary, HC_BOUNDARY);
  hc_cells_init(&world->cells);
  hc_cells_init(&world->boundary_cells);
  hc_halo_init(&world->halo, &world->domain, &world->fluid);
  hc_halo_init(&world->boundary_halo, &world->domain, &world->boundary);
  hc_neighbor_search_init(&world->search, settings->isa);
  hc_neighbors_init(&world->list);
  hc_neighbors_init(&world->walls);
  hc_neighbors_init(&world->wetted);
  world->sweeps = hc_sweeps_of(settings->isa);
  world->sweep =
      hc_sweep_make(&world->frame, settings->mass / settings->rest_density, settings->rest_density);
  world->sweep.reach = 2.0f * world->sweep.wall_offset * world->sweep.support; /* a spacing */
  world->sweep.walls_add = settings->boundary_ops->walls;
  world->sweep.fluid = &world->fluid;
  world->sweep.boundary = &world->boundary;
  world->sweep.list = &world->list;
  world->sweep.walls = &world->walls;
  world->sweep.wetted = &world->wetted;
}

void hc_world_free(hc_world *world) {
  hc_movers_free(&world->moving);
  hc_halo_free(&world->halo);
  hc_halo_free(&world->boundary_halo);
  hc_neighbors_free(&world->list);
  hc_neighbors_free(&world->walls);
  hc_neighbors_free(&world->wetted);
  hc_free(world->contacts);
  hc_neighbor_search_free(&world->search);
  hc_cells_free(&world->cells);
  hc_cells_free(&world->boundary_cells);
  hc_particles_free(&world->fluid);
  hc_particles_free(&world->boundary);
  hc_domain_free(&world->domain);
}

/* Sorts a store's own particles and gives it its ghosts. */
static void sort_and_halo(hc_world *world, hc_particles *particles, hc_cells *cells, hc_halo *halo) {
  hc_stopwatch_enter(&world->watch, HC_STAGE_SORT);
  hc_cells_bin(cells, particles);
  hc_halo_mark(halo, cells);
  hc_cells_order(cells, particles);
  hc_stopwatch_enter(&world->watch, HC_STAGE_HALO);
  hc_halo_build(halo, cells);
}

/* Which wall each boundary particle, own or ghost, belongs to. */
static void number_walls(hc_world *world) {
  hc_particles *boundary = &world->boundary;
  for (int32_t k = 0; k < boundary->own; k++)
    boundary->place[k].scalar = (float)hc_id_source_of(boundary->id[k]);
  hc_halo_refresh(&world->boundary_halo, HC_HALO_PLACE_SCALAR);
  for (int32_t k = 0; k < boundary->own + boundary->ghosts; k++)
    boundary->wall[k] = boundary->place[k].scalar;
}

/* What sweeps read of a wall's particles besides their place; none has a pressure yet. */
static void face(hc_particles *boundary) {
  for (int32_t k = 0; k < boundary->own; k++) {
    memcpy(boundary->facing[k].v, &boundary->normal[3 * (size_t)k], sizeof boundary->facing[k].v);
    boundary->facing[k].scalar = 0.0f;
    boundary->pressure[k] = 0.0f;
  }
}

/* Gives boundary particles that have come to new places their cells, ghosts and numbers, and what sweeps read
 * of them: volumes, which are state, normals and velocities. */
static void place_boundary(hc_world *world) {
  hc_particles *boundary = &world->boundary;
  hc_stopwatch_enter(&world->watch, HC_STAGE_MIGRATE);
  hc_domain_migrate(&world->domain, boundary);
  sort_and_halo(world, boundary, &world->boundary_cells, &world->boundary_halo);
  number_walls(world);
  face(boundary);
  for (int32_t k = 0; k < boundary->own; k++) boundary->place[k].scalar = boundary->volume[k];
  hc_halo_refresh(&world->boundary_halo, HC_HALO_PLACE_SCALAR);
  hc_movers_drive(&world->moving, &world->frame, boundary);
  hc_halo_refresh(&world->boundary_halo, HC_HALO_MOTION);
  hc_halo_refresh(&world->boundary_halo, HC_HALO_FACING);
  world->walls_moved = false;
}

/* Boundary volumes, from the cells and ghosts as they are. */
static void measure_boundary(hc_world *world) {
  hc_neighbors list;
  hc_neighbors_init(&list);
  hc_neighbors_build(&list, &world->search, &world->boundary_cells, &world->boundary, &world->boundary_cells,
                     &world->boundary);
  hc_movers_part(&world->moving, &world->boundary, &list);
  world->boundary_ops->prepare(world->sweeps, &world->sweep, &world->boundary, &list, world->volume_factor);
  hc_neighbors_free(&list);
  hc_halo_refresh(&world->boundary_halo, HC_HALO_PLACE_SCALAR);
}

void hc_world_pose_walls(hc_world *world, double time, double ahead, bool held) {
  if (!hc_movers_pose(&world->moving, world->comm, time, ahead, held)) return;
  hc_movers_place(&world->moving, &world->frame, &world->boundary);
  world->sweep.walls_move = world->moving.moving;
  world->walls_moved = true;
}

void hc_world_rebalance(hc_world *world, hc_divider divider, double busy) {
  hc_stopwatch_enter(&world->watch, HC_STAGE_BALANCE);
  hc_work work = {.fluid = &world->fluid, .boundary = &world->boundary, .busy = busy};
  if (world->listed == world->fluid.own) {
    work.neighbors = world->list.count;
    work.walls = world->walls.count;
  }
  hc_domain_balance(&world->domain, divider, &work, &world->division);
  world->listed = -1;
  hc_domain_migrate(&world->domain, &world->fluid);
  place_boundary(world);
}

void hc_world_distribute(hc_world *world, hc_divider divider) {
  int64_t totals[2] = {world->fluid.own, world->boundary.own};
  hc_comm_sum_i64(world->comm, totals, 2);
  world->fluid_total = totals[0];
  world->boundary_total = totals[1];
  hc_world_rebalance(world, divider, 0.0);
}

void hc_world_start(hc_world *world, hc_divider divider) {
  hc_world_distribute(world, divider);
  measure_boundary(world);
}

static void refresh_motion(hc_particles *fluid) {
  for (int32_t k = 0; k < fluid->own; k++) {
    for (int axis = 0; axis < 3; axis++)
      fluid->motion[k].v[axis] = (float)fluid->velocity[3 * (size_t)k + axis];
    fluid->motion[k].scalar = 0.0f;
  }
}

void hc_world_update(hc_world *world) {
  if (world->walls_moved) place_boundary(world);
  hc_stopwatch_enter(&world->watch, HC_STAGE_MIGRATE);
  hc_domain_migrate(&world->domain, &world->fluid);
  sort_and_halo(world, &world->fluid, &world->cells, &world->halo);
  hc_stopwatch_enter(&world->watch, HC_STAGE_LISTS);
  refresh_motion(&world->fluid);
  hc_halo_begin(&world->halo, HC_HALO_MOTION);
  hc_neighbors_build(&world->list, &world->search, &world->cells, &world->fluid, &world->cells,
                     &world->fluid);
  hc_neighbors_build(&world->walls, &world->search, &world->cells, &world->fluid, &world->boundary_cells,
                     &world->boundary);
  if (world->boundary_ops->walls == HC_WALLS_PRESSURE)
    hc_neighbors_build(&world->wetted, &world->search, &world->boundary_cells, &world->boundary,
                       &world->cells, &world->fluid);
  world->listed = world->fluid.own;
  hc_halo_end(&world->halo);
}

static bool near_fluid(const hc_cells *fluid, const int32_t adjacent[HC_ADJACENT], int cell) {
  for (int way = 0; way < HC_ADJACENT; way++) {
    int there;
    const int32_t brick = hc_cells_next(adjacent, cell, way, &there);
    if (brick >= 0 && fluid->count[brick][there] > 0) return true;
  }
  return false;
}

double hc_world_active_boundary(hc_world *world) {
  const hc_cells *walls = &world->boundary_cells;
  int64_t active = 0;
  int32_t brick = -1, adjacent[HC_ADJACENT];
  bool any = false;
  for (int32_t k = 0; k < walls->own_cell_count; k++) {
    const int32_t slot = walls->own_cells[k];
    if (slot / HC_BRICK_CELLS != brick) {
      brick = slot / HC_BRICK_CELLS;
      any = hc_cells_around(&world->cells, walls->bricks.bricks[brick], adjacent);
    }
    const int cell = slot % HC_BRICK_CELLS;
    if (any && near_fluid(&world->cells, adjacent, cell)) active += walls->count[brick][cell];
  }
  hc_comm_sum_i64(world->comm, &active, 1);
  return world->boundary_total > 0 ? (double)active / (double)world->boundary_total : 0.0;
}
