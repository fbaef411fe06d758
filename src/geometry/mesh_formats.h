/* The three kinds of mesh files, read into a soup. The bytes are those of a whole file, zero-terminated;
 * `path` is for messages. HC_BAD_INPUT with path, line where there are lines, and what is wrong. Local.
 *
 * Numbers that a file has in single precision are taken for the shortest decimal ones that they stand for, so
 * that 0.1 is 0.1 and not 0.100000001490116. */
#ifndef HC_MESH_FORMATS_H
#define HC_MESH_FORMATS_H

#include "base/text_file.h"
#include "mesh_soup.h"

/* Wavefront OBJ: v and f, with indices from 1 or counted back from the last; all else is passed over. */
hc_status hc_mesh_read_obj(const char *path, const char *bytes, size_t length, hc_mesh_soup *soup,
                           hc_error *error);

/* STL, text or binary; bytes behind the last triangle of a binary one do not count. */
hc_status hc_mesh_read_stl(const char *path, const char *bytes, size_t length, hc_mesh_soup *soup,
                           hc_error *error);

/* PLY, text or binary of either byte order: x, y, z of `vertex` and the list of `face`. */
hc_status hc_mesh_read_ply(const char *path, const char *bytes, size_t length, hc_mesh_soup *soup,
                           hc_error *error);

/* The three numbers of a vertex from *at on, which moves behind them; what the kinds of text share. */
hc_status hc_mesh_read_point(const char *path, const hc_lines *lines, char **at, double x[3],
                             hc_error *error);

/* The decimal number of the fewest digits that is nearest to this single one. */
double hc_mesh_decimal(float value);

#endif
