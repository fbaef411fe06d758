/* Surfaces: distances against other formulas, samples without gaps and crowds and with the right normals,
 * fluid that fills what there is. */
#include "meshes.h"

#include "base/memory.h"
#include "geometry/revolution.h"
#include "geometry/surface_samples.h"
#include "geometry/surface_sampling.h"

#include <check.h>
#include <stdlib.h>

#define DX 0.1 /* m */

static const hc_lattice lattice = {{1e-4, 1e-4, 1e-4}, {123456789, -987654321, 7}, {1000, 1000, 1000}};
static const double none[3] = {0, 0, 0}, up[3] = {0, 0, 1}, slanted[3] = {1, -0.5, 3};
static const double box_low[3] = {-0.4, 0.3, 1.0}, box_high[3] = {0.6, 1.0, 1.8}, centre[3] = {0.3, 0.2, 0.1};
static const double glass[][2] = {{0, 0},     {0.5, 0},    {0.55, 0.1}, {0.6, 1.2},
                                  {0.4, 1.2}, {0.38, 0.3}, {0.3, 0.2},  {0, 0.2}};

/* Takes the mesh over. */
static hc_surface *surface_of(hc_mesh mesh, bool closed) {
  hc_error error = {0};
  bool turned;
  hc_mesh_weld(&mesh);
  ck_assert_msg(hc_mesh_check(&mesh, !closed, &turned, &error) == HC_OK, "%s", error.text);
  ck_assert(!turned);
  return hc_surface_make(&mesh, closed);
}

static hc_mesh glass_mesh(void) {
  hc_mesh mesh;
  ck_assert_int_eq(hc_revolution_mesh(none, slanted, glass, 8, true, DX, &mesh, NULL), HC_OK);
  return mesh;
}

static hc_mesh torus_mesh(void) {
  double ring[24][2];
  for (int k = 0; k < 24; k++) {
    ring[k][0] = 0.5 + 0.2 * cos(k * acos(-1.0) / 12);
    ring[k][1] = 0.2 * sin(k * acos(-1.0) / 12);
  }
  hc_mesh mesh;
  ck_assert_int_eq(hc_revolution_mesh(none, slanted, (const double(*)[2])ring, 24, true, DX, &mesh, NULL),
                   HC_OK);
  return mesh;
}

static double random_in(double low, double high) {
  static uint64_t state = 88172645463325252u;
  state ^= state << 13;
  state ^= state >> 7;
  state ^= state << 17;
  return low + (high - low) * (double)(state >> 11) / 9007199254740992.0;
}

START_TEST(distances_are_those_of_the_shapes) {
  hc_surface *const box = surface_of(box_mesh(box_low, box_high), true), *const ball = surface_of(
                                                                             sphere_mesh(centre, 1, 4), true);
  const hc_shape exact_box = hc_shape_box(box_low, box_high, up, 0, 0),
                 exact_ball = hc_shape_sphere(centre, 1);
  for (int k = 0; k < 5000; k++) {
    const double x[3] = {random_in(-2, 2), random_in(-2, 2), random_in(-1, 3)};
    ck_assert_double_eq_tol(hc_surface_signed_distance(box, x, NULL), hc_shape_distance(&exact_box, x),
                            1e-12);
    ck_assert_double_eq_tol(hc_surface_signed_distance(ball, x, NULL), hc_shape_distance(&exact_ball, x),
                            4e-3);
  }
  hc_surface_free(box);
  hc_surface_free(ball);
}
END_TEST

/* The sign against the solid angle that the triangles take up, with corners and edges nearest too. */
START_TEST(sides_are_right_everywhere) {
  const double disc[][2] = {{0, 0}, {0.5, 0.1}, {0, 0.2}}; /* with a sharp rim */
  hc_mesh sharp;
  ck_assert_int_eq(hc_revolution_mesh(none, slanted, disc, 3, true, DX, &sharp, NULL), HC_OK);
  hc_surface *const surfaces[] = {surface_of(l_mesh(0.5), true), surface_of(glass_mesh(), true),
                                  surface_of(torus_mesh(), true), surface_of(sharp, true)};
  for (int s = 0; s < 4; s++) {
    const hc_mesh *const mesh = &surfaces[s]->mesh;
    for (int k = 0; k < 150; k++) {
      double x[3], angle = 0;
      for (int a = 0; a < 3; a++) x[a] = random_in(surfaces[s]->low[a] - 0.1, surfaces[s]->high[a] + 0.1);
      for (int32_t t = 0; t < mesh->triangle_count; t++) { /* van Oosterom and Strackee 1983 */
        double r[3][3], d[3], volume = 0;
        for (int c = 0; c < 3; c++) {
          for (int a = 0; a < 3; a++) r[c][a] = mesh->vertex[mesh->triangle[t][c]][a] - x[a];
          d[c] = sqrt(r[c][0] * r[c][0] + r[c][1] * r[c][1] + r[c][2] * r[c][2]);
        }
        for (int a = 0; a < 3; a++) {
          const int b = (a + 1) % 3, c = (a + 2) % 3;
          volume += r[0][a] * (r[1][b] * r[2][c] - r[1][c] * r[2][b]);
        }
        double below = d[0] * d[1] * d[2];
        for (int c = 0; c < 3; c++)
          for (int a = 0; a < 3; a++) below += r[c][a] * r[(c + 1) % 3][a] * d[(c + 2) % 3];
        angle += 2 * atan2(volume, below);
      }
      const bool inside = angle > 6;
      ck_assert_msg((hc_surface_signed_distance(surfaces[s], x, NULL) < 0) == inside,
                    "surface %d at %g %g %g", s, x[0], x[1], x[2]);
    }
    hc_surface_free(surfaces[s]);
  }
}
END_TEST

static double nearest(const hc_surface *surface, const double x[3], int64_t self) {
  double least = INFINITY;
  for (int64_t k = 0; k < surface->sample_count; k++) {
    double square = 0;
    for (int a = 0; a < 3; a++)
      square += (x[a] - surface->samples[k].x[a]) * (x[a] - surface->samples[k].x[a]);
    if (k != self && square < least) least = square;
  }
  return sqrt(least);
}

/* Brings a random point to the surface on which the first layer lies; false if there is none here, for the
 * wall is too thin or an edge is near. */
static bool on_layer(const hc_surface *surface, double side, double x[3]) {
  for (int a = 0; a < 3; a++) x[a] = random_in(surface->low[a] - DX, surface->high[a] + DX);
  for (int round = 0; round < 4; round++) {
    hc_surface_point point;
    const double deep = -side * hc_surface_signed_distance(surface, x, &point);
    if (round == 0 && fabs(deep - 0.5 * DX) > 0.2 * DX) return false;
    if (round == 3) return fabs(deep - 0.5 * DX) < 1e-3 * DX;
    for (int a = 0; a < 3; a++) x[a] += (x[a] - point.x[a]) / deep * (0.5 * DX - deep);
  }
  return false;
}

/* What is promised of samples: neighbours at 0.7 to 1.3 spacings, no place farther than 0.85 from all, depths
 * and normals. Frees the surface. */
static void assert_even(const char *name, hc_surface *surface, int layers, bool fluid_inside) {
  hc_error error = {0};
  ck_assert_int_eq(hc_surface_samples_make(surface, DX, layers, fluid_inside, &hc_parts_alone, &error),
                   HC_OK);
  const double side = fluid_inside ? -1 : 1;
  double least = INFINITY, most = 0, hole = 0;
  for (int64_t k = 0; k < surface->sample_count; k++) {
    const hc_surface_sample *const sample = &surface->samples[k];
    const double gap = nearest(surface, sample->x, k) / DX,
                 deep = -side * hc_surface_signed_distance(surface, sample->x, NULL) / DX;
    least = fmin(least, gap);
    most = fmax(most, gap);
    ck_assert_msg(deep > 0.46 && deep < (layers - 0.5) * 2.01, "%s: %g deep", name, deep);
    double square = 0, ahead[3];
    for (int a = 0; a < 3; a++) {
      square += sample->normal[a] * sample->normal[a];
      ahead[a] = sample->x[a] + 0.01 * DX * sample->normal[a];
    }
    const double rise = 100 * (deep + side * hc_surface_signed_distance(surface, ahead, NULL) / DX);
    ck_assert_double_eq_tol(square, 1, 1e-12);
    ck_assert_msg(rise > 0.55, "%s: towards the fluid only by %g", name, rise);
  }
  int hits = 0;
  for (int k = 0; k < 10000; k++) {
    double x[3];
    if (!on_layer(surface, side, x)) continue;
    hits++;
    hole = fmax(hole, nearest(surface, x, -1) / DX);
  }
  ck_assert_int_gt(hits, 40);
  printf("%s, %d layers, fluid %s: %lld samples, nearest neighbours at %.3f to %.3f spacings, largest hole "
         "%.3f\n",
         name, layers, fluid_inside ? "inside" : "outside", (long long)surface->sample_count, least, most,
         hole);
  ck_assert_msg(least > 0.7 && most < 1.3 && hole < 0.85, "%s: neighbours at %g to %g, hole %g", name, least,
                most, hole);
  hc_surface_free(surface);
}

START_TEST(samples_are_even) {
  assert_even("box", surface_of(box_mesh(box_low, box_high), true), 1, false);
  assert_even("box", surface_of(box_mesh(box_low, box_high), true), 2, true);
  assert_even("sphere", surface_of(sphere_mesh(centre, 0.6, 3), true), 1, false);
  assert_even("small sphere", surface_of(sphere_mesh(centre, 0.3, 3), true), 2, true);
  assert_even("torus", surface_of(torus_mesh(), true), 1, true);
  assert_even("L", surface_of(l_mesh(0.53), true), 1, true);
  assert_even("L", surface_of(l_mesh(0.53), true), 2, false);
  assert_even("glass", surface_of(glass_mesh(), true), 2, false);
}
END_TEST

START_TEST(normals_are_those_of_the_shape) {
  hc_surface *const box = surface_of(box_mesh(box_low, box_high), true), *const ball = surface_of(
                                                                             sphere_mesh(centre, 0.8, 3),
                                                                             true);
  hc_error error;
  ck_assert_int_eq(hc_surface_samples_make(box, DX, 2, true, &hc_parts_alone, &error), HC_OK);
  int64_t faces = 0, edges = 0, corners = 0;
  for (int64_t k = 0; k < box->sample_count; k++) {
    const double *const n = box->samples[k].normal, *const x = box->samples[k].x;
    int parts = 0, beyond = 0;
    for (int a = 0; a < 3; a++) {
      parts += n[a] != 0;
      beyond += x[a] < box_low[a] - 0.3 * DX || x[a] > box_high[a] + 0.3 * DX;
    }
    faces += parts == 1;
    edges += parts == 2;
    corners += parts == 3;
    if (parts == 1) ck_assert(fabs(n[0]) == 1 || fabs(n[1]) == 1 || fabs(n[2]) == 1);
    if (parts == 3)
      for (int a = 0; a < 3; a++) ck_assert_double_eq_tol(fabs(n[a]), 1 / sqrt(3.0), 1e-6);
    ck_assert_int_le(parts, beyond); /* a face's sample may lie beyond two, near the second layer's edge */
  }
  ck_assert_int_eq(corners, 16);
  ck_assert_int_gt(edges, 80);
  ck_assert_int_gt(faces, edges);
  ck_assert_int_eq(hc_surface_samples_make(ball, DX, 1, false, &hc_parts_alone, &error), HC_OK);
  double worst = 1;
  for (int64_t k = 0; k < ball->sample_count; k++) {
    double along = 0, square = 0;
    for (int a = 0; a < 3; a++) {
      const double out = ball->samples[k].x[a] - centre[a];
      along += out * ball->samples[k].normal[a];
      square += out * out;
    }
    worst = fmin(worst, along / sqrt(square));
  }
  printf("normals of a sphere of 1280 triangles: within %.2f degrees\n", acos(worst) * 180 / acos(-1.0));
  ck_assert_double_gt(worst, cos(3 * acos(-1.0) / 180));
  hc_surface_free(box);
  hc_surface_free(ball);
}
END_TEST

/* A plate of half a spacing: one layer in its middle, none of whose sides is the fluid's; of two spacings:
 * two. */
START_TEST(thin_walls_have_what_fits) {
  for (int thick = 0; thick < 2; thick++) {
    const double high[3] = {1, 1, thick ? 2 * DX : 0.5 * DX};
    hc_surface *const plate = surface_of(box_mesh(none, high), true);
    ck_assert_int_eq(hc_surface_samples_make(plate, DX, 2, false, &hc_parts_alone, NULL), HC_OK);
    ck_assert_int_gt(plate->sample_count, thick ? 150 : 75);
    ck_assert_int_lt(plate->sample_count, thick ? 240 : 120);
    for (int64_t k = 0; k < plate->sample_count; k++) {
      const hc_surface_sample *const s = &plate->samples[k];
      const double z = fmin(s->x[2], high[2] - s->x[2]);
      ck_assert_double_eq_tol(z, thick ? 0.5 * DX : 0.25 * DX, 1e-3 * DX);
      ck_assert(thick || (s->normal[0] == 0 && s->normal[1] == 0 && s->normal[2] == 0));
    }
    hc_surface_free(plate);
  }
}
END_TEST

/* Half a box: the sheet has samples behind it, none before it or around its border. */
START_TEST(sheets_have_one_side) {
  hc_mesh mesh = box_mesh(none, (double[]){1, 1, 1});
  mesh.triangle_count = 6; /* what looks along -x, +x and -y */
  hc_surface *const sheet = surface_of(mesh, false);
  ck_assert_int_eq(hc_surface_samples_make(sheet, DX, 1, false, &hc_parts_alone, NULL), HC_OK);
  ck_assert_int_gt(sheet->sample_count, 220);
  for (int64_t k = 0; k < sheet->sample_count; k++) {
    const double *const x = sheet->samples[k].x;
    ck_assert(x[0] > 0.049 && x[0] < 0.951 && x[1] > -1e-9 && x[1] < 1 + 1e-9 && x[2] > -1e-9 &&
              x[2] < 1 + 1e-9);
    ck_assert(x[0] < 0.051 || x[0] > 0.949 || x[1] < 0.051);
  }
  const hc_shape shape = hc_surface_sampling_shape(sheet);
  ck_assert_double_eq_tol(hc_shape_distance(&shape, (double[]){-0.2, 0.5, 0.5}), -0.2, 1e-12);
  ck_assert_double_eq_tol(hc_shape_distance(&shape, (double[]){0.2, 0.5, 0.5}), 0.2, 1e-12);
  hc_surface_free(sheet);
}
END_TEST

START_TEST(the_same_mesh_gives_the_same_samples) {
  hc_surface *const two[2] = {surface_of(torus_mesh(), true), surface_of(torus_mesh(), true)};
  for (int k = 0; k < 2; k++)
    ck_assert_int_eq(hc_surface_samples_make(two[k], DX, 2, false, &hc_parts_alone, NULL), HC_OK);
  ck_assert_int_eq(two[0]->sample_count, two[1]->sample_count);
  ck_assert_mem_eq(two[0]->samples, two[1]->samples, (size_t)two[0]->sample_count * sizeof *two[0]->samples);
  for (int k = 0; k < 2; k++) hc_surface_free(two[k]);
}
END_TEST

START_TEST(too_much_to_sample_is_refused) {
  hc_surface *const box = surface_of(box_mesh(box_low, box_high), true);
  hc_error error = {0};
  ck_assert_int_eq(hc_surface_samples_make(box, 1e-6, 1, false, &hc_parts_alone, &error), HC_BAD_INPUT);
  ck_assert_ptr_nonnull(strstr(error.text, "is its scale right?"));
  hc_surface_free(box);
}
END_TEST

/* Points of a filling are as many as of the shapes they are of; a box has the very same. */
START_TEST(fillings_are_whole) {
  hc_surface *const box = surface_of(box_mesh(box_low, box_high), true),
                    *const l = surface_of(l_mesh(0.5), true),
                    *const ball = surface_of(sphere_mesh(centre, 1, 4), true);
  hc_sampling filled = hc_surface_sampling_fill(&lattice, box);
  const hc_sampling block = hc_sampling_block(&lattice, box_low, box_high);
  ck_assert_int_eq(hc_sampling_count(&filled), hc_sampling_count(&block));
  for (int64_t k = 0; k < hc_sampling_count(&filled); k++) {
    int64_t x[3], y[3];
    hc_sampling_point(&filled, k, x);
    hc_sampling_point(&block, k, y);
    for (int a = 0; a < 3; a++) ck_assert_int_eq(x[a], y[a]);
  }
  hc_sampling_free(&filled);
  filled = hc_surface_sampling_fill(&lattice, l);
  ck_assert_int_eq(hc_sampling_count(&filled), 10 * 5 * 10 - 5 * 5 * 5);
  hc_sampling_free(&filled);
  filled = hc_surface_sampling_fill(&lattice, ball);
  int64_t expected = 0;
  const double corner = 1 - 0.5 * DX; /* the lattice begins at the lower corner of the box around it */
  for (int n = 0; n < 8000; n++) {
    const double x = n % 20 * DX - corner, y = n / 20 % 20 * DX - corner, z = n / 400 * DX - corner;
    expected += x * x + y * y + z * z <= corner * corner;
  }
  ck_assert_int_le(llabs(hc_sampling_count(&filled) - expected), expected / 50);
  for (int64_t k = 0; k < hc_sampling_count(&filled); k++) {
    int64_t units[3];
    double x[3];
    hc_sampling_point(&filled, k, units);
    for (int a = 0; a < 3; a++) x[a] = 1e-4 * (double)(units[a] - lattice.origin[a]);
    ck_assert_double_le(hc_surface_signed_distance(ball, x, NULL), -0.499 * DX);
  }
  hc_sampling_free(&filled);
  hc_surface_free(box);
  hc_surface_free(l);
  hc_surface_free(ball);
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("mesh_sampling");
  TCase *const tests = tcase_create("mesh_sampling");
  tcase_set_timeout(tests, 120);
  tcase_add_test(tests, distances_are_those_of_the_shapes);
  tcase_add_test(tests, sides_are_right_everywhere);
  tcase_add_test(tests, samples_are_even);
  tcase_add_test(tests, normals_are_those_of_the_shape);
  tcase_add_test(tests, thin_walls_have_what_fits);
  tcase_add_test(tests, sheets_have_one_side);
  tcase_add_test(tests, the_same_mesh_gives_the_same_samples);
  tcase_add_test(tests, too_much_to_sample_is_refused);
  tcase_add_test(tests, fillings_are_whole);
  suite_add_tcase(suite, tests);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? 1 : 0;
}
