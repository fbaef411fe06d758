#include "scene.h"

#include "base/memory.h"

#include <string.h>

static void free_made(hc_made_surface *made) {
  if (made->surface) made->free(made->surface);
  made->surface = NULL;
}

static void free_rest(hc_made_rest_state *rest) {
  if (rest->state) rest->free(rest->state);
  rest->state = NULL;
}

void hc_scene_free_surfaces(hc_scene *scene) {
  for (int k = 0; k < scene->fluid.block_count; k++) {
    free_made(&scene->fluid.blocks[k].made);
    free_rest(&scene->fluid.blocks[k].rest);
  }
  for (int k = 0; k < scene->boundary.wall_count; k++) free_made(&scene->boundary.walls[k].made);
  for (int k = 0; k < scene->body_count; k++) free_made(&scene->bodies[k].surface.made);
  hc_memory_give_back();
}

void hc_scene_free(hc_scene *scene) {
  hc_scene_free_surfaces(scene);
  for (int k = 0; k < scene->fluid.block_count; k++) hc_free(scene->fluid.blocks[k].revolution.profile);
  for (int k = 0; k < scene->boundary.wall_count; k++) {
    hc_free(scene->boundary.walls[k].revolution.profile);
    hc_free(scene->boundary.walls[k].motion.points);
  }
  for (int k = 0; k < scene->body_count; k++) {
    hc_free(scene->bodies[k].surface.revolution.profile);
    hc_free(scene->bodies[k].forces);
    hc_free(scene->bodies[k].moorings);
  }
  hc_free(scene->fluid.blocks);
  hc_free(scene->fluid.emitters);
  hc_free(scene->boundary.walls);
  hc_free(scene->bodies);
  hc_free(scene->absorptions);
  hc_free(scene->output.gauges);
  memset(scene, 0, sizeof *scene);
}

const char *const *hc_scene_gauge_parts(hc_gauge_type type) {
  static const char *const none[] = {NULL}, *const energy[] = {"kinetic", "potential", NULL},
                           *const force[] = {"fx", "fy", "fz", "mx", "my", "mz", NULL},
                           *const body[] = {"x",  "y",  "z",  "roll", "pitch", "yaw", "vx", "vy", "vz", "wx",
                                            "wy", "wz", "fx", "fy",   "fz",    "mx",  "my", "mz", NULL};
  switch (type) {
  case HC_GAUGE_FORCE:
    return force;
  case HC_GAUGE_ENERGY:
    return energy;
  case HC_GAUGE_BODY:
    return body;
  default:
    return none;
  }
}

int hc_scene_surfaces(const hc_scene *scene) {
  return scene->boundary.wall_count + scene->body_count;
}

bool hc_scene_is_body(const hc_scene *scene, int number) {
  return number >= scene->boundary.wall_count;
}

const hc_wall *hc_scene_surface(const hc_scene *scene, int number) {
  return hc_scene_is_body(scene, number) ? &scene->bodies[number - scene->boundary.wall_count].surface
                                         : &scene->boundary.walls[number];
}

int hc_scene_surface_named(const hc_scene *scene, const char *name) {
  for (int k = 0; k < hc_scene_surfaces(scene); k++)
    if (*name && strcmp(hc_scene_surface(scene, k)->name, name) == 0) return k;
  return -1;
}

bool hc_scene_stands(const hc_scene *scene, int number) {
  return !hc_scene_is_body(scene, number) && scene->boundary.walls[number].motion.type == HC_WALL_STANDS;
}

bool hc_scene_has_window(const hc_scene *scene) {
  return scene->window.follow[0] != '\0';
}
