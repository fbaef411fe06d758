#include "fill.h"

#include "base/check.h"
#include "base/memory.h"
#include "convert.h"

#include <string.h>

/* Defaults are YAML text and go the way of all values: a row that contradicts itself aborts. */
void hc_fill_default(const hc_param *param, void *owner) {
  memset((char *)owner + param->offset, 0, param->size);
  if (!param->fallback) return;
  const hc_source source = {.name = param->path, .text = param->fallback, .length = strlen(param->fallback)};
  hc_complaints *complaints = hc_alloc_zero(1, sizeof *complaints);
  hc_yaml *yaml = hc_yaml_parse(&source, complaints);
  HC_CHECK(yaml && yaml->root, "the default of %s is not YAML: %s", param->path, param->fallback);
  const hc_conversion conversion = {.param = param,
                                    .prefix = "",
                                    .node = yaml->root,
                                    .place = {&source, 1, 1},
                                    .owner = owner,
                                    .complaints = complaints};
  const bool good = param->kind == HC_PARAM_LIST ? yaml->root->count == 0 : hc_convert(&conversion);
  HC_CHECK(good && complaints->total == 0, "the default of %s is not valid: %s", param->path,
           param->fallback);
  hc_yaml_free(yaml);
  hc_free(complaints);
}

static void fill_list(hc_given_value *value, const hc_param *param, void *owner,
                      const hc_scene_limits *limits, hc_complaints *complaints) {
  const size_t size = param->items->size;
  char *items = hc_alloc_zero((size_t)value->item_count, size);
  *(void **)((char *)owner + param->offset) = items;
  *(int *)((char *)owner + param->count_offset) = value->item_count;
  for (int k = 0; k < value->item_count; k++)
    hc_fill(&value->items[k], items + (size_t)k * size, limits, complaints);
}

/* True if a key of the map called `name` is given. */
static bool has_map(const hc_given *given, const char *name) {
  const size_t length = strlen(name);
  for (int k = 0; k < given->table->count; k++) {
    const char *path = given->table->params[k].path;
    const bool present = given->values[k].node || given->values[k].bad;
    if (present && strncmp(path, name, length) == 0 && path[length] == '.') return true;
  }
  return false;
}

/* The names of the alternatives in a mask: "a, b, c". */
static void variants_text(const hc_param_table *table, unsigned mask, char *text, size_t size) {
  size_t used = 0;
  text[0] = '\0';
  for (int k = 0; table->variants[k] && used < size; k++)
    if (mask >> k & 1)
      used += (size_t)snprintf(text + used, size - used, "%s%s", used ? ", " : "", table->variants[k]);
}

/* The only alternative that is given, or -1 after a complaint. */
static int find_variant(const hc_given *given, hc_complaints *complaints) {
  const hc_param_table *table = given->table;
  char names[128], present[128] = "";
  int found = -1, count = 0;
  for (int k = 0; table->variants[k]; k++) {
    const char *name = table->variants[k];
    if (!has_map(given, name)) continue;
    snprintf(present + strlen(present), sizeof present - strlen(present), "%s%s", count ? " and " : "", name);
    found = k;
    count++;
  }
  if (count == 1) return found;
  variants_text(table, ~0u, names, sizeof names);
  const int label = (int)strlen(given->prefix) - 1; /* without its dot */
  hc_complaints_add(complaints, given->place, "%.*s must have exactly one of %s; it has %s", label,
                    given->prefix, names, count ? present : "none");
  return -1;
}

void hc_fill(hc_given *given, void *owner, const hc_scene_limits *limits, hc_complaints *complaints) {
  if (given->bad) return;
  const hc_param_table *table = given->table;
  int variant = -1;
  if (table->variants && !table->chosen_by_type) {
    variant = find_variant(given, complaints);
    *(int *)((char *)owner + table->variant_offset) = variant < 0 ? 0 : variant;
  }
  for (int k = 0; k < table->count; k++) {
    const hc_param *param = &table->params[k];
    hc_given_value *value = &given->values[k];
    const bool applies = hc_params_applies(param, variant);
    if (value->node && !applies && variant >= 0) {
      char owners[128];
      variants_text(table, param->only, owners, sizeof owners);
      hc_complaints_add(complaints, value->place, "%s%s is a key of %s, not of %s", given->prefix,
                        param->path, owners, table->variants[variant]);
    } else if (value->node && param->kind == HC_PARAM_LIST) {
      fill_list(value, param, owner, limits, complaints);
    } else if (value->node) {
      const hc_conversion conversion = {.param = param,
                                        .prefix = given->prefix,
                                        .node = value->node,
                                        .place = value->place,
                                        .limits = limits,
                                        .owner = owner,
                                        .complaints = complaints};
      value->bad = !hc_convert(&conversion);
    } else if (applies && !value->bad && hc_params_required(param)) {
      value->bad = true;
      hc_complaints_add(complaints, given->place, "missing required key '%s%s'", given->prefix, param->path);
    } else if (variant >= 0 && (param->needed >> variant & 1)) {
      value->bad = true;
      hc_complaints_add(complaints, given->place, "missing key '%s%s', required for %s", given->prefix,
                        param->path, table->variants[variant]);
    } else if (applies) {
      hc_fill_default(param, owner);
    }
    if (table->chosen_by_type && k == 0 && !value->bad)
      variant = *(const int *)((const char *)owner + table->variant_offset);
  }
}
