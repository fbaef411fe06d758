#include "scene.h"

#include "base/memory.h"

#include <string.h>

static void free_made(hc_made_surface *made) {
  if (made->surface) made->free(made->surface);
  made->surface = NULL;
}

void hc_scene_free_surfaces(hc_scene *scene) {
  for (int k = 0; k < scene->fluid.block_count; k++) free_made(&scene->fluid.blocks[k].made);
  for (int k = 0; k < scene->boundary.wall_count; k++) free_made(&scene->boundary.walls[k].made);
  hc_memory_give_back();
}

void hc_scene_free(hc_scene *scene) {
  hc_scene_free_surfaces(scene);
  for (int k = 0; k < scene->fluid.block_count; k++) hc_free(scene->fluid.blocks[k].revolution.profile);
  for (int k = 0; k < scene->boundary.wall_count; k++) {
    hc_free(scene->boundary.walls[k].revolution.profile);
    hc_free(scene->boundary.walls[k].motion.points);
  }
  hc_free(scene->fluid.blocks);
  hc_free(scene->fluid.emitters);
  hc_free(scene->boundary.walls);
  hc_free(scene->output.gauges);
  memset(scene, 0, sizeof *scene);
}

const char *const *hc_scene_gauge_parts(hc_gauge_type type) {
  static const char *const none[] = {NULL}, *const energy[] = {"kinetic", "potential", NULL},
                           *const force[] = {"fx", "fy", "fz", "mx", "my", "mz", NULL};
  return type == HC_GAUGE_FORCE ? force : type == HC_GAUGE_ENERGY ? energy : none;
}
