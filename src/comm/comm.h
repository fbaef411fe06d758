/* The communicator: the only door to MPI. Every function here is collective over the communicator unless it
 * says "local"; a rank without particles calls them all the same. Messages, broadcasts and gathers may have
 * any size: what MPI cannot count goes in parts. */
#ifndef HC_COMM_H
#define HC_COMM_H

#include "base/exact_sum.h"
#include "communicator.h"
#include "halocline/error.h"

/* Starts MPI if nobody has, and duplicates the world. hc_comm_finish frees it, and ends MPI if we started it.
 */
void hc_comm_start(hc_comm *comm, int *argc, char ***argv);
void hc_comm_finish(hc_comm *comm);

/* The same for programs that embed a run: on the communicator of a Fortran handle (MPI_Comm_c2f), which must
 * belong to an MPI that runs; null: as hc_comm_start. HC_BAD_INPUT, found by every rank alone: MPI is not
 * running or has ended, the handle is no communicator of one group. */
hc_status hc_comm_start_on(hc_comm *comm, const int *handle, hc_error *error);

/* Tests: sends messages in parts of so many bytes, at most INT_MAX; the same on all ranks. Local. */
void hc_comm_set_part_limit(hc_comm *comm, size_t bytes);

/* The rank that a launcher (mpirun, srun) says this process will have, 0 without one. Local; needs no MPI. */
int hc_comm_launched_rank(void);

/* Processor time that this rank has worked outside this room: what is left of its thread's time without
 * waiting for others. Only differences mean something. Local. */
double hc_comm_busy_seconds(const hc_comm *comm);

/* The number of ranks on this rank's machine, which share its memory, that call with the same group; itself
 * included. Groups are not negative. */
int hc_comm_machine_ranks(hc_comm *comm, int group);

/* The lowest rank on this rank's machine. */
int hc_comm_machine_first(hc_comm *comm);

/* The error of the lowest rank that has one (error->status != HC_OK) becomes everybody's; returns its status.
 * This is how a rank tells the others that something of its own failed. */
hc_status hc_comm_agree(hc_comm *comm, hc_error *error);

void hc_comm_barrier(hc_comm *comm);
void hc_comm_broadcast(hc_comm *comm, void *data, size_t bytes, int root);
void hc_comm_max_f64(hc_comm *comm, double *values, int count);
void hc_comm_min_f64(hc_comm *comm, double *values, int count);
void hc_comm_max_i64(hc_comm *comm, int64_t *values, int count);
void hc_comm_min_i64(hc_comm *comm, int64_t *values, int count);
void hc_comm_sum_i64(hc_comm *comm, int64_t *values, int count);

/* Adds exact sums of all ranks; carries the caller left open are taken care of. At most 8 sums. */
enum { HC_COMM_MAX_SUMS = 8 };
void hc_comm_sum_exact(hc_comm *comm, hc_sum *sums, int count);

/* Sum over the ranks below this one (0 on rank 0). */
int64_t hc_comm_prefix_i64(hc_comm *comm, int64_t value);

/* Everybody's blocks in rank order. *all is allocated (hc_free) and holds *total bytes. */
void hc_comm_gather_all(hc_comm *comm, const void *mine, size_t bytes, void **all, size_t *total);

/* The same on `root` alone; elsewhere *all is null and *total 0. */
void hc_comm_gather(hc_comm *comm, const void *mine, size_t bytes, int root, void **all, size_t *total);

/* `count` values of every rank on every rank, in rank order; all has size * count elements. */
void hc_comm_gather_all_f64(hc_comm *comm, const double *mine, int count, double *all);

/* Sends each of `out` to its rank and receives whatever was sent here, from ranks that nobody announced
 * (Hoefler, Siebert, Lumsdaine 2010, "Scalable communication protocols for dynamic sparse data exchange",
 * algorithm NBX). Messages to oneself are copied. *in is allocated, sorted by rank, one message at most from
 * each. */
void hc_comm_sparse(hc_comm *comm, const hc_message *out, int out_count, hc_message **in, int *in_count);
void hc_messages_free(hc_message *messages, int count);

/* The same among partners, `ranks` without this one, ascending, each in the list of each other: without a
 * barrier, an empty message to those that get none. `out` is ascending, none of it empty, and all must go to
 * partners or to oneself. Collective among partners. */
void hc_comm_among(hc_comm *comm, const int32_t *ranks, int count, const hc_message *out, int out_count,
                   hc_message **in, int *in_count);

/* A repeated exchange with known partners, which know the sizes. Local to begin (never waits), completes at
 * end on both sides. Segments to or from oneself are copied at begin. Between the two neither side's buffers
 * may be touched. */
typedef struct hc_exchange {
  int send_count, receive_count;
  const hc_message *send;    /* data, bytes, rank */
  const hc_message *receive; /* data, bytes, rank: the room that is filled, or a part of it */
  MPI_Request *requests;     /* room for send_count + receive_count, the caller's */
  MPI_Request *many;         /* in place of them, where messages come in parts; exchange.c's own */
  int pending;
} hc_exchange;

void hc_comm_exchange_begin(hc_comm *comm, hc_exchange *exchange, int tag);
void hc_comm_exchange_end(hc_comm *comm, hc_exchange *exchange);

#endif
