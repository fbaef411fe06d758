#include "convert.h"

#include "base/check.h"
#include "base/memory.h"
#include "nearest.h"
#include "scene.h"

#include <errno.h>
#include <limits.h>
#include <locale.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { WANTED_TEXT = 256 };

/* "PATH must be WANTED, not SEEN", at a node that is the value or a part of it (`index` >= 0). */
static bool refuse(const hc_conversion *c, const hc_yaml_node *node, int index, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

static bool refuse(const hc_conversion *c, const hc_yaml_node *node, int index, const char *format, ...) {
  char wanted[WANTED_TEXT], seen[HC_YAML_SEEN], part[16] = "";
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(wanted, sizeof wanted, format, arguments);
  va_end(arguments);
  hc_yaml_seen(node, seen);
  hc_place place = c->place;
  if (index >= 0) {
    snprintf(part, sizeof part, "[%d]", index);
    if (!hc_yaml_is_nothing(node)) place = (hc_place){place.source, node->line, node->column};
  }
  hc_complaints_add(c->complaints, place, "%s%s%s must be %s, not %s", c->prefix, c->param->path, part,
                    wanted, seen);
  return false;
}

static const char *skip_digits(const char *text) {
  while (*text >= '0' && *text <= '9') text++;
  return text;
}

static const char *skip_sign(const char *text) {
  return text + (*text == '-' || *text == '+');
}

static bool looks_integer(const char *text) {
  const char *digits = skip_sign(text), *end = skip_digits(digits);
  return end > digits && !*end;
}

/* Decimal numbers as in YAML's core schema: no hexadecimal, no underscores. */
static bool looks_number(const char *text) {
  const char *at = skip_sign(text), *whole = at;
  at = skip_digits(at);
  ptrdiff_t digits = at - whole;
  if (*at == '.') {
    const char *fraction = ++at;
    at = skip_digits(at);
    digits += at - fraction;
  }
  if (digits == 0) return false;
  if (*at == 'e' || *at == 'E') {
    const char *exponent = skip_sign(at + 1);
    at = skip_digits(exponent);
    if (at == exponent) return false;
  }
  return !*at;
}

static bool looks_infinite_or_nan(const char *text) {
  const char *word = skip_sign(text);
  if (*word == '.') word++;
  return strcasecmp(word, "inf") == 0 || strcasecmp(word, "infinity") == 0 || strcasecmp(word, "nan") == 0;
}

static bool in_range(const hc_param *param, double value) {
  const hc_range range = param->range;
  return value <= range.high && (range.above_low ? value > range.low : value >= range.low);
}

static bool refuse_range(const hc_conversion *c, const hc_yaml_node *node, int index) {
  char range[WANTED_TEXT];
  hc_params_range_text(c->param, range, sizeof range);
  return refuse(c, node, index, "%s%s%s", range, c->param->zero_word ? " or " : "",
                c->param->zero_word ? c->param->zero_word : "");
}

static bool convert_number(const hc_conversion *c, const hc_yaml_node *node, int index, double *out) {
  const char *word = c->param->zero_word;
  const bool plain = node->kind == HC_YAML_SCALAR && !node->quoted;
  if (word && plain && strcmp(node->text, word) == 0) {
    *out = 0.0;
    return true;
  }
  if (plain && looks_infinite_or_nan(node->text)) return refuse(c, node, index, "finite");
  if (!plain || !looks_number(node->text))
    return refuse(c, node, index, "a number%s%s", word ? " or the word " : "", word ? word : "");
  const locale_t locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
  *out = strtod_l(node->text, NULL, locale);
  freelocale(locale);
  if (!isfinite(*out)) return refuse(c, node, index, "finite, below 1.8e308");
  return in_range(c->param, *out) || refuse_range(c, node, index);
}

static bool convert_integer(const hc_conversion *c, const hc_yaml_node *node, int index, int64_t *out) {
  if (node->kind != HC_YAML_SCALAR || node->quoted || !looks_integer(node->text))
    return refuse(c, node, index, "an integer");
  errno = 0;
  *out = strtoll(node->text, NULL, 10);
  const bool fits = errno == 0 && (c->param->kind == HC_PARAM_INT64 || (*out >= INT_MIN && *out <= INT_MAX));
  if (!fits && !isfinite(c->param->range.high))
    return refuse(c, node, index, "an integer of at most %d", INT_MAX);
  return (fits && in_range(c->param, (double)*out)) || refuse_range(c, node, index);
}

static bool convert_bool(const hc_conversion *c, const hc_yaml_node *node, int index, bool *out) {
  const bool plain = node->kind == HC_YAML_SCALAR && !node->quoted;
  *out = plain && strcasecmp(node->text, "true") == 0;
  return *out || (plain && strcasecmp(node->text, "false") == 0) || refuse(c, node, index, "true or false");
}

static bool convert_text(const hc_conversion *c, char *out, size_t size) {
  const hc_yaml_node *node = c->node;
  if (node->kind != HC_YAML_SCALAR || !*node->text || hc_yaml_is_nothing(node))
    return refuse(c, node, -1, "text");
  const size_t length = strlen(node->text);
  if (length >= size) return refuse(c, node, -1, "at most %zu bytes long", size - 1);
  for (size_t k = 0; k < length;) {
    const int bytes = hc_complaints_character(node->text + k, length - k);
    if (bytes <= 0 || (unsigned char)node->text[k] < ' ')
      return refuse(c, node, -1, "one line of text without control characters");
    k += (size_t)bytes;
  }
  memset(out, 0, size);
  memcpy(out, node->text, length);
  return true;
}

static bool refuse_name(const hc_conversion *c, const hc_yaml_node *node, int index, const char *known,
                        const char *nearest) {
  return refuse(c, node, index, nearest ? "one of %s (nearest: %s)" : "one of %s", known, nearest);
}

static bool convert_choice(const hc_conversion *c, const hc_yaml_node *node, int index, int *out) {
  enum { MOST = 32 };
  const char *names[MOST];
  int count = 0;
  for (const hc_choice *choice = c->param->choices; choice->name && count < MOST; choice++) {
    names[count++] = choice->name;
    *out = choice->value;
    if (node->kind == HC_YAML_SCALAR && strcmp(node->text, choice->name) == 0) return true;
  }
  char known[WANTED_TEXT];
  hc_params_choices_text(c->param->choices, known, sizeof known);
  const char *nearest = node->kind == HC_YAML_SCALAR ? hc_nearest_name(names, count, node->text) : NULL;
  return refuse_name(c, node, index, known, nearest);
}

static bool convert_flags(const hc_conversion *c, unsigned *out) {
  if (c->node->kind != HC_YAML_LIST)
    return refuse(c, c->node, -1, "a list, such as [%s]", c->param->choices->name);
  bool good = true;
  unsigned bits = 0;
  for (int k = 0; k < c->node->count; k++) {
    int bit = 0;
    if (convert_choice(c, c->node->items[k], k, &bit))
      bits |= (unsigned)bit;
    else
      good = false;
  }
  *out = bits;
  return good;
}

static bool convert_name(const hc_conversion *c, int index, char out[static HC_PARAM_NAME_SIZE]) {
  const hc_yaml_node *node = c->node->items[index];
  const hc_scene_limits *limits = c->limits;
  if (node->kind != HC_YAML_SCALAR || strlen(node->text) >= HC_PARAM_NAME_SIZE || !*node->text)
    return refuse(c, node, index, "a name of at most %d bytes", HC_PARAM_NAME_SIZE - 1);
  bool known = !limits;
  for (int k = 0; limits && k < limits->snapshot_field_count; k++)
    if (strcmp(limits->snapshot_fields[k], node->text) == 0) known = true;
  if (!known) {
    char names[WANTED_TEXT] = "";
    size_t used = 0;
    for (int k = 0; k < limits->snapshot_field_count && used < sizeof names; k++)
      used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", k ? ", " : "",
                               limits->snapshot_fields[k]);
    return refuse_name(c, node, index, names,
                       hc_nearest_name(limits->snapshot_fields, limits->snapshot_field_count, node->text));
  }
  for (int k = 0; k < index; k++)
    if (c->node->items[k]->kind == HC_YAML_SCALAR && strcmp(c->node->items[k]->text, node->text) == 0)
      return refuse(c, node, index, "named once");
  memset(out, 0, HC_PARAM_NAME_SIZE);
  strcpy(out, node->text);
  return true;
}

static bool convert_names(const hc_conversion *c, char *out, int *count) {
  const int most = (int)(c->param->size / HC_PARAM_NAME_SIZE);
  if (c->node->kind != HC_YAML_LIST || c->node->count > most)
    return refuse(c, c->node, -1, "a list of at most %d names", most);
  bool good = true;
  for (int k = 0; k < c->node->count; k++) good &= convert_name(c, k, out + k * HC_PARAM_NAME_SIZE);
  *count = c->node->count;
  return good;
}

/* `*out` is allocated; null unless all pairs are good. */
static bool convert_pairs(const hc_conversion *c, double (**out)[2], int *count) {
  *out = NULL;
  *count = 0;
  if (c->node->kind != HC_YAML_LIST)
    return refuse(c, c->node, -1, "a list of pairs, such as [[0, 0], [1, 2]]");
  double(*const pairs)[2] = hc_alloc((size_t)c->node->count, sizeof *pairs);
  bool good = true;
  for (int k = 0; k < c->node->count; k++) {
    const hc_yaml_node *const pair = c->node->items[k];
    if (pair->kind != HC_YAML_LIST || pair->count != 2) {
      good = refuse(c, pair, k, "a pair of numbers");
      continue;
    }
    for (int part = 0; part < 2; part++) good &= convert_number(c, pair->items[part], k, &pairs[k][part]);
  }
  if (!good) {
    hc_free(pairs);
    return false;
  }
  *out = pairs;
  *count = c->node->count;
  return true;
}

/* One component of a scalar or vector. */
static bool convert_component(const hc_conversion *c, const hc_yaml_node *node, int index, void *member) {
  const int k = index < 0 ? 0 : index;
  int64_t integer = 0;
  bool good = false;
  switch (c->param->kind) {
  case HC_PARAM_BOOL:
    return convert_bool(c, node, index, (bool *)member + k);
  case HC_PARAM_NUMBER:
    return convert_number(c, node, index, (double *)member + k);
  case HC_PARAM_CHOICE:
    return convert_choice(c, node, index, member);
  case HC_PARAM_INT64:
    return convert_integer(c, node, index, (int64_t *)member + k);
  case HC_PARAM_INT:
    good = convert_integer(c, node, index, &integer);
    if (good) *(int *)member = (int)integer;
    return good;
  default:
    hc_check_failed(__FILE__, __LINE__, "key '%s' of kind %d is no scalar", c->param->path, c->param->kind);
  }
}

bool hc_convert(const hc_conversion *c) {
  const hc_param *param = c->param;
  void *member = (char *)c->owner + param->offset;
  if (param->kind == HC_PARAM_TEXT) return convert_text(c, member, param->size);
  if (param->kind == HC_PARAM_FLAGS) return convert_flags(c, member);
  if (param->kind == HC_PARAM_NAMES)
    return convert_names(c, member, (int *)((char *)c->owner + param->count_offset));
  if (param->kind == HC_PARAM_PAIRS)
    return convert_pairs(c, member, (int *)((char *)c->owner + param->count_offset));
  const int length = hc_params_length(param);
  if (length == 1) return convert_component(c, c->node, -1, member);
  const int least = param->shorter ? length - 1 : length;
  if (c->node->kind != HC_YAML_LIST || c->node->count < least || c->node->count > length)
    return refuse(c, c->node, -1, "a list of %s%d %s", param->shorter ? "2 or " : "", length,
                  param->kind == HC_PARAM_BOOL    ? "times true or false"
                  : param->kind == HC_PARAM_INT64 ? "integers"
                                                  : "numbers");
  bool good = true;
  for (int k = 0; k < c->node->count; k++) good &= convert_component(c, c->node->items[k], k, member);
  for (int k = c->node->count; k < length; k++) ((double *)member)[k] = NAN;
  return good;
}
