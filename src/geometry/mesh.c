#include "mesh.h"

#include "base/check.h"
#include "base/memory.h"
#include "base/turns.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

static const double weld_tolerance = 1e-6; /* of the diagonal */
static const double weld_cell = 1e-4;      /* of the diagonal: wide, so that few vertices look into several */
static const double flat = 1e-12;          /* area over the square of the longest edge that is none */

hc_mesh hc_mesh_make(int32_t vertices, int32_t triangles) {
  hc_mesh mesh = {.vertex_count = vertices, .triangle_count = triangles};
  mesh.vertex = hc_alloc((size_t)vertices, sizeof *mesh.vertex);
  mesh.triangle = hc_alloc((size_t)triangles, sizeof *mesh.triangle);
  return mesh;
}

void hc_mesh_free(hc_mesh *mesh) {
  hc_free(mesh->vertex);
  hc_free(mesh->triangle);
  hc_free(mesh->neighbour);
  *mesh = (hc_mesh){0};
}

void hc_mesh_bounds(const hc_mesh *mesh, double low[3], double high[3]) {
  for (int a = 0; a < 3; a++) {
    low[a] = INFINITY;
    high[a] = -INFINITY;
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
      low[a] = fmin(low[a], mesh->vertex[v][a]);
      high[a] = fmax(high[a], mesh->vertex[v][a]);
    }
  }
}

void hc_mesh_place(hc_mesh *mesh, double scale, const double axis[3], double turns,
                   const double translation[3]) {
  const double cosine = hc_turns_cosine(turns), sine = hc_turns_sine(turns);
  double u[3] = {axis[0], axis[1], axis[2]};
  if (turns != 0) hc_vector_normalize(u);
  for (int32_t v = 0; v < mesh->vertex_count; v++) {
    double x[3], across[3];
    for (int a = 0; a < 3; a++) x[a] = scale * mesh->vertex[v][a];
    hc_vector_cross(u, x, across);
    const double along = hc_vector_dot(u, x);
    for (int a = 0; a < 3; a++) {
      const double turned =
          turns != 0 ? cosine * x[a] + sine * across[a] + (1 - cosine) * along * u[a] : x[a];
      mesh->vertex[v][a] = turned + translation[a];
    }
  }
}

/* --- Welding --- */

typedef struct placed {
  int64_t cell[3];
  int32_t vertex;
} placed;

static int compare_cells(const int64_t a[3], const int64_t b[3]) {
  for (int k = 0; k < 3; k++)
    if (a[k] != b[k]) return a[k] < b[k] ? -1 : 1;
  return 0;
}

static int by_cell(const void *left, const void *right) {
  const placed *const a = left, *const b = right;
  const int order = compare_cells(a->cell, b->cell);
  return order ? order : (a->vertex > b->vertex) - (a->vertex < b->vertex);
}

typedef struct welding {
  const hc_mesh *mesh;
  double low[3], cell, tolerance;
  placed *sorted;
  int32_t *kept; /* of each vertex: the first at its place */
} welding;

static void cell_at(const welding *w, const double x[3], double shift[3], int64_t cell[3]) {
  for (int a = 0; a < 3; a++) cell[a] = (int64_t)floor((x[a] + shift[a] - w->low[a]) / w->cell);
}

/* The first kept vertex in a cell that is at the place of v, or v. */
static int32_t kept_in(const welding *w, const int64_t cell[3], int32_t v) {
  int32_t low = 0, high = w->mesh->vertex_count;
  while (low < high) {
    const int32_t middle = low + (high - low) / 2;
    if (compare_cells(w->sorted[middle].cell, cell) < 0)
      low = middle + 1;
    else
      high = middle;
  }
  for (; low < w->mesh->vertex_count && compare_cells(w->sorted[low].cell, cell) == 0; low++) {
    const int32_t other = w->sorted[low].vertex;
    if (other >= v) break;
    double away[3];
    hc_vector_minus(w->mesh->vertex[other], w->mesh->vertex[v], away);
    if (w->kept[other] == other && hc_vector_dot(away, away) <= w->tolerance * w->tolerance) return other;
  }
  return v;
}

static int32_t find_kept(const welding *w, int32_t v) {
  int32_t first = v;
  int64_t seen[8][3];
  int cells = 0;
  for (int corner = 0; corner < 8; corner++) {
    double shift[3];
    for (int a = 0; a < 3; a++) shift[a] = corner >> a & 1 ? w->tolerance : -w->tolerance;
    cell_at(w, w->mesh->vertex[v], shift, seen[cells]);
    bool again = false;
    for (int k = 0; k < cells; k++) again |= compare_cells(seen[k], seen[cells]) == 0;
    if (again) continue;
    const int32_t found = kept_in(w, seen[cells++], v);
    if (found < first) first = found;
  }
  return first;
}

/* Renumbers what is kept and drops triangles that collapsed. */
static void compact(hc_mesh *mesh, int32_t *kept) {
  int32_t vertices = 0, triangles = 0;
  for (int32_t v = 0; v < mesh->vertex_count; v++) {
    if (kept[v] != v) { /* to an earlier one, which has its number */
      kept[v] = kept[kept[v]];
      continue;
    }
    memmove(mesh->vertex[vertices], mesh->vertex[v], sizeof mesh->vertex[v]);
    kept[v] = vertices++;
  }
  for (int32_t t = 0; t < mesh->triangle_count; t++) {
    int32_t corner[3];
    for (int c = 0; c < 3; c++) corner[c] = kept[mesh->triangle[t][c]];
    if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) continue;
    memcpy(mesh->triangle[triangles++], corner, sizeof corner);
  }
  mesh->vertex_count = vertices;
  mesh->triangle_count = triangles;
}

void hc_mesh_weld(hc_mesh *mesh) {
  for (int32_t v = 0; v < mesh->vertex_count; v++)
    for (int a = 0; a < 3; a++)
      if (!isfinite(mesh->vertex[v][a])) return; /* the check tells */
  welding w = {.mesh = mesh};
  double high[3], diagonal[3];
  hc_mesh_bounds(mesh, w.low, high);
  hc_vector_minus(high, w.low, diagonal);
  const double extent = hc_vector_length(diagonal);
  if (!(extent > 0) || !isfinite(extent)) return;
  w.tolerance = weld_tolerance * extent;
  w.cell = weld_cell * extent;
  w.sorted = hc_alloc((size_t)mesh->vertex_count, sizeof *w.sorted);
  w.kept = hc_alloc((size_t)mesh->vertex_count, sizeof *w.kept);
  for (int32_t v = 0; v < mesh->vertex_count; v++) {
    double none[3] = {0, 0, 0};
    cell_at(&w, mesh->vertex[v], none, w.sorted[v].cell);
    w.sorted[v].vertex = v;
  }
  qsort(w.sorted, (size_t)mesh->vertex_count, sizeof *w.sorted, by_cell);
  for (int32_t v = 0; v < mesh->vertex_count; v++) w.kept[v] = find_kept(&w, v);
  compact(mesh, w.kept);
  hc_free(w.sorted);
  hc_free(w.kept);
}

/* --- Checks --- */

/* One side of a triangle, from its corner `side` to the next. */
typedef struct half_edge {
  int32_t low, high; /* its vertices, in order */
  int32_t triangle;
  int8_t side;
  bool up; /* from low to high */
} half_edge;

static int by_edge(const void *left, const void *right) {
  const half_edge *const a = left, *const b = right;
  if (a->low != b->low) return a->low < b->low ? -1 : 1;
  if (a->high != b->high) return a->high < b->high ? -1 : 1;
  return (a->triangle > b->triangle) - (a->triangle < b->triangle);
}

/* What is wrong with the edges: how many, and the first. */
typedef struct flaw {
  int64_t count;
  int32_t vertex[2];
} flaw;

static void note(flaw *f, const half_edge *edge) {
  if (f->count++ == 0) {
    f->vertex[0] = edge->low;
    f->vertex[1] = edge->high;
  }
}

static hc_status tell(const hc_mesh *mesh, const flaw *f, const char *what, hc_error *error) {
  const double *const a = mesh->vertex[f->vertex[0]], *const b = mesh->vertex[f->vertex[1]];
  return hc_error_set(error, HC_BAD_INPUT,
                      "%lld of its edges %s, the first from (%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g) m",
                      (long long)f->count, what, a[0], a[1], a[2], b[0], b[1], b[2]);
}

static hc_status find_neighbours(hc_mesh *mesh, bool may_be_open, hc_error *error) {
  const size_t count = 3 * (size_t)mesh->triangle_count;
  half_edge *const edges = hc_alloc(count, sizeof *edges);
  for (size_t k = 0; k < count; k++) {
    const int32_t t = (int32_t)(k / 3), from = mesh->triangle[t][k % 3], to = mesh->triangle[t][(k + 1) % 3];
    edges[k] = (half_edge){from < to ? from : to, from < to ? to : from, t, (int8_t)(k % 3), from < to};
  }
  qsort(edges, count, sizeof *edges, by_edge);
  mesh->neighbour = hc_alloc((size_t)mesh->triangle_count, sizeof *mesh->neighbour);
  flaw border = {0, {0, 0}}, crowded = {0, {0, 0}}, against = {0, {0, 0}};
  for (size_t k = 0, next; k < count; k = next) {
    for (next = k + 1; next < count && edges[next].low == edges[k].low && edges[next].high == edges[k].high;)
      next++;
    if (next - k == 1) {
      note(&border, &edges[k]);
      mesh->neighbour[edges[k].triangle][edges[k].side] = -1;
    } else if (next - k > 2) {
      note(&crowded, &edges[k]);
    } else if (edges[k].up == edges[k + 1].up) {
      note(&against, &edges[k]);
    } else {
      mesh->neighbour[edges[k].triangle][edges[k].side] = edges[k + 1].triangle;
      mesh->neighbour[edges[k + 1].triangle][edges[k + 1].side] = edges[k].triangle;
    }
  }
  hc_free(edges);
  if (crowded.count) return tell(mesh, &crowded, "belong to more than two triangles", error);
  if (against.count)
    return tell(mesh, &against, "lie between two triangles that are turned against each other", error);
  if (border.count && !may_be_open)
    return tell(mesh, &border, "belong to one triangle only, so that it is not closed", error);
  return HC_OK;
}

static double volume_of(const hc_mesh *mesh, int32_t t, const double from[3]) {
  double corner[3][3], product[3];
  for (int c = 0; c < 3; c++) hc_vector_minus(mesh->vertex[mesh->triangle[t][c]], from, corner[c]);
  hc_vector_cross(corner[1], corner[2], product);
  return hc_vector_dot(corner[0], product) / 6;
}

double hc_mesh_volume(const hc_mesh *mesh) {
  double volume = 0;
  for (int32_t t = 0; t < mesh->triangle_count; t++) volume += volume_of(mesh, t, mesh->vertex[0]);
  return volume;
}

void hc_mesh_turn_around(hc_mesh *mesh) {
  for (int32_t t = 0; t < mesh->triangle_count; t++) {
    const int32_t second = mesh->triangle[t][1];
    mesh->triangle[t][1] = mesh->triangle[t][2];
    mesh->triangle[t][2] = second;
    if (!mesh->neighbour) continue; /* sides 0-1, 1-2, 2-0 become 2-0, 1-2, 0-1 */
    const int32_t first = mesh->neighbour[t][0];
    mesh->neighbour[t][0] = mesh->neighbour[t][2];
    mesh->neighbour[t][2] = first;
  }
}

/* --- Shells: triangles that hang together --- */

typedef struct shell {
  double volume, low[3], high[3];
  int32_t vertex; /* one of its */
} shell;

/* Numbers the shells; `shell_of` has room for all triangles. */
static int32_t number_shells(const hc_mesh *mesh, int32_t *shell_of) {
  int32_t *const open = hc_alloc((size_t)mesh->triangle_count, sizeof *open), shells = 0;
  for (int32_t t = 0; t < mesh->triangle_count; t++) shell_of[t] = -1;
  for (int32_t t = 0; t < mesh->triangle_count; t++) {
    if (shell_of[t] >= 0) continue;
    int32_t left = 0;
    open[left++] = t;
    shell_of[t] = shells;
    while (left > 0) {
      const int32_t *const around = mesh->neighbour[open[--left]];
      for (int side = 0; side < 3; side++)
        if (around[side] >= 0 && shell_of[around[side]] < 0) {
          shell_of[around[side]] = shells;
          open[left++] = around[side];
        }
    }
    shells++;
  }
  hc_free(open);
  return shells;
}

static bool within(const shell *inner, const shell *outer) {
  for (int a = 0; a < 3; a++)
    if (inner->low[a] < outer->low[a] || inner->high[a] > outer->high[a]) return false;
  return true;
}

/* A shell inside out is a hollow of another one, or a mistake. */
static hc_status check_hollows(const hc_mesh *mesh, const int32_t *shell_of, int32_t count, hc_error *error) {
  shell *const shells = hc_alloc((size_t)count, sizeof *shells);
  for (int32_t s = 0; s < count; s++)
    shells[s] = (shell){0, {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, -1};
  for (int32_t t = 0; t < mesh->triangle_count; t++) {
    shell *const s = &shells[shell_of[t]];
    if (s->vertex < 0) s->vertex = mesh->triangle[t][0];
    s->volume += volume_of(mesh, t, mesh->vertex[s->vertex]);
    for (int c = 0; c < 3; c++)
      for (int a = 0; a < 3; a++) {
        s->low[a] = fmin(s->low[a], mesh->vertex[mesh->triangle[t][c]][a]);
        s->high[a] = fmax(s->high[a], mesh->vertex[mesh->triangle[t][c]][a]);
      }
  }
  hc_status status = HC_OK;
  for (int32_t s = 0; s < count && status == HC_OK; s++) {
    bool good = shells[s].volume > 0;
    for (int32_t other = 0; other < count && !good; other++)
      good = shells[other].volume > 0 && within(&shells[s], &shells[other]);
    const double *const x = mesh->vertex[shells[s].vertex];
    if (!good)
      status =
          hc_error_set(error, HC_BAD_INPUT,
                       "one of its %d shells, that at (%.6g, %.6g, %.6g) m, is inside out and lies in no "
                       "other: turn its triangles around",
                       count, x[0], x[1], x[2]);
  }
  hc_free(shells);
  return status;
}

static hc_status check_triangles(const hc_mesh *mesh, hc_error *error) {
  for (int32_t v = 0; v < mesh->vertex_count; v++)
    for (int a = 0; a < 3; a++)
      if (!isfinite(mesh->vertex[v][a]))
        return hc_error_set(error, HC_BAD_INPUT, "its vertices must be finite, vertex %d has %g along %c", v,
                            mesh->vertex[v][a], "xyz"[a]);
  if (mesh->triangle_count == 0)
    return hc_error_set(error, HC_BAD_INPUT, "it must have triangles with an area, and has none");
  flaw none = {0, {0, 0}};
  for (int32_t t = 0; t < mesh->triangle_count; t++) {
    double side[3][3], product[3], longest = 0;
    for (int c = 0; c < 3; c++) {
      hc_vector_minus(mesh->vertex[mesh->triangle[t][(c + 1) % 3]], mesh->vertex[mesh->triangle[t][c]],
                      side[c]);
      longest = fmax(longest, hc_vector_dot(side[c], side[c]));
    }
    hc_vector_cross(side[0], side[1], product);
    if (hc_vector_length(product) <= flat * longest && none.count++ == 0)
      none.vertex[0] = mesh->triangle[t][0];
  }
  const double *const x = mesh->vertex[none.vertex[0]];
  if (none.count > 0)
    return hc_error_set(error, HC_BAD_INPUT,
                        "%lld of its triangles have no area, the first at (%.6g, %.6g, %.6g) m",
                        (long long)none.count, x[0], x[1], x[2]);
  return HC_OK;
}

hc_status hc_mesh_check(hc_mesh *mesh, bool may_be_open, bool *turned, hc_error *error) {
  *turned = false;
  hc_status status = check_triangles(mesh, error);
  if (status == HC_OK) status = find_neighbours(mesh, may_be_open, error);
  if (status != HC_OK) return status;
  int32_t *const shell_of = hc_alloc((size_t)mesh->triangle_count, sizeof *shell_of);
  const int32_t shells = number_shells(mesh, shell_of);
  if (shells > HC_MESH_MOST_SHELLS) {
    status =
        hc_error_set(error, HC_BAD_INPUT,
                     "it falls into %d separate shells and must have at most %d: join its vertices, or give "
                     "each part a file",
                     shells, HC_MESH_MOST_SHELLS);
  } else if (!may_be_open) {
    *turned = hc_mesh_volume(mesh) < 0;
    if (*turned) hc_mesh_turn_around(mesh);
    status = check_hollows(mesh, shell_of, shells, error);
  }
  hc_free(shell_of);
  return status;
}
