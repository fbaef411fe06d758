#include "info.h"

#include "base/memory.h"
#include "particles/ids.h"
#include "particles/particles.h"
#include "snapshot_read.h"
#include "text.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct span {
  double min, max;
  int64_t not_numbers;
} span;

static const span nothing = {INFINITY, -INFINITY, 0};

static void widen(span *range, double value) {
  if (isnan(value)) range->not_numbers++;
  if (value < range->min) range->min = value;
  if (value > range->max) range->max = value;
}

static double magnitude(const void *values, const hc_snapshot_field *field, int64_t particle) {
  double sum = 0;
  for (int component = 0; component < field->components; component++) {
    const int64_t k = particle * field->components + component;
    double value = 0;
    switch (field->type) {
    case HC_SNAPSHOT_U8:
      value = ((const uint8_t *)values)[k];
      break;
    case HC_SNAPSHOT_I64:
      value = (double)((const int64_t *)values)[k];
      break;
    case HC_SNAPSHOT_F32:
      value = ((const float *)values)[k];
      break;
    case HC_SNAPSHOT_F64:
      value = ((const double *)values)[k];
      break;
    }
    if (field->components == 1) return value;
    sum += value * value;
  }
  return sqrt(sum);
}

static unsigned flag_of(uint64_t id) {
  return hc_id_kind_of(id) == HC_ID_FLUID ? HC_FLUID : HC_BOUNDARY;
}

static void print_facts(const hc_snapshot_file *file, const int64_t *pieces, FILE *out) {
  const hc_snapshot_facts *facts = &file->facts;
  char a[HC_TEXT_NUMBER], b[HC_TEXT_NUMBER];
  fprintf(out, "%s: a Halocline snapshot (format %" PRId64 ", written by version %s)\n", file->path,
          facts->format_version, facts->program_version);
  fprintf(out, "scene             %s\n", facts->scene);
  fprintf(out, "time              %s s\n", hc_text_number(a, facts->time));
  fprintf(out, "step              %" PRId64 " (dt %s s)\n", facts->step, hc_text_number(a, facts->dt));
  fprintf(out, "particles         %" PRId64 ": %" PRId64 " fluid, %" PRId64 " boundary\n", facts->particles,
          facts->fluid, facts->boundary);
  fprintf(out, "particle spacing  %s m (support radius %s m)\n", hc_text_number(a, facts->particle_spacing),
          hc_text_number(b, facts->support_radius));
  fprintf(out, "rest density      %s kg/m3\n", hc_text_number(a, facts->rest_density));
  fprintf(out, "gravity           (%.6g, %.6g, %.6g) m/s2\n", facts->gravity[0], facts->gravity[1],
          facts->gravity[2]);
  int64_t least = INT64_MAX, most = 0;
  for (int64_t piece = 0; piece < facts->pieces; piece++) {
    const int64_t count = pieces[2 * piece] + pieces[2 * piece + 1];
    if (count < least) least = count;
    if (count > most) most = count;
  }
  fprintf(out, "pieces            %" PRId64 " (one per rank), %" PRId64 " to %" PRId64 " particles each\n",
          facts->pieces, facts->pieces ? least : 0, most);
}

static hc_status print_extents(const hc_snapshot_file *file, const uint64_t *ids, FILE *out,
                               hc_error *error) {
  double *points = NULL;
  const hc_status status = hc_snapshot_read_points(file, &points, error);
  if (status != HC_OK) return status;
  static const struct {
    const char *name;
    unsigned kind;
  } kinds[2] = {{"fluid", HC_FLUID}, {"boundary", HC_BOUNDARY}};
  for (int kind = 0; kind < 2; kind++) {
    span range[3] = {nothing, nothing, nothing};
    int64_t count = 0;
    for (int64_t k = 0; k < file->facts.particles; k++) {
      if (flag_of(ids[k]) != kinds[kind].kind) continue;
      count++;
      for (int axis = 0; axis < 3; axis++) widen(&range[axis], points[3 * k + axis]);
    }
    if (count == 0) continue;
    fprintf(out, "%-8s extent   (%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g) m\n", kinds[kind].name, range[0].min,
            range[1].min, range[2].min, range[0].max, range[1].max, range[2].max);
  }
  hc_free(points);
  return HC_OK;
}

static hc_status print_field(const hc_snapshot_file *file, const hc_snapshot_field *field,
                             const uint64_t *ids, FILE *out, hc_error *error) {
  static const char *const types[] = {"uint8", "int64", "float32", "float64"};
  void *values = NULL;
  const hc_status status = hc_snapshot_read_field(file, field, &values, error);
  if (status != HC_OK) return status;
  span range = nothing;
  for (int64_t k = 0; k < file->facts.particles; k++)
    if (field->kinds & flag_of(ids[k])) widen(&range, magnitude(values, field, k));
  hc_free(values);
  char shape[32], text[2][HC_TEXT_NUMBER];
  snprintf(shape, sizeof shape, field->components > 1 ? "%s x %d" : "%s", types[field->type],
           field->components);
  fprintf(out, "  %-22s %-12s %-8s ", field->name, shape, field->unit);
  if (range.min <= range.max)
    fprintf(out, "%s%s to %s", field->components > 1 ? "magnitude " : "", hc_text_number(text[0], range.min),
            hc_text_number(text[1], range.max));
  else
    fprintf(out, "no values");
  if (range.not_numbers) fprintf(out, ", %" PRId64 " not a number", range.not_numbers);
  fprintf(out, "\n");
  return HC_OK;
}

hc_status hc_info_print(const char *path, FILE *out, hc_error *error) {
  hc_snapshot_file *file = hc_alloc_zero(1, sizeof *file);
  uint64_t *ids = NULL;
  int64_t *pieces = NULL;
  hc_status status = hc_snapshot_read_open(path, file, error);
  if (status != HC_OK) {
    hc_free(file);
    return status;
  }
  status = hc_snapshot_read_ids(file, &ids, error);
  if (status == HC_OK) status = hc_snapshot_read_pieces(file, &pieces, error);
  if (status == HC_OK) {
    print_facts(file, pieces, out);
    status = print_extents(file, ids, out, error);
  }
  if (status == HC_OK) fprintf(out, "fields\n");
  for (int k = 0; status == HC_OK && k < file->field_count; k++)
    status = print_field(file, &file->fields[k], ids, out, error);
  hc_snapshot_read_close(file);
  hc_free(ids);
  hc_free(pieces);
  hc_free(file);
  if (status == HC_OK && (fflush(out) != 0 || ferror(out)))
    status = hc_error_set(error, HC_IO_FAILED, "cannot write the description of %s", path);
  return status;
}
