/* What the tests of whole runs share: a small block of fluid, whole steps of it, and what became of it. */
#ifndef HC_MPI_SCENE_H
#define HC_MPI_SCENE_H

#include "mpi_test.h"

#include "simulation/step.h"

#include <string.h>

static hc_block block;
static hc_wall wall;

/* The scene file's defaults with fewer iterations, and a block of fluid of these edges in metres. */
static inline hc_scene make_scene(double x, double y, double z) {
  hc_scene scene;
  memset(&scene, 0, sizeof scene);
  memset(&block, 0, sizeof block);
  memset(&wall, 0, sizeof wall);
  scene.particle_spacing = 0.02;
  scene.support_radius = 0.04;
  scene.end_time = 10.0;
  scene.fluid.rest_density = 1000.0;
  scene.fluid.mass_factor = 1.0;
  scene.fluid.viscosity.model = HC_VISCOSITY_XSPH;
  scene.fluid.viscosity.coefficient = 0.02;
  block.box = (hc_box){{0, 0, 0}, {x, y, z}};
  scene.fluid.blocks = &block;
  scene.fluid.block_count = 1;
  scene.solver.density_error_avg = 1e-4;
  scene.solver.divergence_error = 1e-3;
  scene.solver.density_iterations = (hc_iterations){2, 6};
  scene.solver.divergence_iterations = (hc_iterations){2, 4};
  scene.solver.warm_start = 0.5;
  scene.solver.relaxation = 1.0;
  scene.solver.min_divergence_neighbors = 20;
  scene.time_step.control = HC_TIME_CFL;
  scene.time_step.factor = 0.4;
  scene.time_step.max = 0.004;
  scene.parallel.rebalance = HC_REBALANCE_SLABS;
  scene.parallel.rebalance_above = 1.1;
  return scene;
}

/* The wall of the scene, to be called once; gravity downwards. */
static inline void add_wall(hc_scene *scene, double x, double y, double z, unsigned open) {
  wall.box = (hc_box){{0, 0, 0}, {x, y, z}};
  wall.open = open;
  scene->boundary.walls = &wall;
  scene->boundary.wall_count = 1;
  scene->boundary.contact = true;
  scene->gravity[2] = -9.81;
}

/* A run of all ranks from its scene, and steps of it; neither may fail. */
static inline void start_on(hc_simulation *simulation, hc_comm *ranks, const hc_scene *scene) {
  hc_error error = {.status = HC_OK, .text = ""};
  if (hc_simulation_init(simulation, ranks, scene, &error) != HC_OK) ck_abort_msg("%s", error.text);
}

static inline void start(hc_simulation *simulation, const hc_scene *scene) {
  start_on(simulation, &comm, scene);
}

static inline void do_steps(hc_simulation *simulation, int count) {
  hc_error error = {.status = HC_OK, .text = ""};
  for (int k = 0; k < count; k++)
    if (hc_simulation_step(simulation, &error) != HC_OK) ck_abort_msg("%s", error.text); /* on all ranks */
}

static inline int64_t fluid_in(const hc_simulation *simulation) {
  int64_t count = simulation->world.fluid->own;
  hc_comm_sum_i64(simulation->comm, &count, 1);
  return count;
}

/* Digests of the particles of all ranks together, and of these and all else that goes on. */
static inline uint64_t particles_of(const hc_simulation *simulation) {
  int64_t particles = (int64_t)hc_state_digest_particles(&simulation->state, HC_FLUID | HC_BOUNDARY);
  hc_comm_sum_i64(simulation->comm, &particles, 1);
  return (uint64_t)particles;
}

static inline uint64_t state_of(const hc_simulation *simulation) {
  return particles_of(simulation) ^ hc_state_digest_items(&simulation->state);
}

#endif
