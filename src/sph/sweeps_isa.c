/* The sweeps of the divergence-free solver, compiled once per instruction set, and the table of all sweeps.
 * See sweeps.h for what each computes, pairs.h for how. */
#include "error_rule.h"
#include "pairs.h"
#include "trial_rule.h"

/* What walls add to. */
static void expect_wall_fields(const hc_sweep *sweep) {
  EXPECT_FIELD(sweep->fluid, wall_gradient);
  EXPECT_FIELD(sweep->fluid, wall_density);
  if (sweep->walls_move) EXPECT_FIELD(sweep->fluid, wall_rate);
}

static void density(const hc_sweep *sweep, hc_selection selection) {
  expect_ready(sweep->fluid, HC_WHOLE(place) | HC_WHOLE(motion), sweep->fluid, selection);
  expect_walls(sweep);
  expect_wall_fields(sweep);
  hc_particles *fluid = sweep->fluid;
  EXPECT_FIELD(fluid, alpha);
  const float smallest = 1e-5f / (sweep->support * sweep->support);
  const float weight = sweep->volume * sweep->gradient;
  block_sums densities, squares, rates;
  block_vectors gradients;
  block_walls walls;
  for (int32_t first = selection.begin; first < selection.end; first += BLOCK) {
    const int32_t count = block_size(first, selection.end);
    for (int32_t k = 0; k < count; k++) {
      const int32_t i = hc_selected(selection, first + k);
      const self own = make_self(sweep, &fluid->place[i]);
      const row row = row_of(sweep->list, hc_row_of(selection, first + k));
      const vector velocity = spread_velocity(&fluid->motion[i]);
      sums sum = {{{0}}}, square = {{{0}}}, rate = {{{0}}};
      vector_sums gradient = no_sums();
      for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
        for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
          const int32_t at = pass + part * HC_GROUP;
          const pair p = load_pair(&own, fluid->place, row.offset + at);
          hc_float unused;
          const vector other = load_velocity(fluid->motion, row.offset + at, &unused);
          const vector relative = relative_velocity(&velocity, &other), d = direction(&p);
          const hc_float factor = hc_keep_groups(slope_over_q(p.q), row.entries - at);
          sum.part[part] += hc_keep(kernel(p.q), row.count - at);
          square.part[part] = hc_fma(factor * factor, p.q2, square.part[part]);
          rate.part[part] = hc_fma(factor, dot_pair(&relative, &p), rate.part[part]);
          add_scaled(&gradient, part, factor, &d);
        }
      }
      hc_store_lanes(sum.part, densities.lanes[k]);
      hc_store_lanes(square.part, squares.lanes[k]);
      hc_store_lanes(rate.part, rates.lanes[k]);
      store_vector(&gradients, k, &gradient);
    }
    sum_walls(sweep, selection, first, count, false, &walls);
    add_up(&densities, count);
    add_up(&squares, count);
    add_up(&rates, count);
    add_up_vectors(&gradients, count);
    for (int32_t k = 0; k < count; k++) {
      const int32_t i = hc_selected(selection, first + k);
      const float wall[3] = {walls.gradient[0][k], walls.gradient[1][k], walls.gradient[2][k]};
      const float of_walls = walls.density[k];
      const float relative = sweep->kernel * sweep->volume * (1.0f + densities.total[k]) + of_walls;
      const float x = weight * gradients.x.total[k] + wall[0], y = weight * gradients.y.total[k] + wall[1],
                  z = weight * gradients.z.total[k] + wall[2];
      const float denominator = x * x + y * y + z * z + weight * weight * squares.total[k];
      const float *v = fluid->motion[i].v;
      const float wall_rate = walls.rate[k];
      if (fluid->wall_rate) fluid->wall_rate[i] = wall_rate;
      fluid->place[i].scalar =
          weight * rates.total[k] + (v[0] * wall[0] + v[1] * wall[1] + v[2] * wall[2] - wall_rate);
      memcpy(&fluid->wall_gradient[3 * (size_t)i], wall, sizeof wall);
      fluid->wall_density[i] = of_walls;
      fluid->density[i] = sweep->rest_density * relative;
      fluid->motion[i].scalar = 1.0f / relative;
      fluid->alpha[i] = denominator > smallest ? 1.0f / denominator : 0.0f;
    }
  }
}

static void wall_sums(const hc_sweep *sweep, hc_selection selection) {
  expect_walls(sweep);
  expect_wall_fields(sweep);
  block_walls walls;
  for (int32_t first = selection.begin; first < selection.end; first += BLOCK) {
    const int32_t count = block_size(first, selection.end);
    sum_walls(sweep, selection, first, count, false, &walls);
    for (int32_t k = 0; k < count; k++) {
      const int32_t i = hc_selected(selection, first + k);
      for (int axis = 0; axis < 3; axis++)
        sweep->fluid->wall_gradient[3 * (size_t)i + axis] = walls.gradient[axis][k];
      sweep->fluid->wall_density[i] = walls.density[k];
      if (sweep->fluid->wall_rate) sweep->fluid->wall_rate[i] = walls.rate[k];
    }
  }
}

/* dD/dt of a block without the constant: sum (v_i - v_j) . grad W over fluid neighbours; and, unless null,
 * the sums of xsph with it. */
HC_INLINE void sum_rates(const hc_sweep *sweep, hc_selection selection, int32_t first, int32_t count,
                         block_sums *rates, block_vectors *smoothing) {
  const hc_particles *fluid = sweep->fluid;
  const hc_float volume = hc_set(sweep->volume);
  for (int32_t k = 0; k < count; k++) {
    const int32_t i = hc_selected(selection, first + k);
    const self own = make_self(sweep, &fluid->place[i]);
    const vector velocity = spread_velocity(&fluid->motion[i]);
    const row row = row_of(sweep->list, hc_row_of(selection, first + k));
    const hc_float own_inverse = hc_set(fluid->motion[i].scalar);
    sums sum = {{{0}}};
    vector_sums smooth = no_sums();
    for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
      for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
        const int32_t at = pass + part * HC_GROUP;
        const pair p = load_pair(&own, fluid->place, row.offset + at);
        hc_float inverse;
        const vector other = load_velocity(fluid->motion, row.offset + at, &inverse);
        const vector relative = relative_velocity(&velocity, &other);
        const hc_float factor = hc_keep_groups(slope_over_q(p.q), row.entries - at);
        sum.part[part] = hc_fma(factor, dot_pair(&relative, &p), sum.part[part]);
        if (smoothing)
          add_xsph(&smooth, part, &p, &relative, hc_keep_groups(volume, row.entries - at),
                   own_inverse + inverse);
      }
    }
    hc_store_lanes(sum.part, rates->lanes[k]);
    if (smoothing) store_vector(smoothing, k, &smooth);
  }
  add_up(rates, count);
  if (smoothing) add_up_vectors(smoothing, count);
}

/* What walls add to dD/dt of a particle. */
HC_INLINE float wall_rate_of(const hc_sweep *sweep, int32_t i) {
  const hc_particles *fluid = sweep->fluid;
  const float *wall = &fluid->wall_gradient[3 * (size_t)i], *v = fluid->motion[i].v;
  const float of_walls = sweep->walls_move ? fluid->wall_rate[i] : 0.0f;
  return v[0] * wall[0] + v[1] * wall[1] + v[2] * wall[2] - of_walls;
}

static void expect_rates(const hc_sweep *sweep, hc_selection selection) {
  expect_ready(sweep->fluid, HC_WHOLE(place) | HC_WHOLE(motion), sweep->fluid, selection);
  expect_wall_fields(sweep);
  EXPECT_FIELD(sweep->fluid, alpha);
}

/* From dD/dt of a block to errors by the rule, and multipliers. Without branches: nobody could predict them.
 */
static void apply_rule(const hc_sweep *sweep, const hc_error_rule *rule, hc_selection selection,
                       int32_t first, int32_t count, const float *rates, float *errors) {
  hc_particles *fluid = sweep->fluid;
  const float per_density = 1.0f / sweep->rest_density, least = rule->signed_error ? -INFINITY : 0.0f;
  float alphas[BLOCK];
  for (int32_t k = 0; k < count; k++) {
    const int32_t i = hc_selected(selection, first + k);
    errors[k] = fluid->density[i] * per_density - 1.0f;
    alphas[k] = rule->relaxation * fluid->alpha[i];
  }
  for (int32_t k = 0; k < count; k++) {
    const float excess = errors[k], gap = excess < 0.0f ? excess : 0.0f;
    const float e = rule->of_density * excess + rule->of_rate * rates[k] + rule->of_gap * gap;
    errors[k] = e < least ? least : e;
  }
  for (int32_t k = 0; k < count && rule->min_neighbors > 0; k++) {
    const int32_t row = hc_row_of(selection, first + k);
    const bool few = hc_list_count(sweep->list, row) + hc_list_count(sweep->walls, row) < rule->min_neighbors;
    errors[k] = few ? 0.0f : errors[k];
  }
  for (int32_t k = 0; k < count; k++)
    fluid->place[hc_selected(selection, first + k)].scalar = alphas[k] * errors[k];
}

HC_INLINE void find_errors(const hc_sweep *sweep, const hc_error_rule *rule, hc_selection selection,
                           hc_error_total *total, const hc_smoothing *smoothing) {
  expect_rates(sweep, selection);
  const float weight = sweep->volume * sweep->gradient;
  const float smooth = smoothing ? xsph_scale(sweep, smoothing->weight) : 0.0f;
  block_sums rates;
  block_vectors changes;
  float errors[BLOCK];
  for (int32_t first = selection.begin; first < selection.end; first += BLOCK) {
    const int32_t count = block_size(first, selection.end);
    sum_rates(sweep, selection, first, count, &rates, smoothing ? &changes : NULL);
    for (int32_t k = 0; k < count; k++) {
      const int32_t i = hc_selected(selection, first + k);
      rates.total[k] = weight * rates.total[k] + wall_rate_of(sweep, i);
      if (!smoothing) continue;
      float *change = &smoothing->change[3 * (size_t)i];
      change[0] = smooth * changes.x.total[k];
      change[1] = smooth * changes.y.total[k];
      change[2] = smooth * changes.z.total[k];
    }
    apply_rule(sweep, rule, selection, first, count, rates.total, errors);
    hc_errors_note(rule->signed_error, errors, count, total);
  }
}

static void error_from_rate(const hc_sweep *sweep, const hc_error_rule *rule, hc_selection selection) {
  EXPECT_FIELD(sweep->fluid, alpha);
  float rates[BLOCK], errors[BLOCK];
  for (int32_t first = selection.begin; first < selection.end; first += BLOCK) {
    const int32_t count = block_size(first, selection.end);
    for (int32_t k = 0; k < count; k++)
      rates[k] = sweep->fluid->place[hc_selected(selection, first + k)].scalar;
    apply_rule(sweep, rule, selection, first, count, rates, errors);
  }
}

static void error(const hc_sweep *sweep, const hc_error_rule *rule, hc_selection selection,
                  hc_error_total *total) {
  find_errors(sweep, rule, selection, total, NULL);
}

static void error_and_xsph(const hc_sweep *sweep, const hc_error_rule *rule, hc_selection selection,
                           hc_error_total *total, const hc_smoothing *smoothing) {
  expect_ready(sweep->fluid, HC_SCALAR(motion), sweep->fluid, selection);
  find_errors(sweep, rule, selection, total, smoothing);
}

static void trial_error(const hc_sweep *sweep, const hc_trial *trial, hc_selection selection,
                        hc_error_total *total, hc_trial_sums *sums) {
  hc_particles *fluid = sweep->fluid;
  expect_rates(sweep, selection);
  expect_range(selection);
  const float weight = sweep->volume * sweep->gradient;
  const float per_density = 1.0f / sweep->rest_density;
  block_sums rates;
  float errors[BLOCK];
  for (int32_t first = selection.begin; first < selection.end; first += BLOCK) {
    const int32_t count = block_size(first, selection.end);
    sum_rates(sweep, selection, first, count, &rates, NULL);
    for (int32_t k = 0; k < count; k++) {
      const float rate = weight * rates.total[k] + wall_rate_of(sweep, first + k);
      errors[k] = fluid->density[first + k] * per_density - 1.0f + trial->dt * rate;
    }
    for (int32_t k = 0; k < count; k++) fluid->place[first + k].scalar = errors[k];
    hc_errors_note(trial->least < 0.0f, errors, count, total);
    if (sums) note_products(sweep, trial, errors, first, count, sums);
  }
}

static void pressure(const hc_sweep *sweep, float weight, float *multiplier, hc_selection selection) {
  hc_particles *fluid = sweep->fluid;
  const float pair_weight = weight * sweep->volume * sweep->gradient;
  expect_ready(fluid, HC_WHOLE(place) | HC_SCALAR(place), fluid, selection);
  EXPECT_FIELD(fluid, wall_gradient);
  block_vectors changes;
  for (int32_t first = selection.begin; first < selection.end; first += BLOCK) {
    const int32_t count = block_size(first, selection.end);
    sum_pressure_gradients(sweep, selection, first, count, &changes);
    for (int32_t k = 0; k < count; k++) {
      const int32_t i = hc_selected(selection, first + k);
      const float kappa = fluid->place[i].scalar, wall_weight = weight * kappa;
      const float *wall = &fluid->wall_gradient[3 * (size_t)i];
      double *velocity = &fluid->velocity[3 * (size_t)i];
      velocity[0] -= pair_weight * changes.x.total[k] + wall_weight * wall[0];
      velocity[1] -= pair_weight * changes.y.total[k] + wall_weight * wall[1];
      velocity[2] -= pair_weight * changes.z.total[k] + wall_weight * wall[2];
      for (int axis = 0; axis < 3; axis++) fluid->motion[i].v[axis] = (float)velocity[axis];
      multiplier[i] += kappa;
    }
  }
}

/* ---- boundary ---- */

static void boundary_volume(const hc_sweep *sweep, hc_particles *boundary, const hc_neighbors *list,
                            float factor) {
  expect_ready(boundary, HC_WHOLE(place), boundary, hc_select_all(boundary));
  EXPECT_FIELD(boundary, volume);
  block_sums kernels;
  for (int32_t first = 0; first < boundary->own; first += BLOCK) {
    const int32_t count = block_size(first, boundary->own);
    sum_kernels(sweep, boundary->place, list, boundary->place, NULL, hc_select_all(boundary), first, count,
                &kernels);
    for (int32_t k = 0; k < count; k++)
      boundary->volume[first + k] = factor / (sweep->kernel * (1.0f + kernels.total[k]));
  }
  for (int32_t i = 0; i < boundary->own; i++) boundary->place[i].scalar = boundary->volume[i];
}

const hc_sweeps *HC_ISA_SYMBOL(hc_sweeps)(void) {
  static const hc_sweeps sweeps = {.density = density,
                                   .wall_sums = wall_sums,
                                   .error = error,
                                   .error_from_rate = error_from_rate,
                                   .error_and_xsph = error_and_xsph,
                                   .trial_error = trial_error,
                                   .next_trial = next_trial,
                                   .pressure = pressure,
                                   .xsph = HC_ISA_SYMBOL(hc_xsph),
                                   .laminar = HC_ISA_SYMBOL(hc_laminar),
                                   .smagorinsky = HC_ISA_SYMBOL(hc_smagorinsky),
                                   .artificial = HC_ISA_SYMBOL(hc_artificial),
                                   .cohesion = HC_ISA_SYMBOL(hc_cohesion),
                                   .weak_density = HC_ISA_SYMBOL(hc_weak_density),
                                   .weak_forces = HC_ISA_SYMBOL(hc_weak_forces),
                                   .wall_layer = HC_ISA_SYMBOL(hc_wall_layer),
                                   .boundary_volume = boundary_volume,
                                   .predicted_density = HC_ISA_SYMBOL(hc_predicted_density),
                                   .corrected_density = HC_ISA_SYMBOL(hc_corrected_density),
                                   .boundary_density = HC_ISA_SYMBOL(hc_boundary_density),
                                   .push = HC_ISA_SYMBOL(hc_push),
                                   .contacts = HC_ISA_SYMBOL(hc_contacts),
                                   .wall_velocities = HC_ISA_SYMBOL(hc_wall_velocities)};
  return &sweeps;
}
