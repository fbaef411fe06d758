/* Gathers of blocks of any size. MPI's own take blocks up to a part's limit together; beyond, rank by rank.
 */
#include "base/memory.h"
#include "calls.h"
#include "comm.h"

#include <string.h>

static void count_gather(hc_comm *comm, size_t bytes) {
  comm->other_collectives += 2;
  comm->gathered_bytes += (int64_t)bytes;
}

static void gather_all_small(hc_comm *comm, const void *mine, const int64_t *lengths, void *all) {
  const size_t ranks = (size_t)comm->size;
  int *counts = hc_alloc(ranks, sizeof *counts), *begins = hc_alloc(ranks, sizeof *begins);
  int total = 0;
  for (size_t rank = 0; rank < ranks; rank++) {
    counts[rank] = (int)lengths[rank];
    begins[rank] = total;
    total += counts[rank];
  }
  CHECK_MPI(MPI_Allgatherv(mine, counts[comm->rank], MPI_BYTE, all, counts, begins, MPI_BYTE, comm->mpi));
  hc_free(counts);
  hc_free(begins);
}

static void gather_all_large(hc_comm *comm, const void *mine, const int64_t *lengths, void *all) {
  char *place = all;
  for (int rank = 0; rank < comm->size; rank++) {
    const size_t length = (size_t)lengths[rank];
    if (rank == comm->rank && length > 0) memcpy(place, mine, length);
    hc_calls_broadcast(comm, place, length, rank);
    place += length;
  }
}

void hc_comm_gather_all(hc_comm *comm, const void *mine, size_t bytes, void **all, size_t *total) {
  const hc_visit start = hc_calls_enter(comm);
  const size_t ranks = (size_t)comm->size;
  int64_t *lengths = hc_alloc(ranks, sizeof *lengths);
  const int64_t length = (int64_t)bytes;
  CHECK_MPI(MPI_Allgather(&length, 1, MPI_INT64_T, lengths, 1, MPI_INT64_T, comm->mpi));
  *total = 0;
  for (size_t rank = 0; rank < ranks; rank++) *total += (size_t)lengths[rank];
  *all = hc_alloc(*total, 1);
  (*total <= hc_comm_part_limit(comm) ? gather_all_small : gather_all_large)(comm, mine, lengths, *all);
  hc_free(lengths);
  count_gather(comm, *total + ranks * sizeof length);
  hc_calls_leave(comm, start);
}

/* Takes the small blocks from `together` and receives the large ones. */
static void spread(hc_comm *comm, const void *mine, const int64_t *lengths, size_t share,
                   const char *together, char *all) {
  for (int rank = 0; rank < comm->size; rank++) {
    const size_t length = (size_t)lengths[rank];
    if (length > share && rank != comm->rank) {
      hc_calls_receive(comm, all, length, 0, rank, TAG_GATHER);
    } else if (length > 0) {
      memcpy(all, length > share ? mine : together, length);
      if (length <= share) together += length;
    }
    all += length;
  }
}

/* The root's side: blocks up to `share` come together, larger ones by themselves. */
static void gather_here(hc_comm *comm, const void *mine, const int64_t *lengths, size_t share, char *all) {
  const size_t ranks = (size_t)comm->size;
  int *counts = hc_alloc(ranks, sizeof *counts), *begins = hc_alloc(ranks, sizeof *begins);
  size_t small = 0, total = 0;
  for (size_t rank = 0; rank < ranks; rank++) {
    counts[rank] = (size_t)lengths[rank] <= share ? (int)lengths[rank] : 0;
    begins[rank] = (int)small;
    small += (size_t)counts[rank];
    total += (size_t)lengths[rank];
  }
  char *together = small == total ? all : hc_alloc(small, 1);
  CHECK_MPI(MPI_Gatherv(mine, counts[comm->rank], MPI_BYTE, together, counts, begins, MPI_BYTE, comm->rank,
                        comm->mpi));
  if (together != all) {
    spread(comm, mine, lengths, share, together, all);
    hc_free(together);
  }
  hc_free(counts);
  hc_free(begins);
}

static void gather_there(hc_comm *comm, const void *mine, size_t bytes, size_t share, int root) {
  const bool small = bytes <= share;
  CHECK_MPI(MPI_Gatherv(mine, small ? (int)bytes : 0, MPI_BYTE, NULL, NULL, NULL, MPI_BYTE, root, comm->mpi));
  if (!small) hc_calls_send(comm, mine, bytes, root, TAG_GATHER);
}

void hc_comm_gather(hc_comm *comm, const void *mine, size_t bytes, int root, void **all, size_t *total) {
  const hc_visit start = hc_calls_enter(comm);
  const size_t ranks = comm->rank == root ? (size_t)comm->size : 0;
  const size_t share = hc_comm_part_limit(comm) / (size_t)comm->size; /* who is over it knows it alone */
  int64_t *lengths = hc_alloc(ranks, sizeof *lengths);
  const int64_t length = (int64_t)bytes;
  CHECK_MPI(MPI_Gather(&length, 1, MPI_INT64_T, lengths, 1, MPI_INT64_T, root, comm->mpi));
  *total = 0;
  *all = NULL;
  for (size_t rank = 0; rank < ranks; rank++) *total += (size_t)lengths[rank];
  if (ranks) {
    *all = hc_alloc(*total, 1);
    gather_here(comm, mine, lengths, share, *all);
  } else {
    gather_there(comm, mine, bytes, share, root);
  }
  hc_free(lengths);
  count_gather(comm, *total + ranks * sizeof length);
  hc_calls_leave(comm, start);
}

void hc_comm_gather_all_f64(hc_comm *comm, const double *mine, int count, double *all) {
  const hc_visit start = hc_calls_enter(comm);
  CHECK_MPI(MPI_Allgather(mine, count, MPI_DOUBLE, all, count, MPI_DOUBLE, comm->mpi));
  comm->other_collectives++;
  comm->gathered_bytes += (int64_t)((size_t)comm->size * (size_t)count * sizeof *all);
  hc_calls_leave(comm, start);
}
