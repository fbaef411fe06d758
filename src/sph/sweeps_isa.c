/* The pair sweeps, compiled once per instruction set. See sweeps.h for what each computes.
 *
 * Every loop has one shape: a vector's worth of neighbours' records is loaded and transposed, differences are
 * taken exactly on the fixed-point positions, lane sums reduced at the end, even and odd groups apart (see
 * simd.h). Entries that fill up a particle's last group hold the particle itself: its distance is zero, and
 * whatever has a gradient or a velocity difference in it adds exactly zero. Where that does not help, lanes
 * beyond the count are masked. */
#include "sweeps.h"

#include "base/simd.h"
#include "error_rule.h"

enum { PREFETCH = 2048 }; /* bytes of the list ahead of use; without it large sets run at half the speed */

/* Neighbours relative to the particle. */
typedef struct pair {
  hc_float x, y, z; /* x_i - x_j in support radii */
  hc_float q2, q;
  hc_float scalar; /* place.scalar of the neighbours */
} pair;

typedef struct vector {
  hc_float x, y, z;
} vector;

/* Sums under way, lane by lane, even and odd groups apart (see simd.h). */
typedef struct sums {
  hc_float part[HC_PARTS];
} sums;

typedef struct vector_sums {
  sums x, y, z;
} vector_sums;

/* The particle itself, spread over the lanes. */
typedef struct self {
  hc_int x, y, z;
  hc_float scale_x, scale_y, scale_z;
} self;

/* A particle's neighbours in a list. */
typedef struct row {
  const uint32_t *offset;
  int32_t entries; /* in whole groups */
  int32_t count;
} row;

HC_INLINE row row_of(const hc_neighbors *list, int32_t i) {
  const uint32_t first = list->start[i];
  return (row){list->offset + (size_t)first * HC_GROUP, (int32_t)(list->start[i + 1] - first) * HC_GROUP,
               list->count[i]};
}

HC_INLINE self make_self(const hc_sweep *sweep, const hc_record *place) {
  return (self){hc_set_int(place->x[0]), hc_set_int(place->x[1]), hc_set_int(place->x[2]),
                hc_set(sweep->scale[0]), hc_set(sweep->scale[1]), hc_set(sweep->scale[2])};
}

HC_INLINE pair load_pair(const self *own, const hc_record *place, const uint32_t *offset) {
  __builtin_prefetch((const char *)offset + PREFETCH);
  hc_int column[4];
  hc_load_records(place, offset, column);
  pair p;
  p.x = hc_from_int(hc_wrapped_difference(own->x, column[0])) * own->scale_x;
  p.y = hc_from_int(hc_wrapped_difference(own->y, column[1])) * own->scale_y;
  p.z = hc_from_int(hc_wrapped_difference(own->z, column[2])) * own->scale_z;
  p.q2 = hc_fma(p.z, p.z, hc_fma(p.y, p.y, p.x * p.x));
  p.q = hc_sqrt(p.q2);
  p.scalar = (hc_float)column[3];
  return p;
}

HC_INLINE vector load_velocity(const hc_record *motion, const uint32_t *offset, hc_float *scalar) {
  hc_int column[4];
  hc_load_records(motion, offset, column);
  *scalar = (hc_float)column[3];
  return (vector){(hc_float)column[0], (hc_float)column[1], (hc_float)column[2]};
}

/* W without its constant. */
HC_INLINE hc_float kernel(hc_float q) {
  const hc_float zero = hc_set(0.0f);
  const hc_float outer = hc_max(hc_set(1.0f) - q, zero), inner = hc_max(hc_set(0.5f) - q, zero);
  return hc_fma(outer * outer, outer + outer, inner * inner * inner * hc_set(-8.0f));
}

/* dW/dq / q without the constant; never positive. For q <= 1/2 it is -12 + 18 q; with c = max(q, 1/2) both
 * branches are -6 (1 - c)^2 / c - 18 (c - q), which has nothing to divide by zero. */
HC_INLINE hc_float slope_over_q(hc_float q) {
  const hc_float clamped = hc_max(q, hc_set(0.5f));
  const hc_float outer = hc_max(hc_set(1.0f) - clamped, hc_set(0.0f));
  const hc_float inverse = hc_set(-6.0f) / clamped;
  return hc_fma(outer * outer, inverse, hc_set(-18.0f) * (clamped - q));
}

HC_INLINE void add_scaled(vector_sums *sum, int part, hc_float factor, const vector *v) {
  sum->x.part[part] = hc_fma(factor, v->x, sum->x.part[part]);
  sum->y.part[part] = hc_fma(factor, v->y, sum->y.part[part]);
  sum->z.part[part] = hc_fma(factor, v->z, sum->z.part[part]);
}

HC_INLINE vector direction(const pair *p) {
  return (vector){p->x, p->y, p->z};
}

HC_INLINE hc_float dot_pair(const vector *v, const pair *p) {
  return hc_fma(v->z, p->z, hc_fma(v->y, p->y, v->x * p->x));
}

HC_INLINE vector relative_velocity(const vector *own, const vector *other) {
  return (vector){own->x - other->x, own->y - other->y, own->z - other->z};
}

HC_INLINE vector spread_velocity(const hc_record *motion) {
  return (vector){hc_set(motion->v[0]), hc_set(motion->v[1]), hc_set(motion->v[2])};
}

HC_INLINE vector_sums no_sums(void) {
  vector_sums sum;
  memset(&sum, 0, sizeof sum);
  return sum;
}

/* Particles are taken in blocks: the pair loops leave lane sums behind, which are added up eight rows at a
 * time when the block is through, and only then results are written. So the long chain of one particle's
 * arithmetic overlaps with the next one's, and no record is loaded as a neighbour's right after a part of it
 * was stored. */
enum { BLOCK = 64 };

typedef struct block_sums {
  _Alignas(64) float lanes[BLOCK][HC_GROUP];
  _Alignas(64) float total[BLOCK];
} block_sums;

typedef struct block_vectors {
  block_sums x, y, z;
} block_vectors;

HC_INLINE int32_t block_size(int32_t first, int32_t end) {
  return end - first < BLOCK ? end - first : BLOCK;
}

HC_INLINE void add_up(block_sums *block, int32_t count) {
  for (int32_t k = 0; k < count; k += HC_GROUP) hc_sum_rows(block->lanes[k], block->total + k);
}

HC_INLINE void store_vector(block_vectors *block, int32_t k, const vector_sums *sum) {
  hc_store_lanes(sum->x.part, block->x.lanes[k]);
  hc_store_lanes(sum->y.part, block->y.lanes[k]);
  hc_store_lanes(sum->z.part, block->z.lanes[k]);
}

HC_INLINE void add_up_vectors(block_vectors *block, int32_t count) {
  add_up(&block->x, count);
  add_up(&block->y, count);
  add_up(&block->z, count);
}

/* ---- density, alpha, wall gradient ---- */

/* Sums over boundary neighbours of a block: V_b W and V_b grad W without their constants. */
HC_INLINE void sum_walls(const hc_sweep *sweep, int32_t first, int32_t count, block_sums *densities,
                         block_vectors *gradients) {
  if (sweep->walls->start[first] == sweep->walls->start[first + count]) { /* far from any wall */
    memset(densities->total, 0, sizeof densities->total);
    memset(gradients->x.total, 0, sizeof gradients->x.total);
    memset(gradients->y.total, 0, sizeof gradients->y.total);
    memset(gradients->z.total, 0, sizeof gradients->z.total);
    return;
  }
  for (int32_t k = 0; k < count; k++) {
    const self own = make_self(sweep, &sweep->fluid->place[first + k]);
    const row row = row_of(sweep->walls, first + k);
    sums density = {{{0}}};
    vector_sums gradient = no_sums();
    for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
      for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
        const int32_t at = pass + part * HC_GROUP;
        const pair p = load_pair(&own, sweep->boundary->place, row.offset + at);
        const hc_float volume = hc_keep(p.scalar, row.count - at);
        const vector d = direction(&p);
        density.part[part] = hc_fma(kernel(p.q), volume, density.part[part]);
        add_scaled(&gradient, part, volume * slope_over_q(p.q), &d);
      }
    }
    hc_store_lanes(density.part, densities->lanes[k]);
    store_vector(gradients, k, &gradient);
  }
  add_up(densities, count);
  add_up_vectors(gradients, count);
}

/* Sums over boundary neighbours of a block: V_b v_b . grad W without its constant. */
HC_INLINE void sum_wall_rates(const hc_sweep *sweep, int32_t first, int32_t count, block_sums *rates) {
  memset(rates->total, 0, sizeof rates->total);
  if (!sweep->walls_move || sweep->walls->start[first] == sweep->walls->start[first + count]) return;
  for (int32_t k = 0; k < count; k++) {
    const self own = make_self(sweep, &sweep->fluid->place[first + k]);
    const row row = row_of(sweep->walls, first + k);
    sums rate = {{{0}}};
    for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
      for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
        const int32_t at = pass + part * HC_GROUP;
        const pair p = load_pair(&own, sweep->boundary->place, row.offset + at);
        hc_float unused;
        const vector velocity = load_velocity(sweep->boundary->motion, row.offset + at, &unused);
        const hc_float volume = hc_keep(p.scalar, row.count - at);
        rate.part[part] = hc_fma(volume * slope_over_q(p.q), dot_pair(&velocity, &p), rate.part[part]);
      }
    }
    hc_store_lanes(rate.part, rates->lanes[k]);
  }
  add_up(rates, count);
}

static void density(const hc_sweep *sweep, int32_t begin, int32_t end) {
  hc_particles *fluid = sweep->fluid;
  const float smallest = 1e-5f / (sweep->support * sweep->support);
  const float weight = sweep->volume * sweep->gradient;
  block_sums densities, squares, rates, wall_densities, wall_rates;
  block_vectors gradients, wall_gradients;
  for (int32_t first = begin; first < end; first += BLOCK) {
    const int32_t count = block_size(first, end);
    for (int32_t k = 0; k < count; k++) {
      const self own = make_self(sweep, &fluid->place[first + k]);
      const row row = row_of(sweep->list, first + k);
      const vector velocity = spread_velocity(&fluid->motion[first + k]);
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
    sum_walls(sweep, first, count, &wall_densities, &wall_gradients);
    sum_wall_rates(sweep, first, count, &wall_rates);
    add_up(&densities, count);
    add_up(&squares, count);
    add_up(&rates, count);
    add_up_vectors(&gradients, count);
    for (int32_t k = 0; k < count; k++) {
      const int32_t i = first + k;
      const float wall[3] = {sweep->gradient * wall_gradients.x.total[k],
                             sweep->gradient * wall_gradients.y.total[k],
                             sweep->gradient * wall_gradients.z.total[k]};
      const float of_walls = sweep->kernel * wall_densities.total[k];
      const float relative = sweep->kernel * sweep->volume * (1.0f + densities.total[k]) + of_walls;
      const float x = weight * gradients.x.total[k] + wall[0], y = weight * gradients.y.total[k] + wall[1],
                  z = weight * gradients.z.total[k] + wall[2];
      const float denominator = x * x + y * y + z * z + weight * weight * squares.total[k];
      const float *v = fluid->motion[i].v;
      fluid->wall_rate[i] = sweep->gradient * wall_rates.total[k];
      fluid->place[i].scalar =
          weight * rates.total[k] + (v[0] * wall[0] + v[1] * wall[1] + v[2] * wall[2] - fluid->wall_rate[i]);
      memcpy(&fluid->wall_gradient[3 * (size_t)i], wall, sizeof wall);
      fluid->wall_density[i] = of_walls;
      fluid->density[i] = sweep->rest_density * relative;
      fluid->motion[i].scalar = 1.0f / relative;
      fluid->alpha[i] = denominator > smallest ? 1.0f / denominator : 0.0f;
    }
  }
}

/* ---- the pressure solvers' two sweeps ---- */

static void error(const hc_sweep *sweep, const hc_error_rule *rule, int32_t begin, int32_t end,
                  hc_error_total *total) {
  const hc_particles *fluid = sweep->fluid;
  const float weight = sweep->volume * sweep->gradient;
  const float per_density = 1.0f / sweep->rest_density;
  block_sums rates;
  for (int32_t first = begin; first < end; first += BLOCK) {
    const int32_t count = block_size(first, end);
    for (int32_t k = 0; k < count; k++) {
      const self own = make_self(sweep, &fluid->place[first + k]);
      const vector velocity = spread_velocity(&fluid->motion[first + k]);
      const row row = row_of(sweep->list, first + k);
      sums sum = {{{0}}};
      for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
        for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
          const int32_t at = pass + part * HC_GROUP;
          const pair p = load_pair(&own, fluid->place, row.offset + at);
          hc_float unused;
          const vector other = load_velocity(fluid->motion, row.offset + at, &unused);
          const vector relative = relative_velocity(&velocity, &other);
          const hc_float factor = hc_keep_groups(slope_over_q(p.q), row.entries - at);
          sum.part[part] = hc_fma(factor, dot_pair(&relative, &p), sum.part[part]);
        }
      }
      hc_store_lanes(sum.part, rates.lanes[k]);
    }
    add_up(&rates, count);
    for (int32_t k = 0; k < count; k++) {
      const float *wall = &fluid->wall_gradient[3 * (size_t)(first + k)], *v = fluid->motion[first + k].v;
      const float of_walls = sweep->walls_move ? fluid->wall_rate[first + k] : 0.0f;
      const float wall_rate = v[0] * wall[0] + v[1] * wall[1] + v[2] * wall[2] - of_walls;
      hc_error_apply(sweep, rule, per_density, first + k, weight * rates.total[k] + wall_rate, total);
    }
  }
}

static void pressure(const hc_sweep *sweep, float weight, float *multiplier, int32_t begin, int32_t end) {
  hc_particles *fluid = sweep->fluid;
  const float pair_weight = weight * sweep->volume * sweep->gradient;
  block_vectors changes;
  for (int32_t first = begin; first < end; first += BLOCK) {
    const int32_t count = block_size(first, end);
    for (int32_t k = 0; k < count; k++) {
      const self own = make_self(sweep, &fluid->place[first + k]);
      const hc_float own_kappa = hc_set(fluid->place[first + k].scalar);
      const row row = row_of(sweep->list, first + k);
      vector_sums sum = no_sums();
      for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
        for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
          const int32_t at = pass + part * HC_GROUP;
          const pair p = load_pair(&own, fluid->place, row.offset + at);
          const vector d = direction(&p);
          const hc_float factor = (own_kappa + p.scalar) * slope_over_q(p.q);
          add_scaled(&sum, part, hc_keep_groups(factor, row.entries - at), &d);
        }
      }
      store_vector(&changes, k, &sum);
    }
    add_up_vectors(&changes, count);
    for (int32_t k = 0; k < count; k++) {
      const int32_t i = first + k;
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

/* ---- viscosity ---- */

/* Keeps divisions by r^2 finite: 0.01 smoothing lengths squared (half a support radius each). */
#define GUARD 0.0025f

/* What of the particle itself a viscous force needs. */
typedef struct viscous_self {
  vector velocity;
  hc_float inverse_density;
  vector normal; /* of the wall, of unit length or zero */
} viscous_self;

/* Adds one pair's viscous force. `volume` is the neighbours', 0 in lanes to drop. */
typedef void viscous_pair(vector_sums *sum, int part, const viscous_self *own, const pair *p,
                          const vector *relative, hc_float volume, hc_float inverse_density);

HC_INLINE void pair_xsph(vector_sums *sum, int part, const viscous_self *own, const pair *p,
                         const vector *relative, hc_float volume, hc_float inverse_density) {
  add_scaled(sum, part, volume * (own->inverse_density + inverse_density) * kernel(p->q), relative);
}

HC_INLINE void pair_laminar(vector_sums *sum, int part, const viscous_self *own, const pair *p,
                            const vector *relative, hc_float volume, hc_float inverse_density) {
  (void)own, (void)inverse_density;
  /* x . grad W/(r^2 + 0.01 (h/2)^2) = q^2 (W'(q)/q)/(q^2 + 0.0025) / h^2 */
  add_scaled(sum, part, volume * slope_over_q(p->q) * p->q2 / (p->q2 + hc_set(GUARD)), relative);
}

HC_INLINE void pair_artificial(vector_sums *sum, int part, const viscous_self *own, const pair *p,
                               const vector *relative, hc_float volume, hc_float inverse_density) {
  (void)own, (void)inverse_density;
  const hc_float approach = hc_min(dot_pair(relative, p), hc_set(0.0f));
  const vector d = direction(p);
  add_scaled(sum, part, volume * approach * slope_over_q(p->q) / (p->q2 + hc_set(GUARD)), &d);
}

/* From the velocity relative to the wall to that relative to its sample behind the wetted surface. */
HC_INLINE vector relative_to_surface(const hc_sweep *sweep, const viscous_self *own, const pair *p,
                                     const vector *relative) {
  const hc_float behind = hc_set(sweep->wall_offset), distance = dot_pair(&own->normal, p);
  const hc_float before = hc_max(hc_max(distance, hc_set(0.0f) - distance) - behind, behind);
  const hc_float factor = hc_set(1.0f) + behind / before;
  return (vector){factor * relative->x, factor * relative->y, factor * relative->z};
}

HC_INLINE vector wall_normal(const float gradient[3]) {
  const float square = gradient[0] * gradient[0] + gradient[1] * gradient[1] + gradient[2] * gradient[2];
  const float scale = square > 0.0f ? 1.0f / sqrtf(square) : 0.0f;
  return (vector){hc_set(scale * gradient[0]), hc_set(scale * gradient[1]), hc_set(scale * gradient[2])};
}

/* How walls take part: not at all, as particles, or holding the fluid at the wetted surface. */
typedef enum wall_part { NO_WALLS, AS_PARTICLES, NO_SLIP } wall_part;

HC_INLINE void viscous(const hc_sweep *sweep, viscous_pair *add, wall_part walls_are, float weight,
                       float *change, int32_t begin, int32_t end) {
  const hc_particles *fluid = sweep->fluid;
  const hc_float volume = hc_set(sweep->volume);
  block_vectors changes;
  for (int32_t first = begin; first < end; first += BLOCK) {
    const int32_t count = block_size(first, end);
    for (int32_t k = 0; k < count; k++) {
      const int32_t i = first + k;
      const self own = make_self(sweep, &fluid->place[i]);
      const viscous_self state = {spread_velocity(&fluid->motion[i]), hc_set(fluid->motion[i].scalar),
                                  wall_normal(&fluid->wall_gradient[3 * (size_t)i])};
      vector_sums sum = no_sums();
      const row row = row_of(sweep->list, i);
      for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
        for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
          const int32_t at = pass + part * HC_GROUP;
          const pair p = load_pair(&own, fluid->place, row.offset + at);
          hc_float inverse;
          const vector other = load_velocity(fluid->motion, row.offset + at, &inverse);
          const vector relative = relative_velocity(&state.velocity, &other);
          add(&sum, part, &state, &p, &relative, hc_keep_groups(volume, row.entries - at), inverse);
        }
      }
      const struct row walls = row_of(sweep->walls, i);
      for (int32_t pass = 0; walls_are != NO_WALLS && pass < walls.entries; pass += 2 * HC_GROUP) {
        for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < walls.entries; part++) {
          const int32_t at = pass + part * HC_GROUP;
          const pair p = load_pair(&own, sweep->boundary->place, walls.offset + at);
          vector relative = state.velocity;
          if (sweep->walls_move) {
            hc_float unused;
            const vector other = load_velocity(sweep->boundary->motion, walls.offset + at, &unused);
            relative = relative_velocity(&state.velocity, &other);
          }
          if (walls_are == NO_SLIP) relative = relative_to_surface(sweep, &state, &p, &relative);
          add(&sum, part, &state, &p, &relative, hc_keep(p.scalar, walls.count - at), hc_set(1.0f));
        }
      }
      store_vector(&changes, k, &sum);
    }
    add_up_vectors(&changes, count);
    for (int32_t k = 0; k < count; k++) {
      float *to = &change[3 * (size_t)(first + k)];
      to[0] = weight * changes.x.total[k];
      to[1] = weight * changes.y.total[k];
      to[2] = weight * changes.z.total[k];
    }
  }
}

static void xsph(const hc_sweep *sweep, float weight, float *change, int32_t begin, int32_t end) {
  viscous(sweep, pair_xsph, NO_WALLS, -0.5f * weight * sweep->kernel, change, begin, end);
}

static void laminar(const hc_sweep *sweep, float weight, float *change, int32_t begin, int32_t end) {
  viscous(sweep, pair_laminar, NO_SLIP, 2.0f * weight * sweep->gradient / sweep->support, change, begin, end);
}

static void artificial(const hc_sweep *sweep, float weight, float *change, int32_t begin, int32_t end) {
  viscous(sweep, pair_artificial, AS_PARTICLES, weight * sweep->gradient / sweep->support, change, begin,
          end);
}

/* ---- boundary ---- */

static void boundary_volume(const hc_sweep *sweep, hc_particles *boundary, const hc_neighbors *list,
                            float factor) {
  block_sums kernels;
  for (int32_t first = 0; first < boundary->own; first += BLOCK) {
    const int32_t count = block_size(first, boundary->own);
    for (int32_t k = 0; k < count; k++) {
      const self own = make_self(sweep, &boundary->place[first + k]);
      const row row = row_of(list, first + k);
      sums sum = {{{0}}};
      for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
        for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
          const int32_t at = pass + part * HC_GROUP;
          const pair p = load_pair(&own, boundary->place, row.offset + at);
          sum.part[part] += hc_keep(kernel(p.q), row.count - at);
        }
      }
      hc_store_lanes(sum.part, kernels.lanes[k]);
    }
    add_up(&kernels, count);
    for (int32_t k = 0; k < count; k++)
      boundary->volume[first + k] = factor / (sweep->kernel * (1.0f + kernels.total[k]));
  }
  for (int32_t i = 0; i < boundary->own; i++) boundary->place[i].scalar = boundary->volume[i];
}

const hc_sweeps *HC_ISA_SYMBOL(hc_sweeps)(void) {
  static const hc_sweeps sweeps = {density, error, pressure, xsph, laminar, artificial, boundary_volume};
  return &sweeps;
}
