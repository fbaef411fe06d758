/* The sweeps of the weakly compressible solver, compiled once per instruction set. See sweeps.h for what each
 * computes. */
#include "error_rule.h"
#include "pairs.h"

void HC_ISA_SYMBOL(hc_weak_density)(const hc_sweep *sweep, const hc_tait *tait, hc_selection selection,
                                    hc_error_total *total) {
  hc_particles *const fluid = sweep->fluid;
  expect_ready(fluid, HC_WHOLE(place), fluid, selection);
  expect_walls(sweep);
  EXPECT_FIELD(fluid, wall_gradient);
  EXPECT_FIELD(fluid, wall_density);
  block_sums kernels;
  block_walls walls;
  float errors[BLOCK];
  for (int32_t first = selection.begin; first < selection.end; first += BLOCK) {
    const int32_t count = block_size(first, selection.end);
    sum_kernels(sweep, fluid->place, sweep->list, fluid->place, NULL, selection, first, count, &kernels);
    sum_walls(sweep, selection, first, count, false, &walls);
    for (int32_t k = 0; k < count; k++) {
      const int32_t i = hc_selected(selection, first + k);
      const float relative = sweep->kernel * sweep->volume * (1.0f + kernels.total[k]) + walls.density[k];
      const float pressure = hc_tait_pressure(tait, relative);
      for (int axis = 0; axis < 3; axis++)
        fluid->wall_gradient[3 * (size_t)i + (size_t)axis] = walls.gradient[axis][k];
      if (fluid->wall_rate) fluid->wall_rate[i] = walls.rate[k];
      fluid->wall_density[i] = walls.density[k];
      fluid->density[i] = sweep->rest_density * relative;
      fluid->pressure[i] = sweep->rest_density * pressure;
      fluid->place[i].scalar = hc_tait_push(pressure, relative);
      errors[k] = relative - 1.0f;
    }
    hc_errors_note(tait->negative, errors, count, total);
  }
}

/* The sums of weak_forces over the fluid: `rates` may be null, and then costs nothing. */
HC_INLINE void sum_fluid(const hc_sweep *sweep, float viscous, hc_selection selection, int32_t first,
                         int32_t count, block_vectors *forces, block_sums *rates) {
  const hc_particles *const fluid = sweep->fluid;
  const hc_float viscosity = hc_set(viscous), guard = hc_set(HC_GUARD), zero = hc_set(0.0f);
  for (int32_t k = 0; k < count; k++) {
    const int32_t i = hc_selected(selection, first + k);
    const self own = make_self(sweep, &fluid->place[i]);
    const hc_float scalar = hc_set(fluid->place[i].scalar);
    const vector velocity = spread_velocity(&fluid->motion[i]);
    const row row = row_of(sweep->list, hc_row_of(selection, first + k));
    vector_sums force = no_sums();
    sums rate = {{{0}}};
    for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
      for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
        const int32_t at = pass + part * HC_GROUP;
        const pair p = load_pair(&own, fluid->place, row.offset + at);
        hc_float unused;
        const vector other = load_velocity(fluid->motion, row.offset + at, &unused);
        const vector relative = relative_velocity(&velocity, &other), d = direction(&p);
        const hc_float along = dot_pair(&relative, &p);
        const hc_float slope = hc_keep_groups(slope_over_q(p.q), row.entries - at);
        const hc_float viscous_part = viscosity * hc_min(along, zero) / (p.q2 + guard);
        add_scaled(&force, part, slope * (viscous_part - (scalar + p.scalar)), &d);
        if (rates) rate.part[part] = hc_fma(slope, along, rate.part[part]);
      }
    }
    store_vector(forces, k, &force);
    if (rates) hc_store_lanes(rate.part, rates->lanes[k]);
  }
  add_up_vectors(forces, count);
  if (rates) add_up(rates, count);
}

/* What walls take part in of the viscosity. */
HC_INLINE void sum_viscous_walls(const hc_sweep *sweep, hc_selection selection, int32_t first,
                                 const block_rows *rows, block_vectors *forces) {
  const hc_particles *const fluid = sweep->fluid;
  for (int32_t m = 0; m < rows->count; m++) {
    const int32_t number = first + rows->at[m], i = hc_selected(selection, number);
    const self own = make_self(sweep, &fluid->place[i]);
    const vector velocity = spread_velocity(&fluid->motion[i]);
    const row row = row_of(sweep->walls, hc_row_of(selection, number));
    vector_sums force = no_sums();
    for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
      for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
        const int32_t at = pass + part * HC_GROUP;
        const pair p = load_pair(&own, sweep->boundary->place, row.offset + at);
        vector relative = velocity;
        if (sweep->walls_move) {
          hc_float unused;
          const vector other = load_velocity(sweep->boundary->motion, row.offset + at, &unused);
          relative = relative_velocity(&velocity, &other);
        }
        const hc_float approach = hc_min(dot_pair(&relative, &p), hc_set(0.0f));
        const vector d = direction(&p);
        add_scaled(
            &force, part,
            hc_keep(p.scalar, row.count - at) * approach * slope_over_q(p.q) / (p.q2 + hc_set(HC_GUARD)), &d);
      }
    }
    store_vector(forces, m, &force);
  }
  add_up_vectors(forces, rows->count);
}

HC_INLINE void weak_forces(const hc_sweep *sweep, float viscosity, float weight, float *change, float *rate,
                           hc_selection selection) {
  const hc_particles *const fluid = sweep->fluid;
  expect_ready(fluid, HC_WHOLE(place) | HC_WHOLE(motion) | HC_SCALAR(place), fluid, selection);
  expect_walls(sweep);
  const float of_rate = sweep->volume * sweep->gradient, of_pairs = weight * of_rate,
              viscous = viscosity / sweep->support, of_walls = weight * viscous * sweep->gradient;
  block_vectors forces, drags;
  block_sums rates;
  for (int32_t first = selection.begin; first < selection.end; first += BLOCK) {
    const int32_t count = block_size(first, selection.end);
    const block_rows rows = rows_at_walls(sweep, selection, first, count);
    sum_fluid(sweep, viscous, selection, first, count, &forces, rate ? &rates : NULL);
    if (viscous > 0.0f && rows.count > 0) sum_viscous_walls(sweep, selection, first, &rows, &drags);
    for (int32_t k = 0; k < count; k++) {
      const size_t i = (size_t)hc_selected(selection, first + k);
      const float push = weight * fluid->place[i].scalar, *const wall = &fluid->wall_gradient[3 * i];
      change[3 * i] += of_pairs * forces.x.total[k] - push * wall[0];
      change[3 * i + 1] += of_pairs * forces.y.total[k] - push * wall[1];
      change[3 * i + 2] += of_pairs * forces.z.total[k] - push * wall[2];
      if (!rate) continue;
      const float *const v = fluid->motion[i].v, moved = sweep->walls_move ? fluid->wall_rate[i] : 0.0f;
      rate[i] = of_rate * rates.total[k] + (v[0] * wall[0] + v[1] * wall[1] + v[2] * wall[2] - moved);
    }
    for (int32_t m = 0; m < rows.count && viscous > 0.0f; m++) {
      const size_t i = (size_t)hc_selected(selection, first + rows.at[m]);
      change[3 * i] += of_walls * drags.x.total[m];
      change[3 * i + 1] += of_walls * drags.y.total[m];
      change[3 * i + 2] += of_walls * drags.z.total[m];
    }
  }
}

void HC_ISA_SYMBOL(hc_weak_forces)(const hc_sweep *sweep, float viscosity, float weight, float *change,
                                   float *rate, hc_selection selection) {
  if (rate)
    weak_forces(sweep, viscosity, weight, change, rate, selection);
  else
    weak_forces(sweep, viscosity, weight, change, NULL, selection);
}
