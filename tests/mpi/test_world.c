/* Small whole runs without files: what they must conserve, and the same bits on any number of ranks. */
#include "mpi_scene.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A closed periodic box, long enough for several slabs. */
static hc_scene closed_box(void) {
  hc_scene scene = make_scene(0.36, 0.12, 0.12);
  scene.fluid.mass_factor = 0.99;
  for (int axis = 0; axis < 3; axis++) {
    scene.domain.periodic[axis] = true;
    scene.domain.max[axis] = block.box.max[axis];
  }
  return scene;
}

/* A column of fluid in a tank, whose slabs change under way. */
static hc_scene tank(void) {
  hc_scene scene = make_scene(0.24, 0.12, 0.12);
  scene.gravity[2] = -9.81;
  scene.gravity[0] = 2.0;
  add_wall(&scene, 0.6, 0.12, 0.2, HC_FACE_PLUS_Z);
  scene.fluid.viscosity.model = HC_VISCOSITY_ARTIFICIAL;
  scene.fluid.viscosity.coefficient = 0.05;
  scene.parallel.rebalance_at = 7;
  return scene;
}

/* Each particle gets a velocity of its own and moves by up to a tenth of a spacing. */
static void disturb(hc_simulation *simulation, double speed) {
  hc_particles *fluid = simulation->world.fluid;
  const hc_frame *frame = &simulation->world.frame;
  for (int32_t k = 0; k < fluid->own; k++)
    for (int axis = 0; axis < 3; axis++) {
      const double a = (double)(int64_t)mix(fluid->id[k] * 8 + (uint64_t)axis) * 0x1p-63,
                   b = (double)(int64_t)mix(fluid->id[k] * 8 + (uint64_t)axis + 4) * 0x1p-63;
      int64_t *x = &fluid->position[3 * k + axis];
      *x = hc_frame_wrap(frame, axis, *x + (int64_t)(0.1 * b * (double)frame->spacing[axis]));
      fluid->velocity[3 * k + axis] += speed * a;
    }
  hc_world_update(&simulation->world);
}

/* Sums of the velocities, and of their magnitudes. */
typedef struct momentum {
  double sum[3], magnitude;
} momentum;

static momentum momentum_of(hc_simulation *simulation) {
  const hc_particles *fluid = simulation->world.fluid;
  hc_sum sums[4];
  memset(sums, 0, sizeof sums);
  for (int32_t k = 0; k < fluid->own; k++) {
    const double *v = &fluid->velocity[3 * k];
    for (int axis = 0; axis < 3; axis++) hc_sum_add(&sums[axis], v[axis]);
    hc_sum_add(&sums[3], sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
  }
  hc_comm_sum_exact(simulation->comm, sums, 4);
  return (momentum){{hc_sum_value(&sums[0]), hc_sum_value(&sums[1]), hc_sum_value(&sums[2])},
                    hc_sum_value(&sums[3])};
}

START_TEST(a_closed_box_keeps_its_momentum) {
  const hc_scene scene = closed_box();
  hc_simulation simulation;
  start(&simulation, &scene);
  disturb(&simulation, 0.5);
  const momentum before = momentum_of(&simulation);
  ck_assert_double_gt(before.magnitude, 100);
  int iterations = 0;
  for (int k = 0; k < 30; k++) {
    do_steps(&simulation, 1);
    iterations += simulation.report.density_iterations + simulation.report.divergence_iterations;
  }
  const momentum after = momentum_of(&simulation);
  for (int axis = 0; axis < 3; axis++)
    ck_assert_msg(fabs(after.sum[axis] - before.sum[axis]) <= 1e-6 * before.magnitude,
                  "momentum changes by %g of %g", after.sum[axis] - before.sum[axis], before.magnitude);
  ck_assert_double_lt(after.magnitude, 0.95 * before.magnitude); /* there was something to change */
  ck_assert_int_gt(iterations, 150);
  ck_assert_int_eq(fluid_in(&simulation), 18 * 6 * 6);
  hc_simulation_free(&simulation);
}
END_TEST

START_TEST(a_free_block_falls_without_pressure) {
  hc_scene scene = make_scene(0.4, 0.08, 0.08);
  scene.gravity[0] = 0.5;
  scene.gravity[2] = -9.81;
  scene.time_step.control = HC_TIME_CONSTANT;
  scene.time_step.size = 0.002;
  for (int axis = 0; axis < 3; axis++) block.velocity[axis] = 3 - 2 * axis;
  hc_simulation simulation;
  start(&simulation, &scene);
  bool good = true;
  for (int k = 1; k <= 25; k++) {
    do_steps(&simulation, 1);
    const hc_particles *fluid = simulation.world.fluid;
    for (int32_t i = 0; i < fluid->own; i++) {
      good &= fluid->pressure[i] == 0 && fluid->pressure_multiplier[i] == 0 &&
              fluid->divergence_multiplier[i] == 0;
      for (int axis = 0; axis < 3; axis++)
        good &=
            fabs(fluid->velocity[3 * i + axis] - (3 - 2 * axis + 0.002 * k * scene.gravity[axis])) < 1e-13;
    }
  }
  EXPECT(good);
  ck_assert_int_eq(fluid_in(&simulation), 20 * 4 * 4);
  ck_assert_int_eq(simulation.step, 25);
  hc_simulation_free(&simulation);
}
END_TEST

/* ---- the same bits ---- */

/* The state of one particle. */
typedef struct state {
  uint64_t id;
  int64_t x[3];
  double v[3];
  float multipliers[2], density, pressure;
} state;

static int by_id(const void *a, const void *b) {
  const uint64_t p = ((const state *)a)->id, q = ((const state *)b)->id;
  return p < q ? -1 : p > q;
}

/* FNV-1a over all particles by id; positions count from the scene's origin. */
static uint64_t digest_of(hc_simulation *simulation) {
  const hc_particles *fluid = simulation->world.fluid;
  state *mine = hc_alloc_zero((size_t)fluid->own, sizeof *mine);
  for (int32_t k = 0; k < fluid->own; k++) {
    mine[k].id = fluid->id[k];
    for (int axis = 0; axis < 3; axis++)
      mine[k].x[axis] = fluid->position[3 * k + axis] - simulation->world.frame.origin[axis];
    memcpy(mine[k].v, &fluid->velocity[3 * k], sizeof mine[k].v);
    mine[k].multipliers[0] = fluid->pressure_multiplier[k];
    mine[k].multipliers[1] = fluid->divergence_multiplier[k];
    mine[k].density = fluid->density[k];
    mine[k].pressure = fluid->pressure[k];
  }
  void *all;
  size_t bytes;
  hc_comm_gather_all(simulation->comm, mine, (size_t)fluid->own * sizeof *mine, &all, &bytes);
  hc_free(mine);
  qsort(all, bytes / sizeof(state), sizeof(state), by_id);
  uint64_t digest = 0xcbf29ce484222325;
  for (size_t k = 0; k < bytes; k++) digest = (digest ^ ((const unsigned char *)all)[k]) * 0x100000001b3;
  hc_free(all);
  return digest;
}

/* What is compared of a run: the state, and what the last step said of itself. */
typedef struct outcome {
  uint64_t digest;
  int64_t steps, particles;
  double time, kinetic_energy, potential_energy, density_error, v_max;
} outcome;

static outcome run(hc_comm *ranks, const hc_scene *scene, double speed, int steps) {
  hc_simulation simulation;
  start_on(&simulation, ranks, scene);
  if (speed > 0) disturb(&simulation, speed);
  do_steps(&simulation, steps);
  outcome result;
  memset(&result, 0, sizeof result);
  result.digest = digest_of(&simulation);
  result.steps = simulation.step;
  result.particles = fluid_in(&simulation);
  result.time = simulation.time;
  result.kinetic_energy = simulation.report.kinetic_energy;
  result.potential_energy = simulation.report.potential_energy;
  result.density_error = simulation.report.density_error_avg;
  result.v_max = simulation.report.v_max;
  hc_simulation_free(&simulation);
  return result;
}

/* The same run on rank 0 alone, told to all. */
static outcome run_alone(const hc_scene *scene, double speed, int steps) {
  outcome result;
  memset(&result, 0, sizeof result);
  if (comm.rank == 0) {
    hc_comm alone;
    hc_error error = {.status = HC_OK};
    const int self = MPI_Comm_c2f(MPI_COMM_SELF);
    ck_assert_int_eq(hc_comm_start_on(&alone, &self, &error), HC_OK);
    result = run(&alone, scene, speed, steps);
    hc_comm_finish(&alone);
  }
  hc_comm_broadcast(&comm, &result, sizeof result, 0);
  return result;
}

static void compare_with_one_rank(const hc_scene *scene, double speed, int steps) {
  const outcome alone = run_alone(scene, speed, steps), together = run(&comm, scene, speed, steps);
  EXPECT(together.particles == alone.particles && together.steps == steps);
  EXPECT(together.time == alone.time);
  EXPECT(together.digest == alone.digest);
  EXPECT(memcmp(&together, &alone, sizeof alone) == 0);
}

START_TEST(a_closed_box_has_the_same_bits_on_one_rank) {
  const hc_scene scene = closed_box();
  compare_with_one_rank(&scene, 0.4, 20);
}
END_TEST

START_TEST(a_tank_has_the_same_bits_on_one_rank) {
  const hc_scene scene = tank();
  compare_with_one_rank(&scene, 0, 20);
}
END_TEST

/* Whole states with METIS at work in one step of two, first divided by slabs or by METIS. */
START_TEST(metis_changes_no_bits) {
  hc_scene scene = tank();
  scene.parallel.rebalance = HC_REBALANCE_METIS;
  scene.parallel.rebalance_every = 2;
  compare_with_one_rank(&scene, 0, 16);
  scene.parallel.decomposition = HC_DECOMPOSITION_METIS;
  compare_with_one_rank(&scene, 0, 5);
  scene = closed_box();
  scene.parallel.rebalance = HC_REBALANCE_METIS;
  scene.parallel.rebalance_every = 3;
  compare_with_one_rank(&scene, 0.4, 12);
}
END_TEST

/* Two cells of fluid: on several ranks most have none, before and after. */
START_TEST(ranks_may_be_empty) {
  hc_scene scene = make_scene(0.08, 0.04, 0.04);
  scene.gravity[2] = -9.81;
  block.velocity[0] = 3.0;
  for (int divider = HC_REBALANCE_SLABS; divider <= HC_REBALANCE_METIS; divider++) {
    scene.parallel.rebalance = (hc_rebalance)divider;
    scene.parallel.rebalance_every = 2;
    compare_with_one_rank(&scene, 0, 9);
  }
}
END_TEST

START_TEST(a_place_far_away_has_the_same_bits) {
  hc_scene scene = tank();
  scene.fluid.viscosity.model = HC_VISCOSITY_LAMINAR;
  scene.fluid.viscosity.coefficient = 1e-4;
  const outcome here = run(&comm, &scene, 0, 6);
  for (int axis = 0; axis < 3; axis++) scene.origin_cells[axis] = (axis - 1) * 123456789 + 1;
  const outcome there = run(&comm, &scene, 0, 6);
  EXPECT(here.digest == there.digest);
  EXPECT(memcmp(&here, &there, sizeof here) == 0);
}
END_TEST

START_TEST(a_rebalance_is_forced_and_loses_nothing) {
  const hc_scene scene = tank();
  hc_simulation simulation;
  start(&simulation, &scene);
  for (int k = 0; k < 10; k++) {
    do_steps(&simulation, 1);
    ck_assert(hc_balance_divided_in(&simulation.balance, simulation.step) == (k == 7));
    ck_assert_int_eq(fluid_in(&simulation), 12 * 6 * 6);
  }
  int64_t walls = simulation.world.boundary->own;
  hc_comm_sum_i64(&comm, &walls, 1);
  ck_assert_int_eq(walls, simulation.world.boundary_total);
  int64_t active = hc_world_active_boundary(&simulation.world);
  hc_comm_sum_i64(&comm, &active, 1);
  ck_assert(active > simulation.world.boundary_total / 5 && active < simulation.world.boundary_total * 4 / 5);
  hc_simulation_free(&simulation);
}
END_TEST

/* A run has the fields of its own solver and walls. */
START_TEST(a_run_carries_what_it_needs) {
  for (int pcisph = 0; pcisph < 2; pcisph++) {
    hc_scene scene = make_scene(0.08, 0.08, 0.08);
    scene.solver.method = pcisph ? HC_SOLVER_PCISPH : HC_SOLVER_DFSPH;
    hc_simulation simulation;
    start(&simulation, &scene);
    const hc_particles *fluid = simulation.world.fluid;
    ck_assert((fluid->push != NULL) == pcisph && (fluid->alpha != NULL) == !pcisph);
    ck_assert((fluid->pressure_multiplier != NULL) == !pcisph && !fluid->wall_rate);
    hc_simulation_free(&simulation);
  }
}
END_TEST

/* Ranks exchange with those they know: barriers come only with a division, or where water gets to new places.
 */
START_TEST(most_steps_need_no_barrier) {
  enum { STEPS = 20 };
  hc_scene scene = tank();
  scene.parallel.rebalance_above = 1e6; /* none by what a busy machine measures */
  hc_simulation simulation;
  start(&simulation, &scene);
  do_steps(&simulation, 8); /* a division is behind them */
  const int64_t before = comm.sparse_exchanges;
  do_steps(&simulation, STEPS);
  EXPECT(comm.sparse_exchanges - before <= STEPS / 2);
  ck_assert_int_eq(fluid_in(&simulation), 12 * 6 * 6);
  hc_simulation_free(&simulation);
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("world");
  tcase_set_timeout(tests, 100);
  tcase_add_test(tests, a_run_carries_what_it_needs);
  tcase_add_test(tests, a_closed_box_keeps_its_momentum);
  tcase_add_test(tests, a_free_block_falls_without_pressure);
  tcase_add_test(tests, a_closed_box_has_the_same_bits_on_one_rank);
  tcase_add_test(tests, a_tank_has_the_same_bits_on_one_rank);
  tcase_add_test(tests, metis_changes_no_bits);
  tcase_add_test(tests, ranks_may_be_empty);
  tcase_add_test(tests, a_place_far_away_has_the_same_bits);
  tcase_add_test(tests, a_rebalance_is_forced_and_loses_nothing);
  tcase_add_test(tests, most_steps_need_no_barrier);
  return run_mpi_tests("world", tests);
}
