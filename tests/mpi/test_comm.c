/* The communicator: sums that know no order, agreement on errors, gathers and exchanges. */
#include "mpi_test.h"

#include "base/memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

START_TEST(ranks_are_what_the_launcher_said) {
  EXPECT(comm.rank >= 0 && comm.rank < comm.size);
  EXPECT(comm.size == 1 || hc_comm_launched_rank() == comm.rank);
  EXPECT(hc_comm_machine_ranks(&comm, 0) == comm.size); /* tests run on one machine */
  EXPECT(hc_comm_machine_ranks(&comm, comm.rank % 2) == (comm.size + !(comm.rank % 2)) / 2);
}
END_TEST

/* A finite double of any sign and exponent. */
static double term_of(uint64_t k) {
  uint64_t bits = mix(k);
  if ((bits >> 52 & 0x7ff) >= 0x7f0) bits ^= (uint64_t)0x400 << 52;
  double value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

START_TEST(exact_sums_know_no_distribution) {
  enum { TERMS = 3000 };
  hc_sum whole[HC_COMM_MAX_SUMS], shared[HC_COMM_MAX_SUMS];
  for (int count = 1; count <= HC_COMM_MAX_SUMS; count += 7)
    for (uint64_t seed = 0; seed < 4; seed++) { /* seed 3: all terms on one rank */
      memset(whole, 0, sizeof whole);
      memset(shared, 0, sizeof shared);
      for (int k = 0; k < count * TERMS; k++) {
        const int owner =
            seed == 3 ? comm.size / 2 : (int)(mix(seed * 100000 + (uint64_t)k) % (uint64_t)comm.size);
        hc_sum_add(&whole[k % count], term_of((uint64_t)k));
        if (owner == comm.rank) hc_sum_add(&shared[k % count], term_of((uint64_t)k));
      }
      hc_comm_sum_exact(&comm, shared, count);
      bool good = true;
      for (int s = 0; s < count; s++) {
        good &= hc_sum_value(&shared[s]) == hc_sum_value(&whole[s]);
        hc_sum_carry(&shared[s]);
        hc_sum_carry(&whole[s]);
      }
      EXPECT(good && memcmp(shared, whole, (size_t)count * sizeof *whole) == 0);
    }
}
END_TEST

START_TEST(exact_sums_take_open_carries_and_flags) {
  hc_sum sum;
  memset(&sum, 0, sizeof sum);
  const double full = 0xffffffffp-50; /* fills a limb to the brim */
  hc_sum_add(&sum, full);
  for (int k = 0; k < HC_SUM_LIMBS; k++) sum.word[k] *= 1 << 30; /* as many waiting carries as there may be */
  hc_comm_sum_exact(&comm, &sum, 1);
  EXPECT(hc_sum_value(&sum) == comm.size * 0x1p30 * full);
  memset(&sum, 0, sizeof sum);
  hc_sum_add(&sum, comm.rank == comm.size - 1 ? NAN : 1.0);
  hc_comm_sum_exact(&comm, &sum, 1);
  EXPECT(isnan(hc_sum_value(&sum)));
}
END_TEST

START_TEST(reductions_are_element_by_element) {
  const int r = comm.rank, last = comm.size - 1;
  double high[3] = {r, -r, 0.5}, low[3] = {r, -r, 0.5};
  int64_t most[2] = {r, -r}, least[2] = {r, -r}, sum[2] = {1, (int64_t)r << 40};
  hc_comm_max_f64(&comm, high, 3);
  hc_comm_min_f64(&comm, low, 3);
  hc_comm_max_i64(&comm, most, 2);
  hc_comm_min_i64(&comm, least, 2);
  hc_comm_sum_i64(&comm, sum, 2);
  EXPECT(high[0] == last && high[1] == 0 && high[2] == 0.5);
  EXPECT(low[0] == 0 && low[1] == -last && low[2] == 0.5);
  EXPECT(most[0] == last && most[1] == 0 && least[0] == 0 && least[1] == -last);
  EXPECT(sum[0] == comm.size && sum[1] == (int64_t)last * comm.size / 2 << 40);
}
END_TEST

START_TEST(the_lowest_rank_with_an_error_speaks) {
  for (unsigned failing = 0; failing < 1u << comm.size; failing++) {
    if (comm.size > 4 && mix(failing) % 4 != 0) continue;
    hc_error error = {.status = HC_OK, .text = ""};
    if (failing >> comm.rank & 1)
      hc_error_set(&error, comm.rank % 2 ? HC_IO_FAILED : HC_BAD_INPUT, "rank %d fails in round %u",
                   comm.rank, failing);
    const hc_status status = hc_comm_agree(&comm, &error);
    int lowest = 0;
    while (lowest < comm.size && !(failing >> lowest & 1)) lowest++;
    if (lowest == comm.size) {
      EXPECT(status == HC_OK && error.status == HC_OK);
      continue;
    }
    char text[80];
    snprintf(text, sizeof text, "rank %d fails in round %u", lowest, failing);
    EXPECT(status == (lowest % 2 ? HC_IO_FAILED : HC_BAD_INPUT) && error.status == status);
    EXPECT(strcmp(error.text, text) == 0);
  }
}
END_TEST

/* The tests below run with messages whole and in parts: some fit, some fill a part to the last byte. */
static const size_t part_limits[] = {1 << 30, 1, 3, 8, 100};
enum { PART_LIMITS = sizeof part_limits / sizeof *part_limits };

START_TEST(every_rank_may_broadcast) {
  hc_comm_set_part_limit(&comm, part_limits[_i]);
  for (int root = 0; root < comm.size; root++) {
    uint64_t data[100];
    for (int k = 0; k < 100; k++) data[k] = comm.rank == root ? mix((uint64_t)(k + 1000 * root)) : 0;
    hc_comm_broadcast(&comm, data, sizeof data, root);
    bool good = true;
    for (int k = 0; k < 100; k++) good &= data[k] == mix((uint64_t)(k + 1000 * root));
    EXPECT(good);
  }
  hc_comm_barrier(&comm);
}
END_TEST

START_TEST(prefixes_are_over_the_ranks_below) {
  for (int round = 0; round < 5; round++) {
    int64_t below = 0;
    for (int rank = 0; rank < comm.rank; rank++) below += (int64_t)(mix((uint64_t)(rank + 10 * round)) >> 8);
    EXPECT(hc_comm_prefix_i64(&comm, (int64_t)(mix((uint64_t)(comm.rank + 10 * round)) >> 8)) == below);
  }
}
END_TEST

static unsigned char byte_of(int round, int from, int to, size_t k) {
  return (unsigned char)mix(((uint64_t)round * 64 + (uint64_t)from) * 64 + (uint64_t)to +
                            ((uint64_t)k << 32));
}

static size_t length_of(int round, int from, int to) {
  const uint64_t bits = mix(((uint64_t)round << 20) + (uint64_t)(from * 64 + to));
  return bits % 5 == 0   ? 0
         : bits % 7 == 0 ? (comm.part_limit < 20000 ? 800 : 20000)
                         : bits % 300; /* short ones may be sent eagerly, long ones not */
}

static char *content_of(int round, int from, int to, size_t *bytes) {
  *bytes = length_of(round, from, to);
  char *data = hc_alloc(*bytes, 1);
  for (size_t k = 0; k < *bytes; k++) data[k] = (char)byte_of(round, from, to, k);
  return data;
}

static bool holds(const void *data, size_t bytes, int round, int from, int to) {
  bool good = bytes == length_of(round, from, to);
  for (size_t k = 0; good && k < bytes; k++)
    good = ((const unsigned char *)data)[k] == byte_of(round, from, to, k);
  return good;
}

/* Are these everybody's blocks of a round? */
static bool holds_all(const char *all, size_t total, int round) {
  bool good = true;
  size_t expected = 0;
  for (int rank = 0; rank < comm.size; rank++) {
    const size_t length = length_of(round, rank, 0);
    good &= expected + length <= total && holds(all + expected, length, round, rank, 0);
    expected += length;
  }
  return good && total == expected;
}

START_TEST(blocks_are_gathered_in_rank_order) {
  hc_comm_set_part_limit(&comm, part_limits[_i]);
  for (int round = 0; round < 20; round++) {
    size_t bytes, total;
    char *mine = content_of(round, comm.rank, 0, &bytes);
    void *all;
    hc_comm_gather_all(&comm, mine, bytes, &all, &total);
    EXPECT(holds_all(all, total, round));
    hc_free(all);
    const int root = round % comm.size;
    hc_comm_gather(&comm, mine, bytes, root, &all, &total);
    EXPECT(comm.rank == root ? holds_all(all, total, round) : !all && total == 0);
    hc_free(all);
    hc_free(mine);
  }
  const double mine[2] = {comm.rank, -1.5 * comm.rank};
  double *all = hc_alloc(2 * (size_t)comm.size, sizeof *all);
  hc_comm_gather_all_f64(&comm, mine, 2, all);
  bool good = true;
  for (int rank = 0; rank < comm.size; rank++)
    good &= all[2 * rank] == rank && all[2 * rank + 1] == -1.5 * rank;
  EXPECT(good);
  hc_free(all);
}
END_TEST

/* Who sends to whom in a round: a third of all pairs, everybody, nobody, or all to one. */
static bool sends(int round, int from, int to) {
  switch (round % 8) {
  case 0:
    return true;
  case 1:
    return false;
  case 2:
    return to == round % comm.size;
  case 3:
    return from == to;
  case 4:
    return from == round % comm.size;
  default:
    return mix((uint64_t)(round * 4096 + from * 64 + to)) % 3 == 0;
  }
}

/* Many rounds in a row with no other call between them: a fast rank runs ahead of a slow one. */
START_TEST(sparse_exchanges_deliver_what_was_sent) {
  hc_comm_set_part_limit(&comm, part_limits[_i]);
  hc_message *out = hc_alloc((size_t)comm.size, sizeof *out);
  bool good = true;
  for (int round = 0; round < 120; round++) {
    int out_count = 0;
    for (int k = 0; k < comm.size; k++) { /* in no particular order */
      const int to = (k * (comm.size - 1) + round) % comm.size;
      if (!sends(round, comm.rank, to)) continue;
      out[out_count].rank = to;
      out[out_count].data = content_of(round, comm.rank, to, &out[out_count].bytes);
      out_count++;
    }
    if (mix((uint64_t)(round * 64 + comm.rank)) % 40 == 0) usleep(2000); /* some are late */
    hc_message *in;
    int in_count;
    hc_comm_sparse(&comm, out, out_count, &in, &in_count);
    int next = 0;
    for (int from = 0; from < comm.size; from++) {
      if (!sends(round, from, comm.rank)) continue;
      good &= next < in_count && in[next].rank == from &&
              holds(in[next].data, in[next].bytes, round, from, comm.rank);
      next++;
    }
    good &= next == in_count;
    hc_messages_free(in, in_count);
    for (int k = 0; k < out_count; k++) hc_free(out[k].data);
  }
  hc_free(out);
  EXPECT(good);
}
END_TEST

/* One exchange with all partners of a round. */
typedef struct partners {
  hc_exchange exchange;
  hc_message *send, *receive;
  MPI_Request *requests;
} partners;

static void partners_make(partners *p, int round) {
  const size_t ranks = (size_t)comm.size;
  p->send = hc_alloc(ranks, sizeof *p->send);
  p->receive = hc_alloc(ranks, sizeof *p->receive);
  p->requests = hc_alloc(2 * ranks, sizeof(MPI_Request));
  int sent = 0, received = 0;
  for (int rank = 0; rank < comm.size; rank++) {
    if (sends(round, comm.rank, rank)) {
      hc_message *to = &p->send[sent++];
      to->rank = rank;
      to->data = content_of(round, comm.rank, rank, &to->bytes);
    }
    if (sends(round, rank, comm.rank)) {
      hc_message *from = &p->receive[received++];
      const size_t bytes = length_of(round, rank, comm.rank);
      *from = (hc_message){rank, bytes, hc_alloc_zero(bytes, 1)};
    }
  }
  p->exchange = (hc_exchange){sent, received, p->send, p->receive, p->requests, NULL, 0};
}

static bool partners_hold(const partners *p, int round) {
  bool good = true;
  for (int k = 0; k < p->exchange.receive_count; k++)
    good &= holds(p->receive[k].data, p->receive[k].bytes, round, p->receive[k].rank, comm.rank);
  return good;
}

static void partners_free(partners *p) {
  for (int k = 0; k < p->exchange.send_count; k++) hc_free(p->send[k].data);
  for (int k = 0; k < p->exchange.receive_count; k++) hc_free(p->receive[k].data);
  hc_free(p->send);
  hc_free(p->receive);
  hc_free(p->requests);
}

START_TEST(known_partners_exchange_again_and_again) {
  hc_comm_set_part_limit(&comm, part_limits[_i]);
  bool good = true;
  for (int round = 0; round < 16; round++) {
    partners p;
    partners_make(&p, round);
    for (int again = 0; again < 3; again++) {
      for (int k = 0; k < p.exchange.receive_count; k++) memset(p.receive[k].data, 0, p.receive[k].bytes);
      hc_comm_exchange_begin(&comm, &p.exchange, again);
      hc_comm_exchange_end(&comm, &p.exchange);
      good &= partners_hold(&p, round) && p.exchange.pending == 0;
    }
    partners_free(&p);
  }
  EXPECT(good);
}
END_TEST

/* Two at a time, told apart by their tags, with other calls in between. */
START_TEST(exchanges_may_overlap) {
  hc_comm_set_part_limit(&comm, part_limits[_i]);
  partners first, second;
  partners_make(&first, 0);
  partners_make(&second, 8);
  hc_comm_exchange_begin(&comm, &first.exchange, 1);
  hc_comm_exchange_begin(&comm, &second.exchange, 2);
  hc_message *in;
  int in_count;
  hc_comm_sparse(&comm, NULL, 0, &in, &in_count);
  const bool none = in_count == 0;
  hc_messages_free(in, in_count);
  hc_comm_exchange_end(&comm, &second.exchange);
  const bool good = partners_hold(&second, 8);
  hc_comm_exchange_end(&comm, &first.exchange);
  EXPECT(none && good && partners_hold(&first, 0));
  partners_free(&first);
  partners_free(&second);
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("comm");
  tcase_set_timeout(tests, 100);
  tcase_add_test(tests, ranks_are_what_the_launcher_said);
  tcase_add_test(tests, exact_sums_know_no_distribution);
  tcase_add_test(tests, exact_sums_take_open_carries_and_flags);
  tcase_add_test(tests, reductions_are_element_by_element);
  tcase_add_test(tests, the_lowest_rank_with_an_error_speaks);
  tcase_add_loop_test(tests, every_rank_may_broadcast, 0, PART_LIMITS);
  tcase_add_test(tests, prefixes_are_over_the_ranks_below);
  tcase_add_loop_test(tests, blocks_are_gathered_in_rank_order, 0, PART_LIMITS);
  tcase_add_loop_test(tests, sparse_exchanges_deliver_what_was_sent, 0, PART_LIMITS);
  tcase_add_loop_test(tests, known_partners_exchange_again_and_again, 0, PART_LIMITS);
  tcase_add_loop_test(tests, exchanges_may_overlap, 0, PART_LIMITS);
  return run_mpi_tests("comm", tests);
}
