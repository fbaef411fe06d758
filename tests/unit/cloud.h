/* A cloud of particles with walls through it, and what the kernel is in plain double precision: what tests of
 * pair sweeps are made with. Included by one test each. */
#ifndef HC_CLOUD_H
#define HC_CLOUD_H

#include "base/memory.h"
#include "sph/sweeps.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double H = 0.04, REST_DENSITY = 1000.0, VOLUME = 8e-6, PI = 3.14159265358979323846;
static const double TOLERANCE = 1e-5; /* of the sum of the terms' magnitudes */

/* splitmix64's mixer. */
static inline uint64_t mix(uint64_t value) {
  value += 0x9e3779b97f4a7c15;
  value = (value ^ value >> 30) * 0xbf58476d1ce4e5b9;
  value = (value ^ value >> 27) * 0x94d049bb133111eb;
  return value ^ value >> 31;
}

/* In [-1, 1). */
static inline double random_number(uint64_t seed) {
  return (double)(int64_t)mix(seed) * 0x1p-63;
}

/* Fluid, boundary and all that a sweep reads. */
typedef struct setting {
  hc_frame frame;
  hc_particles fluid, boundary;
  hc_cells cells, boundary_cells;
  hc_neighbors list, walls, wetted, boundary_list;
  hc_sweep sweep;
} setting;

static inline void setting_init(setting *s, double stretch_y) {
  memset(s, 0, sizeof *s);
  s->frame.support_radius = H;
  for (int axis = 0; axis < 3; axis++)
    s->frame.unit[axis] = H / (double)HC_CELL_UNITS * (axis == 1 ? stretch_y : 1.0);
  hc_particles_init(&s->fluid, HC_FLUID, HC_FOR_ALL);
  hc_particles_init(&s->boundary, HC_BOUNDARY, HC_FOR_ALL);
  hc_cells_init(&s->cells);
  hc_cells_init(&s->boundary_cells);
  hc_neighbors_init(&s->list);
  hc_neighbors_init(&s->walls);
  hc_neighbors_init(&s->wetted);
  hc_neighbors_init(&s->boundary_list);
  s->sweep = hc_sweep_make(&s->frame, VOLUME, REST_DENSITY);
  s->sweep.walls_add = HC_WALLS_MIRRORED;
  s->sweep.no_slip = true;
  s->sweep.fluid = &s->fluid;
  s->sweep.boundary = &s->boundary;
  s->sweep.list = &s->list;
  s->sweep.walls = &s->walls;
}

static inline void setting_free(setting *s) {
  hc_particles_free(&s->fluid);
  hc_particles_free(&s->boundary);
  hc_cells_free(&s->cells);
  hc_cells_free(&s->boundary_cells);
  hc_neighbors_free(&s->list);
  hc_neighbors_free(&s->walls);
  hc_neighbors_free(&s->wetted);
  hc_neighbors_free(&s->boundary_list);
}

/* Sorts both sets and finds all neighbours. The values of a particle follow from its id afterwards. */
static inline void settle(setting *s) {
  for (int32_t k = 0; k < s->fluid.own; k++) s->fluid.id[k] = (uint64_t)k;
  for (int32_t k = 0; k < s->boundary.own; k++) s->boundary.id[k] = (uint64_t)k;
  hc_cells_bin(&s->cells, &s->fluid);
  hc_cells_order(&s->cells, &s->fluid);
  hc_particles_set_ghosts(&s->fluid, 0);
  hc_cells_bin(&s->boundary_cells, &s->boundary);
  hc_cells_order(&s->boundary_cells, &s->boundary);
  hc_particles_set_ghosts(&s->boundary, 0);
  hc_neighbor_search search;
  hc_neighbor_search_init(&search, HC_ISA_PORTABLE);
  hc_neighbors_build(&s->list, &search, &s->cells, &s->fluid, hc_select_all(&s->fluid),
                     &(hc_neighbor_source){&s->cells, &s->fluid}, 1);
  hc_neighbors_build(&s->walls, &search, &s->cells, &s->fluid, hc_select_all(&s->fluid),
                     &(hc_neighbor_source){&s->boundary_cells, &s->boundary}, 1);
  hc_neighbors_build(&s->wetted, &search, &s->boundary_cells, &s->boundary, hc_select_all(&s->boundary),
                     &(hc_neighbor_source){&s->cells, &s->fluid}, 1);
  hc_neighbors_build(&s->boundary_list, &search, &s->boundary_cells, &s->boundary,
                     hc_select_all(&s->boundary), &(hc_neighbor_source){&s->boundary_cells, &s->boundary}, 1);
  hc_neighbor_search_free(&search);
}

static inline double velocity_of(uint64_t id, int axis) {
  return 0.7 * random_number(5 * id + (uint64_t)axis);
}
/* Read only where walls move. */
static inline double wall_velocity_of(uint64_t id, int axis) {
  return 0.5 * random_number(17 * id + (uint64_t)axis + 999);
}
static inline float kappa_of(uint64_t id) {
  return (float)(1e-6 * random_number(11 * id + 3));
}
static inline float boundary_volume_of(uint64_t id) {
  return (float)(VOLUME * (0.7 + 0.3 * random_number(13 * id)));
}

/* Puts every value that sweeps change back to what it was. */
static inline void set_values(setting *s) {
  for (int32_t k = 0; k < s->fluid.own; k++) {
    const uint64_t id = s->fluid.id[k];
    for (int axis = 0; axis < 3; axis++) {
      s->fluid.velocity[3 * k + axis] = velocity_of(id, axis);
      s->fluid.motion[k].v[axis] = (float)velocity_of(id, axis);
    }
    s->fluid.motion[k].scalar = 1.0f;
    s->fluid.place[k].scalar = kappa_of(id);
    s->fluid.pressure_multiplier[k] = 0.25f * kappa_of(id + 1);
  }
  for (int32_t k = 0; k < s->boundary.own; k++) {
    const uint64_t id = s->boundary.id[k];
    s->boundary.volume[k] = s->boundary.place[k].scalar = boundary_volume_of(id);
    for (int axis = 0; axis < 3; axis++) s->boundary.motion[k].v[axis] = (float)wall_velocity_of(id, axis);
  }
}

/* A cloud at about the rest density, a few particles alone and far away, and walls through the cloud. */
static inline void make_cloud(setting *s, int32_t fluid, int32_t boundary) {
  setting_init(s, 1.07);
  hc_particles_resize(&s->fluid, fluid);
  hc_particles_resize(&s->boundary, boundary);
  const double edge = cbrt(fluid / 8.0);
  for (int32_t k = 0; k < fluid; k++)
    for (int axis = 0; axis < 3; axis++)
      s->fluid.position[3 * k + axis] =
          (int64_t)(0.5 * edge * random_number((uint64_t)(3 * k + axis)) * (double)HC_CELL_UNITS) +
          (k < 5 ? 10 * (k + 1) * HC_CELL_UNITS : 0);
  for (int32_t k = 0; k < boundary; k++)
    for (int axis = 0; axis < 3; axis++)
      s->boundary.position[3 * k + axis] =
          (int64_t)((axis == 2 ? 0.1 : 0.5 * edge) * random_number((uint64_t)(3 * k + axis) + 77777) *
                    (double)HC_CELL_UNITS);
  settle(s);
  set_values(s);
}

/* ---- the plain reference ---- */

/* W and dW/dr as sweeps.h has them. */
static inline double kernel(double r) {
  const double q = r / H, outer = fmax(1 - q, 0), inner = fmax(0.5 - q, 0);
  return 8 / (PI * H * H * H) * (2 * outer * outer * outer - 8 * inner * inner * inner);
}
static inline double slope(double r) {
  const double q = r / H, outer = fmax(1 - q, 0), inner = fmax(0.5 - q, 0);
  return 8 / (PI * H * H * H * H) * (-6 * outer * outer + 24 * inner * inner);
}

typedef struct vec {
  double x[3];
} vec;

static inline double dot(vec a, vec b) {
  return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2];
}
static inline double norm(vec a) {
  return sqrt(dot(a, a));
}
static inline void add(vec *sum, double factor, vec a) {
  for (int axis = 0; axis < 3; axis++) sum->x[axis] += factor * a.x[axis];
}

static inline vec separation(const setting *s, const hc_particles *a, int32_t i, const hc_particles *b,
                             int32_t j) {
  vec d;
  for (int axis = 0; axis < 3; axis++)
    d.x[axis] = (double)(a->position[3 * i + axis] - b->position[3 * j + axis]) * s->frame.unit[axis];
  return d;
}

static inline vec gradient(vec x) {
  vec result = {{0, 0, 0}};
  const double r = norm(x);
  if (r > 0) add(&result, slope(r) / r, x);
  return result;
}

#endif
