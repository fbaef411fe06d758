/* One YAML value into one member of a struct, as a row of the parameter table says. */
#ifndef HC_CONVERT_H
#define HC_CONVERT_H

#include "complaints.h"
#include "params.h"
#include "scene_limits.h"
#include "yaml.h"

typedef struct hc_conversion {
  const hc_param *param; /* not a LIST */
  const char *prefix;    /* of the path in messages */
  const hc_yaml_node *node;
  hc_place place; /* of the value as a whole */
  const hc_scene_limits *limits;
  void *owner; /* the struct */
  hc_complaints *complaints;
} hc_conversion;

/* Writes the member; false after a complaint, with the member undefined. */
bool hc_convert(const hc_conversion *conversion);

#endif
