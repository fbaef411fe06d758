#include "writer.h"

#include "base/check.h"
#include "params.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

enum { STEP = 2 };

static void write_text(FILE *out, const char *text) {
  fputc('"', out);
  for (const char *c = text; *c; c++) {
    if (*c == '"' || *c == '\\') fputc('\\', out);
    fputc(*c, out);
  }
  fputc('"', out);
}

static void write_number(FILE *out, const hc_param *param, double value) {
  char text[HC_PARAM_NUMBER_TEXT];
  hc_params_number_text(value, text);
  fputs(param->zero_word && value == 0.0 ? param->zero_word : text, out);
}

static void write_flags(FILE *out, const hc_param *param, unsigned bits) {
  const char *separator = "";
  fputc('[', out);
  for (const hc_choice *choice = param->choices; choice->name; choice++) {
    if (!(bits & (unsigned)choice->value)) continue;
    fprintf(out, "%s%s", separator, choice->name);
    separator = ", ";
  }
  fputc(']', out);
}

static void write_names(FILE *out, const char *names, int count) {
  fputc('[', out);
  for (int k = 0; k < count; k++) {
    if (k) fputs(", ", out);
    write_text(out, names + k * HC_PARAM_NAME_SIZE);
  }
  fputc(']', out);
}

static void write_pairs(FILE *out, const hc_param *param, const double (*pairs)[2], int count) {
  fputc('[', out);
  for (int k = 0; k < count; k++) {
    fputs(k ? ", [" : "[", out);
    write_number(out, param, pairs[k][0]);
    fputs(", ", out);
    write_number(out, param, pairs[k][1]);
    fputc(']', out);
  }
  fputc(']', out);
}

/* For a value on its line; not for lists of maps. */
void hc_scene_write_value(FILE *out, const hc_param *param, const void *owner) {
  const void *member = (const char *)owner + param->offset;
  const int length = hc_params_length(param);
  if (length > 1) fputc('[', out);
  for (int k = 0; k < length; k++) {
    if (k) fputs(", ", out);
    switch (param->kind) {
    case HC_PARAM_BOOL:
      fputs(((const bool *)member)[k] ? "true" : "false", out);
      break;
    case HC_PARAM_INT:
      fprintf(out, "%d", *(const int *)member);
      break;
    case HC_PARAM_INT64:
      fprintf(out, "%" PRId64, ((const int64_t *)member)[k]);
      break;
    case HC_PARAM_NUMBER:
      write_number(out, param, ((const double *)member)[k]);
      break;
    case HC_PARAM_TEXT:
      write_text(out, member);
      break;
    case HC_PARAM_CHOICE:
      fputs(hc_params_choice_name(param->choices, *(const int *)member), out);
      break;
    case HC_PARAM_FLAGS:
      write_flags(out, param, *(const unsigned *)member);
      break;
    case HC_PARAM_PAIRS:
      write_pairs(out, param, *(const double(*const *)[2])member,
                  *(const int *)((const char *)owner + param->count_offset));
      break;
    case HC_PARAM_NAMES:
      write_names(out, member, *(const int *)((const char *)owner + param->count_offset));
      break;
    case HC_PARAM_LIST:
      break;
    }
  }
  if (length > 1) fputc(']', out);
}

/* Keys that the scene's modes make use of. Zero stands for "not given" where it is outside the range and
 * there is no default; hidden keys are written only if they are given. */
bool hc_scene_writes(const hc_param_table *table, const hc_param *param, const void *owner) {
  const void *member = (const char *)owner + param->offset;
  if (!hc_params_used(table, param, owner)) return false;
  if (param->hidden) return *(const int *)member != 0;
  if (param->kind == HC_PARAM_TEXT) return *(const char *)member != '\0';
  if (param->kind == HC_PARAM_NUMBER && !param->fallback && hc_params_length(param) == 1)
    return *(const double *)member != 0.0 || hc_params_required(param);
  return true;
}

/* Opens the maps of `path` that `before` was not in; returns the indentation of its last word. */
static int write_maps(FILE *out, const char *path, const char *before, int indent, bool *dash) {
  const char *word = path;
  bool same = true;
  for (const char *dot = strchr(word, '.'); dot; dot = strchr(word, '.')) {
    const size_t length = (size_t)(dot + 1 - path);
    same = same && strncmp(path, before, length) == 0;
    if (!same) {
      fprintf(out, "%*s%.*s:\n", indent, *dash ? "- " : "", (int)(dot - word), word);
      *dash = false;
    }
    indent += STEP;
    word = dot + 1;
  }
  fprintf(out, "%*s%s:", indent, *dash ? "- " : "", word);
  *dash = false;
  return indent;
}

/* `dash`: the first line begins the item of a list. */
static void write_table(FILE *out, const hc_param_table *table, const void *owner, int indent, bool dash) {
  const int variant = table->variants ? *(const int *)((const char *)owner + table->variant_offset) : -1;
  const char *before = "";
  for (int k = 0; k < table->count; k++) {
    const hc_param *param = &table->params[k];
    if (!hc_params_applies(param, variant) || !hc_scene_writes(table, param, owner)) continue;
    const int inner = write_maps(out, param->path, before, indent, &dash);
    before = param->path;
    if (param->kind != HC_PARAM_LIST) {
      fputc(' ', out);
      hc_scene_write_value(out, param, owner);
      fputc('\n', out);
      continue;
    }
    const int count = *(const int *)((const char *)owner + param->count_offset);
    const char *items = *(const char *const *)((const char *)owner + param->offset);
    fputs(count ? "\n" : " []\n", out);
    for (int item = 0; item < count; item++)
      write_table(out, param->items, items + (size_t)item * param->items->size, inner + 2 * STEP, true);
  }
}

char *hc_scene_text(const hc_scene *scene) {
  char *text = NULL;
  size_t length = 0;
  FILE *stream = open_memstream(&text, &length);
  HC_CHECK(stream, "no memory for the scene's text");
  fputs("# The scene as understood, every default filled in.\n", stream);
  write_table(stream, &hc_params_scene, scene, 0, false);
  HC_CHECK(fclose(stream) == 0, "no memory for the scene's text");
  return text;
}
