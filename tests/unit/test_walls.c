/* Walls that meet, and what a review has to say about a scene: from scene text, as a user writes it. */
#include "base/memory.h"
#include "scene/reader.h"
#include "setup/populate.h"
#include "setup/review.h"
#include "setup/world_frame.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define START "particle_spacing: 0.1\nend_time: 1\n"
#define WATER "fluid: {blocks: [{box: {min: [0, 0, 0], max: [0.5, 0.5, 0.5]}}]}\n"

static hc_status read_scene(hc_scene *scene, const char *text, bool reviewed, hc_warnings *warnings,
                            hc_error *error) {
  const hc_scene_limits limits = {.check = reviewed ? hc_setup_review : NULL};
  char complete[4096];
  snprintf(complete, sizeof complete, START "output: {snapshots: {fields: []}}\n%s", text);
  return hc_scene_read_text(scene, "t.yaml", complete, strlen(complete), NULL, 0, &limits, warnings, error);
}

/* --- Walls that meet --- */

typedef struct sample {
  uint64_t id;
  double x[3]; /* m */
} sample;

typedef struct walls {
  hc_frame frame;
  hc_setup_plan plan;
  sample *samples;
  int64_t count;
} walls;

static int by_id(const void *a, const void *b) {
  const uint64_t left = ((const sample *)a)->id, right = ((const sample *)b)->id;
  return (left > right) - (left < right);
}

static walls make_walls(const char *text, int size) {
  hc_scene scene;
  hc_error error = {.text = ""};
  ck_assert_msg(read_scene(&scene, text, false, NULL, &error) == HC_OK, "%s", error.text);
  walls made = {.count = 0};
  ck_assert_msg(hc_setup_frame(&scene, &made.frame, &error) == HC_OK, "%s", error.text);
  ck_assert_msg(hc_setup_plan_make(NULL, &scene, &made.frame, &made.plan, &error) == HC_OK, "%s", error.text);
  made.samples = hc_alloc((size_t)made.plan.boundary_count, sizeof *made.samples);
  hc_particles fluid, boundary, moving;
  hc_particles_init(&moving, HC_BOUNDARY | HC_MOVED, HC_FOR_ALL);
  hc_particles_init(&fluid, HC_FLUID, HC_FOR_ALL);
  hc_particles_init(&boundary, HC_BOUNDARY, HC_FOR_ALL);
  for (int rank = 0; rank < size; rank++) {
    ck_assert_int_eq(hc_setup_generate(&made.plan, rank, size, &fluid, &boundary, &moving, &error), HC_OK);
    const hc_particles *const stores[] = {&boundary, &moving};
    for (int s = 0; s < 2; s++)
      for (int32_t k = 0; k < stores[s]->own; k++, made.count++) {
        made.samples[made.count].id = stores[s]->id[k];
        for (int a = 0; a < 3; a++)
          made.samples[made.count].x[a] = hc_frame_to_metres(&made.frame, a, stores[s]->position[3 * k + a]);
      }
  }
  ck_assert_int_eq(made.count, made.plan.boundary_count);
  qsort(made.samples, (size_t)made.count, sizeof *made.samples, by_id);
  hc_particles_free(&fluid);
  hc_particles_free(&boundary);
  hc_particles_free(&moving);
  hc_scene_free(&scene);
  return made;
}

static void free_walls(walls *made) {
  hc_setup_plan_free(&made->plan);
  hc_free(made->samples);
}

static int wall_of(const sample *s) {
  return (int)(s->id >> HC_ID_COUNTER_BITS & (uint64_t)(HC_ID_MAX_SOURCES - 1));
}

/* In spacings, around the periods. */
static double separation(const walls *made, const double a[3], const double b[3]) {
  double square = 0;
  for (int k = 0; k < 3; k++) {
    const double period = (double)made->frame.period[k] * made->frame.unit[k];
    double d = a[k] - b[k];
    if (period > 0) d -= period * rint(d / period);
    square += d * d;
  }
  return sqrt(square) / 0.1;
}

/* Of the samples of walls before `wall`. */
static double nearest_earlier(const walls *made, const double x[3], int wall) {
  double least = INFINITY;
  for (int64_t k = 0; k < made->count; k++)
    if (wall_of(&made->samples[k]) < wall) least = fmin(least, separation(made, made->samples[k].x, x));
  return least;
}

/* Kept samples keep off those of earlier walls, left-out ones have one of them in their place. */
static int64_t check_union(const char *text) {
  walls made = make_walls(text, 1);
  int64_t left_out = 0, at = 0;
  for (int w = 0; w < made.plan.boundary_sources; w++) {
    const hc_setup_source *const source = &made.plan.boundary[w];
    for (int64_t k = 0; k < hc_sampling_count(&source->sampling); k++) {
      int64_t point[3];
      double x[3];
      hc_sampling_point(&source->sampling, k, point);
      for (int a = 0; a < 3; a++) x[a] = hc_frame_to_metres(&made.frame, a, point[a]);
      const double gap = nearest_earlier(&made, x, w);
      if (at < made.count && made.samples[at].id == hc_id_make(HC_ID_BOUNDARY, (uint64_t)w, (uint64_t)k)) {
        ck_assert_msg(gap > 0.499, "wall %d, sample %lld: %g spacings from an earlier one", w, (long long)k,
                      gap);
        at++;
        continue;
      }
      ck_assert_msg(gap < 0.501, "wall %d, sample %lld: left out without need", w, (long long)k);
      left_out++;
    }
  }
  ck_assert_int_eq(at, made.count);
  const int sizes[] = {2, 3, 7};
  for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
    walls parts = make_walls(text, sizes[s]);
    ck_assert_int_eq(parts.count, made.count);
    ck_assert_mem_eq(parts.samples, made.samples, (size_t)made.count * sizeof *made.samples);
    free_walls(&parts);
  }
  free_walls(&made);
  return left_out;
}

START_TEST(obstacle_on_a_floor_shares_nothing) {
  /* Kleefsman's tank and box, coarsely. */
  ck_assert_int_eq(
      check_union("boundary:\n  walls:\n"
                  "  - box: {min: [0, 0, 0], max: [3.22, 1, 1]}\n"
                  "  - {inside: solid, box: {min: [0.6635, 0.295, 0], max: [0.8245, 0.698, 0.161]}}\n"),
      0);
}
END_TEST

START_TEST(equal_walls_are_one) {
  static const char tank[] = "  - box: {min: [0, 0, 0], max: [1, 0.7, 0.83]}\n";
  static const char ball[] = "  - {inside: solid, sphere: {center: [0.5, 0.35, 0.4], radius: 0.3}}\n";
  char text[1024];
  snprintf(text, sizeof text, "boundary:\n  walls:\n%s%s%s%s", tank, ball, tank, ball);
  walls made = make_walls(text, 1);
  ck_assert_int_eq(hc_source_count(&made.plan.boundary[2]), 0);
  ck_assert_int_eq(hc_source_count(&made.plan.boundary[3]), 0);
  ck_assert_int_eq(made.plan.boundary[2].gaps.count, 1); /* a range, not a list */
  ck_assert_int_eq(check_union(text), made.count);
  free_walls(&made);
}
END_TEST

START_TEST(crossing_walls_close_without_crowding) {
  static const char *const scenes[] = {
      /* planes that cross, one of them oblique */
      "  - plane: {point: [0, 0, 0], normal: [0, 0, 1], size: [1.5, 1.5]}\n"
      "  - plane: {point: [0, 0, 0], normal: [1, 0, 0], size: [1.5, 1.5]}\n"
      "  - plane: {point: [0, 0, 0], normal: [1, 2, 2], size: [1.5, 1.5]}\n",
      /* the second gives way to the first, so the third need not give way to the second */
      "  - plane: {point: [0, 0, 0], normal: [0, 0, 1], size: [0.6, 0.6]}\n"
      "  - plane: {point: [0, 0, 0.04], normal: [0, 0, 1], size: [0.6, 0.6]}\n"
      "  - plane: {point: [0, 0, 0.08], normal: [0, 0, 1], size: [0.6, 0.6]}\n",
      /* containers that share a wall */
      "  - box: {min: [0, 0, 0], max: [1, 0.5, 0.5]}\n  - box: {min: [1.08, 0, 0], max: [2, 0.5, 0.5]}\n",
      /* round obstacles through floor and side */
      "  - box: {min: [0, 0, 0], max: [1, 1, 1]}\n"
      "  - {inside: solid, cylinder: {base: [0.5, 0.5, -0.3], axis: [0.2, 0, 1], radius: 0.22, length: "
      "0.7}}\n"
      "  - {inside: solid, sphere: {center: [0.95, 0.5, 0.5], radius: 0.31}}\n",
      /* a turned box in a pipe */
      "  - {cylinder: {base: [0, 0, 0], axis: [1, 0, 0], radius: 0.5, length: 1.4}, open: [top]}\n"
      "  - {inside: solid, box: {min: [0.3, -0.6, -0.2], max: [0.7, 0.6, 0.2], rotation: {axis: [1, 1, 0],\n"
      "     angle: 30}}}\n",
  };
  for (size_t s = 0; s < sizeof scenes / sizeof *scenes; s++) {
    char text[1024];
    snprintf(text, sizeof text, "boundary:\n  walls:\n%s", scenes[s]);
    ck_assert_int_gt(check_union(text), 5);
  }
}
END_TEST

/* A wall across the lower end of the domain meets one across the upper end. */
START_TEST(walls_meet_around_a_period) {
  static const char text[] = "domain: {periodic: [true, true, false], min: [0, 0, 0], max: [1, 1, 0]}\n"
                             "boundary:\n  walls:\n"
                             "  - plane: {point: [1.03, 0.5, 0], normal: [1, 0, 0], size: [0.9, 0.6]}\n"
                             "  - plane: {point: [4.06, 0.5, 0], normal: [1, 0, 0], size: [0.9, 0.6]}\n"
                             "  - {inside: solid, sphere: {center: [0, 3, 0.1], radius: 0.25}}\n";
  ck_assert_int_gt(check_union(text), 54);
}
END_TEST

/* Counting what 10^9 samples share must not need to look at them all. */
START_TEST(large_walls_are_counted_quickly) {
  static const char text[] = "boundary:\n  walls:\n"
                             "  - box: {min: [0, 0, 0], max: [2000, 1000, 1000]}\n"
                             "  - {inside: solid, box: {min: [500, 400, -0.12], max: [501, 401, 2]}}\n"
                             "  - plane: {point: [700, 500, 500], normal: [1, 0, 0], size: [1000, 1000]}\n";
  hc_scene scene;
  hc_error error = {.text = ""};
  ck_assert_msg(read_scene(&scene, text, false, NULL, &error) == HC_OK, "%s", error.text);
  hc_frame frame;
  hc_setup_plan plan;
  ck_assert_int_eq(hc_setup_frame(&scene, &frame, &error), HC_OK);
  ck_assert_int_eq(hc_setup_plan_make(NULL, &scene, &frame, &plan, &error), HC_OK);
  ck_assert_int_gt(plan.boundary_count, INT64_C(1000000000));
  ck_assert_int_gt(hc_gaps_total(&plan.boundary[1].gaps), 0);
  ck_assert_uint_lt(plan.boundary[1].gaps.room + plan.boundary[2].gaps.room, 1 << 20);
  hc_setup_plan_free(&plan);
  hc_scene_free(&scene);
}
END_TEST

START_TEST(gaps_map_places_to_samples) {
  hc_gaps gaps = {0};
  static const int64_t out[] = {0, 1, 5, 6, 7, 20};
  for (size_t k = 0; k < sizeof out / sizeof *out; k++) hc_gaps_add(&gaps, out[k]);
  ck_assert_int_eq(gaps.count, 3);
  ck_assert_int_eq(hc_gaps_total(&gaps), 6);
  int64_t place = 0;
  for (int64_t k = 0; k < 30; k++) {
    bool left_out = false;
    for (size_t i = 0; i < sizeof out / sizeof *out; i++) left_out |= out[i] == k;
    ck_assert_int_eq(hc_gaps_hold(&gaps, k), left_out);
    if (!left_out) ck_assert_int_eq(hc_gaps_kept(&gaps, place++), k);
  }
  hc_gaps_free(&gaps);
}
END_TEST

/* --- The review --- */

static int occurrences(const char *text, const char *word) {
  int count = 0;
  for (const char *at = strstr(text, word); at; at = strstr(at + 1, word)) count++;
  return count;
}

/* Refused with `count` messages, the first of which begins with `message`, from line 4 on. */
static void refuse(const char *text, int count, const char *message) {
  hc_scene scene;
  hc_error error = {.text = ""};
  ck_assert_int_eq(read_scene(&scene, text, true, NULL, &error), HC_BAD_INPUT);
  char expected[512];
  snprintf(expected, sizeof expected, "t.yaml:%s\n", message);
  ck_assert_msg(strncmp(error.text, expected, strlen(expected)) == 0, "%s\n\nand not\n\n%s", error.text,
                expected);
  ck_assert_msg(occurrences(error.text, "t.yaml:") == count, "%s", error.text);
  hc_scene_free(&scene);
}

/* Accepted, with a warning that begins with `warning` (null: none). */
static void accept(const char *text, const char *warning) {
  hc_scene scene;
  hc_error error = {.text = ""};
  hc_warnings warnings = {0};
  ck_assert_msg(read_scene(&scene, text, true, &warnings, &error) == HC_OK, "%s", error.text);
  ck_assert_msg(warnings.count == (warning != NULL), "%s", warnings.count ? warnings.text[0] : "no warning");
  char expected[512];
  snprintf(expected, sizeof expected, "t.yaml:%s\n", warning ? warning : "");
  if (warning)
    ck_assert_msg(strncmp(warnings.text[0], expected, strlen(expected)) == 0, "%s", warnings.text[0]);
  hc_warnings_free(&warnings);
  hc_scene_free(&scene);
}

#define TANK "boundary: {walls: [{name: tank, box: {min: [0, 0, 0], max: [1, 1, 1]}}]}\n"
#define BLOCK(...) "fluid: {blocks: [{" __VA_ARGS__ "}]}\n"

#define NO_FLUID(place)                                                                                      \
  place ": fluid.blocks must have at least one block, or fluid.emitters an emitter: there is no fluid"

START_TEST(blocks_must_hold_a_particle) {
  refuse("name: none\n", 1, NO_FLUID("1:1"));
  refuse("fluid: {blocks: []}\n", 1, NO_FLUID("4:17"));
  refuse(BLOCK("box: {min: [0, 0, 0], max: [0.5, 0.06, 0.5]}"), 1,
         "4:18: fluid.blocks[0] must be thick enough for a particle, at least particle_spacing (0.1 m), not "
         "0.06 m");
  refuse(BLOCK("sphere: {center: [0, 0, 0], radius: 0.04}"), 1,
         "4:18: fluid.blocks[0] must be thick enough for a particle, at least particle_spacing (0.1 m), not "
         "0.08 m");
  refuse(BLOCK("cylinder: {base: [0, 0, 0], radius: 1, length: 0.09}"), 1,
         "4:18: fluid.blocks[0] must be thick enough for a particle, at least particle_spacing (0.1 m), not "
         "0.09 m");
  accept(BLOCK("sphere: {center: [0, 0, 0], radius: 0.05}"), NULL);
}
END_TEST

START_TEST(fluid_must_keep_out_of_walls) {
  accept(TANK BLOCK("box: {min: [0, 0, 0], max: [1, 1, 1]}"), NULL);
  refuse(TANK BLOCK("box: {min: [0, 0, 0], max: [1, 1, 1.1]}"), 1,
         "5:18: fluid.blocks[0] must not reach into boundary.walls[0] \"tank\": a particle would start at "
         "(0.05, 0.05, 1.05) m, behind its surface");
  refuse(TANK BLOCK("sphere: {center: [3, 0.5, 0.5], radius: 0.15}"), 1,
         "5:18: fluid.blocks[0] must lie within the containers of the scene or above their open faces: a "
         "particle would start at (3, 0.5, 0.4) m, outside of all walls");
  static const char post[] =
      "boundary: {walls: [{name: post, inside: solid, cylinder: {base: [0.25, 0.25, 0],\n"
      "  radius: 0.1, length: 1}}]}\n" WATER;
  refuse(
      post, 1,
      "6:18: fluid.blocks[0] must stay out of boundary.walls[0] \"post\": a particle would start at (0.25, "
      "0.25, 0.05) m, within its surface");
  /* Half a spacing off the lattice in all directions: no sample is near, but it is inside. */
  static const char odd[] = "boundary: {walls: [{name: cube, inside: solid, box: {min: [0.05, 0.05, 0.05],\n"
                            "  max: [0.45, 0.45, 0.45]}}]}\n" WATER;
  refuse(
      odd, 1,
      "6:18: fluid.blocks[0] must stay out of boundary.walls[0] \"cube\": a particle would start at (0.15, "
      "0.15, 0.15) m, within its surface");
  accept("boundary: {walls: [{plane: {point: [0.25, 0.25, 0], normal: [0, 0, 1], size: [4, 4]}}]}\n" WATER,
         NULL);
  refuse("boundary: {walls: [{plane: {point: [0, 0, 0.3], normal: [1, 0, 1], size: [1, 1]}}]}\n" WATER, 1,
         "5:18: fluid.blocks[0] must not reach into boundary.walls[0] \"wall_0\": a particle would start at "
         "(0.15, 0.05, 0.05) m, behind its surface");
}
END_TEST

START_TEST(containers_go_on_beyond_open_faces) {
  static const char drop[] =
      "boundary: {walls: [{cylinder: {base: [0, 0, 0], radius: 0.5, length: 1}, open: [%s]}]}\n"
      "fluid: {blocks: [{sphere: {center: [0, 0, 2], radius: 0.3}}]}\n";
  char text[512];
  snprintf(text, sizeof text, drop, "top");
  accept(text, NULL);
  snprintf(text, sizeof text, drop, "base");
  refuse(text, 1,
         "5:18: fluid.blocks[0] must lie within the containers of the scene or above their open faces: a "
         "particle would start at (-0.1, -0.1, 1.8) m, outside of all walls");
  /* around a period: the same place by another name */
  accept("domain: {periodic: [true, true, false], min: [0, 0, 0], max: [1, 1, 0]}\n"
         "boundary: {walls: [{box: {min: [0, 0, 0], max: [0.4, 1, 1]}, open: [-y, +y]}]}\n"
         "fluid: {blocks: [{box: {min: [5, 0, 0], max: [5.4, 1, 0.5]}}]}\n",
         NULL);
  refuse("domain: {periodic: [true, true, false], min: [0, 0, 0], max: [1, 1, 0]}\n"
         "boundary: {walls: [{box: {min: [0, 0, 0], max: [0.4, 1, 1]}, open: [-y, +y]}]}\n"
         "fluid: {blocks: [{box: {min: [5.1, 0, 0], max: [5.5, 1, 0.5]}}]}\n",
         1,
         "6:18: fluid.blocks[0] must not reach into boundary.walls[0] \"wall_0\": a particle would start at "
         "(5.45, 0.05, 0.05) m, behind its surface");
}
END_TEST

START_TEST(blocks_must_not_overlap) {
#define TWO(a, b) "fluid:\n  blocks:\n  - " a "\n  - " b "\n"
  accept(TWO("box: {min: [0, 0, 0], max: [0.5, 0.5, 0.5]}", "box: {min: [0.5, 0, 0], max: [1, 0.5, 0.5]}"),
         NULL);
  refuse(
      TWO("box: {min: [0, 0, 0], max: [0.5, 0.5, 0.5]}", "box: {min: [0.4, 0, 0], max: [1, 0.5, 0.5]}"), 1,
      "7:5: fluid.blocks[1] must not overlap fluid.blocks[0]: a particle would start at (0.45, 0.05, 0.05) "
      "m, within both");
  /* one within the other, in either order, and lattices that miss each other */
  refuse(
      TWO("sphere: {center: [0, 0, 0], radius: 0.5}", "box: {min: [0, 0, 0], max: [0.1, 0.1, 0.1]}"), 1,
      "7:5: fluid.blocks[1] must not overlap fluid.blocks[0]: a particle would start at (0.05, 0.05, 0.05) "
      "m, within both");
  refuse(
      TWO("box: {min: [0.01, 0.01, 0.01], max: [0.14, 0.14, 0.14]}",
          "sphere: {center: [0, 0, 0], radius: 0.5}"),
      1,
      "7:5: fluid.blocks[1] must not overlap fluid.blocks[0]: a particle would start at (0.1, 0.1, 0.1) m, "
      "within both");
  /* only the earlier one's particle lies in the later one */
  refuse(
      TWO("box: {min: [0.05, 0.05, 0.05], max: [0.15, 0.15, 0.15]}",
          "sphere: {center: [0.05, 0.05, 0.05], radius: 0.5}"),
      1,
      "7:5: fluid.blocks[1] must not overlap fluid.blocks[0]: a particle would start at (0.1, 0.1, 0.1) m, "
      "within both");
  accept(TWO("sphere: {center: [0, 0, 0], radius: 0.3}", "box: {min: [0.2, 0.2, 0.2], max: [0.6, 0.6, 0.6]}"),
         NULL);
}
END_TEST

START_TEST(periods_that_do_not_fit_are_all_said) {
  refuse(
      "domain: {periodic: [true, false, true], min: [0, 0, 0], max: [1.05, 0, 0.5]}\n" WATER, 2,
      "4:62: domain along x is periodic: its length, 1.05 m, must be a whole number of particle spacings to "
      "1e-06 of the length; got particle_spacing 0.1 m; nearest that fit: 0.0954545455 or 0.105 m");
}
END_TEST

START_TEST(all_that_is_wrong_comes_at_once) {
  refuse(
      TANK "fluid:\n  blocks:\n"
           "  - box: {min: [0.8, 0, 0], max: [1.2, 0.5, 0.5]}\n"
           "  - box: {min: [0, 0, 0], max: [0.05, 0.5, 0.5]}\n"
           "  - box: {min: [0.7, 0, 0], max: [0.9, 0.5, 0.5]}\n"
           "  - {sphere: {center: [9, 9, 9], radius: 0.2}}\n",
      4,
      "7:5: fluid.blocks[0] must not reach into boundary.walls[0] \"tank\": a particle would start at (1.05, "
      "0.05, 0.05) m, behind its surface");
}
END_TEST

START_TEST(water_at_an_open_side_is_warned_of) {
#define OPEN_TANK(open, more)                                                                                \
  "boundary: {walls: [{name: tank, open: [" open "], box: {min: [0, 0, 0], max: [1, 0.5, 1]}}" more          \
  "]}\n" WATER
  accept(OPEN_TANK("+z", ""), NULL);
  accept(OPEN_TANK("+x", ""), NULL); /* the water is at the other end */
  accept(
      OPEN_TANK("-x", ""),
      "4:39: fluid.blocks[0] reaches the open face -x of boundary.walls[0] \"tank\" at (0.05, 0.05, 0.05) m "
      "and no other wall stands behind it: the fluid runs out at once");
  accept(OPEN_TANK("-x", ", {box: {min: [-2, 0, 0], max: [0, 0.5, 1]}, open: [+x]}"), NULL);
  accept(OPEN_TANK("-z", ", {plane: {point: [0.5, 0.2, -3], normal: [0, 0, 1], size: [9, 9]}}"), NULL);
  accept(OPEN_TANK("-x", "") "gravity: [0, 0, 0]\n", NULL);
  accept("boundary: {walls: [{cylinder: {base: [0, 0, 0], radius: 0.4, length: 1}, open: [base, top]}]}\n"
         "fluid: {blocks: [{cylinder: {base: [0, 0, 0], radius: 0.4, length: 0.5}}]}\n",
         "4:80: fluid.blocks[0] reaches the open base of boundary.walls[0] \"wall_0\" at (-0.1, -0.3, 0.05) "
         "m and "
         "no other wall stands behind it: the fluid runs out at once");
  accept("domain: {periodic: [true, false, false], min: [0, 0, 0], max: [0.6, 0, 0]}\n"
         "boundary: {walls: [{open: [-x, +x], box: {min: [0, 0, 0], max: [0.6, 0.5, 1]}}]}\n" WATER,
         NULL);
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("walls");
  TCase *const cases = tcase_create("walls and reviews");
  tcase_set_timeout(cases, 120);
  tcase_add_test(cases, obstacle_on_a_floor_shares_nothing);
  tcase_add_test(cases, equal_walls_are_one);
  tcase_add_test(cases, crossing_walls_close_without_crowding);
  tcase_add_test(cases, walls_meet_around_a_period);
  tcase_add_test(cases, large_walls_are_counted_quickly);
  tcase_add_test(cases, gaps_map_places_to_samples);
  tcase_add_test(cases, blocks_must_hold_a_particle);
  tcase_add_test(cases, fluid_must_keep_out_of_walls);
  tcase_add_test(cases, containers_go_on_beyond_open_faces);
  tcase_add_test(cases, blocks_must_not_overlap);
  tcase_add_test(cases, periods_that_do_not_fit_are_all_said);
  tcase_add_test(cases, all_that_is_wrong_comes_at_once);
  tcase_add_test(cases, water_at_an_open_side_is_warned_of);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
