#include "domain.h"

#include "base/check.h"
#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

void hc_domain_init(hc_domain *domain, hc_comm *comm, const hc_frame *frame) {
  const int cut_count = comm->size - 1;
  *domain = (hc_domain){comm, frame, 0, hc_alloc((size_t)cut_count, sizeof(hc_brick))};
  for (int k = 0; k < cut_count; k++) domain->cuts[k] = (hc_brick){{INT32_MAX, INT32_MAX, INT32_MAX}};
}

void hc_domain_free(hc_domain *domain) {
  hc_free(domain->cuts);
}

/* Slab order: along the axis first, then the two that follow it. */
static int compare_along(int axis, const hc_brick *a, const hc_brick *b) {
  for (int k = 0; k < 3; k++, axis = axis == 2 ? 0 : axis + 1)
    if (a->x[axis] != b->x[axis]) return a->x[axis] < b->x[axis] ? -1 : 1;
  return 0;
}

int hc_domain_owner(const hc_domain *domain, hc_brick brick) {
  int low = 0, high = domain->comm->size - 1; /* the owner is in [low, high] */
  while (low < high) {
    const int middle = (low + high) / 2;
    if (compare_along(domain->axis, &domain->cuts[middle], &brick) <= 0)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

double hc_domain_imbalance(hc_domain *domain, const hc_particles *fluid) {
  int64_t largest = fluid->own, total = fluid->own;
  hc_comm_max_i64(domain->comm, &largest, 1);
  hc_comm_sum_i64(domain->comm, &total, 1);
  return total > 0 ? (double)largest * domain->comm->size / (double)total : 1.0;
}

typedef struct brick_load {
  hc_brick brick;
  int32_t weight;
} brick_load;

/* qsort has no room for the axis: one comparison for each. */
static int by_x(const void *a, const void *b) {
  return compare_along(0, a, b);
}
static int by_y(const void *a, const void *b) {
  return compare_along(1, a, b);
}
static int by_z(const void *a, const void *b) {
  return compare_along(2, a, b);
}
static int (*const slab_order[3])(const void *, const void *) = {by_x, by_y, by_z};

static void add_loads(hc_cells *loads, const hc_particles *particles, int32_t weight) {
  for (int32_t k = 0; k < particles->own; k++) {
    hc_brick brick;
    hc_cell_of(&particles->position[3 * (size_t)k], &brick);
    const int32_t index = hc_cells_insert(loads, brick); /* may move the counts */
    loads->count[index][0] += weight;
  }
}

/* The loads of all ranks' bricks, in no order, a brick perhaps several times. */
static brick_load *gather_loads(hc_domain *domain, const hc_particles *fluid, const hc_particles *boundary,
                                size_t *count) {
  hc_cells loads;
  hc_cells_init(&loads);
  add_loads(&loads, fluid, HC_DOMAIN_FLUID_WEIGHT);
  add_loads(&loads, boundary, HC_DOMAIN_BOUNDARY_WEIGHT);
  brick_load *mine = hc_alloc((size_t)loads.brick_count, sizeof *mine);
  for (int32_t k = 0; k < loads.brick_count; k++) mine[k] = (brick_load){loads.bricks[k], loads.count[k][0]};
  void *all;
  size_t bytes;
  hc_comm_gather_all(domain->comm, mine, (size_t)loads.brick_count * sizeof *mine, &all, &bytes);
  hc_free(mine);
  hc_cells_free(&loads);
  *count = bytes / sizeof(brick_load);
  return all;
}

static int longest_axis(const brick_load *loads, size_t count) {
  int32_t low[3] = {0, 0, 0}, high[3] = {0, 0, 0};
  for (size_t k = 0; k < count; k++) {
    for (int axis = 0; axis < 3; axis++) {
      const int32_t x = loads[k].brick.x[axis];
      if (k == 0 || x < low[axis]) low[axis] = x;
      if (k == 0 || x > high[axis]) high[axis] = x;
    }
  }
  int longest = 0;
  for (int axis = 1; axis < 3; axis++)
    if ((int64_t)high[axis] - low[axis] > (int64_t)high[longest] - low[longest]) longest = axis;
  return longest;
}

double hc_domain_balance(hc_domain *domain, const hc_particles *fluid, const hc_particles *boundary) {
  size_t count;
  brick_load *loads = gather_loads(domain, fluid, boundary, &count);
  domain->axis = longest_axis(loads, count);
  qsort(loads, count, sizeof *loads, slab_order[domain->axis]);

  int64_t total = 0;
  for (size_t k = 0; k < count; k++) total += loads[k].weight;
  /* A brick goes to the rank whose share of the total holds the brick's middle. */
  const int ranks = domain->comm->size;
  int64_t before = 0, rank_load = 0, largest = 0;
  int rank = 0;
  for (size_t k = 0; k < count;) {
    int64_t weight = 0;
    size_t next = k;
    for (; next < count && hc_brick_equal(loads[next].brick, loads[k].brick); next++)
      weight += loads[next].weight;
    const int owner = (int)((2 * before + weight) * ranks / (2 * total + 1));
    for (; rank < owner; rank++) {
      domain->cuts[rank] = loads[k].brick;
      rank_load = 0;
    }
    rank_load += weight;
    if (rank_load > largest) largest = rank_load;
    before += weight;
    k = next;
  }
  for (; rank < ranks - 1; rank++) domain->cuts[rank] = (hc_brick){{INT32_MAX, INT32_MAX, INT32_MAX}};
  hc_free(loads);
  return total > 0 ? (double)largest * ranks / (double)total : 1.0;
}
