/* Meshes from files: OBJ, STL (text and binary) and PLY, in double precision; see mesh_formats.h. Polygons
 * are cut into triangles, lines and points left away, materials and groups ignored; vertices without a
 * triangle do not count. */
#ifndef HC_MESH_FILE_H
#define HC_MESH_FILE_H

#include "mesh.h"

/* Reads all triangles of a file, as they stand in it; `*checksum` is that of its bytes. Freed with
 * hc_mesh_free. HC_BAD_INPUT, with the path: no such file, not readable, empty, of another kind, broken,
 * without triangles, more than HC_MESH_MOST of them. Local. */
hc_status hc_mesh_file_read(const char *path, hc_mesh *mesh, uint64_t *checksum, hc_error *error);

#endif
