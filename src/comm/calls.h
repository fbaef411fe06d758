/* What the files of this room share: checked calls, the time spent in here, and messages in parts, as MPI
 * counts bytes by an int. */
#ifndef HC_CALLS_H
#define HC_CALLS_H

#include "communicator.h"

/* Ends the program unless the call went well. */
void hc_calls_check(int code, const char *call, const char *file, int line);
#define CHECK_MPI(call) hc_calls_check((call), #call, __FILE__, __LINE__)

/* The tags of this room. Two of each for sparse exchanges, which take turns; TAG_EXCHANGE is the first of
 * those that callers of exchanges choose. */
enum {
  TAG_SPARSE = 1,
  TAG_SPARSE_REST = 3,
  TAG_GATHER = 5,
  TAG_AMONG = 6,
  TAG_AMONG_REST = 7,
  TAG_EXCHANGE = 16
};

/* A stay in this room, on the wall clock and on the thread's. */
typedef struct hc_visit {
  double seconds, work_seconds;
} hc_visit;

hc_visit hc_calls_enter(const hc_comm *comm);
void hc_calls_leave(hc_comm *comm, hc_visit since);

/* The length of the part that begins at byte `from` of `bytes`. */
static inline int hc_calls_part(const hc_comm *comm, size_t bytes, size_t from) {
  const size_t left = bytes - from, limit = hc_comm_part_limit(comm);
  return (int)(left < limit ? left : limit);
}

/* The number of parts behind the first. */
static inline size_t hc_calls_further_parts(const hc_comm *comm, size_t bytes) {
  return bytes == 0 ? 0 : (bytes - 1) / hc_comm_part_limit(comm);
}

/* A broadcast, and a message to a rank; wait until the data may change. */
void hc_calls_broadcast(hc_comm *comm, void *data, size_t bytes, int root);
void hc_calls_send(hc_comm *comm, const void *data, size_t bytes, int rank, int tag);

/* The bytes from `from` on, received part by part; waits for them. */
void hc_calls_receive(hc_comm *comm, void *data, size_t bytes, size_t from, int rank, int tag);

/* Posts the parts from byte `from` on; returns the number of requests used. */
size_t hc_calls_post_sends(hc_comm *comm, const hc_message *message, size_t from, int tag,
                           MPI_Request *requests);
size_t hc_calls_post_receives(hc_comm *comm, const hc_message *message, size_t from, int tag,
                              MPI_Request *requests);

#endif
