/* What the tests of whole runs share: a small block of fluid, and whole steps of it. */
#ifndef HC_MPI_SCENE_H
#define HC_MPI_SCENE_H

#include "mpi_test.h"

#include "app/simulation.h"

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

#endif
