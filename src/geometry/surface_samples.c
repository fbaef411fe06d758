#include "surface_samples.h"

#include "base/memory.h"
#include "vector.h"

#include <string.h>

static const double apart = 0.9;    /* spacings: how far the first choice of samples keeps apart */
static const double crowded = 0.73; /* spacings: closer in the end is too close */
static const double hole = 0.73;    /* spacings: a candidate farther from all samples becomes one */
static const double beside = 0.72;  /* spacings: what creases and layers keep from each other */
enum { PASSES = 3, ROUNDS = 5 };
static const double most_candidates = 1 << 25;

/* A surface being sampled. */
typedef struct work {
  const hc_surface_layer *layer; /* at which it is */
  const hc_surface *surface;
  hc_sample_set samples;
  double (*normals)[3]; /* of samples of creases: their triangle is ON_CREASE less the place here */
  size_t normal_count, normal_room;
} work;

enum { ON_CREASE = -2 };

/* --- Corners and creases --- */

static void add_sample(work *w, const double x[3], const double normal[3]) {
  const double depth = -w->layer->side * hc_surface_signed_distance(w->surface, x, NULL);
  if (depth < hc_surface_layer_deep * w->layer->depth) return;
  if (hc_sample_set_within(&w->samples, x, beside * w->layer->spacing) >= 0) return;
  hc_reserve((void **)&w->normals, &w->normal_room, 2 * w->normal_count + 1, w->normal_count,
             sizeof *w->normals);
  double *const unit = w->normals[w->normal_count];
  for (int a = 0; a < 3; a++) unit[a] = w->layer->side * normal[a];
  hc_vector_normalize(unit);
  hc_sample_set_add(&w->samples, x, ON_CREASE - (int32_t)w->normal_count++);
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
    const double parts = fmax(around ? 3 : 1, rint(length / w->layer->spacing)), pitch = length / parts;
    double done = 0, next = around ? 0 : 1;
    for (arm *a = first;;) {
      hc_surface_layer_vertex(w->layer, a->from, from);
      hc_surface_layer_vertex(w->layer, a->to, to);
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
    hc_surface_layer_vertex(w->layer, v, x);
    add_sample(w, x, w->surface->vertex_normal[v]);
  }
  for (int loops = 0; loops < 2; loops++) /* from the corners, then what has none */
    for (int32_t v = 0; v < vertices; v++)
      for (int32_t k = c.start[v]; k < c.start[v + 1]; k++)
        if (!c.arms[k].used && (loops || is_corner(w, &c, v))) sample_chain(w, &c, &c.arms[k]);
  hc_free(c.arms);
  hc_free(c.start);
}

/* --- All together --- */

static void normal_of(const work *w, const hc_sample *sample, double side, double normal[3]) {
  double share[3];
  normal[0] = normal[1] = normal[2] = 0; /* in the middle of a thin wall */
  if (sample->triangle <= ON_CREASE)
    memcpy(normal, w->normals[ON_CREASE - sample->triangle], 3 * sizeof *normal);
  if (sample->triangle < 0) return;
  hc_surface_shares(w->surface, sample->triangle, sample->x, share);
  hc_surface_smooth_normal(w->surface, sample->triangle, share, normal);
  for (int a = 0; a < 3; a++) normal[a] *= side;
}

static void keep_share(const work *w, bool fluid_inside, const hc_parts *parts, hc_surface *surface) {
  int64_t first, last;
  surface->sample_count = w->samples.count;
  for (int a = 0; a < 3; a++) {
    surface->samples_low[a] = INFINITY;
    surface->samples_high[a] = -INFINITY;
    for (int32_t k = 0; k < w->samples.count; k++) {
      surface->samples_low[a] = fmin(surface->samples_low[a], w->samples.at[k].x[a]);
      surface->samples_high[a] = fmax(surface->samples_high[a], w->samples.at[k].x[a]);
    }
  }
  hc_parts_share(parts, surface->sample_count, &first, &last);
  surface->first_sample = first;
  surface->samples_held = last - first;
  surface->samples = hc_alloc((size_t)(last - first), sizeof *surface->samples);
  for (int64_t k = first; k < last; k++) {
    const hc_sample *const from = &w->samples.at[k];
    hc_surface_sample *const to = &surface->samples[k - first];
    memcpy(to->x, from->x, sizeof to->x);
    normal_of(w, from, fluid_inside ? -1 : 1, to->normal);
  }
}

/* Adds the samples of a layer behind those of the layers before, which keep their room. */
static hc_status sample_layer(work *w, const hc_parts *parts, hc_error *error) {
  const hc_surface_layer *const layer = w->layer;
  const double spacing = layer->spacing, expected = hc_surface_layer_estimate(layer);
  if (expected > most_candidates)
    return hc_error_set(
        error, HC_BAD_INPUT,
        "its surface is too large or too finely cut for particle_spacing %g m: sampling it would "
        "take %.2g candidates and may take %.2g; is its scale right?",
        spacing, expected, most_candidates);
  int64_t first, last;
  hc_parts_share(parts, hc_surface_layer_places(layer), &first, &last);
  hc_sample_candidates candidates = hc_surface_layer_candidates(layer, first, last);
  hc_sample_candidates_number(&candidates, parts);
  sample_creases(w);
  w->samples.fixed = w->samples.count;
  hc_sample_choice_first(&w->samples, &candidates, apart * spacing, parts);
  for (int pass = 0; pass < PASSES; pass++) {
    for (int round = 0; round < ROUNDS; round++) hc_sample_choice_even_out(&w->samples, &candidates, parts);
    hc_sample_choice_thin_out(&w->samples, &candidates, crowded * spacing);
    hc_sample_choice_fill(&w->samples, &candidates, hole * spacing, parts);
  }
  hc_sample_candidates_free(&candidates);
  return HC_OK;
}

hc_status hc_surface_samples_make(hc_surface *surface, double spacing, int layers, bool fluid_inside,
                                  const hc_parts *parts, hc_error *error) {
  work w = {.surface = surface, .samples = hc_sample_set_make(apart * spacing)};
  hc_status status = HC_OK;
  for (int number = 0; number < layers && status == HC_OK; number++) {
    hc_surface_layer layer = hc_surface_layer_make(surface, spacing, number, fluid_inside);
    w.layer = &layer;
    status = sample_layer(&w, parts, error);
    hc_surface_layer_free(&layer);
  }
  if (status == HC_OK) keep_share(&w, fluid_inside, parts, surface);
  hc_sample_set_free(&w.samples);
  hc_free(w.normals);
  return status;
}
