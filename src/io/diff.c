#include "diff.h"

#include "base/memory.h"
#include "diff_report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct entry {
  uint64_t id;
  int64_t index; /* in its file */
} entry;

/* The particles that both files hold. */
typedef struct pair {
  int64_t a, b;
} pair;

typedef struct comparison {
  hc_snapshot_file a, b;
  hc_diff_report report;
  pair *pairs;
  bool *differs;  /* per pair */
  uint64_t *ids;  /* per particle of A */
  double *points; /* of A, m */
  hc_error *error;
} comparison;

static int by_id(const void *left, const void *right) {
  const uint64_t a = ((const entry *)left)->id, b = ((const entry *)right)->id;
  return a < b ? -1 : a > b;
}

static hc_status sort_ids(const hc_snapshot_file *file, const uint64_t *ids, entry **sorted,
                          hc_error *error) {
  const int64_t count = file->facts.particles;
  *sorted = hc_alloc((size_t)count, sizeof **sorted);
  for (int64_t k = 0; k < count; k++) (*sorted)[k] = (entry){ids[k], k};
  qsort(*sorted, (size_t)count, sizeof **sorted, by_id);
  for (int64_t k = 1; k < count; k++)
    if ((*sorted)[k].id == (*sorted)[k - 1].id)
      return hc_error_set(error, HC_BAD_INPUT, "%s: ids must be unique, id %llu appears twice", file->path,
                          (unsigned long long)(*sorted)[k].id);
  return HC_OK;
}

static void note_missing(hc_diff_report *report, int side, uint64_t id) {
  if (report->missing[side] < HC_DIFF_LISTED) report->missing_ids[side][report->missing[side]] = id;
  report->missing[side]++;
}

static void merge(comparison *work, const entry *a, const entry *b) {
  hc_diff_report *report = &work->report;
  const int64_t end_a = work->a.facts.particles, end_b = work->b.facts.particles;
  work->pairs = hc_alloc((size_t)(end_a < end_b ? end_a : end_b), sizeof *work->pairs);
  int64_t i = 0, j = 0;
  while (i < end_a || j < end_b) {
    if (j == end_b || (i < end_a && a[i].id < b[j].id))
      note_missing(report, 0, a[i++].id);
    else if (i == end_a || b[j].id < a[i].id)
      note_missing(report, 1, b[j++].id);
    else
      work->pairs[report->common++] = (pair){a[i++].index, b[j++].index};
  }
  work->differs = hc_alloc_zero((size_t)report->common, sizeof *work->differs);
}

static hc_status match(comparison *work) {
  uint64_t *other = NULL;
  entry *a = NULL, *b = NULL;
  hc_status status = hc_snapshot_read_ids(&work->a, &work->ids, work->error);
  if (status == HC_OK) status = hc_snapshot_read_ids(&work->b, &other, work->error);
  if (status == HC_OK) status = sort_ids(&work->a, work->ids, &a, work->error);
  if (status == HC_OK) status = sort_ids(&work->b, other, &b, work->error);
  if (status == HC_OK) merge(work, a, b);
  hc_free(other);
  hc_free(a);
  hc_free(b);
  return status;
}

/* Remembers the largest difference; one that is not a number beats all others, the first of equals stays. */
static void note_worst(const comparison *work, hc_diff_field *field, int64_t k, double difference) {
  if (field->found && (isnan(field->worst) || difference <= field->worst)) return;
  const int64_t index = work->pairs[k].a;
  field->found = true;
  field->worst = difference;
  field->worst_id = work->ids[index];
  memcpy(field->worst_at, work->points + 3 * index, sizeof field->worst_at);
}

static void count_if(comparison *work, hc_diff_field *field, int64_t k, bool different) {
  field->differing += different;
  work->differs[k] |= different;
}

/* ---- positions ---- */

static int64_t wrapped(int64_t difference, int64_t period) {
  int64_t size = difference < 0 ? -difference : difference;
  if (period > 0) {
    size %= period;
    if (period - size < size) size = period - size;
  }
  return size;
}

static void compare_units(comparison *work, hc_diff_field *field, const int64_t *a, const int64_t *b) {
  const hc_snapshot_facts *facts = &work->a.facts;
  for (int64_t k = 0; k < work->report.common; k++) {
    const int64_t *p = a + 3 * work->pairs[k].a, *q = b + 3 * work->pairs[k].b;
    int64_t most = 0;
    double far = 0;
    bool moved = false;
    for (int axis = 0; axis < 3; axis++) {
      const int64_t size = wrapped(p[axis] - q[axis], facts->period[axis]);
      moved |= p[axis] != q[axis];
      if ((double)size * facts->unit[axis] <= far) continue;
      far = (double)size * facts->unit[axis];
      most = size;
    }
    if (!moved) continue;
    count_if(work, field, k, work->report.tolerance > 0 ? far > work->report.tolerance : true);
    if (!field->found || far > field->worst) field->worst_units = most;
    note_worst(work, field, k, far);
  }
}

static void compare_metres(comparison *work, hc_diff_field *field, const double *other) {
  for (int64_t k = 0; k < work->report.common; k++) {
    const double *p = work->points + 3 * work->pairs[k].a, *q = other + 3 * work->pairs[k].b;
    if (memcmp(p, q, 3 * sizeof *p) == 0) continue;
    double far = 0;
    for (int axis = 0; axis < 3; axis++) {
      const double size = fabs(p[axis] - q[axis]);
      if (!(size <= far)) far = size;
    }
    count_if(work, field, k, work->report.tolerance > 0 ? !(far <= work->report.tolerance) : true);
    note_worst(work, field, k, far);
  }
}

static hc_status compare_positions(comparison *work) {
  hc_diff_report *report = &work->report;
  hc_diff_field *field = &report->fields[report->field_count++];
  *field = (hc_diff_field){.name = "position", .unit = "m"};
  hc_status status = hc_snapshot_read_points(&work->a, &work->points, work->error);
  if (status != HC_OK) return status;
  if (report->same_unit) {
    int64_t *a = NULL, *b = NULL;
    status = hc_snapshot_read_positions(&work->a, &a, work->error);
    if (status == HC_OK) status = hc_snapshot_read_positions(&work->b, &b, work->error);
    if (status == HC_OK) compare_units(work, field, a, b);
    hc_free(a);
    hc_free(b);
  } else {
    double *b = NULL;
    status = hc_snapshot_read_points(&work->b, &b, work->error);
    if (status == HC_OK) compare_metres(work, field, b);
    hc_free(b);
  }
  return status;
}

/* ---- fields ---- */

static void compare_values(comparison *work, hc_diff_field *field, const hc_snapshot_field *shape,
                           const void *a, const void *b) {
  const double tolerance = work->report.tolerance;
  for (int64_t k = 0; k < work->report.common; k++) {
    const pair at = work->pairs[k];
    if (memcmp((const char *)a + (size_t)at.a * shape->bytes, (const char *)b + (size_t)at.b * shape->bytes,
               shape->bytes) == 0)
      continue;
    double most = 0;
    for (int component = 0; component < shape->components; component++) {
      const double x = hc_snapshot_read_value(a, shape->type, at.a * shape->components + component);
      const double y = hc_snapshot_read_value(b, shape->type, at.b * shape->components + component);
      const double size = x == y ? 0 : fabs(x - y); /* equal infinities too */
      if (!(size <= most)) most = size;
    }
    count_if(work, field, k, tolerance > 0 ? !(most <= tolerance) : true);
    note_worst(work, field, k, most);
  }
}

static hc_status compare_field(comparison *work, const hc_snapshot_field *a, const hc_snapshot_field *b) {
  hc_diff_report *report = &work->report;
  hc_diff_field *field = &report->fields[report->field_count++];
  *field = (hc_diff_field){.name = a ? a->name : b->name, .unit = a ? a->unit : b->unit};
  if (!a || !b)
    field->trouble = a ? "only in A" : "only in B";
  else if (a->type != b->type || a->components != b->components)
    field->trouble = "stored as different types";
  if (field->trouble) return HC_OK;
  void *left = NULL, *right = NULL;
  hc_status status = hc_snapshot_read_field(&work->a, a, &left, work->error);
  if (status == HC_OK) status = hc_snapshot_read_field(&work->b, b, &right, work->error);
  if (status == HC_OK) compare_values(work, field, a, left, right);
  hc_free(left);
  hc_free(right);
  return status;
}

/* ---- the files as a whole ---- */

/* What both files say of the scene behind them. */
static void compare_settings(comparison *work) {
  hc_diff_report *report = &work->report;
  const hc_snapshot_facts *a = &work->a.facts, *b = &work->b.facts;
  double period[2][3];
  for (int axis = 0; axis < 3; axis++) {
    period[0][axis] = (double)a->period[axis] * a->unit[axis];
    period[1][axis] = (double)b->period[axis] * b->unit[axis];
  }
  const struct {
    const char *name, *unit;
    int count;
    const double *a, *b;
  } settings[HC_DIFF_SETTINGS] = {{"particle_spacing", "m", 1, &a->particle_spacing, &b->particle_spacing},
                                  {"support_radius", "m", 1, &a->support_radius, &b->support_radius},
                                  {"period", "m", 3, period[0], period[1]},
                                  {"rest_density", "kg/m3", 1, &a->rest_density, &b->rest_density},
                                  {"particle_mass", "kg", 1, &a->particle_mass, &b->particle_mass},
                                  {"gravity", "m/s2", 3, a->gravity, b->gravity}};
  for (int k = 0; k < HC_DIFF_SETTINGS; k++) {
    hc_diff_setting found = {.name = settings[k].name, .unit = settings[k].unit, .count = settings[k].count};
    bool different = false;
    for (int part = 0; part < found.count; part++) {
      found.a[part] = settings[k].a[part];
      found.b[part] = settings[k].b[part];
      different |= fabs(found.a[part] - found.b[part]) > report->tolerance; /* not known: no difference */
    }
    if (different) report->settings[report->setting_count++] = found;
  }
}

static hc_status compare_all(comparison *work) {
  hc_diff_report *report = &work->report;
  const hc_snapshot_facts *a = &work->a.facts, *b = &work->b.facts;
  report->same_step = a->step == b->step;
  report->same_scene = strcmp(a->scene, b->scene) == 0;
  report->same_time = a->time == b->time || fabs(a->time - b->time) <= report->tolerance;
  report->same_unit = memcmp(a->unit, b->unit, sizeof a->unit) == 0;
  compare_settings(work);
  hc_status status = match(work);
  if (status == HC_OK) status = compare_positions(work);
  for (int k = 0; status == HC_OK && k < work->a.field_count; k++)
    status = compare_field(work, &work->a.fields[k], hc_snapshot_read_find(&work->b, work->a.fields[k].name));
  for (int k = 0; status == HC_OK && k < work->b.field_count; k++)
    if (!hc_snapshot_read_find(&work->a, work->b.fields[k].name))
      status = compare_field(work, NULL, &work->b.fields[k]);
  if (status != HC_OK) return status;
  report->same = report->same_time && (report->same_step || report->tolerance > 0) &&
                 report->setting_count == 0 && report->missing[0] == 0 && report->missing[1] == 0;
  for (int k = 0; k < report->field_count; k++)
    report->same &= report->fields[k].differing == 0 && !report->fields[k].trouble;
  for (int64_t k = 0; k < report->common; k++) report->differing += work->differs[k];
  return HC_OK;
}

int hc_diff_run(const char *a, const char *b, const hc_diff_options *options, FILE *out, hc_error *error) {
  if (!(options->tolerance >= 0) || !isfinite(options->tolerance)) {
    hc_error_set(error, HC_BAD_INPUT, "the tolerance must be 0 or a positive number, is %g",
                 options->tolerance);
    return HC_DIFF_IMPOSSIBLE;
  }
  comparison *work = hc_alloc_zero(1, sizeof *work);
  work->error = error;
  work->report.tolerance = options->tolerance;
  work->report.a = &work->a;
  work->report.b = &work->b;
  int result = HC_DIFF_IMPOSSIBLE;
  if (hc_snapshot_read_open(a, &work->a, error) == HC_OK) {
    if (hc_snapshot_read_open(b, &work->b, error) == HC_OK) {
      if (compare_all(work) == HC_OK) {
        (options->json ? hc_diff_report_json : hc_diff_report_text)(&work->report, out);
        result = work->report.same ? HC_DIFF_SAME : HC_DIFF_DIFFERENT;
      }
      hc_snapshot_read_close(&work->b);
    }
    hc_snapshot_read_close(&work->a);
  }
  if (result != HC_DIFF_IMPOSSIBLE && fflush(out) != 0) {
    hc_error_set(error, HC_IO_FAILED, "cannot write the comparison");
    result = HC_DIFF_IMPOSSIBLE;
  }
  hc_free(work->pairs);
  hc_free(work->differs);
  hc_free(work->ids);
  hc_free(work->points);
  hc_free(work);
  return result;
}
