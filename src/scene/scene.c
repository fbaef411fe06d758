#include "scene.h"

#include "base/memory.h"

#include <string.h>

static void free_form(hc_revolution *revolution, hc_made_surface *made) {
  hc_free(revolution->profile);
  if (made->surface) made->free(made->surface);
}

void hc_scene_free(hc_scene *scene) {
  for (int k = 0; k < scene->fluid.block_count; k++)
    free_form(&scene->fluid.blocks[k].revolution, &scene->fluid.blocks[k].made);
  for (int k = 0; k < scene->boundary.wall_count; k++)
    free_form(&scene->boundary.walls[k].revolution, &scene->boundary.walls[k].made);
  hc_free(scene->fluid.blocks);
  hc_free(scene->fluid.emitters);
  for (int k = 0; k < scene->boundary.wall_count; k++) hc_free(scene->boundary.walls[k].motion.points);
  hc_free(scene->boundary.walls);
  hc_free(scene->output.gauges);
  memset(scene, 0, sizeof *scene);
}
