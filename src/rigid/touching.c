#include "touching.h"

#include "base/memory.h"
#include "sph/kernel.h"

#include <math.h>
#include <string.h>

void hc_touching_init(hc_touching *touching) {
  memset(touching, 0, sizeof *touching);
  hc_neighbors_init(&touching->moving.list);
  hc_neighbors_init(&touching->still.list);
}

static void free_side(hc_touching_side *side) {
  hc_neighbors_free(&side->list);
  hc_free(side->index);
  hc_free(side->marks);
}

void hc_touching_free(hc_touching *touching) {
  free_side(&touching->moving);
  free_side(&touching->still);
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

static void clear_marks(hc_touching_side *side, const hc_cells *cells) {
  const size_t bricks = (size_t)cells->bricks.count;
  hc_reserve((void **)&side->marks, &side->marks_room, bricks + 1, 0, sizeof *side->marks);
  memset(side->marks, 0, bricks * sizeof *side->marks);
}

/* Is a sample of another surface in the cell? Its samples ascend by id, which begins with the surface. */
static bool has_other(const hc_cells *cells, const hc_particles *samples, int32_t brick, int cell,
                      float wall) {
  const int32_t count = cells->count[brick][cell];
  const hc_record *const first = &samples->motion[cells->begin[brick][cell]];
  return count > 0 && (first->scalar != wall || first[count - 1].scalar != wall);
}

/* Marks a cell of moving samples, and those around it, where there are other surfaces. `beside`, `around`:
 * the bricks around its own of samples that stand still, null where there are none, and of those that move.
 */
static void mark_around(hc_touching *touching, const hc_world *world, int32_t brick, int cell,
                        const int32_t beside[HC_ADJACENT], const int32_t around[HC_ADJACENT]) {
  const hc_cells *const still = &world->stores[HC_STORE_BOUNDARY].cells;
  const hc_cells *const moving = &world->stores[HC_STORE_MOVING].cells;
  const float wall = world->moving->motion[moving->begin[brick][cell]].scalar;
  bool other = false;
  for (int way = 0; way < HC_ADJACENT; way++) {
    int there;
    const int32_t next = hc_cells_next(around, cell, way, &there);
    other = other || (next >= 0 && has_other(moving, world->moving, next, there, wall));
    const int32_t near = beside ? hc_cells_next(beside, cell, way, &there) : -1;
    if (near < 0 || still->count[near][there] == 0) continue;
    touching->still.marks[near] |= (uint64_t)1 << there;
    other = true;
  }
  if (other) touching->moving.marks[brick] |= (uint64_t)1 << cell;
}

static void mark(hc_touching *touching, const hc_world *world) {
  const hc_cells *const still = &world->stores[HC_STORE_BOUNDARY].cells;
  const hc_cells *const moving = &world->stores[HC_STORE_MOVING].cells;
  int32_t beside[HC_ADJACENT], around[HC_ADJACENT];
  clear_marks(&touching->still, still);
  clear_marks(&touching->moving, moving);
  for (int32_t brick = 0; brick < moving->bricks.count; brick++) {
    const hc_brick place = moving->bricks.bricks[brick];
    const bool any = hc_brick_set_around(&still->bricks, place, beside);
    hc_brick_set_around(&moving->bricks, place, around);
    for (int cell = 0; cell < HC_BRICK_CELLS; cell++)
      if (moving->count[brick][cell] > 0)
        mark_around(touching, world, brick, cell, any ? beside : NULL, around);
  }
}

/* The own samples of marked cells. */
static void choose(hc_touching_side *side, const hc_cells *cells) {
  side->count = 0;
  for (int32_t k = 0; k < cells->own_cell_count; k++) {
    const int32_t brick = cells->own_cells[k] / HC_BRICK_CELLS, cell = cells->own_cells[k] % HC_BRICK_CELLS;
    if (!(side->marks[brick] >> cell & 1)) continue;
    const int32_t first = cells->begin[brick][cell], count = cells->count[brick][cell];
    hc_reserve((void **)&side->index, &side->index_room, 2 * (size_t)(side->count + count),
               (size_t)side->count, sizeof *side->index);
    for (int32_t n = 0; n < count; n++) side->index[side->count++] = first + n;
  }
}

/* Finds who is near samples of a store, and what volumes count. */
static void refresh(hc_touching_side *side, hc_world *world, hc_store *store, int first,
                    const hc_neighbor_source *sources, int source_count) {
  hc_particles *const own = &store->particles;
  choose(side, &store->cells);
  hc_neighbors_build(&side->list, &world->search, &store->cells, own,
                     (hc_selection){side->index, 0, side->count, false}, sources, source_count);
  for (int32_t k = 0; k < side->count; k++) {
    const int32_t i = side->index[k];
    own->place[i].scalar = counted_volume(world, first, own, i, &side->list, k, sources[0].particles);
  }
}

void hc_touching_refresh(hc_touching *touching, hc_world *world, int first) {
  hc_store *const still = &world->stores[HC_STORE_BOUNDARY], *const moving = &world->stores[HC_STORE_MOVING];
  const hc_neighbor_source sources[2] = {{&still->cells, world->boundary}, {&moving->cells, world->moving}};
  mark(touching, world);
  refresh(&touching->moving, world, moving, first, sources, 2);
  touching->any = touching->moving.count > 0;
  for (int32_t k = 0; k < world->boundary->own; k++)
    world->boundary->place[k].scalar = world->boundary->volume[k];
  refresh(&touching->still, world, still, first, &sources[1], 1);
  hc_halo_refresh(&still->halo, HC_SCALAR(place));
  hc_halo_refresh(&moving->halo, HC_SCALAR(place));
}
