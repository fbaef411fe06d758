/* The sweeps of the weakly compressible solver against plain double-precision sums over all pairs, for every
 * instruction set, and of a part of the particles against all. */
#include "cloud.h"
#include "sph/error_rule.h"

#include <check.h>

enum { FLUID = 500, WALL = 200 };

static const hc_tait TAIT = {.stiffness = 20.0f, .negative = 0}, SIGNED = {.stiffness = 20.0f, .negative = 1};
static const float VISCOSITY = 0.3f, WEIGHT = 0.004f;

static const hc_isa isas[] = {HC_ISA_PORTABLE, HC_ISA_AVX2, HC_ISA_AVX512};

static bool runs_here(hc_isa isa) {
  return isa == HC_ISA_PORTABLE || isa <= hc_isa_best();
}

static double density_of(const setting *s, int32_t i) {
  double sum = 0;
  for (int32_t j = 0; j < FLUID; j++) sum += VOLUME * kernel(norm(separation(s, &s->fluid, i, &s->fluid, j)));
  for (int32_t b = 0; b < WALL; b++)
    sum += boundary_volume_of(s->boundary.id[b]) * kernel(norm(separation(s, &s->fluid, i, &s->boundary, b)));
  return sum;
}

START_TEST(densities_and_pressures) {
  setting s;
  make_cloud(&s, FLUID, WALL);
  for (size_t k = 0; k < sizeof isas / sizeof *isas; k++) {
    if (!runs_here(isas[k])) continue;
    for (int negative = 0; negative < 2; negative++) {
      const hc_tait *const tait = negative ? &SIGNED : &TAIT;
      hc_error_total total;
      memset(&total, 0, sizeof total);
      set_values(&s);
      hc_sweeps_of(isas[k])->weak_density(&s.sweep, tait, hc_select_all(&s.fluid), &total);
      double sum = 0;
      for (int32_t i = 0; i < FLUID; i++) {
        const double relative = density_of(&s, i), plain = TAIT.stiffness * (pow(relative, 7) - 1);
        const double pressure = negative ? plain : fmax(0, plain),
                     scale = TAIT.stiffness * pow(relative, 7) + TAIT.stiffness;
        ck_assert(fabs(s.fluid.density[i] / REST_DENSITY - relative) < TOLERANCE * relative);
        ck_assert(fabs(s.fluid.pressure[i] / REST_DENSITY - pressure) < 10 * TOLERANCE * scale);
        ck_assert(fabs(s.fluid.place[i].scalar - pressure / (relative * relative)) <
                  10 * TOLERANCE * scale / (relative * relative));
        sum += negative ? fabs(relative - 1) : fmax(0, relative - 1);
      }
      const hc_sum of_all = hc_error_sum(&total);
      ck_assert(fabs(hc_sum_value(&of_all) - sum) < 1e-4 * sum && sum > 10);
    }
  }
  setting_free(&s);
}
END_TEST

/* Force and rate of a particle, and the sums of their terms' magnitudes. */
typedef struct expected {
  vec force;
  double rate, force_scale, rate_scale;
} expected;

static expected expect(const setting *s, int32_t i) {
  expected e;
  memset(&e, 0, sizeof e);
  const double own = s->fluid.place[i].scalar;
  for (int32_t k = 0; k < FLUID + WALL; k++) {
    const bool wall = k >= FLUID;
    const int32_t j = wall ? k - FLUID : k;
    const vec x = separation(s, &s->fluid, i, wall ? &s->boundary : &s->fluid, j), g = gradient(x);
    const double r = norm(x), volume = wall ? boundary_volume_of(s->boundary.id[j]) : VOLUME;
    if (r == 0 || r >= H) continue;
    vec v;
    for (int axis = 0; axis < 3; axis++)
      v.x[axis] = velocity_of(s->fluid.id[i], axis) -
                  (wall ? wall_velocity_of(s->boundary.id[j], axis) : velocity_of(s->fluid.id[j], axis));
    const double push = wall ? own : own + s->fluid.place[j].scalar;
    const double viscous = VISCOSITY * fmin(0, dot(v, x)) / (r * r + 0.0025 * H * H);
    add(&e.force, WEIGHT * volume * (viscous - push), g);
    e.force_scale += WEIGHT * volume * (fabs(viscous) + push) * norm(g);
    e.rate += volume * dot(v, g);
    e.rate_scale += volume * norm(v) * norm(g);
  }
  return e;
}

static float *forces_of(setting *s, hc_isa isa, hc_selection selection, float *rates) {
  float *const change = hc_alloc_zero(3 * FLUID, sizeof *change);
  hc_error_total total;
  memset(&total, 0, sizeof total);
  set_values(s);
  s->sweep.walls_move = true;
  hc_sweeps_of(isa)->weak_density(&s->sweep, &TAIT, hc_select_all(&s->fluid), &total);
  hc_sweeps_of(isa)->weak_forces(&s->sweep, VISCOSITY, WEIGHT, change, rates, selection);
  return change;
}

START_TEST(forces_and_rates) {
  setting s;
  make_cloud(&s, FLUID, WALL);
  static float rates[FLUID];
  for (size_t k = 0; k < sizeof isas / sizeof *isas; k++) {
    if (!runs_here(isas[k])) continue;
    float *const change = forces_of(&s, isas[k], hc_select_all(&s.fluid), rates);
    for (int32_t i = 0; i < FLUID; i++) {
      const expected e = expect(&s, i);
      ck_assert(fabs((double)rates[i] - e.rate) <= 10 * TOLERANCE * e.rate_scale);
      for (int axis = 0; axis < 3; axis++)
        ck_assert(fabs((double)change[3 * i + axis] - e.force.x[axis]) <= 10 * TOLERANCE * e.force_scale);
    }
    float *const without = forces_of(&s, isas[k], hc_select_all(&s.fluid), NULL);
    ck_assert_mem_eq(change, without, 3 * FLUID * sizeof *change);
    hc_free(change);
    hc_free(without);
  }
  setting_free(&s);
}
END_TEST

/* Every third particle, by the list of all. */
START_TEST(a_part_is_as_all) {
  setting s;
  make_cloud(&s, FLUID, WALL);
  int32_t index[FLUID], count = 0;
  for (int32_t i = 0; i < FLUID; i += 3) index[count++] = i;
  for (size_t k = 0; k < sizeof isas / sizeof *isas; k++) {
    if (!runs_here(isas[k])) continue;
    float *const all = forces_of(&s, isas[k], hc_select_all(&s.fluid), NULL),
                 *const some = forces_of(&s, isas[k], (hc_selection){index, 0, count, true}, NULL);
    for (int32_t i = 0; i < FLUID; i++)
      for (int axis = 0; axis < 3; axis++)
        ck_assert(some[3 * i + axis] == (i % 3 == 0 ? all[3 * i + axis] : 0.0f));
    hc_free(all);
    hc_free(some);
  }
  setting_free(&s);
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("weak");
  TCase *const cases = tcase_create("pairs");
  tcase_set_timeout(cases, 60);
  tcase_add_test(cases, densities_and_pressures);
  tcase_add_test(cases, forces_and_rates);
  tcase_add_test(cases, a_part_is_as_all);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
