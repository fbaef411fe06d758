/* Rest states as scenes take them: what is refused, whatever reads them; and their images in space. */
#include "base/memory.h"
#include "geometry/sampling.h"
#include "scene/reader.h"
#include "setup/fit.h"
#include "setup/rest_states.h"
#include "setup/scene_input.h"
#include "setup/world_frame.h"

#include <check.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EDGE = 8 }; /* spacings: a lattice, as calm as can be */

static double denser, squeezed, faster;
static bool ends;

static hc_status read_lattice(const char *path, hc_rest_state **state, hc_error *error) {
  (void)path;
  (void)error;
  hc_rest_state *const made = hc_alloc_zero(1, sizeof *made);
  *made = (hc_rest_state){.count = (int64_t)(EDGE * EDGE * EDGE * (1.0 + denser)),
                          .particle_spacing = 0.05,
                          .support_radius = 0.1,
                          .rest_density = 1000,
                          .mass_factor = 1,
                          .density_mean = 1,
                          .density_max = 1 + squeezed,
                          .speed_max = faster};
  made->position = hc_alloc_zero((size_t)made->count, sizeof *made->position);
  for (int64_t k = 0; k < made->count; k++) {
    const int64_t at[3] = {k % EDGE, k / EDGE % EDGE, k / EDGE / EDGE % EDGE};
    for (int a = 0; a < 3; a++) made->position[k][a] = (int32_t)(at[a] * HC_REST_PARTS + HC_REST_PARTS / 2);
  }
  for (int a = 0; a < 3; a++) {
    made->extent[a] = (int64_t)EDGE * HC_REST_PARTS;
    made->periodic[a] = !ends;
  }
  strcpy(made->solver, "dfsph");
  *state = made;
  return HC_OK;
}

/* Reads a scene; what it says of it, or nothing. */
static hc_scene read_scene(const char *more, char said[HC_ERROR_TEXT]) {
  const char *names[HC_FIELD_COUNT];
  hc_scene_files files = {.read_rest = read_lattice};
  const hc_scene_limits limits = hc_scene_input_limits(names, &files);
  hc_scene scene;
  hc_error error = {.text = ""};
  char text[2048];
  snprintf(text, sizeof text, "particle_spacing: 0.05\nend_time: 1\n%s", more);
  hc_scene_read_text(&scene, "t.yaml", text, strlen(text), NULL, 0, &limits, NULL, &error);
  strcpy(said, error.text);
  return scene;
}

static void expect_refused(const char *more, const char *message) {
  char said[HC_ERROR_TEXT];
  hc_scene scene = read_scene(more, said);
  ck_assert_msg(strstr(said, message), "no '%s' in '%s'", message, said);
  hc_scene_free(&scene);
}

#define BLOCK "fluid: {blocks: [{box: {min: [0, 0, 0], max: [0.9, 0.6, 0.5]}, rest_state: x}]}\n"

START_TEST(what_is_not_at_rest_is_refused) {
  char said[HC_ERROR_TEXT];
  hc_scene scene = read_scene(BLOCK, said);
  ck_assert_str_eq(said, "");
  hc_scene_free(&scene);
  denser = 0.01;
  expect_refused(BLOCK, "is denser than at rest: 1.0098 particles a spacing^3");
  denser = 0.0;
  squeezed = 0.02;
  expect_refused(BLOCK, "is denser than at rest");
  squeezed = 0.0;
  faster = 0.1;
  expect_refused(BLOCK, "is not at rest: its fastest particle moved by 0.1 half spacings");
  faster = 0.0;
  ends = true;
  expect_refused(BLOCK,
                 "is not periodic along x and reaches from 0 to 0.4 m there, the block from 0 to 0.9 m");
  ends = false;
}
END_TEST

START_TEST(a_period_must_be_a_multiple) {
  static const char open[] =
      "domain: {periodic: [true, false, false], min: [0, 0, 0], max: [%g, 0, 0]}\n"
      "fluid: {blocks: [{box: {min: [0, 0, 0], max: [%g, 0.4, 0.4]}, rest_state: x}]}\n";
  char more[512], said[HC_ERROR_TEXT];
  snprintf(more, sizeof more, open, 0.9, 0.9);
  expect_refused(more, "has a period of 0.4 m along x, of which the scene's, 0.9 m, is no multiple");
  snprintf(more, sizeof more, open, 0.8, 0.8);
  hc_scene scene = read_scene(more, said);
  ck_assert_str_eq(said, "");
  hc_scene_free(&scene);
  snprintf(more, sizeof more, open, 0.9, 0.7); /* which does not go around */
  scene = read_scene(more, said);
  ck_assert_str_eq(said, "");
  hc_scene_free(&scene);
}
END_TEST

/* The source of the scene's block, and its air, fitted to nothing or to its walls. */
static void fit(const hc_scene *scene, hc_frame *frame, hc_setup_source *fluid, hc_setup_source *air) {
  hc_error error = {.text = ""};
  ck_assert_int_eq(hc_setup_frame(scene, frame, &error), HC_OK);
  ck_assert_int_eq(hc_source_block(frame, &scene->fluid.blocks[0], 0, fluid, &error), HC_OK);
  hc_setup_source walls[2];
  for (int w = 0; w < scene->boundary.wall_count; w++)
    ck_assert_int_eq(hc_source_wall(frame, &scene->boundary.walls[w], w, 1, &walls[w], &error), HC_OK);
  *air = *fluid;
  hc_setup_fit(&(hc_fit){.frame = frame, .surfaces = walls, .walls = scene->boundary.wall_count}, fluid, air);
  for (int w = 0; w < scene->boundary.wall_count; w++) hc_source_free(&walls[w]);
}

static int64_t count_fitted(const char *more, int64_t *air_count) {
  char said[HC_ERROR_TEXT];
  hc_scene scene = read_scene(more, said);
  ck_assert_str_eq(said, "");
  hc_frame frame;
  hc_setup_source fluid, air;
  fit(&scene, &frame, &fluid, &air);
  const int64_t count = hc_source_count(&fluid);
  *air_count = hc_source_count(&air);
  hc_gaps_free(&air.gaps);
  hc_source_free(&fluid);
  hc_scene_free(&scene);
  return count;
}

START_TEST(images_fill_a_box_and_the_air_around_it) {
  int64_t air;
  ck_assert_int_eq(count_fitted(BLOCK, &air), 18 * 12 * 10);
  ck_assert_int_gt(air, 21 * 15 * 13 - 18 * 12 * 10); /* two spacings on each side, but for the corners */
  ck_assert_int_lt(air, 22 * 16 * 14 - 18 * 12 * 10);
  /* the same a quarter of an image on, from below the origin, and far from it */
  ck_assert_int_eq(
      count_fitted("fluid: {blocks: [{box: {min: [-0.35, 100.1, 0.05], max: [0.55, 100.7, 0.55]}, "
                   "rest_state: x, rest_offset: [0.1, 0.1, 0.1]}]}\n",
                   &air),
      18 * 12 * 10);
}
END_TEST

START_TEST(a_period_is_filled_once) {
  int64_t air;
  ck_assert_int_eq(
      count_fitted("domain: {periodic: [true, true, true], min: [0, 0, 0], max: [0.8, 0.8, 0.4]}\n"
                   "fluid: {blocks: [{box: {min: [0, 0, 0], max: [0.8, 0.8, 0.4]}, rest_state: x, "
                   "rest_offset: [0.02, 0.03, 0.01]}]}\n",
                   &air),
      16 * 16 * 8);
  ck_assert_int_eq(air, 0);
}
END_TEST

START_TEST(walls_keep_their_room) {
  int64_t air;
  const int64_t count =
      count_fitted("boundary:\n  walls:\n"
                   "    - {box: {min: [0, 0, 0], max: [0.6, 0.6, 0.6]}, inside: fluid, open: [+z]}\n"
                   "    - {box: {min: [0.2, 0.2, 0.2], max: [0.4, 0.4, 0.4]}, inside: solid}\n"
                   "fluid: {blocks: [{box: {min: [-1, -1, -1], max: [1, 1, 0.5]}, rest_state: x}]}\n",
                   &air);
  ck_assert_int_eq(count, 12 * 12 * 10 - 4 * 4 * 4);
  ck_assert_int_eq(air, 12 * 12 * 2);
}
END_TEST

int main(void) {
  Suite *suite = suite_create("rest states");
  TCase *tests = tcase_create("rest states");
  tcase_add_test(tests, what_is_not_at_rest_is_refused);
  tcase_add_test(tests, a_period_must_be_a_multiple);
  tcase_add_test(tests, images_fill_a_box_and_the_air_around_it);
  tcase_add_test(tests, a_period_is_filled_once);
  tcase_add_test(tests, walls_keep_their_room);
  suite_add_tcase(suite, tests);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
