/* Layers of walls and the normals of their samples: counted on boxes, against distances on all shapes. */
#include "base/memory.h"
#include "geometry/round.h"
#include "setup/populate.h"
#include "setup/world_frame.h"

#include <check.h>
#include <math.h>

#define DX 0.1 /* m */

static const hc_lattice lattice = {{1e-4, 1e-4, 1e-4}, {123456789, -987654321, 7}, {1000, 1000, 1000}};
static const double base[3] = {0.2, -0.3, 0.7}, slanted[3] = {1, -0.5, 3};

typedef struct sample {
  double x[3], normal[3];
} sample;

typedef struct samples {
  sample *at;
  int64_t count;
} samples;

typedef struct wall {
  hc_shape shape;
  bool solid, plane;
} wall;

/* Frees the sampling. */
static samples all_samples(hc_sampling sampling, const wall *w) {
  samples set = {hc_alloc((size_t)hc_sampling_count(&sampling), sizeof(sample)),
                 hc_sampling_count(&sampling)};
  for (int64_t k = 0; k < set.count; k++) {
    int64_t units[3];
    hc_sampling_point(&sampling, k, units);
    for (int a = 0; a < 3; a++) set.at[k].x[a] = 1e-4 * (double)(units[a] - lattice.origin[a]);
    hc_shape_sample_normal(&w->shape, DX, w->solid, set.at[k].x, set.at[k].normal);
  }
  hc_sampling_free(&sampling);
  return set;
}

static double nearest(const samples *set, const double x[3], int64_t self) {
  double least = INFINITY;
  for (int64_t k = 0; k < set->count; k++) {
    const double *const y = set->at[k].x;
    if (k != self) least = fmin(least, hypot(hypot(x[0] - y[0], x[1] - y[1]), x[2] - y[2]));
  }
  return least;
}

static samples sample_wall(const wall *w, int layers) {
  static const double size[2] = {1.2, 0.9};
  return all_samples(w->plane ? hc_sampling_plane(&lattice, w->shape.centre, w->shape.axes[2], size, layers)
                              : hc_round_wall(&lattice, &w->shape, w->solid, layers),
                     w);
}

static int make_walls(wall walls[16]) {
  static const double min[3] = {-0.4, 0.3, 1.0}, max[3] = {0.5, 1.0, 1.8}, odd[3] = {0.53, 1.04, 1.77},
                      axis[3] = {1, 2, -2}, size[2] = {1.2, 0.9}, up[3] = {0, 0, 1}, down[3] = {0, -2, 0};
  int n = 0;
  for (int solid = 0; solid < 2; solid++) {
    walls[n++] = (wall){hc_shape_box(min, max, up, 0, 0), solid, false};
    walls[n++] = (wall){hc_shape_box(min, odd, axis, 0.1, 0x21), solid, false};
    walls[n++] = (wall){hc_shape_cylinder(base, up, 0.6, 1.0, 0), solid, false};
    walls[n++] = (wall){hc_shape_cylinder(base, slanted, 0.53, 0.94, 2), solid, false};
    walls[n++] = (wall){hc_shape_sphere(base, 0.63), solid, false};
  }
  walls[n++] = (wall){hc_shape_rectangle(base, up, size), false, true};
  walls[n++] = (wall){hc_shape_rectangle(base, down, size), false, true};
  walls[n++] = (wall){hc_shape_rectangle(base, slanted, size), false, true};
  return n;
}

/* The first layer is there whatever the second does; the second lies a spacing behind it, closed as it is. */
START_TEST(a_second_layer_lies_behind_the_first) {
  wall walls[16];
  const int count = make_walls(walls);
  for (int w = 0; w < count; w++) {
    const samples one = sample_wall(&walls[w], 1), two = sample_wall(&walls[w], 2);
    int64_t firsts = 0, seconds = 0;
    for (int64_t k = 0; k < two.count; k++) {
      const double *const x = two.at[k].x;
      const double crowd = nearest(&two, x, k) / DX, behind = nearest(&one, x, -1) / DX;
      ck_assert_msg(crowd > 0.6 && crowd < 1.3, "wall %d: %g spacings between samples", w, crowd);
      if (behind < 1e-3) {
        firsts++;
        continue;
      }
      seconds++;
      ck_assert_msg(behind > 0.7 && behind < 1.75, "wall %d: second layer %g spacings off", w, behind);
      const double depth = hc_shape_surface_distance(&walls[w].shape, x) / DX;
      ck_assert_msg(depth > (walls[w].solid ? 1.2 : 1.49) && depth < 2.65, "wall %d: %g deep", w, depth);
    }
    ck_assert_int_eq(firsts, one.count);
    const double share = (double)seconds / (double)one.count;
    ck_assert_msg(walls[w].solid ? share > 0.4 && share < 1 : share >= 1 && share < 1.8, "wall %d: %g", w,
                  share);
    hc_free(one.at);
    hc_free(two.at);
  }
}
END_TEST

/* Along its normal a sample comes to the surface; at edges and corners the way is longer by up to sqrt 3. */
START_TEST(normals_lead_into_the_fluid) {
  wall walls[16];
  const int count = make_walls(walls);
  for (int w = 0; w < count; w++)
    for (int layers = 1; layers <= 2; layers++) {
      const samples set = sample_wall(&walls[w], layers);
      int64_t straight = 0;
      for (int64_t k = 0; k < set.count; k++) {
        const sample *const s = &set.at[k];
        const double *const n = s->normal;
        ck_assert_double_eq_tol(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1, 1e-12);
        const double sign =
            walls[w].solid ? -1 : 1; /* the distance is below 0 in a solid, in a container's fluid */
        const double off = sign * hc_shape_region_distance(&walls[w].shape, s->x);
        const double step = 1e-3 * DX;
        double on[3];
        for (int a = 0; a < 3; a++) on[a] = s->x[a] + step * n[a];
        const double rate = (off - sign * hc_shape_region_distance(&walls[w].shape, on)) / step;
        ck_assert_msg(off > 0.49 * DX && rate > 0.57, "wall %d: %g off, %g nearer", w, off / DX, rate);
        straight += rate > 0.999;
      }
      ck_assert_msg(straight > set.count / 2, "wall %d: %lld straight of %lld", w, (long long)straight,
                    (long long)set.count);
      hc_free(set.at);
    }
}
END_TEST

/* How many samples have a normal with so many components that are not zero, all alike. */
static void count_normals(const samples *set, int64_t counts[4]) {
  for (int n = 0; n < 4; n++) counts[n] = 0;
  for (int64_t k = 0; k < set->count; k++) {
    int components = 0;
    for (int a = 0; a < 3; a++) components += set->at[k].normal[a] != 0;
    for (int a = 0; a < 3; a++)
      if (components && set->at[k].normal[a] != 0)
        ck_assert_double_eq_tol(fabs(set->at[k].normal[a]), 1 / sqrt(components), 1e-15);
    counts[components]++;
  }
}

static void assert_normals(const double edges[3], bool solid, int layers, const int64_t expected[4]) {
  static const double min[3] = {0, 0, 0}, none[3] = {0, 0, 1};
  const wall w = {hc_shape_box(min, edges, none, 0, 0), solid, false};
  const samples set =
      all_samples((solid ? hc_sampling_solid : hc_sampling_container)(&lattice, min, edges, 0, layers), &w);
  int64_t counts[4];
  count_normals(&set, counts);
  for (int n = 0; n < 4; n++)
    ck_assert_msg(counts[n] == expected[n], "%s %gx%gx%g, %d layers: %lld normals of %d components, not %lld",
                  solid ? "solid" : "container", edges[0], edges[1], edges[2], layers, (long long)counts[n],
                  n, (long long)expected[n]);
  hc_free(set.at);
}

START_TEST(boxes_have_exact_normals) {
  const double cube[3] = {0.6, 0.6, 0.6};
  assert_normals(cube, false, 1, (int64_t[]){0, 6 * 36, 12 * 6, 8});
  assert_normals(cube, false, 2, (int64_t[]){0, 12 * 36, 12 * 6 * 4, 8 * 8});
  assert_normals(cube, true, 1, (int64_t[]){0, 6 * 16, 12 * 4, 8});
  assert_normals(cube, true, 2, (int64_t[]){0, 6 * 20, 12 * 6, 16});
}
END_TEST

/* Plates: a layer in the middle knows its rim only; up to 3 spacings one layer a side; the layers of 3 share
 * the middle. */
START_TEST(thin_solids_do_not_cross_layers) {
  assert_normals((double[]){1.0, 1.0, 0.1}, true, 1, (int64_t[]){64, 32, 4, 0});
  assert_normals((double[]){1.0, 1.0, 0.1}, true, 2, (int64_t[]){64, 32, 4, 0});
  assert_normals((double[]){1.0, 1.0, 0.2}, true, 2, (int64_t[]){0, 128, 64, 8});
  assert_normals((double[]){1.0, 1.0, 0.29}, true, 2, (int64_t[]){0, 128 + 32 + 24, 64 + 4 + 4, 8});
  assert_normals((double[]){1.0, 1.0, 0.3}, true, 2, (int64_t[]){36, 128 + 32 + 24, 64 + 4 + 4, 8});
  const wall thin[] = {{hc_shape_cylinder(base, slanted, 0.14, 0.25, 0), true, false},
                       {hc_shape_sphere(base, 0.14), true, false}};
  for (int w = 0; w < 2; w++) {
    const samples one = sample_wall(&thin[w], 1), two = sample_wall(&thin[w], 2);
    ck_assert_int_eq(one.count, two.count);
    hc_free(one.at);
    hc_free(two.at);
  }
}
END_TEST

/* What the plan makes: counts of both layers, normals of every wall. */
START_TEST(particles_have_normals) {
  hc_wall walls[2] = {{.box = {{0, 0, 0}, {1, 1, 1}}},
                      {.form = HC_FORM_SPHERE, .sphere = {{0.5, 0.5, 0.5}, 0.3}, .inside = HC_INSIDE_SOLID}};
  hc_scene scene = {.particle_spacing = DX, .support_radius = 2 * DX};
  scene.boundary.walls = walls;
  scene.boundary.wall_count = 2;
  int64_t counts[3];
  for (int layers = 0; layers < 3; layers++) {
    scene.boundary.layers = layers;
    ck_assert_int_eq(hc_setup_layers(&scene), layers ? layers : 1);
    hc_frame frame;
    hc_setup_plan plan;
    ck_assert_int_eq(hc_setup_frame(&scene, &frame, NULL), HC_OK);
    ck_assert_int_eq(hc_setup_plan_make(NULL, &scene, &frame, &plan, NULL), HC_OK);
    counts[layers] = plan.boundary_count;
    hc_particles fluid, boundary, moving;
    hc_particles_init(&moving, HC_BOUNDARY | HC_MOVED, HC_FOR_ALL);
    hc_particles_init(&fluid, HC_FLUID, HC_FOR_ALL);
    hc_particles_init(&boundary, HC_BOUNDARY, HC_FOR_ALL);
    for (int rank = 0; rank < 3; rank++) {
      ck_assert_int_eq(hc_setup_generate(&plan, rank, 3, &fluid, &boundary, &moving, NULL), HC_OK);
      for (int64_t i = 0; i < boundary.own; i++) {
        const float *const n = &boundary.normal[3 * i];
        const bool sphere = hc_id_source_of(boundary.id[i]) == 1;
        double outward = 0, square = 0;
        for (int a = 0; a < 3; a++) {
          outward += n[a] * (hc_frame_to_metres(&frame, a, boundary.position[3 * i + a]) - 0.5);
          square += n[a] * n[a];
        }
        ck_assert_double_eq_tol(square, 1, 1e-6);
        ck_assert(sphere ? outward > 0.14 : outward < -0.5);
      }
    }
    hc_particles_free(&fluid);
    hc_particles_free(&boundary);
    hc_particles_free(&moving);
    hc_setup_plan_free(&plan);
  }
  ck_assert_int_eq(counts[0], counts[1]);
  ck_assert_int_gt(counts[2], 14 * 14 * 14 - 10 * 10 * 10); /* and the sphere */
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("layers");
  TCase *const tests = tcase_create("layers");
  tcase_set_timeout(tests, 120);
  tcase_add_test(tests, a_second_layer_lies_behind_the_first);
  tcase_add_test(tests, normals_lead_into_the_fluid);
  tcase_add_test(tests, boxes_have_exact_normals);
  tcase_add_test(tests, thin_solids_do_not_cross_layers);
  tcase_add_test(tests, particles_have_normals);
  suite_add_tcase(suite, tests);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? 1 : 0;
}
