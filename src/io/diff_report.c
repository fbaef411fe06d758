#include "diff_report.h"

#include "json.h"
#include "particles/ids.h"
#include "text.h"

#include <inttypes.h>
#include <stdio.h>

static void put_id(FILE *out, uint64_t id) {
  const int64_t source = hc_id_source_of(id);
  const uint64_t counter = id & ((uint64_t)HC_ID_MAX_COUNTER - 1);
  const char *kind = hc_id_kind_of(id) == HC_ID_FLUID      ? "fluid"
                     : hc_id_kind_of(id) == HC_ID_BOUNDARY ? "boundary"
                                                           : "unknown kind";
  fprintf(out, "id %" PRIu64 " (%s, source %" PRId64 ", number %" PRIu64 ")", id, kind, source, counter);
}

static void put_field(const hc_diff_report *report, const hc_diff_field *field, FILE *out) {
  char number[HC_TEXT_NUMBER];
  fprintf(out, "  %-22s ", field->name);
  if (field->trouble) {
    fprintf(out, "%s\n", field->trouble);
    return;
  }
  if (field->differing == 0 && !field->found) {
    fprintf(out, "identical\n");
    return;
  }
  fprintf(out, "%" PRId64 " of %" PRId64 " differ%s; worst %s %s", field->differing, report->common,
          report->tolerance > 0 ? " by more than the tolerance" : "", hc_text_number(number, field->worst),
          field->unit);
  if (field->worst_units > 0) fprintf(out, " = %" PRId64 " units", field->worst_units);
  fprintf(out, " at ");
  put_id(out, field->worst_id);
  fprintf(out, " near (%.6g, %.6g, %.6g) m\n", field->worst_at[0], field->worst_at[1], field->worst_at[2]);
}

static void put_missing(const hc_diff_report *report, int side, FILE *out) {
  const int64_t count = report->missing[side];
  if (count == 0) return;
  fprintf(out, "  only in %c: %" PRId64 " particles: ", "AB"[side], count);
  for (int k = 0; k < count && k < HC_DIFF_LISTED; k++) {
    if (k) fprintf(out, ", ");
    put_id(out, report->missing_ids[side][k]);
  }
  fprintf(out, "%s\n", count > HC_DIFF_LISTED ? ", ..." : "");
}

static void put_side(char name, const hc_snapshot_file *file, FILE *out) {
  char time[HC_TEXT_NUMBER];
  const hc_snapshot_facts *facts = &file->facts;
  fprintf(out, "%c: %s: scene %s, step %" PRId64 ", time %s s, %" PRId64 " particles in %" PRId64 " pieces\n",
          name, file->path, facts->scene, facts->step, hc_text_number(time, facts->time), facts->particles,
          facts->pieces);
}

static void put_setting(const hc_diff_setting *setting, FILE *out) {
  char text[HC_TEXT_NUMBER];
  fprintf(out, "  %s differs:", setting->name);
  for (int side = 0; side < 2; side++) {
    for (int part = 0; part < setting->count; part++)
      fprintf(out, "%s%s", part ? ", " : " ", hc_text_number(text, (side ? setting->b : setting->a)[part]));
    fprintf(out, " %s in %c%s", setting->unit, "AB"[side], side ? "\n" : ",");
  }
}

void hc_diff_report_text(const hc_diff_report *report, FILE *out) {
  char text[HC_TEXT_NUMBER];
  if (report->same && report->same_scene && report->tolerance == 0) {
    fprintf(out, "identical: %" PRId64 " particles\n", report->common);
    return;
  }
  put_side('A', report->a, out);
  put_side('B', report->b, out);
  if (!report->same_scene) fprintf(out, "  the scenes have different names\n");
  if (!report->same_step) fprintf(out, "  the steps differ\n");
  if (!report->same_time) fprintf(out, "  the times differ\n");
  if (!report->same_unit) fprintf(out, "  the units of length differ: positions compared in metres\n");
  for (int k = 0; k < report->setting_count; k++) put_setting(&report->settings[k], out);
  put_missing(report, 0, out);
  put_missing(report, 1, out);
  for (int k = 0; k < report->field_count; k++) put_field(report, &report->fields[k], out);
  if (report->same)
    fprintf(out, "the same within %s: %" PRId64 " particles\n", hc_text_number(text, report->tolerance),
            report->common);
  else
    fprintf(out, "different: %" PRId64 " of %" PRId64 " common particles\n", report->differing,
            report->common);
}

static void put_json_side(const char *name, const hc_snapshot_file *file, hc_json *json) {
  hc_json_object(json, name, HC_JSON_DENSE);
  hc_json_string(json, "file", file->path);
  hc_json_string(json, "scene", file->facts.scene);
  hc_json_integer(json, "step", file->facts.step);
  hc_json_number(json, "time", file->facts.time);
  hc_json_integer(json, "particles", file->facts.particles);
  hc_json_integer(json, "pieces", file->facts.pieces);
  hc_json_end(json);
}

static void put_json_field(const hc_diff_field *field, hc_json *json) {
  hc_json_object(json, NULL, HC_JSON_DENSE);
  hc_json_string(json, "name", field->name);
  hc_json_string(json, "unit", field->unit);
  if (field->trouble) hc_json_string(json, "trouble", field->trouble);
  hc_json_integer(json, "differing", field->differing);
  if (field->found) {
    hc_json_number(json, "worst", field->worst);
    if (field->worst_units > 0) hc_json_integer(json, "worst_units", field->worst_units);
    hc_json_id(json, "id", field->worst_id);
    hc_json_numbers(json, "at", 3, field->worst_at);
  }
  hc_json_end(json);
}

static void put_json_value(const char *name, int count, const double *values, hc_json *json) {
  if (count > 1)
    hc_json_numbers(json, name, count, values);
  else
    hc_json_number(json, name, *values);
}

static void put_json_settings(const hc_diff_report *report, hc_json *json) {
  hc_json_list(json, "settings", HC_JSON_DENSE);
  for (int k = 0; k < report->setting_count; k++) {
    const hc_diff_setting *setting = &report->settings[k];
    hc_json_object(json, NULL, HC_JSON_DENSE);
    hc_json_string(json, "name", setting->name);
    hc_json_string(json, "unit", setting->unit);
    put_json_value("a", setting->count, setting->a, json);
    put_json_value("b", setting->count, setting->b, json);
    hc_json_end(json);
  }
  hc_json_end(json);
}

static void put_json_missing(const hc_diff_report *report, int side, hc_json *json) {
  hc_json_object(json, side == 0 ? "only_in_a" : "only_in_b", HC_JSON_DENSE);
  hc_json_integer(json, "count", report->missing[side]);
  hc_json_list(json, "ids", HC_JSON_DENSE);
  for (int k = 0; k < report->missing[side] && k < HC_DIFF_LISTED; k++)
    hc_json_id(json, NULL, report->missing_ids[side][k]);
  hc_json_end(json);
  hc_json_end(json);
}

void hc_diff_report_json(const hc_diff_report *report, FILE *out) {
  hc_json json;
  hc_json_begin(&json, out, false);
  hc_json_object(&json, NULL, HC_JSON_DENSE);
  hc_json_bool(&json, "same", report->same);
  hc_json_number(&json, "tolerance", report->tolerance);
  put_json_side("a", report->a, &json);
  put_json_side("b", report->b, &json);
  hc_json_bool(&json, "same_scene", report->same_scene);
  hc_json_bool(&json, "same_step", report->same_step);
  hc_json_bool(&json, "same_time", report->same_time);
  hc_json_bool(&json, "same_unit", report->same_unit);
  hc_json_integer(&json, "common", report->common);
  hc_json_integer(&json, "differing", report->differing);
  put_json_settings(report, &json);
  for (int side = 0; side < 2; side++) put_json_missing(report, side, &json);
  hc_json_list(&json, "fields", HC_JSON_DENSE);
  for (int k = 0; k < report->field_count; k++) put_json_field(&report->fields[k], &json);
  hc_json_end(&json);
  hc_json_end(&json);
}
