#include "iterations.h"
#include "solver.h"
#include "sph/error_rule.h"

#include <math.h>
#include <string.h>

/* Starts the multiplier of selected particles from the last step's where the error says so; without a warm
 * start by the errors, as iterations go on. */
static void warm_start(const hc_solve *solve, hc_selection selection) {
  hc_record *place = solve->world->fluid->place;
  if (solve->warm == 0.0f) {
    for (int32_t row = selection.begin; row < selection.end; row++)
      solve->multiplier[hc_selected(selection, row)] = 0.0f;
    return;
  }
  const bool always = solve->rule.signed_error;
  for (int32_t row = selection.begin; row < selection.end; row++) {
    const int32_t i = hc_selected(selection, row);
    place[i].scalar = always || place[i].scalar > 0.0f ? solve->warm * solve->multiplier[i] : 0.0f;
    solve->multiplier[i] = 0.0f;
  }
}

/* The first prediction of a solve takes over the warm start's multipliers. */
static void predict_part(const hc_solve *solve, bool first, hc_selection part, hc_error_total *total) {
  hc_world *world = solve->world;
  if (first && solve->rates_known)
    world->sweeps->error_from_rate(&world->sweep, &solve->rule, part);
  else if (!first && solve->smoothing)
    world->sweeps->error_and_xsph(&world->sweep, &solve->rule, part, total, solve->smoothing);
  else
    world->sweeps->error(&world->sweep, &solve->rule, part, total);
  if (first) warm_start(solve, part);
}

/* Predicts the errors of all own particles and gives ghosts their multipliers. */
static hc_error_total predict(const hc_solve *solve, bool first) {
  hc_world *world = solve->world;
  hc_error_total total;
  memset(&total, 0, sizeof total);
  predict_part(solve, first, hc_select_border(world->listed, world->fluid), &total);
  hc_halo_begin(world->halo, HC_SCALAR(place));
  predict_part(solve, first, hc_select_interior(world->listed, world->fluid), &total);
  hc_halo_end(world->halo);
  return total;
}

/* Corrects velocities by the multipliers in place.scalar, bodies' too. */
static void correct(const hc_solve *solve) {
  hc_world *world = solve->world;
  world->sweeps->pressure(&world->sweep, solve->weight, solve->multiplier,
                          hc_select_border(world->listed, world->fluid));
  hc_hold_still(world, 0, world->fluid->border);
  hc_halo_begin(world->halo, HC_WHOLE(motion));
  world->sweeps->pressure(&world->sweep, solve->weight, solve->multiplier,
                          hc_select_interior(world->listed, world->fluid));
  hc_hold_still(world, world->fluid->border, world->fluid->own);
  hc_yield_act(solve->yield);
  hc_halo_end(world->halo);
}

/* Algorithms 3 and 4: predict, then correct and predict until the average error is below the threshold. The
 * total is asked for below the least number of iterations too: what is no number must not spread unseen. */
hc_solved hc_solve_diagonal(const hc_solve *solve) {
  hc_world *world = solve->world;
  const double particles = world->fluid_total > 0 ? (double)world->fluid_total : 1.0;
  hc_tally pushes = {.count = 0}; /* on bodies, of the correction to come */
  predict(solve, true);
  hc_yield_note(solve->yield, (double)solve->weight, &pushes);
  hc_tally_reduce(world->comm, &pushes);
  correct(solve);
  hc_solved result = {.iterations = solve->warm == 0.0f}; /* the first correction is one */
  for (;; result.iterations++) {
    const hc_error_total total = predict(solve, false);
    hc_yield_note(solve->yield, (double)solve->weight, &pushes);
    result.average = hc_reduce_errors(world->comm, &total, &pushes, &result.max) / particles;
    result.broken = !isfinite(result.average) || solve->yield->impulses.broken;
    if (result.broken || (result.average <= solve->threshold && result.iterations >= solve->min)) break;
    result.capped = result.iterations >= solve->max;
    if (result.capped) break;
    correct(solve);
  }
  return result;
}
