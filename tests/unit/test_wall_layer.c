/* What walls do to the fluid next to them besides the pressure: friction and depth, on one particle over a
 * flat wall; and the logarithm of rough walls. */
#include "base/logarithm.h"
#include "cloud.h"
#include "solver/wall_layer.h"

#include <check.h>

enum { ROW = 9 };
static const double SPACING = 0.02, DT = 0.002; /* the support radius is two spacings */

/* A particle at `height` over the wetted surface of a plane that faces +z; the samples lie half a spacing
 * behind it. Those of x < 0 are of wall 0, the others of wall 1. */
static void make_plane(setting *s, double height) {
  setting_init(s, 1.0);
  s->sweep.wall_offset = 0.25f;
  hc_particles_resize(&s->fluid, 1);
  hc_particles_resize(&s->boundary, ROW * ROW);
  const double unit = s->frame.unit[0];
  s->fluid.position[2] = llrint((height + 0.5 * SPACING) / unit);
  for (int32_t b = 0; b < ROW * ROW; b++) {
    s->boundary.position[3 * b] = llrint((b % ROW - ROW / 2) * SPACING / unit);
    s->boundary.position[3 * b + 1] = llrint((b / ROW - ROW / 2) * SPACING / unit);
  }
  settle(s);
  for (int32_t b = 0; b < ROW * ROW; b++) {
    s->boundary.volume[b] = s->boundary.place[b].scalar = (float)VOLUME;
    s->boundary.facing[b] = (hc_record){.v = {0.0f, 0.0f, 1.0f}, .scalar = 1.0f};
    s->boundary.motion[b] = (hc_record){.v = {0.0f, 0.0f, 0.0f}, .scalar = s->boundary.position[3 * b] >= 0};
  }
}

/* The particle's velocity after friction; before it is (2, -1, 0.5). */
static void rub(setting *s, const hc_wall_friction friction[2], hc_world *world) {
  static const double before[3] = {2, -1, 0.5};
  const hc_solver_settings settings = {.gravity = {0, 0, -10}, .kinematic_viscosity = 1e-6};
  memcpy(s->fluid.velocity, before, sizeof before);
  s->sweep.friction = friction;
  s->sweep.friction_differs = friction[0].law != friction[1].law;
  s->sweep.walls_move = true;
  *world = (hc_world){.frame = s->frame,
                      .sweeps = hc_sweeps_of(hc_isa_best()),
                      .sweep = s->sweep,
                      .walls = s->walls,
                      .fluid = &s->fluid};
  hc_wall_layer_look(world, &settings, NULL);
  hc_wall_layer_act(world, &settings, DT, 0, s->fluid.own);
}

/* Twice the volume times |sum grad W|. */
static double area(const setting *s) {
  vec sum = {{0, 0, 0}};
  for (int32_t b = 0; b < s->boundary.own; b++)
    add(&sum, 1, gradient(separation(s, &s->fluid, 0, &s->boundary, b)));
  return 2 * VOLUME * norm(sum);
}

START_TEST(friction_is_that_of_the_law) {
  static const double speed = 2.23606797749979, viscosity = 1e-6, roughness = 1e-3;
  static const double heights[] = {0.2, 0.5, 0.9}; /* spacings */
  for (size_t k = 0; k < sizeof heights / sizeof *heights; k++) {
    setting s;
    make_plane(&s, heights[k] * SPACING);
    const double y = fmax(heights[k], 0.25) * SPACING, reach = speed * y / viscosity;
    const double smooth = 0.0246385 * speed / pow(reach, 0.25),
                 rough = pow(0.41 / log(30 * y / roughness), 2) * speed;
    const double stress[] = {0, viscosity / y, smooth, fmax(smooth, rough)};
    if (heights[k] == 0.5) ck_assert(fabs(area(&s) * SPACING - 1) < 0.05);
    for (int law = HC_FRICTION_NONE; law <= HC_FRICTION_ROUGH; law++) {
      const hc_wall_friction friction[2] = {{(hc_friction_law)law, roughness},
                                            {(hc_friction_law)law, roughness}};
      hc_world world;
      rub(&s, friction, &world);
      const double left = 1 / (1 + DT * area(&s) * stress[law]), *v = s.fluid.velocity;
      ck_assert(fabs(v[0] - 2 * left) < 1e-6 && fabs(v[1] + left) < 1e-6 && v[2] == 0.5);
      for (int axis = 0; axis < 3; axis++) ck_assert(s.fluid.motion[0].v[axis] == (float)v[axis]);
      ck_assert_uint_eq(world.touches.count, 1);
      ck_assert(fabs((double)world.touches.at[0].rub[0] - (v[0] - 2)) < 1e-6);
      hc_free(world.touches.at);
    }
    setting_free(&s);
  }
}
END_TEST

START_TEST(friction_goes_by_the_wall) {
  setting s;
  make_plane(&s, 0.5 * SPACING);
  const hc_wall_friction both[2] = {{HC_FRICTION_SMOOTH, 0}, {HC_FRICTION_SMOOTH, 0}},
                         one[2] = {{HC_FRICTION_SMOOTH, 0}, {HC_FRICTION_NONE, 0}};
  hc_world world;
  rub(&s, both, &world);
  const double of_both = 2 - s.fluid.velocity[0];
  hc_free(world.touches.at);
  rub(&s, one, &world); /* the row of x = 0 is of the wall without */
  const double of_one = 2 - s.fluid.velocity[0];
  hc_free(world.touches.at);
  ck_assert(of_both > 0 && of_one > 0 && of_one < 0.6 * of_both);
  for (int32_t b = 0; b < s.boundary.own; b++)
    s.boundary.motion[b].v[0] = 2.0f, s.boundary.motion[b].v[1] = -1.0f;
  rub(&s, both, &world); /* the wall goes along */
  ck_assert(fabs(s.fluid.velocity[0] - 2) < 1e-6 && fabs(s.fluid.velocity[1] + 1) < 1e-6);
  hc_free(world.touches.at);
  setting_free(&s);
}
END_TEST

/* At a wall along gravity, pressure that grows with depth pushes up; where it bears nothing, it does not. */
START_TEST(depth_pushes_against_the_pull) {
  setting s;
  make_plane(&s, 0.5 * SPACING);
  static const double still[3] = {0, 0, 0};
  const hc_solver_settings settings = {.gravity = {-10, 0, 0}, .kinematic_viscosity = 1e-6};
  const float high = 1e4f, low = 50.0f, none = 0.0f; /* rho g spacing = 200 Pa */
  double push[4];
  for (int k = 0; k < 4; k++) {
    memcpy(s.fluid.velocity, still, sizeof still);
    s.fluid.borne[0] = k < 3 ? 1.0f : 0.0f;
    hc_world world = {.frame = s.frame,
                      .sweeps = hc_sweeps_of(hc_isa_best()),
                      .sweep = s.sweep,
                      .walls = s.walls,
                      .fluid = &s.fluid};
    hc_wall_layer_look(&world, &settings, k == 1 ? &low : k == 2 ? &none : &high);
    hc_wall_layer_act(&world, &settings, DT, 0, 1);
    push[k] = s.fluid.velocity[0];
    ck_assert(fabs(s.fluid.velocity[1]) < 1e-9 && fabs(s.fluid.velocity[2]) < 1e-9);
    hc_free(world.touches.at);
  }
  ck_assert(push[0] > 0.1 * DT * 10 && push[0] < 0.5 * DT * 10); /* the wall's share of the neighbourhood */
  ck_assert(fabs(push[1] - 0.25 * push[0]) < 1e-6 * push[0] && push[2] == 0 && push[3] == 0);
  setting_free(&s);
}
END_TEST

enum { FLUID = 1500, BOUNDARY = 500, SUMS = sizeof(hc_wall_around) / sizeof(float) };

/* The sums around a particle in the order of hc_wall_around, and those of their terms' magnitudes. */
static void look_around(const setting *s, const hc_touch *touch, double sum[SUMS], double scale[SUMS]) {
  const vec pull = {{touch->depth[0], touch->depth[1], touch->depth[2]}};
  memset(sum, 0, SUMS * sizeof *sum);
  for (int k = 0; k < SUMS; k++) /* the outermost neighbours' kernels are small differences of ones */
    scale[k] = k < 8 ? 1e-5 : (k < 11 ? 1 : VOLUME * norm(pull) * H) * 1e-4 * 8 / (PI * H * H * H * H);
  for (int32_t b = 0; b < s->boundary.own; b++) {
    const vec x = separation(s, &s->fluid, touch->particle, &s->boundary, b), g = gradient(x);
    const float *const n = s->boundary.facing[b].v, *const v = s->boundary.motion[b].v;
    const double shape = kernel(norm(x)) * PI * H * H * H / 8, depth = -dot(pull, x);
    const double height = (x.x[0] * (double)n[0] + x.x[1] * (double)n[1] + x.x[2] * (double)n[2]) / H;
    const bool rubs = height > 0 && s->sweep.friction[(int)s->boundary.motion[b].scalar].law;
    double term[SUMS] = {rubs ? shape : 0, rubs ? shape * height : 0};
    for (int axis = 0; axis < 3; axis++) {
      if (rubs) {
        term[2 + axis] = shape * (double)n[axis];
        term[5 + axis] = s->sweep.walls_move ? shape * (double)v[axis] : 0;
        term[8 + axis] = g.x[axis];
      }
      term[11 + axis] = boundary_volume_of(s->boundary.id[b]) * depth * g.x[axis];
    }
    for (int k = 0; k < SUMS; k++) sum[k] += term[k], scale[k] += fabs(term[k]);
    for (int axis = 0; axis < 3; axis++) /* of three products */
      scale[11 + axis] += boundary_volume_of(s->boundary.id[b]) * norm(pull) * norm(x) * norm(g);
  }
}

START_TEST(surroundings_agree_with_plain_sums) {
  setting s;
  make_cloud(&s, FLUID, BOUNDARY);
  const hc_wall_friction friction[2] = {{HC_FRICTION_SMOOTH, 0},
                                        {_i ? HC_FRICTION_NONE : HC_FRICTION_SMOOTH, 0}};
  s.sweep.friction = friction;
  s.sweep.friction_differs = _i;
  s.sweep.walls_move = _i < 2;
  for (int32_t b = 0; b < BOUNDARY; b++) {
    double n[3], square = 0;
    for (int axis = 0; axis < 3; axis++) {
      n[axis] = random_number((uint64_t)(3 * b + axis) + 55555);
      square += n[axis] * n[axis];
    }
    for (int axis = 0; axis < 3; axis++) s.boundary.facing[b].v[axis] = (float)(n[axis] / sqrt(square));
    s.boundary.motion[b].scalar = (float)(mix((uint64_t)b) & 1);
  }
  hc_touch touches[FLUID];
  int32_t count = 0;
  for (int32_t i = 0; i < FLUID; i++) {
    if (hc_list_count(&s.walls, i) == 0) continue;
    touches[count] = (hc_touch){.particle = i};
    for (int axis = 0; axis < 3; axis++)
      touches[count].depth[axis] = (float)(10 * random_number((uint64_t)(3 * i + axis) + 33333));
    count++;
  }
  ck_assert_int_gt(count, 3 * 64);
  hc_wall_around found[HC_ISA_COUNT][FLUID];
  memset(found, 0, sizeof found);
  for (hc_isa isa = 0; isa <= hc_isa_best(); isa++) {
    hc_sweeps_of(isa)->wall_layer(&s.sweep, touches, count, found[isa]);
    for (int32_t k = 0; k < count; k++) {
      double sum[SUMS], scale[SUMS];
      float sums[SUMS];
      look_around(&s, &touches[k], sum, scale);
      memcpy(sums, &found[isa][k], sizeof sums);
      for (int n = 0; n < SUMS; n++)
        ck_assert_msg(fabs((double)sums[n] - sum[n]) <= TOLERANCE * scale[n], "%s, sum %d: %g, not %g",
                      hc_isa_name(isa), n, (double)sums[n], sum[n]);
    }
  }
  if (hc_isa_best() == HC_ISA_AVX512)
    ck_assert(memcmp(found[HC_ISA_AVX2], found[HC_ISA_AVX512], sizeof found[0]) == 0);
  setting_free(&s);
}
END_TEST

START_TEST(logarithm_is_that_of_the_library) {
  for (double x = 1e-9; x < 1e9; x *= 1.37)
    ck_assert(fabs(hc_logarithm(x) - log(x)) <= 4e-16 * fmax(1, fabs(log(x))));
  ck_assert(hc_logarithm(1) == 0);
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("wall layer");
  TCase *const cases = tcase_create("one particle");
  tcase_add_test(cases, friction_is_that_of_the_law);
  tcase_add_test(cases, friction_goes_by_the_wall);
  tcase_add_test(cases, depth_pushes_against_the_pull);
  tcase_add_loop_test(cases, surroundings_agree_with_plain_sums, 0, 3);
  tcase_add_test(cases, logarithm_is_that_of_the_library);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
