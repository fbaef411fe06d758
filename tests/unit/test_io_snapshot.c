/* Reading, comparing and describing snapshots, on files of one rank; the errors of bad files. */
#include "base/memory.h"
#include "comm/comm.h"
#include "io/diff.h"
#include "io/info.h"
#include "io/snapshot.h"
#include "io/snapshot_read.h"
#include "particles/ids.h"

#include <check.h>
#include <ftw.h>
#include <hdf5.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { FLUID = 40, BOUNDARY = 10 };

static hc_comm comm;
static char directory[64];
static hc_error error;
static hc_particles fluid, boundary;
static hc_scene scene;
static hc_frame frame;
static int64_t step;
static double now;
static char output[65536]; /* of the last diff or info */

static int remove_one(const char *path, const struct stat *facts, int type, struct FTW *where) {
  (void)facts, (void)type, (void)where;
  return remove(path);
}

static void fill(hc_particles *particles, hc_id_kind kind, int32_t count) {
  hc_particles_init(particles, kind == HC_ID_FLUID ? HC_FLUID : HC_BOUNDARY, HC_FOR_ALL);
  hc_particles_resize(particles, count);
  for (int32_t k = 0; k < count; k++) {
    particles->id[k] = hc_id_make(kind, 1, (uint64_t)k);
    for (int axis = 0; axis < 3; axis++)
      particles->position[3 * k + axis] = frame.origin[axis] + (int64_t)(k + axis) * 134217728;
    if (particles->volume) particles->volume[k] = 8e-6f;
    if (!particles->velocity) continue;
    particles->density[k] = 1000 + (float)k;
    for (int axis = 0; axis < 3; axis++) particles->velocity[3 * k + axis] = 0.1 * k + axis;
  }
}

static void setup(void) {
  strcpy(directory, "/tmp/halocline_io_XXXXXX");
  ck_assert_ptr_nonnull(mkdtemp(directory));
  memset(&scene, 0, sizeof scene);
  strcpy(scene.name, "tank \"A\"");
  scene.particle_spacing = 0.02;
  scene.fluid.rest_density = 1000;
  static const char *const names[] = {"velocity", "density", "volume"};
  for (int k = 0; k < 3; k++) strcpy(scene.output.snapshot_fields[k], names[k]);
  scene.output.snapshot_field_count = 3;
  memset(&frame, 0, sizeof frame);
  frame.support_radius = 0.04;
  for (int axis = 0; axis < 3; axis++) frame.unit[axis] = 0.04 / HC_CELL_UNITS;
  frame.origin[0] = HC_CELL_UNITS << 30;
  step = 5;
  now = 0.25;
  fill(&fluid, HC_ID_FLUID, FLUID);
  fill(&boundary, HC_ID_BOUNDARY, BOUNDARY);
}

static void teardown(void) {
  hc_particles_free(&fluid);
  hc_particles_free(&boundary);
  nftw(directory, remove_one, 16, FTW_DEPTH | FTW_PHYS);
}

static const char *path_of(int number) {
  static char path[2][128];
  snprintf(path[number & 1], sizeof *path, "%s/snapshots/snap_%06d.hdf", directory, number);
  return path[number & 1];
}

static void write_snapshot(int number) {
  const hc_moment moment = {&frame, &fluid, &boundary, step, now, 1e-3, 0.5, NULL};
  ck_assert_msg(hc_snapshot_write(&comm, &scene, &moment, directory, number, &error) == HC_OK, "%s",
                error.text);
}

static void swap(hc_particles *particles) {
  int32_t order[FLUID] = {0};
  float density[FLUID];
  const int32_t count = particles->own;
  for (int32_t k = 0; k < count; k++) order[k] = count - 1 - k;
  if (particles->density) memcpy(density, particles->density, sizeof density);
  hc_particles_permute(particles, order, count);
  for (int32_t k = 0; particles->density && k < count; k++) particles->density[k] = density[order[k]];
}

static int diff(double tolerance, bool json) {
  FILE *out = fmemopen(output, sizeof output, "w");
  const hc_diff_options options = {tolerance, json};
  const int result = hc_diff_run(path_of(0), path_of(1), &options, out, &error);
  fclose(out);
  return result;
}

START_TEST(order_makes_no_difference) {
  write_snapshot(0);
  swap(&fluid);
  swap(&boundary);
  write_snapshot(1);
  ck_assert_int_eq(diff(0, false), HC_DIFF_SAME);
  ck_assert_str_eq(output, "identical: 50 particles\n");
}
END_TEST

START_TEST(one_unit_of_position_is_seen) {
  write_snapshot(0);
  fluid.position[3 * 7 + 2]++;
  write_snapshot(1);
  ck_assert_int_eq(diff(0, false), HC_DIFF_DIFFERENT);
  ck_assert_msg(strstr(output, "position               1 of 50 differ") &&
                    strstr(output, " = 1 units at id ") && strstr(output, "(fluid, source 1, number 7)") &&
                    strstr(output, "density                identical") &&
                    strstr(output, "different: 1 of 50"),
                "%s", output);
  ck_assert_int_eq(diff(1e-9, false), HC_DIFF_SAME);
  ck_assert_msg(strstr(output, "the same within 1e-09: 50 particles"), "%s", output);
}
END_TEST

START_TEST(one_bit_of_a_field_is_seen) {
  write_snapshot(0);
  fluid.velocity[3 * 9 + 1] = nextafter(fluid.velocity[3 * 9 + 1], 1e9);
  boundary.volume[3] = nextafterf(boundary.volume[3], 1);
  write_snapshot(1);
  ck_assert_int_eq(diff(0, false), HC_DIFF_DIFFERENT);
  ck_assert_msg(strstr(output, "velocity               1 of 50 differ") && strstr(output, "number 9)") &&
                    strstr(output, "volume                 1 of 50 differ") &&
                    strstr(output, "(boundary, source 1, number 3)") && strstr(output, "different: 2 of 50"),
                "%s", output);
  ck_assert_int_eq(diff(1e-6, false), HC_DIFF_SAME);
}
END_TEST

START_TEST(signs_of_zero_and_not_a_number_are_bits) {
  fluid.velocity[3] = 0.0;
  fluid.density[5] = NAN;
  write_snapshot(0);
  write_snapshot(1);
  ck_assert_int_eq(diff(0, false), HC_DIFF_SAME);
  ck_assert_int_eq(diff(1e-3, false), HC_DIFF_SAME);
  fluid.velocity[3] = -0.0;
  write_snapshot(1);
  ck_assert_int_eq(diff(0, false), HC_DIFF_DIFFERENT);
  ck_assert_int_eq(diff(1e-3, false), HC_DIFF_SAME);
  fluid.density[5] = 1005;
  write_snapshot(1);
  ck_assert_int_eq(diff(0.5, false), HC_DIFF_DIFFERENT);
  ck_assert_msg(strstr(output, "worst nan kg/m3 at id"), "%s", output);
}
END_TEST

START_TEST(the_short_way_round_counts) {
  for (int axis = 0; axis < 3; axis++) frame.period[axis] = HC_CELL_UNITS * 10;
  fluid.position[0] = frame.origin[0];
  write_snapshot(0);
  fluid.position[0] += frame.period[0] - 3;
  write_snapshot(1);
  ck_assert_int_eq(diff(0, false), HC_DIFF_DIFFERENT);
  ck_assert_msg(strstr(output, " = 3 units at id"), "%s", output);
  ck_assert_int_eq(diff(1e-8, false), HC_DIFF_SAME);
}
END_TEST

START_TEST(missing_particles_and_fields_are_named) {
  write_snapshot(0);
  fluid.id[4] = hc_id_make(HC_ID_FLUID, 1, 999);
  hc_particles_resize(&boundary, BOUNDARY - 1);
  scene.output.snapshot_field_count = 2;
  step++;
  now += 0.5;
  write_snapshot(1);
  ck_assert_int_eq(diff(0, false), HC_DIFF_DIFFERENT);
  ck_assert_msg(
      strstr(output, "the steps differ") && strstr(output, "the times differ") &&
          strstr(output, "only in A: 2 particles: id 1099511627780 (fluid, source 1, number 4), ") &&
          strstr(output, "only in B: 1 particles: id 1099511628775") &&
          strstr(output, "volume                 only in A"),
      "%s", output);
  ck_assert_int_eq(diff(0, true), HC_DIFF_DIFFERENT);
  ck_assert_msg(strstr(output, "\"same\":false") && strstr(output, "\"scene\":\"tank \\\"A\\\"\"") &&
                    strstr(output, "\"only_in_b\":{\"count\":1,\"ids\":[1099511628775]}") &&
                    strstr(output, "\"trouble\":\"only in A\""),
                "%s", output);
}
END_TEST

START_TEST(a_file_that_cannot_be_compared_is_2) {
  write_snapshot(0);
  ck_assert_int_eq(diff(0, false), HC_DIFF_IMPOSSIBLE);
  ck_assert_msg(strstr(error.text, "No such file"), "%s", error.text);
  fluid.id[3] = fluid.id[2];
  write_snapshot(1);
  ck_assert_int_eq(diff(0, false), HC_DIFF_IMPOSSIBLE);
  ck_assert_msg(strstr(error.text, "ids must be unique, id 1099511627778 appears twice"), "%s", error.text);
  ck_assert_int_eq(diff(NAN, false), HC_DIFF_IMPOSSIBLE);
}
END_TEST

static void expect_bad(const char *path, const char *reason) {
  hc_snapshot_file *file = hc_alloc(1, sizeof *file);
  error.text[0] = 0;
  ck_assert_int_eq(hc_snapshot_read_open(path, file, &error), HC_BAD_INPUT);
  ck_assert_msg(strstr(error.text, reason) && strstr(error.text, path), "expected \"%s\", got: %s", reason,
                error.text);
  hc_free(file);
}

START_TEST(bad_files_are_told_apart) {
  char path[128];
  snprintf(path, sizeof path, "%s/missing.hdf", directory);
  expect_bad(path, "No such file or directory");
  expect_bad(directory, "a folder, not a snapshot");
  snprintf(path, sizeof path, "%s/text.hdf", directory);
  FILE *text = fopen(path, "w");
  fputs("hello\n", text);
  fclose(text);
  expect_bad(path, "not an HDF5 file");
  snprintf(path, sizeof path, "%s/other.hdf", directory);
  H5Fclose(H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
  expect_bad(path, "not a Halocline snapshot");
  write_snapshot(0);
  struct stat facts;
  ck_assert_int_eq(stat(path_of(0), &facts), 0);
  ck_assert_int_eq(truncate(path_of(0), facts.st_size / 2), 0);
  expect_bad(path_of(0), "truncated");
}
END_TEST

/* Writes snapshot 0 anew with one attribute that lies. */
static void write_lying(const char *attribute, int64_t value) {
  write_snapshot(0);
  const hid_t file = H5Fopen(path_of(0), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t group = H5Gopen2(file, "Halocline", H5P_DEFAULT), lie = H5Aopen(group, attribute, H5P_DEFAULT);
  ck_assert(H5Awrite(lie, H5T_NATIVE_INT64, &value) >= 0);
  H5Aclose(lie);
  H5Gclose(group);
  H5Fclose(file);
}

START_TEST(inconsistent_files_are_refused) {
  write_snapshot(0);
  const hid_t file = H5Fopen(path_of(0), H5F_ACC_RDWR, H5P_DEFAULT);
  H5Ldelete(file, "Halocline/fluid_per_piece", H5P_DEFAULT);
  H5Fclose(file);
  expect_bad(path_of(0), "fluid_per_piece is missing");
  write_lying("fluid_particles", 7);
  expect_bad(path_of(0), "must be 17 rows");
  write_lying("boundary_particles", -1);
  expect_bad(path_of(0), "must not be negative");
  write_lying("format_version", 7);
  expect_bad(path_of(0), "format_version must be 1, is 7");
}
END_TEST

START_TEST(positions_round_trip_to_2_48) {
  uint64_t bits = 99;
  for (int32_t k = 0; k < FLUID; k++)
    for (int axis = 0; axis < 3; axis++) {
      bits = bits * 6364136223846793005 + 1442695040888963407;
      fluid.position[3 * k + axis] =
          frame.origin[axis] + ((int64_t)(bits >> 16) - ((int64_t)1 << 47)) * 2 + 1;
    }
  fluid.position[0] = frame.origin[0] + ((int64_t)1 << 48) - 1;
  fluid.position[1] = frame.origin[1] - ((int64_t)1 << 48) + 1;
  frame.unit[1] = 0.1 / 3 / HC_CELL_UNITS;
  frame.unit[2] = M_PI;
  write_snapshot(0);
  hc_snapshot_file *file = hc_alloc(1, sizeof *file);
  int64_t *positions = NULL;
  ck_assert_int_eq(hc_snapshot_read_open(path_of(0), file, &error), HC_OK);
  ck_assert_int_eq(hc_snapshot_read_positions(file, &positions, &error), HC_OK);
  for (int k = 0; k < 3 * FLUID; k++) ck_assert(positions[k] == fluid.position[k] - frame.origin[k % 3]);
  hc_free(positions);
  hc_snapshot_read_close(file);
  hc_free(file);
}
END_TEST

START_TEST(the_tolerance_is_absolute) {
  write_snapshot(0);
  fluid.velocity[3 * 39] += 0.25; /* of 3.9 m/s */
  fluid.density[2] += 0.25f;      /* of 1002 kg/m3 */
  now += 0.25;
  write_snapshot(1);
  ck_assert_int_eq(diff(0.2499, false), HC_DIFF_DIFFERENT);
  ck_assert_msg(
      strstr(output, "the times differ") &&
          strstr(output, "velocity               1 of 50 differ by more than the tolerance; worst 0.25") &&
          strstr(output, "density                1 of 50 differ by more than the tolerance; worst 0.25"),
      "%s", output);
  ck_assert_int_eq(diff(0.2501, false), HC_DIFF_SAME);
}
END_TEST

START_TEST(scenes_that_differ_are_named) {
  write_snapshot(0);
  strcpy(scene.name, "pond");
  write_snapshot(1);
  ck_assert_int_eq(diff(0, false), HC_DIFF_SAME); /* a name is no physics */
  ck_assert_msg(strstr(output, "the scenes have different names") && strstr(output, "scene pond, step 5"),
                "%s", output);
  scene.gravity[2] = -1.5;
  scene.particle_spacing = 0.01;
  for (int axis = 0; axis < 3; axis++) frame.period[axis] = HC_CELL_UNITS * 25 / (axis + 1);
  write_snapshot(1);
  ck_assert_int_eq(diff(0, false), HC_DIFF_DIFFERENT);
  ck_assert_msg(strstr(output, "  particle_spacing differs: 0.02 m in A, 0.01 m in B\n") &&
                    strstr(output, "  gravity differs: 0, 0, 0 m/s2 in A, 0, 0, -1.5 m/s2 in B\n") &&
                    strstr(output, "  period differs: 0, 0, 0 m in A, 1, 0.5, ") &&
                    strstr(output, "different: 0 of 50"),
                "%s", output);
  ck_assert_int_eq(diff(0, true), HC_DIFF_DIFFERENT);
  ck_assert_msg(strstr(output, "\"same_scene\":false") &&
                    strstr(output, "{\"name\":\"particle_spacing\",\"unit\":\"m\",\"a\":0.02,\"b\":0.01}") &&
                    strstr(output, "\"a\":[0,0,0],\"b\":[0,0,-1.5]"),
                "%s", output);
}
END_TEST

static void info(bool json) {
  FILE *out = fmemopen(output, sizeof output, "w");
  ck_assert_int_eq(hc_info_print(path_of(0), json, out, &error), HC_OK);
  fclose(out);
}

START_TEST(info_tells_what_a_file_holds) {
  write_snapshot(0);
  info(false);
  ck_assert_msg(strstr(output, "tank \"A\"\n") && strstr(output, "time              0.25 s") &&
                    strstr(output, "50: 40 fluid, 10 boundary") &&
                    strstr(output, "fluid    extent   (0, 0.02, 0.04) to (0.78, 0.8, 0.82) m") &&
                    strstr(output, "1 (one per rank), 50 to 50") &&
                    strstr(output, "kg/m3    1000 to 1039, mean 1019.5\n") &&
                    strstr(output, "m/s      magnitude"),
                "%s", output);
  ck_assert_int_eq(hc_info_print(directory, false, stdout, &error), HC_BAD_INPUT);
}
END_TEST

START_TEST(info_adds_up) {
  scene.gravity[2] = -10;
  fluid.density[7] = NAN;
  write_snapshot(0);
  /* velocity_k = 0.1 k + axis, z_k = 0.02 (k + 2), 40 particles of 0.5 kg */
  info(false);
  ck_assert_msg(strstr(output, "mass              20 kg (0.5 kg a particle)\n") &&
                    strstr(output, "momentum          (39, 59, 79) kg m/s\n") &&
                    strstr(output, "potential energy  86 J\n") &&
                    strstr(output, "1000 to 1039, mean nan, 1 not a number\n"),
                "%s", output);
  double twice_kinetic = 0;
  for (int k = 0; k < 3 * FLUID; k++) twice_kinetic += 0.5 * pow(fluid.velocity[k], 2);
  const char *kinetic = strstr(output, "kinetic energy");
  ck_assert_double_eq_tol(strtod(kinetic + 14, NULL), 0.5 * twice_kinetic, 1e-9);
  scene.output.snapshot_field_count = 0;
  write_snapshot(0);
  info(false);
  ck_assert_msg(strstr(output, "mass   ") && !strstr(output, "momentum") && !strstr(output, "kinetic"), "%s",
                output);
}
END_TEST

START_TEST(info_as_json) {
  scene.output.snapshot_field_count = 2;
  write_snapshot(0);
  info(true);
  ck_assert_msg(strstr(output, "\"scene\":\"tank \\\"A\\\"\",\"step\":5,\"pieces\":1,\"particles\":50,") &&
                    strstr(output, "\"mass\":20,") && strstr(output, "\"gravity\":[0,0,0]") &&
                    strstr(output, "\"boundary\":{\"low\":[0,0.02,0.04],\"high\":[0.18,0.2,0.22]}") &&
                    strstr(output,
                           "{\"name\":\"density\",\"type\":\"float32\",\"components\":1,\"unit\":"
                           "\"kg/m3\",\"kinds\":[\"fluid\"],\"min\":1000,\"mean\":1019.5,\"max\":1039,"
                           "\"not_numbers\":0}"),
                "%s", output);
  hc_particles_resize(&boundary, 0);
  scene.output.snapshot_field_count = 0;
  write_snapshot(0);
  info(true);
  ck_assert_msg(strstr(output, "\"boundary\":null}") && strstr(output, "\"momentum\":[null,null,null]") &&
                    strstr(output, "\"kinetic_energy\":null"),
                "%s", output);
}
END_TEST

/* Files that were written before particles had a mass in them. */
START_TEST(an_older_file_lacks_the_mass) {
  write_snapshot(0);
  write_snapshot(1);
  const hid_t file = H5Fopen(path_of(0), H5F_ACC_RDWR, H5P_DEFAULT);
  ck_assert(H5Adelete_by_name(file, "Halocline", "particle_mass", H5P_DEFAULT) >= 0);
  H5Fclose(file);
  info(false);
  ck_assert_msg(!strstr(output, "mass") && !strstr(output, "energy"), "%s", output);
  ck_assert_int_eq(diff(0, false), HC_DIFF_SAME);
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("snapshot");
  tcase_add_checked_fixture(tests, setup, teardown);
  tcase_add_test(tests, order_makes_no_difference);
  tcase_add_test(tests, one_unit_of_position_is_seen);
  tcase_add_test(tests, one_bit_of_a_field_is_seen);
  tcase_add_test(tests, signs_of_zero_and_not_a_number_are_bits);
  tcase_add_test(tests, the_short_way_round_counts);
  tcase_add_test(tests, missing_particles_and_fields_are_named);
  tcase_add_test(tests, a_file_that_cannot_be_compared_is_2);
  tcase_add_test(tests, bad_files_are_told_apart);
  tcase_add_test(tests, inconsistent_files_are_refused);
  tcase_add_test(tests, positions_round_trip_to_2_48);
  tcase_add_test(tests, the_tolerance_is_absolute);
  tcase_add_test(tests, scenes_that_differ_are_named);
  tcase_add_test(tests, info_tells_what_a_file_holds);
  tcase_add_test(tests, info_adds_up);
  tcase_add_test(tests, info_as_json);
  tcase_add_test(tests, an_older_file_lacks_the_mass);
  Suite *suite = suite_create("io snapshot");
  suite_add_tcase(suite, tests);
  SRunner *runner = srunner_create(suite);
  srunner_set_fork_status(runner, CK_NOFORK); /* MPI does not survive a fork */
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  hc_comm_finish(&comm);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
