#include "snapshot_read.h"

#include "base/memory.h"
#include "facts.h"
#include "h5.h"
#include "particles/particles.h"
#include "seal.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

static hc_status broken(const hc_snapshot_file *file, hc_error *error, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static hc_status broken(const hc_snapshot_file *file, hc_error *error, const char *format, ...) {
  char text[HC_ERROR_TEXT / 2];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  const bool named = strncmp(text, file->path, strlen(file->path)) == 0; /* passed on from an inner call */
  return hc_error_set(error, HC_BAD_INPUT, "%s%s%s", named ? "" : file->path, named ? "" : ": ", text);
}

/* ---- shape of the file ---- */

/* Rows and components of a dataset; false if it is missing or has another number of dimensions. */
static bool shape(hid_t dataset, int64_t *rows, int *components) {
  const hid_t space = dataset < 0 ? H5I_INVALID_HID : H5Dget_space(dataset);
  hsize_t extent[2] = {0, 1};
  const int dimensions = space < 0 ? -1 : H5Sget_simple_extent_ndims(space);
  const bool good = (dimensions == 1 || dimensions == 2) &&
                    H5Sget_simple_extent_dims(space, extent, NULL) >= 0 && extent[1] >= 1 &&
                    extent[1] <= 64 && extent[0] <= INT64_MAX / 1024;
  if (space >= 0) H5Sclose(space);
  if (!good) return false;
  *rows = (int64_t)extent[0];
  *components = dimensions == 2 ? (int)extent[1] : 1;
  return true;
}

static bool type_of(hid_t dataset, hc_snapshot_type *type) {
  const hid_t stored = H5Dget_type(dataset);
  const H5T_class_t class = stored < 0 ? H5T_NO_CLASS : H5Tget_class(stored);
  const size_t size = stored < 0 ? 0 : H5Tget_size(stored);
  bool good = true;
  if (class == H5T_INTEGER && size == 1)
    *type = HC_SNAPSHOT_U8;
  else if (class == H5T_INTEGER && size == 8)
    *type = HC_SNAPSHOT_I64;
  else if (class == H5T_FLOAT && size == 4)
    *type = HC_SNAPSHOT_F32;
  else if (class == H5T_FLOAT && size == 8)
    *type = HC_SNAPSHOT_F64;
  else
    good = false;
  if (stored >= 0) H5Tclose(stored);
  return good;
}

static hid_t memory_type(hc_snapshot_type type) {
  switch (type) {
  case HC_SNAPSHOT_U8:
    return H5T_NATIVE_UINT8;
  case HC_SNAPSHOT_I64:
    return H5T_NATIVE_INT64;
  case HC_SNAPSHOT_F32:
    return H5T_NATIVE_FLOAT;
  case HC_SNAPSHOT_F64:
    break;
  }
  return H5T_NATIVE_DOUBLE;
}

static size_t type_bytes(hc_snapshot_type type) {
  return type == HC_SNAPSHOT_U8 ? 1 : type == HC_SNAPSHOT_F32 ? 4 : 8;
}

/* Reads a whole dataset that must have `rows` rows of `components`. */
static hc_status read_column(const hc_snapshot_file *file, const char *name, hid_t type, size_t bytes,
                             int64_t rows, int components, void **values, hc_error *error) {
  hc_error problem = {.status = HC_OK};
  int64_t found = 0;
  int parts = 0;
  *values = NULL;
  const hid_t dataset = H5Dopen2(file->handle, name, H5P_DEFAULT);
  if (!shape(dataset, &found, &parts))
    hc_h5_failed(&problem, HC_BAD_INPUT, "dataset %s is missing or has the wrong shape", name);
  else if (found != rows || parts != components)
    broken(file, &problem, "dataset %s must be %lld x %d, is %lld x %d", name, (long long)rows, components,
           (long long)found, parts);
  else {
    *values = hc_alloc((size_t)rows * (size_t)components, bytes);
    if (H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, *values) < 0)
      hc_h5_failed(&problem, HC_BAD_INPUT, "cannot read dataset %s", name);
  }
  if (dataset >= 0) H5Dclose(dataset);
  if (problem.status == HC_OK) return HC_OK;
  hc_free(*values);
  *values = NULL;
  return broken(file, error, "%s", problem.text);
}

/* The groups of a checkpoint, in the order of the rows that are made of them. */
enum { GROUPS = 3 };
static const char *const groups[GROUPS] = {"fluid", "boundary", "moving"};

/* Is there such a column in the group? */
static bool has_column(const hc_snapshot_file *file, int group, const hc_field_info *info) {
  char name[HC_SNAPSHOT_READ_NAME + 16];
  snprintf(name, sizeof name, "%s/%s", groups[group], info->name);
  return H5Lexists(file->handle, groups[group], H5P_DEFAULT) > 0 &&
         H5Lexists(file->handle, name, H5P_DEFAULT) > 0;
}

/* A column of a checkpoint: the rows of its groups; zeros where one lacks the field. */
static hc_status read_groups(const hc_snapshot_file *file, hc_field_id id, void **values, hc_error *error) {
  const hc_snapshot_facts *facts = &file->facts;
  const int64_t rows[GROUPS] = {facts->fluid, facts->boundary - facts->moving, facts->moving};
  const hc_field_info *info = &hc_fields[id];
  char *all = hc_alloc_zero((size_t)facts->particles, info->bytes), *to = all;
  hc_status status = HC_OK;
  for (int group = 0; group < GROUPS && status == HC_OK; group++) {
    char name[HC_SNAPSHOT_READ_NAME + 16];
    void *rows_read = NULL;
    const size_t bytes = (size_t)rows[group] * info->bytes;
    snprintf(name, sizeof name, "%s/%s", groups[group], info->name);
    if (has_column(file, group, info)) {
      status = read_column(file, name, hc_h5_memory_type(info->type), info->bytes / (size_t)info->components,
                           rows[group], info->components, &rows_read, error);
      if (status == HC_OK) memcpy(to, rows_read, bytes);
      hc_free(rows_read);
    }
    to += bytes;
  }
  if (status != HC_OK) {
    hc_free(all);
    all = NULL;
  }
  *values = all;
  return status;
}

/* ---- open ---- */

static void read_facts(hc_snapshot_file *file, hid_t own, hc_error *problem) {
  hc_snapshot_facts *facts = &file->facts;
  hc_h5_get(own, "format_version", H5T_NATIVE_INT64, 1, &facts->format_version, problem);
  if (problem->status == HC_OK && facts->format_version != HC_FACTS_FORMAT) {
    hc_error_set(problem, HC_BAD_INPUT,
                 "format_version must be %d, is %lld: written by another version of Halocline",
                 HC_FACTS_FORMAT, (long long)facts->format_version);
    return;
  }
  hc_h5_get_text(own, "program_version", facts->program_version, sizeof facts->program_version, problem);
  hc_h5_get_text(own, "scene", facts->scene, sizeof facts->scene, problem);
  const struct {
    const char *name;
    int count;
    double *values;
  } reals[] = {{"time", 1, &facts->time},
               {"dt", 1, &facts->dt},
               {"particle_spacing", 1, &facts->particle_spacing},
               {"support_radius", 1, &facts->support_radius},
               {"rest_density", 1, &facts->rest_density},
               {"gravity", 3, facts->gravity},
               {"unit", 3, facts->unit}};
  for (size_t k = 0; k < sizeof reals / sizeof *reals; k++)
    hc_h5_get(own, reals[k].name, H5T_NATIVE_DOUBLE, reals[k].count, reals[k].values, problem);
  facts->particle_mass = NAN;
  if (H5Aexists(own, "particle_mass") > 0)
    hc_h5_get(own, "particle_mass", H5T_NATIVE_DOUBLE, 1, &facts->particle_mass, problem);
  const struct {
    const char *name;
    int count;
    int64_t *values;
  } integers[] = {{"step", 1, &facts->step},
                  {"origin", 3, facts->origin},
                  {"period", 3, facts->period},
                  {"low", 3, facts->low},
                  {"fluid_particles", 1, &facts->fluid},
                  {"boundary_particles", 1, &facts->boundary}};
  for (size_t k = 0; k < sizeof integers / sizeof *integers; k++)
    hc_h5_get(own, integers[k].name, H5T_NATIVE_INT64, integers[k].count, integers[k].values, problem);
  if (H5Aexists(own, "moving_particles") > 0) /* checkpoints */
    hc_h5_get(own, "moving_particles", H5T_NATIVE_INT64, 1, &facts->moving, problem);
  if (problem->status != HC_OK) return;
  for (int axis = 0; axis < 3; axis++)
    if (!(facts->unit[axis] > 0) || !isfinite(facts->unit[axis]))
      hc_error_set(problem, HC_BAD_INPUT, "unit must be positive, is %g", facts->unit[axis]);
  if (facts->fluid < 0 || facts->boundary < 0 || facts->fluid > INT64_MAX / 1024 ||
      facts->boundary > INT64_MAX / 1024 || facts->moving < 0 || facts->moving > facts->boundary)
    hc_error_set(problem, HC_BAD_INPUT, "particle counts must not be negative or absurd, are %lld and %lld",
                 (long long)facts->fluid, (long long)facts->boundary);
  facts->particles = facts->fluid + facts->boundary;
}

typedef struct listing {
  hc_snapshot_file *file;
  hid_t own;
  hc_error *problem;
} listing;

static herr_t list_field(hid_t group, const char *name, const H5L_info_t *link, void *data) {
  (void)link;
  const listing *list = data;
  hc_snapshot_file *file = list->file;
  hc_error *problem = list->problem;
  if (problem->status != HC_OK || strcmp(name, "id") == 0) return 0;
  if (file->field_count == HC_SNAPSHOT_READ_FIELDS || strlen(name) >= HC_SNAPSHOT_READ_NAME) {
    hc_error_set(problem, HC_BAD_INPUT, "PointData may hold %d fields with names below %d bytes",
                 HC_SNAPSHOT_READ_FIELDS, HC_SNAPSHOT_READ_NAME);
    return 0;
  }
  hc_snapshot_field *field = &file->fields[file->field_count];
  memset(field, 0, sizeof *field);
  snprintf(field->name, sizeof field->name, "%s", name);
  int64_t rows = 0;
  const hid_t dataset = H5Dopen2(group, name, H5P_DEFAULT);
  if (!shape(dataset, &rows, &field->components) || !type_of(dataset, &field->type) ||
      rows != file->facts.particles)
    hc_h5_failed(problem, HC_BAD_INPUT, "PointData/%s must be %lld rows of uint8, int64, float32 or float64",
                 name, (long long)file->facts.particles);
  if (dataset >= 0) H5Dclose(dataset);
  field->bytes = (size_t)field->components * type_bytes(field->type);
  int64_t kinds = HC_FLUID | HC_BOUNDARY;
  snprintf(field->unit, sizeof field->unit, "1");
  if (H5Aexists_by_name(list->own, "units", name, H5P_DEFAULT) > 0) { /* `kind` has no row there */
    const hid_t units = H5Gopen2(list->own, "units", H5P_DEFAULT),
                all = H5Gopen2(list->own, "kinds", H5P_DEFAULT);
    hc_h5_get_text(units, name, field->unit, sizeof field->unit, problem);
    hc_h5_get(all, name, H5T_NATIVE_INT64, 1, &kinds, problem);
    if (units >= 0) H5Gclose(units);
    if (all >= 0) H5Gclose(all);
  }
  field->kinds = (unsigned)kinds;
  file->field_count++;
  return 0;
}

static void list_fields(hc_snapshot_file *file, hid_t own, hc_error *problem) {
  const hid_t data = H5Gopen2(file->handle, "VTKHDF/PointData", H5P_DEFAULT);
  listing list = {file, own, problem};
  if (data < 0 || H5Literate(data, H5_INDEX_NAME, H5_ITER_INC, NULL, list_field, &list) < 0)
    hc_h5_failed(problem, HC_BAD_INPUT, "cannot list VTKHDF/PointData");
  if (data >= 0) H5Gclose(data);
}

static void list_state(hc_snapshot_file *file) {
  static const hc_snapshot_type types[] = {[HC_TYPE_i64] = HC_SNAPSHOT_I64,
                                           [HC_TYPE_u64] = HC_SNAPSHOT_I64,
                                           [HC_TYPE_f64] = HC_SNAPSHOT_F64,
                                           [HC_TYPE_f32] = HC_SNAPSHOT_F32};
  for (int id = 0; id < HC_FIELD_COUNT; id++) {
    const hc_field_info *info = &hc_fields[id];
    if (!hc_field_is_state(info) || id == HC_FIELD_id || id == HC_FIELD_position) continue;
    bool there = false;
    for (int group = 0; group < GROUPS; group++) there |= has_column(file, group, info);
    if (!there) continue;
    hc_snapshot_field *field = &file->fields[file->field_count++];
    *field = (hc_snapshot_field){.type = types[info->type],
                                 .components = info->components,
                                 .bytes = info->bytes,
                                 .kinds = (info->flags & HC_FLUID) |
                                          (info->flags & (HC_BOUNDARY | HC_MOVED) ? HC_BOUNDARY : 0)};
    snprintf(field->name, sizeof field->name, "%s", info->name);
    snprintf(field->unit, sizeof field->unit, "%s", info->unit);
  }
}

static void count_pieces(hc_snapshot_file *file, hc_error *problem) {
  const hid_t dataset = H5Dopen2(file->handle, "Halocline/fluid_per_piece", H5P_DEFAULT);
  int components = 0;
  if (!shape(dataset, &file->facts.pieces, &components))
    hc_h5_failed(problem, HC_BAD_INPUT, "Halocline/fluid_per_piece is missing");
  if (dataset >= 0) H5Dclose(dataset);
  if (problem->status != HC_OK) return;
  int64_t *counts = NULL, fluid = 0, boundary = 0;
  if (hc_snapshot_read_pieces(file, &counts, problem) != HC_OK) return;
  for (int64_t piece = 0; piece < file->facts.pieces; piece++) {
    fluid += counts[2 * piece];
    boundary += counts[2 * piece + 1];
  }
  hc_free(counts);
  if (fluid != file->facts.fluid || boundary != file->facts.boundary)
    hc_error_set(problem, HC_BAD_INPUT,
                 "its pieces hold %lld + %lld particles, its attributes say %lld + %lld", (long long)fluid,
                 (long long)boundary, (long long)file->facts.fluid, (long long)file->facts.boundary);
}

/* Snapshots begin with HDF5's signature. A checkpoint whose seal is broken does not: HDF5 must not see it. */
static bool begins_as_hdf5(const char *path) {
  static const char signature[] = "\211HDF\r\n\032\n";
  char begin[sizeof signature - 1];
  FILE *stream = fopen(path, "rb");
  const bool same =
      stream && fread(begin, sizeof begin, 1, stream) == 1 && memcmp(begin, signature, sizeof begin) == 0;
  if (stream) fclose(stream);
  return same;
}

/* HDF5 locks what it has open for writing, as others may. */
static bool is_locked(const char *path) {
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  const bool locked = file >= 0 && flock(file, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  if (file >= 0) close(file);
  return locked;
}

hc_status hc_snapshot_read_open(const char *path, hc_snapshot_file *file, hc_error *error) {
  hc_error problem = {.status = HC_OK};
  hc_h5_silence();
  memset(file, 0, sizeof *file);
  snprintf(file->path, sizeof file->path, "%s", path);
  struct stat facts;
  if (access(path, R_OK) != 0 || stat(path, &facts) != 0)
    return broken(file, error, "cannot read it: %s", strerror(errno));
  if (S_ISDIR(facts.st_mode)) return broken(file, error, "a folder, not a snapshot");
  file->checkpoint = hc_seal_is_there(path);
  if (file->checkpoint && hc_seal_check(NULL, path, &problem) != HC_OK)
    return broken(file, error, "%s", problem.text);
  if (!file->checkpoint && !begins_as_hdf5(path)) return broken(file, error, "not an HDF5 file");
  file->handle = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file->handle < 0) {
    const bool in_use = is_locked(path);
    hc_h5_failed(&problem, HC_BAD_INPUT,
                 in_use ? "in use by another program, which has locked it"
                        : "a damaged or truncated HDF5 file");
    return broken(file, error, "%s", problem.text);
  }
  const hid_t own = H5Gopen2(file->handle, "Halocline", H5P_DEFAULT);
  if (own < 0)
    hc_h5_failed(&problem, HC_BAD_INPUT, "not a Halocline snapshot: it has no group /Halocline");
  else
    read_facts(file, own, &problem);
  if (problem.status == HC_OK && file->checkpoint) {
    list_state(file);
    hc_h5_get(own, "ranks", H5T_NATIVE_INT64, 1, &file->facts.pieces, &problem);
  } else {
    if (problem.status == HC_OK) list_fields(file, own, &problem);
    if (problem.status == HC_OK) count_pieces(file, &problem);
  }
  if (own >= 0) H5Gclose(own);
  if (problem.status == HC_OK) return HC_OK;
  hc_snapshot_read_close(file);
  return broken(file, error, "%s", problem.text);
}

void hc_snapshot_read_close(hc_snapshot_file *file) {
  if (file->handle > 0) H5Fclose(file->handle); /* read only: nothing can be lost */
  file->handle = 0;
}

/* ---- columns ---- */

hc_status hc_snapshot_read_ids(const hc_snapshot_file *file, uint64_t **ids, hc_error *error) {
  void *values = NULL;
  if (file->checkpoint) {
    const hc_status read = read_groups(file, HC_FIELD_id, &values, error);
    *ids = values;
    return read;
  }
  const hc_status status = read_column(file, "VTKHDF/PointData/id", H5T_NATIVE_INT64, sizeof(int64_t),
                                       file->facts.particles, 1, &values, error);
  *ids = values;
  return status;
}

/* A checkpoint's positions, from the scene's origin. */
static hc_status read_units(const hc_snapshot_file *file, int64_t **positions, hc_error *error) {
  void *values = NULL;
  const hc_status status = read_groups(file, HC_FIELD_position, &values, error);
  *positions = values;
  for (size_t k = 0; status == HC_OK && k < 3 * (size_t)file->facts.particles; k++)
    (*positions)[k] = (int64_t)((uint64_t)(*positions)[k] - (uint64_t)file->facts.origin[k % 3]);
  return status;
}

hc_status hc_snapshot_read_points(const hc_snapshot_file *file, double **points, hc_error *error) {
  void *values = NULL;
  if (file->checkpoint) {
    int64_t *units = NULL;
    const hc_status read = read_units(file, &units, error);
    const size_t count = 3 * (size_t)file->facts.particles;
    *points = read == HC_OK ? hc_alloc(count, sizeof **points) : NULL;
    for (size_t k = 0; read == HC_OK && k < count; k++)
      (*points)[k] = (double)units[k] * file->facts.unit[k % 3];
    hc_free(units);
    return read;
  }
  const hc_status status = read_column(file, "VTKHDF/Points", H5T_NATIVE_DOUBLE, sizeof(double),
                                       file->facts.particles, 3, &values, error);
  *points = values;
  return status;
}

hc_status hc_snapshot_read_positions(const hc_snapshot_file *file, int64_t **positions, hc_error *error) {
  if (file->checkpoint) return read_units(file, positions, error);
  *positions = NULL;
  double *points = NULL;
  const hc_status status = hc_snapshot_read_points(file, &points, error);
  if (status != HC_OK) return status;
  const size_t count = 3 * (size_t)file->facts.particles;
  int64_t *units = hc_alloc(count, sizeof *units);
  bool finite = true;
  for (size_t k = 0; k < count; k++) {
    const double value = points[k] / file->facts.unit[k % 3];
    finite &= fabs(value) < 0x1p62;
    units[k] = fabs(value) < 0x1p62 ? llrint(value) : 0;
  }
  hc_free(points);
  *positions = units;
  if (finite) return HC_OK;
  hc_free(units);
  *positions = NULL;
  return broken(file, error, "a position is not a number or beyond 2^62 units");
}

hc_status hc_snapshot_read_field(const hc_snapshot_file *file, const hc_snapshot_field *field, void **values,
                                 hc_error *error) {
  if (file->checkpoint) {
    int id = 0;
    while (id < HC_FIELD_COUNT - 1 && strcmp(hc_fields[id].name, field->name) != 0) id++;
    return read_groups(file, (hc_field_id)id, values, error);
  }
  char name[HC_SNAPSHOT_READ_NAME + 32];
  snprintf(name, sizeof name, "VTKHDF/PointData/%s", field->name);
  return read_column(file, name, memory_type(field->type), type_bytes(field->type), file->facts.particles,
                     field->components, values, error);
}

double hc_snapshot_read_value(const void *values, hc_snapshot_type type, int64_t k) {
  switch (type) {
  case HC_SNAPSHOT_U8:
    return ((const uint8_t *)values)[k];
  case HC_SNAPSHOT_I64:
    return (double)((const int64_t *)values)[k];
  case HC_SNAPSHOT_F32:
    return ((const float *)values)[k];
  case HC_SNAPSHOT_F64:
    break;
  }
  return ((const double *)values)[k];
}

const hc_snapshot_field *hc_snapshot_read_find(const hc_snapshot_file *file, const char *name) {
  for (int k = 0; k < file->field_count; k++)
    if (strcmp(file->fields[k].name, name) == 0) return &file->fields[k];
  return NULL;
}

hc_status hc_snapshot_read_pieces(const hc_snapshot_file *file, int64_t **counts, hc_error *error) {
  const int64_t pieces = file->facts.pieces;
  void *fluid = NULL, *all = NULL;
  *counts = NULL;
  if (file->checkpoint) return HC_OK; /* its rows are not cut into pieces */
  hc_status status =
      read_column(file, "Halocline/fluid_per_piece", H5T_NATIVE_INT64, 8, pieces, 1, &fluid, error);
  if (status == HC_OK)
    status = read_column(file, "VTKHDF/NumberOfPoints", H5T_NATIVE_INT64, 8, pieces, 1, &all, error);
  if (status == HC_OK) {
    *counts = hc_alloc(2 * (size_t)pieces, sizeof **counts);
    for (int64_t piece = 0; piece < pieces; piece++) {
      (*counts)[2 * piece] = ((const int64_t *)fluid)[piece];
      (*counts)[2 * piece + 1] = ((const int64_t *)all)[piece] - ((const int64_t *)fluid)[piece];
    }
  }
  hc_free(fluid);
  hc_free(all);
  return status;
}
