/* Meshes for tests: made here, so that no files of them are kept. */
#ifndef MESHES_H
#define MESHES_H

#include "geometry/mesh.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Faces of one box after the other, each of 12 triangles with vertices of its own, as STL has them. */
static inline void add_face(hc_mesh *mesh, const double corner[4][3]) {
  static const int half[2][3] = {{0, 1, 2}, {0, 2, 3}};
  for (int h = 0; h < 2; h++) {
    for (int c = 0; c < 3; c++) {
      memcpy(mesh->vertex[mesh->vertex_count], corner[half[h][c]], sizeof *mesh->vertex);
      mesh->triangle[mesh->triangle_count][c] = mesh->vertex_count++;
    }
    mesh->triangle_count++;
  }
}

static inline hc_mesh empty_mesh(int32_t vertices, int32_t triangles) {
  hc_mesh mesh = hc_mesh_make(vertices, triangles);
  mesh.vertex_count = mesh.triangle_count = 0;
  return mesh;
}

static inline void add_box(hc_mesh *mesh, const double low[3], const double high[3]) {
  for (int a = 0; a < 3; a++)
    for (int upper = 0; upper < 2; upper++) {
      double corner[4][3];
      for (int k = 0; k < 4; k++) {
        const int turn = upper ? k : 3 - k; /* counterclockwise from outside */
        const int next = (a + 1) % 3, last = (a + 2) % 3;
        corner[k][a] = upper ? high[a] : low[a];
        corner[k][next] = turn == 1 || turn == 2 ? high[next] : low[next];
        corner[k][last] = turn >= 2 ? high[last] : low[last];
      }
      add_face(mesh, (const double(*)[3])corner);
    }
}

static inline hc_mesh box_mesh(const double low[3], const double high[3]) {
  hc_mesh mesh = empty_mesh(36, 12);
  add_box(&mesh, low, high);
  return mesh;
}

/* An L standing on y = 0: x from 0 to 2, z from 0 to 2 without the quarter above (1, 1), y from 0 to 1;
 * scaled. */
static inline hc_mesh l_mesh(double scale) {
  static const double outline[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  static const int ends[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}};
  hc_mesh mesh = hc_mesh_make(12, 20);
  int32_t t = 0;
  for (int side = 0; side < 2; side++)
    for (int v = 0; v < 6; v++) {
      mesh.vertex[6 * side + v][0] = scale * outline[v][0];
      mesh.vertex[6 * side + v][1] = scale * side;
      mesh.vertex[6 * side + v][2] = scale * outline[v][1];
    }
  for (int k = 0; k < 4; k++, t += 2)
    for (int c = 0; c < 3; c++) {
      mesh.triangle[t][c] = ends[k][c];
      mesh.triangle[t + 1][c] = 6 + ends[k][2 - c];
    }
  for (int v = 0; v < 6; v++, t += 2) {
    const int32_t corner[4] = {v, 6 + v, 6 + (v + 1) % 6, (v + 1) % 6};
    const int32_t halves[2][3] = {{corner[0], corner[1], corner[2]}, {corner[0], corner[2], corner[3]}};
    memcpy(mesh.triangle[t], halves[0], sizeof halves[0]);
    memcpy(mesh.triangle[t + 1], halves[1], sizeof halves[1]);
  }
  return mesh;
}

/* A sphere: an icosahedron whose triangles are cut into four so many times; vertices are not shared. */
static inline hc_mesh sphere_mesh(const double centre[3], double radius, int cuts) {
  const double g = 0.5 * (1 + sqrt(5.0));
  const double corner[12][3] = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                                {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  static const int face[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                  {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                  {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                  {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  const int n = 1 << cuts;
  hc_mesh mesh = empty_mesh(60 * n * n, 20 * n * n);
  for (int f = 0; f < 20; f++)
    for (int i = 0; i < n; i++)
      for (int j = 0; j < 2 * (n - i) - 1; j++) {
        /* Of a row, even ones stand upright, odd ones upside down. */
        const int at[2][3][2] = {{{i, j / 2}, {i, j / 2 + 1}, {i + 1, j / 2}},
                                 {{i, j / 2 + 1}, {i + 1, j / 2 + 1}, {i + 1, j / 2}}};
        for (int c = 0; c < 3; c++) {
          double x[3], square = 0;
          const double up = at[j % 2][c][0], along = at[j % 2][c][1], rest = n - up - along;
          for (int a = 0; a < 3; a++) {
            x[a] = rest * corner[face[f][0]][a] + along * corner[face[f][1]][a] + up * corner[face[f][2]][a];
            square += x[a] * x[a];
          }
          for (int a = 0; a < 3; a++)
            mesh.vertex[mesh.vertex_count][a] = centre[a] + radius * x[a] / sqrt(square);
          mesh.triangle[mesh.triangle_count][c] = mesh.vertex_count++;
        }
        mesh.triangle_count++;
      }
  return mesh;
}

#endif
