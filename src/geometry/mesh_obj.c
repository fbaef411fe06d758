#include "mesh_formats.h"

#include "base/memory.h"
#include "base/text_file.h"

#include <stdlib.h>
#include <string.h>

typedef struct reading {
  const char *path;
  hc_lines lines;
  hc_mesh_soup *soup;
  int32_t *corners;
  size_t room;
} reading;

/* A line that ends with a backslash goes on in the next. The whole is the caller's to free. */
static char *join(reading *r, char *line) {
  char *whole = NULL;
  size_t used = 0, room = 0;
  for (bool more = true; more && line;) {
    size_t length = strlen(line);
    more = length > 0 && line[length - 1] == '\\';
    if (more) line[length - 1] = ' ';
    hc_reserve((void **)&whole, &room, used + length + 1, used, 1);
    memcpy(whole + used, line, length + 1);
    used += length;
    if (more) line = hc_lines_next(&r->lines);
  }
  return whole;
}

static hc_status take_vertex(reading *r, char *at, hc_error *error) {
  double x[3];
  if (hc_mesh_read_point(r->path, &r->lines, &at, x, error) != HC_OK) return error->status;
  return hc_mesh_soup_add_vertex(r->soup, x, error);
}

/* "7", "7/1", "7//3", "-1/-1/-1": the vertex is what stands first. */
static hc_status take_corner(const reading *r, const char *word, int32_t *corner, hc_error *error) {
  char *end;
  const long long index = strtoll(word, &end, 10);
  const long long count = (long long)r->soup->vertices, found = index < 0 ? count + index : index - 1;
  if (end == word || (*end && *end != '/'))
    return hc_error_set(error, HC_BAD_INPUT,
                        "%s:%d: a corner of a face must be a vertex's number, not '%.80s'", r->path,
                        r->lines.number, word);
  if (found < 0 || found >= count)
    return hc_error_set(error, HC_BAD_INPUT, "%s:%d: a face names vertex %lld, of %lld before it", r->path,
                        r->lines.number, index, count);
  *corner = (int32_t)found;
  return HC_OK;
}

static hc_status take_face(reading *r, char *at, hc_error *error) {
  size_t count = 0;
  for (const char *word = hc_lines_word(&at); word; word = hc_lines_word(&at)) {
    hc_reserve((void **)&r->corners, &r->room, 2 * count + 4, count, sizeof *r->corners);
    if (take_corner(r, word, &r->corners[count++], error) != HC_OK) return error->status;
  }
  if (count < 3)
    return hc_error_set(error, HC_BAD_INPUT, "%s:%d: a face must have three corners at least, not %zu",
                        r->path, r->lines.number, count);
  return hc_mesh_soup_add_polygon(r->soup, r->corners, (int)count, error);
}

hc_status hc_mesh_read_obj(const char *path, const char *bytes, size_t length, hc_mesh_soup *soup,
                           hc_error *error) {
  reading r = {.path = path, .soup = soup};
  hc_status status = hc_lines_start(&r.lines, path, bytes, length, error);
  for (char *line; status == HC_OK && (line = hc_lines_next(&r.lines));) {
    if (!*line || *line == '#') continue;
    char *const whole = join(&r, line), *at = whole;
    const char *const word = hc_lines_word(&at);
    if (word && strcmp(word, "v") == 0) status = take_vertex(&r, at, error);
    if (word && strcmp(word, "f") == 0) status = take_face(&r, at, error);
    hc_free(whole);
  }
  hc_lines_free(&r.lines);
  hc_free(r.corners);
  return status;
}
