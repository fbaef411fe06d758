/* A program in which rank 1 dies while the others wait: endings SESSION CAUSE. */
#include "base/check.h"
#include "base/memory.h"
#include "comm/comm.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* How the session came to be: the program's own; on a communicator of all ranks, of this one, of the first
 * two, which the program made. */
static int start(const char *session, hc_comm *comm) {
  hc_error error = {.status = HC_OK};
  if (strcmp(session, "own") == 0) {
    hc_comm_start(comm, NULL, NULL);
    return comm->rank;
  }
  MPI_Init(NULL, NULL);
  MPI_Comm part = MPI_COMM_WORLD;
  int rank;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (strcmp(session, "alone") == 0) part = MPI_COMM_SELF;
  if (strcmp(session, "pair") == 0) MPI_Comm_split(MPI_COMM_WORLD, rank == 2, 0, &part);
  const int handle = MPI_Comm_c2f(part);
  if (hc_comm_start_on(comm, &handle, &error) != HC_OK) exit(EXIT_FAILURE);
  return rank;
}

static void die(const char *cause) {
  volatile char *volatile nowhere = NULL;
  char *volatile inside = (char *)malloc(100) + 8;
  HC_CHECK(strcmp(cause, "check") != 0, "the test breaks %s", "an invariant");
  if (strcmp(cause, "abort") == 0) abort();
  if (strcmp(cause, "segfault") == 0) *nowhere = 1;
  if (strcmp(cause, "memory") == 0) hc_alloc((size_t)1 << 60, 1);
  if (strcmp(cause, "heap") == 0) free(inside); /* the C library aborts */
  if (strcmp(cause, "exit") == 0) exit(EXIT_FAILURE);
}

int main(int argc, char **argv) {
  hc_comm comm;
  if (argc != 3) return EXIT_SUCCESS;
  if (start(argv[1], &comm) == 1) die(argv[2]);
  MPI_Barrier(MPI_COMM_WORLD);
  sleep(100);
}
