/* What benchmarks of single parts work on: a cube of fluid at rest that fills the lower two thirds of a tank.
 */
#ifndef HC_FULL_TANK_H
#define HC_FULL_TANK_H

#include "scene/scene.h"

#include <math.h>
#include <string.h>

/* `block` and `wall` become part of the scene. */
static inline hc_scene full_tank(int64_t particles, hc_block *block, hc_wall *wall) {
  const double edge = 0.02 * round(cbrt((double)particles));
  memset(block, 0, sizeof *block);
  memset(wall, 0, sizeof *wall);
  block->box = (hc_box){{0, 0, 0}, {edge, edge, edge}};
  wall->box = (hc_box){{0, 0, 0}, {edge, edge, 1.5 * edge}};
  wall->open = HC_FACE_PLUS_Z;
  hc_scene scene;
  memset(&scene, 0, sizeof scene);
  scene.particle_spacing = 0.02;
  scene.support_radius = 0.04;
  scene.end_time = 1.0;
  scene.fluid.rest_density = 1000.0;
  scene.fluid.mass_factor = 1.0;
  scene.fluid.blocks = block;
  scene.fluid.block_count = 1;
  scene.boundary.walls = wall;
  scene.boundary.wall_count = 1;
  return scene;
}

#endif
