#include "solid.h"

#include "surface.h"
#include "vector.h"

static const double pi = 3.14159265358979323846;

/* Inertia from second moments, of which those with i <= j are known. */
static void set_inertia(const double second[3][3], double inertia[3][3]) {
  for (int i = 0; i < 3; i++) {
    const int next = (i + 1) % 3, last = (i + 2) % 3;
    inertia[i][i] = second[next][next] + second[last][last]; /* not from the trace: thin rods keep digits */
    for (int j = i + 1; j < 3; j++) inertia[i][j] = inertia[j][i] = -second[i][j];
  }
}

/* --- Boxes, cylinders, spheres --- */

static double length_of(const hc_shape *shape, int component) {
  return shape->high[component] - shape->low[component];
}

static double volume_of(const hc_shape *shape) {
  const double radius = shape->high[0];
  if (shape->round == 3) return 4 * pi / 3 * radius * radius * radius;
  if (shape->round == 2) return pi * radius * radius * length_of(shape, 1);
  return length_of(shape, 0) * length_of(shape, 1) * length_of(shape, 2);
}

/* The mean square of the distance from the centre along the shape's own axis t: of a line, a disc, a ball. */
static double mean_square(const hc_shape *shape, int t) {
  const double radius = shape->high[0];
  if (t < shape->round && shape->round > 1) return radius * radius / (shape->round == 2 ? 4 : 5);
  const double length = length_of(shape, t - shape->round + 1);
  return length * length / 12;
}

static hc_solid solid_of_components(const hc_shape *shape) {
  hc_solid solid = {.volume = volume_of(shape)};
  double second[3][3] = {{0}};
  for (int a = 0; a < 3; a++) solid.centre[a] = shape->centre[a];
  for (int t = 0; t < 3; t++) {
    const double *const axis = shape->axes[t], moment = solid.volume * mean_square(shape, t);
    const int c = t - shape->round + 1;
    const double middle = t < shape->round && shape->round > 1 ? 0 : 0.5 * (shape->low[c] + shape->high[c]);
    for (int i = 0; i < 3; i++) {
      solid.centre[i] += middle * axis[i]; /* layers of what is open need not lie about the centre */
      for (int j = i; j < 3; j++) second[i][j] += moment * axis[i] * axis[j];
    }
  }
  set_inertia((const double(*)[3])second, solid.inertia);
  return solid;
}

/* --- Surfaces --- */

/* Integrals over the volume, from a point. */
typedef struct moments {
  double volume, first[3], second[3][3]; /* i <= j */
} moments;

static void add_tetrahedron(const hc_mesh *mesh, int32_t t, const double from[3], moments *sum) {
  double x[4][3], product[3]; /* the corners, and their sum */
  for (int c = 0; c < 3; c++) hc_vector_minus(mesh->vertex[mesh->triangle[t][c]], from, x[c]);
  hc_vector_cross(x[1], x[2], product);
  const double volume = hc_vector_dot(x[0], product) / 6;
  for (int i = 0; i < 3; i++) x[3][i] = x[0][i] + x[1][i] + x[2][i];
  sum->volume += volume;
  for (int i = 0; i < 3; i++) {
    sum->first[i] += volume * x[3][i] / 4;
    for (int j = i; j < 3; j++) {
      double squares = 0;
      for (int c = 0; c < 4; c++) squares += x[c][i] * x[c][j];
      sum->second[i][j] += volume * squares / 20;
    }
  }
}

static hc_solid solid_of_surface(const hc_surface *surface) {
  moments sum = {0};
  double from[3], second[3][3], to_centre[3];
  for (int a = 0; a < 3; a++) from[a] = 0.5 * (surface->low[a] + surface->high[a]);
  for (int32_t t = 0; t < surface->mesh.triangle_count; t++) add_tetrahedron(&surface->mesh, t, from, &sum);
  hc_solid solid = {.volume = sum.volume};
  for (int a = 0; a < 3; a++) {
    to_centre[a] = sum.volume != 0 ? sum.first[a] / sum.volume : 0; /* an open one may be flat */
    solid.centre[a] = from[a] + to_centre[a];
  }
  for (int i = 0; i < 3; i++)
    for (int j = i; j < 3; j++) second[i][j] = sum.second[i][j] - sum.first[i] * to_centre[j];
  set_inertia((const double(*)[3])second, solid.inertia);
  return solid;
}

hc_solid hc_solid_of(const hc_shape *shape) {
  return shape->surface ? solid_of_surface(shape->surface) : solid_of_components(shape);
}
