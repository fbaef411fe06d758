/* The density solve along conjugate directions: multipliers y >= 0 that leave no compression, so that e = D -
 * 1 + dt dD/dt <= 0, and press only where e = 0: a linear complementarity problem, whose matrix is symmetric
 * and whose diagonal is about 1/alpha. Not in the paper.
 *
 * Start: with all of what the steps before have pressed, low-passed (below), everywhere.
 *
 * Directions: p = alpha e_b + turn s, where s = y - K is the last step along one, from K with the errors e_b
 * to the trial y, and turn after Polak and Ribiere 1969, over the particles that are free to follow: those
 * that are pressed or too dense. Multipliers are projected back to where they may be. The search along a
 * direction comes one sweep late: with the errors e found at y, K + reach s is where those of the line are
 * least; the next trial starts from there, by a length that follows what reach has shown. So an iteration is
 * one correction and one prediction, as the paper's is, and one reduction.
 *
 * Low-pass: with all of the last multipliers as the start water at rest is noisy. A mode of which the
 * iterations take the share g of what is left, density and rate, then is a controller without damping. The
 * start follows what was pressed by beta <= g/(1 - g) instead, and g is seen from the errors at the start and
 * at the end of the solve. */
#include "base/clamp.h"
#include "iterations.h"
#include "solver.h"

#include <math.h>
#include <string.h>

static const float FIRST_LENGTH = 0.6f; /* of a diagonal step */
static const double REACH[2] = {0.3, 3.0}, LENGTH[2] = {0.2, 1.0};

typedef struct search {
  const hc_solve *solve;
  hc_trial trial;
  hc_trial_sums sums;
  double finest; /* m2: a product's unit where the largest error is 1 */
} search;

/* Room of this file: K, e_b, and the multipliers at the start. Forces are done with it. */
static float *room_of(hc_world *world, int number) {
  return (float *)hc_particles_scratch(world->fluid, 3 * sizeof(float)) +
         (size_t)number * (size_t)world->fluid->own;
}

/* Corrects velocities by the multipliers in place.scalar of own particles, bodies' too; those of the border
 * are final, of the interior too. False if bodies are pushed beyond all measure. */
static bool correct(const hc_solve *solve) {
  hc_world *const world = solve->world;
  const hc_selection interior = hc_select_interior(world->listed, world->fluid),
                     border = hc_select_border(world->listed, world->fluid);
  hc_tally pushes = {.count = 0};
  hc_yield_note(solve->yield, (double)solve->weight, &pushes);
  hc_tally_reduce(world->comm, &pushes);
  world->sweeps->pressure(&world->sweep, solve->weight, solve->multiplier, interior);
  hc_hold_still(world, world->fluid->border, world->fluid->own);
  hc_halo_end(world->halo);
  world->sweeps->pressure(&world->sweep, solve->weight, solve->multiplier, border);
  hc_hold_still(world, 0, world->fluid->border);
  hc_halo_begin(world->halo, HC_WHOLE(motion));
  hc_yield_act(solve->yield);
  return !solve->yield->impulses.broken;
}

/* Finds the errors with these velocities, whose refresh is under way; products too behind a step. */
static void predict(search *s, bool products, hc_solved *result) {
  hc_world *const world = s->solve->world;
  hc_error_total total;
  hc_tally tally = {.count = 0};
  memset(&total, 0, sizeof total);
  memset(&s->sums, 0, sizeof s->sums);
  s->trial.unit = s->finest * fmax(result->max, s->solve->threshold) * fmax(result->max, s->solve->threshold);
  hc_trial_sums *const sums = products ? &s->sums : NULL;
  world->sweeps->trial_error(&world->sweep, &s->trial, hc_select_interior(world->listed, world->fluid),
                             &total, sums);
  hc_halo_end(world->halo);
  world->sweeps->trial_error(&world->sweep, &s->trial, hc_select_border(world->listed, world->fluid), &total,
                             sums);
  if (products) hc_tally_sum_i64(&tally, (int64_t *)&s->sums, sizeof s->sums / sizeof(int64_t));
  result->average = hc_reduce_errors(world->comm, &total, &tally, &result->max) /
                    (world->fluid_total > 0 ? (double)world->fluid_total : 1.0);
  result->broken = result->broken || !isfinite(result->average);
}

/* Starts from the last step's multipliers. */
static bool start(search *s) {
  const hc_solve *const solve = s->solve;
  hc_world *const world = solve->world;
  hc_record *const place = world->fluid->place;
  float *const from = room_of(world, 2);
  for (int32_t i = 0; i < world->fluid->own; i++) {
    place[i].scalar = from[i] = solve->warm * solve->multiplier[i];
    solve->multiplier[i] = 0.0f;
  }
  hc_halo_begin(world->halo, HC_SCALAR(place));
  return correct(solve);
}

/* Goes to the next trial. */
static bool step(search *s, const hc_turn *turn) {
  hc_world *const world = s->solve->world;
  world->sweeps->next_trial(&world->sweep, &s->trial, turn, hc_select_border(world->listed, world->fluid));
  hc_halo_begin(world->halo, HC_SCALAR(place));
  world->sweeps->next_trial(&world->sweep, &s->trial, turn, hc_select_interior(world->listed, world->fluid));
  return correct(s->solve);
}

/* Where the errors on the line are least, and the direction from there. */
static hc_turn next_turn(const hc_trial_sums *sums, double length) {
  const double found = (double)(int64_t)sums->step_found, oo = (double)(int64_t)sums->expected_expected,
               on = (double)(int64_t)sums->expected_found, nn = (double)(int64_t)sums->found_found;
  const double reach =
      found > 0.0 ? hc_clamp((double)(int64_t)sums->step_expected / found, REACH[0], REACH[1]) : 1.0;
  const double left = 1.0 - reach, ro = left * oo + reach * on,
               rr = left * left * oo + 2.0 * reach * left * on + reach * reach * nn;
  const double turn = oo > 0.0 ? hc_clamp((rr - ro) / oo, 0.0, 1.0) : 0.0;
  return (hc_turn){.reach = (float)reach,
                   .length = (float)hc_clamp(reach * length, LENGTH[0], LENGTH[1]),
                   .turn = (float)(turn / length)};
}

/* The average is below the threshold; and single particles, which a long step along one direction may leave
 * behind where water meets water, are not far above it, or have had their chance. */
static bool is_enough(const hc_solve *solve, const hc_solved *result) {
  static const double SINGLE = 100.0; /* thresholds */
  static const int CHANCE = 12;       /* iterations */
  return result->average <= solve->threshold && result->iterations >= solve->min &&
         (result->max <= SINGLE * solve->threshold || result->iterations >= CHANCE);
}

hc_solved hc_solve_conjugate(const hc_solve *solve, double dt, double alpha) {
  static const double FINEST = 0x1p-30, SHARE = 0.05, LEAST = 0.02; /* of g/(1 - g); of what pressed */
  hc_world *const world = solve->world;
  search s = {.solve = solve,
              .trial = {.dt = (float)dt,
                        .multiplier = solve->multiplier,
                        .base = room_of(world, 0),
                        .expected = room_of(world, 1),
                        .least = solve->rule.signed_error ? -INFINITY : 0.0f,
                        .relaxation = solve->rule.relaxation},
              .finest = FINEST * alpha};
  hc_solved result = {.broken = !start(&s)};
  predict(&s, false, &result);
  const double before = result.average;
  hc_turn turn = {.reach = 1.0f, .length = FIRST_LENGTH, .turn = 0.0f};
  for (int32_t i = 0; i < world->fluid->own; i++)
    s.trial.base[i] = s.trial.expected[i] = 0.0f; /* K + (y - K) is y, e_b + (e - e_b) is e */
  while (!result.broken && !is_enough(solve, &result)) {
    result.capped = result.iterations >= solve->max && result.average > solve->threshold;
    if (result.iterations >= solve->max) break;
    result.broken = !step(&s, &turn);
    predict(&s, true, &result);
    result.iterations++;
    turn = next_turn(&s.sums, turn.length);
  }
  result.follow =
      result.average > 0.0 ? hc_clamp(SHARE * (before - result.average) / result.average, LEAST, 1.0) : 1.0;
  return result;
}

void hc_solve_remember(const hc_solve *solve, const hc_solved *solved) {
  const float *const from = room_of(solve->world, 2), follow = (float)solved->follow;
  for (int32_t i = 0; i < solve->world->fluid->own; i++)
    solve->multiplier[i] = from[i] + follow * (solve->multiplier[i] - from[i]);
}
