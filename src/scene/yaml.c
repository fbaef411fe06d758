#include "yaml.h"

#include "base/check.h"
#include "base/memory.h"

#include <libfyaml.h>
#include <stdio.h>
#include <string.h>

enum { DEEPEST = 32 };

typedef struct builder {
  struct fy_parser *parser;
  struct fy_diag *diag;
  const hc_source *source;
  hc_complaints *complaints;
  hc_yaml *yaml;
  int depth;
  hc_place last; /* for values that are not there */
} builder;

static void drop_message(struct fy_diag *diag, void *user, const char *text, size_t length) {
  (void)diag, (void)user, (void)text, (void)length;
}

static char *copy_text(const char *text, size_t length) {
  char *copy = hc_alloc(length + 1, 1);
  if (length) memcpy(copy, text, length);
  copy[length] = '\0';
  return copy;
}

static hc_yaml_node *new_node(builder *b, hc_yaml_kind kind, hc_place place) {
  hc_yaml_node *node = hc_alloc_zero(1, sizeof *node);
  node->kind = kind;
  node->line = place.line;
  node->column = place.column;
  node->next = b->yaml->nodes;
  b->yaml->nodes = node;
  return node;
}

static void append(hc_yaml_node *parent, hc_yaml_node *key, hc_yaml_node *item) {
  const size_t count = (size_t)parent->count;
  hc_reserve((void **)&parent->items, &parent->item_room, count + 1, count, sizeof *parent->items);
  parent->items[count] = item;
  if (key) {
    hc_reserve((void **)&parent->keys, &parent->key_room, count + 1, count, sizeof *parent->keys);
    parent->keys[count] = key;
  }
  parent->count++;
}

static hc_place event_place(builder *b, struct fy_event *event) {
  const struct fy_mark *mark = fy_event_start_mark(event);
  if (mark) b->last = (hc_place){b->source, mark->line + 1, mark->column + 1};
  return b->last;
}

/* What is missing at the end of a text is missing behind its last line. */
static hc_place within(const hc_source *source, int line, int column) {
  int last_line = 1, last_column = 1, now = 1, at = 1;
  for (size_t k = 0; k < source->length; k++) {
    const char c = source->text[k];
    if (c == '\n') {
      now++;
      at = 1;
    } else if (((unsigned char)c & 0xc0) != 0x80) {
      at++;
      last_line = now;
      last_column = at;
    }
  }
  if (line <= last_line) return (hc_place){source, line, column};
  return (hc_place){source, last_line, last_column};
}

/* libfyaml collects more than one message for one mistake: the first is the cause. */
static void complain_of_syntax(const builder *b) {
  void *position = NULL;
  const struct fy_diag_error *found = fy_diag_errors_iterate(b->diag, &position);
  if (found && found->msg)
    hc_complaints_add(b->complaints, within(b->source, found->line, found->column), "not valid YAML: %s",
                      found->msg);
  else
    hc_complaints_add(b->complaints, b->last, "not valid YAML");
}

/* The next event, or null after a complaint. To be freed with fy_parser_event_free. */
static struct fy_event *next_event(builder *b) {
  struct fy_event *event = fy_parser_parse(b->parser);
  if (!event) complain_of_syntax(b);
  return event;
}

static char *token_copy(struct fy_token *token) {
  size_t length = 0;
  const char *text = token ? fy_token_get_text(token, &length) : NULL;
  return copy_text(text, text ? length : 0);
}

static hc_yaml_node *build_scalar(builder *b, struct fy_event *event, hc_place place) {
  struct fy_token *token = event->scalar.value;
  const enum fy_scalar_style style = token ? fy_token_scalar_style(token) : FYSS_PLAIN;
  /* libfyaml points behind the opening quote. */
  if (style == FYSS_SINGLE_QUOTED || style == FYSS_DOUBLE_QUOTED) place.column--;
  hc_yaml_node *node = new_node(b, HC_YAML_SCALAR, place);
  node->text = token_copy(token);
  node->quoted = style != FYSS_PLAIN;
  if (token && strlen(node->text) != fy_token_get_text_length(token)) {
    hc_complaints_add(b->complaints, place, "text must not hold a zero character");
    return NULL;
  }
  return node;
}

static hc_yaml_node *find_anchor(builder *b, struct fy_event *event, hc_place place) {
  place.column--; /* libfyaml points behind the asterisk */
  char *name = token_copy(event->alias.anchor);
  hc_yaml_node *found = NULL;
  /* The newest node comes first: an anchor may be set again. */
  for (hc_yaml_node *node = b->yaml->nodes; node && !found; node = node->next)
    if (node->anchor && strcmp(node->anchor, name) == 0) found = node;
  if (!found) hc_complaints_add(b->complaints, place, "alias '*%s' has no anchor before it", name);
  hc_free(name);
  return found;
}

static hc_yaml_node *build_node(builder *b, struct fy_event *event);

/* A key that is not there stands where its value does. */
static void place_like(hc_yaml_node *key, const hc_yaml_node *value) {
  key->line = value->line;
  key->column = value->column;
}

/* The children of a list or map; false after a complaint. */
static bool build_children(builder *b, hc_yaml_node *parent) {
  const bool map = parent->kind == HC_YAML_MAP;
  const enum fy_event_type end = map ? FYET_MAPPING_END : FYET_SEQUENCE_END;
  hc_yaml_node *key = NULL;
  for (;;) {
    struct fy_event *event = next_event(b);
    if (!event) return false;
    const bool done = event->type == end;
    hc_yaml_node *node = done ? NULL : build_node(b, event);
    fy_parser_event_free(b->parser, event);
    if (done) return true;
    if (!node) return false;
    if (map && !key) {
      if (node->kind != HC_YAML_SCALAR) {
        hc_complaints_add(b->complaints, (hc_place){b->source, node->line, node->column},
                          "a key must be a word, not a %s", node->kind == HC_YAML_MAP ? "map" : "list");
        return false;
      }
      key = node;
    } else {
      if (key && !*key->text && !key->quoted) place_like(key, node);
      append(parent, key, node);
      key = NULL;
    }
  }
}

/* The node that begins with `event`, which stays the caller's. Null after a complaint. */
static hc_yaml_node *build_node(builder *b, struct fy_event *event) {
  const hc_place place = event_place(b, event);
  struct fy_token *anchor = NULL, *tag = NULL;
  hc_yaml_node *node = NULL;
  switch (event->type) {
  case FYET_ALIAS:
    return find_anchor(b, event, place);
  case FYET_SCALAR:
    anchor = event->scalar.anchor;
    tag = event->scalar.tag;
    node = build_scalar(b, event, place);
    break;
  case FYET_SEQUENCE_START:
    anchor = event->sequence_start.anchor;
    tag = event->sequence_start.tag;
    node = new_node(b, HC_YAML_LIST, place);
    break;
  case FYET_MAPPING_START:
    anchor = event->mapping_start.anchor;
    tag = event->mapping_start.tag;
    node = new_node(b, HC_YAML_MAP, place);
    break;
  default:
    hc_complaints_add(b->complaints, place, "not valid YAML");
    return NULL;
  }
  if (!node) return NULL;
  if (tag) {
    hc_complaints_add(b->complaints, place, "tags are not supported; types follow from the keys");
    return NULL;
  }
  if (node->kind != HC_YAML_SCALAR) {
    if (b->depth == DEEPEST) {
      hc_complaints_add(b->complaints, place, "nested more than %d deep", DEEPEST);
      return NULL;
    }
    b->depth++;
    const bool built = build_children(b, node);
    b->depth--;
    if (!built) return NULL;
  }
  /* Only now, so that no node can hold itself. */
  if (anchor) node->anchor = token_copy(anchor);
  return node;
}

/* Reads the stream into b->yaml->root; false after a complaint. */
static bool build_stream(builder *b) {
  for (;;) {
    struct fy_event *event = next_event(b);
    if (!event) return false;
    const enum fy_event_type type = event->type;
    const hc_place place = event_place(b, event);
    bool good = true;
    if (type == FYET_DOCUMENT_START) {
      if (b->yaml->root) {
        hc_complaints_add(b->complaints, place, "only one YAML document may be given");
        good = false;
      }
    } else if (type != FYET_STREAM_START && type != FYET_STREAM_END && type != FYET_DOCUMENT_END) {
      b->yaml->root = build_node(b, event);
      good = b->yaml->root != NULL;
    }
    fy_parser_event_free(b->parser, event);
    if (!good || type == FYET_STREAM_END) return good;
  }
}

/* libfyaml passes over bytes that are not UTF-8 and keeps control characters. False after a complaint. */
static bool check_characters(const hc_source *source, hc_complaints *complaints) {
  int line = 1, column = 1;
  for (size_t k = 0; k < source->length;) {
    const int length = hc_complaints_character(source->text + k, source->length - k);
    if (length <= 0) {
      hc_complaints_add(complaints, (hc_place){source, line, column},
                        length < 0 ? "not text: byte 0x%02x is a control character"
                                   : "not UTF-8 text: byte 0x%02x",
                        (unsigned)(unsigned char)source->text[k]);
      return false;
    }
    column++;
    const char *c = source->text + k;
    if (*c == '\n' || (*c == '\r' && (k + 1 == source->length || c[1] != '\n'))) {
      line++;
      column = 1;
    }
    k += (size_t)length;
  }
  return true;
}

hc_yaml *hc_yaml_parse(const hc_source *source, hc_complaints *complaints) {
  if (!check_characters(source, complaints)) return NULL;
  struct fy_diag_cfg silent;
  fy_diag_cfg_default(&silent);
  silent.fp = NULL;
  silent.output_fn = drop_message;
  struct fy_diag *diag = fy_diag_create(&silent);
  HC_CHECK(diag, "libfyaml: no memory for diagnostics");
  fy_diag_set_collect_errors(diag, true);
  const struct fy_parse_cfg config = {.search_path = "", .flags = FYPCF_JSON_NONE, .diag = diag};
  struct fy_parser *parser = fy_parser_create(&config);
  HC_CHECK(parser, "libfyaml: no memory for a parser");
  hc_yaml *yaml = hc_alloc_zero(1, sizeof *yaml);
  builder b = {.parser = parser, .diag = diag, .source = source, .complaints = complaints, .yaml = yaml};
  b.last = (hc_place){source, 1, 1};
  const int set = fy_parser_set_string(parser, source->text, source->length);
  HC_CHECK(set == 0, "libfyaml: no memory for %zu bytes of input", source->length);
  const bool built = build_stream(&b);
  fy_parser_destroy(parser);
  fy_diag_destroy(diag);
  if (built) return yaml;
  hc_yaml_free(yaml);
  return NULL;
}

void hc_yaml_free(hc_yaml *yaml) {
  if (!yaml) return;
  for (hc_yaml_node *node = yaml->nodes; node;) {
    hc_yaml_node *next = node->next;
    hc_free(node->text);
    hc_free(node->anchor);
    hc_free(node->items);
    hc_free(node->keys);
    hc_free(node);
    node = next;
  }
  hc_free(yaml);
}

bool hc_yaml_is_nothing(const hc_yaml_node *node) {
  return node->kind == HC_YAML_SCALAR && !node->quoted &&
         (!*node->text || strcmp(node->text, "~") == 0 || strcmp(node->text, "null") == 0);
}

void hc_yaml_seen(const hc_yaml_node *node, char text[static HC_YAML_SEEN]) {
  enum { SHOWN = 64 };
  if (hc_yaml_is_nothing(node)) {
    snprintf(text, HC_YAML_SEEN, "nothing");
  } else if (node->kind == HC_YAML_MAP) {
    snprintf(text, HC_YAML_SEEN, "a map");
  } else if (node->kind == HC_YAML_LIST) {
    snprintf(text, HC_YAML_SEEN, node->count ? "a list of %d" : "an empty list", node->count);
  } else {
    size_t shown = strnlen(node->text, SHOWN);
    const bool cut = node->text[shown] != '\0';
    /* Whole characters and one line only. */
    while (cut && shown > 0 && ((unsigned char)node->text[shown] & 0xc0) == 0x80) shown--;
    const size_t line = strcspn(node->text, "\r\n");
    const bool lines = line < shown;
    if (lines) shown = line;
    snprintf(text, HC_YAML_SEEN, "%s'%.*s%s'", node->quoted ? "the text " : "", (int)shown, node->text,
             cut || lines ? "..." : "");
  }
}
