#include "loads.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

/* What a rank's measured time may change of its weights: clocks are noisy. */
static const double MOST_CORRECTION = 1.5;

static void cell_of(const hc_particles *particles, int32_t k, int64_t cell[3]) {
  for (int axis = 0; axis < 3; axis++) cell[axis] = hc_frame_cell(particles->position[3 * (size_t)k + axis]);
}

int hc_loads_choose_bits(const int64_t counts[HC_MAP_MOST_BITS + 1], int ranks) {
  int bits = HC_MAP_MOST_BITS;
  while (bits > 0 && counts[bits] < (int64_t)HC_BRICKS_A_RANK * ranks) bits--;
  return bits;
}

int hc_loads_bits(hc_comm *comm, const hc_map *map, const hc_particles *fluid) {
  int64_t counts[HC_MAP_MOST_BITS + 1];
  hc_brick_set finer, coarser;
  hc_brick_set_init(&finer);
  for (int32_t k = 0; k < fluid->own; k++) {
    int64_t cell[3];
    cell_of(fluid, k, cell);
    hc_brick_set_add(&finer, hc_map_brick(map, 0, cell));
  }
  counts[0] = finer.count;
  for (int bits = 1; bits <= HC_MAP_MOST_BITS; bits++) {
    hc_brick_set_init(&coarser);
    for (int32_t k = 0; k < finer.count; k++) {
      const int32_t *x = finer.bricks[k].x;
      hc_brick_set_add(&coarser, (hc_brick){{x[0] >> 1, x[1] >> 1, x[2] >> 1}});
    }
    counts[bits] = coarser.count;
    hc_brick_set_free(&finer);
    finer = coarser;
  }
  hc_brick_set_free(&finer);
  hc_comm_sum_i64(comm, counts, HC_MAP_MOST_BITS + 1);
  return hc_loads_choose_bits(counts, comm->size);
}

/* How much more a unit of this rank's cost model takes than one of the average rank. */
static double correction(hc_comm *comm, double busy, double cost) {
  if (!(busy > 0.0) || !(cost > 0.0)) busy = cost = 0.0;
  int64_t sums[2] = {(int64_t)(1e9 * busy), (int64_t)cost};
  hc_comm_sum_i64(comm, sums, 2);
  if (busy == 0.0 || sums[0] <= 0) return 1.0;
  const double ratio = 1e9 * busy / cost * ((double)sums[1] / (double)sums[0]);
  return fmin(fmax(ratio, 1.0 / MOST_CORRECTION), MOST_CORRECTION);
}

/* Loads while they are added up. */
typedef struct loads {
  hc_brick_set set;
  hc_load *load;
  size_t capacity;
} loads;

/* The load of the particle's brick. */
static hc_load *load_at(loads *loads, const hc_map *map, int bits, const hc_particles *particles, int32_t k,
                        int rank) {
  int64_t cell[3];
  cell_of(particles, k, cell);
  const hc_brick brick = hc_map_brick(map, bits, cell);
  const int32_t before = loads->set.count, number = hc_brick_set_add(&loads->set, brick);
  if (number == before) {
    hc_reserve((void **)&loads->load, &loads->capacity, (size_t)before + 1, (size_t)before,
               sizeof *loads->load);
    loads->load[number] = (hc_load){.brick = brick, .rank = rank};
  }
  return &loads->load[number];
}

/* How often a particle found its forces in the last step. */
static double often(const hc_work *work, int32_t k) {
  const float *const own = work->fluid->time_step;
  return own && work->block > 0.0 && own[k] > 0.0f ? work->block / (double)own[k] : 1.0;
}

static double add_fluid(loads *loads, const hc_map *map, int bits, const hc_work *work, int rank) {
  double total = 0.0;
  for (int32_t k = 0; k < work->fluid->own; k++) {
    const int pairs = !work->neighbors ? HC_COST_FLUID - HC_COST_PARTICLE
                                       : hc_list_count(work->neighbors, k) +
                                             hc_list_count(work->walls, k) / HC_COST_WALL_SHARE;
    const double cost = HC_COST_PARTICLE + pairs * often(work, k);
    hc_load *load = load_at(loads, map, bits, work->fluid, k, rank);
    load->weight += (float)cost;
    load->fluid++;
    total += cost;
  }
  return total;
}

static void add_boundary(loads *loads, const hc_map *map, int bits, const hc_particles *boundary, int rank) {
  for (int32_t k = 0; k < boundary->own; k++) {
    hc_load *load = load_at(loads, map, bits, boundary, k, rank);
    load->weight += HC_COST_BOUNDARY;
    load->boundary++;
  }
}

hc_load *hc_loads_gather(hc_comm *comm, const hc_map *map, int bits, const hc_work *work, int64_t *count) {
  loads loads;
  memset(&loads, 0, sizeof loads);
  hc_brick_set_init(&loads.set);
  const double cost = add_fluid(&loads, map, bits, work, comm->rank);
  const float factor = (float)correction(comm, work->busy, cost);
  for (int32_t k = 0; k < loads.set.count; k++) loads.load[k].weight *= factor;
  add_boundary(&loads, map, bits, work->boundary, comm->rank);
  if (work->moving) add_boundary(&loads, map, bits, work->moving, comm->rank);
  void *all;
  size_t bytes;
  hc_comm_gather(comm, loads.load, (size_t)loads.set.count * sizeof *loads.load, 0, &all, &bytes);
  hc_free(loads.load);
  hc_brick_set_free(&loads.set);
  *count = (int64_t)(bytes / sizeof(hc_load));
  return all;
}
