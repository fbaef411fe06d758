/* Whole steps of a developed dam break: microseconds per fluid particle, by stage, on any number of ranks.
 *
 * A column of 0.8 m x 0.54 m x 0.6 m runs to 0.4 s (the front has nearly reached the far wall) with a loose
 * tolerance, then steps are timed twice: with exactly 2 density and 1 divergence iterations, and with the
 * default settings. With a boundary method as third argument the same with PCISPH: exactly 3 iterations, at a
 * step of half a millisecond for each centimetre of spacing; with wcsph as third argument with WCSPH at its
 * longest stable step. Times are wall-clock medians over the steps, the slowest rank counts. Usage: [mpirun
 * -n N] bench_step [SPACING [STEPS [METHOD]]]; 0.01 m makes 259,200 particles */
#include "simulation/step.h"
#include "base/check.h"
#include "base/memory.h"
#include "setup/solvers.h"
#include "solver/dfsph.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_STEPS = 200 };

static int ascending(const void *a, const void *b) {
  const double p = *(const double *)a, q = *(const double *)b;
  return (p > q) - (p < q);
}

static hc_scene make_scene(double spacing, hc_block *block, hc_wall *wall) {
  memset(block, 0, sizeof *block);
  memset(wall, 0, sizeof *wall);
  block->box = (hc_box){{0, 0, 0}, {0.8, 0.54, 0.6}};
  wall->box = (hc_box){{0, 0, 0}, {2.0, 0.54, 1.5}};
  hc_scene scene;
  memset(&scene, 0, sizeof scene);
  scene.particle_spacing = spacing;
  scene.support_radius = 2.0 * spacing;
  scene.gravity[2] = -9.81;
  scene.end_time = 2.0;
  scene.fluid.rest_density = 1000.0;
  scene.fluid.viscosity.model = HC_VISCOSITY_XSPH;
  scene.fluid.viscosity.coefficient = 0.02;
  scene.fluid.mass_factor = 1.0;
  scene.fluid.blocks = block;
  scene.fluid.block_count = 1;
  scene.boundary.walls = wall;
  scene.boundary.wall_count = 1;
  scene.boundary.contact = scene.boundary.depth_pressure = true;
  scene.boundary.wall_density = HC_WALL_DENSITY_SQUARED;
  wall->friction_law = HC_SCENE_FRICTION_SMOOTH;
  scene.fluid.kinematic_viscosity = 1e-6;
  scene.solver.gap_rule = true;
  scene.solver.density_error_avg = 1e-3;
  scene.solver.divergence_error = 1e-3;
  scene.solver.density_iterations = (hc_iterations){2, 100};
  scene.solver.divergence_iterations = (hc_iterations){1, 100};
  scene.solver.pressure_solve = HC_PRESSURE_SOLVE_FAST;
  scene.solver.relaxation = 1.0;
  scene.solver.min_divergence_neighbors = 20;
  scene.time_step.control = HC_TIME_CFL;
  scene.time_step.factor = 0.4;
  scene.time_step.max = 0.004;
  scene.parallel.rebalance = HC_REBALANCE_SLABS;
  scene.parallel.rebalance_above = 1.10;
  return scene;
}

static const struct {
  const char *name;
  hc_boundary_method method;
} methods[] = {{"ihmsen2010", HC_BOUNDARY_IHMSEN2010},
               {"becker2009", HC_BOUNDARY_BECKER2009},
               {"harada2007", HC_BOUNDARY_HARADA2007},
               {"akinci2012", HC_BOUNDARY_AKINCI2012}};

/* Makes it a scene for PCISPH; false for a name that no boundary method has. */
static bool use_pcisph(hc_scene *scene, const char *name) {
  scene->fluid.viscosity.model = HC_VISCOSITY_ARTIFICIAL;
  scene->solver.method = HC_SOLVER_PCISPH;
  scene->solver.density_error_avg = 0.01;
  scene->solver.density_iterations = (hc_iterations){3, 3};
  scene->boundary.friction = 1.0;
  scene->boundary.wall_density = HC_WALL_DENSITY_SUM;
  scene->solver.release_steps = 100;
  scene->time_step.control = HC_TIME_CONSTANT;
  scene->time_step.size = scene->time_step.max = 0.05 * scene->particle_spacing;
  for (size_t k = 0; k < sizeof methods / sizeof *methods; k++) {
    if (strcmp(methods[k].name, name) != 0) continue;
    scene->boundary.method = methods[k].method;
    return true;
  }
  return false;
}

/* Makes it one for WCSPH, with the longest step that is stable. */
static void use_wcsph(hc_scene *scene) {
  scene->fluid.viscosity.model = HC_VISCOSITY_ARTIFICIAL;
  scene->fluid.viscosity.coefficient = 0.1;
  scene->solver.method = HC_SOLVER_WCSPH;
  scene->solver.density_fluctuation = 0.01;
  scene->time_step.control = HC_TIME_CONSTANT;
  scene->time_step.size = scene->time_step.max = hc_setup_solver_longest(scene);
}

static void advance(hc_simulation *simulation) {
  hc_error error = {.status = HC_OK};
  HC_CHECK(hc_simulation_step(simulation, &error) == HC_OK, "%s", error.text);
}

/* Times `steps` steps and prints their median and what each stage took. */
static void measure(hc_simulation *simulation, const char *name, int steps) {
  hc_comm *comm = simulation->comm;
  hc_world *world = &simulation->world;
  double seconds[MAX_STEPS], before[HC_STAGE_COUNT], iterations[2] = {0.0, 0.0};
  memcpy(before, world->watch.seconds, sizeof before);
  const double waited = comm->wait_seconds;
  for (int k = 0; k < steps; k++) {
    hc_comm_barrier(comm);
    const double start = hc_seconds();
    advance(simulation);
    seconds[k] = hc_seconds() - start;
    iterations[0] += (double)simulation->report.density_iterations / steps;
    iterations[1] += (double)simulation->report.divergence_iterations / steps;
  }
  hc_comm_max_f64(comm, seconds, steps);
  double communication = comm->wait_seconds - waited;
  hc_comm_max_f64(comm, &communication, 1);
  hc_stopwatch_enter(&world->watch, HC_STAGE_MOVE);
  double stage[HC_STAGE_COUNT], total = 0.0;
  for (int k = 0; k < HC_STAGE_COUNT; k++) stage[k] = world->watch.seconds[k] - before[k];
  hc_comm_max_f64(comm, stage, HC_STAGE_COUNT);
  for (int k = 0; k < steps; k++) total += seconds[k];
  qsort(seconds, (size_t)steps, sizeof *seconds, ascending);
  if (comm->rank != 0) return;
  printf("%s: %.2f density + %.2f divergence iterations, %.3f us per particle and step (least %.3f), "
         "communication %.1f %%\n",
         name, iterations[0], iterations[1], 1e6 * seconds[steps / 2] / (double)world->fluid_total,
         1e6 * seconds[0] / (double)world->fluid_total, 100.0 * communication / total);
  for (int k = 0; k < HC_STAGE_COUNT; k++)
    if (stage[k] > 0.0)
      printf("  %-10s %8.1f ns\n", hc_stage_name((hc_stage)k),
             1e9 * stage[k] / steps / (double)world->fluid_total);
}

static void measure_dfsph(hc_simulation *simulation, int steps) {
  hc_dfsph_settings *settings = (hc_dfsph_settings *)simulation->solver_settings;
  settings->density_max = 2;
  settings->divergence_max = 1;
  measure(simulation, "fixed", steps);
  settings->density_max = settings->divergence_max = 100;
  settings->density_error_avg = 1e-4;
  for (int k = 0; k < 10; k++) advance(simulation); /* lets the finer tolerance settle */
  measure(simulation, "default settings", steps);
}

int main(int argc, char **argv) {
  hc_comm comm;
  hc_comm_start(&comm, &argc, &argv);
  const double spacing = argc > 1 ? atof(argv[1]) : 0.01;
  const int steps = argc > 2 ? atoi(argv[2]) : 20;
  hc_block block;
  hc_wall wall;
  hc_scene scene = make_scene(spacing, &block, &wall);
  const bool wcsph = argc > 3 && strcmp(argv[3], "wcsph") == 0, other = argc > 3;
  if (wcsph) use_wcsph(&scene);
  if (!(spacing > 0.0) || steps < 1 || steps > MAX_STEPS ||
      (other && !wcsph && !use_pcisph(&scene, argv[3]))) {
    if (comm.rank == 0)
      fprintf(stderr, "usage: bench_step [SPACING [STEPS of 1 to %d [BOUNDARY METHOD | wcsph]]]\n",
              MAX_STEPS);
    hc_comm_finish(&comm);
    return 2;
  }
  hc_simulation *simulation = hc_alloc_zero(1, sizeof *simulation);
  hc_error error = {.status = HC_OK};
  HC_CHECK(hc_simulation_init(simulation, &comm, &scene, &error) == HC_OK, "%s", error.text);
  while (simulation->time < 0.4) advance(simulation);
  if (comm.rank == 0)
    printf("%lld fluid and %lld boundary particles on %d ranks, instruction set %s, %lld steps to %.3f s\n",
           (long long)simulation->world.fluid_total, (long long)simulation->world.boundary_total, comm.size,
           hc_isa_name(simulation->isa), (long long)simulation->step, simulation->time);

  if (other)
    measure(simulation, argv[3], steps);
  else
    measure_dfsph(simulation, steps);
  hc_simulation_free(simulation);
  hc_free(simulation);
  hc_comm_finish(&comm);
  return 0;
}
