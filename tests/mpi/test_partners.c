/* Exchanges among partners against sparse ones, while particles drift, are thrown out, and leave ranks empty.
 */
#include "halo_world.h"

enum { ROUNDS = 24, NEAR = 27 };

static uint64_t dice(int round, uint64_t id, int axis) {
  return mix((uint64_t)round * 1000003 + id * 31 + (uint64_t)axis);
}

/* Up to a cell along each axis; in some rounds one particle far away, or all that a rank has to one place. */
static void move(world *w, int round) {
  const bool emptied = round % 8 == 5 && comm.rank % 2 == 0;
  for (int32_t k = 0; k < w->particles.own; k++)
    for (int axis = 0; axis < 3; axis++) {
      const uint64_t id = w->particles.id[k], bits = dice(round, id, axis);
      int64_t x = w->particles.position[3 * k + axis] + (int64_t)(bits % (2 * HC_CELL_UNITS)) - HC_CELL_UNITS;
      if (round % 8 == 3 && id == (uint64_t)round) x += 100 * HC_CELL_UNITS;
      if (emptied) x = w->frame.low[axis] + HC_CELL_UNITS / 2;
      w->particles.position[3 * k + axis] = hc_frame_wrap(&w->frame, axis, x);
    }
}

/* The owners of the cells around a particle's, each once. */
static int owners_near(const world *w, int32_t k, int32_t owners[NEAR]) {
  int count = 0;
  for (int way = 0; way < NEAR; way++) {
    const int64_t step[3] = {way % 3 - 1, way / 3 % 3 - 1, way / 9 - 1};
    int64_t cell[3];
    for (int axis = 0; axis < 3; axis++)
      cell[axis] = hc_frame_cell(
          hc_frame_wrap(&w->frame, axis, w->particles.position[3 * k + axis] + step[axis] * HC_CELL_UNITS));
    const int32_t owner = hc_domain_owner(&w->domain, cell);
    bool found = false;
    for (int n = 0; n < count; n++) found |= owners[n] == owner;
    if (!found) owners[count++] = owner;
  }
  return count;
}

/* Messages of the ids of own particles to all who own a cell next to theirs, ourselves included. */
static int write_messages(const world *w, hc_message *out, uint64_t **ids) {
  *ids = hc_alloc((size_t)comm.size * (size_t)w->particles.own, sizeof **ids);
  int messages = 0;
  uint64_t *to = *ids;
  for (int rank = 0; rank < comm.size; rank++) {
    const uint64_t *begin = to;
    for (int32_t k = 0; k < w->particles.own; k++) {
      int32_t owners[NEAR];
      const int count = owners_near(w, k, owners);
      for (int n = 0; n < count; n++)
        if (owners[n] == rank) *to++ = w->particles.id[k];
    }
    if (to > begin) out[messages++] = (hc_message){rank, (size_t)(to - begin) * sizeof *to, (void *)begin};
  }
  return messages;
}

static bool same(const hc_message *a, int a_count, const hc_message *b, int b_count) {
  bool good = a_count == b_count;
  for (int m = 0; m < a_count && good; m++)
    good =
        a[m].rank == b[m].rank && a[m].bytes == b[m].bytes && memcmp(a[m].data, b[m].data, a[m].bytes) == 0;
  return good;
}

static bool exchanges_alike(world *w) {
  hc_message *out = hc_alloc((size_t)comm.size, sizeof *out), *among, *sparse;
  uint64_t *ids;
  int among_count, sparse_count;
  const int messages = write_messages(w, out, &ids);
  hc_domain_exchange(&w->domain, &w->particles, out, messages, &among, &among_count);
  hc_comm_sparse(&comm, out, messages, &sparse, &sparse_count);
  const bool good = same(among, among_count, sparse, sparse_count);
  hc_messages_free(among, among_count);
  hc_messages_free(sparse, sparse_count);
  hc_free(ids);
  hc_free(out);
  return good;
}

static bool all_at_home(const world *w) {
  for (int32_t k = 0; k < w->particles.own; k++) {
    int64_t cell[3];
    for (int axis = 0; axis < 3; axis++) cell[axis] = hc_frame_cell(w->particles.position[3 * k + axis]);
    if (hc_domain_owner(&w->domain, cell) != comm.rank) return false;
  }
  return true;
}

/* One round as a step does it; returns whether it went without a barrier. */
static bool do_round(world *w, int round, int32_t count) {
  move(w, round);
  int64_t outside = hc_domain_watch_partners(&w->domain);
  hc_comm_max_i64(&comm, &outside, 1);
  hc_domain_agree_partners(&w->domain, outside != 0);
  const bool among = w->domain.partners.agreed;
  const int64_t before = comm.sparse_exchanges;
  hc_domain_migrate(&w->domain, &w->particles);
  EXPECT(comm.size == 1 || comm.sparse_exchanges - before == !among);
  int64_t total = w->particles.own;
  hc_comm_sum_i64(&comm, &total, 1);
  EXPECT(total == count && all_at_home(w));
  EXPECT(exchanges_alike(w));
  hc_domain_settle_partners(&w->domain, &w->particles);
  return among;
}

/* How many rounds went without a barrier. */
static int do_rounds(const region *region, int bits) {
  world w;
  world_init(&w, region, HC_FLUID, 0);
  fill(&w, region);
  balance(&w, bits % 2 ? HC_DIVIDER_METIS : HC_DIVIDER_SLABS);
  if (bits > 0) divide_wildly(&w, bits - 1);
  hc_domain_migrate(&w.domain, &w.particles);
  hc_domain_settle_partners(&w.domain, &w.particles);
  int among = 0;
  for (int round = 0; round < ROUNDS; round++) among += do_round(&w, round, region->count);
  world_free(&w);
  return among;
}

START_TEST(partners_get_what_sparse_exchanges_bring) {
  for (int r = 0; r < REGIONS; r++)
    for (int bits = 0; bits < 4; bits++) do_rounds(&regions[r], bits);
}
END_TEST

/* In a closed box all of which is in reach, only what is thrown out asks for barriers. */
START_TEST(partners_last) {
  const region box = {{-4, 0, 0}, {12, 8, 8}, {1, 1, 1}, 3000};
  const int among = do_rounds(&box, 0);
  EXPECT(comm.size == 1 || among == ROUNDS);
}
END_TEST

START_TEST(messages_may_come_in_parts) {
  const size_t limit = comm.part_limit;
  hc_comm_set_part_limit(&comm, 100);
  do_rounds(&regions[0], 0);
  do_rounds(&regions[4], 0);
  comm.part_limit = limit;
}
END_TEST

/* Who is thrown out of reach is seen, and learning makes it right again. */
START_TEST(what_leaves_is_seen) {
  const region box = {{0, 0, 0}, {16, 4, 4}, {0}, 600};
  const int among = do_rounds(&box, 1);
  EXPECT(comm.size < 3 || (among > 0 && among < ROUNDS));
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("partners");
  tcase_set_timeout(tests, 100);
  tcase_add_test(tests, partners_get_what_sparse_exchanges_bring);
  tcase_add_test(tests, partners_last);
  tcase_add_test(tests, messages_may_come_in_parts);
  tcase_add_test(tests, what_leaves_is_seen);
  return run_mpi_tests("partners", tests);
}
