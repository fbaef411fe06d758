/* Triangle meshes: welding, checks, neighbours.
 *
 * A mesh comes as a soup of triangles (mesh_file.h, revolution.h). Welding makes one vertex of those that are
 * closer than a tolerance; then each edge is between two triangles, or at a border. What is wrong with a mesh
 * is said, never repaired, but for one thing: triangles that welding collapses to an edge or a point go.
 *
 * Known weakness: surfaces that cut through themselves are not looked for.
 *
 * All functions are local; the result depends on the arguments alone, never on addresses. Metres. */
#ifndef HC_MESH_H
#define HC_MESH_H

#include "halocline/error.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct hc_mesh {
  double (*vertex)[3];
  int32_t (*triangle)[3];  /* counterclockwise seen from outside, or from the fluid */
  int32_t (*neighbour)[3]; /* beyond the edge from corner e to e + 1; -1: a border; null before the check */
  int32_t vertex_count, triangle_count;
} hc_mesh;

enum { HC_MESH_MOST = 1 << 26, HC_MESH_MOST_SHELLS = 1000 };

/* Room for so many vertices and triangles, their contents undefined. Freed with hc_mesh_free. */
hc_mesh hc_mesh_make(int32_t vertices, int32_t triangles);
void hc_mesh_free(hc_mesh *mesh);

/* The smallest box around the vertices, of which there must be some. */
void hc_mesh_bounds(const hc_mesh *mesh, double low[3], double high[3]);

/* x -> translation + turn (scale x), the turn by `turns` whole turns, right-handed about `axis`. */
void hc_mesh_place(hc_mesh *mesh, double scale, const double axis[3], double turns,
                   const double translation[3]);

/* Welds vertices closer than 1e-6 of the bounding box's diagonal: they take the place of the first of them.
 */
void hc_mesh_weld(hc_mesh *mesh);

/* Finds the neighbours of a welded mesh. HC_BAD_INPUT, said with counts and a place: vertices that are no
 * finite numbers, no triangles, triangles without area, edges with more than two triangles or with two that
 * are turned against each other, more than HC_MESH_MOST_SHELLS shells that do not hang together, and, unless
 * `may_be_open`, edges with one. `*turned`: a closed mesh had its inside out (negative volume) and was
 * turned. A shell inside out among others, within none of them: HC_BAD_INPUT. */
hc_status hc_mesh_check(hc_mesh *mesh, bool may_be_open, bool *turned, hc_error *error);

/* The volume of a closed mesh, m3, negative if it is inside out. */
double hc_mesh_volume(const hc_mesh *mesh);

/* Turns all triangles around. */
void hc_mesh_turn_around(hc_mesh *mesh);

#endif
