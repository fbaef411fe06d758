#include "comm.h"
#include "base/check.h"
#include "base/memory.h"
#include "base/timer.h"
#include "calls.h"
#include "ending.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

double hc_comm_busy_seconds(const hc_comm *comm) {
  return hc_work_seconds() - comm->spent_seconds;
}

void hc_comm_set_part_limit(hc_comm *comm, size_t bytes) {
  HC_CHECK(bytes > 0 && bytes <= INT_MAX, "a part must have 1 to %d bytes, got %zu", INT_MAX, bytes);
  comm->part_limit = bytes;
}

static void duplicate(hc_comm *comm, MPI_Comm given) {
  CHECK_MPI(MPI_Comm_dup(given, &comm->mpi));
  CHECK_MPI(MPI_Comm_set_errhandler(comm->mpi, MPI_ERRORS_RETURN));
  CHECK_MPI(MPI_Comm_rank(comm->mpi, &comm->rank));
  CHECK_MPI(MPI_Comm_size(comm->mpi, &comm->size));
  hc_check_set_rank(comm->rank);
  hc_ending_watch();
  comm->watches = true;
}

void hc_comm_start(hc_comm *comm, int *argc, char ***argv) {
  memset(comm, 0, sizeof *comm);
  int started = 0;
  CHECK_MPI(MPI_Initialized(&started));
  if (!started) {
    int level = 0;
    CHECK_MPI(MPI_Init_thread(argc, argv, MPI_THREAD_SINGLE, &level));
    comm->owns_mpi = true;
  }
  duplicate(comm, MPI_COMM_WORLD);
}

hc_status hc_comm_start_on(hc_comm *comm, const int *handle, hc_error *error) {
  int started = 0, ended = 0;
  CHECK_MPI(MPI_Initialized(&started));
  CHECK_MPI(MPI_Finalized(&ended));
  if (ended) return hc_error_set(error, HC_BAD_INPUT, "MPI has been ended, and cannot start a second time");
  if (!handle) {
    hc_comm_start(comm, NULL, NULL);
    return HC_OK;
  }
  memset(comm, 0, sizeof *comm);
  if (!started)
    return hc_error_set(error, HC_BAD_INPUT, "MPI must be started before a communicator is given");
  const MPI_Comm given = MPI_Comm_f2c(*handle);
  if (given == MPI_COMM_NULL)
    return hc_error_set(error, HC_BAD_INPUT,
                        "the communicator must not be MPI_COMM_NULL, nor an unknown handle");
  int between = 0;
  CHECK_MPI(MPI_Comm_test_inter(given, &between));
  if (between) return hc_error_set(error, HC_BAD_INPUT, "the communicator must not be an intercommunicator");
  duplicate(comm, given);
  return HC_OK;
}

void hc_comm_finish(hc_comm *comm) {
  if (comm->watches) hc_ending_unwatch();
  CHECK_MPI(MPI_Comm_free(&comm->mpi));
  if (comm->owns_mpi) CHECK_MPI(MPI_Finalize());
}

int hc_comm_launched_rank(void) {
  static const char *const variables[] = {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"};
  for (size_t k = 0; k < sizeof variables / sizeof *variables; k++) {
    const char *value = getenv(variables[k]);
    if (value) return atoi(value);
  }
  return 0;
}

int hc_comm_machine_ranks(hc_comm *comm, int group) {
  MPI_Comm machine, sharing;
  int count = 0;
  CHECK_MPI(MPI_Comm_split_type(comm->mpi, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine));
  CHECK_MPI(MPI_Comm_split(machine, group, 0, &sharing));
  CHECK_MPI(MPI_Comm_size(sharing, &count));
  CHECK_MPI(MPI_Comm_free(&sharing));
  CHECK_MPI(MPI_Comm_free(&machine));
  return count;
}

int hc_comm_machine_first(hc_comm *comm) {
  MPI_Comm machine;
  int first = comm->rank;
  CHECK_MPI(MPI_Comm_split_type(comm->mpi, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine));
  CHECK_MPI(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, machine));
  CHECK_MPI(MPI_Comm_free(&machine));
  return first;
}

hc_status hc_comm_agree(hc_comm *comm, hc_error *error) {
  int64_t first = error->status == HC_OK ? INT64_MAX : comm->rank;
  hc_comm_min_i64(comm, &first, 1);
  if (first == INT64_MAX) return HC_OK;
  hc_comm_broadcast(comm, error, sizeof *error, (int)first);
  return error->status;
}

void hc_comm_barrier(hc_comm *comm) {
  const hc_visit start = hc_calls_enter(comm);
  CHECK_MPI(MPI_Barrier(comm->mpi));
  comm->other_collectives++;
  hc_calls_leave(comm, start);
}

void hc_comm_broadcast(hc_comm *comm, void *data, size_t bytes, int root) {
  const hc_visit start = hc_calls_enter(comm);
  hc_calls_broadcast(comm, data, bytes, root);
  comm->other_collectives++;
  hc_calls_leave(comm, start);
}

static void reduce(hc_comm *comm, void *values, int count, MPI_Datatype type, MPI_Op operation) {
  if (comm->size == 1) return;
  const hc_visit start = hc_calls_enter(comm);
  CHECK_MPI(MPI_Allreduce(MPI_IN_PLACE, values, count, type, operation, comm->mpi));
  hc_calls_leave(comm, start);
  comm->reductions++;
}

void hc_comm_max_f64(hc_comm *comm, double *values, int count) {
  reduce(comm, values, count, MPI_DOUBLE, MPI_MAX);
}
void hc_comm_min_f64(hc_comm *comm, double *values, int count) {
  reduce(comm, values, count, MPI_DOUBLE, MPI_MIN);
}
void hc_comm_max_i64(hc_comm *comm, int64_t *values, int count) {
  reduce(comm, values, count, MPI_INT64_T, MPI_MAX);
}
void hc_comm_min_i64(hc_comm *comm, int64_t *values, int count) {
  reduce(comm, values, count, MPI_INT64_T, MPI_MIN);
}
void hc_comm_sum_i64(hc_comm *comm, int64_t *values, int count) {
  reduce(comm, values, count, MPI_INT64_T, MPI_SUM);
}

void hc_comm_sum_exact(hc_comm *comm, hc_sum *sums, int count) {
  HC_CHECK(count <= HC_COMM_MAX_SUMS, "at most %d exact sums at a time, got %d", HC_COMM_MAX_SUMS, count);
  for (int k = 0; k < count; k++) hc_sum_carry(&sums[k]);
  reduce(comm, sums[0].word, count * HC_SUM_WORDS, MPI_INT64_T, MPI_SUM);
}

int64_t hc_comm_prefix_i64(hc_comm *comm, int64_t value) {
  int64_t sum = 0;
  const hc_visit start = hc_calls_enter(comm);
  CHECK_MPI(MPI_Exscan(&value, &sum, 1, MPI_INT64_T, MPI_SUM, comm->mpi));
  comm->other_collectives++;
  hc_calls_leave(comm, start);
  return comm->rank == 0 ? 0 : sum;
}
