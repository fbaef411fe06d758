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

/* The only alternative that is given, or -1 after a complaint. */
static int find_variant(const hc_given *given, hc_complaints *complaints) {
  const hc_param_table *table = given->table;
  char names[128] = "", present[128] = "";
  int found = -1, count = 0;
  for (int k = 0; table->variants[k]; k++) {
    const char *name = table->variants[k];
    snprintf(names + strlen(names), sizeof names - strlen(names), "%s%s", k ? ", " : "", name);
    if (!has_map(given, name)) continue;
    snprintf(present + strlen(present), sizeof present - strlen(present), "%s%s", count ? " and " : "", name);
    found = k;
    count++;
  }
  if (count == 1) return found;
  const int label = (int)strlen(given->prefix) - 1; /* without its dot */
  hc_complaints_add(complaints, given->place, "%.*s must have exactly one of %s; it has %s", label,
                    given->prefix, names, count ? present : "none");
  return -1;
}

/* Do items of this type have the key? Complains of keys that are given without, or not given but needed. */
static bool check_type(hc_given *given, int key, const void *owner, hc_complaints *complaints) {
  const hc_param_table *table = given->table;
  const hc_param *param = &table->params[key];
  hc_given_value *value = &given->values[key];
  if (!param->types || hc_given_value_of(given, "type")->bad) return true;
  const int type = *(const int *)((const char *)owner + table->type_offset);
  const char *name = "";
  for (const hc_choice *choice = table->types; choice->name; choice++)
    if (choice->value == type) name = choice->name;
  if (value->node && !(param->types >> type & 1)) {
    hc_complaints_add(complaints, value->place, "%s%s is no key of type %s", given->prefix, param->path,
                      name);
    value->bad = true;
  } else if (!value->node && !value->bad && (param->needed >> type & 1)) {
    hc_complaints_add(complaints, given->place, "missing key '%s%s', required for type %s", given->prefix,
                      param->path, name);
    value->bad = true;
  }
  return !value->bad;
}

void hc_fill(hc_given *given, void *owner, const hc_scene_limits *limits, hc_complaints *complaints) {
  if (given->bad) return;
  const hc_param_table *table = given->table;
  int variant = -1;
  if (table->variants) {
    variant = find_variant(given, complaints);
    *(int *)((char *)owner + table->variant_offset) = variant < 0 ? 0 : variant;
  }
  for (int k = 0; k < table->count; k++) {
    const hc_param *param = &table->params[k];
    hc_given_value *value = &given->values[k];
    if (!check_type(given, k, owner, complaints)) continue;
    const bool applies = param->variant == 0 || param->variant == 1 + variant;
    if (value->node && !applies && variant >= 0) {
      hc_complaints_add(complaints, value->place, "%s%s is a key of %s, not of %s", given->prefix,
                        param->path, table->variants[param->variant - 1], table->variants[variant]);
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
    } else if (applies) {
      hc_fill_default(param, owner);
    }
  }
}
