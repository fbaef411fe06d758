/* What the pair sweeps of one instruction set share. Included by the *_isa.c files of this room only.
 *
 * Every loop has one shape: a vector's worth of neighbours' records is loaded and transposed, differences are
 * taken exactly on the fixed-point positions, lane sums reduced at the end, even and odd groups apart (see
 * simd.h). Entries that fill up a particle's last group hold the particle itself: its distance is zero, and
 * whatever has a gradient or a velocity difference in it adds exactly zero. Where that does not help, lanes
 * beyond the count are masked. */
#ifndef HC_PAIRS_H
#define HC_PAIRS_H

#include "base/check.h"
#include "base/simd.h"
#include "sweeps.h"

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

/* A row of a list: a particle's neighbours. */
typedef struct row {
  const uint32_t *offset;
  int32_t entries; /* in whole groups */
  int32_t count;
} row;

HC_INLINE row row_of(const hc_neighbors *list, int32_t number) {
  return (row){hc_list_row(list, number), hc_list_entries(list, number), hc_list_count(list, number)};
}

/* Nobody reads ghosts' values that are still on their way: only interior particles have no ghosts among their
 * neighbours. */
HC_INLINE void expect_ready(const hc_particles *particles, hc_field_set fields, const hc_particles *targets,
                            hc_selection selection) {
  HC_CHECK(!(particles->under_way & fields) || selection.begin >= selection.end ||
               (particles == targets && hc_selected(selection, selection.begin) >= particles->border),
           "a sweep reads fields that are being refreshed: %#llx",
           (unsigned long long)(particles->under_way & fields));
}

HC_INLINE void expect_walls(const hc_sweep *sweep) {
  const hc_particles *boundary = sweep->boundary, *moving = boundary->tail;
  HC_CHECK(!boundary->under_way && !(moving && moving->under_way),
           "a sweep reads walls that are being refreshed");
}

/* A run has only the fields that its solver's and boundary method's features name. */
#define EXPECT_FIELD(particles, field)                                                                       \
  HC_CHECK((particles)->field, "a sweep needs the field " #field ", which no feature of the run names")

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
  __asm__("" : "+r"(offset)); /* reads them again: sixteen of them held in registers are spilled */
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

HC_INLINE hc_float dot(const vector *a, const vector *b) {
  return hc_fma(a->z, b->z, hc_fma(a->y, b->y, a->x * b->x));
}

HC_INLINE hc_float dot_pair(const vector *v, const pair *p) {
  return hc_fma(v->z, p->z, hc_fma(v->y, p->y, v->x * p->x));
}

/* A pair of xsph; `volume` is the neighbours', 0 in lanes to drop. */
HC_INLINE void add_xsph(vector_sums *sum, int part, const pair *p, const vector *relative, hc_float volume,
                        hc_float inverse_densities) {
  add_scaled(sum, part, volume * inverse_densities * kernel(p->q), relative);
}

/* What its sums are weighed with. */
HC_INLINE float xsph_scale(const hc_sweep *sweep, float weight) {
  return -0.5f * weight * sweep->kernel;
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

/* What walls add to the densities of a block, and what that is made of. */
typedef struct block_walls {
  float density[BLOCK];     /* D_w */
  float gradient[3][BLOCK]; /* grad D_w */
  float rate[BLOCK];        /* what of dD_w/dt their motion takes away, where they move */
} block_walls;

/* Those rows of a block that have boundary neighbours, few where it is far from walls. */
typedef struct block_rows {
  int32_t at[BLOCK], count;
} block_rows;

HC_INLINE block_rows rows_at_walls(const hc_sweep *sweep, hc_selection selection, int32_t first,
                                   int32_t count) {
  block_rows rows = {.count = 0};
  for (int32_t k = 0; k < count; k++) {
    rows.at[rows.count] = k;
    rows.count += hc_list_count(sweep->walls, hc_row_of(selection, first + k)) > 0;
  }
  return rows;
}

/* Sums over boundary neighbours of a block: V_b W, V_b grad W, and V_b v_b . grad W. */
HC_INLINE void sum_plain_walls(const hc_sweep *sweep, hc_selection selection, int32_t first,
                               const block_rows *rows, bool densities_alone, block_walls *walls) {
  block_sums densities, rates;
  block_vectors gradients;
  const bool move = sweep->walls_move && !densities_alone;
  for (int32_t m = 0; m < rows->count; m++) {
    const int32_t number = first + rows->at[m];
    const self own = make_self(sweep, &sweep->fluid->place[hc_selected(selection, number)]);
    const row row = row_of(sweep->walls, hc_row_of(selection, number));
    sums density = {{{0}}}, rate = {{{0}}};
    vector_sums gradient = no_sums();
    for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
      for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
        const int32_t at = pass + part * HC_GROUP;
        const pair p = load_pair(&own, sweep->boundary->place, row.offset + at);
        const hc_float volume = hc_keep(p.scalar, row.count - at);
        density.part[part] = hc_fma(kernel(p.q), volume, density.part[part]);
        if (densities_alone) continue;
        const vector d = direction(&p);
        const hc_float slope = volume * slope_over_q(p.q);
        add_scaled(&gradient, part, slope, &d);
        if (!move) continue;
        hc_float unused;
        const vector velocity = load_velocity(sweep->boundary->motion, row.offset + at, &unused);
        rate.part[part] = hc_fma(slope, dot_pair(&velocity, &p), rate.part[part]);
      }
    }
    hc_store_lanes(density.part, densities.lanes[m]);
    if (move) hc_store_lanes(rate.part, rates.lanes[m]);
    if (!densities_alone) store_vector(&gradients, m, &gradient);
  }
  add_up(&densities, rows->count);
  for (int32_t m = 0; m < rows->count; m++) walls->density[rows->at[m]] = sweep->kernel * densities.total[m];
  if (densities_alone) return;
  add_up_vectors(&gradients, rows->count);
  if (move) add_up(&rates, rows->count);
  for (int32_t m = 0; m < rows->count; m++) {
    walls->gradient[0][rows->at[m]] = sweep->gradient * gradients.x.total[m];
    walls->gradient[1][rows->at[m]] = sweep->gradient * gradients.y.total[m];
    walls->gradient[2][rows->at[m]] = sweep->gradient * gradients.z.total[m];
    walls->rate[rows->at[m]] = move ? sweep->gradient * rates.total[m] : 0.0f;
  }
}

/* The same where the density goes with the square: with N = sum V_b W n_b, n_b the normals times their
 * weights (facing and its scalar's magnitude), and the share D_0 of a flat wall a spacing away, D_w =
 * N.N/D_0, so that grad D_w = 2/D_0 sum V_b (n_b.N) grad W. Samples of walls too thin for normals (scalar 0)
 * count by their volumes as above. */
HC_INLINE void sum_squared_walls(const hc_sweep *sweep, hc_selection selection, int32_t first,
                                 const block_rows *rows, block_walls *walls) {
  block_sums plain, plain_rates;
  block_vectors normals, plain_gradients, gradients[3], rates;
  const bool move = sweep->walls_move;
  for (int32_t m = 0; m < rows->count; m++) {
    const int32_t number = first + rows->at[m];
    const self own = make_self(sweep, &sweep->fluid->place[hc_selected(selection, number)]);
    const row row = row_of(sweep->walls, hc_row_of(selection, number));
    sums density = {{{0}}}, plain_rate = {{{0}}};
    vector_sums normal = no_sums(), plain_gradient = no_sums(), rate = no_sums(),
                gradient[3] = {no_sums(), no_sums(), no_sums()};
    for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
      for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
        const int32_t at = pass + part * HC_GROUP;
        const pair p = load_pair(&own, sweep->boundary->place, row.offset + at);
        const hc_float all = hc_keep(p.scalar, row.count - at);
        hc_float faces, unused;
        const vector n = load_velocity(sweep->boundary->facing, row.offset + at, &faces);
        const hc_float volume = all * hc_max(faces, -faces), shape = kernel(p.q);
        const hc_float of_thin = (hc_float)((hc_int)all & (faces == hc_set(0.0f)));
        add_scaled(&normal, part, volume * shape, &n);
        density.part[part] = hc_fma(of_thin, shape, density.part[part]);
        const vector d = direction(&p);
        const hc_float slope = slope_over_q(p.q);
        add_scaled(&gradient[0], part, volume * slope * p.x, &n);
        add_scaled(&gradient[1], part, volume * slope * p.y, &n);
        add_scaled(&gradient[2], part, volume * slope * p.z, &n);
        add_scaled(&plain_gradient, part, of_thin * slope, &d);
        if (!move) continue;
        const vector velocity = load_velocity(sweep->boundary->motion, row.offset + at, &unused);
        const hc_float along = slope * dot_pair(&velocity, &p);
        add_scaled(&rate, part, volume * along, &n);
        plain_rate.part[part] = hc_fma(of_thin, along, plain_rate.part[part]);
      }
    }
    hc_store_lanes(density.part, plain.lanes[m]);
    if (move) hc_store_lanes(plain_rate.part, plain_rates.lanes[m]);
    store_vector(&normals, m, &normal);
    store_vector(&plain_gradients, m, &plain_gradient);
    for (int axis = 0; axis < 3; axis++) store_vector(&gradients[axis], m, &gradient[axis]);
    if (move) store_vector(&rates, m, &rate);
  }
  const float square = sweep->kernel * sweep->kernel / sweep->flat_wall,
              twice = 2.0f * sweep->kernel * sweep->gradient / sweep->flat_wall;
  add_up(&plain, rows->count);
  add_up_vectors(&normals, rows->count);
  for (int32_t m = 0; m < rows->count; m++) {
    const float x = normals.x.total[m], y = normals.y.total[m], z = normals.z.total[m];
    walls->density[rows->at[m]] = square * (x * x + y * y + z * z) + sweep->kernel * plain.total[m];
  }
  add_up_vectors(&plain_gradients, rows->count);
  for (int axis = 0; axis < 3; axis++) {
    const float *const of_thin = axis == 0   ? plain_gradients.x.total
                                 : axis == 1 ? plain_gradients.y.total
                                             : plain_gradients.z.total;
    add_up_vectors(&gradients[axis], rows->count);
    for (int32_t m = 0; m < rows->count; m++)
      walls->gradient[axis][rows->at[m]] = twice * (gradients[axis].x.total[m] * normals.x.total[m] +
                                                    gradients[axis].y.total[m] * normals.y.total[m] +
                                                    gradients[axis].z.total[m] * normals.z.total[m]) +
                                           sweep->gradient * of_thin[m];
  }
  if (move) add_up_vectors(&rates, rows->count);
  if (move) add_up(&plain_rates, rows->count);
  for (int32_t m = 0; m < rows->count; m++)
    walls->rate[rows->at[m]] =
        move ? twice * (rates.x.total[m] * normals.x.total[m] + rates.y.total[m] * normals.y.total[m] +
                        rates.z.total[m] * normals.z.total[m]) +
                   sweep->gradient * plain_rates.total[m]
             : 0.0f;
}

/* Walls with volumes, by the sweep's rule, or plainly and their densities alone. */
HC_INLINE void sum_walls(const hc_sweep *sweep, hc_selection selection, int32_t first, int32_t count,
                         bool densities_alone, block_walls *walls) {
  const block_rows rows = rows_at_walls(sweep, selection, first, count);
  memset(walls, 0, sizeof *walls);
  if (rows.count == 0) return; /* far from any wall */
  if (sweep->flat_wall > 0.0f && !densities_alone)
    sum_squared_walls(sweep, selection, first, &rows, walls);
  else
    sum_plain_walls(sweep, selection, first, &rows, densities_alone, walls);
}

/* Sums W over the neighbours of targets [first, first + count), or W times the scalar of `weights`, records
 * beside the sources; without the constant. */
HC_INLINE void sum_kernels(const hc_sweep *sweep, const hc_record *targets, const hc_neighbors *list,
                           const hc_record *sources, const hc_record *weights, hc_selection selection,
                           int32_t first, int32_t count, block_sums *kernels) {
  for (int32_t k = 0; k < count; k++) {
    const self own = make_self(sweep, &targets[hc_selected(selection, first + k)]);
    const row row = row_of(list, hc_row_of(selection, first + k));
    sums sum = {{{0}}};
    for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
      for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
        const int32_t at = pass + part * HC_GROUP;
        const pair p = load_pair(&own, sources, row.offset + at);
        hc_float value = kernel(p.q);
        if (weights) {
          hc_float weight;
          load_velocity(weights, row.offset + at, &weight);
          value = value * weight;
        }
        sum.part[part] += hc_keep(value, row.count - at);
      }
    }
    hc_store_lanes(sum.part, kernels->lanes[k]);
  }
  add_up(kernels, count);
}

/* Have rows [first, first + count) of a selection no entries? Says no where they are not one after another.
 */
HC_INLINE bool rows_are_empty(const hc_neighbors *list, hc_selection selection, int32_t first,
                              int32_t count) {
  return !(selection.index && selection.of_all) && hc_list_empty(list, first, first + count);
}

/* Sums (s_i + s_j) grad W over fluid neighbours of a block with s = place.scalar, without the constant. */
HC_INLINE void sum_pressure_gradients(const hc_sweep *sweep, hc_selection selection, int32_t first,
                                      int32_t count, block_vectors *gradients) {
  const hc_record *place = sweep->fluid->place;
  for (int32_t k = 0; k < count; k++) {
    const int32_t i = hc_selected(selection, first + k);
    const self own = make_self(sweep, &place[i]);
    const hc_float scalar = hc_set(place[i].scalar);
    const row row = row_of(sweep->list, hc_row_of(selection, first + k));
    vector_sums sum = no_sums();
    for (int32_t pass = 0; pass < row.entries; pass += 2 * HC_GROUP) {
      for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < row.entries; part++) {
        const int32_t at = pass + part * HC_GROUP;
        const pair p = load_pair(&own, place, row.offset + at);
        const vector d = direction(&p);
        const hc_float factor = (scalar + p.scalar) * slope_over_q(p.q);
        add_scaled(&sum, part, hc_keep_groups(factor, row.entries - at), &d);
      }
    }
    store_vector(gradients, k, &sum);
  }
  add_up_vectors(gradients, count);
}

/* The sweeps that hc_sweeps is put together from, those of the other files. */
typedef void hc_force_sweep(const hc_sweep *sweep, float weight, float *change, hc_selection selection);
hc_force_sweep HC_ISA_SYMBOL(hc_xsph), HC_ISA_SYMBOL(hc_laminar), HC_ISA_SYMBOL(hc_artificial),
    HC_ISA_SYMBOL(hc_cohesion);
void HC_ISA_SYMBOL(hc_smagorinsky)(const hc_sweep *sweep, const hc_eddies *eddies, float *change,
                                   hc_selection selection);
void HC_ISA_SYMBOL(hc_weak_density)(const hc_sweep *sweep, const hc_tait *tait, hc_selection selection,
                                    hc_error_total *total);
void HC_ISA_SYMBOL(hc_weak_forces)(const hc_sweep *sweep, float viscosity, float weight, float *change,
                                   float *rate, hc_selection selection);
void HC_ISA_SYMBOL(hc_wall_layer)(const hc_sweep *sweep, const hc_touch *touches, int32_t count,
                                  hc_wall_around *around);
typedef void hc_prediction_sweep(const hc_sweep *sweep, const hc_prediction *prediction,
                                 hc_selection selection, hc_error_total *total);
hc_prediction_sweep HC_ISA_SYMBOL(hc_predicted_density), HC_ISA_SYMBOL(hc_corrected_density);
void HC_ISA_SYMBOL(hc_boundary_density)(const hc_sweep *sweep, const hc_prediction *prediction,
                                        hc_particles *boundary, const hc_neighbors *wetted,
                                        hc_selection selection);
void HC_ISA_SYMBOL(hc_push)(const hc_sweep *sweep, const hc_prediction *prediction, hc_selection selection);
void HC_ISA_SYMBOL(hc_contacts)(const hc_sweep *sweep, hc_contact_rule rule, hc_record *contacts,
                                hc_selection selection);
void HC_ISA_SYMBOL(hc_wall_velocities)(const hc_sweep *sweep, hc_record *velocities, hc_selection selection);

#endif
