#include "reader.h"

#include "base/memory.h"
#include "base/text_file.h"
#include "complaints.h"
#include "fill.h"
#include "given.h"
#include "rules.h"
#include "yaml.h"

#include <string.h>

/* A snapshot given by mistake must not be read whole; a scene of a hundred thousand blocks fits. */
enum { LARGEST_FILE = 32 << 20 };

hc_status hc_scene_load(const char *path, char **text, size_t *length, hc_error *error) {
  return hc_file_load(path, LARGEST_FILE, "a scene file", text, length, error);
}

typedef struct override {
  char *path; /* up to the equals sign */
  hc_source name, value;
  hc_yaml *yaml;
} override;

/* Applies one override; what it allocates lives until free_override, for the nodes are referred to. */
static void apply_override(override *o, const char *text, int number, hc_given *given,
                           hc_complaints *complaints) {
  static const char option[] = "--set ";
  char *name = hc_alloc(sizeof option + strlen(text), 1);
  strcat(strcpy(name, option), text);
  const size_t key_length = strcspn(text, "=");
  o->path = hc_alloc(key_length + 1, 1);
  memcpy(o->path, text, key_length);
  o->path[key_length] = '\0';
  const char *value = text[key_length] ? text + key_length + 1 : "";
  o->value = (hc_source){name, value, strlen(value), number};
  const hc_place place = {&o->value, 0, 0};
  if (!text[key_length] || key_length == 0) {
    hc_complaints_add(complaints, place, "path.to.key=value is meant");
    return;
  }
  o->yaml = hc_yaml_parse(&o->value, complaints);
  if (!o->yaml) return;
  if (o->yaml->root)
    hc_given_override(given, o->path, o->yaml->root, &o->value, complaints);
  else
    hc_complaints_add(complaints, place, "%s has no value", o->path);
}

static void free_override(override *o) {
  hc_yaml_free(o->yaml);
  hc_free(o->path);
  hc_free((void *)o->value.name);
}

/* The scene's meaning, once its keys are in order. */
static void check_meaning(hc_scene *scene, const char *name, const hc_scene_limits *limits,
                          hc_findings *findings) {
  if (!limits || findings->errors->total > 0) return;
  if (limits->load) limits->load(limits->context, scene, name, findings);
  if (limits->check && findings->errors->total == 0) limits->check(scene, findings);
}

/* Scene, from a parsed file and the overrides. The complaints refer to `applied`. */
static void read_tree(hc_scene *scene, const hc_yaml *yaml, const hc_source *source,
                      const char *const *overrides, int override_count, override *applied,
                      const hc_scene_limits *limits, hc_complaints *complaints, hc_complaints *warnings) {
  const hc_yaml_node *root = yaml->root;
  if (!root || root->kind != HC_YAML_MAP || root->count == 0) {
    char seen[HC_YAML_SEEN] = "nothing";
    if (root) hc_yaml_seen(root, seen);
    hc_complaints_add(complaints, (hc_place){source, root ? root->line : 0, root ? root->column : 0},
                      "a scene must be a map of keys, not %s",
                      root && root->kind == HC_YAML_MAP ? "{}" : seen);
    return;
  }
  hc_given given = hc_given_start(&hc_params_scene, "", (hc_place){source, root->line, root->column});
  hc_given_take(&given, root, source, complaints);
  for (int k = 0; k < override_count; k++)
    apply_override(&applied[k], overrides[k], k + 1, &given, complaints);
  hc_fill(&given, scene, limits, complaints);
  hc_findings findings = {&given, complaints, warnings};
  if (limits && limits->complete) limits->complete(scene, &findings);
  hc_rules_apply(scene, &given, source->name, complaints);
  check_meaning(scene, source->name, limits, &findings);
  if (complaints->total == 0) hc_rules_drop_unused(scene, &given, warnings);
  hc_given_free(&given);
}

hc_status hc_scene_read_text(hc_scene *scene, const char *name, const char *text, size_t length,
                             const char *const *overrides, int override_count, const hc_scene_limits *limits,
                             hc_warnings *warnings, hc_error *error) {
  memset(scene, 0, sizeof *scene);
  hc_text_skip_mark(&text, &length);
  const hc_source source = {name, text, length, 0};
  hc_complaints *complaints = hc_alloc_zero(1, sizeof *complaints),
                *doubts = hc_alloc_zero(1, sizeof *doubts);
  hc_yaml *yaml = hc_yaml_parse(&source, complaints);
  override *applied = hc_alloc_zero((size_t)override_count, sizeof *applied);
  if (yaml) read_tree(scene, yaml, &source, overrides, override_count, applied, limits, complaints, doubts);
  hc_yaml_free(yaml);
  hc_status status = HC_OK;
  if (complaints->total > 0) {
    hc_scene_free(scene);
    status = HC_BAD_INPUT;
    if (error) {
      error->status = status;
      hc_complaints_text(complaints, error->text, sizeof error->text);
    }
  } else {
    hc_complaints_warn(doubts, warnings);
  }
  hc_free(doubts);
  hc_free(complaints);
  for (int k = 0; k < override_count; k++) free_override(&applied[k]);
  hc_free(applied);
  return status;
}

hc_status hc_scene_read(hc_scene *scene, const char *path, const char *const *overrides, int override_count,
                        const hc_scene_limits *limits, hc_warnings *warnings, hc_error *error) {
  memset(scene, 0, sizeof *scene);
  char *text = NULL;
  size_t length = 0;
  hc_status status = hc_scene_load(path, &text, &length, error);
  if (status != HC_OK) return status;
  status = hc_scene_read_text(scene, path, text, length, overrides, override_count, limits, warnings, error);
  hc_free(text);
  return status;
}
