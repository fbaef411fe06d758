#include "mesh_file.h"

#include "base/memory.h"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <xxhash.h>

static const size_t largest_file = (size_t)2 << 30;

static const char *kind_of(const char *path) {
  static const char *const kinds[] = {"obj", "stl", "ply"};
  const char *const dot = strrchr(path, '.');
  for (size_t k = 0; dot && k < sizeof kinds / sizeof *kinds; k++)
    if (strcasecmp(dot + 1, kinds[k]) == 0) return kinds[k];
  return NULL;
}

/* All bytes of a file, the caller's to free. */
static hc_status load(const char *path, char **bytes, size_t *length, hc_error *error) {
  *bytes = NULL;
  *length = 0;
  struct stat status;
  FILE *const file = fopen(path, "rb");
  if (!file) return hc_error_set(error, HC_BAD_INPUT, "%s: cannot be opened: %s", path, strerror(errno));
  hc_status result = HC_OK;
  if (fstat(fileno(file), &status) != 0 || !S_ISREG(status.st_mode))
    result = hc_error_set(error, HC_BAD_INPUT, "%s: not a file", path);
  else if (status.st_size == 0)
    result = hc_error_set(error, HC_BAD_INPUT, "%s: the file is empty", path);
  else if ((size_t)status.st_size > largest_file)
    result = hc_error_set(error, HC_BAD_INPUT, "%s: must be at most %zu GiB large", path, largest_file >> 30);
  if (result == HC_OK) {
    *length = (size_t)status.st_size;
    *bytes = hc_alloc(*length, 1);
    if (fread(*bytes, 1, *length, file) != *length)
      result = hc_error_set(error, HC_BAD_INPUT, "%s: cannot be read: %s", path,
                            ferror(file) ? strerror(errno) : "it has become shorter");
  }
  fclose(file);
  return result;
}

/* The decimal number of the fewest digits that is nearest to this single one. */
static double decimal(float value) {
  static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10,
                                  1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21};
  const double size = fabs((double)value);
  if (!(size >= 1e-12 && size < 1e9)) return value;
  int whole = 0; /* digits before the point; below 0: zeros behind it */
  while (whole < 10 && size >= powers[whole]) whole++;
  while (whole > -12 && whole <= 0 && size < 1 / powers[1 - whole]) whole--;
  for (int digits = 6; digits <= 9; digits++) {
    const int places = digits - whole;
    if (places < 0 || places > 21) continue;
    const double rounded = rint(value * powers[places]) / powers[places];
    if ((float)rounded == value) return rounded;
  }
  return value;
}

static void count(const struct aiScene *scene, int64_t *vertices, int64_t *triangles) {
  *vertices = *triangles = 0;
  for (unsigned m = 0; m < scene->mNumMeshes; m++) {
    const struct aiMesh *const part = scene->mMeshes[m];
    *vertices += part->mNumVertices;
    for (unsigned f = 0; f < part->mNumFaces; f++) *triangles += part->mFaces[f].mNumIndices == 3;
  }
}

static void take(const struct aiScene *scene, hc_mesh *mesh) {
  int32_t vertices = 0, triangles = 0;
  for (unsigned m = 0; m < scene->mNumMeshes; m++) {
    const struct aiMesh *const part = scene->mMeshes[m];
    for (unsigned f = 0; f < part->mNumFaces; f++) {
      if (part->mFaces[f].mNumIndices != 3) continue;
      for (int c = 0; c < 3; c++)
        mesh->triangle[triangles][c] = vertices + (int32_t)part->mFaces[f].mIndices[c];
      triangles++;
    }
    for (unsigned v = 0; v < part->mNumVertices; v++, vertices++) {
      const struct aiVector3D *const x = &part->mVertices[v];
      const float from[3] = {x->x, x->y, x->z};
      for (int a = 0; a < 3; a++) mesh->vertex[vertices][a] = decimal(from[a]);
    }
  }
}

hc_status hc_mesh_file_read(const char *path, hc_mesh *mesh, uint64_t *checksum, hc_error *error) {
  *mesh = (hc_mesh){0};
  *checksum = 0;
  const char *const kind = kind_of(path);
  if (!kind)
    return hc_error_set(error, HC_BAD_INPUT, "%s: a mesh must be a file of the kind .obj, .stl or .ply",
                        path);
  char *bytes;
  size_t length;
  hc_status status = load(path, &bytes, &length, error);
  const struct aiScene *scene = NULL;
  if (status == HC_OK) {
    *checksum = XXH64(bytes, length, 0);
    scene = aiImportFileFromMemory(bytes, (unsigned)length, aiProcess_Triangulate, kind);
    if (!scene)
      status = hc_error_set(error, HC_BAD_INPUT, "%s: cannot be understood as .%s: %s", path, kind,
                            aiGetErrorString());
  }
  if (status == HC_OK) {
    int64_t vertices, triangles;
    count(scene, &vertices, &triangles);
    if (triangles == 0)
      status = hc_error_set(error, HC_BAD_INPUT, "%s: must have triangles, and has none", path);
    else if (vertices > 3 * (int64_t)HC_MESH_MOST || triangles > HC_MESH_MOST)
      status = hc_error_set(error, HC_BAD_INPUT, "%s: must have at most %d triangles, and has %lld", path,
                            HC_MESH_MOST, (long long)triangles);
    if (status == HC_OK) {
      *mesh = hc_mesh_make((int32_t)vertices, (int32_t)triangles);
      take(scene, mesh);
    }
  }
  if (scene) aiReleaseImport(scene);
  hc_free(bytes);
  return status;
}
