#include "surface_layer.h"

#include "base/memory.h"
#include "surface_region.h"
#include "vector.h"

#include <string.h>

static const double fine = 0.2;        /* spacings between candidates */
static const double longest_mitre = 2; /* of the depth */
static const double thin = 1.5;        /* spacings */
static const double rounding = 1e-6;   /* spacings */
enum { AT_A_TIME = 32 };               /* candidates of a row that share a region */

static const double *vertex_of(const hc_surface_layer *layer, int32_t t, int c) {
  return layer->surface->mesh.vertex[layer->surface->mesh.triangle[t][c]];
}

/* --- Where vertices go --- */

/* Solves (A + small) m = b for a symmetric matrix xx, yy, zz, xy, yz, zx. */
static void solve(const double sum[6], const double b[3], double m[3]) {
  const double small = 1e-6 * (sum[0] + sum[1] + sum[2]);
  const double row[3][3] = {
      {sum[0] + small, sum[3], sum[5]}, {sum[3], sum[1] + small, sum[4]}, {sum[5], sum[4], sum[2] + small}};
  double product[3][3];
  for (int k = 0; k < 3; k++) hc_vector_cross(row[(k + 1) % 3], row[(k + 2) % 3], product[k]);
  const double det = hc_vector_dot(row[0], product[0]);
  for (int a = 0; a < 3; a++)
    m[a] = (b[0] * product[0][a] + b[1] * product[1][a] + b[2] * product[2][a]) / det;
}

/* m of each vertex with n . m = 1 for the normals n of all faces around, as far as there is one. */
static void find_mitres(hc_surface_layer *layer) {
  const hc_mesh *const mesh = &layer->surface->mesh;
  const size_t count = (size_t)mesh->vertex_count;
  double(*const sums)[6] = hc_alloc_zero(count, sizeof *sums);
  double(*const b)[3] = hc_alloc_zero(count, sizeof *b);
  double *const weights = hc_alloc_zero(count, sizeof *weights);
  for (int32_t t = 0; t < mesh->triangle_count; t++)
    for (int c = 0; c < 3; c++) {
      const double *const n = layer->surface->face_normal[t];
      double next[3], last[3];
      hc_vector_minus(vertex_of(layer, t, (c + 1) % 3), vertex_of(layer, t, c), next);
      hc_vector_minus(vertex_of(layer, t, (c + 2) % 3), vertex_of(layer, t, c), last);
      const double angle = hc_vector_angle(next, last);
      const int32_t v = mesh->triangle[t][c];
      weights[v] += angle;
      for (int a = 0; a < 3; a++) {
        sums[v][a] += angle * n[a] * n[a];
        sums[v][3 + a] += angle * n[a] * n[(a + 1) % 3];
        b[v][a] += angle * n[a];
      }
    }
  layer->mitre = hc_alloc(count, sizeof *layer->mitre);
  for (size_t v = 0; v < count; v++) {
    double *const m = layer->mitre[v];
    if (!(weights[v] > 0)) { /* of no triangle */
      m[0] = m[1] = m[2] = 0;
      continue;
    }
    solve(sums[v], b[v], m);
    const double reached = hc_vector_dot(m, b[v]) / weights[v]; /* 1 in the mean, but for `small` */
    const double length = hc_vector_length(m) / reached;
    const double scale = (length > longest_mitre ? longest_mitre / length : 1) / reached;
    for (int a = 0; a < 3; a++) m[a] *= scale;
  }
  hc_free(sums);
  hc_free(b);
  hc_free(weights);
}

void hc_surface_layer_vertex(const hc_surface_layer *layer, int32_t v, double x[3]) {
  for (int a = 0; a < 3; a++)
    x[a] = layer->surface->mesh.vertex[v][a] - layer->side * layer->depth * layer->mitre[v][a];
}

hc_surface_layer hc_surface_layer_make(const hc_surface *surface, double spacing, int number,
                                       bool fluid_inside) {
  hc_surface_layer layer = {.surface = surface,
                            .spacing = spacing,
                            .depth = (0.5 + number) * spacing,
                            .side = fluid_inside ? -1 : 1,
                            .number = number};
  find_mitres(&layer);
  return layer;
}

void hc_surface_layer_free(hc_surface_layer *layer) {
  hc_free(layer->mitre);
  *layer = (hc_surface_layer){0};
}

/* --- Places on the faces --- */

/* A triangle and where it goes, for its candidates: corner 2 is across from the longest side. */
typedef struct facet {
  int32_t triangle;
  int corner[3];
  double from[3][3], to[3][3];
  double base, height; /* the larger of both triangles' */
} facet;

static double measure(const double *const corner[3], double *longest, int *side) {
  double edge[3][3], product[3];
  for (int c = 0; c < 3; c++) {
    hc_vector_minus(corner[(c + 1) % 3], corner[c], edge[c]);
    const double length = hc_vector_length(edge[c]);
    if (length <= *longest) continue;
    *longest = length;
    *side = c;
  }
  hc_vector_cross(edge[0], edge[1], product);
  return hc_vector_length(product);
}

static facet facet_of(const hc_surface_layer *layer, int32_t t) {
  facet f = {.triangle = t};
  double moved[3][3];
  const double *from[3], *const to[3] = {moved[0], moved[1], moved[2]};
  int side = 0;
  for (int c = 0; c < 3; c++) {
    from[c] = vertex_of(layer, t, c);
    hc_surface_layer_vertex(layer, layer->surface->mesh.triangle[t][c], moved[c]);
  }
  const double twice = measure(from, &f.base, &side), twice_moved = measure(to, &f.base, &side);
  f.height = fmax(twice, twice_moved) / f.base;
  for (int c = 0; c < 3; c++) {
    f.corner[c] = (side + c) % 3;
    memcpy(f.from[c], from[f.corner[c]], sizeof f.from[c]);
    memcpy(f.to[c], moved[f.corner[c]], sizeof f.to[c]);
  }
  return f;
}

/* Places are in rows along the longest side, the first on it: so that nothing is left out where triangles are
 * slim. */
static double rows_of(const hc_surface_layer *layer, const facet *f) {
  return fmax(1, ceil(f->height / (fine * layer->spacing)));
}

static double places_in(const hc_surface_layer *layer, const facet *f, double row, double rows) {
  return fmax(1, ceil((1 - row / rows) * f->base / (fine * layer->spacing)));
}

static int64_t places_of(const hc_surface_layer *layer, const facet *f) {
  const double rows = rows_of(layer, f);
  int64_t sum = 0;
  for (double row = 0; row < rows; row++) sum += (int64_t)places_in(layer, f, row, rows);
  return sum;
}

double hc_surface_layer_estimate(const hc_surface_layer *layer) {
  double sum = 0;
  for (int32_t t = 0; t < layer->surface->mesh.triangle_count; t++) {
    const facet f = facet_of(layer, t);
    sum += rows_of(layer, &f) * (1 + 0.5 * f.base / (fine * layer->spacing));
  }
  return sum;
}

int64_t hc_surface_layer_places(const hc_surface_layer *layer) {
  int64_t sum = 0;
  for (int32_t t = 0; t < layer->surface->mesh.triangle_count; t++) {
    const facet f = facet_of(layer, t);
    sum += places_of(layer, &f);
  }
  return sum;
}

/* --- Candidates at the places --- */

/* Candidates of a facet being made, and what is around those made now: of a small facet all, else a part of a
 * row. */
typedef struct making {
  const hc_surface_layer *layer;
  facet f;
  double inward[3];
  hc_surface_region region;
  double reach; /* that the region has around the moved facet */
  bool faced;   /* something in the region faces inward */
  hc_sample_candidates *made;
} making;

static void mix(const double (*corner)[3], const double share[3], double x[3]) {
  for (int a = 0; a < 3; a++)
    x[a] = share[0] * corner[0][a] + share[1] * corner[1][a] + share[2] * corner[2][a];
}

/* The facet's triangle says how far the nearest point can be. */
static double depth_at(const making *m, const double x[3], hc_surface_point *nearest) {
  const hc_surface *const surface = m->layer->surface;
  const double within = hc_surface_square(surface, m->f.triangle, x) * (1 + 1e-9) + 1e-300;
  const hc_surface_node *const nodes =
      hc_surface_region_holds(&m->region, x, sqrt(within)) ? m->region.nodes : surface->nodes;
  *nearest = hc_surface_nearest_among(surface, nodes, x, within);
  return -m->layer->side * hc_surface_signed(surface, x, nearest);
}

/* Brings a point to its depth where the moved faces are not deep enough; false if that does not do. */
static bool settle(const making *m, double x[3]) {
  const double wanted = m->layer->depth;
  for (int round = 0; round < 4; round++) {
    hc_surface_point nearest;
    const double depth = depth_at(m, x, &nearest);
    if (depth >= (round < 3 ? 1 - 1e-6 : hc_surface_layer_deep) * wanted) return true;
    if (!(depth > 0.3 * wanted)) return false;
    for (int a = 0; a < 3; a++) x[a] += (x[a] - nearest.x[a]) / depth * (wanted - depth);
  }
  return false;
}

/* The candidate at these shares of the facet's corners, if there is one. */
static void add_candidate(making *m, const double share[3]) {
  const hc_surface_layer *const layer = m->layer;
  double from[3], x[3];
  mix(m->f.from, share, from);
  mix(m->f.to, share, x);
  const double limit = thin * layer->spacing * (1 - 1e-6);
  const double thickness =
      m->faced ? hc_surface_ray(layer->surface, m->region.nodes, from, m->inward, layer->side, limit) : limit;
  if (thickness >= limit) {
    if (settle(m, x)) hc_sample_candidates_add(m->made, x, m->f.triangle);
    return;
  }
  if (layer->number > 0) return;
  hc_surface_point nearest;
  for (int a = 0; a < 3; a++) x[a] = from[a] + 0.5 * thickness * m->inward[a];
  if (depth_at(m, x, &nearest) >= hc_surface_layer_deep * 0.5 * thickness)
    hc_sample_candidates_add(m->made, x, -1);
}

static void widen(const double x[3], double low[3], double high[3]) {
  for (int a = 0; a < 3; a++) {
    low[a] = fmin(low[a], x[a]);
    high[a] = fmax(high[a], x[a]);
  }
}

/* Looks at what is around the points with such shares of the facet's corners, and inward of them. */
static void look_around(making *m, const double (*share)[3], int count) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (int k = 0; k < count; k++) {
    double from[3], to[3], in[3];
    mix(m->f.from, share[k], from);
    mix(m->f.to, share[k], to);
    for (int a = 0; a < 3; a++) in[a] = from[a] + thin * m->layer->spacing * m->inward[a];
    widen(from, low, high);
    widen(in, low, high);
    for (int a = 0; a < 3; a++) {
      low[a] = fmin(low[a], to[a] - m->reach);
      high[a] = fmax(high[a], to[a] + m->reach);
    }
  }
  for (int a = 0; a < 3; a++) {
    low[a] -= rounding * m->layer->spacing;
    high[a] += rounding * m->layer->spacing;
  }
  hc_surface_region_take(&m->region, m->layer->surface, low, high);
  m->faced = hc_surface_region_faces(&m->region, m->layer->surface, m->inward, m->layer->side);
}

static void share_at(double third, double place, double places, double share[3]) {
  const double rest = 1 - third, second = rest * (place + 0.5) / places;
  share[0] = rest - second;
  share[1] = second;
  share[2] = third;
}

/* Those of the facet's places in [first, last). */
static void make_candidates(making *m, int64_t first, int64_t last) {
  static const double corners[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const double rows = rows_of(m->layer, &m->f);
  const bool small = places_of(m->layer, &m->f) <= 2 * AT_A_TIME;
  if (small) look_around(m, corners, 3);
  int64_t before = 0;
  for (double row = 0; row < rows && before < last; row++) {
    const double places = places_in(m->layer, &m->f, row, rows);
    const int64_t from = first > before ? first - before : 0;
    const int64_t to = last - before < (int64_t)places ? last - before : (int64_t)places;
    for (int64_t place = from; place < to; place++) {
      double share[2][3];
      share_at(row / rows, (double)place, places, share[0]);
      if (!small && (place - from) % AT_A_TIME == 0) {
        const int64_t end = place + AT_A_TIME < to ? place + AT_A_TIME : to;
        share_at(row / rows, (double)(end - 1), places, share[1]);
        look_around(m, (const double(*)[3])share, 2);
      }
      add_candidate(m, share[0]);
    }
    before += (int64_t)places;
  }
}

/* How far the facet goes at most, and room for what settles. */
static double reach_of(const hc_surface_layer *layer, const facet *f) {
  double square = 0;
  for (int c = 0; c < 3; c++) {
    double way[3];
    hc_vector_minus(f->to[c], f->from[c], way);
    square = fmax(square, hc_vector_dot(way, way));
  }
  return sqrt(square) + 0.1 * layer->spacing;
}

hc_sample_candidates hc_surface_layer_candidates(const hc_surface_layer *layer, int64_t first, int64_t last) {
  hc_sample_candidates made = hc_sample_candidates_make(last - first);
  making m = {.layer = layer, .made = &made};
  int64_t before = 0;
  for (int32_t t = 0; t < layer->surface->mesh.triangle_count && before < last; t++) {
    m.f = facet_of(layer, t);
    const int64_t places = places_of(layer, &m.f);
    if (before + places > first) {
      m.reach = reach_of(layer, &m.f);
      for (int a = 0; a < 3; a++) m.inward[a] = -layer->side * layer->surface->face_normal[t][a];
      make_candidates(&m, first - before, last - before);
    }
    before += places;
  }
  hc_surface_region_free(&m.region);
  return made;
}
