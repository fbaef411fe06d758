/* halocline check: what a run would be, for people or as one JSON object.
 *
 * The keys of the JSON object: scene, particle_spacing, support_radius, end_time; fluid, boundary: particles;
 * emitters: a list of {name, layer (particles), most (particles until the end), speed, rate}; fluid_most:
 * with all that emitters bring; blocks, walls: lists of {name, particles, extent} and, for walls that move,
 * swept; extents: {fluid, boundary, all}; an extent is {low [3], high [3]} of the particles' positions in m,
 * or null where there are none; periodic [3]: {low, high} in m or null for each axis; limits [3]: likewise,
 * of the world; leaving: what particles beyond do; first_step: {dt, bound}; steps, steps_exact (else they are
 * the fewest); ranks; memory_per_rank: bytes, {total, program, fluid, boundary, ghosts, writing}; output:
 * {snapshots, snapshot_bytes, checkpoint_bytes, total_bytes}. Estimates are those of estimate.h. */
#include "commands.h"
#include "estimate.h"
#include "geometry/solid.h"
#include "io/json.h"
#include "io/rest_file.h"
#include "io/text.h"
#include "setup/scene_input.h"
#include "setup/source.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

static const double mebibyte = 1048576.0;

static const char *leaving_name(const hc_scene *scene) {
  return scene->domain.leaving == HC_LEAVING_REMOVE ? "remove" : "error";
}

/* ---- text ---- */

static void put_body(const hc_scene_body *body) {
  const hc_shape shape = hc_source_wall_shape(&body->surface);
  const double volume = hc_solid_of(&shape).volume,
               mass = body->mass > 0.0 ? body->mass : body->density * volume;
  printf("    a body of         %.6g kg, %.6g kg/m3\n", mass, mass / volume);
}

static void put_set(const char *name, const hc_estimate_set *set) {
  const double *low = set->low, *high = set->high;
  printf("%-19s %" PRId64, name, set->count);
  if (set->count > 0)
    printf(", (%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g) m", low[0], low[1], low[2], high[0], high[1], high[2]);
  printf("\n");
}

static void put_particles(const hc_scene *scene, const hc_estimate *estimate) {
  put_set("fluid particles", &estimate->fluid);
  for (int k = 0; k < scene->fluid.block_count; k++) {
    printf("  ");
    put_set(hc_source_block_name(k).text, &estimate->blocks[k]);
  }
  for (int k = 0; k < scene->fluid.emitter_count; k++) {
    const hc_estimate_emitter *emitter = &estimate->emitters[k];
    printf("  %-19s %" PRId64 " a layer at %.6g m/s, %.6g m3/s, at most %" PRId64 " until the end\n",
           hc_prescribed_emitter_name(k).text, emitter->samples, emitter->speed, emitter->rate,
           emitter->most);
  }
  put_set("boundary particles", &estimate->boundary);
  for (int k = 0; k < hc_scene_surfaces(scene); k++) {
    printf("  ");
    put_set(hc_source_surface_name(scene, k).text, &estimate->walls[k]);
    if (hc_scene_is_body(scene, k)) put_body(&scene->bodies[k - scene->boundary.wall_count]);
    if (estimate->swept[k].count > 0)
      printf("    moves within      (%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g) m\n", estimate->swept[k].low[0],
             estimate->swept[k].low[1], estimate->swept[k].low[2], estimate->swept[k].high[0],
             estimate->swept[k].high[1], estimate->swept[k].high[2]);
  }
  put_set("all particles", &estimate->all);
  for (int axis = 0; axis < 3; axis++)
    if (scene->domain.periodic[axis])
      printf("periodic along %c    from %g to %g m\n", "xyz"[axis], scene -> domain.min[axis],
             scene->domain.max[axis]);
}

static void put_limits(const hc_scene *scene, const hc_estimate *estimate) {
  const double *low = estimate->limits_low, *high = estimate->limits_high;
  printf("limits of the world");
  const char *separator = " ";
  for (int axis = 0; axis < 3; axis++) {
    if (isinf(low[axis])) continue;
    printf("%s%c %.6g to %.6g", separator, "xyz"[axis], low[axis], high[axis]);
    separator = ", ";
  }
  if (*separator == ' ')
    printf(" none\n");
  else
    printf(" m; beyond: %s\n", leaving_name(scene));
}

static void put_memory(const hc_estimate *estimate) {
  const struct {
    const char *name;
    double bytes;
  } parts[] = {{"program", estimate->memory_program},
               {"fluid", estimate->memory_fluid},
               {"boundary", estimate->memory_boundary},
               {"ghosts", estimate->memory_ghosts},
               {"writing", estimate->memory_writing}};
  printf("memory per rank     about %.0f MiB on %" PRId64 " rank%s:", estimate->memory / mebibyte,
         estimate->ranks, estimate->ranks == 1 ? "" : "s");
  for (size_t k = 0; k < sizeof parts / sizeof *parts; k++)
    printf("%s %s %.1f", k ? "," : "", parts[k].name, parts[k].bytes / mebibyte);
  printf("\n");
}

typedef struct size_text {
  char text[32];
} size_text;

static size_text size_of(double bytes) {
  size_text size;
  const bool large = bytes >= 1e9;
  snprintf(size.text, sizeof size.text, "%.2f %s", bytes / (large ? 1e9 : 1e6), large ? "GB" : "MB");
  return size;
}

static void put_window(const hc_scene *scene) {
  if (!hc_scene_has_window(scene)) return;
  printf("window              \"%s\" follows \"%s\", which may get %g m away\n", scene->window.wall,
         scene->window.follow, scene->window.trigger * scene->support_radius);
}

static void put_text(const hc_scene *scene, const hc_estimate *estimate) {
  char number[HC_TEXT_NUMBER];
  printf("scene               %s\n", scene->name);
  printf("particle spacing    %g m, support radius %g m\n", scene->particle_spacing, scene->support_radius);
  put_particles(scene, estimate);
  put_limits(scene, estimate);
  put_window(scene);
  printf("first time step     %s s, bounded by: %s\n", hc_text_number(number, estimate->first_step),
         hc_step_bound_name(estimate->bound));
  printf("end time            %g s, %s%" PRId64 " steps\n", scene->end_time,
         estimate->steps_exact ? "" : "at least ", estimate->steps);
  put_memory(estimate);
  printf("output              about %s: at most %" PRId64 " snapshots of %s\n",
         size_of(estimate->output_bytes).text, estimate->snapshots, size_of(estimate->snapshot_bytes).text);
  printf("checkpoints         %s each, %d kept and one more while it is written\n",
         size_of(estimate->checkpoint_bytes).text, scene->output.checkpoints_keep);
}

/* ---- JSON ---- */

static void put_json_extent(hc_json *json, const char *name, const hc_estimate_set *set) {
  hc_json_extent(json, name, set->count > 0, set->low, set->high);
}

/* `swept`: of a wall that moves; else null or empty. */
static void put_json_source(hc_json *json, const char *name, const hc_estimate_set *set,
                            const hc_estimate_set *swept) {
  hc_json_object(json, NULL, HC_JSON_DENSE);
  hc_json_string(json, "name", name);
  hc_json_integer(json, "particles", set->count);
  put_json_extent(json, "extent", set);
  if (swept && swept->count > 0) put_json_extent(json, "swept", swept);
  hc_json_end(json);
}

static void put_json_emitters(hc_json *json, const hc_scene *scene, const hc_estimate *estimate) {
  hc_json_integer(json, "fluid_most", estimate->fluid_most);
  hc_json_list(json, "emitters", HC_JSON_DENSE);
  for (int k = 0; k < scene->fluid.emitter_count; k++) {
    const hc_estimate_emitter *emitter = &estimate->emitters[k];
    hc_json_object(json, NULL, HC_JSON_DENSE);
    hc_json_string(json, "name", hc_prescribed_emitter_name(k).text);
    hc_json_integer(json, "layer", emitter->samples);
    hc_json_integer(json, "most", emitter->most);
    hc_json_number(json, "speed", emitter->speed);
    hc_json_number(json, "rate", emitter->rate);
    hc_json_end(json);
  }
  hc_json_end(json);
}

/* A list of {low, high}, null along axes that have none. */
static void put_json_ranges(hc_json *json, const char *name, const bool has[3], const double low[3],
                            const double high[3]) {
  hc_json_list(json, name, HC_JSON_DENSE);
  for (int axis = 0; axis < 3; axis++) {
    if (!has[axis]) {
      hc_json_null(json, NULL);
      continue;
    }
    hc_json_object(json, NULL, HC_JSON_DENSE);
    hc_json_number(json, "low", low[axis]);
    hc_json_number(json, "high", high[axis]);
    hc_json_end(json);
  }
  hc_json_end(json);
}

static void put_json_sources(hc_json *json, const hc_scene *scene, const hc_estimate *estimate) {
  hc_json_integer(json, "fluid", estimate->fluid.count);
  hc_json_integer(json, "boundary", estimate->boundary.count);
  hc_json_list(json, "blocks", HC_JSON_DENSE);
  for (int k = 0; k < scene->fluid.block_count; k++)
    put_json_source(json, hc_source_block_name(k).text, &estimate->blocks[k], NULL);
  hc_json_end(json);
  hc_json_list(json, "walls", HC_JSON_DENSE);
  for (int k = 0; k < hc_scene_surfaces(scene); k++)
    put_json_source(json, hc_source_surface_name(scene, k).text, &estimate->walls[k], &estimate->swept[k]);
  hc_json_end(json);
}

static void put_json_extents(hc_json *json, const hc_scene *scene, const hc_estimate *estimate) {
  hc_json_object(json, "extents", HC_JSON_DENSE);
  put_json_extent(json, "fluid", &estimate->fluid);
  put_json_extent(json, "boundary", &estimate->boundary);
  put_json_extent(json, "all", &estimate->all);
  hc_json_end(json);
  put_json_ranges(json, "periodic", scene->domain.periodic, scene->domain.min, scene->domain.max);
  bool limited[3];
  for (int axis = 0; axis < 3; axis++) limited[axis] = isfinite(estimate->limits_low[axis]);
  put_json_ranges(json, "limits", limited, estimate->limits_low, estimate->limits_high);
  hc_json_string(json, "leaving", leaving_name(scene));
}

/* A number of bytes, whole. */
static void put_json_bytes(hc_json *json, const char *name, double bytes) {
  hc_json_number(json, name, nearbyint(bytes));
}

static void put_json_costs(hc_json *json, const hc_estimate *estimate) {
  hc_json_integer(json, "ranks", estimate->ranks);
  hc_json_object(json, "memory_per_rank", HC_JSON_DENSE);
  put_json_bytes(json, "total", estimate->memory);
  put_json_bytes(json, "program", estimate->memory_program);
  put_json_bytes(json, "fluid", estimate->memory_fluid);
  put_json_bytes(json, "boundary", estimate->memory_boundary);
  put_json_bytes(json, "ghosts", estimate->memory_ghosts);
  put_json_bytes(json, "writing", estimate->memory_writing);
  hc_json_end(json);
  hc_json_object(json, "output", HC_JSON_DENSE);
  hc_json_integer(json, "snapshots", estimate->snapshots);
  put_json_bytes(json, "snapshot_bytes", estimate->snapshot_bytes);
  put_json_bytes(json, "checkpoint_bytes", estimate->checkpoint_bytes);
  put_json_bytes(json, "total_bytes", estimate->output_bytes);
  hc_json_end(json);
}

static void put_json(const hc_scene *scene, const hc_estimate *estimate) {
  hc_json json;
  hc_json_begin(&json, stdout, false);
  hc_json_object(&json, NULL, HC_JSON_DENSE);
  hc_json_string(&json, "scene", scene->name);
  hc_json_number(&json, "particle_spacing", scene->particle_spacing);
  hc_json_number(&json, "support_radius", scene->support_radius);
  hc_json_number(&json, "end_time", scene->end_time);
  put_json_sources(&json, scene, estimate);
  put_json_extents(&json, scene, estimate);
  put_json_emitters(&json, scene, estimate);
  hc_json_object(&json, "first_step", HC_JSON_DENSE);
  hc_json_number(&json, "dt", estimate->first_step);
  hc_json_string(&json, "bound", hc_step_bound_name(estimate->bound));
  hc_json_end(&json);
  hc_json_integer(&json, "steps", estimate->steps);
  hc_json_bool(&json, "steps_exact", estimate->steps_exact);
  put_json_costs(&json, estimate);
  hc_json_end(&json);
}

int hc_command_check(const hc_options *options) {
  hc_error error = {.status = HC_OK};
  hc_scene scene;
  hc_estimate estimate;
  const char *names[HC_FIELD_COUNT];
  hc_scene_files files = {.read_rest = hc_rest_file_read};
  const hc_scene_limits limits = hc_scene_input_limits(names, &files);
  hc_warnings warnings = {0};
  hc_scene_read(&scene, options->files[0], options->overrides, options->override_count, &limits, &warnings,
                &error);
  hc_warnings_print(&warnings, 0);
  hc_warnings_free(&warnings);
  if (error.status != HC_OK) return hc_command_fail(&error);
  if (hc_estimate_make(&scene, options->ranks, &estimate, &error) == HC_OK) {
    (options->json ? put_json : put_text)(&scene, &estimate);
    hc_estimate_free(&estimate);
  }
  hc_scene_free(&scene);
  return error.status == HC_OK ? hc_command_finish_output() : hc_command_fail(&error);
}
