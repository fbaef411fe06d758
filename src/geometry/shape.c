#include "shape.h"

#include "base/check.h"
#include "base/turns.h"
#include "surface.h"
#include "vector.h"

#include <math.h>
#include <string.h>

static void normalize(const double v[3], double unit[3]) {
  hc_vector_direction(v, unit);
  HC_CHECK(hc_vector_dot(unit, unit) > 0.5, "a direction needs a length, got [%g, %g, %g]", v[0], v[1], v[2]);
}

static int longest_axis(const double v[3]) {
  int axis = 0;
  for (int k = 1; k < 3; k++)
    if (fabs(v[k]) > fabs(v[axis])) axis = k;
  return axis;
}

/* Axes with the third along `normal`, see hc_shape_rectangle. */
static void axes_about(const double normal[3], double axes[3][3]) {
  double *const n = axes[2];
  normalize(normal, n);
  const int along = longest_axis(n), next = (along + 1) % 3, last = (along + 2) % 3;
  if (fabs(n[next]) <= 1e-12 && fabs(n[last]) <= 1e-12) {
    const double sign = n[along] > 0 ? 1 : -1;
    for (int k = 0; k < 3; k++) {
      n[k] = k == along ? sign : 0;
      axes[0][k] = k == next;
      axes[1][k] = k == last;
    }
    return;
  }
  double tangent[3];
  for (int k = 0; k < 3; k++) tangent[k] = (k == next) - n[next] * n[k];
  normalize(tangent, axes[0]);
  hc_vector_cross(n, axes[0], axes[1]);
}

hc_shape hc_shape_box(const double min[3], const double max[3], const double axis[3], double turns,
                      unsigned open) {
  hc_shape shape = {.round = 1, .open = open};
  for (int a = 0; a < 3; a++) {
    shape.centre[a] = 0.5 * (min[a] + max[a]);
    shape.high[a] = 0.5 * (max[a] - min[a]);
    shape.low[a] = -shape.high[a];
    shape.axes[a][a] = 1;
  }
  if (turns == 0) return shape;
  double u[3];
  normalize(axis, u);
  const double cosine = hc_turns_cosine(turns), sine = hc_turns_sine(turns);
  for (int t = 0; t < 3; t++) {
    double turned[3];
    hc_vector_cross(u, shape.axes[t], turned);
    for (int a = 0; a < 3; a++) turned[a] = cosine * (a == t) + sine * turned[a] + (1 - cosine) * u[t] * u[a];
    memcpy(shape.axes[t], turned, sizeof turned);
  }
  return shape;
}

hc_shape hc_shape_cylinder(const double base[3], const double axis[3], double radius, double length,
                           unsigned open) {
  hc_shape shape = {
      .round = 2, .low = {0, -0.5 * length, 0}, .high = {radius, 0.5 * length, 0}, .open = 1 | open << 2};
  axes_about(axis, shape.axes);
  for (int a = 0; a < 3; a++) shape.centre[a] = base[a] + 0.5 * length * shape.axes[2][a];
  return shape;
}

hc_shape hc_shape_sphere(const double centre[3], double radius) {
  return (hc_shape){.centre = {centre[0], centre[1], centre[2]},
                    .axes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                    .round = 3,
                    .high = {radius, 0, 0},
                    .open = 1};
}

hc_shape hc_shape_rectangle(const double point[3], const double normal[3], const double size[2]) {
  hc_shape shape = {.centre = {point[0], point[1], point[2]},
                    .round = 1,
                    .low = {-0.5 * size[0], -0.5 * size[1], 0},
                    .high = {0.5 * size[0], 0.5 * size[1], 0},
                    .open = 0xf | 1u << 5};
  axes_about(normal, shape.axes);
  return shape;
}

int hc_shape_components(const hc_shape *shape) {
  return 4 - shape->round;
}

static bool is_open(const hc_shape *shape, int component, int upper) {
  return shape->open >> (2 * component + upper) & 1;
}

static bool is_radius(const hc_shape *shape, int component) {
  return shape->round > 1 && component == 0;
}

static double thickness_of(const hc_shape *shape, int component) {
  return is_radius(shape, component) ? 2 * shape->high[component]
                                     : shape->high[component] - shape->low[component];
}

/* Has a single layer of samples, in its middle. */
static bool is_thin(const hc_shape *shape, int component, double spacing) {
  return rint(thickness_of(shape, component) / spacing) <= 1;
}

hc_shape hc_shape_layer(const hc_shape *shape, double spacing, bool solid, int layer) {
  hc_shape surface = *shape;
  const double depth = (0.5 + layer) * spacing;
  if (shape->surface) {
    surface.level = depth;
    surface.outside = shape->surface->closed && !solid;
    return surface;
  }
  for (int c = 0; c < hc_shape_components(shape); c++) {
    if (solid) {
      const double half = 0.5 * thickness_of(shape, c),
                   inset = is_thin(shape, c, spacing) ? half : fmin(depth, half);
      if (!is_radius(shape, c)) surface.low[c] = shape->low[c] + inset;
      surface.high[c] = shape->high[c] - inset;
      continue;
    }
    if (!is_open(shape, c, 0)) surface.low[c] -= depth;
    if (!is_open(shape, c, 1)) surface.high[c] += depth;
  }
  return surface;
}

/* The components of a point, and how many there are. */
static int components_of(const hc_shape *shape, const double x[3], double p[3]) {
  double from_centre[3], q[3];
  for (int a = 0; a < 3; a++) from_centre[a] = x[a] - shape->centre[a];
  for (int t = 0; t < 3; t++) q[t] = hc_vector_dot(shape->axes[t], from_centre);
  double square = 0;
  for (int t = 0; t < shape->round; t++) square += q[t] * q[t];
  p[0] = shape->round == 1 ? q[0] : sqrt(square);
  for (int t = shape->round; t < 3; t++) p[t - shape->round + 1] = q[t];
  return hc_shape_components(shape);
}

/* Outward direction of a face at a point, which must not lie on the axis of a round one. */
static void face_direction(const hc_shape *shape, int component, int upper, const double x[3],
                           double direction[3]) {
  if (!is_radius(shape, component)) {
    hc_shape_face_normal(shape, 2 * component + upper, direction);
    return;
  }
  double from_centre[3];
  for (int a = 0; a < 3; a++) from_centre[a] = x[a] - shape->centre[a];
  const double along = hc_vector_dot(shape->axes[2], from_centre);
  for (int a = 0; a < 3; a++)
    direction[a] = from_centre[a] - (shape->round == 2 ? along * shape->axes[2][a] : 0);
  normalize(direction, direction);
}

/* The layer of a solid's face that a sample lies in, from 0: layers are half a spacing and about one more
 * each inside it. */
static double layer_behind(const hc_shape *shape, int component, int upper, double spacing, double p) {
  if (is_thin(shape, component, spacing)) return 0;
  const double inside = upper ? shape->high[component] - p : p - shape->low[component];
  return floor(inside / spacing);
}

void hc_shape_sample_normal(const hc_shape *shape, double spacing, bool solid, const double x[3],
                            double normal[3]) {
  static const double on_axis = 1e-6; /* spacings: no radial direction */
  double p[3], own = INFINITY, sum[3] = {0, 0, 0};
  const int count = components_of(shape, x, p);
  for (int c = 0; c < count && solid; c++)
    for (int upper = 0; upper < 2; upper++)
      if (!is_open(shape, c, upper)) own = fmin(own, layer_behind(shape, c, upper, spacing, p[c]));
  for (int c = 0; c < count; c++)
    for (int upper = 0; upper < 2; upper++) {
      if (is_open(shape, c, upper)) continue;
      const double beyond = upper ? p[c] - shape->high[c] : shape->low[c] - p[c];
      const bool counts = solid ? layer_behind(shape, c, upper, spacing, p[c]) == own : beyond > 0;
      if (!counts || (is_radius(shape, c) && p[c] < on_axis * spacing)) continue;
      double direction[3];
      face_direction(shape, c, upper, x, direction);
      for (int a = 0; a < 3; a++) sum[a] += solid ? direction[a] : -direction[a];
    }
  const double length = sqrt(hc_vector_dot(sum, sum));
  for (int a = 0; a < 3; a++) normal[a] = length > 0 ? sum[a] / length : 0;
}

static double box_distance(const hc_shape *shape, const double x[3], bool through_open) {
  double p[3], deepest = -INFINITY, square = 0;
  const int count = components_of(shape, x, p);
  for (int c = 0; c < count; c++)
    for (int upper = 0; upper < 2; upper++) {
      if (is_open(shape, c, upper) && (through_open || (c == 0 && shape->round > 1))) continue;
      const double beyond = upper ? p[c] - shape->high[c] : shape->low[c] - p[c];
      deepest = fmax(deepest, beyond);
      if (beyond > 0) square += beyond * beyond;
    }
  return deepest > 0 ? sqrt(square) : deepest;
}

/* Negative inside a closed surface and in front of an open one. */
static double distance_to_surface(const hc_shape *shape, const double x[3]) {
  const double distance = hc_surface_signed_distance(shape->surface, x, NULL);
  return shape->surface->closed ? distance : -distance;
}

double hc_shape_distance(const hc_shape *shape, const double x[3]) {
  if (shape->surface) return distance_to_surface(shape, x);
  return box_distance(shape, x, false);
}

double hc_shape_region_distance(const hc_shape *shape, const double x[3]) {
  if (shape->surface) return distance_to_surface(shape, x);
  return box_distance(shape, x, true);
}

double hc_shape_surface_distance(const hc_shape *shape, const double x[3]) {
  if (shape->surface) {
    const double front = hc_surface_signed_distance(shape->surface, x, NULL);
    return fabs((shape->outside ? -front : front) + shape->level);
  }
  double p[3], beyond[3], nearest = INFINITY;
  const int count = components_of(shape, x, p);
  for (int c = 0; c < count; c++) beyond[c] = fmax(0, fmax(shape->low[c] - p[c], p[c] - shape->high[c]));
  for (int c = 0; c < count; c++)
    for (int upper = 0; upper < 2; upper++) {
      if (is_open(shape, c, upper)) continue;
      const double across = p[c] - (upper ? shape->high[c] : shape->low[c]);
      double square = across * across;
      for (int other = 0; other < count; other++)
        if (other != c) square += beyond[other] * beyond[other];
      nearest = fmin(nearest, sqrt(square));
    }
  return nearest;
}

void hc_shape_face_normal(const hc_shape *shape, int face, double normal[3]) {
  const int axis = face / 2 + shape->round - 1;
  HC_CHECK(shape->round == 1 || face >= 2, "face %d of a round shape is not straight", face);
  for (int a = 0; a < 3; a++) normal[a] = (face % 2 ? 1 : -1) * shape->axes[axis][a];
}

double hc_shape_reach(const hc_shape *shape) {
  double square = 0;
  if (shape->surface)
    return sqrt(hc_vector_dot(shape->high, shape->high)) + 2 * shape->level; /* with mitred corners */
  for (int c = 0; c < hc_shape_components(shape); c++) {
    const double most = fmax(fabs(shape->low[c]), fabs(shape->high[c]));
    square += most * most;
  }
  return sqrt(square);
}

void hc_shape_bounds(const hc_shape *shape, double min[3], double max[3]) {
  for (int a = 0; a < 3; a++) {
    double round = 0, reach = 0;
    if (shape->surface) {
      min[a] = shape->surface->low[a];
      max[a] = shape->surface->high[a];
      continue;
    }
    for (int t = 0; t < 3; t++) {
      const double part = shape->axes[t][a];
      if (shape->round > 1 && t < shape->round)
        round += part * part;
      else
        reach += fabs(part) * shape->high[t - shape->round + 1];
    }
    reach += sqrt(round) * shape->high[0];
    min[a] = shape->centre[a] - reach;
    max[a] = shape->centre[a] + reach;
  }
}

double hc_shape_nearest_image(double (*distance)(const hc_shape *shape, const double x[3]),
                              const hc_shape *shape, const double period[3], const double x[3]) {
  double nearest = INFINITY, from[3];
  for (int a = 0; a < 3; a++)
    from[a] = period[a] > 0 ? x[a] - period[a] * (rint((x[a] - shape->centre[a]) / period[a]) + 1) : x[a];
  double image[3];
  for (int i = 0; i < (period[0] > 0 ? 3 : 1); i++)
    for (int j = 0; j < (period[1] > 0 ? 3 : 1); j++)
      for (int k = 0; k < (period[2] > 0 ? 3 : 1); k++) {
        image[0] = from[0] + i * period[0];
        image[1] = from[1] + j * period[1];
        image[2] = from[2] + k * period[2];
        nearest = fmin(nearest, distance(shape, image));
      }
  return nearest;
}
