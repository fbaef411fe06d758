/* The sweeps over predicted positions (PCISPH) against plain double-precision sums over all pairs, for every
 * instruction set, with every way in which walls take part. */
#include "boundary/boundary.h"
#include "cloud.h"
#include "setup/rest_lattice.h"
#include "sph/error_rule.h"

#include <check.h>

enum { FLUID = 500, WALL = 200, RULES = 4 };

static const float STIFFNESS = 300.0f, DT = 0.002f, REACH = 0.02f;
static float weights[HC_WALL_WEIGHTS + 1];

static double normal_of(uint64_t id, int axis) {
  const double about[3] = {random_number(17 * id + 1), random_number(17 * id + 2), 2.0};
  const double size = sqrt(about[0] * about[0] + about[1] * about[1] + about[2] * about[2]);
  return about[axis] / size;
}
static float share_of(uint64_t id) {
  return (float)(0.5 + 0.4 * random_number(19 * id));
}
static float first_pressure_of(uint64_t id) {
  return (float)(2000.0 * fabs(random_number(23 * id)));
}

/* Compression left for later: none for some. */
static float late_of(uint64_t id) {
  return (float)fmax(0.0, 0.4 * random_number(29 * id));
}

static hc_prediction prediction_of(setting *s, hc_wall_rule walls, bool shepard) {
  s->sweep.walls_add = walls;
  s->sweep.reach = REACH;
  return (hc_prediction){.shepard = shepard, .stiffness = STIFFNESS, .dt = DT, .weights = weights};
}

static void make_setting(setting *s) {
  make_cloud(s, FLUID, WALL);
  for (int k = 0; k <= HC_WALL_WEIGHTS; k++) weights[k] = 0.6f * (1.0f - (float)k / HC_WALL_WEIGHTS);
}

/* Every value as before the first prediction; walls with a pressure of their own start at 0. */
static void reset(setting *s, hc_wall_rule walls) {
  set_values(s);
  for (int32_t i = 0; i < FLUID; i++) s->fluid.pressure[i] = first_pressure_of(s->fluid.id[i]);
  for (int32_t i = 0; i < FLUID; i++) s->fluid.late_compression[i] = late_of(s->fluid.id[i]);
  for (int32_t b = 0; b < WALL; b++) {
    const uint64_t id = s->boundary.id[b];
    for (int axis = 0; axis < 3; axis++) s->boundary.facing[b].v[axis] = (float)normal_of(id, axis);
    s->boundary.boundary_share[b] = share_of(id);
    s->boundary.pressure[b] = 0.0f;
    s->boundary.late_compression[b] = late_of(id);
    if (walls == HC_WALLS_PRESSURE) s->boundary.place[b].scalar = 0.0f;
  }
}

/* ---- the plain reference ---- */

static double wall_share(const setting *s, int32_t i, hc_wall_rule walls) {
  double share = 0, weight = 0, height = 0;
  for (int32_t b = 0; b < WALL; b++) {
    const vec x = separation(s, &s->fluid, i, &s->boundary, b);
    const double r = norm(x);
    if (r >= H) continue;
    if (walls == HC_WALLS_MIRRORED) share += boundary_volume_of(s->boundary.id[b]) * kernel(r);
    if (walls == HC_WALLS_PRESSURE) share += VOLUME * kernel(r);
    double over = 0;
    for (int axis = 0; axis < 3; axis++) over += x.x[axis] / H * normal_of(s->boundary.id[b], axis);
    if (over <= 0) continue;
    weight += 1 - r / H;
    height += (1 - r / H) * over;
  }
  if (walls == HC_WALLS_DISTANCE && weight > 0) share = 0.6 * fmin(1, fmax(0, 1 - fmax(0, height / weight)));
  return share;
}

static double raw_density(const setting *s, int32_t i, hc_wall_rule walls) {
  double sum = wall_share(s, i, walls);
  for (int32_t j = 0; j < FLUID; j++) sum += VOLUME * kernel(norm(separation(s, &s->fluid, i, &s->fluid, j)));
  return sum;
}

/* No more can be left than there is. */
static double late_after(double late, double relative) {
  return fmin(late, fmax(0, relative - 1));
}

static double next_pressure(double pressure, double relative, double late) {
  return fmax(0, pressure + REST_DENSITY * STIFFNESS * (relative - 1 - late_after(late, relative)));
}

static void check_densities(const setting *s, const double *relative, const hc_error_total *total) {
  double sum = 0, most = 0;
  for (int32_t i = 0; i < FLUID; i++) {
    const double error = fmax(0, relative[i] - 1);
    const double late = late_of(s->fluid.id[i]);
    const double pressure = next_pressure(first_pressure_of(s->fluid.id[i]), relative[i], late);
    ck_assert(fabs(s->fluid.late_compression[i] - late_after(late, relative[i])) <=
              TOLERANCE * (1 + relative[i]));
    const double room = TOLERANCE * REST_DENSITY * STIFFNESS * (1 + relative[i]);
    sum += error;
    most = fmax(most, error);
    ck_assert(fabs(s->fluid.density[i] / REST_DENSITY - relative[i]) <= TOLERANCE * relative[i]);
    ck_assert(fabs(s->fluid.pressure[i] - pressure) <= room);
    const double scale = s->sweep.walls_add == HC_WALLS_MIRRORED ? 1 : relative[i] * relative[i];
    ck_assert(fabs(s->fluid.place[i].scalar * REST_DENSITY * scale - pressure) <= 4 * room);
  }
  hc_sum exact = hc_error_sum(total);
  ck_assert(fabs(hc_sum_value(&exact) - sum) <= 1e-4 * sum);
  ck_assert(fabs(total->max - most) <= TOLERANCE * (1 + most));
}

START_TEST(densities_and_pressures) {
  setting s;
  make_setting(&s);
  double raw[FLUID], corrected[FLUID];
  for (int walls = 0; walls < RULES; walls++) {
    for (int32_t i = 0; i < FLUID; i++) raw[i] = raw_density(&s, i, (hc_wall_rule)walls);
    for (int32_t i = 0; i < FLUID; i++) {
      double volumes = wall_share(&s, i, (hc_wall_rule)walls);
      for (int32_t j = 0; j < FLUID; j++)
        volumes += VOLUME / raw[j] * kernel(norm(separation(&s, &s.fluid, i, &s.fluid, j)));
      corrected[i] = raw[i] / volumes;
    }
    for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
      const hc_sweeps *sweeps = hc_sweeps_of((hc_isa)isa);
      for (int shepard = 0; shepard < 2; shepard++) {
        const hc_prediction prediction = prediction_of(&s, (hc_wall_rule)walls, shepard);
        hc_error_total total = {0};
        reset(&s, (hc_wall_rule)walls);
        sweeps->predicted_density(&s.sweep, &prediction, hc_select_range(0, 123), &total);
        sweeps->predicted_density(&s.sweep, &prediction, hc_select_range(123, FLUID), &total);
        if (shepard) sweeps->corrected_density(&s.sweep, &prediction, hc_select_range(0, FLUID), &total);
        check_densities(&s, shepard ? corrected : raw, &total);
      }
    }
  }
  setting_free(&s);
}
END_TEST

START_TEST(densities_of_walls) {
  setting s;
  make_setting(&s);
  const hc_prediction prediction = prediction_of(&s, HC_WALLS_PRESSURE, false);
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
    reset(&s, HC_WALLS_PRESSURE);
    hc_sweeps_of((hc_isa)isa)
        ->boundary_density(&s.sweep, &prediction, &s.boundary, &s.wetted, hc_select_range(0, WALL));
    int pushing = 0;
    for (int32_t b = 0; b < WALL; b++) {
      double relative = 0;
      for (int32_t j = 0; j < FLUID; j++)
        relative += VOLUME * kernel(norm(separation(&s, &s.boundary, b, &s.fluid, j)));
      const bool wet = hc_list_count(&s.wetted, b) > 0;
      relative += share_of(s.boundary.id[b]);
      const double late = late_of(s.boundary.id[b]);
      const double pressure = wet ? next_pressure(0, relative, late) : 0;
      ck_assert(fabs(s.boundary.late_compression[b] - (wet ? late_after(late, relative) : late)) <=
                TOLERANCE * (1 + relative));
      const double room = TOLERANCE * REST_DENSITY * STIFFNESS * (1 + relative);
      ck_assert(fabs(s.boundary.pressure[b] - pressure) <= room);
      ck_assert(fabs(s.boundary.place[b].scalar * REST_DENSITY * relative * relative - pressure) <= 4 * room);
      pushing += pressure > 0;
    }
    ck_assert_int_gt(pushing, WALL / 20);
    ck_assert_int_lt(pushing, WALL);
  }
  setting_free(&s);
}
END_TEST

/* A share of the compression beyond what is left already; pressures stay. */
START_TEST(compression_left_for_later) {
  setting s;
  make_setting(&s);
  const float share = 0.75f;
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
    hc_prediction prediction = prediction_of(&s, HC_WALLS_PRESSURE, false);
    prediction.stiffness = 0.0f;
    prediction.leaves = share;
    hc_error_total total = {0};
    reset(&s, HC_WALLS_PRESSURE);
    hc_sweeps_of((hc_isa)isa)->predicted_density(&s.sweep, &prediction, hc_select_range(0, FLUID), &total);
    int more = 0;
    for (int32_t i = 0; i < FLUID; i++) {
      const double late = late_of(s.fluid.id[i]), relative = raw_density(&s, i, HC_WALLS_PRESSURE);
      const double beyond = fmax(0, relative - 1 - late);
      ck_assert(fabs(s.fluid.late_compression[i] - late - share * beyond) <= TOLERANCE * (1 + relative));
      ck_assert(s.fluid.pressure[i] == first_pressure_of(s.fluid.id[i]));
      more += beyond > 0;
    }
    ck_assert_int_gt(more, FLUID / 20);
    ck_assert_int_lt(more, FLUID);
  }
  setting_free(&s);
}
END_TEST

/* Puts pressures into the scalars and pushes. */
static void push(setting *s, hc_wall_rule walls, hc_isa isa) {
  const hc_prediction prediction = prediction_of(s, walls, false);
  hc_error_total total = {0};
  reset(s, walls);
  hc_sweeps_of(isa)->wall_sums(&s->sweep, hc_select_range(0, FLUID));
  hc_sweeps_of(isa)->predicted_density(&s->sweep, &prediction, hc_select_range(0, FLUID), &total);
  for (int32_t i = 0; i < FLUID; i++) s->fluid.place[i].scalar = kappa_of(s->fluid.id[i]);
  if (walls == HC_WALLS_PRESSURE)
    for (int32_t b = 0; b < WALL; b++) s->boundary.place[b].scalar = kappa_of(s->boundary.id[b] + 9999);
  hc_sweeps_of(isa)->push(&s->sweep, &prediction, hc_select_range(0, 77));
  hc_sweeps_of(isa)->push(&s->sweep, &prediction, hc_select_range(77, FLUID));
}

START_TEST(pushes) {
  setting s;
  make_setting(&s);
  for (int walls = 0; walls < RULES; walls++) {
    for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
      push(&s, (hc_wall_rule)walls, (hc_isa)isa);
      for (int32_t i = 0; i < FLUID; i++) {
        vec sum = {{0, 0, 0}};
        double scale = 0;
        const double own = kappa_of(s.fluid.id[i]);
        for (int32_t j = 0; j < FLUID; j++) {
          const vec g = gradient(separation(&s, &s.fluid, i, &s.fluid, j));
          const double factor = VOLUME * (own + kappa_of(s.fluid.id[j]));
          add(&sum, -DT * factor, g);
          scale += DT * VOLUME * (fabs(own) + fabs(kappa_of(s.fluid.id[j]))) * norm(g);
        }
        for (int32_t b = 0; b < WALL; b++) {
          const vec g = gradient(separation(&s, &s.fluid, i, &s.boundary, b));
          double factor = 0;
          if (walls == HC_WALLS_MIRRORED) factor = own * boundary_volume_of(s.boundary.id[b]);
          if (walls == HC_WALLS_PRESSURE) factor = VOLUME * (own + kappa_of(s.boundary.id[b] + 9999));
          add(&sum, -DT * factor, g);
          scale += DT * (fabs(factor) + VOLUME * 1e-6) * norm(g);
        }
        for (int axis = 0; axis < 3; axis++)
          ck_assert(fabs(s.fluid.push[3 * i + axis] - sum.x[axis]) <= TOLERANCE * scale + 1e-20);
      }
    }
  }
  setting_free(&s);
}
END_TEST

START_TEST(contacts) {
  setting s;
  make_setting(&s);
  static hc_record found[FLUID];
  prediction_of(&s, HC_WALLS_PRESSURE, false);
  for (int rule = 0; rule < 2; rule++) {
    for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
      reset(&s, HC_WALLS_PRESSURE);
      hc_sweeps_of((hc_isa)isa)->contacts(&s.sweep, (hc_contact_rule)rule, found, hc_select_range(0, FLUID));
      int touching = 0;
      for (int32_t i = 0; i < FLUID; i++) {
        double weights_sum = 0, depth = 0;
        vec n = {{0, 0, 0}};
        for (int32_t b = 0; b < WALL; b++) {
          const vec x = separation(&s, &s.fluid, i, &s.boundary, b);
          const double r = norm(x), reach = rule == HC_CONTACT_DISTANCE ? H : REACH;
          const double w = fmax(0, 1 - r / reach);
          const vec normal = {{normal_of(s.boundary.id[b], 0), normal_of(s.boundary.id[b], 1),
                               normal_of(s.boundary.id[b], 2)}};
          if (r >= H || (rule == HC_CONTACT_DISTANCE && dot(x, normal) <= 0)) continue;
          add(&n, w, normal);
          weights_sum += w;
          depth += rule == HC_CONTACT_DISTANCE ? w * (REACH - dot(x, normal)) : w * (REACH - r);
        }
        if (weights_sum > 0) depth /= weights_sum;
        if (weights_sum > 0 && weights_sum < 1e-4) continue; /* on the edge */
        ck_assert(fabs(found[i].scalar - depth) <= 1e-4 * REACH);
        for (int axis = 0; axis < 3; axis++)
          ck_assert(fabs(found[i].v[axis] - n.x[axis]) <= 2 * TOLERANCE * (1 + weights_sum));
        touching += weights_sum > 0;
      }
      ck_assert_int_gt(touching, FLUID / 20);
      ck_assert_int_lt(touching, FLUID);
    }
  }
  setting_free(&s);
}
END_TEST

START_TEST(velocities_of_walls) {
  setting s;
  make_setting(&s);
  static hc_record found[FLUID];
  prediction_of(&s, HC_WALLS_PRESSURE, false);
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
    reset(&s, HC_WALLS_PRESSURE);
    hc_sweeps_of((hc_isa)isa)->wall_velocities(&s.sweep, found, hc_select_range(0, FLUID));
    for (int32_t i = 0; i < FLUID; i++) {
      double weight = 0;
      vec sum = {{0, 0, 0}};
      for (int32_t b = 0; b < WALL; b++) {
        const double w = fmax(0, 1 - norm(separation(&s, &s.fluid, i, &s.boundary, b)) / REACH);
        const uint64_t id = s.boundary.id[b];
        add(&sum, w, (vec){{wall_velocity_of(id, 0), wall_velocity_of(id, 1), wall_velocity_of(id, 2)}});
        weight += w;
      }
      if (weight > 0 && weight < 1e-3) continue; /* on the edge */
      for (int axis = 0; axis < 3; axis++)
        ck_assert(fabs(found[i].v[axis] - (weight > 0 ? sum.x[axis] / weight : 0)) <= 1e-3);
    }
  }
  setting_free(&s);
}
END_TEST

#if defined(__x86_64__)
START_TEST(vector_lengths_give_the_same_bits) {
  if (hc_isa_best() < HC_ISA_AVX512) return;
  setting s;
  make_setting(&s);
  for (int walls = 0; walls < RULES; walls++) {
    static float short_push[3 * FLUID], density[FLUID];
    push(&s, (hc_wall_rule)walls, HC_ISA_AVX2);
    memcpy(short_push, s.fluid.push, sizeof short_push);
    memcpy(density, s.fluid.density, sizeof density);
    push(&s, (hc_wall_rule)walls, HC_ISA_AVX512);
    ck_assert_mem_eq(short_push, s.fluid.push, sizeof short_push);
    ck_assert_mem_eq(density, s.fluid.density, sizeof density);
  }
  setting_free(&s);
}
END_TEST
#endif

/* What the walls' weights and the stiffness rest on. */
START_TEST(half_space_completes_the_lattice) {
  for (double ratio = 0.3; ratio < 0.6; ratio += 0.1) {
    const double whole = hc_setup_rest_lattice_sum(ratio);
    const double below = hc_setup_half_space(ratio, ratio), layer = hc_setup_half_space(ratio, 0) - below;
    ck_assert(fabs((2 * below + layer) / whole - 1) < 0.03); /* spread-out layers against points */
  }
  ck_assert(hc_setup_half_space(0.5, 1.0) == 0);
}
END_TEST

START_TEST(gradient_square_of_the_lattice) {
  /* 6 neighbours at half the support radius, 12 at 0.707, 8 at 0.866 */
  const double sigma = 8 / PI;
  double sum = 0;
  const int count[3] = {6, 12, 8};
  for (int shell = 0; shell < 3; shell++) {
    const double q = 0.5 * sqrt(shell + 1.0), gradient_size = 6 * sigma * (1 - q) * (1 - q);
    sum += count[shell] * gradient_size * gradient_size;
  }
  ck_assert(fabs(hc_setup_rest_lattice_gradient(0.5) / sum - 1) < 1e-12);
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("prediction");
  TCase *const cases = tcase_create("pairs");
  tcase_set_timeout(cases, 60);
  tcase_add_test(cases, densities_and_pressures);
  tcase_add_test(cases, densities_of_walls);
  tcase_add_test(cases, compression_left_for_later);
  tcase_add_test(cases, pushes);
  tcase_add_test(cases, contacts);
  tcase_add_test(cases, velocities_of_walls);
#if defined(__x86_64__)
  tcase_add_test(cases, vector_lengths_give_the_same_bits);
#endif
  tcase_add_test(cases, half_space_completes_the_lattice);
  tcase_add_test(cases, gradient_square_of_the_lattice);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
