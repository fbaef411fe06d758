/* Multipliers on trial: what the error sweep adds up of a block, and the pass from one trial to the next. */
#ifndef HC_TRIAL_RULE_H
#define HC_TRIAL_RULE_H

#include "error_rule.h"
#include "pairs.h"

HC_INLINE void expect_range(hc_selection selection) {
  HC_CHECK(!selection.index, "trials are of particles that stand one behind the other");
}

/* A product in units; beyond 2^45 of them it counts as so many. */
HC_INLINE uint64_t product(float a, float b, double units) {
  static const double MOST = 0x1p45;
  const double value = (double)a * (double)b * units;
  const double below = value < MOST ? value : MOST;
  return hc_to_integer(below > -MOST ? below : -MOST);
}

HC_INLINE void note_products(const hc_sweep *sweep, const hc_trial *trial, const float *found, int32_t first,
                             int32_t count, hc_trial_sums *sums) {
  const double units = 1.0 / trial->unit;
  const float *const alphas = sweep->fluid->alpha;
  float alpha[BLOCK], step[BLOCK], expected[BLOCK];
  for (int32_t k = 0; k < count; k++) {
    const int32_t i = first + k;
    const float y = trial->multiplier[i];
    expected[k] = trial->expected[i];
    step[k] = y - trial->base[i];
    alpha[k] = y > trial->least || found[k] > 0.0f ? alphas[i] : 0.0f;
  }
  hc_trial_sums block = {0};
  for (int32_t k = 0; k < count; k++) {
    const float of_expected = alpha[k] * expected[k];
    block.step_expected += product(step[k], expected[k], units);
    block.step_found += product(step[k], expected[k] - found[k], units);
    block.expected_expected += product(of_expected, expected[k], units);
    block.expected_found += product(of_expected, found[k], units);
    block.found_found += product(alpha[k] * found[k], found[k], units);
  }
  sums->step_expected += block.step_expected;
  sums->step_found += block.step_found;
  sums->expected_expected += block.expected_expected;
  sums->expected_found += block.expected_found;
  sums->found_found += block.found_found;
}

static void next_trial(const hc_sweep *sweep, const hc_trial *trial, const hc_turn *turn,
                       hc_selection selection) {
  expect_range(selection);
  const float *const restrict alpha = sweep->fluid->alpha, *const restrict multiplier = trial->multiplier;
  float *const restrict base = trial->base, *const restrict expected = trial->expected;
  hc_record *const restrict place = sweep->fluid->place;
  const float least = trial->least, relaxation = trial->relaxation, reach = turn->reach,
              length = turn->length, again = turn->turn;
  for (int32_t i = selection.begin; i < selection.end; i++) {
    const float y = multiplier[i], step = y - base[i];
    const float from = base[i] + reach * step, at = from > least ? from : least;
    const float error = expected[i] + reach * (place[i].scalar - expected[i]);
    const float direction = relaxation * alpha[i] * error + again * step;
    const float to = at + (at > least || error > 0.0f ? length * direction : 0.0f);
    base[i] = at;
    expected[i] = error;
    place[i].scalar = (to > least ? to : least) - y;
  }
}

#endif
