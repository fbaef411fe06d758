/* Nanoseconds per particle for each sweep, the sort and the list build, beside STREAM triad in the same run.
 *
 * One process, one core. The particles are a block of a rest lattice in a tank, each moved by up to a fifth
 * of a spacing, with random velocities, so that nothing is in lattice order. Times are CPU times; the table
 * gives the least and the median of the repeats. Usage: bench_sweeps [PARTICLES [REPEATS]] */
#include "base/check.h"
#include "base/memory.h"
#include "full_tank.h"
#include "simulation/simulation.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MAX_REPEATS = 100, TRIAD_LENGTH = 20000000 };

static double cpu_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int ascending(const void *a, const void *b) {
  const double p = *(const double *)a, q = *(const double *)b;
  return (p > q) - (p < q);
}

/* One measured piece of work. */
typedef void work(hc_world *world);

static void bench(const char *name, work *run, hc_world *world, int repeats) {
  double seconds[MAX_REPEATS];
  for (int k = 0; k < repeats; k++) {
    const double start = cpu_seconds();
    run(world);
    seconds[k] = cpu_seconds() - start;
  }
  qsort(seconds, (size_t)repeats, sizeof *seconds, ascending);
  const double scale = 1e9 / world->fluid->own;
  printf("%-34s %8.1f %8.1f\n", name, scale * seconds[0], scale * seconds[repeats / 2]);
}

static void run_sort(hc_world *world) {
  hc_cells_bin(world->cells, world->fluid);
  hc_halo_mark(world->halo, world->cells);
  hc_cells_order(world->cells, world->fluid);
  hc_halo_build(world->halo, world->cells);
}

static void run_list(hc_world *world) {
  hc_neighbors_build(&world->list, &world->search, world->cells, world->fluid, hc_select_all(world->fluid),
                     &(hc_neighbor_source){world->cells, world->fluid}, 1);
}

static void run_walls(hc_world *world) {
  hc_neighbors_build(&world->walls, &world->search, world->cells, world->fluid, hc_select_all(world->fluid),
                     &(hc_neighbor_source){&world->stores[HC_STORE_BOUNDARY].cells, world->boundary}, 1);
}

static void run_density(hc_world *world) {
  world->sweeps->density(&world->sweep, hc_select_all(world->fluid));
}

static void run_error(hc_world *world) {
  const hc_error_rule rule = {.of_density = 1.0f, .of_rate = 1e-3f, .relaxation = 1.0f};
  hc_error_total total;
  memset(&total, 0, sizeof total);
  world->sweeps->error(&world->sweep, &rule, hc_select_all(world->fluid), &total);
}

static void run_pressure(hc_world *world) {
  world->sweeps->pressure(&world->sweep, 1e-6f, world->fluid->pressure_multiplier,
                          hc_select_all(world->fluid));
}

static void run_xsph(hc_world *world) {
  float *change = hc_particles_scratch(world->fluid, 3 * sizeof *change);
  world->sweeps->xsph(&world->sweep, 0.02f, change, hc_select_all(world->fluid));
}

static void run_laminar(hc_world *world) {
  float *change = hc_particles_scratch(world->fluid, 3 * sizeof *change);
  world->sweeps->laminar(&world->sweep, 1e-6f, change, hc_select_all(world->fluid));
}

static void run_smagorinsky(hc_world *world) {
  const hc_eddies eddies = hc_eddies_of(1e-6, 0.003, (double)world->sweep.support, 1e-3);
  float *change = hc_particles_scratch(world->fluid, 3 * sizeof *change);
  world->sweeps->smagorinsky(&world->sweep, &eddies, change, hc_select_all(world->fluid));
}

/* STREAM triad (McCalpin 1995): bytes moved per second as STREAM counts them. */
static double triad(void) {
  double *a = hc_alloc(TRIAD_LENGTH, sizeof *a), *b = hc_alloc(TRIAD_LENGTH, sizeof *b),
         *c = hc_alloc(TRIAD_LENGTH, sizeof *c), best = INFINITY;
  for (int k = 0; k < TRIAD_LENGTH; k++) {
    a[k] = 1.0;
    b[k] = 2.0;
    c[k] = 0.5;
  }
  for (int repeat = 0; repeat < 10; repeat++) {
    const double start = cpu_seconds();
    for (int k = 0; k < TRIAD_LENGTH; k++) a[k] = b[k] + 3.0 * c[k];
    best = fmin(best, cpu_seconds() - start);
    b[repeat] = a[repeat]; /* keeps the work alive */
  }
  hc_free(a);
  hc_free(b);
  hc_free(c);
  return 3.0 * sizeof(double) * TRIAD_LENGTH / best;
}

static void disturb(hc_world *world) {
  srand(1);
  for (int32_t k = 0; k < world->fluid->own; k++) {
    for (int axis = 0; axis < 3; axis++) {
      const double random = (double)rand() / RAND_MAX - 0.5;
      world->fluid->position[3 * (size_t)k + axis] +=
          (int64_t)(0.4 * random * (double)world->frame.spacing[axis]);
      world->fluid->velocity[3 * (size_t)k + axis] = (double)rand() / RAND_MAX - 0.5;
    }
  }
}

int main(int argc, char **argv) {
  hc_comm comm;
  hc_comm_start(&comm, &argc, &argv);
  const int64_t particles = argc > 1 ? atoll(argv[1]) : 1000000;
  int repeats = argc > 2 ? atoi(argv[2]) : 15;
  if (comm.size != 1 || particles < 1000 || repeats < 1) {
    fprintf(stderr, "usage: bench_sweeps [PARTICLES >= 1000 [REPEATS >= 1]], one process\n");
    hc_comm_finish(&comm);
    return 2;
  }
  if (repeats > MAX_REPEATS) repeats = MAX_REPEATS;

  hc_block block;
  hc_wall wall;
  const hc_scene scene = full_tank(particles, &block, &wall);
  hc_simulation simulation;
  hc_error error = {.status = HC_OK};
  HC_CHECK(hc_simulation_init(&simulation, &comm, &scene, &error) == HC_OK, "%s", error.text);
  hc_world *world = &simulation.world;
  disturb(world);
  hc_world_update(world);
  run_density(world);
  printf("particles %d, boundary %d, neighbours %.2f, instruction set %s, STREAM triad %.1f GB/s\n",
         world->fluid->own, world->boundary->own, (double)world->list.pairs / world->fluid->own,
         hc_isa_name(simulation.isa), 1e-9 * triad());
  printf("%-34s %8s %8s\n", "ns per fluid particle", "least", "median");
  bench("sort (bin, order, permute)", run_sort, world, repeats);
  bench("list build, fluid", run_list, world, repeats);
  bench("list build, walls", run_walls, world, repeats);
  bench("S1 density, alpha, walls", run_density, world, repeats);
  bench("S2 error (velocity divergence)", run_error, world, repeats);
  bench("S3 pressure", run_pressure, world, repeats);
  bench("XSPH", run_xsph, world, repeats);
  bench("laminar viscosity", run_laminar, world, repeats);
  bench("eddy viscosity", run_smagorinsky, world, repeats);
  hc_simulation_free(&simulation);
  hc_comm_finish(&comm);
  return 0;
}
