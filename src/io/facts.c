#include "facts.h"

void hc_facts_put(hid_t group, const hc_scene *scene, const hc_moment *moment, int64_t fluid,
                  int64_t boundary, hc_error *problem) {
  const hc_frame *frame = moment->frame;
  const int64_t format = HC_FACTS_FORMAT;
  hc_h5_put_i64(group, "format_version", 1, &format, problem);
  hc_h5_put_text(group, "program_version", HC_VERSION, problem);
  hc_h5_put_text(group, "scene", scene->name, problem);
  hc_h5_put_f64(group, "time", 1, &moment->time, problem);
  hc_h5_put_i64(group, "step", 1, &moment->step, problem);
  hc_h5_put_f64(group, "dt", 1, &moment->dt, problem);
  hc_h5_put_f64(group, "particle_spacing", 1, &scene->particle_spacing, problem);
  hc_h5_put_f64(group, "support_radius", 1, &frame->support_radius, problem);
  hc_h5_put_f64(group, "rest_density", 1, &scene->fluid.rest_density, problem);
  hc_h5_put_f64(group, "particle_mass", 1, &moment->particle_mass, problem);
  hc_h5_put_f64(group, "gravity", 3, scene->gravity, problem);
  hc_h5_put_f64(group, "unit", 3, frame->unit, problem);
  hc_h5_put_i64(group, "origin", 3, frame->origin, problem);
  hc_h5_put_i64(group, "period", 3, frame->period, problem);
  hc_h5_put_i64(group, "low", 3, frame->low, problem);
  hc_h5_put_i64(group, "fluid_particles", 1, &fluid, problem);
  hc_h5_put_i64(group, "boundary_particles", 1, &boundary, problem);
}

void hc_facts_put_fields(hid_t group, const int *fields, int count, hc_error *problem) {
  const hid_t units = hc_h5_create_group(group, "units", problem),
              kinds = hc_h5_create_group(group, "kinds", problem);
  for (int k = 0; k < count; k++) {
    const hc_field_info *info = &hc_fields[fields[k]];
    const bool of_walls = info->flags & (HC_BOUNDARY | HC_MOVED);
    const int64_t who = (info->flags & HC_FLUID) | (of_walls ? HC_BOUNDARY : 0);
    hc_h5_put_text(units, info->name, info->unit, problem);
    hc_h5_put_i64(kinds, info->name, 1, &who, problem);
  }
  hc_h5_close_group(kinds, problem);
  hc_h5_close_group(units, problem);
}
