#include "given.h"

#include "base/check.h"
#include "base/memory.h"
#include "nearest.h"

#include <stdlib.h>
#include <string.h>

/* More sources of particles than ids can name, and more than any memory should be spent on. */
enum { MOST_ITEMS = 1 << 20 };

hc_given hc_given_start(const hc_param_table *table, const char *prefix, hc_place place) {
  hc_given given = {.table = table, .place = place};
  snprintf(given.prefix, sizeof given.prefix, "%s", prefix);
  given.values = hc_alloc_zero((size_t)table->count, sizeof *given.values);
  return given;
}

static void free_items(hc_given_value *value) {
  for (int k = 0; k < value->item_count; k++) hc_given_free(&value->items[k]);
  hc_free(value->items);
  value->items = NULL;
  value->item_count = 0;
}

void hc_given_free(hc_given *given) {
  for (int k = 0; given->values && k < given->table->count; k++) free_items(&given->values[k]);
  hc_free(given->values);
  given->values = NULL;
}

hc_given_value *hc_given_value_of(const hc_given *given, const char *path) {
  const hc_param *param = hc_params_find(given->table, path);
  HC_CHECK(param, "key '%s' is not in the parameter table", path);
  return &given->values[param - given->table->params];
}

bool hc_given_has(const hc_given *given, const char *path) {
  return hc_given_value_of(given, path)->node != NULL;
}

bool hc_given_is_bad(const hc_given *given, const char *path) {
  return hc_given_value_of(given, path)->bad;
}

hc_place hc_given_place_of(const hc_given *given, const char *path) {
  const hc_given_value *value = hc_given_value_of(given, path);
  return value->node ? value->place : given->place;
}

static hc_place place_of(const hc_source *source, const hc_yaml_node *node) {
  return (hc_place){source, node->line, node->column};
}

static void complain_of_unknown(const hc_given *given, const char *path, hc_place place,
                                hc_complaints *complaints) {
  char nearest[HC_PARAM_PATH];
  if (hc_nearest_key(given->table, path, nearest))
    hc_complaints_add(complaints, place, "unknown key '%s%s'; did you mean '%s%s'?", given->prefix, path,
                      given->prefix, nearest);
  else
    hc_complaints_add(complaints, place, "unknown key '%s%s'", given->prefix, path);
}

static void complain_of_kind(const char *prefix, const char *path, const char *wanted,
                             const hc_yaml_node *node, hc_place place, hc_complaints *complaints) {
  char seen[HC_YAML_SEEN];
  hc_yaml_seen(node, seen);
  hc_complaints_add(complaints, place, "%s%s must be %s, not %s", prefix, path, wanted, seen);
}

/* Sorts the items of a list of maps. */
static void take_items(const hc_given *given, hc_given_value *value, const hc_param *param,
                       const hc_source *source, hc_complaints *complaints) {
  const hc_yaml_node *list = value->node;
  free_items(value);
  if (list->kind != HC_YAML_LIST) {
    value->bad = true;
    complain_of_kind(given->prefix, param->path, "a list of maps", list, value->place, complaints);
    return;
  }
  if (list->count > MOST_ITEMS) {
    value->bad = true;
    hc_complaints_add(complaints, value->place, "%s%s must have at most %d items, not %d", given->prefix,
                      param->path, MOST_ITEMS, list->count);
    return;
  }
  value->items = hc_alloc_zero((size_t)list->count, sizeof *value->items);
  value->item_count = list->count;
  for (int k = 0; k < list->count; k++) {
    const hc_yaml_node *item = list->items[k];
    char prefix[HC_PARAM_PATH];
    snprintf(prefix, sizeof prefix, "%.100s%.60s[%d]", given->prefix, param->path, k);
    const hc_place place = place_of(source, item);
    if (item->kind != HC_YAML_MAP) {
      complain_of_kind(prefix, "", "a map", item, place, complaints);
      value->bad = true;
    }
    strcat(prefix, ".");
    value->items[k] = hc_given_start(param->items, prefix, place);
    value->items[k].bad = item->kind != HC_YAML_MAP;
    if (item->kind == HC_YAML_MAP) hc_given_take(&value->items[k], item, source, complaints);
  }
}

static void take_map(hc_given *given, const char *path, const hc_yaml_node *map, const hc_source *source,
                     hc_complaints *complaints);

/* Of a map that is none, no key is missing. */
static void mark_bad(const hc_given *given, const char *path) {
  const size_t length = strlen(path);
  for (int k = 0; k < given->table->count; k++) {
    const char *known = given->table->params[k].path;
    if (strncmp(known, path, length) == 0 && known[length] == '.') given->values[k].bad = true;
  }
}

static bool is_variant(const hc_param_table *table, const char *path) {
  for (int k = 0; table->variants && table->variants[k]; k++)
    if (strcmp(table->variants[k], path) == 0) return true;
  return false;
}

/* Takes the value of a key or map; `key_place` serves values that are not there. */
static void take_value(hc_given *given, const char *path, const hc_yaml_node *node, hc_place key_place,
                       const hc_source *source, hc_complaints *complaints) {
  const hc_param *param = hc_params_find(given->table, path);
  const hc_place place = hc_yaml_is_nothing(node) ? key_place : place_of(source, node);
  if (param) {
    hc_given_value *value = &given->values[param - given->table->params];
    value->node = node;
    value->place = place;
    value->bad = false;
    if (param->kind == HC_PARAM_LIST) take_items(given, value, param, source, complaints);
  } else if (!hc_params_is_map(given->table, path)) {
    complain_of_unknown(given, path, key_place, complaints);
  } else if (node->kind != HC_YAML_MAP) {
    complain_of_kind(given->prefix, path, "a map", node, place, complaints);
    mark_bad(given, path);
  } else if (node->count == 0 && is_variant(given->table, path)) {
    hc_complaints_add(complaints, place, "%s%s must have keys, not {}", given->prefix, path);
    mark_bad(given, path);
  } else {
    take_map(given, path, node, source, complaints);
  }
}

/* True if an earlier key of the map is the same; complains of it. */
static bool is_repeated(const hc_yaml_node *map, int index, const char *prefix, const char *path,
                        hc_place place, hc_complaints *complaints) {
  for (int k = 0; k < index; k++) {
    if (strcmp(map->keys[k]->text, map->keys[index]->text) != 0) continue;
    hc_complaints_add(complaints, place, "duplicate key '%s%s', first given on line %d", prefix, path,
                      map->keys[k]->line);
    return true;
  }
  return false;
}

static void take_map(hc_given *given, const char *path, const hc_yaml_node *map, const hc_source *source,
                     hc_complaints *complaints) {
  for (int k = 0; k < map->count; k++) {
    /* A file of mistakes: all that will be shown is there, and one more to tell that there are more. */
    if (complaints->total > HC_COMPLAINTS_MOST) return;
    const hc_yaml_node *key = map->keys[k];
    const hc_place place = place_of(source, key);
    char inner[HC_PARAM_PATH];
    snprintf(inner, sizeof inner, "%.90s%s%.90s", path, *path ? "." : "", key->text);
    if (strchr(key->text, '.'))
      hc_complaints_add(complaints, place, "unknown key '%.90s': write nested maps, not dots", key->text);
    else if (!is_repeated(map, k, given->prefix, inner, place, complaints))
      take_value(given, inner, map->items[k], place, source, complaints);
  }
}

void hc_given_take(hc_given *given, const hc_yaml_node *node, const hc_source *source,
                   hc_complaints *complaints) {
  take_map(given, "", node, source, complaints);
}

/* Splits "list[index]rest"; false if `path` has no index in its right form. */
static bool split_index(const char *path, char list[static HC_PARAM_PATH], long *index, const char **rest) {
  const char *bracket = strchr(path, '[');
  const size_t length = (size_t)(bracket - path);
  if (length >= HC_PARAM_PATH || bracket[1] < '0' || bracket[1] > '9') return false;
  memcpy(list, path, length);
  list[length] = '\0';
  char *end = NULL;
  *index = strtol(bracket + 1, &end, 10);
  if (*end != ']' || (end[1] != '\0' && (end[1] != '.' || end[2] == '\0'))) return false;
  *rest = end[1] ? end + 2 : "";
  return true;
}

void hc_given_override(hc_given *given, const char *path, const hc_yaml_node *node, const hc_source *source,
                       hc_complaints *complaints) {
  const hc_place place = {source, 0, 0};
  if (!strchr(path, '[')) {
    if (strlen(path) >= HC_PARAM_PATH / 2)
      hc_complaints_add(complaints, place, "unknown key");
    else if (*path)
      take_value(given, path, node, place, source, complaints);
    else if (node->kind == HC_YAML_MAP)
      hc_given_take(given, node, source, complaints);
    else
      complain_of_kind(given->prefix, "", "a map", node, place, complaints);
    return;
  }
  char list[HC_PARAM_PATH];
  const char *rest = NULL;
  long index = 0;
  if (!split_index(path, list, &index, &rest)) {
    hc_complaints_add(complaints, place, "'%.90s' is not a key: list[index].key is meant", path);
    return;
  }
  const hc_param *param = hc_params_find(given->table, list);
  if (!param && !hc_params_is_map(given->table, list)) {
    complain_of_unknown(given, list, place, complaints);
    return;
  }
  if (!param || param->kind != HC_PARAM_LIST) {
    hc_complaints_add(complaints, place, "%s%s is not a list of maps: give its whole value", given->prefix,
                      list);
    return;
  }
  const hc_given_value *value = &given->values[param - given->table->params];
  if (index >= value->item_count)
    hc_complaints_add(complaints, place, "%s%s has no item %ld: it has %d, counted from 0", given->prefix,
                      list, index, value->item_count);
  else
    hc_given_override(&value->items[index], rest, node, source, complaints);
}
