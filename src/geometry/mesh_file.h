/* Meshes from files: OBJ, STL (text and binary) and PLY, read by Assimp (the only user of it).
 *
 * Assimp keeps coordinates in single precision; they are taken for the shortest decimal numbers that they
 * stand for, so that what a text says is what is meant: 0.1, not 0.100000001490116. Polygons are cut into
 * triangles, lines and points left away, materials and groups ignored. */
#ifndef HC_MESH_FILE_H
#define HC_MESH_FILE_H

#include "mesh.h"

/* Reads all triangles of a file, as they stand in it; `*checksum` is that of its bytes. Freed with
 * hc_mesh_free. HC_BAD_INPUT, with the path: no such file, not readable, empty, of another kind, broken,
 * without triangles, more than HC_MESH_MOST of them. Local. */
hc_status hc_mesh_file_read(const char *path, hc_mesh *mesh, uint64_t *checksum, hc_error *error);

#endif
