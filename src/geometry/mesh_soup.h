/* Vertices and polygons as a file names them, on their way to a mesh: polygons are cut into triangles, and
 * vertices that none of them has go. Local. */
#ifndef HC_MESH_SOUP_H
#define HC_MESH_SOUP_H

#include "mesh.h"

#include <stddef.h>

/* Zeroed: empty. */
typedef struct hc_mesh_soup {
  double (*vertex)[3];
  int32_t (*triangle)[3];
  size_t vertices, triangles;
  size_t vertex_room, triangle_room;
} hc_mesh_soup;

void hc_mesh_soup_free(hc_mesh_soup *soup);

/* HC_BAD_INPUT: more than three times HC_MESH_MOST vertices; than HC_MESH_MOST triangles. */
hc_status hc_mesh_soup_add_vertex(hc_mesh_soup *soup, const double x[3], hc_error *error);

/* A polygon of `count` corners, vertices that are there; of fewer than three nothing comes. A flat one is cut
 * by its ears, so that it may be hollow; it keeps its sense. HC_BAD_INPUT: too many corners, or triangles. */
hc_status hc_mesh_soup_add_polygon(hc_mesh_soup *soup, const int32_t *corners, int count, hc_error *error);

/* The mesh of all triangles, freed with hc_mesh_free; the soup is empty then. */
hc_mesh hc_mesh_soup_take(hc_mesh_soup *soup);

#endif
