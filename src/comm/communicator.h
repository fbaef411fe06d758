/* What communication is with: a communicator and its counts, and messages. See comm.h. */
#ifndef HC_COMMUNICATOR_H
#define HC_COMMUNICATOR_H

#include <mpi.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct hc_comm {
  MPI_Comm mpi; /* a duplicate of our own; handed on to HDF5, to nobody else */
  int rank, size;
  bool owns_mpi;
  bool watches;                      /* see ending.h */
  size_t part_limit;                 /* bytes, larger messages are sent in parts; 0: what MPI can count */
  int sparse_parity;                 /* alternates the tag of successive sparse exchanges */
  double wait_seconds;               /* time spent in this room since the start, for timings.json */
  double spent_seconds;              /* of it what the thread's own clock says, which stands still asleep */
  int64_t bytes_sent, messages_sent; /* point to point, those of sparse exchanges included */
  int64_t sparse_exchanges;          /* each with a barrier of all ranks */
  int64_t reductions;                /* to all ranks */
  int64_t other_collectives;         /* broadcasts, gathers, prefix sums, barriers */
  int64_t gathered_bytes;            /* that gathers brought here, from all ranks */
} hc_comm;

enum { HC_MOST_OF_A_PART = 1 << 30 }; /* bytes: under MPI's INT_MAX, whole cache lines */

static inline size_t hc_comm_part_limit(const hc_comm *comm) {
  return comm->part_limit ? comm->part_limit : HC_MOST_OF_A_PART;
}

/* A message of a sparse exchange. `data` of received ones is freed by hc_messages_free. */
typedef struct hc_message {
  int rank;
  size_t bytes;
  void *data;
} hc_message;

#endif
