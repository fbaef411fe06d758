/* Multipliers on trial: errors against those of the error sweep, sums against plain ones, the next trial
 * against its formulas, for every instruction set, and of parts against all. */
#include "cloud.h"
#include "sph/error_rule.h"

#include <check.h>

enum { FLUID = 500, WALL = 150, SUMS = sizeof(hc_trial_sums) / sizeof(uint64_t) };

static const float DT = 0.002f;
static const double UNIT = 1e-12; /* m2 */

/* A trial of multipliers around what steps of a few percent leave, some at the bound. */
typedef struct trial_of {
  float multiplier[FLUID], base[FLUID], expected[FLUID];
  hc_trial trial;
} trial_of;

static void make_trial(trial_of *t, const setting *s, bool negative) {
  for (int32_t i = 0; i < FLUID; i++) {
    const uint64_t id = s->fluid.id[i];
    t->multiplier[i] = negative ? kappa_of(id) : fmaxf(0.0f, kappa_of(id));
    t->base[i] = negative ? kappa_of(id + 7) : fmaxf(0.0f, kappa_of(id + 7));
    t->expected[i] = 1e6f * kappa_of(id + 13);
  }
  t->trial = (hc_trial){.dt = DT,
                        .multiplier = t->multiplier,
                        .base = t->base,
                        .expected = t->expected,
                        .least = negative ? -INFINITY : 0.0f,
                        .unit = UNIT,
                        .relaxation = 0.75f};
}

static bool is_here(int isa) {
  return isa == HC_ISA_PORTABLE || isa <= (int)hc_isa_best();
}

/* What the error sweep makes of the same velocities: alpha e, and its total. */
static hc_error_total plain_errors(setting *s, hc_isa isa, bool negative, float *kappa) {
  const hc_error_rule rule = {.of_density = 1.0f, .of_rate = DT, .signed_error = true, .relaxation = 1.0f};
  hc_error_rule clamped = rule;
  clamped.signed_error = negative;
  hc_error_total total;
  memset(&total, 0, sizeof total);
  hc_sweeps_of(isa)->error(&s->sweep, &clamped, hc_select_all(&s->fluid), &total);
  hc_error_total unused;
  memset(&unused, 0, sizeof unused);
  hc_sweeps_of(isa)->error(&s->sweep, &rule, hc_select_all(&s->fluid), &unused);
  for (int32_t i = 0; i < FLUID; i++) kappa[i] = s->fluid.place[i].scalar;
  return total;
}

static void check_sums(const setting *s, const trial_of *t, const hc_trial_sums *sums) {
  double plain[SUMS] = {0}, size[SUMS] = {0};
  for (int32_t i = 0; i < FLUID; i++) {
    const double e = s->fluid.place[i].scalar, eb = t->expected[i],
                 step = (double)(t->multiplier[i] - t->base[i]);
    const bool is_free = t->multiplier[i] > t->trial.least || e > 0;
    const double alpha = is_free ? s->fluid.alpha[i] : 0;
    const double term[SUMS] = {step * eb, step * (eb - e), alpha * eb * eb, alpha * eb * e, alpha * e * e};
    for (int k = 0; k < SUMS; k++) {
      plain[k] += term[k];
      size[k] += fabs(term[k]);
    }
  }
  const uint64_t *const found = &sums->step_expected;
  for (int k = 0; k < SUMS; k++) {
    const double value = (double)(int64_t)found[k] * UNIT;
    ck_assert_msg(fabs(value - plain[k]) <= 1e-5 * size[k] + FLUID * UNIT, "sum %d: %g, expected %g", k,
                  value, plain[k]);
    ck_assert(size[k] > 1000 * UNIT);
  }
}

START_TEST(errors_and_sums) {
  static float kappa[FLUID];
  setting s;
  make_cloud(&s, FLUID, WALL);
  for (int isa = HC_ISA_PORTABLE; isa <= HC_ISA_AVX512; isa++) {
    for (int negative = 0; negative < 2 && is_here(isa); negative++) {
      static trial_of t;
      set_values(&s);
      make_trial(&t, &s, negative);
      hc_sweeps_of((hc_isa)isa)->density(&s.sweep, hc_select_all(&s.fluid));
      const hc_error_total plain = plain_errors(&s, (hc_isa)isa, negative, kappa);
      static const int32_t cuts[] = {0, 1, 64, 65, 130, 333, FLUID};
      hc_trial_sums sums = {0};
      hc_error_total total;
      memset(&total, 0, sizeof total);
      for (int k = 0; k < 6; k++)
        hc_sweeps_of((hc_isa)isa)
            ->trial_error(&s.sweep, &t.trial, hc_select_range(cuts[k], cuts[k + 1]), &total, &sums);
      for (int32_t i = 0; i < FLUID; i++) ck_assert(s.fluid.alpha[i] * s.fluid.place[i].scalar == kappa[i]);
      ck_assert(total.sum == plain.sum && total.max == plain.max && total.sum > 0);
      check_sums(&s, &t, &sums);
      hc_trial_sums whole = {0};
      hc_sweeps_of((hc_isa)isa)->trial_error(&s.sweep, &t.trial, hc_select_all(&s.fluid), &total, &whole);
      ck_assert(memcmp(&whole, &sums, sizeof sums) == 0);
    }
  }
  setting_free(&s);
}
END_TEST

/* Errors beyond what sums take at once, and beyond all bounds. */
START_TEST(large_errors) {
  static const float speeds[] = {1e9f, 3e13f, 1e30f, NAN};
  static float kappa[FLUID];
  setting s;
  make_cloud(&s, FLUID, 0);
  for (int isa = HC_ISA_PORTABLE; isa <= HC_ISA_AVX512; isa++) {
    for (int k = 0; k < 4 && is_here(isa); k++) {
      static trial_of t;
      set_values(&s);
      make_trial(&t, &s, false);
      hc_sweeps_of((hc_isa)isa)->density(&s.sweep, hc_select_all(&s.fluid));
      s.fluid.motion[77].v[1] = speeds[k];
      const hc_error_total plain = plain_errors(&s, (hc_isa)isa, false, kappa);
      hc_trial_sums sums = {0};
      hc_error_total total;
      memset(&total, 0, sizeof total);
      hc_sweeps_of((hc_isa)isa)->trial_error(&s.sweep, &t.trial, hc_select_all(&s.fluid), &total, &sums);
      ck_assert(total.not_finite == plain.not_finite && total.not_finite == (k > 0));
      ck_assert(total.sum == plain.sum && total.max == plain.max);
    }
  }
  setting_free(&s);
}
END_TEST

START_TEST(next_trials) {
  static const hc_turn turns[] = {{1.0f, 0.6f, 0.0f}, {0.4f, 0.3f, 0.8f}, {2.5f, 1.0f, 0.2f}};
  setting s;
  make_cloud(&s, FLUID, WALL);
  for (int isa = HC_ISA_PORTABLE; isa <= HC_ISA_AVX512; isa++) {
    for (int k = 0; k < 6 && is_here(isa); k++) {
      const hc_turn *const turn = &turns[k / 2];
      static trial_of t, before;
      set_values(&s);
      make_trial(&t, &s, k % 2 == 1);
      hc_sweeps_of((hc_isa)isa)->density(&s.sweep, hc_select_all(&s.fluid));
      hc_error_total total;
      memset(&total, 0, sizeof total);
      hc_sweeps_of((hc_isa)isa)->trial_error(&s.sweep, &t.trial, hc_select_all(&s.fluid), &total, NULL);
      static float found[FLUID];
      for (int32_t i = 0; i < FLUID; i++) found[i] = s.fluid.place[i].scalar;
      before = t;
      hc_sweeps_of((hc_isa)isa)->next_trial(&s.sweep, &t.trial, turn, hc_select_range(0, 100));
      hc_sweeps_of((hc_isa)isa)->next_trial(&s.sweep, &t.trial, turn, hc_select_range(100, FLUID));
      for (int32_t i = 0; i < FLUID; i++) {
        const double least = (double)t.trial.least, step = (double)(before.multiplier[i] - before.base[i]);
        const double at = fmax(least, before.base[i] + turn->reach * step);
        const double e = before.expected[i] + turn->reach * ((double)found[i] - before.expected[i]);
        const double way = at > least || e > 0 ? 0.75 * s.fluid.alpha[i] * e + turn->turn * step : 0;
        const double to = fmax(least, at + turn->length * way);
        const double scale = fabs(at) + fabs(to) + fabs(step) + fabs((double)s.fluid.alpha[i] * e) + 1e-12;
        ck_assert(fabs(t.base[i] - at) <= TOLERANCE * scale);
        ck_assert(fabs(t.expected[i] - e) <= TOLERANCE * (fabs(e) + fabsf(before.expected[i])));
        ck_assert_msg(fabs(s.fluid.place[i].scalar - (to - before.multiplier[i])) <= TOLERANCE * scale,
                      "particle %d: %g, expected %g", i, s.fluid.place[i].scalar, to - before.multiplier[i]);
      }
    }
  }
  setting_free(&s);
}
END_TEST

int main(void) {
  Suite *suite = suite_create("trial");
  TCase *all = tcase_create("all");
  tcase_set_timeout(all, 60);
  tcase_add_test(all, errors_and_sums);
  tcase_add_test(all, large_errors);
  tcase_add_test(all, next_trials);
  suite_add_tcase(suite, all);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_ENV);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed == 0 ? 0 : 1;
}
