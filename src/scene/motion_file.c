#include "motion_file.h"

#include "base/memory.h"
#include "base/text_file.h"
#include "nearest.h"

#include <stdio.h>
#include <string.h>

enum { MOST_ROWS = 1 << 20, MOST_COLUMNS = 64, NAME = 512, LARGEST_FILE = 256 << 20 };

/* What the columns are called, in the order of a row's numbers; the last may be missing. */
enum { TIME, X, Y, Z, ANGLE, KNOWN };
static const char *const column_names[KNOWN] = {"time", "x", "y", "z", "angle"};

bool hc_motion_file_pending(const hc_wall *wall) {
  return wall->motion.type == HC_WALL_TABLE && wall->motion.file[0] != '\0';
}

typedef struct reading {
  char name[NAME]; /* of wall and file, in messages */
  hc_lines lines;
  char between;      /* cells: a comma or a semicolon, as the first line has it */
  int column[KNOWN]; /* where each stands; -1: nowhere */
  int columns;
  hc_motion_point *points;
  size_t count, room;
} reading;

/* Without the blanks and the quotes around it. */
static char *bare(char *cell) {
  static const char blanks[] = " \t";
  cell += strspn(cell, blanks);
  size_t length = strlen(cell);
  while (length > 0 && strchr(blanks, cell[length - 1])) cell[--length] = '\0';
  if (length < 2 || *cell != '"' || cell[length - 1] != '"') return cell;
  cell[length - 1] = '\0';
  return cell + 1;
}

/* Cuts a line into its cells; returns how many there are. */
static int cut(const reading *r, char *line, char *cells[MOST_COLUMNS]) {
  int count = 0;
  for (char *at = line; at && count < MOST_COLUMNS;) {
    char *between = strchr(at, r->between);
    if (between) *between = '\0';
    cells[count++] = bare(at);
    at = between ? between + 1 : NULL;
  }
  return count;
}

static hc_status take_name(reading *r, const char *name, int column, hc_error *error) {
  for (int k = 0; k < KNOWN; k++) {
    if (strcmp(name, column_names[k]) != 0) continue;
    if (r->column[k] >= 0)
      return hc_error_set(error, HC_BAD_INPUT, "%s:%d: the column %s must be there once, not twice", r->name,
                          r->lines.number, name);
    r->column[k] = column;
    return HC_OK;
  }
  const char *const nearest = hc_nearest_name(column_names, KNOWN, name);
  return hc_error_set(
      error, HC_BAD_INPUT,
      "%s:%d: unknown column '%.80s'%s%s%s; the first line must name the columns time, x, y, z and "
      "perhaps angle, with commas or semicolons between them",
      r->name, r->lines.number, name, nearest ? "; did you mean '" : "", nearest ? nearest : "",
      nearest ? "'?" : "");
}

static hc_status take_head(reading *r, char *cells[], int count, hc_error *error) {
  for (int k = 0; k < KNOWN; k++) r->column[k] = -1;
  for (int c = 0; c < count; c++)
    if (take_name(r, cells[c], c, error) != HC_OK) return error->status;
  for (int k = 0; k < KNOWN; k++)
    if (r->column[k] < 0 && k != ANGLE)
      return hc_error_set(error, HC_BAD_INPUT,
                          "%s:%d: the first line must name the columns time, x, y, z and perhaps angle; %s "
                          "is missing",
                          r->name, r->lines.number, column_names[k]);
  r->columns = count;
  return HC_OK;
}

static hc_status take_row(reading *r, char *cells[], int count, hc_error *error) {
  if (count != r->columns)
    return hc_error_set(error, HC_BAD_INPUT, "%s:%d: a row must have %d cells as the first line, not %d",
                        r->name, r->lines.number, r->columns, count);
  double numbers[KNOWN] = {0};
  for (int k = 0; k < KNOWN; k++) {
    if (r->column[k] < 0) continue;
    const char *cell = cells[r->column[k]];
    if (!hc_lines_number(&r->lines, cell, &numbers[k]))
      return hc_error_set(error, HC_BAD_INPUT, "%s:%d: %s must be a number, not '%.80s'", r->name,
                          r->lines.number, column_names[k], cell);
  }
  if (r->count > 0 && !(numbers[TIME] > r->points[r->count - 1].time))
    return hc_error_set(error, HC_BAD_INPUT, "%s:%d: times must ascend, not %.9g after %.9g", r->name,
                        r->lines.number, numbers[TIME], r->points[r->count - 1].time);
  if (r->count == MOST_ROWS)
    return hc_error_set(error, HC_BAD_INPUT, "%s:%d: a table must have at most %d rows", r->name,
                        r->lines.number, MOST_ROWS);
  hc_reserve((void **)&r->points, &r->room, 2 * r->count + 64, r->count, sizeof *r->points);
  r->points[r->count++] = (hc_motion_point){
      .time = numbers[TIME], .shift = {numbers[X], numbers[Y], numbers[Z]}, .angle = numbers[ANGLE]};
  return HC_OK;
}

static hc_status read_rows(reading *r, hc_error *error) {
  bool head = true;
  hc_status status = HC_OK;
  for (char *line; status == HC_OK && (line = hc_lines_next(&r->lines));) {
    char *cells[MOST_COLUMNS];
    if (!*line || *line == '#') continue;
    if (head) r->between = strchr(line, ';') ? ';' : ',';
    const int count = cut(r, line, cells);
    status = head ? take_head(r, cells, count, error) : take_row(r, cells, count, error);
    head = false;
  }
  if (status == HC_OK && r->count == 0)
    return hc_error_set(error, HC_BAD_INPUT, "%s: must have a row of numbers, has none", r->name);
  return status;
}

hc_status hc_motion_file_read(hc_wall *wall, int number, const char *scene_path, hc_error *error) {
  const char *file = wall->motion.file, *slash = strrchr(scene_path, '/');
  const int folder = *file == '/' || !slash ? 0 : (int)(slash + 1 - scene_path);
  const size_t size = (size_t)folder + sizeof wall->motion.file;
  char *path = hc_alloc(size, 1), *text;
  size_t length;
  snprintf(path, size, "%.*s%s", folder, scene_path, file);
  reading r = {.count = 0};
  snprintf(r.name, sizeof r.name, "boundary.walls[%d].motion.file: %.400s", number, path);
  hc_error problem = {.status = HC_OK};
  if (hc_file_load(path, LARGEST_FILE, "a table of motion", &text, &length, &problem) == HC_OK) {
    if (hc_lines_start(&r.lines, path, text, length, &problem) == HC_OK) read_rows(&r, error);
    hc_lines_free(&r.lines);
    hc_free(text);
  }
  if (problem.status != HC_OK)
    hc_error_set(error, HC_BAD_INPUT, "boundary.walls[%d].motion.file: %.4000s", number, problem.text);
  hc_free(path);
  if (error->status != HC_OK) {
    hc_free(r.points);
    return error->status;
  }
  hc_free(wall->motion.points);
  wall->motion.points = r.points;
  wall->motion.point_count = (int)r.count;
  wall->motion.file[0] = '\0';
  return HC_OK;
}
