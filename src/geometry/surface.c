#include "surface.h"

#include "base/check.h"
#include "base/memory.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

enum { LEAF = 4, DEEPEST = 64 };
static const double sharp = 0.76604444311897804; /* cosine of 40 degrees */
static const double straight = 0.7;              /* cosine between a ray and what it comes out through */

/* --- Making the tree --- */

typedef struct sorted {
  double middle;
  int32_t triangle;
} sorted;

static int by_middle(const void *left, const void *right) {
  const sorted *const a = left, *const b = right;
  if (a->middle != b->middle) return a->middle < b->middle ? -1 : 1;
  return (a->triangle > b->triangle) - (a->triangle < b->triangle);
}

static void corners_of(const hc_surface *surface, int32_t t, const double *corner[3]) {
  for (int c = 0; c < 3; c++) corner[c] = surface->mesh.vertex[surface->mesh.triangle[t][c]];
}

static void bound(const hc_surface *surface, hc_surface_node *node, int32_t first, int32_t count) {
  for (int a = 0; a < 3; a++) {
    node->low[a] = INFINITY;
    node->high[a] = -INFINITY;
  }
  for (int32_t k = first; k < first + count; k++) {
    const double *corner[3];
    corners_of(surface, surface->order[k], corner);
    for (int c = 0; c < 3; c++)
      for (int a = 0; a < 3; a++) {
        node->low[a] = fmin(node->low[a], corner[c][a]);
        node->high[a] = fmax(node->high[a], corner[c][a]);
      }
  }
}

/* Nodes from `at` on for these places of the order; returns the node behind them. */
static int32_t build(hc_surface *surface, sorted *room, int32_t at, int32_t first, int32_t count) {
  hc_surface_node *const node = &surface->nodes[at];
  bound(surface, node, first, count);
  if (count <= LEAF) {
    node->first = first;
    node->count = count;
    return at + 1;
  }
  int axis = 0;
  for (int a = 1; a < 3; a++)
    if (node->high[a] - node->low[a] > node->high[axis] - node->low[axis]) axis = a;
  for (int32_t k = 0; k < count; k++) {
    const double *corner[3];
    room[k].triangle = surface->order[first + k];
    corners_of(surface, room[k].triangle, corner);
    room[k].middle = corner[0][axis] + corner[1][axis] + corner[2][axis];
  }
  qsort(room, (size_t)count, sizeof *room, by_middle);
  for (int32_t k = 0; k < count; k++) surface->order[first + k] = room[k].triangle;
  const int32_t second = build(surface, room, at + 1, first, count / 2);
  node->first = second;
  node->count = 0;
  return build(surface, room, second, first + count / 2, count - count / 2);
}

static void find_normals(hc_surface *surface) {
  const hc_mesh *const mesh = &surface->mesh;
  memset(surface->vertex_normal, 0, (size_t)mesh->vertex_count * sizeof *surface->vertex_normal);
  for (int32_t t = 0; t < mesh->triangle_count; t++) {
    const double *corner[3];
    double side[3][3];
    corners_of(surface, t, corner);
    for (int c = 0; c < 3; c++) hc_vector_minus(corner[(c + 1) % 3], corner[c], side[c]);
    hc_vector_cross(side[0], side[1], surface->face_normal[t]);
    hc_vector_normalize(surface->face_normal[t]);
    for (int c = 0; c < 3; c++) {
      const double *const before = side[(c + 2) % 3], back[3] = {-before[0], -before[1], -before[2]};
      const double angle = hc_vector_angle(side[c], back);
      for (int a = 0; a < 3; a++)
        surface->vertex_normal[mesh->triangle[t][c]][a] += angle * surface->face_normal[t][a];
    }
  }
  for (int32_t v = 0; v < mesh->vertex_count; v++) hc_vector_normalize(surface->vertex_normal[v]);
}

hc_surface *hc_surface_make(hc_mesh *mesh, bool closed) {
  HC_CHECK(mesh->triangle_count > 0 && mesh->neighbour,
           "a surface needs a mesh that was checked, got %d triangles", mesh->triangle_count);
  hc_surface *const surface = hc_alloc_zero(1, sizeof *surface);
  surface->mesh = *mesh;
  surface->closed = closed;
  *mesh = (hc_mesh){0};
  const size_t triangles = (size_t)surface->mesh.triangle_count;
  hc_mesh_bounds(&surface->mesh, surface->low, surface->high);
  surface->face_normal = hc_alloc(triangles, sizeof *surface->face_normal);
  surface->vertex_normal = hc_alloc((size_t)surface->mesh.vertex_count, sizeof *surface->vertex_normal);
  surface->nodes = hc_alloc(2 * triangles, sizeof *surface->nodes);
  surface->order = hc_alloc(triangles, sizeof *surface->order);
  for (size_t t = 0; t < triangles; t++) surface->order[t] = (int32_t)t;
  sorted *const room = hc_alloc(triangles, sizeof *room);
  build(surface, room, 0, 0, (int32_t)triangles);
  hc_free(room);
  find_normals(surface);
  return surface;
}

void hc_surface_free(hc_surface *surface) {
  if (!surface) return;
  hc_mesh_free(&surface->mesh);
  hc_free(surface->face_normal);
  hc_free(surface->vertex_normal);
  hc_free(surface->nodes);
  hc_free(surface->order);
  hc_free(surface->samples);
  hc_free(surface);
}

/* --- The nearest point --- */

static inline void set_share(double share[3], double a, double b, double c) {
  share[0] = a;
  share[1] = b;
  share[2] = c;
}

/* The shares of the corners in the point of a triangle that is nearest to x: exactly 0 for corners that do
 * not have one, so that vertices and edges are known. */
static inline __attribute__((always_inline)) void nearest_share(const double *corner[3], const double x[3],
                                                                double share[3]) {
  double ab[3], ac[3], ax[3], bx[3], cx[3];
  hc_vector_minus(corner[1], corner[0], ab);
  hc_vector_minus(corner[2], corner[0], ac);
  hc_vector_minus(x, corner[0], ax);
  hc_vector_minus(x, corner[1], bx);
  hc_vector_minus(x, corner[2], cx);
  const double d1 = hc_vector_dot(ab, ax), d2 = hc_vector_dot(ac, ax), d3 = hc_vector_dot(ab, bx),
               d4 = hc_vector_dot(ac, bx), d5 = hc_vector_dot(ab, cx), d6 = hc_vector_dot(ac, cx);
  if (d1 <= 0 && d2 <= 0) return set_share(share, 1, 0, 0);
  if (d3 >= 0 && d4 <= d3) return set_share(share, 0, 1, 0);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return set_share(share, 1 - d1 / (d1 - d3), d1 / (d1 - d3), 0);
  if (d6 >= 0 && d5 <= d6) return set_share(share, 0, 0, 1);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return set_share(share, 1 - d2 / (d2 - d6), 0, d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4, up = d4 - d3, down = d5 - d6;
  if (va <= 0 && up >= 0 && down >= 0) return set_share(share, 0, 1 - up / (up + down), up / (up + down));
  const double all = va + vb + vc;
  set_share(share, 1 - vb / all - vc / all, vb / all, vc / all);
}

static double box_square(const hc_surface_node *node, const double x[3]) {
  double square = 0;
  for (int a = 0; a < 3; a++) {
    const double below = node->low[a] - x[a], above = x[a] - node->high[a];
    const double beyond = below > above ? below : above; /* fmax calls the library */
    if (beyond > 0) square += beyond * beyond;
  }
  return square;
}

/* The nearer of what was found and a triangle. */
static double look_at(const hc_surface *surface, int32_t t, const double x[3], double least,
                      hc_surface_point *found) {
  const double *corner[3];
  double share[3], at[3], away[3];
  corners_of(surface, t, corner);
  nearest_share(corner, x, share);
  for (int a = 0; a < 3; a++)
    at[a] = share[0] * corner[0][a] + share[1] * corner[1][a] + share[2] * corner[2][a];
  hc_vector_minus(x, at, away);
  const double square = hc_vector_dot(away, away);
  if (square >= least) return least;
  found->triangle = t;
  memcpy(found->x, at, sizeof at);
  memcpy(found->share, share, sizeof share);
  return square;
}

hc_surface_point hc_surface_nearest_among(const hc_surface *surface, const hc_surface_node *nodes,
                                          const double x[3], double within) {
  hc_surface_point found = {.triangle = -1};
  int32_t open[DEEPEST];
  double squares[DEEPEST], least = within;
  int left = 0;
  open[left] = 0;
  squares[left++] = box_square(&nodes[0], x);
  while (left > 0) {
    const int32_t at = open[--left];
    if (squares[left] >= least) continue;
    const hc_surface_node *const node = &nodes[at];
    for (int32_t k = 0; k < node->count; k++)
      least = look_at(surface, surface->order[node->first + k], x, least, &found);
    if (node->count > 0) continue;
    const int32_t child[2] = {at + 1, node->first};
    const double square[2] = {box_square(&nodes[child[0]], x), box_square(&nodes[child[1]], x)};
    const int nearer = square[1] < square[0];
    for (int k = 0; k < 2; k++) { /* the nearer one comes off first */
      const int which = k ? nearer : !nearer;
      open[left] = child[which];
      squares[left++] = square[which];
    }
  }
  found.distance = sqrt(least);
  return found;
}

hc_surface_point hc_surface_nearest(const hc_surface *surface, const double x[3]) {
  return hc_surface_nearest_among(surface, surface->nodes, x, INFINITY);
}

double hc_surface_square(const hc_surface *surface, int32_t triangle, const double x[3]) {
  hc_surface_point unused;
  return look_at(surface, triangle, x, INFINITY, &unused);
}

/* The normal that decides on the side, see the header. */
static void side_normal(const hc_surface *surface, const hc_surface_point *point, double normal[3]) {
  const int32_t t = point->triangle;
  int zeros = 0, zero = 0, one = 0;
  for (int c = 0; c < 3; c++) {
    if (point->share[c] == 0) {
      zeros++;
      zero = c;
    } else {
      one = c;
    }
  }
  memcpy(normal, surface->face_normal[t], sizeof surface->face_normal[t]);
  if (zeros == 2) memcpy(normal, surface->vertex_normal[surface->mesh.triangle[t][one]], 3 * sizeof *normal);
  const int32_t beyond =
      surface->mesh.neighbour[t][(zero + 1) % 3]; /* across from the corner without a share */
  if (zeros == 1 && beyond >= 0)
    for (int a = 0; a < 3; a++) normal[a] += surface->face_normal[beyond][a];
}

double hc_surface_signed(const hc_surface *surface, const double x[3], const hc_surface_point *nearest) {
  double normal[3], away[3];
  side_normal(surface, nearest, normal);
  hc_vector_minus(x, nearest->x, away);
  return hc_vector_dot(away, normal) < 0 ? -nearest->distance : nearest->distance;
}

double hc_surface_signed_distance(const hc_surface *surface, const double x[3], hc_surface_point *nearest) {
  const hc_surface_point point = hc_surface_nearest(surface, x);
  if (nearest) *nearest = point;
  return hc_surface_signed(surface, x, &point);
}

/* --- Rays --- */

/* Where a ray meets a triangle (Moeller and Trumbore 1997), `most` if it does not or farther. */
static double meet(const hc_surface *surface, int32_t t, const double x[3], const double ray[3],
                   double most) {
  const double *corner[3];
  double ab[3], ac[3], ax[3], p[3], q[3];
  corners_of(surface, t, corner);
  hc_vector_minus(corner[1], corner[0], ab);
  hc_vector_minus(corner[2], corner[0], ac);
  hc_vector_minus(x, corner[0], ax);
  hc_vector_cross(ray, ac, p);
  hc_vector_cross(ax, ab, q);
  const double det = hc_vector_dot(ab, p);
  if (det == 0) return most;
  const double u = hc_vector_dot(ax, p) / det, v = hc_vector_dot(ray, q) / det,
               along = hc_vector_dot(ac, q) / det;
  if (u < 0 || v < 0 || u + v > 1 || along <= 0) return most;
  return fmin(along, most);
}

static bool box_meets(const hc_surface_node *node, const double x[3], const double ray[3], double most) {
  double from = 0, to = most;
  for (int a = 0; a < 3; a++) {
    if (ray[a] == 0) {
      if (x[a] < node->low[a] || x[a] > node->high[a]) return false;
      continue;
    }
    const double low = (node->low[a] - x[a]) / ray[a], high = (node->high[a] - x[a]) / ray[a];
    const double in = low < high ? low : high, out = low < high ? high : low;
    if (in > from) from = in;
    if (out < to) to = out;
  }
  return from <= to;
}

bool hc_surface_faces(const hc_surface *surface, int32_t triangle, const double ray[3], double side) {
  return side * hc_vector_dot(surface->face_normal[triangle], ray) > straight;
}

double hc_surface_ray(const hc_surface *surface, const hc_surface_node *nodes, const double x[3],
                      const double ray[3], double side, double most) {
  int32_t open[DEEPEST];
  int left = 0;
  open[left++] = 0;
  while (left > 0) {
    const int32_t at = open[--left];
    const hc_surface_node *const node = &nodes[at];
    if (!box_meets(node, x, ray, most)) continue;
    for (int32_t k = 0; k < node->count; k++) {
      const int32_t t = surface->order[node->first + k];
      if (hc_surface_faces(surface, t, ray, side)) most = meet(surface, t, x, ray, most);
    }
    if (node->count > 0) continue;
    open[left++] = node->first;
    open[left++] = at + 1;
  }
  return most;
}

/* --- Smooth normals --- */

bool hc_surface_crease(const hc_surface *surface, int32_t triangle, int side) {
  const int32_t beyond = surface->mesh.neighbour[triangle][side];
  return beyond < 0 || hc_vector_dot(surface->face_normal[triangle], surface->face_normal[beyond]) < sharp;
}

void hc_surface_shares(const hc_surface *surface, int32_t triangle, const double x[3], double share[3]) {
  const double *corner[3];
  corners_of(surface, triangle, corner);
  nearest_share(corner, x, share);
}

static int corner_at(const hc_surface *surface, int32_t triangle, int32_t vertex) {
  const int32_t *const corner = surface->mesh.triangle[triangle];
  return corner[0] == vertex ? 0 : corner[1] == vertex ? 1 : 2;
}

static void add_weighted(const hc_surface *surface, int32_t triangle, int c, double sum[3]) {
  const double *corner[3];
  double next[3], last[3];
  corners_of(surface, triangle, corner);
  hc_vector_minus(corner[(c + 1) % 3], corner[c], next);
  hc_vector_minus(corner[(c + 2) % 3], corner[c], last);
  const double angle = hc_vector_angle(next, last);
  for (int a = 0; a < 3; a++) sum[a] += angle * surface->face_normal[triangle][a];
}

/* The mean over the faces around a corner that are reached without crossing a crease. */
static void corner_normal(const hc_surface *surface, int32_t triangle, int c, double normal[3]) {
  const int32_t vertex = surface->mesh.triangle[triangle][c];
  normal[0] = normal[1] = normal[2] = 0;
  add_weighted(surface, triangle, c, normal);
  for (int way = 0; way < 2; way++) {
    int32_t at = triangle;
    int corner = c;
    for (;;) {
      const int side = way ? corner : (corner + 2) % 3;
      if (hc_surface_crease(surface, at, side)) break;
      at = surface->mesh.neighbour[at][side];
      corner = corner_at(surface, at, vertex);
      if (at == triangle) {
        hc_vector_normalize(normal);
        return; /* once around */
      }
      add_weighted(surface, at, corner, normal);
    }
  }
  hc_vector_normalize(normal);
}

void hc_surface_smooth_normal(const hc_surface *surface, int32_t triangle, const double share[3],
                              double normal[3]) {
  double sum[3] = {0, 0, 0};
  for (int c = 0; c < 3; c++) {
    double at[3];
    if (share[c] == 0) continue;
    corner_normal(surface, triangle, c, at);
    for (int a = 0; a < 3; a++) sum[a] += share[c] * at[a];
  }
  hc_vector_normalize(sum);
  memcpy(normal, sum, sizeof sum);
}
