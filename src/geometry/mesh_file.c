#include "mesh_file.h"

#include "base/memory.h"
#include "base/text_file.h"
#include "mesh_formats.h"

#include <string.h>
#include <strings.h>
#include <xxhash.h>

static const size_t largest_file = (size_t)2 << 30;

static const struct kind {
  const char *suffix;
  hc_status (*read)(const char *path, const char *bytes, size_t length, hc_mesh_soup *soup, hc_error *error);
} kinds[] = {{"obj", hc_mesh_read_obj}, {"stl", hc_mesh_read_stl}, {"ply", hc_mesh_read_ply}};

static const struct kind *kind_of(const char *path) {
  const char *const dot = strrchr(path, '.');
  for (size_t k = 0; dot && k < sizeof kinds / sizeof *kinds; k++)
    if (strcasecmp(dot + 1, kinds[k].suffix) == 0) return &kinds[k];
  return NULL;
}

hc_status hc_mesh_file_read(const char *path, hc_mesh *mesh, uint64_t *checksum, hc_error *error) {
  *mesh = (hc_mesh){0};
  *checksum = 0;
  const struct kind *const kind = kind_of(path);
  if (!kind)
    return hc_error_set(error, HC_BAD_INPUT, "%s: a mesh must be a file of the kind .obj, .stl or .ply",
                        path);
  char *bytes;
  size_t length;
  if (hc_file_load(path, largest_file, "a mesh file", &bytes, &length, error) != HC_OK) return error->status;
  *checksum = XXH64(bytes, length, 0);
  hc_mesh_soup soup = {.vertices = 0};
  hc_status status = kind->read(path, bytes, length, &soup, error);
  hc_free(bytes);
  if (status == HC_OK && soup.triangles == 0)
    status = hc_error_set(error, HC_BAD_INPUT, "%s: must have triangles, and has none", path);
  if (status == HC_OK) *mesh = hc_mesh_soup_take(&soup);
  hc_mesh_soup_free(&soup);
  return status;
}
