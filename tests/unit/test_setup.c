/* From scene to frame and particles: exact integers, the same set for any number of ranks, clear refusals. */
#include "base/memory.h"
#include "setup/flow.h"
#include "setup/limits.h"
#include "setup/populate.h"
#include "setup/rest_lattice.h"
#include "setup/solvers.h"
#include "setup/world_frame.h"
#include "solver/wcsph.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static hc_scene plain_scene(void) {
  return (hc_scene){.particle_spacing = 0.02, .support_radius = 0.04};
}

static hc_scene periodic_scene(double x, double y, double z) {
  hc_scene scene = plain_scene();
  const double lengths[3] = {x, y, z};
  for (int a = 0; a < 3; a++) {
    scene.domain.periodic[a] = lengths[a] > 0;
    scene.domain.max[a] = lengths[a];
  }
  return scene;
}

static hc_frame frame_of(const hc_scene *scene) {
  hc_frame frame;
  hc_error error = {0};
  ck_assert_msg(hc_setup_frame(scene, &frame, &error) == HC_OK, "%s", error.text);
  return frame;
}

static void assert_refused(const hc_scene *scene, const char *const *words) {
  hc_frame frame;
  hc_error error = {0};
  ck_assert_int_eq(hc_setup_frame(scene, &frame, &error), HC_BAD_INPUT);
  for (; *words; words++)
    ck_assert_msg(strstr(error.text, *words) != NULL, "no '%s' in: %s", *words, error.text);
}

#define REFUSED(scene, ...) assert_refused(scene, (const char *const[]){__VA_ARGS__, NULL})

START_TEST(open_axes_have_cells_of_the_support_radius) {
  hc_scene scene = plain_scene();
  scene.origin_cells[1] = -5;
  const hc_frame frame = frame_of(&scene);
  for (int a = 0; a < 3; a++) {
    ck_assert(frame.unit[a] * (double)HC_CELL_UNITS == 0.04);
    ck_assert_int_eq(frame.spacing[a], HC_CELL_UNITS / 2);
    ck_assert_int_eq(frame.period[a], 0);
    ck_assert_int_eq(frame.origin[a], a == 1 ? -5 * HC_CELL_UNITS : 0);
  }
  ck_assert(frame.support_radius == 0.04);
  scene.particle_spacing = 0.0464;
  scene.support_radius = 0.1;
  const hc_frame odd = frame_of(&scene);
  ck_assert_int_eq(odd.spacing[0] % 2, 0);
  ck_assert_double_le(fabs((double)odd.spacing[0] * odd.unit[0] - 0.0464), odd.unit[0]);
}
END_TEST

START_TEST(periods_are_whole_cells_and_whole_spacings) {
  const hc_scene scene = periodic_scene(0.98, 0.2, 0.12);
  const hc_frame frame = frame_of(&scene);
  const int64_t cells[3] = {24, 5, 3}, spacings[3] = {49, 10, 6};
  const double lengths[3] = {0.98, 0.2, 0.12};
  for (int a = 0; a < 3; a++) {
    ck_assert_int_eq(frame.period[a], cells[a] * HC_CELL_UNITS);
    ck_assert_int_eq(frame.low[a], 0);
    ck_assert_double_eq_tol((double)frame.period[a] * frame.unit[a], lengths[a], 1e-15);
    ck_assert_int_eq(frame.spacing[a] % 2, 0);
    ck_assert_int_le(llabs(spacings[a] * frame.spacing[a] - frame.period[a]), spacings[a]);
    ck_assert_double_le(frame.support_radius, (double)HC_CELL_UNITS * frame.unit[a]);
  }
  ck_assert_double_eq_tol(frame.support_radius, 0.04, 1e-10);
}
END_TEST

/* Individual steps: cells are wider by the margin, but where a period has too few of those. */
START_TEST(cells_of_individual_steps_have_a_margin) {
  hc_scene scene = plain_scene();
  scene.time_step.control = HC_TIME_INDIVIDUAL;
  scene.time_step.margin = 0.25;
  const hc_frame open = frame_of(&scene);
  ck_assert(open.support_radius == 0.04 && fabs(open.margin - 0.01) < 1e-15);
  ck_assert_double_eq_tol(open.unit[0] * (double)HC_CELL_UNITS, 0.05, 1e-15);
  scene = periodic_scene(0.98, 0.2, 0);
  scene.time_step.control = HC_TIME_INDIVIDUAL;
  scene.time_step.margin = 0.25;
  const hc_frame wide = frame_of(&scene);
  ck_assert(wide.period[0] == 19 * HC_CELL_UNITS && wide.period[1] == 4 * HC_CELL_UNITS);
  ck_assert_double_eq_tol(wide.margin, 0.01, 1e-12);
  scene.domain.max[1] = 0.12;
  const hc_frame thin = frame_of(&scene);
  ck_assert(thin.period[1] == 3 * HC_CELL_UNITS && thin.support_radius <= 0.04 && thin.margin < 1e-12 &&
            thin.margin >= 0.0);
}
END_TEST

/* However many of them a block has, a particle's own step heeds sound, the scene's largest and viscosity. */
START_TEST(own_steps_have_a_longest) {
  hc_scene scene = plain_scene();
  scene.solver.method = HC_SOLVER_WCSPH;
  scene.solver.sound_speed = 40.0;
  scene.boundary.wall_density = HC_WALL_DENSITY_SQUARED;
  scene.fluid.viscosity.model = HC_VISCOSITY_LAMINAR;
  const double sound = 0.6 * 0.04 / 40.0, viscous = 0.125 * 0.02 * 0.02;
  const double coefficients[3] = {1e-6, 1e-6, 0.5}, largest[3] = {0.0, 1e-4, 0.0},
               longest[3] = {sound, 1e-4, viscous / 0.5};
  for (int k = 0; k < 3; k++) {
    scene.fluid.viscosity.coefficient = coefficients[k];
    scene.time_step.max = largest[k];
    hc_solver_settings *const settings = hc_setup_solver_settings(&scene);
    ck_assert_double_eq_tol(((hc_wcsph_settings *)settings)->weak.longest, longest[k], 1e-12 * longest[k]);
    hc_free(settings);
  }
}
END_TEST

/* A period that is short of whole cells by rounding only keeps them, and the support radius gives way. */
START_TEST(support_radius_never_exceeds_an_edge) {
  hc_scene scene = periodic_scene(1.0 - 1e-11, 0, 0);
  const hc_frame frame = frame_of(&scene);
  ck_assert_int_eq(frame.period[0], 25 * HC_CELL_UNITS);
  ck_assert_double_lt(frame.support_radius, 0.04);
  ck_assert_double_le(frame.support_radius, (double)HC_CELL_UNITS * frame.unit[0]);
}
END_TEST

START_TEST(lower_end_is_a_cell_corner_and_shifts_exactly) {
  hc_scene scene = periodic_scene(1.0, 0.2, 0);
  scene.domain.min[0] = -0.5; /* 12.5 cells */
  scene.domain.max[0] = 0.5;
  scene.domain.min[1] = 0.4; /* 10 cells */
  scene.domain.max[1] = 0.6;
  const hc_frame frame = frame_of(&scene);
  for (int a = 0; a < 2; a++) {
    ck_assert_int_eq(frame.low[a] % HC_CELL_UNITS, 0);
    ck_assert_int_eq(hc_frame_to_units(&frame, a, scene.domain.min[a]), frame.low[a]);
    ck_assert_int_lt(llabs(frame.origin[a]), HC_CELL_UNITS);
  }
  ck_assert_int_eq(llabs(frame.origin[0]), HC_CELL_UNITS / 2);
  ck_assert_int_eq(frame.origin[1], 0);
  const int64_t shift[3] = {1 << 30, -77, 3};
  for (int a = 0; a < 3; a++) scene.origin_cells[a] += shift[a];
  const hc_frame moved = frame_of(&scene);
  for (int a = 0; a < 3; a++) {
    ck_assert_int_eq(moved.origin[a] - frame.origin[a], shift[a] * HC_CELL_UNITS);
    if (a < 2) ck_assert_int_eq(moved.low[a] - frame.low[a], shift[a] * HC_CELL_UNITS);
    ck_assert_int_eq(moved.spacing[a], frame.spacing[a]);
    ck_assert(moved.unit[a] == frame.unit[a]);
  }
}
END_TEST

START_TEST(frames_that_cannot_be_are_refused_with_what_fits) {
  hc_scene scene = periodic_scene(0.1, 0, 0);
  REFUSED(&scene, "along x", "at least 3", "0.1 m", "that fit: 0.12 m");
  scene = periodic_scene(0, 0.14, 0); /* 3.5 cells: stretched by 17 % */
  REFUSED(&scene, "along y", "support_radius (0.04 m)", "0.14", "0.12 or 0.16 m");
  scene = periodic_scene(0, 0, 0.21); /* cells fit, spacings do not */
  REFUSED(&scene, "along z", "particle_spacing 0.02", "0.0190909091 or 0.021 m");
  scene = periodic_scene(0, 0, 0.2 * (1 + 2e-6));
  REFUSED(&scene, "whole number of particle spacings");
  scene = periodic_scene(0, 0, 0.2 * (1 + 5e-7));
  frame_of(&scene);
  scene = periodic_scene(1, 0, 0);
  scene.domain.min[0] = 2;
  REFUSED(&scene, "max must be above min", "min 2, max 1");
  scene = plain_scene();
  scene.support_radius = 0.02;
  REFUSED(&scene, "support_radius must be above 1", "got 0.02");
  scene.particle_spacing = NAN;
  REFUSED(&scene, "particle_spacing must be above 0");
  scene = plain_scene();
  scene.origin_cells[2] = INT64_C(1) << 40;
  REFUSED(&scene, "origin_cells", "along z");
}
END_TEST

/* A scene with everything: two blocks, three kinds of walls, two periodic axes. */
static hc_block two_blocks[] = {
    {.box = {{0, 0, 0}, {0.2, 0.2, 0.1}}, .velocity = {1, 2, 3}},
    {.box = {{0, 0, 0.3}, {0.2, 0.2, 0.4}}, .flow = {HC_FLOW_TAYLOR_GREEN, 2.0, 0.2, 0}},
};
static hc_wall three_walls[] = {
    {.form = HC_FORM_PLANE, .name = "floor", .point = {0.1, 0.1, 0}, .normal = {0, 0, 1}, .size = {0.2, 0.2}},
    {.form = HC_FORM_BOX, .box = {{0.06, 0.06, 0.16}, {0.14, 0.12, 0.24}}, .inside = HC_INSIDE_SOLID},
    {.form = HC_FORM_BOX,
     .box = {{0, 0, 0}, {0.2, 0.2, 0.5}},
     .inside = HC_INSIDE_FLUID,
     .open = HC_FACE_MINUS_X | HC_FACE_PLUS_X | HC_FACE_MINUS_Y | HC_FACE_PLUS_Y | HC_FACE_MINUS_Z},
};

static hc_scene full_scene(void) {
  hc_scene scene = periodic_scene(0.2, 0.2, 0);
  scene.fluid.blocks = two_blocks;
  scene.fluid.block_count = 2;
  scene.boundary.walls = three_walls;
  scene.boundary.wall_count = 3;
  return scene;
}

typedef struct particle {
  uint64_t id;
  int64_t x[3];
  double v[3];
} particle;

static int by_id(const void *a, const void *b) {
  const uint64_t p = ((const particle *)a)->id, q = ((const particle *)b)->id;
  return p < q ? -1 : p > q;
}

static void collect(const hc_particles *from, particle *to) {
  for (int64_t k = 0; k < from->own; k++) {
    to[k] = (particle){.id = from->id[k]};
    for (int a = 0; a < 3; a++) {
      to[k].x[a] = from->position[3 * k + a];
      if (from->kind == HC_FLUID) to[k].v[a] = from->velocity[3 * k + a];
    }
  }
}

static hc_setup_plan plan_of(const hc_scene *scene) {
  const hc_frame frame = frame_of(scene);
  hc_setup_plan plan;
  hc_error error = {0};
  ck_assert_msg(hc_setup_plan_make(NULL, scene, &frame, &plan, &error) == HC_OK, "%s", error.text);
  return plan;
}

/* All particles of a scene as `size` ranks make them, sorted by id; `*count` of them, the fluid first. */
static particle *made_by(const hc_scene *scene, int size, int64_t *count) {
  hc_setup_plan plan = plan_of(scene);
  particle *const all = hc_alloc((size_t)(plan.fluid_count + plan.boundary_count), sizeof *all);
  hc_particles fluid, boundary, moving;
  hc_particles_init(&moving, HC_BOUNDARY | HC_MOVED, HC_FOR_ALL);
  hc_particles_init(&fluid, HC_FLUID, HC_FOR_ALL);
  hc_particles_init(&boundary, HC_BOUNDARY, HC_FOR_ALL);
  *count = 0;
  for (int rank = 0; rank < size; rank++) {
    ck_assert_int_eq(hc_setup_generate(&plan, rank, size, &fluid, &boundary, &moving, NULL), HC_OK);
    ck_assert_int_le(fluid.own, plan.fluid_count / size + 1);
    collect(&fluid, all + *count);
    *count += fluid.own;
    collect(&boundary, all + *count);
    *count += boundary.own;
  }
  ck_assert_int_eq(*count, plan.fluid_count + plan.boundary_count);
  hc_particles_free(&fluid);
  hc_particles_free(&boundary);
  hc_particles_free(&moving);
  hc_setup_plan_free(&plan);
  qsort(all, (size_t)*count, sizeof *all, by_id);
  return all;
}

START_TEST(plan_counts_without_generating) {
  const hc_scene scene = full_scene();
  hc_setup_plan plan = plan_of(&scene);
  ck_assert_int_eq(plan.fluid_count, 2 * 10 * 10 * 5);
  ck_assert_int_eq(plan.boundary_count, 10 * 10 + (4 * 3 * 4 - 2 * 1 * 2) + 10 * 10);
  hc_setup_plan_free(&plan);
}
END_TEST

START_TEST(any_number_of_ranks_makes_the_same_particles) {
  const hc_scene scene = full_scene();
  int64_t count;
  particle *const one = made_by(&scene, 1, &count);
  for (int64_t k = 1; k < count; k++) ck_assert(one[k - 1].id < one[k].id); /* unique */
  const int sizes[] = {2, 3, 7, 64, 2000};
  for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
    int64_t parts_count;
    particle *const parts = made_by(&scene, sizes[s], &parts_count);
    ck_assert_int_eq(parts_count, count);
    ck_assert(memcmp(one, parts, (size_t)count * sizeof *one) == 0);
    hc_free(parts);
  }
  hc_free(one);
}
END_TEST

START_TEST(particles_are_where_and_what_the_scene_says) {
  const hc_scene scene = full_scene();
  const hc_frame frame = frame_of(&scene);
  int64_t count;
  particle *const all = made_by(&scene, 3, &count);
  const int64_t half = frame.spacing[0] / 2;
  ck_assert(all[0].id == hc_id_make(HC_ID_FLUID, 0, 0));
  for (int a = 0; a < 3; a++) {
    ck_assert_int_eq(all[0].x[a], half);
    ck_assert(all[0].v[a] == 1.0 + a);
  }
  ck_assert(all[500].id == hc_id_make(HC_ID_FLUID, 1, 0));
  ck_assert(all[1000].id == hc_id_make(HC_ID_BOUNDARY, 0, 0));
  ck_assert(all[1100].id == hc_id_make(HC_ID_BOUNDARY, 1, 0));
  const double tau = 2 * acos(-1.0);
  for (int64_t k = 500; k < 1000; k++) {
    const double x = hc_frame_to_metres(&frame, 0, all[k].x[0]),
                 y = hc_frame_to_metres(&frame, 1, all[k].x[1]);
    ck_assert_double_eq_tol(all[k].v[0], -2 * cos(tau * x / 0.2) * sin(tau * y / 0.2), 1e-14);
    ck_assert_double_eq_tol(all[k].v[1], 2 * sin(tau * x / 0.2) * cos(tau * y / 0.2), 1e-14);
    ck_assert(all[k].v[2] == 0);
  }
  for (int64_t k = 1000; k < 1100; k++) ck_assert_int_eq(all[k].x[2], -half);
  for (int64_t k = 0; k < count; k++)
    for (int a = 0; a < 2; a++) ck_assert(all[k].x[a] >= 0 && all[k].x[a] < frame.period[a]);
  hc_free(all);
}
END_TEST

/* A block across the lower end comes back at the upper one and keeps its velocity field. */
START_TEST(periodic_axes_wrap) {
  hc_block block = {.box = {{-0.04, 0, 0}, {0.04, 0.02, 0.02}}, .flow = {HC_FLOW_TAYLOR_GREEN, 1.0, 0.2, 0}};
  hc_scene scene = periodic_scene(0.2, 0, 0);
  scene.fluid.blocks = &block;
  scene.fluid.block_count = 1;
  int64_t count;
  particle *const all = made_by(&scene, 1, &count);
  ck_assert_int_eq(count, 4);
  const double expected[4] = {0.17, 0.19, 0.01, 0.03};
  const hc_frame frame = frame_of(&scene);
  for (int k = 0; k < 4; k++) {
    ck_assert_double_eq_tol(hc_frame_to_metres(&frame, 0, all[k].x[0]), expected[k], 1e-9);
    ck_assert_double_eq_tol(all[k].v[0], -cos(2 * acos(-1.0) * expected[k] / 0.2) * sin(acos(-1.0) / 10),
                            1e-9);
  }
  hc_free(all);
}
END_TEST

START_TEST(origin_cells_shift_every_particle_exactly) {
  hc_scene scene = full_scene();
  int64_t here_count, there_count;
  particle *const here = made_by(&scene, 2, &here_count);
  const int64_t shift[3] = {12345678, -999, INT64_C(1) << 30};
  memcpy(scene.origin_cells, shift, sizeof shift);
  particle *const there = made_by(&scene, 2, &there_count);
  ck_assert_int_eq(here_count, there_count);
  for (int64_t k = 0; k < here_count; k++) {
    ck_assert(here[k].id == there[k].id);
    for (int a = 0; a < 3; a++) {
      ck_assert_int_eq(there[k].x[a] - here[k].x[a], shift[a] * HC_CELL_UNITS);
      ck_assert(there[k].v[a] == here[k].v[a]);
    }
  }
  hc_free(here);
  hc_free(there);
}
END_TEST

/* Shifts stay within bounds, spread evenly, leave walls alone and do not depend on the ranks. */
START_TEST(disorder_shifts_the_fluid_off_its_lattice) {
  hc_scene scene = full_scene();
  const hc_frame frame = frame_of(&scene);
  int64_t count, disordered_count;
  particle *const lattice = made_by(&scene, 1, &count);
  scene.fluid.disorder = 0.3;
  particle *const one = made_by(&scene, 1, &disordered_count), *const parts = made_by(&scene, 7, &count);
  ck_assert_int_eq(disordered_count, count);
  ck_assert(memcmp(one, parts, (size_t)count * sizeof *one) == 0);
  double sum = 0, square = 0;
  for (int64_t k = 0; k < count; k++) {
    ck_assert(one[k].id == lattice[k].id);
    for (int a = 0; a < 3; a++) {
      int64_t moved = one[k].x[a] - lattice[k].x[a];
      if (frame.period[a] > 0 && llabs(moved) > frame.period[a] / 2)
        moved += moved < 0 ? frame.period[a] : -frame.period[a];
      const double shift = (double)moved / (double)frame.spacing[a];
      ck_assert_double_le(fabs(shift), hc_id_kind_of(one[k].id) == HC_ID_FLUID ? 0.3 : 0);
      sum += shift;
      square += shift * shift;
    }
  }
  const double shifts = 3 * 1000; /* fluid particles */
  ck_assert_double_le(fabs(sum / shifts), 3 * 0.3 / sqrt(3 * shifts));
  ck_assert_double_eq_tol(square / shifts, 0.3 * 0.3 / 3, 0.05 * 0.3 * 0.3 / 3);
  hc_free(lattice);
  hc_free(one);
  hc_free(parts);
}
END_TEST

/* What a store held before must be gone, all of it. */
START_TEST(generating_replaces_the_stores) {
  const hc_scene scene = full_scene();
  hc_setup_plan plan = plan_of(&scene);
  hc_particles fluid, boundary, moving;
  hc_particles_init(&moving, HC_BOUNDARY | HC_MOVED, HC_FOR_ALL);
  hc_particles_init(&fluid, HC_FLUID, HC_FOR_ALL);
  hc_particles_init(&boundary, HC_BOUNDARY, HC_FOR_ALL);
  hc_particles_resize(&fluid, 5000);
  for (int k = 0; k < 5000; k++) fluid.pressure_multiplier[k] = 1;
  hc_setup_generate(&plan, 0, 1, &fluid, &boundary, &moving, NULL);
  ck_assert_int_eq(fluid.own, 1000);
  for (int k = 0; k < 1000; k++) ck_assert(fluid.pressure_multiplier[k] == 0);
  for (int k = 0; k < boundary.own; k++) ck_assert(boundary.volume[k] == 0);
  hc_particles_free(&fluid);
  hc_particles_free(&boundary);
  hc_particles_free(&moving);
  hc_setup_plan_free(&plan);
}
END_TEST

static void assert_no_plan(const hc_scene *scene, const char *const *words) {
  const hc_frame frame = frame_of(scene);
  hc_setup_plan plan;
  hc_error error = {0};
  ck_assert_int_eq(hc_setup_plan_make(NULL, scene, &frame, &plan, &error), HC_BAD_INPUT);
  for (; *words; words++)
    ck_assert_msg(strstr(error.text, *words) != NULL, "no '%s' in: %s", *words, error.text);
}

#define NO_PLAN(scene, ...) assert_no_plan(scene, (const char *const[]){__VA_ARGS__, NULL})

START_TEST(plans_that_cannot_be_are_refused) {
  hc_block block = {.box = {{0, 0, 0}, {0.2, -0.2, 0.2}}};
  hc_wall wall = {.form = HC_FORM_BOX, .name = "tank", .box = {{0, 0, 0}, {0.2, 0.2, 0.2}}};
  hc_scene scene = periodic_scene(0.2, 0, 0);
  scene.fluid.blocks = &block;
  scene.fluid.block_count = 1;
  scene.boundary.walls = &wall;
  scene.boundary.wall_count = 1;
  NO_PLAN(&scene, "fluid.blocks[0]", "box.max must be above box.min", "0 to -0.2 m along y");
  block.box.max[1] = INFINITY;
  NO_PLAN(&scene, "fluid.blocks[0]", "within 2^31 support radii", "along y");
  block.box.max[1] = 1e6;
  block.box.max[2] = 1e6;
  NO_PLAN(&scene, "fluid.blocks[0]", "at most 2^40 particles", "got 25000000000000000");
  block.box.max[1] = block.box.max[2] = 0.2;
  NO_PLAN(&scene, "boundary.walls[0] \"tank\"", "around the period of 0.2 m along x", "open its faces");
  wall.open = HC_FACE_MINUS_X | HC_FACE_PLUS_X;
  hc_setup_plan plan = plan_of(&scene);
  hc_setup_plan_free(&plan);
  block.box.max[0] = 0.22;
  NO_PLAN(&scene, "fluid.blocks[0]", "must not meet itself");
  block.box.max[0] = 0.2;
  wall = (hc_wall){.form = HC_FORM_PLANE, .size = {0.2, 0.2}};
  NO_PLAN(&scene, "boundary.walls[0]", "normal must have a length");
  wall.normal[2] = 1;
  wall.size[1] = 0;
  NO_PLAN(&scene, "boundary.walls[0]", "size must be above 0", "got 0 m");
  block.velocity[0] = NAN;
  NO_PLAN(&scene, "velocity must be finite");
}
END_TEST

START_TEST(too_many_particles_for_a_rank_are_refused) {
  hc_block block = {.box = {{0, 0, 0}, {40, 40, 40}}};
  hc_scene scene = plain_scene();
  scene.fluid.blocks = &block;
  scene.fluid.block_count = 1;
  hc_setup_plan plan = plan_of(&scene);
  ck_assert_int_eq(plan.fluid_count, INT64_C(8000000000));
  hc_particles fluid, boundary, moving;
  hc_particles_init(&moving, HC_BOUNDARY | HC_MOVED, HC_FOR_ALL);
  hc_particles_init(&fluid, HC_FLUID, HC_FOR_ALL);
  hc_particles_init(&boundary, HC_BOUNDARY, HC_FOR_ALL);
  hc_error error = {0};
  ck_assert_int_eq(hc_setup_generate(&plan, 1, 3, &fluid, &boundary, &moving, &error), HC_BAD_INPUT);
  ck_assert_ptr_nonnull(strstr(error.text, "268435391"));
  ck_assert_ptr_nonnull(strstr(error.text, "2666666667")); /* rank 1 of 3 */
  ck_assert_int_eq(hc_setup_generate(&plan, 777777, 1 << 20, &fluid, &boundary, &moving, &error), HC_OK);
  hc_particles_free(&fluid);
  hc_particles_free(&boundary);
  hc_particles_free(&moving);
  hc_setup_plan_free(&plan);
}
END_TEST

START_TEST(shares_tile_the_range) {
  const int64_t counts[] = {0, 1, 6, 7, 8, 1000003, (INT64_C(1) << 60) + 5};
  for (size_t c = 0; c < sizeof counts / sizeof *counts; c++)
    for (int size = 1; size < 2000; size += 37) {
      int64_t end = 0;
      for (int rank = 0; rank < size; rank++) {
        int64_t first, last;
        hc_setup_share(counts[c], rank, size, &first, &last);
        ck_assert_int_eq(first, end);
        ck_assert(last - first == counts[c] / size || last - first == counts[c] / size + 1);
        end = last;
      }
      ck_assert_int_eq(end, counts[c]);
    }
}
END_TEST

START_TEST(flow_agrees_with_the_library_everywhere) {
  const hc_flow flow = {HC_FLOW_TAYLOR_GREEN, 1.5, 0.7, 0};
  const double k = 2 * acos(-1.0) / 0.7;
  for (int i = -400; i <= 400; i++) {
    const double x[3] = {0.0037 * i, 0.11 - 0.0071 * i, 5};
    double v[3] = {10, 20, 30};
    hc_flow_add(&flow, x, v);
    ck_assert_double_eq_tol(v[0] - 10, -1.5 * cos(k * x[0]) * sin(k * x[1]), 3e-14);
    ck_assert_double_eq_tol(v[1] - 20, 1.5 * sin(k * x[0]) * cos(k * x[1]), 3e-14);
    ck_assert(v[2] == 30);
  }
}
END_TEST

START_TEST(standing_wave_agrees_with_the_library) {
  const hc_flow flow = {HC_FLOW_STANDING_WAVE, 0.3, 2.0, 1.25};
  const double k = acos(-1.0), scale = 0.3 / sinh(k * 1.25);
  for (int i = -200; i <= 200; i++) {
    const double x[3] = {0.0137 * i, 5, 0.0063 * (i + 20)};
    double v[3] = {10, 20, 30};
    hc_flow_add(&flow, x, v);
    ck_assert_double_eq_tol(v[0] - 10, scale * cosh(k * x[2]) * sin(k * x[0]), 3e-14);
    ck_assert(v[1] == 20);
    ck_assert_double_eq_tol(v[2] - 30, -scale * sinh(k * x[2]) * cos(k * x[0]), 3e-14);
  }
}
END_TEST

/* The kernel written out once more, in metres. */
static double kernel(double r, double h) {
  const double q = r / h, sigma = 8 / (acos(-1.0) * h * h * h);
  return q > 1 ? 0 : q > 0.5 ? 2 * sigma * pow(1 - q, 3) : sigma * (6 * (pow(q, 3) - q * q) + 1);
}

static double layer_sum(double dx, double h, int from, int to) {
  double sum = 0;
  for (int z = from; z <= to; z++)
    for (int y = -9; y <= 9; y++)
      for (int x = -9; x <= 9; x++) sum += kernel(dx * sqrt(x * x + y * y + z * z), h);
  return sum;
}

START_TEST(rest_lattice_matches_the_methods) {
  ck_assert_double_eq_tol(hc_setup_rest_lattice_sum(0.5) / 8, 1 - 2.75e-5, 1e-6);
  ck_assert_double_eq_tol(hc_setup_rest_lattice_sum(1 / 2.154) / pow(2.154, 3), 1.0039, 1e-4);
  ck_assert_double_eq_tol(hc_setup_wall_factor(0.5), 0.7006, 5e-5);
  const double wide = hc_setup_wall_factor(1 / 2.154);
  ck_assert(wide > 0.637 && wide < 0.651);
  for (double ratio = 1.5; ratio <= 4; ratio += 0.31) {
    const double h = 0.1, dx = h / ratio, factor = hc_setup_wall_factor(dx / h);
    const double all = layer_sum(dx, h, -9, 9);
    ck_assert_double_eq_tol(hc_setup_rest_lattice_sum(dx / h), all * h * h * h, 1e-12 * all);
    /* What the factor is for: half a lattice and a wall of V_b = factor / sum W make the rest density. */
    const double density =
        layer_sum(dx, h, 0, 9) / all + factor / layer_sum(dx, h, 0, 0) * layer_sum(dx, h, 1, 1);
    ck_assert_double_eq_tol(density, 1, 1e-12);
  }
}
END_TEST

/* A tank of 1 x 0.5 x 0.5 m: samples half a spacing outside. */
START_TEST(limits_are_computed_or_given) {
  hc_block block = {.box = {{0, 0, 0}, {0.4, 0.4, 0.4}}};
  hc_wall wall = {.box = {{0, 0, 0}, {1, 0.5, 0.5}}};
  hc_scene scene = plain_scene();
  scene.gravity[2] = -9.81;
  scene.origin_cells[0] = 1000;
  scene.fluid.blocks = &block;
  scene.fluid.block_count = 1;
  scene.boundary.walls = &wall;
  scene.boundary.wall_count = 1;
  hc_setup_plan plan = plan_of(&scene);
  hc_limits limits;
  hc_error error = {0};
  ck_assert_int_eq(hc_setup_limits(&scene, &plan, &(hc_emitters){NULL, 0}, &limits, &error), HC_OK);
  const double low[3] = {-1.03, -1.03, -1.03}, high[3] = {2.03, 1.53, 0.51 + 4 * 1.02};
  for (int a = 0; a < 3; a++) {
    ck_assert_double_eq_tol(hc_limits_low(&limits, &plan.frame, a), low[a], 1e-6);
    ck_assert_double_eq_tol(hc_limits_high(&limits, &plan.frame, a), high[a], 1e-6);
  }
  const int64_t corner[3] = {limits.low[0], limits.high[1], limits.high[2]};
  const int64_t beyond[3] = {limits.low[0], limits.high[1] + 1, limits.high[2]};
  ck_assert(hc_limits_hold(&limits, corner) && !hc_limits_hold(&limits, beyond));

  scene.domain.limits_min[2] = -0.25; /* along z only */
  scene.domain.limits_max[2] = 0.5;
  ck_assert_int_eq(hc_setup_limits(&scene, &plan, &(hc_emitters){NULL, 0}, &limits, &error), HC_OK);
  ck_assert_double_eq_tol(hc_limits_low(&limits, &plan.frame, 2), -0.25, 1e-6);
  ck_assert_double_eq_tol(hc_limits_high(&limits, &plan.frame, 0), high[0], 1e-6);
  scene.domain.limits_max[2] = 0.3;
  ck_assert_int_eq(hc_setup_limits(&scene, &plan, &(hc_emitters){NULL, 0}, &limits, &error), HC_BAD_INPUT);
  ck_assert_msg(strstr(error.text, "fluid.blocks[0]: must lie within domain.limits along z"), "%s",
                error.text);
  hc_setup_plan_free(&plan);

  scene.domain.limits_max[2] = 0.5;
  scene.boundary.wall_count = 0; /* nothing holds the fluid: no limits but those given */
  plan = plan_of(&scene);
  ck_assert_int_eq(hc_setup_limits(&scene, &plan, &(hc_emitters){NULL, 0}, &limits, &error), HC_OK);
  ck_assert(isinf(hc_limits_low(&limits, &plan.frame, 0)) && isinf(hc_limits_high(&limits, &plan.frame, 1)));
  ck_assert(!isinf(hc_limits_low(&limits, &plan.frame, 2)));
  hc_setup_plan_free(&plan);
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("setup");
  TCase *const cases = tcase_create("frame and particles");
  tcase_set_timeout(cases, 60);
  tcase_add_test(cases, open_axes_have_cells_of_the_support_radius);
  tcase_add_test(cases, cells_of_individual_steps_have_a_margin);
  tcase_add_test(cases, own_steps_have_a_longest);
  tcase_add_test(cases, periods_are_whole_cells_and_whole_spacings);
  tcase_add_test(cases, support_radius_never_exceeds_an_edge);
  tcase_add_test(cases, lower_end_is_a_cell_corner_and_shifts_exactly);
  tcase_add_test(cases, frames_that_cannot_be_are_refused_with_what_fits);
  tcase_add_test(cases, plan_counts_without_generating);
  tcase_add_test(cases, any_number_of_ranks_makes_the_same_particles);
  tcase_add_test(cases, particles_are_where_and_what_the_scene_says);
  tcase_add_test(cases, periodic_axes_wrap);
  tcase_add_test(cases, origin_cells_shift_every_particle_exactly);
  tcase_add_test(cases, disorder_shifts_the_fluid_off_its_lattice);
  tcase_add_test(cases, generating_replaces_the_stores);
  tcase_add_test(cases, plans_that_cannot_be_are_refused);
  tcase_add_test(cases, too_many_particles_for_a_rank_are_refused);
  tcase_add_test(cases, shares_tile_the_range);
  tcase_add_test(cases, limits_are_computed_or_given);
  tcase_add_test(cases, flow_agrees_with_the_library_everywhere);
  tcase_add_test(cases, standing_wave_agrees_with_the_library);
  tcase_add_test(cases, rest_lattice_matches_the_methods);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
