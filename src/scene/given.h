/* What a user gave, sorted by the parameter table but not yet understood: for each row the YAML node that
 * counts.
 *
 * An override replaces a node here, so that a value is checked once, wherever it comes from. */
#ifndef HC_GIVEN_H
#define HC_GIVEN_H

#include "complaints.h"
#include "params.h"
#include "yaml.h"

typedef struct hc_given hc_given;

typedef struct hc_given_value {
  const hc_yaml_node *node; /* null: not given */
  hc_place place;
  bool bad;        /* complained of: nothing that depends on it needs to be. May hold without a node */
  hc_given *items; /* LIST: one for each item */
  int item_count;
} hc_given_value;

struct hc_given {
  const hc_param_table *table;
  char prefix[HC_PARAM_PATH]; /* of the paths in messages: "fluid.blocks[0]." */
  hc_place place;
  bool bad;               /* an item that is no map */
  hc_given_value *values; /* one for each row of the table */
};

/* An empty instance of a table. Freed with hc_given_free. The nodes stay their trees'. */
hc_given hc_given_start(const hc_param_table *table, const char *prefix, hc_place place);
void hc_given_free(hc_given *given);

/* Takes over the map `node`: complains of unknown and repeated keys, and of values where maps are due. */
void hc_given_take(hc_given *given, const hc_yaml_node *node, const hc_source *source,
                   hc_complaints *complaints);

/* Puts the value `node` at `path`, such as fluid.blocks[0].velocity, over what was given there; maps are
 * merged. */
void hc_given_override(hc_given *given, const char *path, const hc_yaml_node *node, const hc_source *source,
                       hc_complaints *complaints);

/* The value of a key that must be in the table. */
hc_given_value *hc_given_value_of(const hc_given *given, const char *path);

/* Is the key given; is it complained of? */
bool hc_given_has(const hc_given *given, const char *path);
bool hc_given_is_bad(const hc_given *given, const char *path);

/* Where to point for a key: its value, or the map that lacks it. */
hc_place hc_given_place_of(const hc_given *given, const char *path);

#endif
