#include "compare.h"

#include "base/check.h"
#include "base/memory.h"
#include "params.h"
#include "writer.h"

#include <stdio.h>
#include <string.h>

typedef struct comparison {
  FILE *harmless, *refused;
} comparison;

/* A key's value as YAML; "not there" where the scene has no use for the key. The caller's to free. */
static char *value_text(const hc_param_table *table, const hc_param *param, const void *owner) {
  char *text = NULL;
  size_t length = 0;
  FILE *stream = open_memstream(&text, &length);
  HC_CHECK(stream, "no memory for a value's text");
  if (hc_scene_writes(table, param, owner))
    hc_scene_write_value(stream, param, owner);
  else
    fputs("not there", stream);
  HC_CHECK(fclose(stream) == 0, "no memory for a value's text");
  return text;
}

static void note(const comparison *comparison, const hc_param *param, const char *path, const char *before,
                 const char *now) {
  if (strcmp(before, now) == 0) return;
  FILE *out = param->may_change ? comparison->harmless : comparison->refused;
  fprintf(out, "%s%s: was %s, is %s", ftell(out) > 0 ? "; " : "", path, before, now);
}

static void compare_tables(const comparison *comparison, const hc_param_table *table, const char *path,
                           const void *before, const void *now);

static void compare_lists(const comparison *comparison, const hc_param *param, const char *path,
                          const void *before, const void *now) {
  const int counts[2] = {*(const int *)((const char *)before + param->count_offset),
                         *(const int *)((const char *)now + param->count_offset)};
  const char *const items[2] = {*(const char *const *)((const char *)before + param->offset),
                                *(const char *const *)((const char *)now + param->offset)};
  char texts[2][32];
  for (int side = 0; side < 2; side++) snprintf(texts[side], sizeof texts[side], "%d items", counts[side]);
  note(comparison, param, path, texts[0], texts[1]);
  for (int k = 0; k < counts[0] && counts[0] == counts[1]; k++) {
    char below[2 * HC_PARAM_PATH + 16];
    snprintf(below, sizeof below, "%s[%d].", path, k);
    compare_tables(comparison, param->items, below, items[0] + (size_t)k * param->items->size,
                   items[1] + (size_t)k * param->items->size);
  }
}

static void compare_tables(const comparison *comparison, const hc_param_table *table, const char *path,
                           const void *before, const void *now) {
  int variants[2] = {-1, -1};
  if (table->variants) {
    variants[0] = *(const int *)((const char *)before + table->variant_offset);
    variants[1] = *(const int *)((const char *)now + table->variant_offset);
  }
  for (int k = 0; k < table->count; k++) {
    const hc_param *param = &table->params[k];
    const bool applies[2] = {hc_params_applies(param, variants[0]), hc_params_applies(param, variants[1])};
    if (!applies[0] && !applies[1]) continue;
    char name[2 * HC_PARAM_PATH];
    snprintf(name, sizeof name, "%s%s", path, param->path);
    if (param->kind == HC_PARAM_LIST) {
      compare_lists(comparison, param, name, before, now);
      continue;
    }
    char *old = applies[0] ? value_text(table, param, before) : strdup("not there");
    char *new = applies[1] ? value_text(table, param, now) : strdup("not there");
    HC_CHECK(old && new, "no memory for a value's text");
    note(comparison, param, name, old, new);
    hc_free(old);
    hc_free(new);
  }
}

hc_scene_changes hc_scene_compare(const hc_scene *before, const hc_scene *now) {
  hc_scene_changes changes = {NULL, NULL};
  size_t lengths[2];
  const comparison comparison = {open_memstream(&changes.harmless, &lengths[0]),
                                 open_memstream(&changes.refused, &lengths[1])};
  HC_CHECK(comparison.harmless && comparison.refused, "no memory to compare scenes");
  compare_tables(&comparison, &hc_params_scene, "", before, now);
  if ((before->time_step.control == HC_TIME_INDIVIDUAL) != (now->time_step.control == HC_TIME_INDIVIDUAL))
    fprintf(comparison.refused,
            "%stime_step.control: individual steps, which have wider cells, cannot %s in a run",
            ftell(comparison.refused) > 0 ? "; " : "",
            now->time_step.control == HC_TIME_INDIVIDUAL ? "begin" : "end");
  const bool closed = fclose(comparison.harmless) == 0;
  HC_CHECK(fclose(comparison.refused) == 0 && closed, "no memory to compare scenes");
  return changes;
}

void hc_scene_changes_free(hc_scene_changes *changes) {
  hc_free(changes->harmless);
  hc_free(changes->refused);
  memset(changes, 0, sizeof *changes);
}
