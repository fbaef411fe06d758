/* The map from cells to ranks: complete, balanced, the same on every rank; and migration along it. */
#include "mpi_test.h"

#include "base/memory.h"
#include "domain/domain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static hc_frame frame;
static hc_domain domain;
static hc_particles fluid, boundary;

static void setup(void) {
  memset(&frame, 0, sizeof frame);
  hc_domain_init(&domain, &comm, &frame, 0);
  hc_particles_init(&fluid, HC_FLUID, HC_FOR_ALL);
  hc_particles_init(&boundary, HC_BOUNDARY, HC_FOR_ALL);
}

static void teardown(void) {
  hc_domain_free(&domain);
  hc_particles_free(&fluid);
  hc_particles_free(&boundary);
}

/* Where particles lie: a box of `cells` edges around `centre`, in cells; denser at its low end. */
typedef struct cloud {
  int64_t cells[3], centre[3];
  uint64_t fluid, boundary; /* how many */
} cloud;

static int64_t position_of(const cloud *cloud, uint64_t id, int axis) {
  const double fraction = (double)(mix(3 * id + (uint64_t)axis) >> 11) * 0x1p-53;
  const double skewed = axis == 0 ? fraction * fraction : fraction;
  return cloud->centre[axis] * HC_CELL_UNITS +
         (int64_t)((skewed - 0.5) * (double)cloud->cells[axis] * (double)HC_CELL_UNITS);
}

static void fill(hc_particles *particles, const cloud *cloud, uint64_t count, uint64_t first, uint64_t seed) {
  hc_particles_resize(particles, 0);
  for (uint64_t id = first; id < first + count; id++) {
    if ((int)(mix(id * 31 + seed) % (uint64_t)comm.size) != comm.rank) continue;
    const int32_t k = particles->own;
    hc_particles_resize(particles, k + 1);
    particles->id[k] = id;
    for (int axis = 0; axis < 3; axis++) {
      particles->position[3 * k + axis] = position_of(cloud, id, axis);
      if (particles->velocity) particles->velocity[3 * k + axis] = (double)mix(id + (uint64_t)axis);
    }
    if (particles->volume) particles->volume[k] = (float)(id % 1000);
  }
}

enum { FIRST_BOUNDARY = 1000000 };

/* Spreads the particles over the ranks by chance. */
static void spread(const cloud *cloud, uint64_t seed) {
  fill(&fluid, cloud, cloud->fluid, 0, seed);
  fill(&boundary, cloud, cloud->boundary, FIRST_BOUNDARY, seed);
}

static int owner_at(const int64_t position[3]) {
  int64_t cell[3];
  for (int axis = 0; axis < 3; axis++) cell[axis] = hc_frame_cell(position[axis]);
  return hc_domain_owner(&domain, cell);
}

static hc_division balance(hc_divider divider) {
  hc_division division;
  hc_domain_balance(&domain, divider, &(hc_work){.fluid = &fluid, .boundary = &boundary}, &division);
  return division;
}

static bool same_on_all_ranks(uint64_t value) {
  int64_t high = (int64_t)(value >> 1), low = high;
  hc_comm_max_i64(&comm, &high, 1);
  hc_comm_min_i64(&comm, &low, 1);
  return high == low;
}

/* A cell and its ownership brick. */
typedef struct place {
  hc_brick brick;
  int64_t cell[3];
} place;

/* Every cell has one owner, the same on all ranks; a slab's ascend along the bricks. */
static void check_owners(void) {
  enum { COUNT = 3000 };
  static place places[COUNT];
  for (int k = 0; k < COUNT; k++) {
    for (int axis = 0; axis < 3; axis++) {
      const int64_t any = (int64_t)mix((uint64_t)(3 * k + axis));
      places[k].cell[axis] = k % 3 == 0 ? any >> 28 : k % 3 == 1 ? any >> 56 : any >> 60;
    }
    places[k].brick = hc_map_brick(&domain.map, domain.map.bits, places[k].cell);
  }
  qsort(places, COUNT, sizeof *places, hc_map_by(domain.map.order));
  bool good = true;
  uint64_t digest = 0;
  int before = 0;
  for (int k = 0; k < COUNT; k++) {
    const int owner = hc_domain_owner(&domain, places[k].cell);
    good &= owner >= (domain.map.order == HC_ORDER_MORTON ? 0 : before) && owner < comm.size;
    before = owner;
    digest = mix(digest + (uint64_t)owner);
  }
  EXPECT(good);
  EXPECT(same_on_all_ranks(digest));
}

static bool at_home(const hc_particles *particles) {
  bool good = true;
  for (int32_t k = 0; k < particles->own; k++) good &= owner_at(&particles->position[3 * k]) == comm.rank;
  return good;
}

static int ascending(const void *a, const void *b) {
  const uint64_t p = *(const uint64_t *)a, q = *(const uint64_t *)b;
  return p < q ? -1 : p > q;
}

/* Every id from `first` on is there once, and its state is what it was. */
static bool complete(const hc_particles *particles, const cloud *cloud, uint64_t first, uint64_t count) {
  bool good = true;
  for (int32_t k = 0; k < particles->own; k++) {
    const uint64_t id = particles->id[k];
    for (int axis = 0; axis < 3; axis++) {
      good &= particles->position[3 * k + axis] == position_of(cloud, id, axis);
      if (particles->velocity) good &= particles->velocity[3 * k + axis] == (double)mix(id + (uint64_t)axis);
    }
    if (particles->volume) good &= particles->volume[k] == (float)(id % 1000);
  }
  void *all;
  size_t bytes;
  hc_comm_gather_all(&comm, particles->id, (size_t)particles->own * sizeof(uint64_t), &all, &bytes);
  uint64_t *ids = all;
  good &= bytes == count * sizeof *ids;
  qsort(ids, bytes / sizeof *ids, sizeof *ids, ascending);
  for (uint64_t k = 0; good && k < count; k++) good = ids[k] == first + k;
  hc_free(all);
  return good;
}

/* The largest weight of a brick, over all ranks' particles. */
static int64_t heaviest_brick(const cloud *cloud) {
  hc_cells bricks;
  hc_cells_init(&bricks);
  int64_t heaviest = 0;
  for (int kind = 0; kind < 2; kind++) {
    const uint64_t first = kind ? FIRST_BOUNDARY : 0, count = kind ? cloud->boundary : cloud->fluid;
    for (uint64_t id = first; id < first + count; id++) {
      int64_t position[3];
      for (int axis = 0; axis < 3; axis++) position[axis] = position_of(cloud, id, axis);
      hc_brick brick;
      hc_cell_of(position, &brick);
      const int32_t index = hc_cells_insert(&bricks, brick); /* may move the counts */
      int32_t *weight = bricks.count[index];
      weight[0] += kind ? HC_COST_BOUNDARY : HC_COST_FLUID;
      if (weight[0] > heaviest) heaviest = weight[0];
    }
  }
  hc_cells_free(&bricks);
  return heaviest;
}

static void check_balance(const cloud *cloud, const hc_division *division) {
  int64_t load = HC_COST_FLUID * (int64_t)fluid.own + HC_COST_BOUNDARY * (int64_t)boundary.own, total = load,
          largest = load;
  hc_comm_sum_i64(&comm, &total, 1);
  hc_comm_max_i64(&comm, &largest, 1);
  const double mean = (double)total / comm.size, brick = (double)heaviest_brick(cloud);
  if (division->divider == HC_DIVIDER_SLABS)
    EXPECT((double)load <= mean + brick && (double)load >= mean - brick);
  EXPECT((double)load <= 1.05 * mean + brick);
  const double reached = (double)largest / mean;
  EXPECT(division->after >= reached * (1 - 1e-12) && division->after <= reached * (1 + 1e-12));
}

static const cloud clouds[] = {
    {{40, 20, 12}, {0, 0, 0}, 3000, 800},     {{12, 80, 8}, {-1000, 7, 12345678}, 2000, 0},
    {{8, 12, 60}, {-5, -5, -5}, 0, 2500},     {{30, 30, 30}, {1 << 29, -(1 << 29), 1}, 2500, 100},
    {{2000000000, 5, 5}, {0, 0, 0}, 300, 40}, /* the particles far from each other */
    {{1, 1, 1}, {2, 2, 2}, 500, 20},          /* one brick */
    {{12, 1, 1}, {2, 2, 2}, 500, 20},         /* fewer bricks than ranks */
};

START_TEST(rank_0_owns_the_world_at_first) {
  check_owners();
  EXPECT(hc_domain_owner(&domain, (const int64_t[]){5, -5, (int64_t)1 << 33}) == 0);
  spread(&clouds[0], 1);
  hc_domain_migrate(&domain, &fluid);
  EXPECT(fluid.own == (comm.rank == 0 ? 3000 : 0));
}
END_TEST

/* Divides a cloud's particles, wherever they are, and moves them; checks all of it. */
static void divide_and_check(const cloud *cloud, hc_divider divider) {
  int64_t holds = HC_COST_FLUID * (int64_t)fluid.own + HC_COST_BOUNDARY * (int64_t)boundary.own, held = holds;
  hc_comm_max_i64(&comm, &holds, 1);
  hc_comm_sum_i64(&comm, &held, 1);
  const hc_division division = balance(divider);
  EXPECT(division.divider == divider);
  const double before = (double)holds * comm.size / (double)held;
  EXPECT(fabs(division.before - before) <= 1e-12 * before);
  check_owners();
  int64_t leaving[2] = {0, 0};
  for (int32_t k = 0; k < fluid.own; k++) leaving[0] += owner_at(&fluid.position[3 * k]) != comm.rank;
  for (int32_t k = 0; k < boundary.own; k++) leaving[1] += owner_at(&boundary.position[3 * k]) != comm.rank;
  EXPECT(hc_domain_migrate(&domain, &fluid) == leaving[0]);
  EXPECT(hc_domain_migrate(&domain, &boundary) == leaving[1]);
  hc_comm_sum_i64(&comm, leaving, 2);
  EXPECT(division.moving == leaving[0] + leaving[1]);
  EXPECT(at_home(&fluid) && at_home(&boundary));
  EXPECT(complete(&fluid, cloud, 0, cloud->fluid));
  EXPECT(complete(&boundary, cloud, FIRST_BOUNDARY, cloud->boundary));
  check_balance(cloud, &division);
}

START_TEST(clouds_are_balanced_and_migrate) {
  for (size_t c = 0; c < sizeof clouds / sizeof *clouds; c++) {
    const cloud *cloud = &clouds[c];
    spread(cloud, c);
    divide_and_check(cloud, HC_DIVIDER_SLABS);
    int64_t most = fluid.own;
    hc_comm_max_i64(&comm, &most, 1);
    const double imbalance = cloud->fluid ? (double)most * comm.size / (double)cloud->fluid : 1.0;
    EXPECT(fabs(hc_domain_imbalance(&domain, &fluid) - imbalance) <= 1e-12 * imbalance);
    divide_and_check(cloud, HC_DIVIDER_METIS);
    EXPECT(hc_domain_migrate(&domain, &fluid) == 0 && hc_domain_migrate(&domain, &boundary) == 0);
    EXPECT(complete(&fluid, cloud, 0, cloud->fluid));
    const int32_t bits = domain.map.bits;
    const hc_division again = balance(HC_DIVIDER_METIS); /* the same parts, and the same numbers for them */
    EXPECT(again.moving == 0 || again.bits != bits);
    divide_and_check(cloud, HC_DIVIDER_SLABS);
  }
}
END_TEST

static uint64_t digest_of_map(void) {
  uint64_t digest = mix((uint64_t)domain.map.order * 8 + (uint64_t)domain.map.bits);
  for (int32_t k = 0; k < domain.map.count; k++) {
    const hc_interval *interval = &domain.map.intervals[k];
    for (int axis = 0; axis < 3; axis++) digest = mix(digest + (uint32_t)interval->first.x[axis]);
    digest = mix(digest + (uint64_t)interval->rank);
  }
  return digest;
}

/* Slabs follow from the particles and the size of bricks, not from who holds them (on which the size depends
 * where ranks share bricks); parts by METIS may have other numbers. */
START_TEST(divisions_are_deterministic) {
  for (size_t c = 0; c < sizeof clouds / sizeof *clouds; c++) {
    uint64_t slabs = 0;
    int32_t intervals = 0, bits = -1;
    double imbalance[2] = {0, 0};
    for (uint64_t seed = 0; seed < 4; seed++) {
      spread(&clouds[c], seed);
      const hc_division cut = balance(HC_DIVIDER_SLABS);
      EXPECT(same_on_all_ranks(digest_of_map()));
      EXPECT(bits != cut.bits || (digest_of_map() == slabs && cut.after == imbalance[0]));
      EXPECT(domain.map.count <= comm.size && domain.map.count == cut.intervals);
      slabs = digest_of_map();
      imbalance[0] = cut.after;
      const hc_division parts = balance(HC_DIVIDER_METIS);
      EXPECT(same_on_all_ranks(digest_of_map()));
      EXPECT(bits != parts.bits || (parts.after == imbalance[1] && parts.intervals == intervals));
      imbalance[1] = parts.after;
      intervals = parts.intervals;
      bits = parts.bits;
    }
  }
}
END_TEST

START_TEST(slabs_are_cut_along_the_longest_axis) {
  for (int c = 0; c < 3; c++) {
    spread(&clouds[c], 5);
    balance(HC_DIVIDER_SLABS);
    EXPECT((int)domain.map.order == c);
  }
}
END_TEST

/* Each particle flies somewhere else in the world, several times. */
START_TEST(fast_particles_reach_any_rank) {
  cloud moving = clouds[0];
  spread(&moving, 3);
  for (int64_t step = 1; step < 6; step++) {
    balance(step % 2 ? HC_DIVIDER_METIS : HC_DIVIDER_SLABS);
    hc_domain_migrate(&domain, &fluid);
    moving.cells[0] = 40 + 30 * step;
    moving.centre[0] = (step % 2 ? 40 : -40) * step;
    for (int32_t k = 0; k < fluid.own; k++)
      for (int axis = 0; axis < 3; axis++)
        fluid.position[3 * k + axis] = position_of(&moving, fluid.id[k], axis);
    hc_domain_migrate(&domain, &fluid);
    EXPECT(at_home(&fluid));
    EXPECT(complete(&fluid, &moving, 0, moving.fluid));
  }
}
END_TEST

START_TEST(there_may_be_no_particles) {
  const cloud nothing = {{1, 1, 1}, {0, 0, 0}, 0, 0};
  spread(&nothing, 0);
  EXPECT(hc_domain_imbalance(&domain, &fluid) == 1.0);
  for (int divider = HC_DIVIDER_SLABS; divider <= HC_DIVIDER_METIS; divider++) {
    spread(&nothing, 0);
    EXPECT(balance((hc_divider)divider).after == 1.0);
    check_owners();
    EXPECT(hc_domain_migrate(&domain, &fluid) == 0 && fluid.own == 0);
    const cloud one = {{1, 1, 1}, {-900, 0, 0}, 1, 0};
    spread(&one, 0);
    EXPECT(balance((hc_divider)divider).after == comm.size);
    hc_domain_migrate(&domain, &fluid);
    EXPECT(complete(&fluid, &one, 0, 1) && at_home(&fluid));
  }
}
END_TEST

/* A rank that its particles keep busy longer than others gives some away; noise is not believed in full. */
START_TEST(measured_work_weighs) {
  if (comm.size == 1) return;
  spread(&clouds[0], 1);
  hc_work work = {.fluid = &fluid, .boundary = &boundary};
  for (int divider = HC_DIVIDER_SLABS; divider <= HC_DIVIDER_METIS; divider++) {
    work.busy = 0.0;
    hc_domain_balance(&domain, (hc_divider)divider, &work, NULL);
    hc_domain_migrate(&domain, &fluid);
    hc_domain_migrate(&domain, &boundary);
    const int32_t before = fluid.own;
    work.busy = comm.rank == 0 ? 1000.0 : 1.0;
    hc_division division;
    hc_domain_balance(&domain, (hc_divider)divider, &work, &division);
    EXPECT(division.before > 1.2 && division.before < 2.3);
    hc_domain_migrate(&domain, &fluid);
    hc_domain_migrate(&domain, &boundary);
    EXPECT(comm.rank != 0 || fluid.own < 0.95 * before);
    EXPECT(complete(&fluid, &clouds[0], 0, clouds[0].fluid));
  }
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("domain");
  tcase_add_checked_fixture(tests, setup, teardown);
  tcase_set_timeout(tests, 100);
  tcase_add_test(tests, rank_0_owns_the_world_at_first);
  tcase_add_test(tests, clouds_are_balanced_and_migrate);
  tcase_add_test(tests, divisions_are_deterministic);
  tcase_add_test(tests, slabs_are_cut_along_the_longest_axis);
  tcase_add_test(tests, fast_particles_reach_any_rank);
  tcase_add_test(tests, there_may_be_no_particles);
  tcase_add_test(tests, measured_work_weighs);
  return run_mpi_tests("domain", tests);
}
