/* What a checkpoint costs (two are kept, the third last is removed): seconds and GB/s, beside a plain
 * sequential write and sync of as many bytes, in turns in the same run. Usage: [mpirun -n N] bench_checkpoint
 * [DIRECTORY [PARTICLES [REPEATS]]]; default: the current folder, 1,000,000 particles, 5 repeats. All ranks
 * write the checkpoint, rank 0 the plain file. The files go to DIRECTORY/bench_checkpoint, which is removed
 * at the end. */
#include "io/checkpoint.h"
#include "base/check.h"
#include "base/memory.h"
#include "full_tank.h"
#include "simulation/step.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MAX_REPEATS = 100, PIECE = 8 << 20 };

static int ascending(const void *a, const void *b) {
  const double p = *(const double *)a, q = *(const double *)b;
  return (p > q) - (p < q);
}

/* Rank 0: a plain file of so many bytes, written from one piece of memory after the other, and synced. */
static void write_plain(const char *path, int64_t bytes) {
  static char piece[PIECE];
  for (int k = 0; k < PIECE; k++) piece[k] = (char)(k * 2654435761u >> 24);
  const int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
  HC_CHECK(file >= 0, "cannot write %s: %s", path, strerror(errno));
  for (int64_t left = bytes; left > 0;) {
    const ssize_t written = write(file, piece, left < PIECE ? (size_t)left : PIECE);
    HC_CHECK(written > 0, "cannot write %s: %s", path, strerror(errno));
    left -= written;
  }
  HC_CHECK(fsync(file) == 0 && close(file) == 0, "cannot write %s: %s", path, strerror(errno));
}

static void report(const char *what, double *seconds, int repeats, int64_t bytes) {
  qsort(seconds, (size_t)repeats, sizeof *seconds, ascending);
  const double median = seconds[repeats / 2];
  printf("%-28s %9.4f %9.4f %9.3f\n", what, seconds[0], median, 1e-9 * (double)bytes / median);
}

int main(int argc, char **argv) {
  hc_comm comm;
  hc_comm_start(&comm, NULL, NULL);
  const char *where = argc > 1 ? argv[1] : ".";
  const int64_t particles = argc > 2 ? atoll(argv[2]) : 1000000;
  const int repeats = argc > 3 ? atoi(argv[3]) : 5;
  HC_CHECK(particles >= 1000 && repeats >= 1 && repeats <= MAX_REPEATS,
           "usage: bench_checkpoint [DIRECTORY [PARTICLES >= 1000 [REPEATS 1 to %d]]]", MAX_REPEATS);
  hc_block block;
  hc_wall wall;
  hc_scene scene = full_tank(particles, &block, &wall);
  hc_simulation simulation;
  hc_error error = {.status = HC_OK};
  HC_CHECK(hc_simulation_init(&simulation, &comm, &scene, &error) == HC_OK, "%s", error.text);
  char folder[HC_TEXT_PATH], plain[HC_TEXT_PATH + 16], path[HC_TEXT_PATH];
  snprintf(folder, sizeof folder, "%s/bench_checkpoint", where);
  snprintf(plain, sizeof plain, "%s/plain", folder);
  HC_CHECK(comm.rank > 0 || mkdir(folder, 0777) == 0, "cannot create %s: %s", folder, strerror(errno));

  double seconds[2][MAX_REPEATS];
  int64_t bytes = 0, step;
  for (int k = -2; k < repeats; k++) { /* the first warm up, and are what later ones replace */
    const int at = k < 0 ? 0 : k;
    hc_comm_barrier(&comm);
    double begin = hc_seconds();
    simulation.step++; /* another name */
    const hc_moment moment = hc_simulation_moment(&simulation);
    HC_CHECK(hc_checkpoint_write(&comm, simulation.scene, &moment, &simulation.state, "bench", folder, 2,
                                 &bytes, &error) == HC_OK,
             "%s", error.text);
    seconds[0][at] = hc_seconds() - begin;
    begin = hc_seconds();
    if (comm.rank == 0) {
      write_plain(plain, bytes);
      seconds[1][at] = hc_seconds() - begin;
      unlink(plain);
    }
  }
  while (hc_checkpoint_find(&comm, folder, INT64_MAX, path, &step, &error) == HC_OK && step >= 0) {
    if (comm.rank == 0) unlink(path);
    hc_comm_barrier(&comm);
  }
  if (comm.rank == 0) {
    printf("%lld fluid, %lld boundary particles on %d ranks: %.1f MB\n",
           (long long)simulation.world.fluid_total, (long long)simulation.world.boundary_total, comm.size,
           1e-6 * (double)bytes);
    printf("%-28s %9s %9s %9s\n", "", "least, s", "median, s", "GB/s");
    report("checkpoint", seconds[0], repeats, bytes);
    report("plain write and sync", seconds[1], repeats, bytes);
    printf("ratio of the medians %.2f\n", seconds[0][repeats / 2] / seconds[1][repeats / 2]);
    snprintf(path, sizeof path, "%s/bench_checkpoint/checkpoints", where);
    rmdir(path);
    rmdir(folder);
  }
  hc_simulation_free(&simulation);
  hc_comm_finish(&comm);
  return 0;
}
