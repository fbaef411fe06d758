/* The sweeps over predicted positions (PCISPH), compiled once per instruction set. See sweeps.h for what each
 * computes, pairs.h for how. */
#include "pairs.h"
#include "prediction_rule.h"

/* ---- what walls add ---- */

/* Sums W over boundary neighbours of a block, without the constant; each sample as a particle of fluid. */
HC_INLINE void sum_wall_kernels(const hc_sweep *sweep, hc_selection selection, int32_t first, int32_t count,
                                block_sums *kernels) {
  if (rows_are_empty(sweep->walls, selection, first, count)) { /* far from any wall */
    memset(kernels->total, 0, sizeof kernels->total);
    return;
  }
  sum_kernels(sweep, sweep->fluid->place, sweep->walls, sweep->boundary->place, NULL, selection, first, count,
              kernels);
}

/* Where particles of a block stand to the planes through the samples around them: w = max(0, 1 - q), sums of
 * w, w n and w (x . n). */
typedef struct block_planes {
  block_sums weight, height;
  block_vectors normal;
} block_planes;

HC_INLINE void no_planes(block_planes *planes) {
  memset(planes->weight.total, 0, sizeof planes->weight.total);
  memset(planes->height.total, 0, sizeof planes->height.total);
  memset(planes->normal.x.total, 0, sizeof planes->normal.x.total);
  memset(planes->normal.y.total, 0, sizeof planes->normal.y.total);
  memset(planes->normal.z.total, 0, sizeof planes->normal.z.total);
}

/* Sums w = max(0, 1 - q * steepness), w times the samples' vectors (normals or velocities), and w times the
 * height over the sample (`plane`) or w (1 - q * steepness). */
HC_INLINE void sum_planes(const hc_sweep *sweep, const hc_record *vectors, bool plane, float steepness,
                          hc_selection selection, int32_t first, int32_t count, block_planes *planes) {
  if (rows_are_empty(sweep->walls, selection, first, count)) {
    no_planes(planes);
    return;
  }
  const hc_float one = hc_set(1.0f), zero = hc_set(0.0f), rate = hc_set(steepness);
  for (int32_t k = 0; k < count; k++) {
    const self own = make_self(sweep, &sweep->fluid->place[hc_selected(selection, first + k)]);
    const row row = row_of(sweep->walls, hc_row_of(selection, first + k));
    sums weight = {{{0}}}, height = {{{0}}};
    vector_sums normal = no_sums();
    for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
      for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
        const int32_t at = pass + part * HC_GROUP;
        const pair p = load_pair(&own, sweep->boundary->place, row.offset + at);
        hc_float unused;
        const vector n = load_velocity(vectors, row.offset + at, &unused);
        const hc_float over = dot_pair(&n, &p), near = hc_max(one - rate * p.q, zero);
        /* the far side of a thin wall has no say */
        const hc_float w = hc_keep(plane ? (hc_float)((hc_int)near & (over > zero)) : near, row.count - at);
        weight.part[part] += w;
        height.part[part] = hc_fma(w, plane ? over : w, height.part[part]);
        add_scaled(&normal, part, w, &n);
      }
    }
    hc_store_lanes(weight.part, planes->weight.lanes[k]);
    hc_store_lanes(height.part, planes->height.lanes[k]);
    store_vector(&planes->normal, k, &normal);
  }
  add_up(&planes->weight, count);
  add_up(&planes->height, count);
  add_up_vectors(&planes->normal, count);
}

/* The density that a wall of the fluid's lattice would add at a distance from its first layer, in support
 * radii. */
static float density_at(const float *weights, float distance) {
  const float at = (distance > 0.0f ? distance : 0.0f) * (float)HC_WALL_WEIGHTS;
  if (!(at < (float)HC_WALL_WEIGHTS)) return 0.0f;
  const int step = (int)at;
  return weights[step] + (at - (float)step) * (weights[step + 1] - weights[step]);
}

/* The walls' share in the densities of a block, by the rule. */
HC_INLINE void sum_wall_densities(const hc_sweep *sweep, const hc_prediction *prediction,
                                  hc_selection selection, int32_t first, int32_t count, float share[BLOCK]) {
  block_sums sums;
  block_walls walls;
  block_planes planes;
  switch (sweep->walls_add) {
  case HC_WALLS_NOTHING:
    memset(share, 0, (size_t)count * sizeof *share);
    break;
  case HC_WALLS_MIRRORED:
    sum_walls(sweep, selection, first, count, true, &walls);
    memcpy(share, walls.density, (size_t)count * sizeof *share);
    break;
  case HC_WALLS_PRESSURE:
    sum_wall_kernels(sweep, selection, first, count, &sums);
    for (int32_t k = 0; k < count; k++) share[k] = sweep->kernel * sweep->volume * sums.total[k];
    break;
  case HC_WALLS_DISTANCE:
    EXPECT_FIELD(sweep->boundary, facing);
    sum_planes(sweep, sweep->boundary->facing, true, 1.0f, selection, first, count, &planes);
    for (int32_t k = 0; k < count; k++)
      share[k] = planes.weight.total[k] > 0.0f
                     ? density_at(prediction->weights, planes.height.total[k] / planes.weight.total[k])
                     : 0.0f;
    break;
  }
}

/* ---- densities and pressures ---- */

void HC_ISA_SYMBOL(hc_predicted_density)(const hc_sweep *sweep, const hc_prediction *prediction,
                                         hc_selection selection, hc_error_total *total) {
  hc_particles *fluid = sweep->fluid;
  expect_ready(fluid, HC_WHOLE(place), fluid, selection);
  expect_walls(sweep);
  block_sums kernels;
  float share[BLOCK], errors[BLOCK];
  for (int32_t first = selection.begin; first < selection.end; first += BLOCK) {
    const int32_t count = block_size(first, selection.end);
    sum_kernels(sweep, fluid->place, sweep->list, fluid->place, NULL, selection, first, count, &kernels);
    sum_wall_densities(sweep, prediction, selection, first, count, share);
    for (int32_t k = 0; k < count; k++) {
      const int32_t i = hc_selected(selection, first + k);
      const float relative = sweep->kernel * sweep->volume * (1.0f + kernels.total[k]) + share[k];
      if (prediction->shepard) {
        fluid->density[i] = relative;
        fluid->motion[i].scalar = 1.0f / relative;
      } else {
        errors[k] = hc_end_prediction(sweep, prediction, i, relative);
      }
    }
    if (!prediction->shepard) hc_errors_note(false, errors, count, total);
  }
}

void HC_ISA_SYMBOL(hc_corrected_density)(const hc_sweep *sweep, const hc_prediction *prediction,
                                         hc_selection selection, hc_error_total *total) {
  hc_particles *fluid = sweep->fluid;
  expect_ready(fluid, HC_WHOLE(place) | HC_WHOLE(motion) | HC_SCALAR(motion), fluid, selection);
  expect_walls(sweep);
  block_sums kernels;
  float share[BLOCK], errors[BLOCK];
  for (int32_t first = selection.begin; first < selection.end; first += BLOCK) {
    const int32_t count = block_size(first, selection.end);
    sum_kernels(sweep, fluid->place, sweep->list, fluid->place, fluid->motion, selection, first, count,
                &kernels);
    sum_wall_densities(sweep, prediction, selection, first, count, share);
    for (int32_t k = 0; k < count; k++) {
      const int32_t i = hc_selected(selection, first + k);
      const float own = fluid->density[i];
      const float volumes = sweep->kernel * sweep->volume * (1.0f / own + kernels.total[k]) + share[k];
      errors[k] = hc_end_prediction(sweep, prediction, i, own / volumes);
    }
    hc_errors_note(false, errors, count, total);
  }
}

void HC_ISA_SYMBOL(hc_boundary_density)(const hc_sweep *sweep, const hc_prediction *prediction,
                                        hc_particles *boundary, const hc_neighbors *list,
                                        hc_selection selection) {
  expect_ready(sweep->fluid, HC_WHOLE(place), boundary, selection);
  EXPECT_FIELD(boundary, boundary_share);
  block_sums kernels;
  for (int32_t first = selection.begin; first < selection.end; first += BLOCK) {
    const int32_t count = block_size(first, selection.end);
    if (rows_are_empty(list, selection, first, count)) continue; /* dry: the pressure stays 0 */
    sum_kernels(sweep, boundary->place, list, sweep->fluid->place, NULL, selection, first, count, &kernels);
    for (int32_t k = 0; k < count; k++) {
      const int32_t b = hc_selected(selection, first + k);
      if (hc_list_count(list, first + k) == 0) continue;
      const float relative = sweep->kernel * sweep->volume * kernels.total[k] + boundary->boundary_share[b];
      hc_raise_pressure(sweep, prediction, boundary, b, relative);
      boundary->place[b].scalar = hc_pressure_scalar(sweep, boundary->pressure[b], relative);
    }
  }
}

/* ---- the pressure's push ---- */

/* Sums (s_i + s_b) grad W over boundary neighbours of a block, without constants. */
HC_INLINE void sum_wall_pushes(const hc_sweep *sweep, hc_selection selection, int32_t first, int32_t count,
                               block_vectors *pushes) {
  if (rows_are_empty(sweep->walls, selection, first, count)) {
    memset(pushes->x.total, 0, sizeof pushes->x.total);
    memset(pushes->y.total, 0, sizeof pushes->y.total);
    memset(pushes->z.total, 0, sizeof pushes->z.total);
    return;
  }
  for (int32_t k = 0; k < count; k++) {
    const int32_t i = hc_selected(selection, first + k);
    const self own = make_self(sweep, &sweep->fluid->place[i]);
    const hc_float scalar = hc_set(sweep->fluid->place[i].scalar);
    const row row = row_of(sweep->walls, hc_row_of(selection, first + k));
    vector_sums sum = no_sums();
    for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
      for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
        const int32_t at = pass + part * HC_GROUP;
        const pair p = load_pair(&own, sweep->boundary->place, row.offset + at);
        const vector d = direction(&p);
        add_scaled(&sum, part, hc_keep((scalar + p.scalar) * slope_over_q(p.q), row.count - at), &d);
      }
    }
    store_vector(pushes, k, &sum);
  }
  add_up_vectors(pushes, count);
}

void HC_ISA_SYMBOL(hc_push)(const hc_sweep *sweep, const hc_prediction *prediction, hc_selection selection) {
  hc_particles *fluid = sweep->fluid;
  const float weight = -prediction->dt * sweep->volume * sweep->gradient;
  expect_ready(fluid, HC_WHOLE(place) | HC_SCALAR(place), fluid, selection);
  expect_walls(sweep);
  EXPECT_FIELD(fluid, push);
  if (sweep->walls_add == HC_WALLS_MIRRORED) EXPECT_FIELD(fluid, wall_gradient);
  block_vectors pushes, walls;
  for (int32_t first = selection.begin; first < selection.end; first += BLOCK) {
    const int32_t count = block_size(first, selection.end);
    sum_pressure_gradients(sweep, selection, first, count, &pushes);
    if (sweep->walls_add == HC_WALLS_PRESSURE) sum_wall_pushes(sweep, selection, first, count, &walls);
    for (int32_t k = 0; k < count; k++) {
      const size_t i = (size_t)hc_selected(selection, first + k);
      float push[3] = {weight * pushes.x.total[k], weight * pushes.y.total[k], weight * pushes.z.total[k]};
      if (sweep->walls_add == HC_WALLS_PRESSURE) {
        push[0] += weight * walls.x.total[k];
        push[1] += weight * walls.y.total[k];
        push[2] += weight * walls.z.total[k];
      } else if (sweep->walls_add == HC_WALLS_MIRRORED) {
        const float mirrored = -prediction->dt * fluid->place[i].scalar;
        for (int axis = 0; axis < 3; axis++)
          push[axis] += mirrored * fluid->wall_gradient[3 * i + (size_t)axis];
      }
      memcpy(&fluid->push[3 * i], push, sizeof push);
    }
  }
}

/* ---- contact ---- */

void HC_ISA_SYMBOL(hc_contacts)(const hc_sweep *sweep, hc_contact_rule rule, hc_record *contacts,
                                hc_selection selection) {
  const bool plane = rule == HC_CONTACT_DISTANCE;
  const float steepness = plane ? 1.0f : sweep->support / sweep->reach;
  expect_walls(sweep);
  EXPECT_FIELD(sweep->boundary, facing);
  block_planes planes;
  for (int32_t first = selection.begin; first < selection.end; first += BLOCK) {
    const int32_t count = block_size(first, selection.end);
    if (plane)
      sum_planes(sweep, sweep->boundary->facing, true, 1.0f, selection, first, count, &planes);
    else
      sum_planes(sweep, sweep->boundary->facing, false, steepness, selection, first, count, &planes);
    for (int32_t k = 0; k < count; k++) {
      hc_record *contact = &contacts[hc_selected(selection, first + k)];
      const float weight = planes.weight.total[k];
      memset(contact, 0, sizeof *contact);
      if (!(weight > 0.0f)) continue;
      const float mean = planes.height.total[k] / weight;
      contact->v[0] = planes.normal.x.total[k];
      contact->v[1] = planes.normal.y.total[k];
      contact->v[2] = planes.normal.z.total[k];
      contact->scalar = plane ? sweep->reach - sweep->support * mean : sweep->reach * mean;
    }
  }
}

void HC_ISA_SYMBOL(hc_wall_velocities)(const hc_sweep *sweep, hc_record *velocities, hc_selection selection) {
  const float steepness = sweep->support / sweep->reach;
  expect_walls(sweep);
  block_planes planes;
  for (int32_t first = selection.begin; first < selection.end; first += BLOCK) {
    const int32_t count = block_size(first, selection.end);
    sum_planes(sweep, sweep->boundary->motion, false, steepness, selection, first, count, &planes);
    for (int32_t k = 0; k < count; k++) {
      const float scale = planes.weight.total[k] > 0.0f ? 1.0f / planes.weight.total[k] : 0.0f;
      velocities[hc_selected(selection, first + k)] =
          (hc_record){.v = {scale * planes.normal.x.total[k], scale * planes.normal.y.total[k],
                            scale * planes.normal.z.total[k]}};
    }
  }
}
