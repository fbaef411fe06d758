/* What particles next to walls have around them, compiled once per instruction set. See sweeps.h for what it
 * adds up. */
#include "pairs.h"

/* All ones in the lanes whose sample is of a wall with friction. */
HC_INLINE hc_int has_friction(const hc_sweep *sweep, const hc_record *motion, const uint32_t *offset) {
  _Static_assert(sizeof(hc_wall_friction) == sizeof(hc_record), "it is loaded as a record");
  uint32_t of_wall[HC_LANES];
  hc_int law[4];
  hc_float wall;
  load_velocity(motion, offset, &wall);
  const hc_int offsets = __builtin_convertvector(wall, hc_int) * (int32_t)sizeof(hc_wall_friction);
  memcpy(of_wall, &offsets, sizeof of_wall);
  hc_load_records(sweep->friction, of_wall, law);
  return law[0] != HC_FRICTION_NONE;
}

HC_INLINE hc_float keep_where(hc_float value, hc_int mask) {
  return (hc_float)((hc_int)value & mask);
}

/* Of the particles of a block; constants are still to come. */
typedef struct block_layer {
  block_sums weight, height;
  block_vectors normal, velocity, area, depth;
} block_layer;

HC_INLINE void look_around(const hc_sweep *sweep, const hc_touch *touch, int32_t k, block_layer *block) {
  const hc_particles *const boundary = sweep->boundary;
  const self own = make_self(sweep, &sweep->fluid->place[touch->particle]);
  const row row = row_of(sweep->walls, touch->particle);
  const vector g = {hc_set(touch->depth[0]), hc_set(touch->depth[1]), hc_set(touch->depth[2])};
  sums weights = {{{0}}}, heights = {{{0}}};
  vector_sums normal = no_sums(), velocity = no_sums(), area = no_sums(), depth = no_sums();
  for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
    for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
      const int32_t at = pass + part * HC_GROUP;
      const pair p = load_pair(&own, boundary->place, row.offset + at);
      const vector d = direction(&p);
      const hc_float volume = hc_keep(p.scalar, row.count - at), slope = slope_over_q(p.q);
      add_scaled(&depth, part, volume * dot_pair(&g, &p) * slope, &d);
      if (!sweep->friction) continue;
      hc_float unused;
      const vector n = load_velocity(boundary->facing, row.offset + at, &unused);
      const hc_float height = dot_pair(&n, &p);
      hc_int rubs = height > hc_set(0.0f);
      if (sweep->friction_differs) rubs &= has_friction(sweep, boundary->motion, row.offset + at);
      const hc_float weight = hc_keep(keep_where(kernel(p.q), rubs), row.count - at);
      weights.part[part] += weight;
      heights.part[part] = hc_fma(weight, height, heights.part[part]);
      add_scaled(&normal, part, weight, &n);
      add_scaled(&area, part, hc_keep(keep_where(slope, rubs), row.count - at), &d);
      if (!sweep->walls_move) continue;
      const vector v = load_velocity(boundary->motion, row.offset + at, &unused);
      add_scaled(&velocity, part, weight, &v);
    }
  }
  hc_store_lanes(weights.part, block->weight.lanes[k]);
  hc_store_lanes(heights.part, block->height.lanes[k]);
  store_vector(&block->normal, k, &normal);
  store_vector(&block->velocity, k, &velocity);
  store_vector(&block->area, k, &area);
  store_vector(&block->depth, k, &depth);
}

HC_INLINE void put(const block_vectors *block, int32_t k, float scale, float to[3]) {
  to[0] = scale * block->x.total[k];
  to[1] = scale * block->y.total[k];
  to[2] = scale * block->z.total[k];
}

void HC_ISA_SYMBOL(hc_wall_layer)(const hc_sweep *sweep, const hc_touch *touches, int32_t count,
                                  hc_wall_around *around) {
  expect_walls(sweep);
  EXPECT_FIELD(sweep->boundary, facing);
  block_layer block;
  for (int32_t first = 0; first < count; first += BLOCK) {
    const int32_t size = block_size(first, count);
    for (int32_t k = 0; k < size; k++) look_around(sweep, &touches[first + k], k, &block);
    add_up(&block.weight, size);
    add_up(&block.height, size);
    add_up_vectors(&block.normal, size);
    add_up_vectors(&block.velocity, size);
    add_up_vectors(&block.area, size);
    add_up_vectors(&block.depth, size);
    for (int32_t k = 0; k < size; k++) {
      hc_wall_around *const to = &around[first + k];
      to->weight = block.weight.total[k];
      to->height = block.height.total[k];
      put(&block.normal, k, 1.0f, to->normal);
      put(&block.velocity, k, 1.0f, to->velocity);
      put(&block.area, k, sweep->gradient, to->area);
      put(&block.depth, k, -sweep->gradient * sweep->support, to->depth);
    }
  }
}
