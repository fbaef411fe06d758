/* The public interface: sessions and runs on some ranks, what they tell, and their errors. */
#include "halocline/halocline.h"
#include "io/snapshot_read.h"
#include "mpi_test.h"

#include <math.h>
#include <mpi.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char text[] =
    "name: fall\n"
    "particle_spacing: 0.1\n"
    "gravity: [0, 0, -10]\n"
    "end_time: 0.01\n"
    "fluid: {blocks: [{box: {min: [0, 0, 5], max: [0.8, 0.5, 5.6]}, velocity: [1, 0, 0]}]}\n"
    "boundary: {walls: [{plane: {point: [0, 0, 0], normal: [0, 0, 1], size: [1, 1]}}]}\n"
    "time_step: {control: constant, size: 0.002}\n";
enum { FLUID = 8 * 5 * 6, BOUNDARY = 100, STEPS = 5 };

static hc_session *session;
static hc_error error;

static void setup(void) {
  memset(&error, 0, sizeof error);
  EXPECT(hc_session_start(NULL, &session, &error) == HC_OK);
}

static void teardown(void) {
  hc_session_end(session);
}

/* Only rank 0 knows the scene. */
static hc_run *start(void) {
  hc_run *run = NULL;
  const char *const overrides[] = {"fluid.mass_factor=0.5", "fluid.mass_factor=1"};
  const bool first = hc_session_rank(session) == 0;
  const hc_status status =
      hc_run_from_text(session, first ? text : NULL, first ? overrides : NULL, first ? 2 : 0, &run, &error);
  EXPECT(status == HC_OK && run);
  return run;
}

typedef struct copy {
  int64_t count;
  double *position, *velocity;
  float *density, *pressure;
  uint64_t *id;
} copy;

static copy copy_of(const hc_run *run, hc_run_kind kind) {
  const hc_run_facts facts = hc_run_facts_of(run);
  copy c = {.count = kind == HC_RUN_FLUID ? facts.own_fluid : facts.own_boundary};
  const size_t room = (size_t)c.count + 1;
  c.position = calloc(3 * room, sizeof *c.position);
  c.velocity = calloc(3 * room, sizeof *c.velocity);
  c.density = calloc(room, sizeof *c.density);
  c.pressure = calloc(room, sizeof *c.pressure);
  c.id = calloc(room, sizeof *c.id);
  const hc_run_particles arrays = {c.position, c.velocity, c.density, c.pressure, c.id};
  EXPECT(hc_run_get(run, kind, &arrays, c.count, &error) == HC_OK);
  return c;
}

static void free_copy(copy *c) {
  free(c->position);
  free(c->velocity);
  free(c->density);
  free(c->pressure);
  free(c->id);
}

static int64_t sum(int64_t value) {
  hc_comm_sum_i64(&comm, &value, 1);
  return value;
}

START_TEST(a_run_falls_as_it_must) {
  hc_run *run = start();
  hc_run_facts facts = hc_run_facts_of(run);
  EXPECT(facts.step == 0 && facts.time == 0 && facts.dt == 0 && !facts.done && facts.end_time == 0.01);
  EXPECT(facts.fluid == FLUID && facts.boundary == BOUNDARY && isnan(facts.kinetic_energy));
  EXPECT(facts.v_max == 1 && facts.particle_spacing == 0.1 && facts.support_radius == 0.2);
  EXPECT(fabs(facts.particle_mass - 1) < 1e-3); /* the later override counts */
  for (int step = 1; step <= STEPS; step++) {
    EXPECT(hc_run_step(run, &error) == HC_OK);
    facts = hc_run_facts_of(run);
    EXPECT(facts.step == step && facts.dt == 0.002 && facts.done == (step == STEPS));
  }
  EXPECT(facts.time == 0.01 && facts.density_iterations > 0);
  EXPECT(sum(facts.own_fluid) == FLUID && sum(facts.own_boundary) == BOUNDARY);
  const double v2 = 1 + 0.1 * 0.1;
  EXPECT(fabs(facts.kinetic_energy - 0.5 * FLUID * facts.particle_mass * v2) < 1e-6);
  EXPECT(hc_run_step(run, &error) == HC_BAD_INPUT && strstr(error.text, "end time, 0.01 s"));
  hc_run_free(run);
}
END_TEST

START_TEST(particles_come_out_in_metres) {
  hc_run *run = start();
  for (int step = 0; step < STEPS; step++) EXPECT(hc_run_step(run, &error) == HC_OK);
  copy fluid = copy_of(run, HC_RUN_FLUID), walls = copy_of(run, HC_RUN_BOUNDARY);
  bool good = true;
  int64_t ids = 0, first_layer = 0;
  for (int64_t k = 0; k < fluid.count; k++) {
    const double *x = &fluid.position[3 * k], *v = &fluid.velocity[3 * k];
    const double fallen = 10 * 0.002 * 0.002 * (STEPS * (STEPS + 1) / 2);
    const double cell = (x[2] + fallen - 5.05) / 0.1;
    good &= fabs(v[0] - 1) < 1e-9 && fabs(v[1]) < 1e-9 && fabs(v[2] + 0.1) < 1e-9;
    good &= x[0] > 0.0599 && x[0] < 0.7601 && fabs(cell - rint(cell)) < 1e-6;
    good &= fluid.density[k] > 100 && fluid.density[k] < 1001 && fluid.pressure[k] == 0;
    first_layer += rint(cell) == 0;
    ids += (int64_t)(fluid.id[k] & 0xffff);
  }
  for (int64_t k = 0; k < walls.count; k++)
    good &= fabs(walls.position[3 * k + 2] + 0.05) < 1e-6 && walls.velocity[3 * k] == 0 &&
            walls.density[k] == 0 && walls.id[k] != 0;
  EXPECT(good);
  EXPECT(sum(ids) == FLUID * (FLUID - 1) / 2 && sum(first_layer) == 40);
  const hc_run_particles nothing = {NULL, NULL, NULL, NULL, NULL};
  EXPECT(hc_run_get(run, HC_RUN_FLUID, &nothing, fluid.count + 1, NULL) == HC_OK);
  EXPECT(fluid.count == 0 ||
         (hc_run_get(run, HC_RUN_FLUID, &nothing, fluid.count - 1, &error) == HC_BAD_INPUT &&
          strstr(error.text, "must have room for")));
  free_copy(&fluid);
  free_copy(&walls);
  hc_run_free(run);
}
END_TEST

START_TEST(snapshots_are_numbered) {
  char directory[64] = "";
  if (comm.rank == 0) snprintf(directory, sizeof directory, "/tmp/halocline_api_%d/a/b", (int)getpid());
  hc_run *run = start();
  for (int number = 0; number < 2; number++) {
    EXPECT(hc_run_snapshot(run, comm.rank == 0 ? directory : NULL, &error) == HC_OK);
    EXPECT(hc_run_step(run, &error) == HC_OK);
  }
  bool good = true;
  if (comm.rank == 0) {
    char path[128];
    hc_snapshot_file *file = calloc(1, sizeof *file);
    snprintf(path, sizeof path, "%s/snapshots/snap_000001.hdf", directory);
    good = hc_snapshot_read_open(path, file, &error) == HC_OK && file->facts.step == 1 &&
           file->facts.fluid == FLUID && file->facts.boundary == BOUNDARY &&
           file->facts.pieces == comm.size && strcmp(file->facts.scene, "fall") == 0;
    hc_snapshot_read_close(file);
    free(file);
    char command[128];
    snprintf(command, sizeof command, "rm -r /tmp/halocline_api_%d", (int)getpid());
    good &= system(command) == 0;
  }
  EXPECT(good);
  EXPECT(hc_run_snapshot(run, "/dev/null/x", &error) == HC_IO_FAILED && strstr(error.text, "/dev/null/x"));
  EXPECT(hc_run_step(run, &error) == HC_OK); /* the run goes on */
  hc_run_free(run);
}
END_TEST

START_TEST(bad_scenes_are_told_on_every_rank) {
  hc_run *run = (hc_run *)&error;
  EXPECT(hc_run_from_file(session, "/nowhere/scene.yaml", NULL, 0, &run, &error) == HC_BAD_INPUT && !run);
  EXPECT(error.status == HC_BAD_INPUT &&
         strstr(error.text, "/nowhere/scene.yaml: cannot be opened: No such"));
  EXPECT(hc_run_from_file(session, "/nowhere/scene.yaml", NULL, 0, &run, NULL) == HC_BAD_INPUT && !run);
  EXPECT(hc_run_from_text(session, "particle_spacing: 0.1\nend_tim: 1\n", NULL, 0, &run, &error) ==
         HC_BAD_INPUT);
  EXPECT(!run && strstr(error.text, "scene:2") && strstr(error.text, "end_time"));
  const char *const overrides[] = {"particle_spacing=-1"};
  EXPECT(hc_run_from_text(session, text, overrides, 1, &run, &error) == HC_BAD_INPUT && !run);
  EXPECT(strstr(error.text, "particle_spacing"));
  const char *const open_period[] = {"domain.periodic=[true, false, false]", "domain.max=[0.3, 0, 0]"};
  EXPECT(hc_run_from_text(session, text, open_period, 2, &run, &error) == HC_BAD_INPUT && !run);
  EXPECT(strstr(error.text, "periodic"));
}
END_TEST

/* Two halves of the world run side by side, each with a session of its own. */
START_TEST(a_communicator_of_the_callers) {
  MPI_Comm half;
  MPI_Comm_split(MPI_COMM_WORLD, comm.rank % 2, comm.rank, &half);
  const int handle = MPI_Comm_c2f(half), bad = MPI_Comm_c2f(MPI_COMM_NULL);
  hc_session *world = session, *other = session;
  EXPECT(hc_session_start(&bad, &other, &error) == HC_BAD_INPUT && !other);
  EXPECT(strstr(error.text, "MPI_COMM_NULL"));
  EXPECT(hc_session_start(&handle, &session, &error) == HC_OK);
  MPI_Comm_free(&half); /* the session has its own */
  EXPECT(hc_session_rank(session) == comm.rank / 2);
  EXPECT(hc_session_size(session) == (comm.size + 1 - comm.rank % 2) / 2);
  hc_run *run = NULL;
  EXPECT(hc_run_from_text(session, text, NULL, 0, &run, &error) == HC_OK);
  for (int step = 0; step < 2 + comm.rank % 2; step++) ck_assert_int_eq(hc_run_step(run, &error), HC_OK);
  const hc_run_facts facts = hc_run_facts_of(run);
  EXPECT(facts.step == 2 + comm.rank % 2 && facts.fluid == FLUID);
  hc_run_free(run);
  hc_run_free(NULL);
  hc_session_end(session);
  hc_session_end(NULL);
  session = world;
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("api");
  tcase_add_checked_fixture(tests, setup, teardown);
  tcase_add_test(tests, a_run_falls_as_it_must);
  tcase_add_test(tests, particles_come_out_in_metres);
  tcase_add_test(tests, snapshots_are_numbered);
  tcase_add_test(tests, bad_scenes_are_told_on_every_rank);
  tcase_add_test(tests, a_communicator_of_the_callers);
  return run_mpi_tests("api", tests);
}
