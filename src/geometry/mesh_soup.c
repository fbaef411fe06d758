#include "mesh_soup.h"

#include "base/memory.h"
#include "vector.h"

#include <math.h>
#include <string.h>

enum { MOST_CORNERS = 512 }; /* cutting takes their cube */

void hc_mesh_soup_free(hc_mesh_soup *soup) {
  hc_free(soup->vertex);
  hc_free(soup->triangle);
  *soup = (hc_mesh_soup){.vertices = 0};
}

hc_status hc_mesh_soup_add_vertex(hc_mesh_soup *soup, const double x[3], hc_error *error) {
  if (soup->vertices == 3 * (size_t)HC_MESH_MOST)
    return hc_error_set(error, HC_BAD_INPUT, "must have at most %lld vertices", 3 * (long long)HC_MESH_MOST);
  hc_reserve((void **)&soup->vertex, &soup->vertex_room, 2 * soup->vertices + 64, soup->vertices,
             sizeof *soup->vertex);
  memcpy(soup->vertex[soup->vertices++], x, sizeof *soup->vertex);
  return HC_OK;
}

static hc_status add_triangle(hc_mesh_soup *soup, int32_t a, int32_t b, int32_t c, hc_error *error) {
  if (soup->triangles == HC_MESH_MOST)
    return hc_error_set(error, HC_BAD_INPUT, "must have at most %d triangles", HC_MESH_MOST);
  hc_reserve((void **)&soup->triangle, &soup->triangle_room, 2 * soup->triangles + 64, soup->triangles,
             sizeof *soup->triangle);
  int32_t *const corner = soup->triangle[soup->triangles++];
  corner[0] = a;
  corner[1] = b;
  corner[2] = c;
  return HC_OK;
}

/* Twice the area of a triangle, with a direction. */
static void area_of(const hc_mesh_soup *soup, int32_t a, int32_t b, int32_t c, double area[3]) {
  double ab[3], ac[3];
  hc_vector_minus(soup->vertex[b], soup->vertex[a], ab);
  hc_vector_minus(soup->vertex[c], soup->vertex[a], ac);
  hc_vector_cross(ab, ac, area);
}

static bool is_within(const hc_mesh_soup *soup, const int32_t ear[3], const double normal[3], int32_t v) {
  for (int k = 0; k < 3; k++) {
    double area[3];
    area_of(soup, ear[k], ear[(k + 1) % 3], v, area);
    if (hc_vector_dot(area, normal) < 0) return false;
  }
  return true;
}

/* How good a triangle the corner `at` of what is left makes with its neighbours: its area over the square of
 * its longest side; 0 if it does not stick out or another corner lies in it. */
static double ear_of(const hc_mesh_soup *soup, const int32_t *left, int count, int at,
                     const double normal[3]) {
  const int32_t ear[3] = {left[(at + count - 1) % count], left[at], left[(at + 1) % count]};
  double area[3], longest = 0;
  area_of(soup, ear[0], ear[1], ear[2], area);
  if (!(hc_vector_dot(area, normal) > 0)) return 0;
  for (int k = 0; k < count; k++) {
    const int32_t v = left[k];
    if (v == ear[0] || v == ear[1] || v == ear[2]) continue;
    if (is_within(soup, ear, normal, v)) return 0;
  }
  for (int k = 0; k < 3; k++) {
    double side[3];
    hc_vector_minus(soup->vertex[ear[k]], soup->vertex[ear[(k + 1) % 3]], side);
    longest = fmax(longest, hc_vector_dot(side, side));
  }
  return hc_vector_length(area) / longest;
}

/* The best ear, so that corners on a straight line find others to make triangles with; where nothing is an
 * ear, as in a polygon that crosses itself, any corner goes. */
static int find_ear(const hc_mesh_soup *soup, const int32_t *left, int count, const double normal[3]) {
  double best = 0;
  int found = 1;
  for (int k = 1; k <= count; k++) {
    const double quality = ear_of(soup, left, count, k % count, normal);
    if (!(quality > best * (1 + 1e-9))) continue; /* the first among equals */
    best = quality;
    found = k % count;
  }
  return found;
}

hc_status hc_mesh_soup_add_polygon(hc_mesh_soup *soup, const int32_t *corners, int count, hc_error *error) {
  if (count < 3) return HC_OK;
  if (count == 3) return add_triangle(soup, corners[0], corners[1], corners[2], error);
  if (count > MOST_CORNERS)
    return hc_error_set(error, HC_BAD_INPUT, "a face must have at most %d corners, and one has %d",
                        MOST_CORNERS, count);
  double normal[3] = {0, 0, 0};
  for (int k = 1; k + 1 < count; k++) {
    double area[3];
    area_of(soup, corners[0], corners[k], corners[k + 1], area);
    for (int a = 0; a < 3; a++) normal[a] += area[a];
  }
  int32_t left[MOST_CORNERS];
  memcpy(left, corners, (size_t)count * sizeof *left);
  for (; count > 3; count--) {
    const int at = find_ear(soup, left, count, normal);
    if (add_triangle(soup, left[(at + count - 1) % count], left[at], left[(at + 1) % count], error) != HC_OK)
      return error->status;
    memmove(left + at, left + at + 1, (size_t)(count - at - 1) * sizeof *left);
  }
  return add_triangle(soup, left[0], left[1], left[2], error);
}

hc_mesh hc_mesh_soup_take(hc_mesh_soup *soup) {
  int32_t *const place = hc_alloc(soup->vertices, sizeof *place);
  int32_t kept = 0;
  for (size_t v = 0; v < soup->vertices; v++) place[v] = -1;
  for (size_t t = 0; t < soup->triangles; t++)
    for (int c = 0; c < 3; c++) place[soup->triangle[t][c]] = 0;
  for (size_t v = 0; v < soup->vertices; v++)
    if (place[v] == 0) place[v] = kept++;
  hc_mesh mesh = hc_mesh_make(kept, (int32_t)soup->triangles);
  for (size_t v = 0; v < soup->vertices; v++)
    if (place[v] >= 0) memcpy(mesh.vertex[place[v]], soup->vertex[v], sizeof *mesh.vertex);
  for (size_t t = 0; t < soup->triangles; t++)
    for (int c = 0; c < 3; c++) mesh.triangle[t][c] = place[soup->triangle[t][c]];
  hc_free(place);
  hc_mesh_soup_free(soup);
  return mesh;
}
