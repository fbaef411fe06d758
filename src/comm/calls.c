#include "calls.h"

#include "base/check.h"
#include "base/timer.h"

void hc_calls_check(int code, const char *call, const char *file, int line) {
  if (__builtin_expect(code != MPI_SUCCESS, 0)) {
    char text[MPI_MAX_ERROR_STRING] = "";
    int length = 0;
    MPI_Error_string(code, text, &length);
    hc_check_failed(file, line, "%s failed: %s", call, text);
  }
}

hc_visit hc_calls_enter(const hc_comm *comm) {
  return (hc_visit){hc_seconds(), comm->size > 1 ? hc_work_seconds() : 0.0};
}

void hc_calls_leave(hc_comm *comm, hc_visit since) {
  comm->wait_seconds += hc_seconds() - since.seconds;
  if (comm->size > 1) comm->spent_seconds += hc_work_seconds() - since.work_seconds;
}

void hc_calls_broadcast(hc_comm *comm, void *data, size_t bytes, int root) {
  for (size_t from = 0; from < bytes;) {
    const int part = hc_calls_part(comm, bytes, from);
    CHECK_MPI(MPI_Bcast((char *)data + from, part, MPI_BYTE, root, comm->mpi));
    from += (size_t)part;
  }
}

void hc_calls_send(hc_comm *comm, const void *data, size_t bytes, int rank, int tag) {
  for (size_t from = 0; from < bytes;) {
    const int part = hc_calls_part(comm, bytes, from);
    CHECK_MPI(MPI_Send((const char *)data + from, part, MPI_BYTE, rank, tag, comm->mpi));
    from += (size_t)part;
  }
}

void hc_calls_receive(hc_comm *comm, void *data, size_t bytes, size_t from, int rank, int tag) {
  while (from < bytes) {
    const int part = hc_calls_part(comm, bytes, from);
    CHECK_MPI(MPI_Recv((char *)data + from, part, MPI_BYTE, rank, tag, comm->mpi, MPI_STATUS_IGNORE));
    from += (size_t)part;
  }
}

size_t hc_calls_post_sends(hc_comm *comm, const hc_message *message, size_t from, int tag,
                           MPI_Request *requests) {
  size_t posted = 0;
  while (from < message->bytes) {
    const int part = hc_calls_part(comm, message->bytes, from);
    CHECK_MPI(MPI_Isend((const char *)message->data + from, part, MPI_BYTE, message->rank, tag, comm->mpi,
                        &requests[posted++]));
    from += (size_t)part;
  }
  return posted;
}

size_t hc_calls_post_receives(hc_comm *comm, const hc_message *message, size_t from, int tag,
                              MPI_Request *requests) {
  size_t posted = 0;
  while (from < message->bytes) {
    const int part = hc_calls_part(comm, message->bytes, from);
    CHECK_MPI(MPI_Irecv((char *)message->data + from, part, MPI_BYTE, message->rank, tag, comm->mpi,
                        &requests[posted++]));
    from += (size_t)part;
  }
  return posted;
}
