#include "motion_file.h"

#include "base/memory.h"

#include <errno.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ROWS = 1 << 20, MOST_COLUMNS = 64, NAME = 512 };

/* What the columns are called, in the order of a row's numbers; the last may be missing. */
enum { TIME, X, Y, Z, ANGLE, KNOWN };
static const char *const column_names[KNOWN] = {"time", "x", "y", "z", "angle"};

typedef struct reading {
  FILE *file;
  char name[NAME]; /* of wall and file, in messages */
  int line;
  int column[KNOWN]; /* where each stands; -1: nowhere */
  int columns;
  locale_t plain;
  hc_motion_point *points;
  size_t count, room;
} reading;

bool hc_motion_file_pending(const hc_wall *wall) {
  return wall->motion.type == HC_WALL_TABLE && wall->motion.file[0] != '\0';
}

/* Without the blanks around it. */
static char *trim(char *text) {
  text += strspn(text, " \t\r\n");
  size_t length = strlen(text);
  while (length > 0 && strchr(" \t\r\n", text[length - 1])) text[--length] = '\0';
  return text;
}

/* Cuts a line at its commas; returns how many cells there are. */
static int cut(char *line, char *cells[MOST_COLUMNS]) {
  int count = 0;
  for (char *at = line; at && count < MOST_COLUMNS;) {
    char *comma = strchr(at, ',');
    if (comma) *comma = '\0';
    cells[count++] = trim(at);
    at = comma ? comma + 1 : NULL;
  }
  return count;
}

static hc_status take_head(reading *r, char *cells[], int count, hc_error *error) {
  for (int k = 0; k < KNOWN; k++) {
    r->column[k] = -1;
    for (int c = 0; c < count; c++)
      if (strcmp(cells[c], column_names[k]) == 0) r->column[k] = c;
    if (r->column[k] < 0 && k != ANGLE)
      return hc_error_set(error, HC_BAD_INPUT,
                          "%s:%d: the first line must name the columns time, x, y, z and perhaps angle; %s "
                          "is missing",
                          r->name, r->line, column_names[k]);
  }
  r->columns = count;
  return HC_OK;
}

static hc_status take_row(reading *r, char *cells[], int count, hc_error *error) {
  if (count != r->columns)
    return hc_error_set(error, HC_BAD_INPUT, "%s:%d: a row must have %d cells as the first line, not %d",
                        r->name, r->line, r->columns, count);
  double numbers[KNOWN] = {0};
  for (int k = 0; k < KNOWN; k++) {
    if (r->column[k] < 0) continue;
    const char *cell = cells[r->column[k]];
    char *end;
    numbers[k] = strtod_l(cell, &end, r->plain);
    if (end == cell || *end || !isfinite(numbers[k]))
      return hc_error_set(error, HC_BAD_INPUT, "%s:%d: %s must be a number, not '%.80s'", r->name, r->line,
                          column_names[k], cell);
  }
  if (r->count > 0 && !(numbers[TIME] > r->points[r->count - 1].time))
    return hc_error_set(error, HC_BAD_INPUT, "%s:%d: times must ascend, not %.9g after %.9g", r->name,
                        r->line, numbers[TIME], r->points[r->count - 1].time);
  if (r->count == MOST_ROWS)
    return hc_error_set(error, HC_BAD_INPUT, "%s:%d: a table must have at most %d rows", r->name, r->line,
                        MOST_ROWS);
  hc_reserve((void **)&r->points, &r->room, 2 * r->count + 64, r->count, sizeof *r->points);
  r->points[r->count++] = (hc_motion_point){
      .time = numbers[TIME], .shift = {numbers[X], numbers[Y], numbers[Z]}, .angle = numbers[ANGLE]};
  return HC_OK;
}

static hc_status read_lines(reading *r, hc_error *error) {
  char *line = NULL;
  size_t room = 0;
  bool head = true;
  hc_status status = HC_OK;
  while (status == HC_OK && getline(&line, &room, r->file) >= 0) {
    r->line++;
    char *cells[MOST_COLUMNS], *text = trim(line);
    if (!*text || *text == '#') continue;
    const int count = cut(text, cells);
    status = head ? take_head(r, cells, count, error) : take_row(r, cells, count, error);
    head = false;
  }
  free(line);
  if (status == HC_OK && ferror(r->file))
    return hc_error_set(error, HC_BAD_INPUT, "%s: cannot be read: %s", r->name, strerror(errno));
  if (status == HC_OK && r->count == 0)
    return hc_error_set(error, HC_BAD_INPUT, "%s: must have a row of numbers, has none", r->name);
  return status;
}

static hc_status read_table(hc_wall *wall, int number, const char *scene_path, hc_error *error) {
  const char *file = wall->motion.file, *slash = strrchr(scene_path, '/');
  const int folder = *file == '/' || !slash ? 0 : (int)(slash + 1 - scene_path);
  const size_t size = (size_t)folder + sizeof wall->motion.file;
  char *path = hc_alloc(size, 1);
  snprintf(path, size, "%.*s%s", folder, scene_path, file);
  reading r = {.file = fopen(path, "r"), .plain = newlocale(LC_ALL_MASK, "C", (locale_t)0)};
  snprintf(r.name, sizeof r.name, "boundary.walls[%d].motion.file: %.400s", number, path);
  hc_status status = HC_OK;
  if (r.file)
    status = read_lines(&r, error);
  else
    status = hc_error_set(error, HC_BAD_INPUT, "%s: cannot be opened: %s", r.name, strerror(errno));
  if (r.file) fclose(r.file);
  freelocale(r.plain);
  hc_free(path);
  if (status != HC_OK) {
    hc_free(r.points);
    return status;
  }
  hc_free(wall->motion.points);
  wall->motion.points = r.points;
  wall->motion.point_count = (int)r.count;
  wall->motion.file[0] = '\0';
  return HC_OK;
}

hc_status hc_motion_file_read_all(hc_scene *scene, const char *scene_path, hc_error *error) {
  for (int k = 0; k < scene->boundary.wall_count; k++) {
    hc_wall *wall = &scene->boundary.walls[k];
    if (hc_motion_file_pending(wall) && read_table(wall, k, scene_path, error) != HC_OK) return error->status;
  }
  return HC_OK;
}
