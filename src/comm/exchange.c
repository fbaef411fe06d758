/* Messages from rank to rank: to those that do not know of them, and between known partners. */
#include "base/check.h"
#include "base/memory.h"
#include "calls.h"
#include "comm.h"

#include <stdlib.h>
#include <string.h>

static int by_rank(const void *a, const void *b) {
  return ((const hc_message *)a)->rank - ((const hc_message *)b)->rank;
}

static void append(hc_message **list, int *count, size_t *capacity, hc_message message) {
  hc_reserve((void **)list, capacity, (size_t)*count + 1, (size_t)*count, sizeof **list);
  (*list)[(*count)++] = message;
}

/* A message that fills its first part has its whole size and the parts that are left behind it, under another
 * tag, so that shorter ones are one message of MPI's. */
static bool has_rest(const hc_comm *comm, size_t first_part) {
  return first_part == hc_comm_part_limit(comm);
}

static void receive_rest(hc_comm *comm, int tag, hc_message *message) {
  const size_t first_part = message->bytes;
  hc_calls_receive(comm, &message->bytes, sizeof message->bytes, 0, message->rank, tag);
  void *whole = hc_alloc(message->bytes, 1);
  memcpy(whole, message->data, first_part);
  hc_free(message->data);
  message->data = whole;
  hc_calls_receive(comm, whole, message->bytes, first_part, message->rank, tag);
}

/* The tags of an exchange whose receivers do not know sizes: of first parts, and of the rest. */
typedef struct line {
  int tag, rest;
} line;

/* Takes a message that waits. */
static hc_message receive(hc_comm *comm, line line, const MPI_Status *status) {
  int bytes = 0;
  CHECK_MPI(MPI_Get_count(status, MPI_BYTE, &bytes));
  hc_message message = {status->MPI_SOURCE, (size_t)bytes, hc_alloc((size_t)bytes, 1)};
  CHECK_MPI(MPI_Recv(message.data, bytes, MPI_BYTE, message.rank, line.tag, comm->mpi, MPI_STATUS_IGNORE));
  if (has_rest(comm, message.bytes)) receive_rest(comm, line.rest, &message);
  return message;
}

/* Posts a message; `synchronous`: its first part is received before its request is done. Returns the number
 * of requests. */
static size_t send_one(hc_comm *comm, line line, bool synchronous, const hc_message *message,
                       MPI_Request *requests) {
  const int first_part = hc_calls_part(comm, message->bytes, 0);
  if (synchronous)
    CHECK_MPI(MPI_Issend(message->data, first_part, MPI_BYTE, message->rank, line.tag, comm->mpi, requests));
  else
    CHECK_MPI(MPI_Isend(message->data, first_part, MPI_BYTE, message->rank, line.tag, comm->mpi, requests));
  size_t posted = 1;
  if (has_rest(comm, (size_t)first_part)) {
    const hc_message size = {message->rank, sizeof message->bytes, (void *)&message->bytes};
    posted += hc_calls_post_sends(comm, &size, 0, line.rest, requests + posted);
    posted += hc_calls_post_sends(comm, message, (size_t)first_part, line.rest, requests + posted);
  }
  comm->bytes_sent += (int64_t)message->bytes;
  comm->messages_sent++;
  return posted;
}

static hc_message copy_of(const hc_message *message) {
  hc_message copy = {message->rank, message->bytes, hc_alloc(message->bytes, 1)};
  memcpy(copy.data, message->data, copy.bytes);
  return copy;
}

/* Requests that a message may take: its parts, and those of its size. */
static size_t requests_for(const hc_comm *comm, const hc_message *message) {
  return has_rest(comm, (size_t)hc_calls_part(comm, message->bytes, 0))
             ? 2 + hc_calls_further_parts(comm, message->bytes) +
                   hc_calls_further_parts(comm, sizeof message->bytes)
             : 1;
}

void hc_comm_sparse(hc_comm *comm, const hc_message *out, int out_count, hc_message **in, int *in_count) {
  const hc_visit start = hc_calls_enter(comm);
  *in = NULL;
  *in_count = 0;
  size_t capacity = 0;
  hc_reserve((void **)in, &capacity, 1, 0, sizeof **in);
  /* A fast rank may be one exchange ahead of a slow one, never two: two sets of tags keep them apart. */
  const line line = {TAG_SPARSE + comm->sparse_parity, TAG_SPARSE_REST + comm->sparse_parity};
  comm->sparse_parity ^= 1;

  size_t room = 0, sends = 0;
  for (int k = 0; k < out_count; k++) room += requests_for(comm, &out[k]);
  MPI_Request *requests = hc_alloc(room, sizeof *requests);
  for (int k = 0; k < out_count; k++) {
    if (out[k].rank == comm->rank) {
      append(in, in_count, &capacity, copy_of(&out[k]));
      continue;
    }
    sends += send_one(comm, line, true, &out[k], requests + sends);
  }
  if (comm->size > 1) {
    comm->sparse_exchanges++;
    MPI_Request barrier = MPI_REQUEST_NULL;
    for (int finished = 0; !finished;) {
      int waiting = 0;
      MPI_Status status;
      CHECK_MPI(MPI_Iprobe(MPI_ANY_SOURCE, line.tag, comm->mpi, &waiting, &status));
      if (waiting) append(in, in_count, &capacity, receive(comm, line, &status));
      if (barrier == MPI_REQUEST_NULL) {
        int all_taken = 0; /* a synchronous send completes when its receiver took it */
        CHECK_MPI(MPI_Testall((int)sends, requests, &all_taken, MPI_STATUSES_IGNORE));
        if (all_taken) CHECK_MPI(MPI_Ibarrier(comm->mpi, &barrier));
      } else {
        CHECK_MPI(MPI_Test(&barrier, &finished, MPI_STATUS_IGNORE));
      }
    }
  }
  hc_free(requests);
  qsort(*in, (size_t)*in_count, sizeof **in, by_rank);
  hc_calls_leave(comm, start);
}

/* Sends each partner its message, or an empty one. Returns the number of requests. */
static size_t send_among(hc_comm *comm, line line, const int32_t *ranks, int count, const hc_message *out,
                         int out_count, MPI_Request *requests) {
  size_t sends = 0;
  int next = 0;
  for (int k = 0; k < count; k++) {
    const hc_message none = {ranks[k], 0, NULL};
    if (next < out_count && out[next].rank == comm->rank) next++;
    const bool some = next < out_count && out[next].rank == ranks[k];
    sends += send_one(comm, line, false, some ? &out[next++] : &none, requests + sends);
  }
  if (next < out_count && out[next].rank == comm->rank) next++;
  HC_CHECK(next == out_count, "%d messages go to ranks that are no partners", out_count - next);
  return sends;
}

void hc_comm_among(hc_comm *comm, const int32_t *ranks, int count, const hc_message *out, int out_count,
                   hc_message **in, int *in_count) {
  const hc_visit start = hc_calls_enter(comm);
  *in = NULL;
  *in_count = 0;
  size_t capacity = 0, room = (size_t)count;
  hc_reserve((void **)in, &capacity, 1, 0, sizeof **in);
  const line line = {TAG_AMONG, TAG_AMONG_REST};
  for (int k = 0; k < out_count; k++) {
    room += requests_for(comm, &out[k]);
    if (out[k].rank == comm->rank) append(in, in_count, &capacity, copy_of(&out[k]));
  }
  MPI_Request *requests = hc_alloc(room, sizeof *requests);
  const size_t sends = send_among(comm, line, ranks, count, out, out_count, requests);
  for (int k = 0; k < count; k++) {
    MPI_Status status;
    CHECK_MPI(MPI_Probe(ranks[k], line.tag, comm->mpi, &status));
    hc_message message = receive(comm, line, &status);
    if (message.bytes > 0)
      append(in, in_count, &capacity, message);
    else
      hc_free(message.data);
  }
  CHECK_MPI(MPI_Waitall((int)sends, requests, MPI_STATUSES_IGNORE));
  hc_free(requests);
  qsort(*in, (size_t)*in_count, sizeof **in, by_rank);
  hc_calls_leave(comm, start);
}

void hc_messages_free(hc_message *messages, int count) {
  for (int k = 0; k < count; k++) hc_free(messages[k].data);
  hc_free(messages);
}

/* Requests beyond one for each message, where some come in parts. */
static size_t further_requests(const hc_comm *comm, const hc_exchange *exchange) {
  size_t count = 0;
  for (int k = 0; k < exchange->send_count; k++)
    count += hc_calls_further_parts(comm, exchange->send[k].bytes);
  for (int k = 0; k < exchange->receive_count; k++)
    count += hc_calls_further_parts(comm, exchange->receive[k].bytes);
  return count;
}

void hc_comm_exchange_begin(hc_comm *comm, hc_exchange *exchange, int tag) {
  const hc_visit start = hc_calls_enter(comm);
  const size_t further = further_requests(comm, exchange);
  exchange->many = further
                       ? hc_alloc((size_t)exchange->send_count + (size_t)exchange->receive_count + further,
                                  sizeof(MPI_Request))
                       : NULL;
  MPI_Request *requests = exchange->many ? exchange->many : exchange->requests;
  size_t posted = 0;
  const hc_message *own = NULL;
  for (int k = 0; k < exchange->receive_count; k++) {
    const hc_message *from = &exchange->receive[k];
    if (from->rank == comm->rank)
      own = from;
    else
      posted += hc_calls_post_receives(comm, from, 0, TAG_EXCHANGE + tag, requests + posted);
  }
  for (int k = 0; k < exchange->send_count; k++) {
    const hc_message *to = &exchange->send[k];
    if (to->rank == comm->rank) {
      HC_CHECK(own && own->bytes >= to->bytes, "an exchange with oneself must match, sent %zu bytes",
               to->bytes);
      memcpy(own->data, to->data, to->bytes);
      continue;
    }
    posted += hc_calls_post_sends(comm, to, 0, TAG_EXCHANGE + tag, requests + posted);
    comm->bytes_sent += (int64_t)to->bytes;
    comm->messages_sent++;
  }
  exchange->pending = (int)posted;
  hc_calls_leave(comm, start);
}

void hc_comm_exchange_end(hc_comm *comm, hc_exchange *exchange) {
  const hc_visit start = hc_calls_enter(comm);
  CHECK_MPI(MPI_Waitall(exchange->pending, exchange->many ? exchange->many : exchange->requests,
                        MPI_STATUSES_IGNORE));
  hc_free(exchange->many);
  exchange->many = NULL;
  exchange->pending = 0;
  hc_calls_leave(comm, start);
}
