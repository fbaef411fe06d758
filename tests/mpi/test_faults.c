/* Faults are found in the step in which they happen, whoever owns the particle, and named alike by all ranks.
 */
#include "mpi_scene.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* A column of 12 x 6 x 6 particles in a tank, in the scene file's defaults; rebalanced at the start, so that
 * every rank has some. */
static hc_scene tank(void) {
  hc_scene scene = make_scene(0.24, 0.12, 0.12);
  add_wall(&scene, 0.24, 0.12, 0.2, HC_FACE_PLUS_Z);
  scene.solver.density_iterations = (hc_iterations){2, 100};
  scene.solver.divergence_iterations = (hc_iterations){3, 100};
  return scene;
}

enum { PARTICLES = 12 * 6 * 6, BEFORE = 3 };

typedef enum break_what { VELOCITY, INFINITE_VELOCITY, MULTIPLIER, DIVERGENCE, DENSITY, KICK } break_what;

/* The sweeps with a density that breaks for one particle. */
static uint64_t broken_id;
static const hc_sweeps *good_sweeps;

static void broken_density(const hc_sweep *sweep, hc_selection selection) {
  good_sweeps->density(sweep, selection);
  for (int32_t k = selection.begin; k < selection.end; k++)
    if (sweep->fluid->id[k] == broken_id) sweep->fluid->density[k] = NAN;
}

static void break_particle(hc_simulation *simulation, break_what what, uint64_t id, hc_sweeps *sweeps) {
  hc_particles *fluid = simulation->world.fluid;
  if (what == DENSITY) {
    broken_id = id;
    good_sweeps = simulation->world.sweeps;
    *sweeps = *good_sweeps;
    sweeps->density = broken_density;
    simulation->world.sweeps = sweeps;
  }
  for (int32_t k = 0; k < fluid->own; k++) {
    if (fluid->id[k] != id) continue;
    if (what == VELOCITY) fluid->velocity[3 * k + 1] = NAN;
    if (what == INFINITE_VELOCITY) fluid->velocity[3 * k + 2] = -INFINITY;
    if (what == MULTIPLIER) fluid->pressure_multiplier[k] = NAN;
    if (what == DIVERGENCE) fluid->divergence_multiplier[k] = INFINITY;
    if (what == KICK) fluid->velocity[3 * k] = 1e5;
  }
}

/* Breaks a particle after some steps and expects the next step to say so. The text, the same on every rank.
 */
static void break_and_step(hc_comm *ranks, const hc_scene *scene, break_what what, uint64_t id,
                           hc_error *error) {
  hc_simulation simulation;
  hc_sweeps sweeps;
  memset(error, 0, sizeof *error);
  if (hc_simulation_init(&simulation, ranks, scene, error) != HC_OK) ck_abort_msg("%s", error->text);
  for (int k = 0; k < BEFORE; k++)
    if (hc_simulation_step(&simulation, error) != HC_OK) ck_abort_msg("%s", error->text);
  break_particle(&simulation, what, id, &sweeps);
  ck_assert_msg(hc_simulation_step(&simulation, error) == HC_FAILED, "fault %d of particle %d is not found",
                what, (int)id);
  ck_assert_int_eq(simulation.step, BEFORE);
  ck_assert_uint_eq(simulation.report.fault.id, id);
  hc_simulation_free(&simulation);
}

static void expect_named(break_what what, const char *sentence) {
  const hc_scene scene = tank();
  char name[64];
  for (uint64_t id = 0; id < PARTICLES; id += PARTICLES / 5) {
    hc_error error, alone;
    break_and_step(&comm, &scene, what, id, &error);
    snprintf(name, sizeof name, "\n  particle %d (number %d of fluid.blocks[0]): at (", (int)id, (int)id);
    ck_assert_msg(strstr(error.text, sentence) && strstr(error.text, name) &&
                      strstr(error.text, "in step 4 at"),
                  "%s", error.text);
    if (comm.rank == 0) { /* as one rank says it */
      hc_comm self;
      hc_error none = {.status = HC_OK};
      const int handle = MPI_Comm_c2f(MPI_COMM_SELF);
      ck_assert_int_eq(hc_comm_start_on(&self, &handle, &none), HC_OK);
      break_and_step(&self, &scene, what, id, &alone);
      hc_comm_finish(&self);
    }
    hc_comm_broadcast(&comm, &alone, sizeof alone, 0);
    EXPECT(strcmp(alone.text, error.text) == 0);
  }
}

START_TEST(a_velocity_that_is_no_number) {
  expect_named(VELOCITY, "velocity or pressure of particle");
  expect_named(INFINITE_VELOCITY, "velocity or pressure of particle");
}
END_TEST

START_TEST(a_multiplier_that_is_no_number) {
  expect_named(MULTIPLIER, "velocity or pressure of particle");
  expect_named(DIVERGENCE, "velocity or pressure of particle");
}
END_TEST

START_TEST(a_density_that_is_no_number) {
  expect_named(DENSITY, "the density of particle");
}
END_TEST

START_TEST(a_particle_too_fast_for_its_neighborhood) {
  expect_named(KICK, "more than a support radius");
}
END_TEST

/* Starts that cannot work: pressures below 0 beside a free surface, fluid that is squeezed. */
START_TEST(starts_that_cannot_work_are_refused) {
  for (int squeezed = 0; squeezed < 2; squeezed++) {
    hc_scene scene = tank();
    hc_error error = {.status = HC_OK};
    hc_simulation simulation;
    scene.solver.negative_pressure = !squeezed;
    if (squeezed) scene.fluid.mass_factor = 1.3;
    EXPECT(hc_simulation_init(&simulation, &comm, &scene, &error) == HC_BAD_INPUT);
    ck_assert_msg(strstr(error.text, squeezed ? "too dense at the start" : "as at a free surface"), "%s",
                  error.text);
  }
}
END_TEST

/* What the solver itself makes: the end of the step finds it, too. */
static void broken_pressure(const hc_sweep *sweep, float weight, float *multiplier, hc_selection selection) {
  good_sweeps->pressure(sweep, weight, multiplier, selection);
  for (int32_t k = selection.begin; k < selection.end; k++)
    if (sweep->fluid->id[k] == broken_id) {
      sweep->fluid->velocity[3 * k] = 1e3;
      sweep->fluid->motion[k].v[0] = 0.0f; /* so that no error sweep sees it */
    }
}

START_TEST(a_speed_that_the_solver_made) {
  hc_scene scene = tank();
  scene.time_step.control = HC_TIME_CONSTANT; /* which does not try it again with shorter ones */
  scene.time_step.size = 0.001;
  hc_error error = {.status = HC_OK};
  hc_simulation simulation;
  if (hc_simulation_init(&simulation, &comm, &scene, &error) != HC_OK) ck_abort_msg("%s", error.text);
  hc_sweeps sweeps = *simulation.world.sweeps;
  good_sweeps = simulation.world.sweeps;
  sweeps.pressure = broken_pressure;
  simulation.world.sweeps = &sweeps;
  broken_id = PARTICLES - 1;
  EXPECT(hc_simulation_step(&simulation, &error) == HC_FAILED);
  ck_assert_int_eq(simulation.report.fault.kind, HC_FAULT_SPEED);
  ck_assert_uint_eq(simulation.report.fault.id, broken_id);
  hc_simulation_free(&simulation);
}
END_TEST

/* The worst is named; of equals the smallest id. */
START_TEST(the_worst_particle_is_named) {
  hc_error error = {.status = HC_OK};
  const uint64_t id = 1000 - (uint64_t)comm.rank;
  hc_fault fault = {HC_FAULT_NONE, 0, 0};
  hc_tally tally = {.count = 0};
  ck_assert(hc_fault_agree(&comm, 1.0, &tally, &fault, &error) == HC_OK && fault.kind == HC_FAULT_NONE);
  hc_fault_note(&fault, HC_FAULT_SPEED, 5.0, id);
  hc_fault_note(&fault, HC_FAULT_SPEED, 4.0, 1);
  hc_fault_note(&fault, HC_FAULT_LEFT, 9.0, 2);
  ck_assert(hc_fault_agree(&comm, 1.0, &tally, &fault, &error) == HC_FAILED);
  ck_assert_uint_eq(fault.id, 1001 - (uint64_t)comm.size);
  ck_assert_int_eq(fault.kind, HC_FAULT_SPEED);
  fault = (hc_fault){HC_FAULT_NONE, 0, 0};
  if (comm.rank == comm.size - 1) hc_fault_note(&fault, HC_FAULT_DENSITY, 0.0, 77);
  if (comm.rank == 0) hc_fault_note(&fault, HC_FAULT_SPEED, 1e9, 3);
  ck_assert(hc_fault_agree(&comm, 1.0, &tally, &fault, &error) == HC_FAILED);
  ck_assert_uint_eq(fault.id, 77); /* the earlier kind */
}
END_TEST

/* ---- an overfull cell ---- */

/* Puts all but some of the particles at rest into one cell. */
enum { CROWD = 20 * 16 * 16, NOT_IN_IT = 700 };

static void squeeze(hc_simulation *simulation) {
  hc_particles *fluid = simulation->world.fluid;
  for (int32_t k = 0; k < fluid->own; k++) {
    if (fluid->id[k] < NOT_IN_IT) continue;
    for (int axis = 0; axis < 3; axis++) {
      fluid->position[3 * k + axis] =
          simulation->world.frame.origin[axis] + 3 * HC_CELL_UNITS +
          (int64_t)(mix(3 * fluid->id[k] + (uint64_t)axis) >> (64 - HC_CELL_BITS));
      fluid->velocity[3 * k + axis] = 0.0;
    }
  }
}

static void squeeze_and_step(hc_comm *ranks, hc_error *error) {
  const hc_scene scene = make_scene(0.4, 0.32, 0.32);
  hc_simulation simulation;
  memset(error, 0, sizeof *error);
  start_on(&simulation, ranks, &scene);
  do_steps(&simulation, 1);
  squeeze(&simulation);
  ck_assert_int_eq(hc_simulation_step(&simulation, error), HC_FAILED);
  ck_assert_int_eq(simulation.report.fault.kind, HC_FAULT_CROWDED);
  ck_assert_uint_eq(simulation.report.fault.id, NOT_IN_IT);
  ck_assert_int_eq(simulation.step, 1);
  hc_simulation_free(&simulation);
}

START_TEST(far_too_many_particles_in_one_cell) {
  hc_error error, alone;
  squeeze_and_step(&comm, &error);
  char expected[128];
  snprintf(expected, sizeof expected, "more than %d particles lie in one cell with particle %d", HC_CELL_MOST,
           NOT_IN_IT);
  ck_assert_msg(strstr(error.text, expected) != NULL, "%s", error.text);
  if (comm.rank == 0) {
    hc_comm self;
    memset(&self, 0, sizeof self);
    MPI_Comm_dup(MPI_COMM_SELF, &self.mpi);
    self.size = 1;
    squeeze_and_step(&self, &alone);
    hc_comm_finish(&self);
  }
  hc_comm_broadcast(&comm, &alone, sizeof alone, 0);
  EXPECT(strcmp(alone.text, error.text) == 0);
}
END_TEST

/* ---- leaving the world ---- */

static void tilt_out(hc_scene *scene) {
  wall.box.max[0] = 0.5;
  wall.open |= HC_FACE_PLUS_X;
  scene->gravity[0] = 8.0;
  for (int axis = 0; axis < 3; axis++) {
    scene->domain.limits_min[axis] = -0.1;
    scene->domain.limits_max[axis] = 0.3;
  }
}

START_TEST(particles_that_leave_end_the_run) {
  hc_scene scene = tank();
  tilt_out(&scene);
  hc_error error = {.status = HC_OK};
  hc_simulation simulation;
  if (hc_simulation_init(&simulation, &comm, &scene, &error) != HC_OK) ck_abort_msg("%s", error.text);
  for (int k = 0; k < 500 && error.status == HC_OK; k++) hc_simulation_step(&simulation, &error);
  ck_assert_int_eq(error.status, HC_FAILED);
  ck_assert_int_eq(simulation.report.fault.kind, HC_FAULT_LEFT);
  ck_assert_msg(strstr(error.text, "has left the world's limits"), "%s", error.text);
  hc_simulation_free(&simulation);
}
END_TEST

START_TEST(particles_that_leave_are_removed) {
  hc_scene scene = tank();
  tilt_out(&scene);
  scene.domain.leaving = HC_LEAVING_REMOVE;
  hc_error error = {.status = HC_OK};
  hc_simulation simulation;
  if (hc_simulation_init(&simulation, &comm, &scene, &error) != HC_OK) ck_abort_msg("%s", error.text);
  int64_t removed = 0;
  for (int k = 0; k < 2000 && removed < PARTICLES; k++) {
    if (hc_simulation_step(&simulation, &error) != HC_OK) ck_abort_msg("%s", error.text);
    removed += simulation.population.departures.count;
    int64_t left = simulation.world.fluid->own;
    hc_comm_sum_i64(&comm, &left, 1);
    ck_assert_int_eq(left, simulation.world.fluid_total);
    ck_assert_int_eq(left + removed, PARTICLES);
    for (int d = 0; d < simulation.population.departures.named; d++)
      ck_assert(simulation.population.departures.count == 0 ||
                fmax(simulation.population.departures.first[d].at[0],
                     -simulation.population.departures.first[d].at[2]) > 0.1);
  }
  ck_assert_int_gt(removed, PARTICLES / 2);
  hc_simulation_free(&simulation);
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("faults");
  tcase_set_timeout(tests, 100);
  tcase_add_test(tests, a_velocity_that_is_no_number);
  tcase_add_test(tests, a_multiplier_that_is_no_number);
  tcase_add_test(tests, a_density_that_is_no_number);
  tcase_add_test(tests, a_particle_too_fast_for_its_neighborhood);
  tcase_add_test(tests, starts_that_cannot_work_are_refused);
  tcase_add_test(tests, a_speed_that_the_solver_made);
  tcase_add_test(tests, the_worst_particle_is_named);
  tcase_add_test(tests, far_too_many_particles_in_one_cell);
  tcase_add_test(tests, particles_that_leave_end_the_run);
  tcase_add_test(tests, particles_that_leave_are_removed);
  return run_mpi_tests("faults", tests);
}
