/* YAML text as a tree of nodes that know where they stand. The only user of libfyaml.
 *
 * The tree is built from libfyaml's events, not from its documents: those keep no positions of maps and
 * lists, stop at the first duplicate key, and expand aliases. */
#ifndef HC_YAML_H
#define HC_YAML_H

#include "complaints.h"

#include <stdbool.h>

typedef enum hc_yaml_kind { HC_YAML_SCALAR, HC_YAML_LIST, HC_YAML_MAP } hc_yaml_kind;

typedef struct hc_yaml_node hc_yaml_node;
struct hc_yaml_node {
  hc_yaml_kind kind;
  int line, column; /* from 1 */
  char *text;       /* SCALAR: zero-terminated, without zeros inside */
  bool quoted;      /* SCALAR: text, whatever it looks like */
  int count;        /* LIST, MAP */
  hc_yaml_node **items;
  hc_yaml_node **keys; /* MAP: scalars */
  size_t item_room, key_room;
  char *anchor;
  hc_yaml_node *next; /* all nodes of a tree: an aliased node has several parents */
};

typedef struct hc_yaml {
  hc_yaml_node *root; /* null: nothing but comments */
  hc_yaml_node *nodes;
} hc_yaml;

/* Parses one document. Complains and returns null if the text is not YAML, or uses tags, several documents or
 * keys that are not scalars. The tree is independent of the source's text. Freed with hc_yaml_free. Local. */
hc_yaml *hc_yaml_parse(const hc_source *source, hc_complaints *complaints);

void hc_yaml_free(hc_yaml *yaml);

/* True for a scalar that says nothing: empty, ~ or null. */
bool hc_yaml_is_nothing(const hc_yaml_node *node);

/* What a node is, for messages: 'text', a list of 2, a map, nothing. */
enum { HC_YAML_SEEN = 96 };
void hc_yaml_seen(const hc_yaml_node *node, char text[static HC_YAML_SEEN]);

#endif
