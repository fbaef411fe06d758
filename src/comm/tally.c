#include "tally.h"

#include "base/check.h"
#include "base/memory.h"
#include "calls.h"

#include <string.h>

static void note(hc_tally *tally, hc_tally_kind kind, void *values, int count) {
  if (count == 0) return;
  HC_CHECK(tally->count < HC_TALLY_MOST, "a tally has room for %d entries", HC_TALLY_MOST);
  tally->entry[tally->count].kind = kind;
  tally->entry[tally->count].count = count;
  tally->entry[tally->count++].values = values;
}

void hc_tally_sum_exact(hc_tally *tally, hc_sum *sums, int count) {
  note(tally, HC_TALLY_SUM_EXACT, sums, count);
}
void hc_tally_sum_i64(hc_tally *tally, int64_t *values, int count) {
  note(tally, HC_TALLY_SUM_I64, values, count);
}
void hc_tally_max_i64(hc_tally *tally, int64_t *values, int count) {
  note(tally, HC_TALLY_MAX_I64, values, count);
}
void hc_tally_max_f64(hc_tally *tally, double *values, int count) {
  note(tally, HC_TALLY_MAX_F64, values, count);
}

/* Turns bits of doubles into integers of the same order, and back. */
static int64_t ordered(int64_t bits) {
  return bits ^ (int64_t)((uint64_t)(bits >> 63) >> 1);
}

static int words_of(const hc_tally *tally, int entry) {
  const int count = tally->entry[entry].count;
  return tally->entry[entry].kind == HC_TALLY_SUM_EXACT ? count * HC_SUM_WORDS : count;
}

static bool is_sum(const hc_tally *tally, int entry) {
  return tally->entry[entry].kind == HC_TALLY_SUM_EXACT || tally->entry[entry].kind == HC_TALLY_SUM_I64;
}

static void turn(int64_t *words, int count) {
  for (int k = 0; k < count; k++) words[k] = ordered(words[k]);
}

/* Copies the values of all sums, or of all maxima, to `words`; returns how many. */
static int take(const hc_tally *tally, bool sums, int64_t *words) {
  int taken = 0;
  for (int entry = 0; entry < tally->count; entry++) {
    if (is_sum(tally, entry) != sums) continue;
    void *values = tally->entry[entry].values;
    if (tally->entry[entry].kind == HC_TALLY_SUM_EXACT)
      for (int k = 0; k < tally->entry[entry].count; k++) hc_sum_carry((hc_sum *)values + k);
    const int count = words_of(tally, entry);
    memcpy(words + taken, values, (size_t)count * sizeof *words);
    if (tally->entry[entry].kind == HC_TALLY_MAX_F64) turn(words + taken, count);
    taken += count;
  }
  return taken;
}

/* The way back. */
static void give(const hc_tally *tally, bool sums, int64_t *words) {
  for (int entry = 0; entry < tally->count; entry++) {
    if (is_sum(tally, entry) != sums) continue;
    const int count = words_of(tally, entry);
    if (tally->entry[entry].kind == HC_TALLY_MAX_F64) turn(words, count);
    memcpy(tally->entry[entry].values, words, (size_t)count * sizeof *words);
    words += count;
  }
}

/* Combines blocks: the number of sums, the sums, the maxima. */
static void combine(void *from, void *to, int *blocks, MPI_Datatype *type) {
  int bytes = 0;
  CHECK_MPI(MPI_Type_size(*type, &bytes));
  const int64_t *a = from, words = bytes / (int64_t)sizeof *a;
  int64_t *b = to;
  for (int block = 0; block < *blocks; block++, a += words, b += words) {
    const int64_t maxima = 1 + b[0];
    for (int64_t k = 1; k < maxima; k++) b[k] = (int64_t)((uint64_t)a[k] + (uint64_t)b[k]);
    for (int64_t k = maxima; k < words; k++) b[k] = a[k] > b[k] ? a[k] : b[k];
  }
}

/* A block is of a type of its own, so that MPI does not split it. */
static void reduce(hc_comm *comm, int64_t *block, int words) {
  if (comm->size == 1) return;
  const hc_visit start = hc_calls_enter(comm);
  MPI_Datatype type;
  MPI_Op operation;
  CHECK_MPI(MPI_Type_contiguous(words, MPI_INT64_T, &type));
  CHECK_MPI(MPI_Type_commit(&type));
  CHECK_MPI(MPI_Op_create(combine, true, &operation));
  CHECK_MPI(MPI_Allreduce(MPI_IN_PLACE, block, 1, type, operation, comm->mpi));
  CHECK_MPI(MPI_Op_free(&operation));
  CHECK_MPI(MPI_Type_free(&type));
  comm->reductions++;
  hc_calls_leave(comm, start);
}

void hc_tally_reduce(hc_comm *comm, hc_tally *tally) {
  int room = 0;
  for (int entry = 0; entry < tally->count; entry++) room += words_of(tally, entry);
  if (room == 0) return;
  int64_t *block = hc_alloc((size_t)room + 1, sizeof *block);
  const int sums = take(tally, true, block + 1);
  block[0] = sums;
  take(tally, false, block + 1 + sums);
  reduce(comm, block, room + 1);
  give(tally, true, block + 1);
  give(tally, false, block + 1 + sums);
  hc_free(block);
  tally->count = 0;
}
