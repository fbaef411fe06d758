/* Snapshots written by all ranks and read back by one: whatever the distribution, the file holds every
 * particle. */
#include "mpi_test.h"

#include "base/memory.h"
#include "io/diff.h"
#include "io/run_dir.h"
#include "io/snapshot.h"
#include "io/snapshot_read.h"
#include "particles/ids.h"

#include <dirent.h>
#include <ftw.h>
#include <hdf5.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

static char directory[64];
static hc_particles fluid, boundary;
static hc_scene scene;
static hc_frame frame;

static int remove_one(const char *path, const struct stat *facts, int type, struct FTW *where) {
  (void)facts, (void)type, (void)where;
  return remove(path);
}

static void setup(void) {
  strcpy(directory, "/tmp/halocline_snapshot_XXXXXX");
  if (comm.rank == 0) ck_assert_ptr_nonnull(mkdtemp(directory));
  hc_comm_broadcast(&comm, directory, sizeof directory, 0);
  hc_particles_init(&fluid, HC_FLUID, HC_FOR_ALL);
  hc_particles_init(&boundary, HC_BOUNDARY, HC_FOR_ALL);
  memset(&scene, 0, sizeof scene);
  strcpy(scene.name, "tank");
  scene.particle_spacing = 0.02;
  scene.gravity[2] = -9.81;
  scene.fluid.rest_density = 1000;
  static const char *const names[] = {"velocity", "density", "volume", "velocity", "id", "acceleration"};
  for (int k = 0; k < 6; k++) strcpy(scene.output.snapshot_fields[k], names[k]);
  scene.output.snapshot_field_count = 6;
  memset(&frame, 0, sizeof frame);
  frame.support_radius = 0.04;
  for (int axis = 0; axis < 3; axis++) {
    frame.unit[axis] = 0.04 / HC_CELL_UNITS * (1 + 0.013 * axis);
    frame.origin[axis] = ((int64_t)1000003 * (axis + 1)) << HC_CELL_BITS;
  }
}

static void teardown(void) {
  hc_particles_free(&fluid);
  hc_particles_free(&boundary);
  hc_comm_barrier(&comm);
  if (comm.rank == 0) nftw(directory, remove_one, 16, FTW_DEPTH | FTW_PHYS);
}

/* Everything about a particle follows from its id, through the mixer. */
static int64_t expected_offset(uint64_t id, int axis) {
  return (int64_t)(mix(id * 3 + (uint64_t)axis) >> 15) - ((int64_t)1 << 48); /* 49 bits with the sign */
}
static double expected_velocity(uint64_t id, int axis) {
  return (double)(int64_t)mix(id * 7 + (uint64_t)axis) * 1e-18;
}
static float expected_scalar(uint64_t id) {
  return (float)(mix(id * 11) >> 40) * 1e-3f;
}

static void fill(hc_particles *particles, int32_t index, uint64_t id) {
  particles->id[index] = id;
  for (int axis = 0; axis < 3; axis++) {
    particles->position[3 * index + axis] = frame.origin[axis] + expected_offset(id, axis);
    if (particles->velocity) particles->velocity[3 * index + axis] = expected_velocity(id, axis);
    if (particles->acceleration)
      particles->acceleration[3 * index + axis] = expected_scalar(id + (uint64_t)axis);
  }
  if (particles->density) particles->density[index] = expected_scalar(id);
  if (particles->volume) particles->volume[index] = expected_scalar(id);
}

typedef int owner_of(uint64_t id);
static int owner_scattered(uint64_t id) {
  return (int)(mix(id) % (uint64_t)comm.size);
}
static int owner_blocks(uint64_t id) {
  return (int)((id & 0xffff) * (uint64_t)comm.size / 0x10000);
}
static int owner_last(uint64_t id) {
  return (void)id, comm.size - 1;
}

/* Gives this rank its share of `count` particles, in descending order so that the order of memory is no
 * order. */
static void share(hc_particles *particles, hc_id_kind kind, int64_t count, owner_of *owner) {
  int32_t mine = 0;
  for (int64_t k = 0; k < count; k++) mine += owner(hc_id_make(kind, 3, (uint64_t)k)) == comm.rank;
  hc_particles_resize(particles, mine);
  for (int64_t k = 0; k < count; k++) {
    const uint64_t id = hc_id_make(kind, 3, (uint64_t)k);
    if (owner(id) == comm.rank) fill(particles, --mine, id);
  }
}

static hc_status write_snapshot(int number, hc_error *error) {
  const hc_moment moment = {&frame, &fluid, &boundary, 42, 0.125, 1.0 / 1024, 0.5, NULL};
  error->status = HC_OK;
  error->text[0] = 0;
  return hc_snapshot_write(&comm, &scene, &moment, directory, number, error);
}

static void write_good(int number) {
  hc_error error;
  ck_assert_msg(write_snapshot(number, &error) == HC_OK, "%s", error.text);
}

static const char *path_of(int number) {
  static char path[2][128];
  snprintf(path[number & 1], sizeof *path, "%s/snapshots/snap_%06d.hdf", directory, number);
  return path[number & 1];
}

static void *must_read(const hc_snapshot_file *file, const char *name) {
  hc_error error;
  void *values = NULL;
  const hc_snapshot_field *field = hc_snapshot_read_find(file, name);
  ck_assert_msg(field != NULL, "no field %s", name);
  ck_assert_msg(hc_snapshot_read_field(file, field, &values, &error) == HC_OK, "%s", error.text);
  return values;
}

/* Rank 0: every particle is there once, with its values to the last bit. */
static void check_content(int number, int64_t fluids, int64_t boundaries) {
  static hc_snapshot_file file;
  hc_error error;
  ck_assert_msg(hc_snapshot_read_open(path_of(number), &file, &error) == HC_OK, "%s", error.text);
  const hc_snapshot_facts *facts = &file.facts;
  ck_assert_str_eq(facts->scene, "tank");
  ck_assert(facts->step == 42 && facts->time == 0.125 && facts->dt == 1.0 / 1024);
  ck_assert(facts->fluid == fluids && facts->boundary == boundaries && facts->pieces == comm.size);
  ck_assert(memcmp(facts->unit, frame.unit, sizeof frame.unit) == 0);
  ck_assert(memcmp(facts->origin, frame.origin, sizeof frame.origin) == 0);
  ck_assert_int_eq(file.field_count, 5); /* acceleration, density, kind, velocity, volume */
  uint64_t *ids = NULL;
  int64_t *positions = NULL;
  ck_assert(hc_snapshot_read_ids(&file, &ids, &error) == HC_OK);
  ck_assert(hc_snapshot_read_positions(&file, &positions, &error) == HC_OK);
  const double *velocity = must_read(&file, "velocity");
  const float *density = must_read(&file, "density"), *volume = must_read(&file, "volume");
  const uint8_t *kind = must_read(&file, "kind");
  bool *seen = hc_alloc_zero((size_t)(fluids + boundaries), sizeof *seen);
  bool good = true; /* a ck_assert costs a system call */
  for (int64_t k = 0; k < facts->particles; k++) {
    const bool is_fluid = hc_id_kind_of(ids[k]) == HC_ID_FLUID;
    const int64_t counter = (int64_t)(ids[k] & 0xffffffffff) + (is_fluid ? 0 : fluids);
    good = counter < fluids + boundaries && !seen[counter] && kind[k] == (is_fluid ? 0 : 1);
    if (good) seen[counter] = true;
    good &= density[k] == (is_fluid ? expected_scalar(ids[k]) : 0);
    good &= volume[k] == (is_fluid ? 0 : expected_scalar(ids[k]));
    for (int axis = 0; axis < 3; axis++) {
      good &= positions[3 * k + axis] == expected_offset(ids[k], axis);
      good &= velocity[3 * k + axis] == (is_fluid ? expected_velocity(ids[k], axis) : 0);
    }
    if (!good) ck_abort_msg("particle %lld of the file is not what was written", (long long)k);
  }
  hc_free(seen);
  hc_free(ids);
  hc_free(positions);
  hc_free((void *)velocity);
  hc_free((void *)density);
  hc_free((void *)volume);
  hc_free((void *)kind);
  hc_snapshot_read_close(&file);
}

static int64_t *raw(hid_t file, const char *name, int64_t *count) {
  const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(dataset);
  *count = H5Sget_simple_extent_npoints(space);
  int64_t *values = hc_alloc((size_t)*count, sizeof *values);
  ck_assert(H5Dread(dataset, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
  H5Sclose(space);
  H5Dclose(dataset);
  return values;
}

/* Rank 0: what ParaView walks along: counts per piece, cells that count from 0 within each piece. */
static void check_cells(int number, int64_t total) {
  const hid_t file = H5Fopen(path_of(number), H5F_ACC_RDONLY, H5P_DEFAULT);
  int64_t pieces = 0, points = 0, ends = 0, types = 0;
  int64_t *counts = raw(file, "VTKHDF/NumberOfCells", &pieces);
  int64_t *connectivity = raw(file, "VTKHDF/Connectivity", &points);
  int64_t *offsets = raw(file, "VTKHDF/Offsets", &ends);
  int64_t *type = raw(file, "VTKHDF/Types", &types);
  ck_assert(pieces == comm.size && points == total && types == total && ends == total + pieces);
  int64_t row = 0;
  bool good = true;
  for (int64_t piece = 0; piece < pieces; piece++) {
    for (int64_t k = 0; k < counts[piece]; k++, row++) {
      good &= connectivity[row] == k && offsets[row + piece] == k && type[row] == 1;
    }
    good &= offsets[row + piece] == counts[piece];
  }
  ck_assert(good && row == total);
  hc_free(counts);
  hc_free(connectivity);
  hc_free(offsets);
  hc_free(type);
  H5Fclose(file);
}

static void round_trip(int64_t fluids, int64_t boundaries, owner_of *owner) {
  share(&fluid, HC_ID_FLUID, fluids, owner);
  share(&boundary, HC_ID_BOUNDARY, boundaries, owner);
  write_good(0);
  if (comm.rank != 0) return;
  check_content(0, fluids, boundaries);
  check_cells(0, fluids + boundaries);
}

START_TEST(every_particle_comes_back) {
  round_trip(3000, 700, owner_scattered);
  round_trip(3000, 0, owner_scattered);
  round_trip(0, 700, owner_scattered);
  round_trip(3, 1, owner_scattered);
}
END_TEST

START_TEST(ranks_may_have_nothing) {
  round_trip(500, 60, owner_last);
  round_trip(500, 60, owner_blocks); /* few particles: all on the first rank */
  round_trip(0, 0, owner_last);
}
END_TEST

START_TEST(chunks_may_span_ranks) {
  round_trip(700001, 61001, owner_scattered);
}
END_TEST

static int compare(int a, int b) {
  hc_error error = {.status = HC_OK};
  FILE *sink = fopen("/dev/null", "w");
  const hc_diff_options exact = {0};
  const int result = hc_diff_run(path_of(a), path_of(b), &exact, sink, &error);
  fclose(sink);
  ck_assert_msg(result != HC_DIFF_IMPOSSIBLE, "%s", error.text);
  return result;
}

START_TEST(the_distribution_makes_no_difference) {
  share(&fluid, HC_ID_FLUID, 2000, owner_scattered);
  share(&boundary, HC_ID_BOUNDARY, 500, owner_scattered);
  write_good(0);
  share(&fluid, HC_ID_FLUID, 2000, owner_last);
  share(&boundary, HC_ID_BOUNDARY, 500, owner_last);
  write_good(1);
  if (comm.rank == 0) ck_assert_int_eq(compare(0, 1), HC_DIFF_SAME);
  if (fluid.own > 17) fluid.position[3 * 17 + 1] += 1;
  write_good(1);
  if (comm.rank == 0) ck_assert_int_eq(compare(0, 1), HC_DIFF_DIFFERENT);
}
END_TEST

START_TEST(the_bytes_are_reproducible) {
  share(&fluid, HC_ID_FLUID, 90000, owner_scattered);
  share(&boundary, HC_ID_BOUNDARY, 500, owner_scattered);
  write_good(0);
  write_good(1);
  char command[400];
  snprintf(command, sizeof command, "cmp %s %s", path_of(0), path_of(1));
  if (comm.rank == 0) ck_assert_int_eq(system(command), 0);
}
END_TEST

/* Rank 0: the directory holds nothing, no temporary either. */
static void check_empty(const char *path) {
  DIR *list = opendir(path);
  if (!list) return;
  int count = 0;
  while (readdir(list)) count++;
  closedir(list);
  ck_assert_int_eq(count, 2);
}

START_TEST(an_unwritable_directory_is_told_to_all) {
  share(&fluid, HC_ID_FLUID, 100, owner_scattered);
  char blocked[128];
  snprintf(blocked, sizeof blocked, "%s/snapshots", directory);
  if (comm.rank == 0) fclose(fopen(blocked, "w"));
  hc_error error;
  ck_assert_int_eq(write_snapshot(5, &error), HC_IO_FAILED);
  ck_assert_int_eq(error.status, HC_IO_FAILED);
  ck_assert_msg(strstr(error.text, "snapshot 5") && strstr(error.text, "Not a directory"), "%s", error.text);
}
END_TEST

START_TEST(an_unknown_field_is_told_to_all) {
  strcpy(scene.output.snapshot_fields[1], "colour");
  hc_error error;
  ck_assert_int_eq(write_snapshot(0, &error), HC_BAD_INPUT);
  ck_assert_msg(strstr(error.text, "\"colour\"") && strstr(error.text, "velocity, density"), "%s",
                error.text);
}
END_TEST

START_TEST(a_size_limit_is_an_error) {
  share(&fluid, HC_ID_FLUID, 5000, owner_scattered);
  struct rlimit old, tight;
  ck_assert_int_eq(getrlimit(RLIMIT_FSIZE, &old), 0);
  tight = old;
  if (comm.rank == comm.size - 1) tight.rlim_cur = 100000; /* one rank is enough */
  setrlimit(RLIMIT_FSIZE, &tight);
  hc_error error;
  const hc_status status = write_snapshot(0, &error);
  setrlimit(RLIMIT_FSIZE, &old);
  ck_assert_int_eq(status, HC_IO_FAILED);
  ck_assert_msg(strstr(error.text, "file size limit"), "%s", error.text);
  hc_comm_barrier(&comm);
  char path[128];
  snprintf(path, sizeof path, "%s/snapshots", directory);
  if (comm.rank == 0) check_empty(path);
}
END_TEST

/* The moment of a fault, with values that are no numbers: read back, and no part of the series. */
START_TEST(a_fault_has_a_snapshot_of_its_own) {
  share(&fluid, HC_ID_FLUID, 500, owner_scattered);
  for (int32_t k = 0; k < fluid.own; k++) fluid.density[k] = NAN;
  const hc_moment moment = {&frame, &fluid, &boundary, 42, 0.125, 1.0 / 1024, 0.5, NULL};
  hc_error error = {.status = HC_OK};
  ck_assert_msg(hc_snapshot_write_fault(&comm, &scene, &moment, directory, &error) == HC_OK, "%s",
                error.text);
  hc_comm_barrier(&comm);
  char path[128];
  snprintf(path, sizeof path, "%s/snapshots/run.hdf.series", directory);
  ck_assert_int_ne(access(path, F_OK), 0);
  if (comm.rank != 0) return;
  hc_snapshot_file file;
  snprintf(path, sizeof path, "%s/snapshots/fault_000042.hdf", directory);
  ck_assert_msg(hc_snapshot_read_open(path, &file, &error) == HC_OK, "%s", error.text);
  ck_assert_int_eq(file.facts.particles, 500);
  hc_snapshot_read_close(&file);
}
END_TEST

#ifndef __SANITIZE_ADDRESS__ /* which does not bear it */
START_TEST(short_memory_is_an_error) {
  share(&fluid, HC_ID_FLUID, 5000, owner_scattered);
  struct rlimit old, tight;
  ck_assert_int_eq(getrlimit(RLIMIT_AS, &old), 0);
  tight = old;
  long pages = 0;
  FILE *file = fopen("/proc/self/statm", "r");
  ck_assert(file && fscanf(file, "%ld", &pages) == 1);
  fclose(file);
  if (comm.rank == comm.size - 1) /* one rank is enough */
    tight.rlim_cur = (rlim_t)pages * (rlim_t)sysconf(_SC_PAGESIZE) + (16 << 20);
  setrlimit(RLIMIT_AS, &tight);
  hc_error error;
  const hc_status status = write_snapshot(0, &error);
  setrlimit(RLIMIT_AS, &old);
  ck_assert_int_eq(status, HC_FAILED);
  ck_assert_msg(strstr(error.text, "out of memory: writing"), "%s", error.text);
  write_good(0); /* and the program goes on */
}
END_TEST
#endif

/* On a tiny file system of memory, if we may mount one. */
START_TEST(a_full_disk_is_an_error) {
  int64_t mounted = comm.rank == 0 && mount("none", directory, "tmpfs", 0, "size=400k,nr_inodes=20") == 0;
  hc_comm_max_i64(&comm, &mounted, 1);
  if (!mounted) return;
  share(&fluid, HC_ID_FLUID, 20000, owner_scattered);
  hc_error error;
  const hc_status status = write_snapshot(0, &error);
  hc_particles_resize(&fluid, 0);
  hc_error later;
  const hc_status small = write_snapshot(1, &later); /* the space came back; the program goes on */
  char path[128];
  snprintf(path, sizeof path, "%s/snapshots/.snap_000000.hdf.tmp", directory);
  const bool left = access(path, F_OK) == 0 || access(path_of(0), F_OK) == 0;
  hc_comm_barrier(&comm);
  if (comm.rank == 0) umount(directory);
  hc_comm_barrier(&comm);
  ck_assert_int_eq(status, HC_IO_FAILED);
  ck_assert_msg(strstr(error.text, "No space left"), "%s", error.text);
  ck_assert(!left);
  ck_assert_msg(small == HC_OK, "%s", later.text);
}
END_TEST

START_TEST(a_run_directory_is_agreed) {
  hc_error error;
  ck_assert_int_eq(hc_run_dir_open(&comm, directory, HC_RUN_DIR_NEW, &error), HC_OK);
  char path[128];
  snprintf(path, sizeof path, "%s/steps.csv", directory);
  if (comm.rank == 0) fclose(fopen(path, "w"));
  ck_assert_int_eq(hc_run_dir_open(&comm, directory, HC_RUN_DIR_NEW, &error), HC_BAD_INPUT);
  ck_assert_msg(strstr(error.text, "--force"), "%s", error.text);
  ck_assert_int_eq(hc_run_dir_open(&comm, directory, HC_RUN_DIR_FORCE, &error), HC_OK);
  ck_assert_int_ne(access(path, F_OK), 0);
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("snapshot");
  tcase_add_checked_fixture(tests, setup, teardown);
  tcase_set_timeout(tests, 100);
  tcase_add_test(tests, every_particle_comes_back);
  tcase_add_test(tests, ranks_may_have_nothing);
  tcase_add_test(tests, chunks_may_span_ranks);
  tcase_add_test(tests, the_distribution_makes_no_difference);
  tcase_add_test(tests, the_bytes_are_reproducible);
  tcase_add_test(tests, an_unwritable_directory_is_told_to_all);
  tcase_add_test(tests, an_unknown_field_is_told_to_all);
  tcase_add_test(tests, a_size_limit_is_an_error);
  tcase_add_test(tests, a_full_disk_is_an_error);
  tcase_add_test(tests, a_fault_has_a_snapshot_of_its_own);
#ifndef __SANITIZE_ADDRESS__
  tcase_add_test(tests, short_memory_is_an_error);
#endif
  tcase_add_test(tests, a_run_directory_is_agreed);
  return run_mpi_tests("snapshot", tests);
}
