#include "scene.h"

#include "base/memory.h"

#include <string.h>

void hc_scene_free(hc_scene *scene) {
  hc_free(scene->fluid.blocks);
  hc_free(scene->fluid.emitters);
  for (int k = 0; k < scene->boundary.wall_count; k++) hc_free(scene->boundary.walls[k].motion.points);
  hc_free(scene->boundary.walls);
  hc_free(scene->output.gauges);
  memset(scene, 0, sizeof *scene);
}
