#include "revolution.h"

#include "base/memory.h"
#include "base/turns.h"
#include "shape.h"

#include <math.h>
#include <string.h>

static const double sagitta = 0.01; /* spacings */
enum { FEWEST = 24 };

/* A face's middle is r (1 - cos(pi / n)), about r (pi / n)^2 / 2, within the round surface; corners lie as
 * much outside of the mean. */
static double segments_of(double radius, double spacing) {
  return fmax(FEWEST, ceil(3.14159265358979323846 * sqrt(radius / (2 * sagitta * spacing))));
}

typedef struct lathe {
  double (*profile)[2];
  int32_t *first; /* vertex of each point; on the axis there is one, else one for each segment */
  int count, segments;
} lathe;

static int32_t vertex_of(const lathe *l, int point, int segment) {
  return l->first[point] + (l->profile[point][0] > 0 ? segment % l->segments : 0);
}

/* The faces between two points; counterclockwise seen from the left of the way from a to b. */
static int32_t add_band(const lathe *l, int a, int b, hc_mesh *mesh, int32_t at) {
  if (l->profile[a][0] == 0 && l->profile[b][0] == 0) return at;
  for (int s = 0; s < l->segments; s++) {
    const int32_t corner[4] = {vertex_of(l, a, s), vertex_of(l, b, s), vertex_of(l, b, s + 1),
                               vertex_of(l, a, s + 1)};
    for (int half = 0; half < 2; half++) {
      const int32_t triangle[3] = {corner[0], corner[1 + half], corner[2 + half]};
      if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) continue;
      memcpy(mesh->triangle[at++], triangle, sizeof triangle);
    }
  }
  return at;
}

static void turn(const lathe *l, const double base[3], const double axis[3], bool closed, hc_mesh *mesh) {
  const hc_shape frame = hc_shape_cylinder(base, axis, 1, 1, 0); /* for its axes */
  int32_t vertices = 0, triangles = 0;
  for (int p = 0; p < l->count; p++) {
    const double radius = l->profile[p][0], height = l->profile[p][1];
    l->first[p] = vertices;
    for (int s = 0; s < (radius > 0 ? l->segments : 1); s++, vertices++) {
      const double turns = (double)s / l->segments;
      const double own[3] = {radius * hc_turns_cosine(turns), radius * hc_turns_sine(turns), height};
      for (int a = 0; a < 3; a++)
        mesh->vertex[vertices][a] =
            base[a] + own[0] * frame.axes[0][a] + own[1] * frame.axes[1][a] + own[2] * frame.axes[2][a];
    }
  }
  for (int p = 0; p + 1 < l->count; p++) triangles = add_band(l, p, p + 1, mesh, triangles);
  if (closed) triangles = add_band(l, l->count - 1, 0, mesh, triangles);
  mesh->vertex_count = vertices;
  mesh->triangle_count = triangles;
}

static hc_status check(const double (*profile)[2], int count, bool closed, double *radius, hc_error *error) {
  *radius = 0;
  for (int p = 0; p < count; p++) {
    if (!(profile[p][0] >= 0) || !isfinite(profile[p][0]) || !isfinite(profile[p][1]))
      return hc_error_set(error, HC_BAD_INPUT, "profile[%d] must have a radius >= 0, not [%g, %g]", p,
                          profile[p][0], profile[p][1]);
    *radius = fmax(*radius, profile[p][0]);
  }
  if (count < (closed ? 3 : 2))
    return hc_error_set(error, HC_BAD_INPUT, "profile must have at least %d different points, and has %d",
                        closed ? 3 : 2, count);
  if (*radius == 0)
    return hc_error_set(error, HC_BAD_INPUT, "profile must leave the axis, and has no radius > 0");
  return HC_OK;
}

hc_status hc_revolution_mesh(const double base[3], const double axis[3], const double (*profile)[2],
                             int count, bool closed, double spacing, hc_mesh *mesh, hc_error *error) {
  *mesh = (hc_mesh){0};
  lathe l = {.profile = hc_alloc((size_t)count, sizeof *l.profile),
             .first = hc_alloc((size_t)count, sizeof *l.first)};
  for (int p = 0; p < count; p++) {
    const double *const before = l.count > 0 ? l.profile[l.count - 1] : NULL;
    if (before && before[0] == profile[p][0] && before[1] == profile[p][1]) continue;
    memcpy(l.profile[l.count++], profile[p], sizeof *profile);
  }
  while (closed && l.count > 1 && memcmp(l.profile[l.count - 1], l.profile[0], sizeof *l.profile) == 0)
    l.count--;
  double radius;
  hc_status status = check((const double(*)[2])l.profile, l.count, closed, &radius, error);
  if (status == HC_OK) {
    const double segments = segments_of(radius, spacing), triangles = 2 * segments * l.count;
    if (triangles > HC_MESH_MOST) {
      status =
          hc_error_set(error, HC_BAD_INPUT,
                       "the profile would make %.3g triangles at particle_spacing %g m, and may make %d: is "
                       "its unit m?",
                       triangles, spacing, HC_MESH_MOST);
    } else {
      l.segments = (int)segments;
      *mesh = hc_mesh_make(l.segments * l.count, (int32_t)triangles);
      turn(&l, base, axis, closed, mesh);
      if (closed && hc_mesh_volume(mesh) < 0) hc_mesh_turn_around(mesh);
    }
  }
  hc_free(l.profile);
  hc_free(l.first);
  return status;
}
