#include "diff_report.h"

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

static void put_json_side(const char *name, const hc_snapshot_file *file, FILE *out) {
  char time[HC_TEXT_NUMBER];
  fprintf(out, "\"%s\":{\"file\":", name);
  hc_text_json_string(out, file->path);
  fprintf(out, ",\"scene\":");
  hc_text_json_string(out, file->facts.scene);
  fprintf(out, ",\"step\":%" PRId64 ",\"time\":%s,\"particles\":%" PRId64 ",\"pieces\":%" PRId64 "}",
          file->facts.step, hc_text_json_number(time, file->facts.time), file->facts.particles,
          file->facts.pieces);
}

static void put_json_field(const hc_diff_field *field, FILE *out) {
  fprintf(out, "{\"name\":");
  hc_text_json_string(out, field->name);
  fprintf(out, ",\"unit\":");
  hc_text_json_string(out, field->unit);
  if (field->trouble) {
    fprintf(out, ",\"trouble\":");
    hc_text_json_string(out, field->trouble);
  }
  fprintf(out, ",\"differing\":%" PRId64, field->differing);
  if (field->found) {
    hc_text_json_numbers(out, "worst", 0, &field->worst);
    if (field->worst_units > 0) fprintf(out, ",\"worst_units\":%" PRId64, field->worst_units);
    fprintf(out, ",\"id\":%" PRIu64, field->worst_id);
    hc_text_json_numbers(out, "at", 3, field->worst_at);
  }
  fprintf(out, "}");
}

void hc_diff_report_json(const hc_diff_report *report, FILE *out) {
  char number[HC_TEXT_NUMBER];
  fprintf(out, "{\"same\":%s,\"tolerance\":%s,", report->same ? "true" : "false",
          hc_text_json_number(number, report->tolerance));
  put_json_side("a", report->a, out);
  fprintf(out, ",");
  put_json_side("b", report->b, out);
  fprintf(out,
          ",\"same_scene\":%s,\"same_step\":%s,\"same_time\":%s,\"same_unit\":%s,\"common\":%" PRId64
          ",\"differing\":%" PRId64,
          report->same_scene ? "true" : "false", report->same_step ? "true" : "false",
          report->same_time ? "true" : "false", report->same_unit ? "true" : "false", report->common,
          report->differing);
  fprintf(out, ",\"settings\":[");
  for (int k = 0; k < report->setting_count; k++) {
    const hc_diff_setting *setting = &report->settings[k];
    fprintf(out, "%s{\"name\":\"%s\",\"unit\":\"%s\"", k ? "," : "", setting->name, setting->unit);
    hc_text_json_numbers(out, "a", setting->count > 1 ? setting->count : 0, setting->a);
    hc_text_json_numbers(out, "b", setting->count > 1 ? setting->count : 0, setting->b);
    fprintf(out, "}");
  }
  fprintf(out, "]");
  for (int side = 0; side < 2; side++) {
    fprintf(out, ",\"only_in_%c\":{\"count\":%" PRId64 ",\"ids\":[", "ab"[side], report -> missing[side]);
    for (int k = 0; k < report->missing[side] && k < HC_DIFF_LISTED; k++)
      fprintf(out, "%s%" PRIu64, k ? "," : "", report->missing_ids[side][k]);
    fprintf(out, "]}");
  }
  fprintf(out, ",\"fields\":[");
  for (int k = 0; k < report->field_count; k++) {
    if (k) fprintf(out, ",");
    put_json_field(&report->fields[k], out);
  }
  fprintf(out, "]}\n");
}
