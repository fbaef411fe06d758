/* What a scene prescribes: motions and what they make of walls, tables in files, the layers of emitters. */
#include "base/memory.h"
#include "boundary/boundary.h"
#include "scene/motion_file.h"
#include "scene/reader.h"
#include "setup/prescribed.h"
#include "setup/scene_input.h"
#include "setup/world_frame.h"

#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const double PI = 3.14159265358979323846;

/* ---- motions ---- */

static const hc_motion_row rows[] = {
    {0.5, {0, 0, 0}, 0}, {1.0, {0.1, 0, 0.2}, 0.125}, {1.5, {0.4, 0.1, 0.2}, 0.25}, {3.0, {0, 0, 0}, 0.25}};

static hc_motion table(bool smooth) {
  return (hc_motion){.law = HC_MOTION_TABLE,
                     .start = 0.25,
                     .stop = INFINITY,
                     .centre = {1, 2, 3},
                     .axis = {0, 0.6, 0.8},
                     .smooth = smooth,
                     .rows = rows,
                     .row_count = 4};
}

static hc_motion cosine(void) {
  return (hc_motion){.law = HC_MOTION_COSINE,
                     .start = 0.5,
                     .stop = 4,
                     .axis = {1, 0, 0},
                     .shift = {0.3, 0, -0.1},
                     .turns = 0.05,
                     .frequency = 0.7,
                     .phase = 0.2};
}

static hc_motion constant(void) {
  return (hc_motion){.law = HC_MOTION_CONSTANT,
                     .start = 1,
                     .stop = 2,
                     .axis = {0, 0, 1},
                     .shift = {1, -2, 0.5},
                     .turns = 0.75};
}

START_TEST(laws_have_their_values) {
  const hc_motion straight = constant(), swing = cosine(), steps = table(false);
  hc_pose pose = hc_motion_pose(&straight, 1.5);
  ck_assert_double_eq(pose.shift[1], -1.0);
  ck_assert_double_eq_tol(pose.spin[2], 1.5 * PI, 1e-15);
  pose = hc_motion_pose(&straight, 7);
  ck_assert_double_eq(pose.shift[1], -2.0); /* where it has come to, at rest */
  ck_assert_double_eq(hc_pose_speed(&pose, 1), 0.0);
  pose = hc_motion_pose(&straight, 0.5);
  ck_assert_double_eq(hc_pose_speed(&pose, 1) + fabs(pose.shift[0]) + fabs(pose.turn[0][0]), 0.0);

  pose = hc_motion_pose(&swing, 1.3);
  const double angle = 2 * PI * (0.7 * 0.8 + 0.2);
  ck_assert_double_eq_tol(pose.shift[0], 0.3 * (cos(angle) - cos(2 * PI * 0.2)), 1e-15);
  ck_assert_double_eq_tol(pose.velocity[2], 0.1 * 2 * PI * 0.7 * sin(angle), 1e-14);

  pose = hc_motion_pose(&steps, 0.25 + 1.25);
  ck_assert_double_eq_tol(pose.shift[0], 0.25, 1e-15);
  ck_assert_double_eq_tol(pose.velocity[1], 0.2, 1e-15);
  ck_assert_double_eq_tol(pose.turn[0][0], cos(2 * PI * 0.1875) - 1, 1e-15);
  pose = hc_motion_pose(&steps, 0.25 + 0.4);
  ck_assert_double_eq(hc_pose_speed(&pose, 1), 0.0); /* before the first row */
  pose = hc_motion_pose(&steps, 9);
  ck_assert_double_eq(hc_pose_speed(&pose, 1) + pose.shift[0], 0.0);
}
END_TEST

/* Where a point is. */
static void moved(const hc_motion *motion, const hc_pose *pose, const double x[3], double to[3]) {
  for (int a = 0; a < 3; a++) {
    to[a] = x[a] + pose->shift[a];
    for (int b = 0; b < 3; b++) to[a] += pose->turn[a][b] * (x[b] - motion->centre[b]);
  }
}

START_TEST(velocities_are_derivatives) {
  const hc_motion motions[] = {constant(), cosine(), table(false), table(true)};
  const double x[3] = {0.7, -0.4, 1.1}, h = 1e-6;
  for (int m = 0; m < 4; m++)
    for (double time = 0.013; time < 5; time += 0.0471) {
      const hc_motion *motion = &motions[m];
      const hc_pose before = hc_motion_pose(motion, time - h), now = hc_motion_pose(motion, time),
                    then = hc_motion_pose(motion, time + h);
      double from[3], at[3], to[3], arm[3];
      moved(motion, &before, x, from);
      moved(motion, &now, x, at);
      moved(motion, &then, x, to);
      double speed = 0;
      for (int a = 0; a < 3; a++) arm[a] = at[a] - motion->centre[a] - now.shift[a];
      for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        const double v = now.velocity[a] + now.spin[b] * arm[c] - now.spin[c] * arm[b];
        ck_assert_msg(fabs((to[a] - from[a]) / (2 * h) - v) < 1e-7, "motion %d at %g s: %g, not %g m/s", m,
                      time, v, (to[a] - from[a]) / (2 * h));
        speed += v * v;
      }
      const double reach = sqrt(arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2]);
      ck_assert_double_le(sqrt(speed), hc_pose_speed(&now, reach) + 1e-12);
    }
}
END_TEST

START_TEST(smooth_tables_go_through_their_rows) {
  const hc_motion smooth = table(true);
  for (int k = 0; k < 4; k++) {
    const hc_pose pose = hc_motion_pose(&smooth, 0.25 + rows[k].time),
                  before = hc_motion_pose(&smooth, 0.25 + rows[k].time - 1e-9);
    for (int a = 0; a < 3; a++) {
      ck_assert_double_eq_tol(pose.shift[a], rows[k].shift[a], 1e-15);
      ck_assert_double_eq_tol(pose.velocity[a], before.velocity[a], 1e-7);
    }
  }
  double low[3], high[3];
  hc_motion_range(&smooth, 10, low, high);
  ck_assert_double_eq(low[0], 0.0);
  ck_assert_double_eq(high[0], 0.4);
  ck_assert(hc_motion_turns(&smooth));
}
END_TEST

START_TEST(turns_keep_lengths) {
  const hc_motion smooth = table(true);
  const hc_pose pose = hc_motion_pose(&smooth, 1.4);
  double turn[3][3];
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) turn[a][b] = pose.turn[a][b] + (a == b);
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) {
      double product = 0;
      for (int k = 0; k < 3; k++) product += turn[a][k] * turn[b][k];
      ck_assert_double_eq_tol(product, a == b, 1e-15);
    }
}
END_TEST

/* ---- walls ---- */

static hc_scene scene_of(const char *text) {
  hc_scene scene;
  hc_error error;
  if (hc_scene_read_text(&scene, "t.yaml", text, strlen(text), NULL, 0, NULL, NULL, &error) != HC_OK)
    ck_abort_msg("%s", error.text);
  return scene;
}

static const char two_walls[] = "particle_spacing: 0.02\nend_time: 1\nboundary:\n  walls:\n"
                                "  - {box: {min: [0, 0, 0], max: [0.4, 0.2, 0.2]}}\n"
                                "  - {box: {min: [0.1, 0, 0], max: [0.2, 0.2, 0.2]}, inside: solid,\n"
                                "     motion: {type: constant, velocity: [0.5, 0, 0], angular_velocity: "
                                "1.5707963267948966, axis: [0, 0, 2],\n"
                                "              center: [0.1, 0.1, 0]}}\n";

START_TEST(poses_do_not_add_up) {
  hc_scene scene = scene_of(two_walls);
  hc_frame frame;
  hc_setup_plan plan;
  hc_error error;
  ck_assert_int_eq(hc_setup_frame(&scene, &frame, &error), HC_OK);
  ck_assert_int_eq(hc_setup_plan_make(NULL, &scene, &frame, &plan, &error), HC_OK);
  hc_particles fluid, still, boundary;
  hc_particles_init(&fluid, HC_FLUID, HC_FOR_ALL);
  hc_particles_init(&still, HC_BOUNDARY, HC_FOR_ALL);
  hc_particles_init(&boundary, HC_BOUNDARY | HC_MOVED, HC_FOR_ALL);
  ck_assert_int_eq(hc_setup_generate(&plan, 0, 1, &fluid, &still, &boundary, &error), HC_OK);
  ck_assert_int_eq(still.own + boundary.own, plan.boundary_count);
  for (int32_t k = 0; k < still.own; k++) ck_assert_int_eq(hc_id_source_of(still.id[k]), 0);
  hc_movers moving = hc_prescribed_movers_make(&scene, &plan);
  ck_assert_int_eq(moving.count, 1);
  const size_t bytes = 3 * (size_t)boundary.own * sizeof *boundary.position;
  int64_t *once = hc_alloc(1, bytes), *start = hc_alloc(1, bytes);
  memcpy(start, boundary.position, bytes);
  for (int32_t k = 0; k < 3 * boundary.own; k++) boundary.normal[k] = k % 3 == 0;
  hc_movers_start(&boundary);
  static const double times[] = {1.0, 0.0, 0.3, 0.7, 0.2, 1.0};
  for (int k = 0; k < 6; k++) {
    moving.poses[0] = hc_motion_pose(&moving.walls[0].motion, times[k]);
    hc_movers_place(&moving, &frame, &boundary);
    if (k == 0) memcpy(once, boundary.position, bytes);
    if (k == 1) ck_assert_mem_eq(boundary.position, start, bytes);
  }
  ck_assert_mem_eq(boundary.position, once, bytes);
  ck_assert_mem_eq(boundary.reference, start, bytes);
  for (int32_t k = 0; k < boundary.own; k++) { /* a quarter turn about (0.1, 0.1) and half a metre */
    double x[3], was[3];
    for (int a = 0; a < 3; a++) {
      x[a] = hc_frame_to_metres(&frame, a, boundary.position[3 * k + a]);
      was[a] = hc_frame_to_metres(&frame, a, start[3 * k + a]);
    }
    ck_assert_int_eq(hc_id_source_of(boundary.id[k]), 1);
    const double to[3] = {0.6 - (was[1] - 0.1), 0.1 + (was[0] - 0.1), was[2]};
    for (int a = 0; a < 3; a++) ck_assert_double_eq_tol(x[a], to[a], 2e-10);
    ck_assert_float_eq_tol(boundary.normal[3 * k], 0.0f, 1e-6f);
    ck_assert_float_eq_tol(boundary.normal[3 * k + 1], 1.0f, 1e-6f);
  }
  ck_assert_int_gt(boundary.own, 100);
  for (int32_t k = 0; k < boundary.own; k++) {
    const double y = hc_frame_to_metres(&frame, 1, boundary.position[3 * k + 1]) - 0.1;
    ck_assert_double_eq_tol(boundary.wall_velocity[3 * k], (float)(0.5 - PI / 2 * y), 1e-6);
  }
  hc_free(once);
  hc_free(start);
  hc_movers_free(&moving);
  hc_setup_plan_free(&plan);
  hc_particles_free(&fluid);
  hc_particles_free(&still);
  hc_particles_free(&boundary);
  hc_scene_free(&scene);
}
END_TEST

/* A wall at -x comes with 0.4 m/s: what is too deep in it gets its speed, what is not stays. */
START_TEST(contact_carries_along) {
  hc_particles fluid;
  hc_particles_init(&fluid, HC_FLUID, HC_FOR_ALL);
  hc_particles_resize(&fluid, 3);
  hc_particles_set_ghosts(&fluid, 0);
  const float densities[] = {0.5f, 0.1f, 0.5f};
  for (int k = 0; k < 3; k++) {
    fluid.wall_density[k] = densities[k];
    const float gradient[3] = {-5.0f, 0.0f, 0.0f};
    memcpy(&fluid.wall_gradient[3 * k], gradient, sizeof gradient);
    fluid.wall_rate[k] = -5.0f * 0.4f;
    fluid.pressure[k] = 0.0f;
  }
  fluid.velocity[6] = 0.5; /* faster than the wall */
  uint32_t rows[4] = {0};  /* no samples in sight */
  const hc_neighbors none = {.row = rows};
  hc_holds holds = {.count = 0};
  const hc_sweep sweep = {.fluid = &fluid, .walls = &none, .holds = &holds, .rest_density = 1000.0f};
  ck_assert_int_eq(hc_boundary_akinci2012.contact(&sweep, hc_select_all(sweep.fluid), 0.3, 0.001, NULL), 1);
  ck_assert_double_eq_tol(fluid.velocity[0], 0.4, 1e-6);
  ck_assert_double_eq(fluid.velocity[3], 0.0);
  ck_assert_double_eq(fluid.velocity[6], 0.5);
  hc_particles_free(&fluid);
}
END_TEST

/* ---- tables in files ---- */

static char folder[] = "/tmp/halocline_prescribed_XXXXXX";

/* Reads a scene whose table is these bytes; "" if it is good, else the first line of the message from the
 * table's line number on. */
static const char *read_bytes(const char *text, size_t length, const char *more, hc_scene *scene) {
  static hc_error error;
  char path[256];
  snprintf(path, sizeof path, "%s/table.csv", folder);
  FILE *file = fopen(path, "w");
  ck_assert_ptr_nonnull(file);
  fwrite(text, 1, length, file);
  fclose(file);
  snprintf(path, sizeof path, "%s/scene.yaml", folder);
  file = fopen(path, "w");
  ck_assert_ptr_nonnull(file);
  fprintf(file,
          "particle_spacing: 0.02\nend_time: 1\nboundary:\n  walls:\n"
          "  - {sphere: {center: [0, 0, 0], radius: 1}, motion: {type: table, file: table.csv%s}}\n",
          more);
  fclose(file);
  const char *names[HC_FIELD_COUNT];
  hc_scene_limits limits = hc_scene_input_limits(names, NULL);
  limits.check = NULL; /* there is no fluid */
  if (hc_scene_read(scene, path, NULL, 0, &limits, NULL, &error) == HC_OK) return "";
  *strchr(error.text, '\n') = '\0';
  char *found = strstr(error.text, "motion.file: ");
  return found ? strstr(found, "table.csv") + strlen("table.csv") : error.text;
}

static const char *read_table(const char *text, hc_scene *scene) {
  return read_bytes(text, strlen(text), ", center: [0, 0, 0]", scene);
}

START_TEST(tables_come_from_files) {
  hc_scene scene;
  ck_assert_str_eq(read_table("# paddle\n\ny, time ,x,z\n0,0,0,0\r\n 0.5 , 1e-1 ,-2,+3\n", &scene), "");
  const hc_wall_motion *motion = &scene.boundary.walls[0].motion;
  ck_assert_int_eq(motion->point_count, 2);
  ck_assert_double_eq(motion->points[1].time, 0.1);
  ck_assert_double_eq(motion->points[1].shift[0], -2.0);
  ck_assert_double_eq(motion->points[1].shift[1], 0.5);
  ck_assert_str_eq(motion->file, "");
  hc_scene_free(&scene);
  ck_assert_str_eq(read_table("time,x,y,z,angle\n0,0,0,0,90\n", &scene), "");
  ck_assert_double_eq(scene.boundary.walls[0].motion.points[0].angle, 90.0);
  hc_scene_free(&scene);
  ck_assert_str_eq(read_table("time,x,y\n0,0,0\n", &scene),
                   ":1: the first line must name the columns time, x, y, z and perhaps angle; z is missing");
  ck_assert_str_eq(read_table("time,x,y,z\n0,0,0,0\n0,1,0,0\n", &scene),
                   ":3: times must ascend, not 0 after 0");
  ck_assert_str_eq(read_table("time,x,y,z\n0,0,0\n", &scene),
                   ":2: a row must have 4 cells as the first line, not 3");
  ck_assert_str_eq(read_table("time,x,y,z\n0,0,a,0\n", &scene), ":2: y must be a number, not 'a'");
  ck_assert_str_eq(read_table("time,x,y,z\n0,0,nan,0\n", &scene), ":2: y must be a number, not 'nan'");
  ck_assert_str_eq(read_table("time,x,y,z\n", &scene), ": must have a row of numbers, has none");
}
END_TEST

/* What spreadsheets and other systems write is read; what would be misread is refused. */
START_TEST(tables_are_read_in_one_way) {
  hc_scene scene;
  const char *const good[] = {"\xef\xbb\xbftime,x,y,z\n0,0,0,0\n0.5,1,2,3\n",
                              "time,x,y,z\r\n0,0,0,0\r\n0.5,1,2,3\r\n",
                              "time,x,y,z\r0,0,0,0\r0.5,1,2,3",
                              "time;x;y;z\n0;0;0;0\n0.5;1;2;3\n",
                              "\"time\",\"x\", \"y\" ,\"z\"\n0,0,0,0\n\"0.5\",1,2,3\n",
                              "  time , x , y , z  \n\t0,0,0,0\n0.5,1,2,3"};
  for (size_t k = 0; k < sizeof good / sizeof *good; k++) {
    ck_assert_str_eq(read_table(good[k], &scene), "");
    const hc_wall_motion *const motion = &scene.boundary.walls[0].motion;
    ck_assert(motion->point_count == 2 && motion->points[1].time == 0.5 && motion->points[1].shift[2] == 3.0);
    hc_scene_free(&scene);
  }
#define HINT                                                                                                 \
  "; the first line must name the columns time, x, y, z and perhaps angle, with commas or semicolons "       \
  "between them"
  const char *const bad[][2] = {
      {"time,x,y,z,Angle\n0,0,0,0,1\n", ":1: unknown column 'Angle'; did you mean 'angle'?" HINT},
      {"time,x,y,z,pitch\n0,0,0,0,1\n", ":1: unknown column 'pitch'" HINT},
      {"time x y z\n0 0 0 0\n", ":1: unknown column 'time x y z'" HINT},
      {"time,x,y,z,x\n0,0,0,0,1\n", ":1: the column x must be there once, not twice"},
      {"time;x;y;z\n0;0,5;0;0\n", ":2: x must be a number, not '0,5'"}};
#undef HINT
  for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
    ck_assert_str_eq(read_table(bad[k][0], &scene), bad[k][1]);
  static const char utf16[] = "\xff\xfet\0i\0m\0e\0";
  ck_assert_str_eq(read_bytes(utf16, sizeof utf16, "", &scene),
                   ": must be a text in UTF-8, and has zeros in it (is it UTF-16?)");
}
END_TEST

/* The rules hold for what a file brings as for what the scene says. */
START_TEST(rules_hold_for_tables) {
  hc_scene scene;
  static const char turning[] = "time,x,y,z,angle\n0,0,0,0,0\n1,0,0,0,90\n",
                    shifting[] = "time,x,y,z\n0,0,0,0\n1,1,0,0\n";
  ck_assert_ptr_nonnull(
      strstr(read_bytes(turning, strlen(turning), "", &scene),
             "missing key 'boundary.walls[0].motion.center', required of a wall that turns"));
  ck_assert_str_eq(read_bytes(shifting, strlen(shifting), "", &scene), "");
  hc_scene_free(&scene);
}
END_TEST

/* ---- emitters ---- */

static hc_emitter emitter_of(const char *text, hc_emitters *emitters) {
  char whole[512];
  snprintf(whole, sizeof whole, "particle_spacing: 0.02\nend_time: 1\nfluid:\n  emitters: [{%s}]\n", text);
  hc_scene scene = scene_of(whole);
  hc_frame frame;
  hc_error error;
  ck_assert_int_eq(hc_setup_frame(&scene, &frame, &error), HC_OK);
  if (hc_prescribed_emitters_make(&scene, &frame, emitters, &error) != HC_OK) ck_abort_msg("%s", error.text);
  hc_scene_free(&scene);
  return emitters->emitters[0];
}

START_TEST(layers_fill_their_opening) {
  hc_emitters emitters;
  hc_emitter e = emitter_of(
      "rectangle: {position: [1, 2, 3], direction: [0, 0, -2], size: [0.1, 0.07]}, speed: 2", &emitters);
  ck_assert_int_eq(e.sample_count, 5 * 3);
  double x[3], low[3], high[3];
  hc_emitter_point(&e, 0, 0.01, x);
  ck_assert_double_eq_tol(x[0], 1 - 0.04, 1e-9);
  ck_assert_double_eq_tol(x[1], 2 - 0.02, 1e-9);
  ck_assert_double_eq_tol(x[2], 3 - 0.01, 1e-12);
  hc_prescribed_emitter_bounds(&e, low, high);
  ck_assert_double_eq_tol(high[0], 1.04, 1e-9);
  ck_assert_double_eq_tol(low[2], 2.98, 1e-9);
  ck_assert_double_eq(hc_emitter_layers_until(&e, 1), 100);
  ck_assert_double_eq(hc_emitter_most(&e, 0.5), 50 * 15);
  hc_emitters_free(&emitters);

  e = emitter_of(
      "disc: {position: [0, 0, 0], direction: [1, 1, 1], radius: 0.2}, rate: 0.1, max_particles: 1000, "
      "start: 0.1, stop: 0.3",
      &emitters);
  ck_assert_int_eq(e.sample_count, 316); /* of pi 10^2 */
  ck_assert_double_eq_tol(e.speed * (double)e.sample_count * 0.02 * 0.02, 0.1, 1e-9);
  for (int64_t k = 0; k < e.sample_count; k++) {
    hc_emitter_point(&e, k, 0.0, x);
    ck_assert_double_le(x[0] * x[0] + x[1] * x[1] + x[2] * x[2], 0.04 + 1e-7);
    ck_assert_double_eq_tol(x[0] + x[1] + x[2], 0, 1e-12);
  }
  ck_assert_double_eq(hc_emitter_most(&e, 1), 1000);
  ck_assert(!hc_emitters_due(&emitters, 0.0999));
  ck_assert(hc_emitters_due(&emitters, 0.1));
  ck_assert_double_eq(hc_emitters_speed(&emitters, 0.05, 0.04), 0.0);
  ck_assert_double_eq(hc_emitters_speed(&emitters, 0.05, 0.06), e.speed);
  emitters.emitters[0].layers = 1000;
  ck_assert(!hc_emitters_due(&emitters, 100)); /* its time is up */
  hc_emitters_free(&emitters);
}
END_TEST

START_TEST(an_opening_may_be_too_small) {
  hc_scene scene =
      scene_of("particle_spacing: 0.02\nend_time: 1\nfluid: {emitters: [{disc: {position: [0, 0, 0], "
               "direction: [1, 0, 0], radius: 0.01}, speed: 1}]}\n");
  hc_frame frame;
  hc_error error;
  hc_emitters emitters;
  ck_assert_int_eq(hc_setup_frame(&scene, &frame, &error), HC_OK);
  ck_assert_int_eq(hc_prescribed_emitters_make(&scene, &frame, &emitters, &error), HC_BAD_INPUT);
  ck_assert_str_eq(
      error.text,
      "fluid.emitters[0]: the opening must have room for a particle, at least 0.0282843 m across");
  hc_emitters_free(&emitters);
  hc_scene_free(&scene);
}
END_TEST

int main(void) {
  if (!mkdtemp(folder)) return EXIT_FAILURE;
  Suite *suite = suite_create("prescribed");
  TCase *cases = tcase_create("all");
  tcase_add_test(cases, laws_have_their_values);
  tcase_add_test(cases, velocities_are_derivatives);
  tcase_add_test(cases, smooth_tables_go_through_their_rows);
  tcase_add_test(cases, turns_keep_lengths);
  tcase_add_test(cases, poses_do_not_add_up);
  tcase_add_test(cases, contact_carries_along);
  tcase_add_test(cases, tables_come_from_files);
  tcase_add_test(cases, tables_are_read_in_one_way);
  tcase_add_test(cases, rules_hold_for_tables);
  tcase_add_test(cases, layers_fill_their_opening);
  tcase_add_test(cases, an_opening_may_be_too_small);
  suite_add_tcase(suite, cases);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_ENV);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  char path[256];
  snprintf(path, sizeof path, "%s/table.csv", folder);
  unlink(path);
  snprintf(path, sizeof path, "%s/scene.yaml", folder);
  unlink(path);
  rmdir(folder);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
