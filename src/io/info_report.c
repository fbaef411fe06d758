#include "info_report.h"

#include "json.h"
#include "particles/particles.h"
#include "text.h"

#include <inttypes.h>
#include <math.h>

static const char *const kind_names[HC_INFO_KINDS] = {"fluid", "boundary"};
static const unsigned kind_flags[HC_INFO_KINDS] = {HC_FLUID, HC_BOUNDARY};
static const char *const type_names[] = {"uint8", "int64", "float32", "float64"};

static void put_totals(const hc_info_report *report, FILE *out) {
  const double *p = report->momentum;
  char text[HC_TEXT_NUMBER];
  if (isnan(report->mass)) return;
  fprintf(out, "mass              %s kg (%.6g kg a particle)\n", hc_text_number(text, report->mass),
          report->file.facts.particle_mass);
  if (!isnan(report->kinetic_energy)) {
    fprintf(out, "momentum          (%.6g, %.6g, %.6g) kg m/s\n", p[0], p[1], p[2]);
    fprintf(out, "kinetic energy    %s J\n", hc_text_number(text, report->kinetic_energy));
  }
  fprintf(out, "potential energy  %s J\n", hc_text_number(text, report->potential_energy));
}

static void put_facts(const hc_info_report *report, FILE *out) {
  const hc_snapshot_facts *facts = &report->file.facts;
  char a[HC_TEXT_NUMBER], b[HC_TEXT_NUMBER];
  fprintf(out, "%s: a Halocline %s (format %" PRId64 ", written by version %s)\n", report->file.path,
          report->file.checkpoint ? "checkpoint" : "snapshot", facts->format_version, facts->program_version);
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
  put_totals(report, out);
  if (report->file.checkpoint)
    fprintf(out, "written by        %" PRId64 " ranks\n", facts->pieces);
  else
    fprintf(out, "pieces            %" PRId64 " (one per rank), %" PRId64 " to %" PRId64 " particles each\n",
            facts->pieces, report->piece_min, report->piece_max);
  for (int kind = 0; kind < HC_INFO_KINDS; kind++) {
    const double *low = report->extent[kind].low, *high = report->extent[kind].high;
    if (report->extent[kind].count == 0) continue;
    fprintf(out, "%-8s extent   (%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g) m\n", kind_names[kind], low[0],
            low[1], low[2], high[0], high[1], high[2]);
  }
}

static void put_field(const hc_snapshot_field *field, const hc_info_range *range, FILE *out) {
  char shape[32], text[3][HC_TEXT_NUMBER];
  snprintf(shape, sizeof shape, field->components > 1 ? "%s x %d" : "%s", type_names[field->type],
           field->components);
  fprintf(out, "  %-22s %-12s %-8s ", field->name, shape, field->unit);
  if (range->min <= range->max)
    fprintf(out, "%s%s to %s, mean %s", field->components > 1 ? "magnitude " : "",
            hc_text_number(text[0], range->min), hc_text_number(text[1], range->max),
            hc_text_number(text[2], range->mean));
  else
    fprintf(out, "no values");
  if (range->not_numbers) fprintf(out, ", %" PRId64 " not a number", range->not_numbers);
  fprintf(out, "\n");
}

void hc_info_report_text(const hc_info_report *report, FILE *out) {
  put_facts(report, out);
  fprintf(out, "fields\n");
  for (int k = 0; k < report->file.field_count; k++)
    put_field(&report->file.fields[k], &report->fields[k], out);
}

/* ---- JSON ---- */

static void put_json_facts(const hc_info_report *report, hc_json *json) {
  const hc_snapshot_facts *facts = &report->file.facts;
  hc_json_string(json, "file", report->file.path);
  hc_json_string(json, "content", report->file.checkpoint ? "checkpoint" : "snapshot");
  hc_json_integer(json, "format", facts->format_version);
  hc_json_string(json, "version", facts->program_version);
  hc_json_string(json, "scene", facts->scene);
  hc_json_integer(json, "step", facts->step);
  hc_json_integer(json, "pieces", facts->pieces);
  hc_json_integer(json, "particles", facts->particles);
  hc_json_integer(json, "fluid", facts->fluid);
  hc_json_integer(json, "boundary", facts->boundary);
  hc_json_number(json, "time", facts->time);
  hc_json_number(json, "dt", facts->dt);
  hc_json_number(json, "particle_spacing", facts->particle_spacing);
  hc_json_number(json, "support_radius", facts->support_radius);
  hc_json_number(json, "rest_density", facts->rest_density);
  hc_json_number(json, "particle_mass", facts->particle_mass);
  hc_json_number(json, "mass", report->mass);
  hc_json_number(json, "kinetic_energy", report->kinetic_energy);
  hc_json_number(json, "potential_energy", report->potential_energy);
  hc_json_numbers(json, "gravity", 3, facts->gravity);
  hc_json_numbers(json, "momentum", 3, report->momentum);
}

static void put_json_field(const hc_snapshot_field *field, const hc_info_range *range, hc_json *json) {
  const bool any = range->min <= range->max;
  hc_json_object(json, NULL, HC_JSON_DENSE);
  hc_json_string(json, "name", field->name);
  hc_json_string(json, "type", type_names[field->type]);
  hc_json_integer(json, "components", field->components);
  hc_json_string(json, "unit", field->unit);
  hc_json_list(json, "kinds", HC_JSON_DENSE);
  for (int kind = 0; kind < HC_INFO_KINDS; kind++)
    if (field->kinds & kind_flags[kind]) hc_json_string(json, NULL, kind_names[kind]);
  hc_json_end(json);
  hc_json_number(json, "min", any ? range->min : NAN);
  hc_json_number(json, "mean", range->mean);
  hc_json_number(json, "max", any ? range->max : NAN);
  hc_json_integer(json, "not_numbers", range->not_numbers);
  hc_json_end(json);
}

void hc_info_report_json(const hc_info_report *report, FILE *out) {
  hc_json json;
  hc_json_begin(&json, out, false);
  hc_json_object(&json, NULL, HC_JSON_DENSE);
  put_json_facts(report, &json);
  hc_json_object(&json, "extents", HC_JSON_DENSE);
  for (int kind = 0; kind < HC_INFO_KINDS; kind++)
    hc_json_extent(&json, kind_names[kind], report->extent[kind].count > 0, report->extent[kind].low,
                   report->extent[kind].high);
  hc_json_end(&json);
  hc_json_list(&json, "fields", HC_JSON_DENSE);
  for (int k = 0; k < report->file.field_count; k++)
    put_json_field(&report->file.fields[k], &report->fields[k], &json);
  hc_json_end(&json);
  hc_json_end(&json);
}
