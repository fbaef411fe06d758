#include "absorptions.h"

#include "base/memory.h"
#include "setup/samples.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

hc_source_name hc_setup_absorption_name(const hc_scene *scene, int number) {
  hc_source_name name;
  snprintf(name.text, sizeof name.text, "absorption[%d] at \"%.*s\"", number, HC_NAME_LENGTH,
           scene->absorptions[number].wall);
  return name;
}

static hc_absorber make_absorber(const hc_scene *scene, const hc_setup_plan *plan, int number) {
  const hc_scene_absorption *const given = &scene->absorptions[number];
  return (hc_absorber){.shape = plan->boundary[hc_scene_surface_named(scene, given->wall)].shape,
                       .height = given->ocean_height,
                       .nearest = 0.5 * given->inflow_distance * scene->particle_spacing,
                       .density = given->inflow_density,
                       .reach = given->outflow_distance * plan->frame.support_radius,
                       .source = (uint64_t)(scene->fluid.block_count + scene->fluid.emitter_count + number)};
}

static double (*currents(const hc_scene *scene))[3] {
  bool any = false;
  for (int k = 0; k < scene->boundary.wall_count; k++)
    for (int a = 0; a < 3; a++) any |= scene->boundary.walls[k].surface_velocity[a] != 0.0;
  if (!any) return NULL;
  double(*const made)[3] = hc_alloc_zero((size_t)hc_scene_surfaces(scene), sizeof *made);
  for (int k = 0; k < scene->boundary.wall_count; k++)
    memcpy(made[k], scene->boundary.walls[k].surface_velocity, sizeof made[k]);
  return made;
}

hc_status hc_setup_absorption(const hc_scene *scene, const hc_setup_plan *plan, hc_absorption *absorption,
                              hc_error *error) {
  *absorption = (hc_absorption){.count = scene->absorption_count};
  if (absorption->count == 0) return HC_OK;
  hc_places_init(&absorption->places, HC_INFLOW);
  absorption->absorbers = hc_alloc((size_t)absorption->count, sizeof *absorption->absorbers);
  for (int k = 0; k < absorption->count; k++) absorption->absorbers[k] = make_absorber(scene, plan, k);
  absorption->current = currents(scene);
  double square = 0.0;
  for (int a = 0; a < 3; a++) square += scene->gravity[a] * scene->gravity[a];
  for (int a = 0; a < 3; a++) absorption->up[a] = -scene->gravity[a] / sqrt(square);
  if (scene->fluid.block_count + scene->fluid.emitter_count + absorption->count > HC_ID_MAX_SOURCES)
    return hc_error_set(error, HC_BAD_INPUT,
                        "fluid.blocks, fluid.emitters and absorption must have at most 2^%d entries together",
                        HC_ID_SOURCE_BITS);
  return hc_setup_sample_numbers(plan, &absorption->samples, error);
}
