/* Forces between particles besides the pressure, compiled once per instruction set. See sweeps.h for what
 * each computes. */
#include "pairs.h"

/* What of the particle itself a viscous force needs. */
typedef struct viscous_self {
  vector velocity;
  hc_float inverse_density;
  vector normal;                           /* of the wall, of unit length or zero */
  hc_float distance;                       /* from walls of frozen fluid, in support radii */
  hc_float molecular, eddies, most_eddies; /* see hc_eddies; the same for all */
} viscous_self;

/* Adds one pair's viscous force. `volume` is the neighbours', 0 in lanes to drop. */
typedef void viscous_pair(vector_sums *sum, int part, const viscous_self *own, const pair *p,
                          const vector *relative, hc_float volume, hc_float inverse_density);

HC_INLINE void pair_xsph(vector_sums *sum, int part, const viscous_self *own, const pair *p,
                         const vector *relative, hc_float volume, hc_float inverse_density) {
  add_xsph(sum, part, p, relative, volume, own->inverse_density + inverse_density);
}

HC_INLINE void pair_laminar(vector_sums *sum, int part, const viscous_self *own, const pair *p,
                            const vector *relative, hc_float volume, hc_float inverse_density) {
  (void)own, (void)inverse_density;
  /* x . grad W/(r^2 + 0.01 (h/2)^2) = q^2 (W'(q)/q)/(q^2 + 0.0025) / h^2 */
  add_scaled(sum, part, volume * slope_over_q(p->q) * p->q2 / (p->q2 + hc_set(HC_GUARD)), relative);
}

HC_INLINE void pair_smagorinsky(vector_sums *sum, int part, const viscous_self *own, const pair *p,
                                const vector *relative, hc_float volume, hc_float inverse_density) {
  (void)inverse_density;
  const hc_float inverse = hc_set(1.0f) / (p->q2 + hc_set(HC_GUARD)), v2 = dot(relative, relative);
  const hc_float eddies = hc_min(own->eddies * hc_sqrt(v2 * inverse), own->most_eddies);
  add_scaled(sum, part, volume * slope_over_q(p->q) * (p->q2 * inverse) * (own->molecular + eddies),
             relative);
}

HC_INLINE void pair_artificial(vector_sums *sum, int part, const viscous_self *own, const pair *p,
                               const vector *relative, hc_float volume, hc_float inverse_density) {
  (void)own, (void)inverse_density;
  const hc_float approach = hc_min(dot_pair(relative, p), hc_set(0.0f));
  const vector d = direction(p);
  add_scaled(sum, part, volume * approach * slope_over_q(p->q) / (p->q2 + hc_set(HC_GUARD)), &d);
}

/* From the velocity relative to the wall to that relative to its sample behind the wetted surface. */
HC_INLINE vector relative_to_surface(const hc_sweep *sweep, const viscous_self *own, const pair *p,
                                     const vector *relative) {
  const hc_float behind = hc_set(sweep->wall_offset), distance = dot_pair(&own->normal, p);
  const hc_float before = hc_max(hc_max(distance, hc_set(0.0f) - distance) - behind, behind);
  const hc_float factor = hc_set(1.0f) + behind / before;
  return (vector){factor * relative->x, factor * relative->y, factor * relative->z};
}

/* The same for a sample of frozen fluid that looks where `facing` says: the deeper the layer it is of, the
 * more. */
HC_INLINE vector relative_to_layer(const hc_sweep *sweep, const viscous_self *own, const pair *p,
                                   const vector *facing, const vector *relative) {
  const hc_float behind = hc_set(sweep->wall_offset), height = dot_pair(facing, p);
  const hc_float before = hc_max(own->distance, behind), depth = hc_max(height - own->distance, behind);
  const hc_float factor = hc_set(1.0f) + hc_min(depth / before, hc_set(3.0f));
  return (vector){factor * relative->x, factor * relative->y, factor * relative->z};
}

/* How far a particle is from the surface in front of the samples in its row, in support radii: the nearest
 * are half a spacing behind it. */
static float distance_from_walls(const hc_sweep *sweep, int32_t i, const uint32_t *offset, int32_t count) {
  double least = 1.0;
  for (int32_t k = 0; k < count; k++) {
    const size_t b = offset[k] / sizeof(hc_record);
    double height = 0.0;
    for (int axis = 0; axis < 3; axis++)
      height += (double)(int32_t)((uint32_t)sweep->fluid->place[i].x[axis] -
                                  (uint32_t)sweep->boundary->place[b].x[axis]) *
                sweep->scale[axis] * sweep->boundary->facing[b].v[axis];
    if (height > 0.0 && height < least) least = height;
  }
  return (float)(least - sweep->wall_offset);
}

HC_INLINE vector wall_normal(const float gradient[3]) {
  const float square = gradient[0] * gradient[0] + gradient[1] * gradient[1] + gradient[2] * gradient[2];
  const float scale = square > 0.0f ? 1.0f / sqrtf(square) : 0.0f;
  return (vector){hc_set(scale * gradient[0]), hc_set(scale * gradient[1]), hc_set(scale * gradient[2])};
}

/* Pulls towards the neighbours, whatever their velocity. */
HC_INLINE void pair_cohesion(vector_sums *sum, int part, const viscous_self *own, const pair *p,
                             const vector *relative, hc_float volume, hc_float inverse_density) {
  (void)own, (void)relative, (void)inverse_density;
  const vector d = direction(p);
  add_scaled(sum, part, volume * kernel(p->q), &d);
}

/* How walls take part: not at all, as particles, or holding the fluid at the wetted surface. */
typedef enum wall_part { NO_WALLS, AS_PARTICLES, NO_SLIP } wall_part;

/* Whether a sweep's changes take the place of what is there or come on top. */
typedef enum change_mode { SET_CHANGE, ADD_CHANGE } change_mode;

HC_INLINE void viscous(const hc_sweep *sweep, viscous_pair *add, wall_part walls_are, change_mode mode,
                       const hc_eddies *eddies, float weight, float *change, hc_selection selection) {
  const hc_particles *fluid = sweep->fluid;
  expect_ready(fluid, HC_WHOLE(place) | HC_WHOLE(motion) | HC_SCALAR(motion), fluid, selection);
  expect_walls(sweep);
  const hc_float volume = hc_set(sweep->volume);
  const bool frozen = walls_are == NO_SLIP && sweep->walls_add == HC_WALLS_PRESSURE; /* volumes of fluid */
  const bool walls_take_part = walls_are != NO_WALLS && (walls_are != NO_SLIP || sweep->no_slip) &&
                               (sweep->walls_add == HC_WALLS_MIRRORED || frozen); /* else no volumes */
  if (walls_take_part && !frozen) EXPECT_FIELD(fluid, wall_gradient);
  if (frozen) EXPECT_FIELD(sweep->boundary, facing);
  block_vectors changes;
  for (int32_t first = selection.begin; first < selection.end; first += BLOCK) {
    const int32_t count = block_size(first, selection.end);
    for (int32_t k = 0; k < count; k++) {
      const int32_t i = hc_selected(selection, first + k);
      const self own = make_self(sweep, &fluid->place[i]);
      const struct row walls = row_of(sweep->walls, hc_row_of(selection, first + k));
      viscous_self state = {.velocity = spread_velocity(&fluid->motion[i]),
                            .inverse_density = hc_set(fluid->motion[i].scalar),
                            .normal = {hc_set(0.0f), hc_set(0.0f), hc_set(0.0f)},
                            .distance = hc_set(0.0f),
                            .molecular = hc_set(eddies->molecular),
                            .eddies = hc_set(eddies->scale),
                            .most_eddies = hc_set(eddies->most)};
      if (walls_take_part && !frozen) state.normal = wall_normal(&fluid->wall_gradient[3 * (size_t)i]);
      if (frozen) state.distance = hc_set(distance_from_walls(sweep, i, walls.offset, walls.count));
      vector_sums sum = no_sums();
      const row row = row_of(sweep->list, hc_row_of(selection, first + k));
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
      for (int32_t pass = 0; walls_take_part && pass < walls.entries; pass += 2 * HC_GROUP) {
        for (int part = 0; part < HC_PARTS && pass + part * HC_GROUP < walls.entries; part++) {
          const int32_t at = pass + part * HC_GROUP;
          const pair p = load_pair(&own, sweep->boundary->place, walls.offset + at);
          vector relative = state.velocity;
          if (sweep->walls_move) {
            hc_float unused;
            const vector other = load_velocity(sweep->boundary->motion, walls.offset + at, &unused);
            relative = relative_velocity(&state.velocity, &other);
          }
          if (frozen) {
            hc_float unused;
            const vector facing = load_velocity(sweep->boundary->facing, walls.offset + at, &unused);
            relative = relative_to_layer(sweep, &state, &p, &facing, &relative);
          } else if (walls_are == NO_SLIP) {
            relative = relative_to_surface(sweep, &state, &p, &relative);
          }
          add(&sum, part, &state, &p, &relative, hc_keep(frozen ? volume : p.scalar, walls.count - at),
              hc_set(1.0f));
        }
      }
      store_vector(&changes, k, &sum);
    }
    add_up_vectors(&changes, count);
    for (int32_t k = 0; k < count; k++) {
      float *to = &change[3 * (size_t)hc_selected(selection, first + k)];
      const float sum[3] = {changes.x.total[k], changes.y.total[k], changes.z.total[k]};
      for (int axis = 0; axis < 3; axis++)
        to[axis] = mode == ADD_CHANGE ? to[axis] + weight * sum[axis] : weight * sum[axis];
    }
  }
}

static const hc_eddies no_eddies = {0};

void HC_ISA_SYMBOL(hc_xsph)(const hc_sweep *sweep, float weight, float *change, hc_selection selection) {
  viscous(sweep, pair_xsph, NO_WALLS, SET_CHANGE, &no_eddies, xsph_scale(sweep, weight), change, selection);
}

void HC_ISA_SYMBOL(hc_laminar)(const hc_sweep *sweep, float weight, float *change, hc_selection selection) {
  viscous(sweep, pair_laminar, NO_SLIP, SET_CHANGE, &no_eddies,
          2.0f * weight * sweep->gradient / sweep->support, change, selection);
}

/* nu dt comes in squares of the support radius: two lengths of grad W / r are in it, the kernel's constant is
 * left. */
void HC_ISA_SYMBOL(hc_smagorinsky)(const hc_sweep *sweep, const hc_eddies *eddies, float *change,
                                   hc_selection selection) {
  viscous(sweep, pair_smagorinsky, NO_WALLS, SET_CHANGE, eddies, 2.0f * sweep->kernel, change, selection);
}

void HC_ISA_SYMBOL(hc_artificial)(const hc_sweep *sweep, float weight, float *change,
                                  hc_selection selection) {
  viscous(sweep, pair_artificial, AS_PARTICLES, SET_CHANGE, &no_eddies,
          weight * sweep->gradient / sweep->support, change, selection);
}

void HC_ISA_SYMBOL(hc_cohesion)(const hc_sweep *sweep, float weight, float *change, hc_selection selection) {
  const float scale =
      -weight * sweep->kernel * sweep->support / sweep->volume; /* pairs are weighed with it */
  viscous(sweep, pair_cohesion, NO_WALLS, ADD_CHANGE, &no_eddies, scale, change, selection);
}
