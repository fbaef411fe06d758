#include "surface_samples.h"

#include "base/memory.h"
#include "sample_set.h"
#include "vector.h"

#include <string.h>

static const double fine = 0.2;         /* spacings between candidates */
static const double apart = 0.9;        /* spacings: how far the first choice of samples keeps apart */
static const double crowded = 0.73;     /* spacings: closer in the end is too close */
static const double hole = 0.73;        /* spacings: a candidate farther from all samples becomes one */
static const double beside = 0.72;      /* spacings: what creases and layers keep from each other */
static const double near_enough = 0.93; /* of the depth that is meant */
static const double longest_mitre = 2;  /* of the depth */
static const double thin = 1.5;         /* spacings */
enum { PASSES = 3, ROUNDS = 5 };
static const double most_candidates = 1 << 24;

/* A surface being sampled at one depth. */
typedef struct work {
  const hc_surface *surface;
  double spacing, depth;
  double side; /* 1: the fluid is where the normals point to; -1: on the other side */
  bool first_layer;
  double (*mitre)[3]; /* of each vertex: where it goes, over the depth, against the fluid's normal */
  hc_sample_set samples;
  hc_sample_candidates candidates;
} work;

static const double *vertex_of(const work *w, int32_t t, int c) {
  return w->surface->mesh.vertex[w->surface->mesh.triangle[t][c]];
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
static void find_mitres(work *w) {
  const hc_mesh *const mesh = &w->surface->mesh;
  const size_t count = (size_t)mesh->vertex_count;
  double(*const sums)[6] = hc_alloc_zero(count, sizeof *sums);
  double(*const b)[3] = hc_alloc_zero(count, sizeof *b);
  double *const weights = hc_alloc_zero(count, sizeof *weights);
  for (int32_t t = 0; t < mesh->triangle_count; t++)
    for (int c = 0; c < 3; c++) {
      const double *const n = w->surface->face_normal[t];
      double next[3], last[3];
      hc_vector_minus(vertex_of(w, t, (c + 1) % 3), vertex_of(w, t, c), next);
      hc_vector_minus(vertex_of(w, t, (c + 2) % 3), vertex_of(w, t, c), last);
      const double angle = hc_vector_angle(next, last);
      const int32_t v = mesh->triangle[t][c];
      weights[v] += angle;
      for (int a = 0; a < 3; a++) {
        sums[v][a] += angle * n[a] * n[a];
        sums[v][3 + a] += angle * n[a] * n[(a + 1) % 3];
        b[v][a] += angle * n[a];
      }
    }
  w->mitre = hc_alloc(count, sizeof *w->mitre);
  for (size_t v = 0; v < count; v++) {
    double *const m = w->mitre[v];
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

static void moved_vertex(const work *w, int32_t v, double x[3]) {
  for (int a = 0; a < 3; a++) x[a] = w->surface->mesh.vertex[v][a] - w->side * w->depth * w->mitre[v][a];
}

/* How deep in the wall a point is, below 0 in the fluid. */
static double depth_at(const work *w, const double x[3], hc_surface_point *nearest) {
  return -w->side * hc_surface_signed_distance(w->surface, x, nearest);
}

/* Brings a point to its depth where the moved faces are not deep enough; false if that does not do. */
static bool settle(const work *w, double x[3]) {
  for (int round = 0; round < 4; round++) {
    hc_surface_point nearest;
    const double depth = depth_at(w, x, &nearest);
    if (depth >= (round < 3 ? 1 - 1e-6 : near_enough) * w->depth) return true;
    if (!(depth > 0.3 * w->depth)) return false;
    for (int a = 0; a < 3; a++) x[a] += (x[a] - nearest.x[a]) / depth * (w->depth - depth);
  }
  return false;
}

/* --- Corners and creases --- */

static void add_sample(work *w, const double x[3], const double normal[3]) {
  double settled[3] = {x[0], x[1], x[2]}, unit[3];
  if (depth_at(w, settled, NULL) < near_enough * w->depth) return;
  if (hc_sample_set_any_within(&w->samples, settled, beside * w->spacing)) return;
  for (int a = 0; a < 3; a++) unit[a] = w->side * normal[a];
  hc_vector_normalize(unit);
  hc_sample_set_add(&w->samples, settled, unit, -1);
}

/* A crease: side `side` of a triangle, seen from its first or second vertex. */
typedef struct arm {
  int32_t triangle, from, to;
  int8_t side;
  bool used;
} arm;

/* The creases, each from both its ends, sorted by the vertex they leave: those of v are arms[start[v]] on. */
typedef struct creases {
  arm *arms;
  int32_t *start;
} creases;

static bool is_first_side(const hc_surface *surface, int32_t t, int side) {
  const int32_t beyond = surface->mesh.neighbour[t][side];
  return beyond < 0 || t < beyond;
}

static creases find_creases(const work *w) {
  const hc_mesh *const mesh = &w->surface->mesh;
  creases c = {NULL, hc_alloc_zero((size_t)mesh->vertex_count + 2, sizeof *c.start)};
  for (int pass = 0; pass < 2; pass++) { /* counts two places on, then fills one on */
    for (int32_t t = 0; t < mesh->triangle_count; t++)
      for (int side = 0; side < 3; side++) {
        if (!is_first_side(w->surface, t, side) || !hc_surface_crease(w->surface, t, side)) continue;
        const int32_t end[2] = {mesh->triangle[t][side], mesh->triangle[t][(side + 1) % 3]};
        for (int k = 0; k < 2; k++) {
          if (pass == 0)
            c.start[end[k] + 2]++;
          else
            c.arms[c.start[end[k] + 1]++] = (arm){t, end[k], end[!k], (int8_t)side, false};
        }
      }
    if (pass == 1) break;
    for (int32_t v = 0; v < mesh->vertex_count; v++) c.start[v + 2] += c.start[v + 1];
    c.arms = hc_alloc((size_t)c.start[mesh->vertex_count + 1], sizeof *c.arms);
  }
  return c;
}

/* Whether creases end here, meet, or make a turn. */
static bool is_corner(const work *w, const creases *c, int32_t v) {
  const int32_t count = c->start[v + 1] - c->start[v];
  if (count != 2) return count > 0;
  double way[2][3];
  for (int k = 0; k < 2; k++) {
    hc_vector_minus(w->surface->mesh.vertex[c->arms[c->start[v] + k].to], w->surface->mesh.vertex[v], way[k]);
    hc_vector_normalize(way[k]);
  }
  return hc_vector_dot(way[0], way[1]) > -0.766;
}

static void edge_normal(const work *w, const arm *a, double normal[3]) {
  memcpy(normal, w->surface->face_normal[a->triangle], 3 * sizeof *normal);
  const int32_t beyond = w->surface->mesh.neighbour[a->triangle][a->side];
  for (int k = 0; k < 3 && beyond >= 0; k++) normal[k] += w->surface->face_normal[beyond][k];
}

/* The arm that leaves the end of another, going on: at a vertex that is no corner. */
static arm *arm_behind(const creases *c, const arm *a) {
  arm *const here = &c->arms[c->start[a->to]];
  return here[0].to == a->from && here[0].triangle == a->triangle && here[0].side == a->side ? &here[1]
                                                                                             : &here[0];
}

static arm *arm_back(const creases *c, const arm *a) {
  arm *back = &c->arms[c->start[a->to]];
  while (back->triangle != a->triangle || back->side != a->side) back++;
  return back;
}

/* Samples a chain from its first arm to a corner or around, without the corners. */
static void sample_chain(work *w, const creases *c, arm *first) {
  double length = 0, from[3], to[3], step[3];
  bool around = false;
  for (int pass = 0; pass < 2; pass++) { /* measures, then samples */
    const double parts = fmax(around ? 3 : 1, rint(length / w->spacing)), pitch = length / parts;
    double done = 0, next = around ? 0 : 1;
    for (arm *a = first;;) {
      moved_vertex(w, a->from, from);
      moved_vertex(w, a->to, to);
      hc_vector_minus(to, from, step);
      const double stretch = hc_vector_length(step);
      for (; pass == 1 && next < parts && next * pitch <= done + stretch; next++) {
        double x[3], normal[3];
        const double share = stretch > 0 ? (next * pitch - done) / stretch : 0;
        for (int k = 0; k < 3; k++) x[k] = from[k] + share * step[k];
        edge_normal(w, a, normal);
        add_sample(w, x, normal);
      }
      done += stretch;
      a->used = arm_back(c, a)->used = true;
      if (is_corner(w, c, a->to)) break;
      a = arm_behind(c, a);
      if (a == first) {
        around = true;
        break;
      }
    }
    length = done;
  }
}

static void sample_creases(work *w) {
  const int32_t vertices = w->surface->mesh.vertex_count;
  creases c = find_creases(w);
  for (int32_t v = 0; v < vertices; v++) {
    if (!is_corner(w, &c, v)) continue;
    double x[3];
    moved_vertex(w, v, x);
    add_sample(w, x, w->surface->vertex_normal[v]);
  }
  for (int loops = 0; loops < 2; loops++) /* from the corners, then what has none */
    for (int32_t v = 0; v < vertices; v++)
      for (int32_t k = c.start[v]; k < c.start[v + 1]; k++)
        if (!c.arms[k].used && (loops || is_corner(w, &c, v))) sample_chain(w, &c, &c.arms[k]);
  hc_free(c.arms);
  hc_free(c.start);
}

/* --- Candidates on the faces --- */

/* A triangle and where it goes, for its candidates: corner 2 is across from the longest side. */
typedef struct facet {
  int32_t triangle;
  int corner[3];
  const double *from[3];
  double to[3][3];
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

static facet facet_of(const work *w, int32_t t) {
  facet f = {.triangle = t};
  double moved[3][3];
  const double *from[3], *const to[3] = {moved[0], moved[1], moved[2]};
  int side = 0;
  for (int c = 0; c < 3; c++) {
    from[c] = vertex_of(w, t, c);
    moved_vertex(w, w->surface->mesh.triangle[t][c], moved[c]);
  }
  const double twice = measure(from, &f.base, &side), twice_moved = measure(to, &f.base, &side);
  f.height = fmax(twice, twice_moved) / f.base;
  for (int c = 0; c < 3; c++) {
    f.corner[c] = (side + c) % 3;
    f.from[c] = from[f.corner[c]];
    memcpy(f.to[c], moved[f.corner[c]], sizeof f.to[c]);
  }
  return f;
}

/* The candidate at these shares of the facet's corners, if there is one. */
static void add_candidate(work *w, const facet *f, const double share[3]) {
  const double *const n = w->surface->face_normal[f->triangle];
  double from[3], x[3], inward[3];
  for (int a = 0; a < 3; a++) {
    from[a] = share[0] * f->from[0][a] + share[1] * f->from[1][a] + share[2] * f->from[2][a];
    x[a] = share[0] * f->to[0][a] + share[1] * f->to[1][a] + share[2] * f->to[2][a];
    inward[a] = -w->side * n[a];
  }
  const double limit = thin * w->spacing * (1 - 1e-6);
  const double thickness = hc_surface_ray(w->surface, from, inward, w->side, limit);
  if (thickness >= limit) {
    if (settle(w, x)) hc_sample_candidates_add(&w->candidates, x, f->triangle);
    return;
  }
  if (!w->first_layer) return;
  for (int a = 0; a < 3; a++) x[a] = from[a] + 0.5 * thickness * inward[a];
  if (depth_at(w, x, NULL) >= near_enough * 0.5 * thickness) hc_sample_candidates_add(&w->candidates, x, -1);
}

/* In rows along the longest side, the first on it: so that nothing is left out where triangles are slim. */
static void add_candidates(work *w, const facet *f) {
  const double pitch = fine * w->spacing, rows = fmax(1, ceil(f->height / pitch));
  for (double row = 0; row < rows; row++) {
    const double third = row / rows, rest = 1 - third;
    const double places = fmax(1, ceil(rest * f->base / pitch));
    for (double place = 0; place < places; place++) {
      const double second = rest * (place + 0.5) / places;
      add_candidate(w, f, (const double[3]){rest - second, second, third});
    }
  }
}

static double expected_candidates(const work *w) {
  const double pitch = fine * w->spacing;
  double sum = 0;
  for (int32_t t = 0; t < w->surface->mesh.triangle_count; t++) {
    const facet f = facet_of(w, t);
    const double rows = fmax(1, ceil(f.height / pitch));
    sum += rows * (1 + 0.5 * f.base / pitch);
  }
  return sum;
}

/* --- All together --- */

static void set_normals(const work *w, hc_sample_set *samples) {
  for (int32_t k = samples->fixed; k < samples->count; k++) {
    hc_sample *const sample = &samples->at[k];
    double share[3];
    if (sample->triangle < 0) continue; /* in the middle of a thin wall */
    hc_surface_shares(w->surface, sample->triangle, sample->x, share);
    hc_surface_smooth_normal(w->surface, sample->triangle, share, sample->normal);
    for (int a = 0; a < 3; a++) sample->normal[a] *= w->side;
  }
}

/* Samples of one layer behind `samples`, which are kept. */
static void append(hc_surface *surface, const hc_sample_set *set, int32_t from) {
  const int64_t count = set->count - from;
  hc_surface_sample *const all = hc_alloc((size_t)(surface->sample_count + count), sizeof *all);
  if (surface->sample_count > 0) memcpy(all, surface->samples, (size_t)surface->sample_count * sizeof *all);
  for (int64_t k = 0; k < count; k++) {
    hc_surface_sample *const to = &all[surface->sample_count + k];
    memcpy(to->x, set->at[from + k].x, sizeof to->x);
    memcpy(to->normal, set->at[from + k].normal, sizeof to->normal);
  }
  hc_free(surface->samples);
  surface->samples = all;
  surface->sample_count += count;
}

static hc_status sample_layer(hc_surface *surface, double spacing, int layer, bool fluid_inside,
                              hc_error *error) {
  work w = {.surface = surface,
            .spacing = spacing,
            .depth = (0.5 + layer) * spacing,
            .side = fluid_inside ? -1 : 1,
            .first_layer = layer == 0};
  find_mitres(&w);
  const double expected = expected_candidates(&w);
  if (expected > most_candidates) {
    hc_free(w.mitre);
    return hc_error_set(
        error, HC_BAD_INPUT,
        "its surface is too large or too finely cut for particle_spacing %g m: sampling it would "
        "take %.2g candidates and may take %.2g; is its scale right?",
        spacing, expected, most_candidates);
  }
  w.samples = hc_sample_set_make(apart * spacing);
  for (int64_t k = 0; k < surface->sample_count; k++) /* the layer before keeps its room */
    hc_sample_set_add(&w.samples, surface->samples[k].x, surface->samples[k].normal, -1);
  sample_creases(&w);
  w.samples.fixed = w.samples.count;
  for (int32_t t = 0; t < surface->mesh.triangle_count; t++) {
    const facet f = facet_of(&w, t);
    add_candidates(&w, &f);
  }
  hc_sample_set_choose(&w.samples, &w.candidates, apart * spacing);
  for (int pass = 0; pass < PASSES; pass++) {
    for (int round = 0; round < ROUNDS; round++) hc_sample_set_even_out(&w.samples, &w.candidates);
    hc_sample_set_thin_out(&w.samples, crowded * spacing);
    hc_sample_set_fill(&w.samples, &w.candidates, hole * spacing);
  }
  set_normals(&w, &w.samples);
  append(surface, &w.samples, (int32_t)surface->sample_count);
  hc_sample_set_free(&w.samples);
  hc_sample_candidates_free(&w.candidates);
  hc_free(w.mitre);
  return HC_OK;
}

hc_status hc_surface_samples_make(hc_surface *surface, double spacing, int layers, bool fluid_inside,
                                  hc_error *error) {
  for (int layer = 0; layer < layers; layer++) {
    const hc_status status = sample_layer(surface, spacing, layer, fluid_inside, error);
    if (status != HC_OK) return status;
  }
  return HC_OK;
}
