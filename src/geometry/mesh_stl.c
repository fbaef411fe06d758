#include "mesh_formats.h"

#include "base/text_file.h"

#include <ctype.h>
#include <string.h>
#include <strings.h>

enum { HEAD = 80, FACET = 50, LOOKED_AT = 1024 };

static hc_status add_facet(hc_mesh_soup *soup, const double (*x)[3], hc_error *error) {
  int32_t corners[3];
  for (int c = 0; c < 3; c++) {
    corners[c] = (int32_t)soup->vertices;
    if (hc_mesh_soup_add_vertex(soup, x[c], error) != HC_OK) return error->status;
  }
  return hc_mesh_soup_add_polygon(soup, corners, 3, error);
}

/* ---- binary ---- */

static uint32_t whole_at(const unsigned char *at) {
  return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static hc_status read_binary(const char *path, const unsigned char *bytes, size_t length, hc_mesh_soup *soup,
                             hc_error *error) {
  const size_t count = length < HEAD + 4 ? 0 : whole_at(bytes + HEAD), needed = HEAD + 4 + FACET * count;
  if (length < HEAD + 4 || length < needed)
    return hc_error_set(
        error, HC_BAD_INPUT,
        "%s: is cut short, or no STL file: a binary one of %zu triangles has %zu bytes, this has %zu", path,
        count, needed, length);
  for (size_t k = 0; k < count; k++) {
    const unsigned char *at = bytes + HEAD + 4 + FACET * k + 12; /* behind the normal */
    double x[3][3];
    for (int c = 0; c < 3; c++)
      for (int a = 0; a < 3; a++, at += 4) {
        const uint32_t word = whole_at(at);
        float value;
        memcpy(&value, &word, sizeof value);
        x[c][a] = hc_mesh_decimal(value);
      }
    if (add_facet(soup, (const double(*)[3])x, error) != HC_OK) return error->status;
  }
  return HC_OK;
}

/* ---- text ---- */

/* Binary files may begin with "solid" too, but have a zero in the count of their triangles at least. */
static bool is_text(const char *bytes, size_t length) {
  hc_text_skip_mark(&bytes, &length);
  while (length > 0 && isspace((unsigned char)*bytes)) {
    bytes++;
    length--;
  }
  const size_t looked_at = length < LOOKED_AT ? length : LOOKED_AT;
  return length >= 5 && strncasecmp(bytes, "solid", 5) == 0 && !memchr(bytes, '\0', looked_at);
}

/* A facet being read. */
typedef struct facet {
  double x[3][3];
  int corners;
  bool open; /* between "loop" and "endloop" */
} facet;

static hc_status take_vertex(const char *path, const hc_lines *lines, char **at, facet *f, hc_error *error) {
  if (!f->open || f->corners == 3)
    return hc_error_set(error, HC_BAD_INPUT, "%s:%d: a facet must have one loop of three vertices", path,
                        lines->number);
  if (hc_mesh_read_point(path, lines, at, f->x[f->corners], error) != HC_OK) return error->status;
  f->corners++;
  return HC_OK;
}

static hc_status close_loop(const char *path, const hc_lines *lines, facet *f, hc_mesh_soup *soup,
                            hc_error *error) {
  if (f->corners != 3)
    return hc_error_set(error, HC_BAD_INPUT, "%s:%d: a facet must have three vertices, not %d", path,
                        lines->number, f->corners);
  f->open = false;
  f->corners = 0;
  return add_facet(soup, (const double(*)[3])f->x, error);
}

static hc_status take_line(const char *path, const hc_lines *lines, char *line, facet *f, hc_mesh_soup *soup,
                           hc_error *error) {
  hc_status status = HC_OK;
  for (const char *word = hc_lines_word(&line); word && status == HC_OK; word = hc_lines_word(&line)) {
    if (strcasecmp(word, "solid") == 0 || strcasecmp(word, "endsolid") == 0) return HC_OK; /* its name */
    if (strcasecmp(word, "loop") == 0) *f = (facet){.open = true};
    if (strcasecmp(word, "vertex") == 0) status = take_vertex(path, lines, &line, f, error);
    if (strcasecmp(word, "endloop") == 0) status = close_loop(path, lines, f, soup, error);
  }
  return status;
}

static hc_status read_text(const char *path, const char *bytes, size_t length, hc_mesh_soup *soup,
                           hc_error *error) {
  hc_lines lines;
  facet f = {.open = false};
  hc_status status = hc_lines_start(&lines, path, bytes, length, error);
  for (char *line; status == HC_OK && (line = hc_lines_next(&lines));)
    status = take_line(path, &lines, line, &f, soup, error);
  if (status == HC_OK && f.open)
    status = hc_error_set(error, HC_BAD_INPUT, "%s:%d: is cut short: a facet has no end", path, lines.number);
  hc_lines_free(&lines);
  return status;
}

hc_status hc_mesh_read_stl(const char *path, const char *bytes, size_t length, hc_mesh_soup *soup,
                           hc_error *error) {
  return is_text(bytes, length) ? read_text(path, bytes, length, soup, error)
                                : read_binary(path, (const unsigned char *)bytes, length, soup, error);
}
