/* Samples that touch count once: a box on the floor, and one far above it. */
#include "mpi_scene.h"

#include "particles/ids.h"

#include <stdlib.h>

static hc_scene_body bodies[2];

static void add_box(hc_scene *scene, int number, double z) {
  hc_scene_body *const body = &bodies[number];
  *body = (hc_scene_body){.density = 2000};
  body->surface.box = (hc_box){{0.2, 0.04, z}, {0.32, 0.16, z + 0.1}};
  body->surface.inside = HC_INSIDE_SOLID;
  body->surface.mesh.closed = true;
  body->turned.axis[2] = 1.0;
  for (int a = 0; a < 3; a++)
    body->center_of_mass[a] = body->position[a] = 0.5 * (body->surface.box.min[a] + body->surface.box.max[a]);
  scene->bodies = bodies;
  scene->body_count = number + 1;
}

/* Of own samples of a store whose volumes are less than by themselves: how many, their least share; sums. */
typedef struct found {
  int64_t less, all, sum; /* sum of the volumes that count, in units of 2^-60 m3 */
  double least;
} found;

static found look(const hc_particles *store, double low, double high) {
  found f = {.least = 1.0};
  for (int32_t k = 0; k < store->own; k++) {
    const double z = (double)store->position[3 * (size_t)k + 2] * 0.04 / (double)HC_CELL_UNITS;
    if (z < low || z > high) continue;
    const double share = (double)store->place[k].scalar / (double)store->volume[k];
    f.all++;
    f.less += store->place[k].scalar < store->volume[k];
    f.sum += (int64_t)((double)store->place[k].scalar * 0x1p60);
    if (share < f.least) f.least = share;
  }
  hc_comm_sum_i64(&comm, &f.less, 1);
  hc_comm_sum_i64(&comm, &f.all, 1);
  hc_comm_sum_i64(&comm, &f.sum, 1);
  hc_comm_min_f64(&comm, &f.least, 1);
  return f;
}

START_TEST(what_touches_counts_once) {
  hc_scene scene = make_scene(0.12, 0.2, 0.1);
  add_wall(&scene, 0.4, 0.2, 0.6, HC_FACE_PLUS_Z);
  add_box(&scene, 0, 0.0);
  add_box(&scene, 1, 0.3);
  scene.boundary.walls[0].name[0] = 't';
  hc_simulation simulation;
  start(&simulation, &scene);
  const found bottom = look(simulation.world.moving, 0.0, 0.015),
              top = look(simulation.world.moving, 0.08, 0.1),
              above = look(simulation.world.moving, 0.25, 0.5),
              floor = look(simulation.world.boundary, -0.02, 0.0),
              rim = look(simulation.world.boundary, 0.3, 0.6);
  ck_assert_int_eq(bottom.less, bottom.all);
  ck_assert_int_gt(bottom.all, 20);
  ck_assert_double_lt(bottom.least, 0.9);
  ck_assert_double_gt(bottom.least, 0.4);
  ck_assert_int_eq(top.less + above.less + rim.less, 0);
  ck_assert_int_gt(floor.less, bottom.all / 2);
  ck_assert_int_lt(floor.less, floor.all);
  ck_assert_double_lt(floor.least, 0.9);
  /* once they part, all is as before: the volumes of the state have not changed */
  for (int k = 0; k < 2; k++) simulation.bodies.body[k].position[2] += 5 * HC_CELL_UNITS;
  simulation.movers.posed = false;
  hc_simulation_pose_walls(&simulation);
  hc_world_update(&simulation.world);
  hc_bodies_touch(&simulation.bodies, &simulation.world);
  const found parted = look(simulation.world.boundary, -0.02, 0.0);
  ck_assert_int_eq(parted.less, 0);
  ck_assert_int_gt(parted.sum, floor.sum);
  hc_simulation_free(&simulation);
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("touching");
  tcase_set_timeout(tests, 100);
  tcase_add_test(tests, what_touches_counts_once);
  return run_mpi_tests("touching", tests);
}
