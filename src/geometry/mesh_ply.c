#include "mesh_formats.h"

#include "base/memory.h"
#include "base/text_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ELEMENTS = 32, MOST_PROPERTIES = 64, NAME = 32 };

typedef enum type { NO_TYPE, I8, U8, I16, U16, I32, U32, F32, F64 } type;

static const struct {
  const char *name;
  type type;
} types[] = {{"char", I8},   {"uchar", U8},   {"short", I16},   {"ushort", U16},
             {"int", I32},   {"uint", U32},   {"float", F32},   {"double", F64},
             {"int8", I8},   {"uint8", U8},   {"int16", I16},   {"uint16", U16},
             {"int32", I32}, {"uint32", U32}, {"float32", F32}, {"float64", F64}};

static const int sizes[] = {
    [I8] = 1, [U8] = 1, [I16] = 2, [U16] = 2, [I32] = 4, [U32] = 4, [F32] = 4, [F64] = 8};

typedef struct property {
  char name[NAME];
  type count, type; /* count: NO_TYPE if it is no list */
} property;

typedef struct element {
  char name[NAME];
  long long count;
  int property_count;
  property properties[MOST_PROPERTIES];
} element;

typedef enum form { TEXT, LITTLE, BIG } form;

typedef struct reading {
  const char *path;
  hc_lines lines; /* of the head, and of a text */
  char *rest;     /* of the line */
  const unsigned char *at, *end;
  form form;
  element *elements;
  int element_count;
  hc_mesh_soup *soup;
  int32_t *corners;
  size_t room;
} reading;

static hc_status broken(const reading *r, hc_error *error, const char *what, const char *seen) {
  return hc_error_set(error, HC_BAD_INPUT, "%s:%d: %s, not '%.80s'", r->path, r->lines.number, what,
                      seen ? seen : "");
}

/* ---- the head ---- */

static type type_of(const char *name) {
  for (size_t k = 0; name && k < sizeof types / sizeof *types; k++)
    if (strcmp(types[k].name, name) == 0) return types[k].type;
  return NO_TYPE;
}

static hc_status take_format(reading *r, char *at, hc_error *error) {
  static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
  const char *const name = hc_lines_word(&at);
  for (int k = 0; name && k < 3; k++)
    if (strcmp(names[k], name) == 0) {
      r->form = (form)k;
      return HC_OK;
    }
  return broken(r, error, "format must be one of ascii, binary_little_endian, binary_big_endian", name);
}

static void set_name(char to[static NAME], const char *name) {
  strncpy(to, name, NAME - 1);
  to[NAME - 1] = '\0';
}

static hc_status take_element(reading *r, char *at, hc_error *error) {
  const char *const name = hc_lines_word(&at), *const count = hc_lines_word(&at);
  char *end = NULL;
  const long long number = count ? strtoll(count, &end, 10) : -1;
  if (!name || number < 0 || *end) return broken(r, error, "an element must have a name and a count", count);
  if (r->element_count == MOST_ELEMENTS) return broken(r, error, "there must be at most 32 elements", name);
  element *const e = &r->elements[r->element_count++];
  set_name(e->name, name);
  e->count = number;
  return HC_OK;
}

static hc_status take_property(reading *r, char *at, hc_error *error) {
  if (r->element_count == 0) return broken(r, error, "a property must come behind an element", at);
  element *const e = &r->elements[r->element_count - 1];
  if (e->property_count == MOST_PROPERTIES)
    return broken(r, error, "an element must have at most 64 properties", at);
  property *const p = &e->properties[e->property_count++];
  const char *word = hc_lines_word(&at);
  const bool list = word && strcmp(word, "list") == 0;
  if (list) {
    p->count = type_of(word = hc_lines_word(&at));
    if (p->count == NO_TYPE || p->count >= F32)
      return broken(r, error, "a list must have a whole number's type", word);
    word = hc_lines_word(&at);
  }
  p->type = type_of(word);
  if (p->type == NO_TYPE) return broken(r, error, "a property must have a type such as float or int", word);
  word = hc_lines_word(&at);
  if (!word) return broken(r, error, "a property must have a name", word);
  set_name(p->name, word);
  return HC_OK;
}

/* The head is text in binary files too: the lines end where it ends. */
static hc_status read_head(reading *r, const char *bytes, size_t length, hc_error *error) {
  const char *const mark = "end_header", *end = NULL;
  for (size_t k = 0; !end && k + strlen(mark) <= length; k++)
    if (memcmp(bytes + k, mark, strlen(mark)) == 0) end = bytes + k + strlen(mark);
  if (!end)
    return hc_error_set(error, HC_BAD_INPUT, "%s: no PLY file, or cut short: its head has no end", r->path);
  if (end < bytes + length && *end == '\r') end++;
  if (end < bytes + length && *end == '\n') end++;
  r->at = (const unsigned char *)end;
  r->end = (const unsigned char *)bytes + length;
  hc_status status = hc_lines_start(&r->lines, r->path, bytes, (size_t)(end - bytes), error);
  const char *const first = status == HC_OK ? hc_lines_next(&r->lines) : NULL;
  if (status == HC_OK && (!first || strcmp(first, "ply") != 0))
    status = broken(r, error, "must begin with ply", first);
  for (char *line; status == HC_OK && (line = hc_lines_next(&r->lines));) {
    const char *const word = hc_lines_word(&line);
    if (word && strcmp(word, "format") == 0) status = take_format(r, line, error);
    if (word && strcmp(word, "element") == 0) status = take_element(r, line, error);
    if (word && strcmp(word, "property") == 0) status = take_property(r, line, error);
  }
  return status;
}

/* ---- numbers ---- */

static hc_status next_word(reading *r, double *number, hc_error *error) {
  const char *word = r->rest ? hc_lines_word(&r->rest) : NULL;
  while (!word) {
    r->rest = hc_lines_next(&r->lines);
    if (!r->rest) return hc_error_set(error, HC_BAD_INPUT, "%s: is cut short: numbers are missing", r->path);
    word = hc_lines_word(&r->rest);
  }
  if (!hc_lines_number(&r->lines, word, number)) return broken(r, error, "there must be a number", word);
  return HC_OK;
}

/* Of a number's bits, the lowest first. */
static double value_of(uint64_t bits, type type) {
  const uint32_t half = (uint32_t)bits;
  float single;
  double full;
  switch (type) {
  case I8:
    return (int8_t)bits;
  case I16:
    return (int16_t)bits;
  case I32:
    return (int32_t)bits;
  case F32:
    memcpy(&single, &half, sizeof single);
    return hc_mesh_decimal(single);
  case F64:
    memcpy(&full, &bits, sizeof full);
    return full;
  case U8:
  case U16:
  case U32:
  case NO_TYPE:
    break;
  }
  return (double)bits;
}

static hc_status next_number(reading *r, type type, double *number, hc_error *error) {
  if (r->form == TEXT) return next_word(r, number, error);
  const int size = sizes[type];
  if (r->end - r->at < size)
    return hc_error_set(error, HC_BAD_INPUT, "%s: is cut short: numbers are missing", r->path);
  uint64_t bits = 0;
  for (int k = 0; k < size; k++) bits |= (uint64_t)r->at[r->form == BIG ? size - 1 - k : k] << 8 * k;
  r->at += size;
  *number = value_of(bits, type);
  return HC_OK;
}

/* How many numbers a property has: 1, or a list's count. */
static hc_status next_count(reading *r, const property *p, double *count, hc_error *error) {
  *count = 1;
  if (p->count == NO_TYPE) return HC_OK;
  if (next_number(r, p->count, count, error) != HC_OK) return error->status;
  if (*count >= 0 && *count == floor(*count)) return HC_OK;
  return hc_error_set(error, HC_BAD_INPUT, "%s: a list must have a whole number of items, not %.9g", r->path,
                      *count);
}

/* ---- the elements ---- */

static hc_status read_vertex(reading *r, const element *e, hc_error *error) {
  double x[3] = {NAN, NAN, NAN}, number;
  for (int k = 0; k < e->property_count; k++) {
    const property *const p = &e->properties[k];
    double count;
    if (next_count(r, p, &count, error) != HC_OK) return error->status;
    for (double item = 0; item < count; item++)
      if (next_number(r, p->type, &number, error) != HC_OK) return error->status;
    if (p->count == NO_TYPE && p->name[0] >= 'x' && p->name[0] <= 'z' && !p->name[1])
      x[p->name[0] - 'x'] = number;
  }
  return hc_mesh_soup_add_vertex(r->soup, x, error);
}

static bool has_corners(const property *p) {
  return p->count != NO_TYPE &&
         (strcmp(p->name, "vertex_indices") == 0 || strcmp(p->name, "vertex_index") == 0);
}

static hc_status read_list(reading *r, const property *p, bool wanted, hc_error *error) {
  double number, count;
  if (next_count(r, p, &count, error) != HC_OK) return error->status;
  for (double k = 0; k < count; k++) {
    if (next_number(r, p->type, &number, error) != HC_OK) return error->status;
    if (!wanted) continue;
    if (!(number >= 0 && number < (double)r->soup->vertices && number == floor(number)))
      return hc_error_set(error, HC_BAD_INPUT, "%s: a face names vertex %.9g, of %zu (from 0 on)", r->path,
                          number, r->soup->vertices);
    hc_reserve((void **)&r->corners, &r->room, 2 * (size_t)k + 4, (size_t)k, sizeof *r->corners);
    r->corners[(size_t)k] = (int32_t)number;
  }
  return wanted ? hc_mesh_soup_add_polygon(r->soup, r->corners, (int)count, error) : HC_OK;
}

static bool has_all(const element *e, const char *const *names) {
  for (; *names; names++) {
    bool found = false;
    for (int k = 0; k < e->property_count; k++) found |= strcmp(e->properties[k].name, *names) == 0;
    if (!found) return false;
  }
  return true;
}

static hc_status read_element(reading *r, const element *e, hc_error *error) {
  static const char *const needed[] = {"x", "y", "z", NULL};
  const bool vertices = strcmp(e->name, "vertex") == 0, faces = strcmp(e->name, "face") == 0;
  if (vertices && !has_all(e, needed))
    return hc_error_set(error, HC_BAD_INPUT, "%s: its vertices must have the properties x, y and z", r->path);
  for (long long k = 0; k < e->count && e->property_count > 0; k++) {
    hc_status status = vertices ? read_vertex(r, e, error) : HC_OK;
    for (int p = 0; p < e->property_count && !vertices && status == HC_OK; p++)
      status = read_list(r, &e->properties[p], faces && has_corners(&e->properties[p]), error);
    if (status != HC_OK) return status;
  }
  return HC_OK;
}

hc_status hc_mesh_read_ply(const char *path, const char *bytes, size_t length, hc_mesh_soup *soup,
                           hc_error *error) {
  reading r = {
      .path = path, .soup = soup, .elements = hc_alloc_zero(MOST_ELEMENTS, sizeof *r.elements), .form = TEXT};
  hc_status status = read_head(&r, bytes, length, error);
  if (status == HC_OK && r.form == TEXT) {
    const int head = r.lines.number;
    hc_lines_free(&r.lines);
    status = hc_lines_start(&r.lines, path, (const char *)r.at, (size_t)(r.end - r.at), error);
    r.lines.number = head;
  }
  for (int k = 0; k < r.element_count && status == HC_OK; k++)
    status = read_element(&r, &r.elements[k], error);
  hc_lines_free(&r.lines);
  hc_free(r.elements);
  hc_free(r.corners);
  return status;
}
