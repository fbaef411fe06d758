#include "info.h"

#include "base/exact_sum.h"
#include "base/memory.h"
#include "info_report.h"
#include "particles/ids.h"
#include "particles/particles.h"
#include "rest_file.h"

#include <math.h>
#include <string.h>

/* Carries of an exact sum may wait for this many terms. */
enum { CARRY_EVERY = 1 << 24 };

static void add(hc_sum *sum, int64_t term, double value) {
  hc_sum_add(sum, value);
  if (term % CARRY_EVERY == CARRY_EVERY - 1) hc_sum_carry(sum);
}

static double value_of(hc_sum *sum) {
  hc_sum_carry(sum);
  return hc_sum_value(sum);
}

static unsigned flag_of(uint64_t id) {
  return hc_id_kind_of(id) == HC_ID_FLUID ? HC_FLUID : HC_BOUNDARY;
}

static void count_pieces(hc_info_report *report, const int64_t *pieces) {
  const int64_t count = pieces ? report->file.facts.pieces : 0;
  report->piece_min = count ? INT64_MAX : 0;
  for (int64_t piece = 0; piece < count; piece++) {
    const int64_t particles = pieces[2 * piece] + pieces[2 * piece + 1];
    if (particles < report->piece_min) report->piece_min = particles;
    if (particles > report->piece_max) report->piece_max = particles;
  }
}

/* Extents, and what gravity makes of the positions. */
static hc_status look_at_points(hc_info_report *report, const uint64_t *ids, hc_error *error) {
  const hc_snapshot_facts *facts = &report->file.facts;
  double *points = NULL;
  const hc_status status = hc_snapshot_read_points(&report->file, &points, error);
  if (status != HC_OK) return status;
  hc_sum work;
  memset(&work, 0, sizeof work);
  for (int kind = 0; kind < HC_INFO_KINDS; kind++)
    for (int axis = 0; axis < 3; axis++) {
      report->extent[kind].low[axis] = INFINITY;
      report->extent[kind].high[axis] = -INFINITY;
    }
  for (int64_t k = 0; k < facts->particles; k++) {
    const int kind = flag_of(ids[k]) == HC_FLUID ? HC_INFO_FLUID : HC_INFO_BOUNDARY;
    double done = 0.0;
    report->extent[kind].count++;
    for (int axis = 0; axis < 3; axis++) {
      const double x = points[3 * k + axis];
      report->extent[kind].low[axis] = fmin(report->extent[kind].low[axis], x);
      report->extent[kind].high[axis] = fmax(report->extent[kind].high[axis], x);
      done += facts->gravity[axis] * x;
    }
    if (kind == HC_INFO_FLUID) add(&work, k, done);
  }
  hc_free(points);
  report->mass = facts->particle_mass * (double)facts->fluid;
  report->potential_energy = -facts->particle_mass * value_of(&work);
  return HC_OK;
}

static double magnitude(const void *values, const hc_snapshot_field *field, int64_t particle) {
  double sum = 0.0;
  for (int component = 0; component < field->components; component++) {
    const double value =
        hc_snapshot_read_value(values, field->type, particle * field->components + component);
    if (field->components == 1) return value;
    sum += value * value;
  }
  return sqrt(sum);
}

static hc_info_range range_of(const hc_snapshot_file *file, const hc_snapshot_field *field,
                              const uint64_t *ids, const void *values) {
  hc_info_range range = {.min = INFINITY, .max = -INFINITY};
  hc_sum sum;
  memset(&sum, 0, sizeof sum);
  int64_t count = 0;
  for (int64_t k = 0; k < file->facts.particles; k++) {
    if (!(field->kinds & flag_of(ids[k]))) continue;
    const double value = magnitude(values, field, k);
    range.not_numbers += isnan(value) != 0;
    range.min = fmin(range.min, value);
    range.max = fmax(range.max, value);
    add(&sum, count++, value);
  }
  range.mean = value_of(&sum) / (double)count;
  return range;
}

/* Momentum and kinetic energy, from velocities as they are written: three doubles. */
static void add_up_motion(hc_info_report *report, const uint64_t *ids, const double *velocity) {
  const double mass = report->file.facts.particle_mass;
  hc_sum sums[4]; /* v, v^2 */
  memset(sums, 0, sizeof sums);
  for (int64_t k = 0; k < report->file.facts.particles; k++) {
    if (flag_of(ids[k]) != HC_FLUID) continue;
    double v2 = 0.0;
    for (int axis = 0; axis < 3; axis++) {
      const double v = velocity[3 * k + axis];
      add(&sums[axis], k, v);
      v2 += v * v;
    }
    add(&sums[3], k, v2);
  }
  for (int axis = 0; axis < 3; axis++) report->momentum[axis] = mass * value_of(&sums[axis]);
  report->kinetic_energy = 0.5 * mass * value_of(&sums[3]);
}

static hc_status look_at_fields(hc_info_report *report, const uint64_t *ids, hc_error *error) {
  const hc_snapshot_file *file = &report->file;
  for (int k = 0; k < file->field_count; k++) {
    const hc_snapshot_field *field = &file->fields[k];
    void *values = NULL;
    const hc_status status = hc_snapshot_read_field(file, field, &values, error);
    if (status != HC_OK) return status;
    report->fields[k] = range_of(file, field, ids, values);
    if (strcmp(field->name, "velocity") == 0 && field->components == 3 && field->type == HC_SNAPSHOT_F64)
      add_up_motion(report, ids, values);
    hc_free(values);
  }
  return HC_OK;
}

static hc_status look(hc_info_report *report, hc_error *error) {
  uint64_t *ids = NULL;
  int64_t *pieces = NULL;
  report->kinetic_energy = report->momentum[0] = report->momentum[1] = report->momentum[2] = NAN;
  hc_status status = hc_snapshot_read_ids(&report->file, &ids, error);
  if (status == HC_OK) status = hc_snapshot_read_pieces(&report->file, &pieces, error);
  if (status == HC_OK) count_pieces(report, pieces);
  if (status == HC_OK) status = look_at_points(report, ids, error);
  if (status == HC_OK) status = look_at_fields(report, ids, error);
  hc_free(ids);
  hc_free(pieces);
  return status;
}

hc_status hc_info_print(const char *path, bool json, FILE *out, hc_error *error) {
  if (hc_rest_file_is(path)) return hc_rest_file_print(path, json, out, error);
  hc_info_report *report = hc_alloc_zero(1, sizeof *report);
  hc_status status = hc_snapshot_read_open(path, &report->file, error);
  if (status == HC_OK) {
    status = look(report, error);
    if (status == HC_OK) (json ? hc_info_report_json : hc_info_report_text)(report, out);
    hc_snapshot_read_close(&report->file);
  }
  hc_free(report);
  if (status == HC_OK && (fflush(out) != 0 || ferror(out)))
    status = hc_error_set(error, HC_IO_FAILED, "cannot write the description of %s", path);
  return status;
}
