#include "comm.h"

#include "base/check.h"
#include "base/memory.h"
#include "base/timer.h"

#include <limits.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void check_mpi(int code, const char *call, int line) {
  if (__builtin_expect(code != MPI_SUCCESS, 0)) {
    char text[MPI_MAX_ERROR_STRING] = "";
    int length = 0;
    MPI_Error_string(code, text, &length);
    hc_check_failed(__FILE__, line, "%s failed: %s", call, text);
  }
}
#define CHECK_MPI(call) check_mpi((call), #call, __LINE__)

/* A stay in this room, on the wall clock and on the thread's. */
typedef struct visit {
  double seconds, work_seconds;
} visit;

static visit enter(const hc_comm *comm) {
  return (visit){hc_seconds(), comm->size > 1 ? hc_work_seconds() : 0.0};
}

static void leave(hc_comm *comm, visit since) {
  comm->wait_seconds += hc_seconds() - since.seconds;
  if (comm->size > 1) comm->spent_seconds += hc_work_seconds() - since.work_seconds;
}

double hc_comm_busy_seconds(const hc_comm *comm) {
  return hc_work_seconds() - comm->spent_seconds;
}

static int as_count(size_t bytes) {
  HC_CHECK(bytes <= INT_MAX, "a message of %zu bytes is over MPI's limit of %d", bytes, INT_MAX);
  return (int)bytes;
}

static void end_alone(int signal_number) {
  (void)signal_number;
  _exit(HC_FAILED); /* the launcher ends the others */
}

/* Without memory the library may not find its way out: then this rank leaves by itself. */
static void end_all(int exit_code) {
  enum { PATIENCE = 10 }; /* s */
  signal(SIGALRM, end_alone);
  alarm(PATIENCE);
  MPI_Abort(MPI_COMM_WORLD, exit_code);
}

static void duplicate(hc_comm *comm, MPI_Comm given) {
  CHECK_MPI(MPI_Comm_dup(given, &comm->mpi));
  CHECK_MPI(MPI_Comm_set_errhandler(comm->mpi, MPI_ERRORS_RETURN));
  CHECK_MPI(MPI_Comm_rank(comm->mpi, &comm->rank));
  CHECK_MPI(MPI_Comm_size(comm->mpi, &comm->size));
  hc_check_set_rank(comm->rank);
  if (comm->size > 1) hc_check_set_leave(end_all);
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
  hc_check_set_leave(NULL);
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

int hc_comm_machine_ranks(hc_comm *comm) {
  MPI_Comm machine;
  int count = 0;
  CHECK_MPI(MPI_Comm_split_type(comm->mpi, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine));
  CHECK_MPI(MPI_Comm_size(machine, &count));
  CHECK_MPI(MPI_Comm_free(&machine));
  return count;
}

hc_status hc_comm_agree(hc_comm *comm, hc_error *error) {
  int64_t first = error->status == HC_OK ? INT64_MAX : comm->rank;
  hc_comm_min_i64(comm, &first, 1);
  if (first == INT64_MAX) return HC_OK;
  hc_comm_broadcast(comm, error, sizeof *error, (int)first);
  return error->status;
}

void hc_comm_barrier(hc_comm *comm) {
  const visit start = enter(comm);
  CHECK_MPI(MPI_Barrier(comm->mpi));
  comm->other_collectives++;
  leave(comm, start);
}

void hc_comm_broadcast(hc_comm *comm, void *data, size_t bytes, int root) {
  const visit start = enter(comm);
  CHECK_MPI(MPI_Bcast(data, as_count(bytes), MPI_BYTE, root, comm->mpi));
  comm->other_collectives++;
  leave(comm, start);
}

static void reduce(hc_comm *comm, void *values, int count, MPI_Datatype type, MPI_Op operation) {
  if (comm->size == 1) return;
  const visit start = enter(comm);
  CHECK_MPI(MPI_Allreduce(MPI_IN_PLACE, values, count, type, operation, comm->mpi));
  leave(comm, start);
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

/* Combines blocks of a type of their own, which MPI does not split: the number of sums, the sums, maxima. */
static void sum_max(void *from, void *to, int *blocks, MPI_Datatype *type) {
  int bytes = 0;
  CHECK_MPI(MPI_Type_size(*type, &bytes));
  const int64_t *a = from, words = bytes / (int64_t)sizeof *a;
  int64_t *b = to;
  for (int block = 0; block < *blocks; block++, a += words, b += words) {
    const int64_t sums = b[0];
    for (int64_t k = 1; k <= sums; k++) b[k] = (int64_t)((uint64_t)a[k] + (uint64_t)b[k]);
    for (int64_t k = 1 + sums; k < words; k++) b[k] = a[k] > b[k] ? a[k] : b[k];
  }
}

void hc_comm_sum_max_i64(hc_comm *comm, int64_t *values, int sums, int maxima) {
  if (comm->size == 1) return;
  const visit start = enter(comm);
  const int words = 1 + sums + maxima;
  int64_t *block = hc_alloc((size_t)words, sizeof *block);
  block[0] = sums;
  memcpy(block + 1, values, (size_t)(sums + maxima) * sizeof *values);
  MPI_Datatype type;
  MPI_Op operation;
  CHECK_MPI(MPI_Op_create(sum_max, true, &operation));
  CHECK_MPI(MPI_Type_contiguous(words, MPI_INT64_T, &type));
  CHECK_MPI(MPI_Type_commit(&type));
  CHECK_MPI(MPI_Allreduce(MPI_IN_PLACE, block, 1, type, operation, comm->mpi));
  CHECK_MPI(MPI_Type_free(&type));
  CHECK_MPI(MPI_Op_free(&operation));
  memcpy(values, block + 1, (size_t)(sums + maxima) * sizeof *values);
  hc_free(block);
  leave(comm, start);
  comm->reductions++;
}

void hc_comm_sum_exact(hc_comm *comm, hc_sum *sums, int count) {
  HC_CHECK(count <= HC_COMM_MAX_SUMS, "at most %d exact sums at a time, got %d", HC_COMM_MAX_SUMS, count);
  for (int k = 0; k < count; k++) hc_sum_carry(&sums[k]);
  reduce(comm, sums[0].word, count * HC_SUM_WORDS, MPI_INT64_T, MPI_SUM);
}

int64_t hc_comm_prefix_i64(hc_comm *comm, int64_t value) {
  int64_t sum = 0;
  const visit start = enter(comm);
  CHECK_MPI(MPI_Exscan(&value, &sum, 1, MPI_INT64_T, MPI_SUM, comm->mpi));
  comm->other_collectives++;
  leave(comm, start);
  return comm->rank == 0 ? 0 : sum;
}

void hc_comm_gather_all(hc_comm *comm, const void *mine, size_t bytes, void **all, size_t *total) {
  const visit start = enter(comm);
  const size_t ranks = (size_t)comm->size;
  int *counts = hc_alloc(ranks, sizeof *counts), *places = hc_alloc(ranks, sizeof *places);
  const int count = as_count(bytes);
  CHECK_MPI(MPI_Allgather(&count, 1, MPI_INT, counts, 1, MPI_INT, comm->mpi));
  *total = 0;
  for (size_t rank = 0; rank < ranks; rank++) {
    places[rank] = as_count(*total);
    *total += (size_t)counts[rank];
  }
  *all = hc_alloc(as_count(*total), 1);
  CHECK_MPI(MPI_Allgatherv(mine, count, MPI_BYTE, *all, counts, places, MPI_BYTE, comm->mpi));
  hc_free(counts);
  hc_free(places);
  comm->other_collectives += 2;
  comm->gathered_bytes += (int64_t)(*total + ranks * sizeof count);
  leave(comm, start);
}

void hc_comm_gather(hc_comm *comm, const void *mine, size_t bytes, int root, void **all, size_t *total) {
  const visit start = enter(comm);
  const size_t ranks = comm->rank == root ? (size_t)comm->size : 0;
  int *counts = hc_alloc(ranks, sizeof *counts), *places = hc_alloc(ranks, sizeof *places);
  const int count = as_count(bytes);
  CHECK_MPI(MPI_Gather(&count, 1, MPI_INT, counts, 1, MPI_INT, root, comm->mpi));
  *total = 0;
  for (size_t rank = 0; rank < ranks; rank++) {
    places[rank] = as_count(*total);
    *total += (size_t)counts[rank];
  }
  *all = ranks ? hc_alloc(as_count(*total), 1) : NULL;
  CHECK_MPI(MPI_Gatherv(mine, count, MPI_BYTE, *all, counts, places, MPI_BYTE, root, comm->mpi));
  hc_free(counts);
  hc_free(places);
  comm->other_collectives += 2;
  comm->gathered_bytes += (int64_t)(*total + ranks * sizeof count);
  leave(comm, start);
}

void hc_comm_gather_all_f64(hc_comm *comm, const double *mine, int count, double *all) {
  const visit start = enter(comm);
  CHECK_MPI(MPI_Allgather(mine, count, MPI_DOUBLE, all, count, MPI_DOUBLE, comm->mpi));
  comm->other_collectives++;
  comm->gathered_bytes += (int64_t)((size_t)comm->size * (size_t)count * sizeof *all);
  leave(comm, start);
}

enum { TAG_SPARSE = 1, TAG_EXCHANGE = 16 };

static int by_rank(const void *a, const void *b) {
  return ((const hc_message *)a)->rank - ((const hc_message *)b)->rank;
}

static void append(hc_message **list, int *count, size_t *capacity, hc_message message) {
  hc_reserve((void **)list, capacity, (size_t)*count + 1, (size_t)*count, sizeof **list);
  (*list)[(*count)++] = message;
}

/* Takes one waiting message with this tag off the line, if there is any. */
static bool receive_one(hc_comm *comm, int tag, hc_message *message) {
  int waiting = 0;
  MPI_Status status;
  CHECK_MPI(MPI_Iprobe(MPI_ANY_SOURCE, tag, comm->mpi, &waiting, &status));
  if (!waiting) return false;
  int bytes = 0;
  CHECK_MPI(MPI_Get_count(&status, MPI_BYTE, &bytes));
  *message = (hc_message){status.MPI_SOURCE, (size_t)bytes, hc_alloc((size_t)bytes, 1)};
  CHECK_MPI(MPI_Recv(message->data, bytes, MPI_BYTE, message->rank, tag, comm->mpi, MPI_STATUS_IGNORE));
  return true;
}

void hc_comm_sparse(hc_comm *comm, const hc_message *out, int out_count, hc_message **in, int *in_count) {
  const visit start = enter(comm);
  *in = NULL;
  *in_count = 0;
  size_t capacity = 0;
  hc_reserve((void **)in, &capacity, 1, 0, sizeof **in);
  /* A fast rank may be one exchange ahead of a slow one, never two: two tags keep them apart. */
  const int tag = TAG_SPARSE + comm->sparse_parity;
  comm->sparse_parity ^= 1;

  MPI_Request *requests = hc_alloc((size_t)out_count + 1, sizeof *requests);
  int sends = 0;
  for (int k = 0; k < out_count; k++) {
    if (out[k].rank == comm->rank) {
      hc_message own = {comm->rank, out[k].bytes, hc_alloc(out[k].bytes, 1)};
      memcpy(own.data, out[k].data, own.bytes);
      append(in, in_count, &capacity, own);
      continue;
    }
    CHECK_MPI(MPI_Issend(out[k].data, as_count(out[k].bytes), MPI_BYTE, out[k].rank, tag, comm->mpi,
                         &requests[sends++]));
    comm->bytes_sent += (int64_t)out[k].bytes;
    comm->messages_sent++;
  }
  if (comm->size > 1) {
    comm->sparse_exchanges++;
    MPI_Request barrier = MPI_REQUEST_NULL;
    for (int finished = 0; !finished;) {
      hc_message message;
      if (receive_one(comm, tag, &message)) append(in, in_count, &capacity, message);
      if (barrier == MPI_REQUEST_NULL) {
        int all_taken = 0; /* a synchronous send completes when its receiver took it */
        CHECK_MPI(MPI_Testall(sends, requests, &all_taken, MPI_STATUSES_IGNORE));
        if (all_taken) CHECK_MPI(MPI_Ibarrier(comm->mpi, &barrier));
      } else {
        CHECK_MPI(MPI_Test(&barrier, &finished, MPI_STATUS_IGNORE));
      }
    }
  }
  hc_free(requests);
  qsort(*in, (size_t)*in_count, sizeof **in, by_rank);
  leave(comm, start);
}

void hc_messages_free(hc_message *messages, int count) {
  for (int k = 0; k < count; k++) hc_free(messages[k].data);
  hc_free(messages);
}

void hc_comm_exchange_begin(hc_comm *comm, hc_exchange *exchange, int tag) {
  const visit start = enter(comm);
  exchange->pending = 0;
  const hc_message *own = NULL;
  for (int k = 0; k < exchange->receive_count; k++) {
    const hc_message *from = &exchange->receive[k];
    if (from->rank == comm->rank) {
      own = from;
      continue;
    }
    CHECK_MPI(MPI_Irecv(from->data, as_count(from->bytes), MPI_BYTE, from->rank, TAG_EXCHANGE + tag,
                        comm->mpi, &exchange->requests[exchange->pending++]));
  }
  for (int k = 0; k < exchange->send_count; k++) {
    const hc_message *to = &exchange->send[k];
    if (to->rank == comm->rank) {
      HC_CHECK(own && own->bytes >= to->bytes, "an exchange with oneself must match, sent %zu bytes",
               to->bytes);
      memcpy(own->data, to->data, to->bytes);
      continue;
    }
    CHECK_MPI(MPI_Isend(to->data, as_count(to->bytes), MPI_BYTE, to->rank, TAG_EXCHANGE + tag, comm->mpi,
                        &exchange->requests[exchange->pending++]));
    comm->bytes_sent += (int64_t)to->bytes;
    comm->messages_sent++;
  }
  leave(comm, start);
}

void hc_comm_exchange_end(hc_comm *comm, hc_exchange *exchange) {
  if (exchange->pending == 0) return;
  const visit start = enter(comm);
  CHECK_MPI(MPI_Waitall(exchange->pending, exchange->requests, MPI_STATUSES_IGNORE));
  exchange->pending = 0;
  leave(comm, start);
}
