/* The scene room: defaults, every kind of error with its text, overrides, round trip, keys. */
#include "base/memory.h"
#include "scene/params.h"
#include "scene/reader.h"
#include "scene/scene.h"
#include "scene/writer.h"
#include "setup/methods.h"

#include <check.h>
#include <glob.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define SMALLEST "particle_spacing: 0.02\nend_time: 2\n"

static const char *const fields[] = {"id", "velocity", "density", "pressure"};
static const hc_scene_limits limits = {
    .snapshot_fields = fields, .snapshot_field_count = 4, .complete = hc_setup_complete};

/* Reads `text` with up to one override (may be null). */
static hc_status read_with(hc_scene *scene, const char *text, const char *override, hc_error *error) {
  return hc_scene_read_text(scene, "folder/t.yaml", text, strlen(text), &override, override ? 1 : 0, &limits,
                            NULL, error);
}

static hc_scene read_good(const char *text, const char *override) {
  hc_scene scene;
  hc_error error = {.text = ""};
  const hc_status status = read_with(&scene, text, override, &error);
  ck_assert_msg(status == HC_OK, "%s", error.text);
  return scene;
}

/* The whole text of the error must be `expected`. */
static void refuse_text(const char *text, const char *override, const char *expected) {
  hc_scene scene;
  hc_error error = {.text = ""};
  ck_assert_int_eq(read_with(&scene, text, override, &error), HC_BAD_INPUT);
  ck_assert_int_eq(error.status, HC_BAD_INPUT);
  ck_assert_str_eq(error.text, expected);
  ck_assert_ptr_null(scene.fluid.blocks);
  ck_assert_ptr_null(scene.boundary.walls);
}

/* One error; `message` begins with line and column, which say what source line and caret follow. */
static void refuse(const char *text, const char *message) {
  int line = 0, column = 0;
  ck_assert_int_eq(sscanf(message, "%d:%d", &line, &column), 2);
  const char *shown = text;
  for (int k = 1; k < line; k++) shown = strchr(shown, '\n') + 1;
  char expected[2048];
  snprintf(expected, sizeof expected, "folder/t.yaml:%s\n%.*s\n%*s", message, (int)strcspn(shown, "\n"),
           shown, column, "^");
  refuse_text(text, NULL, expected);
}

/* One error in a line below the smallest scene; `message` begins with the column. */
static void refuse_line(const char *line, const char *message) {
  char text[1024], placed[1024];
  snprintf(text, sizeof text, SMALLEST "%s\n", line);
  snprintf(placed, sizeof placed, "3:%s", message);
  refuse(text, placed);
}

static void refuse_set(const char *override, const char *message) {
  char expected[1024];
  snprintf(expected, sizeof expected, "--set %s: %s", override, message);
  refuse_text(SMALLEST, override, expected);
}

static void expect_same_body(const hc_scene_body *a, const hc_scene_body *b) {
  hc_scene_body left, right;
  memcpy(&left, a, sizeof left);
  memcpy(&right, b, sizeof right);
  ck_assert_int_eq(left.force_count, right.force_count);
  ck_assert_int_eq(left.mooring_count, right.mooring_count);
  const size_t forces = (size_t)left.force_count * sizeof *left.forces,
               moorings = (size_t)left.mooring_count * sizeof *left.moorings;
  if (forces) ck_assert_mem_eq(left.forces, right.forces, forces);
  if (moorings) ck_assert_mem_eq(left.moorings, right.moorings, moorings);
  left.forces = right.forces = NULL;
  left.moorings = right.moorings = NULL;
  ck_assert_mem_eq(&left, &right, sizeof left);
}

/* All bytes but the pointers. */
static void expect_same(const hc_scene *a, const hc_scene *b) {
  ck_assert_int_eq(a->fluid.block_count, b->fluid.block_count);
  ck_assert_int_eq(a->boundary.wall_count, b->boundary.wall_count);
  const size_t block_bytes = (size_t)a->fluid.block_count * sizeof *a->fluid.blocks;
  const size_t wall_bytes = (size_t)a->boundary.wall_count * sizeof *a->boundary.walls;
  if (block_bytes) ck_assert_mem_eq(a->fluid.blocks, b->fluid.blocks, block_bytes);
  for (int k = 0; wall_bytes && k < a->boundary.wall_count; k++) {
    hc_wall left, right;
    memcpy(&left, &a->boundary.walls[k], sizeof left);
    memcpy(&right, &b->boundary.walls[k], sizeof right);
    const size_t point_bytes = (size_t)left.motion.point_count * sizeof *left.motion.points;
    ck_assert_int_eq(left.motion.point_count, right.motion.point_count);
    if (point_bytes) ck_assert_mem_eq(left.motion.points, right.motion.points, point_bytes);
    left.motion.points = right.motion.points = NULL;
    ck_assert_mem_eq(&left, &right, sizeof left);
  }
  ck_assert_int_eq(a->fluid.emitter_count, b->fluid.emitter_count);
  const size_t emitter_bytes = (size_t)a->fluid.emitter_count * sizeof *a->fluid.emitters;
  if (emitter_bytes) ck_assert_mem_eq(a->fluid.emitters, b->fluid.emitters, emitter_bytes);
  ck_assert_int_eq(a->output.gauge_count, b->output.gauge_count);
  const size_t gauge_bytes = (size_t)a->output.gauge_count * sizeof *a->output.gauges;
  if (gauge_bytes) ck_assert_mem_eq(a->output.gauges, b->output.gauges, gauge_bytes);
  ck_assert_int_eq(a->absorption_count, b->absorption_count);
  const size_t absorption_bytes = (size_t)a->absorption_count * sizeof *a->absorptions;
  if (absorption_bytes) ck_assert_mem_eq(a->absorptions, b->absorptions, absorption_bytes);
  ck_assert_int_eq(a->body_count, b->body_count);
  for (int k = 0; k < a->body_count; k++) expect_same_body(&a->bodies[k], &b->bodies[k]);
  hc_scene left, right;
  memcpy(&left, a, sizeof left);
  memcpy(&right, b, sizeof right);
  left.fluid.blocks = right.fluid.blocks = NULL;
  left.fluid.emitters = right.fluid.emitters = NULL;
  left.boundary.walls = right.boundary.walls = NULL;
  left.bodies = right.bodies = NULL;
  left.absorptions = right.absorptions = NULL;
  left.output.gauges = right.output.gauges = NULL;
  ck_assert_mem_eq(&left, &right, sizeof left);
}

START_TEST(test_defaults) {
  static const char spelled_out[] =
      "name: t\n"
      "particle_spacing: 0.02\n"
      "support_radius: 0.04\n"
      "gravity: [0, 0, -9.81]\n"
      "end_time: 2\n"
      "origin_cells: [0, 0, 0]\n"
      "domain: {periodic: [false, false, false], min: [0, 0, 0], max: [0, 0, 0],\n"
      "         limits: {min: [0, 0, 0], max: [0, 0, 0]}, leaving: error}\n"
      "fluid: {rest_density: 1000, viscosity: {model: xsph, coefficient: 0.02, sound_speed: 0},\n"
      "        mass_factor: 1, blocks: []}\n"
      "boundary: {method: akinci2012, volume_factor: computed, walls: []}\n"
      "solver: {method: dfsph, density_error_avg: 0.0001, divergence_error: 0.001,\n"
      "         density_iterations: {min: 2, max: 100}, divergence_iterations: {min: 1, max: 100},\n"
      "         pressure_solve: fast, min_divergence_neighbors: 20, negative_pressure: false}\n"
      "time_step: {control: cfl, factor: 0.4, max: computed, min: 0}\n"
      "output: {snapshots: {every: 0.05, fields: [velocity, density, pressure]}}\n"
      "parallel: {decomposition: slabs, rebalance: metis, rebalance_above: 1.1, rebalance_at: 0,\n"
      "           rebalance_every: 0}\n"
      "faults: {nan_at: 0, kick_at: 0}\n";
  hc_scene scene = read_good(SMALLEST, NULL), same = read_good(spelled_out, NULL);
  expect_same(&scene, &same);
  ck_assert_double_eq(scene.support_radius, 0.04);
  ck_assert_double_eq(scene.gravity[2], -9.81);
  ck_assert_double_eq(scene.boundary.volume_factor, 0.0);
  hc_scene_free(&scene);
  hc_scene_free(&same);
}
END_TEST

/* Every key differs from its default. */
static const char full[] =
    "# a comment\n"
    "name: 'käse \"1\" \\ x'\n"
    "particle_spacing: 0.1\n"
    "support_radius: 0.33333333333333337\n"
    "gravity: [1e-3, -0.0, 3.]\n"
    "end_time: +1.5e+1\n"
    "origin_cells: [1073741824, -1073741824, +7]\n"
    "domain: {periodic: [true, false, true], min: [0.1, 0, -1], max: [2, 0, .7]}\n"
    "fluid:\n"
    "  rest_density: 997.1\n"
    "  viscosity: {model: artificial, coefficient: 0.08, sound_speed: 44.3}\n"
    "  mass_factor: 0.98\n"
    "  blocks:\n"
    "  - box: &b {min: [0, 0, 0], max: [0.5, 0.25, 1]}\n"
    "  - {box: *b, velocity: [1, 2, 3],\n"
    "     flow: {type: taylor_green, speed: 1.25, length: 0.6}}\n"
    "  - box: {min: [0, 0, 2], max: [1, 1, 3], rotation: {axis: [1, 2, 3], angle: -12.5}}\n"
    "  - cylinder: {base: [1, 2, 3], axis: [0, 3, 4], radius: 0.5, length: 2}\n"
    "  - sphere: {center: [7, 8, 9], radius: 0.25}\n"
    "  emitters:\n"
    "  - {disc: {position: [0, 0, 3], direction: [0, 3, -4], radius: 0.3}, speed: 1.5, start: 1}\n"
    "  - {rectangle: {position: [1, 2, 3], direction: [1, 0, 0], size: [0.3, 0.4]}, rate: 0.01,\n"
    "     start: 0.5, stop: 2, max_particles: 99999999999, clearance: 0.9}\n"
    "boundary:\n"
    "  volume_factor: 0.72\n"
    "  walls:\n"
    "  - {box: {min: [0, 0, 0], max: [2, 1, 1]}, open: [+z, -x]}\n"
    "  - {name: post, box: {min: [1, 0, 0], max: [1.1, 1, 1]}, inside: solid, surface_velocity: [1, 0, -2]}\n"
    "  - plane: {point: [1, 2, 3], normal: [3, 0, -4], size: [5, 6]}\n"
    "  - plane: {point: [1, 2, 3], normal: [1e200, 1e200, 1e-200], size: [5, 6]}\n"
    "  - {cylinder: {base: [1, 2, 3], radius: 0.5, length: 2}, open: [top], inside: solid}\n"
    "  - sphere: {center: [1, 2, 3], radius: 4}\n"
    "  - {box: {min: [0, 0, 0], max: [2, 1, 1], rotation: {angle: 90}}, open: [+x]}\n"
    "  - {name: a, sphere: {center: [1, 2, 3], radius: 4}, motion: {type: constant, velocity: [1, 2, 3],\n"
    "     angular_velocity: -2, axis: [1, 1, 0], center: [4, 5, 6], start: 1, stop: 2}}\n"
    "  - {name: b, sphere: {center: [1, 2, 3], radius: 4}, motion: {type: cosine, amplitude: 0.1,\n"
    "     direction: [0, 2, 0], angle: 10, center: [0, 0, 1], frequency: 0.7, phase: 90}}\n"
    "  - {name: c, sphere: {center: [1, 2, 3], radius: 4}, motion: {type: cosine, speed: 0.25,\n"
    "     direction: [0, 2, 0], frequency: 3}}\n"
    "  - name: d\n"
    "    sphere: {center: [1, 2, 3], radius: 4}\n"
    "    motion:\n"
    "      type: table\n"
    "      interpolation: smooth\n"
    "      center: [1, 1, 1]\n"
    "      points: [{time: 0}, {time: 0.5, shift: [1, 2, 3]}, {time: 0.75, angle: -30}]\n"
    "absorption:\n"
    "- {wall: post, ocean_height: 0.7, inflow_distance: 1, inflow_density: 0, outflow_distance: 2}\n"
    "solver: {density_error_avg: 2e-5, divergence_error: 3e-4, density_iterations: {min: 4, max: 4},\n"
    "  divergence_iterations: {min: 0, max: 1}, warm_start: 1, min_divergence_neighbors: 0,\n"
    "  negative_pressure: true}\n"
    "time_step: {control: constant, size: 1e-4, factor: 0.3, max: 1, min: 1e-4}\n"
    "output:\n"
    "  snapshots: {every: 0, fields: [id]}\n"
    "  gauges_every: 0.25\n"
    "  gauges:\n"
    "  - {name: a, type: front, axis: -y}\n"
    "  - {name: b, type: height, at: [1, 2]}\n"
    "  - {name: c, type: pressure, at: [1, 2, 3], radius: 5}\n"
    "  - {name: d, type: pressure, at: [1, 2, 3], wall: post, mean_over: 0.01}\n"
    "  - {name: e, type: flow, axis: +z, box: {min: [0, 0, 1], max: [2, 1, 1]}}\n"
    "  - {name: f, type: force, wall: wall_0, at: [1, 0, 0]}\n"
    "  - {name: g, type: energy, box: {min: [0, 0, 1], max: [2, 1, 1]}}\n"
    "  - {name: h, type: volume}\n"
    "parallel: {decomposition: metis, rebalance: none, rebalance_above: 1, rebalance_at: 12, "
    "rebalance_every: 3}\n"
    "faults: {nan_at: 7, kick_at: 8}\n";

START_TEST(test_values) {
  hc_scene scene = read_good(full, NULL);
  ck_assert_str_eq(scene.name, "käse \"1\" \\ x");
  ck_assert(signbit(scene.gravity[1]) != 0);
  ck_assert_double_eq(scene.end_time, 15.0);
  ck_assert_int_eq(scene.origin_cells[1], -1073741824);
  ck_assert_int_eq(scene.fluid.viscosity.model, HC_VISCOSITY_ARTIFICIAL);
  ck_assert_double_eq(scene.fluid.blocks[1].box.max[1], 0.25); /* the alias */
  ck_assert_double_eq(scene.fluid.blocks[1].velocity[2], 3.0);
  ck_assert_int_eq(scene.fluid.blocks[1].flow.type, HC_FLOW_TAYLOR_GREEN);
  const hc_wall *walls = scene.boundary.walls;
  ck_assert_str_eq(walls[0].name, "wall_0");
  ck_assert_uint_eq(walls[0].open, HC_FACE_PLUS_Z | HC_FACE_MINUS_X);
  ck_assert_str_eq(walls[1].name, "post");
  ck_assert_int_eq(walls[1].inside, HC_INSIDE_SOLID);
  ck_assert_int_eq(walls[2].form, HC_FORM_PLANE);
  ck_assert_double_eq_tol(walls[2].normal[2], -0.8, 1e-15);
  ck_assert_double_eq_tol(walls[3].normal[0], sqrt(0.5), 1e-15);
  const hc_block *blocks = scene.fluid.blocks;
  ck_assert_int_eq(scene.fluid.block_count, 5);
  ck_assert_double_eq(blocks[2].rotation.angle, -12.5);
  ck_assert_double_eq(blocks[2].rotation.axis[1], 2.0);
  ck_assert_int_eq(blocks[3].form, HC_FORM_CYLINDER);
  ck_assert_double_eq(blocks[3].cylinder.axis[2], 4.0);
  ck_assert_int_eq(blocks[4].form, HC_FORM_SPHERE);
  ck_assert_double_eq(blocks[4].sphere.center[1], 8.0);
  ck_assert_int_eq(walls[4].form, HC_FORM_CYLINDER);
  ck_assert_double_eq(walls[4].cylinder.axis[2], 1.0); /* the default */
  ck_assert_uint_eq(walls[4].open, HC_FACE_TOP);
  ck_assert_int_eq(walls[4].inside, HC_INSIDE_SOLID);
  ck_assert_int_eq(walls[5].form, HC_FORM_SPHERE);
  ck_assert_double_eq(walls[5].sphere.radius, 4.0);
  ck_assert_double_eq(walls[6].rotation.angle, 90.0);
  ck_assert_double_eq(walls[6].rotation.axis[2], 1.0);
  const hc_wall_motion *motion = &walls[10].motion;
  ck_assert_int_eq(motion->type, HC_WALL_TABLE);
  ck_assert_int_eq(motion->interpolation, HC_INTERPOLATION_SMOOTH);
  ck_assert_int_eq(motion->point_count, 3);
  ck_assert_double_eq(motion->points[1].shift[1], 2.0);
  ck_assert_double_eq(motion->points[2].angle, -30.0);
  ck_assert_double_eq(walls[7].motion.angular_velocity, -2.0);
  ck_assert_double_eq(walls[7].motion.stop, 2.0);
  ck_assert_double_eq(walls[9].motion.speed, 0.25);
  ck_assert_int_eq(scene.fluid.emitter_count, 2);
  ck_assert_int_eq(scene.fluid.emitters[1].form, HC_EMITTER_RECTANGLE);
  ck_assert_double_eq(scene.fluid.emitters[1].rate, 0.01);
  ck_assert_int_eq(scene.fluid.emitters[1].max_particles, 99999999999);
  ck_assert_double_eq(scene.fluid.emitters[0].direction[2], -4.0);
  ck_assert_double_eq(scene.fluid.emitters[0].clearance, 0.8);
  ck_assert_int_eq(scene.parallel.decomposition, HC_DECOMPOSITION_METIS);
  ck_assert_int_eq(scene.parallel.rebalance, HC_REBALANCE_NONE);
  ck_assert_int_eq(scene.parallel.rebalance_at, 12);
  ck_assert_int_eq(scene.faults.nan_at, 7);
  ck_assert_int_eq(scene.faults.kick_at, 8);
  ck_assert_double_eq(scene.time_step.min, 1e-4);
  ck_assert_int_eq(scene.parallel.rebalance_every, 3);
  hc_scene_free(&scene);
}
END_TEST

typedef struct pair {
  const char *given, *message;
} pair;

/* One gauge below the smallest scene. */
static void refuse_gauge(const char *gauge, const char *message) {
  char text[1024], placed[1024];
  snprintf(text, sizeof text, SMALLEST "output:\n  gauges:\n  - {%s}\n", gauge);
  snprintf(placed, sizeof placed, "5:%s", message);
  refuse(text, placed);
}

START_TEST(test_gauges) {
  refuse_gauge("name: a", "5: missing required key 'output.gauges[0].type'");
  refuse_gauge("name: a, type: level",
               "21: output.gauges[0].type must be one of height, front, pressure, flow, "
               "force, energy, volume, density, body, mooring, not 'level'");
  refuse_gauge("name: a, type: front", "5: missing key 'output.gauges[0].axis', required for front");
  refuse_gauge("name: a, type: volume, axis: +x",
               "35: output.gauges[0].axis is a key of height, front, pressure, flow, not of volume");
  refuse_gauge("name: a, type: pressure, at: [1]",
               "35: output.gauges[0].at must be a list of 2 or 3 numbers, not a list of 1");
  refuse_gauge("name: a, type: pressure, at: [1, 2]",
               "35: output.gauges[0].at must be a list of 3 numbers, not a list of 2");
  refuse_gauge("name: a, type: pressure, at: [1, 2, 3], radius: 0.001",
               "54: output.gauges[0].radius must be >= particle_spacing, or 0 for the support radius, "
               "not 0.001 < 0.02");
  refuse_gauge("name: a, type: pressure, at: [1, 2, 3], mean_over: -1",
               "57: output.gauges[0].mean_over must be >= 0, not '-1'");
  refuse_gauge("name: a, type: height, at: [1, 2], mean_over: 1",
               "52: output.gauges[0].mean_over is a key of pressure, flow, force, not of height");
  refuse_gauge("name: a, type: force, wall: tank",
               "34: output.gauges[0].wall must be the name of a wall or body of the scene, not 'tank'");
  refuse_gauge("name: a, type: volume, box: {min: [0, 0, 0], max: [1, -1, 1]}",
               "56: output.gauges[0].box.max must be >= box.min along y");
  refuse_gauge(
      "name: a, type: flow, axis: +x, box: {min: [0, 0, 0], max: [1, 1, 1]}",
      "64: output.gauges[0].box must be a rectangle across its axis: box.min and box.max equal along x "
      "and nowhere else");
  refuse_gauge("name: 'a,b', type: volume",
               "12: output.gauges[0].name must do without commas and quotes, not a,b");
}
END_TEST

START_TEST(test_errors_in_a_line) {
  static const pair cases[] = {
      {"gravty: [0, 0, -1]", "1: unknown key 'gravty'; did you mean 'gravity'?"},
      {"rest_density: 998", "1: unknown key 'rest_density'; did you mean 'fluid.rest_density'?"},
      {"time_step: {maxx: 1}", "13: unknown key 'time_step.maxx'; did you mean 'time_step.max'?"},
      {"solvr: {}", "1: unknown key 'solvr'; did you mean 'solver'?"},
      {"rafts: []", "1: unknown key 'rafts'"},
      {"fluid: {blocks: [{box: {min: [0,0,0], max: [1,1,1]}, velocit: 1}]}",
       "54: unknown key 'fluid.blocks[0].velocit'; did you mean 'fluid.blocks[0].velocity'?"},
      {"solver.warm_start: 1", "1: unknown key 'solver.warm_start': write nested maps, not dots"},
      {"warm_start: 1", "1: unknown key 'warm_start'; did you mean 'solver.warm_start'?"},
      {"name: a/b", "7: name must do as a folder's name: without '/', not '.' or '..', not 'a/b'"},
      {"name: ..", "7: name must do as a folder's name: without '/', not '.' or '..', not '..'"},
      {"boundary: {walls: [{box: {}}]}", "26: boundary.walls[0].box must have keys, not {}"},
      {"support_radius: abc", "17: support_radius must be a number, not 'abc'"},
      {"support_radius: \"0.04\"", "17: support_radius must be a number, not the text '0.04'"},
      {"support_radius: 0x1", "17: support_radius must be a number, not '0x1'"},
      {"support_radius: 1,5", "17: support_radius must be a number, not '1,5'"},
      {"support_radius:", "1: support_radius must be a number, not nothing"},
      {"gravity: [0, 0]", "10: gravity must be a list of 3 numbers, not a list of 2"},
      {"gravity: [0, x, 0]", "14: gravity[1] must be a number, not 'x'"},
      {"solver: {min_divergence_neighbors: 2.5}",
       "36: solver.min_divergence_neighbors must be an integer, not '2.5'"},
      {"solver: {negative_pressure: yes}", "29: solver.negative_pressure must be true or false, not 'yes'"},
      {"fluid: 5", "8: fluid must be a map, not '5'"},
      {"fluid: {blocks: [7]}", "18: fluid.blocks[0] must be a map, not '7'"},
      {"fluid: {blocks: [{box: 1}]}", "24: fluid.blocks[0].box must be a map, not '1'"},
      {"name: [a]", "7: name must be text, not a list of 1"},
      {"name: \"a\\nb\"", "7: name must be one line of text without control characters, not the text 'a...'"},
      {"boundary: {volume_factor: compute}",
       "27: boundary.volume_factor must be a number or the word computed, not 'compute'"},
      {"fluid: {viscosity: {model: xspf}}", "28: fluid.viscosity.model must be one of none, xsph, "
                                            "artificial, laminar, smagorinsky (nearest: xsph), not 'xspf'"},
      {"output: {snapshots: {fields: [density, speed]}}",
       "40: output.snapshots.fields[1] must be one of id, velocity, density, pressure, not 'speed'"},
      {"output: {snapshots: {fields: [density, density]}}",
       "40: output.snapshots.fields[1] must be named once, not 'density'"},
      {"boundary: {walls: [{box: {min: [0,0,0], max: [1,1,1]}, open: [up]}]}",
       "63: boundary.walls[0].open[0] must be one of -x, +x, -y, +y, -z, +z, base, top, not 'up'"},
      {"fluid: {mass_factor: 1.2}", "22: fluid.mass_factor must be in [0.9, 1], not '1.2'"},
      {"support_radius: .inf", "17: support_radius must be finite, not '.inf'"},
      {"gravity: [0, 0, -.NaN]", "17: gravity[2] must be finite, not '-.NaN'"},
      {"gravity: [0, 0, 1e999]", "17: gravity[2] must be finite, below 1.8e308, not '1e999'"},
      {"solver: {density_iterations: {min: 99999999999}}",
       "36: solver.density_iterations.min must be an integer of at most 2147483647, not '99999999999'"},
      {"origin_cells: [0, 99999999999999999999, 0]",
       "19: origin_cells[1] must be in [-1073741824, 1073741824], not '99999999999999999999'"},
      {"boundary: {volume_factor: 0}", "27: boundary.volume_factor must be > 0 or computed, not '0'"},
      {"support_ratio: 4.5", "16: support_ratio must be in [1.5, 4], not '4.5'"},
      {"support_radius: 0.05\nsupport_ratio: 2",
       "17: support_radius must be support_ratio particle_spacing, 0.04 m, not 0.05: leave one of them out"},
      {"support_radius: 0.02",
       "17: support_radius must be 1.5 to 4 particle_spacing, not 0.02 (1 particle_spacing)"},
      {"solver: {density_iterations: {min: 5, max: 4}}",
       "44: solver.density_iterations.min must be <= solver.density_iterations.max, not 5 > 4"},
      {"domain: {periodic: [true, false, false], min: [1, 0, 0], max: [1, 0, 0]}",
       "63: domain.max must be > domain.min along x, not 1 <= 1"},
      {"fluid: {blocks: [{box: {min: [0,0,0], max: [1,-0.5,1]}}]}",
       "44: fluid.blocks[0].box.max must be > box.min along y, not -0.5 <= 0"},
      {"boundary: {walls: [{sphere: {center: [0,0,0], radius: 1}, open: [+z]}]}",
       "65: boundary.walls[0].open is a key of box, cylinder, not of sphere"},
      {"boundary: {walls: [{cylinder: {base: [0,0,0], radius: 1, length: 1}, open: [+z]}]}",
       "76: boundary.walls[0].open must be of base, top with a cylinder, not -x, +x, -y, +y, -z or +z"},
      {"boundary: {walls: [{box: {min: [0,0,0], max: [1,1,1]}, open: [top]}]}",
       "62: boundary.walls[0].open must be of -x, +x, -y, +y, -z, +z with a box, not base or top"},
      {"boundary: {walls: [{box: {min: [0,0,0], max: [1,1,1]}, open: [-x, +x, -y, +y, -z, +z]}]}",
       "62: boundary.walls[0].open must leave a face of the box closed, not open all six"},
      {"boundary: {walls: [{cylinder: {base: [0,0,0], axis: [0,0,0], radius: 1, length: 1}}]}",
       "53: boundary.walls[0].cylinder.axis must not be zero, not [0, 0, 0]"},
      {"boundary: {walls: [{sphere: {center: [0,0,0], radius: 0}}]}",
       "55: boundary.walls[0].sphere.radius must be > 0, not '0'"},
      {"fluid: {blocks: [{box: {min: [0,0,0], max: [1,1,1], rotation: {axis: [0,0,0], angle: 5}}}]}",
       "70: fluid.blocks[0].box.rotation.axis must not be zero, not [0, 0, 0]"},
      {"fluid: {blocks: [{box: {min: [0,0,0], max: [1,1,1], rotation: {angle: 400}}}]}",
       "71: fluid.blocks[0].box.rotation.angle must be in [-360, 360], not '400'"},
      {"fluid: {blocks: [{cylinder: {base: [0,0,0], radius: 1}}]}",
       "18: missing required key 'fluid.blocks[0].cylinder.length'"},
      {"fluid: {blocks: [{velocity: [0,0,1]}]}",
       "18: fluid.blocks[0] must have exactly one of box, cylinder, sphere, mesh, revolution; it has none"},
      {"time_step: {control: constant, size: 0.02, max: 0.01}",
       "38: time_step.size must be <= time_step.max, not 0.02 > 0.01"},
      {"boundary: {walls: [{}]}", "20: boundary.walls[0] must have exactly one of box, cylinder, sphere, "
                                  "mesh, revolution, plane; it has none"},
      {"boundary: {walls: [{plane: {point: [0,0,0], normal: [0,0,0], size: [1,1]}}]}",
       "53: boundary.walls[0].plane.normal must not be zero, not [0, 0, 0]"},
      {"boundary: {walls: [{inside: solid, plane: {point: [0,0,0], normal: [0,0,1], size: [1,1]}}]}",
       "29: boundary.walls[0].inside is a key of box, cylinder, sphere, mesh, revolution, not of plane"},
      {"fluid: {blocks: [{box: {min: [0,0,0]}}]}", "18: missing required key 'fluid.blocks[0].box.max'"},
      {"fluid: {blocks: [{box: {min: [0,0,0], max: [1,1,1]}, flow: {type: taylor_green, speed: 1}}]}",
       "18: missing key 'fluid.blocks[0].flow.length', required with a flow.type"},
      {"end_time: 3", "1: duplicate key 'end_time', first given on line 2"},
      {"time_step: {max: 1, factor: 0.1, max: 2}",
       "34: duplicate key 'time_step.max', first given on line 3"},
  };
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) refuse_line(cases[k].given, cases[k].message);
  hc_scene scene = read_good(SMALLEST "support_radius: 0.03\n", NULL); /* 1.5 spacings, but for rounding */
  hc_scene_free(&scene);
}
END_TEST

START_TEST(test_errors_elsewhere) {
  refuse("particle_spacing: -0.02\nend_time: 1", "1:19: particle_spacing must be > 0, not '-0.02'");
  refuse(SMALLEST "boundary:\n  walls:\n  - {box: {min: [0,0,0], max: [1,1,1]}, plane: {size: [1,1]}}\n",
         "5:5: boundary.walls[0] must have exactly one of box, cylinder, sphere, mesh, revolution, plane; it "
         "has box and plane");
  refuse(SMALLEST "boundary:\n  walls:\n  - {name: a, box: {min: [0,0,0], max: [1,1,1]}}\n"
                  "  - {name: a, box: {min: [0,0,0], max: [1,1,1]}}\n",
         "6:12: boundary.walls[1].name must be the wall's own, not 'a' like wall 0");
  refuse("particle_spacing: 1e-10\nend_time: 1", "1:19: particle_spacing must be 1e-9 to 1e9, not 1e-10");
  refuse("# no time\nparticle_spacing: 1\n", "2:1: missing required key 'end_time'");
  refuse(SMALLEST "time_step: {control: constant}\n",
         "1:1: missing key 'time_step.size', required with time_step.control constant");
  refuse(SMALLEST "domain: {periodic: [false, true, false], min: [0, 0, 0]}\n",
         "1:1: missing key 'domain.max', required along periodic axes");
  refuse_text(
      "end_time: 0\nparticle_spacing: x # why\nfluid:\n  blocks: [ 1, 2 ]\nfoo: 3\n", "gravity=4",
      "folder/t.yaml:1:11: end_time must be > 0, not '0'\nend_time: 0\n          ^\n"
      "folder/t.yaml:2:19: particle_spacing must be a number, not 'x'\n"
      "particle_spacing: x # why\n                  ^\n"
      "folder/t.yaml:4:13: fluid.blocks[0] must be a map, not '1'\n  blocks: [ 1, 2 ]\n            ^\n"
      "folder/t.yaml:4:16: fluid.blocks[1] must be a map, not '2'\n  blocks: [ 1, 2 ]\n               ^\n"
      "folder/t.yaml:5:1: unknown key 'foo'\nfoo: 3\n^\n"
      "--set gravity=4: gravity must be a list of 3 numbers, not '4'");
}
END_TEST

START_TEST(test_many_errors) {
  char text[8192] = SMALLEST;
  for (int k = 0; k < 200; k++)
    snprintf(text + strlen(text), sizeof text - strlen(text), "unheard_of_%d: 1\n", k);
  hc_scene scene;
  hc_error error;
  ck_assert_int_eq(read_with(&scene, text, NULL, &error), HC_BAD_INPUT);
  ck_assert_ptr_nonnull(strstr(error.text, "folder/t.yaml:3:1: unknown key 'unheard_of_0'"));
  ck_assert_ptr_nonnull(strstr(error.text, "folder/t.yaml:52:1: unknown key 'unheard_of_49'"));
  ck_assert_ptr_null(strstr(error.text, "unheard_of_50"));
  char wide[16384] = SMALLEST;
  for (int k = 0; k < 60; k++)
    snprintf(wide + strlen(wide), sizeof wide - strlen(wide), "unheard_of_%d: %0200d\n", k, 0);
  ck_assert_int_eq(read_with(&scene, wide, NULL, &error), HC_BAD_INPUT);
  ck_assert_uint_lt(strlen(error.text), sizeof error.text - 1);
  ck_assert_str_eq(error.text + strlen(error.text) - 9, "\nand more");
}
END_TEST

START_TEST(test_not_yaml) {
  refuse("a: b: c", "1:5: not valid YAML: invalid nested block mapping on the same line");
  refuse("name: *x\n", "1:7: alias '*x' has no anchor before it");
  refuse("name: &x [*x]\n", "1:11: alias '*x' has no anchor before it");
  refuse("name: !!str x\n", "1:13: tags are not supported; types follow from the keys");
  refuse(SMALLEST "---\nname: x\n", "3:1: only one YAML document may be given");
  refuse("? [a]\n: 1\n", "1:3: a key must be a word, not a list");
  refuse("[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[", "1:33: nested more than 32 deep");
  refuse("- 1\n- 2\n", "1:1: a scene must be a map of keys, not a list of 2");
  refuse_text("# nothing\n", NULL, "folder/t.yaml: a scene must be a map of keys, not nothing");
  refuse_text("", NULL, "folder/t.yaml: a scene must be a map of keys, not nothing");
  /* Columns count characters; a tab stays a tab; CRLF ends a line. */
  refuse_text("name: ä\r\nfluid: {ä: 1,\té: 1}\r\n" SMALLEST, "name=x",
              "folder/t.yaml:2:9: unknown key 'fluid.ä'\nfluid: {ä: 1,\té: 1}\n        ^\n"
              "folder/t.yaml:2:15: unknown key 'fluid.é'\nfluid: {ä: 1,\té: 1}\n             \t^");
  refuse_text("name: x\n\x89HDF\r\n\x1a\n", NULL, "folder/t.yaml:2:1: not UTF-8 text: byte 0x89\n?HDF\n^");
  refuse_text("name: a\033[2J\n", NULL,
              "folder/t.yaml:1:8: not text: byte 0x1b is a control character\nname: a?[2J\n       ^");
  static const char zero[] = "name: a\0b\n";
  hc_scene scene;
  hc_error error;
  ck_assert_int_eq(hc_scene_read_text(&scene, "z", zero, sizeof zero - 1, NULL, 0, NULL, NULL, &error),
                   HC_BAD_INPUT);
  ck_assert_str_eq(error.text, "z:1:8: not text: byte 0x00 is a control character\nname: a?b\n       ^");
}
END_TEST

START_TEST(test_overrides) {
  hc_scene scene = read_good(full, "time_step.size=0.002");
  ck_assert_double_eq(scene.time_step.size, 0.002);
  hc_scene_free(&scene);
  scene = read_good(full, "gravity=[0,0,-1]");
  ck_assert_double_eq(scene.gravity[2], -1.0);
  hc_scene_free(&scene);
  scene = read_good(full, "fluid.blocks[0].velocity=[1,0,0]");
  ck_assert_double_eq(scene.fluid.blocks[0].velocity[0], 1.0);
  ck_assert_double_eq(scene.fluid.blocks[1].velocity[0], 1.0);
  hc_scene_free(&scene);
  scene = read_good(full, "fluid.viscosity={model: laminar}"); /* merged */
  ck_assert_int_eq(scene.fluid.viscosity.model, HC_VISCOSITY_LAMINAR);
  ck_assert_double_eq(scene.fluid.viscosity.coefficient, 0.08);
  hc_scene_free(&scene);
  scene = read_good(SMALLEST "fluid: {viscosity: {model: smagorinsky}}\n", NULL);
  ck_assert_int_eq(scene.fluid.viscosity.model, HC_VISCOSITY_SMAGORINSKY);
  ck_assert_double_eq(scene.fluid.viscosity.coefficient, 0.15);
  ck_assert_double_eq(scene.fluid.kinematic_viscosity, 1e-6);
  ck_assert_int_eq(scene.boundary.friction_law, HC_SCENE_FRICTION_SMOOTH);
  hc_scene_free(&scene);
  /* The last one counts, and a bad value that is replaced hurts nobody. */
  static const char bad[] = "particle_spacing: x\nend_time: 2\n";
  static const char *const two[] = {"particle_spacing=1", "particle_spacing=0.5"};
  hc_error error;
  ck_assert_int_eq(hc_scene_read_text(&scene, "t", bad, sizeof bad - 1, two, 2, &limits, NULL, &error),
                   HC_OK);
  ck_assert_double_eq(scene.particle_spacing, 0.5);
  hc_scene_free(&scene);
}
END_TEST

START_TEST(test_bad_overrides) {
  static const pair cases[] = {
      {"time_step.max=abc", "time_step.max must be a number or the word computed, not 'abc'"},
      {"time_step.maxx=1", "unknown key 'time_step.maxx'; did you mean 'time_step.max'?"},
      {"time_step.max", "path.to.key=value is meant"},
      {"time_step.max=", "time_step.max has no value"},
      {"gravity=[0,0", "not valid YAML: flow sequence without a closing bracket"},
      {"gravity[0]=3", "gravity is not a list of maps: give its whole value"},
      {"fluid.blocks[0].velocity=[1,0,0]", "fluid.blocks has no item 0: it has 0, counted from 0"},
      {"fluid.blocks[x].velocity=1", "'fluid.blocks[x].velocity' is not a key: list[index].key is meant"},
      {"fluid.block[0].velocity=1", "unknown key 'fluid.block'; did you mean 'fluid.blocks'?"},
      {"fluid.blocks=[{box: {min: [0,0,0], max: [1,1]}}]",
       "fluid.blocks[0].box.max must be a list of 3 numbers, not a list of 2"},
  };
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) refuse_set(cases[k].given, cases[k].message);
}
END_TEST

/* One warning of a line below the smallest scene, which begins with the column; null: none. */
static void warn_line(const char *line, const char *override, const char *message) {
  char text[1024], expected[2048] = "";
  snprintf(text, sizeof text, SMALLEST "%s\n", line);
  if (message && override)
    snprintf(expected, sizeof expected, "--set %s: %s", override, message);
  else if (message)
    snprintf(expected, sizeof expected, "folder/t.yaml:3:%s\n%s\n%*s", message, line, atoi(message), "^");
  hc_scene scene;
  hc_warnings warnings = {0};
  hc_error error = {.text = ""};
  ck_assert_msg(hc_scene_read_text(&scene, "folder/t.yaml", text, strlen(text), &override, override ? 1 : 0,
                                   &limits, &warnings, &error) == HC_OK,
                "%s", error.text);
  ck_assert_int_eq(warnings.count, message ? 1 : 0);
  if (message) ck_assert_str_eq(warnings.text[0], expected);
  hc_warnings_free(&warnings);
  hc_scene_free(&scene);
}

START_TEST(test_unused_keys) {
  static const pair cases[] = {
      {"time_step: {size: 0.1}", "19: time_step.size is not used: time_step.control is cfl"},
      {"time_step: {control: constant, size: 0.001, factor: 0.4}",
       "53: time_step.factor is not used: time_step.control is constant"},
      {"fluid: {viscosity: {model: none, coefficient: 1}}",
       "47: fluid.viscosity.coefficient is not used: fluid.viscosity.model is none"},
      {"fluid: {viscosity: {model: laminar, sound_speed: 1}}",
       "50: fluid.viscosity.sound_speed is not used: fluid.viscosity.model is laminar"},
      {"fluid: {blocks: [{box: {min: [0,0,0], max: [1,1,1]}, flow: {speed: 1}}]}",
       "68: fluid.blocks[0].flow.speed is not used: fluid.blocks[0].flow.type is none"},
      {"domain: {max: [1, 1, 1]}", "15: domain.max is not used: domain.periodic is false"},
      {"parallel: {rebalance: none, rebalance_above: 2}",
       "46: parallel.rebalance_above is not used: parallel.rebalance is none"},
      {"time_step: {control: constant, size: 0.1}", NULL},
      {"fluid: {viscosity: {model: artificial, sound_speed: 1}}", NULL},
      {"fluid: {kinematic_viscosity: 1.0e-5, viscosity: {model: smagorinsky, coefficient: 0.1}}", NULL},
      {"domain: {periodic: [false, true, false], min: [0, 0, 0], max: [1, 1, 1]}", NULL},
      {"solver: {pressure_solve: paper, warm_start: 0}", NULL},
      {"solver: {warm_start: 0}", "22: solver.warm_start is not used: solver.pressure_solve is fast"},
      {"solver: {warm_start: 0, method: pcisph}",
       "22: solver.warm_start is not used: solver.method is pcisph"},
  };
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++)
    warn_line(cases[k].given, NULL, cases[k].message);
  warn_line("gravity: [0, 0, -1]", "time_step.size=1",
            "time_step.size is not used: time_step.control is cfl");
  hc_scene scene = read_good(SMALLEST "time_step: {size: 0.1}\n", NULL);
  ck_assert_double_eq(scene.time_step.size, 0.0);
  hc_scene_free(&scene);
}
END_TEST

static void make_folder(char folder[static 32]) {
  strcpy(folder, "/tmp/test_scene_XXXXXX");
  ck_assert_ptr_nonnull(mkdtemp(folder));
}

/* Reads a file of this content (null: none); the error must be "PATH: MESSAGE" (null: none). */
static void check_file(const char *path, const char *text, const char *message) {
  FILE *file = text ? fopen(path, "w") : NULL;
  ck_assert(!text || (file && fputs(text, file) >= 0 && fclose(file) == 0));
  hc_scene scene;
  hc_error error = {.text = ""};
  const hc_status status = hc_scene_read(&scene, path, NULL, 0, NULL, NULL, &error);
  ck_assert_int_eq(status, message ? HC_BAD_INPUT : HC_OK);
  char expected[256] = "";
  if (message) snprintf(expected, sizeof expected, "%s: %s", path, message);
  ck_assert_str_eq(error.text, expected);
  if (!message) ck_assert_str_eq(scene.name, "my.scene");
  hc_scene_free(&scene);
}

START_TEST(test_files) {
  char folder[32], path[64];
  make_folder(folder);
  snprintf(path, sizeof path, "%s/my.scene.yaml", folder);
  check_file(folder, NULL, "a folder, not a scene file");
  check_file(path, NULL, "cannot be opened: No such file or directory");
  check_file(path, "", "the file is empty");
  check_file(path, "\xef\xbb\xbf" SMALLEST, NULL); /* a byte order mark */
  remove(path);
  rmdir(folder);
}
END_TEST

static void check_round_trip(const char *text, const char *override) {
  hc_scene scene = read_good(text, override), again;
  hc_error error = {.text = ""};
  char *written = hc_scene_text(&scene);
  hc_warnings warnings = {0};
  ck_assert_msg(hc_scene_read_text(&again, "scene.yaml", written, strlen(written), NULL, 0, &limits,
                                   &warnings, &error) == HC_OK,
                "%s", error.text);
  hc_free(written);
  ck_assert_int_eq(warnings.count, 0);
  expect_same(&scene, &again);
  hc_scene_free(&again);
  hc_scene_free(&scene);
}

START_TEST(test_round_trip) {
  check_round_trip(SMALLEST, NULL);
  check_round_trip(full, NULL);
  check_round_trip(full, "boundary.volume_factor=computed");
  check_round_trip(
      SMALLEST
      "bodies:\n"
      "  - {name: b, sphere: {center: [0, 0, 1], radius: 0.3}, mass: 2, position: [1, 0, 0.1], locked: "
      "[x, yaw],\n"
      "     forces: [{force: [1, 2, 3], at: [0, 0, 1], frame: body, stop: 3}],\n"
      "     moorings: [{type: spring, at: [0, 0, 1], anchor: [0.1, 0, 0], stiffness: 5}]}\n"
      "  - {box: {min: [0, 0, 1], max: [1, 1, 2]}, density: 0.1}\n",
      NULL);
  /* A constant step above the default of time_step.max takes it along. */
  check_round_trip(SMALLEST "time_step: {control: constant, size: 0.01}\n", NULL);
  check_round_trip(full, "gravity=[5e-324, 1.7976931348623157e308, 0.1]");
  /* Normals of all kinds keep their bits when they are read again. */
  for (int k = 1; k <= 50; k++) {
    char override[128];
    snprintf(override, sizeof override, "boundary.walls[2].plane.normal=[%d, %.17g, %.17g]", k % 7, sin(k),
             1.0 / k);
    check_round_trip(full, override);
  }
  /* Where a comma is the decimal mark (if the machine has such a locale) nothing changes. */
  setlocale(LC_ALL, "de_DE.UTF-8");
  check_round_trip(full, "fluid.mass_factor=0.99");
  setlocale(LC_ALL, "C");
}
END_TEST

/* True if a line begins with the key. */
static bool has_key(const char *text, const char *key) {
  char line[160];
  snprintf(line, sizeof line, "\n%s ", key);
  return strstr(text, line) != NULL;
}

/* What `halocline keys` prints, of one solver's keys or all. The caller's to free. */
static char *printed_keys(const char *solver) {
  char *all = NULL;
  size_t length = 0;
  FILE *out = open_memstream(&all, &length);
  ck_assert_ptr_nonnull(out);
  hc_error error;
  ck_assert_int_eq(hc_params_print(out, solver, &error), HC_OK);
  fclose(out);
  return all;
}

START_TEST(test_keys) {
  char *all = printed_keys(NULL);
  for (int k = 0; k < hc_params_scene.count; k++) {
    const hc_param *param = &hc_params_scene.params[k];
    ck_assert_msg(has_key(all, param->path) == !param->hidden, "%s", param->path);
    for (int i = 0; param->items && i < param->items->count; i++) {
      char path[128];
      snprintf(path, sizeof path, "%s[].%s", param->path, param->items->params[i].path);
      ck_assert_msg(has_key(all, path), "%s", path);
    }
  }
  free(all);
  char *own = printed_keys("pcisph"), *other = printed_keys("dfsph");
  ck_assert(has_key(own, "solver.density_correction") && !has_key(own, "solver.warm_start"));
  ck_assert(!has_key(other, "solver.density_correction") && has_key(other, "solver.warm_start"));
  free(own);
  free(other);
  hc_error error;
  ck_assert_int_eq(hc_params_print(stdout, "magic", &error), HC_BAD_INPUT);
  ck_assert_str_eq(error.text, "unknown solver 'magic'; known: dfsph, pcisph, wcsph");
}
END_TEST

START_TEST(test_own_scenes) {
  glob_t found;
  if (glob(HC_SOURCE_DIR "/scenes/*.yaml", 0, NULL, &found) != 0) return;
  for (size_t k = 0; k < found.gl_pathc; k++) {
    hc_scene scene;
    hc_warnings warnings = {0};
    hc_error error = {.text = ""};
    ck_assert_msg(hc_scene_read(&scene, found.gl_pathv[k], NULL, 0, NULL, &warnings, &error) == HC_OK, "%s",
                  error.text);
    ck_assert_msg(warnings.count == 0, "%s", warnings.text[0]);
    hc_scene_free(&scene);
  }
  globfree(&found);
}
END_TEST

int main(void) {
  const TTest *const tests[] = {
      test_defaults,   test_values,    test_errors_in_a_line, test_errors_elsewhere, test_many_errors,
      test_not_yaml,   test_overrides, test_bad_overrides,    test_unused_keys,      test_files,
      test_round_trip, test_keys,      test_gauges,           test_own_scenes};
  Suite *suite = suite_create("scene");
  TCase *all = tcase_create("all");
  tcase_set_timeout(all, 60); /* sanitizers make every key cost */
  for (size_t k = 0; k < sizeof tests / sizeof tests[0]; k++) tcase_add_test(all, tests[k]);
  suite_add_tcase(suite, all);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
