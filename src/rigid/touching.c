#include "touching.h"

#include "base/memory.h"
#include "sph/kernel.h"

#include <math.h>
#include <string.h>

void hc_touching_init(hc_touching *touching) {
  memset(touching, 0, sizeof *touching);
  hc_neighbors_init(&touching->list);
  hc_neighbors_init(&touching->near);
}

void hc_touching_free(hc_touching *touching) {
  hc_neighbors_free(&touching->list);
  hc_neighbors_free(&touching->near);
  hc_free(touching->index);
}

/* The volume that counts of sample k of a store, whose row is of these records. */
static float counted_volume(const hc_world *world, int first, const hc_particles *store, int32_t k,
                            const hc_neighbors *list, int32_t row, const hc_particles *others) {
  const uint32_t *const offset = hc_list_row(list, row);
  double sum = 0.0;
  for (int32_t n = 0; n < hc_list_count(list, row); n++) {
    const int32_t b = (int32_t)(offset[n] / sizeof(hc_record));
    const hc_record *const own = &store->motion[k], *const other = &others->motion[b];
    const int walls[2] = {(int)own->scalar, (int)other->scalar};
    if (walls[0] == walls[1] || (walls[0] < first && walls[1] < first)) continue;
    double square = 0.0;
    for (int axis = 0; axis < 3; axis++) {
      const double d =
          (double)(int32_t)((uint32_t)store->place[k].x[axis] - (uint32_t)others->place[b].x[axis]) *
          (double)world->sweep.scale[axis];
      square += d * d;
    }
    sum += (double)world->sweep.kernel * hc_kernel_shape(sqrt(square));
  }
  const double volume = (double)store->volume[k];
  return (float)(volume / (1.0 + volume * sum / world->volume_factor));
}

/* Own samples that stand still in or next to cells with moving ones. */
static void choose(hc_touching *touching, const hc_world *world) {
  const hc_cells *const moving = &world->stores[HC_STORE_MOVING].cells;
  const hc_cells *const walls = &world->stores[HC_STORE_BOUNDARY].cells;
  int32_t brick = -1, adjacent[HC_ADJACENT];
  bool any = false;
  touching->count = 0;
  for (int32_t k = 0; k < walls->own_cell_count; k++) {
    const int32_t slot = walls->own_cells[k], cell = slot % HC_BRICK_CELLS;
    if (slot / HC_BRICK_CELLS != brick) {
      brick = slot / HC_BRICK_CELLS;
      any = hc_brick_set_around(&moving->bricks, walls->bricks.bricks[brick], adjacent);
    }
    if (!any || !hc_cells_any_around(moving, adjacent, cell)) continue;
    const int32_t first = walls->begin[brick][cell], count = walls->count[brick][cell];
    hc_reserve((void **)&touching->index, &touching->room, 2 * (size_t)(touching->count + count),
               (size_t)touching->count, sizeof *touching->index);
    for (int32_t n = 0; n < count; n++) touching->index[touching->count++] = first + n;
  }
}

static void refresh_still(hc_touching *touching, hc_world *world, int first) {
  hc_particles *const walls = world->boundary;
  hc_store *const stores = world->stores;
  const hc_neighbor_source source = {&stores[HC_STORE_MOVING].cells, world->moving};
  for (int32_t k = 0; k < walls->own; k++) walls->place[k].scalar = walls->volume[k];
  choose(touching, world);
  const hc_selection chosen = {touching->index, 0, touching->count, false};
  hc_neighbors_build(&touching->near, &world->search, &stores[HC_STORE_BOUNDARY].cells, walls, chosen,
                     &source, 1);
  for (int32_t k = 0; k < touching->count; k++) {
    const int32_t i = touching->index[k];
    walls->place[i].scalar = counted_volume(world, first, walls, i, &touching->near, k, world->moving);
  }
}

void hc_touching_refresh(hc_touching *touching, hc_world *world, int first) {
  hc_particles *const moving = world->moving;
  hc_store *const stores = world->stores;
  const hc_neighbor_source sources[2] = {{&stores[HC_STORE_BOUNDARY].cells, world->boundary},
                                         {&stores[HC_STORE_MOVING].cells, moving}};
  hc_neighbors_build(&touching->list, &world->search, &stores[HC_STORE_MOVING].cells, moving,
                     hc_select_all(moving), sources, 2);
  for (int32_t k = 0; k < moving->own; k++)
    moving->place[k].scalar = counted_volume(world, first, moving, k, &touching->list, k, world->boundary);
  refresh_still(touching, world, first);
  hc_halo_refresh(&stores[HC_STORE_BOUNDARY].halo, HC_SCALAR(place));
  hc_halo_refresh(&stores[HC_STORE_MOVING].halo, HC_SCALAR(place));
}
